// What computes behind a page: takes what is to be computed from a port, works in slices, and answers.
//
// In a worker the port is the worker itself, without workers one end of a channel in the page.  Messages in:
// {do: "compute", id, model, parameters, settings}, {do: "forget", id}, {do: "stop", id}.  Out: {ready}, {failed} where
// nothing can be computed, {id, progress} of long runs, {id, run}, {id, trust} when the horizon is known, {id, error} in
// plain words.  One motion is computed at a time; a horizon only while nothing else waits.

import { CoreModel } from "./core_model.js";
import { bytesFrom, openCore } from "./core.js";
import { openTape } from "./tape.js";
import { shownOf } from "./core_unread.js";

const SLICE = 12; // milliseconds between two looks at the messages
const TELL = 250; // milliseconds between two words of progress

/** Open the models of a page, data by name, whose functions are on a tape, and serve a port. */
export async function serve(port, engineText, tape, models) {
  try {
    const engine = await openCore(await bytesFrom(engineText)), functions = await openTape(tape), opened = {};
    for (const [name, data] of Object.entries(models)) opened[name] = await CoreModel.open(engine, data, functions);
    serveModels(port, opened);
    port.postMessage({ ready: true });
  } catch (error) {
    port.postMessage({ failed: error.message });
  }
}

function serveModels(port, models) {
  const waiting = new Map(), trusting = new Map(); // tasks by number, and by slot: horizons that are still unknown
  let busy = false;
  const channel = new MessageChannel();
  const soon = () => channel.port2.postMessage(0); // a pause that lets messages in, shorter than a timer's
  const move = (task) => {
    task.first ??= models[task.model].begin(task.parameters, task.settings);
    if (!task.first.advance(SLICE)) return void tellProgress(port, task);
    waiting.delete(task.id);
    task.made = task.first.result();
    answer(port, task.id, { ...task.made, ...shownOf(task.made, models[task.model].data.result.told, task.made.between) });
    if (!task.made.trust.pending || task.model !== "model") return;
    if (task.first.stopped) giveUp(task); // nobody waits twice
    else trusting.set(task.slot, task);
  };
  const trust = (task) => {
    task.second ??= task.first.second();
    if (!task.second.advance(SLICE)) return;
    trusting.delete(task.slot);
    const said = { ...task.made.trust, ...task.first.agreement(task.second), pending: false };
    port.postMessage({ id: task.id, trust: task.first.trusted(said) });
  };
  const giveUp = (task) => { // a horizon that cannot be known is not waited for
    trusting.delete(task.slot);
    const said = { ...task.made.trust, pending: false };
    port.postMessage({ id: task.id, trust: task.first.trusted(said) });
  };
  channel.port1.onmessage = () => {
    const [task] = waiting.values(), [quiet] = trusting.values();
    try {
      if (task) move(task);
      else if (quiet) trust(quiet);
    } catch (error) {
      if (task) port.postMessage({ id: task.id, error: error.message });
      if (task) waiting.delete(task.id);
      else giveUp(quiet);
    }
    busy = waiting.size + trusting.size > 0;
    if (busy) soon();
  };
  port.onmessage = ({ data }) => {
    const task = waiting.get(data.id);
    if (data.do === "forget") waiting.delete(data.id);
    else if (data.do === "stop") {
      if (task?.first) task.first.stopped = true;
      else if (task && waiting.delete(data.id)) port.postMessage({ id: data.id, error: "it was stopped before it had begun" });
    } else {
      waiting.set(data.id, data);
      trusting.delete(data.slot);
    }
    if (!busy && waiting.size) {
      busy = true;
      soon();
    }
  };
}

function tellProgress(port, task) {
  const now = performance.now();
  if (now - (task.told ?? task.first.began) < TELL) return;
  task.told = now;
  port.postMessage({ id: task.id, progress: task.first.run.progress });
}

function answer(port, id, made) {
  const { columns, t, written, ...rest } = made, rows = t.length, data = new Float64Array(rest.names.length * rows);
  rest.names.forEach((name, c) => data.set(columns[name], c * rows));
  const times = t.slice();
  port.postMessage({ id, run: { ...rest, times, data } }, [times.buffer, data.buffer]);
}
