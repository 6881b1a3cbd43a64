// A run by the compiled kernels, in slices: `rattle.solvers.run_loop` takes it from its beginning to its end.

import { CoreMemory } from "./core.js";


/** One run in slices: `advance` until it returns true, then `result`. */
export class CoreRun {
  constructor(engine, image, { mostSteps = Infinity } = {}) {
    [this.m] = CoreMemory.together(engine, [image]);
    Object.assign(this, image.description, { N: engine.about.numbers, mostSteps });
    Object.assign(this, { events: [], breaks: [], kept: 0, crossings: [], jolts: [], jams: [] });
    this.status = null; // before the start
  }

  /** Find when expressions of time switch and drivers jump, with the numbers that the workspace holds. */
  findTimetable() {
    const { m } = this;
    for (let needed; (needed = m.call("run.timetable", this.start, this.end)) > 0;) {
      const room = this.N.MORE * needed;
      m.enlarge({ switchings: room, edges: room + 2, driver_jump: room * m.arrays.driver_leap.shape[0] });
    }
  }

  get t() { return this.m.arrays.clock.data[this.N.T]; }
  tally(name) { return Number(this.m.arrays.tally.data[this.N[name]]); }
  get done() { return this.status !== null && (this.status !== this.N.PAUSED || this.tally("STEPS") >= this.mostSteps); }
  get chunk() { return Math.max(1, Math.min(this.N.CHUNK, this.mostSteps - this.tally("STEPS"))); }

  /** Steps until so many milliseconds are over, or until `stopped()`; true at the end of the run. */
  advance(milliseconds = Infinity, stopped = () => false) {
    const until = performance.now() + milliseconds, { m, end } = this;
    const how = [end, this.rtol, this.atol, this.step || Infinity, m.times, m.rows];
    if (this.status === null) {
      this.status = m.call("run.begin", this.start, ...how);
      this.collect();
    }
    while (!this.done) {
      this.status = m.call("run.advance", end, ...how, this.chunk);
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

  // ---------------------------------------------------------------- what steps leave
  collect() {
    const { m, N } = this, { events, crossings, tally, course, driver_jump: jumps } = m.arrays;
    for (let k = 0; k < this.tally("FOUND"); k++) this.crossings.push([...m.row(crossings, k).data]);
    for (let k = 0; k < this.tally("EVENT_COUNT"); k++) {
      const [t, who, kind, ...values] = m.row(events, k).data;
      this.events.push({ t, joint: this.owners[who], contact: this.labels[who] ?? "", kind, values });
    }
    tally.data[N.FOUND] = tally.data[N.EVENT_COUNT] = 0n;
    while (this.jolts.length < course.data[N.JOLTS]) {
      const [t, row, impulse] = m.row(jumps, this.jolts.length).data;
      this.jolts.push({ t, row, impulse });
    }
    if (this.jams.at(-1) !== course.data[N.JAM_AT] && course.data[N.JAMS]) this.jams.push(course.data[N.JAM_AT]);
    this.keepBreaks();
  }

  keepBreaks() {
    const { break_times: times, break_rows: rows } = this.m.arrays, count = times.shape[0] ? Math.floor(times.data[0]) : 0;
    if (!count) return;
    this.kept += count * this.width;
    if (this.kept > this.N.MOST_NUMBERS) this.breaks = [];
    else for (let k = 0; k < count; k++) this.breaks.push({ t: times.data[1 + k], row: this.m.row(rows, k).data.slice() });
    times.data[0] = 0;
  }
}
