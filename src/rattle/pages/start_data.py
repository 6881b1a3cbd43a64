"""What a page needs to find the start of a mechanism for other parameters: `viewer/core_start.js` does.

Python finds what belongs to the form: which pins lie where joints do not say, which are pressed by reactions, what is
put together first (the mechanism without play, and without joints whose rows count from the start).  Numbers that
follow from parameters are recorded; see `analyses.straight_line.recorded_arrays`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from rattle.analyses.assembly.assembly import (
    Assembled,
    consistent_start,
    ideal_system,
    undetermined,
    with_play,
)
from rattle.analyses.assembly.first_guess import first_guess, ways_of_kernels
from rattle.analyses.assembly.outside import least_gaps
from rattle.analyses.assembly.start_constants import constants_of, flat, with_constants, without_counting
from rattle.analyses.assembly.start_values import KEYS
from rattle.analyses.assembly.vector_loops import given_in_one_turn
from rattle.analyses.assembly.without_play import ideal_model
from rattle.analyses.straight_line.recorded_arrays import Values, recorded_arrays
from rattle.description.model import Model, driven_ends
from rattle.equations.dense import LARGE
from rattle.equations.start_near import DISTANCE, LINE
from rattle.equations.system import System, compile_system, is_link, joint_rows
from rattle.errors import AssemblyError, TraceError
from rattle.jit import layout as at
from rattle.language.local_function import packed
from rattle.mechanism import Mechanism
from rattle.pages.run_image import Content, workspace_image
from rattle.pages.tape import Tape, add_arrays

Form = Callable[[Model], Model]
Numbers = Callable[[System], Values] | None  # of vectors, see `_start_numbers`
ALL, MOVING = True, False  # entries of arrays that count: all, or those from which positions and rates follow
OFFSET = (3.0, 4.0)  # of the points of a joint, at which it tells what its constants are
NO_OFFSET = 1e-9  # clearances below which an offset is none: the pin is where it is pressed


class StartData(NamedTuple):
    """A start that can be found for other parameters."""

    description: dict[str, Any]  # see `_Writer.start`
    content: bytes


def start_data(m: Mechanism, tape: Tape, names: Sequence[str] | None = None) -> StartData:
    """The start of a mechanism as data for pages; its functions are added to a tape.

    names: of the parameters, by default all that follow from none.
    Raises TraceError, with the reason, where no page can follow its search; ModelError, AssemblyError.
    """
    writer = _Writer(m, tape, names)
    description = writer.start(m.system, lambda model: model, m.start, MOVING)
    names = list(writer.names)
    known = m.model.parameters
    own = [known[name].value for name in names]
    return StartData({"parameters": names, "own": own, "start": description}, bytes(writer.content.written))


class _Writer:
    """Collects the systems that a start needs: their images, and functions of the numbers in them."""

    def __init__(self, m: Mechanism, tape: Tape, asked: Sequence[str] | None) -> None:
        self.document, self.content, self.tape, self.asked = m._document, Content(), tape, asked
        self.names: tuple[str, ...] = ()
        self.without_play: list[tuple[System, System, Assembled | AssemblyError]] = []

    def shut(self, system: System) -> tuple[System, Assembled | AssemblyError]:
        """The mechanism without play, made of this very model, and its start, or why there is none."""
        for known, ideal, begun in self.without_play:
            if known is system:
                return ideal, begun
        shut = ideal_system(system.model)
        try:
            start: Assembled | AssemblyError = consistent_start(shut, 0.0)
        except AssemblyError as error:
            start = error
        self.without_play.append((system, shut, start))
        return shut, start

    def start(
        self, system: System, form: Form, start: Assembled, counted: bool, presses: Sequence[str] = ()
    ) -> dict[str, Any]:
        """A start, and those that are found before it.

        counted: whether all entries of arrays count, or `MOVING`; presses: joints whose reactions are asked for.
        """
        if system.row_count > LARGE:
            raise TraceError("the mechanism has too many joints for a page that finds its start")
        model = system.model
        links, open_ = with_play(model)
        offsets = {name: model.initial.offsets.get(name, (0.0, 0.0)) for name in (*links, *open_)}
        missing = [x for x in links if math.hypot(*offsets[x]) < NO_OFFSET * model.joints[x].clearance]
        ideal, held = None, list[str]()
        if offsets:
            shut, without = self.shut(system)
            near = without.q if isinstance(without, Assembled) else first_guess(system)
            held = [*links, *undetermined(system, 0.0, near, {name: model.joints[name] for name in open_})]
            if isinstance(without, Assembled):
                ideal = self.start(shut, lambda read: ideal_model(form(read)), without, bool(missing), missing)
            elif held:
                raise TraceError(f"its start without play is not known: {without}")
        given = [name in model.initial.offsets for name in held]
        every = list(dict.fromkeys([*held, *open_])) if ideal is not None else []
        vectors, numbers = _start_numbers(system, every, missing)
        vectors["first"] = np.array([system.first_row(x) for x in presses], np.int64).reshape(-1, 1)
        vectors["pressed"] = np.zeros((len(presses), 3))
        made: dict[str, Any] = {
            "system": self.system(system, form, counted, vectors, numbers),
            "q": start.q.tolist(), "v": start.v.tolist(), "constants": flat(constants_of(model)), "size": system.size,
            "rows": [[row.owner, row.unit, row.driver] for row in system.rows],
            "contacts": [system.joints[n] for n in system.arrays["contact"][:, at.OWNER].tolist()],
            "ideal": ideal, "held": held, "missing": missing, "keeps": not missing and not any(given),
            "loose": None, "every": every, "holds": [],
        }  # fmt: skip
        if constants_of(model):
            made |= self._counting(system, form)
        for names in ([held] if held else []) + ([every] if every != held and not missing else []):
            made["holds"].append(self._closed(system, form, names, alike=len(names) == len(offsets)))
        return made

    def _counting(self, system: System, form: Form) -> dict[str, Any]:
        """What is put together before the constants are known, and the rows that tell them."""
        model = system.model
        loose = compile_system(without_counting(model))
        if any(is_link(one) for one in loose.model.joints.values()):
            raise TraceError("gears beside massless links: no page finds such a start")
        known = constants_of(model)

        def without(read: Model) -> Model:
            read = form(read)
            rows = {k: replace(one, contact=None) if one.leaf.from_start else one for k, one in read.joints.items()}
            return replace(read, joints=rows)

        zero = dict.fromkeys(known, 0.0)
        counting = compile_system(with_constants(without(model), zero))
        joints = []
        for name in known:
            leaf = model.joints[name].leaf
            residuals = tuple(float(k + 1) for k in range(len(leaf.rows)))
            told = leaf.start_constants(residuals, OFFSET)
            polar = told == (residuals[0], math.hypot(*OFFSET), math.atan2(OFFSET[1], OFFSET[0]), 0.0)
            if not polar and told != residuals:
                raise TraceError(f"joint '{name}' has constants of a kind that no page knows")
            first, ends = counting.first_row(name), (model.joints[name].a.body, model.joints[name].b.body)
            bodies = [1 + system.bodies.index(x) if x in system.bodies else 0 for x in ends]
            joints.append({"row": first, "rows": len(leaf.rows), "polar": polar, "ends": bodies,
                           "values": counting.first_value(name)})  # fmt: skip
        return {
            "loose": self.start(
                loose, lambda read: without_counting(form(read)), consistent_start(loose, 0.0), MOVING
            ),
            "counting": {"system": self.system(counting, without, MOVING, {}, None), "joints": joints},
        }  # fmt: skip

    def _closed(self, system: System, form: Form, held: list[str], alike: bool) -> dict[str, Any]:
        """The mechanism with some joints closed, whose pins are held: the first of `every`."""
        model, number = system.model, {name: n for n, name in enumerate(("ground", *system.bodies))}

        def closed(read: Model) -> Model:
            read = form(read)
            joints = {name: replace(one, contact=None) if name in held else one for name, one in read.joints.items()}
            return replace(read, joints=joints)

        shut = compile_system(closed(model))
        if alike and not constants_of(model):
            shut, closed = self.shut(system)[0], lambda read: ideal_model(form(read))
        pins, which = [], []
        for n, name in enumerate(held):
            for owner in (name, *(key for key, driver in model.drivers.items() if driver.joint == name)):
                pins.append((number[model.joints[name].a.body], shut.first_value(owner)))
                which.append(n)
        vectors = {"pins": np.array(pins, np.int64).reshape(-1, 2), "shifts": np.zeros((len(pins), 4))}
        return {"system": self.system(shut, closed, MOVING, vectors, None), "which": which}

    def system(
        self, system: System, form: Form, counted: bool, vectors: Mapping[str, np.ndarray], numbers: Numbers
    ) -> dict[str, Any]:
        """The image of a workspace, and how numbers in it, and in vectors beside it, follow from parameters."""
        n = 3 * system.body_count
        state = {name: np.zeros(n) for name in ("q", "v", "given", "rates") if name not in vectors}
        every = {**state, "scratch": np.zeros((2, n)), **vectors}
        recorded = recorded_arrays(self.document, system, self.asked, form=form, more=numbers)
        self.names, entries = recorded.names, recorded.entries
        arrays = [name for name in entries if name not in vectors]
        beside = [(name, k) for name in entries if name in vectors for k in entries[name].tolist()]
        counts = [x for name in arrays for x in _counts(system, name, entries[name], counted)]
        counts += [*(vector != "least" for vector, _ in beside), *(False for _ in recorded.facts)]
        return {
            "function": add_arrays(self.tape, recorded),
            "image": {
                **workspace_image(system, system.assembly_workspace(), self.content),
                "times": [0, -1], "width": 0,
                "more": {
                    name: [f"{'f' if one.dtype == float else 'i'}{one.ndim}", self.content.add(one), *one.shape]
                    for name, one in every.items()
                },
            },
            "entries": [[name, entries[name].tolist()] for name in arrays],
            "facts": [*map(list, beside), *([name, -1] for name in recorded.facts)],
            "counts": [int(x) for x in counts], "inputs": recorded.inputs(system).tolist(),
        }  # fmt: skip


def _counts(system: System, name: str, where: np.ndarray, counted: bool) -> list[bool]:
    """Whether positions and rates of the start depend on entries of an array."""
    if counted:
        return [True] * len(where)
    if name == "values":
        return [int(k) < _values_of_joints(system.model) for k in where]
    moving = name == "weight" or (name == "const" and len(system.arrays["jet"]) > 0)
    return [moving] * len(where)


def _values_of_joints(model: Model) -> int:
    """How many parameters of joints and drivers there are in `values`: they come first."""
    joints = sum(len(packed([*one.a.at, *one.b.at, *joint_rows(one)[1]])) for one in model.joints.values())
    return joints + sum(at.POINTS + len(driven_ends(model, one)[2]) + 3 for one in model.drivers.values())


# ---------------------------------------------------------------- numbers beside the arrays
def _start_numbers(
    system: System, held: list[str], missing: list[str]
) -> tuple[dict[str, np.ndarray], Callable[[System], Values]]:
    """Vectors of what is given for a start, and how their numbers follow from a system."""
    n, ways, one_turn = 3 * system.body_count, ways_of_kernels(system), given_in_one_turn(system, 0.0)
    joints = _way_joints(system)

    def find(other: System) -> Values:
        model, found = other.model, {name: dict[int, Any]() for name in shapes}
        for turn, vector in enumerate(("given", "rates")):
            for b, body in enumerate(other.bodies):
                for k, key in enumerate(KEYS[turn]):
                    found[vector][3 * b + k] = model.initial.bodies.get(body, {}).get(key, math.nan)
        for k, name in enumerate(joints):
            offset, joint = model.initial.offsets.get(name, (0.0, 0.0)), model.joints[name]
            found["offsets"] |= {2 * k: offset[0], 2 * k + 1: offset[1]}
            found["lines"] |= {2 * k + LINE: joint.line or 0.0, 2 * k + DISTANCE: joint.distance}
        for k, name in enumerate(held):
            place = *model.joints[name].a.at, *model.initial.offsets.get(name, (0.0, 0.0))
            found["held"] |= dict(enumerate(place, 4 * k))
        for k, name in enumerate(missing):
            found["clearances"][k] = model.joints[name].clearance
        found["least"] |= {k: least for k, (least, _) in enumerate(least_gaps(other))}
        return found

    shapes = {
        "given": (n,), "rates": (n,), "offsets": (len(ways), 2), "lines": (len(ways), 2), "held": (len(held), 4),
        "clearances": (len(missing),), "least": (len(system.arrays["contact"]),),
    }  # fmt: skip
    vectors: dict[str, np.ndarray] = {name: np.zeros(shape) for name, shape in shapes.items()}
    for name, values in find(system).items():
        for place, value in values.items():
            vectors[name].ravel()[place] = value
    turns = one_turn - vectors["given"]  # whole ones
    vectors |= {"given": one_turn, "turns": np.where(np.isnan(turns), 0.0, turns), "ways": ways}
    return vectors, find


def _way_joints(system: System) -> list[str]:
    """The joint of every way outward."""
    first = {int(p): name for name, p in zip(system.joints, system.arrays["joint"][:, at.FIRST_P], strict=True)}
    return [first[int(way)] for way in ways_of_kernels(system)[:, 4]]
