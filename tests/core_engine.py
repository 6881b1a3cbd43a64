"""The engine of pages in node: runs of examples, moved by it and by machine code."""

import ctypes
import json
import subprocess
from functools import cache
from pathlib import Path

import llvmlite.binding as llvm
import numpy as np

import rattle as rt
from rattle.analyses.dynamics.methods import choose_stepper, new_run
from rattle.analyses.dynamics.run import How
from rattle.analyses.dynamics.simulate import output_times
from rattle.jit import functions, machine
from rattle.jit import layout as at
from rattle.pages.engine import engine_of_pages
from rattle.pages.live_model import touches
from rattle.pages.result_data import result_data
from rattle.pages.run_image import run_image
from rattle.pages.tape import Tape
from rattle.solvers.stepper import ATOL, RTOL
from rattle.trace.library import NAMES, library_text

VIEWER = Path(rt.__file__).parent / "pages" / "viewer"
SCRIPT = """
import fs from "node:fs";
import zlib from "node:zlib";
import { openCore } from "%(viewer)s/core.js";
import { CoreRun } from "%(viewer)s/core_run.js";
const engine = await openCore(zlib.gunzipSync(fs.readFileSync("engine.wasm.gz")));
const image = { description: JSON.parse(fs.readFileSync("run.json")), content: fs.readFileSync("run.bin") };
let said;
try {
  const run = new CoreRun(engine, image);
  %(steps)s
  const { rows, breaks, t, ...rest } = run.result();
  fs.writeFileSync("rows.bin", rows);
  fs.writeFileSync("breaks.bin", Float64Array.from(breaks.flatMap((one) => [one.t, ...one.row])));
  said = { ...rest, outputs: t.length };
} catch (error) {
  said = { error: error.message, reason: error.reason };
}
console.log(JSON.stringify(said));
"""
RESULT = f"""const {{ openTape, functionsByName }} = await import("{VIEWER.as_uri()}/tape.js");
  const {{ data, tape, numbers }} = JSON.parse(fs.readFileSync("result_data.json"));
  const functions = functionsByName(await openTape(tape), numbers);"""
# sine and cosine of one angle, and powers of 2, are calls of their own in machine code
TOGETHER = """define void @"rattle.sincos"(double %x, ptr %s, ptr %c) {
  %a = call double @"rattle.sin"(double %x)
  %b = call double @"rattle.cos"(double %x)
  store double %a, ptr %s
  store double %b, ptr %c
  ret void
}
define double @"rattle.exp2"(double %x) {
  %a = call double @"rattle.pow"(double 2.0, double %x)
  ret double %a
}"""
TWO = ("pow", "atan2", "hypot", "fmod")


def new(name, method=None, t_end=None, finer=1.0, **changes):
    """A run of an example, or of a mechanism, as `simulate` makes it, before its first step.

    finer: by what its tolerances are divided.
    """
    functions.start()
    m = rt.example(name) if isinstance(name, str) else name
    m = m.set(**changes) if changes else m
    settings = m.system.model.settings
    end, times = output_times(settings, t_end, None)
    rtol = (settings.rtol or RTOL) / finer
    stepper, step = choose_stepper(m.system, method or settings.method, settings.step, end)
    return new_run(
        m.system, m.start, times, end, How(stepper, rtol, (settings.atol or ATOL * rtol * finer) / finer, step)
    )


def with_result(folder, m, t_end=None, names=None):
    """Write what `RESULT` reads: the data and functions with which the end of a run becomes a result.

    names: of the parameters that a page changes, all by default.
    """
    tape = Tape()
    data, numbers = result_data(m, tape, t_end, names)
    (folder / "result_data.json").write_text(json.dumps({"data": data, "tape": tape.written(), "numbers": numbers}))


def in_node(folder, run, steps="run.advance();", **changes):
    """What the engine makes of a run: its statistics, `rows` as `Run.raw`, and `breaks` (n, 1 + width).

    changes: of the description.
    """
    image = run_image(run)
    (folder / "engine.wasm.gz").write_bytes(engine_of_pages(touches(run)))
    (folder / "run.json").write_text(json.dumps({**image.description, **changes}, allow_nan=False))
    (folder / "run.bin").write_bytes(image.content)
    (folder / "go.mjs").write_text(SCRIPT % {"viewer": VIEWER.as_uri(), "steps": steps}, encoding="utf-8")
    done = subprocess.run(["node", "go.mjs"], cwd=folder, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    if "error" not in said:
        width = run.raw.shape[1]
        said["rows"] = np.fromfile(folder / "rows.bin").reshape(said["outputs"], width)
        said["breaks"] = np.fromfile(folder / "breaks.bin").reshape(-1, 1 + width)
    return said


def by_machine_code(run):
    """The same of a run that goes here."""
    run.go()
    events = np.concatenate(run.contacts)
    breaks = [np.column_stack(part) for part in run.breaks]
    return {
        "success": not run.message,
        "statistics": {
            name: int(run.tally[getattr(at, name.upper())]) for name in ("steps", "rejected", "evaluations")
        },
        "rows": run.raw[: run.tally[at.OUTPUTS]],
        "events": events,
        "breaks": np.concatenate(breaks) if breaks else np.zeros((0, 1 + run.raw.shape[1])),
        "jolts": [[one.jump.t, one.impulse] for one in run.jolts],
    }


@cache
def _library():
    """The package's own elementary functions as machine code, by name: addresses."""
    text = library_text().replace("define internal", "define") + TOGETHER
    declared = "\n".join(f"declare double @llvm.{name}.f64(double)" for name in ("fabs", "floor", "sqrt"))
    made = machine.parsed(f"{text}\n{declared}\ndeclare double @llvm.copysign.f64(double, double)")
    target = machine.target()
    made.triple, made.data_layout = llvm.get_process_triple(), str(target.target_data)
    engine = machine._engine()
    engine.add_object_file(llvm.ObjectFileRef.from_data(bytes(target.emit_object(made))))
    engine.finalize_object()
    return {name: engine.get_function_address(f"rattle.{name}") for name in (*NAMES, "fmod", "sincos", "exp2")}


def own_function(name):
    """One of the package's own elementary functions, compiled."""
    return ctypes.CFUNCTYPE(*[ctypes.c_double] * (3 if name in TWO else 2))(_library()[name])


def use_own_functions():
    """Let kernels that are loaded from now on call the package's own elementary functions instead of the C library's.

    It cannot be undone: for a process of its own.
    """
    for name, address in _library().items():
        llvm.add_symbol(name, address)
