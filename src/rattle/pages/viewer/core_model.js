// A model that a page moves: its run, its start and its drawing, for any values of its parameters.
//
// data: of `rattle.pages.live_model`; functions: of its tape, by their numbers.

import { bytesFrom } from "./core.js";
import { CoreRun } from "./core_run.js";
import { general, trusted } from "./trust_words.js";
import { StartFinder } from "./core_start.js";
import { agreement } from "./core_horizon.js";
import { curves, resultOf } from "./core_result.js";
import { leapsOf } from "./core_trust.js";
import { functionsByName } from "./tape.js";

const MOST_BESIDE = 400_000; // numbers beside events that a page keeps of a run
const MOST_OUTPUTS = 20_000; // of a longer run they are farther apart
const EVENT_PARTS = ["t", "joint", "kind", "normal_speed", "duration", "peak_force", "impulse", "energy_lost", "contact"]; // in lists of a scene

/** A model in an engine. */
export class CoreModel {
  static async open(engine, data, functions) {
    const content = await bytesFrom(data.content), start = { ...data.start, content: await bytesFrom(data.start.content) };
    return new CoreModel(engine, { ...data, start }, functions, content);
  }

  constructor(engine, data, functions, content) {
    Object.assign(this, { engine, data, content });
    this.functions = functionsByName(functions, data.functions);
    this.names = data.parameters.map(([name]) => name);
    this.own = Float64Array.from(data.parameters, ([, value]) => value);
    this.finder = new StartFinder(engine, data.start, functions);
    this.ownStart = this.finder.start.own;
  }

  /** A run that has not begun.  parameters: values [SI] by name; settings: t_end, interval of outputs [s], rtol. */
  begin(parameters = {}, settings = {}) {
    const p = Float64Array.from(this.names, (name, k) => (Object.hasOwn(parameters, name) ? parameters[name] : this.own[k]));
    p.forEach((value, k) => { if (!Number.isFinite(value)) throw new Error(`${this.names[k]}: a finite number is expected`); });
    this.requireLimits(p);
    const same = p.every((value, k) => value === this.own[k]);
    const start = same ? null : this.finder.find(p);
    if (start?.error) throw new Error(start.error);
    const arrays = this.arrays(p, (start ?? this.ownStart).constants);
    return new ModelRun(this, p, start, arrays, settings);
  }

  requireLimits(p) {
    this.data.parameters.forEach(([name, , low, high, unit], k) => {
      if (p[k] < (low ?? -Infinity) || p[k] > (high ?? Infinity))
        throw new Error(`${name} = ${general(p[k])} is outside of its limits, ${general(low ?? -Infinity)} to ${general(high ?? Infinity)} ${unit}`);
    });
  }

  // values of the entries that follow from parameters, and of the facts
  arrays(p, constants) {
    const { entries, facts } = this.data, input = Float64Array.from([...p, ...constants]);
    const made = new Float64Array(1 + entries.reduce((sum, [, where]) => sum + where.length, 0) + facts.length + this.data.drawn.length);
    this.functions.arrays(input, made);
    if (!made[0]) throw new Error("with these values the mechanism has another form, which this page does not hold: open the model with rattle for it");
    let first = 1;
    const found = entries.map(([name, where]) => {
      first += where.length;
      return [name, where, made.subarray(first - where.length, first)];
    });
    const sizes = made.subarray(first, first + this.data.drawn.length);
    return { entries: found, sizes, facts: Object.fromEntries(facts.map((name, k) => [name, made[first + sizes.length + k]])) };
  }

  drawing(sizes) {
    const made = structuredClone(this.data.drawing);
    this.data.drawn.forEach((place, k) => {
      let inner = made;
      for (const key of place.slice(0, -1)) inner = inner[key];
      inner[place.at(-1)] = sizes[k];
    });
    return made;
  }
}

class ModelRun {
  constructor(model, p, start, arrays, settings) {
    Object.assign(this, { model, p, start, arrays, settings, began: performance.now(), stopped: false });
    this.run = this.prepared(1);
  }

