// Pins in their bushes and blocks in their guides, magnified: how they lie in their play at one time.

import { make, say } from "./dom.js";
import { Painter, sized } from "./painter.js";
import { blocksWithPlay, pinsWithPlay } from "./stage.js";
import { handyUnit, short, steady } from "./units.js";

const TRAIL = 0.012; // of the motion, whose path is drawn behind the centre of a pin
const PIN = 0.56; // radius of the pin as a share of that of its bush, in the picture

// Path of a pin {x, y, normal} in metres and newtons; on a massless link with the arcs between the rows.
export function pinPath(motion, joint) {
  const x = motion.curve(`${joint}.ex`), y = motion.curve(`${joint}.ey`);
  const normal = motion.has(`${joint}.normal`) ? motion.curve(`${joint}.normal`) : new Float64Array(motion.n);
  if (motion.geometry.joints[joint].contact !== "massless-link" || motion.n < 2) return { x, y, normal, pieces: 1 };
  const pieces = 8, count = pieces * (motion.n - 1) + 1;
  const made = { x: new Float64Array(count), y: new Float64Array(count), normal: new Float64Array(count), pieces };
  for (let k = 0; k < motion.n - 1; k++) {
    const from = Math.atan2(y[k], x[k]), r = Math.hypot(x[k], y[k]);
    let turn = Math.atan2(y[k + 1], x[k + 1]) - from;
    turn -= 2 * Math.PI * Math.round(turn / (2 * Math.PI));
    const grow = Math.hypot(x[k + 1], y[k + 1]) - r;
    for (let i = 0; i < pieces; i++) {
      const f = i / pieces, angle = from + f * turn, n = pieces * k + i;
      made.x[n] = (r + f * grow) * Math.cos(angle);
      made.y[n] = (r + f * grow) * Math.sin(angle);
      made.normal[n] = normal[k] + f * (normal[k + 1] - normal[k]);
    }
  }
  made.x[count - 1] = x[motion.n - 1];
  made.y[count - 1] = y[motion.n - 1];
  made.normal[count - 1] = normal[motion.n - 1];
  return made;
}

// Where a pin is at a time; on a massless link between two rows along the arc.
export function pinNow(motion, joint, path, time) {
  const { k, f } = motion.row(time), place = path.pieces * (k + f), n = Math.min(path.x.length - 1, Math.floor(place));
  const g = place - n, next = Math.min(path.x.length - 1, n + 1);
  return { x: path.x[n] + g * (path.x[next] - path.x[n]), y: path.y[n] + g * (path.y[next] - path.y[n]), n };
}

// The insets of one motion, beside the mechanism.
export class Insets {
  constructor(host) {
    this.host = host;
    this.tiles = [];
  }

  setMotion(motion, scene) {
    this.motion = motion;
    const pins = Object.entries(pinsWithPlay(motion, scene.kinds)).map(([name, form]) => ({ name, form, draw: drawPin }));
    const blocks = Object.entries(blocksWithPlay(motion, scene.kinds)).map(([name, form]) =>
      ({ name, form, draw: scene.kinds.joints[name] === "slot" ? drawInSlot : drawBlock }));
    const every = [...pins, ...blocks];
    if (every.map((one) => one.name).join("\n") !== this.tiles.map((one) => one.name).join("\n")) this.build(every);
    this.tiles.forEach((tile, k) => {
      const { unit, factor } = handyUnit("m", every[k].form.clearance);
      Object.assign(tile, every[k], { path: every[k].draw === drawPin ? pinPath(motion, every[k].name) : null });
      tile.usual = usualForce(motion, tile.name);
      tile.curve = `${tile.name}.${motion.has(`${tile.name}.film_pressure`) ? "force" : "normal"}`;
      const most = motion.has(tile.curve) ? motion.largest(tile.curve) : 0, { factor: of, unit: newtons } = handyUnit("N", most);
      tile.say = { factor: of, unit: newtons, text: steady(of * most, 3), name: tile.curve.endsWith("normal") ? "N" : "force" };
      say(tile.size, `play ${short(factor * tile.form.clearance)} ${unit}`);
    });
    this.host.hidden = !every.length;
  }

  build(every) {
    this.tiles = every.map(({ name }) => {
      const canvas = make("canvas", { role: "img", "aria-label": `${name}, magnified` });
      const size = make("span", { class: "quiet" }), force = make("span", { class: "number" });
      const element = make("figure", { class: "inset" }, make("figcaption", {}, make("b", {}, name), size), canvas, force);
      return { name, canvas, size, force, element };
    });
    this.host.replaceChildren(...this.tiles.map((one) => one.element));
  }

  draw(time, theme) {
    for (const tile of this.tiles) {
      const side = tile.canvas.clientWidth;
      if (!side) continue;
      const context = sized(tile.canvas, side, side), p = new Painter(context, { scale: 1, x: side / 2, y: side / 2 }, theme);
      const normal = this.motion.has(tile.curve) ? this.motion.value(tile.curve, time) : 0;
      const pulls = tile.form.contact === "massless-link" && normal < 0;
      tile.draw(p, this.motion, tile, time, side, pulls);
      say(tile.force, `${tile.say.name} =${tile.say.text(tile.say.factor * normal)} ${tile.say.unit}${pulls ? " would pull" : ""}`);
      tile.force.classList.toggle("bad", pulls);
    }
  }
}

