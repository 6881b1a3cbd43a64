// Drawing a mechanism on the Motion tab: tools, the sheet, the fields of what is chosen.  Every act is a small change of
// the model text, which the studio makes; the sheet shows the text as it then is.

import { Board, lengthText } from "./board.js";
import { Chosen, FIELDS_FIRST } from "./chosen.js";
import { h, icon, replace } from "./dom.js";
import { Hand } from "./hand.js";
import { Panel } from "./panel.js";
import { TOOLS, headingOf, nextOf, titleOf, toolWords } from "./telling.js";
import { Underlay } from "./underlay.js";

const MOST_LINES = 24; // paths and centrodes on the sheet at once
const STEPS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

export class Edit {
  // send: tells the studio.  show: the Motion tab.  text(): the model text now.  sent(): the number of texts that the page
  // has sent.  back(): takes the last change of the text back.
  constructor({ send, show, text, sent, back }) {
    Object.assign(this, { send, show, sent, back, on: false, heard: 0, under: null, waiting: [], tool: "Select", things: [], count: 0, turned: null, lines: [] });
    this.board = new Board();
    this.hand = new Hand(this.board, this.told());
    this.panel = new Panel({
      write: (chosen, field, value) => (chosen === "picture" ? this.typedBeside(chosen, value) : this.act({ act: "type", chosen, field, text: value })),
      left: () => this.board.above.focus(),
      start: () => { if (this.turned) this.act({ act: "start", places: this.turned }); },
      remove: () => this.remove(),
    });
    this.underlay = new Underlay(this);
    this.buttons = new Map(TOOLS.map(([name, key, what]) => [name, h("button", { "aria-pressed": String(name === this.tool), "aria-label": name,
      title: `${name} (${key}): ${what}`, onclick: () => this.take(name) }, icon(name), h("span", { "aria-hidden": "true" }, name))]));
    this.fit = h("button", { "aria-label": "Show all", title: "Show everything (0)", onclick: () => this.board.fit() }, icon("fit"), h("span", { "aria-hidden": "true" }, "All"));
    this.status = h("span", { class: "freedoms", role: "status" });
    this.follow = h("span", { class: "next", role: "status" });
    this.word = h("span", { class: "word", role: "status" });
    this.fails = h("span", { class: "fails", role: "status" });
    this.alert = h("span", { class: "refused", role: "alert", hidden: true });
    const help = h("p", { id: "edit-help", class: "unseen" }, "Arrow keys move a cross hair, Enter draws with the tool. Tab goes through points, joints and bodies; arrows then move the chosen point, Delete removes it.");
    this.el = h("div", { class: "edit", hidden: true },
      h("div", { class: "edit-tools", role: "toolbar", "aria-label": "Tools" }, [...this.buttons.values()], this.fit, this.underlay.input),
      h("div", { class: "edit-sheet" }, this.board.el, this.panel.el, this.panel.none),
      h("div", { class: "edit-foot" }, this.status, this.follow, this.word, this.fails, this.alert, help));
    this.chosen = new Chosen(this);
    addEventListener("keydown", (event) => this.key(event), { capture: true });
    this.api = this.apiOf(text);
  }

  apiOf(text) {
    const { board } = this, edit = this;
    return {
      get on() { return edit.on; },
      get tool() { return edit.tool; },
      get text() { return text(); },
      get selected() { return edit.things[0] ?? null; },
      get snap() { return edit.drawing ? board.snap : 0; }, // 0 until there is a drawing
      set snap(value) { board.snap = value; },
      get picture() { return edit.underlay.told; },
      toScreen: (at) => board.toScreen(at),
      position: (name) => board.position(name),
    };
  }

