// Curves over time: one panel for each unit, all with the same window of time.

import { Scope } from "./chart.js";
import { measuredLines } from "./measured.js";
import { Panel } from "./panel.js";
import { handyUnit } from "./units.js";

export class Curves {
  // host: {seek(t), choose(names), invalidate(), mayZoom(event), word}
  constructor(element, host) {
    this.element = element;
    this.host = host;
    this.panels = [];
    this.chosen = [];
    this.scope = new Scope(() => host.invalidate()); // the window of time
  }

  // others: [{motion, label}], their curves of the same names are dashed.
  setMotion(motion, others) {
    this.motion = motion;
    this.others = others;
    this.scope.cover(motion.start, motion.end);
    this.setNames(this.chosen.filter((name) => motion.has(name)));
  }

  setNames(names) {
    this.chosen = [...new Set(names)];
    const units = new Map();
    for (const name of this.chosen) {
      const unit = this.panelOf(name);
      units.set(unit, [...(units.get(unit) ?? []), name]);
    }
    const shown = [...units].flatMap(([unit, own]) => this.panelsOf(unit, own));
    for (const panel of this.panels.filter((one) => !shown.some(({ key }) => key === one.key))) panel.end();
    this.panels = shown.map(({ key, names: own, lines }) => {
      const panel = this.panels.find((one) => one.key === key) ?? new Panel(key, this);
      panel.setNames(own, lines);
      return panel;
    });
    this.element.replaceChildren(...this.panels.map((one) => one.element));
    this.element.classList.toggle("empty", !this.panels.length);
  }

  // What is in the panel of a unit, and below it in that of what measured curves differ by: [{key, names, lines}].
  panelsOf(unit, names) {
    const measured = measuredLines(this.host.measured, this.motion, names);
    const lines = names.flatMap((name, k) => [
      { name, motion: this.motion, colour: k },
      ...this.others.filter((one) => one.motion.has(name)).map((one, n) =>
        ({ name, motion: one.motion, colour: k, label: one.label, dash: n ? [2, 3] : [6, 4] })),
      ...measured.filter(({ values }) => values.name === name).map(({ values }) => values),
    ]);
    const key = `${unit} difference`, off = measured.map((one) => one.off);
    return [{ key: unit, names, lines }, ...(off.length ? [{ key, names: names.filter((name) => off.some((one) => one.name === name)), lines: off }] : [])];
  }

  // Curves are in one panel if they have one unit, and lengths in µm, mm and m apart.
  panelOf(name) {
    const unit = this.motion.unit(name);
    return unit === "m" ? `${unit} ${handyUnit(unit, this.motion.largest(name), this.host.scene.units).unit}` : unit;
  }

  draw(time, theme) {
    for (const panel of this.panels) panel.drawAt(time, theme);
  }

  destroy() {
    for (const panel of this.panels) panel.end();
  }
}

// Curves that say most about a mechanism, where nobody chose any.
export function firstChoice(motion, pins) {
  const { geometry, names } = motion, found = [];
  const add = (list, most) => found.push(...list.filter((name) => motion.has(name) && !found.includes(name) && motion.largest(name) > 0).slice(0, most));
  const oiled = pins.filter((name) => motion.has(`${name}.film_pressure`));
  add(oiled.map((name) => `${name}.eccentricity`), 2);
  if (oiled.length === pins.length) add(oiled.map((name) => `${name}.film_pressure`), 2);
  add(pins.map((name) => `${name}.normal`), 3);
  if (!found.length) add(names.filter((name) => name.endsWith(".torque") && !(name.slice(0, -7) in geometry.loads)), 1);
  if (!found.length) add(Object.keys(geometry.joints).map((name) => `${name}.normal`), 2);
  if (!found.length) add(Object.keys(geometry.joints).map((name) => `${name}.force`), 2);
  const bodies = Object.keys(geometry.bodies);
  const moving = (name) => motion.has(name) && spread(motion.curve(name)) > 1e-6;
  const turning = bodies.filter((body) => moving(`${body}.angle`)).map((body) => `${body}.angle`);
  add(turning.slice(-1), 1);
  const sliding = bodies.filter((body) => !turning.includes(`${body}.angle`)).flatMap((body) => [`${body}.x`, `${body}.y`]).filter(moving);
  add(sliding, 1);
  return found;
}

function spread(values) {
  let low = Infinity, high = -Infinity;
  for (const value of values) {
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return high - low;
}
