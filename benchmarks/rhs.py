"""Cost of one right-hand side: the paper's four-bar against C written by hand, and a chain against its length."""

from __future__ import annotations

import json
import shutil
import subprocess
import tempfile
from functools import partial
from pathlib import Path

import numpy as np

import rattle as rt
from measure import Row, interleave, timed
from rattle.analyses.dynamics.run import start_state
from rattle.equations.motion import derivative
from rattle.jit import functions
from rattle.jit.functions import KernelFunction

LINKS = (10, 30, 100, 300, 1000, 3000, 10_000)
C_OPTIONS = ("-O3", "-march=native")


def _many(m, t, y, dy, n):  # type: ignore[no-untyped-def]
    for _ in range(n):
        derivative(m, t, y, dy)


many = KernelFunction(_many)


def seconds_per_rhs(mechanism: rt.Mechanism, calls: int) -> float:
    """Time of one right-hand side at the start of the mechanism [s], called in a compiled loop."""
    functions.start()
    y = start_state(mechanism.system, mechanism.start)
    workspace, dy = mechanism.system.workspace(), np.zeros_like(y)
    many(workspace, 0.0, y, dy, 1)
    return timed(lambda: many(workspace, 0.0, y, dy, calls))() / calls


def handwritten(folder: Path) -> Path | None:
    """The compiled C program, or None where there is no C compiler."""
    compiler = shutil.which("cc")
    if compiler is None:
        return None
    program = folder / "handwritten_fourbar"
    source = Path(__file__).with_name("handwritten_fourbar.c")
    subprocess.run([compiler, *C_OPTIONS, str(source), "-o", str(program), "-lm"], check=True)
    return program


def seconds_per_rhs_in_c(program: Path) -> float:
    """Time of one right-hand side of the C program [s], as it measured itself."""
    run = subprocess.run([str(program), "2000", "100"], check=True, capture_output=True, text=True)
    return float(json.loads(run.stdout)["seconds_per_rhs"])


def fourbar_rows(repeats: int) -> list[Row]:
    """The paper's four-bar, massless links."""
    mechanism = rt.example("fourbar")
    with tempfile.TemporaryDirectory() as folder:
        program = handwritten(Path(folder))
        samplers = {"rattle": partial(seconds_per_rhs, mechanism, 100_000)}
        if program is not None:
            samplers["C"] = partial(seconds_per_rhs_in_c, program)
        median = interleave(samplers, repeats)
    name = "C by hand" if program else "no C compiler (cc) here"
    return [Row("four-bar: one right-hand side", median["rattle"], name, median.get("C"), "0.6 us, about 10")]


def planetary_rows(repeats: int) -> list[Row]:
    """Three planets between a sun and a ring: six meshes, of which two are redundant."""
    found = interleave({"rattle": partial(seconds_per_rhs, rt.example("planetary"), 50_000)}, repeats)
    return [Row("planetary gear set: one right-hand side", found["rattle"], aim="2 us")]


def chain(links: int) -> str:
    """Model text of a chain of equal bars, pinned to the ground at one end, let go from a zigzag."""
    lines = ["format = 1", f'name = "chain of {links} links"', "gravity = [0, -9.81]", "[ground.points]", "P = [0, 0]"]
    for k in range(links):
        lines += [f"[bodies.b{k}]", 'bar = ["A", "B"]', "length = 0.1", "mass = 0.1"]
    for k in range(links):
        first = f"b{k - 1}.B" if k else "ground.P"
        lines += [f"[joints.j{k}]", 'type = "revolute"', f'connect = ["{first}", "b{k}.A"]']
    lines += ["[initial]"]
    lines += [f"b{k} = {{ angle = {0.3 if k % 2 else -0.3}, omega = 0 }}" for k in range(links)]
    return "\n".join(lines) + "\n"


def chain_rows(repeats: int) -> list[Row]:
    """Chains of growing length, and the exponent p of cost ~ links^p."""
    samplers = {}
    for links in LINKS:
        samplers[str(links)] = partial(seconds_per_rhs, rt.loads(chain(links)), max(5, 400_000 // links))
    median = interleave(samplers, repeats)
    cost = np.array([median[str(links)] for links in LINKS])
    exponent = np.polyfit(np.log(LINKS), np.log(cost), 1)[0]
    rows = [
        Row(f"chain of {links} links: one right-hand side, per link", one / links)
        for links, one in zip(LINKS, cost, strict=True)
    ]
    return [*rows, Row("chain: exponent of the cost over the links", float(exponent), aim="1", seconds=False)]
