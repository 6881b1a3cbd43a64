// Sliders of the parameters: the motion follows while one drags.  Two sets, A and B, can be shown side by side.

import { button, make, say } from "./dom.js";
import { downloadText, modelFile, runTable } from "./hand_over.js";
import { STEPS, stepOf, valueAt } from "./slider.js";
import { typedValue, unitOf } from "./typed.js";
import { handyUnit, plain, printed } from "./units.js";

const ROUNDING = 1e-14; // of a number in a unit: 20 um is 0.000019999999999999998 m, and a limit of so much is meant

// A part of an address as it was written; as it stands where it is none.
function decoded(text) {
  try {
    return decodeURIComponent(text);
  } catch {
    return text;
  }
}

// A name that may be broken behind its underscores.
const broken = (name) => name.split(/(?<=_)/).flatMap((part, k) => (k ? [make("wbr"), part] : [part]));

export class Knobs {
  // source: {compute(slot, model, parameters, settings) -> promise of a run}; ideal: there is a mechanism without play
  constructor(viewer, source, { ideal = false, model = "", first = null } = {}) {
    const { knobs, live } = viewer.scene;
    this.viewer = viewer;
    this.word = viewer.word;
    this.source = source;
    this.hasIdeal = ideal;
    this.model = model;
    this.knobs = new Map(knobs.map((one) => [one.name, one]));
    this.end = live?.settings?.t_end ?? null;
    this.usualEnd = this.end;
    const usual = Object.fromEntries(knobs.map((one) => [one.name, one.value]));
    this.sets = { A: { ...usual }, B: null };
    this.runs = { A: null, B: null, ideal: null };
    this.orders = {}; // how many motions each set has asked for
    this.now = "A";
    this.rows = new Map();
    this.runs.A = first; // of the parameters as they are given, if somebody has computed it already
    this.fromLink();
    this.build(viewer.parts.knobs);
    this.fill();
    this.ready = first && !this.linkText() ? Promise.resolve() : this.computeAll().catch((error) => this.beginAsWritten(error));
    this.quietly(this.ready);
  }

  // An address whose values are refused: the motion of the model file, and the words beside it.
  async beginAsWritten(error) {
    if (!this.runs.A && this.linkText()) {
      this.sets = { A: Object.fromEntries([...this.knobs.values()].map((knob) => [knob.name, knob.value])), B: null };
      [this.now, this.end] = ["A", this.usualEnd];
      await this.follow("A");
      this.fill();
      this.error = error.message;
      this.refuse(`${error.message}. The motion shown is that of the model file.`);
    }
    throw error;
  }

  // ---------------------------------------------------------------- what is shown
  build(root) {
    const { word } = this;
    const limited = [...this.knobs.values()].filter((one) => one.min !== null && one.max !== null);
    const others = [...this.knobs.values()].filter((one) => !limited.includes(one));
    this.which = make("div", { class: "which", role: "group", "aria-label": word("Set of parameters") });
    this.compare = make("button", { type: "button", class: "chip", "aria-pressed": "false", title: word("Two sets of parameters side by side"),
      onclick: () => this.turnSecond(!this.sets.B) }, word("Compare"));
    this.reset = make("button", { type: "button", class: "chip", title: word("All parameters as in the model file"), onclick: () => this.resetAll() }, word("Reset"));
    this.said = make("p", { class: "refused bad", role: "alert", lang: "en", hidden: true });
    this.time = make("input", { type: "text", class: "typed", inputmode: "decimal", "aria-label": word("End of the motion"), title: word("End of the motion, such as 2 s"),
      onchange: () => this.typeEnd() });
    const list = make("div", { class: "rows" }, ...limited.map((one) => this.row(one)));
    root.append(
      make("div", { class: "bar" }, make("b", {}, word("Parameters")), this.which, this.compare, this.reset, make("span", { class: "grow" }),
        make("label", { class: "until" }, word("until"), this.time), this.handing()),
      this.said, list,
      ...(others.length ? [make("details", { class: "more", ...(limited.length ? {} : { open: true }) }, make("summary", {}, limited.length ? word("{count} more", { count: others.length }) : word("All parameters")),
        make("div", { class: "rows" }, ...others.map((one) => this.row(one))))] : []));
    root.hidden = false;
  }

