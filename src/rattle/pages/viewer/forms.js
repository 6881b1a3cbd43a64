// Forms of joints and loads, by the name under which a kind says how it is drawn (rattle/plots/drawings has the same).
// A form has reach(form, stage): [body, point] that must be in the picture; holds(form, stage), if any: [body, point] up to
// which bodies are drawn; instead(stage, form): bodies that it draws
// itself; prepare(stage, part): a list of {z, draw(painter, pose, at)}, drawn in the order of z.

import { pointAt } from "./data.js";
import { feet } from "./ground.js";
import { actuator, cylinderBodies, guide, guideHolds, guideReach, slot, slotHolds, slotReach } from "./guides.js";
import { spring, torsionSpring } from "./springs.js";
import { belt, beltReach, cam, camReach, discReach, flatFollower, gear, gearReach, lockingDisc, rack } from "./wheels.js";

const ends = (form) => form.bodies.map((body, k) => [body, form.points[k]]);
const none = () => [];
const STOP = 0.09; // radius at which stops of an angle are marked

export const FORMS = {
  pin: { reach: ends, instead: none, prepare: pin },
  weld: { reach: ends, instead: none, prepare: weld },
  rod: { reach: ends, instead: none, prepare: rod },
  clutch: { reach: (form) => [[hub(form), [0, 0]]], instead: none, prepare: clutch },
  guide: { reach: guideReach, holds: guideHolds, instead: cylinderBodies, prepare: guide },
  slot: { reach: slotReach, holds: slotHolds, instead: none, prepare: slot },
  actuator: { reach: ends, instead: none, prepare: actuator },
  spring: { reach: ends, instead: none, prepare: spring },
  "torsion-spring": { reach: ends, instead: none, prepare: torsionSpring },
  gear: { reach: gearReach, instead: none, prepare: gear },
  rack: { reach: gearReach, instead: none, prepare: rack },
  belt: { reach: beltReach, instead: none, prepare: belt },
  cam: { reach: camReach, instead: none, prepare: cam },
  "locking-disc": { reach: discReach, instead: none, prepare: lockingDisc },
  "flat-follower": { reach: camReach, instead: none, prepare: flatFollower },
};

// ---------------------------------------------------------------- pins
function pin(stage, part) {
  const { form } = part, loose = form.clearance > 0 && form.contact !== "ideal";
  return [
    ...feet(stage, form),
    {
      z: 5,
      draw(p, pose) {
        const at = stage.ends(form, pose)[0];
        if (loose) p.dot(at, 8.5, { colour: p.theme.grey, width: 1.3, fill: p.theme.paper });
        p.dot(at, 4.6, { width: 1.8, fill: part.driven ? p.theme.black : p.theme.paper });
      },
    },
    ...stops(stage, form),
  ];
}

// Stops of the angle: marks in the directions that the farthest point of B has there, and the arc between them.
function stops(stage, form) {
  let { bodies: [a, b], points: [point, other] } = form, known = (form.stop ?? []).filter((end) => end !== null);
  if (!known.length) return [];
  if (b === "ground") {
    [a, b, point, other] = [b, a, other, point];
    known = known.map((end) => -end);
  }
  const arms = stage.points(b).map(([x, y]) => [x - other[0], y - other[1]]);
  const far = arms.reduce((best, arm) => (Math.hypot(...arm) > Math.hypot(...best) ? arm : best), arms[0] ?? [1, 0]);
  const radius = STOP * stage.size, own = Math.atan2(far[1], far[0]);
  const polar = ([x, y], r, angle) => [x + r * Math.cos(angle), y + r * Math.sin(angle)];
  const draw = (p, pose) => {
    const centre = pointAt(pose, a, point), turn = pose[a].angle + own;
    for (const end of known) {
      p.line([polar(centre, 0.5 * radius, turn + end), polar(centre, 1.2 * radius, turn + end)], { width: 3.5, cap: "butt" });
    }
    if (known.length === 2) {
      const arc = Array.from({ length: 41 }, (_, k) => polar(centre, radius, turn + known[0] + (k / 40) * (known[1] - known[0])));
      p.line(arc, { colour: p.theme.grey, width: 1 });
    }
  };
  return [{ z: 2.5, draw }];
}

function weld(stage, part) {
  const { form } = part, ground = form.bodies.indexOf("ground");
  const drawn = [{ z: 5, draw: (p, pose) => p.square(stage.ends(form, pose)[0], 5, p.theme.black) }];
  if (ground >= 0) {
    const [x, y] = form.points[ground], half = 0.045 * stage.size;
    drawn.push({ z: 1, draw: (p) => p.wall([x - half, y], [x + half, y], { stroke: 8 }) });
  }
  return drawn;
}

function rod(stage, part) {
  return [
    ...feet(stage, part.form),
    { z: 2, draw: (p, pose) => p.line(stage.ends(part.form, pose), { colour: p.theme.grey, width: 2.6 }) },
    { z: 5, draw: (p, pose) => stage.ends(part.form, pose).forEach((end) => p.dot(end, 4, { width: 1.6 })) },
  ];
}

// ---------------------------------------------------------------- clutches
function hub(form) {
  return form.bodies[1] === "ground" ? form.bodies[0] : form.bodies[1];
}

// An arrow in its sense around the middle of the driven body, black while it is locked.
function clutch(stage, part) {
  const { form, name } = part;
  const others = Object.entries(stage.geometry.joints).filter(([, one]) => "sense" in one && hub(one) === hub(form));
  const radius = (0.045 + 0.024 * others.findIndex(([one]) => one === name)) * stage.size, { sense } = form;
  const turns = Array.from({ length: 30 }, (_, k) => (0.5 + sense * (-1.6 + (1.45 * k) / 29)) * Math.PI);
  const arc = turns.map((turn) => [radius * Math.cos(turn), radius * Math.sin(turn)]);
  const last = arc[29], tip = turns[29] + 0.12 * sense * Math.PI;
  const head = [
    last.map((one) => 1.22 * one), [radius * Math.cos(tip), radius * Math.sin(tip)], last.map((one) => 0.78 * one),
  ];
  const shown = stage.motion.has(`${name}.locked`);
  const draw = (p, pose, at) => {
    const held = shown && stage.motion.value(`${name}.locked`, at) > 0.5;
    const style = { colour: held ? p.theme.black : p.theme.grey, width: held ? 3 : 1.6 };
    const { x, y } = pose[hub(form)], move = ([dx, dy]) => [x + dx, y + dy];
    p.line(arc.map(move), style);
    p.area(head.map(move), style.colour);
  };
  return [{ z: 6, draw }];
}
