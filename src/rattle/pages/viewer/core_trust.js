// How far a run by the compiled kernels can be trusted: analyses/dynamics/report.py with the notes that it collects.

import { ReadCurves } from "./core_unread.js";
import { fill, general, trusted } from "./trust_words.js";

/**
 * Trust with its words.  result: of a run, as far as it is known (t, units, columns, peaks, events); gaps: spans beside
 * singular positions [s] without forces; grips: of `data.belts`, row after row.
 */
export function trustOf(run, data, p, result, gaps, message, grips) {
  const { audit, clock, tally } = run.m.arrays, A = data.at.audit, seen = (name) => audit.data[A[name]], { told } = data;
  const { events, columns } = result, balance = columns["energy.balance"], count = (kind) => events.filter((event) => event.kind === kind).length;
  const fewest = clock.data[data.at.clock.FEWEST], lost = tally.data[data.at.tally.LOST_ROWS] !== 0n;
  const trust = {
    drift: seen("OPEN_LENGTH"), drift_angle: seen("OPEN_ANGLE"),
    drift_joint: data.rows.length ? data.rows[Number(tally.data[data.at.tally.DRIFT_ROW])][0] : "",
    energy: balance.reduce((most, x) => (Math.abs(x) > most || Number.isNaN(x) ? Math.abs(x) : most), balance.length ? 0 : NaN),
    energy_share: energyShareOf(run, data), t_end: clock.data[data.at.clock.T],
    stopped: message !== "", ...pulls(run, data), pending: balance.length > 1, horizon: null, horizon_motion: null, horizon_curve: "",
    contact_count: data.contacts ? count("contact") : null, impact_count: count("impact"),
    fewest_steps: data.contacts && fewest < Infinity ? fewest : null, few: told.limits.FEW, poor: told.limits.POOR,
    gaps, singular: passed(run, data).map(({ t }) => t), unread: [], contacts: [], lock: lockOfRun(run, data),
    nonunique: lost ? told.nonunique : [], notes: [],
  };
  const read = new ReadCurves({ ...result, trust }, told);
  trust.unread = read.unread;
  trust.contacts = contactLines(read, events, told);
  trust.notes = notesOf(run, data, p, result, trust, message, grips);
  return trusted(trust, told.sentences.trust);
}

