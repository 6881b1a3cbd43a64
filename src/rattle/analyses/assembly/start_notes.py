"""What became of the values that were given for the start, in words.

An angle of a loop is a guess that selects a closing, and it does its work however rough it is; so is a position that
nearly fits the loops.  Where play is closed, or a massless link, what it leaves open is no longer free: such a value
moves by the play, and such a rate follows.  A value that contradicts a driver, a place or a rate is another thing.
`check` names every change, results only those that matter, in one line.
"""

from __future__ import annotations

import functools
import math
from typing import NamedTuple

import numpy as np

from rattle.analyses.assembly.coincident_ends import without_direction
from rattle.analyses.assembly.computable import finite
from rattle.analyses.assembly.held_bodies import held_by_loads, placed_nearby
from rattle.analyses.assembly.outward import ways_outward
from rattle.analyses.assembly.rank import RANK, free_motions, scaled_rows
from rattle.analyses.assembly.searching import first_guess
from rattle.analyses.assembly.start_values import KEYS, given_values
from rattle.analyses.assembly.tied_bodies import groups_at
from rattle.description.model import GROUND, driven_ends
from rattle.equations.closure import open_by
from rattle.equations.dense import LARGE, dense_rows
from rattle.equations.system import System
from rattle.jit.choices import TINY

UNITS = {"x": "m", "y": "m", "angle": "deg", "vx": "m/s", "vy": "m/s", "omega": "rad/s"}
MOST_NAMED = 6  # joints that are named one by one, at most
MOST_VALUES = 3  # values that a result names, at most
SEEN = 1e-6  # least change that is reported [rad, mechanism sizes, share of the rates]
NOTHING = 1e-12  # share of its measure below which a value is rounding, and shown as 0
FAR = 1e-3  # the same of a body that loads hold and that given angles, which may be rounded, have moved
SHAKE = 1e-3  # displacement along the joints' freedoms [rad, mechanism sizes]
GUESS = math.radians(60)  # up to which an angle that selects a closing is a rough guess
ROUGH = math.radians(10)  # the same of an angle that could have been kept if others had not been given
NEAR = 0.01  # mechanism sizes up to which a position that a driver gives through loops is a rough guess
ACROSS = 2.0  # plays, all together, by which a body may move where pins go from one side of their bushes to the other
FREED = 1e-7  # part in a free motion above which a coordinate can change; below, it is rounding of singular vectors
AT_ODDS, HELD = "the given values contradict each other", "the joints hold it"
UNREACHED = "the joints do not let it get there"
TURNED = "bodies that turn together start in the same turn"


class Change(NamedTuple):
    """A given value that was not kept."""

    text: str
    why: str
    matters: bool


class Played(NamedTuple):
    """Coordinates (3 nb,) that would be free without the rows of closed joints and links in place of contacts."""

    moved: np.ndarray  # all of them
    held: np.ndarray  # those that are not free with these rows


class StartNotes(NamedTuple):
    """What is said of a start."""

    all: tuple[str, ...]  # every change
    brief: tuple[str, ...]  # at most one line on changes, bodies that nobody has placed, forces without direction


def start_notes(system: System, shut: System, t: float, q: np.ndarray, v: np.ndarray) -> StartNotes:
    """Notes on changed values: "asked for crank.angle = 90 deg, got 0 deg: the driver 'motor' holds it".

    shut: the mechanism without play; t: [s]; q, v: (3 nb,) assembled positions [m, m, rad] and rates [m/s, m/s, rad/s].
    """
    changes = _changes(system, shut, t, q, v)
    adrift = [*_adrift(system, t, q), *without_direction(system, t, q, v)]
    return StartNotes(
        (*_lines(changes), *adrift), (*_one_line([change for change in changes if change.matters]), *adrift)
    )


def _lines(changes: list[Change]) -> list[str]:
    """One line for every reason."""
    by_reason: dict[str, list[str]] = {}
    for change in changes:
        by_reason.setdefault(change.why, []).append(change.text)
    return [f"{'; '.join(texts)}: {why}" for why, texts in by_reason.items()]


def _one_line(changes: list[Change]) -> list[str]:
    if not changes:
        return []
    more = len(changes) - MOST_VALUES
    also = f"; and {more} more given values were changed, which `rattle check` names" if more > 0 else ""
    return ["; ".join(_lines(changes[:MOST_VALUES])) + also]


