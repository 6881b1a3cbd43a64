"""Measures by a click: what is told of a position, and the entry of [signals] that a run computes it with."""

from __future__ import annotations

import math
from collections.abc import Iterable
from itertools import count
from typing import NamedTuple

import numpy as np

from rattle.analyses.assembly.rank import RANK
from rattle.description.model import Joint
from rattle.description.read_values import TAKEN
from rattle.equations.closure import open_by
from rattle.equations.dense import dense_rows
from rattle.equations.placement import pose
from rattle.errors import InputError, suggest
from rattle.language.expression import RESERVED
from rattle.mechanism import Mechanism
from rattle.sketch.spots import Place, Spot, spot

STILL = 1e-9  # speed of a point, per rate of the driver and arm of the size, below which it stands still


class Measure(NamedTuple):
    """A measure at a position, and how a run computes it."""

    label: str  # what it is, in words
    value: float  # [unit]
    unit: str  # SI
    name: str  # of its signal: none of the model's names
    expression: str

    @property
    def entry(self) -> str:
        """Its line in the table [signals]."""
        return f'{self.name} = "{self.expression}"'


def unused_name(m: Mechanism, wish: str, besides: Iterable[str] = ()) -> str:
    """`wish`, or with the first number behind it that makes it a name which the model does not have."""
    model = m.model
    taken = {*TAKEN, *RESERVED, *besides, *model.parameters, *model.signals, *model.states, *model.tables.curves}
    taken |= {*model.bodies, *model.joints, *model.drivers, *model.loads}
    wish = "".join(letter if letter.isascii() and letter.isalnum() else "_" for letter in wish)
    return next(name for n in count(1) if (name := wish if n == 1 else f"{wish}_{n}") not in taken)


def distance(m: Mechanism, a: Place, b: Place, q: np.ndarray | None = None) -> Measure:
    """Distance of two places [m]; q: (3 nb,) positions, by default those of the start.  Raises InputError."""
    first, second = spot(m, a), spot(m, b)
    value = float(np.hypot(*(second.at(m, _at(m, q)) - first.at(m, _at(m, q)))))
    expression = f"hypot({second.x} - {first.x}, {second.y} - {first.y})"
    label = f"distance of {first.label} and {second.label}"
    return Measure(label, value, "m", unused_name(m, "distance"), expression)


def angle(m: Mechanism, a: Place, corner: Place, b: Place, q: np.ndarray | None = None) -> Measure:
    """Angle at a corner between the lines to two places [rad], 0 to pi; q as in `distance`.  Raises InputError."""
    first, middle, second = spot(m, a), spot(m, corner), spot(m, b)
    lines = [_Line.between(m, middle, end, _at(m, q)) for end in (first, second)]
    label = f"angle at {middle.label} from {first.label} to {second.label}"
    return _angle_of(m, label, "angle_at", lines, half=False)


def transmission_angle(
    m: Mechanism, joint: str, ends: tuple[str, str] = ("", ""), q: np.ndarray | None = None
) -> Measure:
    """Angle at a pin between the lines of the two bodies it joins, coupler and follower [rad], 0 to pi/2.

    The line of a body goes to its other joint; of a slider it is normal to its guide.  ends: the joints to which the
    lines go on A and B, needed where a body has more than two.  At a right angle forces are passed on best.
    q as in `distance`.  Raises InputError where there is no pin, or a line is not clear.
    """
    pin = m.model.joints.get(joint)
    if pin is None:
        raise InputError(f"there is no joint '{joint}'{suggest(joint, list(m.model.joints))}")
    if not pin.is_hinge:
        raise InputError(
            f"joint '{joint}' is no pin: a transmission angle is measured at the pin of coupler and follower"
        )
    lines = [_line_of(m, pin, n, end, _at(m, q)) for n, end in enumerate(ends)]
    return _angle_of(m, f"transmission angle at {joint}", f"transmission_{joint}", lines, half=True)


def mechanical_advantage(
    m: Mechanism, driver: str, place: Place, direction: float | None = None, q: np.ndarray | None = None
) -> Measure:
    """Force at a place over the effort of a driver, without friction and play: rate of the driver over speed there.

    In 1/m for a driven angle (N for each N m), a plain number for a driven position.  direction: of the force, in the
    ground plane [rad]; by default along the motion of the place, and then the number is positive.
    Infinite where the place stands still.  q as in `distance`.  Raises InputError, also if other freedoms are left.
    """
    if driver not in m.model.motors or not m.model.drivers[driver].joint:
        motors = [name for name, motor in m.model.motors.items() if motor.joint]
        raise InputError(f"there is no driver '{driver}' of a joint{suggest(driver, motors)}")
    joint, end = m.model.joints[m.model.drivers[driver].joint], spot(m, place)
    rate = _speed(m, driver, end, _at(m, q))
    along = float(np.hypot(*rate)) if direction is None else float(rate @ [math.cos(direction), math.sin(direction)])
    value = 1.0 / along if abs(along) > STILL * m.system.size else math.inf
    if direction is None:
        speed, over = f"hypot({end.vx}, {end.vy})", f"abs({joint.name}.rate)"
    else:
        speed = f"({end.vx}*cos({direction!r}) + {end.vy}*sin({direction!r}))"
        over = f"{joint.name}.rate"
    unit = "1/m" if joint.coordinate == "angle" else ""
    label = f"force at {end.label} over {'torque' if unit else 'force'} of {driver}"
    return Measure(label, value, unit, unused_name(m, "advantage"), f"{over}/{speed}")


