// One panel of curves of one unit: axes, lines, cursor, and what stands under the mouse.

import { mix } from "./colours.js";
import { before } from "./data.js";
import { make, say } from "./dom.js";
import { gestures } from "./gestures.js";
import { FONT, sized } from "./painter.js";
import { axisTicks, handyUnit, QUANTITY, steady, timeText } from "./units.js";

const LEFT = 58, RIGHT = 12, TOP = 10, BOTTOM = 24, LAST = 48; // pixels around the lines, and from the last label to the edge
// Single values of a line that lie between its instants: its largest, and contacts too short to be seen.
const marksOf = ({ motion, name }) => [motion.peak(name), ...motion.bursts(name)].filter(Boolean);
const AFTER = "after the horizon: statistics only";

export class Panel {
  // curves: the view it belongs to, which holds the window of time that all panels share
  // key: the unit, for lengths with the one in which they are shown
  constructor(key, curves) {
    this.key = key;
    [this.unit] = key.split(" ");
    this.curves = curves;
    this.names = [];
    this.below = make("canvas", { role: "img" });
    this.above = make("canvas", { class: "above", "aria-hidden": "true" });
    this.tip = make("div", { class: "tip", hidden: true });
    this.legend = make("ul", { class: "legend" });
    this.layers = make("div", { class: "layers plot" }, this.below, this.above, this.tip);
    this.element = make("div", { class: "panel" }, this.legend, this.layers);
    this.end = gestures(this.above, {
      tap: (x) => curves.host.seek(this.timeAt(x)),
      double: () => curves.window(null),
      start: (x, y, pointer) => { this.picking = pointer === "mouse" ? { from: x, to: x } : "scrub"; },
      drag: (x) => this.dragged(x),
      end: (x) => this.released(x),
      pinch: (x, y, factor, dx) => { this.picking = null; curves.zoom(this.timeAt(x), factor, (-dx / this.room) * curves.span); },
      wheel: (x, y, factor, event) => this.wheeled(x, factor, event),
      hover: (x) => { this.over = x; curves.host.invalidate(); },
      leave: () => { this.over = null; this.tip.hidden = true; curves.host.invalidate(); },
    });
  }

  get room() { return Math.max(1, this.width - LEFT - RIGHT); }

  timeAt(x) {
    const [from, to] = this.curves.shown;
    return from + (Math.max(0, Math.min(this.room, x - LEFT)) / this.room) * (to - from);
  }

  dragged(x) {
    if (this.picking === "scrub") this.curves.host.seek(this.timeAt(x));
    else if (this.picking) this.picking.to = x;
    this.curves.host.invalidate();
  }

  released(x) {
    const { picking } = this;
    this.picking = null;
    if (x !== null && picking?.to !== undefined && Math.abs(picking.to - picking.from) > 6) {
      this.curves.window([this.timeAt(Math.min(picking.from, picking.to)), this.timeAt(Math.max(picking.from, picking.to))]);
    }
    this.curves.host.invalidate();
  }

