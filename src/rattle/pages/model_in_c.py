"""A model that kernels move as a text in C: the workspaces of its run and of its start, and its recorded functions.

It is what pages hold as JSON, see `live_model`, `start_data` and `result_data`; `trace/fmu_sources/run.c` includes it.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import islice

import numpy as np

from rattle.analyses.arguments import TIGHTEST
from rattle.analyses.timetable import MORE
from rattle.equations.kept_values import MOVED, NOT_FINITE
from rattle.equations.motion import DONE, PAUSED
from rattle.jit import families
from rattle.jit import layout as at
from rattle.jit.object_file import prototype, symbol
from rattle.jit.workspace import ARRAYS
from rattle.language.recorded import Operand
from rattle.pages.engine import Kernels
from rattle.pages.result_data import WORDS
from rattle.pages.tape import Key, Tape
from rattle.trace import c
from rattle.trace.graph import Graph
from rattle.value_types import Tree

ROOM = 128  # rows of what steps leave, of which one is taken at a time
LEFT_BY_STEPS = ("events", "crossings", "break_rows")
INSTANTS = 64  # rows for those of expressions of time, at least
# arrays and columns that the sources use by name
USED = (
    *("state", "clock", "tally", "course", "contact_memory", "break_times", "rows", "contact_kinematics", "audit"),
    *("timed", "driver_leap"),
    *(f"start_{name}" for name in ("q", "v", "least", "constants")),
)
COLUMNS = {
    "clock": ("T",), "tally": ("FOUND", "EVENT_COUNT", "OUTPUTS"), "course": ("PIECE",),
    "contact_memory": ("CLOSED",), "rows": ("RES",), "contact_kinematics": ("GAP",),
    "driver_leap": ("LEAP_COUNT", "LEAP_SIZE", "LEAP_AT"),
    "timed": ("RESOLVED",),
    "audit": ("FLOOR", "MOST_KINETIC", "MOST_WORK", "LEAST_POTENTIAL", "MOST_POTENTIAL", "MOST_UNREST"),
}  # fmt: skip
STATUSES = {"PAUSED": PAUSED, "DONE": DONE, "MOVED": MOVED, "NOT_FINITE": NOT_FINITE}
TYPES = """#include <stdbool.h>
#define RATTLE_HIDDEN __attribute__((visibility("hidden")))

typedef struct { int64_t size, rows, columns, content; const int *kernels; } Array;
typedef struct { const Array *arrays; const uint64_t *content; } Image;
typedef struct { int array, cell; } Place;
typedef struct { int status; const char *words; } End;
typedef struct { const char *name, *unit; } Row;
typedef struct {
    void (*numbers)(const double *in, double *out);
    int count, placed;
    const Place *places;
    const unsigned char *counts;
    const double *inputs;
} System;
typedef struct { int system, ideal, loose, shut, every, counting, count; const Row *rows; } Start;

