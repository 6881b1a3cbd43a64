// The kernels of the package, compiled: what `simulate` does, step by step, in the memory of a WebAssembly engine.
//
// engine: the module that `rattle.pages.engine` builds.  image: a run before its first step, of `rattle.pages.run_image`:
// { description, content }.  A run does what `rattle.analyses.dynamics.run` does around the kernels: switches at the
// instants of the timetable, jolts, jams that are passed, rows at the outputs.

const CELL = 8; // bytes of a number, address or length

/** An error of the engine; `reason` is "unsupported", "version", "kernel" or "failed". */
export class CoreError extends Error {
  constructor(reason, message) {
    super(message);
    this.reason = reason;
  }
}

/** An engine from the bytes of its module, which every run then uses; throws a CoreError where none can run. */
export async function openCore(bytes) {
  if (typeof WebAssembly !== "object") throw new CoreError("unsupported", "this browser has no WebAssembly, which computes the motion");
  let module;
  try {
    module = await WebAssembly.compile(bytes);
  } catch (error) {
    throw new CoreError("unsupported", `this browser cannot compile the engine that computes the motion: ${error.message}`);
  }
  const [section] = WebAssembly.Module.customSections(module, "rattle");
  if (!section) throw new CoreError("version", "these bytes are no engine of rattle");
  return { module, about: JSON.parse(new TextDecoder().decode(section)) };
}

