// The list of all curves, grouped by body, joint and load, with a search and their units.

import { make } from "./dom.js";
import { printed } from "./units.js";

// Groups [{title, names}] of names of curves: by what stands before the first dot; what belongs to nothing comes last.
export function grouped(motion, word) {
  const { geometry } = motion, groups = new Map();
  const kindOf = (name) => name in geometry.bodies ? word("{name} (body)", { name }) : name in geometry.joints ? word("{name} (joint)", { name })
    : name in geometry.loads ? word("{name} (load)", { name }) : name === "energy" ? word("energy") : name;
  for (const name of motion.names) {
    const dot = name.indexOf("."), title = dot > 0 ? kindOf(name.slice(0, dot)) : word("signals and states");
    groups.set(title, [...(groups.get(title) ?? []), name]);
  }
  return [...groups].map(([title, names]) => ({ title, names }));
}

export class Chooser {
  // host: {choose(names), word}
  constructor(host) {
    const { word } = host;
    this.host = host;
    this.chosen = [];
    this.search = make("input", { type: "search", placeholder: word("Search: angle, O3, force …"), "aria-label": word("Search curves"),
      oninput: () => this.filter() });
    this.list = make("div", { class: "names", role: "group", "aria-label": word("Curves") });
    this.none = make("p", { class: "quiet", hidden: true }, word("No curve has all of these words."));
    this.element = make("div", { class: "chooser", role: "dialog", "aria-label": word("Choose curves"), hidden: true,
      onkeydown: (event) => { if (event.key === "Escape") { event.stopPropagation(); this.open(false); } } },
    this.search, this.none, this.list);
    this.toggle = make("button", { type: "button", class: "chip strong", "aria-expanded": "false", onclick: () => this.open(this.element.hidden) },
      word("Choose curves"));
  }

  open(now) {
    this.element.hidden = !now;
    this.toggle.setAttribute("aria-expanded", String(now));
    if (now) this.search.focus();
    else this.toggle.focus();
  }

  setMotion(motion) {
    if (this.names === motion.names.join("\n")) return;
    this.names = motion.names.join("\n");
    this.rows = [];
    this.groups = grouped(motion, this.host.word).map(({ title, names }) => {
      const rows = names.map((name) => this.row(name, printed(motion.unit(name))));
      this.rows.push(...rows);
      const element = make("details", {}, make("summary", {}, title, make("span", { class: "quiet" }, ` ${names.length}`)),
        ...rows.map((one) => one.element));
      return { element, rows };
    });
    this.list.replaceChildren(...this.groups.map((one) => one.element));
    this.filter();
  }

  row(name, unit) {
    const box = make("input", { type: "checkbox", onchange: () => this.changed(name, box.checked) });
    return { name, box, words: name.toLowerCase(), element: make("label", {}, box, make("span", {}, name), make("span", { class: "quiet" }, unit)) };
  }

  changed(name, on) {
    this.host.choose(on ? [...this.chosen, name] : this.chosen.filter((one) => one !== name));
  }

  setChosen(names) {
    this.chosen = names;
    for (const row of this.rows ?? []) row.box.checked = names.includes(row.name);
    for (const { element, rows } of this.groups ?? []) if (rows.some((one) => one.box.checked)) element.open = true;
  }

  // Show the curves whose names have all words of the search.
  filter() {
    const words = this.search.value.toLowerCase().split(/\s+/).filter(Boolean);
    let any = false;
    for (const { element, rows } of this.groups ?? []) {
      let shown = 0;
      for (const row of rows) {
        row.element.hidden = !words.every((word) => row.words.includes(word));
        shown += row.element.hidden ? 0 : 1;
      }
      element.hidden = !shown;
      if (words.length) element.open = shown > 0;
      any ||= shown > 0;
    }
    this.none.hidden = any;
  }
}
