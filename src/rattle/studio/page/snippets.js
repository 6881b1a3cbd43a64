// Parts that can be added to a model text, with names that are free and points that exist.

import { namesOf, pointsOf, tableOf } from "./entries.js";

// A name that no part of a table has.
function free(root, section, stem) {
  const used = tableOf(root, section);
  let name = stem;
  for (let k = 2; used.has(name); k++) name = `${stem}${k}`;
  return name;
}

const ends = (joint) => (joint instanceof Map && Array.isArray(joint.get("connect")) ? joint.get("connect") : []);

// Two points to connect: of a body that nothing holds yet, else of two bodies; points without a joint before others.
function pair(root) {
  const used = new Set([...tableOf(root, "joints").values()].flatMap(ends)), bodies = [...tableOf(root, "bodies")];
  const held = ([name]) => [...used].some((end) => typeof end === "string" && end.startsWith(`${name}.`));
  const points = (list) => list.flatMap(([name, body]) => pointsOf(body).map((point) => `${name}.${point}`));
  const best = (list) => list.find((point) => !used.has(point)) ?? list.at(-1);
  const loose = bodies.findLast((body) => !held(body)) ?? bodies.at(-1);
  const rest = [...bodies.filter((body) => body !== loose).reverse(), ["ground", tableOf(root, "ground")]];
  return [best(points(rest)) ?? "ground.O", best(points(loose ? [loose] : [])) ?? "body.A"];
}

const isPlain = (joint) => joint instanceof Map && joint.get("type") === "revolute" && !joint.has("clearance");
const part = (section, name, lines) => ({ section, text: `[${section}.${name}]\n${lines.join("\n")}\n`, select: name });
const quoted = (names) => `[${names.map((name) => `"${name}"`).join(", ")}]`;
const lastPoint = (root) => namesOf(root, "points").at(-1) ?? "body.A";
const named = (section, stem, lines) => (root) => part(section, free(root, section, stem), lines(root));
const joint = (stem, type) => named("joints", stem, (root) => [`type = "${type}"`, `connect = ${quoted(pair(root))}`]);
const between = (root) => { const all = namesOf(root, "points"); return quoted([all[0] ?? "ground.O", all.at(-1) ?? "body.A"]); };

export const SNIPPETS = [
  ["body", "a uniform bar between two points", named("bodies", "link", () => ['bar = ["A", "B"]', 'length = "0.2 m"', 'mass = "1 kg"'])],
  ["block", "a body of any shape: mass, inertia, points", named("bodies", "block", () => ['mass = "1 kg"', 'inertia = "1e-3 kg*m^2"', "points = { P = [0, 0] }"])],
  ["joint", "a pin: two bodies share a point", joint("pin", "revolute")],
  ["slider", "a point slides along a line, its body does not turn", joint("slide", "prismatic")],
  ["driver", "a joint whose angle follows time", driver],
  ["spring", "a spring between two points", named("loads", "spring", (root) => ['type = "spring"', `connect = ${between(root)}`, 'stiffness = "1 kN/m"'])],
  ["bushing", "rubber between two points: along x, along y, and for the angle", named("loads", "mount", (root) => ['type = "bushing"', `connect = ${between(root)}`, 'stiffness = ["100 kN/m", "100 kN/m", "100 N*m/rad"]'])],
  ["force", "a force at a point", named("loads", "force", (root) => ['type = "force"', `at = "${lastPoint(root)}"`, 'force = ["10 N", "0 N"]'])],
  ["play in a joint", "clearance of a pin and what happens in it", play],
  ["parameter", "a dimension that becomes a knob", parameter],
].map(([label, about, make]) => ({ label: `add ${label}`, about, make }));

// Pins without play, and which of them no driver turns.
function pins(root) {
  const driven = new Set([...tableOf(root, "drivers").values()].map((one) => one instanceof Map && one.get("joint")));
  const plain = [...tableOf(root, "joints")].filter(([, one]) => isPlain(one)).map(([name]) => name);
  return { plain, idle: plain.filter((name) => !driven.has(name)) };
}

// Of the first pin that has none; null if there is no such pin.
function driver(root) {
  const [name] = pins(root).idle;
  return name === undefined ? null : part("drivers", free(root, "drivers", "motor"), [`joint = "${name}"`, 'angle = "2*pi*t"']);
}

// Into the joint at the caret, else into the first pin without play; null if there is none.
function play(root, path) {
  const { plain, idle } = pins(root), name = path[0] === "joints" && plain.includes(path[1]) ? path[1] : idle[0] ?? plain[0];
  return name === undefined ? null : { into: ["joints", name], text: 'clearance = "0.1 mm"\ncontact = "impact"\n', select: "0.1" };
}

function parameter(root) {
  const name = free(root, "parameters", "a"), line = `${name} = { value = "0.1 m", min = "0.05 m", max = "0.2 m" }\n`;
  return root.has("parameters") ? { into: ["parameters"], text: line, select: name } : { section: "parameters", text: `[parameters]\n${line}`, select: name };
}

// Where a snippet goes: {at, text, from, to}: an offset, what is put there, and what of it is selected.
export function placed(text, { root, heads }, made) {
  const begins = (path, wanted) => wanted.every((name, k) => path[k] === name);
  const wanted = made.into ?? [made.section];
  const last = heads.findLastIndex(({ path }) => begins(path, wanted) && (!made.into || path.length === wanted.length));
  let at = last < 0 || last === heads.length - 1 ? text.length : heads[last + 1].from;
  if (last >= 0 || !made.into) at = afterLast(text, at, last < 0 ? 0 : heads[last].from);
  const before = at > 0 && text[at - 1] !== "\n" ? "\n" : "", gap = made.into || at === 0 ? "" : "\n";
  const put = `${before}${gap}${made.text}`, from = at + put.indexOf(made.select);
  return { at, text: put, from, to: from + made.select.length };
}

// The end of the last line before a place that is neither empty nor a comment, which belongs to what follows.
function afterLast(text, at, least) {
  while (at > least) {
    const line = text.lastIndexOf("\n", at - 2) + 1, words = text.slice(line, at).trim();
    if (words && !words.startsWith("#")) return at;
    at = line;
  }
  return at;
}
