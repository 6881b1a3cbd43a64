// What may stand at a place of the model text: keys and choices from the schema of the model file, names from the text.

const KINDS = { points: "point", joints: "joint", bodies: "body", materials: "material" };

export class Entries {
  constructor({ parts, whole }) {
    this.parts = parts;
    this.whole = whole;
  }

  // A part with its alternatives side by side; what is said of all of them is said of each.
  expand(number, about) {
    const part = this.parts[number], words = part.about ?? about;
    if (!part.either) return [{ ...part, about: words }];
    return part.either.flatMap((one) => this.expand(one, words));
  }

  // The parts that describe what is at a path, as far as what is written leaves them open.
  at(root, path) {
    let parts = this.expand(this.whole), written = root;
    for (const step of path) {
      parts = narrowed(this, parts, written, step).flatMap((part) => this.below(part, step));
      written = written instanceof Map || Array.isArray(written) ? (written instanceof Map ? written.get(step) : written[step]) : undefined;
    }
    return { parts: distinct(parts), written };
  }

  below(part, step) {
    if (typeof step === "number") return part.items === undefined ? [] : this.expand(part.items, part.about);
    if (part.keys && Object.hasOwn(part.keys, step)) return this.expand(part.keys[step]);
    return part.any === undefined ? [] : this.expand(part.any);
  }

  // Keys that may be added to a table: [{label, about, detail, parts}], those that are needed first.
  keys(root, path, typing = "") {
    const { parts, written } = this.at(root, path), table = written instanceof Map ? written : new Map();
    const open = narrowed(this, parts, table, typing), found = new Map();
    for (const part of open) {
      for (const [key, number] of Object.entries(part.keys ?? {})) {
        if (table.has(key) && key !== typing) continue;
        const entry = found.get(key) ?? { label: key, about: "", parts: [], needed: 0 };
        entry.parts.push(...this.expand(number));
        entry.about ||= this.parts[number].about ?? entry.parts[0].about ?? "";
        entry.needed += (part.required ?? []).includes(key);
        found.set(key, entry);
      }
    }
    const all = [...found.values()];
    for (const entry of all) entry.detail = entry.needed === open.length ? "needed" : "";
    return all.sort((a, b) => (b.detail > a.detail) - (a.detail > b.detail));
  }

  // Values that may stand at a path: [{label, about, detail, plain}].
  values(root, path) {
    const { parts } = this.at(root, path), found = new Map();
    const add = (label, about, detail, plain = false) => { if (!found.has(label)) found.set(label, { label, about: about ?? "", detail, plain }); };
    for (const part of parts) {
      if (part.const !== undefined) add(String(part.const), part.about, "", typeof part.const !== "string");
      for (const value of part.enum ?? []) add(String(value), meaning(this, parts, value) ?? part.about, value === part.default ? "usual" : "", typeof value !== "string");
      if (part.type === "boolean") for (const value of ["true", "false"]) add(value, part.about, String(part.default) === value ? "usual" : "", true);
      if (part.names) for (const name of namesOf(root, part.names)) add(name, part.about, KINDS[part.names]);
      for (const value of part.examples ?? []) add(value, part.about, "");
      if (part.type?.includes?.("number") && part.type.includes("string")) for (const name of tableOf(root, "parameters").keys()) add(name, part.about, "parameter");
    }
    return [...found.values()];
  }
}

// Those alternatives that what is written allows; the key that is being written counts for none of them.
function narrowed(entries, parts, written, except) {
  if (!(written instanceof Map) || parts.length < 2) return parts;
  const others = [...written].filter(([key]) => key !== except);
  const clashes = (part) => others.some(([key, value]) => {
    const constant = part.keys && Object.hasOwn(part.keys, key) ? entries.parts[part.keys[key]].const : undefined;
    return constant !== undefined && constant !== value;
  });
  const allowed = parts.filter((part) => part.keys && !clashes(part)), chosen = allowed.length ? allowed : parts;
  const whole = chosen.filter((part) => others.every(([key]) => part.any !== undefined || (part.keys && Object.hasOwn(part.keys, key))));
  return whole.length ? whole : chosen;
}

function distinct(parts) {
  const seen = new Map();
  for (const part of parts) seen.set(JSON.stringify(part), part);
  return [...seen.values()];
}

// What a choice means, where it may also be written as a table that begins with it.
function meaning(entries, parts, value) {
  for (const part of parts) {
    const model = part.keys?.model;
    if (model !== undefined && entries.parts[model].const === value) return entries.parts[model].about;
  }
  return undefined;
}

export function tableOf(root, name) {
  const table = root.get(name);
  return table instanceof Map ? table : new Map();
}

// Points of a body, as the text names them.
export function pointsOf(body) {
  if (!(body instanceof Map)) return [];
  const ends = Array.isArray(body.get("bar")) ? body.get("bar") : [], more = body.get("points");
  return [...ends.filter((name) => typeof name === "string" && name), ...(more instanceof Map ? more.keys() : [])];
}

export function namesOf(root, kind) {
  if (kind === "joints" || kind === "materials") return [...tableOf(root, kind).keys()];
  const bodies = [["ground", tableOf(root, "ground")], ...tableOf(root, "bodies")];
  if (kind === "bodies") return bodies.map(([name]) => name);
  return bodies.flatMap(([name, body]) => pointsOf(body).map((point) => `${name}.${point}`));
}
