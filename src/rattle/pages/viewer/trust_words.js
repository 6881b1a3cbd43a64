// What is said of a run's accuracy, in the words that `str(r.trust)` prints; numbers as Python formats them.

/** A number as Python's format "g" with so many digits writes it. */
export function general(x, digits = 6) {
  if (!Number.isFinite(x)) return Number.isNaN(x) ? "nan" : x > 0 ? "inf" : "-inf";
  if (x === 0) return Object.is(x, -0) ? "-0" : "0";
  const [mantissa, power] = x.toExponential(digits - 1).split("e"), size = Number(power);
  if (size >= -4 && size < digits) return String(Number(x.toPrecision(digits)));
  const sign = size < 0 ? "-" : "+";
  return `${Number(mantissa)}e${sign}${String(Math.abs(size)).padStart(2, "0")}`;
}

const short = (x) => general(x, 1).replace("e-0", "e-");

function accuracy(trust) {
  const where = trust.drift_joint && trust.drift > 0 ? ` (worst at ${trust.drift_joint})` : "";
  const energy = Number.isNaN(trust.energy) ? "" : `, energy error ${short(Math.abs(trust.energy))} J`;
  const share = trust.energy_share > 1e-6 ? ` (${short(trust.energy_share)} of the largest energy)` : "";
  const angle = trust.drift_angle > trust.drift ? ` and ${short(trust.drift_angle)} rad` : "";
  return `constraint error ${short(trust.drift)} m${angle}${where}${energy}${share}`;
}

function reach(trust) {
  const { horizon, t_end: end, stopped } = trust;
  if (horizon === null) return `how long the curves can be trusted ${trust.pending ? "is being" : "was not"} computed`;
  let whole = `up to where the run ended, t = ${general(end, 4)} s`;
  if (!stopped) whole = `over the whole run, to t = ${general(end, 4)} s`;
  const agree = horizon >= end || (stopped && !trust.horizon_curve);
  if (agree && horizon > 0) return `the curves can be trusted ${whole}`;
  const motion = trust.horizon_motion;
  if (motion !== null && motion > 2 * horizon) {
    const until = motion >= end ? whole : `up to t = ${general(motion, 3)} s (horizon)`;
    const first = trust.horizon_curve ? ` (${trust.horizon_curve} deviates first)` : "";
    return `positions and rates can be trusted ${until}, all other curves up to t = ${general(horizon, 3)} s${first}`;
  }
  return `the curves can be trusted up to t = ${general(horizon, 3)} s (horizon), after it statistics only`;
}

function howMuch(trust, joint) {
  const share = 100 * trust.pulled[joint], first = trust.first_pull[joint];
  const part = share >= 1 ? `for ${share.toFixed(0)} % of the run` : "for less than 1 % of the run";
  return first === null ? part : `${part}, first at t = ${general(first, 4)}${first ? " s" : ""}`;
}

function links(trust) {
  const names = Object.keys(trust.pulled);
  const pulling = names.filter((j) => trust.pulled[j] > 0).sort((a, b) => trust.pulled[b] - trust.pulled[a]);
  if (!names.length) return "";
  if (!pulling.length)
    return `${names.join(" and ")} would never have to pull: the pin stays on its bush all the time`;
  const said = pulling.slice(0, 3).map((j, n) => `${j} ${n === 0 ? "would have to pull " : ""}${howMuch(trust, j)}`);
  const more = pulling.length > 3 ? [`${pulling.length - 3} more pins`] : [];
  const pin = pulling.length === 1 ? "the pin" : "these pins";
  return `${[...said, ...more].join(", and ")}: ${pin} would lift off; this model does not hold there`;
}

/** The lines of `str(r.trust)`. */
export function trustLines(trust) {
  const remarks = [links(trust), ...trust.notes].filter((one) => one).join("; ");
  return remarks ? [`${accuracy(trust)}; ${reach(trust)}`, remarks] : [accuracy(trust), reach(trust)];
}
