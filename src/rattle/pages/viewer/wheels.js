// Wheels: gears, racks, belts and cams to scale.  A model knows pitch circles, not teeth: their number is that of the
// picture, chosen so that they mesh; where no number does, a mark stands for every tooth.

import { mix } from "./colours.js";
import { pointAt } from "./data.js";

const DEPTH = 0.3; // height of a tooth on either side of the pitch circle, as a share of the pitch
const RIM = 3; // height of the rim of a ring, in such heights
const FEWEST = 18; // teeth on the smallest wheel
const MOST_TEETH = 36;
const BEYOND = 1.5; // of a rack beyond the ways of its pinion, in radii
const LONGEST = 400; // teeth of a rack
const TURN = Array.from({ length: 97 }, (_, k) => (2 * Math.PI * k) / 96);

const circle = ([x, y], r, turns = TURN) => turns.map((s) => [x + r * Math.cos(s), y + r * Math.sin(s)]);

// The wheels of a gear pair, or the pinion of a rack: {body, centre, radius, ring}.
function wheelsOf(form) {
  const radii = form.fields.radii ?? [0, form.fields.radius ?? 0];
  return radii.map((radius, k) => ({
    body: form.bodies[k], centre: form.points[k], radius, ring: k === 0 && Boolean(form.fields.internal) && "radii" in form.fields,
  })).filter((one) => one.radius > 0);
}

const same = (one, other) => one.body === other.body && one.radius === other.radius && one.ring === other.ring
  && one.centre[0] === other.centre[0] && one.centre[1] === other.centre[1];

function around(body, [x, y], radius) {
  return TURN.slice(0, -1).filter((_, k) => k % 4 === 0).map((s) => [body, [x + radius * Math.cos(s), y + radius * Math.sin(s)]]);
}

export function gearReach(form) {
  const every = wheelsOf(form), rim = (RIM * DEPTH * 2 * Math.PI * Math.min(...every.map((one) => one.radius))) / FEWEST;
  return every.flatMap((one) => around(one.body, one.centre, one.radius + (one.ring ? rim : 0.3 * rim)));
}

function toothed(stage) {
  return Object.entries(stage.geometry.joints).filter(([name]) => ["gear", "rack"].includes(stage.kinds.joints[name]));
}

// Pitch of the teeth of all wheels [m], and whether whole numbers of teeth fit all of them.
function pitchOf(stage) {
  const radii = toothed(stage).flatMap(([, form]) => wheelsOf(form).map((one) => one.radius));
  const least = Math.min(...radii, Infinity);
  if (!Number.isFinite(least)) return { step: 1, whole: false };
  for (let count = FEWEST; count <= MOST_TEETH; count++) {
    if (radii.every((one) => Math.abs((one / least) * count - Math.round((one / least) * count)) < 0.01)) {
      return { step: (2 * Math.PI * least) / count, whole: true };
    }
  }
  return { step: (2 * Math.PI * least) / 16, whole: false };
}

// All wheels with the angle of a tooth in their frame, so that teeth of one lie in the gaps of the other at the start.
function meshing(stage) {
  if (stage.wheels) return stage.wheels;
  const { step, whole } = pitchOf(stage), found = [];
  for (const [, form] of toothed(stage)) {
    let [one, other] = wheelsOf(form).map((wheel) => found.find((old) => same(old, wheel)) ?? { ...wheel, step, whole, phase: null });
    if (other && one.phase === null && other.phase !== null) [one, other] = [other, one];
    one.phase ??= 0;
    if (other && other.phase === null) other.phase = meshed(stage, one, other, step);
    for (const wheel of [one, other]) if (wheel && !found.includes(wheel)) found.push(wheel);
  }
  stage.wheels = found;
  return found;
}

function meshed(stage, one, other, step) {
  const a = pointAt(stage.first, one.body, one.centre), b = pointAt(stage.first, other.body, other.centre);
  const inside = one.ring || other.ring;
  let way = Math.atan2(b[1] - a[1], b[0] - a[0]); // from the centre of `one` to where they touch
  if (inside && other.ring) way += Math.PI;
  const share = ((way - stage.first[one.body].angle - one.phase) * one.radius) / step; // teeth of `one` up to there
  const there = way + (inside ? 0 : Math.PI) - stage.first[other.body].angle;
  return there + ((inside ? -1 : 1) * (share + (inside ? 0 : 0.5)) * step) / other.radius;
}

