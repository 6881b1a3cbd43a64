// The model text: a plain text field with line numbers and colours behind it, and problems at their place.

import { h, replace } from "./dom.js";

const PAUSE = 250; // after the last key before the text is checked [ms]

export class Editor {
  constructor(changed) {
    this.changed = changed; // called with the text when typing pauses
    this.problems = [];
    this.pending = 0;
    this.gutter = h("div", { class: "gutter", "aria-hidden": "true" });
    this.paint = h("pre", { class: "paint", "aria-hidden": "true" });
    this.area = h("textarea", { class: "area", "aria-label": "Model file", spellcheck: "false", autocapitalize: "off", autocomplete: "off", wrap: "off" });
    this.list = h("ol", { class: "problems", role: "alert" });
    this.el = h("div", { class: "editor" }, h("div", { class: "sheet" }, this.gutter, h("div", { class: "text" }, this.paint, this.area)), this.list);
    this.area.addEventListener("input", () => this.typed());
    this.area.addEventListener("scroll", () => this.follow());
    this.area.addEventListener("keydown", (event) => this.key(event));
  }

  get text() { return this.area.value; }

  typed() {
    this.draw();
    clearTimeout(this.pending);
    this.pending = setTimeout(() => this.flush(), PAUSE);
  }

  // Give away what was typed and not yet given.
  flush() {
    clearTimeout(this.pending);
    if (!this.pending) return;
    this.pending = 0;
    this.changed(this.text);
  }

  // Another text; the caret stays at what it was beside.
  show(text, start = false) {
    clearTimeout(this.pending);
    this.pending = 0;
    if (text === this.text) return;
    const old = this.text, at = this.area.selectionStart, scroll = this.area.scrollTop;
    let same = 0;
    while (same < at && same < text.length && old[same] === text[same]) same++;
    this.area.value = text;
    const caret = start ? 0 : same === at ? at : Math.min(text.length, Math.max(0, at + text.length - old.length));
    this.area.setSelectionRange(caret, caret);
    this.area.scrollTop = start ? 0 : scroll;
    this.draw();
  }

  mark(problems) {
    this.problems = problems;
    replace(this.list, problems.map((one) => h("li", {}, h("button", { class: "problem", onclick: () => this.go(one) },
      h("b", {}, one.line ? `line ${one.line}` : "model"), one.where ? h("code", {}, one.where) : null, one.words))));
    this.draw();
  }

  // The caret to a problem.
  go(problem) {
    const lines = this.text.split("\n"), line = Math.max(1, problem.line || 1);
    let at = 0;
    for (let k = 0; k < line - 1; k++) at += (lines[k] ?? "").length + 1;
    const from = at + Math.max(0, (problem.column || 1) - 1);
    this.area.focus();
    this.area.setSelectionRange(from, from + Math.max(0, problem.width));
    const height = parseFloat(getComputedStyle(this.area).lineHeight) || 20;
    this.area.scrollTop = Math.max(0, (line - 6) * height);
    this.follow();
  }

  follow() {
    this.paint.style.transform = `translate(${-this.area.scrollLeft}px, ${-this.area.scrollTop}px)`;
    this.gutter.firstChild?.style.setProperty("transform", `translateY(${-this.area.scrollTop}px)`);
  }

  draw() {
    const lines = this.text.split("\n"), wrong = new Map();
    for (const one of this.problems) if (one.line) wrong.set(one.line, [...(wrong.get(one.line) ?? []), one]);
    replace(this.paint, lines.map((line, k) => h("div", { class: wrong.has(k + 1) ? "wrong" : null }, ...painted(line, wrong.get(k + 1) ?? []))));
    replace(this.gutter, h("div", {}, lines.map((_, k) => h("div", wrong.has(k + 1) ? { class: "wrong" } : {}, String(k + 1)))));
    this.follow();
  }

  // Tab indents what is selected, Escape leaves the field so that Tab moves on.
  key(event) {
    if (event.key === "Escape") { this.area.blur(); return; }
    if (event.key !== "Tab" || event.ctrlKey || event.altKey || event.shiftKey) return;
    event.preventDefault();
    this.area.setRangeText("    ", this.area.selectionStart, this.area.selectionEnd, "end");
    this.typed();
  }
}

const TOKEN = /(#.*$)|("(?:[^"\\]|\\.)*"|'[^']*')|(^\s*\[\[?[^\]]*\]\]?)|([A-Za-z_][\w.-]*)(?=\s*=)|\b(true|false)\b|([-+]?\b\d[\d_]*(?:\.\d+)?(?:[eE][-+]?\d+)?\b)/g;
const COLOUR = [null, "comment", "string", "heading", "name", "word", "number"];

// A line with its colours, and a wavy line under what is wrong.
function painted(line, problems) {
  const marks = new Array(line.length).fill("");
  for (const found of line.matchAll(TOKEN)) {
    const kind = COLOUR[found.findIndex((one, k) => k > 0 && one !== undefined)];
    for (let k = 0; k < found[0].length; k++) marks[found.index + k] = kind;
  }
  for (const one of problems) {
    if (!one.column) continue;
    for (let k = one.column - 1; k < Math.min(line.length, one.column - 1 + Math.max(1, one.width)); k++) marks[k] += " bad";
  }
  const pieces = [];
  for (let k = 0, from = 0; k <= line.length; k++) {
    if (k < line.length && marks[k] === marks[from]) continue;
    if (k > from) pieces.push(marks[from] ? h("span", { class: marks[from] }, line.slice(from, k)) : line.slice(from, k));
    from = k;
  }
  return pieces.length ? pieces : ["\u200b"];
}
