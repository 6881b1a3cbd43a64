// What the orbit of a pin in oil also shows: the last turn of the crank, its angle, mixed friction, the thinnest film.

import { FONT } from "./painter.js";
import { handyUnit, short } from "./units.js";

const DOT = 10; // degrees of the crank from dot to dot
const NAMED = 90;

// Name and angle of the first driven joint that turns one way, or null: {name, angle, last}, last: where its last turn begins.
export function crankOf(motion) {
  for (const name of motion.geometry.driven) {
    if (!motion.has(`${name}.angle`) || motion.n < 3) continue;
    const angle = motion.curve(`${name}.angle`), way = Math.sign(angle[1] - angle[0]);
    for (let k = 1; ; k++) {
      if (k === motion.n) return { name, angle, way, last: lastTurn(angle, way) };
      if ((angle[k] - angle[k - 1]) * way <= 0) break;
    }
  }
  return null;
}

function lastTurn(angle, way) {
  const end = angle[angle.length - 1], first = angle.findIndex((one) => way * (end - one) <= 2 * Math.PI + 1e-6);
  return Math.min(first, angle.length - 3);
}

// Dots every ten degrees of the crank in its last turn, with numbers at quarters of it.
export function crankDots(p, motion, joint, crank) {
  const { theme, context } = p, x = motion.curve(`${joint}.ex`), y = motion.curve(`${joint}.ey`), { angle, last, way } = crank;
  context.font = `11px ${FONT}`;
  context.textAlign = "center";
  context.textBaseline = "middle";
  for (let k = last; k + 1 < motion.n; k++) {
    const from = (180 / Math.PI) * way * angle[k], to = (180 / Math.PI) * way * angle[k + 1];
    for (let mark = Math.ceil(from / DOT - 1e-6) * DOT; mark < to; mark += DOT) {
      const f = (mark - from) / (to - from), at = [x[k] + f * (x[k + 1] - x[k]), y[k] + f * (y[k + 1] - y[k])];
      const named = mark % NAMED === 0, size = Math.hypot(...at) || 1;
      p.dot(at, named ? 3 : 1.6, { colour: null, fill: theme.ink });
      if (!named) continue;
      context.fillStyle = theme.ink;
      context.fillText(`${((mark % 360) + 360) % 360}°`, p.X(at[0]) + (15 * at[0]) / size, p.Y(at[1]) - (15 * at[1]) / size);
    }
  }
}

// Where the film is thinnest, and where the dry contact carries too.
export function oilMarks(p, motion, joint) {
  const x = motion.curve(`${joint}.ex`), y = motion.curve(`${joint}.ey`), thin = motion.curve(`${joint}.film_thickness`);
  const regime = motion.has(`${joint}.regime`) ? motion.curve(`${joint}.regime`) : [];
  p.line(Array.from(regime, (one, k) => (one > 0 ? [x[k], y[k]] : null)), { colour: p.theme.red, width: 5, opacity: 0.5 });
  const k = leastOf(thin);
  p.context.save();
  p.context.translate(p.X(x[k]), p.Y(y[k]));
  p.context.rotate(Math.PI / 4);
  p.context.fillStyle = p.theme.paper;
  p.context.strokeStyle = p.theme.red;
  p.context.lineWidth = 1.8;
  p.context.fillRect(-4, -4, 8, 8);
  p.context.strokeRect(-4, -4, 8, 8);
  p.context.restore();
}

function leastOf(values) {
  let best = 0;
  for (let k = 1; k < values.length; k++) if (values[k] < values[best]) best = k;
  return best;
}

// The same in words.
export function oilKey(motion, joint, crank, word) {
  const thin = motion.curve(`${joint}.film_thickness`), least = thin[leastOf(thin)], { factor, unit } = handyUnit("m", Math.abs(least));
  const found = [word("diamond: least film, {size}", { size: `${short(factor * least)} ${unit}` })];
  if (crank) found.push(word("dots: every {step}° of {name} in its last turn", { step: DOT, name: crank.name }));
  if (motion.has(`${joint}.regime`) && motion.largest(`${joint}.regime`) > 0) found.push(word("red: the dry contact carries too"));
  return found;
}
