// Numbers of a drawing, which follow from dimensions, from the motion as a whole and from where the bodies are now: nodes of
// a tape that name earlier ones by their place.  rattle/drawings/numbers.py writes them, and says what each means.

import { niceStep } from "./units.js";

export const OPERATIONS = {
  "+": (a, b) => a + b, "-": (a, b) => a - b, "*": (a, b) => a * b, "/": (a, b) => a / b, "<": (a, b) => (a < b ? 1 : 0),
  min: (a, b) => (b < a ? b : a), max: (a, b) => (b > a ? b : a), hypot: (a, b) => Math.hypot(a, b), atan2: Math.atan2,
  abs: Math.abs, sin: Math.sin, cos: Math.cos,
  nice: niceStep, acos: (a) => Math.acos(Math.max(-1, Math.min(1, a))), ceil: Math.ceil, round: Math.round, if: (a, b, c) => (a > 0 ? b : c),
};
const MOVING = ["x", "y", "angle", "curve", "pin", "pixel", "side"];
const OVER_TIME = {
  least: (values) => values.reduce((low, value) => (value < low ? value : low), Infinity),
  most: (values) => values.reduce((high, value) => (value > high ? value : high), -Infinity),
  first: (values) => values[0],
};
const usualSize = (values, share) => {
  const sizes = values.map(Math.abs).filter(Number.isFinite).sort((a, b) => a - b);
  return sizes[Math.min(sizes.length - 1, Math.floor(share * sizes.length))] || (sizes.at(-1) ?? 0); // a force that is seldom there
};
const NOWHERE = { x: NaN, y: NaN, angle: NaN, cos: NaN, sin: NaN }; // a body that a motion does not have

export class Values {
  constructor(nodes, stage) {
    Object.assign(this, { nodes, stage, still: [], columns: [], now: [], pose: {}, time: NaN, pixel: NaN, side: NaN });
    this.moves = [];
    for (const node of nodes) {
      const operation = Array.isArray(node) && node[0] in OPERATIONS;
      this.moves.push(operation ? node.slice(1).some((place) => this.moves[place]) : MOVING.includes(node[0]));
    }
  }

  // What follows is asked for at this time; pixel, and side, the shorter one: of the picture [m].
  set(pose, time, pixel, side = NaN) { Object.assign(this, { pose, time, pixel, side, now: [] }); }

  // The size of the mechanism is another.
  renew() { [this.still, this.columns] = [[], []]; }

  get(place) { return ((this.moves[place] ? this.now : this.still)[place] ??= this.find(this.nodes[place])); }

  find(node) {
    if (typeof node === "number") return node;
    const [name, first, second, third] = node;
    const operation = OPERATIONS[name], next = (place) => (place === undefined ? NaN : this.get(place));
    if (operation) return operation(this.get(first), next(second), next(third));
    if (name === "usual") return usualSize(node.slice(2).flatMap((place) => this.over(place)), this.get(first));
    if (name in OVER_TIME) return OVER_TIME[name](this.over(first, name === "first" ? 1 : Infinity));
    if (name === "of") return node.slice(1).reduce((entry, key) => entry?.[key], this.stage.geometry) ?? NaN;
    if (name === "size") return this.stage.size;
    if (name === "pixel" || name === "side") return this[name];
    if (name === "angle") return this.place(first).angle;
    if (name === "curve") return this.stage.motion.has(first) ? this.stage.motion.value(first, this.time) : 0;
    if (name === "pin") return this.stage.motion.pinAt(first.slice(0, -3), this.time)[first.slice(-1)];
    const { x, y, cos, sin } = this.place(first), u = this.get(second), v = this.get(third);
    return name === "x" ? x + cos * u - sin * v : y + sin * u + cos * v;
  }

  // What a number is at the instants of the motion, or at so many of them; once if it does not move.
  over(place, most = Infinity) {
    if (!this.moves[place]) return [this.get(place)];
    if (this.columns[place]) return this.columns[place].slice(0, most);
    const { pose, time, pixel, side, now } = this, { poses, times } = this.stage;
    const values = poses.slice(0, most).map((there, k) => {
      this.set(there, times[k], pixel, side);
      return this.get(place);
    });
    Object.assign(this, { pose, time, pixel, side, now });
    if (most === Infinity) this.columns[place] = values;
    return values;
  }

  place(body) { return this.pose?.[body] ?? NOWHERE; }

  // Origin, angle and stretch of the frame of a body.
  frame(body) {
    const { x, y, angle } = this.place(body);
    return [x, y, angle, 1];
  }
}
