// The left column: parameters as sliders, contact models of joints, gravity, end and method of the run.

import { h, replace } from "./dom.js";
import { STEPS, plain, stepOf, valueAt } from "./viewer.js";

const DIGITS = 6; // of a value beside its slider
const WAIT = 60; // between two messages while a slider is dragged [ms]

const shown = (knob, value) => `${plain(value / knob.factor, DIGITS)} ${knob.unit}`.trim();

export class Knobs {
  constructor(tell, turned) {
    this.tell = tell; // message to the studio
    this.turned = turned; // a slider was moved: name and value [SI]
    this.rows = new Map();
    this.el = h("aside", { class: "knobs", "aria-label": "Knobs" });
    this.trouble = h("p", { class: "trouble", role: "alert", hidden: true });
    this.shape = "";
  }

  // Show what a model has; the elements stay where only values differ, so that a drag goes on.
  show(facts) {
    this.facts = facts;
    this.complain("");
    const shape = JSON.stringify([facts.knobs.map((one) => [one.name, one.label, one.description, one.min, one.max, one.unit, one.follows]),
      facts.contacts.map((one) => [one.joint, one.models.length]), facts.settings.gravity.length]);
    if (shape !== this.shape) this.build(facts);
    this.shape = shape;
    for (const knob of facts.knobs) this.rows.get(`knob ${knob.name}`)(knob);
    for (const contact of facts.contacts) this.rows.get(`contact ${contact.joint}`)(contact);
    this.rows.get("settings")(facts.settings);
  }

  build(facts) {
    this.rows.clear();
    const parameters = facts.knobs.map((knob) => this.knobRow(knob));
    const empty = h("p", { class: "quiet" }, "The model has no parameters. Write a dimension as one in Text, and it becomes a slider here.");
    const contacts = facts.contacts.map((contact) => this.contactRow(contact));
    replace(this.el, this.trouble,
      h("section", {}, h("h2", {}, "Parameters"), parameters.length ? parameters : empty),
      contacts.length ? h("section", {}, h("h2", {}, "Contact models"), contacts) : null,
      h("section", {}, h("h2", {}, "Run"), this.settingRows(facts.settings)));
  }

  complain(words) {
    this.trouble.textContent = words;
    this.trouble.hidden = !words;
  }

  knobRow(knob) {
    const id = `knob-${knob.name}`;
    const entry = h("input", { class: "entry", "aria-label": `${knob.name}, value with unit`, spellcheck: "false", autocomplete: "off" });
    const slider = h("input", { type: "range", id, min: 0, max: STEPS, step: 1 });
    const label = h("label", { for: id, title: knob.label === knob.name ? knob.name : `${knob.label} (${knob.name})` }, knob.label);
    let now = knob, sent = 0, timer = 0;
    const send = (value) => {
      clearTimeout(timer);
      timer = setTimeout(() => {
        sent = performance.now();
        this.tell({ do: "knob", name: knob.name, value: now.unit ? shown(now, value) : Number(plain(value, 10)) });
      }, Math.max(0, sent + WAIT - performance.now()));
    };
    slider.addEventListener("input", () => {
      const value = valueAt(now, Number(slider.value));
      entry.value = shown(now, value);
      slider.setAttribute("aria-valuetext", entry.value);
      this.turned(knob.name, value);
      send(value);
    });
    onEntry(entry, () => shown(now, now.value), (text) => this.tell({ do: "knob", name: knob.name, value: text }));
    this.rows.set(`knob ${knob.name}`, (fresh) => {
      now = fresh;
      slider.disabled = entry.disabled = Boolean(fresh.follows);
      if (document.activeElement === null || !slider.matches(":active")) slider.value = stepOf(fresh, fresh.value);
      if (!entry.matches(":focus")) entry.value = shown(fresh, fresh.value);
      slider.setAttribute("aria-valuetext", shown(fresh, fresh.value));
    });
    const follows = knob.follows ? h("p", { class: "quiet" }, `= ${knob.follows}`) : null;
    const ends = h("div", { class: "ends", "aria-hidden": "true" }, h("span", {}, shown(knob, knob.min)), h("span", {}, shown(knob, knob.max)));
    const about = knob.description ? h("p", { class: "quiet about" }, knob.description) : null;
    return h("div", { class: "knob" }, h("div", { class: "row" }, label, entry), about, follows ?? [slider, ends]);
  }

  contactRow(contact) {
    const id = `contact-${contact.joint}`;
    const select = h("select", { id }, contact.models.map((one) => h("option", { value: one }, one.replaceAll("-", " "))));
    select.addEventListener("change", () => this.tell({ do: "contact", joint: contact.joint, model: select.value }));
    this.rows.set(`contact ${contact.joint}`, (fresh) => { select.value = fresh.model; });
    return h("div", { class: "row" }, h("label", { for: id }, contact.joint), select);
  }

  settingRows(settings) {
    const fields = settings.gravity.map((_, k) => this.entryRow(`gravity ${"xy"[k]}`, `gravity.${k}`, (s) => withUnit(s.gravity[k], "m/s²")));
    const end = this.entryRow("end", "simulate.t_end", (s) => withUnit(s.t_end, "s"));
    const method = h("select", { id: "setting-method" }, h("option", { value: "" }, "automatic"), settings.methods.map((one) => h("option", { value: one }, one)));
    method.addEventListener("change", () => this.tell({ do: "method", method: method.value }));
    this.rows.set("settings", (fresh) => {
      for (const row of [...fields, end]) row.update(fresh);
      method.value = fresh.method;
    });
    return [...fields.map((row) => row.el), end.el, h("div", { class: "row" }, h("label", { for: "setting-method" }, "method"), method)];
  }

  entryRow(label, name, read) {
    const entry = h("input", { class: "entry", id: `setting-${name}`, spellcheck: "false", autocomplete: "off" });
    let text = "";
    onEntry(entry, () => text, (value) => this.tell({ do: "setting", name, value }));
    const update = (settings) => {
      text = read(settings);
      if (!entry.matches(":focus")) entry.value = text;
    };
    return { el: h("div", { class: "row" }, h("label", { for: `setting-${name}` }, label), entry), update };
  }
}

function withUnit(text, unit) {
  return /^[-+.\d]+(e[-+]?\d+)?$/i.test(text.trim()) ? `${text.trim()} ${unit}` : text;
}

// An entry takes effect with Enter or when it is left; Escape brings back what was there.
function onEntry(entry, before, take) {
  const done = () => {
    const text = entry.value.trim().replaceAll("²", "^2");
    if (text && entry.value !== before()) take(text);
    else entry.value = before();
  };
  entry.addEventListener("focus", () => entry.select());
  entry.addEventListener("change", done);
  entry.addEventListener("keydown", (event) => {
    if (event.key === "Escape") { entry.value = before(); entry.blur(); event.stopPropagation(); }
  });
}
