// Why a run by the compiled kernels ended early, in words, as far as its workspace tells it: analyses/dynamics/failure.py,
// contact_trouble.py, soundness.py.  `rattle run` looks further, for expressions without a value and positions of lost rank.

import { fill, general } from "./trust_words.js";

const MORE = "; `rattle run` tells more";

export function messageOf(run, data, status) {
  const { t } = run, why = data.words_of_end[status];
  const few = run.tally("STEPS") >= run.mostSteps ? ` after ${run.mostSteps} steps, the most of a page` : "";
  if (!why) return `ended at t = ${general(t)} s${few}; the result holds what was computed before`;
  if (status === data.unsound) return unsoundEnd(run, data);
  const trouble = new Trouble(run, data, status);
  return trouble.ofContacts() || trouble.explained() || `cannot go on at t = ${general(t)} s: ${why}${MORE}`;
}

function unsoundEnd(run, data) {
  const { audit, clock } = run.m.arrays, A = data.at.audit, seen = (name) => audit.data[A[name]], what = [];
  const { limits, method, sentences: { sound: said } } = data.told, opened = Math.max(seen("OPENNESS"), seen("CORRECTION"));
  if (!(opened <= (seen("OPENNESS") > data.limit ? data.limit : limits.TOO_FAR)) && data.rows.length) {
    const [joint, unit] = data.rows[seen("OPEN_ROW")];
    what.push(fill(said.opens, { joint, share: opened, measure: limits.OF_OPENING[unit === "rad" ? 1 : 0] }));
  }
  if (!(seen("UNREST") <= seen("UNREST_LIMIT"))) what.push(fill(said.unrest, { percent: 100 * seen("UNREST") }));
  const step = clock.data[data.at.clock.TROUBLE] - run.t;
  const cause = method.adaptive ? `${data.words_of_end[data.unsound]}${MORE}` : fill(said.step_too_long, { step });
  return fill(said.ended, { t: run.t, what: what.join(" and "), cause });
}

class Trouble {
  constructor(run, data, status) {
    const { told } = data, { loops, method } = told;
    Object.assign(this, { run, data, status, told, t: run.t, arrays: run.m.arrays, S: data.statuses, said: told.sentences });
    this.byEvents = method.loop === loops.by_events;
    this.setValued = this.byEvents || method.loop === loops.equal_steps;
    this.contacts = Array.from({ length: data.contacts }, (_, n) => n);
  }

  value(array, n, column) { return this.run.m.row(this.arrays[array], n).data[this.data.at[array][column]]; }
  contact(n, column) { return Number(this.value("contact", n, column)); }
  of(array, column) { return this.arrays[array].data[this.data.at[array][column]]; }

  // whether a contact is closed, or about to be
  touches(n) {
    const { about } = this.told, near = this.value("contact_kinematics", n, "GAP") < about * this.value("lever", n, "GAP_SIZE");
    const closes = this.contact(n, "LEVEL") !== 1 || this.value("contact_kinematics", n, "DGAP") < about;
    return this.contact(n, "IMPACT") === 1 && (Number(this.arrays.mode.data[n]) !== this.S.OFF || (near && closes));
  }

  rubs(n) { return this.contact(n, "IMPACT") === 1 && this.arrays.values.data[this.contact(n, "NORMAL_P") + this.S.MU] > 0; }

  ofContacts() {
    const { S, status, t, told: { other, rough } } = this, { trouble: said } = this.said;
    if (!this.setValued) return "";
    if (status === S.CHATTER && this.byEvents) return this.chatter();
    const closed = this.contacts.filter((n) => this.touches(n)), sliding = closed.some((n) => this.rubs(n));
    const joints = [...new Set(closed.map((n) => `'${this.run.owners[n]}'`))].join(", ") || said.all_contacts;
    const passed = this.byEvents && !this.of("course", "MAY_PASS") ? said.jam : "";
    if (status === S.NO_SOLUTION && !sliding) return this.dryLocks().length ? "" : this.noWay(closed, joints);
    if (status === S.LOCKED && !sliding) return fill(rough.length ? said.joints_lock : said.depend, { rough: rough.join(", "), joints, t, other });
    const unsolved = this.setValued && this.of("held", "OUTCOME") === S.JAMMED ? said.path_jammed : said.no_solution;
    const sentence = { [S.NO_SOLUTION]: unsolved, [S.NOT_FOUND]: said.not_found, [S.NOT_UNIQUE]: said.several, [S.LOCKED]: said.locks }[status]
      ?? (status === S.STEP_TOO_SMALL && sliding && this.locksNow() ? said.locks : "");
    const more = status === S.NOT_UNIQUE ? MORE : ""; // it may be a dead end
    return sentence ? fill(sentence, { joints, t, passed, other }) + more : "";
  }

