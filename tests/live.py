"""Live pages in node: the engine that computes in the browser, run from a test."""

import json
import subprocess
from functools import cache
from pathlib import Path

import numpy as np

import rattle as rt
from rattle.pages.live_program import live_program, method_settings

VIEWER = Path(rt.__file__).parent / "pages" / "viewer"
SCRIPT = """
import fs from "node:fs";
import * as model from "./model.mjs";
import * as ideal from "./ideal.mjs";
import { runLive, runWithHorizon } from "%s/engine.js";
const { settings, parameters, horizon } = JSON.parse(fs.readFileSync("job.json"));
if (model.needsIdeal) model.setIdeal(ideal.start);
let said;
try {
  const run = (horizon ? runWithHorizon : runLive)(model, settings, parameters);
  fs.writeFileSync("out.bin", Float64Array.from(run.names.flatMap((name) => [...run.columns[name]])));
  said = { ...run, n: run.t.length, t: [...run.t], columns: null };
} catch (error) {
  said = { error: error.message };
}
console.log(JSON.stringify(said, (_, x) => (Number.isNaN(x) ? null : x)));
"""


@cache
def program_of(name):
    """The live program of an example, and the example."""
    m = rt.example(name)
    return live_program(m), m


def computed(folder, live, parameters=None, horizon=False, **settings):
    """What the engine makes of a live program: its run, with `columns` as arrays."""
    (folder / "model.mjs").write_text(live.module, encoding="utf-8")
    (folder / "ideal.mjs").write_text("" if live.ideal is None else live.ideal.module, encoding="utf-8")
    (folder / "go.mjs").write_text(SCRIPT % VIEWER.as_uri(), encoding="utf-8")
    if "method" in settings:
        settings |= method_settings(settings["method"])
    job = {"settings": {**live.settings, **settings}, "parameters": parameters or {}, "horizon": horizon}
    (folder / "job.json").write_text(json.dumps(job))
    done = subprocess.run(["node", "go.mjs"], cwd=folder, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    run = json.loads(done.stdout)
    if "error" not in run:
        data = np.fromfile(folder / "out.bin").reshape(len(run["names"]), run["n"])
        run["columns"] = dict(zip(run["names"], data, strict=True))
    return run
