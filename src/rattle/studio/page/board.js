// The sheet on which one draws: the mechanism as it stands, a grid of snaps, ghosts of what is being drawn, a photograph
// below.  Places are in metres of the ground plane; the view says where they are on the screen.

import { h } from "./dom.js";
import { MechanismView, Motion, Painter, plain, sized, themeOf } from "./viewer.js";

const WIDE = 0.6; // of an empty sheet [m]
const COARSEST = 0.01; // snap of an empty sheet [m]
const MOST = 20; // pixels of a snap, which then has 8 at least
const MARGIN = 0.15; // of a fitted drawing
const POINT = 1e-12; // extent below which a drawing is one place [m], and share of how far away it is
const STEADY = 1.6; // a drawing that is no more than so many times larger or smaller keeps the width of its bars

export class Board {
  constructor() {
    this.below = h("canvas", { class: "below", "aria-hidden": "true" });
    this.canvas = h("canvas", { class: "mechanism", "aria-hidden": "true" });
    this.above = h("canvas", { class: "above", tabindex: 0, role: "application", "aria-label": "Sheet",
      "aria-describedby": "edit-help" });
    this.el = h("div", { class: "board" }, this.below, this.canvas, this.above);
    this.still = new MechanismView(this.canvas);
    this.moving = new MechanismView(this.canvas);
    this.view = null; // {scale, x, y}
    this.begins = true; // the next drawing is of another model: it is shown as a whole
    this.drawing = null; // what the studio told last
    this.marks = []; // drawn in front: functions of a painter
    this.photo = null;
    this.turnTheme(false);
    new ResizeObserver(() => this.resized()).observe(this.el);
  }

  turnTheme(dark) {
    this.dark = dark;
    this.theme = themeOf(dark, this.drawing?.scene?.colours ?? {});
    this.invalidate();
  }

  get width() { return this.el.clientWidth; }
  get height() { return this.el.clientHeight; }

  // The sheet keeps its upper left corner, unless something that was seen would be outside of it then.
  resized() {
    if (this.view && this.drawing && [...this.outside()].some((name) => !this.away?.has(name))) this.fit();
    this.invalidate();
  }

  // ---------------------------------------------------------------- what is shown
  // drawing: as the studio tells it, see rattle.sketch.picture; places of bodies may differ while one pulls.
  show(drawing) {
    this.drawing = drawing;
    this.pulled = null;
    this.theme = themeOf(this.dark, drawing.scene?.colours ?? {});
    this.motion = drawing.scene ? new Motion(drawing.scene.runs[0], drawing.scene) : null;
    if (this.motion) this.drawAsBefore(this.motion, drawing.scene);
    const away = this.view && this.outside();
    if (!this.view || this.begins || [...away].some((name) => !this.away?.has(name))) this.fit();
    else this.away = away;
    this.begins = false;
    this.invalidate();
  }

  // Bars keep their width from act to act, and in the motion that runs.
  drawAsBefore(motion, scene) {
    this.still.setMotion(motion, scene, []);
    const { stage } = this.still, size = Math.max(stage.high[0] - stage.low[0], stage.high[1] - stage.low[1]) || 1;
    if (!(size < STEADY * this.size && size > this.size / STEADY)) this.size = size;
    this.still.setMotion(motion, scene, [], this.size);
  }

  // Bodies stand elsewhere while they are pulled by hand: {body: [x, y, angle]}, or null.
  pull(places) {
    this.pulled = places;
    this.invalidate();
  }

  get geometry() { return this.drawing?.scene?.geometry ?? { bodies: {}, ground: { points: {} } }; }

  // Where a body stands on the sheet now: {x, y, angle, cos, sin}.
  placeOf(body) {
    if (body === "ground") return { x: 0, y: 0, angle: 0, cos: 1, sin: 0 };
    if (this.running) return this.running.motion.pose(this.running.time)[body] ?? null;
    const place = this.pulled?.[body] ?? this.drawing?.places[body];
    return place ? { x: place[0], y: place[1], angle: place[2], cos: Math.cos(place[2]), sin: Math.sin(place[2]) } : null;
  }

