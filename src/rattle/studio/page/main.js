// The page of the studio: it shows what the studio tells and tells what the user does; every decision is the studio's.

import { DECLARED } from "./declared.js";
import { Dialogs, hints } from "./dialogs.js";
import { h } from "./dom.js";
import { Edit } from "./edit.js";
import { Editor } from "./editor.js";
import { Header, Theme } from "./header.js";
import { History } from "./history.js";
import { Knobs } from "./knobs.js";
import { listen } from "./keys.js";
import { Show } from "./motion.js";
import { Report } from "./report.js";
import { Sheet } from "./sheet.js";
import { Status, stateOf } from "./status.js";
import { Strip, TABS, TabHead, fieldsOf, know } from "./tabs.js";
import { Wire } from "./wire.js";

const BEAT = 5000; // between two questions whether the studio is there [ms]
const EMPTY = { knobs: [], contacts: [], wear: [], oil: [], tolerances: [] }; // what is known of a model that was not read yet

class Page {
  constructor(wire) {
    this.wire = wire;
    know(DECLARED);
    this.history = new History();
    this.shown = "motion";
    this.texts = 0; // how many the page has sent
    this.opened = 0; // how many models the studio has given
    this.puts = 0; // how often something was put into the text at once: a step back each
    this.facts = EMPTY;
    this.tell = (message) => {
      this.editor.flush();
      if (["setting", "contact", "method"].includes(message.do)) this.show.otherwise = true;
      wire.send(message.do === "act" ? { ...message, opened: this.opened } : message);
    };
    this.dialogs = new Dialogs((message) => this.tell(message));
    this.editor = new Editor((text, atOnce) => this.typed(text, atOnce), (words) => this.say(words));
    this.knobs = new Knobs((message) => this.tell(message), (name, value) => {
      this.checked = false;
      this.show.turn({ ...this.show.values, [name]: value });
    });
    this.strip = new Strip((name) => this.choose(name));
    this.status = new Status((message) => this.tell(message));
    this.report = new Report();
    this.show = new Show((run) => this.computed(run), (message) => this.tell(message));
    this.edit = new Edit({ send: (message) => this.tell(message), show: this.show, text: () => this.history.now, sent: () => this.texts, back: () => this.move("undo") });
    this.show.edit = this.edit;
    this.show.el.prepend(this.edit.el);
    this.header = new Header({
      edit: () => this.draw(), blank: () => this.unlessUnsaved(() => this.blank()),
      gallery: () => this.tell({ do: "files", gallery: true }), open: () => this.tell({ do: "files" }),
      save: () => this.tell({ do: "save" }), saveAs: () => this.tell({ do: "save-as" }), python: () => this.tell({ do: "python" }),
      undo: () => this.step("undo"), redo: () => this.step("redo"), theme: () => this.theme.next(), keys: () => this.dialogs.keys(),
    });
    this.build();
    this.show.offer();
  }

  // Begin to draw on the Motion tab, or end it.
  draw() {
    if (this.shown !== "motion") this.choose("motion");
    else if (this.edit.on) { this.edit.toggle(false); this.header.draws(false); return; }
    if (!this.edit.on) this.edit.toggle(true);
    this.header.draws(true);
  }

  // An empty sheet, and the tools.
  blank() {
    this.tell({ do: "new" });
    this.choose("motion");
    if (!this.edit.on) this.draw();
  }

  build() {
    this.heads = new Map(DECLARED.map(({ name }) => [name, new TabHead(name, (message) => this.tell(message))]));
    this.sheets = new Map(DECLARED.filter(({ name }) => name !== "report").map(({ name }) => [name, new Sheet((message) => this.tell(message))]));
    this.panels = new Map(TABS.map(([name, title]) => [name, h("section", { class: `panel ${name}`, role: "tabpanel", id: `panel-${name}`, "aria-label": title, hidden: true }, this.content(name))]));
    this.main = h("main", {}, this.strip.el, [...this.panels.values()]);
    this.toast = h("div", { class: "toast", role: "status", hidden: true });
    this.el = h("div", { class: "desk" }, this.header.el, this.knobs.el, this.main, this.status.el, this.toast, this.dialogs.el);
    this.theme = new Theme(this.el, (dark) => {
      this.show.dark(dark);
      for (const sheet of this.sheets.values()) sheet.turn(dark);
    });
    this.theme.button = this.header.theme;
    this.theme.apply();
    this.dialogs.onhints = () => hints(this.strip.el);
    hints(this.strip.el);
    this.choose("motion");
    listen(this);
    this.heard = performance.now();
    this.wire.listen((message) => this.hear(message), () => { this.heard = -Infinity; });
    setInterval(() => this.listen(), BEAT);
    addEventListener("beforeinput", (event) => { // the undo of a browser's menu, or of a phone that is shaken
      const way = { historyUndo: "undo", historyRedo: "redo" }[event.inputType];
      if (way) { event.preventDefault(); this.step(way); }
    }, { capture: true });
    addEventListener("beforeunload", (event) => { if (this.unsaved) event.preventDefault(); });
    this.wire.send({ do: "hello" });
  }

