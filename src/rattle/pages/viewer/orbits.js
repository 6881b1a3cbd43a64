// Orbits of pins in their clearance circles, coloured by the normal force, or in oil by the pressure of the film.

import { make, say } from "./dom.js";
import { crankDots, crankOf, oilKey, oilMarks } from "./oil_marks.js";
import { FONT, Painter, sized } from "./painter.js";
import { pinsWithPlay } from "./stage.js";
import { handyUnit, short, steady, ticks } from "./units.js";

const LEVELS = 24; // colours of a path
const BAR = 78; // pixels for the colour bar with its numbers

// All orbits of a motion, one figure for each pin with play.
export class Orbits {
  constructor(host, word) {
    this.host = host;
    this.word = word;
    this.tiles = [];
  }

  setMotion(motion, scene) {
    this.motion = motion;
    const pins = Object.entries(pinsWithPlay(motion, scene.kinds));
    if (pins.map(([name]) => name).join("\n") !== this.tiles.map((one) => one.name).join("\n")) this.build(pins);
    this.tiles.forEach((tile, k) => { tile.stale = pins[k][1]; }); // formed when someone looks
    return pins.length;
  }

  build(pins) {
    this.tiles = pins.map(([name]) => {
      const below = make("canvas", { role: "img" }), above = make("canvas", { class: "above", "aria-hidden": "true" });
      const title = make("figcaption", {}), live = make("p", { class: "number quiet" }), key = make("p", { class: "key quiet" });
      const element = make("figure", { class: "orbit" }, title, make("div", { class: "layers" }, below, above), live, key);
      return { name, below, above, title, live, key, element };
    });
    this.host.replaceChildren(...this.tiles.map((one) => one.element));
  }

  describe(tile, form) {
    const { motion } = this, { name } = tile, oil = motion.has(`${name}.film_pressure`);
    const path = motion.pinPath(name), { factor, unit } = handyUnit("m", form.clearance);
    const strength = oil ? motion.curve(`${name}.film_pressure`) : path.normal.map(Math.abs);
    const sizes = Array.from(strength).filter(Number.isFinite).sort((a, b) => a - b);
    const top = sizes[Math.min(sizes.length - 1, Math.floor(0.999 * sizes.length))] || 1;
    const most = motion.largest(`${name}.${oil ? "film_pressure" : "normal"}`);
    Object.assign(tile, { form, path, oil, strength, top, most, factor, unit, fresh: false, stale: null });
    tile.crank = oil ? crankOf(motion) : null;
    tile.shown = handyUnit(oil ? "Pa" : "N", most);
    tile.upTo = this.word("up to {value}", { value: short(tile.shown.factor * most, 4) });
    tile.least = Math.max(1, ...Array.from(path.x, (x, k) => Math.hypot(x, path.y[k]) / form.clearance).filter(Number.isFinite));
    tile.hits = motion.events.filter((one) => one.joint === name && one.kind === "impact" && one.impulse > 0);
    tile.lasting = motion.events.filter((one) => one.joint === name && one.kind === "contact");
    tile.pulls = form.contact === "massless-link" ? Array.from(path.normal.keys()).filter((k) => path.normal[k] < 0) : [];
    const { word } = this, size = `${short(factor * form.clearance)} ${unit}`;
    say(tile.title, oil ? word("{name}: orbit of the pin in oil, clearance {size}", { name, size }) : word("{name}: orbit of the pin, clearance {size}", { name, size }));
    tile.below.setAttribute("aria-label", tile.title.textContent);
    say(tile.key, keyOf(motion, tile, word));
    tile.texts = {
      place: steady(factor * form.clearance, 4), angle: steady(360, 4),
      force: steady(tile.shown.factor * most, 4),
    };
  }

  draw(time, theme) {
    for (const tile of this.tiles) {
      const width = tile.below.clientWidth, height = tile.below.clientHeight;
      if (!width) continue;
      if (tile.stale) this.describe(tile, tile.stale);
      const side = Math.min(width - BAR, height), radius = (0.5 * side) / (1.24 * tile.least);
      const view = { scale: radius / tile.form.clearance, x: 0.5 * side, y: 0.5 * height };
      const mark = `${width} ${height} ${theme.dark}`;
      if (tile.fresh !== mark) {
        drawPath(new Painter(sized(tile.below, width, height), view, theme), this.motion, tile, side, height);
        tile.fresh = mark;
      }
      this.live(tile, new Painter(sized(tile.above, width, height), view, theme), time);
    }
  }

  live(tile, p, time) {
    const now = this.motion.pinAt(tile.name, time), at = [now.x, now.y];
    const pulls = tile.path.pieces > 1 && this.motion.value(`${tile.name}.normal`, time) < 0;
    p.line([[0, 0], at], { colour: p.theme.grey, width: 1 });
    p.dot(at, 6, { colour: p.theme.paper, fill: pulls ? p.theme.red : p.theme.ink, width: 2 });
    const e = Math.hypot(...at), turn = (Math.atan2(now.y, now.x) * 180) / Math.PI;
    const ratio = short(e / tile.form.clearance, 3), { word } = this;
    const size = this.motion.value(`${tile.name}.${tile.oil ? "film_pressure" : "normal"}`, time);
    const place = word("{distance} from the centre ({ratio} of the clearance) at {angle}°", { distance: `${tile.texts.place(tile.factor * e)} ${tile.unit}`, ratio, angle: tile.texts.angle(turn) });
    say(tile.live, `${place}, ${tile.oil ? word("pressure") : "N"} ${tile.texts.force(tile.shown.factor * size)} ${tile.shown.unit}${pulls ? `: ${word("the bush would have to pull")}` : ""}`);
  }
}

