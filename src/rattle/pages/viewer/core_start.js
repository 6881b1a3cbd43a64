// The start of a mechanism for other parameters, by the compiled kernels: what `rattle.analyses.assembly` does near a
// start that is known.  data: `rattle.pages.start_data`, { description, content }; functions: of its tape, by their numbers.

import { CoreMemory } from "./core.js";

const PARTS = [1, 8, 32, 128]; // equal parts of the way from the model's own parameters, the next where one fails
const FAR = 0.1; // rotation of a body that pins pressed on their bushes may cause [rad]
const ALONG = 1e-12, NEAR = 1e-9; // sizes of the mechanism: to which Newton's method goes, by which given values are kept

/** Starts of one mechanism: `find(p)`, with all parameters [SI] in the order of `description.parameters`. */
export class StartFinder {
  constructor(engine, { description, content }, functions) {
    Object.assign(this, { own: description.own, parameters: description.parameters });
    this.start = new Start(engine, content, description.start, functions);
  }

  /** { q, v, constants, size, error }: positions, rates and what the start sets; error: null, or why in words. */
  find(p) {
    let first = null;
    for (const parts of PARTS) {
      this.start.begin();
      let found;
      for (let k = 1; k <= parts && !found?.error; k++) {
        found = this.start.near(k === parts ? p : this.own.map((x, n) => x + ((p[n] - x) * k) / parts));
        if (!found.error) this.start.goOnFrom(found);
      }
      if (!found.error) return { ...found, error: this.start.outside(found) };
      first ??= found;
      if (found.final) break;
    }
    return { q: null, v: null, constants: null, error: first.error };
  }
}

// ---------------------------------------------------------------- one system in its memory
class Part {
  constructor(engine, content, made, functions) {
    const [m] = CoreMemory.together(engine, [{ description: made.image, content }]), { memory, end } = m.room, { free } = engine.about;
    Object.assign(this, made, { m, numbers: functions[made.function] });
    this.out = new Float64Array(1 + made.counts.length);
    this.own = null; // its numbers for the model's own parameters, when they are asked for
    this.memory = () => new Uint8Array(memory.buffer, free, end - free);
    this.image = this.memory().slice();
  }

  begin() { this.memory().set(this.image); }

  /** Enter the numbers that follow from inputs; false where the model has another form. */
  enter(inputs) {
    const { m, out } = this, values = out.subarray(1);
    if (!this.own) {
      this.numbers(Float64Array.from(this.inputs), out);
      this.own = values.slice();
    }
    this.numbers(inputs, out);
    if (out[0] !== 1 || values.some((x) => !Number.isFinite(x))) return false;
    let n = 0;
    for (const [name, where] of this.entries) for (const k of where) m.arrays[name].data[k] = values[n++];
    for (const [name, k] of this.facts) {
      if (k < 0) this[name] = values[n++]; // the size of the mechanism, settings of a run
      else m[name].data[k] = values[n++] + (name === "given" ? m.turns.data[k] : 0);
    }
    this.same = this.own.every((x, k) => !this.counts[k] || Object.is(x, values[k]));
    return true;
  }
}

// ---------------------------------------------------------------- a start, and those before it
class Start {
  constructor(engine, content, made, functions) {
    const part = (one) => one && new Part(engine, content, one.system, functions);
    const start = (one) => one && new Start(engine, content, one, functions);
    Object.assign(this, made, { N: engine.about.numbers, main: part(made), ideal: start(made.ideal), loose: start(made.loose) });
    Object.assign(this, { shut: made.holds.map(part), counts: part(made.counting) });
    this.main.size = made.size;
    this.ownStart = { q: Float64Array.from(made.q), v: Float64Array.from(made.v), constants: Float64Array.from(made.constants) };
  }

  begin() {
    for (const one of [this.main, ...this.shut, this.counts, this.ideal, this.loose]) one?.begin();
    this.main.size = this.size;
    this.from = this.ownStart.q;
  }

