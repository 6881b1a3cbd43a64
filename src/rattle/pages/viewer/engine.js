// The motion of a live model: the same steps, checks and words as `simulate`, in the browser.
//
// module: what pages/live_program.py writes (recorded functions of one model and how its start follows from the
// parameters).  settings: method, rtol, atol, step [s], t_end [s], outputs (how many intervals), limits, tableau.
// Nothing here touches a page, so it also runs in a worker and in node.

import {
  NOT_FINITE, SINGULAR, TOO_FAST, WEAK, cannot, checkResidual, diverged, floorOf, stands, tooMany, trustOf, unsound,
} from "./audit.js";
import { interpolate, prepareDense, rootOf, stepExplicit } from "./explicit.js";
import { agreement } from "./horizon.js";
import { Peaks } from "./peaks.js";
import { endOnSwitch, nextInstant, release, slides, takeSides, turnSwitch } from "./switches.js";

const OK = 0, AGAIN = 1, STOP = 2;
const FAR = 0.5; // [rad, sizes of the mechanism], see analyses/straight_line/starts.py
const LEAP = 0.1, LEAP_ERROR = 1e-8, MOST_TRIES = 20; // steps across it, see solvers/step_loop.py
const SAME = 1e-13; // share of a run within which two instants count as one
const SCAN = 8; // parts of a step that are searched for zeros of a link's force

/** A run from the start to settings.t_end, with everything that a page shows of it. */
export function runLive(module, settings, parameters) {
  const run = beginRun(module, settings, parameters);
  advanceRun(run, Infinity);
  return endRun(run);
}

/** The same with the horizon, which takes a second, tighter run. */
export function runWithHorizon(module, settings, parameters) {
  const first = beginRun(module, settings, parameters);
  advanceRun(first, Infinity);
  if (first.written < 2) return endRun(first);
  const second = beginSecond(first);
  advanceRun(second, Infinity);
  return endRun(first, agreement(first, second));
}

// ---------------------------------------------------------------- a run in slices
/** A run that has not taken a step yet; throws an Error in plain words where the parameters have no start. */
export function beginRun(module, settings, parameters = {}) {
  const p = module.values(parameters), y = module.start(p);
  const s = newState(module, settings, p, y);
  s.anotherWay = startsFar(module, y);
  s.times = outputTimes(settings);
  s.data = new Float64Array(s.no * s.times.length);
  s.began = now();
  takeSides(s);
  if (!s.rates(0, y, s.f)) return stop(s, `${cannot(0)}: ${SINGULAR}`);
  if (!finite(s.f, s.ny)) return stop(s, `${cannot(0)}: ${NOT_FINITE}`);
  for (let n = 0; n < s.nl; n++) s.sign[n] = s.f[s.ny + 2 + n] < 0 ? -1 : 1;
  s.firstSign = s.sign.slice();
  s.functions.outputs(s.at(0, y), s.row);
  s.prepare(s.row[s.no - 1]);
  checkResidual(s, 0, y);
  stands(s, y, true);
  s.h = !s.tableau.adaptive ? equalStep(s, 0) : firstStep(s);
  s.floor = floorOf(s);
  record(s, 0, y);
  return s;
}

/** A tighter run with the parameters of another, for the horizon. */
export function beginSecond(first) {
  const { settings } = first, { rtol, refinement, usual } = settings;
  const tight = rtol > usual ? Math.min(rtol / 10, usual) : rtol / 10;
  const step = settings.step === null ? null : settings.step / refinement;
  return beginRun(first.module, { ...settings, rtol: tight, atol: (settings.atol * tight) / rtol, step }, first.p);
}

/** Takes steps for up to so many milliseconds; true at the end of the run. */
export function advanceRun(s, milliseconds) {
  const until = milliseconds === Infinity ? Infinity : now() + milliseconds;
  while (!s.done) {
    for (let n = 0; n < 16 && !s.done; n++) oneStep(s);
    if (until !== Infinity && now() >= until) break;
  }
  return s.done;
}

