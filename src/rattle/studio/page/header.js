// The top of the page: what is open, and what can be done with it.

import { h, icon, kept, replace } from "./dom.js";

export class Header {
  constructor(acts) {
    this.title = h("h1", {}, "rattle studio");
    this.file = h("span", { class: "file-name" });
    const button = (label, act, title) => h("button", { class: "quiet", onclick: act, title }, label);
    this.undo = h("button", { class: "quiet icon", "aria-label": "Undo", title: "Undo (Ctrl Z)", onclick: acts.undo }, icon("undo"));
    this.redo = h("button", { class: "quiet icon", "aria-label": "Redo", title: "Redo (Ctrl Y)", onclick: acts.redo }, icon("redo"));
    this.theme = h("button", { class: "quiet icon", onclick: acts.theme });
    this.edit = h("button", { class: "edit-button", "aria-pressed": "false", title: "Draw on the Motion tab (E)", onclick: acts.edit }, "Edit");
    this.el = h("header", { class: "top" },
      h("div", { class: "names" }, this.title, this.file),
      h("nav", { "aria-label": "Model" }, this.edit,
        button("New", acts.blank, "An empty sheet to draw on"), button("Examples", acts.gallery, "Gallery of examples (G)"), button("Open", acts.open, "Open a model file (Ctrl O)"),
        button("Save", acts.save, "Save (Ctrl S)"), button("Save as", acts.saveAs, "Save under another name (Ctrl Shift S)"),
        button("Copy as Python", acts.python, "The same mechanism as Python code"),
        h("span", { class: "gap" }), this.undo, this.redo, this.theme,
        h("button", { class: "quiet icon", "aria-label": "Keys", title: "Keys (?)", onclick: acts.keys }, "?")));
  }

  name(message) {
    replace(this.file, message.name || "not saved yet", message.changed && message.name ? h("b", { title: "changed since it was saved" }, " • changed") : null);
  }

  draws(on) { this.edit.setAttribute("aria-pressed", String(on)); }

  steps(history) {
    this.undo.disabled = !history.past.length;
    this.redo.disabled = !history.future.length;
  }
}

const NEXT = { auto: "light", light: "dark", dark: "auto" };
const TOLD = { auto: "Colours as the system has them (D)", light: "Light colours (D)", dark: "Dark colours (D)" };

// Light, dark, or as the system; kept between visits.
export class Theme {
  constructor(root, changed) {
    this.root = root;
    this.changed = changed;
    this.choice = NEXT[kept("theme")] ? kept("theme") : "auto";
    this.system = matchMedia("(prefers-color-scheme: dark)");
    this.system.addEventListener("change", () => this.apply());
  }

  get dark() { return this.choice === "dark" || (this.choice === "auto" && this.system.matches); }

  next() {
    this.choice = NEXT[this.choice];
    kept("theme", this.choice);
    this.apply();
  }

  apply() {
    this.root.dataset.theme = this.dark ? "dark" : "light";
    document.documentElement.style.colorScheme = this.dark ? "dark" : "light";
    document.documentElement.style.background = this.dark ? "#14171b" : "#f6f7f8";
    if (this.button) {
      replace(this.button, icon(this.dark ? "moon" : "sun"), this.choice === "auto" ? h("small", {}, "A") : null);
      this.button.title = TOLD[this.choice];
      this.button.setAttribute("aria-label", TOLD[this.choice]);
    }
    this.changed(this.dark, this.choice);
  }
}