  // Ask the studio whether it is there; a page that has slept asks again before it complains.
  listen() {
    const silent = performance.now() - this.heard, slept = performance.now() - (this.asked ?? 0) > 3 * BEAT;
    this.asked = performance.now();
    if (silent > 4 * BEAT && !slept && !this.gone) {
      this.gone = true;
      this.dialogs.ask("The studio does not answer", "It was ended, or this computer has slept. What is not saved is in Text, from where it can be copied; after that, open the studio again.",
        [["Open again", () => location.reload()], ["Stay here", null]]);
    }
    this.wire.send({ do: "alive" });
  }

  on_alive() { this.gone = false; }

  content(name) {
    if (name === "motion") return this.show.el;
    if (name === "text") return this.editor.el;
    if (name === "report") return [this.heads.get(name).el, this.report.el];
    return [this.heads.get(name).el, this.sheets.get(name).el];
  }

  choose(name) {
    this.shown = this.el.dataset.shown = name;
    this.strip.select(name);
    for (const [one, panel] of this.panels) panel.hidden = one !== name;
    if (name === "text" && !this.editor.suggest.entries) this.wire.send({ do: "entries" });
    this.wire.send({ do: "show", tab: name, options: this.heads.get(name)?.read() ?? {} });
    dispatchEvent(new Event("resize"));
  }

  typed(text, atOnce = false) {
    this.history.record(text, atOnce ? `put ${++this.puts}` : "typing");
    this.header.steps(this.history);
    this.sendText(text);
  }

  sendText(text) {
    this.show.otherwise = true;
    this.wire.send({ do: "text", text, number: ++this.texts, opened: this.opened });
  }

  step(way) {
    this.editor.flush();
    if (!this.edit.takesBack(way)) this.move(way);
  }

  move(way) {
    const text = this.history[way]();
    this.header.steps(this.history);
    if (text === null) return;
    this.edit.waits(this.edit.on);
    this.editor.show(text, "change");
    this.sendText(text);
  }

  say(words) {
    this.toast.textContent = words;
    this.toast.hidden = false;
    clearTimeout(this.toasting);
    this.toasting = setTimeout(() => { this.toast.hidden = true; }, 4000);
  }

  // ---------------------------------------------------------------- what the studio says
  hear(message) {
    this.heard = performance.now();
    const answer = this[`on_${message.kind.replaceAll("-", "_")}`];
    if (answer) answer.call(this, message);
  }

  // What the studio made of an earlier text is not recorded: it has that of the page by now.
  on_text(message) {
    if (message.fresh) this.opened += 1;
    else if (message.heard !== this.texts) return;
    if (message.fresh) { this.history.start(message.text); this.show.clear(); this.edit.fresh(); this.facts = EMPTY; for (const head of this.heads.values()) { head.forget(); head.show({ state: "" }); } for (const sheet of this.sheets.values()) sheet.show([]); }
    else if (this.history.now === "" && !this.history.past.length) this.history.start(message.text);
    else this.history.record(message.text, message.act ? `act ${message.act}` : "knob");
    this.header.steps(this.history);
    this.editor.show(message.text, message.fresh ? "start" : "beside");
  }

  on_name_is(message) {
    this.unsaved = message.changed;
    this.header.name(message);
  }

  on_model(message) {
    this.checked = false;
    this.editor.mark(message.problems);
    this.strip.mark("text", message.problems.length ? "failed" : "");
    this.el.classList.toggle("broken", message.problems.length > 0);
    if (message.problems.length) {
      const first = message.problems[0], more = message.problems.length - 1;
      this.knobs.complain(`The text has ${more ? `${more + 1} problems` : "a problem"}${first.line ? `, line ${first.line}` : ""}: ${first.words}. What is shown is of the last text without problems.`);
      this.status.old();
      return;
    }
    if (message.empty) { this.empty(message.facts); return; }
    this.status.begins();
    this.facts = { output: this.facts.output, force: this.facts.force, ...message.facts }; // until its motion is there
    this.header.title.textContent = message.facts.title || "mechanism";
    document.title = `${message.facts.title || "mechanism"} – rattle studio`;
    this.knobs.show(message.facts);
    this.show.turn(Object.fromEntries(message.facts.knobs.map((one) => [one.name, one.value])));
    this.offer();
  }