  row(knob) {
    const { word } = this, own = knob.shown ? unitOf(knob.shown) : null;
    const handy = handyUnit(knob.unit, Math.max(...[knob.min, knob.max, knob.value].filter((x) => x !== null).map(Math.abs)), this.viewer.scene.units);
    const shown = own ? { unit: knob.shown, factor: own[0] } : { unit: handy.unit, factor: 1 / handy.factor };
    const around = Math.abs(knob.value) || 1;
    const range = { min: knob.min ?? knob.value - 0.5 * around, max: knob.max ?? knob.value + 0.5 * around, value: knob.value, factor: shown.factor };
    const name = knob.label || knob.name;
    const slider = make("input", { type: "range", min: 0, max: STEPS, step: 1, "aria-label": name, title: word("Double-click: as in the model file"),
      oninput: () => this.quietly(this.turned(knob.name, valueAt(row.range, Number(slider.value)))),
      ondblclick: () => this.quietly(this.turned(knob.name, knob.value)) });
    const box = make("input", { type: "text", class: "typed", inputmode: "decimal", "aria-label": shown.unit ? word("{name} in {unit}", { name, unit: shown.unit }) : word("{name} in its unit", { name }),
      title: shown.unit ? word("Type a number, in {unit} unless you write another unit", { unit: printed(shown.unit) })
        : word("Type a number, in its own unit unless you write another unit"),
      onchange: () => this.typed(row), onkeydown: (event) => this.nudge(row, event) });
    const long = name !== knob.name, label = make("label", { class: "name", title: long ? `${name} (${knob.name})` : name,
      ondblclick: () => this.quietly(this.turned(knob.name, knob.value)) }, make("span", {}, ...broken(name)));
    const about = knob.description ? make("p", { class: "about quiet", hidden: true }, knob.description) : null;
    if (about) label.append(make("button", { type: "button", class: "ask quiet", "aria-label": word("What {name} is", { name }), "aria-expanded": "false",
      onclick: ({ currentTarget: ask }) => {
        about.hidden = !about.hidden;
        ask.setAttribute("aria-expanded", String(!about.hidden));
      } }, "?"));
    const element = make("div", { class: long ? "knob labelled" : "knob" }, label, slider, box, make("span", { class: "unit quiet" }, printed(shown.unit)), about);
    const row = { knob, shown, range, slider, box, element };
    this.rows.set(knob.name, row);
    return row.element;
  }

  fill() {
    const set = this.sets[this.now];
    for (const [name, { knob, range, slider, box, shown, element }] of this.rows) {
      const share = (set[name] - range.min) / (range.max - range.min);
      slider.value = String(stepOf(range, set[name]));
      slider.style.setProperty("--share", Math.min(1, Math.max(0, share)).toFixed(5));
      slider.setAttribute("aria-valuetext", `${plain(set[name] / shown.factor)} ${shown.unit}`);
      if (box !== this.viewer.shadow.activeElement) box.value = plain(set[name] / shown.factor);
      element.classList.toggle("changed", set[name] !== knob.value);
    }
    const end = this.end === this.usualEnd ? this.runs[this.now]?.t_end ?? this.end : this.end;
    if (this.end !== null) this.time.value = `${plain(Number(end.toPrecision(5)))} s`;
    this.time.parentElement.hidden = this.end === null;
    const names = this.sets.B ? ["A", "B"] : [];
    this.which.replaceChildren(...names.map((one) => make("button", { type: "button", class: "chip strong", "aria-pressed": String(one === this.now),
      title: this.word("Turn the parameters of {name}; the other one is dashed", { name: one }), onclick: () => this.look(one) }, one)));
    this.compare.setAttribute("aria-pressed", String(Boolean(this.sets.B)));
  }

  // ---------------------------------------------------------------- what is turned
  // A promise that ends when the motion for this value is there.
  turned(name, value) {
    const knob = this.knobs.get(name);
    if (!knob) return Promise.reject(new Error(`no parameter ${name}; there are ${[...this.knobs.keys()].join(", ") || "none"}`));
    if (!Number.isFinite(value)) return Promise.reject(new Error(`${name}: a finite number is expected`));
    this.sets[this.now][name] = value;
    this.fill();
    this.keepLink();
    return this.follow(this.now);
  }

  quietly(promise) {
    promise.catch(() => {}); // it is said beside the sliders
  }

  typed(row) {
    const { knob, shown, box } = row;
    try {
      const value = typedValue(box.value, knob.unit, shown.unit), told = [knob.value, knob.min, knob.max].filter((x) => x !== null);
      this.quietly(this.turned(knob.name, told.find((x) => Math.abs(value - x) <= ROUNDING * Math.abs(x)) ?? value));
    } catch (error) {
      this.refuse(error.message);
    }
  }