// whether positions at the start are so far from the model's own that the assembly of Python would begin anew
function startsFar(module, y) {
  const { nb, size } = module.layout, own = module.start(module.values({}));
  for (let n = 0; n < 3 * nb; n++) if (Math.abs(y[n] - own[n]) > FAR * (n % 3 === 2 ? 1 : size)) return true;
  return false;
}

const now = () => (typeof performance === "undefined" ? Date.now() : performance.now());

// places in a row of outputs of what follows from the forces of joints and drivers
function reactions({ names, units, layout: { rows } }) {
  const owners = new Set(rows.map(([owner]) => owner)), kinds = new Set(["N", "N*m", "W"]);
  return names.slice(1).flatMap((name, c) => (kinds.has(units[c + 1]) && owners.has(name.slice(0, name.lastIndexOf("."))) ? [c] : []));
}

function newState(module, settings, p, y) {
  const { layout, functions } = module, { ny, nb, links, rows, switches } = layout;
  const array = (n) => new Float64Array(n), arrays = (n) => Array.from({ length: n }, () => array(ny + 2 + links.length + switches.length));
  const s = {
    module, settings, layout, functions, p, ny, nb, nm: 6 * nb, nl: links.length, no: module.names.length - 1,
    method: settings.method, tableau: settings.tableau, rtol: settings.rtol, atol: settings.atol,
    longest: settings.step === null ? Infinity : settings.step, controlled: layout.controlled,
    y: y.slice(), f: arrays(1)[0], yNew: array(ny), fNew: arrays(1)[0], stage: array(ny), k: arrays(1 + Math.max(settings.tableau.C.length, settings.tableau.stages)), dense: arrays(7),
    whole: array(module.inputs), input: array(1 + ny + switches.length + layout.prepared), made: array(ny + 1),
    row: array(module.names.length), residual: array(rows.length + 2), fixed: array(3 * nb + 2),
    t: 0, h: 0, tEnd: settings.t_end, longestStable: Infinity, shortened: false, written: 0, steps: 0, rejected: 0,
    near: [], reactions: reactions(module), sign: array(links.length), crossings: [], changed: false, message: "", done: false, pivot: 1, tame: false, streak: 0, soundStep: 0, lands: 0, shortest: Infinity,
    drift: 0, driftAngle: 0, driftRow: -1, openness: 0, openRow: 0, correction: 0,
    total0: 0, work0: 0, mostKinetic: 0, mostWork: 0, least: 0, most: 0, unrest: 0, mostUnrest: 0, floor: 0,
  };
  const ns = switches.length;
  Object.assign(s, {
    ns, sides: s.input.subarray(1 + ny, 1 + ny + ns), over: array(ns), values: array(ns), scratch: arrays(1)[0],
    peaks: new Peaks(module.names.slice(1), module.units.slice(1)), instants: [], crossed: false, goOn: 0, again: 0, lastTurn: -Infinity, endless: "",
  });
  addFunctions(s);
  return s;
}

function addFunctions(s) {
  const { functions, ny, nl, ns, sides, input, whole, p } = s;
  s.at = (t, state) => {
    input[0] = t;
    for (let n = 0; n < ny; n++) input[1 + n] = state[n];
    return input;
  };
  // dy/dt, a flag, how far the equations are from being dependent, forces of links
  s.rates = (t, state, out) => {
    functions.rates(s.at(t, state), out);
    if (out[ny] === 0) functions.refined(input, out); // next to a singular position
    if (out[ny + 1] < s.pivot) s.pivot = out[ny + 1];
    for (let n = 0; n < nl && !s.changed; n++) s.changed = out[ny + 2 + n] * s.sign[n] < 0;
    for (let n = 0; n < ns; n++) if (out[ny + 2 + nl + n] * sides[n] < 0) s.over[n] = s.crossed = true;
    if (out[ny] === 0) s.why = SINGULAR;
    return out[ny] !== 0;
  };
  s.project = (t, state) => {
    functions.project(s.at(t, state), s.made);
    for (let n = 0; n < ny; n++) state[n] = s.made[n];
    return s.made[ny] !== 0;
  };
  // what follows from the parameters and the energy at the start alone
  s.prepare = (energy) => {
    whole.fill(0);
    whole.set(s.y, 1);
    whole.set(p, 1 + ny);
    whole[1 + ny + p.length] = energy;
    functions.fixed(whole, s.fixed);
    functions.prepare(whole, input.subarray(1 + ny + ns));
  };
  s.prepare(0);
}

