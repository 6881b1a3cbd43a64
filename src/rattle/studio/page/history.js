// Undo and redo of the model text, whatever changed it: typing, knobs, contact models.

const TOGETHER = 900; // changes of one kind within this time are one step back [ms]
const DEEPEST = 300;

export class History {
  constructor() {
    this.start("");
  }

  start(text) {
    this.past = [];
    this.future = [];
    this.now = text;
    this.kind = "";
    this.when = 0;
  }

  // The text has become this one; kind: what changed it.
  record(text, kind, time = performance.now()) {
    if (text === this.now) return;
    const joins = kind === this.kind && time - this.when < TOGETHER && this.past.length;
    if (!joins) this.past.push(this.now);
    if (this.past.length > DEEPEST) this.past.shift();
    this.future = [];
    this.now = text;
    this.kind = kind;
    this.when = time;
  }

  undo() { return this.move(this.past, this.future); }

  redo() { return this.move(this.future, this.past); }

  // The text to go to, or null if there is none.
  move(from, to) {
    if (!from.length) return null;
    to.push(this.now);
    this.now = from.pop();
    this.kind = "";
    return this.now;
  }
}
