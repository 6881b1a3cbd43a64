// The checks of every step of a live run, what is said where it ends, and how far it can be trusted.
//
// The measures and limits are those of `simulate` (solvers/step_audit.py, analyses/dynamics/soundness.py): a step after
// which joints are open, or energy is unaccounted for, is not taken.

import { general, trustLines } from "./trust_words.js";

// ---------------------------------------------------------------- checks of every step: see solvers/step_audit.py
// the largest opening of any joint, as a share of the mechanism's size or of a radian
export function checkResidual(s, t, y, before = false) {
  const { rows, extent } = s.layout, { residual } = s;
  s.functions.residual(s.at(t, y), residual);
  let worst = 0, which = 0, length = 0, angle = 0;
  for (let r = 0; r < rows.length; r++) {
    const value = Math.abs(residual[r]), turns = rows[r][1] === "rad", share = turns ? value : value / extent;
    if (!(share <= worst)) [worst, which] = [share, r];
    if (turns) angle = Math.max(angle, value);
    else length = Math.max(length, value);
  }
  if (before) return void (s.correction = worst);
  s.openness = worst;
  s.openRow = which;
  if (!(worst <= s.settings.limits.drift)) return;
  if (length > s.drift || angle > s.driftAngle) s.driftRow = which;
  s.drift = Math.max(s.drift, length);
  s.driftAngle = Math.max(s.driftAngle, angle);
}

// whether joints are closed and the energy is accounted for; the residual function has left both energies
export function stands(s, y, first) {
  const { residual, layout, nm } = s, { limits } = s.settings, at = layout.rows.length;
  const kinetic = residual[at], potential = residual[at + 1], done = y[nm], lost = y[nm + 1];
  const total = kinetic + potential - done + lost;
  if (first) {
    [s.total0, s.work0, s.mostKinetic, s.mostWork, s.least, s.most] = [total, done, kinetic, 0, potential, potential];
    return true;
  }
  const work = Math.abs(done - s.work0), low = Math.min(s.least, potential), high = Math.max(s.most, potential);
  const turnover = Math.max(s.mostKinetic, kinetic, s.mostWork, work, high - low) + s.floor;
  const unrest = Math.max(0, Math.abs(total - s.total0) - 1e-14 * Math.max(Math.abs(low), Math.abs(high)));
  s.unrest = turnover > 0 ? unrest / turnover : unrest;
  if (!(s.unrest <= limits.energy && s.openness <= limits.drift && s.correction <= limits.jump)) return false;
  [s.mostKinetic, s.mostWork, s.least, s.most] = [
    Math.max(s.mostKinetic, kinetic), Math.max(s.mostWork, work), low, high];
  s.mostUnrest = Math.max(s.mostUnrest, unrest);
  return true;
}

// the largest energy error as a share of the energy exchanged so far, with what the tolerances allow
function energyShare(s) {
  const exchanged = Math.max(s.mostKinetic, s.mostWork, s.most - s.least) + s.settings.limits.drift * s.floor;
  return exchanged > 0 ? s.mostUnrest / exchanged : 0;
}

// the energy below which errors are ignored: that of a mechanism at rest, within the tolerances
export function floorOf(s) {
  const { fixed, nb, layout, settings } = s, slow = 1e5 * s.atol;
  let resting = 0;
  for (let n = 0; n < 3 * nb; n++) resting += 0.5 * fixed[n] * (n % 3 === 2 ? slow / layout.extent : slow) ** 2;
  const moment = fixed[3 * nb] + layout.extent * fixed[3 * nb + 1];
  return Math.min((1e2 * s.rtol) / settings.limits.drift, 0.1) * moment + resting;
}

// ---------------------------------------------------------------- the end, in words
export const WEAK = 1e-3; // share of a pivot below which the position is next to a singular one
export const SINGULAR =
  "the mechanism gets to a singular position there (a dead centre, or points that coincide), which a page cannot pass;"
  + " `rattle run` tries to";
export const NOT_FINITE = "a load, driver or signal has no finite value there";
const ANOTHER_WAY =
  "this start is far from that of the model as it is written: if the mechanism can be put together in several ways,"
  + " `rattle run` may take another one";
export const TOO_FAST = "the motion, or a load, driver or signal, changes too fast there, or has no finite value from there on";
export const cannot = (t) => `cannot go on at t = ${general(t)} s`;

