// The Motion tab: the viewer.  Where the page can compute the motion by itself it follows a knob at once; otherwise the
// motion comes from the studio, and the old one stays until the new one is there, marked as old.

import { h, replace } from "./dom.js";
import { Measured } from "./measured.js";
import { mount } from "./viewer.js";

export class Show {
  // told: called with a run that the page has computed; send: a message to the studio.
  constructor(told, send) {
    this.told = told;
    this.place = h("div", { class: "viewer" });
    this.badge = h("div", { class: "badge", role: "status", hidden: true });
    this.back = h("div", { class: "sample", hidden: true });
    this.el = h("div", { class: "motion-of" }, this.back, this.badge, this.place);
    this.edit = null; // drawing, see edit.js
    this.measured = new Measured(this.el, { send, app: () => this.app });
    this.app = null;
    this.live = null; // the scene that the page computes by itself, with its base
    this.values = {};
    this.lost = false; // the page could not compute the motion that is asked for
    this.otherwise = false; // more was changed than a knob
  }

  get names() { return this.app?.names ?? []; }

  // A motion has come from the studio.
  take(value) {
    this.latest = value;
    this.otherwise = false;
    this.badge.hidden = true;
    this.edit?.fail("");
    const run = value.scene.runs[0];
    if (this.live && this.live.base === value.base && this.follows(run.parameters)) {
      if (this.lost) this.app.setRun(run); // what the page could not compute the studio could
      this.lost = false;
      return;
    }
    this.live = null;
    this.back.hidden = true;
    this.put(value.scene);
  }

  // The scene of a model that the page can compute, or none.
  compute(message) {
    if (message.scene && this.latest?.base === message.base) {
      this.live = message;
      this.put(message.scene, true);
      this.app.on("run", (run) => { if (this.live) this.told(run); });
      this.turn(this.values);
    }
  }

  // True if all parameters that differ from what is shown can be turned in the page.
  follows(parameters) {
    const names = new Set(this.live.scene.knobs.map((knob) => knob.name)), shown = this.app.parameters;
    return Object.entries(parameters).every(([name, value]) => names.has(name) || !(name in shown) || same(value, shown[name]));
  }

  put(scene, live = false) {
    const shape = JSON.stringify([live, scene.title, Object.keys(scene.geometry.bodies), Object.keys(scene.geometry.joints), scene.runs[0]?.names]);
    if (this.app && shape === this.shape && !live) this.app.setRun(scene.runs[0]);
    else {
      const before = this.app && { time: this.app.time, playing: this.app.playing, chosen: this.app.viewer.curves.chosen };
      this.app?.destroy();
      this.place.replaceChildren();
      this.app = mount(this.place, scene, { inside: true, theme: this.theme, autoplay: !this.drawing, measured: this.measured });
      if (this.measured.shown.length) this.measured.apply();
      this.app.on("time", () => this.told_time());
      this.offer();
      if (before && this.title === scene.title) this.goOn(before);
    }
    this.title = scene.title;
    this.shape = shape;
    if (this.edit?.starts()) this.play();
  }

  // What scripts find as window.rattle: the viewer, and drawing.
  offer() {
    window.rattle = this.app ?? { names: [], events: [], time: 0, live: false };
    if (this.edit) window.rattle.edit = this.edit.api;
    this.app?.viewer.frame.classList.toggle("bare", this.drawing);
  }

  // ---------------------------------------------------------------- while one draws
  get drawing() { return this.edit?.on ?? false; }
  get seen() { return this.el.closest("[hidden]") === null; }
  get playing() { return this.app?.playing ?? false; }

  // Drawing begins or ends: the time line alone stays below the sheet.
  draws(on) {
    this.el.classList.toggle("draws", on);
    if (!this.app) this.badge.hidden = on;
    this.offer();
  }

  play() { this.app?.play(); }
  pause() { this.app?.pause(); }

  // The motion stands at its start.
  rest() {
    this.pause();
    this.app?.seek(this.app.viewer.motion?.start ?? 0);
  }

  told_time() {
    if (this.drawing && this.app) this.edit.frame(this.app.viewer.motion, this.app.viewer.scene, this.app.time, this.app.playing);
  }

  goOn({ time, playing, chosen }) {
    const kept = chosen.filter((name) => this.app.names.includes(name));
    if (kept.length) this.app.choose(kept);
    this.app.seek(Math.min(time, this.app.run.t.at(-1)));
    if (playing) this.app.play();
    else this.app.pause();
  }

  busy(message) {
    if (this.live && !this.lost && !this.otherwise && message.state !== "stopped") return;
    const words = { waiting: "old: the new motion is waiting", running: "old: computing the new motion", stopped: "old: the new motion was stopped" }[message.state];
    if (!words) return;
    this.badge.hidden = false;
    this.badge.textContent = this.app ? words : words.replace("old: the new", "the").replace("old: computing the new", "computing the");
    if (message.share !== undefined) this.badge.textContent += ` … ${Math.round(100 * message.share)} %`;
  }

  failed(words) {
    this.edit?.fail(words);
    this.badge.hidden = false;
    this.badge.textContent = `${this.app ? "old; " : ""}no motion: ${words}`;
  }

  // Parameters have these values now [SI]: a page that computes by itself follows at once.
  turn(values) {
    this.values = values;
    if (!this.live || !this.back.hidden) return;
    const shown = this.app.parameters;
    for (const { name } of this.live.scene.knobs) {
      if (name in values && !same(values[name], shown[name])) this.app.set(name, values[name]).then(() => { this.lost = false; }, () => this.refuse());
    }
  }

  // The page could not compute this motion: what is shown is old until the studio has it, or says why there is none.
  refuse() {
    this.lost = true;
    this.badge.hidden = false;
    this.badge.textContent = "old: computing the new motion";
  }

  sample(message) {
    this.put(message.scene);
    this.back.hidden = false;
    const back = () => {
      this.back.hidden = true;
      if (this.live) this.compute(this.live);
      else this.put(this.latest.scene);
    };
    replace(this.back, h("span", { title: message.more }, message.words), h("button", { onclick: back }, "Back to the model"));
  }

  clear() {
    this.app?.destroy();
    this.edit?.board.run(null);
    this.app = this.live = this.latest = null;
    this.place.replaceChildren();
    this.back.hidden = true;
    this.measured.clear();
    this.offer();
  }

  // Nothing to show: the model has no bodies yet.
  blank() {
    this.badge.hidden = this.drawing;
    this.badge.textContent = "An empty sheet: press Edit to draw on it.";
  }

  toggle() {
    if (this.app) (this.app.playing ? this.app.pause() : this.app.play());
  }

  dark(dark) {
    this.theme = dark ? "dark" : "light";
    this.app?.viewer.turnTheme(this.theme);
    this.edit?.board.turnTheme(dark);
  }
}

function same(a, b) {
  return a === b || Math.abs(a - b) <= 1e-12 * Math.max(Math.abs(a), Math.abs(b));
}
