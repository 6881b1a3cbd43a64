"""The exact elementary functions as functions in LLVM's language, `double "rattle.sin"(double)`, for linked kernels.

They have the bits of `rattle.trace.elementary`, which lanes and C code have too, so a linked engine has the same bits
on every machine.  Where most of the operations of a function serve one of two cases only, it branches.

Source: those of `rattle.trace.elementary`; expm1 and log1p after W. Kahan, see Higham, Accuracy and Stability of
Numerical Algorithms (2002), section 1.14.1.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from rattle.language.recorded import Operand
from rattle.trace import elementary
from rattle.trace.graph import FUNCTIONS as OPERANDS
from rattle.trace.graph import Graph, select
from rattle.trace.llvm import instructions


def exponential_less_one(x: Operand) -> Operand:
    """e^x - 1."""
    u = elementary.exponential(x)
    near = (u - 1.0) * (x / elementary.logarithm(u))
    return select(u == 1.0, x, select(u - 1.0 == -1.0, -1.0, select(u < elementary.INF, near, u)))


def logarithm_of_one_and(x: Operand) -> Operand:
    """ln(1 + x)."""
    u = 1.0 + x
    near = elementary.logarithm(u) * (x / (u - 1.0))
    return select(u == 1.0, x, select(u < elementary.INF, near, elementary.logarithm(u)))


WHOLE: dict[str, Callable[..., Operand]] = {  # computed without a branch
    **{
        name: function
        for name, function in elementary.FUNCTIONS.items()
        if name not in ("sin", "cos", "hypot", "copysign")
    },
    "expm1": exponential_less_one,
    "log1p": logarithm_of_one_and,
    "part.hypot": elementary.hypotenuse,
    "part.sin": elementary.sine_of_rest,
    "part.cos": elementary.cosine_of_rest,
}
NAMES = ("sin", "cos", "hypot", *(name for name in WHOLE if not name.startswith("part.")))
NUMBERS = {**OPERANDS, "part.hypot": 2, "part.sin": 2, "part.cos": 2}  # that a function takes, if not one
# sine and cosine: of what is left of the angle beside quarter turns, one of both is needed
TURNED = """define internal double @"rattle.{name}"(double %x) #1 {{
{reduced}
  %first = fcmp oeq double {quarter}, 0x3FF0000000000000
  %third = fcmp oeq double {quarter}, 0x4008000000000000
  %odd = or i1 %first, %third
  br i1 %odd, label %other, label %same
same:
  %a = call double @"rattle.part.{name}"(double {r}, double {s})
  br label %end
other:
  %b = call double @"rattle.part.{across}"(double {r}, double {s})
  br label %end
end:
  %size = phi double [%a, %same], [%b, %other]
  {negative}
  %less = fneg double %size
  %signed = select i1 %down, double %less, double %size
  ret double %signed
}}"""
DOWN = {
    "sin": "%down = fcmp oge double {quarter}, 0x4000000000000000",
    "cos": "%second = fcmp oeq double {quarter}, 0x4000000000000000\n  %down = or i1 %first, %second",
}
# usual lengths: their squares are far from the ends of the range, and the scale makes no difference
HYPOT = """define internal double @"rattle.hypot"(double %x, double %y) #1 {
  %a = call double @llvm.fabs.f64(double %x)
  %b = call double @llvm.fabs.f64(double %y)
  %la = fcmp oge double %a, 0x26F0000000000000
  %lb = fcmp oge double %b, 0x26F0000000000000
  %ma = fcmp ole double %a, 0x58F0000000000000
  %mb = fcmp ole double %b, 0x58F0000000000000
  %l = and i1 %la, %lb
  %m = and i1 %ma, %mb
  %usual = and i1 %l, %m
  br i1 %usual, label %fast, label %slow
fast:
  %aa = fmul double %a, %a
  %bb = fmul double %b, %b
  %sum = fadd double %aa, %bb
  %root = call double @llvm.sqrt.f64(double %sum)
  ret double %root
slow:
  %all = call double @"rattle.part.hypot"(double %x, double %y)
  ret double %all
}"""
# x minus the largest multiple of y that is not beyond it, exactly: y is doubled until it is larger, and taken away
REMAINDER = """define internal double @"rattle.fmod"(double %x, double %y) #1 {
entry:
  %ax = call double @llvm.fabs.f64(double %x)
  %ay = call double @llvm.fabs.f64(double %y)
  %finite = fcmp olt double %ax, 0x7FF0000000000000
  %some = fcmp ogt double %ay, 0.0
  %bounded = fcmp olt double %ay, 0x7FF0000000000000
  %both = and i1 %some, %bounded
  %fine = and i1 %finite, %both
  br i1 %fine, label %up, label %none
up:
  %t = phi double [%ay, %entry], [%twice, %up]
  %twice = fadd double %t, %t
  %more = fcmp ole double %twice, %ax
  br i1 %more, label %up, label %down
down:
  %s = phi double [%t, %up], [%half, %down]
  %r = phi double [%ax, %up], [%left, %down]
  %fits = fcmp oge double %r, %s
  %less = fsub double %r, %s
  %left = select i1 %fits, double %less, double %r
  %half = fmul double %s, 0.5
  %on = fcmp oge double %half, %ay
  br i1 %on, label %down, label %end
end:
  %signed = call double @llvm.copysign.f64(double %left, double %x)
  ret double %signed
none:
  %far = fcmp oeq double %ay, 0x7FF0000000000000
  %whole = and i1 %finite, %far
  %rest = select i1 %whole, double %x, double 0x7FF8000000000000
  ret double %rest
}"""
ATTRIBUTES = "attributes #1 = { nounwind readnone willreturn noinline }"


def library_text() -> str:
    """All functions that kernels may call besides those of the processor."""
    whole = [_function(name, function, NUMBERS.get(name, 1)) for name, function in WHOLE.items()]
    turned = [_turned("sin", "cos"), _turned("cos", "sin")]
    return "\n".join([*whole, *turned, HYPOT, REMAINDER, ATTRIBUTES])


def _function(name: str, function: Callable[..., Operand], count: int) -> str:
    """One function of some numbers."""
    arguments = [f"%a{n}" for n in range(count)]
    lines, (result,) = _recorded(function, arguments)
    head = f'define internal double @"rattle.{name}"({", ".join(f"double {name}" for name in arguments)}) #1 {{'
    return "\n".join([head, *lines, f"ret double {result}", "}"])


def _recorded(
    function: Callable[..., Operand | tuple[Operand, ...]], arguments: Sequence[str]
) -> tuple[list[str], list[str]]:
    """Instructions of a function of numbers with these names, and the names of its results."""
    graph = Graph()
    results = function(*[graph.input() for _ in arguments])
    return instructions(graph, results if isinstance(results, tuple) else (results,), arguments)


def _turned(name: str, across: str) -> str:
    """Sine or cosine, of which quarter turns are taken away."""
    lines, (quarter, r, s) = _recorded(elementary.reduced, ["%x"])
    negative = DOWN[name].format(quarter=quarter)
    words = {"name": name, "across": across, "reduced": "\n".join(lines), "negative": negative}
    return TURNED.format(**words, quarter=quarter, r=r, s=s)
