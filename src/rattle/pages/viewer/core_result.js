// From the end of a run by the compiled kernels to a result, as a page shows it.
//
// data, functions: of `rattle.pages.result_data`.  p: the parameters in its order [SI].

import { CoreRoom } from "./core.js";
import { messageOf } from "./core_trouble.js";
import { endsBeside, joltsOf, passed, trustOf } from "./core_trust.js";

/** What a page shows of a run that has ended, or was stopped; columns are those of `simulate`. */
export function resultOf(run, data, functions, p = data.values, milliseconds = 0) {
  const message = run.status === run.N.DONE ? "" : messageOf(run, data, run.status); // rows overwrite what it reads
  if (message) recordFirst(run);
  const found = run.result(), n = found.t.length, columns = curves(run, data, functions, p, found.rows);
  const gaps = passed(run, data).map(({ since, until }) => [since, until]), events = eventsOf(run, data, found);
  for (const name of gaps.length ? data.reactions : [])
    found.t.forEach((t, k) => { if (gaps.some(([since, until]) => t >= since && t <= until)) columns[name][k] = NaN; });
  const { steps, rejected, evaluations } = found.statistics;
  const result = { names: data.names, units: data.units, t: found.t, columns, peaks: peaksOf(run, data, gaps), events };
  return {
    ...result, trust: trustOf(run, { ...data, told: toldFor(data, functions, p) }, p, result, gaps, message, slipping(data, functions, p, found.rows)), success: found.success, message,
    stats: { steps, rejected, evaluations, method: run.method ?? "", rtol: run.rtol, step: run.step, milliseconds }, written: n,
  };
}

// what trust is judged by, for these parameters
function toldFor(data, functions, p) {
  const { facts, told, width, calls, parameters } = data, values = new Float64Array(facts.length), changed = structuredClone({ links: told.links, oil: told.oil });
  const input = new Float64Array(parameters.length + width + 4 + calls.length);
  input.set(p.slice(0, parameters.length));
  functions.facts(input, values);
  facts.forEach((place, k) => {
    let inner = changed;
    for (const key of place.slice(0, -1)) inner = inner[key];
    inner[place.at(-1)] = values[k];
  });
  return { ...told, ...changed };
}

// of belts that may slip, row after row: the ratio of their strands that friction holds, the wrap [rad] and mu
function slipping({ belts, width, calls, parameters }, functions, p, rows) {
  const input = new Float64Array(parameters.length + width + 4 + calls.length), made = new Float64Array(3 * belts.length);
  input.set(p.slice(0, parameters.length));
  return Array.from({ length: belts.length ? rows.length / width : 0 }, (_, k) => {
    input.set(rows.subarray(k * width, (k + 1) * width), parameters.length);
    functions.belts(input, made);
    return made.slice();
  });
}

// a run that fails at once has the output at its start all the same
function recordFirst({ m, N, start, t }) {
  const { tally, state } = m.arrays;
  if (tally.data[N.OUTPUTS] || t !== start || !(m.times.data[0] <= start)) return;
  m.call("record", start, state, m.row(m.rows, 0));
  tally.data[N.OUTPUTS] = 1n;
}

// ---------------------------------------------------------------- columns
/** Columns by name, each a Float64Array, of raw rows one after the other; the first one is where the balance begins. */
export function curves(run, data, functions, p, rows, first = rows.subarray(0, data.width)) {
  const { width, places, calls, energies } = data, n = rows.length / width, np = data.parameters.length;
  const input = new Float64Array(np + width + 4 + calls.length), returned = called(run, data, functions, p, rows);
  input.set(p.slice(0, np));
  if (n) input.set(first.subarray(energies, energies + 4), np + width);
  const derived = new Float64Array(places.filter((place) => place < 0).length);
  const columns = data.names.map(() => new Float64Array(n));
  for (let k = 0; k < n; k++) {
    input.set(rows.subarray(k * width, (k + 1) * width), np);
    returned.forEach((values, c) => { input[np + width + 4 + c] = values[k]; });
    functions.columns(input, derived);
    places.forEach((place, c) => { columns[c][k] = place < 0 ? derived[-1 - place] : input[np + place]; });
  }
  return Object.fromEntries(data.names.map((name, c) => [name, columns[c]]));
}

