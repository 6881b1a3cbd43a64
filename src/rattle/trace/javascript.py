"""Straight-line code in JavaScript: functions and a whole ES module, for pages and for node, without dependencies.

JavaScript's numbers are IEEE doubles, its + - * /, sqrt, abs and floor are exact, and no engine may contract them, so
every operation has the bits of the reference.  The module takes its steps as the program of `c` does, operation by
operation, and stops with the same messages.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from rattle.trace.graph import ROUND, Graph
from rattle.trace.text import pieces

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
ROWS = 1000
SIZE = 2000  # operations of one function: engines leave large ones to their slow tiers (V8 beyond 60 kB of byte code)


def number(value: float) -> str:
    """A number as JavaScript reads it, to the bit."""
    if value != value:
        return "NaN"
    if math.isinf(value):
        return "Infinity" if value > 0.0 else "(-Infinity)"
    text = repr(float(value))
    return f"({text})" if text.startswith("-") else text


def function(graph: Graph, outputs: Sequence[Any], name: str) -> str:
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


# the text of a module after its recorded functions; what stands in @...@ is put in
MAIN = """
const NY = @ny@, NO = names.length, NP = parameterNames.length, ROWS = @rows@;
const input = new Float64Array(1 + NY + NP), rates = new Float64Array(NY + 1), row = new Float64Array(NO + 1);

// parameters as an array: those that are not given have their values in the model
const model = Float64Array.from(Object.values(parameters));
function values(p) {
  if (p instanceof Float64Array && p.length === NP) return p;
  if (p === undefined || p === null) return model;
  if (typeof p.length === "number") {
    if (p.length !== NP) throw new Error(`p: ${NP} numbers expected, in the order of parameters, not ${p.length}`);
    return Float64Array.from(p);
  }
  const all = model.slice();
  for (const name of Object.keys(p)) {
    const k = parameterNames.indexOf(name);
    if (k < 0) throw new Error(`p: no parameter '${name}' (there are: ${parameterNames.join(", ") || "none"})`);
    all[k] = p[name];
  }
  return all;
}

// a number with six digits, as C prints it with %g
function brief(x) {
  if (!Number.isFinite(x)) return Number.isNaN(x) ? "nan" : x > 0 ? "inf" : "-inf";
  const short = Number(x.toPrecision(6)), size = Math.abs(short);
  if (size === 0 || (size >= 1e-4 && size < 1e6)) return String(short);
  const [digits, power] = short.toExponential().split("e");
  return `${digits}e${power[0]}${power.slice(1).padStart(2, "0")}`;
}

function put(t, y, p) {
  input[0] = t;
  for (let i = 0; i < NY; i++) input[1 + i] = y[i];
  for (let i = 0; i < NP; i++) input[1 + NY + i] = p[i];
}

function requireSound(t, flag) {
  if (flag === 0)
    throw new Error(`t = ${brief(t)} s: near a singular position or coincident points, which this code cannot pass`);
}

function requireFinite(t, y) {
  for (let i = 0; i < NY; i++)
    if (!(Math.abs(y[i]) < Infinity))
      throw new Error(`t = ${brief(t)} s: no finite value (a load outside its domain, or a diverging motion)`);
}

/** The state at t = 0: a Float64Array. */
export function start(p) {
  const y = new Float64Array(NY);
@start@
  return y;
}

/** dy = dy/dt at t [s]. */
export function derivative(t, y, dy, p) {
  put(t, y, values(p));
  derivativeOf(input, rates);
  requireSound(t, rates[NY]);
  requireFinite(t, rates);
  for (let i = 0; i < NY; i++) dy[i] = rates[i];
}

/** Brings y onto the constraints, in place; y must be close to them, as it is after a step. */
export function project(t, y, p) {
  put(t, y, values(p));
  projectionOf(input, rates);
  if (rates[NY] === 0)
    throw new Error(`t = ${brief(t)} s: the joints cannot be closed after this step; choose a shorter one`);
  for (let i = 0; i < NY; i++) y[i] = rates[i];
  requireFinite(t, y);
}

