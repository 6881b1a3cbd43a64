// What leaves a page: a model file with other parameters, and curves as a table.

// Lets the reader save a text as a file.
export function downloadText(name, text) {
  const address = URL.createObjectURL(new Blob([text], { type: "text/plain" })), link = document.createElement("a");
  Object.assign(link, { href: address, download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(address), 10000);
}

// Curves of a motion as CSV: one row per instant, the first line names and units.
export function runTable(motion, names) {
  const head = ["t [s]", ...names.map((name) => `${name} [${motion.unit(name)}]`)].map((one) => (/[",]/.test(one) ? `"${one.replaceAll('"', '""')}"` : one));
  const curves = names.map((name) => motion.curve(name));
  const rows = Array.from(motion.t, (t, k) => [t, ...curves.map((one) => one[k])].join(","));
  return `${[head.join(","), ...rows].join("\n")}\n`;
}

// A model file (TOML) in which changed parameters have their new values [SI].
export function modelFile(text, set, knobs) {
  const lines = text.split("\n");
  let inside = false;
  return lines.map((line) => {
    const table = /^\s*\[+\s*([^\]]+?)\s*\]+/.exec(line);
    if (table) inside = /^parameters(\.|$)/.test(table[1]) ? table[1].slice(11) || true : false;
    const entry = inside ? /^(\s*"?([\w-]+)"?\s*=\s*)(.*)$/.exec(line) : null;
    const knob = entry && (inside === true ? knobs.get(entry[2]) : entry[2] === "value" && knobs.get(inside));
    if (!knob || set[knob.name] === knob.value) return line;
    return entry[1] + withValue(entry[3], set[knob.name]);
  }).join("\n");
}

function withValue(written, value) {
  const pair = /^(\{(?:[^"]|"[^"]*")*?\bvalue\s*=\s*)("[^"]*"|[^,}\s]+)(.*)$/.exec(written);
  if (pair) return pair[1] + value + pair[3];
  const plain = /^("[^"]*"|[^#\s]+)(.*)$/.exec(written);
  return plain ? value + plain[2] : written;
}
