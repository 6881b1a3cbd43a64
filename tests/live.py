"""Live pages in node: the program of a page's worker, asked as the page asks it."""

import json
import subprocess
from functools import cache

import numpy as np

import rattle as rt
from rattle.pages.live_model import live_model
from rattle.pages.page import worker_text

SCRIPT = """
const fs = require("node:fs"), vm = require("node:vm");
const { tasks, horizon } = JSON.parse(fs.readFileSync("job.json"));
const answers = [], runs = new Map();
const plain = (_, x) => (Number.isNaN(x) ? null : ArrayBuffer.isView(x) ? Array.from(x) : x);
const finish = () => {
  fs.writeFileSync("answers.json", JSON.stringify(answers, plain));
  process.exit(0);
};
const next = () => {
  const id = answers.length;
  if (id === tasks.length) return finish();
  self.onmessage({ data: { do: "compute", id, slot: "A", model: "model", settings: {}, ...tasks[id] } });
};
const take = ({ ready, failed, id, run, trust, error }) => {
  if (failed) return console.error(failed), process.exit(1);
  if (ready) return next();
  if (run) {
    const { data, times, ...rest } = run;
    fs.writeFileSync(`run${id}.bin`, data);
    runs.set(id, { ...rest, t: times });
    if (horizon && run.trust.pending) return;
    answers.push(runs.get(id));
  } else if (trust && horizon) answers.push({ ...runs.get(id), trust });
  else if (error !== undefined) answers.push({ error });
  else return;
  setTimeout(next, 0);
};
globalThis.self = { postMessage: take };
vm.runInThisContext(fs.readFileSync("worker.js", "utf8"));
"""


@cache
def program_of(name):
    """The live model of an example, and the example."""
    m = rt.example(name)
    return live_model(m), m


def computed(folder, live, *wishes, horizon=False, **settings):
    """What a page computes: a run for each of the wishes, which are parameters by name; `columns` as arrays.

    live: of `live_model`.  horizon: the second run too.  settings: of all runs, such as t_end.  A list for several.
    """
    (folder / "worker.js").write_text(worker_text(live), encoding="utf-8")
    (folder / "go.cjs").write_text(SCRIPT, encoding="utf-8")
    tasks = [{"parameters": wish, "settings": settings} for wish in wishes or ({},)]
    (folder / "job.json").write_text(json.dumps({"tasks": tasks, "horizon": horizon}))
    done = subprocess.run(["node", "go.cjs"], cwd=folder, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    runs = json.loads((folder / "answers.json").read_text())
    for k, run in enumerate(runs):
        if "error" not in run:
            data = np.fromfile(folder / f"run{k}.bin").reshape(len(run["names"]), len(run["t"]))
            run["columns"], run["n"] = dict(zip(run["names"], data, strict=True)), len(run["t"])
    return runs if len(wishes) > 1 else runs[0]
