// Runs: numbers unpacked from a scene, curves by name, and places of bodies at any time.

import { derivedRules } from "./derived.js";

const TICKS = 2 ** 32 - 1; // parts of a run in which the instants of single values are counted
const GROUND = { x: 0, y: 0, angle: 0, cos: 1, sin: 0 };

// The bytes that a text in base64 stands for.
export function bytesOf(text) {
  const raw = atob(text);
  const bytes = new Uint8Array(raw.length);
  for (let k = 0; k < raw.length; k++) bytes[k] = raw.charCodeAt(k);
  return bytes.buffer;
}

// A run of a scene with its numbers as arrays; one that is unpacked already comes back as it is.
export function unpack(run) {
  if (run.columns) return run;
  const t = new Float64Array(bytesOf(run.t)), data = new Float32Array(bytesOf(run.data));
  const columns = {}, units = {};
  run.names.forEach((name, k) => {
    columns[name] = data.subarray(k * run.n, (k + 1) * run.n);
    units[name] = run.units[k];
  });
  const { data: _, ...rest } = run, span = (t[run.n - 1] - t[0]) / TICKS;
  const between = Object.fromEntries(Object.entries(run.between ?? {}).map(([name, [at, y]]) =>
    [name, { t: Float64Array.from(new Uint32Array(bytesOf(at)), (k) => t[0] + k * span), y: new Float32Array(bytesOf(y)) }]));
  return { ...rest, t, columns, units, between };
}

// The last k with t[k] <= time, of increasing t.
export function before(t, time) {
  let low = 0, high = t.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (t[middle] <= time) low = middle;
    else high = middle;
  }
  return time >= t[high] ? high : low;
}

export const EVENT = ["t", "joint", "kind", "speed", "duration", "force", "impulse", "lost", "contact"];

// One run that is shown: its curves, derived ones too, and where it is in time.
export class Motion {
  constructor(run, scene) {
    this.run = unpack(run);
    this.t = this.run.t;
    this.n = this.t.length;
    this.geometry = this.run.geometry ?? scene.geometry;
    this.label = this.run.label ?? "";
    this.trust = this.run.trust ?? { text: [] };
    const stored = this.run.names.filter((name) => this.run.columns[name]);
    this.rules = derivedRules(scene.derived, this.geometry, new Set(stored));
    this.names = [...stored, ...this.rules.keys()];
    this.made = new Map();
    this.lines = new Map();
    this.paths = new Map();
    this.events = (this.run.events ?? []).map((one) =>
      Array.isArray(one) ? Object.fromEntries(EVENT.map((key, k) => [key, one[k]])) : one);
  }

  get start() { return this.n ? this.t[0] : 0; }
  get end() { return this.n ? this.t[this.n - 1] : 0; }
  get span() { return this.end - this.start; }
  get horizon() {
    const one = this.trust.horizon;
    return typeof one === "number" && one < this.end ? one : null;
  }

  has(name) { return Boolean(this.run.columns[name]) || this.rules.has(name); }

  unit(name) { return this.rules.get(name)?.unit ?? this.run.units[name] ?? ""; }

  // One curve (n,) in its SI unit; an unknown name is an error that names near ones.
  curve(name) {
    const stored = this.run.columns[name] ?? this.made.get(name);
    if (stored) return stored;
    const rule = this.rules.get(name);
    if (!rule) {
      const near = this.names.filter((one) => one.split(".")[0] === String(name).split(".")[0]).slice(0, 6);
      throw new Error(`this motion has no curve ${name}${near.length ? `; there are ${near.join(", ")}` : ""}`);
    }
    this.made.set(name, rule.make((one) => this.curve(one), this.n));
    return this.made.get(name);
  }

  // All that is known of a curve, {t, y}: the instants that it shares with the others, and its own between them.
  line(name) {
    const own = this.run.between?.[name], y = this.curve(name), { t } = this;
    if (!own) return { t, y };
    if (!this.lines.has(name)) {
      const n = t.length + own.t.length, line = { t: new Float64Array(n), y: new Float64Array(n) };
      for (let i = 0, k = 0; i + k < n;) {
        const shared = k === own.t.length || (i < t.length && t[i] <= own.t[k]), m = i + k;
        line.t[m] = shared ? t[i] : own.t[k];
        line.y[m] = shared ? y[i++] : own.y[k++];
      }
      this.lines.set(name, line);
    }
    return this.lines.get(name);
  }

  // The largest magnitude of a curve within the steps of the run, {t, y}; null where it was not looked for.
  peak(name) {
    const [y, t] = this.run.peaks?.[name] ?? [];
    return Number.isFinite(y) && t >= this.start && t <= this.end ? { t, y } : null;
  }

