// Curves over one axis on a canvas, of which no extreme is lost: a drag, the wheel or two fingers zoom, the mouse reads off.

import { mix } from "./colours.js";
import { before } from "./data.js";
import { make, say } from "./dom.js";
import { gestures } from "./gestures.js";
import { FONT, sized } from "./painter.js";
import { axisTicks, steady } from "./units.js";
import { inEnglish } from "./words.js";

const LEFT = 58, RIGHT = 12, TOP = 10, BOTTOM = 24; // pixels around the lines
const LETTER = 6.5; // of the label of the horizontal axis, which stands right of its numbers [pixels]
const CLOSEST = 1e-5; // shortest part of an axis that can be shown, as a share of the whole
const NEAR = 4; // so close the mouse is at something [pixels]

// The part of the horizontal axis that is shown; several charts may share one.
export class Scope {
  constructor(changed) {
    this.changed = changed;
    this.whole = [0, 1];
    this.own = null; // the part that a user chose
  }

  // What there is to show; a part that was chosen stays as long as anything of it is there.
  cover(low, high) {
    this.whole = high > low ? [low, high] : [low - 0.5, low + 0.5];
    if (this.own && !(this.own[0] < this.whole[1] && this.own[1] > this.whole[0])) this.own = null;
  }

  get shown() { return this.own ?? this.whole; }
  get span() { return this.shown[1] - this.shown[0]; }

  choose(range) {
    this.own = range;
    this.changed();
  }

  // Zoom about a place, then move.
  zoom(at, factor, by) {
    const [low, high] = this.whole, [from, to] = this.shown;
    const span = Math.max((high - low) * CLOSEST, Math.min(high - low, (to - from) / factor)), share = (at - from) / (to - from);
    const start = Math.max(low, Math.min(high - span, at - share * span + by));
    this.choose(span > (high - low) * 0.999 ? null : [start, start + span]);
  }
}

export class Chart {
  // host: {invalidate(), mayZoom(event), readout(x, span): a text, seek(x) where a click goes to a place, word: of its language}
  constructor(scope, host) {
    this.scope = scope;
    this.host = host;
    this.word = host.word ?? inEnglish;
    this.lines = [];
    this.notes = []; // marks on the upper edge, {x, strong, words}
    this.horizon = null; // right of it the ground is grey
    this.below = make("canvas", { role: "img" });
    this.above = make("canvas", { class: "above", "aria-hidden": "true" });
    this.tip = make("div", { class: "tip", hidden: true });
    this.layers = make("div", { class: "layers plot" }, this.below, this.above, this.tip);
    const go = (x) => (host.seek ? host.seek(this.valueAt(x)) : this.read(x));
    this.end = gestures(this.above, {
      tap: go,
      double: () => scope.choose(null),
      start: (x, y, pointer) => { this.picking = pointer === "mouse" ? { from: x, to: x } : null; },
      drag: (x) => {
        if (this.picking) this.picking.to = x;
        else go(x);
        host.invalidate();
      },
      end: (x) => this.released(x),
      pinch: (x, y, factor, dx) => { this.picking = null; scope.zoom(this.valueAt(x), factor, (-dx / this.room) * scope.span); },
      wheel: (x, y, factor, event) => this.wheeled(x, factor, event),
      hover: (x) => this.read(x),
      leave: (pointer) => {
        if (pointer === "touch") return; // what a finger has asked for stays when it is lifted
        this.tip.hidden = true;
        this.read(null);
      },
    });
  }

  get room() { return Math.max(1, this.width - LEFT - RIGHT); }

  X(value) { return LEFT + ((value - this.scope.shown[0]) / this.scope.span) * this.room; }
  Y(value) { return TOP + ((this.high - value) / (this.high - this.low)) * (this.height - TOP - BOTTOM); }

  // The place on the horizontal axis at a pixel.
  valueAt(x) {
    return this.scope.shown[0] + (Math.max(0, Math.min(this.room, x - LEFT)) / this.room) * this.scope.span;
  }

  // Have what is at a pixel read off; null: nothing.
  read(x) {
    this.over = x;
    this.host.invalidate();
  }

