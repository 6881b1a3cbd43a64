// The fields of what is chosen in a drawing: Enter writes, Escape leaves; what is refused stays to be mended.

import { h, replace } from "./dom.js";

const AGAIN = { driver: ["Name"], point: ["Name"] }; // not shown again where a pin with its joint is chosen

export class Panel {
  // write(chosen, field, text): a value was entered; act(name): a button.
  constructor({ write, left, start, remove }) {
    this.write = write;
    this.left = left;
    this.title = h("h2", {}, "");
    this.form = h("div", { class: "fields" });
    this.alert = h("p", { class: "trouble", role: "alert", hidden: true });
    this.start = h("button", { class: "main", hidden: true, onclick: start }, "Start here");
    this.readings = h("div", { class: "readings", hidden: true });
    this.remove = h("button", { class: "quiet", onclick: remove, title: "Delete (Del)" }, "Delete");
    this.el = h("aside", { class: "edit-panel", "aria-label": "What is chosen", hidden: true }, this.title, this.form, this.readings, this.alert,
      h("div", { class: "buttons-of" }, this.start, this.remove));
    this.inputs = new Map();
  }

  // things: ["joint J3", "point ground.O1"]; fields: those of all things.  What is being written into stays as it is.
  show(title, things, fields) {
    const rows = things.flatMap((thing, k) => (fields[thing] ?? []).filter((field) => !(k > 0 && AGAIN[thing.split(" ")[0]]?.includes(field.name)))
      .map((field) => ({ ...field, thing })));
    const shape = JSON.stringify([title, rows.map((row) => [row.thing, row.name, row.choices])]);
    this.el.hidden = !rows.length && this.start.hidden && this.readings.hidden;
    this.title.textContent = title;
    this.remove.hidden = !things.length;
    if (shape !== this.shape) this.build(rows);
    this.shape = shape;
    for (const row of rows) {
      const input = this.inputs.get(`${row.thing} ${row.name}`);
      input.now = row.text;
      if (!input.matches(":focus") || input.entered) input.value = row.text;
      input.entered = false;
    }
  }

  // Measures: words, and a button that keeps each as a signal.
  list(rows) {
    this.readings.hidden = !rows.length;
    replace(this.readings, rows.map(({ words, keep }) => h("p", {}, words, keep ? h("button", { onclick: keep, title: "Record it as a signal of the model" }, "Keep") : null)));
    this.el.hidden = !rows.length && !this.inputs.size && this.start.hidden;
    if (rows.length) this.title.textContent = "Measured";
  }

  build(rows) {
    this.inputs.clear();
    this.complain("");
    replace(this.form, rows.map((row) => {
      const input = row.choices.length ? h("select", {}, row.choices.map((one) => h("option", { value: one }, one)))
        : h("input", { spellcheck: "false", autocomplete: "off", placeholder: row.name === "Play" ? "none" : "", title: row.hint });
      input.now = row.text;
      input.value = row.text;
      const enter = () => {
        if (input.value.trim() === input.now) return this.complain("");
        input.entered = true;
        this.asked = input;
        this.complain("");
        this.write(row.thing, row.name, input.value.trim());
      };
      input.addEventListener("change", () => { if (row.choices.length || !input.matches(":focus")) enter(); });
      input.addEventListener("keydown", (event) => {
        if (event.key === "Enter") { enter(); event.preventDefault(); }
        if (event.key === "Escape") {
          input.value = input.now;
          this.complain("");
          this.left();
          event.preventDefault();
          event.stopPropagation();
        }
      });
      input.addEventListener("focus", () => input.select?.());
      this.inputs.set(`${row.thing} ${row.name}`, input);
      return h("label", {}, h("span", {}, row.name), input);
    }));
  }

  // Why what was entered is refused; "" takes it back.
  complain(words) {
    this.alert.textContent = words;
    this.alert.hidden = !words;
    for (const input of this.inputs.values()) input.toggleAttribute("aria-invalid", false);
    if (words && this.asked?.isConnected) {
      this.asked.setAttribute("aria-invalid", "true");
      this.asked.entered = false;
      this.el.hidden = false;
    }
    if (!words) this.asked = null;
  }

  // The first of these fields that there is gets the focus; letters: what is written into it already.
  focus(names, letters = null) {
    const [, input] = names.flatMap((name) => [...this.inputs].filter(([key]) => key.endsWith(` ${name}`)))[0] ?? [];
    if (!input) return false;
    input.focus();
    if (letters !== null) input.value = letters;
    return true;
  }
}