  // Contacts too short to be seen between two outputs, of a curve of normal forces: the force that each reaches, {t, y}.
  bursts(name) {
    if (!name.endsWith(".normal")) return [];
    const joint = name.slice(0, -".normal".length), interval = 2 * this.span / Math.max(1, this.n - 1);
    return this.events.filter((event) => event.joint === joint && event.kind === "contact" && event.force > 0 && event.duration < interval)
      .map((event) => ({ t: event.t + 0.5 * event.duration, y: event.force }));
  }

  // The row k at or before a time, and how far from there to the next row, 0 to 1.
  row(time) {
    const { t, n } = this;
    if (!(time > t[0])) return { k: 0, f: 0 };
    if (time >= t[n - 1]) return { k: n - 1, f: 0 };
    const k = before(t, time), f = (time - t[k]) / (t[k + 1] - t[k]);
    return f < 1e-9 ? { k, f: 0 } : { k, f };
  }

  // A curve at a time, linear between rows.
  value(name, time, row = this.row(time)) {
    const y = this.curve(name);
    return row.f === 0 ? y[row.k] : y[row.k] + row.f * (y[row.k + 1] - y[row.k]);
  }

  // Largest magnitude of a curve, within the steps where it is known, without what is not a number.
  largest(name) {
    let most = Math.abs(this.peak(name)?.y ?? 0);
    for (const value of this.line(name).y) if (Number.isFinite(value) && Math.abs(value) > most) most = Math.abs(value);
    return most;
  }

  // Places of all bodies at a time: {body: {x, y, angle, cos, sin}}, the ground too.
  pose(time) {
    const row = this.row(time);
    const places = { ground: GROUND };
    for (const body of Object.keys(this.geometry.bodies)) {
      if (!this.has(`${body}.x`)) continue;
      const x = this.value(`${body}.x`, time, row), y = this.value(`${body}.y`, time, row);
      const angle = this.value(`${body}.angle`, time, row);
      places[body] = { x, y, angle, cos: Math.cos(angle), sin: Math.sin(angle) };
    }
    return places;
  }

  // Path of a pin in its bush {x, y, normal}, so many pieces between rows: on a massless link with the arcs between them.
  pinPath(joint) {
    if (!this.paths.has(joint)) this.paths.set(joint, pinPath(this, joint));
    return this.paths.get(joint);
  }

  // Where a pin is at a time, and the last point of its path before.
  pinAt(joint, time) {
    const path = this.pinPath(joint), { k, f } = this.row(time), place = path.pieces * (k + f), n = Math.min(path.x.length - 1, Math.floor(place));
    const g = place - n, next = Math.min(path.x.length - 1, n + 1);
    return { x: path.x[n] + g * (path.x[next] - path.x[n]), y: path.y[n] + g * (path.y[next] - path.y[n]), n };
  }
}

function pinPath(motion, joint) {
  const x = motion.curve(`${joint}.ex`), y = motion.curve(`${joint}.ey`);
  const normal = motion.has(`${joint}.normal`) ? motion.curve(`${joint}.normal`) : new Float64Array(motion.n);
  if (motion.geometry.joints[joint].contact !== "massless-link" || motion.n < 2) return { x, y, normal, pieces: 1 };
  const pieces = 8, last = motion.n - 1, [fineX, fineY, fineNormal] = [x, y, normal].map(() => new Float64Array(pieces * last + 1));
  for (let n = 0; n <= pieces * last; n++) {
    const k = Math.min(last - 1, Math.floor(n / pieces)), f = n / pieces - k;
    const from = Math.atan2(y[k], x[k]), r = Math.hypot(x[k], y[k]), way = Math.atan2(y[k + 1], x[k + 1]) - from;
    const angle = from + f * (way - 2 * Math.PI * Math.round(way / (2 * Math.PI))), radius = r + f * (Math.hypot(x[k + 1], y[k + 1]) - r);
    fineX[n] = radius * Math.cos(angle);
    fineY[n] = radius * Math.sin(angle);
    fineNormal[n] = normal[k] + f * (normal[k + 1] - normal[k]);
  }
  return { x: fineX, y: fineY, normal: fineNormal, pieces };
}

// Where a point given in the frame of a body is, [x, y] in metres.
export function pointAt(pose, body, [px, py]) {
  const one = pose[body];
  return [one.x + one.cos * px - one.sin * py, one.y + one.sin * px + one.cos * py];
}

// Places of a named point ("coupler.P", or a body for its mass centre) as curves {x, y}; null if there are none.
export function pathOf(motion, name) {
  return motion.has(`${name}.x`) && motion.has(`${name}.y`)
    ? { x: motion.curve(`${name}.x`), y: motion.curve(`${name}.y`) } : null;
}

// All that has a path: mass centres, then named points.
export function pathNames(motion) {
  return motion.names.filter((name) => name.endsWith(".x") && motion.has(`${name.slice(0, -1)}y`)).map((name) => name.slice(0, -2));
}
