"""What a drawing can do, in one line: whether it moves, which freedoms are left, what is too much, what stays open."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rattle.analyses.assembly.rank import nonunique_reactions, rank, rank_of, scaled_rows
from rattle.equations.closure import open_by
from rattle.errors import AssemblyError
from rattle.results.display import quantity
from rattle.sketch.drawn import Drawn

EMPTY = "Put two ground points, then draw bars between them."
BARS = "Draw bars between the ground points: drag from one point to the next."
MOST_NAMED = 3


def freedoms(sketch: Drawn) -> str:
    """What the status line says of a drawing."""
    if not sketch.bodies:
        return BARS if len(sketch.model.ground) > 1 else EMPTY
    if sketch.open_joints:
        gaps = [f"{pin.name} by {quantity(pin.apart, 'm')}" for pin in sketch.open_joints]
        more = f" and {len(gaps) - MOST_NAMED} more" if len(gaps) > MOST_NAMED else ""
        return f"{_counts(sketch)}: does not close, open at {', '.join(gaps[:MOST_NAMED])}{more}"
    try:
        return f"{_counts(sketch)}: {_mobility(sketch)}"
    except AssemblyError as error:  # a motor whose function has no value here, for one
        return f"{_counts(sketch)}: cannot move: {sketch.trouble or error}"


def _counts(sketch: Drawn) -> str:
    joints, motors = len(sketch.model.joints), len(sketch.model.drivers)
    return f"{joints} {'joint' if joints == 1 else 'joints'}, {motors or 'no'} {'motor' if motors == 1 else 'motors'}"


class _Count(NamedTuple):
    left: int  # freedoms that neither joints nor drivers take
    too_many: int  # constraints that repeat others
    unsure: tuple[str, ...]  # whose constraints those may be
    moves_by_joints: bool  # the joints alone leave a freedom: what is too much is a motor


def _count(sketch: Drawn) -> _Count:
    system = sketch.system
    assert system is not None
    q = np.array([sketch.places[name] for name in system.bodies]).ravel()
    workspace = system.workspace()
    open_by(workspace, 0.0, q, np.zeros_like(q))
    independent = rank(system, workspace)
    too_many = system.row_count - independent
    unsure = nonunique_reactions(system, workspace) if too_many else ()
    of_joints = scaled_rows(system, workspace)[[not row.driver for row in system.rows]]
    moves = 3 * system.body_count > rank_of(of_joints)
    return _Count(3 * system.body_count - independent, too_many, unsure, moves)


def freedoms_left(sketch: Drawn) -> int:
    """How many freedoms of a drawing have no motor."""
    return _count(sketch).left if sketch.bodies else 0


def _mobility(sketch: Drawn) -> str:
    count = _count(sketch)
    surplus = _surplus(sketch, count)
    if count.left:
        free = f"{count.left} {'freedom without a motor' if count.left == 1 else 'freedoms without a motor'}"
    elif not sketch.model.drivers or (count.too_many and sketch.trouble):
        return f"cannot move: {surplus or 'no degree of freedom is left'}"
    elif sketch.trouble:
        return f"cannot move: {sketch.trouble}"
    else:
        free = "moves"
    return f"{free}, {surplus}" if surplus else free


def _surplus(sketch: Drawn, count: _Count) -> str:
    """How many constraints are too many, and whose the last of them may be; "" if none is."""
    if not count.too_many:
        return ""
    motors, joints = (
        [name for name in count.unsure if name in table] for table in (sketch.model.drivers, sketch.model.joints)
    )
    spare = motors if count.moves_by_joints and motors else joints or count.unsure
    return f"{count.too_many} constraint{'s' if count.too_many > 1 else ''} too many ({', '.join(spare[-1:])})"
