"""What stands after the functions in the module of a live page; `live_program` puts in what stands in @...@ here."""

LIVE = """
// rates at the start of the mechanism without play, where those of this one follow from them
let startOfIdeal = null;
export const needsIdeal = @needs@;
export function setIdeal(start) {
  startOfIdeal = start;
}
function beside(p) {
  const ideal = startOfIdeal(Object.fromEntries(sliders.map((one, k) => [one.name, p[k]]))), nq = 3 * layout.nb;
  return ideal.subarray(nq, 2 * nq);
}
export { values };
export const inputs = input.length;
export const layout = @layout@;
export const functions = { @functions@ };

// the drawing: numbers that follow from parameters are put in at their places
const drawn = @drawing@, places = @places@, sizes_ = new Float64Array(Math.max(1, places.length));

/** Everything that a drawing needs to know of the mechanism for parameters p, as `geometry(model)` gives it. */
export function geometry(p) {
  const made = structuredClone(drawn);
  put(0, ownStart, values(p));
  if (places.length) functions.geometry(input, sizes_);
  places.forEach((place, k) => {
    let inner = made;
    for (const key of place.slice(0, -1)) inner = inner[key];
    inner[place.at(-1)] = sizes_[k];
  });
  return made;
}
"""
