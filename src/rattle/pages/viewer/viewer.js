// One viewer: what is shown, and when it is drawn.  It draws only while something changes and someone can see it.

import { themeOf } from "./colours.js";
import { Chooser } from "./chooser.js";
import { Clock, usualSpeed } from "./clock.js";
import { Curves, firstChoice } from "./curves.js";
import { Motion, pathNames, pathOf } from "./data.js";
import { make, say } from "./dom.js";
import { eventTable } from "./events.js";
import { gestures } from "./gestures.js";
import { handleKeys } from "./keys.js";
import { layout, sayTrust, tabbed, toolbar } from "./layout.js";
import { unpackMeasured } from "./measured.js";
import { MechanismView } from "./mechanism.js";
import { Orbits } from "./orbits.js";
import { Insets } from "./pins.js";
import { Player } from "./player.js";
import { pinsWithPlay } from "./stage.js";
import { viewerStyle } from "./style.js";
import { speaking } from "./words.js";

export class Viewer {
  constructor(root, scene, host) {
    Object.assign(this, { root, scene, host, listeners: new Map(), ends: [], frameId: 0, awake: true, others: [] });
    this.word = speaking(scene.words);
    this.clock = new Clock();
    this.measured = unpackMeasured(scene.measured ?? []);
    const wish = scene.show ?? {};
    this.show = { forces: wish.forces ?? false, ghost: wish.ghost ?? Boolean(scene.ideal), names: Boolean(wish.names), traces: wish.traces ?? [] };
    this.calm = globalThis.matchMedia?.("(prefers-reduced-motion: reduce)").matches ?? false;
    this.build();
    this.watch();
    this.turnTheme(host.theme ?? "auto");
  }

  build() {
    this.box = make("div", { class: "rattle-viewer" });
    this.root.append(this.box);
    this.shadow = this.box.attachShadow({ mode: "open" });
    const { word } = this, parts = this.parts = layout(this, this.scene);
    this.view = new MechanismView(parts.canvas, word);
    this.insets = new Insets(parts.insets, word);
    this.player = new Player(this);
    this.tools = toolbar(this, this.scene);
    parts.tools.append(...this.tools.all, parts.late, parts.busy);
    const panels = make("div", { class: "panels", "data-empty": word("Choose curves to see them over time.") });
    this.curves = new Curves(panels, this);
    this.chooser = new Chooser(this);
    this.orbitSheet = make("div", { class: "sheet orbits" });
    this.orbits = new Orbits(this.orbitSheet, word);
    this.eventSheet = make("div", { class: "sheet" });
    this.tabs = tabbed(parts.tabs, parts.sheets, () => this.invalidate());
    this.tabs.add("curves", word("Curves"), make("div", { class: "sheet curves" },
      make("div", { class: "bar" }, this.chooser.toggle, this.host.measured?.button, make("span", { class: "quiet hint" }, word("click: go to a time, drag or wheel: zoom; ▼ largest value"))), this.host.measured?.rows, this.chooser.element, panels));
    this.tabs.add("orbits", word("Orbits"), this.orbitSheet);
    this.tabs.add("events", word("Events"), this.eventSheet);
    this.tabs.choose("curves");
    this.frame = make("div", { class: `frame${this.host.page ? " page" : this.host.inside ? " inside" : ""}`, tabindex: 0, role: "region",
      "aria-label": this.scene.title ?? word("Mechanism"), lang: this.scene.language },
      parts.header, parts.trust, parts.main, this.player.element, parts.help);
    this.shadow.append(make("style", {}, viewerStyle), this.frame);
  }