// The outline of a toothed wheel about its centre; a ring has its teeth inside.
function teeth(wheel) {
  const { radius, step, phase, ring } = wheel, count = Math.round((2 * Math.PI * radius) / step);
  const [tip, root] = ring ? [radius - DEPTH * step, radius + 1.15 * DEPTH * step] : [radius + DEPTH * step, radius - 1.15 * DEPTH * step];
  const outline = [];
  for (let k = 0; k < count; k++) {
    for (const [at, r] of [[-0.36, root], [-0.13, tip], [0.13, tip], [0.36, root]]) {
      const angle = phase + (2 * Math.PI * (k + at)) / count;
      outline.push([r * Math.cos(angle), r * Math.sin(angle)]);
    }
  }
  return outline;
}

function marks(wheel) {
  const count = Math.max(3, Math.round((2 * Math.PI * wheel.radius) / wheel.step)), depth = DEPTH * wheel.step, strokes = [];
  for (let k = 0; k < count; k++) {
    const c = Math.cos((2 * Math.PI * k) / count), s = Math.sin((2 * Math.PI * k) / count);
    strokes.push([(wheel.radius - depth) * c, (wheel.radius - depth) * s], [(wheel.radius + depth) * c, (wheel.radius + depth) * s], null);
  }
  return strokes;
}

function wheelDraw(stage, wheel) {
  const rim = wheel.radius + RIM * DEPTH * wheel.step, shift = (points) =>
    points.map((one) => one && [one[0] + wheel.centre[0], one[1] + wheel.centre[1]]);
  const edge = shift(wheel.whole ? teeth(wheel) : circle([0, 0], wheel.radius));
  const outer = shift(circle([0, 0], rim)), strokes = wheel.whole ? null : shift(marks(wheel));
  const holes = wheel.ring ? [] : [0, 1, 2].map((k) => shift(circle(
    [0, 1].map((way) => 0.56 * wheel.radius * Math.cos((Math.PI * (2 * k + 1)) / 3 - way * Math.PI / 2)), 0.17 * wheel.radius)));
  const spoke = shift(wheel.ring ? [[wheel.radius + 1.5 * DEPTH * wheel.step, 0], [rim, 0]] : [[0, 0], [0.8 * wheel.radius, 0]]);
  return (p, pose) => {
    const move = (points) => points.map((one) => one && pointAt(pose, wheel.body, one));
    const colour = p.theme.body(wheel.body), own = move(edge), fill = mix(colour, p.theme.paper, 0.72);
    p.plate(wheel.ring ? [move(outer), own] : [own, ...holes.map(move)], fill, 0.8);
    p.line(own, { colour, width: 1.4, closed: true });
    if (wheel.ring) p.line(move(outer), { colour, width: 1.4, closed: true });
    for (const hole of holes) p.line(move(hole), { colour, width: 1, closed: true });
    if (strokes) p.line(move(strokes), { colour, width: 1.2 });
    p.line(move(spoke), { colour, width: 1.6 });
  };
}

// Those wheels of one pair that no joint before it has.
export function gear(stage, part) {
  const every = meshing(stage), before = [];
  for (const [name, form] of toothed(stage)) {
    if (name === part.name) break;
    before.push(...wheelsOf(form));
  }
  return wheelsOf(part.form).filter((one) => !before.some((old) => same(old, one)))
    .map((one) => ({ z: 2, draw: wheelDraw(stage, every.find((wheel) => same(wheel, one))) }));
}

