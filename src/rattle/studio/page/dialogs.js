// What stands in front of the page: files, examples, questions, keys, the model as Python, and first hints.

import { h, kept, replace } from "./dom.js";
import { TOOLS } from "./telling.js";

export const KEYS = [
  ["Space", "play or pause the motion"],
  ["← →", "one step back or on, while the motion has the focus"],
  ["1 … 9, 0", "open a tab: 1 is Motion, 0 is Text"],
  ["K", "to the first knob"],
  ["T", "to the model text; Escape leaves it"],
  ["Ctrl Space", "what may stand at the caret of the text; arrows, then Enter or Tab"],
  ["E", "draw on the Motion tab, or end it"],
  ["G", "gallery of examples"],
  ["D", "light, dark, or as the system"],
  ["Ctrl O", "open a model file"],
  ["Ctrl S", "save; with Shift under another name"],
  ["Ctrl Z, Ctrl Y", "undo and redo, whatever changed the model"],
  ["Escape", "close what is in front"],
  ["?", "this list"],
];

export const DRAWING_KEYS = [
  [TOOLS.map(([, key]) => key).join(", "), `tools: ${TOOLS.map(([name]) => name.toLowerCase()).join(", ")}`],
  ["← → ↑ ↓", "move the chosen point by a step of the grid, with Shift by ten; with another tool, or nothing chosen, a cross hair"],
  ["Enter", "press and let go where the cross hair is"],
  ["Tab", "to the next point, joint, body or load, which is read out"],
  ["0 … 9", "into the main field of what is chosen: Length, Play, Speed; Enter writes, Escape leaves"],
  ["Delete", "remove what is chosen, with all that hangs on it"],
  ["Escape", "end what was begun; then back to Select; then choose nothing"],
  ["Alt", "held: nothing is caught and nothing put on the grid"],
  ["0", "show everything, while nothing is chosen"],
];

export class Dialogs {
  constructor(tell) {
    this.tell = tell;
    this.el = h("dialog", { class: "dialog" });
    this.el.addEventListener("click", (event) => { if (event.target === this.el) this.close(); });
    this.thumbnails = new Map();
    this.cards = new Map();
  }

  get open() { return this.el.open; }

  close() { this.el.close(); }

  // Show content under a title; wide: a gallery.
  front(title, content, wide = false) {
    this.el.classList.toggle("wide", wide);
    const close = h("button", { class: "quiet close", "aria-label": "Close", onclick: () => this.close() }, "×");
    replace(this.el, h("header", {}, h("h2", { id: "dialog-title" }, title), close), content);
    this.el.setAttribute("aria-labelledby", "dialog-title");
    if (!this.el.open) this.el.showModal();
  }

  // A question; the first button is the one that does what was asked for.
  ask(title, words, buttons) {
    const made = buttons.map(([label, action], k) => h("button", { class: k === 0 ? "main" : "", onclick: () => { this.close(); action?.(); } }, label));
    this.front(title, [h("p", {}, words), h("div", { class: "buttons" }, made)]);
    made.at(-1).focus();
  }

  files(message) {
    const open = (name) => { this.close(); this.tell({ do: "open", name }); };
    const list = message.files.map((name) => h("li", {}, h("button", { class: "file", onclick: () => open(name) }, name)));
    const none = h("p", { class: "quiet" }, "There is no model file in this folder yet. Begin with an example and save it here.");
    this.front(`Model files in ${message.folder || "this folder"}`, [
      list.length ? h("ul", { class: "files" }, list) : none,
      message.whole === false ? h("p", { class: "quiet" }, "There are very many files here; not all were looked at. Start the studio in a smaller folder.") : null,
    ]);
  }

