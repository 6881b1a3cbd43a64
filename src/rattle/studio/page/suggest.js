// What may be written where the caret is: a list beside it, chosen from with the arrow keys, Enter or Tab, or a finger.

import { h, replace } from "./dom.js";
import { namesOf } from "./entries.js";
import { outline } from "./outline.js";
import { SNIPPETS, placed } from "./snippets.js";

const LONGEST = 400000; // characters of a text that is looked through at a key; as many as knobs change
const CLEAR = 3; // letters from which a word that is typed may mean a part to add, and not a name of the user's
const SHOWN = 60; // entries of a list; more are found by typing on

export class Suggest {
  constructor(put) {
    this.put = put; // called with {from, to, text, select: [from, to], more}
    this.entries = null;
    this.items = [];
    this.list = h("ul", { role: "listbox", id: "suggestions", "aria-label": "What may stand here" });
    this.about = h("p", { class: "about" });
    this.el = h("div", { class: "suggest", hidden: true }, this.list, this.about);
    for (const press of ["pointerdown", "mousedown"]) this.el.addEventListener(press, (event) => event.preventDefault()); // the text keeps the focus
  }

  get open() { return !this.el.hidden; }

  hide() {
    this.el.hidden = true;
    this.items = [];
  }

  // Look what may stand at the caret; asked: with a key for it, else while something is typed.
  look(text, at, asked) {
    this.hide();
    if (!this.entries || text.length > LONGEST || text.trimStart().startsWith("{")) return;
    const read = outline(text, at), { place } = read;
    if (place.kind === "none" || (!asked && place.typed === "" && place.quote === undefined)) return;
    const found = this.found(text, read, asked).concat(asked || place.typed.length >= CLEAR ? added(text, read) : []);
    const word = place.typed.toLowerCase();
    const begin = found.filter((item) => item.label.toLowerCase().startsWith(word));
    const hold = word ? found.filter((item) => !begin.includes(item) && item.label.toLowerCase().includes(word)) : [];
    const all = [...begin, ...hold].slice(0, SHOWN);
    if (all.length && !(all.length === 1 && all[0].label === place.typed)) this.show(all);
  }

  found(all, { root, place }, asked) {
    const { path, from, to } = place;
    if (place.kind === "key") return this.entries.keys(root, path, place.typed).map((key) => ({ ...key, ...asKey(key, place) }));
    if (place.kind === "header") return headers(this.entries, root, path).map((key) => ({ ...key, ...asHeader(key, place) }));
    const values = this.entries.values(root, path).filter((value) => asked || value.detail !== "parameter" || /^[A-Za-z_]/.test(place.typed));
    return values.filter((value) => !(place.quote && value.plain)).map((value) => {
      const text = place.quote ? `${value.label}${place.closed ? "" : place.quote}` : value.plain ? value.label : `"${value.label}"`;
      const next = place.closed ? /^["']\s*,\s*(["'])(?=\1)/.exec(all.slice(to, to + 40)) : null; // an empty text after this one
      const end = from + text.length + (next ? next[0].length : place.quote && place.closed ? 1 : 0);
      return { ...value, put: { from, to, text, select: [end, end], more: Boolean(next) } };
    });
  }

  show(items) {
    this.items = items;
    replace(this.list, items.map((item, k) => h("li", { role: "option", id: `suggestion-${k}`, onclick: () => this.take(k) },
      h("b", {}, item.label), item.detail ? h("span", {}, item.detail) : null)));
    this.el.hidden = false;
    this.choose(0);
  }

  choose(k) {
    this.chosen = (k + this.items.length) % this.items.length;
    [...this.list.children].forEach((el, j) => el.setAttribute("aria-selected", String(j === this.chosen)));
    this.list.children[this.chosen].scrollIntoView({ block: "nearest" });
    this.about.textContent = this.items[this.chosen].about;
    this.about.hidden = !this.items[this.chosen].about;
  }

  take(k = this.chosen) {
    const { put } = this.items[k];
    this.hide();
    this.put(put);
  }

  // True for a key that the list has used.
  key(event) {
    if (!this.open || event.ctrlKey || event.metaKey || event.altKey || event.shiftKey) return false;
    if (event.key === "ArrowDown") this.choose(this.chosen + 1);
    else if (event.key === "ArrowUp") this.choose(this.chosen - 1);
    else if (event.key === "Enter" || event.key === "Tab") this.take();
    else if (event.key === "Escape") this.hide();
    else return false;
    event.preventDefault();
    event.stopPropagation();
    return true;
  }
}

// A key with the beginning of its value; the caret where that is written.
function asKey(key, { from, to, assigned }) {
  if (assigned) return { put: { from, to, text: key.label, select: [from + key.label.length, from + key.label.length] } };
  const [before, after] = shapeOf(key.parts), text = `${key.label} = ${before}${after}`, at = from + text.length - after.length;
  return { put: { from, to, text, select: [at, at], more: true } };
}

// What stands around the first thing that is written of a value.
function shapeOf(parts) {
  const types = parts.map((part) => part.type), words = (part) => part.type === "string" || typeof (part.const ?? part.enum?.[0]) === "string";
  if (parts.some(words)) return ['"', '"'];
  if (types.includes("array")) return parts.some((part) => part.type === "array" && part.pair) ? ['["', '", ""]'] : ["[", "]"];
  return types.every((type) => type === "object") ? ["{ ", " }"] : ["", ""];
}

function headers(entries, root, path) {
  const tables = entries.keys(new Map(), path).filter((key) => key.parts.some((part) => part.keys || part.any !== undefined));
  const names = path.length === 1 && path[0] === "initial" ? namesOf(root, "bodies").filter((name) => name !== "ground") : [];
  return [...tables.map((key) => ({ ...key, named: key.parts.every((part) => part.any !== undefined && !part.keys) })), ...names.map((label) => ({ label, about: "", detail: "body" }))];
}

// A heading; where the user names what stands under it, up to that name.
function asHeader({ label, named }, { from, to, closed }) {
  const own = named && !["parameters", "signals", "points"].includes(label), text = `${label}${own ? "." : ""}${closed ? "" : "]"}`;
  const at = from + label.length + 1;
  return { put: { from, to, text, select: [at, at], more: own } };
}

// What can be added to the text from here, as entries of the list; the word that was typed for it goes.
function added(text, { place, root, heads }) {
  const line = text.lastIndexOf("\n", place.from - 1) + 1;
  if (place.kind !== "key" || place.assigned || text.slice(line, place.from).trim()) return [];
  return SNIPPETS.map(({ label, about, make }) => ({ label, about, detail: "", make: make(root, place.path) })).filter((item) => item.make)
    .map((item) => ({ ...item, put: { from: place.from, to: place.to, text: "", snippet: placedWithout(text, place, item.make) } }));
}

// Where a snippet goes once the word that was typed for it is gone.
function placedWithout(text, { from, to }, made) {
  const rest = text.slice(0, from) + text.slice(to);
  return placed(rest, outline(rest, from), made);
}

// What a button adds: the place in the text, or null.
export function addition(text, at, snippet) {
  const read = outline(text, at), made = snippet.make(read.root, read.place.path ?? []);
  return made && placed(text, read, made);
}
