"""Straight-line code in JavaScript: functions and a whole ES module, for pages and for node, without dependencies.

JavaScript's numbers are IEEE doubles, its + - * /, sqrt, abs and floor are exact, and no engine may contract them, so
every operation has the bits of the reference.  The module takes its steps as the program of `c` does, operation by
operation, and stops with the same messages.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence

from rattle.language.recorded import Operand
from rattle.trace.graph import ROUND, Graph
from rattle.trace.javascript_text import BEGIN, GUIDE, HEAD, MAIN, NO_BEGIN
from rattle.trace.program import PIECES, ROWS, Begin, Input, Program
from rattle.trace.text import pieces
from rattle.value_types import Json

FORMS = {
    "add": "{0} + {1}", "sub": "{0} - {1}", "mul": "{0} * {1}", "div": "{0} / {1}", "neg": "-{0}",
    "abs": "Math.abs({0})", "sqrt": "Math.sqrt({0})", "floor": "Math.floor({0})", "less": "{0} < {1}",
    "at_most": "{0} <= {1}", "equal": "{0} === {1}", "both": "{0} && {1}", "either": "{0} || {1}", "not": "!{0}",
    "select": "{0} ? {1} : {2}", "power_of_two": "powerOfTwo({0})", "exponent": "exponentOf({0})",
    "mantissa": "mantissaOf({0})",
}  # fmt: skip
BITS = f"""// the bits of a number: two halves of 32 bits of the same memory, found in either order
const number = new Float64Array([1]);
const half = new Uint32Array(number.buffer);
const HIGH = half[1] === 0x3ff00000 ? 1 : 0, LOW = 1 - HIGH;
// 2^n for a whole n
function powerOfTwo(n) {{
  number[0] = n + {ROUND + 1023.0!r};
  half[HIGH] = (half[LOW] & 0xfff) << 20;
  half[LOW] = 0;
  return number[0];
}}
// x = m 2^n with m from 1 to 2: n, for a positive normal number
function exponentOf(x) {{
  number[0] = x;
  return ((half[HIGH] >>> 20) & 0x7ff) - 1023;
}}
// x = m 2^n with m from 1 to 2: m, for a positive normal number
function mantissaOf(x) {{
  number[0] = x;
  half[HIGH] = (half[HIGH] & 0xfffff) | 0x3ff00000;
  return number[0];
}}
"""
SIZE = 2000  # operations of one function: engines leave large ones to their slow tiers (V8 beyond 60 kB of byte code)


def number(value: float) -> str:
    """A number as JavaScript reads it, to the bit."""
    if value != value:
        return "NaN"
    if math.isinf(value):
        return "Infinity" if value > 0.0 else "(-Infinity)"
    text = repr(float(value))
    return f"({text})" if text.startswith("-") else text


def function(graph: Graph, outputs: Sequence[Operand], name: str) -> str:
    """`function name(inp, out)` over Float64Arrays; the file needs BITS before it."""
    bodies = pieces(graph, outputs, FORMS, number, lambda x, flag: f"const {x}", "inp", SIZE)
    if len(bodies) == 1:
        return _function(name, "inp, out", bodies[0])
    calls = [f"{name}{n}(inp, out, {name}Held);" for n in range(len(bodies))]
    parts = [_function(f"{name}{n}", "inp, out, held", body) for n, body in enumerate(bodies)]
    count = graph.count(outputs)
    return "".join([f"const {name}Held = new Float64Array({count});\n", *parts, _function(name, "inp, out", calls)])


def _function(name: str, arguments: str, lines: Sequence[str]) -> str:
    return "\n  ".join([f"function {name}({arguments}) {{", *lines]) + "\n}\n"


def module(header: Sequence[str], model: Program, t_end: float, step: float) -> str:
    """A whole ES module: `names`, `units`, `parameters`, `start`, `derivative`, `project`, `outputs`, `run`.

    header: lines of the comment on top; t_end, step: what `run` does when not told [s].
    """
    first = next(iter(model.parameters), None)
    change = f", {{ {as_text(first.name)}: {number(first.value)} }}" if first is not None else ""
    guide = GUIDE.replace("@change@", _comment(change)).replace("@name@", _comment(as_text(model.names[0])))
    comment = "\n * ".join(_comment(line) for line in header)
    main = MAIN
    for key, text in (("rows", str(ROWS)), ("t_end", number(t_end)), ("step", number(step))):
        main = main.replace(f"@{key}@", text)
    return "\n".join(
        [
            f"/** {comment}\n *{guide} */",
            *_tables(model),
            BITS,
            *(function(model.graph, outputs, f"{name}Of") for name, outputs in model.functions.items()),
            _head(model).lstrip("\n"),
            main.lstrip("\n"),
        ]
    )


def _tables(model: Program) -> list[str]:
    """What a module exports besides functions."""
    pairs = ", ".join(f"[{as_text(parameter.name)}, {number(parameter.value)}]" for parameter in model.parameters)
    table = "".join(f"  {_input(parameter)},\n" for parameter in model.parameters)
    return [
        f"/** Names of what is in a row: t, then the outputs; and their units. */\n"
        f"export const names = {as_text(['t', *model.names])};",
        f"export const units = {as_text(['s', *model.units])};",
        f"/** Values of the parameters in the model [SI], by name. */\n"
        f"export const parameters = Object.fromEntries([{pairs}]);",
        f"/** The same with their units, and limits where the model has some. */\n"
        f"export const sliders = [\n{table}];\n",
    ]


def _head(model: Program) -> str:
    """What a module does with the recorded functions, and the start for parameters."""
    head = HEAD.replace("@begin@", NO_BEGIN if model.begin is None else _begin(model.begin))
    for key, text in (
        ("ny", str(len(model.start))), ("inputs", str(len(model.graph.inputs))),
        ("start", ", ".join(map(number, model.start))),
    ):  # fmt: skip
        head = head.replace(f"@{key}@", text)
    return head


def _input(parameter: Input) -> str:
    low, high = ("null" if x is None else number(x) for x in (parameter.low, parameter.high))
    value, unit = number(parameter.value), as_text(parameter.unit)
    return f"{{ name: {as_text(parameter.name)}, value: {value}, unit: {unit}, min: {low}, max: {high} }}"


def _begin(begin: Begin) -> str:
    text = BEGIN
    for key, value in (
        ("sizes", ", ".join(map(number, begin.sizes))),
        ("gaps", as_text([[name, unit] for name, _, unit in begin.gaps])), ("rounds", str(begin.rounds)),
        ("small", number(begin.small)), ("closed", number(begin.closed)), ("far", number(begin.far)),
        ("missed", number(begin.missed)), ("pieces", str(PIECES)),
    ):  # fmt: skip
        text = text.replace(f"@{key}@", value)
    return text


def as_text(x: Json) -> str:
    """A text or list of texts as JavaScript reads it, inside a page too."""
    return json.dumps(x).replace("<", "\\u003c")


def _comment(text: str) -> str:
    """A text that ends neither a comment nor a script of a page."""
    return text.replace("*/", "* /").replace("</", "< /").replace("<!", "< !")
