// Values of knobs: steps of a slider, and numbers with their unit as a reader writes them.

const STEPS = 400;

// A value [SI] at a step of the slider of a knob, rounded to what can be read.
export function valueAt(knob, step) {
  const value = (knob.min + (step / STEPS) * (knob.max - knob.min)) / knob.factor;
  if (step <= 0) return knob.min;
  if (step >= STEPS) return knob.max;
  const grain = 10 ** Math.floor(Math.log10(Math.abs(knob.max - knob.min) / knob.factor / 200));
  const rounded = Math.round(value / grain) * grain;
  const digits = Math.max(0, -Math.floor(Math.log10(grain) + 1e-9));
  return Number(rounded.toFixed(Math.min(digits, 15))) * knob.factor;
}

export function stepOf(knob, value) {
  if (!(knob.max > knob.min)) return 0;
  return Math.round(Math.min(1, Math.max(0, (value - knob.min) / (knob.max - knob.min))) * STEPS);
}

export function shortNumber(value, digits = 6) {
  if (value === 0) return "0";
  const text = Number(value.toPrecision(digits));
  return Math.abs(text) >= 1e6 || Math.abs(text) < 1e-4 ? text.toExponential().replace("e+", "e") : String(text);
}

export function shown(knob, value) {
  return `${shortNumber(value / knob.factor)} ${knob.unit}`.trim();
}

// What is written into the model for a value [SI]: a number, or a text with its unit.
export function written(knob, value) {
  return knob.unit ? shown(knob, value) : Number(shortNumber(value, 10));
}
