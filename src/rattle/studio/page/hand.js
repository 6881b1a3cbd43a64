// The hand on the sheet: mouse, finger and keyboard as acts of the tool that it holds.  While a button is down only a
// ghost is drawn; the act is told when it is let go.

import { lengthText } from "./board.js";
import { Catcher, NEAR } from "./catching.js";
import { drawGhosts } from "./ghosts.js";

const FAR = 5; // pixels from which on a press is a drag
const EDGE = 24; // pixels between a cross hair and the edge of the sheet
const LONG = 550; // a finger that rests so long chooses [ms]
const LINES = new Set(["Bar", "Spring", "Force", "Slot"]); // from here to there

export class Hand {
  // told: what the hand asks and tells, see Edit.told.
  constructor(board, told) {
    Object.assign(this, { board, told, catcher: new Catcher(board), down: new Map(), act: null, cross: null, over: null });
    board.marks.push((p) => drawGhosts(this, p));
    const el = board.above;
    for (const [name, call] of [["pointerdown", this.press], ["pointermove", this.move], ["pointerup", this.release], ["pointercancel", this.lose], ["pointerleave", this.leave], ["dblclick", this.twice]]) {
      el.addEventListener(name, (event) => call.call(this, event));
    }
    el.addEventListener("wheel", (event) => {
      board.zoom(...this.place(event), Math.exp(-Math.max(-80, Math.min(80, event.deltaY)) / (event.deltaMode ? 12 : 320)));
      event.preventDefault();
    }, { passive: false });
    el.addEventListener("contextmenu", (event) => event.preventDefault());
  }

  get within() { return NEAR[this.pointer === "touch" ? "touch" : "mouse"]; }

