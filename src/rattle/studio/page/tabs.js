// Tabs: what each shows, whether it is computed, out of date or wrong, and what can be asked of it.

import { h, replace } from "./dom.js";

export const TABS = []; // [name, title] of each
const FORMS = new Map(); // fields by tab

// The tabs that the studio has: [{name, title, fields}].
export function know(forms) {
  TABS.splice(0, TABS.length, ["motion", "Motion"], ...forms.map((tab) => [tab.name, tab.title]), ["text", "Text"]);
  for (const tab of forms) FORMS.set(tab.name, tab.fields);
}

const SAID = {
  waiting: "waiting for its turn …", running: "computing …", old: "out of date: the model has changed since", stopped: "stopped", failed: "", done: "",
};

// The head of a tab: its state, progress, what can be chosen, and the buttons.
export class TabHead {
  constructor(tab, tell) {
    this.tab = tab;
    this.tell = tell;
    this.words = h("span", { class: "words", role: "status" });
    this.bar = h("progress", { max: 1, hidden: true });
    this.stop = h("button", { class: "quiet", hidden: true, onclick: () => tell({ do: "stop", tab }) }, "Stop");
    this.again = h("button", { hidden: true, onclick: () => this.compute() }, "Compute");
    this.form = h("div", { class: "form" });
    this.inputs = new Map();
    this.entered = new Set(); // fields into which the user has written
    this.usual = new Map();
    this.el = h("div", { class: "tab-head" }, this.form, h("div", { class: "state" }, this.words, this.bar, this.stop, this.again));
    this.state = "";
  }

  compute() { this.tell({ do: "compute", tab: this.tab, options: this.read() }); }

  // What can be chosen, as fields: [{key, label, kind: "select" | "text", options, value, hint}].  What the user has
  // entered stays; a field that was left alone follows the model, and what it means is left to the studio.
  offer(fields) {
    const text = JSON.stringify(fields);
    if (text === this.offered) return;
    this.offered = text;
    if (fields.map((one) => one.key).join() !== [...this.inputs.keys()].join()) this.build(fields);
    for (const field of fields) {
      const { input, list } = this.inputs.get(field.key);
      this.usual.set(field.key, field.value);
      if (!this.entered.has(field.key)) input.value = field.value;
      if (list) replace(list, field.options.map((one) => h("option", { value: one })));
    }
  }

  build(fields) {
    this.forget();
    replace(this.form, fields.map((field) => {
      const id = `${this.tab}-${field.key}`;
      const input = field.kind === "select"
        ? h("select", { id }, field.options.map((one) => h("option", { value: one }, one)))
        : h("input", { id, spellcheck: "false", autocomplete: "off", placeholder: field.hint ?? "", size: field.size ?? 18, list: field.options ? `${id}-list` : null });
      const list = field.kind !== "select" && field.options ? h("datalist", { id: `${id}-list` }) : null;
      this.inputs.set(field.key, { input, list });
      input.addEventListener("input", () => this.entered.add(field.key));
      input.addEventListener(field.kind === "select" ? "change" : "keydown", (event) => {
        if (event.type === "change" || event.key === "Enter") this.compute();
      });
      return h("label", { for: id }, h("span", {}, field.label), input, list);
    }));
  }

  // Another model: nothing that was entered for the one before holds.
  forget() {
    this.inputs.clear();
    this.entered.clear();
    this.usual.clear();
    this.offered = "";
    replace(this.form, []);
  }

  // What was entered; a field that is empty gets back what is usual.
  read() {
    const found = {};
    for (const key of this.entered) {
      const { input } = this.inputs.get(key), value = input.value.trim();
      if (value !== "" && value !== this.usual.get(key)) found[key] = value;
      else {
        this.entered.delete(key);
        input.value = this.usual.get(key);
      }
    }
    return found;
  }

  show(message) {
    this.state = this.el.dataset.state = message.state;
    const busy = message.state === "waiting" || message.state === "running";
    this.words.textContent = message.words && message.state === "failed" ? message.words : message.value?.told ?? SAID[message.state];
    this.words.className = message.state === "failed" ? "words failed" : message.state === "old" ? "words old" : "words";
    this.bar.hidden = !busy;
    if (message.share === undefined) this.bar.removeAttribute("value");
    else this.bar.value = message.share;
    this.stop.hidden = !busy;
    this.again.hidden = busy;
    this.again.textContent = message.state === "old" || message.state === "done" ? "Compute again" : "Compute";
  }
}

// The strip of tabs; arrow keys move in it.
export class Strip {
  constructor(chosen) {
    this.chosen = chosen;
    this.buttons = new Map(TABS.map(([name, title]) => [name, h("button", { role: "tab", id: `tab-${name}`, "aria-controls": `panel-${name}`, onclick: () => chosen(name) },
      title, h("i", { class: "dot", "aria-hidden": "true" }))]));
    this.el = h("div", { class: "strip", role: "tablist", "aria-label": "What is shown" }, [...this.buttons.values()]);
    this.el.addEventListener("keydown", (event) => {
      const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
      if (!step) return;
      const names = [...this.buttons.keys()], now = names.findIndex((one) => this.buttons.get(one).getAttribute("aria-selected") === "true");
      const next = names[(now + step + names.length) % names.length];
      chosen(next);
      this.buttons.get(next).focus();
      event.preventDefault();
    });
  }

  select(name) {
    for (const [one, button] of this.buttons) {
      button.setAttribute("aria-selected", String(one === name));
      button.tabIndex = one === name ? 0 : -1;
    }
    const button = this.buttons.get(name);
    button.scrollIntoView?.({ block: "nearest", inline: "nearest" });
  }

  // A mark beside a title: "busy", "old", "failed" or "".
  mark(name, state) {
    const button = this.buttons.get(name);
    if (!button) return;
    const words = { busy: "computing", old: "out of date", failed: "has a problem" }[state] ?? "";
    button.dataset.state = state;
    button.title = words;
  }
}

// What can be chosen in a tab, from what is declared of it, the facts of the model and the names of curves.
export function fieldsOf(tab, facts, names) {
  const usual = { output: facts.output ?? "", force: facts.force ?? "",
    dimensions: (facts.tolerances.length ? facts.tolerances : facts.knobs.map((knob) => knob.name)).join(", ") };
  const fields = (FORMS.get(tab) ?? []).filter((field) => !field.needs || facts[field.needs].length);
  return fields.map((field) => ({
    key: field.key, label: field.label, size: field.size, kind: field.choices.length ? "select" : "text",
    value: field.usual ? usual[field.usual] : field.value, options: field.choices.length ? field.choices : field.offers_curves ? names : null,
    hint: ["output", "force"].includes(field.usual) ? "known after the motion" : field.means,
  }));
}
