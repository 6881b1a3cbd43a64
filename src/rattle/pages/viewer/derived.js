// Curves that follow from stored ones: nodes of a tape over whole columns, which rattle/pages/derived_curves.py writes.

import { OPERATIONS } from "./values.js";

const at = (values, k) => (typeof values === "number" ? values : values?.[k]);

// Rules {name: {unit, make(curve, n) -> array}} of the curves that stored columns (a Set of names) allow.
export function derivedRules({ numbers = [], curves = {} } = {}, geometry, stored) {
  const own = (place) => place.reduce((entry, key) => entry?.[key], geometry), there = [];
  for (const node of numbers) {
    const [name, ...rest] = Array.isArray(node) ? node : [null];
    there.push(name === "curve" ? stored.has(rest[0]) : name === "of" ? own(rest) !== undefined : rest.every((place) => there[place]));
  }
  const column = (place, curve, n, known) => known[place] ??= (() => {
    const node = numbers[place], [name, ...rest] = Array.isArray(node) ? node : [null];
    if (name === null || name === "of") return name ? own(rest) : node;
    if (name === "curve") return curve(rest[0]);
    const [a, b] = rest.map((entry) => column(entry, curve, n, known)), operation = OPERATIONS[name];
    return Float64Array.from({ length: n }, (_, k) => operation(at(a, k), at(b, k)));
  })();
  return new Map(Object.entries(curves).filter(([name, [, place]]) => there[place] && !stored.has(name))
    .map(([name, [unit, place]]) => [name, { unit, make: (curve, n) => column(place, curve, n, []) }]));
}