  place(event) {
    const box = this.board.above.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  // A tool was taken: what was begun with another is forgotten.
  forget() {
    clearTimeout(this.resting);
    this.act = null;
    this.over = null;
    this.board.invalidate();
  }

  // Escape: what was begun ends; false if nothing was.
  cancel() {
    const begun = this.act !== null;
    if (this.act?.begun) this.told.letGo();
    this.forget();
    this.cancelled = this.down.size > 0;
    return begun;
  }

  // ---------------------------------------------------------------- mouse and fingers
  press(event) {
    if (event.button > 0 && event.button !== 1 && event.button !== 2) return;
    this.pointer = event.pointerType;
    const at = this.place(event);
    this.down.set(event.pointerId, { at, from: at });
    this.board.above.setPointerCapture?.(event.pointerId);
    this.board.above.focus({ preventScroll: true });
    this.cross = null;
    clearTimeout(this.resting);
    if (this.down.size === 2) { this.cancel(); this.cancelled = true; this.told.resume(); return; }
    if (event.button > 0) { this.act = { pans: true }; return; }
    this.cancelled = false;
    this.shift = event.shiftKey;
    if (event.pointerType === "touch") this.resting = setTimeout(() => this.rest(at), LONG);
    this.begin(at, event.altKey);
    event.preventDefault();
  }

  move(event) {
    const at = this.place(event), one = this.down.get(event.pointerId);
    this.shift = event.shiftKey;
    if (!one) { this.hover(at, event.altKey); return; }
    if (this.down.size === 2) { this.pinch(event.pointerId, at); return; }
    const before = one.at;
    one.at = at;
    if (!one.moved && Math.hypot(at[0] - one.from[0], at[1] - one.from[1]) <= FAR) return;
    one.moved = true;
    clearTimeout(this.resting);
    if (this.act?.pans) this.board.pan(at[0] - before[0], at[1] - before[1]);
    else if (this.act) this.drag(at, event.altKey, one.from);
  }

  release(event) {
    const one = this.down.get(event.pointerId), at = this.place(event);
    if (!one) return;
    this.down.delete(event.pointerId);
    clearTimeout(this.resting);
    if (this.down.size || this.cancelled) return;
    if (this.act?.pans) {
      if (!one.moved && event.button === 0 && !this.act.keeps) this.told.choose([]);
      this.act = null;
    } else if (this.act) this.end(at, event.altKey, Boolean(one.moved));
    this.told.resume();
  }

  lose(event) {
    this.down.delete(event.pointerId);
    this.cancel();
    this.told.resume();
  }

  leave() {
    if (this.down.size) return;
    this.over = null;
    this.told.point("");
    this.board.invalidate();
  }

  // Two fingers move and zoom the sheet.
  pinch(id, at) {
    const middle = () => {
      const [a, b] = [...this.down.values()].map((one) => one.at);
      return { x: (a[0] + b[0]) / 2, y: (a[1] + b[1]) / 2, size: Math.hypot(a[0] - b[0], a[1] - b[1]) || 1 };
    };
    const before = middle();
    this.down.get(id).at = at;
    const after = middle();
    this.board.zoom(after.x, after.y, after.size / before.size);
    this.board.pan(after.x - before.x, after.y - before.y);
  }

  // A finger that rests chooses, whatever tool it holds.
  rest(at) {
    this.act = null;
    this.cancelled = true;
    this.chooseAt(at);
    this.told.resume();
  }

  twice(event) {
    const at = this.place(event);
    const things = this.thingsAt(at);
    if (this.told.tool === "Select") this.told.focus(things.length ? things : this.told.labelled(at) ?? []);
    if (this.told.tool === "Plate" && this.act?.corners) this.closePlate();
  }

  // ---------------------------------------------------------------- acts
  options(free, more = {}) {
    return { within: this.within, free, ...more };
  }

  begin(at, free) {
    const { tool } = this.told;
    if (this.told.stop(tool, at) && tool !== "Select") return;
    if (this.act?.waits) { this.drag(at, free, at); return; } // the second click of two
    if (tool === "Select") { this.beginSelect(at); return; }
    if (LINES.has(tool)) this.act = { tool, from: this.catcher.catch(at, this.options(free, { lines: true })) };
    else if (this.act?.corners) this.drag(at, free, at);
    else this.act = { tool, to: this.catcher.catch(at, this.options(free, { lines: ["Pin", "Slider", "Measure"].includes(tool) })), pressed: at };
    this.told.point(this.act?.from?.words ? `from ${this.act.from.words}` : "");
    this.board.invalidate();
  }

  beginSelect(at) {
    const point = this.catcher.points(at, this.within)[0], body = point ? null : this.catcher.body(at, this.within * 0.75);
    const held = point ? this.catcher.joined(point.name).map((name) => name.split(".")[0]).find((name) => name !== "ground") : body;
    const turns = body || this.told.turned || this.board.running || this.shift; // a point that is dragged otherwise is put elsewhere
    if (held && turns) this.act = { tool: "Select", pulls: held, force: this.shift, at: this.board.inPlane(at) };
    else if (point) this.act = { tool: "Select", drags: point.name };
    else this.act = { pans: true, keeps: this.told.labelled(at) !== null }; // a label stands for what is chosen
  }

  drag(at, free, from) {
    const { act } = this;
    if (act.pulls) {
      if (!act.begun) this.told.grab(act.pulls, act.at, act.force);
      act.begun = true;
      this.told.pull(this.board.inPlane(at));
      return;
    }
    if (act.held === null) this.over = this.catcher.catch(at, this.options(free, { lines: true, without: [act.from.point, act.to.point] }));
    else if (act.drags) {
      const own = this.catcher.joined(act.drags), bodies = own.map((name) => name.split(".")[0]);
      act.to = this.catcher.catch(at, this.options(free, { lines: true, without: own, bodies }));
      this.told.point(act.to.point ? `joins ${act.to.words}` : act.to.line ? `joins ${act.to.line}` : "");
    } else if (act.tool === "Slider") {
      act.along = this.direction(act.to.at, this.board.inPlane(at), free);
    } else if (act.from && act.held === undefined) {
      act.to = this.catcher.catch(at, this.options(free, { lines: act.tool !== "Force", without: [act.from.point] }));
      if (this.shift && !act.to.point) act.to = this.straight(act.from, at);
      const away = Math.hypot(act.to.at[0] - act.from.at[0], act.to.at[1] - act.from.at[1]);
      this.told.point(`${act.to.point || act.to.line ? `joins ${act.to.words}, ` : ""}${act.tool === "Force" ? `${(away / this.board.snap).toPrecision(3)} N` : lengthText(away)}`);
    } else act.to = this.catcher.catch(at, this.options(free, { lines: ["Pin", "Slider", "Slot", "Measure"].includes(act.tool) }));
    this.board.invalidate();
  }

  // With Shift: level, upright, or along or square to a bar that ends where the line began, in whole steps of the grid.
  straight(from, at) {
    const { board } = this, to = board.inPlane(at), way = Math.atan2(to[1] - from.at[1], to[0] - from.at[0]);
    const bars = from.point ? this.catcher.joined(from.point).map((name) => name.split(".")[0]) : [from.line];
    const slopes = [0, ...bars.filter((body) => board.drawing.bars[body]).map((body) => board.placeOf(body).angle)];
    const ways = slopes.flatMap((slope) => [0, 1, 2, 3].map((k) => slope + k * Math.PI / 2));
    const apart = (angle) => Math.abs(Math.atan2(Math.sin(angle - way), Math.cos(angle - way)));
    const angle = ways.reduce((best, one) => (apart(one) < apart(best) - 1e-9 ? one : best)), { snap } = board;
    const long = Math.round(Math.hypot(to[0] - from.at[0], to[1] - from.at[1]) * Math.cos(apart(angle)) / snap) * snap;
    return { at: [from.at[0] + long * Math.cos(angle), from.at[1] + long * Math.sin(angle)], words: "straight" };
  }

  // The direction from one place to another, in steps of 15 degrees unless it is free.
  direction(a, b, free) {
    const angle = Math.atan2(b[1] - a[1], b[0] - a[0]), step = Math.PI / 12;
    return free ? angle : Math.round(angle / step) * step;
  }

  hover(at, free) {
    const { act } = this, { tool } = this.told;
    if (act && (act.waits || act.corners)) { this.drag(at, free, at); return; }
    const before = JSON.stringify(this.over);
    this.over = tool === "Select" ? this.overThing(at) : this.catcher.catch(at, this.options(free, { lines: ["Bar", "Pin", "Slider", "Slot", "Spring", "Force"].includes(tool) }));
    this.told.point(tool === "Select" ? this.over?.point ?? this.over?.body ?? "" : this.over.words);
    this.board.above.style.cursor = tool === "Select" ? (this.over ? "grab" : "default") : "crosshair";
    if (JSON.stringify(this.over) !== before) this.board.invalidate();
  }

  overThing(at) {
    const point = this.catcher.points(at, this.within)[0];
    if (point) return { at: point.spot, point: point.name };
    const body = this.catcher.body(at, this.within * 0.75);
    return body ? { body } : null;
  }

  end(at, free, moved) {
    const { act } = this;
    this.over = null;
    if (act.pulls) {
      this.act = null;
      if (act.begun) this.told.release();
      else this.chooseAt(at);
    } else if (act.drags) {
      this.act = null;
      if (moved) this.told.act({ act: "drop", point: act.drags, to: bare(act.to) });
      else this.chooseAt(at);
    } else if (act.tool === "Plate") this.corner(act, at, free);
    else if (LINES.has(act.tool)) this.endLine(act, at, free, moved);
    else this.endClick(act);
    if (!this.act) this.told.point("");
    this.board.invalidate();
  }

  endLine(act, at, free, moved) {
    if (act.held === null) { // a slot that waits for the point that it holds
      const held = this.catcher.catch(at, this.options(free, { lines: true, without: [act.from.point, act.to.point] }));
      this.act = this.over = null;
      this.told.act({ act: "slot", from: bare(act.from), to: bare(act.to), held: bare(held) });
      return;
    }
    if (!moved && !act.waits) { act.waits = true; return; } // click, then click
    if (moved || act.waits) this.drag(at, free, at);
    if (act.tool === "Slot") {
      this.act = { ...act, waits: true, held: null };
      this.told.say("click the point that slides in it");
      return;
    }
    this.act = null;
    this.told.act({ act: act.tool.toLowerCase(), from: bare(act.from), to: bare(act.to), snap: this.board.snap });
  }

  endClick(act) {
    const at = bare(act.to), within = this.within / this.board.view.scale;
    if (["Gear", "Measure", "Picture"].includes(act.tool)) {
      const spots = [...(act.spots ?? []), at];
      this.act = { tool: act.tool, spots, waits: true, to: act.to };
      if (act.tool === "Gear") {
        this.told.say(spots.length < 2 ? "click the centre of the other wheel" : "");
        if (spots.length === 2) { this.act = null; this.told.act({ act: "gear", from: spots[0], to: spots[1] }); }
      } else this.told.spots(act.tool, spots);
      return;
    }
    this.act = null;
    const more = act.tool === "Slider" ? { along: act.along ?? 0 } : {};
    this.told.act({ act: act.tool.toLowerCase(), at, within, ...more });
  }

  corner(act, at, free) {
    const { to } = act, corners = act.corners ?? [], first = corners[0];
    const near = first && Math.hypot(...[0, 1].map((k) => this.board.onCanvas(first.at)[k] - at[k])) <= this.within;
    if (near && corners.length > 2) { this.closePlate(); return; }
    if (!near) this.act = { ...act, corners: [...corners, bare(to)] };
    this.told.say(this.act.corners.length > 2 ? "click the first corner, or press Enter, to close the plate" : "click the next corner");
  }

  closePlate() {
    const { corners } = this.act;
    this.act = null;
    if (corners.length > 2) this.told.act({ act: "plate", corners });
    this.board.invalidate();
  }

  // ---------------------------------------------------------------- choosing
  // What lies at a place: a pin as its joints and its point, a body, a load.
  thingsAt(at) {
    const point = this.catcher.points(at, this.within)[0];
    if (point) return this.thingsOf(point.name);
    const load = this.loadAt(at);
    if (load) return [`load ${load}`];
    const body = this.catcher.body(at, this.within);
    return body ? [`body ${body}`] : [];
  }

  thingsOf(point) {
    const joints = this.catcher.jointsAt(point);
    const ground = this.catcher.joined(point).find((name) => name.startsWith("ground.")) ?? point;
    return [...joints.flatMap(({ name, driver }) => [`joint ${name}`, ...(driver ? [`driver ${driver}`] : [])]), `point ${ground}`];
  }

  loadAt(at) {
    const { board } = this;
    for (const [name, ends] of Object.entries(board.drawing?.loads ?? {})) {
      const spots = [...new Set(ends)].map((end) => board.position(end)).filter(Boolean).map((spot) => board.onCanvas(spot));
      if (spots.length === 2) {
        const middle = [0, 1].map((k) => (spots[0][k] + spots[1][k]) / 2);
        if (Math.hypot(middle[0] - at[0], middle[1] - at[1]) <= 1.5 * this.within && !this.catcher.body(at, this.within / 2)) return name;
      }
    }
    return null;
  }

  // A click where something is chosen already chooses the next joint there.
  chooseAt(at) {
    const things = this.thingsAt(at), joints = things.filter((thing) => thing.startsWith("joint "));
    const now = this.told.chosen, again = joints.length > 1 && joints.indexOf(now[0]) >= 0 && things.every((thing) => now.includes(thing));
    this.told.choose(again ? this.from(things, joints[(joints.indexOf(now[0]) + 1) % joints.length]) : things);
  }

  // The same things, this joint first.
  from(things, joint) {
    const start = things.indexOf(joint), end = things.length - 1; // the point is the last
    return [...things.slice(start, end), ...things.slice(0, start), things[end]];
  }

  // Everything that can be chosen, for the Tab key.
  everything() {
    const { drawing } = this.board;
    const seen = new Set(), things = [];
    for (const name of Object.keys(drawing?.points ?? {})) {
      if (seen.has(name)) continue;
      for (const other of this.catcher.joined(name)) seen.add(other);
      const here = this.thingsOf(name), joints = here.filter((thing) => thing.startsWith("joint "));
      things.push(...(joints.length ? joints.map((joint) => this.from(here, joint)) : [here]));
    }
    return [...things, ...Object.keys(drawing?.places ?? {}).map((body) => [`body ${body}`]), ...Object.keys(drawing?.loads ?? {}).map((load) => [`load ${load}`])];
  }

  // ---------------------------------------------------------------- keyboard
  // The cross hair moves by snaps; Enter presses and lets go where it is.
  step(dx, dy) {
    const { board } = this, at = this.cross ?? board.onGrid(board.inPlane([board.width / 2, board.height / 2]));
    this.cross = board.onGrid([at[0] + dx * board.snap, at[1] + dy * board.snap]);
    this.reveal(this.cross);
    this.hover(board.onCanvas(this.cross), false);
    this.told.point(`${this.cross.map((x) => lengthText(x)).join(", ")}${this.over?.words || this.over?.point ? `, ${this.over.words || this.over.point}` : ""}`);
    board.invalidate();
  }

  // The sheet follows a cross hair that leaves it.
  reveal(place) {
    const { board } = this, at = board.onCanvas(place), sides = [board.width, board.height];
    const [dx, dy] = sides.map((side, k) => Math.max(0, EDGE - at[k]) + Math.min(0, side - EDGE - at[k]));
    if (dx || dy) board.pan(dx, dy);
  }

  enter() {
    if (this.act?.corners && !this.cross) { this.closePlate(); return true; }
    if (!this.cross) { this.step(0, 0); return true; }
    const at = this.board.onCanvas(this.cross), first = this.act?.corners?.[0];
    if (first && this.act.corners.length > 2 && Math.hypot(first.at[0] - this.cross[0], first.at[1] - this.cross[1]) < this.board.snap / 2) { this.closePlate(); return true; }
    if (!this.act) this.begin(at, false);
    else this.drag(at, false, at);
    if (this.act) this.end(at, false, false);
    return true;
  }
}

// What the studio is told of a place.
function bare({ at, point, line }) {
  return { at, ...(point ? { point } : {}), ...(line ? { line } : {}) };
}