  released(x) {
    const { picking } = this;
    this.picking = null;
    if (x !== null && picking && Math.abs(picking.to - picking.from) > 6) {
      this.scope.choose([Math.min(picking.from, picking.to), Math.max(picking.from, picking.to)].map((pixel) => this.valueAt(pixel)));
    }
    this.host.invalidate();
  }

  wheeled(x, factor, event) {
    if (!this.host.mayZoom(event)) return false;
    if (event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY)) {
      this.scope.zoom(this.valueAt(x), 1, (0.002 * (event.deltaX || event.deltaY)) * this.scope.span);
    } else this.scope.zoom(this.valueAt(x), factor, 0);
    return true;
  }

  // Which curves it shows: [{name, label, x, y, peak, bursts, colour, dash, dots, joined, over, swatch}], the first on top but for those that
  // lie over all; x increases, peak and bursts {x, y} are single values that lie between.
  // across, up: labels of the axes; values times `factor` are in `unit`, in which they are shown.
  setLines(lines, { across, up, factor = 1, unit = "" }) {
    Object.assign(this, { lines, across, up, factor, unit, fresh: null });
    for (const line of lines) line.text = steady(factor * largest(line)); // a small curve keeps its digits beside a large one
    this.below.setAttribute("aria-label", this.word("{up} over {across}: {names}", { up, across, names: lines.map((line) => line.name).join(", ") }));
  }

  get seen() { return this.lines.filter((line) => !line.hidden); }

  // at: where a line across all curves stands; null for none.  labelled: the ground behind the horizon says what it is.
  draw(theme, at = null, labelled = true) {
    this.width = this.layers.clientWidth;
    this.height = this.layers.clientHeight;
    if (!(this.width > 40 && this.height > 40)) return;
    const [from, to] = this.scope.shown, mark = [this.width, this.height, theme.dark, from, to, this.horizon].join(" ");
    if (mark !== this.fresh) {
      this.fresh = mark;
      this.range(from, to);
      this.ground(theme, from, to, labelled);
      this.curves(theme, from, to);
    }
    this.live(theme, at);
  }

  // Lowest and highest value within the part that is shown.
  range(from, to) {
    let low = Infinity, high = -Infinity;
    const reach = (value) => {
      if (value < low) low = value;
      if (value > high) high = value;
    };
    for (const line of this.seen) {
      const { x, y } = line, last = Math.min(x.length - 1, before(x, to) + 1);
      for (let k = before(x, from); k <= last; k++) reach(y[k]);
      for (const single of [line.peak, ...line.bursts]) if (within(single, from, to)) reach(single.y);
    }
    if (this.differs) reach(0); // how far it is from nothing
    if (!Number.isFinite(low + high)) [low, high] = [0, 1];
    const size = Math.max(Math.abs(low), Math.abs(high)), constant = high - low < 1e-6 * size || size === 0; // but for rounding
    const air = constant ? 0.5 * size || 1 / this.factor : 0.06 * (high - low);
    this.low = this.factor * (low - air);
    this.high = this.factor * (high + air);
  }

  // Axes, and what stands behind the curves.
  ground(theme, from, to, labelled) {
    const c = sized(this.below, this.width, this.height), bottom = this.height - BOTTOM;
    if (this.horizon !== null && this.horizon < to) this.shade(c, theme, Math.max(this.horizon, from), to, labelled);
    c.font = `11px ${FONT}`;
    c.lineWidth = 1;
    const last = this.width - RIGHT - LETTER * this.across.length - 5; // of the numbers; further right stands the label
    const wide = axisTicks(from, this.valueAt(last), Math.max(2, Math.floor((last - LEFT) / 62)));
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
    c.fillText(this.across, this.width - RIGHT, bottom + 16);
    c.save();
    c.translate(12, TOP + (bottom - TOP) / 2);
    c.rotate(-Math.PI / 2);
    c.textAlign = "center";
    c.fillStyle = theme.ink;
    c.fillText(this.up, 0, 0, bottom);
    c.restore();
    this.ticks(c, theme);
  }

  shade(c, theme, from, to, labelled) {
    const wide = this.X(to) - this.X(from);
    c.fillStyle = theme.shade;
    c.fillRect(this.X(from), TOP, wide, this.height - TOP - BOTTOM);
    c.fillStyle = theme.grey;
    c.font = `11px ${FONT}`;
    c.textAlign = "right";
    if (labelled && wide > 60) c.fillText(this.word("after the horizon: statistics only"), this.X(to) - 6, TOP + 12, wide - 10);
  }

  // Notes as short ticks on the upper edge.
  ticks(c, theme) {
    const taken = new Set();
    for (const note of this.notes) {
      const x = Math.round(this.X(note.x)), key = `${x} ${note.strong}`;
      if (x < LEFT || x > this.width - RIGHT || taken.has(key)) continue;
      taken.add(key);
      c.fillStyle = note.strong ? theme.red : theme.grey;
      c.fillRect(x - 0.5, note.strong ? TOP - 7 : TOP - 4, 1.4, note.strong ? 7 : 4);
    }
  }

  curves(theme, from, to) {
    const c = this.below.getContext("2d"), { seen } = this;
    c.save();
    c.beginPath();
    c.rect(LEFT, 0, this.room, this.height - BOTTOM + 1);
    c.clip();
    for (const line of [...seen.filter((line) => !line.over).reverse(), ...seen.filter((line) => line.over)]) this.stroke(c, theme, line, from, to);
    c.restore();
    for (const line of seen) if (!line.dash && within(line.peak, from, to)) this.summit(c, line);
  }

  // A line; where there are more rows than pixels, lowest and highest of each pixel.
  stroke(c, theme, line, from, to) {
    const { x, y, dash } = line, first = Math.max(0, before(x, from) - 1), last = Math.min(x.length - 1, before(x, to) + 2);
    const colour = theme.curve(line.colour);
    c.strokeStyle = dash || line.dots ? mix(colour, theme.ink, 0.5) : colour;
    if (line.swatch) line.swatch.style.color = c.strokeStyle;
    if (line.dots) return void this.dots(c, line, first, last);
    c.lineWidth = dash ? 1.5 : 1.7;
    c.globalAlpha = dash ? 0.85 : 1;
    c.setLineDash(dash ?? []);
    c.lineCap = dash ? "butt" : "round"; // a value alone between gaps is a dot
    c.beginPath();
    if (last - first > 4 * this.room) this.envelope(c, x, y, first, last);
    else this.polyline(c, x, y, first, last);
    for (const burst of line.bursts) {
      if (!within(burst, from, to)) continue;
      c.moveTo(this.X(burst.x), this.Y(0));
      c.lineTo(this.X(burst.x), this.Y(this.factor * burst.y));
    }
    c.stroke();
    c.setLineDash([]);
    c.globalAlpha = 1;
  }

  // Single values as small circles, where joined with a thin line; very many as a line alone.
  dots(c, { x, y, joined }, first, last) {
    const many = last - first > this.room / 2;
    c.lineWidth = 0.9;
    c.beginPath();
    if (many) this.envelope(c, x, y, first, last);
    else if (joined) this.polyline(c, x, y, first, last);
    for (let k = first; k <= last && !many; k++) {
      const right = this.X(x[k]), top = this.Y(this.factor * y[k]);
      if (!Number.isFinite(top)) continue;
      c.moveTo(right + 2.2, top);
      c.arc(right, top, 2.2, 0, 2 * Math.PI);
    }
    c.stroke();
  }

  polyline(c, x, y, first, last) {
    let down = false;
    for (let k = first; k <= last; k++) {
      const right = this.X(x[k]), top = this.Y(this.factor * y[k]), there = Number.isFinite(top);
      if (there && !down) c.moveTo(right, top);
      if (there) c.lineTo(right, top);
      down = there;
    }
  }

  envelope(c, x, y, first, last) {
    let pixel = null, low = 0, high = 0, down = false;
    const put = () => {
      if (pixel === null) return;
      if (!down) c.moveTo(pixel, this.Y(this.factor * low));
      c.lineTo(pixel, this.Y(this.factor * low));
      c.lineTo(pixel, this.Y(this.factor * high));
      down = true;
    };
    for (let k = first; k <= last; k++) {
      const here = Math.round(this.X(x[k]));
      if (!Number.isFinite(y[k])) {
        put();
        pixel = null;
        down = false;
      } else if (here !== pixel) {
        put();
        [pixel, low, high] = [here, y[k], y[k]];
      } else if (y[k] < low) low = y[k];
      else if (y[k] > high) high = y[k];
    }
    put();
  }

  // A triangle that points at the largest value of a curve within the steps of its run.
  summit(c, line) {
    const x = this.X(line.peak.x), y = this.Y(this.factor * line.peak.y), way = line.peak.y < 0 ? 1 : -1;
    c.beginPath();
    c.moveTo(x, y);
    c.lineTo(x - 4.5, y + 8 * way);
    c.lineTo(x + 4.5, y + 8 * way);
    c.fillStyle = line.swatch.style.color;
    c.fill();
  }

  // What follows the mouse and the time.
  live(theme, at) {
    const c = sized(this.above, this.width, this.height), tall = this.height - TOP - BOTTOM;
    if (this.picking) {
      c.fillStyle = theme.dark ? "rgba(86,180,233,.2)" : "rgba(0,114,178,.14)";
      c.fillRect(Math.min(this.picking.from, this.picking.to), TOP, Math.abs(this.picking.to - this.picking.from), tall);
    }
    const x = at === null ? -1 : this.X(at);
    if (x >= LEFT - 0.5 && x <= this.width - RIGHT + 0.5) {
      c.fillStyle = theme.ink;
      c.fillRect(x - 0.6, TOP - 4, 1.2, tall + 4);
      for (const line of this.seen) if (!line.dots) this.dot(c, theme, line, x, valueOf(line, at));
    }
    if (this.over !== null && this.over !== undefined) this.hover(c, theme, tall);
  }

  dot(c, theme, line, x, value) {
    const y = this.Y(this.factor * value);
    if (!Number.isFinite(y)) return;
    c.beginPath();
    c.arc(x, y, 3.6, 0, 2 * Math.PI);
    c.fillStyle = theme.curve(line.colour);
    c.fill();
    c.strokeStyle = theme.paper;
    c.lineWidth = 1.4;
    c.stroke();
  }

  hover(c, theme, tall) {
    const x = Math.max(LEFT, Math.min(this.width - RIGHT, this.over)), at = this.valueAt(x);
    c.fillStyle = theme.grey;
    c.fillRect(x - 0.5, TOP, 1, tall);
    for (const line of this.seen) this.dot(c, theme, line, x, valueOf(line, at));
    const row = (line, value) => `${line.name}${line.label ? `, ${line.label}` : ""} = ${line.text(this.factor * value).trim()} ${this.unit}`.trim();
    const near = (single) => single && Math.abs(this.X(single.x) - x) < NEAR;
    const named = this.seen.filter((line) => line.name);
    say(this.tip, [this.host.readout(at, this.scope.span), ...named.map((line) => row(line, valueOf(line, at))),
      ...named.filter((line) => !line.dash && near(line.peak)).map((line) => this.word("largest {value}, within the steps", { value: row(line, line.peak.y) })),
      ...this.notes.filter(near).slice(0, 3).map((note) => note.words)].join("\n"));
    this.tip.hidden = false;
    const left = x > this.width / 2 ? x - this.tip.offsetWidth - 10 : x + 10;
    this.tip.style.transform = `translate(${Math.max(2, left)}px, ${TOP + 2}px)`;
  }
}

function within(single, from, to) {
  return single && single.x >= from && single.x <= to;
}

// A curve at a place, linear between its values; single values say nothing beyond the first and the last of them.
export function valueOf({ x, y, dots }, at) {
  if (dots && !(at >= x[0] && at <= x[x.length - 1])) return NaN;
  const k = before(x, at), next = Math.min(x.length - 1, k + 1);
  return next === k || !(at > x[k]) ? y[k] : y[k] + ((at - x[k]) / (x[next] - x[k])) * (y[next] - y[k]);
}

// Largest magnitude of a curve, without what is not a number.
function largest(line) {
  let most = Math.abs(line.peak?.y ?? 0);
  for (const value of line.y) if (Number.isFinite(value) && Math.abs(value) > most) most = Math.abs(value);
  return most;
}
