// Drawing a mechanism on the Motion tab: tools, the sheet, the fields of what is chosen.  Every act is a small change of
// the model text, which the studio makes; the sheet shows the text as it then is.

import { Board, lengthText } from "./board.js";
import { h, icon, replace } from "./dom.js";
import { Hand } from "./hand.js";
import { Panel } from "./panel.js";
import { Underlay } from "./underlay.js";

const TOOLS = [
  ["Select", "V", "choose, drag points, turn the mechanism by a body"], ["Ground", "O", "click: a point of the ground"],
  ["Bar", "B", "drag from point to point"], ["Plate", "P", "click corners, the first one again to close"],
  ["Pin", "J", "click where two bodies cross, or on a joint for its play"], ["Slider", "L", "click an end, drag for a direction"],
  ["Slot", "U", "drag along a bar, then click the point that slides"], ["Gear", "W", "click two centres"],
  ["Motor", "M", "click a pin on the ground, or a slider"], ["Spring", "S", "drag from point to point"],
  ["Force", "F", "drag from a point: 1 N per step of the grid"], ["Measure", "R", "click a point for its path, a bar for its centrodes, two points, three for an angle"],
  ["Picture", "I", "a photograph below the drawing, scaled by two points"],
];
const FIELDS_FIRST = ["Length", "Play", "Speed", "X", "Force", "Stiffness"]; // into which digits go
const MOST_LINES = 24; // paths and centrodes on the sheet at once
const STEPS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

