// One panel of curves of one unit over time: a chart with what follows the time, and a legend with values.

import { Chart, valueOf } from "./chart.js";
import { make, say } from "./dom.js";
import { HANDY } from "./handy_units.js";
import { handyUnit, short, timeText } from "./units.js";

export class Panel extends Chart {
  // curves: the view it belongs to, which holds the window of time that all panels share
  // key: the unit, for lengths with the one in which they are shown, and `difference` for what measured curves differ by
  constructor(key, curves) {
    const { host } = curves;
    super(curves.scope, {
      invalidate: () => host.invalidate(), mayZoom: (event) => host.mayZoom(event), seek: (t) => host.seek(t), word: host.word,
      readout: (t, span) => `t = ${timeText(span)(t)} s`,
    });
    this.key = key;
    [this.quantity] = key.split(" ");
    this.differs = key.endsWith(" difference");
    this.view = curves;
    this.names = [];
    this.legend = make("ul", { class: "legend" });
    this.element = make("div", { class: this.differs ? "panel flat" : "panel" }, this.legend, this.layers);
  }

  // Which curves it shows: [{name, motion, colour index, label, dash}], of measured ones {own: {t, y}, dots, joined, rms,
  // all} too; texts of the legend are made once.
  setNames(names, lines) {
    this.names = names;
    const most = Math.max(0, ...lines.map((line) => (line.own ? mostOf(line.own.y) : line.motion.largest(line.name))));
    this.handy = handyUnit(this.quantity, most, this.view.host.scene.units);
    const { word } = this, kind = HANDY.quantities[this.quantity] ?? names[0].slice(names[0].lastIndexOf(".") + 1).replaceAll("_", " ");
    const quantity = this.differs ? word("difference") : word(kind);
    this.notes = this.view.motion.events.map(({ t, joint, kind: what }) => ({ x: t, strong: what === "impact", words: `${joint}: ${word(what)}` }));
    this.setLines(lines.map(({ motion, name, ...style }) => ({ ...style, name, ...overTime(style.own ?? motion.line(name)),
      peak: style.own ? null : overTime(motion.peak(name)), bursts: style.own ? [] : motion.bursts(name).map(overTime) })), { across: "t [s]", up: `${quantity} [${this.handy.unit || "1"}]`, ...this.handy });
    this.legend.replaceChildren(...(this.differs ? this.lines.map((line) => this.difference(line)) : names.map((name) => this.entry(name))));
  }

  entry(name) {
    const lines = this.lines.filter((line) => line.name === name);
    const values = lines.map((line) => {
      line.swatch = make("span", { class: line.dots ? "swatch dots" : line.dash ? "swatch dashed" : "swatch" });
      line.value = make("span", { class: "number" });
      const label = line.label ? make("span", { class: "quiet" }, line.label) : null;
      return line.dash || line.dots ? make("span", { class: "beside" }, line.swatch, label, line.value) : line.value;
    });
    const { swatch } = lines[0], remove = this.word("Remove {name}", { name });
    const close = make("button", { type: "button", class: "close", "aria-label": remove, title: remove,
      onclick: () => this.view.host.choose(this.view.chosen.filter((other) => other !== name)) }, "×");
    return make("li", {}, swatch, make("span", { class: "name" }, name), ...values, make("span", { class: "quiet" }, this.handy.unit), close);
  }

  // What a measured curve differs by, with its root mean square.
  difference(line) {
    line.swatch = make("span", { class: "swatch dots" });
    line.value = make("span", { class: "number" });
    const rms = this.word("rms {value}", { value: `${short(this.factor * line.rms)} ${this.handy.unit}` }), count = line.x.length;
    const told = count < line.all ? this.word("{count} of {all} values within the run", { count, all: line.all }) : "";
    return make("li", {}, line.swatch, make("span", { class: "name" }, `${line.label} \u2212 ${line.name}`), make("span", { class: "rms" }, rms),
      line.value, make("span", { class: "quiet" }, told));
  }

  drawAt(time, theme) {
    this.horizon = this.view.motion.horizon;
    this.draw(theme, time, this.view.panels[0] === this);
    for (const line of this.lines) say(line.value, line.text(this.factor * valueOf(line, time)));
  }
}

function mostOf(values) {
  return values.reduce((most, value) => (Math.abs(value) > most ? Math.abs(value) : most), 0);
}

// What is known over time, for a chart.
function overTime(known) {
  return known && { x: known.t, y: known.y };
}
