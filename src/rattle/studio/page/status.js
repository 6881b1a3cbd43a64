// The line at the bottom that is always there: how far the result can be trusted, and what is being computed.

import { h, replace } from "./dom.js";

export class Status {
  constructor(tell) {
    this.sign = h("i", { class: "sign", "aria-hidden": "true" });
    this.text = h("div", { class: "trust-text" });
    this.trust = h("button", { class: "trust", "aria-expanded": "false", title: "How far the result can be trusted; click for all of it", onclick: () => this.turn() }, this.sign, this.text);
    this.words = h("span", { role: "status" });
    this.bar = h("progress", { max: 1 });
    this.stop = h("button", { class: "quiet", onclick: () => tell({ do: "stop", tab: this.job }) }, "Stop");
    this.work = h("div", { class: "work", hidden: true }, this.words, this.bar, this.stop);
    this.el = h("footer", { class: "status", "aria-label": "Trust" }, this.trust, this.work);
    this.say("wait", ["nothing is computed yet"]);
  }

  turn() {
    const open = this.el.classList.toggle("open");
    this.trust.setAttribute("aria-expanded", String(open));
  }

  // state: "good", "care", "bad", "old" or "wait".
  say(state, lines) {
    const names = { good: "Trusted", care: "With care", bad: "Not trusted", old: "Old", wait: "Wait" };
    this.el.dataset.state = state;
    replace(this.text, h("b", {}, names[state]), h("span", {}, lines.join(" · ")));
    this.last = [state, lines];
  }

  old() {
    if (this.last[0] !== "wait") this.say("old", ["this is of the model before the change", ...this.last[1].filter((one) => !one.startsWith("this is of"))]);
  }

  // What is computed at the moment: a message of a job, or null.
  working(job, message) {
    const busy = message.state === "waiting" || message.state === "running";
    if (!busy && job !== this.job) return;
    this.job = job;
    this.work.hidden = !busy;
    this.words.textContent = message.what ? `${job}: ${message.what}` : `${job} …`;
    if (message.share === undefined) this.bar.removeAttribute("value");
    else this.bar.value = message.share;
  }
}

// The sign of what a run says of itself.
export function stateOf(value) {
  if (!value.success) return "bad";
  const text = value.trust.join(" ");
  if (/would have to pull|does not hold|statistics only|too few|up to t =/.test(text) && !/over the whole run/.test(text)) return "care";
  return /would have to pull|does not hold|too few/.test(text) ? "care" : "good";
}
