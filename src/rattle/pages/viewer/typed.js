// Quantities as people type them ("5 mm", "120 rpm", "0.2") and as they read them.

import { HANDY } from "./handy_units.js";

const KNOWN = { __proto__: null, ...HANDY.known, "%": [0.01, 0, 0, 0, 0] }; // factor to SI, and powers of m, kg, s, K

// Factor to SI and powers of a unit such as "N*m/rad" or "kg*m^2"; null if it is none.
export function unitOf(text) {
  const made = [1, 0, 0, 0, 0];
  let way = 1;
  for (const part of text.replaceAll("·", "*").replaceAll("μ", "µ").replaceAll("²", "^2").replaceAll("³", "^3").replaceAll(" ", "").split(/([*/])/)) {
    if (part === "*" || part === "/") {
      way = part === "/" ? -1 : 1;
      continue;
    }
    if (part === "" || part === "1") continue;
    const [name, power = "1"] = part.replace(/[()]/g, "").split("^"), one = KNOWN[name], times = way * Number(power);
    if (!one || !Number.isFinite(times)) return null;
    made[0] *= one[0] ** times;
    for (let k = 1; k < 5; k++) made[k] += one[k] * times;
  }
  return made;
}

const FREEZING = 273.15; // 0 degC in K

// The number in SI of a text for a quantity in `unit` (SI); without a unit it counts in `usual`.  Throws an Error.
export function typedValue(text, unit, usual) {
  const parts = /^\s*([-+−]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][-+]?\d+)?)\s*(.*?)\s*$/.exec(text);
  if (!parts) throw new Error(`'${text}' is no number: write one such as ${usual ? `5 ${usual}` : "5"}`);
  const number = Number(parts[1].replace("−", "-").replace(",", ".")), given = parts[2] || usual;
  const zero = given === "degC" ? FREEZING : 0, found = unitOf(zero ? "K" : given), own = unitOf(unit);
  if (!found) throw new Error(`'${given}' is no unit that is known here; ${unit || "a bare number"} is expected`);
  if (own && found.slice(1).some((power, k) => power !== own[k + 1]))
    throw new Error(`'${given}' is another quantity; ${unit || "a bare number"} is expected`);
  return number * found[0] + zero;
}
