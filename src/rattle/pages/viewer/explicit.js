// One step of an explicit Runge-Kutta method, and the state inside it: the steppers of rattle, number for number.
//
// s is the state of a run, see engine.js: s.y, s.f at the start of the step, s.yNew at its end, s.k slopes of the
// stages.  A step returns its error as a share of the tolerance (Infinity where a stage cannot be computed).
// The coefficients come with the model, see solvers/tableau.py.

// stage = y + h * (sum of coefficients times slopes)
function stageOf(s, h, [from, weights]) {
  const { stage, y, k, ny } = s;
  stage.fill(0);
  for (let j = 0; j < from.length; j++) {
    const slope = k[from[j]], weight = weights[j];
    for (let n = 0; n < ny; n++) stage[n] += weight * slope[n];
  }
  for (let n = 0; n < ny; n++) stage[n] = y[n] + h * stage[n];
}

function weighted(s, [from, weights], out) {
  out.fill(0);
  for (let j = 0; j < from.length; j++) {
    const slope = s.k[from[j]], weight = weights[j];
    for (let n = 0; n < s.ny; n++) out[n] += weight * slope[n];
  }
}

/** One step of the method: see solvers/explicit.py. */
export function stepExplicit(s, t, h) {
  const { A, C, ends, stages } = s.tableau, { y, yNew, k, controlled, dense } = s;
  k[0].set(s.f);
  for (let i = 1; i < stages; i++) {
    stageOf(s, h, A[i]);
    if (s.tame) s.project(t + C[i] * h, s.stage);
    if (!s.rates(t + C[i] * h, s.stage, k[i])) return Infinity;
  }
  const errors = [dense[5], dense[6]].slice(0, ends.length - 1), sums = [0, 0];
  weighted(s, ends[0], yNew);
  errors.forEach((row, e) => weighted(s, ends[1 + e], row));
  let finite = true;
  for (let n = 0; n < s.ny; n++) {
    yNew[n] = y[n] + h * yNew[n];
    finite = finite && Math.abs(yNew[n]) < Infinity;
  }
  if (errors.length === 0) return finite ? 0 : Infinity;
  for (let c = 0; c < controlled.length; c++) {
    const n = controlled[c], scale = s.atol + s.rtol * Math.max(Math.abs(y[n]), Math.abs(yNew[n]));
    errors.forEach((row, e) => (sums[e] += (row[n] / scale) ** 2));
  }
  const error = (Math.abs(h) * sums[0]) / Math.sqrt((sums[0] + 0.01 * sums[1]) * s.nm + 1e-300);
  return error < Infinity ? error : Infinity;
}

/** x^(1/power): square roots as far as they go. */
export function rootOf(x, power) {
  for (; power % 2 === 0; power /= 2) x = Math.sqrt(x);
  return power === 1 ? x : x ** (1 / power);
}

/** The polynomial of the step from (t, y) to (t + h, yNew): cubic, and the further terms of the method. */
export function prepareDense(s, t, h) {
  const { y, f, yNew, fNew, dense, ny, k } = s;
  for (let n = 0; n < ny; n++) {
    const jump = yNew[n] - y[n];
    dense[0][n] = jump;
    dense[1][n] = h * f[n] - jump;
    dense[2][n] = 2 * jump - h * (fNew[n] + f[n]);
  }
  for (let row = 3; row < 7; row++) dense[row].fill(0);
  const { A, C, D, stages } = s.tableau;
  if (C.length > stages) k[stages].set(fNew);
  for (let i = stages + 1; i < C.length; i++) {
    stageOf(s, h, A[i]);
    if (!s.rates(t + C[i] * h, s.stage, k[i])) return; // the cubic is what is left
  }
  for (let row = 0; row < D.length; row++) {
    weighted(s, D[row], dense[3 + row]);
    for (let n = 0; n < ny; n++) dense[3 + row][n] *= h;
  }
}

/** The state at a share of the step, into out. */
export function interpolate(s, share, out) {
  const { y, dense, ny } = s, rest = 1 - share;
  for (let n = 0; n < ny; n++) {
    const value = (dense[4][n] + (dense[5][n] + dense[6][n] * share) * rest) * share;
    out[n] =
      y[n] + (dense[0][n] + (dense[1][n] + (dense[2][n] + (dense[3][n] + value) * rest) * share) * rest) * share;
  }
}