function outputTimes({ t_end: end, outputs }) {
  const times = Float64Array.from({ length: outputs + 1 }, (_, k) => k * (end / outputs));
  times[outputs] = end;
  return times;
}

function finite(values, n) {
  for (let i = 0; i < n; i++) if (!(Math.abs(values[i]) < 1e130)) return false;
  return true;
}

// ---------------------------------------------------------------- steps
function equalStep(s, t) {
  const ahead = nextInstant(s) - t, step = s.settings.step ?? s.settings.fixed_step;
  return ahead / Math.max(1, Math.ceil(ahead / step - 1e-9));
}

// Hairer, Norsett, Wanner, section II.4, starting step size
function firstStep(s) {
  const { y, f, nm, rtol, atol, stage } = s, longest = Math.min(s.longest, s.tEnd), slope = s.k[1];
  let size = 0, steep = 0, bend = 0;
  for (let n = 0; n < nm; n++) {
    const scale = atol + rtol * Math.abs(y[n]);
    size += (y[n] / scale) ** 2;
    steep += (f[n] / scale) ** 2;
  }
  const h = Math.min(size > 1e-10 && steep > 1e-10 ? 0.01 * Math.sqrt(size / steep) : 1e-6, longest);
  for (let n = 0; n < s.ny; n++) stage[n] = y[n] + h * f[n];
  s.rates(h, stage, slope);
  for (let n = 0; n < nm; n++) bend += ((slope[n] - f[n]) / (atol + rtol * Math.abs(y[n]))) ** 2;
  const largest = Math.max(Math.sqrt(steep), Math.sqrt(bend) / h) / Math.sqrt(nm);
  const second = largest > 1e-15 && largest < Infinity ? rootOf(0.01 / largest, s.tableau.order) : Math.max(1e-6, 1e-3 * h);
  return Math.min(100 * h, second, longest);
}

function oneStep(s) {
  const { t, tEnd } = s;
  if (t >= tEnd) return void (s.done = true);
  const end = nextInstant(s), last = t + (s.lands ? 1 : 1.000001) * s.h >= end, h = last ? end - t : s.h;
  if (h <= 1e-15 * Math.abs(t) || h <= 1e-16 * tEnd || t + h === t) return void stop(s, `${cannot(t)}: ${s.why}`);
  if (s.steps + s.rejected >= s.settings.most_steps) return void stop(s, tooMany(s));
  const tNew = last ? end : t + h;
  s.changed = false;
  let status = tryStep(s, t, h, last);
  if (status === OK) status = endOnConstraints(s, t, h, tNew);
  if (s.endless) return void stop(s, slides(s));
  if (status !== OK) return;
  search(s, t, tNew);
  startNext(s, tNew);
}

function tryStep(s, t, h, last) {
  s.why = NOT_FINITE;
  s.pivot = 1;
  let error = stepExplicit(s, t, h);
  const weak = s.pivot < WEAK && h <= LEAP * s.soundStep;
  if (weak && error > 1 && error * s.rtol <= LEAP_ERROR * 2 ** s.streak) error = 1e-8;
  if (!(error <= 1)) return stepAnew(s, t, h, error, weak);
  if (s.tableau.adaptive) {
    if (s.pivot > WEAK) s.tame = false;
    if (!weak) {
      s.streak = 0;
      s.soundStep = Math.max(h, 0.7 * s.soundStep);
    }
    const ahead = h * (error < 1e-7 ? 6 : Math.min(6, 0.9 / rootOf(Math.max(error, 1e-300), s.tableau.order)));
    s.longestStable *= 1.005;
    s.h = Math.min(s.longest, s.longestStable, Math.max(ahead, last ? s.h : 0));
  }
  return OK;
}

