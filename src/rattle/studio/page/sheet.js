// What a tab shows: words, tables, drawings, curves and bars, from the blocks of its job.

import { bars, histogram } from "./bars.js";
import { h, replace } from "./dom.js";
import { Chart, Scope, bytesOf, minus, themeOf } from "./viewer.js";

export class Sheet {
  constructor(tell) {
    this.tell = tell;
    this.charts = [];
    this.seen = new ResizeObserver(() => this.draw());
    this.el = h("div", { class: "sheet-of" });
  }

  show(blocks) {
    this.seen.disconnect();
    for (const chart of this.charts) chart.end();
    this.charts = [];
    replace(this.el, blocks.map((block) => VIEWS[block.kind](block, this)));
    for (const chart of this.charts) this.seen.observe(chart.layers);
  }

  turn(dark) {
    this.theme = themeOf(dark);
    this.draw();
  }

  // At the next frame, once for all that has changed until then.
  draw() {
    this.frame ||= requestAnimationFrame(() => {
      this.frame = 0;
      for (const chart of this.charts) chart.draw(this.theme, null, false);
    });
  }
}

const VIEWS = {
  words: ({ text, tone }) => h("div", { class: `words ${tone}` }, text),
  table: ({ head, rows, caption }) => h("div", { class: "scroll" }, h("table", {}, caption ? h("caption", {}, caption) : null,
    h("thead", {}, h("tr", {}, head.map((cell) => h("th", {}, cell)))), h("tbody", {}, rows.map((row) => h("tr", {}, row.map((cell) => h("td", {}, cell))))))),
  svg: ({ svg, caption }) => {
    const drawing = h("div", { class: "drawing" });
    drawing.innerHTML = svg; // drawn by the studio itself
    return h("figure", {}, caption ? h("h3", {}, caption) : null, drawing);
  },
  bars,
  histogram: (block, sheet) => histogram({ ...block, edges: numbers(block.edges), counts: numbers(block.counts) },
    (number) => sheet.tell({ do: "pick", number })),
  curves,
};

// Numbers of a block; arrays come as their bytes.
function numbers(values) {
  return Array.isArray(values) ? values : new Float64Array(bytesOf(values.f8));
}

// Curves with their names above, and a button that goes back from a zoom.
function curves({ title, x, y, lines, after }, sheet) {
  const [quantity, unit] = partsOf(x), drawn = linesOf(lines);
  const whole = h("button", { class: "quiet", hidden: true, onclick: () => scope.choose(null) }, "Show all of it");
  const scope = new Scope(() => {
    whole.hidden = scope.own === null;
    sheet.draw();
  });
  scope.cover(Math.min(...drawn.map((line) => line.x[0])), Math.max(...drawn.map((line) => line.x.at(-1))));
  const chart = new Chart(scope, {
    invalidate: () => sheet.draw(), mayZoom: (event) => event.ctrlKey || event.metaKey,
    readout: (at, span) => `${quantity} = ${minus(at.toFixed(Math.max(0, Math.min(9, 3 - Math.floor(Math.log10(span))))))} ${unit}`.trim(),
  });
  chart.horizon = after ?? null;
  chart.setLines(drawn, { across: x, up: y, unit: partsOf(y)[1] });
  sheet.charts.push(chart);
  const names = drawn.filter((line) => line.name).map((line) => h("li", {}, nameOf(line, drawn, () => {
    chart.fresh = null;
    sheet.draw();
  })));
  return h("figure", { class: "curves" }, h("h3", {}, after == null ? title : `${title}  (grey: after the horizon, statistics only)`),
    h("ul", { class: "legend" }, names, h("li", {}, whole)), chart.layers);
}

// Quantity and unit of the label of an axis, such as "time [s]".
function partsOf(label) {
  const [, quantity, unit] = /^(.*?) \[(.*)\]$/.exec(label) ?? [null, label, ""];
  return [quantity, unit];
}

// Lines of a block as a chart takes them; one that is `like` another has its colour.
function linesOf(lines) {
  const drawn = [], point = ([at, value]) => ({ x: at, y: value });
  for (const { name, like, dash, top, short, x, y } of lines) {
    drawn.push({ name, x: numbers(x), y: numbers(y), peak: top ? point(top) : null, bursts: (short ?? []).map(point),
      colour: like == null ? new Set(drawn.map((line) => line.colour)).size : drawn[like].colour,
      dash: dash ? [6, 4] : null, over: dash, swatch: h("span", { class: dash ? "swatch dashed" : "swatch" }) });
  }
  return drawn;
}

// The name of a curve, of which a click hides it; one without a name goes with the one whose colour it has.
function nameOf(line, all, changed) {
  const button = h("button", { class: "quiet", "aria-pressed": "true", title: `Hide or show ${line.name}`, onclick: () => {
    const hidden = !line.hidden;
    button.setAttribute("aria-pressed", String(!hidden));
    for (const other of all) if (other === line || (!other.name && other.colour === line.colour)) other.hidden = hidden;
    changed();
  } }, line.swatch, line.name);
  return button;
}
