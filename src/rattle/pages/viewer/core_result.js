// From the end of a run by the compiled kernels to a result, as `endRun` of engine.js returns it.
//
// data, functions: of `rattle.pages.result_data`.  p: the parameters in its order [SI].

import { general, trustLines } from "./trust_words.js";

const NUMBER_BYTES = 8;

/** What a page shows of a run that has ended, or was stopped; columns are those of `simulate`. */
export function resultOf(run, data, functions, p = data.values, milliseconds = 0) {
  const found = run.result(), n = found.t.length, columns = curves(run, data, functions, p, found.rows);
  const gaps = passages(run, data), events = eventsOf(run, data, found);
  for (const name of gaps.length ? data.reactions : [])
    found.t.forEach((t, k) => { if (gaps.some(([since, until]) => t >= since && t <= until)) columns[name][k] = NaN; });
  const message = found.success ? "" : messageOf(run, data, found.status), { steps, rejected, evaluations } = found.statistics;
  return {
    names: data.names, units: data.units, t: found.t, columns, peaks: peaksOf(run, data, gaps), events,
    trust: trustOf(run, data, columns["energy.balance"], events, gaps, message), success: found.success, message,
    stats: { steps, rejected, evaluations, method: run.method ?? "", rtol: run.rtol, step: run.step, milliseconds }, written: n,
  };
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
  const aside = new Aside(run.m, 3 * n + table.length);
  let first = 0;
  return calls.map(({ kernel, table: size }, c) => {
    const own = size ? [table.subarray(first, first + size)] : [];
    first += size;
    return aside.call(kernel, n, [sides[2 * c], sides[2 * c + 1], ...own]);
  });
}

// an instance of the engine beside that of a run, with room for a few arrays
class Aside {
  constructor({ module, about }, cells) {
    this.about = about;
    this.calls = new WebAssembly.Instance(module, {}).exports;
    const { memory } = this.calls, start = Math.ceil(about.free / NUMBER_BYTES) * NUMBER_BYTES;
    const missing = Math.ceil((start + NUMBER_BYTES * (cells + 8) - memory.buffer.byteLength) / 65536);
    if (missing > 0) memory.grow(missing);
    Object.assign(this, { result: start, room: start + 8 * NUMBER_BYTES });
  }

  /** Call a kernel that fills an array of n numbers. */
  call(name, n, given) {
    const { buffer } = this.calls.memory, every = [...given, new Float64Array(n)];
    let at = this.room;
    const flat = every.flatMap((values) => {
      new Float64Array(buffer, at, values.length).set(values);
      at += NUMBER_BYTES * values.length;
      return [at - NUMBER_BYTES * values.length, BigInt(values.length)];
    });
    if (this.calls[`call ${name}`](this.result, ...flat)) throw new Error(`the kernel ${name} failed`);
    return new Float64Array(buffer, at - NUMBER_BYTES * n, n).slice();
  }
}

// ---------------------------------------------------------------- peaks, events
// value, time, root mean square by name: analyses/dynamics/peak_values.py
function peaksOf(run, data, gaps) {
  const { peaks, clock } = run.m.arrays, { BEST, WHEN, SQUARES } = data.sample, wide = peaks.shape[1];
  const span = clock.data[data.at.clock.T] - run.start - gaps.reduce((sum, [since, until]) => sum + until - since, 0);
  const found = {};
  data.peaks.names.forEach((name, k) => {
    const [best, when, squares] = [BEST, WHEN, SQUARES].map((c) => peaks.data[k * wide + c]);
    const value = best > -Infinity ? best : NaN;
    found[name] = [value, when, span > 0 ? Math.sqrt(Math.max(squares, 0) / span) : Math.abs(value)];
  });
  for (const [name, like] of Object.entries(data.peaks.same)) found[name] ??= found[like];
  return found;
}

// analyses/dynamics/events.py, analyses/timetable.py
function eventsOf(run, data, found) {
  const word = (joint, kind) => data.words[joint]?.[kind] ?? kind, { arrays } = run.m, C = data.at.contact_memory;
  const events = found.events.map(({ t, joint, kind, values }) => {
    const plain = data.kinds[kind], whole = plain === "contact" || plain === "impact";
    const [normal_speed, duration, peak_force, impulse, energy_lost] = values.map((x, k) => (whole || k === 0 ? x : 0));
    return { t, joint, kind: word(joint, plain), normal_speed, duration, peak_force, impulse, energy_lost };
  });
  const now = arrays.clock.data[data.at.clock.T], wide = arrays.contact_memory.shape[1];
  for (let n = 0; n < data.contacts; n++) {
    const memory = arrays.contact_memory.data.subarray(n * wide, (n + 1) * wide), account = data.first_account + data.account.size * n;
    if (memory[C.CLOSED] !== C.SHUT) continue;
    events.push({
      t: memory[C.SINCE], joint: run.owners[n], kind: word(run.owners[n], "contact"), normal_speed: memory[C.SPEED],
      duration: now - memory[C.SINCE], peak_force: memory[C.PEAK],
      impulse: arrays.state.data[account + data.account.IMPULSE] - memory[C.IMPULSE_0],
      energy_lost: arrays.state.data[account + data.account.LOSS] - memory[C.LOSS_0],
    });
  }
  events.sort((a, b) => a.t - b.t);
  const seen = new Map();
  for (const { t, row, impulse } of found.jolts) { // of several drivers at one instant, in their order
    const like = data.jumps.filter((jump) => jump.t === t), k = seen.get(t) ?? 0, jump = like[k] ?? { joint: `row ${row}`, size: NaN };
    seen.set(t, k + 1);
    events.push({ t, joint: jump.joint, kind: "jolt", normal_speed: jump.size, duration: 0, peak_force: 0, impulse, energy_lost: NaN });
  }
  return events.sort((a, b) => a.t - b.t);
}

