"""The engine of pages: every kernel that a run needs, as one WebAssembly module, `python -m rattle.pages.engine`."""

from __future__ import annotations

import argparse
import gzip
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from rattle.jit import functions
from rattle.jit.functions import KernelFunction
from rattle.jit.wasm.engine import Linked, engine, link
from rattle.pages.run_image import numbers
from rattle.solvers import step_loop
from rattle.solvers.dry_friction_modes import decide
from rattle.solvers.energy_floor import set_floor
from rattle.solvers.nonsmooth import event_driven, jams, jolts, moreau_jean
from rattle.solvers.output_row import record
from rattle.solvers.state_switches import choose_sides
from rattle.trace.library import library_text


def offered() -> dict[str, tuple[KernelFunction, Sequence[str]]]:
    """What a page calls: the functions that `analyses.dynamics` calls in a run, with letters of result and arguments."""
    natives = {
        "smooth.begin": step_loop.begin,
        "smooth.resume": step_loop.resume,
        "smooth.advance": step_loop.advance,
        "events.start": event_driven.start,
        "events.goOn": event_driven.go_on,
        "events.advance": event_driven.advance,
        "events.passJam": jams.pass_jam,
        "stepping.start": moreau_jean.start,
        "stepping.advance": moreau_jean.advance,
        "record": record,
        "decide": decide,
        "jolt": jolts.jolt,
        "floor": set_floor,
    }
    return {name: (one, one.letters) for name, one in natives.items()} | {
        "chooseSides": (choose_sides, ("void", "h", "f", "f")),
        "speeds": (jolts.speeds, ("void", "h", "f", "v")),
    }


def linked() -> Linked:
    """All that a page calls, with all kernels of the package that may stand in a table."""
    kernels = [one for one in functions.natives() if one.family and one.__module__.startswith("rattle.")]
    return link(offered(), kernels, library_text())


def build() -> bytes:
    """The engine of pages."""
    return engine(linked(), {"numbers": numbers()})


def main(arguments: Sequence[str]) -> None:
    """Build the engine into a file, and say what it has become."""
    parser = argparse.ArgumentParser(prog="python -m rattle.pages.engine", description=__doc__)
    parser.add_argument("-o", dest="file", type=Path, required=True, help="the file, .wasm or .wasm.gz")
    file, began = parser.parse_args(arguments).file, time.process_time()
    module = build()
    small = gzip.compress(module, mtime=0)
    file.write_bytes(small if file.suffix == ".gz" else module)
    print(f"{file}: {len(module)} bytes, {len(small)} compressed, {time.process_time() - began:.1f} s", file=sys.stderr)


if __name__ == "__main__":
    main(sys.argv[1:])
