// Time of the motion: how it goes on while it plays.

const MANTISSAS = [1, 2, 5];
const LASTS = 5; // seconds that a motion lasts at least when it is first played

// Speeds to choose from: of the animation relative to the motion; below 0.01 for short motions only.
export function speedsFor(span) {
  const found = [];
  for (let power = -5; power <= 1; power++) for (const one of MANTISSAS) found.push(Number((one * 10 ** power).toPrecision(1)));
  return found.filter((one) => one <= 10 && (one >= 0.01 || (span > 0 && one >= 0.2 * span / LASTS)));
}

export function usualSpeed(span) {
  const fit = speedsFor(span).filter((one) => span / one >= LASTS);
  return fit.length ? Math.min(fit[fit.length - 1], 10) : speedsFor(span)[0];
}

export class Clock {
  constructor() {
    this.time = 0;
    this.playing = false;
    this.loop = true;
    this.speed = 1;
    this.last = null; // when the last frame was [ms]
  }

  setMotion(motion) {
    this.motion = motion;
    this.speeds = speedsFor(motion.span);
    this.time = Math.max(motion.start, Math.min(motion.end, this.time));
  }

  play() {
    if (!this.motion.span) return;
    if (this.time >= this.motion.end) this.time = this.motion.start;
    this.playing = true;
    this.last = null;
  }

  pause() { this.playing = false; }

  seek(t) {
    if (Number.isFinite(t)) this.time = Math.max(this.motion.start, Math.min(this.motion.end, t));
  }

  // Rows forwards or backwards from the time shown.
  step(rows) {
    const { t, n } = this.motion, { k, f } = this.motion.row(this.time);
    const from = rows < 0 && f > 0 ? k + 1 : k;
    this.time = t[Math.max(0, Math.min(n - 1, from + rows))] ?? 0;
  }

  faster(way) {
    const near = this.speeds.reduce((best, one, k) => (Math.abs(Math.log(one / this.speed)) < Math.abs(Math.log(this.speeds[best] / this.speed)) ? k : best), 0);
    this.speed = this.speeds[Math.max(0, Math.min(this.speeds.length - 1, near + way))];
  }

  // Go on to a frame [ms]; after a pause of the page (hidden, busy) it goes on from where it was.
  advance(now) {
    const passed = this.last === null ? 0 : Math.min(100, now - this.last);
    this.last = now;
    if (!this.playing) return;
    const { start, end, span } = this.motion;
    let time = this.time + (this.speed * passed) / 1000;
    if (time > end && this.loop) time = start + ((time - start) % (span || 1));
    else if (time >= end) {
      time = end;
      this.playing = this.loop;
    }
    this.time = time;
  }
}
