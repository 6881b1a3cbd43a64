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
const sizeOf = (shape) => shape.reduce((a, b) => a * b, 1);
const shapesOf = ({ arrays, times: [count], width, more = {} }) =>
  [[3 * arrays.length], [count], [count, width], ...arrays.map((one) => one.slice(0, -1)), ...Object.values(more).map(([, , ...shape]) => shape)];

/** The memory of an instance of an engine with room for arrays of these shapes, and its kernels. */
export class CoreRoom {
  constructor(engine, shapes) {
    const { module, about } = engine, calls = new WebAssembly.Instance(module, {}).exports, { memory } = calls;
    Object.assign(this, { engine, about, calls, memory, end: Math.ceil(about.free / CELL) * CELL, arrays: [] });
    this.reserve([[8], ...shapes]);
    this.result = this.array([8]).at;
  }

  /** Room for further arrays. */
  reserve(shapes) {
    const { memory } = this, needed = this.end + CELL * shapes.reduce((sum, shape) => sum + Math.max(sizeOf(shape), 1), 0);
    try {
      memory.grow(Math.max(0, Math.ceil((needed - memory.buffer.byteLength) / 65536)));
    } catch {
      throw new CoreError("failed", `the run needs ${Math.ceil(needed / 2 ** 20)} MB, more than the browser gives`);
    }
    this.word = new DataView(memory.buffer);
    for (const one of this.arrays) one.data = this.numbers(one); // memory that grows is taken from all views
  }

  numbers({ at, shape, kind }) {
    const { buffer } = this.memory, size = sizeOf(shape);
    return kind[0] === "f" ? new Float64Array(buffer, at, size) : new BigInt64Array(buffer, at, size);
  }

  /** A new array; offset: of its numbers in the content, or -1. */
  array(shape, kind = "f1", content = null, offset = -1) {
    const made = { at: this.end, shape, kind }, bytes = CELL * sizeOf(shape);
    this.end += Math.max(bytes, CELL);
    if (offset >= 0) new Uint8Array(this.memory.buffer, made.at, bytes).set(content.subarray(offset, offset + bytes));
    this.arrays.push(made);
    return Object.assign(made, { data: this.numbers(made) });
  }

  /** Call a kernel with numbers, arrays and workspaces; returns its first result. */
  call(name, ...given) {
    const [result, ...letters] = this.about.calls[name];
    const flat = letters.flatMap((letter, k) => {
      const one = given[k];
      if (letter === "h") return one.table.at;
      return letter === "f" ? one : letter === "i" ? BigInt(one) : [one.at, ...one.shape.map(BigInt)];
    });
    if (this.calls[`call ${name}`](this.result, ...flat)) throw new CoreError("failed", this.told());
    return result[0] === "i" ? Number(this.word.getBigInt64(this.result, true)) : this.word.getFloat64(this.result, true);
  }

  told() {
    const bytes = new Uint8Array(this.memory.buffer), at = this.word.getInt32(this.about.told, true);
    return at ? new TextDecoder().decode(bytes.subarray(at, bytes.indexOf(0, at))) : "the engine stopped without a word";
  }
}

/** A workspace in the memory of an instance: arrays by name, and kernels that may be called. */
export class CoreMemory {
  /** Workspaces in one memory, of which a kernel may get several. */
  static together(engine, images) {
    const room = new CoreRoom(engine, images.flatMap(({ description }) => shapesOf(description)));
    return images.map((image) => new CoreMemory(room, image));
  }

  constructor(room, { description, content }) {
    const { about } = room, { layout, arrays, tables, times: [count, stored, last], width, more = {} } = description;
    if (layout !== about.layout)
      throw new CoreError("version", "the model was written by another version of rattle than its engine");
    Object.assign(this, { room, about, arrays: {}, table: room.array([3 * arrays.length], "i1") });
    about.arrays.forEach(([name, kind], k) => {
      const { data } = this.arrays[name] = room.array(arrays[k].slice(0, -1), kind, content, arrays[k].at(-1));
      this.announce(name, k);
      if (name.endsWith("_table")) data.forEach((_, n) => { data[n] = BigInt(this.numberOf(tables[name]?.[n], name)); });
    });
    for (const [name, [kind, offset, ...shape]] of Object.entries(more)) this[name] = room.array(shape, kind, content, offset); // no part of a workspace
    this.times = room.array([count], "f1", content, stored);
    if (stored < 0) this.times.data.forEach((_, k, every) => { every[k] = k === count - 1 ? last : k * (last / (count - 1)); });
    this.rows = room.array([count, width], "f2");
  }

  // tell the kernels where an array is, as a handle of `rattle.jit.workspace` has it
  announce(name, k) {
    const { at, shape } = this.arrays[name];
    this.table.data.set([at, shape[0], shape.at(-1)].map(BigInt), 3 * k);
  }

  /** Give arrays another number of rows, which are zero. */
  enlarge(rows) {
    const { room, about, arrays } = this, shapes = Object.entries(rows).map(([name, count]) => [name, [count, ...arrays[name].shape.slice(1)]]);
    room.reserve(shapes.map(([, shape]) => shape));
    for (const [name, shape] of shapes) arrays[name] = room.array(shape, arrays[name].kind);
    about.arrays.forEach(([name], k) => this.announce(name, k));
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
    return this.room.call(name, this, ...given);
  }
}
