"""The engines of pages: every kernel that a run needs, as one WebAssembly module.

There is one for everything, and one of half the size for mechanisms without contacts and friction in joints.
`python -m rattle.pages.engine FOLDER` builds them.  A wheel holds built ones.  Where there is none, or one of other
sources, as while they are changed, it is built when it is first needed and kept in the cache folder.
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
from rattle.equations import compliant, kept_values, motion, start
from rattle.jit import functions
from rattle.jit import layout as at
from rattle.jit.cache import KeptFile
from rattle.jit.folder import cache_folder, compiled_sources
from rattle.jit.functions import KernelFunction
from rattle.jit.linking import Linked, link
from rattle.jit.object_file import object_file
from rattle.jit.wasm.engine import about, engine
from rattle.solvers import driver_jumps, ports, run_loop
from rattle.solvers.contacts import contact_events, wear_sum
from rattle.solvers.nonsmooth import jolts
from rattle.solvers.output_row import record
from rattle.trace.library import library_text

OF_LIBRARY = ("elementary.py", "graph.py", "library.py", "llvm.py")
BUILT = {True: "engine.wasm.gz", False: "engine_without_contacts.wasm.gz"}  # in this folder, by `contacts`
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
# what only contacts, oil and friction in joints call: families of kernels, modules, single functions
FAMILIES_OF_CONTACTS = ("clearance", "stiffness", "normal", "friction", "film", "problem", "closed contacts")
MODULES_OF_CONTACTS = tuple(
    f"rattle.{name}"
    for name in (
        "solvers.nonsmooth.", "solvers.contacts.gap_search", "solvers.dry_friction_modes", "equations.dry_friction",
        "equations.friction_beside_contacts", "equations.worn_contact",
    )
)  # fmt: skip
OF_CONTACTS = (compliant.add_contact_forces, *(getattr(contact_events, name) for name in ("start_contacts", "turn")))
WITHOUT_CONTACTS = (jolts.jolt,)  # what needs none although it stands in one of these modules
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
_NAMED: list[tuple[Any, tuple[str, ...]]] = [(at, COLUMNS), *STATUSES.items(), *SETTINGS.items()]
NUMBERS = {name: getattr(module, name) for module, names in _NAMED for name in names}  # that a page reads by name


def linked(contacts: bool = True) -> Linked:
    """All that a page calls, with all kernels of the package that may stand in a table."""
    ours = [native for native in functions.natives() if native.__module__.startswith("rattle.")]
    without = [*NEVER_CALLED, *(native for native in ours if not contacts and _is_of_contacts(native))]
    offered: Mapping[str, tuple[KernelFunction, Sequence[str]]] = {
        **{name: (native, native.letters) for name, native in NATIVES.items()},
        **WITH_LETTERS,
    }
    return link(offered, [native for native in ours if native.family and native not in without], without)


def _is_of_contacts(native: KernelFunction) -> bool:
    """Whether a native is left out of the engine without contacts; a run that calls it after all fails with words."""
    named = native.family in FAMILIES_OF_CONTACTS or native.__module__.startswith(MODULES_OF_CONTACTS)
    return native in OF_CONTACTS or (named and native not in WITHOUT_CONTACTS)


def build(contacts: bool = True) -> bytes:
    """An engine of pages, made from the sources."""
    return engine(linked(contacts), library_text(), {"sources": sources(), "numbers": NUMBERS})


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


def built(contacts: bool = True) -> bytes | None:
    """The engine that the package holds; None if it holds none."""
    file = resources.files("rattle.pages") / BUILT[contacts]
    return gzip.decompress(file.read_bytes()) if file.is_file() else None


@functools.cache
def engine_of_pages(contacts: bool = True) -> bytes:
    """The engine for these sources, compressed: the one that the package holds, one that was kept, or a new one.

    contacts: whether mechanisms may have contacts, oil and friction in joints.
    """
    held = built(contacts)
    if held is not None and about(held)["sources"] == sources():
        return compressed(held)
    kept = KeptFile(cache_folder(), BUILT[contacts], (sources(), os.environ.get("RATTLE_BOUNDSCHECK", "0")))
    engine: bytes | None = kept.read()
    if engine is None:
        functions.say_once("compiling kernels for pages (once)")
        engine = compressed(build(contacts))
        kept.write(lambda: pickle.dumps(engine))
    return engine


class Kernels(NamedTuple):
    """The same kernels as machine code for this platform, see `jit.object_file`."""

    content: bytes  # of the object file
    offered: Mapping[str, tuple[str, ...]]  # letters of functions by name
    families: Mapping[str, str]  # family by symbol, in the order of the table of kernels


def kernels_of_platform() -> Kernels:
    """The kernels for these sources and this platform: those that were kept, or new ones."""
    kept = KeptFile(cache_folder(), "object", (sources(), platform.platform()))
    parts: tuple[Any, ...] | None = kept.read()
    if parts is None:
        functions.say_once("compiling kernels for this platform (once)")
        engine = linked()
        parts = (object_file(engine), engine.offered, engine.kernels)
        kept.write(lambda: pickle.dumps(parts))
    return Kernels(*parts)


def main(arguments: Sequence[str]) -> None:
    """Build the engines into a folder, and say what they have become."""
    parser = argparse.ArgumentParser(prog="python -m rattle.pages.engine", description=main.__doc__)
    parser.add_argument("folder", type=Path, help="the folder")
    folder, began = parser.parse_args(arguments).folder, time.process_time()
    for contacts, name in BUILT.items():
        module = build(contacts)
        small = compressed(module)
        (folder / name).write_bytes(small)
        took = time.process_time() - began
        sys.stderr.write(f"{folder / name}: {len(module)} bytes, {len(small)} compressed, {took:.1f} s\n")


if __name__ == "__main__":
    main(sys.argv[1:])
