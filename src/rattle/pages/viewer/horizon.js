// Up to which time two runs agree, and the curve that deviates first: analyses/dynamics/horizon.py.

const AGREE = 0.01; // share of its range within which two curves agree
const STILL = 1e-7; // a curve whose range is below this share of the widest of its unit counts as constant
const NOISE = 10; // perturbation of a state, in tolerances, that shows how much of a curve is rounding
const MOST_NOISE = 1e-3; // share of the widest of its unit that may count as rounding
const SHAKEN = 12; // instants at which the state is perturbed
const MOTION = ["m", "rad", "m/s", "rad/s"];
const LIKE = [["m", "rad"], ["m/s", "rad/s"], ["m/s^2", "rad/s^2"], ["N", "N*m"]];

const column = (run, c) => run.data.subarray(c * run.times.length, c * run.times.length + run.written);

/** {time, first, motion} of a run and a tighter one: up to when all curves, and all positions and rates, agree. */
export function agreement(run, second) {
  const n = Math.min(run.written, second.written), { layout, module } = run, count = layout.compared;
  const units = module.units.slice(1, count + 1), signals = new Set(layout.signals);
  const spans = units.map((_, c) => range(column(run, c).subarray(0, n)));
  const widest = widestByUnit(units, spans, layout.size), shaken = rounding(run, n);
  let time = run.times[n - 1], motion = time, first = "", row = n;
  for (let c = 0; c < count; c++) {
    const wide = STILL * widest.get(units[c]), noise = MOST_NOISE * widest.get(units[c]);
    const floor = Math.max(wide, signals.has(c) ? shaken[c] : Math.min(shaken[c], noise));
    const k = parting(column(run, c), column(second, c), n, Math.max(AGREE * spans[c], floor));
    if (k === n) continue;
    const until = run.times[Math.max(0, k - 1)];
    if (k < row) [row, first, time] = [k, module.names[c + 1], until];
    if (MOTION.includes(units[c]) && !signals.has(c)) motion = Math.min(motion, until);
  }
  return { time, first, motion };
}

function range(values) {
  let low = Infinity, high = -Infinity;
  for (const x of values) {
    low = Math.min(low, x);
    high = Math.max(high, x);
  }
  return high - low;
}

function parting(one, other, n, tolerance) {
  for (let k = 0; k < n; k++) if (Math.abs(one[k] - other[k]) > tolerance) return k;
  return n;
}

// a length of the mechanism's size compares with an angle of 1 rad
function widestByUnit(units, spans, size) {
  const widest = new Map();
  units.forEach((unit, c) => widest.set(unit, Math.max(widest.get(unit) ?? 0, spans[c])));
  for (const [linear, angular] of LIKE) {
    const arm = angular === "N*m" ? 1 / size : size;
    const wide = Math.max(widest.get(linear) ?? 0, (widest.get(angular) ?? 0) * arm);
    widest.set(linear, wide);
    widest.set(angular, wide / arm);
  }
  return widest;
}

// change of every curve when positions and rates are perturbed by NOISE tolerances
function rounding(run, n) {
  const { layout, ny, nm, no } = run, most = new Float64Array(layout.compared);
  const y = new Float64Array(ny), near = new Float64Array(ny), [one, other] = [0, 0].map(() => new Float64Array(no + 1));
  let seed = 1; // a linear congruential generator: the same numbers in every browser
  const random = () => (seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0) / 2 ** 31 - 1;
  for (let i = 0; i < SHAKEN; i++) {
    const k = Math.trunc((i * (n - 1)) / (SHAKEN - 1)), t = run.times[k];
    stateAt(run, k, y);
    near.set(y);
    for (let j = 0; j < nm; j++) near[j] += NOISE * (run.atol + run.rtol * Math.abs(y[j])) * random();
    run.functions.outputs(run.at(t, y), one);
    run.functions.outputs(run.at(t, near), other);
    for (let c = 0; c < layout.compared; c++) {
      const change = Math.abs(other[c] - one[c]);
      if (change < Infinity) most[c] = Math.max(most[c], change);
    }
  }
  return most;
}

// y of an output row: positions and rates of bodies, states of the model; energies count from zero
function stateAt(run, k, y) {
  const { layout, nb } = run;
  y.fill(0);
  for (let i = 0; i < nb; i++)
    for (let j = 0; j < 3; j++) {
      y[3 * i + j] = column(run, 9 * i + j)[k];
      y[3 * nb + 3 * i + j] = column(run, 9 * i + 3 + j)[k];
    }
  layout.states.forEach((c, n) => (y[layout.first_state + n] = column(run, c)[k]));
}
