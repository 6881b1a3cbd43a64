// Motions computed by the page itself: one worker, made from a text in the page, and what is asked of it.
//
// Every slot (the set A of parameters, the set B, the mechanism without play) has at most one task in work; of those that
// come meanwhile only the latest is kept, and the promises of all end with it.

import { unpack } from "./data.js";
import { unpackedText } from "./unpack.js";

const PATIENCE = 400; // milliseconds after which a task that is out of date is given up

export class LiveSource {
  // live: of the scene; heard(slot, trust): called when the horizon of the last motion of a slot is known; progress(share):
  // of the run that is computed
  constructor(live, heard, progress = () => {}) {
    Object.assign(this, { heard, progress, slots: new Map(), tasks: new Map(), count: 0, gone: false });
    this.ready = new Promise((resolve, reject) => { Object.assign(this, { opened: resolve, refused: reject }); });
    this.ready.catch(() => {}); // whoever waits for a motion hears it
    this.port = openPort(live).then((port) => {
      port.onmessage = ({ data }) => this.take(data);
      this.opened();
      return port;
    });
    this.port.catch(this.refused);
  }

  // The run that is computed ends where it is, and what was computed is shown.
  stop() {
    for (const { now } of this.slots.values()) if (now) this.port.then((port) => port.postMessage({ do: "stop", id: now.id }), () => {});
  }

  // A promise of the run for these parameters; null if a later wish of this slot came first and was refused.
  compute(slot, model, parameters, settings) {
    return new Promise((resolve, reject) => {
      const one = this.slots.get(slot) ?? { now: null, next: null };
      this.slots.set(slot, one);
      const waiters = one.next ? one.next.waiters : [];
      for (const waiter of waiters) waiter.last = false;
      waiters.push({ resolve, reject, last: true });
      one.next = { slot, model, parameters: { ...parameters }, settings: { ...settings }, waiters };
      if (!one.now) this.start(one);
      else this.hurry(one);
    });
  }

  // A task that is out of date may go on for a while: most are there before it is over.
  hurry(one) {
    const { id, began } = one.now, left = PATIENCE - (performance.now() - began);
    if (left <= 0) return void this.giveUp(one);
    clearTimeout(one.timer);
    one.timer = setTimeout(() => { if (one.now?.id === id && one.next && !this.gone) this.giveUp(one); }, left);
  }

  // Nothing of a slot is wanted any more.
  drop(slot) {
    const one = this.slots.get(slot);
    if (!one) return;
    this.slots.delete(slot);
    for (const [id, other] of this.tasks) {
      if (other !== one) continue;
      this.tasks.delete(id);
      this.port.then((port) => port.postMessage({ do: "forget", id }), () => {});
    }
    for (const { resolve } of [...(one.now?.waiters ?? []), ...(one.next?.waiters ?? [])]) resolve(null);
    Object.assign(one, { now: null, next: null });
  }

  start(one) {
    const task = one.next;
    Object.assign(one, { now: task, next: null });
    Object.assign(task, { id: ++this.count, began: performance.now() });
    for (const [id, other] of this.tasks) if (other === one && id !== task.id) this.tasks.delete(id);
    this.tasks.set(task.id, one);
    const { waiters, began, ...message } = task;
    this.port.then((port) => port.postMessage({ do: "compute", ...message }), (error) => this.take({ id: task.id, error: error.message }));
  }

  // A task that has taken long is dropped for the latest one; those who wait for it wait for that one.
  giveUp(one) {
    const { id, waiters } = one.now;
    this.port.then((port) => port.postMessage({ do: "forget", id }), () => {});
    this.tasks.delete(id);
    for (const waiter of waiters) waiter.last = false;
    one.next.waiters.unshift(...waiters);
    one.now = null;
    this.start(one);
  }

  take({ id, run, trust, error, progress }) {
    const one = this.tasks.get(id);
    if (!one || this.gone) return;
    if (progress !== undefined) return void this.progress(progress);
    if (trust) return void this.heard(one.done, trust);
    const { waiters, slot } = one.now;
    Object.assign(one, { now: null, done: slot });
    const made = error === undefined ? unpackLive(run) : null;
    for (const { resolve, reject, last } of waiters) {
      if (made || !last) resolve(made);
      else reject(new Error(error));
    }
    if (one.next) this.start(one);
  }

  destroy() {
    this.gone = true;
    this.port.then((port) => (port.terminate ? port.terminate() : port.close()), () => {});
    for (const one of this.slots.values()) {
      for (const { resolve } of [...(one.now?.waiters ?? []), ...(one.next?.waiters ?? [])]) resolve(null);
    }
  }
}

// The same for a host that computes: a studio, a kernel of a notebook.  host.compute(parameters, {t_end, progress}) gives
// {promise, cancel()}; the latest wish of a slot counts, and whoever waited for an earlier one is served by it.
export class HostSource {
  constructor(host) {
    Object.assign(this, { host, slots: new Map() });
  }

  compute(slot, model, parameters, settings) {
    if (model !== "model") return Promise.resolve(null);
    this.slots.get(slot)?.cancel?.();
    const task = this.host.compute(parameters, settings);
    this.slots.set(slot, task);
    return task.promise.then((run) => (this.slots.get(slot) === task ? unpack(run) : null), (error) => {
      if (this.slots.get(slot) === task) throw error;
      return null;
    });
  }

  destroy() {
    for (const task of this.slots.values()) task.cancel?.();
  }
}

function unpackLive({ times, data, ...run }) {
  const columns = {};
  run.names.forEach((name, c) => { columns[name] = data.subarray(c * times.length, (c + 1) * times.length); });
  return { ...run, t: times, columns };
}

// A worker; in a browser that allows none, the same text in the page itself, which works in small slices.
async function openPort(live) {
  const text = live.text ?? (await unpackedText(live.packed)), address = URL.createObjectURL(new Blob([text], { type: "text/javascript" }));
  try {
    return await startedWorker(address);
  } catch (error) {
    if (error.failed) throw error;
    return await portInPage(address);
  } finally {
    URL.revokeObjectURL(address);
  }
}

function startedWorker(address) {
  return new Promise((resolve, reject) => {
    const worker = new Worker(address);
    worker.onmessage = ({ data }) => (data.failed ? reject(failure(data.failed)) : resolve(worker)); // it says that it is there
    worker.onerror = (event) => {
      event.preventDefault?.();
      worker.terminate();
      reject(new Error("no worker"));
    };
  });
}

function portInPage(address) {
  return new Promise((resolve, reject) => {
    const script = document.createElement("script"), channel = new MessageChannel();
    script.src = address;
    script.onload = () => {
      script.remove();
      const serve = globalThis.rattleLive;
      delete globalThis.rattleLive;
      if (!serve) return void reject(new Error("this browser cannot compute the motion"));
      channel.port2.onmessage = ({ data }) => (data.failed ? reject(failure(data.failed)) : resolve(channel.port2));
      serve(channel.port1);
    };
    script.onerror = () => reject(new Error("this browser cannot compute the motion"));
    document.head.append(script);
  });
}

// Nothing can be computed in this browser, worker or not.
function failure(message) {
  return Object.assign(new Error(message), { failed: true });
}
