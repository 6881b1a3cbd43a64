// What all forms read of a mechanism: its bodies and parts, its size, and places over the whole motion.

import { pointAt } from "./data.js";
import { placed } from "./play.js";
import { Values } from "./values.js";

const MOST_POSES = 400; // of those that tell how far things reach

export class Stage {
  // size: how large things are drawn [m], where that shall not follow from how far this motion reaches.
  constructor(motion, scene, size = null) {
    this.motion = motion;
    this.geometry = motion.geometry;
    this.bodies = this.geometry.bodies;
    this.kinds = scene.kinds;
    const every = Math.max(1, Math.ceil(motion.n / MOST_POSES));
    this.times = Array.from(motion.t).filter((_, k) => k % every === 0 || k === motion.n - 1);
    this.poses = this.times.map((t) => motion.pose(t));
    this.first = this.poses[0];
    this.drawing = motion.run.drawing ?? scene.drawing;
    this.size = 0; // until it is known: parts whose size follows from it then reach as far as their points
    this.values = new Values(this.drawing.numbers, this);
    for (let round = 0; round < 2; round++) {
      [this.low, this.high] = this.extent();
      this.size = size ?? (Math.max(this.high[0] - this.low[0], this.high[1] - this.low[1]) || 1);
      this.values.renew();
    }
  }

  // All joints and loads that are drawn: {name, form}.
  parts() {
    return ["joints", "loads"].flatMap((family) => Object.entries(this.geometry[family] ?? {})
      .filter(([name, form]) => this.kinds[family]?.[name] && form.bodies.every((body) => body === "ground" || this.first?.[body]))
      .map(([name, form]) => ({ name, form })));
  }

  ends(form, pose) { return form.bodies.map((body, k) => pointAt(pose, body, form.points[k])); }

  // Lower left and upper right corner of the box that holds everything at every time; no smaller than a bush.
  extent() {
    const within = this.drawing.within.map(({ frame, path }) => placed(this.values, frame, path));
    const low = [Infinity, Infinity], high = [-Infinity, -Infinity];
    for (const pose of this.poses) {
      this.values.set(pose, NaN, 0);
      for (const path of within) {
        for (const at of path()) {
          for (const k of [0, 1]) {
            if (at[k] < low[k]) low[k] = at[k];
            if (at[k] > high[k]) high[k] = at[k];
          }
        }
      }
    }
    if (!Number.isFinite(low[0] + high[0] + low[1] + high[1])) return [[-1, -1], [1, 1]];
    const bush = 2 * Math.max(0, ...Object.values(this.geometry.joints).map((form) => form.bush_radius ?? 0));
    if (Math.max(high[0] - low[0], high[1] - low[1]) < bush) {
      return [[0, 1].map((k) => (low[k] + high[k] - bush) / 2), [0, 1].map((k) => (low[k] + high[k] + bush) / 2)];
    }
    return [low, high];
  }
}

// Joints of a motion whose play is a circle in which the path of a pin is drawn: {name: form}.
export function pinsWithPlay(motion, kinds) {
  return Object.fromEntries(Object.entries(motion.geometry.joints).filter(([name, form]) =>
    motion.has(`${name}.ex`) && kinds.play?.[name] === "circle" && form.clearance > 0 && form.contact !== "ideal"));
}
