"""What stands after the recorded functions in an ES module; `javascript` puts in what stands in @...@ here."""

HEAD = """
const NY = @ny@, NP = sliders.length, input = new Float64Array(@inputs@);
const ownStart = Float64Array.of(@start@); // y at t = 0 for the values of the model

// parameters as an array: those that are not given have their values in the model
const model = Float64Array.from(sliders, (one) => one.value);
function values(p) {
  if (p instanceof Float64Array && p.length === NP) return p;
  if (p === undefined || p === null) return model;
  if (typeof p !== "object" || p instanceof Map)
    throw new Error("p: an object of parameters, an array of all of them, or nothing expected");
  if (typeof p.length === "number") {
    if (p.length !== NP) throw new Error(`p: ${NP} numbers expected, in the order of parameters, not ${p.length}`);
    return Float64Array.from(p);
  }
  const all = model.slice();
  for (const name of Object.keys(p)) {
    const k = sliders.findIndex((one) => one.name === name);
    if (k < 0)
      throw new Error(`p: no parameter '${name}' (there are: ${sliders.map((one) => one.name).join(", ") || "none"})`);
    const x = p[name]; // an empty text, null and true are no numbers, though Number() says so
    all[k] = typeof x === "number" || (typeof x === "string" && x.trim() !== "") ? Number(x) : NaN;
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

function put(t, y, p, energy = 0) {
  input[0] = t;
  for (let i = 0; i < NY; i++) input[1 + i] = y[i];
  for (let i = 0; i < NP; i++) input[1 + NY + i] = p[i];
  input[1 + NY + NP] = energy;
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

@begin@
/** The state at t = 0: a Float64Array. */
export function start(p) {
  const given = values(p), y = ownStart.slice();
  if (given.some((x, k) => x !== model[k])) begin(y, given);
  return y;
}
"""

MAIN = """
const NO = names.length - 1, ROWS = @rows@, rates = new Float64Array(NY + 1), row = new Float64Array(NO + 1);

// the energy at the start [J], from which energy.balance counts; NaN for parameters that have no start
const last = { p: null, energy: NaN };
function startEnergy(p) {
  if (last.p === null || p.some((x, k) => x !== last.p[k])) {
    last.p = p.slice();
    last.energy = NaN;
    try {
      put(0, start(p), p);
      outputsOf(input, row);
      last.energy = row[NO - 1];
    } catch {} // start(p) says why
  }
  return last.energy;
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
  projectOf(input, rates);
  if (rates[NY] === 0)
    throw new Error(`t = ${brief(t)} s: the joints cannot be closed after this step; choose a shorter one`);
  for (let i = 0; i < NY; i++) y[i] = rates[i];
  requireFinite(t, y);
}

/** out = what `names` lists, at t [s]; t itself is out[0]. */
export function outputs(t, y, out, p) {
  const given = values(p), energy = startEnergy(given);
  put(t, y, given, energy);
  outputsOf(input, row);
  requireSound(t, row[NO]);
  out[0] = t;
  for (let i = 0; i < NO; i++) out[1 + i] = row[i];
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
  const [kinetic, potential, work, , balance] = out.slice(NO - 4);
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

/** The motion from 0 to t_end [s] in steps of at most `step` [s]: at most about @rows@ rows of what `names` lists. */
export function run(t_end = @t_end@, step = @step@, p = undefined) {
  if (!(t_end > 0 && step > 0 && t_end / step <= 1e9))
    throw new Error("run(t_end, step, p): both in s and positive, at most 1e9 steps");
  const given = values(p), n = Math.max(1, Math.ceil(t_end / step - 1e-9)), h = t_end / n, every = Math.ceil(n / ROWS);
  const y = start(given), out = new Float64Array(1 + NO), rows = [];
  const held = Array.from({ length: 5 }, () => new Float64Array(NY));
  const seen = { kinetic: 0, work: 0, lowest: Infinity, highest: -Infinity };
  const keep = (t) => {
    outputs(t, y, out, given);
    requireBalance(t, out, seen);
    rows.push([...out]);
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
 *   const rows = run(0.5, 1e-4@change@);   // t from 0 to 0.5 s in steps of 0.1 ms
 *   const k = names.indexOf(@name@);   // names[0] is "t"
 *   const curve = rows.map((row) => [row[0], row[k]]);
 *
 * With steps of your own: y = start(p), then derivative(t, y, dy, p) fills dy, project(t, y, p) brings y onto the
 * constraints after a step, outputs(t, y, out, p) fills out with what `names` lists, in `units`.  Arrays are
 * Float64Arrays, all numbers in SI units; p is an object of the parameters that change, an array of all of them in the
 * order of `sliders` (fastest as a Float64Array), or left out.  The state y: positions x, y, angle of every body in
 * turn, their rates, work done and energy dissipated.  energy.balance counts from the energy of start(p); it is NaN
 * where p has no start.  Whatever cannot go on throws an Error that says when and why.
"""