  nudge(row, event) {
    const way = { ArrowUp: 1, ArrowDown: -1 }[event.key];
    if (!way) return;
    event.preventDefault();
    event.stopPropagation();
    const step = stepOf(row.range, this.sets[this.now][row.knob.name]) + 4 * way;
    row.box.blur();
    this.quietly(this.turned(row.knob.name, valueAt(row.range, Math.min(STEPS, Math.max(0, step)))));
    row.box.focus();
  }

  typeEnd() {
    try {
      const end = typedValue(this.time.value, "s", "s");
      if (!(end > 0 && end < Infinity)) throw new Error("the end of the motion must be a time after its start");
      this.end = end;
      this.keepLink();
      this.quietly(this.computeAll());
    } catch (error) {
      this.refuse(error.message);
    }
  }

  resetAll() {
    for (const knob of this.knobs.values()) this.sets[this.now][knob.name] = knob.value;
    this.end = this.usualEnd;
    this.fill();
    this.keepLink();
    this.quietly(this.computeAll());
  }

  turnSecond(on) {
    this.sets.B = on ? { ...this.sets.A } : null;
    if (!on) {
      this.source.drop?.("B");
      this.runs.B = null;
      this.now = "A";
    } else this.now = "B";
    this.fill();
    this.keepLink();
    if (on) this.quietly(this.follow("B"));
    else this.show();
  }

  look(one) {
    this.now = one;
    this.fill();
    this.show();
  }

  // ---------------------------------------------------------------- motions
  // the end only where somebody has chosen one: otherwise it may follow from parameters
  settings() {
    return this.end === this.usualEnd ? {} : { t_end: this.end };
  }

  async follow(slot) {
    const set = { ...this.sets[slot] }, order = this.orders[slot] = (this.orders[slot] ?? 0) + 1;
    this.busy(1);
    try {
      this.requireLimits(set);
      const follows = slot === "A" && this.hasIdeal, [run, ideal] = await Promise.all([
        this.source.compute(slot, "model", set, this.settings()),
        follows ? this.source.compute("ideal", "ideal", set, this.settings()).catch(() => null) : null,
      ]);
      if (!run || !this.sets[slot]) return;
      run.label = slot;
      this.runs[slot] = run;
      if (follows) this.runs.ideal = ideal; // none where there is none for these values
      if (order === this.orders[slot]) { // what was said of a later wish stays
        this.error = null;
        this.refuse("");
      }
      this.show();
      this.viewer.emit("set", run.parameters);
    } catch (error) {
      this.error = error.message;
      this.refuse([error.message, this.runs[slot] ? "The motion shown is the one before." : ""].filter(Boolean).join(". ").replace("..", "."));
      throw error;
    } finally {
      this.busy(-1);
    }
  }

  // In the units of the page; whoever computes knows those of SI.
  requireLimits(set) {
    for (const { knob, shown: { unit, factor } } of this.rows.values()) {
      const { min, max } = knob, inUnit = (x) => plain(x / factor), value = set[knob.name];
      if (value >= (min ?? -Infinity) && value <= (max ?? Infinity)) continue;
      const limits = [min === null ? "" : `at least ${inUnit(min)}`, max === null ? "" : `at most ${inUnit(max)}`].filter(Boolean).join(", ");
      throw new Error(`${knob.label || knob.name} = ${inUnit(value)} ${printed(unit)} is outside of its limits: ${limits} ${printed(unit)}`.trim());
    }
  }

  computeAll() {
    return Promise.all([this.follow("A"), ...(this.sets.B ? [this.follow("B")] : [])]);
  }

  show() {
    const { A, B, ideal } = this.runs, main = this.runs[this.now] ?? A;
    if (!main) return;
    const other = this.now === "A" ? B : A;
    main.label = B ? this.now : "";
    this.viewer.setRun(main, { ghost: ideal, others: B && other ? [other] : [] });
  }

  // The horizon of a motion has become known.
  heard(slot, trust) {
    const run = this.runs[slot];
    if (!run) return;
    run.trust = trust;
    if (run === (this.runs[this.now] ?? this.runs.A)) this.viewer.sayTrust();
  }

