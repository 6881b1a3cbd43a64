// Feet of what is fixed to the ground.

const FOOT = 0.05; // size of a foot, as a share of the mechanism's size

export function footSize(stage, p) {
  return Math.max(9, Math.min(26, FOOT * stage.size * p.view.scale));
}

// Feet of those ends of a joint or load that are on the ground.
export function feet(stage, form) {
  return form.bodies.flatMap((body, k) =>
    body === "ground" ? [{ z: 1, draw: (p) => p.foot(form.points[k], footSize(stage, p)) }] : []);
}
