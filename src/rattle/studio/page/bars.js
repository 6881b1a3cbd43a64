// Bars: named ones, and the histogram of an ensemble, whose bars can be clicked.

import { h } from "./dom.js";
import { axisTicks, short } from "./viewer.js";

const BESIDE = 0.15; // room for marks beside the bars, in widths of all bars
const ROOM = 1.3; // height of a histogram, in heights of its highest bar: names of marks stand above

const percent = (share) => `${(100 * share).toFixed(3)}%`;

export function bars({ title, y, labels, values }) {
  const most = Math.max(...values, 0) || 1;
  return h("figure", { class: "bars", "aria-label": `${title}: ${y}` }, h("h3", {}, title), h("p", { class: "quiet" }, y),
    h("div", { class: "rows" }, labels.flatMap((label, k) => [h("span", { class: "name" }, label),
      h("span", { class: "track", "aria-hidden": "true" }, h("i", { style: `width: ${percent(Math.max(0, values[k]) / most)}` })), h("span", { class: "number" }, short(values[k], 4))])));
}

// edges (n + 1,), counts (n,), samples (n,): the mechanism that a click on a bar picks, -1 for none.
export function histogram({ title, x, edges, counts, samples, marks }, pick) {
  const first = edges[0], last = edges.at(-1), air = BESIDE * (last - first);
  const inside = (at) => Math.min(last + air, Math.max(first - air, at)); // a mark far away stands at the edge
  const low = Math.min(first, ...marks.map((mark) => inside(mark.x))), high = Math.max(last, ...marks.map((mark) => inside(mark.x)));
  const across = axisTicks(low, high, 5), highest = Math.max(...counts), top = ROOM * highest, up = axisTicks(0, top, 5);
  const left = (value) => (value - low) / (high - low || 1), number = (value) => short(value, 4);
  const bins = samples.map((sample, k) => h("button", {
    class: left(edges[k]) > 0.5 ? "bin right" : "bin", disabled: sample < 0, onclick: () => pick(sample),
    style: `left: ${percent(left(edges[k]))}; width: ${percent(left(edges[k + 1]) - left(edges[k]))}; height: ${percent(counts[k] / top)}`,
    "data-tip": `${counts[k]} mechanisms\nfrom ${number(edges[k])}\nto ${number(edges[k + 1])}\nclick replays number ${sample}`,
    "aria-label": `${counts[k]} mechanisms from ${number(edges[k])} to ${number(edges[k + 1])}; replays number ${sample}`,
  }));
  const lines = marks.map(({ x: at, label }, k) => h("div", {
    class: `mark${label === "nominal" ? " nominal" : ""}${left(inside(at)) > 0.85 ? " right" : ""}`, style: `left: ${percent(left(inside(at)))}` },
  h("span", { style: `bottom: ${percent((label === "nominal" ? 1.2 : 1.02 + 0.09 * (k % 2)) / ROOM)}` }, label)));
  return h("figure", { class: "histogram" }, h("h3", {}, title), h("div", { class: "ground" },
    h("span", { class: "up" }, "number of mechanisms"),
    up.values.filter(Number.isInteger).map((value) => h("span", { class: "row", style: `bottom: ${percent(value / top)}` }, h("span", {}, up.text(value)))),
    bins, lines,
    across.values.map((value) => h("span", { class: "column", style: `left: ${percent(left(value))}` }, across.text(value)))),
  h("p", { class: "quiet across" }, x));
}