// after a step with too large an error; next to a singular position stages are projected, and steps leap across it
function stepAnew(s, t, h, error, weak) {
  s.trouble = t + h;
  s.lands = 0;
  if (s.why === NOT_FINITE && s.pivot < WEAK) s.why = SINGULAR;
  else if (s.why === NOT_FINITE && error < Infinity) s.why = TOO_FAST;
  if (!(error < Infinity) && s.crossed && release(s)) return s.rejected++, AGAIN;
  if (!s.tableau.adaptive) return stop(s, diverged(s, h)), STOP;
  s.rejected++;
  if (s.pivot < WEAK && !s.tame) {
    s.tame = true;
    return AGAIN;
  }
  s.h = h * (error < Infinity ? Math.max(0.2, 0.9 / rootOf(error, s.tableau.order)) : 0.1);
  if (weak && s.streak < MOST_TRIES) s.h = LEAP * s.soundStep * 0.9 ** ++s.streak;
  return AGAIN;
}

function endOnConstraints(s, t, h, tNew) {
  const { yNew, fNew } = s;
  checkResidual(s, tNew, yNew, true);
  const sound = s.project(tNew, yNew) && s.rates(tNew, yNew, fNew);
  if (s.why === NOT_FINITE) s.why = s.pivot < WEAK ? SINGULAR : TOO_FAST; // all stages are finite
  if (s.tableau.stable > 0 && sound && !isStable(s, h)) {
    s.rejected++;
    s.lands = 0;
    return AGAIN;
  }
  checkResidual(s, tNew, yNew);
  const torn = s.correction > s.settings.limits.jump || s.openness > s.settings.limits.drift;
  if (!stands(s, yNew, false) || !sound) {
    s.trouble = tNew;
    s.lands = 0;
    if (s.tableau.adaptive && h > 1e-9 * (s.tEnd - t)) {
      s.h = 0.25 * h;
      s.rejected++;
      return AGAIN;
    }
    return stop(s, sound || torn ? unsound(s, tNew) : `${cannot(t)}: ${SINGULAR}`), STOP;
  }
  return endOnSwitch(s, t, tNew - t) ? OK : AGAIN;
}

// false if the step was too long for the stiffest spring: see solvers/step_control.py, is_stable
function isStable(s, h) {
  const { yNew: y, fNew: f, stage, nb, rtol, atol, fixed } = s, slope = s.k[s.tableau.stages - 1], { stable } = s.tableau, nq = 3 * nb;
  let dq2 = 0, dv2 = 0, da2 = 0, counts = false;
  for (let n = 0; n < nq; n++) {
    const mass = fixed[n], dq = y[n] - stage[n], dv = y[nq + n] - stage[nq + n], da = f[nq + n] - slope[nq + n];
    dq2 += mass * dq * dq;
    dv2 += mass * dv * dv;
    da2 += mass * da * da;
    const fast = Math.abs(dv) > 1e-2 * (atol + rtol * Math.abs(y[nq + n]));
    counts = counts || fast || Math.abs(dq) > 1e-2 * (atol + rtol * Math.abs(y[n]));
  }
  const again = s.shortened, da = Math.sqrt(da2);
  s.shortened = false;
  const fall = Math.sqrt(dv2) + Math.sqrt(dv2 + 4 * da * Math.sqrt(dq2));
  if (again || !counts || !(da < Infinity) || 2 * da * h <= stable * fall) return true;
  s.shortened = true;
  s.longestStable = Math.max(0.2 * h, (0.9 * stable * fall) / (2 * da));
  s.h = s.longestStable;
  return false;
}

