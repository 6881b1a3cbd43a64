// Contacts, impacts and other events of a motion as a table; a row leads to its time.

import { make } from "./dom.js";
import { handyUnit, printed, short, timeText } from "./units.js";

const MOST_EVENTS = 400; // rows

export function eventTable(motion, word, seek) {
  const text = timeText(motion.span), shown = motion.events.slice(0, MOST_EVENTS);
  const energy = handyUnit("J", Math.max(0, ...shown.map((one) => Math.abs(one.lost ?? 0))));
  const columns = [["t", "s"], [word("joint"), ""], [word("what"), ""], [word("speed"), "m/s"], [word("peak"), "N"], [word("impulse"), "N*s"], [word("lost"), energy.unit]];
  const head = columns.map(([name, unit]) => make("th", { scope: "col" }, unit ? `${name} [${printed(unit)}]` : name));
  const unread = () => make("td", {}, word("not to be read")); // the force of a rigid contact that towers
  const number = (value, factor = 1) => make("td", { class: "number" }, value ? short(factor * value) : "");
  const rows = shown.map((one) => make("tr", { onclick: () => seek(one.t) },
    make("td", { class: "number" }, make("button", { type: "button", title: word("Go to this time") }, text(one.t))), make("td", {}, one.contact ? `${one.joint} ${one.contact}` : one.joint),
    make("td", {}, word(one.kind)), number(one.speed), one.force === null ? unread() : number(one.force), number(one.impulse), number(one.lost, energy.factor)));
  const more = motion.events.length - shown.length;
  return [
    make("table", { class: "events" }, make("thead", {}, make("tr", {}, ...head)), make("tbody", {}, ...rows)),
    ...(more > 0 ? [make("p", { class: "quiet" }, word("and {count} more; the result holds all of them", { count: more }))] : []),
  ];
}
