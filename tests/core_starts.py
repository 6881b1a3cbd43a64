"""Starts that pages find, in node, and those of their kernels in plain Python."""

import json
import math
import subprocess
from pathlib import Path

import numpy as np

import rattle as rt
from rattle.equations.kept_values import MOVED
from rattle.equations.start import count_constants, find_start, outside
from rattle.errors import AssemblyError, ModelError, TraceError
from rattle.jit import functions
from rattle.jit.workspace import TYPES, Workspace
from rattle.pages.engine import engine_of_pages
from rattle.pages.live_model import live_model
from rattle.pages.start_data import start_data
from rattle.pages.tape import Tape

VIEWER = Path(rt.__file__).parent / "pages" / "viewer"
SCRIPT = """
import fs from "node:fs";
import zlib from "node:zlib";
import { openCore } from "%(viewer)s/core.js";
import { StartFinder } from "%(viewer)s/core_start.js";
import { openTape } from "%(viewer)s/tape.js";
const engine = await openCore(zlib.gunzipSync(fs.readFileSync("engine.wasm.gz")));
const data = { description: JSON.parse(fs.readFileSync("start.json")), content: fs.readFileSync("start.bin") };
const functions = await openTape(JSON.parse(fs.readFileSync("tape.json")));
const finder = new StartFinder(engine, data, functions);
const starts = JSON.parse(fs.readFileSync("asked.json")).map((p) => finder.find(Float64Array.from(p)));
const plain = (x) => x && [...x];
const plainly = ({ q, v, constants, error }) => ({ q: plain(q), v: plain(v), constants: plain(constants), error });
console.log(JSON.stringify(starts.map(plainly)));
"""


def found_in_node(folder, m, asked, names=None):
    """What a page finds for lists of values of parameters, all by default, in this order, in one finder."""
    functions.start()
    tape = Tape()
    data = start_data(m, tape, names)
    (folder / "engine.wasm.gz").write_bytes(engine_of_pages())
    (folder / "start.json").write_text(json.dumps(data.description, allow_nan=False))
    (folder / "start.bin").write_bytes(data.content)
    (folder / "tape.json").write_text(json.dumps(tape.written()))
    (folder / "asked.json").write_text(json.dumps(asked))
    (folder / "go.mjs").write_text(SCRIPT % {"viewer": VIEWER.as_uri()}, encoding="utf-8")
    done = subprocess.run(["node", "go.mjs"], cwd=folder, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def parameters_of(m):
    """Names of the parameters that pages change: all, unless one cannot be recorded, as the diameter of a fit."""
    try:
        return start_data(m, Tape()).description["parameters"]
    except TraceError:
        return list(live_model(m, alone=True).parameters)


def far_values(m):
    """(name, value [SI]) for every parameter that can be chosen: fractions and multiples within its limits."""
    known = m.model.parameters
    for name in parameters_of(m):
        one = known[name]
        least, most = (-math.inf if one.minimum is None else one.minimum, one.maximum or math.inf)
        values = [(one.value or 1.0) * share for share in (0.3, 0.7, 1.7, 2.4, 6.0)]
        yield from ((name, x) for x in (*values, least, most) if least <= x <= most and math.isfinite(x))


def changed_values(m):
    """(name, value [SI]) for every parameter that can be chosen: a small step, and a larger one towards its limits."""
    known = m.model.parameters
    for name in parameters_of(m):
        one = known[name]
        far = one.maximum if one.maximum is not None and one.maximum > one.value else one.minimum
        yield name, (one.value or 1.0) * 1.004
        yield name, one.value * 1.1 if far is None or far == one.value else one.value + 0.1 * (far - one.value)


def starts_apart(folder, name, far=False):
    """By parameter and value, how starts in a page differ from those of Python; only those that do."""
    m = rt.example(name)
    values = list(far_values(m) if far else changed_values(m))
    names = parameters_of(m)
    own = [m.model.parameters[x].value for x in names]
    asked = [own]
    for changed, value in values:
        asked.append([value if x == changed else y for x, y in zip(names, own, strict=True)])
    first, *starts = found_in_node(folder, m, asked, names)
    assert first["error"] is None
    assert first["q"] == m.start.q.tolist()
    assert first["v"] == m.start.v.tolist()
    differ = {}
    for (changed, value), start in zip(values, starts, strict=True):
        try:
            want = m.set({changed: value}).start
        except (ModelError, AssemblyError) as error:
            if start["error"] is None:
                differ[changed, value] = f"only Python says: {error}"
            continue
        if start["error"] is not None:
            differ[changed, value] = f"only the page says: {start['error']}"
            continue
        size = np.tile([m.system.size, m.system.size, 1.0], m.system.body_count)
        q = np.abs((np.array(start["q"]) - want.q) / size).max()
        v = np.abs((np.array(start["v"]) - want.v) / size).max() / max(1.0, np.abs(want.v / size).max())
        if not max(q, v) < 1e-10:
            differ[changed, value] = f"{q:.2g}, {v:.2g}"
    return differ


class KeptFunctions:
    """Functions of a start, in the place of a tape that a page would compute."""

    def __init__(self):
        self.functions = []

    def add(self, graph, outputs, inputs):
        self.functions.append(lambda given: graph.evaluate(outputs, given[:, None])[1:, 0].tolist())
        return len(self.functions) - 1


def workspace_of(image, content):
    """The workspace of an image, for plain Python."""
    kernels, arrays = {one.symbol: one.python for one in functions.natives()}, {}
    for (name, (kind, _)), (*shape, first) in zip(TYPES.items(), image["arrays"], strict=True):
        stored = content[first:] if first >= 0 else bytes(8 * math.prod(shape))
        arrays[name] = np.frombuffer(stored, kind, math.prod(shape)).reshape(shape).copy()
    tables = {name: tuple(kernels.get(one) for one in table) for name, table in image["tables"].items()}
    return Workspace(arrays | tables)


def found_here(m, p):
    """Positions, rates and constants of a start by the kernels in plain Python."""
    kept = KeptFunctions()
    description, content = start_data(m, kept)
    workspaces = [workspace_of(system["image"], content) for system in description["systems"]]

    def enter(k, inputs):
        system, workspace = description["systems"][k], workspaces[k]
        values = iter(kept.functions[system["function"]](np.array(inputs)))
        for name, where in system["entries"]:
            for place in where:
                getattr(workspace, name).ravel()[place] = next(values)
        return workspace

    def find(start):
        constants = []
        if start["loose"]:
            loose = find(start["loose"])
            counting = enter(start["counting"], [*p, *(0.0 for _ in workspaces[start["counting"]].start_constants)])
            count_constants(counting, loose, 0.0)
            constants = counting.start_constants
        main, shut, every = (
            workspaces[start["system"]] if k is None else enter(k, [*p, *constants])
            for k in (start["system"], start["shut"], start["every"])
        )
        ideal = find(start["ideal"]) if start["ideal"] else main
        assert find_start(main, ideal, shut, every, 0.0) == MOVED
        assert outside(main, 0.0) == -1
        return main

    return find(description["start"])
