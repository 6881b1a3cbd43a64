// The engine behind a page: takes what is to be computed from a port, works in slices, and answers.
//
// In a worker the port is the worker itself, without workers one end of a channel in the page.  Messages in:
// {do: "compute", id, model, parameters, settings}, {do: "forget", id}.  Out: {id, run}, {id, trust} when the horizon is
// known, {id, error} in plain words.  One motion is computed at a time; a horizon only while nothing else waits.

import { advanceRun, beginRun, beginSecond, endRun } from "./engine.js";
import { agreement } from "./horizon.js";
import { trustLines } from "./trust_words.js";

const SLICE = 12; // milliseconds between two looks at the messages

export function serveModels(port, models) {
  const waiting = new Map(), trusting = new Map(); // tasks by number, and by slot: horizons that are still unknown
  let busy = false;
  const channel = new MessageChannel();
  const soon = () => channel.port2.postMessage(0); // a pause that lets messages in, shorter than a timer's
  const move = (task) => {
    task.first ??= begunFor(models[task.model], { ...models.settings, ...task.settings }, task.parameters);
    if (!advanceRun(task.first, SLICE)) return;
    waiting.delete(task.id);
    answer(port, task);
    if (task.first.written > 1 && task.model === "model") trusting.set(task.slot, task);
  };
  const trust = (task) => {
    task.second ??= beginSecond(task.first);
    if (!advanceRun(task.second, SLICE)) return;
    trusting.delete(task.slot);
    port.postMessage({ id: task.id, trust: endRun(task.first, agreement(task.first, task.second)).trust });
  };
  const giveUp = (task) => { // a horizon that cannot be known is not waited for
    trusting.delete(task.slot);
    const { trust: known } = endRun(task.first), said = { ...known, pending: false };
    port.postMessage({ id: task.id, trust: { ...said, text: trustLines(said) } });
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
    if (data.do === "forget") waiting.delete(data.id);
    else {
      waiting.set(data.id, data);
      trusting.delete(data.slot);
    }
    if (!busy && waiting.size) {
      busy = true;
      soon();
    }
  };
  port.postMessage({ ready: true });
}

// a model need not have all parameters of another one
function begunFor(model, settings, parameters) {
  const known = Object.entries(parameters).filter(([name]) => name in model.parameters);
  return beginRun(model, settings, Object.fromEntries(known));
}

function answer(port, task) {
  const { columns, t, ...rest } = endRun(task.first), rows = t.length;
  const data = new Float64Array(rest.names.length * rows);
  rest.names.forEach((name, c) => data.set(columns[name], c * rows));
  const times = t.slice();
  port.postMessage({ id: task.id, run: { ...rest, times, data } }, [times.buffer, data.buffer]);
}