  goOnFrom({ q, inner }) {
    this.from = q;
    if (this.ideal) this.ideal.goOnFrom(inner.ideal);
    if (this.loose) this.loose.goOnFrom(inner.loose);
  }

  near(p) {
    const { main, ownStart } = this, inner = { ideal: null, loose: null };
    let { constants } = ownStart;
    if (this.loose) {
      inner.loose = this.loose.near(p);
      if (inner.loose.error) return inner.loose;
      if (!inner.loose.same) constants = this.count(p, inner.loose.q);
    }
    const inputs = Float64Array.from([...p, ...(constants ?? [])]);
    if (!constants || !main.enter(inputs) || !this.shut.every((one) => one.enter(inputs)))
      return { error: "with these parameters the mechanism has another form", final: true };
    if (this.ideal) {
      inner.ideal = this.ideal.near(p);
      if (inner.ideal.error) return inner.ideal;
    }
    if (main.same && [inner.ideal, inner.loose].every((one) => one?.same ?? true) && this.shut.every((one) => one.same))
      return { ...ownStart, inner, same: true, error: null };
    const error = this.place(inner.ideal) ?? this.farther() ?? this.move(inner.ideal);
    return { q: main.m.q.data.slice(), v: main.m.v.data.slice(), constants, inner, same: false, error };
  }

  // ---------------------------------------------------------------- positions
  place(ideal) {
    const { main: { m, size }, N } = this, { q, given } = m;
    if (!ideal) {
      q.data.set(this.from);
      const became = m.call("start.near", 0, q, given, size, m.scratch);
      return became === N.MOVED ? null : this.words(became);
    }
    if (!this.held.length || !this.hold(ideal, 0)) {
      if (this.held.length && !this.missing.length) return this.words(N.NOT_CLOSED);
      q.data.set(ideal.q);
      m.call("start.place", q, given, m.offsets, m.lines, m.ways);
      if (!this.close()) return this.words(N.NOT_CLOSED);
    }
    if (this.missing.length) this.keepPlaces();
    if (this.keeps) this.unlessOutside(() => m.call("start.keep", 0, q, given, size) === N.MOVED);
    if (this.shut.length > (this.held.length ? 1 : 0) && this.isOutside()) {
      const before = q.data.slice(); // given values are too rough for the play: all pins where they are without it
      if (!this.hold(ideal, this.shut.length - 1) || this.isOutside()) q.data.set(before);
    }
    return null;
  }

  isOutside() {
    const { m } = this.main;
    return m.call("start.outside", 0, m.q, m.v, m.least) >= 0;
  }

  close() {
    const { main: { m, size }, N } = this;
    return m.call("start.close", 0, m.q, m.row(m.scratch, 0), ALONG * size, N.ITERATIONS) <= N.SHUT * size;
  }

  // pins at their offsets, given or along the reactions without play, with their joints closed
  hold(ideal, number) {
    const { main: { m, size }, N, missing, every } = this, { m: shut } = this.shut[number], { which } = this.holds[number];
    const offsets = m.held.data.slice();
    if (missing.length) {
      const { m: at } = this.ideal.main;
      at.q.data.set(ideal.q);
      at.v.data.set(ideal.v);
      missing.forEach((_, k) => { at.pressed.data[3 * k] = m.clearances.data[k]; });
      at.call("start.press", 0, at.q, at.v, at.first, at.pressed);
      missing.forEach((name, k) => offsets.set(at.pressed.data.subarray(3 * k + 1, 3 * k + 3), 4 * every.indexOf(name) + 2));
    }
    which.forEach((n, k) => shut.shifts.data.set(offsets.subarray(4 * n, 4 * n + 4), 4 * k));
    shut.q.data.set(ideal.q);
    shut.given.data.set(m.given.data);
    if (shut.call("start.hold", 0, shut.q, shut.given, size, shut.pins, shut.shifts, 1, shut.scratch) !== N.MOVED) return false;
    m.q.data.set(shut.q.data);
    return this.close() && !(missing.length && m.q.data.some((x, k) => k % 3 === 2 && Math.abs(x - ideal.q[k]) > FAR));
  }