  // What the hand asks and tells.
  told() {
    const edit = this;
    return {
      get tool() { return edit.tool; },
      get turned() { return edit.turned !== null; },
      get chosen() { return edit.things; },
      act: (message) => this.act(message),
      choose: (things) => this.choose(things),
      focus: (things) => { if (things.length) { this.choose(things); this.panel.focus(FIELDS_FIRST); } },
      say: (words) => this.say(words),
      point: (words) => this.pointAt(words),
      labelled: (at) => (edit.tool === "Select" ? edit.chosen.labelled(at) : null),
      resume: () => this.resume(),
      stop: (tool) => this.stop(tool),
      spots: (tool, spots) => this.spots(tool, spots),
      grab: (body, at, force) => this.grab(body, at, force),
      pull: (at) => this.pullTo(at),
      release: () => this.release(),
      letGo: () => this.show_still(),
    };
  }

  // ---------------------------------------------------------------- on and off
  toggle(on = !this.on) {
    this.on = on;
    this.el.hidden = !on;
    this.show.draws(on);
    if (on) {
      this.waiting = [];
      this.show.rest();
      this.take("Select");
      this.board.run(null);
      this.board.above.focus({ preventScroll: true });
    } else { this.hand.forget(); this.choose([]); }
    this.send({ do: "edit", on });
    if (on && !this.drawing) this.status.textContent = "The drawing is on its way …";
    this.waits(on);
  }

  // The drawing is that of an earlier text until the studio has drawn the new one.
  get settled() { return !this.under && this.heard === this.sent(); }
  waits(waits = !this.settled || this.waiting.length > 0) { this.board.above.setAttribute("aria-busy", String(waits)); }

  take(name) {
    this.tool = name;
    this.goesOn = true;
    this.starts();
    for (const [one, button] of this.buttons) button.setAttribute("aria-pressed", String(one === name));
    this.hand.forget();
    this.show_still();
    this.complain("");
    if (this.lines.length) this.lines = [];
    this.panel.list([]);
    if (name !== "Select") this.choose([]);
    else this.choose(this.things.filter((thing) => thing !== "picture"));
    this.say(toolWords(name));
    if (name === "Picture") this.underlay.ask();
  }

  // True if the motion that comes now is to play.  Who draws on meanwhile is not disturbed: it plays after the next act.
  starts() {
    const { runs } = this, draws = this.goesOn || this.hand.act !== null;
    this.runs = false;
    if (runs && draws) this.ran = true;
    return runs && !draws;
  }

  // The drawing as the text has it: the motion rests, what was turned by hand goes back.
  show_still() {
    if (this.board.running || this.show.playing) {
      this.ran = this.show.playing;
      this.show.rest();
      this.board.run(null);
    }
    if (this.turned || this.expects || this.pulling) {
      this.turned = null;
      this.pulling = false;
      this.expects = false;
      this.board.pull(null);
      this.panel.start.hidden = true;
      this.send({ do: "let-go" });
    }
  }

  // ---------------------------------------------------------------- what the studio says
  // message: {drawing, words, chosen, field, number} or {trouble}.
  hear(message) {
    this.heard = message.heard;
    this.takeIn(message);
    this.answered(message.number, message.changed);
  }

  takeIn(message) {
    this.breaks(Boolean(message.trouble));
    if (message.trouble) {
      this.status.textContent = message.trouble;
      this.follow.textContent = "";
      return;
    }
    if (message.act !== "keep" && !same(message.drawing.points, this.drawing?.points)) this.lines = []; // measured on another drawing
    this.began ??= message.drawing.scene ? "with a model" : "empty";
    this.drawing = message.drawing;
    if (this.turned) { this.turned = null; this.panel.start.hidden = true; }
    this.expects = false;
    this.board.show(message.drawing);
    this.underlay.show(message.drawing.picture);
    this.status.textContent = message.drawing.status;
    this.follow.textContent = this.began === "empty" ? nextOf(message.drawing) : "";
    const acted = message.number !== undefined;
    if (!acted && !this.pulling) this.hand.forget(); // what was begun may be gone
    this.fail();
    if (acted) {
      this.complain("");
      this.say(message.words);
      if (message.act === "scale-picture") this.spots("Picture", []);
      if (message.chosen) this.choose(this.fullThings(message.chosen));
      else if (message.words) this.choose(this.things);
      if (!message.changed && message.field) this.panel.focus([message.field]);
      this.runs = message.changed && (message.act === "motor" || (message.act === "type" && (this.ran || this.show.playing)));
      if (this.goesOn) this.starts();
    } else this.choose(this.things);
  }