export const tooMany = (s) =>
  `ended at t = ${general(s.t)} s after ${s.steps} steps: the rest would take too long in a page; look for lengths,`
  + " masses or stiffnesses out of proportion";
export const diverged = (s, h) =>
  `the motion diverged at t = ${general(s.t)} s with the step of ${general(h, 3)} s; try a smaller step`;

export function unsound(s, tNew) {
  const { rows } = s.layout, { limits } = s.settings, what = [];
  const opened = Math.max(s.openness, s.correction), limit = s.openness > limits.drift ? limits.drift : limits.jump;
  if (!(opened <= limit) && rows.length) {
    const [owner, unit] = rows[s.openRow];
    what.push(`'${owner}' would open by ${general(opened, 2)} ${unit === "rad" ? "rad" : "of the mechanism's size"}`);
  }
  if (!(s.unrest <= limits.energy))
    what.push(`the energy error would be ${general(100 * s.unrest, 2)} % of the largest energy`);
  if (s.tableau.adaptive && s.pivot < WEAK)
    return `ended at t = ${general(s.t)} s, before ${what.join(" and ")}: a singular position (a dead centre, or points that`
      + " coincide); start from another position, or change the lengths slightly";
  const why = !s.tableau.adaptive
    ? `the step of ${general(tNew - s.t, 3)} s is far too long for this motion; choose a shorter step`
    : `the steps are too long for this motion at rtol = ${general(s.rtol)}; choose a smaller rtol or limit the step`;
  return `ended at t = ${general(s.t)} s, before ${what.join(" and ")}: ${why}`;
}

export function trustOf(s, reach) {
  const { layout, settings } = s, balance = s.data.subarray((s.no - 1) * s.times.length).subarray(0, s.written);
  const trust = {
    drift: s.drift, drift_angle: s.driftAngle, drift_joint: s.driftRow < 0 ? "" : layout.rows[s.driftRow][0],
    energy: balance.reduce((most, x) => Math.max(most, Math.abs(x)), s.written ? 0 : NaN),
    energy_share: energyShare(s), t_end: s.t, stopped: s.message !== "", ...pulls(s),
    pending: reach === null && s.written > 1, horizon: reach && reach.time, horizon_motion: reach && reach.motion, horizon_curve: reach ? reach.first : "",
    limits: s.near.length ? ["with limits: the forces next to singular positions are not to be trusted"] : [],
    notes: [...besideSingular(s), ...(s.anotherWay ? [ANOTHER_WAY] : []), ...(s.message ? [] : remarks(s))],
  };
  if (s.tableau.adaptive && settings.rtol > 1e-6)
    trust.notes.push(`rtol = ${general(settings.rtol)} is loose: short contacts may be missed and the horizon may be overestimated`);
  return { ...trust, text: trustLines(trust) };
}

function besideSingular({ near }) {
  if (!near.length) return [];
  const [from, to] = near[0].map((t) => general(t, 6)), more = near.length > 1 ? ` and ${near.length - 1} more times` : "";
  return [`the motion comes next to a singular position near t = ${from} to ${to} s${more}; forces there are not determined,`
    + ` or grow without bound: curves and largest values leave out ${from} to ${to} s${more ? " and so on" : ""}. A page does not`
    + " locate such positions and may miss others: rattle run names their instants"];
}

function pulls(s) {
  const pulled = {}, first_pull = {}, span = Math.max(s.t, 1e-300);
  s.layout.links.forEach((name, n) => {
    const times = s.crossings.filter((one) => one[1] === n).map((one) => one[0]);
    if (s.firstSign && s.firstSign[n] < 0) times.unshift(0);
    if (times.length % 2) times.push(s.t);
    let sum = 0;
    for (let k = 0; k < times.length; k += 2) sum += times[k + 1] - times[k];
    pulled[name] = sum / span;
    first_pull[name] = times.length ? times[0] : null;
  });
  return { pulled, first_pull };
}

function remarks(s) {
  const opened = Math.max(s.drift / s.layout.extent, s.driftAngle), found = [];
  const shorter = !s.tableau.adaptive ? "a shorter step" : "a smaller rtol";
  if (opened > 1e-6)
    found.push(`joints opened by ${general(opened, 2)} of the mechanism's size (or rad): ${shorter} reduces this`);
  if (energyShare(s) > 1e-6)
    found.push(`energy error ${general(energyShare(s), 2)} of the largest energy: ${shorter} reduces it`);
  return found;
}
