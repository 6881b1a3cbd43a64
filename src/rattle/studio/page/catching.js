// What a hand catches on the sheet: a point of the mechanism, the line of a bar, the grid; and what lies under it.

export const NEAR = { mouse: 12, touch: 24 }; // pixels

const distance = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);

// The place on a line of the screen that is nearest, as a share from p to q, and how far it is.
function onLine(at, p, q) {
  const [ux, uy] = [q[0] - p[0], q[1] - p[1]], share = Math.max(0, Math.min(1, ((at[0] - p[0]) * ux + (at[1] - p[1]) * uy) / (ux * ux + uy * uy || 1)));
  return { share, far: distance(at, [p[0] + share * ux, p[1] + share * uy]) };
}

export class Catcher {
  constructor(board) { this.board = board; }

  // Points within reach, the nearest first; of those at one place points of the ground first.  without: names to pass over.
  points(at, within, without = []) {
    const { board } = this, found = [];
    for (const name of Object.keys(board.drawing?.points ?? {})) {
      const spot = without.includes(name) ? null : board.position(name);
      if (!spot) continue;
      const far = distance(at, board.onCanvas(spot));
      if (far <= within) found.push({ name, spot, far });
    }
    const rank = (one) => Math.round(one.far * 4) / 4 - (one.name.startsWith("ground.") ? 0.1 : 0);
    return found.sort((a, b) => rank(a) - rank(b));
  }

  // Bars within reach, the nearest first: {body, spot, far}.
  lines(at, within, without = []) {
    const { board } = this, found = [];
    for (const [body, ends] of Object.entries(board.drawing?.bars ?? {})) {
      const spots = without.includes(body) ? [null] : ends.map((end) => board.position(end));
      if (!spots.every(Boolean)) continue;
      const { share, far } = onLine(at, ...spots.map((spot) => board.onCanvas(spot)));
      if (far <= within) found.push({ body, far, spot: [0, 1].map((k) => spots[0][k] + share * (spots[1][k] - spots[0][k])) });
    }
    return found.sort((a, b) => a.far - b.far);
  }

  // The body under a place of the screen: a bar, a plate, or another body near its points; null if there is none.
  body(at, within) {
    const line = this.lines(at, within)[0];
    if (line) return line.body;
    const { board } = this, [x, y] = board.inPlane(at);
    for (const [body, form] of Object.entries(board.geometry.bodies)) {
      const place = board.placeOf(body);
      if (!place || board.drawing.bars[body]) continue;
      const spot = [place.cos * (x - place.x) + place.sin * (y - place.y), -place.sin * (x - place.x) + place.cos * (y - place.y)];
      if (form.outline?.length ? inside(form.outline[0], spot) : nearOutline(board, body, form, at, within)) return body;
    }
    return null;
  }

  // What a tool catches: {at, point?, line?, words}; lines: whether bars are caught too.
  catch(at, { within, lines = false, free = false, without = [], bodies = [] } = {}) {
    const { board } = this, bare = board.inPlane(at);
    if (free) return { at: bare, words: "" };
    const point = this.points(at, within, without)[0];
    if (point) return { at: point.spot, point: point.name, words: point.name };
    const line = lines ? this.lines(at, within, bodies)[0] : null;
    if (line) return { at: line.spot, line: line.body, words: line.body };
    return { at: board.onGrid(bare), words: "" };
  }

  // All points that joints put at the place of this one; a block is where it is drawn on its guide.
  joined(name) {
    const group = [name];
    for (let k = 0; k < group.length; k++) {
      for (const { together, ends } of this.board.drawing.joints) {
        if (together && ends.includes(group[k])) group.push(...ends.filter((end) => !group.includes(end)));
      }
    }
    return group;
  }

  // Joints at a point, those with the ground first.
  jointsAt(name) {
    const group = this.joined(name), onGround = (one) => one.ends.some((end) => end.startsWith("ground."));
    return this.board.drawing.joints.filter(({ ends }) => ends.some((end) => group.includes(end))).sort((a, b) => onGround(b) - onGround(a));
  }
}

function inside(ring, [x, y]) {
  let odd = false;
  for (let k = 0, n = ring.length - 1; k < ring.length; n = k++) {
    const [ax, ay] = ring[k], [bx, by] = ring[n];
    if ((ay > y) !== (by > y) && x < ax + (y - ay) * (bx - ax) / (by - ay)) odd = !odd;
  }
  return odd;
}

// Bodies of points alone are drawn as lines between them, a block as a small box.
function nearOutline(board, body, form, at, within) {
  const spots = Object.keys(form.points).map((point) => board.onCanvas(board.position(`${body}.${point}`)));
  return spots.some((spot, k) => distance(at, spot) <= 1.5 * within || (k > 0 && onLine(at, spots[k - 1], spot).far <= within));
}
