// Numbers for people: handy units by the table of Python, ticks, and texts whose width does not jump.

import { HANDY } from "./handy_units.js";

const FINER = 8; // steps by which an axis without two labels is divided more finely, enough for any range

export function printed(unit) {
  return unit.replaceAll("*", "·").replaceAll("^2", "²").replaceAll("^3", "³");
}

// Factor from the SI unit and the unit in which a quantity of this size is shown, as `handy_unit` in Python.
// written: quantities of the model file by SI unit, {unit: [[size, factor, name]]}: the one nearest in size lends its unit.
export function handyUnit(unit, size, written = {}) {
  const rungs = HANDY.units[unit] ?? [], far = ([one]) => (size > 0 ? Math.abs(Math.log(one / size)) : 0);
  const near = (written[unit] ?? []).reduce((best, one) => (best && far(best) <= far(one) ? best : one), null);
  if (near && (size === 0 || (near[1] * size >= HANDY.least && near[1] * size < HANDY.most))) return { factor: near[1], unit: printed(near[2]) };
  const reached = rungs.length > 1 && !(size > 0) ? [] : rungs.filter(([least]) => least <= size);
  const [, times = 1, shown = unit] = reached[reached.length - 1] ?? [];
  return { factor: times, unit: printed(shown) };
}

export function minus(text) {
  return String(text).replaceAll("-", "\u2212");
}

// A number with so many significant digits, without superfluous zeros.
export function short(value, digits = 3) {
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  if (!Number.isFinite(value)) return value > 0 ? "∞" : minus("-∞");
  const size = Math.abs(value);
  if (size !== 0 && (size >= 1e6 || size < 1e-4)) {
    const [part, power] = value.toExponential(digits - 1).split("e");
    return minus(`${Number(part)}e${Number(power)}`);
  }
  return minus(Number(value.toPrecision(digits)));
}

// A number as it is typed: as many digits as tell it from its neighbours.
export function plain(value, digits = 7) {
  const number = Number(Number(value).toPrecision(digits)), size = Math.abs(number);
  return size !== 0 && (size >= 1e6 || size < 1e-4) ? number.toExponential().replace("e+", "e") : String(number);
}

// A function that writes numbers up to this size with constant width: figure spaces in front.
export function steady(most, digits = 4) {
  const size = Math.abs(most) || 1;
  const first = Math.floor(Math.log10(size) + 1e-9) + 1, before = Math.max(1, first); // small ones keep their digits
  const wild = before > 7 || size < 1e-4;
  const after = wild ? digits - 2 : Math.max(0, digits - first);
  const width = wild ? after + 7 : 1 + before + (after ? 1 + after : 0);
  return (value) => {
    if (!Number.isFinite(value)) return "–".padStart(width, "\u2007");
    let text = wild ? value.toExponential(after) : value.toFixed(after);
    if (Number(text) === 0) text = text.replace("-", "");
    return minus(text).padStart(width, "\u2007");
  };
}

// A step of 1, 2 or 5 times a power of ten, no smaller than this one.
export function niceStep(least) {
  if (!(least > 0) || !Number.isFinite(least)) return 1;
  const power = 10 ** Math.floor(Math.log10(least) + 1e-12);
  return [1, 2, 5, 10].find((one) => one * power >= least * (1 - 1e-9)) * power;
}

// Round values from low to high, about `count` of them, and how many decimals they need.
export function ticks(low, high, count) {
  const step = niceStep((high - low) / Math.max(1, count));
  const decimals = Math.max(0, Math.min(12, -Math.floor(Math.log10(step) + 1e-9)));
  const values = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step && values.length < 200; k++) {
    values.push(Number((k * step).toFixed(decimals)));
  }
  const large = Math.max(Math.abs(low), Math.abs(high)) >= 1e6 || decimals > 6;
  return { values, step, text: (value) => (large ? short(value, 4) : minus(value.toFixed(decimals))) };
}

// The same for an axis: at least two values, so that it has a scale.
export function axisTicks(low, high, count) {
  let found = ticks(low, high, count);
  for (let more = count + 1; found.values.length < 2 && more <= count + FINER; more++) found = ticks(low, high, more);
  return found;
}

// How times of a motion are written: as many digits for a short one as it needs.
export function timeText(span) {
  const digits = Math.max(2, Math.min(9, 3 - Math.floor(Math.log10(span > 0 ? span : 1))));
  return (t) => minus(t.toFixed(digits));
}
