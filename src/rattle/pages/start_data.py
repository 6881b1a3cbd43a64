"""What a page needs to find the start of a mechanism for other parameters: `viewer/core_start.js` does.

Python finds what belongs to the form: which pins lie where joints do not say, which are pressed by reactions, what is
put together first (the mechanism without play, and without joints whose rows count from the start).  Numbers that
follow from parameters are recorded; see `analyses.straight_line.recorded_arrays`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from rattle.analyses.assembly.assembly import Assembled, consistent_start, ideal_system
from rattle.analyses.assembly.outside import least_gaps
from rattle.analyses.assembly.pins import (
    held_pins,
    pin_places,
    play_arrays,
    pressed,
    undetermined,
    with_play,
)
from rattle.analyses.assembly.searching import first_guess, joint_lines, joint_offsets, search_arrays
from rattle.analyses.assembly.start_constants import constants_of, counting_rows, flat, with_constants, without_counting
from rattle.analyses.assembly.start_values import KEYS, given_values
from rattle.analyses.assembly.tied_bodies import given_in_one_turn
from rattle.analyses.assembly.without_play import ideal_model
from rattle.analyses.straight_line.recorded_arrays import Values, recorded_arrays
from rattle.description.model import Model, driven_ends
from rattle.equations import start_columns as of
from rattle.equations.dense import LARGE
from rattle.equations.system import System, compile_system, is_link, joint_rows
from rattle.errors import AssemblyError, TraceError
from rattle.jit import layout as at
from rattle.language.local_function import packed
from rattle.mechanism import Mechanism
from rattle.pages.run_image import Content, workspace_image
from rattle.pages.tape import Tape, add_arrays
from rattle.value_types import Json

Form = Callable[[Model], Model]
Numbers = Callable[[System], Values] | None  # of vectors, see `_start_numbers`
ALL, MOVING = True, False  # entries of arrays that count: all, or those from which positions and rates follow
OFFSET = (3.0, 4.0)  # of the points of a joint, at which it tells what its constants are


class StartData(NamedTuple):
    """A start that can be found for other parameters."""

    description: dict[str, Json]  # of its systems, and of the start, see `_Writer`
    content: bytes


def start_data(m: Mechanism, tape: Tape, names: Sequence[str] | None = None) -> StartData:
    """The start of a mechanism as data for pages; its functions are added to a tape.

    names: of the parameters, by default all that follow from none.
    Raises TraceError, with the reason, where no page can follow its search; ModelError, AssemblyError.
    """
    writer = _Writer(m, tape, names)
    description = writer.start(m.system, lambda model: model, m.start, MOVING)
    names = list(writer.names)
    parameters = m.model.parameters
    own = [parameters[name].value for name in names]
    content = bytes(writer.content.written)
    return StartData({"parameters": names, "own": own, "systems": writer.systems, "start": description}, content)


class _Play(NamedTuple):
    """Pins that are held in a start, all that can be, those whose offset follows from reactions."""

    held: list[str]
    every: list[str]
    missing: list[str]
    shut: System  # the mechanism without play
    ideal: dict[str, Json] | None  # its start


class _Writer:
    """Collects the systems that a start needs: their images, and functions of the numbers in them."""

    def __init__(self, m: Mechanism, tape: Tape, asked: Sequence[str] | None) -> None:
        self.document, self.content, self.tape, self.asked = m._document, Content(), tape, asked
        self.names: tuple[str, ...] = ()
        self.systems: list[dict[str, Json]] = []
        self.without_play: list[tuple[System, System, Assembled | AssemblyError]] = []

    def shut(self, system: System) -> tuple[System, Assembled | AssemblyError]:
        """The mechanism without play, made of this very model, and its start, or why there is none."""
        for played, ideal, begun in self.without_play:
            if played is system:
                return ideal, begun
        shut = ideal_system(system.model)
        try:
            start: Assembled | AssemblyError = consistent_start(shut, 0.0)
        except AssemblyError as error:
            start = error
        self.without_play.append((system, shut, start))
        return shut, start

    def start(self, system: System, form: Form, start: Assembled, counted: bool) -> dict[str, Json]:
        """A start, and those that are found before it.

        counted: whether all entries of arrays count, or `MOVING`.
        """
        if system.row_count > LARGE:
            raise TraceError("the mechanism has too many joints for a page that finds its start")
        held, every, missing, shut, ideal = self._play(system, form)
        closed = self._closed(system, form, held, alike=set(held) == set(every)) if held else None
        more = self._closed(system, form, every, alike=True) if ideal is not None and every != held else None
        numbers = _start_numbers(system, every, missing)
        vectors = _start_arrays(system, numbers(system)) | play_arrays(
            system, shut, held, every, missing, ideal is not None
        )
        vectors |= {"start_q": start.q, "start_v": start.v}
        vectors["start_form"][of.EVERY] = more is not None
        return {
            "system": self.system(system, form, counted, vectors, numbers),
            "rows": [[row.owner, row.unit, row.driver] for row in system.rows],
            "contacts": [system.joints[n] for n in system.arrays["contact"][:, at.OWNER].tolist()],
            "ideal": ideal, "shut": closed, "every": more,
            **(self._counting(system, form) if constants_of(system.model) else {"loose": None, "counting": None}),
        }  # fmt: skip

    def _play(self, system: System, form: Form) -> _Play:
        """What the start without play does for that of a system."""
        links, open_ = with_play(system.model)
        if not (links or open_):
            return _Play([], [], [], system, None)
        joints = system.model.joints
        shut, without = self.shut(system)
        near = without.q if isinstance(without, Assembled) else first_guess(system)
        held = [*links, *undetermined(system, 0.0, near, {name: joints[name] for name in open_})]
        missing = pressed(system.model, links)
        if isinstance(without, Assembled):
            ideal = self.start(shut, lambda read: ideal_model(form(read)), without, bool(missing))
            return _Play(held, list(dict.fromkeys([*held, *open_])), missing, shut, ideal)
        if held:
            raise TraceError(f"its start without play is not known: {without}")
        return _Play([], [], [], shut, None)

    def _counting(self, system: System, form: Form) -> dict[str, Json]:
        """What is put together before the constants are known, and the rows that tell them."""
        model = system.model
        loose = compile_system(without_counting(model))
        if any(is_link(joint) for joint in loose.model.joints.values()):
            raise TraceError("gears beside massless links: no page finds such a start")
        constants = constants_of(model)

        def without(read: Model) -> Model:
            read = form(read)
            return _without_contacts(read, {name for name, joint in read.joints.items() if joint.from_start})

        zero = dict.fromkeys(constants, 0.0)
        counting = compile_system(with_constants(without(model), zero))
        joints, counted = [], counting_rows(counting)
        for name in constants:
            if name in model.drivers:
                joints.append([counting.first_row(name), len(model.drivers[name].leaf.rows), False, 0, 0, 0])
                continue
            leaf = model.joints[name].leaf
            rows = counted[name]
            residuals = tuple(float(k + 1) for k in range(len(rows)))
            told = leaf.start_constants(residuals, OFFSET)
            polar = told == (residuals[0], math.hypot(*OFFSET), math.atan2(OFFSET[1], OFFSET[0]), 0.0)
            if not polar and told != residuals:
                raise TraceError(f"joint '{name}' has constants of a kind that no page knows")
            ends = (model.joints[name].a.body, model.joints[name].b.body)
            bodies = [1 + system.bodies.index(x) if x in system.bodies else 0 for x in ends]
            joints.append([rows.start, len(rows), polar, *bodies, counting.first_value(name)])
        vectors = {"start_counting": np.array(joints, np.int64), "start_constants": np.array(flat(constants))}
        start = consistent_start(loose, 0.0)
        return {
            "loose": self.start(loose, lambda read: without_counting(form(read)), start, MOVING),
            "counting": self.system(counting, without, MOVING, vectors, None),
        }

    def _closed(self, system: System, form: Form, held: list[str], alike: bool) -> int:
        """The mechanism with some joints closed, whose pins are held: the first of those that can be."""
        model = system.model

        def closed(read: Model) -> Model:
            read = form(read)
            return _without_contacts(read, held)

        shut = compile_system(closed(model))
        if alike and not constants_of(model):
            shut, closed = self.shut(system)[0], lambda read: ideal_model(form(read))
        return self.system(shut, closed, MOVING, {"start_pins": held_pins(system, shut, held)}, None)

    def system(
        self, system: System, form: Form, counted: bool, vectors: Mapping[str, np.ndarray], numbers: Numbers
    ) -> int:
        """The number of a new entry of `systems`: the image of a workspace, and how its numbers follow from parameters.

        vectors: its arrays of the start.
        """
        workspace = system.assembly_workspace(None, **vectors)
        recorded = recorded_arrays(self.document, system, self.asked, form=form, more=numbers)
        self.names, entries = recorded.names, recorded.entries
        counts = [x for name in entries for x in _counts(system, name, entries[name], counted)]
        self.systems.append(
            {
                "function": add_arrays(self.tape, recorded),
                "image": {**workspace_image(system, workspace, self.content), "times": [0, -1], "width": 0},
                "entries": [[name, where.tolist()] for name, where in entries.items()],
                "counts": [*map(int, counts), *(0 for _ in recorded.facts)],
                "inputs": recorded.inputs(system).tolist(),
            }
        )
        return len(self.systems) - 1


def _counts(system: System, name: str, where: np.ndarray, counted: bool) -> list[bool]:
    """Whether positions and rates of the start depend on entries of an array."""
    if name in ("start_least", "start_size"):
        return [False] * len(where)
    if counted or name.startswith("start_"):
        return [True] * len(where)
    if name == "values":
        return [int(k) < _values_of_joints(system.model) for k in where]
    moving = name == "weight" or (name == "const" and len(system.arrays["jet"]) > 0)
    return [moving] * len(where)


def _without_contacts(model: Model, names: Container[str]) -> Model:
    """A model in which these joints have no contact."""
    joints = {name: replace(joint, contact=None) if name in names else joint for name, joint in model.joints.items()}
    return replace(model, joints=joints)


def _values_of_joints(model: Model) -> int:
    """How many parameters of joints and drivers there are in `values`: they come first."""
    joints = sum(len(packed([*joint.a.at, *joint.b.at, *joint_rows(joint)[1]])) for joint in model.joints.values())
    return joints + sum(at.POINTS + len(driven_ends(model, driver)[2]) + 3 for driver in model.drivers.values())


# ---------------------------------------------------------------- numbers beside the arrays
def _start_numbers(system: System, held: list[str], missing: list[str]) -> Callable[[System], Values]:
    """How numbers of what is given for a start follow from a system.

    held: pins that can be held; missing: those whose offset follows from reactions.
    """
    turns = np.nan_to_num(given_in_one_turn(system, 0.0) - given_values(system, 0)).tolist()  # whole ones

    def numbers(other: System) -> Values:
        offsets, joints = other.model.initial.offsets, other.model.joints
        values = {
            "start_given": [x + turn for x, turn in zip(_given(other, KEYS[0]), turns, strict=True)],
            "start_rates": _given(other, KEYS[1]),
            "start_offsets": [x for offset in joint_offsets(other, offsets) for x in offset],
            "start_lines": [x for line in joint_lines(other) for x in line],
            "start_held": [x for place in pin_places(other, held) for x in place],
            "start_pressed": [x for name in missing for x in (joints[name].clearance, 0.0, 0.0)],
            "start_least": [least for least, _ in least_gaps(other)],
            "start_size": [other.size],
        }
        return {name: dict(enumerate(entries)) for name, entries in values.items()}

    return numbers


def _start_arrays(system: System, numbers: Values) -> dict[str, np.ndarray]:
    """Arrays of the start of a system, with its numbers."""
    values, rates, least = (
        np.array([*numbers[f"start_{name}"].values()], dtype=float) for name in ("given", "rates", "least")
    )
    arrays = search_arrays(system, values, system.model.initial.offsets)
    return arrays | {"start_rates": rates, "start_least": least}


def _given(system: System, keys: Sequence[str]) -> list[object]:
    """Given values of these keys, body after body; nan if not given."""
    bodies = system.model.initial.bodies
    return [bodies.get(body, {}).get(key, math.nan) for body in system.bodies for key in keys]
