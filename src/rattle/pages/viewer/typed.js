// Quantities as people type them ("5 mm", "120 rpm", "0.2") and as they read them.

const RADIANS = Math.PI / 180;
// factor to SI, and powers of m, kg, s, A
const KNOWN = {
  m: [1, 1, 0, 0, 0], g: [1e-3, 0, 1, 0, 0], s: [1, 0, 0, 1, 0], min: [60, 0, 0, 1, 0], h: [3600, 0, 0, 1, 0], A: [1, 0, 0, 0, 1],
  rad: [1, 0, 0, 0, 0], deg: [RADIANS, 0, 0, 0, 0], "°": [RADIANS, 0, 0, 0, 0], rev: [2 * Math.PI, 0, 0, 0, 0], "%": [0.01, 0, 0, 0, 0],
  rpm: [Math.PI / 30, 0, 0, -1, 0], Hz: [1, 0, 0, -1, 0], N: [1, 1, 1, -2, 0], Pa: [1, -1, 1, -2, 0], bar: [1e5, -1, 1, -2, 0],
  J: [1, 2, 1, -2, 0], W: [1, 2, 1, -3, 0], V: [1, 2, 1, -3, -1], ohm: [1, 2, 1, -3, -2], H: [1, 2, 1, -2, -2], F: [1, -2, -1, 4, 2], K: [1, 0, 0, 0, 0],
};
const PREFIXES = { G: 1e9, M: 1e6, k: 1e3, c: 1e-2, d: 1e-1, m: 1e-3, u: 1e-6, µ: 1e-6, n: 1e-9 };

function unitPart(text) {
  if (text in KNOWN) return KNOWN[text];
  const inner = KNOWN[text.slice(1)], factor = PREFIXES[text[0]];
  return inner && factor ? [inner[0] * factor, ...inner.slice(1)] : null;
}

// Factor to SI and powers of a unit such as "N*m/rad" or "kg*m^2"; null if it is none.
export function unitOf(text) {
  const made = [1, 0, 0, 0, 0];
  let way = 1;
  for (const part of text.replaceAll("·", "*").replaceAll("²", "^2").replaceAll("³", "^3").replaceAll(" ", "").split(/([*/])/)) {
    if (part === "*" || part === "/") {
      way = part === "/" ? -1 : 1;
      continue;
    }
    if (part === "" || part === "1") continue;
    const [name, power = "1"] = part.replace(/[()]/g, "").split("^"), one = unitPart(name), times = way * Number(power);
    if (!one || !Number.isFinite(times)) return null;
    made[0] *= one[0] ** times;
    for (let k = 1; k < 5; k++) made[k] += one[k] * times;
  }
  return made;
}

// The number in SI of a text for a quantity in `unit` (SI); without a unit it counts in `usual`.  Throws an Error.
export function typedValue(text, unit, usual) {
  const parts = /^\s*([-+−]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][-+]?\d+)?)\s*(.*?)\s*$/.exec(text);
  if (!parts) throw new Error(`'${text}' is no number: write one such as ${usual ? `5 ${usual}` : "5"}`);
  const number = Number(parts[1].replace("−", "-").replace(",", ".")), given = parts[2] || usual;
  const found = unitOf(given), own = unitOf(unit);
  if (!found) throw new Error(`'${given}' is no unit that is known here; ${unit || "a bare number"} is expected`);
  if (own && found.slice(1).some((power, k) => power !== own[k + 1]))
    throw new Error(`'${given}' is another quantity; ${unit || "a bare number"} is expected`);
  return number * found[0];
}

// A number as short as it can be told from its neighbours in seven digits.
export const tidy = (x) => String(Number(Number(x).toPrecision(7)));
