// Up to which time two compiled runs agree, and the curve that deviates first: analyses/dynamics/horizon.py.

import { curves } from "./core_result.js";

/**
 * {time, first, motion} of a result of `resultOf` and of a tighter one: up to when all curves, and all positions and
 * rates, agree.  run: the CoreRun of the first, whose kernels show how much of a curve is rounding; `shaken` of its image
 * is room for two rows.
 */
export function agreement(first, second, run, data, functions, p = data.values) {
  const { AGREE, STILL, MOST_NOISE } = data.horizon, n = Math.min(first.t.length, second.t.length);
  const names = data.names.filter((name) => !name.startsWith("energy.")), signals = new Set(data.signals), moving = new Set(data.moving);
  const of = (result, name) => result.columns[name].subarray(0, n);
  const spans = Object.fromEntries(names.map((name) => [name, range(of(first, name))]));
  const widest = widestByUnit(names, data, spans), shaken = rounding(run, data, functions, p, names, n);
  let time = first.t[n - 1], motion = time, deviating = "", row = n;
  for (const name of names) {
    const wide = widest.get(data.units[name]), noise = shaken[name];
    const floor = Math.max(STILL * wide, signals.has(name) ? noise : Math.min(noise, MOST_NOISE * wide));
    const k = parting(of(first, name), of(second, name), n, Math.max(AGREE * spans[name], floor));
    if (k === n) continue;
    const until = first.t[Math.max(0, k - 1)];
    if (k < row) [row, deviating, time] = [k, name, until];
    if (moving.has(name)) motion = Math.min(motion, until);
  }
  return { time, first: deviating, motion };
}

function range(values) {
  let low = Infinity, high = -Infinity;
  for (const x of values) {
    if (Number.isNaN(x)) return NaN;
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
function widestByUnit(names, { units, size, horizon: { LIKE } }, spans) {
  const widest = new Map();
  for (const name of names) widest.set(units[name], larger(widest.get(units[name]) ?? 0, spans[name]));
  for (const [linear, angular] of LIKE) {
    const arm = angular === "N*m" ? 1 / size : size, wide = larger(widest.get(linear) ?? 0, (widest.get(angular) ?? 0) * arm);
    widest.set(linear, wide);
    widest.set(angular, wide / arm);
  }
  return widest;
}

const larger = (a, b) => (b > a ? b : a); // as Python: the first where one is nan

// change of every curve when positions and rates are perturbed by NOISE tolerances
function rounding(run, data, functions, p, names, n) {
  const { NOISE, SHAKEN } = data.horizon, { m } = run, count = 6 * data.bodies, [first, last] = data.own_states;
  const most = Object.fromEntries(names.map((name) => [name, 0])), held = m.arrays.state.data.slice(), { rows } = run.result();
  const kept = [m.row(m.shaken, 0), m.row(m.shaken, 1)], both = new Float64Array(2 * data.width), y = m.arrays.state.data;
  let seed = 1; // a linear congruential generator: the same numbers in every browser
  const random = () => (seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0) / 2 ** 31 - 1;
  for (const k of new Set(Array.from({ length: SHAKEN }, (_, i) => Math.trunc((i * (n - 1)) / (SHAKEN - 1))))) {
    const row = rows.subarray(k * data.width, (k + 1) * data.width), t = m.times.data[k];
    y.fill(0);
    for (let i = 0; i < data.bodies; i++)
      for (let j = 0; j < 3; j++) [y[3 * i + j], y[3 * data.bodies + 3 * i + j]] = [row[9 * i + j], row[9 * i + 3 + j]];
    for (let j = first; j < last; j++) y[j] = row[data.states + j - first];
    m.call("record", t, m.arrays.state, kept[0]);
    for (let j = 0; j < count; j++) y[j] += NOISE * (run.atol + run.rtol * Math.abs(y[j])) * random();
    m.call("record", t, m.arrays.state, kept[1]);
    kept.forEach(({ data: values }, side) => both.set(values, side * data.width));
    const found = curves(run, data, functions, p, both);
    for (const name of names) {
      const change = Math.abs(found[name][1] - found[name][0]);
      if (change < Infinity) most[name] = Math.max(most[name], change);
    }
  }
  y.set(held);
  return most;
}
