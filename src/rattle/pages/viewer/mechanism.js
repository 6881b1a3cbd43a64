// The mechanism to scale: bodies and parts, paths of points, another motion behind it, forces, and a scale bar.

import { pathOf, pointAt } from "./data.js";
import { Painter, sized } from "./painter.js";
import { ghostPlayer, player } from "./play.js";
import { Stage } from "./stage.js";
import { handyUnit, niceStep, short } from "./units.js";
import { inEnglish } from "./words.js";

const DASHED = [6, 5];

export class MechanismView {
  constructor(canvas, word = inEnglish) {
    this.canvas = canvas;
    this.word = word;
    this.width = this.height = 0;
    this.own = null; // the view that a user chose: {scale, x, y}, or null where everything is shown
  }

  // motion: what is shown; ghosts: [{motion, name}] with it, the ideal mechanism first; size: see Stage.
  setMotion(motion, scene, ghosts, size = null) {
    this.stage = new Stage(motion, scene, size);
    this.units = scene.units;
    const { stage } = this;
    this.layers = Object.fromEntries(["drawn", "arrows", "pins", "names"].map((name) => [name, played(stage, stage.drawing[name])]));
    this.scales = (stage.drawing.scales ?? []).map((scale) => ({ ...scale, draw: played(stage, scale.drawn) }));
    const before = this.ghosts ?? [];
    this.ghosts = ghosts.map(({ motion: other, name }) => before.find((one) => one.motion === other) ?? this.ghostOf(other, scene, name));
    this.reachNow();
  }

  // Scales of the forces and moments that there are in the motion.
  get forces() { return this.scales.filter(({ when }) => this.stage.values.get(when) > 0); }

  ghostOf(motion, scene, name) {
    const stage = new Stage(motion, scene), ideal = name === "ideal";
    const style = { dash: ideal ? [1, 5] : DASHED, own: !ideal };
    const bodies = stage.drawing.drawn.filter((primitive) => primitive.body);
    return { name, motion, stage, drawn: bodies.map((primitive) => ghostPlayer(stage, primitive, style)) };
  }

  // The box that is shown: it stays while a knob is turned, as long as the motion is inside and not much smaller.
  reachNow() {
    const low = [...this.stage.low], high = [...this.stage.high];
    const inside = this.low && [0, 1].every((k) => this.low[k] <= low[k] + 1e-9 && this.high[k] >= high[k] - 1e-9);
    const size = Math.max(high[0] - low[0], high[1] - low[1]);
    const large = this.low && Math.max(this.high[0] - this.low[0], this.high[1] - this.low[1]);
    if (inside && large < 1.3 * size) return;
    this.low = low;
    this.high = high;
  }

  // Height of the picture over its width, for places where it may have the height it needs.
  get tall() { return (this.high[1] - this.low[1]) / Math.max(this.high[0] - this.low[0], 1e-9); }

  get view() {
    if (this.own) return this.own;
    const side = Math.min(this.width, this.height), edge = Math.max(22, 0.07 * side) + (this.roomy ? 0.09 * side : 0), below = edge + 26, above = Math.max(edge, 56); // room for the scale bar and the tools
    const spans = [0, 1].map((k) => this.high[k] - this.low[k]), least = Math.max(...spans) > 0 ? 1e-9 : 1; // a point that rests
    const [wide, tall] = spans.map((span) => Math.max(span, least));
    const room = [Math.max(20, this.width - 2 * edge), Math.max(20, this.height - above - below)];
    const scale = Math.min(room[0] / wide, room[1] / tall);
    const middle = [0, 1].map((k) => (this.low[k] + this.high[k]) / 2);
    return { scale, x: this.width / 2 - scale * middle[0], y: above + room[1] / 2 + scale * middle[1] };
  }

  fit() { this.own = null; }

  zoom(x, y, factor) {
    const { scale, x: ox, y: oy } = this.view;
    const f = Math.max(1e-3, Math.min(1e7, scale * factor)) / scale;
    this.own = { scale: scale * f, x: x + (ox - x) * f, y: y + (oy - y) * f };
  }

  pan(dx, dy) {
    const view = this.view;
    this.own = { ...view, x: view.x + dx, y: view.y + dy };
  }

  // show: {forces, ghost, names, traces: [names], plain: without grid and scales}
  draw(time, theme, show) {
    this.theme = theme;
    this.roomy = show.forces;
    const context = sized(this.canvas, this.width, this.height), p = new Painter(context, this.view, theme);
    const { stage } = this, pose = stage.motion.pose(time);
    if (!show.plain) this.grid(p); // on a sheet of its own
    this.traces(p, time, show);
    const side = Math.min(this.width, this.height), layer = (name) => this.layers[name].forEach((draw) => draw(p));
    stage.values.set(pose, time, p.metres(1), p.metres(side));
    layer("drawn");
    for (const ghost of this.ghosts) { // on top: its bars lie within a bar's width
      if (ghost.name === "ideal" && !show.ghost) continue;
      ghost.stage.values.set(ghost.motion.pose(time), time, p.metres(1));
      for (const draw of ghost.drawn) draw(p);
    }
    show.traces.forEach((name, n) => { // ends of the paths on top of what moves them
      const colour = theme.curve(n);
      if (!pathOf(stage.motion, name)) return;
      p.dot([stage.motion.value(`${name}.x`, time), stage.motion.value(`${name}.y`, time)], 4, { colour: theme.paper, fill: colour });
    });
    if (show.forces) layer("arrows");
    layer("pins");
    if (show.names) layer("names");
    if (!show.plain) this.legend(p, show, side, pose, time);
    if (this.over) this.hover(p, pose, time);
  }

