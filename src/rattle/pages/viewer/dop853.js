// One step of an explicit Runge-Kutta method, and the state inside it: the steppers of rattle, number for number.
//
// s is the state of a run, see engine.js: s.y, s.f at the start of the step, s.yNew at its end, s.k slopes of the
// stages.  A step returns its error as a share of the tolerance (Infinity where a stage cannot be computed).
// The coefficients come with the model: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, II.10.

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

/** Dormand-Prince 8(5, 3). */
export function stepDop853(s, t, h) {
  const { A, B, C, E3, E5 } = s.tableau, { y, yNew, k, controlled } = s;
  k[0].set(s.f);
  for (let i = 1; i < 12; i++) {
    stageOf(s, h, A[i]);
    if (s.tame) s.project(t + C[i] * h, s.stage);
    if (!s.rates(t + C[i] * h, s.stage, k[i])) return Infinity;
  }
  const third = k[13], fifth = k[14];
  weighted(s, B, yNew);
  weighted(s, E3, third);
  weighted(s, E5, fifth);
  for (let n = 0; n < s.ny; n++) yNew[n] = y[n] + h * yNew[n];
  let error3 = 0, error5 = 0;
  for (let c = 0; c < controlled.length; c++) {
    const n = controlled[c], scale = s.atol + s.rtol * Math.max(Math.abs(y[n]), Math.abs(yNew[n]));
    error3 += (third[n] / scale) ** 2;
    error5 += (fifth[n] / scale) ** 2;
  }
  if (error5 === 0 && error3 === 0) return 0;
  const error = (Math.abs(h) * error5) / Math.sqrt((error5 + 0.01 * error3) * s.nm);
  return error < Infinity ? error : Infinity;
}

/** The classical method of order 4: no error estimate. */
export function stepRk4(s, t, h) {
  const { y, yNew, k, stage, ny } = s;
  k[0].set(s.f);
  for (let i = 1; i < 4; i++) {
    const share = i === 3 ? 1 : 0.5, slope = k[i - 1];
    for (let n = 0; n < ny; n++) stage[n] = y[n] + share * h * slope[n];
    if (!s.rates(t + share * h, stage, k[i])) return Infinity;
  }
  let finite = true;
  for (let n = 0; n < ny; n++) {
    yNew[n] = y[n] + (h / 6) * (k[0][n] + 2 * k[1][n] + 2 * k[2][n] + k[3][n]);
    finite = finite && Math.abs(yNew[n]) < Infinity;
  }
  return finite ? 0 : Infinity;
}

/** The polynomial of the step from (t, y) to (t + h, yNew): cubic, and for Dormand-Prince four terms more. */
export function prepareDense(s, t, h) {
  const { y, f, yNew, fNew, dense, ny, k } = s;
  for (let n = 0; n < ny; n++) {
    const jump = yNew[n] - y[n];
    dense[0][n] = jump;
    dense[1][n] = h * f[n] - jump;
    dense[2][n] = 2 * jump - h * (fNew[n] + f[n]);
  }
  for (let row = 3; row < 7; row++) dense[row].fill(0);
  if (s.method !== "dop853") return;
  const { A, C, D } = s.tableau;
  k[12].set(fNew);
  for (let i = 13; i < 16; i++) {
    stageOf(s, h, A[i]);
    if (!s.rates(t + C[i] * h, s.stage, k[i])) return; // the cubic is what is left
  }
  for (let row = 0; row < 4; row++) {
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
