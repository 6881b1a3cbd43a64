// Measured curves beside those of a motion: dots, and what they differ by at the measured times within the run.

import { valueOf } from "./chart.js";
import { bytesOf } from "./data.js";

// Measured curves of a scene with their numbers as arrays: {curve, label, t, y} [SI].
export function unpackMeasured(packed) {
  return packed.map(({ curve, label, t, y }) => ({ curve, label, t: new Float64Array(bytesOf(t)), y: new Float64Array(bytesOf(y)) }));
}

// A measured curve within a motion: {t, y, difference (measured minus computed), rms,
// all: how many were measured}.
export function differing(measured, motion) {
  const known = motion.line(measured.curve), line = { x: known.t, y: known.y }, edge = 1e-9 * motion.span, t = [], y = [], difference = [];
  let squares = 0, count = 0;
  measured.t.forEach((time, k) => {
    if (time < motion.start - edge || time > motion.end + edge) return;
    const off = measured.y[k] - valueOf(line, time);
    t.push(time);
    y.push(measured.y[k]);
    difference.push(off);
    if (Number.isFinite(off)) [squares, count] = [squares + off * off, count + 1];
  });
  return { t, y, difference, rms: count ? Math.sqrt(squares / count) : NaN, all: measured.t.length };
}

// Lines of measured values for a panel of curves, and for the panel of what they differ by.
export function measuredLines(list, motion, names) {
  return list.filter((one) => names.includes(one.curve)).map((one) => {
    const found = differing(one, motion), style = { name: one.curve, motion, colour: names.indexOf(one.curve), label: one.label, dots: true };
    return { values: { ...style, own: { t: found.t, y: found.y } },
      off: { ...style, own: { t: found.t, y: found.difference }, joined: true, rms: found.rms, all: found.all } };
  });
}
