// Bodies: bars and plates with round corners in their colours, outlines as they are, and pale copies of another motion.

import { mix } from "./colours.js";
import { pointAt } from "./data.js";

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

// How a body is drawn: {rings} of a plate, {points} of a bar or hull, or {spot} for a single point.
export function shapeOf(stage, body) {
  const rings = stage.rings(body);
  if (rings.length) return { rings };
  let points = [...stage.points(body), ...stage.held(body)];
  if (points.length < 2) points = [...points, [0, 0]];
  const wide = Math.max(...[0, 1].map((k) => Math.max(...points.map((p) => p[k])) - Math.min(...points.map((p) => p[k]))));
  if (wide < 1e-9 * stage.size) return { spot: points[0] };
  return { points: points.length > 2 ? hull(points) : points };
}

export function barWidth(stage, p) {
  return Math.max(5, Math.min(15, 0.026 * stage.size * p.view.scale));
}

// What draws one body.
export function drawBody(stage, body) {
  const shape = shapeOf(stage, body);
  return [{ z: 3, body, draw: (p, pose) => paintShape(p, stage, shape, pose, body) }];
}

function paintShape(p, stage, shape, pose, body) {
  const colour = p.theme.body(body), tint = mix(colour, p.theme.paper, p.theme.dark ? 0.58 : 0.6);
  if (shape.rings) {
    const rings = shape.rings.map((ring) => ring.map((point) => pointAt(pose, body, point)));
    p.plate(rings, tint, 0.75);
    for (const ring of rings) p.line(ring, { colour, width: 1.8, closed: true });
  } else if (shape.spot) {
    p.dot(pointAt(pose, body, shape.spot), 7.5, { colour, fill: tint, width: 1.8 });
  } else {
    const path = shape.points.map((point) => pointAt(pose, body, point)), width = barWidth(stage, p);
    if (path.length > 2) paintPlate(p, path, width, colour, tint);
    else {
      p.line(path, { colour, width });
      p.line(path, { colour: tint, width: width - 3 });
    }
  }
}

// A plate with round corners through which one sees a little of what lies behind.
function paintPlate(p, path, width, colour, tint) {
  const grown = rounded(path, p.metres(width / 2));
  p.area(grown, tint, 0.78);
  p.line(grown, { colour, width: 1.6, closed: true });
}

// The outline of a convex polygon, counter-clockwise, that is larger by a distance to all sides.
export function rounded(corners, by) {
  const outline = [];
  corners.forEach(([x, y], k) => {
    const [px, py] = corners[(k + corners.length - 1) % corners.length], [qx, qy] = corners[(k + 1) % corners.length];
    const from = Math.atan2(y - py, x - px) - Math.PI / 2;
    let turn = Math.atan2(qy - y, qx - x) - Math.PI / 2 - from;
    turn -= 2 * Math.PI * Math.floor(turn / (2 * Math.PI));
    for (let i = 0; i <= 8; i++) outline.push([x + by * Math.cos(from + (turn * i) / 8), y + by * Math.sin(from + (turn * i) / 8)]);
  });
  return outline;
}

// A body of another motion: its outline alone.
export function drawGhost(stage, body, style) {
  const shape = shapeOf(stage, body);
  return {
    draw(p, pose) {
      const colour = style.own ? mix(p.theme.body(body), p.theme.ink, 0.45) : p.theme.ink;
      const line = { colour, width: 1.8, dash: style.dash, opacity: 0.8 };
      const paths = shape.rings ?? [shape.points ?? [shape.spot]];
      for (const path of paths) {
        const points = path.map((point) => pointAt(pose, body, point));
        if (points.length === 1) p.dot(points[0], 7, { colour: line.colour, fill: null, width: 1.4 });
        else p.line(points, { ...line, closed: points.length > 2 });
      }
    },
  };
}
