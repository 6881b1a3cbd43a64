"""The exact elementary functions as functions in LLVM's language, `double "rattle.sin"(double)`, for kernels.

Engines of pages call them all, so they have the same bits on every machine.  Machine code of a desk and FMUs call those
that are as quick as the C library's, `QUICK`, so they have the bits of pages until another one is called, like a power.
Most have the bits of `rattle.trace.elementary`, which lanes and C code have too; where most of the operations
of a function serve one of two cases only, it branches.  Exponential and logarithm read tables, which straight-line code
cannot, and are twice as fast for it.

Source: those of `rattle.trace.elementary`; tables after Tang, Table-driven implementation of the exponential function
in IEEE floating-point arithmetic (1989), and of the logarithm (1990); expm1 and log1p after W. Kahan, see Higham,
Accuracy and Stability of Numerical Algorithms (2002), section 1.14.1.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable, Iterator, Sequence
from decimal import Decimal, localcontext
from typing import Any

from rattle.jit.linking import intrinsics
from rattle.jit.translation.values import number
from rattle.trace import elementary
from rattle.trace.graph import FUNCTIONS as OPERANDS
from rattle.trace.graph import ROUND, Graph
from rattle.trace.llvm import instructions

BRANCHING = ("sin", "cos", "hypot", "exp", "log", "pow", "copysign")  # written below, but for the last
WHOLE: dict[str, Callable[..., Any]] = {  # computed without a branch
    **{name: one for name, one in elementary.FUNCTIONS.items() if name not in BRANCHING},
    "part.exp": elementary.exponential,
    "part.log": elementary.logarithm,
    "part.pow": elementary.power,
    "part.hypot": elementary.hypotenuse,
    "part.sin": elementary.sine_of_rest,
    "part.cos": elementary.cosine_of_rest,
}
NAMES = (*BRANCHING[:-1], "expm1", "log1p", *(name for name in WHOLE if not name.startswith("part.")))
# that a function takes, if not one
NUMBERS = {**OPERANDS, "part.hypot": 2, "part.pow": 2, "part.sin": 2, "part.cos": 2}
# sine and cosine: of what is left of the angle beside quarter turns, one of both is needed
TURNED = """define internal double @"rattle.{name}"(double %x) #1 {{
  %length = call double @llvm.fabs.f64(double %x)
  %near = fcmp olt double %length, {eighth}
  br i1 %near, label %small, label %large
small:
  %y = fadd double %x, 0.0
  %found = call double @"rattle.part.{name}"(double %y, double 0.0)
  ret double %found
