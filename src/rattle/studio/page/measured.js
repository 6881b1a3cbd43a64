// Measured curves beside the motion: a file is dropped on the Motion tab, or chosen; nothing of it goes into the model.

import { h, replace } from "./dom.js";
import { bytesOf, typedValue } from "./viewer.js";

const LARGEST = 8000000; // bytes of a file
const TABLE = /\.(csv|tsv|txt|dat)$/i;

export class Measured {
  // host: {send(message), app(): the viewer or null}; place: the element on which files are dropped
  constructor(place, host) {
    this.host = host;
    this.files = new Map(); // {t, columns} by the names of files
    this.shown = []; // rows: {file, column (its number), curve, offset [s], written}
    this.words = h("span", { class: "words", role: "alert" });
    this.picker = h("input", { type: "file", accept: ".csv,.tsv,.txt,.dat", multiple: true, hidden: true, "aria-label": "File of measured curves",
      onchange: () => { this.take([...this.picker.files]); this.picker.value = ""; } });
    this.button = h("button", { type: "button", class: "chip", title: "Show a file of measured curves beside the motion; or drop it here",
      onclick: () => this.picker.click() }, "Measured …");
    place.append(this.picker);
    this.rows = h("div", { class: "measured", role: "group", "aria-label": "Measured curves", hidden: true });
    place.addEventListener("dragover", (event) => {
      if (!carriesFiles(event)) return;
      event.preventDefault();
      event.dataTransfer.dropEffect = "copy";
    });
    place.addEventListener("drop", (event) => {
      const files = [...event.dataTransfer.files];
      if (!files.length || !files.some((file) => TABLE.test(file.name) || file.type.startsWith("text/"))) return;
      event.preventDefault();
      this.take(files);
    });
  }

  // Read files and ask the studio what is in them.
  async take(files) {
    const app = this.host.app();
    if (!app) { this.say("there is no motion yet to which measured curves could belong"); return; }
    const curves = Object.fromEntries(app.names.map((name) => [name, app.viewer.motion.unit(name)]));
    for (const file of files) {
      if (file.size > LARGEST) { this.say(`${file.name} has more than 8 MB`); continue; }
      try {
        const text = new TextDecoder("utf-8", { fatal: true }).decode(await file.arrayBuffer());
        this.host.send({ do: "measured", file: file.name, text, curves, shown: app.viewer.curves.chosen });
      } catch {
        this.say(`${file.name} is not UTF-8 text; save it as CSV in UTF-8`);
      }
    }
  }

  // The studio has read a file.
  hear({ file, t, columns }) {
    const times = new Float64Array(bytesOf(t));
    this.files.set(file, { t: times, columns: columns.map((column) => ({ ...column, y: new Float64Array(bytesOf(column.y)) })) });
    const before = this.shown.filter((row) => row.file === file && columns[row.column]);
    const found = columns.flatMap(({ curve }, column) => (curve ? [{ file, column, curve, offset: 0, written: "0 s" }] : []));
    const first = found.length ? found : [{ file, column: 0, curve: "", offset: 0, written: "0 s" }];
    this.shown = [...this.shown.filter((row) => row.file !== file), ...(before.length ? before : first)];
    this.say(found.length || before.length ? "" : `${file}: choose the curve that its column belongs to`);
    this.apply();
  }

  say(words) {
    this.words.textContent = words;
    this.list();
  }

  clear() {
    this.files.clear();
    this.shown = [];
    this.words.textContent = "";
    this.list();
  }

  // What is shown beside the motion; a viewer that was made anew is told again.
  apply() {
    this.host.app()?.viewer.setMeasured(this.shown.filter((row) => row.curve).map((row) => {
      const { t, columns } = this.files.get(row.file), { name, y } = columns[row.column];
      return { curve: row.curve, label: `${name === row.curve ? "measured" : name} (${row.file})`, t: t.map((time) => time + row.offset), y };
    }));
    this.list();
  }

  list() {
    this.rows.hidden = !this.shown.length && !this.words.textContent;
    replace(this.rows, this.shown.map((row) => this.row(row)), this.words.textContent ? this.words : null);
  }

  row(row) {
    const { columns } = this.files.get(row.file), app = this.host.app(), { units } = columns[row.column];
    const fitting = (app?.names ?? []).filter((name) => units.includes(app.viewer.motion.unit(name)));
    const column = select(`Column of ${row.file}`, columns.map(({ head }, k) => [String(k), head]), String(row.column), (value) => {
      row.column = Number(value);
      if (!columns[row.column].units.includes(app?.viewer.motion.unit(row.curve))) row.curve = "";
      this.apply();
    });
    const curve = select("belongs to", [["", "no curve"], ...fitting.map((name) => [name, name])], row.curve, (value) => {
      row.curve = value;
      this.words.textContent = "";
      this.apply();
    });
    const offset = h("input", { type: "text", value: row.written, "aria-label": "Offset in time", "aria-invalid": String(row.wrong ?? false), title: "What is added to its times, such as 20 ms",
      onchange: () => this.shift(row, offset) });
    return h("div", {}, h("span", { class: "file", title: row.file }, row.file), column, h("span", { class: "quiet" }, "is"), curve,
      h("span", { class: "quiet" }, "shifted by"), offset,
      h("button", { type: "button", class: "chip", title: "Another column of this file", "aria-label": `Another column of ${row.file}`,
        onclick: () => { this.shown.splice(this.shown.indexOf(row) + 1, 0, { ...row, curve: "" }); this.apply(); } }, "+"),
      h("button", { type: "button", class: "close", "aria-label": `Remove ${columns[row.column].name} of ${row.file}`,
        onclick: () => { this.shown = this.shown.filter((other) => other !== row); this.apply(); } }, "×"));
  }

  shift(row, field) {
    row.written = field.value.trim();
    row.wrong = false;
    try { row.offset = typedValue(row.written, "s", "s"); } catch { row.wrong = true; }
    this.apply();
  }
}

function select(label, options, value, change) {
  const field = h("select", { "aria-label": label, onchange: () => change(field.value) }, options.map(([key, text]) => h("option", { value: key }, text)));
  field.value = value;
  return field;
}

function carriesFiles(event) {
  return [...(event.dataTransfer?.types ?? [])].includes("Files");
}
