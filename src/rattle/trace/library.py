"""The exact elementary functions as functions in LLVM's language, `double "rattle.sin"(double)`, for linked kernels.

Source: those of `rattle.trace.elementary`; expm1 and log1p after W. Kahan, see Higham, Accuracy and Stability of
Numerical Algorithms (2002), section 1.14.1.
"""

from __future__ import annotations

from typing import Any

from rattle.trace import elementary
from rattle.trace.elementary import FUNCTIONS
from rattle.trace.graph import FUNCTIONS as OPERANDS
from rattle.trace.graph import Graph, select
from rattle.trace.llvm import _Body, _written


def exponential_less_one(x: Any) -> Any:
    """e^x - 1."""
    u = elementary.exponential(x)
    near = (u - 1.0) * (x / elementary.logarithm(u))
    return select(u == 1.0, x, select(u - 1.0 == -1.0, -1.0, select(u < elementary.INF, near, u)))


def logarithm_of_one_and(x: Any) -> Any:
    """ln(1 + x)."""
    u = 1.0 + x
    near = elementary.logarithm(u) * (x / (u - 1.0))
    return select(u == 1.0, x, select(u < elementary.INF, near, elementary.logarithm(u)))


OWN = {**{name: FUNCTIONS[name] for name in FUNCTIONS if name != "copysign"}, "expm1": exponential_less_one,
       "log1p": logarithm_of_one_and}  # fmt: skip
# x minus the largest multiple of y that is not beyond it, exactly: y is doubled until it is larger, and taken away
REMAINDER = """define internal double @"rattle.fmod"(double %x, double %y) #1 {
entry:
  %ax = call double @llvm.fabs.f64(double %x)
  %ay = call double @llvm.fabs.f64(double %y)
  %finite = fcmp olt double %ax, 0x7FF0000000000000
  %some = fcmp ogt double %ay, 0.0
  %fine = and i1 %finite, %some
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
  ret double 0x7FF8000000000000
}"""
ATTRIBUTES = "attributes #1 = { nounwind memory(none) willreturn noinline }"


def library_text() -> str:
    """All functions that kernels may call besides those of the processor."""
    bodies = [_function(name) for name in OWN]
    return "\n".join([*bodies, REMAINDER, ATTRIBUTES])


def _function(name: str) -> str:
    """One function of one or two numbers."""
    graph = Graph()
    given = [graph.input() for _ in range(OPERANDS.get(name, 1))]
    result = graph.place(OWN[name](*given))
    body = _Body(graph, _written(1))
    for n, place in enumerate(graph.inputs):
        body._numbers[place] = f"%a{n}"
    for place in graph.live([elementary_symbol(graph, result)]):
        if graph.ops[place] != "input":
            body.add(place)
    parameters = ", ".join(f"double %a{n}" for n in range(len(given)))
    head = f'define internal double @"rattle.{name}"({parameters}) #1 {{'
    return "\n".join([head, *body.lines, f"ret double {body.number(result)}", "}"])


def elementary_symbol(graph: Graph, place: int) -> Any:
    """A place of a graph as a symbol of it."""
    return elementary.Symbol(graph, place)
