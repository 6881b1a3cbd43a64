// The line at the bottom that is always there: how far the result can be trusted, and what is being computed.

import { h, replace } from "./dom.js";
import { TABS } from "./tabs.js";

const OTHERS = [["trust", "Trust"], ["sample", "Mechanism of the ensemble"]];
const titleOf = (name) => new Map([...TABS, ...OTHERS]).get(name);
const UNCHECKED = /how long the curves can be trusted was not computed( \([^)]*\))?/g; // of a run of rattle
const PREPARING = 4; // a job that has not said for so long how far it is compiles [s]

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

  // state: "good", "check", "care", "bad", "old", "wait" or "empty".
  say(state, lines) {
    const names = { good: "Trusted", check: "Being checked", care: "With care", bad: "Not trusted", old: "Old", wait: "Wait", empty: "Empty" };
    this.el.dataset.state = state;
    replace(this.text, h("b", {}, names[state]), h("span", {}, answerFirst(lines).join(" · ").replaceAll(UNCHECKED, state === "check" ? "how long the curves can be trusted is computed now" : "how long the curves can be trusted was not computed")));
    this.last = [state, lines];
  }

  // The second run, from which one knows how long the curves can be trusted, was stopped or has failed.
  unchecked() {
    if (this.last[0] === "check") this.say("care", this.last[1]);
  }

  // There is something to compute now.
  begins() {
    if (this.last[0] === "empty") this.say("wait", ["nothing is computed yet"]);
  }

  old() {
    if (!["wait", "empty"].includes(this.last[0])) this.say("old", ["this is of the model before the change", ...this.last[1].filter((one) => !one.startsWith("this is of"))]);
  }

  // What is computed at the moment, for how long, and how far it is; message: of a job.
  working(job, message) {
    const busy = message.state === "waiting" || message.state === "running";
    if (!busy && job !== this.job) return;
    if (busy && (job !== this.job || this.work.hidden)) this.since = performance.now();
    this.job = job;
    this.message = message;
    this.work.hidden = !busy;
    if (message.share === undefined) this.bar.removeAttribute("value");
    else this.bar.value = message.share;
    clearInterval(this.clock);
    if (busy) this.clock = setInterval(() => this.tick(), 1000);
    this.tick();
  }

  tick() {
    const { what, share } = this.message, seconds = Math.floor((performance.now() - this.since) / 1000);
    const name = titleOf(this.job) ?? this.job;
    const first = seconds >= PREPARING && share === undefined ? ", a mechanism of a new kind is prepared first" : "";
    this.words.textContent = `${name}${what && what !== this.job ? `, ${what}` : ""} …${seconds >= 2 ? ` ${seconds} s` : ""}${first}`;
  }
}

// What a run says of itself, with how well its equations were solved at the end.
function answerFirst(lines) {
  const parts = lines.flatMap((line) => line.split(/; (?=the curves|positions and rates|how long)/));
  const solved = (part) => part.startsWith("constraint error");
  return [...parts.filter((part) => !solved(part)), ...parts.filter(solved)];
}

// The sign of what a run says of itself.
export function stateOf(value) {
  if (!value.success) return "bad";
  if (value.limited) return "care";
  const text = value.trust.join(" ");
  if (/would have to pull|does not hold|statistics only|too few|up to t =/.test(text) && !/over the whole run/.test(text)) return "care";
  if (/would have to pull|does not hold|too few/.test(text)) return "care";
  return text.search(UNCHECKED) >= 0 ? "check" : "good";
}