large:
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
BOTH = """
define internal void @"rattle.sincos"(double %x, ptr %sine, ptr %cosine) nounwind {{
  %length = call double @llvm.fabs.f64(double %x)
  %near = fcmp olt double %length, {eighth}
  br i1 %near, label %small, label %large
small:
  %y = fadd double %x, 0.0
  %sine_of_small = call double @"rattle.part.sin"(double %y, double 0.0)
  %cosine_of_small = call double @"rattle.part.cos"(double %y, double 0.0)
  store double %sine_of_small, ptr %sine
  store double %cosine_of_small, ptr %cosine
  ret void
large:
{reduced}
  %first = fcmp oeq double {quarter}, 0x3FF0000000000000
  %third = fcmp oeq double {quarter}, 0x4008000000000000
  %odd = or i1 %first, %third
  %a = call double @"rattle.part.sin"(double {r}, double {s})
  %b = call double @"rattle.part.cos"(double {r}, double {s})
  %size_sin = select i1 %odd, double %b, double %a
  %size_cos = select i1 %odd, double %a, double %b
  {negative_sin}
  {negative_cos}
  %less_sin = fneg double %size_sin
  %less_cos = fneg double %size_cos
  %signed_sin = select i1 %down_sin, double %less_sin, double %size_sin
  %signed_cos = select i1 %down_cos, double %less_cos, double %size_cos
  store double %signed_sin, ptr %sine
  store double %signed_cos, ptr %cosine
  ret void
}}
"""
FAR = """
declare {kind} @"{name}"({types})
define internal {kind} @"rattle.{name}"({given}) {{
  %length = call double @llvm.fabs.f64(double %x)
  %usual = fcmp olt double %length, 1.0e+06
  br i1 %usual, label %near, label %far
near:
  {to}call {kind} @"rattle.near.{name}"({given})
  ret {result}
far:
  {to_far}call {kind} @"{name}"({given})
  ret {result_far}
}}
"""
ANGLE, PLACES = "double %x", ", ptr %sine, ptr %cosine"
WORDS = {
    "kind": "double", "types": "double", "given": ANGLE, "to": "%a = ", "result": "double %a", "to_far": "%b = ",
    "result_far": "double %b",
}  # fmt: skip
WITHOUT = {
    "kind": "void", "types": "double, ptr, ptr", "given": ANGLE + PLACES, "to": "", "result": "void", "to_far": "",
    "result_far": "void",
}  # fmt: skip
EIGHTH = "7.85e-01"  # of a turn [rad]: nothing is taken away from a smaller angle
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
QUICK = ("sin", "cos", "hypot", "exp", "log")
PARTS = 128  # of a factor of 2, in the tables
SHIFT = 45  # of the bits of a number, to the part that it is in
LEAST = 0.6875  # of the mantissas whose logarithm is read
FEW = 512  # times 1/c is whole, so that its products with half a mantissa are exact
# e^x = 2^(k / PARTS) e^r: the table has the first factor without whole powers of 2, and what is left of it
EXPONENTIAL = """define internal double @"rattle.exp"(double %x) #1 {{
  %size = call double @llvm.fabs.f64(double %x)
  %usual = fcmp ole double %size, 7.0e+02
  br i1 %usual, label %fast, label %slow
fast:
  %z = fmul double %x, {per_part}
  %up = fadd double %z, {round}
  %n = fsub double %up, {round}
  %k = fptosi double %n to i64
  %a = fmul double %n, {high}
  %b = fmul double %n, {low}
  %c = fsub double %x, %a
  %r = fsub double %c, %b
  %i = and i64 %k, {mask}
  %at = getelementptr [{parts} x [2 x i64]], ptr @"rattle.powers", i64 0, i64 %i
  %left = load double, ptr %at
  %next = getelementptr i64, ptr %at, i64 1
  %power = load i64, ptr %next
  %shifted = shl i64 %k, {shift}
  %bits = add i64 %power, %shifted
  %scale = bitcast i64 %bits to double
  %rr = fmul double %r, %r
  %p5 = fmul double %r, {c5}
  %p4 = fadd double %p5, {c4}
  %p3 = fmul double %r, {c3}
  %p2 = fadd double %p3, 5.0e-01
  %q4 = fmul double %rr, %p4
  %q2 = fadd double %p2, %q4
  %q = fmul double %rr, %q2
  %s = fadd double %left, %r
  %t = fadd double %s, %q
  %u = fmul double %scale, %t
  %y = fadd double %scale, %u
  ret double %y
slow:
  %all = call double @"rattle.part.exp"(double %x)
  ret double %all
}}"""
# ln x = n ln 2 - ln(1/c) + ln(1 + r) with 1 + r = m (1/c), x = m 2^n: the table has 1/c, of few bits, and -ln(1/c)
LOGARITHM = """define internal double @"rattle.log"(double %x) #1 {{
  %enough = fcmp oge double %x, 0x0010000000000000
  %bounded = fcmp olt double %x, 0x7FF0000000000000
  %usual = and i1 %enough, %bounded
  br i1 %usual, label %fast, label %slow
fast:
  %bits = bitcast double %x to i64
  %off = sub i64 %bits, {least}
  %j = lshr i64 %off, {shift}
  %i = and i64 %j, {mask}
  %k = ashr i64 %off, 52
  %whole = shl i64 %k, 52
  %rest = sub i64 %bits, %whole
  %m = bitcast i64 %rest to double
  %upper = and i64 %rest, -134217728
  %m1 = bitcast i64 %upper to double
  %m2 = fsub double %m, %m1
  %at = getelementptr [{parts} x [2 x double]], ptr @"rattle.logarithms", i64 0, i64 %i
  %inverse = load double, ptr %at
  %next = getelementptr double, ptr %at, i64 1
  %log = load double, ptr %next
  %r1 = fmul double %m1, %inverse
  %r2 = fsub double %r1, 1.0
  %r3 = fmul double %m2, %inverse
  %r = fadd double %r2, %r3
  %n = sitofp i64 %k to double
  %n1 = fmul double %n, {high}
  %n2 = fmul double %n, {low}
  %w = fadd double %n1, %log
  %h = fadd double %w, %r
  %d = fsub double %w, %h
  %e = fadd double %d, %r
  %l = fadd double %e, %n2
  %rr = fmul double %r, %r
  %p8 = fmul double %r, -1.25e-01
  %p7 = fadd double %p8, {c7}
  %p6 = fmul double %r, {c6}
  %p5 = fadd double %p6, 2.0e-01
  %p4 = fmul double %r, -2.5e-01
  %p3 = fadd double %p4, {c3}
  %q7 = fmul double %rr, %p7
  %q5 = fadd double %p5, %q7
  %q4 = fmul double %rr, %q5
  %q3 = fadd double %p3, %q4
  %q2 = fmul double %r, %q3
  %q1 = fsub double %q2, 5.0e-01
  %q = fmul double %rr, %q1
  %y1 = fadd double %l, %q
  %y = fadd double %y1, %h
  ret double %y
slow:
  %all = call double @"rattle.part.log"(double %x)
  ret double %all
}}"""
# squares are frequent, and right to the last bit
POWER = """define internal double @"rattle.pow"(double %x, double %y) #1 {
  %square = fcmp oeq double %y, 2.0
  br i1 %square, label %fast, label %slow
fast:
  %xx = fmul double %x, %x
  ret double %xx
slow:
  %all = call double @"rattle.part.pow"(double %x, double %y)
  ret double %all
}
define internal double @"rattle.exp2"(double %x) #1 {
  %y = call double @"rattle.part.pow"(double 2.0, double %x)
  ret double %y
}"""
BESIDE_ONE = """define internal double @"rattle.expm1"(double %x) #1 {
  %u = call double @"rattle.exp"(double %x)
  %v = fsub double %u, 1.0
  %l = call double @"rattle.log"(double %u)
  %q = fdiv double %x, %l
  %near = fmul double %v, %q
  %some = fcmp olt double %u, 0x7FF0000000000000
  %a = select i1 %some, double %near, double %u
  %low = fcmp oeq double %v, -1.0
  %b = select i1 %low, double -1.0, double %a
  %none = fcmp oeq double %u, 1.0
  %y = select i1 %none, double %x, double %b
  ret double %y
}
define internal double @"rattle.log1p"(double %x) #1 {
  %u = fadd double %x, 1.0
  %l = call double @"rattle.log"(double %u)
  %v = fsub double %u, 1.0
  %q = fdiv double %x, %v
  %near = fmul double %l, %q
  %some = fcmp olt double %u, 0x7FF0000000000000
  %a = select i1 %some, double %near, double %l
  %none = fcmp oeq double %u, 1.0
  %y = select i1 %none, double %x, double %a
  ret double %y
}"""
ATTRIBUTES = "attributes #1 = { nounwind readnone willreturn noinline }"