  wheeled(x, factor, event) {
    if (!this.curves.host.mayZoom(event)) return false;
    if (event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY)) {
      this.curves.zoom(this.timeAt(x), 1, (0.002 * (event.deltaX || event.deltaY)) * this.curves.span);
    } else this.curves.zoom(this.timeAt(x), factor, 0);
    return true;
  }

  // Which curves it shows: [{name, motion, colour index, label, dash}]; texts of the legend are made once.
  setLines(names, lines) {
    this.names = names;
    this.lines = lines;
    const most = Math.max(0, ...lines.map((one) => one.motion.largest(one.name)));
    this.handy = handyUnit(this.unit, most, this.curves.host.scene.units);
    this.fresh = null;
    this.legend.replaceChildren(...names.map((name) => this.entry(name)));
    const quantity = QUANTITY[this.unit] ?? names[0].slice(names[0].lastIndexOf(".") + 1).replaceAll("_", " ");
    this.title = this.handy.unit ? `${quantity} [${this.handy.unit}]` : `${quantity} [1]`;
    this.below.setAttribute("aria-label", `${this.title} over time: ${names.join(", ")}`);
  }

  entry(name) {
    const lines = this.lines.filter((one) => one.name === name);
    const values = lines.map((one) => {
      one.text = steady(this.handy.factor * one.motion.largest(one.name)); // a small curve keeps its digits beside a large one
      one.swatch = make("span", { class: one.dash ? "swatch dashed" : "swatch" });
      one.value = make("span", { class: "number" });
      const label = one.label ? make("span", { class: "quiet" }, one.label) : null;
      return one.dash ? make("span", { class: "beside" }, one.swatch, label, one.value) : one.value;
    });
    const { swatch } = lines[0];
    const close = make("button", { type: "button", class: "close", "aria-label": `Remove ${name}`, title: `Remove ${name}`,
      onclick: () => this.curves.host.choose(this.curves.chosen.filter((one) => one !== name)) }, "×");
    return make("li", {}, swatch, make("span", { class: "name" }, name), ...values, make("span", { class: "quiet" }, this.handy.unit), close);
  }

  layout() {
    this.width = this.layers.clientWidth;
    this.height = this.layers.clientHeight;
    return this.width > 40 && this.height > 40;
  }

  draw(time, theme) {
    if (!this.layout()) return;
    const [from, to] = this.curves.shown, mark = [this.width, this.height, theme.dark, from, to, this.curves.version, this.curves.motion.horizon].join(" ");
    if (mark !== this.fresh) {
      this.fresh = mark;
      this.range(from, to);
      this.static(theme, from, to);
    }
    this.live(time, theme);
  }

  X(t) { return LEFT + ((t - this.curves.shown[0]) / this.curves.span) * this.room; }
  Y(value) { return TOP + ((this.high - value) / (this.high - this.low)) * (this.height - TOP - BOTTOM); }

  // Lowest and highest value within the window of time.
  range(from, to) {
    let low = Infinity, high = -Infinity;
    const reach = (value) => {
      if (value < low) low = value;
      if (value > high) high = value;
    };
    for (const line of this.lines) {
      const { t, y } = line.motion.line(line.name), last = Math.min(t.length - 1, before(t, to) + 1);
      for (let k = before(t, from); k <= last; k++) reach(y[k]);
      for (const { y: value } of this.within(marksOf(line), from, to)) reach(value);
    }
    if (!Number.isFinite(low + high)) [low, high] = [0, 1];
    const size = Math.max(Math.abs(low), Math.abs(high)), constant = high - low < 1e-6 * size || size === 0; // but for rounding
    const air = constant ? 0.5 * size || 1 / this.handy.factor : 0.06 * (high - low);
    this.low = this.handy.factor * (low - air);
    this.high = this.handy.factor * (high + air);
  }

  within(marks, from, to) {
    return marks.filter(({ t }) => t >= from && t <= to);
  }

  static(theme, from, to) {
    const c = sized(this.below, this.width, this.height), bottom = this.height - BOTTOM;
    const { horizon } = this.curves.motion;
    if (horizon !== null && horizon < to) this.shade(c, theme, Math.max(horizon, from), to);
    c.font = `11px ${FONT}`;
    c.lineWidth = 1;
    const written = this.width - LAST; // further right stands the unit of time
    const wide = axisTicks(from, this.timeAt(written), Math.max(2, Math.floor(this.room / 62)));
    const tall = axisTicks(this.low, this.high, Math.max(2, Math.floor((bottom - TOP) / 38)));
    this.labels = { across: wide.values.map(wide.text), up: tall.values.map(tall.text) };
    c.strokeStyle = theme.lines;
    c.fillStyle = theme.grey;
    c.beginPath();
    c.textAlign = "right";
    c.textBaseline = "middle";
    for (const value of tall.values) {
      const y = Math.round(this.Y(value)) + 0.5;
      c.moveTo(LEFT, y);
      c.lineTo(this.width - RIGHT, y);
      c.fillText(tall.text(value), LEFT - 6, y);
    }
    c.textAlign = "center";
    c.textBaseline = "alphabetic";
    for (const value of wide.values) {
      const x = Math.round(this.X(value)) + 0.5;
      c.moveTo(x, bottom);
      c.lineTo(x, bottom + 4);
      c.fillText(wide.text(value), x, bottom + 16);
    }
    c.stroke();
    c.textAlign = "right";
    c.fillText("t [s]", this.width - RIGHT, bottom + 16);
    c.save();
    c.translate(12, TOP + (bottom - TOP) / 2);
    c.rotate(-Math.PI / 2);
    c.textAlign = "center";
    c.fillStyle = theme.ink;
    c.fillText(this.title, 0, 0, bottom);
    c.restore();
    this.marks(c, theme);
    c.save();
    c.beginPath();
    c.rect(LEFT, 0, this.room, bottom + 1);
    c.clip();
    for (const line of [...this.lines].reverse()) this.stroke(c, theme, line, from, to);
    c.restore();
    for (const line of this.lines) this.summit(c, line, from, to);
  }

  shade(c, theme, from, to) {
    c.fillStyle = theme.shade;
    c.fillRect(this.X(from), TOP, this.X(to) - this.X(from), this.height - TOP - BOTTOM);
    c.fillStyle = theme.grey;
    c.font = `11px ${FONT}`;
    c.textAlign = "right";
    if (this.X(to) - this.X(from) > 60 && this.curves.panels[0] === this) c.fillText(AFTER, this.X(to) - 6, TOP + 12, this.X(to) - this.X(from) - 10);
  }

  // Events as short ticks on top: impacts in red, all others grey.
  marks(c, theme) {
    const taken = new Set();
    for (const event of this.curves.motion.events) {
      const x = Math.round(this.X(event.t)), impact = event.kind === "impact", key = `${x} ${impact}`;
      if (x < LEFT || x > this.width - RIGHT || taken.has(key)) continue;
      taken.add(key);
      c.fillStyle = impact ? theme.red : theme.grey;
      c.fillRect(x - 0.5, impact ? TOP - 7 : TOP - 4, 1.4, impact ? 7 : 4);
    }
  }

  // A line; where there are more rows than pixels, lowest and highest of each pixel.
  stroke(c, theme, line, from, to) {
    const { motion, name } = line, { t, y } = motion.line(name), { factor } = this.handy;
    const first = Math.max(0, before(t, from) - 1), last = Math.min(t.length - 1, before(t, to) + 2);
    const colour = theme.curve(line.colour);
    c.strokeStyle = line.dash ? mix(colour, theme.ink, 0.5) : colour;
    line.swatch.style.color = c.strokeStyle;
    c.lineWidth = line.dash ? 1.5 : 1.7;
    c.globalAlpha = line.dash ? 0.85 : 1;
    c.setLineDash(line.dash ?? []);
    c.beginPath();
    if (last - first > 4 * this.room) this.envelope(c, t, y, factor, first, last);
    else {
      let down = false;
      for (let k = first; k <= last; k++) {
        const X = this.X(t[k]), Y = this.Y(factor * y[k]);
        if (!Number.isFinite(Y)) { down = false; continue; }
        if (down) c.lineTo(X, Y);
        else c.moveTo(X, Y);
        down = true;
      }
    }
    for (const burst of this.within(motion.bursts(name), from, to)) {
      c.moveTo(this.X(burst.t), this.Y(0));
      c.lineTo(this.X(burst.t), this.Y(factor * burst.y));
    }
    c.stroke();
    c.setLineDash([]);
    c.globalAlpha = 1;
  }

  // A triangle that points at the largest value of a curve within the steps of its run.
  summit(c, line, from, to) {
    const peak = line.motion.peak(line.name);
    if (line.dash || !peak || peak.t < from || peak.t > to) return;
    const x = this.X(peak.t), y = this.Y(this.handy.factor * peak.y), way = peak.y < 0 ? 1 : -1;
    c.fillStyle = line.swatch.style.color;
    c.beginPath();
    c.moveTo(x, y);
    c.lineTo(x - 4.5, y + 8 * way);
    c.lineTo(x + 4.5, y + 8 * way);
    c.fill();
  }

  envelope(c, t, y, factor, first, last) {
    let pixel = null, low = 0, high = 0;
    const put = () => {
      c.lineTo(pixel, this.Y(factor * low));
      c.lineTo(pixel, this.Y(factor * high));
    };
    for (let k = first; k <= last; k++) {
      const x = Math.round(this.X(t[k]));
      if (!Number.isFinite(y[k])) continue;
      if (x !== pixel) {
        if (pixel !== null) put();
        [pixel, low, high] = [x, y[k], y[k]];
      } else if (y[k] < low) low = y[k];
      else if (y[k] > high) high = y[k];
    }
    if (pixel !== null) put();
  }

  live(time, theme) {
    const c = sized(this.above, this.width, this.height), bottom = this.height - BOTTOM, { factor } = this.handy;
    if (this.picking?.to !== undefined) {
      c.fillStyle = theme.dark ? "rgba(86,180,233,.2)" : "rgba(0,114,178,.14)";
      c.fillRect(Math.min(this.picking.from, this.picking.to), TOP, Math.abs(this.picking.to - this.picking.from), bottom - TOP);
    }
    const x = this.X(time);
    if (x >= LEFT - 0.5 && x <= this.width - RIGHT + 0.5) {
      c.fillStyle = theme.ink;
      c.fillRect(x - 0.6, TOP - 4, 1.2, bottom - TOP + 4);
      for (const line of this.lines) this.dot(c, theme, line, x, line.motion.at(line.name, time));
    }
    for (const line of this.lines) if (line.value) say(line.value, line.text(factor * line.motion.at(line.name, time)));
    if (this.over !== null && this.over !== undefined) this.hover(c, theme, bottom);
  }

  dot(c, theme, line, x, value) {
    const y = this.Y(this.handy.factor * value);
    if (!Number.isFinite(y)) return;
    c.beginPath();
    c.arc(x, y, 3.6, 0, 2 * Math.PI);
    c.fillStyle = theme.curve(line.colour);
    c.fill();
    c.strokeStyle = theme.paper;
    c.lineWidth = 1.4;
    c.stroke();
  }

  hover(c, theme, bottom) {
    const x = Math.max(LEFT, Math.min(this.width - RIGHT, this.over)), t = this.timeAt(x);
    c.fillStyle = theme.grey;
    c.fillRect(x - 0.5, TOP, 1, bottom - TOP);
    for (const line of this.lines) this.dot(c, theme, line, x, line.motion.at(line.name, t));
    const near = this.curves.motion.events.filter((one) => Math.abs(this.X(one.t) - x) < 4).slice(0, 3);
    const rows = [`t = ${timeText(this.curves.span)(t)} s`,
      ...this.lines.map((one) => `${one.name}${one.label ? `, ${one.label}` : ""} = ${one.text(this.handy.factor * one.motion.at(one.name, t)).trim()} ${this.handy.unit}`),
      ...near.map((one) => `${one.joint}: ${one.kind}`)];
    say(this.tip, rows.join("\n"));
    this.tip.hidden = false;
    const left = x > this.width / 2 ? x - this.tip.offsetWidth - 10 : x + 10;
    this.tip.style.transform = `translate(${Math.max(2, left)}px, ${TOP + 2}px)`;
  }
}
