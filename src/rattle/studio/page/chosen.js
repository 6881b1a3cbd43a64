// Marks on the sheet: what is chosen, with its main value beside it, lines that were measured, and where a loop stays open.

export const FIELDS_FIRST = ["Length", "Play", "Speed", "X", "Force", "Stiffness"]; // the main value: into it digits go

export class Chosen {
  constructor(edit) {
    this.edit = edit;
    this.box = null; // of the label, in pixels of the sheet
    edit.board.marks.unshift((p) => this.draw(p));
  }

  draw(p) {
    const { board, drawing, things, lines } = this.edit, { theme } = board;
    this.box = null;
    lines.forEach((line, k) => p.line(line.map((at) => (at[0] === null ? null : at)), { colour: theme.curve(k), width: 2 }));
    if (!drawing || board.running) return;
    for (const thing of things) {
      const [kind, name] = thing.split(/ (.*)/s);
      if (kind === "body") this.outline(p, name);
      if (kind === "point" && board.position(name)) p.dot(board.position(name), 11, { colour: theme.sky, width: 3, fill: null });
    }
    for (const name of Object.keys(drawing.points)) {
      if (name.startsWith("ground.")) p.dot(drawing.points[name], 3.5, { colour: theme.black, fill: theme.paper, width: 1.6 });
    }
    for (const { apart, ends } of drawing.joints) {
      if (!(apart > 0)) continue;
      const [a, b] = ends.map((end) => board.position(end));
      p.line([a, b], { colour: theme.red, width: 2.5, dash: [4, 4] });
      for (const at of [a, b]) p.dot(at, 7, { colour: theme.red, width: 2.5, fill: null });
    }
    this.label(p);
  }

  outline(p, body) {
    const { board, drawing } = this.edit, ends = drawing.bars[body], place = board.placeOf(body), form = board.geometry.bodies[body];
    const soft = { colour: board.theme.sky, width: 9, opacity: 0.45 };
    if (ends) p.line(ends.map((end) => board.position(end)), soft);
    else if (form?.outline && place) p.line(form.outline[0].map(([x, y]) => [place.x + place.cos * x - place.sin * y, place.y + place.sin * x + place.cos * y]), { ...soft, width: 4, closed: true });
    else for (const point of Object.keys(form?.points ?? {})) p.dot(board.position(`${body}.${point}`), 14, { colour: board.theme.sky, width: 3, fill: null });
  }

  label(p) {
    const { board, drawing, things: [thing] } = this.edit, [kind, name] = (thing ?? "").split(/ (.*)/s);
    const field = (drawing.fields[thing] ?? []).find((other) => FIELDS_FIRST.includes(other.name) && other.text);
    if (!field || kind === "point") return;
    const joint = drawing.joints.find((other) => (kind === "joint" && other.name === name) || (kind === "driver" && other.driver === name));
    const ends = kind === "body" ? drawing.bars[name] : joint?.ends ?? drawing.loads[name];
    const spots = (ends ?? []).map((end) => board.position(end)).filter(Boolean);
    if (!spots.length) return;
    const middle = [0, 1].map((k) => spots.reduce((sum, at) => sum + at[k], 0) / spots.length);
    const text = field.text.replace(/\d+\.\d{5,}/g, (number) => String(Number(Number(number).toPrecision(5)))); // the field has all digits
    this.box = p.tag(`${field.name === "Length" ? "" : `${field.name.toLowerCase()} `}${text}`, middle, { dx: 14, dy: -14, bold: true });
  }

  // What is chosen, where its label is at a place of the sheet; else null.
  labelled([x, y]) {
    if (!this.box) return null;
    const [left, top, width, height] = this.box;
    return x >= left && x <= left + width && y >= top && y <= top + height ? this.edit.things : null;
  }
}
