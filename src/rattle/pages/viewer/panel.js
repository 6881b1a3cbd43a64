// One panel of curves of one unit over time: a chart with what follows the time, and a legend with values.

import { Chart, valueOf } from "./chart.js";
import { make, say } from "./dom.js";
import { HANDY } from "./handy_units.js";
import { handyUnit, timeText } from "./units.js";

export class Panel extends Chart {
  // curves: the view it belongs to, which holds the window of time that all panels share
  // key: the unit, for lengths with the one in which they are shown
  constructor(key, curves) {
    const { host } = curves;
    super(curves.scope, {
      invalidate: () => host.invalidate(), mayZoom: (event) => host.mayZoom(event), seek: (t) => host.seek(t), word: host.word,
      readout: (t, span) => `t = ${timeText(span)(t)} s`,
    });
    this.key = key;
    [this.quantity] = key.split(" ");
    this.view = curves;
    this.names = [];
    this.legend = make("ul", { class: "legend" });
    this.element = make("div", { class: "panel" }, this.legend, this.layers);
  }

  // Which curves it shows: [{name, motion, colour index, label, dash}]; texts of the legend are made once.
  setNames(names, lines) {
    this.names = names;
    const most = Math.max(0, ...lines.map((line) => line.motion.largest(line.name)));
    this.handy = handyUnit(this.quantity, most, this.view.host.scene.units);
    const { word } = this, quantity = word(HANDY.quantities[this.quantity] ?? names[0].slice(names[0].lastIndexOf(".") + 1).replaceAll("_", " "));
    this.notes = this.view.motion.events.map(({ t, joint, kind }) => ({ x: t, strong: kind === "impact", words: `${joint}: ${word(kind)}` }));
    this.setLines(lines.map(({ motion, name, ...style }) => ({ ...style, name, ...overTime(motion.line(name)),
      peak: overTime(motion.peak(name)), bursts: motion.bursts(name).map(overTime) })), { across: "t [s]", up: `${quantity} [${this.handy.unit || "1"}]`, ...this.handy });
    this.legend.replaceChildren(...names.map((name) => this.entry(name)));
  }

  entry(name) {
    const lines = this.lines.filter((line) => line.name === name);
    const values = lines.map((line) => {
      line.swatch = make("span", { class: line.dash ? "swatch dashed" : "swatch" });
      line.value = make("span", { class: "number" });
      const label = line.label ? make("span", { class: "quiet" }, line.label) : null;
      return line.dash ? make("span", { class: "beside" }, line.swatch, label, line.value) : line.value;
    });
    const { swatch } = lines[0], remove = this.word("Remove {name}", { name });
    const close = make("button", { type: "button", class: "close", "aria-label": remove, title: remove,
      onclick: () => this.view.host.choose(this.view.chosen.filter((other) => other !== name)) }, "×");
    return make("li", {}, swatch, make("span", { class: "name" }, name), ...values, make("span", { class: "quiet" }, this.handy.unit), close);
  }

  drawAt(time, theme) {
    this.horizon = this.view.motion.horizon;
    this.draw(theme, time, this.view.panels[0] === this);
    for (const line of this.lines) say(line.value, line.text(this.factor * valueOf(line, time)));
  }
}

// What is known over time, for a chart.
function overTime(known) {
  return known && { x: known.t, y: known.y };
}