// ---------------------------------------------------------------- trust
function trustOf(run, data, balance, events, gaps, message) {
  const { audit, clock, tally } = run.m.arrays, A = data.at.audit, seen = (name) => audit.data[A[name]];
  const exchanged = Math.max(seen("MOST_KINETIC"), seen("MOST_WORK"), seen("MOST_POTENTIAL") - seen("LEAST_POTENTIAL")) + data.limit * seen("FLOOR");
  const count = (kind) => events.filter((event) => event.kind === kind).length, fewest = clock.data[data.at.clock.FEWEST];
  const trust = {
    drift: seen("OPEN_LENGTH"), drift_angle: seen("OPEN_ANGLE"),
    drift_joint: data.rows.length ? data.rows[Number(tally.data[data.at.tally.DRIFT_ROW])][0] : "",
    energy: balance.reduce((most, x) => (Math.abs(x) > most || Number.isNaN(x) ? Math.abs(x) : most), balance.length ? 0 : NaN),
    energy_share: exchanged > 0 ? seen("MOST_UNREST") / exchanged : 0, t_end: clock.data[data.at.clock.T],
    stopped: message !== "", ...pulls(run, data), pending: balance.length > 1, horizon: null, horizon_motion: null, horizon_curve: "",
    contact_count: data.contacts ? count("contact") : null, impact_count: count("impact"), contacts: [],
    fewest_steps: data.contacts && fewest < Infinity ? fewest : null, gaps, singular: singular(run, data), limits: [], notes: [...data.notes],
  };
  if (run.adaptive && run.rtol > data.loose)
    trust.notes.push(`rtol = ${general(run.rtol)} is loose: short contacts may be missed and the horizon may be overestimated`);
  return { ...trust, text: trustLines(trust) };
}

function pulls(run, data) {
  const pulled = {}, first_pull = {}, until = run.m.arrays.clock.data[data.at.clock.T], span = Math.max(until - run.start, 1e-300);
  data.watched.forEach((name, n) => {
    const own = run.crossings.filter(([, force]) => force === n), times = own.map(([t]) => t);
    const first = own.length ? -own[0][2] : run.m.arrays.sign.data[n]; // every crossing has its new sign
    if (first < 0) times.unshift(run.start);
    if (times.length % 2) times.push(until);
    let sum = 0;
    for (let k = 0; k < times.length; k += 2) sum += times[k + 1] - times[k];
    pulled[name] = sum / span;
    first_pull[name] = times.length ? times[0] : null;
  });
  return { pulled, first_pull };
}

const passed = ({ m }, data) => {
  const { passage, passages: rows } = m.arrays, P = data.at.passage, count = passage.shape[0] ? passage.data[P.PASSED] : 0;
  return Array.from({ length: Math.min(count, rows.shape[0]) }, (_, k) => m.row(rows, k).data);
};
const passages = (run, data) => passed(run, data).map((row) => [row[data.at.passage.PASSED_FROM], row[data.at.passage.PASSED_UNTIL]]);
const singular = (run, data) => passed(run, data).map((row) => row[data.at.passage.PASSED_AT]);

// ---------------------------------------------------------------- why a run ended early
function messageOf(run, data, status) {
  const { audit } = run.m.arrays, A = data.at.audit, seen = (name) => audit.data[A[name]], what = [];
  const why = data.words_of_end[status], head = `cannot go on at t = ${general(run.t)} s`;
  if (!why) return `ended at t = ${general(run.t)} s; the result holds what was computed before`;
  if (status !== data.unsound) return `${head}: ${why}`;
  const opened = Math.max(seen("OPENNESS"), seen("CORRECTION"));
  if (!(opened <= data.limit) && data.rows.length) {
    const [owner, unit] = data.rows[seen("OPEN_ROW")];
    what.push(`'${owner}' would open by ${general(opened, 2)} ${unit === "rad" ? "rad" : "of the mechanism's size"}`);
  }
  if (!(seen("UNREST") <= seen("UNREST_LIMIT"))) what.push(`the energy error would be ${general(100 * seen("UNREST"), 2)} % of the largest energy`);
  return `ended at t = ${general(run.t)} s${what.length ? `, before ${what.join(" and ")}` : `: ${why}`}`;
}