function energyShareOf(run, data) {
  const { audit } = run.m.arrays, seen = (name) => audit.data[data.at.audit[name]];
  const exchanged = Math.max(seen("MOST_KINETIC"), seen("MOST_WORK"), seen("MOST_POTENTIAL") - seen("LEAST_POTENTIAL")) + data.limit * seen("FLOOR");
  return exchanged > 0 ? seen("MOST_UNREST") / exchanged : 0;
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

/** Whether a run has ended beside a singular position: what its peaks were before is in `peaks_aside`. */
export function endsBeside({ m }, { at: { passage: P }, told: { limits } }) {
  const { data, shape } = m.arrays.passage;
  return shape[0] > 0 && (data[P.NEARBY] === limits.PASSED || data[P.CLOSEST_ROOT] < limits.SINGULAR);
}

/** Singular positions that were passed: when, and from when to when forces are left out [s]. */
export function passed(run, data) {
  const { m } = run, { passage, passages: rows } = m.arrays, P = data.at.passage, count = passage.shape[0] ? passage.data[P.PASSED] : 0;
  const read = (k) => {
    const row = m.row(rows, k).data;
    return { t: row[P.PASSED_AT], since: row[P.PASSED_FROM], until: row[P.PASSED_UNTIL] };
  };
  const every = Array.from({ length: Math.min(count, rows.shape[0]) }, (_, k) => read(k));
  if (!endsBeside(run, data)) return every;
  const counted = passage.data[P.NEARBY] === data.told.limits.PASSED;
  if (!counted && count < rows.shape[0]) every.push({ ...read(count), since: passage.data[P.NEAR_SINCE] });
  if (count - (counted ? 1 : 0) < rows.shape[0]) every.at(-1).until = run.t;
  return every;
}

// how near friction has come to locking a contact: least share of its response, when, and its joint
function nearestLock(run, { told, at: { held: H } }) {
  const { held } = run.m.arrays;
  if (told.method.loop !== told.loops.by_events || !held.data.length) return null;
  const [share, t, contact] = [H.LOCK_SHARE, H.LOCK_AT, H.LOCK_CONTACT].map((column) => held.data[column]);
  return share > 0 ? { share, t, joint: run.owners[contact] } : null;
}

function lockOfRun(run, data) {
  const nearest = nearestLock(run, data);
  return nearest && nearest.share < data.told.limits.LEAST_SAID ? { joint: nearest.joint, t: nearest.t } : null;
}

// ---------------------------------------------------------------- contacts, joint by joint: results/contact_summary.py
const quantity = (x, unit, digits = 4) => `${general(x, digits)} ${unit}`;

function contactLines(read, events, { rigid, joints, limits, sentences: { joint: words } }) {
  const lines = [], forces = new Map(read.touching);
  for (const joint of read.t.length ? rigid : []) {
    const force = forces.get(joint), said = [];
    if (!force) continue;
    const own = events.filter((event) => event.joint === joint), hits = own.filter(({ kind }) => kind === "impact");
    const hardest = hits.reduce((most, hit) => (most && most.impulse >= hit.impulse ? most : hit), null);
    if (hardest) said.push(fill(words.impulse, { impulse: quantity(hardest.impulse, "N*s", 3), t: quantity(hardest.t, "s") }));
    if (!read.readable(force)) said.push(words.towers);
    else {
      const [pressing] = read.peaks[`${joint}.pressing`] ?? read.peaks[force] ?? [Math.max(...read.columns[force])];
      const most = Math.max(pressing, ...own.filter(({ kind }) => kind === "contact").map((event) => event.peak_force));
      if (most > 0) said.push(fill(words.lasting, { force: quantity(most, "N") }));
    }
    if (said.length) lines.push(`${joint}: ${said.join("; ")}`);
  }
  for (const joint of read.t.length ? joints : []) {
    if (!read.has(`${joint}.locked`)) continue;
    const often = limits.OFTEN.map(([word, kind]) => [word, events.filter((event) => event.joint === joint && event.kind === kind).length]);
    const counts = often.filter(([, n]) => n).map(([word, n]) => `${word} ${n} time${n > 1 ? "s" : ""}`), [torque, when] = read.peak(`${joint}.torque`);
    const most = torque ? fill(words.torque, { torque: quantity(torque, "N*m"), t: quantity(when, "s") }) : words.no_torque;
    lines.push(`${joint}: ${[...counts, most].join(", ")}`);
  }
  return lines;
}

// ---------------------------------------------------------------- notes, in their order
function notesOf(run, data, p, result, trust, message, grips) {
  const { told } = data, { sentences: said, limits } = told, tally = (name) => Number(run.m.arrays.tally.data[data.at.tally[name]]);
  const asWritten = data.values.every((value, k) => value === p[k]), written = (note) => (asWritten ? note : told.written + note);
  const singular = singularNote(run, data);
  if (!singular.length && tally("LOST_ROWS")) singular.push(...(told.nonunique.length ? told.friction_note : [said.report.lost_rank]));
  const series = tally("SERIES"), counted = fill(series === 1 ? said.report.one_series : said.report.more_series, { count: series });
  const held = told.dry.filter((_, k) => run.m.row(run.m.arrays.dry_memory, k).data[data.at.dry_memory.DRY_UNSURE] === 1);
  return [
    ...data.notes.map(written), ...singular, ...told.choice, ...told.unused.map(written), ...gains(result, told), ...laws(result, told, written),
    ...oilNotes(result, told, written), ...joltNotes(run, data), ...unresolved(run, data),
    ...(run.kept > run.N.MOST_NUMBERS ? [said.report.many_breaks] : []),
    ...peakNotes(run, data, trust), ...(message ? [] : remarks(run, data, trust)),
    ...(told.method.adaptive && run.rtol > data.loose ? [fill(said.sound.loose, { rtol: run.rtol })] : []),
    ...swiftLinks(run, data, result), ...told.doubts.map(written), ...slips(data, result, grips),
    ...(series ? [fill(said.report.series, { count: counted, low: limits.LOW })] : []),
    ...(held.length ? [fill(said.report.held_friction, { joints: held.join(", ") })] : []),
    ...leftEnds(run, data), ...ofContacts(run, data),
  ];
}

// corners that have passed the end of their segment
function leftEnds(run, data) {
  const left = (n) => run.m.row(run.m.arrays.contact_memory, n).data[data.at.contact_memory.LEFT_END] === 1;
  const names = run.labels.flatMap((label, n) => (n < data.contacts && label && left(n) && data.told.cornered.includes(run.owners[n]) ? [run.owners[n]] : []));
  return names.length ? [fill(data.told.sentences.report.left_ends, { joints: [...new Set(names)].join(", ") })] : [];
}

function singularNote(run, data) {
  const every = passed(run, data), { sentences: { passage: said }, limits } = data.told;
  if (!every.length) return [];
  if (every.some(({ since, until }) => since <= run.start && until >= run.t)) return [said.throughout];
  const widest = every.reduce((most, one) => (one.until - one.since > most.until - most.since ? one : most));
  if (every.length === 1) return [fill(said.passes, { t: widest.t, lose: "", span: spanOf(widest.since, widest.until) })];
  const times = every.slice(0, limits.NAMED).map(({ t }) => general(t, 4)).join(", ");
  const more = every.length > limits.NAMED ? ` and ${every.length - limits.NAMED} more times` : "";
  return [fill(said.passes_many, { count: every.length, times, more, lose: "", half: 500 * (widest.until - widest.since) })];
}

function spanOf(since, until) {
  let digits = 4;
  while (digits < 12 && general(since, digits) === general(until, digits)) digits++;
  return `${general(since, digits)} to ${general(until, digits)} s`;
}

// energy that impacts created, each with all its contacts
function gains({ events, columns }, { limits, sentences }) {
  const sums = new Map(), energy = columns["energy.kinetic"].reduce((most, x) => Math.max(most, x), 0);
  for (const { kind, t, energy_lost, impulse, normal_speed } of events) {
    if (kind !== "impact") continue;
    const { gain, least } = sums.get(t) ?? { gain: 0, least: 0 };
    sums.set(t, { gain: gain - energy_lost, least: least + 1e-9 * (impulse * normal_speed) + 1e-9 * Math.abs(energy_lost) });
  }
  const created = [...sums.values()].filter(({ gain, least }) => gain > Math.max(least, limits.GAIN * energy)).map(({ gain }) => gain);
  if (!created.length) return [];
  const impacts = `${created.length} impact${created.length > 1 ? "s" : ""}`;
  return [fill(sentences.event.gains, { impacts, gain: created.reduce((sum, x) => sum + x, 0) })];
}

function laws({ events }, told, written) {
  return told.laws.flatMap((law) => {
    if (typeof law === "string") return [written(law)];
    const force = events.reduce((most, event) => (event.joint === law.joint ? Math.max(most, event.peak_force) : most), 0);
    return force > law.limit ? [fill(law.sentence, { force, limit: law.limit })] : [];
  });
}

function oilNotes({ t, columns }, { oil, sentences: { oil: said }, limits }, written) {
  return Object.entries(oil).flatMap(([joint, film]) => {
    const notes = film.notes.map(written), thickness = columns[`${joint}.film_thickness`], pressure = columns[`${joint}.film_pressure`];
    if (!t.length || !thickness) return notes;
    const thin = thickness.filter((x) => x < film.boundary).length / t.length, high = largestOf(pressure);
    if (thin > 0) notes.push(fill(said.thin, { joint, boundary: 1e6 * film.boundary, percent: 100 * thin }));
    if (high > limits.HARD) notes.push(fill(said.hard, { joint, pressure: 1e-6 * high }));
    const [a, b] = film.bodies.map((body) => columns[`${body}.omega`]), rate = (turning, k) => (turning ? turning[k] : 0);
    const mean = largestOf(t.map((_, k) => Math.abs(rate(a, k) + rate(b, k)))) / 2, relative = largestOf(t.map((_, k) => Math.abs(rate(b, k) - rate(a, k))));
    const over = (film.density * film.clearance) / film.viscosity, reynolds = over * relative * film.radius, reduced = over * mean * film.clearance;
    if (reynolds > limits.VORTICES * Math.sqrt(film.radius / film.clearance)) notes.push(fill(said.vortices, { joint, rate: relative, reynolds }));
    else if (reduced > limits.INERTIA) notes.push(fill(said.inertia, { joint, rate: mean, reduced }));
    return notes;
  });
}

const largestOf = (values) => values.reduce((most, x) => Math.max(most, x), 0);

function joltNotes(run, data) {
  const { sentences: { jolt: said }, limits, units } = data.told, every = joltsOf(run, data), notes = [];
  for (const driver of new Set(every.map((jolt) => jolt.driver))) {
    const own = every.filter((jolt) => jolt.driver === driver), many = own.length > limits.JOLTS;
    for (const jolt of many ? own.slice(0, 1) : own) {
      const [, rate, unit] = units[jolt.unit];
      notes.push(fill(said.jolt, { ...jolt, rate, unit }));
    }
    if (many) notes.push(fill(said.jolts, { driver, count: own.length, work: own.reduce((sum, { work }) => sum + work, 0) }));
  }
  return notes;
}

/** The jumps of drivers that were passed: t, driver, size, unit, impulse and work. */
export function joltsOf(run, data) {
  const { driver_jump: jumps } = run.m.arrays, J = data.at.driver_jump;
  return run.jolts.map((_, k) => {
    const row = run.m.row(jumps, k).data, { name: driver, unit } = data.told.drivers[row[J.JUMP_DRIVER]];
    return { t: row[J.JUMP_AT], driver, size: row[J.JUMP_SIZE], unit, impulse: row[J.JUMP_IMPULSE], work: row[J.JUMP_WORK] };
  });
}

/** What is said of drivers that jump in position, where a run is refused: analyses/timetable.py. */
export function leapsOf({ m }, { at: { driver_leap: L }, told: { drivers, sentences } }) {
  return Array.from({ length: m.arrays.driver_leap.shape[0] }, (_, d) => d).flatMap((d) => {
    const row = m.row(m.arrays.driver_leap, d).data, { name: driver, unit } = drivers[d], count = row[L.LEAP_COUNT];
    const more = count > 1 ? ` (and ${count - 1} more times)` : "";
    return count ? [fill(sentences.jolt.leap, { driver, unit, size: row[L.LEAP_SIZE], t: row[L.LEAP_AT], more })] : [];
  });
}

// expressions with too many instants to follow
function unresolved({ m }, { at: { timed: T }, told: { timed, sentences } }) {
  const lost = timed.filter((_, k) => Number(m.row(m.arrays.timed, k).data[T.RESOLVED]) === 0);
  return [...new Set(lost)].map((name) => fill(sentences.jolt.unresolved, { name }));
}

function peakNotes(run, data, { impact_count: impacts }) {
  const { sentences: { lock: said, peaks }, limits, method, loops } = data.told, nearest = nearestLock(run, data);
  if (method.loop === loops.equal_steps) return [fill(peaks.steps, { method: method.title, more: impacts ? peaks.impacts : "" })];
  if (!nearest || nearest.share >= limits.NEARLY_LOCKED) return [];
  const { share, t, joint } = nearest, told = share > limits.LEAST_SAID;
  const near = told ? fill(said.near, { percent: 100 * share }) : fill(said.nearer, { percent: 100 * limits.LEAST_SAID });
  return [fill(said.nearly_locked, { joint, near, t, grows: told ? fill(said.grows, { times: 1 / share }) : said.unbound })];
}

function remarks(run, data, { drift, drift_angle, energy_share: share }) {
  const { sentences: { sound: said }, limits, method } = data.told, shorter = limits.SHORTER[method.adaptive ? 1 : 0];
  const { course, audit } = run.m.arrays, opened = Math.max(drift / course.data[data.at.course.EXTENT], drift_angle), sunk = audit.data[data.at.audit.SUNK];
  return [
    ...(opened > limits.SAID ? [fill(said.opened, { share: opened, shorter })] : []),
    ...(sunk > limits.SUNK ? [fill(said.sunk, { percent: 100 * sunk, method: method.title })] : []),
    ...(share > limits.SAID ? [fill(method.title ? said.energy_of_method : said.energy, { share, method: method.title, shorter })] : []),
  ];
}

// massless links that turn incredibly fast for their mechanism
function swiftLinks(run, data, { t, columns }) {
  const { links, drivers, bodies, limits, sentences: { sound: said } } = data.told, { m } = run;
  if (!t.length || !data.watched.length) return [];
  const { code, timed, switchings } = m.arrays, T = data.at.timed, held = m.arrays.state.data.slice(), kept = code.data.slice();
  for (let k = 0; k < timed.shape[0]; k++) {
    const row = m.row(timed, k).data, first = m.row(switchings, Number(row[T.FIRST_FOUND])).data;
    code.data[Number(row[T.OWN_CODE]) * code.shape[1] + data.told.side] = BigInt(first[data.at.switchings.SIDE_AFTER]);
  }
  m.call("record", run.start, m.arrays.state, m.row(m.shaken, 0)); // the rates of drivers at the start
  code.data.set(kept);
  const extent = m.arrays.course.data[data.at.course.EXTENT], rates = drivers.map(({ slot, unit }) => Math.abs(m.arrays.values.data[slot + 1]) / (unit === "rad" ? 1 : extent));
  m.arrays.state.data.set(held);
  const driven = Math.max(0, ...rates), usual = driven || Math.max(...bodies.map((body) => Math.abs(columns[`${body}.omega`][0])));
  return data.watched.flatMap((joint) => {
    const { clearance, ends } = links[joint], x = columns[`${joint}.ex`], y = columns[`${joint}.ey`];
    let rate = 0;
    t.forEach((_, k) => {
      const [[ax, ay], [bx, by]] = ends.map((end) => pointRate(columns, end, k));
      rate = Math.max(rate, Math.abs(x[k] * (by - ay) - y[k] * (bx - ax)) / clearance ** 2);
    });
    const what = driven ? limits.ITS_DRIVER : limits.FASTEST_BODY;
    return rate > limits.SWIFT * usual && usual > 0 ? [fill(said.swift, { joint, rate, times: rate / usual, what })] : [];
  });
}

// belts that no friction would hold: analyses/grip.py
function slips({ belts, told: { limits, sentences: { grip: said } } }, { t, columns }, grips) {
  return belts.flatMap(({ joint, columns: names, source }, b) => {
    if (!names.every((name) => columns[name])) return [];
    const [tight, slack] = names.map((name) => columns[name].map((x) => Math.max(x, 0))), most = largestOf(tight);
    const ratio = (k) => (slack[k] > 0 ? tight[k] / slack[k] : Infinity), over = [];
    t.forEach((_, k) => { if (tight[k] > limits.CARRIES * most && tight[k] > slack[k] * grips[k][3 * b]) over.push(k); });
    if (!over.length) return [];
    const k = over.reduce((worst, row) => (ratio(row) > ratio(worst) ? row : worst)), [holds, wrap, mu] = grips[k].subarray(3 * b);
    const many = ratio(k) < Infinity ? general(ratio(k), 3) : said.hangs, first = t[over[0]];
    return [fill(said.slips, { joint, first, tight: tight[k], slack: slack[k], ratio: many, t: t[k], holds, mu, source, wrap: (180 * wrap) / Math.PI })];
  });
}

function pointRate(columns, [body, px, py], k) {
  if (body === "ground") return [0, 0];
  const [angle, omega, vx, vy] = ["angle", "omega", "vx", "vy"].map((key) => columns[`${body}.${key}`][k]);
  const x = Math.cos(angle) * px - Math.sin(angle) * py, y = Math.sin(angle) * px + Math.cos(angle) * py;
  return [vx - omega * y, vy + omega * x];
}

// contacts whose forces the motion does not determine, and jams that were passed
function ofContacts(run, data) {
  const { method, loops, clutches, sentences: { shared, lock } } = data.told, { arrays } = run.m, C = data.at.course;
  if (method.loop !== loops.by_events && method.loop !== loops.equal_steps) return [];
  const unsure = (n) => run.m.row(arrays.contact_memory, n).data[data.at.contact_memory.UNSURE];
  const among = (clutch, which) => [...new Set(clutches.flatMap((is, n) => (is === clutch && which(unsure(n)) ? [`'${run.owners[n]}'`] : [])))].join(", ");
  const notes = [[shared.torque, among(true, (doubt) => doubt > 0)], [shared.force, among(false, (doubt) => doubt === 1)], [shared.free, among(false, (doubt) => doubt === 2)]].filter(([, joints]) => joints).map(([sentence, joints]) => fill(sentence, { joints }));
  const jams = method.loop === loops.by_events ? arrays.course.data[C.JAMS] : 0;
  if (!jams) return notes;
  const names = clutches.flatMap((_, n) => (Number(arrays.jammed.data[n]) === 1 ? [`'${run.owners[n]}'`] : []));
  const number = jams > 1 ? `${jams} impacts` : "1 impact";
  return [...notes, fill(lock.jams, { number, t: arrays.course.data[C.FIRST_JAM], joints: [...new Set(names)].join(", ") })];
}