/** out = what `names` lists, at t [s]. */
export function outputs(t, y, out, p) {
  put(t, y, values(p));
  outputsOf(input, row);
  requireSound(t, row[NO]);
  for (let i = 0; i < NO; i++) out[i] = row[i];
}

// one step of the classical Runge-Kutta method of order 4, brought onto the constraints
function advance(t, h, y, p, [k0, k1, k2, k3, stage]) {
  derivative(t, y, k0, p);
  for (let i = 0; i < NY; i++) stage[i] = y[i] + 0.5 * h * k0[i];
  derivative(t + 0.5 * h, stage, k1, p);
  for (let i = 0; i < NY; i++) stage[i] = y[i] + 0.5 * h * k1[i];
  derivative(t + 0.5 * h, stage, k2, p);
  for (let i = 0; i < NY; i++) stage[i] = y[i] + h * k2[i];
  derivative(t + h, stage, k3, p);
  for (let i = 0; i < NY; i++) y[i] = y[i] + (h / 6.0) * (k0[i] + 2.0 * k1[i] + 2.0 * k2[i] + k3[i]);
  project(t + h, y, p);
}

// stops where the energy error is above 0.1 % of the largest energy: the last outputs are kinetic and potential
// energy, work done, energy dissipated, balance
function requireBalance(t, out, seen) {
  const [kinetic, potential, work, , balance] = out.slice(NO - 5);
  if (kinetic > seen.kinetic) seen.kinetic = kinetic;
  if (potential < seen.lowest) seen.lowest = potential;
  if (potential > seen.highest) seen.highest = potential;
  if (Math.abs(work) > seen.work) seen.work = Math.abs(work);
  const largest = Math.max(seen.kinetic, seen.work, seen.highest - seen.lowest);
  const potentials = Math.max(Math.abs(seen.lowest), Math.abs(seen.highest));
  const rounding = 1e-12 * (seen.kinetic + seen.work + potentials);
  if (!(Math.abs(balance) <= 1e-3 * largest + rounding))
    throw new Error(
      `t = ${brief(t)} s: energy error ${brief(Math.abs(balance))} J,` +
        " above 0.1 % of the largest energy: choose a shorter step");
}

/** The motion from 0 to t_end [s] in steps of at most `step` [s]: about @rows@ rows [t, ...outputs] at most. */
export function run(t_end = @t_end@, step = @step@, p = undefined) {
  if (!(t_end > 0 && step > 0 && t_end / step <= 1e9))
    throw new Error("run(t_end, step, p): both in s and positive, at most 1e9 steps");
  const given = values(p), n = Math.max(1, Math.ceil(t_end / step - 1e-9)), h = t_end / n, every = Math.ceil(n / ROWS);
  const y = start(given), out = new Float64Array(NO), rows = [];
  const held = Array.from({ length: 5 }, () => new Float64Array(NY));
  const seen = { kinetic: 0, work: 0, lowest: Infinity, highest: -Infinity };
  const keep = (t) => {
    outputs(t, y, out, given);
    requireBalance(t, out, seen);
    rows.push([t, ...out]);
  };
  keep(0);
  for (let k = 0; k < n; k++) {
    advance(k * h, h, y, given, held);
    if ((k + 1) % every === 0 || k + 1 === n) keep((k + 1) * h);
  }
  return rows;
}
"""
GUIDE = """
 * In a page, inside <script type="module">:
 *
 *   import { names, units, parameters, run } from "./model.js";
 *   const rows = run(0.5, 1e-4@change@);   // [[t, ...outputs], ...], t from 0 to 0.5 s in steps of 0.1 ms
 *   const k = 1 + names.indexOf(@name@);
 *   const curve = rows.map((row) => [row[0], row[k]]);
 *
 * With steps of your own: y = start(p), then derivative(t, y, dy, p) fills dy, project(t, y, p) brings y onto the
 * constraints after a step, outputs(t, y, out, p) fills out with what `names` lists, in `units`.  Arrays are
 * Float64Arrays, all numbers in SI units; p is an object of the parameters that change, an array of all of them in the
 * order of `parameters` (fastest as a Float64Array), or left out.  The state y: positions x, y, angle of every body in
 * turn, their rates, work done and energy dissipated.  Whatever cannot go on throws an Error that says when and why.
