"""An ES module that moves one mechanism with the compiled kernels: contacts, impacts, friction, oil and states too.

It holds the engine of pages, a run before its first step, and what turns its rows into result curves.
"""

from __future__ import annotations

import base64
import json
import re
from importlib import resources
from typing import Any

from rattle.mechanism import Mechanism
from rattle.pages.engine import engine_of_pages
from rattle.pages.result_data import result_data
from rattle.pages.run_image import image_of
from rattle.trace.javascript import BITS

SCRIPTS = ("core.js", "core_run.js", "trust_words.js", "core_result.js")
MAIN = """
const DATA = @data@;
const engine = await openCore(await bytesFrom(DATA.engine));
const content = await bytesFrom(DATA.content);

/** Names of what is in a row: t, then the outputs; and their units. */
export const names = DATA.names;
export const units = DATA.units;

/**
 * The motion from the start to tEnd [s], not beyond the end that the model was written for.
 *
 * Returns { rows, events, peaks, success, message, statistics }: rows as names lists them; events { t, joint, kind,
 * normal_speed, duration, peak_force, impulse, energy_lost }; peaks by name: value, time, root mean square [SI].
 */
export function run(tEnd = DATA.run.end) {
  if (!(typeof tEnd === "number" && tEnd > 0 && tEnd <= DATA.run.end))
    throw new RangeError(`tEnd = ${tEnd}: a time above 0 is expected, up to ${DATA.run.end} s, the end that it has`);
  const moved = new CoreRun(engine, { description: { ...DATA.run, end: tEnd }, content });
  moved.advance();
  const { t, columns, peaks, events, success, message } = resultOf(moved, DATA.result, resultFunctions);
  const rows = Array.from(t, (at, k) => [at, ...DATA.result.names.map((name) => columns[name][k])]);
  return { rows, events, peaks, success, message, statistics: moved.result().statistics };
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


def compiled_module(m: Mechanism, title: str, t_end: float, step: float | None) -> str:
    """The text of the module.

    t_end: of its run [s]; step: the longest one [s].  Raises InputError for laws in Python.
    """
    image, (result, functions) = image_of(m, t_end, step=step), result_data(m, t_end)
    data: dict[str, Any] = {
        "names": ["t", *result["names"]], "units": ["s", *result["units"].values()], "result": result,
        "run": image.description, "content": base64.b64encode(image.content).decode(),
        "engine": base64.b64encode(engine_of_pages()).decode(),
    }  # fmt: skip
    viewer = resources.files("rattle.pages") / "viewer"
    scripts = [
        (viewer / name).read_text(encoding="utf-8")
        for name in ("core.js", "core_run.js", "trust_words.js", "core_result.js")
    ]
    joined = "\n".join(re.sub(r"^import .*$|^export (?=class|async|function)", "", one, flags=re.M) for one in scripts)
    safe = title.replace("*/", "* /")
    head = (
        f"/** {safe}\n *\n * The motion with contacts and events: import {{ run, names, units }}, then run(tEnd) [s].\n"
    )
    head += " * In node, `node FILE [tEnd]` prints it as CSV.  All numbers are in SI units. */\n"
    text = json.dumps(data, separators=(",", ":")).replace("<", "\\u003c")
    return "\n".join([head + joined, BITS, functions, MAIN.replace("@data@", text)])
