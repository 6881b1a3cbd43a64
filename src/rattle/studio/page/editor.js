// The model text: a text field with colours and line numbers behind it, problems at their place, and what may stand where.

import { h, replace } from "./dom.js";
import { Entries } from "./entries.js";
import { outline } from "./outline.js";
import { SNIPPETS } from "./snippets.js";
import { Suggest, addition } from "./suggest.js";

const PAUSE = 250; // after the last key before the text is checked [ms]

export class Editor {
  constructor(changed, say) {
    this.say = say; // words for the user
    this.changed = changed; // called with the text when typing pauses, and with true if it was put in at once
    this.problems = [];
    this.pending = 0;
    this.rows = []; // of the painted text: what each was drawn from
    this.paint = h("div", { class: "paint", "aria-hidden": "true" });
    this.area = h("textarea", { class: "area", "aria-label": "Model file", "aria-autocomplete": "list", "aria-haspopup": "listbox", "aria-controls": "suggestions", spellcheck: "false", autocapitalize: "off", autocomplete: "off" });
    this.suggest = new Suggest((put) => this.put(put));
    this.places = h("select", { class: "places", "aria-label": "Go to a section", title: "Go to a section", onfocus: () => this.chart(), onpointerdown: () => this.chart(), onchange: () => this.jump() }, h("option", { value: "" }, "go to ..."));
    this.list = h("ol", { class: "problems", role: "alert" });
    this.sheet = h("div", { class: "sheet" }, h("div", { class: "text" }, this.paint, this.area, this.suggest.el));
    this.el = h("div", { class: "editor" }, this.bar(), this.sheet, this.list);
    this.area.addEventListener("input", (event) => this.typed(event));
    this.area.addEventListener("keydown", (event) => this.key(event));
    for (const left of ["blur", "pointerdown"]) this.area.addEventListener(left, () => { this.suggest.hide(); this.point(); });
  }

  bar() {
    const button = (label, title, onclick) => h("button", { title, onclick }, label);
    return h("div", { class: "adds", role: "toolbar", "aria-label": "Add to the model" }, h("span", { class: "quiet" }, "Add"),
      SNIPPETS.map((snippet) => button(snippet.label.replace("add ", ""), snippet.about, () => this.add(snippet))),
      button("what fits here?", "What may stand at the caret (Ctrl Space)", () => this.ask()), this.places);
  }

  // The sections of the text, in the list of places to go to.
  chart() {
    const heads = outline(this.text, 0).heads.map(({ path, from }) => h("option", { value: from }, path.join(" . ")));
    replace(this.places, [h("option", { value: "" }, heads.length ? "go to ..." : "no section yet"), ...heads]);
  }

  // The chosen section to the top of the sheet, with the caret.
  jump() {
    const from = Number(this.places.value), row = this.text.slice(0, from).split("\n").length - 1;
    this.places.value = "";
    this.area.focus({ preventScroll: true });
    this.area.setSelectionRange(from, from);
    this.paint.children[row]?.scrollIntoView({ block: "start" });
  }

  get text() { return this.area.value; }

  // What may stand where is known from now on.
  know(message) {
    this.suggest.entries = new Entries(message);
    this.el.dataset.ready = "true";
  }

