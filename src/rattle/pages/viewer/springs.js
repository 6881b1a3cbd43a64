// Springs with coils, dampers as dashpots, torsion springs as spirals; walls where they are held by the ground.

import { mix } from "./colours.js";

const HALF = 0.025; // half the width, as a share of the mechanism's size
const TURNS = 2.5, RADIUS = 0.05; // of a spiral
const COILS = 9;

// A line between two points: along as a share of the length, across in metres.
function placed(shape, [ax, ay], [bx, by]) {
  const dx = bx - ax, dy = by - ay, length = Math.max(Math.hypot(dx, dy), 1e-12);
  return shape.map((one) => one && [ax + one[0] * dx - (one[1] * dy) / length, ay + one[0] * dy + (one[1] * dx) / length]);
}

function dashpot(half, shift) {
  const pot = [[0.65, shift + half], [0.35, shift + half], [0.35, shift - half], [0.65, shift - half]];
  return [[0.12, shift], [0.35, shift], null, ...pot, null, [0.55, shift + 0.8 * half], [0.55, shift - 0.8 * half], null,
    [0.55, shift], [0.88, shift]];
}

// Coils of a helical spring seen from the side: half turns, those in front apart from those behind.
function coils(half, shift) {
  const x = (k) => 0.15 + (0.7 * k) / (2 * COILS), y = (k) => shift + half * (k % 2 ? 1 : -1);
  const front = [], back = [];
  for (let k = 0; k < 2 * COILS; k++) (k % 2 ? back : front).push([x(k), y(k)], [x(k + 1), y(k + 1)], null);
  const lead = [[0, shift], [0.12, shift], [x(0), y(0)]], tail = [[x(2 * COILS), y(2 * COILS)], [0.88, shift], [1, shift]];
  return { front: [...lead, null, ...front, ...tail], back };
}

export function spring(stage, part) {
  const { form } = part, half = HALF * stage.size, fields = form.fields ?? {};
  const stiff = (fields.stiffness ?? 1) !== 0 || !form.fields, damped = (fields.damping ?? 1) !== 0 && form.fields;
  const both = stiff && damped, turns = stiff && coils(both ? 0.7 * half : half, both ? half : 0);
  const pot = damped ? [[0, 0], [0.12, 0], null, ...dashpot(0.6 * half, both ? -half : 0), null, [0.88, 0], [1, 0]] : null;
  if (both) {
    turns.front = turns.front.slice(1, -1); // its ends are those of the frame
    pot.push(null, [0.12, -half], [0.12, half], null, [0.88, -half], [0.88, half]);
  }
  const draw = (p, pose) => {
    const [a, b] = stage.ends(form, pose), width = stage.size * p.view.scale < 260 ? 1.4 : 2;
    const pale = mix(p.theme.metal, p.theme.paper, 0.45);
    if (turns) {
      p.line(placed(turns.back, a, b), { colour: pale, width });
      p.line(placed(turns.front, a, b), { colour: p.theme.metal, width });
    }
    if (pot) p.line(placed(pot, a, b), { colour: p.theme.grey, width: 1.5, cap: "butt" });
    for (const end of [a, b]) p.dot(end, 2.6, { colour: p.theme.grey, width: 1.2 });
  };
  return [{ z: 2, draw }, ...held(stage, form, half)];
}

// A short wall across the end at the ground, as that end lies at the start.
function held(stage, form, half) {
  const [a, b] = stage.ends(form, stage.first);
  return form.bodies.flatMap((body, k) => {
    if (body !== "ground") return [];
    const here = k ? b : a, there = k ? a : b;
    const dx = there[0] - here[0], dy = there[1] - here[1], length = Math.hypot(dx, dy);
    const n = length > 0 ? [-dy / length, dx / length] : [1, 0], reach = 1.6 * half;
    return [{ z: 1, draw: (p) => p.wall(
      [here[0] - reach * n[0], here[1] - reach * n[1]], [here[0] + reach * n[0], here[1] + reach * n[1]], { stroke: 8 }) }];
  });
}

// A spiral about the point of B, its outer end goes with A and its inner end with B.
export function torsionSpring(stage, part) {
  const { form } = part, [a, b] = form.bodies;
  const draw = (p, pose) => {
    const [x, y] = stage.ends(form, pose)[1], inner = pose[b].angle, outer = pose[a].angle;
    const spiral = Array.from({ length: 91 }, (_, k) => {
      const share = k / 90, angle = inner + share * (2 * Math.PI * TURNS + outer - inner);
      const radius = stage.size * RADIUS * (0.25 + 0.75 * share);
      return [x + radius * Math.cos(angle), y + radius * Math.sin(angle)];
    });
    p.line(spiral, { colour: p.theme.metal, width: 1.6 });
  };
  return [{ z: 4.5, draw }];
}
