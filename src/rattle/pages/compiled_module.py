"""An ES module that moves one mechanism with the compiled kernels: contacts, impacts, friction, oil and states too.

It holds the engine of pages, a run before its first step, and what turns its rows into result curves.
"""

from __future__ import annotations

import base64
import json
import re
from importlib import resources
from typing import Any

import numpy as np

from rattle.analyses.dynamics.events import KINDS
from rattle.equations import motion, unilateral
from rattle.jit import layout as at
from rattle.mechanism import Mechanism
from rattle.pages.engine import engine_of_pages
from rattle.pages.run_image import image_of
from rattle.results.columns import columns, width
from rattle.solvers.contacts.penetration import ESCAPED
from rattle.solvers.state_switches import SLIDES
from rattle.solvers.step_audit import UNSOUND

BALANCE = "energy.balance"  # which the module computes
WORDS = {  # why a run ends before its end, by status; `rattle run` tells more
    motion.NOT_FINITE: "a load, driver or signal has no finite value, or the motion diverges",
    motion.STEP_TOO_SMALL: "no step is short enough: a singular position, or a load without a finite value",
    ESCAPED: "a contact is inside its wall",
    UNSOUND: "the loops do not close, or the energy error is above its limit",
    SLIDES: "an expression switches to and fro without end",
    unilateral.NO_SOLUTION: "the forces of the contacts have no solution",
    unilateral.NOT_UNIQUE: "the forces of the contacts are not unique",
    unilateral.LOCKED: "friction locks a contact",
    unilateral.CHATTER: "contacts change without end",
    unilateral.NOT_FOUND: "the forces of the contacts were not found",
}
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
 * Returns { rows, events, success, message, statistics }: rows as names lists them; events { t, joint, kind,
 * normal_speed, duration, peak_force, impulse, energy_lost } [SI], the last four of contacts and impacts; contacts
 * that last to the end are not among them.
 */
export function run(tEnd = DATA.run.end) {
  if (!(typeof tEnd === "number" && tEnd > 0 && tEnd <= DATA.run.end))
    throw new RangeError(`tEnd = ${tEnd}: a time above 0 is expected, up to ${DATA.run.end} s, the end that it has`);
  const one = new CoreRun(engine, { description: { ...DATA.run, end: tEnd }, content });
  one.advance();
  const { t, rows: raw, width, status, success, statistics, events } = one.result(), rows = [];
  t.forEach((at, k) => {
    const row = raw.subarray(k * width, (k + 1) * width);
    rows.push([at, ...DATA.columns.map((column) => (column < 0 ? total(row) - total(raw) : row[column]))]);
  });
  const message = success ? "" : `cannot go on at t = ${one.t} s: ${DATA.words[status] ?? "the run stopped"}`;
  return { rows, events: events.map(eventOf).sort((a, b) => a.t - b.t), success, message, statistics };
}

// kinetic + potential - work + dissipated
function total(row) {
  const [kinetic, potential, work, dissipated] = row.subarray(DATA.energies, DATA.energies + 4);
  return kinetic + potential - work + dissipated;
}

function eventOf({ t, joint, kind, values: [normal_speed, duration, peak_force, impulse, energy_lost] }) {
  const plain = DATA.kinds[kind], about = { t, joint, kind: DATA.words_of[joint]?.[plain] ?? plain, normal_speed };
  if (plain !== "contact" && plain !== "impact") return about;
  return { ...about, duration, peak_force, impulse, energy_lost };
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


def compiled_module(m: Mechanism, title: str, t_end: float, step: float | None) -> tuple[str, list[str]]:
    """The text of the module, and names of result curves that it leaves out.

    t_end: of its run [s]; step: the longest one [s].  Raises InputError for laws in Python.
    """
    image = image_of(m, t_end, step=step)
    places, units, left_out = _places(m)
    names = list(places)
    data: dict[str, Any] = {
        "names": ["t", *names], "units": ["s", *(units[name] for name in names)], "columns": list(places.values()),
        "run": image.description, "content": base64.b64encode(image.content).decode(),
        "engine": base64.b64encode(engine_of_pages()).decode(), "kinds": KINDS, "words": WORDS,
        "words_of": _words_of(m),
        "energies": width(m.system) - at.ENERGIES,
    }  # fmt: skip
    viewer = resources.files("rattle.pages") / "viewer"
    scripts = [(viewer / name).read_text(encoding="utf-8") for name in ("core.js", "core_run.js")]
    joined = "\n".join(re.sub(r"^import .*$|^export (?=class|async|function)", "", one, flags=re.M) for one in scripts)
    safe = title.replace("*/", "* /")
    head = (
        f"/** {safe}\n *\n * The motion with contacts and events: import {{ run, names, units }}, then run(tEnd) [s].\n"
    )
    head += " * In node, `node FILE [tEnd]` prints it as CSV.  All numbers are in SI units. */\n"
    text = json.dumps(data, separators=(",", ":")).replace("<", "\\u003c")
    return head + joined + MAIN.replace("@data@", text), left_out


def _words_of(m: Mechanism) -> dict[str, dict[str, str]]:
    """What joints call their events, where that is not what contacts do: a clutch locks."""
    return {name: dict(words) for name, joint in m.model.joints.items() if (words := joint.leaf.events)}


def _places(m: Mechanism) -> tuple[dict[str, int], dict[str, str], list[str]]:
    """Which number of a written row is which result curve, by name; their units; names of those that are none of them.

    Numbers that differ everywhere show it, as if they had been written by a run.
    """
    raw = np.random.default_rng(1).uniform(0.5, 1.0, (2, width(m.system)))
    made, names, units = columns(m.system, raw)
    places, left_out = {}, []
    for name, values in zip(names, made.T, strict=True):
        same = np.flatnonzero((raw == values[:, None]).all(axis=0))
        if len(same) or name == BALANCE:
            places[name] = int(same[0]) if len(same) else -1
        else:
            left_out.append(name)
    return places, units, left_out
