// Curves that follow from stored ones: the same names and formulas as in rattle/results/derived.py.

const POINT = { x: "m", y: "m", vx: "m/s", vy: "m/s" };
const UNITS = { angle: "rad", position: "m", length: "m" };

// Rules {name: {unit, make(curve, n) -> array}} of the curves that stored columns (a Set of names) allow.
export function derivedRules(geometry, stored) {
  const found = new Map();
  for (const [body, form] of Object.entries(geometry.bodies ?? {})) {
    for (const [point, at] of Object.entries(form.points)) {
      for (const key of Object.keys(POINT)) {
        if (stored.has(`${body}.${key}`)) found.set(`${body}.${point}.${key}`, pointRule(body, at, key));
      }
    }
  }
  for (const [joint, form] of Object.entries(geometry.joints ?? {})) {
    if (stored.has(`${joint}.fx`)) found.set(`${joint}.force`, sizeRule(joint));
    if (form.coordinate) between(found, joint, form.coordinate, form, form.axis ?? 0, stored);
  }
  for (const [load, form] of Object.entries(geometry.loads ?? {})) {
    if (form.coordinate) ofLoad(found, load, form, stored);
  }
  for (const name of stored) found.delete(name);
  return found;
}

function ofLoad(found, load, form, stored) {
  between(found, load, form.coordinate, form, 0, stored);
  const turns = form.coordinate === "angle";
  if (turns && found.has(`${load}.angle`)) found.set(`${load}.length`, found.get(`${load}.angle`));
  if (!stored.has(`${load}.force`) || !found.has(`${load}.rate`)) return;
  const rate = found.get(`${load}.rate`);
  found.set(`${load}.power`, {
    unit: "W",
    make(curve, n) {
      const force = curve(`${load}.force`), speed = rate.make(curve, n);
      return each(n, (k) => form.power * force[k] * speed[k]);
    },
  });
  if (turns) found.set(`${load}.torque`, { unit: "N*m", make: (curve) => curve(`${load}.force`) });
}

function each(n, value) {
  const made = new Float64Array(n);
  for (let k = 0; k < n; k++) made[k] = value(k);
  return made;
}

function sizeRule(joint) {
  return {
    unit: "N",
    make(curve, n) {
      const fx = curve(`${joint}.fx`), fy = curve(`${joint}.fy`);
      return each(n, (k) => Math.hypot(fx[k], fy[k]));
    },
  };
}

function pointRule(body, at, key) {
  return { unit: POINT[key], make: (curve, n) => pointCurves(body, at, curve, n, key.startsWith("v"))[key.replace("v", "")] };
}

// Coordinates of a point over all rows, or of its velocity.
function pointCurves(body, [px, py], curve, n, rate) {
  if (body === "ground") return { x: each(n, () => (rate ? 0 : px)), y: each(n, () => (rate ? 0 : py)) };
  const angle = curve(`${body}.angle`);
  const right = (k) => Math.cos(angle[k]) * px - Math.sin(angle[k]) * py;
  const up = (k) => Math.sin(angle[k]) * px + Math.cos(angle[k]) * py;
  if (!rate) {
    const x = curve(`${body}.x`), y = curve(`${body}.y`);
    return { x: each(n, (k) => x[k] + right(k)), y: each(n, (k) => y[k] + up(k)) };
  }
  const w = curve(`${body}.omega`), vx = curve(`${body}.vx`), vy = curve(`${body}.vy`);
  return { x: each(n, (k) => vx[k] - w[k] * up(k)), y: each(n, (k) => vy[k] + w[k] * right(k)) };
}

function between(found, owner, coordinate, form, axis, stored) {
  const moving = form.bodies.filter((one) => one !== "ground");
  for (const [key, name, needs] of [["", coordinate, "x"], ["rate", "rate", "vx"]]) {
    if (!moving.every((one) => stored.has(`${one}.${needs}`))) continue;
    const unit = UNITS[coordinate] + (key ? "/s" : "");
    found.set(`${owner}.${name}`, { unit, make: (curve, n) => coordinateCurve(coordinate, key !== "", form, axis, curve, n) });
  }
}

function coordinateCurve(coordinate, rate, form, axis, curve, n) {
  const [a, b] = form.bodies;
  const zero = new Float64Array(n);
  const own = (body, key) => (body === "ground" ? zero : curve(`${body}.${key}`));
  if (coordinate === "angle") {
    const key = rate ? "omega" : "angle", of_a = own(a, key), of_b = own(b, key);
    return each(n, (k) => of_b[k] - of_a[k]);
  }
  const at_a = pointCurves(a, form.points[0], curve, n, false), at_b = pointCurves(b, form.points[1], curve, n, false);
  const dx = each(n, (k) => at_b.x[k] - at_a.x[k]), dy = each(n, (k) => at_b.y[k] - at_a.y[k]);
  if (coordinate === "length" && !rate) return each(n, (k) => Math.hypot(dx[k], dy[k]));
  const turned = own(a, "angle");
  const ux = each(n, (k) => Math.cos(turned[k] + axis)), uy = each(n, (k) => Math.sin(turned[k] + axis));
  if (!rate) return each(n, (k) => dx[k] * ux[k] + dy[k] * uy[k]);
  const v_a = pointCurves(a, form.points[0], curve, n, true), v_b = pointCurves(b, form.points[1], curve, n, true);
  const vx = each(n, (k) => v_b.x[k] - v_a.x[k]), vy = each(n, (k) => v_b.y[k] - v_a.y[k]);
  if (coordinate === "length") return each(n, (k) => (dx[k] * vx[k] + dy[k] * vy[k]) / Math.hypot(dx[k], dy[k]));
  const w = own(a, "omega");
  return each(n, (k) => vx[k] * ux[k] + vy[k] * uy[k] + w[k] * (dy[k] * ux[k] - dx[k] * uy[k]));
}
