// Primitives of a drawing (rattle/drawings/sheet.py) played on a canvas: paths with lines and areas, marks, walls.

import { mix } from "./colours.js";

const CORNER = Array.from({ length: 9 }, (_, k) => k / 8); // of the turn at a round corner
const END = Array.from({ length: 17 }, (_, k) => (Math.PI * (k + 1)) / 18); // directions of a round end
const polarFrom = ([x, y], r, angle) => [x + r * Math.cos(angle), y + r * Math.sin(angle)];

// Points of a path in its frame, null between strokes; thin: of bars their middle lines.
function pathNow(values, pieces, thin) {
  return pieces.flatMap((piece) => {
    if (piece === null) return [null];
    if (Array.isArray(piece)) return [piece.map((place) => values.get(place))];
    if (piece.arc) return arcNow(piece.arc.map((place) => values.get(place)), piece.count);
    if (piece.trail) return trailNow(values, piece);
    if (piece.of) return piece.of.reduce((entry, key) => entry?.[key] ?? [], values.stage.geometry).filter((_, k) => k % piece.every === 0);
    if (piece.around) return around(pathNow(values, piece.around), values.get(piece.half));
    if (piece.grown) return grown(pathNow(values, piece.grown), thin ? 0 : values.get(piece.half));
    const path = pathNow(values, piece.path), shift = values.get(piece.shift), turn = values.get(piece.turn);
    return Array.from({ length: Math.max(0, Math.round(values.get(piece.copies))) || 0 }, (_, k) => path.map((point) => point && turned(point, k * shift, k * turn))).flat();
  });
}

// Where a pin was up to now.
function trailNow(values, { trail, share, scale }) {
  const { stage: { motion }, time } = values, { x, y } = motion.pinPath(trail), { n } = motion.pinAt(trail, time), times = values.get(scale);
  const from = Math.max(0, n - Math.ceil(share * x.length));
  return Array.from({ length: n + 1 - from }, (_, k) => [times * x[from + k], times * y[from + k]]);
}

function turned([x, y], shift, turn) {
  const c = Math.cos(turn), s = Math.sin(turn);
  return [c * (x + shift) - s * y, s * (x + shift) + c * y];
}

function arcNow([x, y, radius, last, start, end], count) {
  return Array.from({ length: count }, (_, k) => {
    const share = k / (count - 1);
    return polarFrom([x, y], radius + share * (last - radius), start + share * (end - start));
  });
}

// The outline of what lies at most so far from a path, with round ends.
function around(path, half) {
  const last = path.length - 1, angles = path.map((_, k) => {
    const [x, y] = path[Math.max(0, k - 1)], [u, v] = path[Math.min(last, k + 1)];
    return Math.atan2(v - y, u - x);
  });
  const side = (turn) => path.map((point, k) => polarFrom(point, half, angles[k] + turn)), right = side(-Math.PI / 2), left = side(Math.PI / 2);
  const end = (k, turn) => END.map((angle) => polarFrom(path[k], half, angles[k] + turn + angle));
  return [...right, ...end(last, -Math.PI / 2), ...left.reverse(), ...end(0, Math.PI / 2)];
}

// The outline of what lies at most so far from the convex hull of points.
function grown(points, by) {
  const wide = Math.max(...[0, 1].map((k) => Math.max(...points.map((point) => point[k])) - Math.min(...points.map((point) => point[k]))));
  if (wide <= 1e-9 * by) return arcNow([...points[0], by, by, 0, 2 * Math.PI], 25);
  const corners = hull(points), n = corners.length;
  if (!by) return corners;
  const way = corners.map(([x, y], k) => Math.atan2(corners[(k + 1) % n][1] - y, corners[(k + 1) % n][0] - x) - Math.PI / 2);
  return corners.flatMap((corner, k) => {
    const from = way[(k + n - 1) % n], turn = way[k] - from;
    return CORNER.map((share) => polarFrom(corner, by, from + share * (turn - 2 * Math.PI * Math.floor(turn / (2 * Math.PI)))));
  });
}

// Corners of the convex hull of points, counter-clockwise; two if all are on one line.
export function hull(points) {
  const ordered = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const corners = [];
  for (const way of [ordered, [...ordered].reverse()]) {
    const side = [];
    for (const [x, y] of way) {
      while (side.length > 1) {
        const [ax, ay] = side[side.length - 2], [bx, by] = side[side.length - 1];
        if ((bx - ax) * (y - ay) - (by - ay) * (x - ax) > 0) break;
        side.pop();
      }
      side.push([x, y]);
    }
    corners.push(...side.slice(0, -1));
  }
  return corners;
}

function movesIn(values, pieces) {
  return pieces.some((piece) => {
    if (!piece || piece.of) return false;
    if (piece.trail) return true;
    const places = Array.isArray(piece) ? piece : [...(piece.arc ?? []), piece.half, piece.copies, piece.shift, piece.turn];
    return places.some((place) => values.moves[place]) || movesIn(values, piece.around ?? piece.grown ?? piece.path ?? []);
  });
}

// A function of the bodies as they are: points of a path [m] in the world.
export function placed(values, frame, path, thin = false) {
  const still = movesIn(values, path) ? null : pathNow(values, path, thin);
  const own = typeof frame === "string" ? null : frame;
  return () => {
    const points = still ?? pathNow(values, path, thin);
    const [x, y, angle, stretch] = own ? own.map((place) => values.get(place)) : values.frame(frame);
    const cos = Math.cos(angle), sin = Math.sin(angle);
    return points.map((point) => point && [x + cos * stretch * point[0] - sin * point[1], y + sin * stretch * point[0] + cos * point[1]]);
  };
}

// What draws a primitive of a stage on a painter, as the values of the stage are set.
export function player(stage, primitive) {
  const { values } = stage, { draw, frame, width, radius } = primitive;
  const rings = (primitive.rings ?? [primitive.path]).map((ring) => placed(values, frame, ring));
  return (p) => {
    if (primitive.when !== undefined && !(values.get(primitive.when) > 0)) return;
    const colour = colourOf(p.theme, primitive.line), fill = colourOf(p.theme, primitive.fill), paths = rings.map((ring) => ring());
    if (draw === "wall") p.wall(...paths[0], { stroke: values.get(primitive.stroke) / p.metres(1), colour, width });
    else if (draw === "text") p.tag(primitive.text, paths[0][0], { colour, bold: primitive.bold });
    else if (draw === "dot" && primitive.square) p.square(paths[0][0], radius, fill);
    else if (draw === "dot") p.dot(paths[0][0], radius, { colour, width, fill });
    else {
      if (fill) p.plate(paths, fill, primitive.opacity);
      if (colour) for (const path of paths) p.line(path, { colour, width, dash: primitive.dash, closed: primitive.closed, cap: primitive.butt ? "butt" : "round" });
    }
  };
}

function colourOf(theme, colour) {
  if (!colour) return null;
  const [name, paper] = colour, own = name.startsWith("body ") ? theme.body(name.slice(5)) : theme[name];
  return paper ? mix(own, theme.paper, paper) : own;
}

// What draws a body of another motion: its outline alone.
export function ghostPlayer(stage, primitive, style) {
  const rings = primitive.rings.map((ring) => placed(stage.values, primitive.frame, ring, true));
  return (p) => {
    const colour = style.own ? mix(p.theme.body(primitive.body), p.theme.ink, 0.45) : p.theme.ink;
    const line = { colour, width: 1.8, dash: style.dash, opacity: 0.8 };
    for (const points of rings.map((ring) => ring())) p.line(points, { ...line, closed: points.length > 2 });
  };
}