// outputs and zeros of links' forces inside the step
function search(s, t, tNew) {
  const h = tNew - t, due = s.written < s.times.length && s.times[s.written] <= tNew;
  const { changed } = s;
  if (due || changed) prepareDense(s, t, h);
  if (changed) findCrossings(s, t, h);
  const until = tNew < s.tEnd && tNew === nextInstant(s) ? tNew - SAME * s.tEnd : tNew; // there, values just after it
  while (s.written < s.times.length && s.times[s.written] <= until) {
    const at = s.times[s.written];
    interpolate(s, (at - t) / h, s.stage);
    s.project(at, s.stage);
    record(s, at, s.stage);
  }
}

function findCrossings(s, t, h) {
  const force = (share, n) => {
    interpolate(s, share, s.stage);
    s.functions.rates(s.at(t + share * h, s.stage), s.k[1]);
    return s.k[1][s.ny + 2 + n];
  };
  for (let n = 0; n < s.nl; n++) {
    let left = 0;
    for (let part = 1; part <= SCAN; part++) {
      const right = part / SCAN;
      if (force(right, n) * s.sign[n] < 0) {
        let low = left, high = right;
        for (let k = 0; k < 60 && (high - low) * h > 1e-13 * Math.abs(t) + 1e-16 * h; k++) {
          const middle = 0.5 * (low + high);
          if (force(middle, n) * s.sign[n] < 0) high = middle;
          else low = middle;
        }
        s.sign[n] = -s.sign[n];
        s.crossings.push([t + high * h, n]);
      }
      left = right;
    }
  }
}

function startNext(s, tNew) {
  const at = nextInstant(s) === tNew && tNew < s.tEnd;
  turnSwitch(s, tNew);
  [s.y, s.yNew] = [s.yNew, s.y];
  [s.f, s.fNew] = [s.fNew, s.f];
  s.shortest = Math.min(s.shortest, tNew - s.t);
  if (s.pivot < WEAK) goNear(s, s.t, tNew);
  s.t = tNew;
  s.steps++;
  look(s, tNew, s.y);
  if (!at) return;
  if (!s.tableau.adaptive) s.h = equalStep(s, tNew);
  while (s.written < s.times.length && s.times[s.written] <= tNew + SAME * s.tEnd) record(s, tNew, s.y);
}

// a step next to a singular position: forces in it are not determined, or grow without bound
function goNear(s, t, tNew) {
  const last = s.near[s.near.length - 1];
  if (last && last[1] === t) last[1] = tNew;
  else s.near.push([t, tNew]);
}

function look(s, t, y) {
  s.functions.outputs(s.at(t, y), s.row);
  if (s.pivot < WEAK) for (const c of s.reactions) s.row[c] = NaN;
  s.peaks.add(t, s.row);
}

function record(s, t, y) {
  look(s, t, y);
  const n = s.times.length, k = s.written++;
  for (let c = 0; c < s.no; c++) s.data[c * n + k] = s.row[c];
}

// ---------------------------------------------------------------- the end
function stop(s, message) {
  s.message = message;
  s.done = true;
  return s;
}

/** What a page shows of a run; reach: times up to which a tighter run agrees, null if there was none. */
export function endRun(s, reach = null) {
  const { module, written: n, times, settings } = s, columns = {}, units = {};
  module.names.slice(1).forEach((name, c) => {
    columns[name] = s.data.subarray(c * times.length, c * times.length + n);
    units[name] = module.units[c + 1];
  });
  const parameters = Object.fromEntries(module.sliders.map((one, k) => [one.name, s.p[k]]));
  return {
    label: "", parameters, names: module.names.slice(1), units, t: times.subarray(0, n), columns,
    peaks: s.peaks.found(), geometry: module.geometry(s.p), events: [], trust: trustOf(s, reach), success: !s.message, message: s.message,
    stats: { steps: s.steps, rejected: s.rejected, milliseconds: now() - s.began, method: s.method, rtol: s.rtol,
      step: settings.step },
  };
}
