// What all forms read of a mechanism: its bodies and parts, its size, and places over the whole motion.

import { bodyColours } from "./colours.js";
import { pointAt } from "./data.js";
import { FORMS } from "./forms.js";

const MOST_POSES = 400; // of those that tell how far things reach

export class Stage {
  constructor(motion, scene) {
    this.motion = motion;
    this.geometry = motion.geometry;
    this.bodies = this.geometry.bodies;
    this.kinds = scene.kinds;
    this.colours = { ...bodyColours(Object.keys(this.bodies)), ...scene.colours };
    const every = Math.max(1, Math.ceil(motion.n / MOST_POSES));
    this.poses = [];
    for (let k = 0; k < motion.n; k += every) this.poses.push(motion.poseAt(k));
    if (motion.n && (motion.n - 1) % every) this.poses.push(motion.poseAt(motion.n - 1));
    this.first = this.poses[0];
    this.size = 0; // until it is known: parts whose size follows from it then reach as far as their points
    for (let round = 0; round < 2; round++) {
      [this.low, this.high] = this.extent();
      this.size ||= Math.max(this.high[0] - this.low[0], this.high[1] - this.low[1]) || 1;
    }
  }

  // All joints and loads that are drawn: {name, family, form, driven, drawing}.
  parts() {
    const found = [];
    for (const family of ["joints", "loads"]) {
      for (const [name, form] of Object.entries(this.geometry[family] ?? {})) {
        const drawing = FORMS[this.kinds[family]?.[name]];
        if (drawing && form.bodies.every((body) => body === "ground" || this.first?.[body])) {
          found.push({ name, family, form, driven: this.geometry.driven.includes(name), drawing });
        }
      }
    }
    return found;
  }

  points(body) { return Object.values(this.bodies[body]?.points ?? {}); }

  // Points of a body up to which it is drawn because of slots and guides that it carries.
  held(body) {
    return this.parts().flatMap(({ form, drawing }) => drawing.holds?.(form, this) ?? []).filter(([one]) => one === body).map(([, point]) => point);
  }

  rings(body) { return this.bodies[body]?.outline ?? []; }

  ends(form, pose) { return form.bodies.map((body, k) => pointAt(pose, body, form.points[k])); }

  // Lowest and highest value of a function of the pose over the motion.
  range(value) {
    let low = Infinity, high = -Infinity;
    for (const pose of this.poses) {
      const one = value(pose);
      if (one < low) low = one;
      if (one > high) high = one;
    }
    return Number.isFinite(low + high) ? [low, high] : [0, 0];
  }

  // Lower left and upper right corner of the box that holds everything at every time; no smaller than a bush.
  extent() {
    const reach = [];
    for (const body of Object.keys(this.bodies)) {
      if (!this.first?.[body]) continue;
      for (const point of [...this.rings(body).flat(), ...this.points(body), [0, 0]]) reach.push([body, point]);
    }
    for (const part of this.parts()) reach.push(...part.drawing.reach(part.form, this));
    const low = [Infinity, Infinity], high = [-Infinity, -Infinity];
    for (const pose of this.poses) {
      for (const [body, point] of reach) {
        const at = pointAt(pose, body, point);
        for (const k of [0, 1]) {
          if (at[k] < low[k]) low[k] = at[k];
          if (at[k] > high[k]) high[k] = at[k];
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
  return joints(motion, (name, form) => kinds.play?.[name] === "circle" && form.clearance > 0 && form.contact !== "ideal");
}

// Joints of a motion whose play is between walls: blocks in guides, pins in slots: {name: form}.
export function blocksWithPlay(motion, kinds) {
  return joints(motion, (name, form) => kinds.play?.[name] === "walls" && form.clearance > 0 && form.contact !== "ideal");
}

function joints(motion, chosen) {
  return Object.fromEntries(
    Object.entries(motion.geometry.joints).filter(([name, form]) => motion.has(`${name}.ex`) && chosen(name, form)));
}
