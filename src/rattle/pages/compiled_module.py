"""An ES module that moves one mechanism with the compiled kernels: contacts, impacts, friction, oil and states too.

It holds what a live page holds behind its pictures: the engine, and the model for any values of its parameters.
"""

from __future__ import annotations

from collections.abc import Mapping

from rattle.errors import InputError
from rattle.mechanism import Mechanism
from rattle.pages.live_model import live_model
from rattle.pages.page import engine_in_text, in_function, model_text
from rattle.pages.viewer_text import joined, viewer_files

MAIN = """
const model = await (async () => {
  const { data, tape } = @model@;
  return CoreModel.open(await openCore(await bytesFrom("@engine@")), data, await openTape(tape));
})();

/** Names of what is in a row: t, then the outputs; and their units. */
export const names = ["t", ...model.data.result.names];
export const units = ["s", ...model.data.result.names.map((name) => model.data.result.units[name])];
/** Values of the parameters in the model [SI], by name. */
export const parameters = Object.fromEntries(model.names.map((name, k) => [name, model.own[k]]));

/**
 * The motion from the start to tEnd [s], with outputs every `step` [s] and other values of parameters [SI], by name.
 *
 * Returns { t, columns, rows, events, peaks, success, message, statistics }: columns by name; rows as names lists
 * them; events { t, joint, kind,
 * normal_speed, duration, peak_force, impulse, energy_lost }; peaks by name: value, time, root mean square [SI].
 */
export function run(tEnd = undefined, step = undefined, p = {}) {
  for (const [value, what] of [[tEnd, "tEnd"], [step, "step"]])
    if (value !== undefined && !(typeof value === "number" && value > 0 && value < Infinity))
      throw new RangeError(`${what} = ${value}: a time above 0 is expected [s]`);
  if (typeof p !== "object" || p === null) throw new TypeError("p: values of parameters by name are expected");
  for (const name of Object.keys(p))
    if (!Object.hasOwn(parameters, name))
      throw new RangeError(`no parameter ${name}; there are ${model.names.join(", ") || "none"}`);
  const moved = model.begin(p, { t_end: tEnd, interval: step });
  moved.advance(Infinity);
  const { t, columns, peaks, success, message, stats, events: lists } = moved.result();
  const events = lists.map((values) => Object.fromEntries(values.map((value, k) => [EVENT_PARTS[k], value])));
  const { steps, rejected, evaluations } = stats;
  return {
    t, columns, events, peaks, success, message, statistics: { steps, rejected, evaluations },
    get rows() { return Array.from(t, (at, k) => [at, ...names.slice(1).map((name) => columns[name][k])]); },
  };
}

/** In node: print the motion as CSV if this file is what node was asked to run. */
if (typeof process === "object" && process.versions?.node && process.argv[1]) {
  const { pathToFileURL } = await import("node:url"), { realpathSync } = await import("node:fs");
  let asked = "";
  try {
    asked = pathToFileURL(realpathSync(process.argv[1])).href;
  } catch {} // node runs something that is no file
  if (asked === import.meta.url) print(process.argv.slice(2));
}

function print(words) {
  try {
    const { rows, message } = run(...words.map(Number));
    console.log([names.join(","), ...rows.map((row) => row.join(","))].join("\\n"));
    if (message) throw new Error(message);
  } catch (error) {
    console.error(error.message);
    process.exitCode = 1;
  }
}
"""


def compiled_module(m: Mechanism, title: str, t_end: float, step: float | None) -> tuple[str, Mapping[str, str]]:
    """The text of the module, and parameters that it cannot change, with the reason.

    t_end: of its run [s]; step: the longest one [s].  Raises TraceError for laws in Python and what else no page moves.
    """
    if step is not None:
        raise InputError("the steps of a module with compiled kernels are those of the model: give step in [simulate]")
    live = live_model(m, t_end, alone=True, derived=True)
    safe = title.replace("*/", "* /")
    head = (
        f"/** {safe}\n *\n * The motion with contacts and events: import {{ run, names, units, parameters }}, then\n"
        " * run(tEnd, step, p).  In node, `node FILE [tEnd]` prints it as CSV.  All numbers are in SI units. */\n"
    )
    main = MAIN.replace("@model@", model_text(live)).replace("@engine@", engine_in_text(live.contacts))
    return head + in_function(joined(viewer_files(), "core_model.js")) + main.replace("</", "<\\/"), live.fixed