  // given places of bodies, if the mechanism closes with them: on which side of its bush a pin stands
  keepPlaces() {
    const { main: { m, size } } = this, { q, given } = m;
    const off = (k) => Math.abs(q.data[k] - given.data[k]) > NEAR * size;
    if (!q.data.some((_, k) => k % 3 < 2 && off(k))) return;
    this.unlessOutside(() => {
      given.data.forEach((x, k) => { if (!Number.isNaN(x)) q.data[k] = x; });
      if (!this.close()) return false;
      m.call("start.keep", 0, q, given, size);
      return !q.data.some((_, k) => off(k));
    });
  }

  // what changes q, unless it fails or a pin is then outside its bush
  unlessOutside(change) {
    const { q } = this.main.m, before = q.data.slice();
    if (!change() || this.isOutside()) q.data.set(before);
  }

  farther() {
    const { main: { m, size }, N } = this;
    const far = m.q.data.some((x, k) => !(Math.abs(x - this.from[k]) <= N.BESIDE * (k % 3 === 2 ? 1 : size)));
    return far ? this.words(N.TOO_FAR) : null;
  }

  // ---------------------------------------------------------------- rates, constants, words
  move(ideal) {
    const { main: { m, size }, N } = this;
    if (ideal) m.v.data.set(ideal.v);
    else m.v.data.fill(0);
    const became = m.call("start.rates", 0, m.q, m.v, m.rates, size, m.ways);
    return became === N.NOT_FINITE ? this.words(became) : null;
  }

  // constants with which rows that count from the start vanish there; null where the form is another
  count(p, q) {
    const { counts, N } = this, { m } = counts, { data: rows, shape: [, width] } = m.arrays.rows;
    if (!counts.enter(Float64Array.from([...p, ...this.ownStart.constants.map(() => 0)]))) return null;
    m.q.data.set(q);
    m.call("start.open", 0, m.q, m.v);
    return this.counting.joints.flatMap((joint) => {
      const residuals = Array.from({ length: joint.rows }, (_, k) => rows[(joint.row + k) * width + N.RES]);
      if (!joint.polar) return residuals;
      const [a, b] = joint.ends.map((body, k) => this.point(m, body, joint.values + 2 * k)), d = [b[0] - a[0], b[1] - a[1]];
      return [residuals[0], Math.hypot(...d), Math.atan2(d[1], d[0]), 0];
    });
  }

  point(m, body, place) {
    const [x, y, angle] = body ? m.q.data.subarray(3 * body - 3, 3 * body) : [0, 0, 0];
    const [c, s, px, py] = [Math.cos(angle), Math.sin(angle), ...m.arrays.values.data.subarray(place, place + 2)];
    return [x + c * px - s * py, y + s * px + c * py];
  }

  words(became) {
    const { N, rows, main: { m } } = this, { data, shape: [, width] } = m.arrays.rows;
    if (became === N.TOO_FAR) return "these parameters lead to another position of the mechanism, which is not looked for here";
    if (became === N.NOT_FINITE) return "with these parameters numbers of the mechanism are too large or have no value";
    const gaps = rows.map((_, k) => Math.abs(data[k * width + N.RES])), k = gaps.indexOf(Math.max(...gaps));
    const what = rows[k] ? `${rows[k][2] ? "driver" : "joint"} '${rows[k][0]}' stays open by ${gaps[k].toPrecision(3)} ${rows[k][1]}` : "pins do not fit";
    return `the mechanism cannot be put together with these parameters, beside its own position: ${what}`;
  }

  outside({ q, v }) {
    const { m } = this.main;
    m.q.data.set(q);
    m.v.data.set(v);
    const n = m.call("start.outside", 0, m.q, m.v, m.least);
    if (n < 0) return null;
    const { data, shape: [, width] } = m.arrays.contact_kinematics, gap = data[n * width + this.N.GAP] - Math.max(m.least.data[n], -1);
    return `with these parameters joint '${this.contacts[n]}' starts ${Math.abs(gap).toPrecision(3)} outside its play`;
  }
}