  typed(event) {
    this.draw();
    clearTimeout(this.pending);
    this.pending = setTimeout(() => this.flush(), PAUSE);
    if (event?.inputType === "insertText" && /^[\w."'[]$/.test(event.data)) this.complete(false);
    else if (event?.inputType === "deleteContentBackward" && this.suggest.open) this.complete(true);
    else this.suggest.hide();
  }

  // Give away what was typed and not yet given.
  flush() {
    clearTimeout(this.pending);
    if (!this.pending) return;
    this.pending = 0;
    this.changed(this.text);
  }

  // ---------------------------------------------------------------- what is put in
  complete(asked) {
    this.suggest.look(this.text, this.area.selectionStart, asked);
    this.point();
    if (!this.suggest.open) return;
    const { left, bottom, top } = this.caret(), sheet = this.sheet.getBoundingClientRect(), box = this.suggest.el.getBoundingClientRect();
    const origin = this.paint.getBoundingClientRect();
    const above = bottom + box.height > sheet.bottom && top - box.height > sheet.top;
    this.suggest.el.style.left = `${Math.max(4, Math.min(left - origin.left, origin.width - box.width - 4))}px`;
    this.suggest.el.style.top = `${(above ? top - box.height - 2 : bottom + 2) - origin.top}px`;
    this.suggest.el.scrollIntoView({ block: "nearest" });
  }

  ask() {
    this.focus();
    this.complete(true);
    if (!this.suggest.open) this.say("Nothing is offered here: go to an empty line, behind =, or between quotation marks.");
  }

  // Where the caret is on the page.
  caret() {
    const before = this.text.slice(0, this.area.selectionStart), row = before.split("\n").length - 1, range = document.createRange();
    let left = before.length - before.lastIndexOf("\n") - 1;
    const line = this.paint.children[row];
    for (const piece of line.childNodes) {
      const words = piece.firstChild ?? piece;
      if (left > words.length && piece !== line.lastChild) { left -= words.length; continue; }
      range.setStart(words, Math.min(left, words.length));
      return range.getBoundingClientRect();
    }
    return line.getBoundingClientRect();
  }

  // Tell those who do not see the list which entry is chosen.
  point() {
    if (this.suggest.open) this.area.setAttribute("aria-activedescendant", `suggestion-${this.suggest.chosen}`);
    else this.area.removeAttribute("aria-activedescendant");
  }

  // Put something into the text, as a step of its own that can be undone.
  put({ from, to, text, select, more, snippet }) {
    this.flush();
    this.area.setRangeText(text, from, to);
    if (snippet) this.area.setRangeText(snippet.text, snippet.at, snippet.at);
    this.area.focus({ preventScroll: true });
    this.area.setSelectionRange(...(snippet ? [snippet.from, snippet.to] : select));
    this.draw();
    this.changed(this.text, true);
    this.reveal();
    if (more) this.complete(true);
    else this.point();
  }

  add(snippet) {
    const place = addition(this.text, this.area.selectionStart, snippet);
    if (place) this.put({ from: 0, to: 0, text: "", snippet: place });
    else this.say("There is no pin left for this: add a joint first.");
  }

  // ---------------------------------------------------------------- what is shown
  // Another text; the caret stays "beside" what it was, or goes to the "start" of the text or to the end of the "change".
  show(text, caret = "beside") {
    clearTimeout(this.pending);
    this.pending = 0;
    if (text === this.text) return;
    this.suggest.hide();
    const old = this.text, at = this.area.selectionStart, scroll = this.sheet.scrollTop, least = Math.min(text.length, old.length);
    let same = 0, tail = 0;
    while (same < least && old[same] === text[same]) same++;
    while (tail < least - same && old.at(-1 - tail) === text.at(-1 - tail)) tail++;
    const beside = at <= same ? at : Math.min(text.length, Math.max(0, at + text.length - old.length));
    const place = { start: 0, change: text.length - tail, beside }[caret];
    this.area.value = text;
    this.area.setSelectionRange(place, place);
    this.draw();
    this.sheet.scrollTop = caret === "start" ? 0 : scroll;
    if (caret === "change") this.reveal();
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
    this.area.focus({ preventScroll: true });
    this.area.setSelectionRange(from, from + Math.max(0, problem.width));
    this.reveal();
  }

  focus() {
    this.area.focus({ preventScroll: true }); // a browser would show the beginning of the text
    this.reveal();
  }

  // The line of the caret into sight.
  reveal() {
    const row = this.text.slice(0, this.area.selectionStart).split("\n").length - 1;
    this.paint.children[row]?.scrollIntoView({ block: "nearest" });
  }

  // Draw the lines anew that have changed.
  draw() {
    const wrong = new Map();
    for (const one of this.problems) if (one.line) wrong.set(one.line, [...(wrong.get(one.line) ?? []), one]);
    const rows = this.text.split("\n").map((line, k) => (wrong.has(k + 1) ? `${line}\n${JSON.stringify(wrong.get(k + 1))}` : line));
    const old = this.rows, least = Math.min(rows.length, old.length);
    let head = 0, foot = 0;
    while (head < least && rows[head] === old[head]) head++;
    while (foot < least - head && rows.at(-1 - foot) === old.at(-1 - foot)) foot++;
    const fresh = [];
    for (let k = head; k < rows.length - foot; k++) {
      const problems = wrong.get(k + 1) ?? [];
      fresh.push(h("div", { class: problems.length ? "wrong" : null }, ...painted(rows[k].split("\n")[0], problems)));
    }
    const range = document.createRange();
    range.setStart(this.paint, head);
    range.setEnd(this.paint, old.length - foot);
    range.deleteContents();
    const after = this.paint.children[head] ?? null, all = document.createDocumentFragment();
    all.append(...fresh);
    this.paint.insertBefore(all, after);
    this.rows = rows;
  }

  // Whether a quotation mark at the caret would be the one that already ends the text there.
  closes() {
    const { value, selectionStart: at, selectionEnd: end } = this.area;
    const line = value.slice(value.lastIndexOf("\n", at - 1) + 1, at);
    return at === end && value[at] === '"' && line.split('"').length % 2 === 0;
  }

  // Ctrl Space asks what may stand here, Tab indents what is selected, Escape leaves the field so that Tab moves on.
  key(event) {
    if (this.suggest.key(event)) { this.point(); return; }
    if (event.key === " " && event.ctrlKey) { event.preventDefault(); this.ask(); return; }
    if (event.key === '"' && this.closes()) {
      event.preventDefault();
      this.area.setSelectionRange(this.area.selectionEnd + 1, this.area.selectionEnd + 1);
      this.suggest.hide();
      return;
    }
    if (/^(Arrow|Home|End|Page)/.test(event.key)) this.suggest.hide();
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