  // While the text has an error there is nothing to draw on: the tools rest.
  breaks(broken) {
    if (broken) this.waiting = [];
    if (broken && !this.broken) { this.hand.cancel(); this.show_still(); this.choose([]); this.say(""); this.complain(""); }
    this.broken = broken;
    this.el.classList.toggle("broken", broken);
    for (const button of this.buttons.values()) button.disabled = broken;
  }

  // Another model is open: it is shown as a whole.
  fresh() {
    this.waiting = [];
    this.under = null;
    this.underlay.forget();
    this.board.begins = true;
    this.began = this.drawing = null;
    this.turned = null;
    this.choose([]);
    this.fail("");
  }

  // Why there is no motion, unless the drawing says that already.
  fail(words = this.failed) {
    this.failed = words;
    this.fails.textContent = words && !/cannot move|does not close/.test(this.drawing?.status ?? "") ? `no motion: ${words}` : "";
  }

  // A pin is chosen with its joints and its point.
  fullThings(chosen) {
    const [kind, name] = chosen.split(/ (.*)/s), joint = (this.drawing.joints ?? []).find((one) => (kind === "joint" && one.name === name) || (kind === "driver" && one.driver === name));
    if (joint) {
      const things = this.hand.from(this.hand.thingsOf(joint.ends[0]), `joint ${joint.name}`);
      return [chosen, ...things.filter((thing) => thing !== chosen)];
    }
    return kind === "point" ? this.hand.thingsOf(name) : [chosen];
  }

  refuse(words, about) {
    this.hand.forget();
    if (this.panel.asked) this.panel.complain(words);
    else this.complain(words);
    if (about === "act") this.answered(this.under?.number, false);
  }

  pulled(message) {
    if (!this.pulling && !this.turned && !this.expects) return;
    this.turned = message.places;
    this.board.pull(message.places);
    this.say(message.words);
  }

  say(words) {
    this.last = words ?? "";
    this.pointAt("");
  }

  // What the hand is over; then again what was said last.
  pointAt(words) {
    const now = words || this.last;
    if (this.word.textContent !== now) this.word.textContent = now;
  }

  complain(words) {
    this.alert.textContent = words;
    this.alert.hidden = !words;
  }

  // ---------------------------------------------------------------- acts
  act(message) {
    if (this.broken) return;
    this.complain("");
    this.goesOn = false; // no tool was taken since
    this.waiting.push({ snap: this.board.snap, ...message, seen: this.settled && !this.waiting.length });
    this.sendNext();
  }

  // One act after the other, each when the drawing is that of the text.
  sendNext() {
    if (this.settled && this.waiting.length) {
      const { seen, ...message } = this.waiting.shift();
      this.under = { number: ++this.count, back: 0 };
      this.send({ do: "act", number: this.count, ...(seen ? message : caughtAnew(message, this.drawing?.points ?? {})) });
    }
    this.waits();
  }

  // The studio has answered an act; what Ctrl Z meant meanwhile is taken back.
  answered(number, changed) {
    if (this.under && number === this.under.number) {
      const { back } = this.under;
      this.under = null;
      for (let k = changed ? 0 : 1; k < back; k++) this.back();
    }
    this.sendNext();
  }

  // True if a step back or forth is one of acts that wait or are under way, the last first.
  takesBack(way) {
    if (!this.under && !this.waiting.length) return false;
    if (way === "undo" && !this.waiting.pop()) this.under.back += 1;
    if (way === "redo" && this.under?.back) this.under.back -= 1;
    this.waits();
    return true;
  }

