// Switches of expressions (abs, sign, min, max, if): each step stays on the branches of its start and ends where the
// first switching function changes its sign, as in solvers/state_switches.py.  Those of time are located beforehand.

import { interpolate, prepareDense } from "./explicit.js";
import { general } from "./trust_words.js";

const PARTS = 16; // pieces of a step that are searched
const ENDLESS = 200; // switchings without progress in time after which a run stops
const SAMPLES = 20000; // instants at which switching functions of time are looked at

const side = (x) => (x > 0 ? 1 : x < 0 ? -1 : 0);

// values of the switching functions at a state
function argumentsAt(s, t, y, out = s.values) {
  s.functions.rates(s.at(t, y), s.scratch);
  out.set(s.scratch.subarray(s.ny + 2 + s.nl, s.ny + 2 + s.nl + s.ns));
  return out;
}

// switches without a side take that of their switching function
function takeFree(s, t, y) {
  argumentsAt(s, t, y);
  for (let n = 0; n < s.ns; n++) if (s.sides[n] === 0) s.sides[n] = side(s.values[n]);
}

/** Sides at the start: where a switching function is zero, the one that it enters at once. */
export function takeSides(s) {
  if (!s.ns) return;
  const { y, f, stage, nm } = s, ahead = 1e-6 * s.tEnd, half = nm / 2;
  s.sides.fill(0);
  s.rates(0, y, f);
  takeFree(s, 0, y);
  for (let n = 0; n < s.ny; n++) stage[n] = y[n] + ahead * f[n];
  for (let n = 0; n < half; n++) stage[n] = y[n] + 0.5 * ahead * (y[half + n] + stage[half + n]);
  takeFree(s, ahead, stage);
  s.instants = instantsOf(s);
  s.crossed = false;
}

// instants at which switching functions of time change their signs, in order: [t, number of the switch]
function instantsOf(s) {
  const timed = s.layout.switches.map((one, n) => (one[1] ? n : -1)).filter((n) => n >= 0), found = [];
  if (!timed.length) return found;
  const at = (t) => Float64Array.from(argumentsAt(s, t, s.y));
  let before = at(0), tBefore = 0;
  for (let k = 1; k <= SAMPLES; k++) {
    const t = (s.tEnd * k) / SAMPLES, now = at(t);
    for (const n of timed) if (before[n] * now[n] < 0 || (before[n] !== 0 && now[n] === 0))
      found.push([located(at, n, before[n], tBefore, t), n]);
    [before, tBefore] = [now, t];
  }
  return found.sort((a, b) => a[0] - b[0]);
}

function located(at, n, sign, low, high) {
  for (let k = 0; k < 60; k++) {
    const middle = 0.5 * (low + high);
    if (middle <= low || middle >= high) break;
    if (at(middle)[n] * sign > 0) low = middle;
    else high = middle;
  }
  return high;
}

/** The time up to which the next steps go without a switch of time. */
export const nextInstant = (s) => (s.instants.length ? Math.min(s.instants[0][0], s.tEnd) : s.tEnd);

/** After a step without a finite value: values decide for switches whose functions have changed sign; true if any. */
export function release(s) {
  let any = false;
  for (let n = 0; n < s.ns; n++)
    if (s.over[n] && s.sides[n] !== 0) {
      s.sides[n] = 0;
      any = true;
    }
  forget(s);
  return any;
}

function forget(s) {
  s.over.fill(0);
  s.crossed = false;
}

/** True if the step may be taken; false if a shorter one, which ends at a switch, is to be tried. */
export function endOnSwitch(s, t, h) {
  if (!s.ns || s.lands !== 0 || !s.crossed) return true;
  prepareDense(s, t, h);
  const [share, who] = firstSwitch(s, t, h);
  forget(s);
  if (who < 0) return true;
  s.goOn = s.h;
  if (share * h <= 1e-15 * Math.abs(t) + 1e-16 * s.tEnd) {
    turn(s, t, s.y, who, h);
    s.rates(t, s.y, s.f);
    forget(s);
    s.h = h;
    if (s.again > ENDLESS) s.endless = s.layout.switches[who][0];
    return false;
  }
  s.lands = 1 + who;
  if ((1 - share) * h <= 1e-13 * s.tEnd) return true;
  s.h = share * h;
  return false;
}

// share of the step at which the first switching function changes its sign, and its number
function firstSwitch(s, t, h) {
  let best = Infinity, who = -1;
  const value = (share, n) => {
    interpolate(s, share, s.stage);
    return argumentsAt(s, t + share * h, s.stage)[n] * s.sides[n];
  };
  for (let n = 0; n < s.ns; n++) {
    let left = 0;
    for (let part = 1; part <= PARTS && s.sides[n] !== 0 && left < best && !s.layout.switches[n][1]; part++) {
      const right = part / PARTS;
      if (value(right, n) < 0) {
        let low = left, high = right;
        for (let k = 0; k < 60 && (high - low) * h > 1e-16 * Math.abs(t); k++) {
          const middle = 0.5 * (low + high);
          if (middle <= low || middle >= high) break;
          if (value(middle, n) < 0) high = middle;
          else low = middle;
        }
        if (high < best) [best, who] = [high, n];
        break;
      }
      left = right;
    }
  }
  return [best, who];
}

// switch `who` changes its side at (t, y), and with it all whose sign has changed, unless again at the same time
function turn(s, t, y, who, h) {
  const again = t - s.lastTurn <= 1e-7 * h;
  argumentsAt(s, t, y);
  for (let n = 0; n < s.ns; n++)
    if (n === who || (!again && s.values[n] * s.sides[n] < 0)) s.sides[n] = -s.sides[n];
  takeFree(s, t, y);
  s.again = again ? s.again + 1 : 0;
  s.lastTurn = t;
}

/** At the end of an accepted step: the switch at which it ended changes its side, with a new derivative. */
export function turnSwitch(s, t) {
  if (!s.ns) return false;
  let turned = false;
  while (s.instants.length && s.instants[0][0] <= t) {
    const [, n] = s.instants.shift();
    s.sides[n] = s.sides[n] === 0 ? 0 : -s.sides[n];
    turned = true;
  }
  if (s.lands > 0) {
    s.h = s.goOn;
    turn(s, t, s.yNew, s.lands - 1, s.goOn);
    turned = true;
  } else takeFree(s, t, s.yNew);
  s.lands = 0;
  forget(s);
  if (turned) s.rates(t, s.yNew, s.fNew);
  forget(s);
  return turned;
}

/** Why a run ends that switches without end. */
export const slides = (s) =>
  `cannot go on at t = ${general(s.lastTurn)} s: ${s.endless} switches to and fro without end, each of its branches`
  + " drives the motion back to the other. Make the change gradual, as tanh(x/width) for sign(x); for dry friction use"
  + " `friction` of a joint or its contact";
