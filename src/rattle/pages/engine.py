"""The engine of pages: every kernel that a run needs, as one WebAssembly module.

`python -m rattle.pages.engine -o FILE` builds it.  A wheel holds a built one, `engine.wasm.gz`.  Where there is none,
or one of other sources, as while they are changed, it is built when it is first needed and kept in the cache folder.
"""

from __future__ import annotations

import argparse
import functools
import gzip
import hashlib
import os
import pickle
import platform
import sys
import time
from collections.abc import Mapping, Sequence
from importlib import resources
from pathlib import Path
from typing import Any, NamedTuple

from rattle.analyses import timetable
from rattle.analyses.dynamics import run
from rattle.elements.film_table import read_ratios
from rattle.elements.long_film import long_peaks
from rattle.elements.short_film import short_peaks
from rattle.equations import kept_values, motion, start
from rattle.jit import functions
from rattle.jit import layout as at
from rattle.jit.cache import KeptFile
from rattle.jit.folder import cache_folder, compiled_sources
from rattle.jit.functions import KernelFunction
from rattle.jit.linking import Linked, link
from rattle.jit.object_file import object_file
from rattle.jit.wasm.engine import about, engine
from rattle.solvers import driver_jumps, ports, run_loop
from rattle.solvers.contacts import wear_sum
from rattle.solvers.output_row import record
from rattle.trace.library import library_text

OF_LIBRARY = ("elementary.py", "graph.py", "library.py", "llvm.py")
BUILT = "engine.wasm.gz"  # in this folder
NATIVES = {  # what a page calls: the functions that `analyses` calls for a run and its start
    "run.timetable": driver_jumps.find_timetable,
    "run.begin": run_loop.begin,
    "run.advance": run_loop.advance,
    "record": record,
    "start.find": start.find_start,
    "start.outside": start.outside,
    "start.constants": start.count_constants,
}
NEVER_CALLED = (ports.write_ports, wear_sum.keep_speeds, wear_sum.add_wear)  # no page asks for powers or wear
WITH_LETTERS = {  # the same of functions whose types follow from their arguments
    # arrays of results: what `pages/result_data.py` leaves to them
    "short_peaks": (short_peaks, ("void", "v", "v", "v")),
    "long_peaks": (long_peaks, ("void", "v", "v", "v")),
    "read_ratios": (read_ratios, ("void", "v", "v", "v", "v")),
}
# columns and statuses, and settings, that `viewer/core_run.js` and `viewer/core_start.js` use by name
COLUMNS = (
    *("T", "OUTPUTS", "FOUND", "EVENT_COUNT", "STEPS", "REJECTED", "EVALUATIONS", "JOLTS", "JAMS", "JAM_AT"),
    *("RES", "GAP"),
)
STATUSES = {
    motion: ("PAUSED", "DONE"),
    kept_values: ("MOVED", "NOT_FINITE"),
    start: ("NOT_HELD",),
}
SETTINGS = {run: ("CHUNK", "MOST_NUMBERS"), timetable: ("MORE",)}


def linked() -> Linked:
    """All that a page calls, with all kernels of the package that may stand in a table."""
    kernels = [one for one in functions.natives() if one.family and one.__module__.startswith("rattle.")]
    offered: Mapping[str, tuple[KernelFunction, Sequence[str]]] = {
        **{name: (one, one.letters) for name, one in NATIVES.items()},
        **WITH_LETTERS,
    }
    return link(offered, kernels, NEVER_CALLED)


def build() -> bytes:
    """The engine of pages, made from the sources."""
    named: list[tuple[Any, tuple[str, ...]]] = [(at, COLUMNS), *STATUSES.items(), *SETTINGS.items()]
    numbers = {name: getattr(one, name) for one, names in named for name in names}
    return engine(linked(), library_text(), {"sources": sources(), "numbers": numbers})


@functools.cache
def sources() -> str:
    """What the engine is made from, as a short text."""
    here, digest = Path(__file__).parents[1], hashlib.sha256()
    makers = [
        here / "jit" / "linking.py",
        here / "jit" / "object_file.py",
        *(here / "jit" / "wasm").glob("*.py"),
        *(here / "trace" / name for name in OF_LIBRARY),
        Path(__file__),
    ]
    for path in [*compiled_sources(), *sorted(makers)]:
        digest.update(path.relative_to(here).as_posix().encode() + path.read_bytes())
    return digest.hexdigest()[:16]


def compressed(module: bytes) -> bytes:
    """A module as the package and its pages hold it."""
    return gzip.compress(module, 9, mtime=0)


def built() -> bytes | None:
    """The engine that the package holds; None if it holds none."""
    file = resources.files("rattle.pages") / BUILT
    return gzip.decompress(file.read_bytes()) if file.is_file() else None


@functools.cache
def engine_of_pages() -> bytes:
    """The engine for these sources, compressed: the one that the package holds, one that was kept, or a new one."""
    held = built()
    if held is not None and about(held)["sources"] == sources():
        return compressed(held)
    kept = KeptFile(cache_folder(), "engine", (sources(), os.environ.get("RATTLE_BOUNDSCHECK", "0")))
    found: bytes | None = kept.read()
    if found is None:
        functions.say_once("compiling kernels for pages (once)")
        found = compressed(build())
        kept.write(lambda: pickle.dumps(found))
    return found


class Kernels(NamedTuple):
    """The same kernels as machine code for this platform, see `jit.object_file`."""

    content: bytes  # of the object file
    offered: Mapping[str, tuple[str, ...]]  # letters of functions by name
    families: Mapping[str, str]  # family by symbol, in the order of the table of kernels


def kernels_of_platform() -> Kernels:
    """The kernels for these sources and this platform: those that were kept, or new ones."""
    kept = KeptFile(cache_folder(), "object", (sources(), platform.platform()))
    found: tuple[Any, ...] | None = kept.read()
    if found is None:
        functions.say_once("compiling kernels for this platform (once)")
        made = linked()
        found = (object_file(made), made.offered, made.kernels)
        kept.write(lambda: pickle.dumps(found))
    return Kernels(*found)


def main(arguments: Sequence[str]) -> None:
    """Build the engine into a file, and say what it has become."""
    parser = argparse.ArgumentParser(prog="python -m rattle.pages.engine", description=main.__doc__)
    parser.add_argument("-o", dest="file", type=Path, required=True, help="the file, .wasm or .wasm.gz")
    file, began = parser.parse_args(arguments).file, time.process_time()
    module = build()
    small = compressed(module)
    file.write_bytes(small if file.suffix == ".gz" else module)
    took = time.process_time() - began
    sys.stderr.write(f"{file}: {len(module)} bytes, {len(small)} compressed, {took:.1f} s\n")


if __name__ == "__main__":
    main(sys.argv[1:])