BEGIN = """
// what changes of positions are measured by [m or rad]; what must close at the start
const sizes = Float64Array.of(@sizes@), NQ = sizes.length, found = new Float64Array(NQ + 2);
const gapNames = @gaps@;

const larger = (a, b) => (b > a || b !== b ? b : a); // nan stays

// positions q that close, by Newton's method; returns "", or why not: "open", "singular", "far" from the first
function closePositions(q, p) {
  let left = Infinity, sound = 0, far = 0;
  put(0, ownStart, p);
  input.set(q, 1);
  for (let round = 0; round < @rounds@; round++) {
    correctOf(input, found);
    let step = 0;
    for (let i = 0; i < NQ; i++) step = larger(step, Math.abs((found[i] - input[1 + i]) / sizes[i]));
    for (let i = 0; i < NQ; i++) input[1 + i] = found[i];
    left = found[NQ];
    sound = found[NQ + 1];
    if (!(step > @small@)) break;
  }
  for (let i = 0; i < NQ; i++) far = larger(far, Math.abs((input[1 + i] - q[i]) / sizes[i]));
  q.set(input.subarray(1, 1 + NQ));
  return !(left <= @closed@) ? "open" : sound === 0 ? "singular" : !(far <= @far@) ? "far" : "";
}

function refuse(why, q, p) {
  let said = why;
  if (why === "open") {
    const open = new Float64Array(gapNames.length);
    let worst = 0;
    put(0, ownStart, p);
    input.set(q, 1);
    gapsOf(input, open);
    for (let i = 1; i < open.length; i++) worst = open[i] > open[worst] || open[i] !== open[i] ? i : worst;
    said = `${gapNames[worst][0]} ${brief(open[worst])} ${gapNames[worst][1]}`;
  } else if (why === "singular") said = "its position is singular";
  else if (why === "far") said = "they are too far from the model's";
  throw new Error(`the mechanism cannot be put together with these parameters: ${said}`);
}

// throws for parameters that the model does not take
function requireReadable(y, p) {
  const flag = new Float64Array(1);
  sliders.forEach(({ name }, i) => {
    if (!Number.isFinite(p[i])) throw new Error(`${name}: expected a finite number, not ${p[i]}`);
  });
  put(0, y, p);
  readableOf(input, flag);
  if (flag[0] !== 0) return;
  sliders.forEach(({ name, min, max, unit }, i) => {
    const low = min ?? -Infinity, high = max ?? Infinity;
    if (p[i] < low || p[i] > high)
      throw new Error(`${name} = ${brief(p[i])} is outside of its limits, ${brief(low)} to ${brief(high)} ${unit}`);
  });
  throw new Error("with these parameters the model is refused or has another form; write its code anew");
}
// y at t = 0 for other parameters than the model's, from y for the model's: at once, or in up to @pieces@ pieces
function begin(y, p) {
  requireReadable(y, p);
  let why = "open", once, first, q;
  for (let n = 1; why !== "" && n <= @pieces@; n *= 2) {
    q = y.slice(0, NQ);
    why = "";
    for (let k = 1; why === "" && k <= n; k++)
      why = closePositions(q, k === n ? p : model.map((x, i) => x + (k / n) * (p[i] - x)));
    if (n === 1) [once, first] = [why, q];
  }
  if (why !== "") refuse(once, first, p);
  y.set(q);
  put(0, y, p);
  closeRatesOf(input, found);
  let fastest = 0;
  for (let i = 0; i < NQ; i++) fastest = larger(fastest, Math.abs(found[i]));
  if (found[NQ + 1] === 0) refuse("singular", q, p);
  if (!(found[NQ] <= @missed@ * larger(1, fastest))) refuse("given rates contradict the joints", q, p);
  y.set(found.subarray(0, NQ), NQ);
  requireFinite(0, y);
}
"""
NO_BEGIN = """
function begin() {
  throw new Error("only the parameters of the model have a start here");
}
"""