// Force that fills the arrow, so that rare peaks do not shrink it.
function usualForce(motion, joint) {
  if (!motion.has(`${joint}.force`)) return 0;
  const sizes = motion.sample(`${joint}.force`).sort((a, b) => a - b);
  return sizes.length ? sizes[Math.floor(0.8 * (sizes.length - 1))] || sizes[sizes.length - 1] : 0;
}

function forceArrow(p, motion, tile, time, at, side, colour) {
  if (!(tile.usual > 0)) return;
  const fx = motion.value(`${tile.name}.fx`, time), fy = motion.value(`${tile.name}.fy`, time), size = Math.hypot(fx, fy);
  const long = Math.min(size / tile.usual, 1.25) * 0.3 * side;
  if (size > 0) p.arrow(at, [(fx / size) * long, (fy / size) * long], { colour, width: 2.6, cut: size > 1.25 * tile.usual });
}

function drawPin(p, motion, tile, time, side, pulls) {
  const bush = 0.4 * side, c = tile.form.clearance, scale = ((1 - PIN) * bush) / c, { theme } = p;
  const now = pinNow(motion, tile.name, tile.path, time), colour = pulls ? theme.red : theme.black;
  const far = Math.max(1, Math.hypot(now.x, now.y) / (1.35 * c)); // a pin that left its bush stays in the picture
  const at = [(scale * now.x) / far, (scale * now.y) / far];
  p.circle([0, 0], bush + 4, { colour: null, fill: theme.steel });
  p.circle([0, 0], bush, { colour: theme.metal, fill: theme.paper, width: 1.4 });
  p.circle(at, PIN * bush, { colour, fill: pulls ? theme.red : theme.metal, width: 0, opacity: 0.35 });
  p.circle(at, PIN * bush, { colour, width: 1.8 });
  p.circle([0, 0], scale * c, { colour: theme.grey, width: 0.8, dash: [2, 3] });
  const back = Math.max(0, now.n - Math.ceil(TRAIL * tile.path.x.length)), trail = [];
  for (let k = back; k <= now.n; k++) trail.push([scale * tile.path.x[k], scale * tile.path.y[k]]);
  p.line([...trail, at], { colour: theme.curve(5), width: 2 });
  p.dot(at, 3, { colour, fill: colour });
  forceArrow(p, motion, tile, time, at, side, colour);
}

// Play of a block: how far its middle is across the guide, in a frame where the guide is as in the mechanism.
function across(motion, tile, time) {
  const [a, b] = tile.form.bodies, pose = motion.pose(time), start = motion.poseAt(0);
  const axis = pose[a].angle + tile.form.axis, n = [-Math.sin(axis), Math.cos(axis)];
  const off = motion.value(`${tile.name}.ex`, time) * n[0] + motion.value(`${tile.name}.ey`, time) * n[1];
  return { axis, n, off, tilt: pose[b].angle - pose[a].angle - (start[b].angle - start[a].angle) };
}

function walls(p, axis, half, side) {
  const u = [Math.cos(axis), Math.sin(axis)], n = [-u[1], u[0]], reach = 0.44 * side;
  for (const way of [-1, 1]) {
    const ends = [-way, way].map((end) => [0, 1].map((k) => way * half * n[k] - end * reach * u[k]));
    p.wall(...ends, { stroke: 7, colour: p.theme.metal, width: 1.6 });
  }
}

function drawBlock(p, motion, tile, time, side) {
  const { axis, off, tilt } = across(motion, tile, time), c = tile.form.clearance, scale = (0.13 * side) / c;
  const [length] = tile.form.block ?? [4 * c], half = 0.16 * side, long = 0.28 * side;
  walls(p, axis, half + scale * c, side);
  const turn = axis + Math.atan2((scale * tilt * length) / 2, long), u = [Math.cos(turn), Math.sin(turn)];
  const middle = [-Math.sin(axis) * scale * off, Math.cos(axis) * scale * off];
  const corners = [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([i, j]) =>
    [middle[0] + i * long * u[0] - j * half * u[1], middle[1] + i * long * u[1] + j * half * u[0]]);
  p.plate([corners], p.theme.metal, 0.35);
  p.line(corners, { width: 1.8, closed: true });
  p.dot(middle, 3, { fill: p.theme.black });
  forceArrow(p, motion, tile, time, middle, side, p.theme.black);
}

function drawInSlot(p, motion, tile, time, side) {
  const { axis, off } = across(motion, tile, time), c = tile.form.clearance, scale = (0.13 * side) / c, half = 0.2 * side;
  walls(p, axis, half + scale * c, side);
  const middle = [-Math.sin(axis) * scale * off, Math.cos(axis) * scale * off];
  p.circle(middle, half, { colour: p.theme.black, fill: p.theme.steel, width: 1.8 });
  p.dot(middle, 3, { fill: p.theme.black });
  forceArrow(p, motion, tile, time, middle, side, p.theme.black);
}
