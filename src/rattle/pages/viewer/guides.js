// Blocks in guides, cylinders with piston and rod, pins in slots, actuators.

import { mix } from "./colours.js";
import { pointAt } from "./data.js";
import { feet } from "./ground.js";

const STRAIGHT = 0.01; // share of the mechanism's size within which points are on the line
const BORE = 0.026, PISTON = 0.032, ROD = 0.009; // half the barrel's height, the piston's length, half the rod's
const OUT = 0.55; // a barrel without points of its own holds so much of the rod
const SLOT_MORE = 0.06; // of a slot without ends beyond the ways of its pin
const BARREL = 0.6; // of the shortest length of an actuator

// The line of a guide or slot at a pose: origin, along, across.
function lineOf(stage, form, pose) {
  const turn = pose[form.bodies[0]].angle + form.axis, cos = Math.cos(turn), sin = Math.sin(turn);
  return { origin: stage.ends(form, pose)[0], along: [cos, sin], across: [-sin, cos] };
}

function onLine(line, x, y) {
  return [0, 1].map((k) => line.origin[k] + x * line.along[k] + y * line.across[k]);
}

function coordinate(line, [x, y]) {
  return (x - line.origin[0]) * line.along[0] + (y - line.origin[1]) * line.along[1];
}

function box(line, low, high, half) {
  return [[low, -half], [high, -half], [high, half], [low, half]].map(([x, y]) => onLine(line, x, y));
}

const known = (form) => (form.stop ?? []).filter((end) => end !== null);

// Both points, and the ends of the guide or slot with its height.
const reachOf = (spanOf) => (form, stage) => {
  const [a, b] = form.bodies, [p, q] = form.points, { low, high, half } = spanOf(stage, form);
  const c = Math.cos(form.axis), s = Math.sin(form.axis);
  const ends = [low, high].flatMap((x) => [-half, half].map((y) => [a, [p[0] + x * c - y * s, p[1] + x * s + y * c]]));
  return [[a, p], [b, q], ...ends];
};

export const guideReach = reachOf(guideSpan), slotReach = reachOf(slotSpan);

// Both ends of a guide or slot that a body carries, [body, point]: the body is drawn up to them.
const heldBy = (spanOf) => (form, stage) => {
  const [a] = form.bodies, [[x, y]] = form.points, { low, high, half } = spanOf(stage, form);
  const c = Math.cos(form.axis), s = Math.sin(form.axis);
  return a === "ground" ? [] : [low + half, high - half].map((way) => [a, [x + way * c, y + way * s]]);
};

export const slotHolds = heldBy(slotSpan);
export const guideHolds = (form, stage) => (cylinderBodies(stage, form).length ? [] : heldBy((...of) => ({ ...guideSpan(...of), half: 0 }))(form, stage));

function ways(stage, form) {
  return stage.range((pose) => coordinate(lineOf(stage, form, pose), stage.ends(form, pose)[1]));
}

// How far a guide goes along its line, half its height, and the block in it.
function guideSpan(stage, form) {
  const [least, most] = ways(stage, form), [length, height] = form.block ?? [0.12 * stage.size, 0.07 * stage.size];
  const low = Math.min(least, ...known(form)) - 0.85 * length, high = Math.max(most, ...known(form)) + 0.85 * length;
  return { low, high, half: height / 2 + form.clearance, length, height };
}

// A slot goes as far as it is long, or else a little farther than its pin.
function slotSpan(stage, form) {
  const [least, most] = ways(stage, form), more = SLOT_MORE * stage.size;
  const [low, high] = "travel" in form ? [-form.travel, form.travel] : [least - more, most + more];
  const half = form.bush_radius || 0.02 * stage.size + form.clearance;
  return { low: low - half, high: high + half, half };
}

function allOnLine(stage, form, body) {
  const line = lineOf(stage, form, stage.first);
  const off = stage.points(body).map((point) => {
    const [x, y] = pointAt(stage.first, body, point);
    return Math.abs((x - line.origin[0]) * line.across[0] + (y - line.origin[1]) * line.across[1]);
  });
  return Math.max(0, ...off) < STRAIGHT * stage.size;
}