  // Everything from outside that it listens to; `ends` undoes it.
  watch() {
    const listen = (target, name, call) => {
      target.addEventListener(name, call);
      this.ends.push(() => target.removeEventListener(name, call));
    };
    const resize = new ResizeObserver(() => this.invalidate());
    for (const one of [this.frame, this.parts.stage, this.parts.sheets, this.parts.insets]) resize.observe(one);
    const seen = new IntersectionObserver((entries) => {
      this.onScreen = entries[entries.length - 1].isIntersecting;
      this.wake();
    });
    this.onScreen = true;
    seen.observe(this.box);
    this.ends.push(() => resize.disconnect(), () => seen.disconnect());
    listen(document, "visibilitychange", () => this.wake());
    const dark = globalThis.matchMedia?.("(prefers-color-scheme: dark)");
    if (dark) listen(dark, "change", () => this.turnTheme(this.wish));
    listen(this.frame, "pointerdown", (event) => this.closeLists(event.composedPath()));
    this.ends.push(handleKeys(this), gestures(this.parts.canvas, {
      hover: (x, y) => { this.view.over = [x, y]; this.invalidate(); },
      leave: () => { this.view.over = null; this.invalidate(); },
      double: () => this.fit(),
      drag: (x, y, dx, dy) => { this.view.pan(dx, dy); this.invalidate(); },
      pinch: (x, y, factor, dx, dy) => { this.view.zoom(x, y, factor); this.view.pan(dx, dy); this.invalidate(); },
      wheel: (x, y, factor, event) => {
        if (!this.mayZoom(event)) return false;
        this.view.zoom(x, y, factor);
        this.invalidate();
        return true;
      },
    }));
  }

  // The wheel zooms in a page of its own; in a longer page it scrolls, unless Ctrl is held or the viewer has the focus.
  mayZoom(event) {
    return Boolean(this.host.page) || event.ctrlKey || event.metaKey || this.shadow.activeElement !== null;
  }

  wake() {
    const before = this.awake;
    this.awake = this.onScreen && document.visibilityState !== "hidden";
    if (this.awake && !before) {
      this.clock.last = null;
      this.invalidate();
    }
  }

  // ---------------------------------------------------------------- motion
  // run: packed or unpacked; ghost: another, or null; others: further runs whose curves are dashed.
  setRun(run, { ghost = this.ghostRun ?? this.scene.ideal ?? null, others = this.otherRuns ?? [] } = {}) {
    const first = !this.motion;
    [this.ghostRun, this.otherRuns] = [ghost, others];
    this.motion = new Motion(run, this.scene);
    if (!this.motion.n) throw new Error("this motion has no instant to show");
    this.clock.setMotion(this.motion);
    const known = [this.ghost, ...this.others].filter(Boolean), motionOf = (one) =>
      known.find((old) => old.run === one || old.from === one) ?? Object.assign(new Motion(one, this.scene), { from: one });
    this.ghost = ghost ? motionOf(ghost) : null;
    this.others = others.map(motionOf);
    this.tools.ghost.hidden = !this.ghost;
    this.regroup();
    this.tools.forces.hidden = !this.view.forces.length;
    this.parts.canvas.style.setProperty("--tall", Math.min(2, this.view.tall).toFixed(3));
    this.insets.setMotion(this.view.stage);
    this.player.setMotion(this.motion);
    this.chooser.setMotion(this.motion);
    const { word } = this, pins = this.orbits.setMotion(this.motion, this.scene), events = this.motion.events.length;
    this.tabs.show("orbits", pins > 0, pins > 1 ? `${word("Orbits")} (${pins})` : word("Orbit"));
    this.tabs.show("events", events > 0, `${word("Events")} (${events})`);
    this.eventSheet.replaceChildren(); // filled when someone looks
    this.sayTrust();
    this.listPoints();
    if (first) this.begin();
    this.emit("run", this.motion.run);
    this.invalidate();
  }

  sayTrust() {
    this.motion.trust = this.motion.run.trust ?? this.motion.trust;
    sayTrust(this.parts.trust, this.motion, this.scene.notes ?? [], this.word, this.scene.show?.trust);
    this.invalidate();
  }

