"""Moments of bearings whose bodies move in planes beside each other.

Bodies are symmetric about their planes, in which loads, weight and inertia act.  For each, about its plane:

    sum over joints  M_j + (z_j - z) (-F_y, F_x)_j + (r_y, -r_x)_j F_z,j = 0,      sum F_z,j = 0

F: force of the joint on the body in the plane, known; r: the joint from the mass centre; M = (M_x, M_y), F_z: wanted of
every bearing.  A tree has as many equations as unknowns.  In loops the unknowns with the least  sum |M_j|^2/k_j  are
taken (Castigliano: bearings that give way to tilting by k_j and are rigid along z).
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rattle.description.model import GROUND, Joint, Model, frame_of
from rattle.errors import InputError, suggest
from rattle.language.quantities import Quantity, in_si
from rattle.questions.power.ports import Ports
from rattle.questions.strength.known_motion import KnownMotion, known_motion
from rattle.questions.strength.wrenches import at_joint
from rattle.results.archive import package
from rattle.results.display import quantity, table
from rattle.results.result import Result
from rattle.results.table_file import write_frame
from rattle.wrong_arguments import answers_in_words

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame

Array = NDArray[np.float64]
PIECE = 4096  # instants whose equations are solved at once
UNHELD = 1e-8  # share of the largest moment that may be left of the balance of a body: more is not held by any bearing
SINGULAR = 1e-12  # share of the largest eigenvalue below which shares of bearings are not determined, and least


@answers_in_words
class BearingMoments:
    """Force and moment of a bearing on body B about its middle, at n instants.

    t (n,) [s]; fx, fy (n,) [N]; mx, my (n,) [N m] in the axes of the ground; edge_load (n,) [N]; tilt [rad], nan
    without `length`.  determinate: balance alone gives the moments.
    """

    def __init__(self, motion: KnownMotion, joint: Joint, force: Array, moment: Array, determinate: bool) -> None:
        self.result, self.joint, self.t = motion.result, joint.name, motion.t
        self.length = float(joint.length)
        self.fx, self.fy = force.T
        self.mx, self.my = moment.T
        self.determinate = determinate
        self.clearance = float(joint.clearance)

    @property
    def edge_load(self) -> Array:
        """Load (n,) [N] of the end that bears more, at most: |F|/2 + |M|/length; nan without length.

        It is that where the force and the couple's forces lie on one line, else less.
        """
        load: Array = 0.5 * np.hypot(self.fx, self.fy) + np.hypot(self.mx, self.my) / self.length
        return load

    @property
    def tilt(self) -> float:
        """By how much the play lets the pin tilt from end to end [rad]: 2 c/length; nan without length."""
        return 2.0 * self.clearance / self.length

    @property
    def remarks(self) -> tuple[str, ...]:
        """What limits these numbers."""
        shared = "the moment is one share of several: bearings in a loop share it by their stiffness against tilting"
        return () if self.determinate else (shared,)

    def told(self) -> list[tuple[str, str]]:
        """What it says in a few rows: a name and a number with its unit."""
        force, moment = np.hypot(self.fx, self.fy), np.hypot(self.mx, self.my)
        rows = [
            ("largest force", quantity(float(np.nanmax(force, initial=0.0)), "N")),
            ("largest tilting moment", quantity(float(np.nanmax(moment, initial=0.0)), "N*m")),
        ]
        if not math.isnan(self.length):
            rows.append(("largest load of an edge", quantity(float(np.nanmax(self.edge_load, initial=0.0)), "N")))
        if self.tilt > 0.0:
            rows.append(("tilt that the play allows", f"{1e3 * self.tilt:.4g} mrad"))
        return rows

    def __repr__(self) -> str:
        largest = quantity(float(np.nanmax(np.hypot(self.mx, self.my), initial=0.0)), "N*m")
        return f"<rattle.BearingMoments: '{self.joint}', {len(self.t)} instants, largest {largest}>"

    def _repr_html_(self) -> str:
        return table(("", ""), self.told(), f"Moments of {self.joint}", self.remarks, hint="b.plot(), b.table")

    @property
    def table(self) -> DataFrame:
        """pandas.DataFrame: t [s], fx, fy [N], mx, my [N m], edge_load [N].  Raises MissingPackage."""
        columns = {name: getattr(self, name) for name in ("t", "fx", "fy", "mx", "my", "edge_load")}
        frame: DataFrame = package("pandas", "a table of moments").DataFrame(columns)
        return frame

    def to_csv(self, path: str | os.PathLike[str]) -> Path:
        """Write `table` as CSV, in SI units.  Raises InputError for a suffix of another format, OSError."""
        return write_frame(self.table, path)

    def plot(self) -> Figure:
        """Force and moment over time."""
        from rattle.questions.bearing_moments.pictures import plot_over_time

        return plot_over_time(self)


class Known(NamedTuple):
    """What balance starts from."""

    bodies: list[str]  # that move
    bearings: list[Joint]
    matrix: Array  # (n, 3 bodies, 3 bearings): forces along z, moments about x and y
    load: Array  # (n, 3 bodies) what the known forces leave


def bearing_moments(r: Result, name: str, tilt_stiffness: Mapping[str, Quantity] | None) -> BearingMoments:
    """The moments of a bearing; see `Result.bearing_moments`."""
    motion = known_motion(r, "a moment of bearings")
    model = motion.system.model
    if name not in model.joints:
        raise InputError(f"bearing_moments: no joint '{name}'{suggest(name, model.joints)}")
    joint = model.joints[name]
    if not is_bearing(joint):
        raise InputError(f"bearing_moments: joint '{name}' is a {joint.kind}, which bears no moment out of the plane")
    stiffness = _stiffness(model, tilt_stiffness or {})
    balance = _balance(motion)
    shares = _shares(
        balance, np.array([stiffness.get(each.name, 1.0) for each in balance.bearings]), motion.system.size
    )
    k = [each.name for each in balance.bearings].index(name)
    force = _force_on_b(motion, name)
    moment = shares[:, 3 * k + 1 : 3 * k + 3]
    for part in (force, moment):
        part[~motion.defined] = np.nan
    return BearingMoments(motion, joint, force, moment, _is_bridge(balance.bearings, joint))


def is_bearing(joint: Joint) -> bool:
    """True if a joint holds its bodies in their planes: a pin, a guide, a slot, a fixed one."""
    return joint.places and joint.distance == 0.0 and not joint.leaf.bodies


def _stiffness(model: Model, written: Mapping[str, Quantity]) -> dict[str, float]:
    """Stiffnesses [N m/rad] by joint.  Raises InputError."""
    stiffness = {}
    bearings = [name for name, joint in model.joints.items() if is_bearing(joint)]
    for name, value in written.items():
        if name not in bearings:
            raise InputError(f"tilt_stiffness: no bearing '{name}'{suggest(name, bearings)}")
        stiffness[name] = in_si(value, f"tilt_stiffness of {name}", "N*m/rad", '"2e4 N*m/rad"')
        if not 0.0 < stiffness[name] < np.inf:
            raise InputError(f"tilt_stiffness of {name} must be positive, not {stiffness[name]:g} N*m/rad")
    if missing := [name for name in bearings if stiffness and name not in stiffness]:
        raise InputError(f"tilt_stiffness: {', '.join(missing)} share them too; state all, or none for equal ones")
    return stiffness


def plane_of(model: Model, body: str) -> float:
    """Offset of the plane of a body [m]; 0 of the ground."""
    return 0.0 if frame_of(body) == GROUND else float(model.bodies[body].z)


def middle_of(model: Model, joint: Joint) -> float:
    """Offset of the middle of a joint [m]: its z, else half way between the planes of its bodies."""
    own = float(joint.z)
    return own if not math.isnan(own) else 0.5 * (plane_of(model, joint.a.body) + plane_of(model, joint.b.body))


def _balance(motion: KnownMotion) -> Known:
    """The equations of all bodies."""
    model = motion.system.model
    bodies = model.moving_bodies
    bearings = [joint for joint in model.joints.values() if is_bearing(joint)]
    matrix = np.zeros((len(motion.t), 3 * len(bodies), 3 * len(bearings)))
    for column, joint in enumerate(bearings):
        for side, end in enumerate((joint.a, joint.b)):
            if end.body not in bodies:
                continue
            row, sense = 3 * bodies.index(end.body), 1.0 if side else -1.0
            spot = at_joint(motion, joint, side, end.body)[1] - motion.place(end.body, (0.0, 0.0))
            block = matrix[:, row : row + 3, 3 * column : 3 * column + 3]
            block[:, [0, 1, 2], [0, 1, 2]] = sense
            block[:, 1, 0], block[:, 2, 0] = sense * spot[:, 1], -sense * spot[:, 0]
    return Known(bodies, bearings, matrix, _moments_of_forces(motion, bodies))


def _moments_of_forces(motion: KnownMotion, bodies: Sequence[str]) -> Array:
    """(n, 3 bodies) minus the moments [N m] of forces of joints beside the plane of each body; none along z."""
    model, ports = motion.system.model, Ports(motion.system)
    load = np.zeros((len(motion.t), 3 * len(bodies)))

    def add(body: str, joint: str, force: Array) -> None:
        if body in bodies:
            offset, row = middle_of(model, model.joints[joint]) - plane_of(model, body), 3 * bodies.index(body)
            load[:, row + 1] += offset * force[:, 1]
            load[:, row + 2] -= offset * force[:, 0]

    for port in ports.list:
        name = ports.elements[port.element].name
        at_plane = model.drivers[name].joint if name in model.drivers else name
        if port.element < len(motion.system.joints) and at_plane:
            add(ports.bodies[port.body - 1], at_plane, motion.rows[:, port.column : port.column + 2])
    for motor in motion.motors:
        joint = model.joints[motor.joint]
        for sense, end in ((-1.0, joint.a), (1.0, joint.b)):
            add(end.body, joint.name, sense * motor.force(motion))
    return load


def _force_on_b(motion: KnownMotion, name: str) -> Array:
    """(n, 2) force of a joint on body B [N], or minus that on A where B is the ground."""
    ports = Ports(motion.system)
    mine = {port.side: port for port in ports.list if ports.elements[port.element].name == name}
    port = mine[max(mine)]
    force = motion.rows[:, port.column : port.column + 2]
    return force.copy() if port.side else -force


def _shares(balance: Known, stiffness: Array, size: float) -> Array:
    """(n, 3 bearings) forces along z [N] and moments [N m] of all bearings that balance every body.

    Unknowns and equations in moments: forces times the size [m] of the mechanism.
    """
    unit = np.tile([size, 1.0, 1.0], len(balance.bearings))
    equation = np.tile([size, 1.0, 1.0], len(balance.bodies))
    matrix = balance.matrix * equation[:, None] / unit
    load = balance.load * equation
    rows, columns = matrix.shape[1:]
    cost = np.diag(np.ravel([[0.0, k, k] for k in stiffness.mean() / stiffness]))
    solved = np.zeros((len(matrix), columns))
    for first in range(0, len(matrix), PIECE):
        part = slice(first, first + PIECE)
        whole = np.zeros((len(matrix[part]), columns + rows, columns + rows))
        whole[:, :columns, :columns] = cost
        whole[:, columns:, :columns] = matrix[part]
        whole[:, :columns, columns:] = matrix[part].transpose(0, 2, 1)
        right = np.concatenate([np.zeros((len(whole), columns)), load[part]], axis=1)
        whole, right = np.nan_to_num(whole), np.nan_to_num(right)
        solution = (np.linalg.pinv(whole, SINGULAR, hermitian=True) @ right[:, :, None])[:, :, 0]
        solved[part] = solution[:, :columns]
    _require_held(balance, np.nan_to_num(matrix @ solved[:, :, None])[:, :, 0], np.nan_to_num(load))
    shares: Array = solved / unit
    return shares


def _require_held(balance: Known, reached: Array, load: Array) -> None:
    """Raise InputError for a body that its bearings do not balance."""
    left = np.abs(reached - load).max(axis=0).reshape(-1, 3).max(axis=1)
    if len(left) and left.max() > UNHELD * np.abs(load).max():
        body = balance.bodies[int(left.argmax())]
        raise InputError(f"bearing_moments: no bearing holds body '{body}' against tipping out of its plane")


def _is_bridge(bearings: Sequence[Joint], joint: Joint) -> bool:
    """True if a bearing is in no loop: without it, its bodies hang together no more."""
    reached, ahead = {frame_of(joint.a.body)}, [frame_of(joint.a.body)]
    while ahead:
        body = ahead.pop()
        for other in bearings:
            ends = [frame_of(other.a.body), frame_of(other.b.body)]
            if other.name == joint.name or body not in ends:
                continue
            beyond = ends[1] if ends[0] == body else ends[0]
            if beyond not in reached:
                reached.add(beyond)
                ahead.append(beyond)
    return frame_of(joint.b.body) not in reached
