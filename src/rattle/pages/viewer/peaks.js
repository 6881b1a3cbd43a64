// Largest forces, moments and powers of a run within its steps: at outputs, at the ends of steps, and between these where
// the curve is smooth.

const QUANTITIES = new Set(["N", "N*m", "W"]); // units of what peaks are looked for
const SMOOTH = 0.1; // share of the range of five samples by which a parabola through the middle three may miss the outer two

// names, units: of the columns of a row.  add(t, row) takes rows in the order of time.
export class Peaks {
  constructor(names, units) {
    const column = new Map(names.map((name, c) => [name, c])), forces = names.filter((name) => name.endsWith(".fx"))
      .map((name) => ({ name: `${name.slice(0, -3)}.force`, of: [column.get(name), column.get(`${name.slice(0, -1)}y`)] }));
    const single = names.filter((name, c) => QUANTITIES.has(units[c]) && name.includes(".") && !/\.f[xy]$/.test(name));
    this.every = [...forces, ...single.map((name) => ({ name, of: [column.get(name)] }))]
      .map((one) => ({ ...one, near: [], best: 0, at: 0, sign: 1 }));
  }

  add(t, row) {
    for (const one of this.every) {
      const value = one.of.length === 2 ? Math.hypot(row[one.of[0]], row[one.of[1]]) : row[one.of[0]], { near } = one;
      if (!Number.isFinite(value) || (near.length && t <= near[near.length - 1][0])) continue;
      const sign = value < 0 ? -1 : 1;
      if (sign * value > one.best) Object.assign(one, { best: sign * value, at: t, sign });
      near.push([t, sign * value]);
      if (near.length > 5) near.shift();
      if (near.length === 5 && near[2][1] === one.best) climb(one);
    }
  }

  // By name the largest magnitude with its sign, and when it is there.
  found() {
    return Object.fromEntries(this.every.filter((one) => one.best > 0).map((one) => [one.name, [one.sign * one.best, one.at]]));
  }
}

// The crest of the parabola through the middle three of five samples, where it fits the outer two as well.
function climb(one) {
  const [[t, top]] = one.near.slice(2), [a, b, , d, e] = one.near.map(([at, value]) => [at - t, value - top]);
  const bend = (d[1] / d[0] - b[1] / b[0]) / (d[0] - b[0]), slope = b[1] / b[0] - bend * b[0];
  const miss = ([at, value]) => Math.abs((bend * at + slope) * at - value);
  const range = -Math.min(a[1], b[1], d[1], e[1]);
  if (!(bend < 0) || Math.max(miss(a), miss(e)) > SMOOTH * range) return;
  Object.assign(one, { best: top - (slope * slope) / (4 * bend), at: t - slope / (2 * bend) });
}