  // What stands behind the motion: the ghost if it is switched on, and further runs.
  regroup() {
    const shown = [...(this.ghost ? [{ motion: this.ghost, name: "ideal" }] : []), ...this.others.map((motion) => ({ motion, name: motion.label }))];
    this.view.setMotion(this.motion, this.scene, shown);
    const compared = [...(this.ghost && this.show.ghost ? [{ motion: this.ghost, label: this.word(this.ghost.label || "without play") }] : []),
      ...this.others.map((motion) => ({ motion, label: this.word(motion.label) }))];
    this.curves.setMotion(this.motion, compared);
  }

  begin() {
    const wish = this.scene.show ?? {}, { motion } = this, pins = Object.keys(pinsWithPlay(motion, this.scene.kinds));
    this.clock.speed = wish.speed > 0 ? wish.speed : usualSpeed(motion.span);
    this.clock.time = motion.start;
    const named = (wish.curves ?? []).filter((name) => motion.has(name));
    this.choose(named.length ? named : [...this.measured.map((one) => one.curve), ...firstChoice(motion, pins)]);
    if (!wish.traces?.length) this.show.traces = this.freePoints().slice(0, 1);
    this.listPoints();
    if (!this.calm && this.host.autoplay !== false) this.play();
  }

  // Named points that no joint and no load uses: those that someone is interested in.
  freePoints() {
    const { geometry } = this.motion, taken = new Set();
    for (const family of ["joints", "loads"]) {
      for (const form of Object.values(geometry[family] ?? {})) form.bodies.forEach((body, k) => taken.add(`${body} ${form.points[k].join(" ")}`));
    }
    return Object.entries(geometry.bodies).flatMap(([body, form]) => Object.entries(form.points)
      .filter(([, at]) => !taken.has(`${body} ${at.join(" ")}`) && Math.hypot(...at) > 0).map(([point]) => `${body}.${point}`))
      .filter((name) => pathOf(this.motion, name));
  }

  listPoints() {
    const names = pathNames(this.motion), { list } = this.tools;
    list.replaceChildren(...names.map((name) => {
      const box = make("input", { type: "checkbox", onchange: () => this.trace(name, box.checked) });
      box.checked = this.show.traces.includes(name);
      return make("label", {}, box, make("span", {}, name), name.includes(".") ? null : make("span", { class: "quiet" }, this.word("mass centre")));
    }));
    this.countTraces();
  }

  countTraces() {
    const { length } = this.show.traces, paths = this.word("Paths");
    say(this.tools.traces, length ? `${paths} (${length})` : paths);
  }

  trace(name, on) {
    this.show.traces = on ? [...this.show.traces, name] : this.show.traces.filter((one) => one !== name);
    this.countTraces();
    this.invalidate();
  }

  openTraces(now) {
    this.tools.list.hidden = !now;
    this.tools.traces.setAttribute("aria-expanded", String(now));
    if (now) this.tools.list.querySelector("input")?.focus();
    else this.tools.traces.focus();
  }

  // A press elsewhere closes the lists of points and of curves.
  closeLists(path) {
    const { list, traces } = this.tools, { element, toggle } = this.chooser;
    if (!list.hidden && !path.includes(list) && !path.includes(traces)) this.openTraces(false);
    if (!element.hidden && !path.includes(element) && !path.includes(toggle)) this.chooser.open(false);
  }

  // Paths off, or on again: those shown before, or the point that says most.
  turnTraces() {
    const { traces } = this.show;
    if (traces.length) [this.kept, this.show.traces] = [traces, []];
    else this.show.traces = this.kept ?? [...this.freePoints(), ...pathNames(this.motion)].slice(0, 1);
    this.listPoints();
    this.invalidate();
  }

  choose(names) {
    this.curves.setNames(names.filter((name) => this.motion.has(name)));
    this.chooser.setChosen(this.curves.chosen);
    this.emit("choose", this.curves.chosen);
    this.invalidate();
  }

  // Other measured curves: [{curve, label, t, y}]; their curves are shown.
  setMeasured(list) {
    this.measured = list;
    if (this.motion) this.choose([...this.curves.chosen, ...list.map((one) => one.curve)]);
  }