class _Assembled:
    """An assembled start, and what is free there: costly, and rarely needed."""

    def __init__(self, system: System, shut: System, t: float, q: np.ndarray, v: np.ndarray) -> None:
        """Arguments as `start_notes` has them."""
        self.system, self.shut, self.t, self.q, self.v = system, shut, t, q, v

    @functools.cached_property
    def free(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """See `_freedom`."""
        return _freedom(self.shut, self.t, self.q, self.v)

    @functools.cached_property
    def played(self) -> Played:
        """See `_freed_by_play`."""
        return _freed_by_play(self.system, self.t, self.q, self.v)

    def why(self, k: int, turns: bool, change: float, alone: bool) -> str:
        """In words, why coordinate k has changed [SI]; turns: it is an angle; alone: no other position is given."""
        why = _holder(self.shut, self.free, k)
        if why == AT_ODDS and alone:
            why = UNREACHED
        if why == AT_ODDS and turns and abs(math.remainder(change, math.tau)) <= SEEN:
            why = TURNED
        return why

    def limit_of_position(self, k: int, turns: bool, why: str) -> float:
        """Change of a position [m or rad] up to which its given value was a guess that did its work."""
        if turns:
            guess = ROUGH if why in (AT_ODDS, UNREACHED) else GUESS
            return guess if _selects(self.system, self.t, self.system.bodies[k // 3]) else 0.0
        near = NEAR * self.system.size if _through_loops(self.shut, self.free, k) else 0.0
        return max(near, ACROSS * _play(self.system) if self.played.moved[k] else 0.0)

    def limit_of_rate(self, k: int) -> float:
        """The same of a rate, which follows where play is closed."""
        return math.inf if self.played.held[k] else 0.0


def _changes(system: System, shut: System, t: float, q: np.ndarray, v: np.ndarray) -> list[Change]:
    """Given values that were not kept, positions before rates."""
    speed = max(float(np.abs(v).max(initial=0.0)), TINY)
    start, changes = _Assembled(system, shut, t, q, v), []
    alone = int((~np.isnan(given_values(system, 0))).sum()) == 1
    for turn, now in enumerate((q, v)):
        for k, (wanted, got) in enumerate(zip(given_values(system, turn).tolist(), now.tolist(), strict=True)):
            key = KEYS[turn][k % 3]
            size = (1.0 if key == "angle" else system.size) if turn == 0 else max(speed, abs(wanted))
            if math.isnan(wanted) or abs(got - wanted) <= SEEN * size:
                continue
            why = start.why(k, key == "angle", got - wanted, alone and turn == 0)
            limit = start.limit_of_position(k, key == "angle", why) if turn == 0 else start.limit_of_rate(k)
            text = _asked_and_got(f"{system.bodies[k // 3]}.{key}", UNITS[key], key == "angle", wanted, got, size)
            changes.append(Change(text, why, abs(got - wanted) > limit))
    return changes


def _asked_and_got(name: str, unit: str, turns: bool, wanted: float, got: float, size: float) -> str:
    """ "asked for crank.angle = 90 deg, got 0 deg"; size: what the value [SI] is compared with."""
    factor = 180.0 / math.pi if turns else 1.0
    asked, reached = f"{wanted * factor:.6g}", f"{got * factor if abs(got) > NOTHING * size else 0.0:.6g}"
    if asked == reached:
        reached = f"{got * factor:.12g}"
    return f"asked for {name} = {asked} {unit}, got {reached} {unit}"


def _selects(system: System, t: float, body: str) -> bool:
    """True if neither joints nor drivers tie the angle of a body to the ground: a loop may close with several."""
    groups = groups_at(system, t)
    return groups[body][0] != groups[GROUND][0]


def _through_loops(system: System, free: tuple[np.ndarray, np.ndarray, np.ndarray], k: int) -> bool:
    """True if the joints leave coordinate k free and drivers of other bodies hold it."""
    under_all, under_joints, _ = free
    return bool(under_joints[k] and not under_all[k]) and not _own_drivers(system, system.bodies[k // 3])


def _play(system: System) -> float:
    """All clearances together [m]."""
    return sum(joint.clearance for joint in system.model.joints.values())


def _freed_by_play(system: System, t: float, q: np.ndarray, v: np.ndarray) -> Played:
    """What play leaves free, if it is closed or a massless link."""
    loose = {name for name, joint in system.model.joints.items() if joint.contact is not None}
    owned = np.array([row.owner in loose for row in system.rows], dtype=bool)
    if not owned.any():
        return Played(np.zeros(len(q), dtype=bool), np.zeros(len(q), dtype=bool))
    workspace = system.workspace()
    open_by(workspace, t, q, v)
    rows = dense_rows(system, workspace)
    moved = _free(rows[~owned])
    return Played(moved, moved & ~_free(rows))


def _adrift(system: System, t: float, q: np.ndarray) -> list[str]:
    """Bodies that no joint, driver or given value places, if closing the joints has moved them.

    Those that loads hold to the ground are named too where only given angles have moved them.
    q: (3 nb,) positions at t [s].
    """
    reached = {body for body, _, _ in ways_outward(system)}
    resting = {name: place for name, place in held_by_loads(system, q).items() if not placed_nearby(system.model, name)}
    loose = [name for name in system.bodies if name not in reached or name in resting]
    if not loose or system.row_count > LARGE:
        return []
    guess, wanted = first_guess(system, t), given_values(system, 0)
    for name, place in resting.items():
        guess[_places_of(system, name)] = [place[key] for key in KEYS[0]]
    size = np.tile([system.size, system.size, 1.0], system.body_count)
    moved, far = (np.abs(q - guess) > least * size for least in (SEEN, FAR))
    workspace = system.workspace()
    open_by(workspace, t, q, np.zeros_like(q))
    fixed = np.eye(len(q))[~np.isnan(wanted)]
    open_ = np.abs(free_motions(np.vstack([scaled_rows(system, workspace), fixed]))).max(axis=0, initial=0.0) > SEEN
    texts = []
    for name in loose:
        places = _places_of(system, name)
        elsewhere = far[places] if name in resting else (moved & open_)[places]
        if not system.model.initial.given(name) and elsewhere.any():
            x, y, angle = q[places].tolist()
            texts.append(f"{name} to x = {x:.6g} m, y = {y:.6g} m, angle = {math.degrees(angle):.6g} deg")
    if not texts:
        return []
    return [f"closing the joints moved {'; '.join(texts)}, which nothing places: give x, y and angle in [initial]"]


def _places_of(system: System, body: str) -> slice:
    """Where the coordinates of a body stand."""
    n = 3 * system.bodies.index(body)
    return slice(n, n + 3)


def _freedom(system: System, t: float, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Coordinates (3 nb,) that can change under all rows, those that can under the rows of joints, and the rows."""
    workspace = system.workspace()
    open_by(workspace, t, q, v)
    full = dense_rows(system, workspace)
    driving = np.array([row.driver for row in system.rows], dtype=bool)
    every = _free(full)
    if not driving.any():
        return every, every, full
    joints = _free(full[~driving])
    motions = free_motions(scaled_rows(system, workspace)[~driving])
    if len(motions):  # where a coordinate has an extreme, as at a dead centre, it is free beside it
        size = np.tile([system.size, system.size, 1.0], system.body_count)
        open_by(workspace, t, q + SHAKE * size * motions.sum(axis=0), v)
        joints |= _free(dense_rows(system, workspace)[~driving])
    return every, joints, full


def _holder(system: System, free: tuple[np.ndarray, np.ndarray, np.ndarray], k: int) -> str:
    """In words, what prevents the given value of coordinate k."""
    under_all, under_joints, rows = free
    if under_all[k]:
        return AT_ODDS
    if not under_joints[k]:
        return HELD
    body = system.bodies[k // 3]
    own = _own_drivers(system, body)
    if len(own) == 1:
        return f"the driver '{own[0]}' holds it"
    owners = _holding(system, rows, k)
    drivers = [
        f"'{name}'" for name in system.model.drivers if name in owners or owners.isdisjoint(system.model.drivers)
    ]
    joints = [f"'{name}'" for name in system.model.joints if name in owners]
    more = f" and {len(joints) - MOST_NAMED} more" if len(joints) > MOST_NAMED else ""
    through = f" through joint{'s' if len(joints) > 1 else ''} {', '.join(joints[:MOST_NAMED])}{more}" if joints else ""
    several = len(drivers) > 1
    return f"the driver{'s' if several else ''} {', '.join(drivers)} hold{'' if several else 's'} it{through}"


def _own_drivers(system: System, body: str) -> list[str]:
    """Names of the drivers of a body, or of a joint of it."""
    ends = {name: driven_ends(system.model, driver)[:2] for name, driver in system.model.drivers.items()}
    return [name for name, points in ends.items() if body in [point.body for point in points]]


def _holding(system: System, rows: np.ndarray, k: int) -> set[str]:
    """Owners of the rows that together fix coordinate k: those in e_k = Phi_q^T x."""
    unit = np.zeros(rows.shape[1])
    unit[k] = 1.0
    length = np.maximum(np.linalg.norm(rows, axis=1), TINY)
    part = np.abs(np.linalg.lstsq((rows / length[:, None]).T, unit, rcond=RANK)[0])
    return {row.owner for row, size in zip(system.rows, part, strict=True) if size > RANK * part.max()}


def _free(rows: np.ndarray) -> np.ndarray:
    """Coordinates (columns) that can change without violating any of the rows."""
    if not len(rows):
        return np.ones(rows.shape[1], dtype=bool)
    rows = rows / np.maximum(np.linalg.norm(rows, axis=1, keepdims=True), TINY)
    _, values, right = np.linalg.svd(finite(rows))
    rank = int((values > RANK * values[0]).sum())
    free: np.ndarray = np.abs(right[rank:]).max(axis=0, initial=0.0) > FREED
    return free