  name(message) {
    const entry = h("input", { class: "wide-entry", value: message.suggested, "aria-label": "File name", spellcheck: "false" });
    const save = () => { this.close(); this.tell({ do: "save", name: entry.value }); };
    entry.addEventListener("keydown", (event) => { if (event.key === "Enter") save(); });
    this.front("Save as", [h("p", { class: "quiet" }, "A name in the folder in which the studio was started."), entry,
      h("div", { class: "buttons" }, h("button", { class: "main", onclick: save }, "Save"), h("button", { onclick: () => this.close() }, "Cancel"))]);
    entry.focus();
    entry.setSelectionRange(0, entry.value.lastIndexOf("."));
  }

  python(code) {
    const text = h("textarea", { class: "code", readonly: true, rows: Math.min(18, code.split("\n").length + 1), "aria-label": "Python code" });
    text.value = code;
    const said = h("span", { class: "quiet", role: "status" });
    const copy = async () => {
      try {
        await navigator.clipboard.writeText(code);
        said.textContent = "copied";
      } catch {
        text.select();
        said.textContent = "press Ctrl C to copy";
      }
    };
    this.front("The same in Python", [text, h("div", { class: "buttons" }, said, h("button", { class: "main", onclick: copy }, "Copy"))]);
    copy();
  }

  keys() {
    const rows = (keys) => keys.map(([key, what]) => h("tr", {}, h("td", {}, key.split(", ").map((one) => h("kbd", {}, one))), h("td", {}, what)));
    this.front("Keys", [h("div", { class: "all-keys" }, h("table", { class: "keys" }, rows(KEYS)),
      h("table", { class: "keys" }, h("caption", {}, "While drawing"), rows(DRAWING_KEYS))),
      h("div", { class: "buttons" }, h("button", { onclick: () => { this.close(); kept("hints", ""); this.onhints?.(); } }, "Show the first hints again"))]);
  }

  gallery(examples, pick) {
    const cards = examples.map((one) => {
      const picture = h("div", { class: "picture" });
      if (this.thumbnails.has(one.name)) picture.innerHTML = this.thumbnails.get(one.name);
      this.cards.set(one.name, picture);
      return h("button", { class: "card", "data-name": one.name, onclick: () => { this.close(); pick(one.name); } }, picture, h("b", {}, one.name.replaceAll("_", " ")), h("span", {}, one.title));
    });
    const search = h("input", { class: "wide-entry", placeholder: "Search", "aria-label": "Search the examples" });
    search.addEventListener("input", () => {
      const word = search.value.toLowerCase();
      cards.forEach((card) => { card.hidden = !card.textContent.toLowerCase().includes(word); });
    });
    const grid = h("div", { class: "cards" }, cards);
    this.front("Examples", [search, grid], true);
    const seen = new IntersectionObserver((entries) => {
      const names = entries.filter((one) => one.isIntersecting).map((one) => one.target.dataset.name).filter((name) => !this.thumbnails.has(name));
      if (names.length) this.tell({ do: "thumbnails", names });
    }, { root: grid, rootMargin: "200px" });
    cards.forEach((card) => seen.observe(card));
    this.el.addEventListener("close", () => seen.disconnect(), { once: true });
  }

  // A drawing has come; it is drawn by the studio itself.
  thumbnail(name, svg) {
    this.thumbnails.set(name, svg);
    if (this.cards.has(name)) this.cards.get(name).innerHTML = svg;
  }
}

// A strip with first hints, above what the tabs show, until it is closed once.
export function hints(above) {
  if (kept("hints") === "seen" || above.previousElementSibling?.matches(".hints")) return;
  const done = () => { kept("hints", "seen"); card.remove(); dispatchEvent(new Event("resize")); };
  const card = h("section", { class: "hints", "aria-label": "First hints" },
    h("p", {}, h("b", {}, "Turn a knob"), ": the mechanism and its curves follow. ", h("b", {}, "Edit"), ": draw and change it by hand. ", h("b", {}, "Each tab"), " is computed when it is opened. ",
      h("b", {}, "The last line"), " says how far the result can be trusted."),
    h("button", { class: "quiet", onclick: done }, "Got it"));
  above.before(card);
  dispatchEvent(new Event("resize"));
}