// Bodies that are drawn as barrel and rod, not as bars; A is a barrel if all its points are on the line.
export function cylinderBodies(stage, form) {
  const [a, b] = form.bodies;
  if (a === "ground" || stage.rings(a).length || !allOnLine(stage, form, a)) return [];
  return b !== "ground" && !stage.rings(b).length && allOnLine(stage, form, b) ? [a, b] : [a];
}

// Stops of the position as walls across the line, as far before B's point as the block reaches.
function stopWalls(stage, form, before, half) {
  return (form.stop ?? []).flatMap((end, k) => (end === null ? [] : [{
    z: 3.6,
    draw(p, pose) {
      const line = lineOf(stage, form, pose), x = end + (k ? 1 : -1) * before;
      p.line([onLine(line, x, -half), onLine(line, x, half)], { width: 3.5, cap: "butt" });
    },
  }]));
}

export function guide(stage, part) {
  const { form } = part;
  if (cylinderBodies(stage, form).length) return cylinder(stage, form);
  const { low, high, length, height } = guideSpan(stage, form);
  const ground = form.bodies[0] === "ground";
  const walls = (p, pose) => {
    const line = lineOf(stage, form, pose);
    for (const side of form.clearance ? [-1, 1] : [0]) {
      const y = side * (height / 2 + form.clearance), a = onLine(line, low, y), b = onLine(line, high, y);
      if (ground) p.wall(...(side <= 0 ? [a, b] : [b, a]), { stroke: 8, colour: p.theme.grey, width: 1.8 });
      else p.line([a, b], { colour: p.theme.grey, width: 1.8 });
    }
  };
  return [{ z: 1, draw: walls }, ...stopWalls(stage, form, length / 2, 0.7 * height), block(stage, form, length, height)];
}

// A block that turns with B, which keeps its angle to A as far as the play lets it.
function block(stage, form, length, height) {
  const [a, b] = form.bodies, start = stage.first[b].angle - stage.first[a].angle;
  const draw = (p, pose) => {
    const line = lineOf(stage, form, pose), centre = stage.ends(form, pose)[1];
    const turned = pose[b].angle - pose[a].angle - start, c = Math.cos(turned), s = Math.sin(turned);
    const u = [0, 1].map((k) => c * line.along[k] + s * line.across[k]);
    const n = [0, 1].map((k) => c * line.across[k] - s * line.along[k]);
    const corners = box({ origin: centre, along: u, across: n }, -length / 2, length / 2, height / 2);
    const colour = p.theme.body(b === "ground" ? a : b);
    p.area(corners, mix(colour, p.theme.paper, 0.72));
    p.line(corners, { colour, width: 1.8, closed: true });
  };
  return { z: 2.4, draw };
}

// Barrel A, piston and rod B.
function cylinder(stage, form) {
  const [a, b] = form.bodies, { size } = stage;
  const along = (pose, body, point) => coordinate(lineOf(stage, form, pose), pointAt(pose, body, point));
  const piston = (pose) => along(pose, b, form.points[1]);
  const [length, height] = form.block ?? [PISTON * size, 2 * BORE * size], half = height / 2 + form.clearance;
  const points = stage.points(a), own = points.length ? points.map((point) => along(stage.first, a, point)) : [0];
  const [least, most] = stage.range(piston);
  let low = Math.min(...own, least - 0.8 * length, ...known(form).map((end) => end - 0.5 * length));
  let high = Math.max(...own, most + 0.8 * length, ...known(form).map((end) => end + 0.5 * length));
  const tips = b === "ground" ? [] : stage.points(b);
  const far = (point) => Math.max(...stage.range((pose) => Math.abs(along(pose, b, point) - piston(pose))));
  const tip = tips.reduce((best, one) => (best === null || far(one) > far(best) ? one : best), null) ?? form.points[1];
  if (Math.max(...own) - Math.min(...own) < 0.1 * size && along(stage.first, b, tip) > piston(stage.first)) {
    high = Math.max(high, OUT * stage.range((pose) => along(pose, b, tip))[0]); // no point says where the barrel ends
  }
  low -= 0.3 * half;
  high += 0.3 * half;
  const whole = cylinderBodies(stage, form).includes(b);
  const draw = (p, pose) => {
    const line = lineOf(stage, form, pose), x = piston(pose), at_a = p.theme.body(a), at_b = p.theme.body(b);
    p.area(box(line, low, high, half), mix(at_a, p.theme.paper, 0.7));
    if (whole) {
      const rod = box(line, Math.min(x, along(pose, b, tip)), Math.max(x, along(pose, b, tip)), ROD * size);
      p.area(rod, mix(at_b, p.theme.paper, 0.35));
      p.line(rod, { colour: at_b, width: 1.2, closed: true });
    }
    const head = box(line, x - length / 2, x + length / 2, height / 2);
    p.area(head, mix(at_b, p.theme.paper, 0.25));
    p.line(head, { colour: at_b, width: 1.2, closed: true });
    p.line(box(line, low, high, half), { colour: at_a, width: 2, closed: true });
  };
  return [...stopWalls(stage, form, length / 2, half), { z: 3.2, draw }];
}

