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

/** A sentence of the package with values put in as `str.format` does it. */
export function fill(sentence, values = {}) {
  return sentence.replace(/\{\{|\}\}|\{(\w+)(?::([^}]*))?\}/g, (whole, name, form = "") => {
    if (!name) return whole[0];
    const value = values[name];
    if (typeof value !== "number" || !form) return String(value);
    return form.endsWith("f") ? value.toFixed(Number(form.slice(1, -1))) : general(value, Number(form.slice(1, -1) || 6));
  });
}

const short = (x) => general(x, 1).replace("e-0", "e-");

function accuracy(trust) {
  const where = trust.drift_joint && trust.drift > 0 ? ` (worst at ${trust.drift_joint})` : "";
  const energy = Number.isNaN(trust.energy) ? "" : `, energy error ${short(Math.abs(trust.energy))} J`;
  const share = trust.energy_share > 1e-6 ? ` (${short(trust.energy_share)} of the largest energy)` : "";
  const angle = trust.drift_angle > trust.drift ? ` and ${short(trust.drift_angle)} rad` : "";
  return `constraint error ${short(trust.drift)} m${angle}${where}${energy}${share}`;
}

function reach(trust, words) {
  const { horizon, t_end: end, stopped, locked } = trust;
  if (horizon === null) return `how long the curves can be trusted ${trust.pending ? "is being" : "was not"} computed`;
  let whole = `up to where the run ended, t = ${general(end, 4)} s`;
  if (!stopped) whole = `over the whole run, to t = ${general(end, 4)} s`;
  const agree = horizon >= end || (stopped && !trust.horizon_curve && !locked);
  if (agree && horizon > 0) return `the curves can be trusted ${whole}`;
  if (locked) return fill(words.reach_of_lock, { t: horizon, lock: lockOf(trust, words) });
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

const lockOf = ({ locked }, words) => fill(words.lock, { joint: locked });

function touching({ contact_count: contacts, impact_count: impacts, fewest_steps: steps, few }, words) {
  if (contacts === null || contacts === undefined || !words) return "";
  const counts = [[contacts, "contact"], [impacts, "impact"]].filter(([n]) => n).map(([n, what]) => `${n} ${what}${n === 1 ? "" : "s"}`);
  if (!counts.length) return words.no_contact;
  if (steps === null) return counts.join(" and ");
  const said = `${steps.toFixed(0)} step${Math.round(steps) === 1 ? "" : "s"}`;
  return fill(words.shortest, { counts: counts.join(" and "), steps: said }) + (steps < few ? words.coarse : "");
}

/** The lines of `str(r.trust)`; words: its sentences, of `pages.trust_data`, which runs with contacts need. */
export function trustLines(trust, words = null) {
  const nonunique = trust.nonunique?.length ? [fill(words.nonunique, { joints: trust.nonunique.join(", ") })] : [];
  const remarks = [links(trust), touching(trust, words), ...nonunique, ...trust.notes].filter((remark) => remark).join("; ");
  return remarks ? [`${accuracy(trust)}; ${reach(trust, words)}`, remarks] : [accuracy(trust), reach(trust, words)];
}

// what is not trusted within the time of the verdict
function excepted({ unread, singular }, words) {
  const times = singular.slice(0, 3).map((t) => general(t, 4)).join(", ") + (singular.length > 3 ? ", ..." : "");
  return [
    ...(unread.length ? [fill(words.unread, { joints: unread.join(", ") })] : []),
    ...(singular.length ? [fill(words.singular, { times })] : []),
  ].join(" and ");
}

function verdict(trust, words) {
  const { horizon, t_end: end, horizon_motion: motion } = trust;
  const starts = Object.entries(trust.pulled).filter(([, share]) => share > 0).map(([joint]) => trust.first_pull[joint] ?? 0);
  const first = Math.min(...starts), until = horizon === null ? null : Math.min(horizon, ...starts);
  if (starts.length && (until === null || first <= until)) return fill(first ? words.before_a_pull : words.from_a_pull_on, { t: first, links: links(trust) });
  if (until === null) return trust.pending ? "how far it can be trusted is being computed" : words.unknown;
  if (trust.energy_share > trust.poor) return fill(words.unaccounted, { percent: 100 * trust.energy_share });
  if (trust.locked) return fill(words.before_a_lock, { t: until, lock: lockOf(trust, words) });
  if (trust.stopped && (until >= end || !trust.horizon_curve)) return fill(words.before_the_end, { t: end });
  if (until >= end) return words.whole;
  if (motion !== null && motion > 2 * until)
    return fill(words.motion, { reach: motion >= end ? words.over_all : fill(words.up_to, { t: motion }), t: until });
  return fill(words.horizon, { t: until });
}

// `Trust.word`
function wordOf(trust, words) {
  const said = verdict(trust, words), but = excepted(trust, words);
  if (!but) return said;
  return fill(said.startsWith("trusted") || said.startsWith("positions") ? words.but_not : words.in_no_case, { verdict: said, excepted: but });
}

/** Trust with its words: text as `str(r.trust)`, word, and limits; where friction nearly locks a contact it ends. */
export function trusted(given, words) {
  const { horizon, lock, t_end: end } = given, trust = { ...given, locked: "" };
  if (horizon !== null && lock && lock.t < Math.min(horizon, end))
    Object.assign(trust, { locked: lock.joint, horizon: lock.t, horizon_motion: Math.min(given.horizon_motion, lock.t) });
  const word = wordOf(trust, words), unknown = trust.horizon === null && !trust.pending;
  const limited = trust.unread.length || trust.singular.length || trust.locked || trust.energy_share > trust.poor || unknown;
  return { ...trust, word, limits: limited ? [word] : [], text: trustLines(trust, words) };
}
