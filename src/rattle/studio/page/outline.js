// What stands where in a model text: its tables as far as they can be read, and where the caret is in them.  A text that
// is being written is rarely sound, so everything is read that can be; whether it is right is said by the studio.

const DEEPEST_TABLES = 40; // arrays and tables within each other that are followed; more are no model
const KEY = /(?:"[^"\n]*"|'[^'\n]*'|[\w-]+)(?:[ \t]*\.[ \t]*(?:"[^"\n]*"|'[^'\n]*'|[\w-]*))*/y;
const HEADER = /\[\[?([^\]\n#]*)\]{0,2}/y;
const BARE = /[^\s,\]}#]+/y;
const BLANK = /[ \t]*/y;
const STATEMENT = /[ \t]*(?:\[\[?[A-Za-z_"]|[\w.-]+[ \t]*=)/y;
const AFTER = /[ \t]*(?:[\n,\]}#]|$)/y;

// {root: tables as Maps, heads: [{path, from}], place: {kind: "key", "value", "header" or "none", path, from, to, typed, ...}}
export function outline(text, at) {
  const reader = new Outline(text.replaceAll("\r", " "), at);
  reader.read();
  return reader;
}

class Outline {
  constructor(text, at) {
    this.text = text;
    this.at = at;
    this.i = 0;
    this.root = new Map();
    this.heads = [];
    this.place = null;
  }

  read() {
    let table = this.root, path = [];
    while (this.i < this.text.length) {
      const start = this.i;
      this.take(BLANK);
      const c = this.text[this.i];
      if (c === "\n" || c === undefined || c === "#") {
        this.gap(start, this.i, () => this.free(path, table));
        if (c === "#") this.comment();
        else this.i++;
      } else if (c === "[") {
        path = this.header();
        table = this.within(this.root, path);
      } else {
        this.gap(start, this.i, () => this.free(path, table));
        this.statement(path, table);
      }
    }
    this.place ??= this.free(path, table);
  }

  // A place for a key, if nothing stands before it in its line.
  free(path, table) {
    const line = this.text.slice(this.text.lastIndexOf("\n", this.at - 1) + 1, this.at);
    return line.trim() ? { kind: "none" } : this.empty("key", path, { table });
  }

  empty(kind, path, more = {}) { return { kind, path, from: this.at, to: this.at, typed: "", ...more }; }

  // The caret is in what was passed over, before something else begins.
  gap(from, to, place) {
    if (this.place || this.at < from || this.at > to) return;
    if (this.at === to && !this.matches(AFTER, to)) return;
    this.place = place();
  }

  matches(pattern, at) {
    pattern.lastIndex = at;
    return pattern.exec(this.text);
  }

  take(pattern) {
    const found = this.matches(pattern, this.i);
    if (found) this.i += found[0].length;
    return found;
  }

  comment() {
    const end = this.text.indexOf("\n", this.i), to = end < 0 ? this.text.length : end;
    if (this.at > this.i && this.at <= to) this.place ??= { kind: "none" };
    this.i = to;
  }

  within(table, path) {
    for (const name of path) {
      if (!(table.get(name) instanceof Map)) table.set(name, new Map());
      table = table.get(name);
    }
    return table;
  }

  header() {
    const from = this.i, found = this.take(HEADER), inner = from + found[0].length - found[0].replace(/^\[\[?/, "").length;
    const path = parts(found[1]);
    this.heads.push({ path, from });
    if (this.at >= inner && this.at <= inner + found[1].length) {
      const before = this.text.slice(inner, this.at), dot = before.lastIndexOf(".") + 1;
      this.place ??= { kind: "header", path: parts(before.slice(0, dot)), from: inner + dot, to: inner + found[1].length, typed: before.slice(dot), closed: found[0].endsWith("]") };
    }
    return path;
  }

  statement(path, table, depth = 0) {
    const from = this.i, found = this.take(KEY);
    if (!found) { this.i++; return; }
    const names = parts(found[0]), last = names.length - 1;
    const holder = () => this.within(table, names.slice(0, last));
    this.take(BLANK);
    const assigned = this.text[this.i] === "=";
    if (this.at >= from && this.at <= from + found[0].length) {
      const before = this.text.slice(from, this.at), dot = before.lastIndexOf(".") + 1, stem = parts(before.slice(0, dot));
      const rest = /^[\w-]*/.exec(this.text.slice(this.at, from + found[0].length))[0];
      this.place ??= { kind: "key", path: [...path, ...stem], table: this.within(table, stem), from: from + dot, to: this.at + rest.length, typed: before.slice(dot), assigned };
    }
    if (!assigned) return;
    const equals = ++this.i;
    this.take(BLANK);
    const full = [...path, ...names];
    this.gap(equals, this.i, () => this.empty("value", full));
    holder().set(names[last], this.value(full, depth + 1));
  }

  value(path, depth) {
    const c = this.text[this.i];
    if (depth > DEEPEST_TABLES) { this.i++; return ""; }
    if (c === '"' || c === "'") return this.words(c, path);
    if (c === "[") return this.array(path, depth);
    if (c === "{") return this.inline(path, depth);
    const from = this.i, found = this.take(BARE);
    if (found && this.at > from && this.at <= this.i) this.place ??= { kind: "value", path, from, to: this.i, typed: this.text.slice(from, this.at) };
    return found ? found[0] : "";
  }

  words(quote, path) {
    const from = this.i, long = this.text.startsWith(quote.repeat(3), from), ends = long ? quote.repeat(3) : quote;
    const start = from + ends.length;
    let end = this.text.indexOf(ends, start);
    const line = this.text.indexOf("\n", start);
    const closed = end >= 0 && (long || line < 0 || end < line);
    if (!closed) end = line < 0 || long ? this.text.length : line;
    this.i = closed ? end + ends.length : end;
    if (this.at >= start && this.at <= end) {
      this.place ??= long ? { kind: "none" } : { kind: "value", path, quote, from: start, to: closed ? end : this.at, typed: this.text.slice(start, this.at), closed };
    } else if (this.at > from && this.at < this.i) this.place ??= { kind: "none" };
    return this.text.slice(start, end);
  }

  array(path, depth) {
    const entries = [];
    let index = 0, before = ++this.i;
    while (this.i < this.text.length) {
      this.take(BLANK);
      const c = this.text[this.i];
      this.gap(before, this.i, () => this.empty("value", [...path, index]));
      if (c === "\n") {
        this.i++;
        if (this.matches(STATEMENT, this.i)) return entries; // it was not closed
      } else if (c === "#") this.comment();
      else if (c === "]") { this.i++; return entries; }
      else if (c === ",") { this.i++; index++; }
      else {
        const from = this.i;
        entries[index] = this.value([...path, index], depth + 1);
        if (this.i === from) this.i++; // a sign that has no place here
      }
      before = this.i;
    }
    return entries;
  }

  inline(path, depth) {
    const table = new Map();
    let before = ++this.i, next = true;
    while (this.i < this.text.length) {
      this.take(BLANK);
      const c = this.text[this.i];
      this.gap(before, this.i, () => (next ? this.empty("key", path, { table }) : { kind: "none" }));
      if (c === "\n" || c === "#") return table; // it was not closed
      if (c === "}") { this.i++; return table; }
      next = c === ",";
      if (next) this.i++;
      else this.statement(path, table, depth);
      before = this.i;
    }
    return table;
  }
}

// Names between dots, without their quotes; an empty one after the last dot is none.
function parts(dotted) {
  return dotted.split(".").map((name) => name.trim().replace(/^(["'])(.*)\1$/, "$2")).filter(Boolean);
}
