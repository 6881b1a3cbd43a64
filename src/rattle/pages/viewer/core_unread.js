// Which curves of rigid contacts tower, so that their largest value says nothing of a real one, and what is shown of them:
// results/contact_summary.py, results/within_steps.py.

const PEAK_FORCE = 5; // place in the list of an event

/** The curves of a result as `contact_summary` reads them; told: of `pages.trust_data`; between: {t, y} by name. */
export class ReadCurves {
  constructor({ units, t, columns, peaks, trust }, told, between = {}) {
    Object.assign(this, { units: { ...units }, t, columns: { ...columns }, peaks, trust, told, between });
    for (const joint of told.joints) { // derived curves, which no run stores
      const fx = columns[`${joint}.fx`], fy = columns[`${joint}.fy`], name = `${joint}.force`;
      if (fx && !columns[name]) Object.assign(this.columns, { [name]: fx.map((x, k) => Math.hypot(x, fy[k])) });
      this.units[name] = "N";
    }
    this.owners = new Set(told.joints);
    this.unread = [];
    if (t.length && told.rigid.length) this.unread = told.joints.filter((joint) => this.has(`${joint}.force`) && !this.readable(`${joint}.force`));
  }

  has(name) { return Boolean(this.columns[name]); }

  /** Largest magnitude and its time. */
  peak(name) {
    if (this.peaks[name]) return this.peaks[name];
    let best = NaN, when = NaN;
    for (const { t, y } of this.parts(name)) y.forEach((x, k) => { if (Math.abs(x) > best || (Number.isNaN(best) && !Number.isNaN(x))) [best, when] = [Math.abs(x), t[k]]; });
    return [best, when];
  }

  parts(name) {
    const whole = { t: this.t, y: this.columns[name] };
    return this.between[name] ? [whole, this.between[name]] : [whole];
  }

  rms(name) {
    if (this.peaks[name]) return this.peaks[name][2];
    const { t } = this, y = this.columns[name];
    let sum = 0, span = 0;
    for (let k = 1; k < t.length; k++) {
      if (!Number.isFinite(y[k]) || !Number.isFinite(y[k - 1])) continue;
      sum += 0.5 * (y[k] ** 2 + y[k - 1] ** 2) * (t[k] - t[k - 1]);
      span += t[k] - t[k - 1];
    }
    return span > 0 ? Math.sqrt(sum / span) : Math.abs(y[0]);
  }

  // a force that is usual while there is one
  usual(name) {
    const { USUAL, ENOUGH } = this.told.limits, pressing = this.columns[name].map(Math.abs).filter((x) => x > 0 && x < Infinity);
    if (pressing.length < ENOUGH) return this.rms(name);
    pressing.sort();
    const place = USUAL * (pressing.length - 1), k = Math.floor(place), above = pressing[Math.min(k + 1, pressing.length - 1)];
    return Math.min(this.rms(name), pressing[k] + (place - k) * (above - pressing[k]));
  }

  mostReadable(name) {
    const unit = this.units[name], cut = name.lastIndexOf("."), owner = name.slice(0, cut), { RISING, TOWERS } = this.told.limits;
    if (!RISING.includes(unit)) return Infinity;
    const ofContact = this.owners.has(owner) && (unit === "N" || name.slice(cut + 1) === "stop");
    return !ofContact && !this.unread?.length ? Infinity : TOWERS * this.usual(name);
  }

  readable(name) {
    const [value] = this.peak(name);
    if (!Number.isFinite(value) || this.gapBeside(name) !== null) return false;
    return !this.told.rigid.length || value <= this.mostReadable(name);
  }

  // the singular position towards which a curve grows
  gapBeside(name) {
    if (!this.peaks[name]) return null;
    const when = this.peaks[name][1], { gaps, singular } = this.trust;
    const k = gaps.findIndex(([since, until]) => [since, until].some((edge) => Math.abs(when - edge) <= this.told.limits.ON_EDGE * (until - since)));
    return k < 0 ? null : singular[k];
  }

  /** Those joints that can lose contact, with the name of the force of their contacts. */
  get touching() {
    const { joints, loose, stops } = this.told, force = (joint, what) => (this.has(`${joint}.${what}`) ? [[joint, `${joint}.${what}`]] : []);
    return joints.flatMap((joint) => {
      const normal = loose.includes(joint) ? force(joint, "normal") : [];
      return normal.length || !stops.includes(joint) ? normal : force(joint, "stop");
    });
  }

  /** The magnitude up to which a curve is shown. */
  shownLimit(name) {
    if (!this.t.length || !this.told.rigid.length || this.readable(name)) return Infinity;
    return this.told.limits.TOWERS * this.usual(name);
  }
}

const cut = (values, limit) => values.map((x) => (Math.abs(x) <= limit ? x : NaN));

/**
 * What a page shows of a result: curves that tower are cut, and their largest values and those of events left out.
 * told: of `pages.trust_data`; between: {t, y} by name, values beside events.
 */
export function shownOf(result, told, between = {}) {
  const read = new ReadCurves(result, told, between), columns = { ...result.columns }, peaks = { ...result.peaks }, beside = { ...between };
  for (const name of result.names) {
    const limit = read.shownLimit(name);
    if (limit === Infinity) continue;
    columns[name] = cut(columns[name], limit);
    if (beside[name]) beside[name] = { t: beside[name].t, y: cut(beside[name].y, limit) };
  }
  for (const name of Object.keys(peaks))
    if (read.has(name) && (read.shownLimit(name) < Infinity || read.gapBeside(name) !== null)) delete peaks[name];
  const unread = new Set(read.touching.filter(([, force]) => !read.readable(force)).map(([joint]) => joint));
  const events = result.events.map((event) => { // lists as those of a scene
    const [, joint] = event, force = event[PEAK_FORCE];
    return unread.has(joint) && force ? event.map((value, k) => (k === PEAK_FORCE ? null : value)) : event;
  });
  return { columns, peaks, events, between: beside };
}