// The teeth of a rack along its pitch line, towards the pinion, as far as this goes, and the pinion as a gear.
export function rack(stage, part) {
  const { form } = part, [a] = form.bodies, [px, py] = form.points[0];
  const { axis, radius } = form.fields, along = [Math.cos(axis), Math.sin(axis)], across = [-along[1], along[0]];
  const [low, high] = stage.range((pose) => wayOf(stage, form, pose)).map((way, k) => way + (k ? 1 : -1) * BEYOND * radius);
  const { step: pitch } = pitchOf(stage), step = pitch * Math.max(1, (high - low) / (pitch * LONGEST)), h = DEPTH * step;
  const line = [[low, 2.4 * h], [low, h]], first = firstTooth(stage, form) - 0.5 * step; // the pinion is on the side -h
  for (let x = first + Math.ceil((low - first) / step) * step; x < high - step; x += step) {
    line.push([x + 0.14 * step, h], [x + 0.37 * step, -h], [x + 0.63 * step, -h], [x + 0.86 * step, h]);
  }
  line.push([high, h], [high, 2.4 * h]);
  const body = line.map(([x, y]) => [0, 1].map((k) => [px, py][k] + x * along[k] + y * across[k]));
  const draw = (p, pose) => {
    const shown = body.map((point) => pointAt(pose, a, point)), colour = p.theme.body(a);
    p.area(shown, mix(colour, p.theme.paper, 0.72));
    p.line(shown, { colour, width: 1.4, closed: true });
  };
  return [...gear(stage, part), { z: 1.8, draw }];
}

// Where the centre of the pinion is along the line of its rack.
function wayOf(stage, form, pose) {
  const [from, to] = stage.ends(form, pose), turn = pose[form.bodies[0]].angle + form.fields.axis;
  return (to[0] - from[0]) * Math.cos(turn) + (to[1] - from[1]) * Math.sin(turn);
}

// Where a tooth of the rack is, so that at the start it lies in a gap of the pinion.
function firstTooth(stage, form) {
  const pinion = meshing(stage).find((one) => same(one, wheelsOf(form)[0])), [a, b] = form.bodies;
  const turned = pinion.phase + stage.first[b].angle - stage.first[a].angle - form.fields.axis - Math.PI / 2;
  return wayOf(stage, form, stage.first) - pinion.radius * turned + 0.5 * pinion.step;
}

// Where the force of a gear pair or rack acts: where the pitch circles touch, or the circle and the line.
export function pitchPoint(stage, form, pose) {
  const [one, other] = stage.ends(form, pose), { radii, radius, axis } = form.fields;
  if (radii) {
    const d = Math.hypot(other[0] - one[0], other[1] - one[1]) || 1;
    return [0, 1].map((k) => one[k] + (radii[0] / d) * (other[k] - one[k]));
  }
  const turn = pose[form.bodies[0]].angle + axis;
  return [other[0] - radius * Math.sin(turn), other[1] + radius * Math.cos(turn)];
}

// ---------------------------------------------------------------- belts
export function beltReach(form) {
  return form.bodies.flatMap((body, k) => around(body, form.points[k], form.fields.radii[k]));
}

// The line that touches both pulleys on one side, from their centres.
export function strand(one, other, radii, crossed, side) {
  const dx = other[0] - one[0], dy = other[1] - one[1], length = Math.max(Math.hypot(dx, dy), 1e-300);
  const share = Math.max(-1, Math.min(1, (crossed ? radii[0] + radii[1] : radii[0] - radii[1]) / length));
  const turn = Math.atan2(dy, dx) + side * Math.acos(share), c = Math.cos(turn), s = Math.sin(turn);
  const far = (crossed ? -1 : 1) * radii[1];
  return [[one[0] + radii[0] * c, one[1] + radii[0] * s], [other[0] + far * c, other[1] + far * s]];
}

