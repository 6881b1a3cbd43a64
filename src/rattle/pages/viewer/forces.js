// Arrows of forces: of joints on their second body, of springs and actuators on both ends, moments of drivers as arcs.

import { pointAt } from "./data.js";
import { handyUnit, niceStep, short } from "./units.js";

const LONG = 0.17; // of the arrow of a usual force, as a share of the shorter side of the picture
const MOST = 1.7; // times that length at which an arrow is cut, and gets two heads
const USUAL = 0.96; // share of all instants whose forces are no larger than the usual one

function usual(values) {
  const sizes = values.sort((a, b) => a - b);
  return sizes.length ? sizes[Math.min(sizes.length - 1, Math.floor(USUAL * sizes.length))] : 0;
}

// All forces and moments of a motion that have a place: {forces: [...], moments: [...], scale, turn}.
export function forcesOf(stage) {
  const { motion, geometry } = stage;
  const forces = [], moments = [];
  for (const [name, form] of Object.entries(geometry.joints)) {
    if (motion.has(`${name}.fx`)) forces.push({ name, form, kind: "joint", link: form.contact === "massless-link" });
  }
  for (const [name, form] of Object.entries(geometry.loads)) {
    if (motion.has(`${name}.force`) && form.coordinate === "length") forces.push({ name, form, kind: "load" });
    else if (form.fields?.torque) moments.push({ name, form, constant: form.fields.torque }); // others a result does not hold
  }
  for (const [name, joint] of driversOf(motion)) {
    const form = geometry.joints[joint];
    if (motion.has(`${name}.torque`)) moments.push({ name, form });
    else if (form.axis !== undefined) forces.push({ name, form, kind: "driver" });
  }
  const sizes = forces.flatMap((one) => motion.sample(`${one.name}.force`));
  return {
    forces, moments, scale: usual(sizes),
    turn: usual(moments.flatMap((one) => (one.constant ? [Math.abs(one.constant)] : motion.sample(`${one.name}.torque`)))),
  };
}

// Names of drivers with the joints that they move; a result does not say which is whose, but their order is the same.
function driversOf(motion) {
  const { geometry } = motion;
  const taken = (owner) => owner in geometry.joints || owner in geometry.loads || owner in geometry.bodies;
  const owners = motion.names.filter((name) => name.endsWith(".power") && !motion.rules.has(name))
    .map((name) => name.slice(0, -6)).filter((owner) => !taken(owner) && (motion.has(`${owner}.torque`) || motion.has(`${owner}.force`)));
  return owners.length === geometry.driven.length ? owners.map((owner, k) => [owner, geometry.driven[k]]) : [];
}

// Draw them at a time; `side` is the shorter side of the picture in pixels.
export function drawForces(p, stage, known, pose, time, side) {
  const { motion } = stage, row = motion.row(time);
  const value = (name) => motion.value(name, time, row);
  const long = known.scale > 0 ? (LONG * side) / known.scale : 0;
  const put = (at, fx, fy, colour) => {
    const size = Math.hypot(fx, fy), most = MOST * LONG * side, cut = size * long > most;
    const share = cut ? most / size : long;
    p.arrow(at, [fx * share, fy * share], { colour, cut });
  };
  for (const { name, form, kind, link } of known.forces) {
    const [a, b] = stage.ends(form, pose);
    if (kind === "joint") {
      put(stage.drawing.forces[name]?.map((place) => stage.values.get(place)) ?? a, value(`${name}.fx`), value(`${name}.fy`), link && value(`${name}.normal`) < 0 ? p.theme.red : p.theme.black);
      continue;
    }
    const angle = kind === "driver" ? pose[form.bodies[0]].angle + form.axis : Math.atan2(b[1] - a[1], b[0] - a[0]);
    const size = (kind === "driver" ? 1 : form.power) * value(`${name}.force`), colour = p.theme.curve(2);
    put(b, size * Math.cos(angle), size * Math.sin(angle), colour);
    if (kind === "load") put(a, -size * Math.cos(angle), -size * Math.sin(angle), colour);
  }
  for (const { name, form, constant } of known.moments) {
    if (known.turn > 0) drawMoment(p, pointAt(pose, form.bodies[1], form.points[1]), (constant ?? value(`${name}.torque`)) / known.turn);
  }
}

// A moment as an arc about a point: its length is the share of the usual moment, three quarters of a turn at most.
export function drawMoment(p, at, share, radius = 22) {
  const sweep = Math.min(1.5, Math.abs(share)) * Math.PI;
  if (!(sweep > 0.5)) return;
  const way = Math.sign(share), { context } = p, x = p.X(at[0]), y = p.Y(at[1]), end = -Math.PI / 2 - way * sweep;
  context.strokeStyle = context.fillStyle = p.theme.curve(3);
  context.lineWidth = 2.6;
  context.beginPath();
  context.arc(x, y, radius, -Math.PI / 2, end + way * 0.2, way > 0);
  context.stroke();
  const tx = x + radius * Math.cos(end), ty = y + radius * Math.sin(end), back = end + way * 0.42;
  context.beginPath();
  context.moveTo(tx, ty);
  context.lineTo(x + (radius + 5) * Math.cos(back), y + (radius + 5) * Math.sin(back));
  context.lineTo(x + (radius - 5) * Math.cos(back), y + (radius - 5) * Math.sin(back));
  context.fill();
}

// What the legend says: [{text, length in pixels, colour}].
export function forceScale(p, known, side) {
  const found = [];
  if (known.scale > 0 && known.forces.length) {
    const step = niceStep(0.45 * known.scale), { factor, unit } = handyUnit("N", step);
    const length = (step / known.scale) * LONG * side, text = `${short(factor * step)} ${unit}`;
    if (known.forces.some((one) => one.kind === "joint")) found.push({ text: `${text} joint, on its second body`, length, colour: p.theme.black });
    if (known.forces.some((one) => one.kind !== "joint")) found.push({ text: `${text} spring, actuator`, length, colour: p.theme.curve(2) });
  }
  if (known.moments.length && known.turn > 0) {
    const { factor, unit } = handyUnit("N*m", known.turn);
    const step = niceStep(0.45 * factor * known.turn);
    found.push({ text: `${short(step)} ${unit} driver, load`, share: step / (factor * known.turn), colour: p.theme.curve(3) });
  }
  return found;
}