  busy(change) {
    this.working = (this.working ?? 0) + change;
    clearTimeout(this.sayBusy);
    const { busy } = this.viewer.parts;
    if (!this.working) busy.hidden = true;
    else this.sayBusy = setTimeout(() => {
      const stop = make("button", { type: "button", class: "chip", title: this.word("Show what was computed so far"), onclick: () => this.source.stop?.() }, this.word("Stop"));
      this.share = make("span", {}, this.word("computing …"));
      busy.replaceChildren(this.share, ...(this.source.stop ? [stop] : []));
      busy.hidden = false;
    }, 250);
  }

  progress(share) {
    if (this.share) say(this.share, `${this.word("computing …")} ${Math.floor(100 * share)} %`);
  }

  refuse(text) {
    say(this.said, text.replace(/^[a-z](?=[a-z]* ['a-z])/, (letter) => letter.toUpperCase())); // no name of a parameter
    this.said.hidden = !text;
  }

  // ---------------------------------------------------------------- handing over
  handing() {
    const { word } = this, menu = make("div", { class: "menu right", hidden: true, role: "group", "aria-label": word("Hand over") });
    const act = (text, title, call) => make("button", { type: "button", class: "item", title, onclick: () => { open(false); call(); } }, text);
    const toggle = make("button", { type: "button", class: "chip", "aria-expanded": "false", title: word("Link, model file, curves"),
      onclick: () => open(menu.hidden) }, word("Send"));
    const open = (on) => {
      menu.hidden = !on;
      toggle.setAttribute("aria-expanded", String(on));
    };
    menu.append(act(word("Copy a link to this setting"), word("The address of this page with the parameters in it"), () => this.copyLink()),
      ...(this.model ? [act(word("Model file with these parameters"), word("A .toml file for rattle"), () => downloadText("model.toml", modelFile(this.model, this.sets[this.now], this.knobs)))] : []),
      act(word("Curves that are shown, as CSV"), word("One row per instant, SI units"), () => downloadText("curves.csv", runTable(this.viewer.motion, this.viewer.curves.chosen))));
    menu.addEventListener("keydown", (event) => {
      if (event.key !== "Escape") return;
      event.stopPropagation();
      open(false);
      toggle.focus();
    });
    return make("span", { class: "hand" }, toggle, menu);
  }

  // Parameters that differ from the model's, as #r3=0.002&B.r3=0.004; what is no parameter has a dot in its name where a
  // parameter is called so.
  linkText() {
    const parts = [];
    for (const [slot, set] of Object.entries(this.sets)) {
      if (!set) continue;
      const head = slot === "B" ? "B." : "";
      if (slot === "B") parts.push(`${this.linkKey("B")}=`);
      for (const { name, value } of this.knobs.values()) if (set[name] !== value) parts.push(`${head}${encodeURIComponent(name)}=${set[name]}`);
    }
    if (this.end !== this.usualEnd) parts.push(`${this.linkKey("t_end")}=${this.end}`);
    return parts.join("&");
  }

  linkKey(word) {
    return this.knobs.has(word) ? `.${word}` : word;
  }

  keepLink() {
    if (!this.viewer.host.page) return;
    const text = this.linkText();
    clearTimeout(this.linking); // browsers allow a few changes per second
    this.linking = setTimeout(() => history.replaceState(null, "", text ? `#${text}` : location.pathname + location.search), 300);
  }

  fromLink() {
    if (!this.viewer.host.page) return;
    for (const part of location.hash.slice(1).split("&")) {
      const [key, text = ""] = part.split("=").map(decoded), value = Number(text);
      const second = key.startsWith("B."), name = second ? key.slice(2) : key;
      if (second || key === this.linkKey("B")) this.sets.B ??= Object.fromEntries([...this.knobs.values()].map((one) => [one.name, one.value]));
      if (text === "" || !Number.isFinite(value)) continue;
      if (this.knobs.has(name)) this.sets[second ? "B" : "A"][name] = value;
      else if (key === this.linkKey("t_end") && value > 0 && this.end !== null) this.end = value;
    }
  }

  async copyLink() {
    const address = `${location.href.split("#")[0]}#${this.linkText()}`;
    try {
      await navigator.clipboard.writeText(address);
      this.refuse("");
      say(this.viewer.parts.busy, this.word("copied"));
      this.viewer.parts.busy.hidden = false;
      setTimeout(() => { this.viewer.parts.busy.hidden = true; }, 1200);
    } catch {
      globalThis.prompt(this.word("Copy this address:"), address);
    }
  }

  destroy() {
    clearTimeout(this.linking);
    clearTimeout(this.sayBusy);
    this.source.destroy();
  }
}