"""


class Parts(NamedTuple):
    """Recorded functions of one model; inputs of the graph are t, y (ny), p (np), every list ends with a flag."""

    graph: Graph  # of exact operations
    derivative: Sequence[Any]  # (ny + 1,)
    projection: Sequence[Any]  # (ny + 1,)
    outputs: Sequence[Any]  # (no + 1,), the energies last


def module(
    header: Sequence[str], parts: Parts, names: Sequence[str], units: Sequence[str],
    parameters: Mapping[str, tuple[float, str]], start: Sequence[float] | tuple[Graph, Sequence[Any]],
    t_end: float, step: float,
) -> str:  # fmt: skip
    """A whole ES module: `names`, `units`, `parameters`, `start`, `derivative`, `project`, `outputs`, `run`.

    header: lines of the comment on top; names, units: of the outputs; parameters: value in the model [SI] and unit, by
    name; start: y at t = 0 [SI], or the graph and outputs (ny + 1,) that give it and a flag from p;
    t_end, step: what `run` does when not told [s].
    """
    ny = len(parts.derivative) - 1
    functions = [
        function(parts.graph, outputs, name)
        for name, outputs in (
            ("derivativeOf", parts.derivative), ("projectionOf", parts.projection), ("outputsOf", parts.outputs),
        )
    ]  # fmt: skip
    if isinstance(start, tuple):
        functions.append(function(start[0], start[1], "startOf"))
        begin = STARTS
    else:
        begin = f"  y.set([{', '.join(number(x) for x in start)}]);"
    first = next(iter(parameters), None)
    change = f", {{ {_text(first)}: {number(parameters[first][0])} }}" if first is not None else ""
    guide = GUIDE.replace("@change@", _comment(change)).replace("@name@", _comment(_text(names[0])))
    comment = "\n * ".join(_comment(line) for line in header)
    pairs = ", ".join(f"[{_text(name)}, {number(value)}]" for name, (value, _) in parameters.items())
    main = MAIN
    for key, text in (
        ("ny", str(ny)), ("rows", str(ROWS)), ("start", begin), ("t_end", number(t_end)), ("step", number(step)),
    ):  # fmt: skip
        main = main.replace(f"@{key}@", text)
    tables = [
        f"/** Names of the outputs, and their units. */\nexport const names = {_text(list(names))};",
        f"export const units = {_text(list(units))};",
        f"/** Values of the parameters in the model [SI], by name, and their units. */\n"
        f"export const parameters = Object.fromEntries([{pairs}]);",
        f"export const parameterUnits = {_text([unit for _, unit in parameters.values()])};",
        "const parameterNames = Object.keys(parameters);\n",
    ]
    return "\n".join([f"/** {comment}\n *{guide} */", *tables, BITS, *functions, main.lstrip("\n")])


STARTS = """  const made = new Float64Array(NY + 1);
  startOf(values(p), made);
  if (made[NY] === 0) throw new Error("the mechanism cannot be put together with these parameters");
  requireFinite(0, made);
  y.set(made.subarray(0, NY));"""


def _text(x: Any) -> str:
    """A text or list of texts as JavaScript reads it, inside a page too."""
    return json.dumps(x).replace("<", "\\u003c")


def _comment(text: str) -> str:
    """A text that ends neither a comment nor a script of a page."""
    return text.replace("*/", "* /").replace("</", "< /").replace("<!", "< !")
