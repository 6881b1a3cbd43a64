// The Motion tab: the viewer, with the motion that the studio has computed, the old one until the new one is there.

import { h, replace } from "./dom.js";

export class Show {
  constructor(model, tell) {
    this.tell = tell;
    this.place = h("div", { class: "viewer" });
    this.badge = h("div", { class: "badge", role: "status", hidden: true });
    this.back = h("div", { class: "sample", hidden: true });
    this.el = h("div", { class: "motion-of" }, this.back, this.badge, this.place);
    const address = URL.createObjectURL(new Blob([model.viewer], { type: "text/javascript" }));
    this.ready = import(address).finally(() => URL.revokeObjectURL(address));
    this.names = [];
    this.app = null;
    this.waiting = [];
  }

  // A motion has come: the viewer is made anew where the mechanism is another one.
  async take(value) {
    const { mount } = await this.ready;
    this.quiet();
    this.latest = value;
    this.back.hidden = true;
    this.put(mount, value.scene);
    for (const done of this.waiting.splice(0)) done();
  }

  put(mount, scene) {
    const shape = JSON.stringify([scene.title, Object.keys(scene.geometry.bodies), Object.keys(scene.geometry.joints), scene.runs[0]?.names]);
    if (this.app && shape === this.shape) this.app.setRun(scene.runs[0]);
    else {
      this.app?.destroy();
      this.place.replaceChildren();
      this.app = mount(this.place, scene, { inside: true, theme: this.theme });
      window.rattle = this.app;
      this.names = this.app.names;
    }
    this.shape = shape;
  }

  quiet() { this.badge.hidden = true; }

  busy(message) {
    const words = { waiting: "old: the new motion is waiting", running: "old: computing the new motion …", stopped: "old: the new motion was stopped" }[message.state];
    if (!words) return;
    this.badge.hidden = false;
    this.badge.textContent = this.app ? words : words.replace("old: the new motion", "the motion").replace("old: computing the new motion", "computing the motion");
    if (message.share !== undefined) this.badge.textContent += ` ${Math.round(100 * message.share)} %`;
  }

  failed(words) {
    this.badge.hidden = false;
    this.badge.textContent = `${this.app ? "old; " : ""}no motion: ${words}`;
    for (const done of this.waiting.splice(0)) done();
  }

  // A slider was moved: a page that computes by itself follows at once.
  turned(name, value) { this.live?.(name, value); }

  async sample(message) {
    const { mount } = await this.ready;
    this.put(mount, message.scene);
    this.back.hidden = false;
    replace(this.back, h("span", {}, message.words), h("button", { onclick: () => { this.back.hidden = true; this.put(mount, this.latest.scene); } }, "Back to the model"));
  }

  clear() {
    this.app?.destroy();
    this.app = null;
    this.place.replaceChildren();
    this.names = [];
    this.back.hidden = true;
  }

  toggle() {
    if (this.app) (this.app.playing ? this.app.pause() : this.app.play());
  }

  visible() {}

  dark(dark) {
    this.theme = dark ? "dark" : "light";
    this.app?.viewer.turnTheme(this.theme);
  }
}