  // whether friction nearly locks a contact at the very end
  locksNow() {
    const { limits } = this.told;
    return this.byEvents && this.of("held", "LOCK_SHARE") < limits.NEARLY_GONE && Math.abs(this.of("held", "LOCK_AT") - this.t) <= limits.TINY;
  }

  chatter() {
    const { lock: said } = this.said, { limits, other } = this.told, count = this.of("stuck", "EVENTS_IN_A_ROW");
    const joint = this.run.owners[this.of("stuck", "EVENT_WHO")], close = limits.CROWDED * this.run.end;
    return fill(count > limits.MOST_IN_A_ROW ? said.in_a_row : said.chatter, { count, close, t: this.t, joint, other });
  }

  // contacts without friction leave no motion
  noWay(closed, joints) {
    const { trouble: said } = this.said, { rough, drivers } = this.told, some = (level) => closed.some((n) => this.contact(n, "LEVEL") === level);
    const clutch = some(1), stop = some(0), what = [...(clutch ? [said.clutch] : []), ...(stop || !clutch ? [said.stop] : [])].join(" or ");
    const remedies = [...(drivers.length ? [said.motion] : []), ...(clutch ? [said.torque] : []), ...(stop ? [said.compliant] : [])];
    const rubs = rough.length ? fill(said.rubs, { joints: rough.join(", ") }) : "";
    return fill(drivers.length ? said.driven_on : said.moved_on, { joints, t: this.t, what, rubs, remedy: remedies.join(", or ") });
  }

  dryLocks() { return this.told.dry.filter((_, k) => this.value("dry_memory", k, "DRY_LOCKS") === 1); }

  explained() {
    const { S, status, t, told: { limits, rough, method } } = this, { failure: said } = this.said;
    if (status === S.ESCAPED) return this.escaped();
    const grown = method.adaptive ? this.grown() : "", locked = this.dryLocks();
    if (grown) return grown;
    if (status === S.SLIDES) return this.arrays.switch.shape[0] ? "" : fill(said.to_and_fro, { t, joints: rough.join(", ") });
    if (locked.length) return fill(said.locks, { t, joints: locked.map((joint) => `'${joint}'`).join(", ") });
    const shut = this.contacts.find((n) => this.contact(n, "IMPACT") === 0 && this.value("contact_memory", n, "CLOSED") === this.data.at.contact_memory.SHUT);
    if (shut === undefined || this.of("clock", "H") >= limits.TINY) return "";
    return fill(said.stiff, { t, joint: this.run.owners[shut], least: limits.TINY });
  }

  // a body where no number can follow
  grown() {
    const state = this.arrays.state.data, { limits, bodies } = this.told, nb = bodies.length;
    let worst = 0;
    for (let k = 0; k < 6 * nb; k++) if (Math.abs(state[k]) > Math.abs(state[worst])) worst = k;
    if (!(Math.abs(state[worst]) > limits.BEYOND)) return "";
    const [key, unit] = limits.STATE[(worst % 3) + (worst >= 3 * nb ? 3 : 0)];
    return fill(this.said.failure.grown, { t: this.t, curve: `${bodies[Math.floor(worst / 3) % nb]}.${key}`, value: state[worst], unit });
  }

  // which contact is inside its wall, and by how much
  escaped() {
    const { S, said: { failure: said }, told: { limits } } = this, scale = (n) => this.value("lever", n, "GAP_SCALE");
    const shares = this.contacts.map((n) => -this.value("contact_kinematics", n, "GAP") / scale(n));
    const open = (n) => (this.contact(n, "IMPACT") === 1 ? Number(this.arrays.mode.data[n]) === S.OFF
      : this.value("contact_memory", n, "CLOSED") === this.data.at.contact_memory.OPEN);
    let depth = shares.map((share, n) => (open(n) ? share : -Infinity));
    if (!depth.some((share) => share > 0.1 * limits.DEEP)) depth = shares;
    const n = depth.indexOf(Math.max(...depth)), ofJoint = this.contact(n, "FORCE_COLUMN") === this.data.at.contact.JOINT_NORMAL;
    return fill(said.missed, {
      t: this.of("clock", "TROUBLE"), joint: this.run.owners[n], depth: depth[n] * scale(n),
      unit: this.value("lever", n, "ANGULAR") > 0 ? "rad" : "m", size: ofJoint ? fill(said.clearance, { scale: scale(n) }) : said.its_stop,
    });
  }
}