  choose(things) {
    const known = this.drawing?.fields ?? {};
    this.things = things.filter((thing) => thing in known || thing === "picture");
    const extra = this.extraFields(), title = this.things.length ? titleOf(this.things, this.drawing) : this.turned ? "turned by hand" : "";
    this.panel.show(title, this.things, { ...known, ...extra }, (thing) => headingOf(thing, this.things, this.drawing));
    if (!this.panel.asked) this.panel.complain("");
    this.panel.dodge(this.board, this.drawing);
    this.board.invalidate();
  }

  extraFields() {
    const spots = this.underlay.spots ?? [];
    return { picture: [{ name: "Distance", text: spots.length === 2 ? lengthText(distance(spots), 6) : "", hint: "such as 0.5 m", choices: [] }] };
  }

  typedBeside(chosen, text) {
    if (chosen === "picture" && this.underlay.spots?.length === 2) this.act({ act: "scale-picture", from: this.underlay.spots[0], to: this.underlay.spots[1], text });
  }

  remove() {
    const thing = this.things.find((one) => !one.startsWith("point ") || one.startsWith("point ground."));
    if (!thing && this.things.length) this.say(`${this.things[0]} goes with its body: choose that to delete both`);
    if (thing && thing !== "picture") this.act({ act: "delete", chosen: thing });
    if (thing === "picture") this.act({ act: "no-picture" });
  }

  // ---------------------------------------------------------------- measuring, a picture below
  spots(tool, spots) {
    if (tool === "Picture") {
      if (spots.length > 2 || !spots.length) { this.hand.forget(); this.underlay.spots = null; this.choose([]); return; }
      this.underlay.spots = spots.map((one) => one.at);
      this.say(spots.length < 2 ? "click a second point of known distance" : "type the distance of the two points");
      if (spots.length === 2) { this.choose(["picture"]); this.panel.focus(["Distance"]); }
      return;
    }
    if (spots.length > 3) { this.hand.act = { ...this.hand.act, spots: spots.slice(3) }; spots = spots.slice(3); }
    if (spots.length === 1 && !spots[0].point && !spots[0].line) { this.say("click a second point"); return; }
    this.send({ do: "measure", spots, snap: this.board.snap });
  }

  // What was measured: rows of words, each with what would record it, and lines on the sheet.
  measures({ rows }) {
    if (this.tool !== "Measure") return;
    const curves = rows.flatMap((row) => row.curves);
    this.lines = [...this.lines, ...curves].slice(-MOST_LINES);
    this.panel.list(rows.map((row) => ({ words: row.words, keep: Object.keys(row.signals).length ? () => this.act({ act: "keep", signals: row.signals }) : null })));
    this.say(rows.length ? rows[0].words : "");
    this.board.invalidate();
  }

  // ---------------------------------------------------------------- by hand
  // A press while the motion runs: a body is grabbed where it is, any other tool stops it.
  stop(tool) {
    if (!this.board.running) return false;
    this.wasRunning = tool === "Select" && this.show.playing;
    this.show.pause();
    if (tool !== "Select") this.show_still();
    return true;
  }

  // Nothing was grabbed: the motion that was stopped goes on.
  resume() {
    if (this.wasRunning && !this.pulling) this.show.play();
    this.wasRunning = false;
  }

  // force: it is pulled with a force while the motors hold, and only play lets it follow.
  grab(body, at, force = false) {
    const places = this.board.running ? Object.fromEntries(Object.entries(this.board.running.motion.pose(this.board.running.time))
      .filter(([name]) => name !== "ground").map(([name, place]) => [name, [place.x, place.y, place.angle]])) : this.turned;
    this.grabbedFrom = this.board.running;
    if (this.board.running) this.board.run(null);
    if (places) { this.turned = places; this.board.pull(places); }
    this.pulling = true;
    this.forced = force;
    this.send({ do: "grab", body, at, places, force });
  }

  pullTo(at) {
    this.wanted = at;
    if (this.asking) return;
    this.asking = true;
    requestAnimationFrame(() => {
      this.asking = false;
      if (this.pulling) this.send({ do: "pull", at: this.wanted });
    });
  }