extern RATTLE_HIDDEN const void *const rattle_kernels[], *const rattle_traps[];
static const void *kernel(int n) { return n >= 0 ? rattle_kernels[n] : rattle_traps[-1 - n]; }
"""
CALL = "    if ({name}(&none, given + {first}, 1, given + {second}, 1, {table}called + {call}, 1)) return false;"


class FunctionsInC(Tape):
    """Recorded functions, each by itself."""

    def __init__(self) -> None:
        super().__init__()
        self.recorded: list[tuple[Graph, list[Operand]]] = []

    def add(self, graph: Graph, outputs: Sequence[Operand], inputs: Sequence[Key]) -> int:
        """Number of a function of exact operations; inputs: see `Tape.add`."""
        self.recorded.append((graph, list(outputs)))
        return len(self.recorded) - 1

    def text(self, number: int, name: str) -> str:
        """A function in C, see `trace.c`."""
        return c.function(*self.recorded[number], name)


class ModelInC:
    """The file model.c.  data: of a LiveModel, whose functions are in C."""

    def __init__(self, data: Tree, functions: FunctionsInC, kernels: Kernels) -> None:
        self.data, self.result, self.functions, self.kernels = data, data["result"], functions, kernels
        start = data["start"]["description"]
        self.systems, content = start["systems"], data["start"]["content"]
        self.starts = list[Tree]()
        self._enter(start["start"])
        self.order = {kernel: n for n, kernel in enumerate(kernels.families)}
        self.cells = list[int]()
        images = [(data["run"], data["content"]), *((system["image"], content) for system in self.systems)]
        self.images = [line for k, image in enumerate(images) for line in self._image(k, *image)]

    def _enter(self, start: Tree) -> int:
        """Number of a start in the list of all, the first of which is that of the model; -1 for none."""
        if start is None:
            return -1
        number = len(self.starts)
        self.starts.append({})
        inner = {key: self._enter(start[key]) for key in ("ideal", "loose")}
        none = {key: -1 for key in ("shut", "every", "counting") if start[key] is None}
        self.starts[number] = {**start, **inner, **none}
        return number

    def text(self) -> str:
        """The text."""
        functions, defined = [*self._functions()], {**self._sizes(), **self._settings()}
        lines = [
            c.INCLUDES, TYPES, *(f"#define {name} {value}" for name, value in defined.items()),
            *(prototype(name, letters) for name, letters in self.kernels.offered.items()), *self.images,
            _list("const Image images[]", (f"{{arrays_{k}, content_{k}}}" for k in range(len(self.cells)))),
            *self._parameters(), *c.helpers(functions), *functions, *self._curves(), *self._systems(), *self._starts(),
            _list("const End ends[]", (f"{{{status}, {json.dumps(words)}}}" for status, words in WORDS.items())),
        ]  # fmt: skip
        return "\n".join(lines)

    def _sizes(self) -> dict[str, int]:
        """Numbers that the sources use by name."""
        data, result, order = self.data, self.result, list(ARRAYS)
        return {
            "NP": len(data["parameters"]), "NO": len(result["names"]),
            "NCONST": self._constants(self.starts[0]["counting"]),
            "NENTRIES": sum(len(where) for _, where in data["entries"]),
            "NFACTS": len(data["drawn"]) + len(data["facts"]), "NCALLS": len(result["calls"]),
            "WIDTH": result["width"], "ENERGIES": at.ENERGIES, "FIRST_ENERGY": result["energies"],
            "ARRAYS": len(ARRAYS), "WORKSPACES": len(self.cells), "CELLS": sum(self.cells), "RUN_CELLS": self.cells[0],
            "STARTS": len(self.starts), "SYSTEMS": len(self.systems),
            "MOST_NUMBERS": 1 + max(len(system["counts"]) for system in self.systems),
            "MOST_CONSTANTS": max(self._constants(k) for k in range(len(self.systems))),
            **{name.upper(): order.index(name) for name in USED},
            **{f"{array}_{name}".upper(): getattr(at, name) for array, names in COLUMNS.items() for name in names},
            **STATUSES,
        }  # fmt: skip

    def _constants(self, system: int) -> int:
        """How many constants a system tells, if there is one."""
        place = list(ARRAYS).index("start_constants")
        return int(self.systems[system]["image"]["arrays"][place][0]) if system >= 0 else 0

    def _settings(self) -> dict[str, str]:
        """Settings of a run as expressions, see `ModelRun.prepared` in viewer/core_model.js."""
        run, about, first = self.data["run"], self.data["settings"], len(self.data["drawn"])
        facts = {name: f"facts[{first + k}]" for k, name in enumerate(self.data["facts"])}
        end, atol = c.number(run["end"]), facts.get("atol", c.number(run["atol"]))
        longest = facts.get("step", c.number(run["step"] or math.inf))
        if run["step"] and not about["step_given"]:
            longest = f"fmin({c.number(about['longest'])}, m->end / {c.number(about['fewest'])})"
        return {
            "SMALLEST_TOLERANCE": c.number(TIGHTEST), "TOLERANCE": "0.0",
            "T_END": end if about["end_given"] else facts.get("t_end", end),
            "RTOL": facts.get("rtol", c.number(run["rtol"])),
            "ATOL": atol if about["atol_given"] else f"({c.number(run['atol'] / run['rtol'])} * m->rtol)",
            "LONGEST": longest,
        }  # fmt: skip

    # ---------------------------------------------------------------- workspaces
    def _image(self, number: int, description: Tree, content: bytes) -> Iterator[str]:
        """A workspace before anything has happened in it."""
        arrays, cells, tables = list[str](), 3 * len(ARRAYS), description["tables"]
        words = np.frombuffer(content, np.uint64).tolist() or [0]
        if number < 2:
            yield _list(f"const uint64_t content_{number}[]", (f"UINT64_C({x:#x})" for x in words))
        else:  # that of all systems of the start
            yield f"#define content_{number} content_1"
        shapes = dict(zip(ARRAYS, description["arrays"], strict=True))
        room = max(MORE * shapes["switchings"][0], INSTANTS)
        searched = {"switchings": room, "edges": room + 2, "driver_jump": room * shapes["driver_leap"][0]}
        for name, (*shape, stored) in shapes.items():
            if name in LEFT_BY_STEPS:
                shape[0] = min(shape[0], ROOM)
            if name in searched and shapes["timed"][0]:  # what is there is found anew
                shape[0], stored = searched[name], -1
            size, called = math.prod(shape), "NULL"
            if name in tables:
                called = f"kernels_{number}_{name}"
                yield _list(f"const int {called}[]", self._table(name, tables[name]) or ["0"])
            place = stored // 8 if stored >= 0 else -1
            arrays.append(f"{{{size}, {shape[0]}, {shape[-1]}, {place}, {called}}}")
            cells += max(size, 1)
        yield _list(f"const Array arrays_{number}[]", arrays)
        self.cells.append(cells)

    def _table(self, name: str, kernels: Sequence[str | None]) -> list[str]:
        """Numbers of kernels in a table; for none, of what fails and says the family."""
        family = name.removesuffix("_table").replace("_", " ")
        trap = str(-1 - list(families.SIGNATURE).index(family))
        return [trap if kernel is None else str(self.order[kernel]) for kernel in kernels]

    # ---------------------------------------------------------------- parameters, curves
    def _parameters(self) -> Iterator[str]:
        """Values and limits of the parameters, and where what follows from them stands."""
        parameters = self.data["parameters"]
        yield _numbers("nominal", [*(value for _, value, *_ in parameters), 0.0])
        if parameters:
            yield _list("const char *const names[]", (json.dumps(name) for name, *_ in parameters))
            yield _numbers("least", [-math.inf if low is None else low for _, _, low, _, _ in parameters])
            yield _numbers("most", [math.inf if high is None else high for _, _, _, high, _ in parameters])
        yield _list("const Place entries[]", _places(self.data["entries"]))

    def _functions(self) -> Iterator[str]:
        """The recorded functions."""
        wanted, numbers = ["columns", *(["tables", "before"] if self.result["calls"] else [])], self.data["functions"]
        yield self.functions.text(numbers["arrays"], "arrays")
        for name in wanted:
            yield self.functions.text(numbers[name], f"row_{name}")
        for k, system in enumerate(self.systems):
            yield self.functions.text(system["function"], f"numbers_{k}")

    def _curves(self) -> Iterator[str]:
        """Curves of a row, and what kernels over arrays return for it, call after call."""
        places, calls = self.result["places"], self.result["calls"]
        yield "static void read_curves(const double *in, double *curves) {"
        yield f"    double derived[{1 + sum(place < 0 for place in places)}];\n    row_columns(in, derived);"
        for k, place in enumerate(places):
            yield f"    curves[{k}] = {f'derived[{-1 - place}]' if place < 0 else f'in[NP + {place}]'};"
        yield "}\n\nstatic bool call_kernels(const double *in, double *called) {"
        if calls:
            yield f"    double given[{2 * len(calls)}], table[{1 + sum(call['table'] for call in calls)}];"
            yield "    int64_t none;\n    row_tables(in, table);\n    row_before(in, given);"
        first = 0
        for k, call in enumerate(calls):
            table = f"table + {first}, {call['table']}, " if call["table"] else ""
            yield CALL.format(name=symbol(call["kernel"]), first=2 * k, second=2 * k + 1, table=table, call=k)
            first += call["table"]
        yield "    return true;\n}\n"

    # ---------------------------------------------------------------- the start
    def _systems(self) -> Iterator[str]:
        """How numbers of the systems of the start follow from parameters and constants."""
        rows = []
        for k, system in enumerate(self.systems):
            placed = sum(len(where) for _, where in system["entries"])
            yield _list(f"const Place places_{k}[]", _places(system["entries"]))
            yield _list(f"const unsigned char counts_{k}[]", map(str, system["counts"] or [0]))
            yield _numbers(f"inputs_{k}", [*system["inputs"], 0.0])
            rows.append(f"{{numbers_{k}, {len(system['counts'])}, {placed}, places_{k}, counts_{k}, inputs_{k}}}")
        yield _list("const System systems[]", rows)

    def _starts(self) -> Iterator[str]:
        """The start of the model and those that are found before it."""
        starts = []
        for k, start in enumerate(self.starts):
            rows = [
                f'{{"{"driver" if driver else "joint"} {owner}", "{unit}"}}' for owner, unit, driver in start["rows"]
            ]
            yield _list(f"const Row rows_{k}[]", rows or ['{"", ""}'])
            keys = ("system", "ideal", "loose", "shut", "every", "counting")
            starts.append(f"{{{', '.join(str(start[key]) for key in keys)}, {len(rows)}, rows_{k}}}")
        yield _list("const Start starts[]", starts)
        drivers = [driver["name"] for driver in self.result["told"]["drivers"]] or [""]
        yield _list("const char *const drivers[]", map(json.dumps, drivers))
        yield _list("const char *const contacts[]", (json.dumps(name) for name in self.starts[0]["contacts"] or [""]))


def _places(entries: Sequence[tuple[str, Sequence[int]]]) -> list[str]:
    """Entries of arrays; C has no empty list."""
    order = list(ARRAYS)
    return [f"{{{order.index(name)}, {k}}}" for name, where in entries for k in where] or ["{0, 0}"]


def _numbers(name: str, values: Sequence[float]) -> str:
    return _list(f"const double {name}[]", (c.number(float(x)) for x in values))


def _list(declared: str, values: Iterable[str]) -> str:
    """A list that does not change, with eight entries in a line."""
    every, lines = iter(values), list[str]()
    while row := list(islice(every, 8)):
        lines.append(f"    {', '.join(row)}")
    return f"static {declared} = {{\n" + ",\n".join(lines) + "\n};"