/** Bytes from base64, unpacked if they are compressed. */
export async function bytesFrom(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  if (bytes[0] !== 0x1f || bytes[1] !== 0x8b) return bytes;
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// ---------------------------------------------------------------- memory and calls
/** The workspace of one run in the memory of its own instance: arrays by name, and kernels that may be called. */
class CoreMemory {
  constructor({ module, about }, { description, content }) {
    if (description.layout !== about.layout)
      throw new CoreError("version", "the model was written by another version of rattle than its engine");
    this.about = about;
    this.calls = new WebAssembly.Instance(module, {}).exports;
    const sizes = description.arrays.map((one) => one.slice(0, -1).reduce((a, b) => a * b, 1));
    this.end = Math.ceil(about.free / CELL) * CELL;
    const given = this.take(16), table = this.take(3 * sizes.length);
    const places = sizes.map((size) => this.take(size));
    const [count] = description.times, times = this.take(count), rows = this.take(count * description.width), sides = this.take(2 * description.width);
    const speeds = this.take(2 * sizes[about.arrays.findIndex(([name]) => name === "multiplier")]);
    const result = this.take(8), exception = this.take(1);
    this.grow();
    Object.assign(this, { given, table, result, exception, arrays: {}, word: new DataView(this.calls.memory.buffer) });
    about.arrays.forEach(([name, kind], k) => {
      const shape = description.arrays[k].slice(0, -1);
      this.arrays[name] = this.view(places[k], shape, kind);
      this.fill(this.arrays[name], content, description.arrays[k].at(-1));
      const row = [places[k], shape[0], shape.at(-1)]; // as a handle of `rattle.jit.workspace` has it
      row.forEach((value, n) => this.word.setBigInt64(table + CELL * (3 * k + n), BigInt(value), true));
    });
    for (const [name, kernels] of Object.entries(description.tables))
      kernels.forEach((kernel, k) => { this.arrays[name].data[k] = BigInt(kernel === null ? 0 : this.numberOf(kernel)); });
    this.times = this.view(times, [count], "f1");
    this.fill(this.times, content, description.times[1]);
    this.rows = this.view(rows, [count, description.width], "f2");
    this.sides = this.view(sides, [2, description.width], "f2");
    this.speeds = this.view(speeds, [2, this.arrays.multiplier.shape[0]], "f2");
  }

  take(cells) {
    const start = this.end;
    this.end += CELL * Math.max(cells, 1);
    return start;
  }

  grow() {
    const { memory } = this.calls, missing = Math.ceil((this.end - memory.buffer.byteLength) / 65536);
    try {
      if (missing > 0) memory.grow(missing);
    } catch {
      throw new CoreError("failed", `the run needs ${Math.ceil(this.end / 2 ** 20)} MB, more than the browser gives`);
    }
  }

  view(at, shape, kind) {
    const size = shape.reduce((a, b) => a * b, 1), { buffer } = this.calls.memory;
    return { at, shape, data: kind[0] === "f" ? new Float64Array(buffer, at, size) : new BigInt64Array(buffer, at, size) };
  }

  fill({ at, data }, content, offset) {
    if (offset >= 0) new Uint8Array(this.calls.memory.buffer, at, data.byteLength).set(content.subarray(offset, offset + data.byteLength));
  }

  numberOf(kernel) {
    const number = this.about.kernels[kernel];
    if (number === undefined) throw new CoreError("kernel", `the engine does not have ${kernel.replace("rattle.place.", "")}`);
    return number;
  }

  row(array, n) {
    const width = array.shape[1];
    return { at: array.at + CELL * n * width, shape: [width], data: array.data.subarray(n * width, (n + 1) * width) };
  }

  /** Call a kernel of the workspace: arguments are packed as `rattle.jit.wasm.engine` says; returns its first result. */
  call(name, ...given) {
    const [result, ...letters] = this.about.calls[name];
    let at = this.given;
    const put = (value, float) => {
      if (float) this.word.setFloat64(at, value, true);
      else this.word.setBigInt64(at, BigInt(value), true);
      at += CELL;
    };
    letters.forEach((letter, k) => {
      const one = letter === "h" ? this.table : given[k - 1];
      if (letter === "f" || letter === "i" || letter === "h") put(one, letter === "f");
      else [one.at, ...one.shape].forEach((part) => put(part, false));
    });
    if (this.calls[`call ${name}`](this.result, this.exception, this.given)) throw new CoreError("failed", this.told());
    return result === "i" ? Number(this.word.getBigInt64(this.result, true)) : this.word.getFloat64(this.result, true);
  }

  told() {
    const bytes = new Uint8Array(this.calls.memory.buffer), at = this.word.getInt32(this.about.told, true);
    return at ? new TextDecoder().decode(bytes.subarray(at, bytes.indexOf(0, at))) : "the engine stopped without a word";
  }
}

// ---------------------------------------------------------------- a run
const LOOPS = { smooth: "smooth.advance", "event-driven": "events.advance" };

/** One run in slices: `advance` until it returns true, then `result`. */
export class CoreRun {
  constructor(engine, image) {
    this.m = new CoreMemory(engine, image);
    Object.assign(this, { ...image.description, N: engine.about.numbers, events: [], breaks: [], crossings: [], jolts: [], jams: [], piece: 0 });
    this.kept = 0;
    this.leg = { start: this.start, end: this.start, h: 0, steps: 0 };
    this.status = null; // before the start
  }

  get t() { return this.m.arrays.clock.data[this.N.T]; }
  get y() { return this.m.arrays.state; }
  tally(name) { return Number(this.m.arrays.tally.data[this.N[name]]); }
  get done() { return this.status !== null && this.status !== this.N.PAUSED; }

  /** Steps for so many milliseconds at least; true at the end of the run. progress: the share that is done. */
  advance(milliseconds = Infinity, stopped = () => false) {
    const until = performance.now() + milliseconds, { m, N } = this;
    if (this.status === null) {
      this.status = this.begin(this.start);
      if (this.status === N.PAUSED && this.locates && this.times[0] && m.times.data[0] <= this.start) {
        m.call("record", this.start, this.y, m.row(m.rows, 0));
        m.arrays.tally.data[N.OUTPUTS] = 1n;
      }
    }
    while (!this.done && !stopped() && performance.now() <= until) {
      this.status = this.towards(this.end);
      this.collect();
    }
    return this.done;
  }

  get progress() { return Math.min(1, (this.t - this.start) / (this.end - this.start)); }

  result() {
    const { m, N } = this, count = this.tally("OUTPUTS");
    return {
      status: this.status, success: this.status === N.DONE, t: m.times.data.slice(0, count), width: this.width,
      rows: m.rows.data.slice(0, count * this.width), events: this.events, breaks: this.breaks, jams: this.jams, jolts: this.jolts,
      statistics: { steps: this.tally("STEPS"), rejected: this.tally("REJECTED"), evaluations: this.tally("EVALUATIONS") },
    };
  }

  // ---------------------------------------------------------------- the beginning
  begin(t) {
    const { m, N } = this, { stuck, clock } = m.arrays;
    this.takeSides(t);
    if (this.loop === "time-stepping") {
      m.call("stepping.start", t);
      this.setFloor();
      return N.PAUSED;
    }
    if (this.loop === "event-driven") {
      stuck.data.fill(0);
      stuck.data[N.EVENT_AT] = -Infinity;
      clock.data[N.T] = t;
      let status = m.call("events.start", t);
      if (status === N.NO_SOLUTION && this.passesJams && this.passJam(status, 0) === N.PAUSED) status = N.OK;
      if (status !== N.OK) return status;
      this.takeSides(t);
    }
    const status = m.call("smooth.begin", t, this.end, this.rtol, this.atol, this.longest);
    this.setFloor();
    if (this.loop === "smooth") this.pace(t);
    return status === N.OK ? N.PAUSED : status;
  }

  get longest() { return this.step ?? Infinity; }
  setFloor() { this.m.call("floor", this.extent, this.N.LIMIT, this.rtol, this.atol); }
  get ahead() { return this.piece < this.instants.length ? this.instants[this.piece] : Infinity; }

  takeSides(t) {
    const { m, N } = this;
    this.piece = this.instants.filter((one) => one <= t).length;
    this.takePiece();
    if (m.arrays.switch.shape[0] && this.locates) m.call("chooseSides", t, N.GLANCE * (this.end - t));
    if (m.arrays.dry.shape[0] && this.locates) m.call("decide", t, this.y, -1, 0);
  }

  takePiece() {
    const { code } = this.m.arrays;
    this.switches.forEach((row, k) => { code.data[row * code.shape[1] + this.N.SIDE] = BigInt(this.sides[this.piece][k]); });
  }

  pace(t) { // equal steps to the next instant of the timetable
    const ahead = Math.min(this.ahead, this.end) - t;
    if (!this.adaptive && ahead > 0) this.m.arrays.clock.data[this.N.H] = ahead / Math.max(1, Math.ceil(ahead / this.longest - 1e-9));
  }

  // ---------------------------------------------------------------- steps
  towards(t) {
    const { N } = this, instant = this.ahead;
    if (instant > t) return this.takeSteps(t, this.times[0]);
    let status = this.takeSteps(instant, this.outputsBefore(instant));
    if (status === N.DONE) status = this.turn(instant);
    return status === N.PAUSED && this.t >= t && this.ahead > t ? N.DONE : status;
  }

  outputsBefore(t) {
    const limit = t - this.N.SAME * this.end, found = this.m.times.data.findIndex((one) => one >= limit);
    return found < 0 ? this.times[0] : found;
  }

  takeSteps(t, outputs) {
    const { m, N } = this, out = (count) => ({ at: m.times.at, shape: [count] });
    if (this.loop === "time-stepping") {
      if (t !== this.leg.end) {
        const now = this.leg.end, done = this.tally("STEPS");
        const count = Math.max(1, Math.ceil((t - now) / (this.step || this.end) * (1 - 1e-12))), h = (t - now) / count;
        this.leg = { start: now - done * h, end: t, h, steps: done + count };
      }
      return m.call("stepping.advance", this.leg.start, this.leg.h, this.leg.steps, out(t >= this.end ? this.times[0] : outputs), m.rows, N.CHUNK);
    }
    const status = m.call(LOOPS[this.loop], t, this.rtol, this.atol, this.longest, out(outputs), m.rows, N.CHUNK);
    const stuck = status === N.NO_SOLUTION || status === N.LOCKED || status === N.STEP_TOO_SMALL;
    return stuck && this.passesJams ? this.passJam(status, status === N.NO_SOLUTION ? 1 : 0) : status;
  }

  passJam(status, late) {
    const { m, N, t } = this, { clock } = m.arrays;
    if (this.jams.length && t - this.jams.at(-1) <= 1e-9 * this.end) return status;
    if (m.call("events.passJam", t, late) !== N.OK) return status;
    this.jams.push(t);
    clock.data[N.H] = Math.max(clock.data[N.H], 1e-6 * (this.end - t));
    return this.goOn(t, true);
  }

  goOn(t, jolted) {
    const { m, N } = this;
    if (this.loop === "time-stepping") return N.PAUSED;
    if (this.loop === "event-driven") {
      const status = m.call("events.goOn", t, jolted ? 1 : 0);
      if (status !== N.OK) return status;
    } else if (m.arrays.dry.shape[0]) m.call("decide", t, this.y, -1, 1);
    m.call("smooth.resume", t);
    if (this.loop === "smooth") this.pace(t);
    return N.PAUSED;
  }

  /** Expressions switch at t: sides of the next piece, a jolt if a driver jumps. */
  turn(t) {
    const { m, N } = this, [before, after] = [m.row(m.sides, 0), m.row(m.sides, 1)];
    this.takeBreaks();
    m.call("record", t, this.y, before);
    const sides = [before.data.slice()], jumps = this.jumps.filter((one) => one.t === t);
    const [speeds, impulses] = [m.row(m.speeds, 0), m.row(m.speeds, 1)];
    if (jumps.length) m.call("speeds", t, speeds);
    this.piece += 1;
    this.takePiece();
    if (jumps.length) {
      const status = m.call("jolt", t, speeds, impulses);
      if (status !== N.OK) return status;
      for (const { row } of jumps) this.jolts.push({ t, row, impulse: -impulses.data[row] });
    }
    const status = this.goOn(t, jumps.length > 0);
    if (status === N.PAUSED) {
      this.recordNow(t);
      m.call("record", t, this.y, after);
      sides.push(after.data.slice());
      this.keepBreaks([t, t], sides);
    }
    return status;
  }

  recordNow(t) {
    if (!this.locates) return;
    const { m, N } = this;
    let k = this.tally("OUTPUTS");
    for (; k < this.times[0] && m.times.data[k] <= t + N.SAME * this.end; k++) m.call("record", t, this.y, m.row(m.rows, k));
    m.arrays.tally.data[N.OUTPUTS] = BigInt(k);
  }

  // ---------------------------------------------------------------- what steps leave
  collect() {
    const { m, N } = this, { events, tally } = m.arrays, width = events.shape[1];
    for (let k = 0; k < this.tally("EVENT_COUNT"); k++) {
      const [t, who, kind, ...values] = events.data.subarray(k * width, (k + 1) * width);
      this.events.push({ t, joint: this.owners[who], kind, values });
    }
    this.takeBreaks();
    tally.data[N.FOUND] = tally.data[N.EVENT_COUNT] = 0n;
  }

  takeBreaks() {
    const { break_times: times, break_rows: rows } = this.m.arrays, count = times.shape[0] ? times.data[0] : 0;
    if (!count) return;
    this.keepBreaks([...times.data.subarray(1, 1 + count)], Array.from({ length: count }, (_, k) => this.m.row(rows, k).data.slice()));
    times.data[0] = 0;
  }

  keepBreaks(times, rows) {
    this.kept += rows.length * this.width;
    if (this.kept > this.N.MOST_NUMBERS) this.breaks = [];
    else times.forEach((t, k) => this.breaks.push({ t, row: rows[k] }));
  }
}