  release() {
    this.pulling = false;
    if (this.asking) this.send({ do: "pull", at: this.wanted }); // an answer may come after the hand has let go
    this.expects = true;
    if (this.grabbedFrom && this.wasRunning) { this.show_still(); this.say(""); this.show.play(); }
    else {
      this.panel.start.hidden = this.forced;
      this.choose(this.things);
      if (!this.forced) this.say("turned by hand; Start here begins the motion so, Escape takes it back");
    }
    this.wasRunning = false;
  }

  // ---------------------------------------------------------------- the motion on the sheet
  frame(motion, scene, time, playing) {
    if (!this.on) return;
    if (!motion || (!playing && time <= motion.start) || this.turned) { if (this.board.running) this.board.run(null); return; }
    this.board.run({ motion, scene, time });
  }

  // ---------------------------------------------------------------- keyboard
  key(event) {
    const target = event.composedPath()[0], writes = target.matches?.("input:not([type=range]), textarea, select");
    if (!this.on || this.broken || !this.show.seen || event.ctrlKey || event.metaKey || event.altKey) return;
    if (writes || document.querySelector("dialog[open]")) return;
    if (this.plainKey(event, target)) {
      event.preventDefault();
      event.stopPropagation();
    }
  }

  plainKey(event, target) {
    const { key } = event, onSheet = target === this.board.above || target === document.body;
    if (key === "Escape") return this.escape();
    if (/^[-0-9.]$/.test(key) && onSheet && this.things.length && this.panel.focus(FIELDS_FIRST, key)) return true;
    if (key === "0") { this.board.fit(); return true; }
    if ((key === "Delete" || key === "Backspace") && onSheet && this.things.length) { this.remove(); return true; }
    if (key in STEPS && onSheet) return this.arrow(STEPS[key], event.shiftKey ? 10 : 1);
    if (key === "Enter" && onSheet) return this.hand.enter();
    if (key === "Tab" && target === this.board.above) return this.next(event.shiftKey ? -1 : 1);
    const tool = TOOLS.find(([, letter]) => letter === key.toUpperCase());
    if (tool && key.length === 1) { this.take(tool[0]); return true; }
    return false;
  }

  escape() {
    if (this.hand.cancel()) { this.say(""); return true; }
    if (this.turned || this.expects || this.board.running) { this.show_still(); this.choose(this.things); return true; }
    if (this.tool !== "Select") { this.take("Select"); return true; }
    this.complain("");
    this.choose([]);
    return true;
  }

  arrow([dx, dy], times) {
    const point = this.things.find((one) => one.startsWith("point "));
    if (point && this.tool === "Select" && !this.hand.act) this.act({ act: "nudge", point: point.slice(6), by: [dx, dy].map((k) => k * times * this.board.snap) });
    else this.hand.step(dx * times, dy * times);
    return true;
  }

  // Tab: the next thing, announced; behind the last one the page goes on.
  next(way) {
    const all = this.hand.everything(), now = all.findIndex((things) => things[0] === this.things[0]);
    const to = now < 0 ? (way > 0 ? 0 : all.length - 1) : now + way;
    if (to < 0 || to >= all.length) { this.choose([]); return false; }
    this.choose(all[to]);
    this.say(titleOf(this.things, this.drawing));
    return true;
  }
}

const same = (one, other) => JSON.stringify(one) === JSON.stringify(other);
const distance = ([a, b]) => Math.hypot(a[0] - b[0], a[1] - b[1]);

// An act on an earlier drawing: places of the sheet at which there are points by now.
function caughtAnew(message, points) {
  const names = Object.entries(points), within = message.snap / 1000;
  const anew = (told) => {
    if (!Array.isArray(told?.at) || told.point || told.line) return told;
    const here = names.filter(([, spot]) => distance([spot, told.at]) <= within).map(([name]) => name);
    return here.length ? { ...told, point: here.find((name) => name.startsWith("ground.")) ?? here[0] } : told;
  };
  return Object.fromEntries(Object.entries(message).map(([key, told]) => [key, Array.isArray(told) ? told.map(anew) : anew(told)]));
}
