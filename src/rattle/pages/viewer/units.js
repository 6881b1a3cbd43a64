// Numbers for people: handy units as in the Python plots, ticks, and texts whose width does not jump.

const DEGREES = 180 / Math.PI;
const FINER = 8; // steps by which an axis without two labels is divided more finely, enough for any range
const TURNED = { rad: "deg", "rad/s": "deg/s", "rad/s^2": "deg/s²" };
const PREFIXED = { N: 2e4, W: 2e4, J: 2e4, "N*m": 2e4, Pa: 1e4 }; // from where on thousands are written with a prefix
export const QUANTITY = {
  s: "time", m: "length", rad: "angle", N: "force", "N*m": "moment", Pa: "pressure", "m/s": "speed",
  "rad/s": "angular rate", "m/s^2": "acceleration", "rad/s^2": "angular acceleration", J: "energy", W: "power",
};

export function printed(unit) {
  return unit.replaceAll("*", "·").replaceAll("^2", "²").replaceAll("^3", "³");
}

// Factor from the SI unit and the unit in which a quantity of this size is shown.
export function handyUnit(unit, size) {
  if (unit in TURNED) return { factor: DEGREES, unit: TURNED[unit] };
  if (unit === "m" && size > 0 && size < 1e-4) return { factor: 1e6, unit: "µm" };
  if (unit === "m" && size > 0 && size < 0.05) return { factor: 1e3, unit: "mm" };
  if (unit in PREFIXED && size >= PREFIXED[unit]) {
    if (size >= 1000 * PREFIXED[unit] || (unit === "Pa" && size >= 1e5)) return { factor: 1e-6, unit: `M${printed(unit)}` };
    return { factor: 1e-3, unit: `k${printed(unit)}` };
  }
  if (unit === "J" && size > 0 && size < 0.05) return { factor: 1e3, unit: "mJ" };
  return { factor: 1, unit: printed(unit) };
}

// Lengths of a drawing: mm below 0.2 m, else m.
export function drawingUnit(span) {
  return span < 2e-4 ? { factor: 1e6, unit: "µm" } : span < 0.2 ? { factor: 1e3, unit: "mm" } : { factor: 1, unit: "m" };
}

// Factor and unit in which a clearance is a handy number.
export function clearanceUnit(clearance) {
  return clearance >= 1e-4 ? { factor: 1e3, unit: "mm" } : { factor: 1e6, unit: "µm" };
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

// A function that writes numbers up to this size with constant width: figure spaces in front.
export function steady(most, digits = 4) {
  const size = Math.abs(most) || 1;
  const before = Math.max(1, Math.floor(Math.log10(size) + 1e-9) + 1);
  const wild = before > 7 || size < 1e-4;
  const after = wild ? digits - 2 : Math.max(0, Math.min(6, digits - before));
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
