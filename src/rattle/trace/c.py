"""Straight-line code in C99, without dependencies but the C library's sqrt, fabs and floor."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rattle.language.recorded import Operand
from rattle.trace.c_text import BEGIN, MAIN, NO_BEGIN
from rattle.trace.graph import ROUND, Graph
from rattle.trace.program import PIECES, ROWS, Begin, Input, Program
from rattle.trace.text import statements

FORMS = {
    "add": "{0} + {1}", "sub": "{0} - {1}", "mul": "{0} * {1}", "div": "{0} / {1}", "neg": "-{0}", "abs": "fabs({0})",
    "sqrt": "sqrt({0})", "floor": "floor({0})", "less": "{0} < {1}", "at_most": "{0} <= {1}", "equal": "{0} == {1}",
    "both": "{0} && {1}", "either": "{0} || {1}", "not": "!{0}", "select": "{0} ? {1} : {2}",
    "power_of_two": "power_of_two({0})", "exponent": "exponent_of({0})", "mantissa": "mantissa_of({0})",
}  # fmt: skip
INCLUDES = """#ifdef __FAST_MATH__
#error "compile without -ffast-math (-Ofast): it changes what the operations below are"
#endif
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* products and sums are rounded apart, on machines with fused operations too */
#if defined(__clang__) || !defined(__GNUC__)
#pragma STDC FP_CONTRACT OFF
#else
#pragma GCC optimize("fp-contract=off")
#endif
"""
BITS = {  # what works on the bits of a number, by the name under which code calls it
    "power_of_two": f"""/* 2^n for a whole n */
static double power_of_two(double n) {{
    uint64_t u;
    n += {ROUND + 1023.0!r};
    memcpy(&u, &n, 8);
    u <<= 52;
    memcpy(&n, &u, 8);
    return n;
}}
""",
    "exponent_of": """/* x = m 2^n with m from 1 to 2: n, for a positive normal number */
static double exponent_of(double x) {
    uint64_t u;
    memcpy(&u, &x, 8);
    return (double)((u >> 52) & 0x7FF) - 1023.0;
}
""",
    "mantissa_of": """/* x = m 2^n with m from 1 to 2: m, for a positive normal number */
static double mantissa_of(double x) {
    uint64_t u;
    memcpy(&u, &x, 8);
    u = (u & UINT64_C(0xFFFFFFFFFFFFF)) | UINT64_C(0x3FF0000000000000);
    memcpy(&x, &u, 8);
    return x;
}
""",
}


def helpers(functions: Sequence[str]) -> list[str]:
    """The functions of BITS that these call."""
    return [text for name, text in BITS.items() if any(f"{name}(" in one for one in functions)]


def number(value: float) -> str:
    """A number as C reads it, to the bit."""
    if value != value:
        return "NAN"
    if math.isinf(value):
        return "INFINITY" if value > 0.0 else "(-INFINITY)"
    text = repr(value)
    return f"({text})" if text.startswith("-") else text


def function(graph: Graph, outputs: Sequence[Operand], name: str) -> str:
    """`static void name(const double *in, double *out)`; the file needs INCLUDES and `helpers` before it."""
    body = statements(graph, outputs, FORMS, number, lambda x, flag: f"const {'int' if flag else 'double'} {x}")
    return "\n    ".join([f"static void {name}(const double *in, double *out) {{", *body]) + "\n}\n"


def program(header: Sequence[str], model: Program, t_end: float, step: float) -> str:
    """A whole file: the recorded functions, and a main that prints the motion as CSV.

    header: lines of the comment on top; t_end, step: what the program does when not told [s].
    """
    columns = "\n".join(f"     {name} [{unit or '-'}]" for name, unit in zip(model.names, model.units, strict=True))
    comment = "\n   ".join(header).replace("*/", "* /").replace("/*", "/ *")
    change = " [name=value ...]" if model.parameters else ""
    inputs = GIVEN + "\n".join(map(_described, model.parameters)) + "\n" if model.parameters else ""
    top = f"""/* {comment}

   cc -std=c99 -O2 model.c -lm && ./a.out [t_end [step]]{change}

   The functions take t [s], then the state y [SI]: positions x, y, angle of every body in turn, their rates, work done
   and energy dissipated; then the parameters [SI] and the energy at the start [J].  The last number that each returns
   is 0 where it holds for no reason: next to a singular position, or where points coincide.
   To call them from a program of your own: #define main model_main, then #include this file, then #undef main.
{inputs}   Result columns:
{columns}
*/
"""
    functions = [function(model.graph, outputs, name) for name, outputs in model.functions.items()]
    table = [
        _row(parameter.name, parameter.unit, parameter.value, parameter.low, parameter.high)
        for parameter in model.parameters
    ]
    main = MAIN.replace("@begin@", NO_BEGIN if model.begin is None else _begin(model.begin))
    for key, text in (
        ("ny", str(len(model.start))), ("no", str(len(model.names))), ("np", str(len(model.parameters))),
        ("names", _texts(model.names)), ("start", ", ".join(map(number, model.start))),
        ("parameters", ",\n".join(table or [_row("", "", 0.0, None, None)])), ("set", change),
        ("t_end", number(t_end)), ("step", number(step)), ("rows", str(ROWS)),
    ):  # fmt: skip
        main = main.replace(f"@{key}@", text)
    return "\n".join([top, INCLUDES, *helpers(functions), *functions, main])


GIVEN = "   Parameters and their values in the model, to be changed as name=value:\n"


def _described(parameter: Input) -> str:
    limits = [
        f", {word} {x:.10g}" for word, x in (("at least", parameter.low), ("at most", parameter.high)) if x is not None
    ]
    return f"     {parameter.name} [{parameter.unit or '-'}] {parameter.value:.10g}{''.join(limits)}"


def _row(name: str, unit: str, value: float, low: float | None, high: float | None) -> str:
    limits = number(-math.inf if low is None else low), number(math.inf if high is None else high)
    return f"    {{{_text(name)}, {_text(unit)}, {number(value)}, {limits[0]}, {limits[1]}}}"


def _begin(begin: Begin) -> str:
    text = BEGIN
    for key, value in (
        ("nq", str(len(begin.sizes))), ("ng", str(len(begin.gaps))), ("sizes", ", ".join(map(number, begin.sizes))),
        ("gaps", _texts([name for name, _, _ in begin.gaps])), ("units", _texts([unit for _, _, unit in begin.gaps])),
        ("rounds", str(begin.rounds)), ("small", number(begin.small)), ("closed", number(begin.closed)),
        ("far", number(begin.far)), ("missed", number(begin.missed)), ("pieces", str(PIECES)),
    ):  # fmt: skip
        text = text.replace(f"@{key}@", value)
    return text


def _texts(every: Sequence[str]) -> str:
    return ", ".join(map(_text, every))


def _text(text: str) -> str:
    """A text as C reads it; names of model files are ASCII letters, digits and _, units hold no quote."""
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'