export class Edit {
  // send: tells the studio.  show: the Motion tab.  text(): the model text now.
  constructor({ send, show, text }) {
    Object.assign(this, { send, show, on: false, tool: "Select", things: [], count: 0, turned: null, lines: [] });
    this.board = new Board();
    this.hand = new Hand(this.board, this.told());
    this.panel = new Panel({
      write: (chosen, field, value) => (chosen === "picture" ? this.typedBeside(chosen, value) : this.act({ act: "type", chosen, field, text: value })),
      left: () => this.board.above.focus(),
      start: () => this.act({ act: "start", places: this.turned }),
      remove: () => this.remove(),
    });
    this.underlay = new Underlay(this);
    this.buttons = new Map(TOOLS.map(([name, key, what]) => [name, h("button", { "aria-pressed": String(name === this.tool), "aria-label": name,
      title: `${name} (${key}): ${what}`, onclick: () => this.take(name) }, icon(name), h("span", { "aria-hidden": "true" }, name))]));
    this.fit = h("button", { "aria-label": "Show all", title: "Show everything (0)", onclick: () => this.board.fit() }, icon("fit"), h("span", { "aria-hidden": "true" }, "All"));
    this.status = h("span", { class: "freedoms", role: "status" });
    this.word = h("span", { class: "word", role: "status" });
    this.alert = h("span", { class: "refused", role: "alert", hidden: true });
    const help = h("p", { id: "edit-help", class: "unseen" }, "Arrow keys move a cross hair, Enter draws with the tool. Tab goes through points, joints and bodies; arrows then move the chosen point, Delete removes it.");
    this.el = h("div", { class: "edit", hidden: true },
      h("div", { class: "edit-tools", role: "toolbar", "aria-label": "Tools" }, [...this.buttons.values()], this.fit, this.underlay.input),
      h("div", { class: "edit-sheet" }, this.board.el, this.panel.el),
      h("div", { class: "edit-foot" }, this.status, this.word, this.alert, help));
    this.board.marks.unshift((p) => this.drawChosen(p));
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
      get snap() { return board.snap; },
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
      get word() { return edit.word.textContent; },
      act: (message) => this.act(message),
      choose: (things) => this.choose(things),
      focus: (things) => { if (things.length) { this.choose(things); this.panel.focus(FIELDS_FIRST); } },
      say: (words) => this.say(words),
      stop: (tool) => this.stop(tool),
      spots: (tool, spots) => this.spots(tool, spots),
      grab: (body, at) => this.grab(body, at),
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
      this.show.rest();
      this.take("Select");
      this.board.run(null);
      this.board.above.focus({ preventScroll: true });
    } else this.choose([]);
    this.send({ do: "edit", on });
  }

  take(name) {
    this.tool = name;
    for (const [one, button] of this.buttons) button.setAttribute("aria-pressed", String(one === name));
    this.hand.forget();
    this.show_still();
    this.complain("");
    if (this.lines.length) this.lines = [];
    this.panel.list([]);
    if (name !== "Select") this.choose([]);
    else this.choose(this.things.filter((thing) => thing !== "picture"));
    this.say(TOOLS.find(([one]) => one === name)[2]);
    if (name === "Picture") this.underlay.ask();
  }

  // The drawing as the text has it: the motion rests, what was turned by hand goes back.
  show_still() {
    if (this.board.running) { this.show.rest(); this.board.run(null); }
    if (this.turned) {
      this.turned = null;
      this.board.pull(null);
      this.panel.start.hidden = true;
      this.send({ do: "let-go" });
    }
  }

  // ---------------------------------------------------------------- what the studio says
  // message: {drawing, words, chosen, field, number} or {trouble}.
  hear(message) {
    if (message.trouble) {
      this.broken = true;
      this.el.classList.add("broken");
      this.status.textContent = message.trouble;
      return;
    }
    this.broken = false;
    this.el.classList.remove("broken");
    this.drawing = message.drawing;
    if (this.turned) { this.turned = null; this.panel.start.hidden = true; }
    this.board.show(message.drawing);
    this.underlay.show(message.drawing.picture);
    this.status.textContent = message.drawing.status;
    const acted = message.number !== undefined;
    if (acted) {
      this.complain("");
      this.say(message.words);
      if (message.chosen) this.choose(this.fullThings(message.chosen));
      else if (message.words) this.choose(this.things);
      if (!message.changed && message.field) this.panel.focus([message.field]);
      this.runs = message.act === "motor" && message.changed;
    } else this.choose(this.things);
  }

  // A pin is chosen with its joints and its point.
  fullThings(chosen) {
    const [kind, name] = chosen.split(/ (.*)/s), joint = (this.drawing.joints ?? []).find((one) => (kind === "joint" && one.name === name) || (kind === "driver" && one.driver === name));
    if (joint) {
      const things = this.hand.thingsOf(joint.ends[0]);
      return [chosen, ...things.filter((one) => one !== chosen)];
    }
    return kind === "point" ? this.hand.thingsOf(name) : [chosen];
  }

  refuse(words) {
    this.hand.forget();
    if (this.panel.asked) this.panel.complain(words);
    else this.complain(words);
  }

  pulled(message) {
    if (!this.pulling && !this.turned) return;
    this.turned = message.places;
    this.board.pull(message.places);
    this.say(message.words);
  }

  say(words) { if (this.word.textContent !== words) this.word.textContent = words ?? ""; }

  complain(words) {
    this.alert.textContent = words;
    this.alert.hidden = !words;
  }

  // ---------------------------------------------------------------- acts
  act(message) {
    if (this.broken) return;
    this.complain("");
    this.send({ do: "act", number: ++this.count, snap: this.board.snap, ...message });
  }

  choose(things) {
    const known = this.drawing?.fields ?? {};
    this.things = things.filter((thing) => thing in known || thing === "picture");
    const first = this.things[0] ?? "", extra = this.extraFields();
    this.panel.show(first ? titleOf(this.things, this.drawing) : this.turned ? "turned by hand" : "", this.things, { ...known, ...extra });
    if (!this.panel.asked) this.panel.complain("");
    this.board.invalidate();
  }

  extraFields() {
    const spots = this.underlay.spots ?? [];
    return { picture: [{ name: "Distance", text: spots.length === 2 ? lengthText(distance(spots), 6) : "", hint: "such as 0.5 m", choices: [] }] };
  }

  typedBeside(chosen, text) {
    if (chosen === "picture") this.act({ act: "scale-picture", from: this.underlay.spots[0], to: this.underlay.spots[1], text });
  }

  remove() {
    const thing = this.things.find((one) => !one.startsWith("point ") || one.startsWith("point ground."));
    if (thing && thing !== "picture") this.act({ act: "delete", chosen: thing });
    if (thing === "picture") this.act({ act: "no-picture" });
  }

  // ---------------------------------------------------------------- measuring, a picture below
  spots(tool, spots) {
    if (tool === "Picture") {
      if (spots.length > 2) { this.hand.act = null; this.underlay.spots = null; this.choose([]); return; }
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
    this.wasRunning = this.show.playing;
    this.show.pause();
    if (tool !== "Select") this.show_still();
    return true;
  }

  grab(body, at) {
    const places = this.board.running ? Object.fromEntries(Object.entries(this.board.running.motion.pose(this.board.running.time))
      .filter(([name]) => name !== "ground").map(([name, place]) => [name, [place.x, place.y, place.angle]])) : this.turned;
    this.grabbedFrom = this.board.running;
    if (this.board.running) this.board.run(null);
    if (places) { this.turned = places; this.board.pull(places); }
    this.pulling = true;
    this.send({ do: "grab", body, at, places });
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
    if (this.grabbedFrom && this.wasRunning) { this.show_still(); this.show.play(); }
    else {
      this.panel.start.hidden = false;
      this.choose(this.things);
      this.say("turned by hand; Start here begins the motion so, Escape takes it back");
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
    if (!this.on || !this.show.seen || event.ctrlKey || event.metaKey || event.altKey) return;
    if (writes || document.querySelector("dialog[open]")) return;
    if (this.plainKey(event, target)) {
      event.preventDefault();
      event.stopPropagation();
    }
  }

  plainKey(event, target) {
    const { key } = event, onSheet = target === this.board.above || target === document.body;
    if (key === "Escape") return this.escape();
    if (/^[0-9.]$/.test(key) && this.things.length && this.panel.focus(FIELDS_FIRST, key)) return true;
    if (key === "0") { this.board.fit(); return true; }
    if ((key === "Delete" || key === "Backspace") && this.things.length) { this.remove(); return true; }
    if (key in STEPS && onSheet) return this.arrow(STEPS[key], event.shiftKey ? 10 : 1);
    if (key === "Enter" && onSheet) return this.hand.enter();
    if (key === "Tab" && target === this.board.above) return this.next(event.shiftKey ? -1 : 1);
    const tool = TOOLS.find(([, letter]) => letter === key.toUpperCase());
    if (tool && key.length === 1) { this.take(tool[0]); return true; }
    return false;
  }

  escape() {
    if (this.hand.cancel()) { this.say(""); return true; }
    if (this.turned || this.board.running) { this.show_still(); this.choose(this.things); return true; }
    if (this.tool !== "Select") { this.take("Select"); return true; }
    this.complain("");
    this.choose([]);
    return true;
  }

  arrow([dx, dy], times) {
    const point = this.things.find((one) => one.startsWith("point "));
    if (point && !this.hand.act) this.act({ act: "nudge", point: point.slice(6), by: [dx, dy].map((k) => k * times * this.board.snap) });
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

  // ---------------------------------------------------------------- what is chosen, and what is open
  drawChosen(p) {
    const { board, drawing } = this, { theme } = board;
    this.lines.forEach((line, k) => p.line(line.map((at) => (at[0] === null ? null : at)), { colour: theme.curve(k), width: 2 }));
    if (!drawing || board.running) return;
    for (const thing of this.things) {
      const [kind, name] = thing.split(/ (.*)/s);
      if (kind === "body") this.outlineOf(p, name);
      if (kind === "point" && board.position(name)) p.dot(board.position(name), 11, { colour: theme.sky, width: 3, fill: null });
    }
    for (const name of Object.keys(drawing.points)) {
      if (name.startsWith("ground.")) p.dot(drawing.points[name], 3.5, { colour: theme.black, fill: theme.paper, width: 1.6 });
    }
    for (const { apart, ends } of drawing.joints) {
      if (!(apart > 0)) continue;
      const [a, b] = ends.map((end) => board.position(end));
      p.line([a, b], { colour: theme.red, width: 2.5, dash: [4, 4] });
      for (const at of [a, b]) p.dot(at, 7, { colour: theme.red, width: 2.5, fill: null });
    }
    if (this.tool === "Select") this.label(p);
  }

  outlineOf(p, body) {
    const { board } = this, ends = this.drawing.bars[body], place = board.placeOf(body), form = board.geometry.bodies[body];
    const soft = { colour: board.theme.sky, width: 9, opacity: 0.45 };
    if (ends) p.line(ends.map((end) => board.position(end)), soft);
    else if (form?.outline && place) p.line(form.outline[0].map(([x, y]) => [place.x + place.cos * x - place.sin * y, place.y + place.sin * x + place.cos * y]), { ...soft, width: 4, closed: true });
    else for (const point of Object.keys(form?.points ?? {})) p.dot(board.position(`${body}.${point}`), 14, { colour: board.theme.sky, width: 3, fill: null });
  }

  // The main value of what is chosen, beside it.
  label(p) {
    const thing = this.things[0], [kind, name] = (thing ?? "").split(/ (.*)/s), field = (this.drawing.fields[thing] ?? []).find((one) => FIELDS_FIRST.includes(one.name) && one.text);
    if (!field || kind === "point") return;
    const ends = kind === "body" ? this.drawing.bars[name] : this.drawing.joints.find((one) => one.name === name || one.driver === name)?.ends ?? this.drawing.loads[name];
    const spots = (ends ?? []).map((end) => this.board.position(end)).filter(Boolean);
    if (spots.length) p.tag(`${field.name === "Length" ? "" : `${field.name.toLowerCase()} `}${field.text}`, [0, 1].map((k) => spots.reduce((sum, at) => sum + at[k], 0) / spots.length), { dx: 14, dy: -14, bold: true });
  }
}

const distance = ([a, b]) => Math.hypot(a[0] - b[0], a[1] - b[1]);

// What is chosen, in words: "joint J3, coupler and rocker, play 0.2 mm".
function titleOf(things, drawing) {
  const [kind, name] = (things[0] ?? "").split(/ (.*)/s);
  if (kind === "joint") {
    const joint = drawing.joints.find((one) => one.name === name), bodies = joint.ends.map((end) => end.split(".")[0]);
    return `${joint.type === "revolute" ? "pin" : joint.type} ${name}, ${bodies.join(" and ")}${joint.play ? `, play ${joint.play}` : ""}`;
  }
  if (kind === "body") return `${drawing.bars[name] ? "bar" : "body"} ${name}`;
  if (kind === "driver") return `${name} drives ${drawing.joints.find((one) => one.driver === name)?.name ?? "a coordinate"}`;
  if (kind === "picture") return "picture below the drawing";
  return things[0] ?? "";
}