  turn(what, on) {
    this.show[what] = on;
    this.tools[what].turn(on);
    if (what === "ghost") this.regroup();
    this.invalidate();
  }

  // A parameter was turned: whoever can compute motions replaces this.
  turnKnob(name) {
    return Promise.reject(new Error(`this page replays a motion that was computed before; ${name} cannot be changed here`));
  }

  fit() {
    this.view.fit();
    this.invalidate();
  }

  // ---------------------------------------------------------------- time
  play() {
    if (!this.motion) return;
    this.clock.play();
    this.invalidate();
  }

  pause() {
    this.clock.pause();
    this.invalidate();
  }

  seek(t) {
    if (!this.motion) return;
    this.clock.seek(t);
    this.told = null;
    this.invalidate();
    this.tell();
  }

  step(rows) {
    this.clock.step(rows);
    this.seek(this.clock.time);
  }

  setSpeed(speed) {
    this.clock.speed = speed;
    this.invalidate();
  }

  faster(way) {
    this.clock.faster(way);
    this.invalidate();
  }

  setLoop(on) {
    this.clock.loop = on;
    this.invalidate();
  }

  // ---------------------------------------------------------------- looks
  turnTheme(wish = this.theme.dark ? "light" : "dark") {
    this.wish = wish;
    const dark = wish === "auto" ? Boolean(globalThis.matchMedia?.("(prefers-color-scheme: dark)").matches) : wish === "dark";
    this.theme = themeOf(dark, this.scene.colours ?? {});
    this.box.dataset.theme = this.frame.dataset.theme = dark ? "dark" : "light";
    if (this.host.page) {
      document.documentElement.style.background = this.theme.paper;
      document.documentElement.style.colorScheme = dark ? "dark" : "light";
    }
    this.emit("theme", dark);
    this.invalidate();
  }

  help(now) {
    const { help } = this.parts;
    if (now === !help.hidden) return;
    if (now) this.before = this.shadow.activeElement;
    help.hidden = !now;
    if (now) help.focus();
    else (this.before ?? this.frame).focus();
  }

  // ---------------------------------------------------------------- frames
  invalidate() {
    if (this.frameId || !this.awake || this.gone || !this.motion) return;
    this.frameId = requestAnimationFrame((now) => this.next(now));
  }

  next(now) {
    this.frameId = 0;
    if (this.gone || !this.motion) return;
    this.clock.advance(now);
    this.draw();
    this.tell();
    if (this.clock.playing) this.invalidate();
    else this.clock.last = null;
  }

  draw() {
    const { clock: { time }, theme, parts } = this;
    this.view.width = parts.canvas.clientWidth;
    this.view.height = parts.canvas.clientHeight;
    if (this.view.width > 20 && this.view.height > 20) this.view.draw(time, theme, this.show);
    this.insets.draw(time, theme);
    this.player.draw(time, theme);
    if (this.tabs.current === "curves") this.curves.draw(time, theme);
    if (this.tabs.current === "orbits") this.orbits.draw(time, theme);
    if (this.tabs.current === "events" && !this.eventSheet.childNodes.length) this.eventSheet.append(...eventTable(this.motion, this.word, (t) => this.seek(t)));
    parts.late.hidden = !(this.motion.horizon !== null && time > this.motion.horizon);
  }

  tell() {
    if (this.told === this.clock.time) return;
    this.told = this.clock.time;
    this.emit("time", this.told);
  }

  // ---------------------------------------------------------------- listeners, end
  on(event, call) {
    if (!this.listeners.has(event)) this.listeners.set(event, new Set());
    this.listeners.get(event).add(call);
    return () => this.listeners.get(event).delete(call);
  }

  emit(event, value) {
    for (const call of this.listeners.get(event) ?? []) call(value);
  }

  destroy() {
    this.gone = true;
    cancelAnimationFrame(this.frameId);
    for (const end of this.ends) end();
    this.curves.destroy();
    this.listeners.clear();
    this.box.remove();
  }
}