  // Where "body.point" is on the sheet now, [x, y]; null if there is no such point.
  position(name) {
    const [body, point] = name.split(/\.(.*)/s);
    if (body === "ground") return this.drawing?.points[name] ?? null;
    const at = this.geometry.bodies[body]?.points[point], place = this.placeOf(body);
    return at && place ? [place.x + place.cos * at[0] - place.sin * at[1], place.y + place.sin * at[0] + place.cos * at[1]] : null;
  }

  // The motion runs on the sheet, or null where the drawing is shown: {motion, scene, time}.
  run(running) {
    if (running && running.motion !== this.running?.motion) this.moving.setMotion(running.motion, running.scene, [], this.size);
    this.running = running;
    this.invalidate();
  }

  // ---------------------------------------------------------------- the view
  get snap() { return this.own ?? this.snapOf(); }
  set snap(value) { this.own = value > 0 ? value : null; this.invalidate(); }

  // 1, 2 or 5 times a power of ten, of 8 to 20 pixels; on the sheet that was empty no coarser than a centimetre.
  snapOf() {
    if (!this.view) return COARSEST;
    const most = MOST / this.view.scale * (1 + 1e-9), power = 10 ** Math.floor(Math.log10(most));
    const snap = Number((power * [5, 2, 1].find((k) => k * power <= most)).toPrecision(1));
    return this.unmoved ? Math.min(snap, COARSEST) : snap;
  }

  // Names of the points that the sheet does not show.
  outside() {
    if (!(this.width > 0)) return new Set();
    return new Set(Object.entries(this.drawing.points).filter(([, at]) => {
      const [x, y] = this.onCanvas(at);
      return x < 0 || y < 0 || x > this.width || y > this.height;
    }).map(([name]) => name));
  }

  // The user has moved the sheet: what is outside now is meant to be.
  moved() {
    this.away = this.drawing ? this.outside() : new Set();
    this.invalidate();
  }

  fit() {
    const points = Object.values(this.drawing?.points ?? {});
    if (!(this.width > 0)) { this.view = null; return; }
    if (!this.drawing?.scene) {
      this.view = { scale: this.width / WIDE, x: this.width / 2, y: this.height / 2 };
      this.unmoved = true;
      if (!points.length || !this.outside().size) { this.away = new Set(); this.invalidate(); return; }
    }
    this.away = new Set();
    this.unmoved = false;
    const reach = this.running ? [this.moving.stage.low, this.moving.stage.high] : []; // of the motion that runs
    const [low, high] = [Math.min, Math.max].map((extreme) => [0, 1].map((k) => extreme(...[...points, ...reach].map((at) => at[k]))));
    const spans = [0, 1].map((k) => high[k] - low[k]), size = Math.max(...spans) > POINT * (1 + Math.max(...low.map(Math.abs), ...high.map(Math.abs))) ? Math.max(...spans) : WIDE / 4;
    const room = [this.width, this.height].map((one) => one * (1 - 2 * MARGIN));
    const scale = Math.min(...[0, 1].map((k) => room[k] / Math.max(spans[k], 0.2 * size)));
    this.view = { scale, x: this.width / 2 - scale * (low[0] + high[0]) / 2, y: this.height / 2 + scale * (low[1] + high[1]) / 2 };
    this.invalidate();
  }

  zoom(x, y, factor) {
    const scale = Math.max(1e-2, Math.min(1e8, this.view.scale * factor)), f = scale / this.view.scale;
    this.view = { scale, x: x + (this.view.x - x) * f, y: y + (this.view.y - y) * f };
    this.unmoved &&= f === 1;
    this.moved();
  }

  pan(dx, dy) {
    this.view = { ...this.view, x: this.view.x + dx, y: this.view.y + dy };
    this.moved();
  }

