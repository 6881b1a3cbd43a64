// Drawing on a canvas in metres: lines, areas, marks of fixed size, the ground.

// A canvas of these CSS pixels, sharp on every screen; returns its context.
export function sized(canvas, width, height) {
  const ratio = Math.min(globalThis.devicePixelRatio || 1, 3);
  const w = Math.max(1, Math.round(width * ratio)), h = Math.max(1, Math.round(height * ratio));
  if (canvas.width !== w || canvas.height !== h) {
    canvas.width = w;
    canvas.height = h;
  }
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  context.lineJoin = "round";
  return context;
}

export const FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif";

export class Painter {
  // view: {scale [px/m], x, y}: where the origin is, in pixels
  constructor(context, view, theme) {
    this.context = context;
    this.view = view;
    this.theme = theme;
  }

  X(x) { return this.view.x + this.view.scale * x; }
  Y(y) { return this.view.y - this.view.scale * y; }
  metres(pixels) { return pixels / this.view.scale; }

  // Lines through points [m]; null between strokes.
  trail(points) {
    const { context } = this;
    context.beginPath();
    let down = false;
    for (const point of points) {
      if (!point || !Number.isFinite(point[0] + point[1])) { down = false; continue; }
      if (down) context.lineTo(this.X(point[0]), this.Y(point[1]));
      else context.moveTo(this.X(point[0]), this.Y(point[1]));
      down = true;
    }
  }

  line(points, { colour = this.theme.black, width = 1.2, dash = null, cap = "round", opacity = 1, closed = false } = {}) {
    const { context } = this;
    this.trail(points);
    if (closed) context.closePath();
    context.lineWidth = width;
    context.strokeStyle = colour;
    context.lineCap = cap;
    context.globalAlpha = opacity;
    if (dash) context.setLineDash(dash);
    context.stroke();
    if (dash) context.setLineDash([]);
    context.globalAlpha = 1;
  }

  // A filled area of one or several rings, the further ones holes.
  plate(rings, colour, opacity = 1) {
    const { context } = this;
    context.beginPath();
    for (const ring of rings) {
      ring.forEach(([x, y], k) => (k ? context.lineTo(this.X(x), this.Y(y)) : context.moveTo(this.X(x), this.Y(y))));
      context.closePath();
    }
    context.fillStyle = colour;
    context.globalAlpha = opacity;
    context.fill("evenodd");
    context.globalAlpha = 1;
  }

  // A circle, its radius in metres.
  circle([x, y], radius, { colour = null, width = 1.2, fill = null, opacity = 1 } = {}) {
    this.round(this.X(x), this.Y(y), Math.abs(radius) * this.view.scale, { colour, width, fill, opacity });
  }

  // A mark of fixed size: radius in pixels.
  dot([x, y], radius, { colour = this.theme.black, width = 1.4, fill = this.theme.paper, opacity = 1 } = {}) {
    this.round(this.X(x), this.Y(y), radius, { colour, width, fill, opacity });
  }

  round(x, y, radius, { colour, width, fill, opacity }) {
    if (!Number.isFinite(x + y + radius)) return;
    const { context } = this;
    context.beginPath();
    context.arc(x, y, radius, 0, 2 * Math.PI);
    context.globalAlpha = opacity;
    if (fill) { context.fillStyle = fill; context.fill(); }
    if (colour) {
      context.strokeStyle = colour;
      context.lineWidth = width;
      context.stroke();
    }
    context.globalAlpha = 1;
  }

  square([x, y], half, fill) {
    this.context.fillStyle = fill;
    this.context.fillRect(this.X(x) - half, this.Y(y) - half, 2 * half, 2 * half);
  }

  // Text beside a point, on a little paper so that lines do not cross it; offsets in pixels.  Returns the box of the paper: [left, top, width, height].
  tag(text, [x, y], { dx = 10, dy = -10, colour = this.theme.ink, size = 12, bold = false } = {}) {
    const { context } = this;
    context.font = `${bold ? 600 : 400} ${size}px ${FONT}`;
    const width = context.measureText(text).width, room = context.canvas.clientWidth - this.X(x) - dx;
    const left = this.X(x) + (room < width ? -dx - width : dx), base = this.Y(y) + dy;
    context.globalAlpha = 0.85;
    context.fillStyle = this.theme.paper;
    const box = [left - 2, base - size + 1, width + 4, size + 3];
    context.fillRect(...box);
    context.globalAlpha = 1;
    context.fillStyle = colour;
    context.textAlign = "left";
    context.textBaseline = "alphabetic";
    context.fillText(text, left, base);
    return box;
  }

  // The scale of a drawing at its lower left: a bar of this many pixels with its length in words.
  scaleBar(text, long, height, colour = this.theme.ink) {
    const { context } = this, [left, y] = [16, height - 14];
    context.strokeStyle = context.fillStyle = colour;
    context.lineWidth = 1.6;
    context.lineCap = "butt";
    context.beginPath();
    context.moveTo(left, y - 5);
    context.lineTo(left, y);
    context.lineTo(left + long, y);
    context.lineTo(left + long, y - 5);
    context.stroke();
    context.font = `12px ${FONT}`;
    context.textAlign = "center";
    context.fillText(text, left + long / 2, y - 7);
  }

  // A line of the ground, hatched on its right hand; stroke: length of a hatch in pixels.
  wall(a, b, { stroke = 8, colour = this.theme.black, width = 1.4 } = {}) {
    const length = Math.hypot(b[0] - a[0], b[1] - a[1]);
    if (!(length > 0)) return;
    const u = [(b[0] - a[0]) / length, (b[1] - a[1]) / length], s = this.metres(stroke) / Math.SQRT2;
    const count = Math.max(3, Math.min(80, Math.round((length * this.view.scale) / (0.8 * stroke))));
    const strokes = [];
    for (let k = 0; k < count; k++) {
      const x = a[0] + ((k + 0.5) / count) * length * u[0], y = a[1] + ((k + 0.5) / count) * length * u[1];
      strokes.push([x, y], [x + s * (u[1] - u[0]), y + s * (-u[0] - u[1])], null);
    }
    this.line(strokes, { colour, width: 0.8, opacity: 0.8 });
    this.line([a, b], { colour, width });
  }
}