function keyOf(motion, tile, word) {
  const found = [];
  if (tile.pulls.length) found.push(word("red ticks: the bush would have to pull"));
  if (tile.hits.length) found.push(tile.hits.length > 1 ? word("dots: {count} impacts, area by impulse", { count: tile.hits.length }) : word("dot: 1 impact"));
  if (tile.lasting.length) found.push(tile.lasting.length > 1 ? word("rings: {count} contacts begin", { count: tile.lasting.length }) : word("ring: 1 contact begins"));
  if (tile.oil) {
    const { boundary } = tile.form.oil, { factor, unit } = handyUnit("m", boundary);
    found.push(word("red ring: boundary film, {size}", { size: `${short(factor * boundary)} ${unit}` }), ...oilKey(motion, tile.name, tile.crank, word));
  }
  return found.join("; ");
}

function drawPath(p, motion, tile, side, height) {
  const { theme } = p, { form, path, strength } = tile, c = form.clearance;
  p.circle([0, 0], c, { colour: theme.grey, fill: theme.bore, width: 1.2 });
  if (tile.oil) p.circle([0, 0], c - form.oil.boundary / 2, { colour: theme.red, width: Math.max(1, form.oil.boundary * p.view.scale), opacity: 0.45 });
  p.line([[-0.05 * c, 0], [0.05 * c, 0], null, [0, -0.05 * c], [0, 0.05 * c]], { colour: theme.grey, width: 1 });
  const bins = Array.from({ length: LEVELS }, () => []);
  for (let k = 0; k + 1 < path.x.length; k++) {
    const most = Math.max(strength[k], strength[k + 1]), level = Math.min(LEVELS - 1, Math.floor((LEVELS * most) / tile.top) || 0);
    bins[level].push([path.x[k], path.y[k]], [path.x[k + 1], path.y[k + 1]], null);
  }
  const width = path.pieces > 1 ? 4.5 : tile.oil ? 2.4 : 1.5;
  bins.forEach((bin, level) => p.line(bin, { colour: theme.force(level / (LEVELS - 1)), width }));
  p.dot([path.x[0], path.y[0]], 4, { width: 1.4 });
  if (tile.crank) crankDots(p, motion, tile.name, tile.crank);
  if (tile.oil) oilMarks(p, motion, tile.name);
  drawMarks(p, motion, tile);
  drawBar(p, tile, side, height);
}

// Red ticks where the bush would have to pull, impacts as dots with an area by their impulse, contacts as rings.
function drawMarks(p, motion, tile) {
  const { theme } = p, c = tile.form.clearance, { x, y } = tile.path;
  const opacity = Math.max(0.06, Math.min(1, 100 / tile.pulls.length));
  for (const k of tile.pulls) {
    const r = Math.hypot(x[k], y[k]) || 1, tick = [1.06, 1.14].map((one) => [(one * c * x[k]) / r, (one * c * y[k]) / r]);
    p.line(tick, { colour: theme.red, width: 1.6, opacity });
  }
  const onCircle = (event) => {
    const row = motion.row(event.t), ex = motion.value(`${tile.name}.ex`, event.t, row), ey = motion.value(`${tile.name}.ey`, event.t, row);
    const r = Math.hypot(ex, ey) || 1;
    return [(c * ex) / r, (c * ey) / r];
  };
  for (const event of tile.lasting) p.dot(onCircle(event), 4, { colour: theme.ink, fill: null, width: 1, opacity: 0.6 });
  const most = Math.max(...tile.hits.map((one) => one.impulse));
  for (const event of tile.hits) {
    p.dot(onCircle(event), Math.max(1.2, 6 * Math.sqrt(event.impulse / most)), { colour: null, fill: theme.red, opacity: 0.5 });
  }
}

function drawBar(p, tile, side, height) {
  const { context, theme } = p, x = side + 6, top = Math.max(46, 0.14 * height), tall = 0.86 * height - top, { factor, unit } = tile.shown;
  for (let k = 0; k < tall; k++) {
    context.fillStyle = theme.force(1 - k / tall);
    context.fillRect(x, top + k, 12, 1.5);
  }
  context.fillStyle = theme.ink;
  context.font = `12px ${FONT}`;
  context.textAlign = "left";
  context.textBaseline = "middle";
  const scale = ticks(0, factor * tile.top, 4);
  for (const value of scale.values) context.fillText(scale.text(value), x + 17, top + tall * (1 - value / (factor * tile.top)));
  context.textBaseline = "alphabetic";
  if (tile.most > tile.top) overBar(context, x, top, tile.upTo);
  context.fillText(`${tile.oil ? "p" : "|N|"} [${unit}]`, x - 4, top - 30);
}

// An arrow on top of the bar, where colours end before the largest value does, and that value.
function overBar(context, x, top, text) {
  context.beginPath();
  context.moveTo(x + 6, top - 10);
  context.lineTo(x, top - 1);
  context.lineTo(x + 12, top - 1);
  context.fill();
  context.fillText(text, x - 4, top - 14);
}
