// The fields of what is chosen in a drawing: Enter writes, Escape leaves; what is refused stays to be mended.

import { h, replace } from "./dom.js";

const GAP = 10; // pixels between the panel and the edge of the sheet

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
    this.none = h("p", { class: "edit-none" }, "What is chosen has its fields here: length, play, speed."); // where nothing is chosen, on a narrow screen
    this.inputs = new Map();
  }

  // Go to the other side of the sheet where the panel would cover what is drawn.
  dodge(board, drawing) {
    if (this.el.hidden || !drawing || getComputedStyle(this.el).position !== "absolute") return;
    const { offsetWidth: wide, offsetHeight: high } = this.el, ends = Object.values(drawing.bars).map((bar) => bar.map((end) => board.position(end)).filter(Boolean));
    const middles = ends.filter((bar) => bar.length === 2).map(([p, q]) => [(p[0] + q[0]) / 2, (p[1] + q[1]) / 2]);
    const spots = [...Object.keys(drawing.points).map((name) => board.position(name)).filter(Boolean), ...middles].map((spot) => board.onCanvas(spot));
    const covered = (left) => spots.filter(([x, y]) => y < high + 2 * GAP && (left ? x < wide + 2 * GAP : x > board.width - wide - 2 * GAP)).length;
    const left = this.el.classList.contains("left");
    if (covered(left) > covered(!left)) this.el.classList.toggle("left", !left);
  }

  // things: ["joint J3", "point ground.O1"]; fields: those of all things, the name of the first alone.
  // headingOf(thing): above its fields.  What is being written into stays as it is.
  show(title, things, fields, headingOf) {
    const rows = things.flatMap((thing, k) => (fields[thing] ?? []).filter(({ name }) => !(k > 0 && name === "Name")).map((field, n) => ({ ...field, thing, heading: n ? "" : headingOf(thing) })));
    const shape = JSON.stringify([things[0], rows.map((row) => [row.thing, row.name, row.choices, row.heading])]);
    this.el.hidden = !rows.length && this.start.hidden && this.readings.hidden;
    this.title.textContent = title;
    this.remove.hidden = !things.length || things[0] === "picture";
    const writing = [...this.inputs].find(([, input]) => input.matches(":focus"))?.[0];
    if (shape !== this.shape) {
      this.build(rows);
      this.inputs.get(writing)?.focus();
    }
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
    for (const input of this.inputs.values()) input.now = input.value.trim(); // one that goes writes nothing more
    this.inputs.clear();
    this.complain("");
    const seen = new Set();
    replace(this.form, rows.flatMap((row) => {
      const label = seen.has(row.name) ? `${row.name} of ${row.thing.split(" ")[1]}` : row.name; // the first has the plain name
      seen.add(row.name);
      const input = row.choices.length ? h("select", { "aria-label": label }, row.choices.map((one) => h("option", { value: one }, one)))
        : h("input", { "aria-label": label, spellcheck: "false", autocomplete: "off", placeholder: row.name === "Play" ? "none" : "", title: row.hint, ...(row.offers?.length ? { list: `offers of ${row.name}`.replaceAll(" ", "-") } : {}) });
      input.now = row.text;
      input.value = row.text;
      const enter = () => {
        if (input.value.trim() === input.now) return this.complain("");
        input.entered = true;
        this.complain("");
        this.asked = input;
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
      const offers = row.offers?.length ? h("datalist", { id: input.getAttribute("list") }, row.offers.map((value) => h("option", { value }))) : null;
      return [row.heading ? h("h3", {}, row.heading) : null, h("label", {}, h("span", {}, row.name), input, offers)];
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
