// Pins in their bushes and blocks in their guides, magnified: how they lie in their play at one time.

import { make, say } from "./dom.js";
import { Painter, sized } from "./painter.js";
import { player } from "./play.js";
import { handyUnit, short, steady } from "./units.js";

// The insets of one motion, beside the mechanism: primitives of which 1 is the width of the picture.
export class Insets {
  constructor(host, word) {
    this.host = host;
    this.word = word;
    this.tiles = [];
  }

  setMotion(stage) {
    const { motion } = stage;
    this.stage = stage;
    const every = (stage.drawing.magnified ?? []).filter(({ joint }) => motion.geometry.joints[joint].clearance > 0 && motion.has(`${joint}.ex`));
    if (every.map((picture) => picture.joint).join("\n") !== this.tiles.map((tile) => tile.name).join("\n")) this.build(every);
    this.tiles.forEach((tile, k) => {
      const form = motion.geometry.joints[tile.name], { unit, factor } = handyUnit("m", form.clearance);
      tile.draw = every[k].drawn.map((primitive) => player(stage, primitive));
      tile.link = form.contact === "massless-link";
      tile.curve = `${tile.name}.${motion.has(`${tile.name}.film_pressure`) ? "force" : "normal"}`;
      const most = motion.has(tile.curve) ? motion.largest(tile.curve) : 0, { factor: of, unit: newtons } = handyUnit("N", most);
      tile.say = { factor: of, unit: newtons, text: steady(of * most, 3), name: tile.curve.endsWith("normal") ? "N" : this.word("force") };
      say(tile.size, this.word("play {size}", { size: `${short(factor * form.clearance)} ${unit}` }));
    });
    this.host.hidden = !every.length;
  }

  build(every) {
    this.tiles = every.map(({ joint: name }) => {
      const canvas = make("canvas", { role: "img", "aria-label": this.word("{name}, magnified", { name }) });
      const size = make("span", { class: "quiet" }), force = make("span", { class: "number" });
      const element = make("figure", { class: "inset" }, make("figcaption", {}, make("b", {}, name), size), canvas, force);
      return { name, canvas, size, force, element };
    });
    this.host.replaceChildren(...this.tiles.map((tile) => tile.element));
  }

  draw(time, theme) {
    const { motion, values } = this.stage ?? {};
    for (const tile of this.tiles) {
      const side = tile.canvas.clientWidth;
      if (!side) continue;
      const p = new Painter(sized(tile.canvas, side, side), { scale: side, x: side / 2, y: side / 2 }, theme);
      values.set(motion.pose(time), time, p.metres(1), 1);
      for (const draw of tile.draw) draw(p);
      const normal = motion.has(tile.curve) ? motion.value(tile.curve, time) : 0, pulls = tile.link && normal < 0;
      say(tile.force, `${tile.say.name} =${tile.say.text(tile.say.factor * normal)} ${tile.say.unit}${pulls ? ` ${this.word("would pull")}` : ""}`);
      tile.force.classList.toggle("bad", pulls);
    }
  }
}
