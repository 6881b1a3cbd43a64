// The start of a mechanism for other parameters: numbers are entered into the workspaces of the systems that it is put
// together from, and the kernel `find_start` of `rattle.equations.start` finds a start, as `Mechanism.set` does.
// data: `rattle.pages.start_data`, { description, content }; functions: of its tape, by their numbers.

import { CoreMemory } from "./core.js";

/** Starts of one mechanism: `find(p)`, with all parameters [SI] in the order of `description.parameters`. */
export class StartFinder {
  constructor(engine, { description: { own, parameters, systems, start }, content }, functions) {
    const every = CoreMemory.together(engine, systems.map(({ image }) => ({ description: image, content })));
    const parts = systems.map((made, k) => new Part(made, every[k], functions[made.function])), { room } = every[0];
    Object.assign(this, { own, parameters, start: new Start(start, parts, engine.about.numbers) });
    this.memory = new Uint8Array(room.memory.buffer, engine.about.free, room.end - engine.about.free);
    this.image = this.memory.slice();
  }

  /** { q, v, constants, error }: positions, rates and what the start sets; error: null, or why in words. */
  find(p) {
    this.memory.set(this.image);
    const { error } = this.start.find(p);
    return error ? { q: null, v: null, constants: null, error } : this.start.found();
  }
}

/** One system in its workspace. */
class Part {
  constructor(made, m, numbers) {
    Object.assign(this, made, { m, numbers, out: new Float64Array(1 + made.counts.length) });
    this.own = null; // its numbers for the model's own parameters, when they are asked for
  }

  /** Enter the numbers that follow from inputs; false where the model has another form. */
  enter(inputs) {
    const { m: { arrays }, out } = this, values = out.subarray(1);
    if (!this.own) {
      this.numbers(Float64Array.from(this.inputs), out);
      this.own = values.slice();
    }
    this.numbers(inputs, out);
    if (out[0] !== 1 || values.some((x) => !Number.isFinite(x))) return false;
    let n = 0;
    for (const [name, where] of this.entries) for (const k of where) arrays[name].data[k] = values[n++];
    this.same = this.own.every((x, k) => !this.counts[k] || Object.is(x, values[k]));
    return true;
  }
}

/** A start, and those that are found before it: without play, and without rows that count from the start. */
class Start {
  constructor(made, parts, N) {
    const start = (one) => one && new Start(one, parts, N), part = (k) => (k === null ? null : parts[k]);
    Object.assign(this, { ...made, N, main: parts[made.system], ideal: start(made.ideal), loose: start(made.loose) });
    Object.assign(this, { shut: part(made.shut), every: part(made.every), counting: part(made.counting) });
    const { start_q, start_v } = this.main.m.arrays, constants = this.counting?.m.arrays.start_constants;
    this.own = { q: start_q.data.slice(), v: start_v.data.slice(), constants: constants?.data.slice() ?? new Float64Array() };
  }

  find(p) {
    const { main, ideal, loose, shut, every, own } = this, inner = loose?.find(p);
    if (inner?.error) return inner;
    this.constants = !inner || inner.same ? own.constants : this.count(p);
    const inputs = Float64Array.from([...p, ...(this.constants ?? [])]), parts = [main, shut, every].filter((one) => one);
    if (!this.constants || !parts.every((one) => one.enter(inputs)))
      return { error: "with these parameters the mechanism has another form" };
    const without = ideal?.find(p);
    if (without?.error) return without;
    const same = [...parts, inner, without].every((one) => one?.same ?? true), { m } = main;
    if (same) {
      m.arrays.start_q.data.set(own.q);
      m.arrays.start_v.data.set(own.v);
      return { same, error: null };
    }
    const became = m.call("start.find", ideal?.main.m ?? m, shut?.m ?? m, every?.m ?? m, 0);
    return { same, error: became === this.N.MOVED ? null : this.words(became) };
  }

  // constants with which rows that count from the start vanish there; null where the form is another
  count(p) {
    const { counting: { m }, counting, loose, own } = this;
    if (!counting.enter(Float64Array.from([...p, ...own.constants.map(() => 0)]))) return null;
    m.call("start.constants", loose.main.m, 0);
    return m.arrays.start_constants.data.slice();
  }

  found() {
    const { main: { m }, constants } = this, { start_q, start_v, start_least, contact_kinematics: { data, shape: [, width] } } = m.arrays;
    const n = m.call("start.outside", 0), gap = n < 0 ? 0 : data[n * width + this.N.GAP] - Math.max(start_least.data[n], -1);
    const error = n < 0 ? null : `with these parameters joint '${this.contacts[n]}' starts ${Math.abs(gap).toPrecision(3)} outside its play`;
    return { q: start_q.data.slice(), v: start_v.data.slice(), constants, error };
  }

  words(became) {
    const { N, rows, main: { m } } = this, { data, shape: [, width] } = m.arrays.rows;
    if (became === N.NOT_FINITE) return "with these parameters numbers of the mechanism are too large or have no value";
    const gaps = rows.map((_, k) => Math.abs(data[k * width + N.RES])), k = gaps.indexOf(Math.max(...gaps));
    const what = became !== N.NOT_HELD && rows[k] ? `${rows[k][2] ? "driver" : "joint"} '${rows[k][0]}' stays open by ${gaps[k].toPrecision(3)} ${rows[k][1]}` : "pins do not fit";
    return `the mechanism cannot be put together with these parameters: ${what}`;
  }
}