  // From metres to pixels of the canvas, and back; `toScreen` in pixels of the page.
  onCanvas([x, y]) { return [this.view.x + this.view.scale * x, this.view.y - this.view.scale * y]; }
  inPlane([X, Y]) { return [(X - this.view.x) / this.view.scale, (this.view.y - Y) / this.view.scale]; }
  toScreen(at) {
    const box = this.above.getBoundingClientRect(), [X, Y] = this.onCanvas(at);
    return [box.left + X, box.top + Y];
  }

  // The nearest place of the grid.
  onGrid(at) {
    const { snap } = this, digits = Math.max(0, 3 - Math.floor(Math.log10(snap)));
    return at.map((x) => Number((Math.round(x / snap) * snap).toFixed(Math.min(15, digits))) + 0);
  }

  // ---------------------------------------------------------------- drawing
  invalidate() {
    if (this.frame) return;
    this.frame = requestAnimationFrame(() => {
      this.frame = 0;
      this.draw();
    });
  }

  draw() {
    const { width, height } = this;
    if (!(width > 20) || !(height > 20)) return;
    if (!this.view) this.fit();
    this.drawBelow(sized(this.below, width, height));
    const one = this.running ? this.moving : this.still;
    one.width = width;
    one.height = height;
    one.own = this.view;
    if (this.running || this.motion) this.drawMechanism(one);
    else sized(this.canvas, width, height);
    const p = new Painter(sized(this.above, width, height), this.view, this.theme);
    for (const mark of this.marks) mark(p);
    p.scaleBar(lengthText(10 * this.snap), 10 * this.snap * this.view.scale, this.height, this.theme.grey);
  }

  drawMechanism(view) {
    const { motion } = this, pose = motion?.pose;
    if (this.pulled && motion) motion.pose = () => Object.fromEntries(["ground", ...Object.keys(this.geometry.bodies)].map((body) => [body, this.placeOf(body)]));
    view.draw(this.running?.time ?? 0, this.theme, { forces: false, ghost: false, names: Boolean(this.names), traces: this.traces ?? [], plain: true });
    if (this.pulled && motion) motion.pose = pose;
  }

  drawBelow(context) {
    const { width, height, view, theme } = this, p = new Painter(context, view, theme);
    context.fillStyle = theme.paper;
    context.fillRect(0, 0, width, height);
    if (this.photo?.image) this.drawPhoto(context);
    const { snap } = this, step = snap * view.scale;
    if (step >= 5) {
      const left = Math.ceil(-view.x / step), top = Math.ceil(-view.y / step);
      for (let k = left; k * step + view.x <= width; k++) {
        for (let n = top; n * step + view.y <= height; n++) {
          const strong = k % 10 === 0 && n % 10 === 0 ? 1.8 : k % 10 === 0 || n % 10 === 0 ? 1.2 : 1;
          context.fillStyle = strong > 1 ? theme.grey : theme.lines;
          context.fillRect(k * step + view.x - strong / 2, n * step + view.y - strong / 2, strong, strong);
        }
      }
    }
    const far = [this.inPlane([0, 0]), this.inPlane([width, height])];
    p.line([[far[0][0], 0], [far[1][0], 0]], { colour: theme.lines, width: 1 });
    p.line([[0, far[0][1]], [0, far[1][1]]], { colour: theme.lines, width: 1 });
  }

  // origin: where the lower left corner of the picture is [m]; scale [m per pixel]; angle [rad].
  drawPhoto(context) {
    const { image, scale, origin, angle, width, height } = this.photo, [x, y] = this.onCanvas(origin), size = scale * this.view.scale;
    context.save();
    context.translate(x, y);
    context.rotate(-angle);
    context.globalAlpha = 0.55;
    context.drawImage(image, 0, -height * size, width * size, height * size);
    context.restore();
  }
}

// A length [m] in a unit that fits: "25 mm".
export function lengthText(value, digits = 4) {
  const [factor, unit] = Math.abs(value) >= 1 ? [1, "m"] : Math.abs(value) >= 1e-3 ? [1e3, "mm"] : [1e6, "µm"];
  return `${plain(value * factor, digits)} ${unit}`;
}