// Pin in a slot with rounded or open ends, of its given length or else a little longer than the pin moves.
export function slot(stage, part) {
  const { form } = part;
  const span = slotSpan(stage, form), { half } = span, size = half - form.clearance;
  const [low, high] = [span.low + half, span.high - half];
  const turns = Array.from({ length: 19 }, (_, k) => -Math.PI / 2 + (Math.PI * k) / 18);
  const open = form.fields?.open ?? 0, ends = [[1, high, open >= 2], [-1, low, open === 1 || open === 3]];
  const edges = ends.map(([sense, end, mouth]) => (mouth
    ? [[end, -sense * half], [end, sense * half]]
    : turns.map((s) => [end + sense * half * Math.cos(s), sense * half * Math.sin(s)])));
  // lines that begin and end at a mouth
  const [first, last] = ends.map(([, , mouth]) => mouth), [right, left] = edges;
  const strokes = [];
  if (first && last) strokes.push([right[1], left[0]], [left[1], right[0]]);
  else if (first) strokes.push([right[1], ...left, right[0]]);
  else if (last) strokes.push([left[1], ...right, left[0]]);
  else strokes.push([...right, ...left]);
  const walls = (p, pose) => {
    const line = lineOf(stage, form, pose), shown = (points) => points.map(([x, y]) => onLine(line, x, y));
    if (form.bodies[0] === "ground") {
      p.wall(onLine(line, low, -half), onLine(line, high, -half), { stroke: 7, colour: p.theme.grey, width: 1.6 });
    }
    p.area(shown([...right, ...left]), p.theme.paper, 0.85);
    for (const one of strokes) p.line(shown(one), { colour: p.theme.grey, width: 1.8, closed: !(first || last) });
  };
  const pin = (p, pose) => {
    p.circle(stage.ends(form, pose)[1], size, { colour: p.theme.black, fill: p.theme.steel, width: 1.5 });
  };
  return [...stopWalls(stage, form, size, 1.3 * half), { z: 4, draw: walls }, { z: 5, draw: pin }];
}

// Actuator between two points: a cylinder whose barrel hangs at A and whose rod leads to B.
export function actuator(stage, part) {
  const { form } = part, half = 0.8 * BORE * stage.size;
  const length = (pose) => Math.hypot(...[0, 1].map((k) => stage.ends(form, pose)[1][k] - stage.ends(form, pose)[0][k]));
  const end = BARREL * stage.range(length)[0];
  const draw = (p, pose) => {
    const [a, b] = stage.ends(form, pose), size = Math.max(length(pose), 1e-12);
    const u = [(b[0] - a[0]) / size, (b[1] - a[1]) / size];
    const line = { origin: a, along: u, across: [-u[1], u[0]] };
    p.area(box(line, end, size, ROD * stage.size), p.theme.grey);
    p.area(box(line, 0, end, half), mix(p.theme.metal, p.theme.paper, 0.5));
    p.line(box(line, 0, end, half), { width: 1.6, closed: true });
    for (const one of [a, b]) p.dot(one, 3.6, { width: 1.5 });
  };
  return [...feet(stage, form), { z: 3.4, draw }];
}