def _at(m: Mechanism, q: np.ndarray | None) -> np.ndarray:
    return m.start.q if q is None else q


class _Line(NamedTuple):
    """A direction as numbers at a position, and as expressions."""

    x: float
    y: float
    along_x: str
    along_y: str

    @classmethod
    def between(cls, m: Mechanism, a: Spot, b: Spot, q: np.ndarray) -> _Line:
        """From a to b."""
        x, y = (b.at(m, q) - a.at(m, q)).tolist()
        return cls(x, y, f"({b.x} - {a.x})", f"({b.y} - {a.y})")


def _angle_of(m: Mechanism, label: str, name: str, lines: list[_Line], half: bool) -> Measure:
    """Angle between two lines; half: the smaller one of both that they have with each other."""
    a, b = lines
    sine, cosine = abs(a.x * b.y - a.y * b.x), a.x * b.x + a.y * b.y
    across = f"abs({a.along_x}*{b.along_y} - {a.along_y}*{b.along_x})"
    along = f"{a.along_x}*{b.along_x} + {a.along_y}*{b.along_y}"
    if half:
        cosine, along = abs(cosine), f"abs({along})"
    return Measure(label, math.atan2(sine, cosine), "rad", unused_name(m, name), f"atan2({across}, {along})")


def _line_of(m: Mechanism, pin: Joint, side: int, other: str, q: np.ndarray) -> _Line:
    """The line of one of the bodies of a pin, from there to its other joint."""
    end = (pin.a, pin.b)[side]
    joint = _other_joint(m, pin, end.body, other)
    if joint.line is not None and joint.kept_angle is not None:  # a slider: normal to its guide
        guide, body = pose(m.system, q, joint.a.body)[2] + joint.line, joint.a.body
        turn = f"{joint.line!r}" if body == "ground" else f"({body}.angle + {joint.line!r})"
        return _Line(-math.sin(guide), math.cos(guide), f"(-sin({turn}))", f"cos({turn})")
    far = joint.a if joint.a.body == end.body else joint.b
    here, there = (
        spot(m, f"{point.body}.{point.name}" if point.name else (point.body, point.at)) for point in (end, far)
    )
    return _Line.between(m, here, there, q)


def _other_joint(m: Mechanism, pin: Joint, body: str, other: str) -> Joint:
    """The joint of a body besides a pin, or that of this name.  Raises InputError where that is not clear."""
    others = {
        joint.name: joint
        for joint in m.model.joints.values()
        if joint.name != pin.name and joint.places and body in (joint.a.body, joint.b.body)
    }
    if other and other not in others:
        raise InputError(f"joint '{other}' is not one of '{body}'{suggest(other, list(others))}")
    if not other and len(others) != 1:
        which = f"it has {', '.join(others)}: say to which its line goes" if others else "it has no other"
        raise InputError(f"the line of '{body}' goes from '{pin.name}' to its other joint, and {which}")
    return others[other or next(iter(others))]


def _speed(m: Mechanism, driver: str, end: Spot, q: np.ndarray) -> np.ndarray:
    """Velocity (2,) of a place for a unit rate of a driver, all others at rest, every play closed."""
    closed = m.ideal().system
    workspace = closed.workspace()
    open_by(workspace, 0.0, q, np.zeros_like(q))
    rows, side = dense_rows(closed, workspace), np.zeros(closed.row_count)
    side[closed.first_row(driver)] = 1.0
    rates, _, rank, _ = np.linalg.lstsq(rows, side, rcond=RANK)
    if rank < len(q):
        left = len(q) - rank
        what = "1 degree of freedom is" if left == 1 else f"{left} degrees of freedom are"
        raise InputError(f"{what} left without a motor: nothing says how the parts move")
    if float(np.abs(rows @ rates - side).max()) > math.sqrt(RANK):
        raise InputError(f"driver '{driver}' cannot move here: it is at a dead centre, or another one holds it")
    if end.point.body == "ground":
        return np.zeros(2)
    k = 3 * closed.bodies.index(end.point.body)
    x, y = (end.at(m, q) - q[k : k + 2]).tolist()
    return np.array([rates[k] - rates[k + 2] * y, rates[k + 1] + rates[k + 2] * x])
