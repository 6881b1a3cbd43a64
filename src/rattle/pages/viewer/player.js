// Buttons and the time line below the mechanism.

import { button, icon, make, say } from "./dom.js";
import { sized } from "./painter.js";
import { short, timeText } from "./units.js";

export class Player {
  // host: the viewer {clock, play(), pause(), seek(t), setSpeed(v), faster(way), setLoop(on), invalidate(), word}
  constructor(host) {
    const { word } = host, relative = word("Speed of the animation relative to the motion");
    this.host = host;
    this.go = button("play", word("Play (space)"), () => (host.clock.playing ? host.pause() : host.play()), { class: "go" });
    this.first = button("first", word("To the start (Home)"), () => host.seek(host.clock.motion.start));
    this.line = make("input", { type: "range", min: 0, max: 1, step: "any", value: 0, "aria-label": word("Time"),
      oninput: () => host.seek(Number(this.line.value)) });
    this.marks = make("canvas", { class: "marks", "aria-hidden": "true" });
    this.time = make("span", { class: "number time" });
    this.slower = button("−", word("Slower (−)"), () => host.faster(-1));
    this.speed = make("select", { "aria-label": relative, title: relative,
      onchange: () => host.setSpeed(Number(this.speed.value)) });
    this.quicker = button("+", word("Faster (+)"), () => host.faster(1));
    this.loop = button("loop", word("Loop (L)"), () => host.setLoop(!host.clock.loop), { "aria-pressed": "true", class: "loop" });
    this.element = make("div", { class: "player", role: "group", "aria-label": word("Player") }, this.first, this.go,
      make("div", { class: "track" }, this.marks, this.line), this.time,
      make("span", { class: "speed" }, this.slower, this.speed, this.quicker), this.loop);
  }

  setMotion(motion) {
    this.motion = motion;
    this.line.min = motion.start;
    this.line.max = motion.end;
    this.text = timeText(motion.span);
    this.width = this.text(motion.end).length;
    this.drawn = null;
    this.speed.replaceChildren(...this.host.clock.speeds.map((one) => make("option", { value: one }, `${one}×`)));
  }

  draw(time, theme) {
    const { clock } = this.host;
    if (this.shown !== clock.playing) {
      this.shown = clock.playing;
      const { word } = this.host, now = clock.playing ? word("Pause (space)") : word("Play (space)");
      this.go.replaceChildren(icon(clock.playing ? "pause" : "play"));
      this.go.setAttribute("aria-label", now);
      this.go.title = now;
    }
    if (Number(this.line.value) !== time) this.line.value = time;
    const share = this.motion.span ? (time - this.motion.start) / this.motion.span : 0;
    this.line.style.setProperty("--share", share.toFixed(5));
    const text = `${this.text(time).padStart(this.width, "\u2007")} s`;
    say(this.time, text);
    this.line.setAttribute("aria-valuetext", text.trim());
    if (Number(this.speed.value) !== clock.speed) this.chooseSpeed(clock.speed);
    this.loop.setAttribute("aria-pressed", String(clock.loop));
    this.events(theme);
  }

  // A speed that is none of the list is entered into it.
  chooseSpeed(speed) {
    this.speed.value = speed;
    if (Number(this.speed.value) === speed) return;
    this.speed.append(make("option", { value: speed }, `${short(speed)}×`));
    this.speed.value = speed;
  }

  // Impacts and other events as ticks above the time line, and what lies after the horizon as a shade.
  events(theme) {
    const width = this.marks.clientWidth, height = this.marks.clientHeight, mark = `${width} ${theme.dark} ${this.motion.horizon}`;
    if (this.drawn === mark || !width) return;
    this.drawn = mark;
    const c = sized(this.marks, width, height), { start, span, horizon, events } = this.motion;
    const X = (t) => 8 + ((t - start) / (span || 1)) * (width - 16);
    if (horizon !== null) {
      c.fillStyle = theme.shade;
      c.fillRect(X(horizon), 0, X(this.motion.end) - X(horizon), height);
    }
    const taken = new Set();
    for (const event of events) {
      const x = Math.round(X(event.t)), impact = event.kind === "impact";
      if (taken.has(`${x} ${impact}`)) continue;
      taken.add(`${x} ${impact}`);
      c.fillStyle = impact ? theme.red : theme.grey;
      c.globalAlpha = impact ? 0.9 : 0.55;
      c.fillRect(x - 0.5, impact ? 0 : 3, 1.2, impact ? 7 : 4);
    }
  }
}