  // What lies under the mouse: the name of a joint, load or point, and the force there.
  hover(p, pose, time) {
    const { stage } = this, { motion } = stage, found = [];
    const add = (text, at) => {
      const far = Math.hypot(p.X(at[0]) - this.over[0], p.Y(at[1]) - this.over[1]);
      if (far < 16) found.push({ text, at, far });
    };
    for (const part of stage.parts()) {
      const force = motion.has(`${part.name}.force`) ? `${part.name}.force` : null, { factor, unit } = handyUnit(force ? motion.unit(force) : "", force ? motion.largest(force) : 0, this.units);
      const text = `${part.name}, ${this.word(part.form.type)}${force ? `, ${short(factor * motion.value(force, time))} ${unit}` : ""}`;
      for (const at of stage.ends(part.form, pose)) add(text, at);
    }
    for (const body of Object.keys(stage.bodies).filter((one) => pose[one])) {
      for (const [point, at] of Object.entries(stage.bodies[body].points)) add(`${body}.${point}`, pointAt(pose, body, at));
    }
    const lines = found.sort((a, b) => a.far - b.far).map((one) => one.text);
    [...new Set(lines)].slice(0, 4).forEach((text, k) => p.tag(text, found[0].at, { dx: 14, dy: 26 + 17 * k }));
  }

  grid(p) {
    const { context, theme } = p, step = niceStep(p.metres(84));
    const { unit, factor } = handyUnit("m", step, this.units);
    context.strokeStyle = theme.faint;
    context.lineWidth = 1;
    context.beginPath();
    const from = (pixel) => Math.ceil((pixel - p.view.x) / p.view.scale / step), line = (X, Y, toX, toY) => {
      context.moveTo(X, Y);
      context.lineTo(toX, toY);
    };
    for (let k = from(0); p.X(k * step) < this.width; k++) line(Math.round(p.X(k * step)) + 0.5, 0, Math.round(p.X(k * step)) + 0.5, this.height);
    for (let k = Math.floor(p.view.y / p.view.scale / step); p.Y(k * step) < this.height; k--) line(0, Math.round(p.Y(k * step)) + 0.5, this.width, Math.round(p.Y(k * step)) + 0.5);
    context.stroke();
    this.bar = { length: step * p.view.scale, text: `${short(factor * step)} ${unit}` };
  }

  traces(p, time, show) {
    show.traces.forEach((name, n) => {
      const colour = p.theme.curve(n), { motion } = this.stage, path = pathOf(motion, name);
      if (!path) return;
      const all = Array.from({ length: motion.n }, (_, k) => [path.x[k], path.y[k]]), { k, f } = motion.row(time);
      p.line(all, { colour, width: 1, opacity: 0.4 });
      const now = [motion.value(`${name}.x`, time), motion.value(`${name}.y`, time)];
      p.line([...all.slice(0, k + 1), ...(f ? [now] : [])], { colour, width: 2 });
      for (const ghost of this.ghosts.filter((one) => one.name !== "ideal" || show.ghost)) {
        const other = pathOf(ghost.motion, name);
        if (other) p.line(Array.from(other.x, (x, i) => [x, other.y[i]]), { colour, width: 1.1, dash: DASHED, opacity: 0.7 });
      }
    });
  }

  // The scale bar at the lower left, the scale of forces at the lower right.
  legend(p, show, side, pose, time) {
    const { context, theme } = p, y = this.height - 14, { length, text } = this.bar;
    p.scaleBar(text, length, this.height);
    if (!show.forces) return;
    const { values } = this.stage, { forces } = this;
    context.textAlign = "right";
    values.set(pose, time, 1, side);
    forces.forEach(({ text: what, unit, line: [name], step, wide, draw }, k) => {
      const base = y - 22 * (forces.length - 1 - k), size = values.get(step), handy = handyUnit(unit, size), across = values.get(wide);
      const room = Math.max(80, this.width - across - length - 52); // right of the scale bar
      context.fillStyle = theme[name];
      context.fillText(`${short(handy.factor * size)} ${handy.unit} ${this.word(what)}`, this.width - 26 - across, base + 4, room);
      const corner = new Painter(context, { x: this.width - 16 - across, y: base, scale: 1 }, theme);
      for (const play of draw) play(corner);
    });
  }
}

const played = (stage, primitives = []) => primitives.map((primitive) => player(stage, primitive));