  // A text without bodies: a sheet to draw on.
  empty(facts) {
    this.facts = { ...EMPTY, settings: facts.settings };
    this.header.title.textContent = document.title = facts.title || "empty sheet";
    this.knobs.show(this.facts);
    this.show.clear();
    this.show.blank();
    this.status.say("empty", ["Nothing is drawn yet: draw on the Motion tab (Edit), or write bodies under Text."]);
  }

  offer() {
    for (const [tab, head] of this.heads) head.offer(fieldsOf(tab, this.facts, this.show.names));
  }

  on_tab(message) {
    const { tab, state } = message;
    this.status.working(tab, message);
    if (tab === "motion") { this.motion(message); return; }
    if (tab === "trust") { this.trusted(message); return; }
    this.heads.get(tab)?.show(message);
    if (tab === "report" && state === "done") this.report.show(message.value.page, this.facts.title);
    else if (state === "done") this.sheets.get(tab)?.show(message.value.blocks);
    this.strip.mark(tab, state === "waiting" || state === "running" ? "busy" : state === "old" || state === "failed" ? state : "");
  }

  motion(message) {
    this.strip.mark("motion", message.state === "waiting" || message.state === "running" ? "busy" : message.state === "failed" ? "failed" : "");
    if (message.state === "done") {
      this.facts.output = message.value.output;
      this.facts.force = message.value.force;
      this.show.take(message.value);
      this.offer();
      this.vouch(message.value);
    } else if (message.state === "failed") {
      this.show.failed(message.words);
      this.status.say("bad", [message.words]);
    } else {
      this.show.busy(message);
      this.status.old();
    }
  }

  trusted(message) {
    if (message.state === "stopped" || message.state === "failed") this.status.unchecked();
    if (message.state !== "done") return;
    this.checked = true;
    this.vouch(message.value);
  }

  // What a motion says of itself; while the text has problems it is not that of the text.
  vouch(value) {
    this.status.say(stateOf(value), [...(value.success ? [] : [value.message]), ...value.trust]);
    if (this.el.classList.contains("broken")) this.status.old();
  }

  on_sketch(message) { this.edit.hear(message); }

  on_pulled(message) { this.edit.pulled(message); }

  on_readings(message) { this.edit.measures(message); }

  on_picture_file(message) { this.edit.underlay.hear(message); }

  on_live(message) { this.show.compute(message); }

  // The page itself has computed a motion: it says how far that can be trusted, until the studio has checked it.
  computed(run) {
    if (this.checked) return;
    const lines = run.trust?.text ?? [], limited = (run.trust?.limits ?? []).length > 0;
    if (lines.length) this.status.say(stateOf({ success: run.success !== false, trust: lines, limited }), [...(run.success === false ? [run.message] : []), ...lines]);
  }

  on_trouble(message) {
    if (this.facts.settings) this.knobs.show(this.facts); // what was entered is taken back
    if (["act", "measure", "grab", "pull"].includes(message.about)) this.edit.refuse(message.words, message.about);
    else if (["knob", "contact", "setting", "method"].includes(message.about)) this.knobs.complain(message.words);
    else if (message.about === "sketch") this.edit.hear({ trouble: message.words, heard: this.texts }); // or acts would wait for it
    else if (message.about === "measured") this.show.measured.say(message.words);
    else this.say(message.words);
  }

  on_measured(message) { this.show.measured.hear(message); }

  on_entries(message) { this.editor.know(message); }

  on_said(message) { this.say(message.words); }

  on_files(message) {
    if (!message.gallery) this.unlessUnsaved(() => this.dialogs.files(message));
    else this.dialogs.gallery(message.examples, (name) => this.unlessUnsaved(() => this.tell({ do: "example", name })));
  }

  unlessUnsaved(then) {
    if (!this.unsaved) then();
    else this.dialogs.ask("The model has changes that are not saved", "Go on without saving them?", [["Go on without saving", then], ["Cancel", null]]);
  }

  on_name(message) { this.dialogs.name(message); }

  on_overwrite(message) {
    this.dialogs.ask("Overwrite?", message.words, [["Overwrite", () => this.tell({ do: "save", name: message.name, sure: true })],
      ["Save under another name", () => this.tell({ do: "save-as" })], ["Cancel", null]]);
  }

  on_python(message) { this.dialogs.python(message.code); }

  on_thumbnail(message) { this.dialogs.thumbnail(message.name, message.svg); }

  on_sample(message) { this.choose("motion"); this.show.sample(message); }
}

document.body.append(new Page(new Wire()).el);