  // share: of the tolerances, and by how much steps are shorter
  prepared(share, step = null) {
    const { model: { engine, data, content }, arrays: { entries, facts }, start, settings } = this, { run } = data;
    const end = settings.t_end ?? (data.settings.end_given ? run.end : facts.t_end ?? run.end), rtol = (settings.rtol ?? facts.rtol ?? run.rtol) * share;
    const interval = settings.interval ?? facts.output ?? data.settings.interval, most = settings.interval ? Infinity : MOST_OUTPUTS;
    const count = Math.min(most, Math.max(1, Math.round(interval ? end / interval : data.settings.outputs)));
    if (!(rtol >= data.settings.tightest && rtol < 1)) throw new Error(`rtol = ${general(rtol)}: expected ${general(data.settings.tightest)} or more, and less than 1`);
    if (!(end > 0 && end < Infinity)) throw new Error("the end of the motion must be after its start");
    const changed = end !== run.end || count + 1 !== run.times[0];
    const longest = step ?? (data.settings.step_given ? facts.step ?? run.step : run.step && Math.min(data.settings.longest, end / data.settings.fewest));
    const atol = data.settings.atol_given ? (facts.atol ?? run.atol) * share : (run.atol / run.rtol) * rtol;
    const description = { ...run, end, rtol, atol, step: longest, times: changed ? [count + 1, -1, end] : run.times };
    const core = new CoreRun(engine, { description, content }, { mostSteps: data.settings.most_steps });
    const { m } = core, state = m.arrays.state.data;
    core.method = data.method.name;
    for (const [name, where, values] of entries) where.forEach((place, k) => { m.arrays[name].data[place] = values[k]; });
    if (start) {
      state.set(start.q);
      state.set(start.v, start.q.length);
    }
    core.findTimetable();
    const leaps = leapsOf(core, data.result);
    if (leaps.length) throw new Error(leaps.join("; "));
    return core;
  }

  /** The same motion with tighter tolerances, see analyses/dynamics/simulate.py. */
  second() {
    const { rtol, step } = this.run, { usual, refinement } = this.model.data.method;
    const fine = rtol > usual ? Math.min(rtol / 10, usual) : rtol / 10;
    const core = this.prepared(fine / rtol, step === null ? null : step / refinement);
    core.mostSteps = 10 * this.run.mostSteps;
    return core;
  }

  /** What a page says of such a trust. */
  trusted(trust) {
    return trusted(trust, this.model.data.result.told.sentences.trust);
  }

  /** Up to which time [s] the second run, which has ended, agrees with this one. */
  agreement(second) {
    const { data, functions } = this.model, other = resultOf(second, data.result, functions, this.p);
    const { time, first, motion } = agreement(this.made, other, this.run, data.result, functions, this.p);
    return { horizon: time, horizon_curve: first, horizon_motion: motion };
  }

  advance(milliseconds) {
    return this.stopped || this.run.advance(milliseconds, () => this.stopped);
  }

  /** What a page shows. */
  result() {
    const { model, p, run, arrays: { sizes } } = this, { data, functions } = model;
    const made = this.made = resultOf(run, data.result, functions, p, performance.now() - this.began);
    const parameters = Object.fromEntries(model.names.map((name, k) => [name, p[k]]));
    const message = this.stopped && !made.success ? `at t = ${general(run.t)} s, when it was told to; what was computed before is shown` : made.message;
    const events = made.events.map((event) => EVENT_PARTS.map((key) => event[key]));
    return {
      ...made, trust: this.trusted(made.trust), label: "", t_end: run.end, message, parameters, events, geometry: model.drawing(sizes),
      between: this.between(),
    };
  }

  // values just before and after events
  between() {
    const { model: { data, functions }, run } = this, { breaks, rows } = run.result(), { width } = data.result;
    if (!breaks.length || breaks.length * width > MOST_BESIDE) return {};
    breaks.sort((a, b) => a.t - b.t);
    const every = new Float64Array(breaks.length * width), t = Float64Array.from(breaks, (one) => one.t);
    breaks.forEach(({ row }, k) => every.set(row, k * width));
    const made = curves(run, data.result, functions, this.p, every, rows.subarray(0, width));
    return Object.fromEntries(Object.entries(made).map(([name, y]) => [name, { t, y }]));
  }
}