// what kernels over arrays return for all rows, call after call
function called(run, data, functions, p, rows) {
  const { width, calls } = data, n = rows.length / width, np = data.parameters.length;
  if (!calls.length || !n) return [];
  const input = new Float64Array(np + width + 4 + calls.length), given = new Float64Array(2 * calls.length);
  const table = new Float64Array(calls.reduce((sum, { table: size }) => sum + size, 0));
  const sides = Array.from(given, () => new Float64Array(n));
  input.set(p.slice(0, np));
  functions.tables(input, table);
  for (let k = 0; k < n; k++) {
    input.set(rows.subarray(k * width, (k + 1) * width), np);
    functions.before(input, given);
    given.forEach((x, c) => { sides[c][k] = x; });
  }
  const aside = new CoreRoom(run.m.room.engine, [table.length, n, n, n].map((size) => [size])), own = aside.array([table.length]);
  const [first, second, made] = [n, n, n].map((size) => aside.array([size]));
  own.data.set(table);
  let start = 0;
  return calls.map(({ kernel, table: size }, c) => {
    first.data.set(sides[2 * c]);
    second.data.set(sides[2 * c + 1]);
    aside.call(kernel, first, second, ...(size ? [{ at: own.at + own.data.BYTES_PER_ELEMENT * start, shape: [size] }] : []), made);
    start += size;
    return made.data.slice();
  });
}

// ---------------------------------------------------------------- peaks, events
// value, time, root mean square by name: analyses/dynamics/peak_values.py
function peaksOf(run, data, gaps) {
  const { peaks: last, peaks_aside: before, clock } = run.m.arrays, { BEST, WHEN, SQUARES } = data.sample;
  const beside = endsBeside(run, data), { data: seen, shape: [, wide] } = beside ? before : last;
  const span = clock.data[data.at.clock.T] - run.start - gaps.reduce((sum, [since, until]) => sum + until - since, 0);
  const found = {};
  data.peaks.names.forEach((name, k) => {
    const [best, when, squares] = (beside ? [0, 1, 2] : [BEST, WHEN, SQUARES]).map((c) => seen[k * wide + c]);
    const value = best > -Infinity ? best : NaN;
    found[name] = [value, when, span > 0 ? Math.sqrt(Math.max(squares, 0) / span) : Math.abs(value)];
  });
  for (const [name, like] of Object.entries(data.peaks.same)) found[name] ??= found[like];
  return found;
}

// analyses/dynamics/events.py, analyses/timetable.py
function eventsOf(run, data, found) {
  const word = (joint, kind) => data.words[joint]?.[kind] ?? kind, { arrays } = run.m, C = data.at.contact_memory;
  const events = found.events.map(({ t, joint, contact, kind, values }) => {
    const plain = data.kinds[kind], whole = plain === "contact" || plain === "impact";
    const [normal_speed, duration, peak_force, impulse, energy_lost] = values.map((x, k) => (whole || k === 0 ? x : 0));
    return { t, joint, kind: word(joint, plain), normal_speed, duration, peak_force, impulse, energy_lost, contact };
  });
  const now = arrays.clock.data[data.at.clock.T], wide = arrays.contact_memory.shape[1];
  for (let n = 0; n < data.contacts; n++) {
    const memory = arrays.contact_memory.data.subarray(n * wide, (n + 1) * wide), account = data.first_account + data.account.size * n;
    if (memory[C.CLOSED] !== C.SHUT) continue;
    events.push({
      t: memory[C.SINCE], joint: run.owners[n], kind: word(run.owners[n], "contact"), normal_speed: memory[C.SPEED],
      duration: now - memory[C.SINCE], peak_force: memory[C.PEAK],
      impulse: arrays.state.data[account + data.account.IMPULSE] - memory[C.IMPULSE_0],
      energy_lost: arrays.state.data[account + data.account.LOSS] - memory[C.LOSS_0], contact: run.labels[n] ?? "",
    });
  }
  events.sort((a, b) => a.t - b.t);
  for (const { t, driver: joint, size: normal_speed, impulse, work } of joltsOf(run, data))
    events.push({ t, joint, kind: "jolt", normal_speed, duration: 0, peak_force: 0, impulse, energy_lost: -work, contact: "" });
  return events.sort((a, b) => a.t - b.t);
}
