// The kernels of the package, compiled: an engine, and the workspace of a run in its memory.
//
// engine: the module that `rattle.pages.engine` builds.  image: a run before its first step, of
// `rattle.pages.run_image`: { description, content }.

const CELL = 8; // bytes of a number, address or length

/** An error of the engine; `reason` is "unsupported", "version", "kernel" or "failed". */
export class CoreError extends Error {
  constructor(reason, message) {
    super(message);
    this.reason = reason;
  }
}

/** An engine from the bytes of its module, which every run then uses; throws a CoreError where none can run. */
export async function openCore(bytes) {
  if (typeof WebAssembly !== "object") throw new CoreError("unsupported", "this browser has no WebAssembly, which computes the motion");
  let module;
  try {
    module = await WebAssembly.compile(bytes);
  } catch (error) {
    throw new CoreError("unsupported", `this browser cannot compile the engine that computes the motion: ${error.message}`);
  }
  const [section] = WebAssembly.Module.customSections(module, "rattle");
  if (!section) throw new CoreError("version", "these bytes are no engine of rattle");
  return { module, about: JSON.parse(new TextDecoder().decode(section)) };
}

/** Bytes from base64, unpacked if they are compressed. */
export async function bytesFrom(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  if (bytes[0] !== 0x1f || bytes[1] !== 0x8b) return bytes;
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// ---------------------------------------------------------------- memory and calls
/** The workspace of one run in the memory of its own instance: arrays by name, and kernels that may be called. */
export class CoreMemory {
  constructor({ module, about }, { description, content }) {
    if (description.layout !== about.layout)
      throw new CoreError("version", "the model was written by another version of rattle than its engine");
    Object.assign(this, { module, about });
    this.calls = new WebAssembly.Instance(module, {}).exports;
    const sizes = description.arrays.map((one) => one.slice(0, -1).reduce((a, b) => a * b, 1));
    this.end = Math.ceil(about.free / CELL) * CELL;
    const table = this.take(3 * sizes.length);
    const places = sizes.map((size) => this.take(size));
    const [count, stored, last] = description.times, times = this.take(count), rows = this.take(count * description.width);
    const more = Object.entries(description.more ?? {}).map(([name, [kind, offset, ...shape]]) =>
      [name, kind, offset, shape, this.take(shape.reduce((a, b) => a * b, 1))]);
    const result = this.take(8);
    this.grow();
    Object.assign(this, { table, result, arrays: {}, word: new DataView(this.calls.memory.buffer) });
    about.arrays.forEach(([name, kind], k) => {
      const shape = description.arrays[k].slice(0, -1);
      this.arrays[name] = this.view(places[k], shape, kind);
      this.fill(this.arrays[name], content, description.arrays[k].at(-1));
      const row = [places[k], shape[0], shape.at(-1)]; // as a handle of `rattle.jit.workspace` has it
      row.forEach((value, n) => this.word.setBigInt64(table + CELL * (3 * k + n), BigInt(value), true));
    });
    for (const [name, { data }] of Object.entries(this.arrays))
      if (name.endsWith("_table")) data.forEach((_, k) => { data[k] = BigInt(this.numberOf(description.tables[name]?.[k], name)); });
    for (const [name, kind, offset, shape, at] of more) { // arrays that are no part of a workspace
      this[name] = this.view(at, shape, kind);
      this.fill(this[name], content, offset);
    }
    this.times = this.view(times, [count], "f1");
    this.fill(this.times, content, stored);
    if (stored < 0) this.times.data.forEach((_, k, every) => { every[k] = k === count - 1 ? last : k * (last / (count - 1)); });
    this.rows = this.view(rows, [count, description.width], "f2");
  }

  take(cells) {
    const start = this.end;
    this.end += CELL * Math.max(cells, 1);
    return start;
  }

  grow() {
    const { memory } = this.calls, missing = Math.ceil((this.end - memory.buffer.byteLength) / 65536);
    try {
      if (missing > 0) memory.grow(missing);
    } catch {
      throw new CoreError("failed", `the run needs ${Math.ceil(this.end / 2 ** 20)} MB, more than the browser gives`);
    }
  }

  view(at, shape, kind) {
    const size = shape.reduce((a, b) => a * b, 1), { buffer } = this.calls.memory;
    return { at, shape, data: kind[0] === "f" ? new Float64Array(buffer, at, size) : new BigInt64Array(buffer, at, size) };
  }

  fill({ at, data }, content, offset) {
    if (offset >= 0) new Uint8Array(this.calls.memory.buffer, at, data.byteLength).set(content.subarray(offset, offset + data.byteLength));
  }

  // what stands for a kernel in a table; for none, what fails and says the family
  numberOf(kernel, table) {
    if (!kernel) return this.about.traps[table.replace("_table", "").replace("_", " ")];
    const number = this.about.kernels[kernel];
    if (number === undefined) throw new CoreError("kernel", `the engine does not have ${kernel.replace("rattle.place.", "")}`);
    return number;
  }

  row(array, n) {
    const width = array.shape[1];
    return { at: array.at + CELL * n * width, shape: [width], data: array.data.subarray(n * width, (n + 1) * width) };
  }

  /** Call a kernel of the workspace; returns its first result. */
  call(name, ...given) {
    const [result, ...letters] = this.about.calls[name];
    const flat = letters.flatMap((letter, k) => {
      if (letter === "h") return this.table;
      const one = given[k - 1];
      return letter === "f" ? one : letter === "i" ? BigInt(one) : [one.at, ...one.shape.map(BigInt)];
    });
    if (this.calls[`call ${name}`](this.result, ...flat)) throw new CoreError("failed", this.told());
    return result[0] === "i" ? Number(this.word.getBigInt64(this.result, true)) : this.word.getFloat64(this.result, true);
  }

  told() {
    const bytes = new Uint8Array(this.calls.memory.buffer), at = this.word.getInt32(this.about.told, true);
    return at ? new TextDecoder().decode(bytes.subarray(at, bytes.indexOf(0, at))) : "the engine stopped without a word";
  }
}
