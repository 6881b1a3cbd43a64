// Sliders of parameters, in pages and in the studio: steps from the least value to the largest, round in the unit shown.

export const STEPS = 400;

// The value [SI] at a step of the slider of a knob, exact at its ends and for its own value.
// knob: {min, max, value, factor}: in SI, and the size of the unit shown.
export function valueAt(knob, step) {
  const { min, max, value, factor } = knob;
  if (step <= 0 || step >= STEPS) return step > 0 ? max : min;
  if (step === stepOf(knob, value)) return value;
  const fine = 10 ** Math.ceil(Math.log10((max - min) / STEPS / factor) - 1e-9 - 0.5);
  return Number((Math.round((min + ((max - min) * step) / STEPS) / factor / fine) * fine).toPrecision(12)) * factor;
}

export function stepOf({ min, max }, value) {
  return max > min ? Math.round(Math.min(1, Math.max(0, (value - min) / (max - min))) * STEPS) : 0;
}