def text_of_desk() -> str:
    """The same for programs that have a C library, which knows sine and cosine of angles of any size."""
    text = library_text().replace(" noinline }", " }") + _turned_both()
    for name in ("sin", "cos", "sincos"):
        text = text.replace(f'@"rattle.{name}"(', f'@"rattle.near.{name}"(')
    words = {"sin": WORDS, "cos": WORDS, "sincos": WITHOUT}
    return text + "".join(FAR.format(name=name, **one) for name, one in words.items())


def text_of_machine(names: Sequence[str] = (*QUICK, "sincos")) -> str:
    """The same with some functions by names that others see."""
    text = text_of_desk()
    for name in names:
        text = text.replace(f'define internal void @"rattle.{name}"(', f'define void @"rattle.{name}"(')
        text = text.replace(f'define internal double @"rattle.{name}"(', f'define double @"rattle.{name}"(')
    return "\n".join([text, *intrinsics(text)])


def library_text() -> str:
    """All functions that kernels may call besides those of the processor."""
    whole = [_function(name, one, NUMBERS.get(name, 1)) for name, one in WHOLE.items()]
    turned = [_turned("sin", "cos"), _turned("cos", "sin")]
    return "\n".join([*whole, *turned, HYPOT, *_by_tables(), POWER, BESIDE_ONE, REMAINDER, ATTRIBUTES])


