// A run by the compiled kernels, in slices: what `rattle.analyses.dynamics.run` does around them.
//
// Switches at the instants of the timetable, jolts, jams that are passed, rows at the outputs and beside events.

import { CoreMemory } from "./core.js";


/** One run in slices: `advance` until it returns true, then `result`. */
export class CoreRun {
  constructor(engine, image, { mostSteps = Infinity } = {}) {
    this.m = new CoreMemory(engine, image);
    Object.assign(this, image.description, { N: engine.about.numbers, piece: 0 });
    Object.assign(this, { mostSteps, events: [], breaks: [], kept: 0, crossings: [], jolts: [], jams: [] });
    this.leg = { start: this.start, end: this.start, h: 0, steps: 0 };
    this.status = null; // before the start
  }

  get t() { return this.m.arrays.clock.data[this.N.T]; }
  get y() { return this.m.arrays.state; }
  tally(name) { return Number(this.m.arrays.tally.data[this.N[name]]); }
  get done() { return this.status !== null && (this.status !== this.N.PAUSED || this.tally("STEPS") >= this.mostSteps); }
  get chunk() { return Math.max(1, Math.min(this.N.CHUNK, this.mostSteps - this.tally("STEPS"))); }

  /** Steps until so many milliseconds are over, or until `stopped()`; true at the end of the run. */
  advance(milliseconds = Infinity, stopped = () => false) {
    const until = performance.now() + milliseconds, { m, N } = this;
    if (this.status === null) {
      this.status = this.begin(this.start);
      if (this.status === N.PAUSED && this.locates && this.times[0] && m.times.data[0] <= this.start) {
        m.call("record", this.start, this.y, m.row(m.rows, 0));
        m.arrays.tally.data[N.OUTPUTS] = 1n;
      }
    }
    while (!this.done) {
      this.status = this.towards(this.end);
      this.collect();
      if (stopped() || performance.now() >= until) break;
    }
    return this.done;
  }

  get progress() { return Math.min(1, (this.t - this.start) / (this.end - this.start)); }

  result() {
    const { m, N } = this, count = this.tally("OUTPUTS");
    return {
      status: this.status, success: this.status === N.DONE, t: m.times.data.slice(0, count), width: this.width,
      rows: m.rows.data.slice(0, count * this.width), events: this.events, breaks: this.breaks,
      crossings: this.crossings, jams: this.jams, jolts: this.jolts,
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
    const status = m.call("steps.begin", t, this.end, this.rtol, this.atol, this.longest);
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
      return m.call("stepping.advance", this.leg.start, this.leg.h, this.leg.steps, out(t >= this.end ? this.times[0] : outputs), m.rows, this.chunk);
    }
    const status = m.call("steps.advance", t, this.rtol, this.atol, this.longest, out(outputs), m.rows, this.chunk);
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
    m.call("steps.resume", t);
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
    const { m, N } = this, { events, crossings, tally } = m.arrays;
    for (let k = 0; k < this.tally("FOUND"); k++) this.crossings.push([...m.row(crossings, k).data]);
    for (let k = 0; k < this.tally("EVENT_COUNT"); k++) {
      const [t, who, kind, ...values] = m.row(events, k).data;
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