export function belt(stage, part) {
  const { form } = part, { radii, crossed } = form.fields;
  const pulleys = form.bodies.map((body, k) => ({
    z: 2,
    draw(p, pose) {
      const centre = pointAt(pose, body, form.points[k]), colour = p.theme.body(body);
      p.circle(centre, radii[k], { colour, width: 1.8, fill: mix(colour, p.theme.paper, 0.75) });
      p.circle(centre, 0.82 * radii[k], { colour, width: 1 });
      for (const turn of [0, 1, 2]) {
        const angle = (turn * 2 * Math.PI) / 3, [x, y] = form.points[k];
        p.line([centre, pointAt(pose, body, [x + 0.82 * radii[k] * Math.cos(angle), y + 0.82 * radii[k] * Math.sin(angle)])],
          { colour, width: turn ? 1 : 2.4 });
      }
    },
  }));
  const draw = (p, pose) => {
    const [a, b] = stage.ends(form, pose);
    for (const side of [1, -1]) p.line(strand(a, b, radii, Boolean(crossed), side), { width: 2.4 });
  };
  return [...pulleys, { z: 2.2, draw }];
}

// ---------------------------------------------------------------- cams
export function camReach(form) {
  const ends = form.bodies.map((body, k) => [body, form.points[k]]), [x, y] = form.points[0];
  return [...ends, ...(form.outline ?? []).filter((_, k) => k % 12 === 0).map((one) => [form.bodies[0], [x + one[0], y + one[1]]])];
}

// The same seen from B: its outline stands in the place of that of A.
const borne = (form) => ({
  ...form, bodies: [...form.bodies].reverse(), points: [...form.points].reverse(), outline: form.borne_outline,
});
export const discReach = (form) => [...camReach(form), ...camReach(borne(form))];

// The outline on its body, filled if it is closed, then with a line from the centre to where it begins.
function outlineOf(form) {
  const outline = form.outline ?? [], [x, y] = form.points[0], [body] = form.bodies;
  if (outline.length < 2) return [];
  const size = Math.max(...outline.flat().map(Math.abs)), last = outline[outline.length - 1];
  const closed = Math.hypot(outline[0][0] - last[0], outline[0][1] - last[1]) < 1e-6 * size;
  const path = outline.map((one) => [one[0] + x, one[1] + y]);
  const draw = (p, pose) => {
    const shown = path.map((point) => pointAt(pose, body, point)), colour = p.theme.body(body);
    if (closed) p.area(shown, mix(colour, p.theme.paper, 0.72), 0.9);
    p.line(shown, { colour, width: 2 });
    if (closed) p.line([pointAt(pose, body, form.points[0]), shown[Math.floor(shown.length / 2)]], { colour, width: 1.4 });
  };
  return [{ z: 2, draw }];
}

export function cam(stage, part) {
  const { form } = part, radius = form.fields.roller ?? 0, [, b] = form.bodies;
  const draw = (p, pose) => {
    const at = stage.ends(form, pose)[1], colour = p.theme.body(b);
    if (radius > 0) {
      p.circle(at, radius, { colour, width: 1.8, fill: mix(colour, p.theme.paper, 0.75) });
      p.line([at, pointAt(pose, b, [form.points[1][0] + 0.8 * radius, form.points[1][1]])], { colour, width: 1.2 });
    }
    p.dot(at, radius > 0 ? 2.6 : 4, { width: 1.4 });
  };
  return [...outlineOf(form), { z: 4, draw }];
}

// A cam, and the face of its follower as far as the cam may touch it.
export function flatFollower(stage, part) {
  const { form } = part, [, b] = form.bodies, outline = form.outline?.length ? form.outline : [[0.1 * stage.size, 0]];
  const size = 1.1 * Math.max(...outline.map((one) => Math.hypot(...one)));
  const draw = (p, pose) => {
    const [centre, point] = stage.ends(form, pose), turn = pose[b].angle + form.fields.axis;
    const along = [-Math.sin(turn), Math.cos(turn)];
    const own = (centre[0] - point[0]) * along[0] + (centre[1] - point[1]) * along[1];
    const at = (way) => [point[0] + way * along[0], point[1] + way * along[1]];
    p.line([at(Math.min(own - size, 0)), at(Math.max(own + size, 0))], { colour: p.theme.body(b), width: 4 });
    p.dot(point, 2, { width: 1 });
  };
  return [...outlineOf(form), { z: 3, draw }];
}

// A locking disc with its sector cut out, and the wheel with its hollow arcs.
export const lockingDisc = (stage, part) => [...outlineOf(part.form), ...outlineOf(borne(part.form))];