def _by_tables() -> Iterator[str]:
    """Exponential and logarithm, and their tables; ln 2 is in two parts, of which whole multiples are exact."""
    high, low = elementary.LN2_HIGH, elementary.LN2_LOW
    each = range(PARTS)
    with localcontext(prec=40):
        powers = [Decimal(2) ** (Decimal(i) / PARTS) for i in each]
        left = [_bits(float(one / Decimal(float(one)) - 1)) for one in powers]
        # less what whole parts add to the bits when k is shifted
        bits = [_bits(float(one)) - (i << SHIFT) for i, one in enumerate(powers)]
        inverse = [_inverse_of_part(i) for i in each]
        logarithms = [-float(Decimal(one).ln()) for one in inverse]
    yield _table("powers", "i64", zip(map(str, left), map(str, bits), strict=True))
    yield _table("logarithms", "double", zip(map(number, inverse), map(number, logarithms), strict=True))
    known = {"parts": PARTS, "mask": PARTS - 1, "shift": SHIFT}
    yield EXPONENTIAL.format(
        per_part=number(PARTS * elementary.ONE_OVER_LN2), round=number(ROUND), high=number(high / PARTS),
        low=number(low / PARTS), c3=number(1.0 / 6.0), c4=number(1.0 / 24.0), c5=number(1.0 / 120.0), **known,
    )  # fmt: skip
    yield LOGARITHM.format(
        least=_bits(LEAST), high=number(high), low=number(low), c3=number(1.0 / 3.0), c6=number(-1.0 / 6.0),
        c7=number(1.0 / 7.0), **known,
    )  # fmt: skip


def _bits(x: float) -> int:
    return int.from_bytes(struct.pack("<d", x), "little", signed=True)


def _inverse_of_part(i: int) -> float:
    """1/c of the part i of the numbers from LEAST to 2 LEAST; 1 on both sides of 1, where the logarithm vanishes."""
    first, last = (struct.unpack("<d", struct.pack("<q", _bits(LEAST) + (k << SHIFT)))[0] for k in (i, i + 1))
    return 1.0 if 1.0 in (first, last) else round(FEW / (0.5 * (first + last))) / FEW


def _table(name: str, kind: str, rows: Iterable[tuple[str, str]]) -> str:
    """A table of pairs."""
    every = ", ".join(f"[2 x {kind}] [{kind} {a}, {kind} {b}]" for a, b in rows)
    return f'@"rattle.{name}" = internal constant [{PARTS} x [2 x {kind}]] [{every}]'


def _function(name: str, one: Callable[..., Any], count: int) -> str:
    """One function of some numbers."""
    given = [f"%a{n}" for n in range(count)]
    lines, (result,) = _recorded(one, given)
    head = f'define internal double @"rattle.{name}"({", ".join(f"double {one}" for one in given)}) #1 {{'
    return "\n".join([head, *lines, f"ret double {result}", "}"])


def _recorded(one: Callable[..., Any], given: Sequence[str]) -> tuple[list[str], list[str]]:
    """Instructions of a function of numbers with these names, and the names of its results."""
    graph = Graph()
    results = one(*[graph.input() for _ in given])
    return instructions(graph, results if isinstance(results, tuple) else (results,), given)


def _turned_both() -> str:
    """Sine and cosine of one angle, which machine code asks for together."""
    lines, (quarter, r, s) = _recorded(elementary.reduced, ["%x"])
    return BOTH.format(reduced="\n".join(lines), quarter=quarter, r=r, s=s, eighth=EIGHTH, **{
        f"negative_{name}": DOWN[name].format(quarter=quarter).replace("%down", f"%down_{name}") for name in DOWN
    })  # fmt: skip


def _turned(name: str, across: str) -> str:
    """Sine or cosine, of which quarter turns are taken away."""
    lines, (quarter, r, s) = _recorded(elementary.reduced, ["%x"])
    negative = DOWN[name].format(quarter=quarter)
    words = {"name": name, "across": across, "reduced": "\n".join(lines), "negative": negative}
    return TURNED.format(**words, quarter=quarter, r=r, s=s, eighth=EIGHTH)
