"""What the equations and the solvers need to know of the geometry of a contact: the interface of its kinds.

A contact is one-sided: a gap g >= 0 and N >= 0 that opens it.  It may belong to a joint in place of its rows
(clearance, one-sided joint) or besides them (stop).  With n and the arms p_A, p_B, and the couple m (columns NX to PBY
and TURN of `contact_kinematics`), its normal row is

    -g' = w . v,   w = A (-n, -p_A x n - m), B (n, p_B x n + m)

so the gap is a length [m], N a force [N]; or, with n = 0 and m = +-1, an angle [rad] and a moment [N m].
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import ClassVar, NamedTuple, Protocol

import numpy as np

from rattle.interfaces.fields import Field, Fields
from rattle.jit import layout as at
from rattle.language.local_function import LocalFunction
from rattle.language.recorded import hypot, least

Dimensions = Mapping[str, tuple[float, ...]]
Corners = Mapping[str, tuple[float, float]]  # of B, by name, from its mass centre [m]


class ContactGeometry:
    """Interface of the kinds of geometry; the defaults are those of a point on a curved wall."""

    contacts: ClassVar[int] = 1  # number of places that may touch; `corner` of the kernel is their index
    walls_turn: ClassVar[bool] = False  # True: straight walls, which turn with `turning`
    turning: ClassVar[int] = at.A_BODY  # the body whose walls turn: at.A_BODY or at.B_BODY
    rounded: ClassVar[bool] = True  # True: a curved wall, whose normal turns as B moves; its speed is in touch[ACROSS]
    wall: ClassVar[str]  # what bears, in messages, with an article
    bounded: ClassVar[bool] = False  # True: its kernel writes a bound of the gaps of all its contacts for corner -1
    angular: ClassVar[bool] = False  # True: the gap is an angle [rad], N a moment [N m]
    slides: ClassVar[bool] = True  # True: it has a tangential row, on which friction acts
    column: ClassVar[int] = at.JOINT_NORMAL  # of an output row of its joint: N of its contacts is added there
    has_radius: ClassVar[bool] = True  # True: forces depend on the radius of the bush, which the contact may give
    holds_oil: ClassVar[bool] = False  # True: a round pin in a round bush, between which a film of oil can be
    worn: ClassVar[int] = 0  # 1: its force is that of a foundation between two profiles, see `equations.worn_contact`
    from_materials: ClassVar[bool] = False  # True: stiffness from materials, by the formulas for a pin in a bush

    @classmethod
    def one_way(cls, fields: Fields) -> bool:
        """True: it bears on one side of a segment or edge, and ends at its end, a point."""
        return False

    @staticmethod
    def levers(p: Sequence[float]) -> tuple[float, float]:
        """Longest arms [m] from the mass centres of A and B to the points that determine the gap (centres, corners)."""
        return hypot(p[0], p[1]), hypot(p[2], p[3])

    @staticmethod
    def scale(p: Sequence[float], size: float) -> float:
        """Size of the gap by which tolerances are set [m or rad]; size: of the mechanism [m], or 1 rad."""
        return size

    @classmethod
    def scale_at(cls, corner: int, p: Sequence[float], size: float) -> float:
        """`scale` of one contact."""
        return cls.scale(p, size)

    @classmethod
    def curved(cls, corner: int) -> float:
        """How its wall is curved: 1 around the offset of B, which is scale - gap, 2 inside it, scale + gap; 0: not."""
        return float(cls.rounded)

    @staticmethod
    def bends(fields: Fields, constants: Sequence[float]) -> tuple[float, float, float]:
        """What bends the gap besides arms and turning walls: SLOPE [m], CURVE [m] and BOW [1/m], see `layout`.

        constants: that the start of a joint has set; of a kind of clearance the clearance and radius of the bush [m].
        """
        return 0.0, 0.0, 0.0

    @classmethod
    def column_of(cls, corner: int) -> int:
        """Column of an output row of its joint to which N of this contact is added."""
        return cls.column

    @staticmethod
    def sense(corner: int) -> int:
        """1 or -1: N of this contact counts positive or negative in its column."""
        return 1


class OwnContact(NamedTuple):
    """The contact that a joint consists of: it has no rows and no clearance, and the force of this contact is its own.

    Its force is positive in the column EFFORT of an output row where it drives B in the positive direction.
    """

    kind: str  # of the family "clutch": its geometry
    rigid: bool  # set-valued; otherwise its force follows from the state
    level: bool  # decided by the rate g' alone; otherwise it has a gap
    toothed: bool  # the gap becomes one pitch smaller where it reaches a pitch
    states: int  # number of states of its law
    sense: int  # 1 or -1: the direction in which it drives B
    geometry: tuple[float, ...]  # what its kernel takes after the points
    law: tuple[float, ...]  # largest torque, stiffness, damping, see `layout`


class FreePlay:
    """The displacements e = (e_0, e_1) of B from its position without clearance that a joint allows: here a circle.

    e is in the frame of A [m]; for some kinds e_1 is a rotation [rad], or unused.
    """

    two_tips = False  # True: two kinds of corners of the region of e may be extremes, see `tip`

    def __init__(self, clearance: float) -> None:
        self.clearance = clearance
        self.steps = (clearance, clearance)  # scales of the components of e

    def first_order(self, y: np.ndarray) -> tuple[float, np.ndarray]:
        """Largest y . e [unit of the output] to first order in the clearance, and the e (2,) [m, rad] that reaches it.

        y: (2,) derivative of an output with respect to e.
        """
        size = float(np.hypot(*y))
        return self.clearance * size, (self.clearance / size * y if size > 0.0 else np.zeros(2))

    def tip(self, y: np.ndarray, second: bool | None) -> np.ndarray:
        """The e (2,) [m, rad] with the largest y . e; second: the kind of corner, None for the better one."""
        return self.first_order(y)[1]

    def side(self, e: np.ndarray, y: np.ndarray) -> tuple[float, Callable[[float], np.ndarray]] | None:
        """A curved side of the region on which y . e grows from e: its length [m or rad], and e (2,) along it."""
        return None

    @property
    def unbounded(self) -> str:
        """Why the displacements are not bounded, as a clause about B; "" if they are bounded."""
        return ""


class ClearanceKind(ContactGeometry):
    """Interface of the kinds of clearance; the defaults are those of a pin in a bush."""

    joint: ClassVar[str]  # the kind of joint that has this clearance
    borne, bearer = "pin", "bush"  # names of the parts on B and A
    wall = "a bush"
    orbit: ClassVar[bool] = False  # True: a circle in which the path of the pin is drawn
    dimensions: ClassVar[Mapping[str, Mapping[str, Field]]] = {}  # tables of dimensions of a joint with this clearance

    @staticmethod
    def scale(p: Sequence[float], size: float) -> float:
        """The clearance [m]."""
        return p[at.CLEARANCE]

    @staticmethod
    def play_along(fields: Fields, along: np.ndarray) -> np.ndarray:
        """The part (n,) [m] of the displacement `along` (n,) [m] of B's point on the joint's line that is clearance."""
        return 0.0 * along

    @staticmethod
    def displaced(fields: Fields, e: np.ndarray) -> tuple[float, float, Mapping[str, float]]:
        """Shift of A's point in its frame [m] and changes of the joint's fields [SI] that displace B by e (2,)."""
        return float(e[0]), float(e[1]), {}

    @staticmethod
    def free_play(clearance: float, fields: Fields, dimensions: Dimensions) -> FreePlay:
        """The displacements that a clearance [m] allows."""
        return FreePlay(clearance)


class WornSurfaces(Protocol):
    """What is known of a pin and a bush that wear, see `description.model.Wear`."""

    @property
    def profile(self) -> tuple[tuple[float, ...], tuple[float, ...]] | None: ...
    @property
    def foundation(self) -> float: ...
    @property
    def radius(self) -> float: ...
    @property
    def length(self) -> float: ...


class WornKind(ClearanceKind, ABC):
    """Interface of the clearances between two worn profiles."""

    @staticmethod
    @abstractmethod
    def worn_play(wear: WornSurfaces, clearance: float) -> FreePlay:
        """The displacements that the clearance and the profiles of a joint allow."""

    @staticmethod
    @abstractmethod
    def parameters(wear: WornSurfaces) -> tuple[float, ...]:
        """Parameters of the kernel after those of `pin`."""


class Held(NamedTuple):
    """The joint that holds two bodies as a contact of a surface does while it is closed."""

    kind: str  # of joint, without play
    fields: Fields
    on_a: tuple[float, float]  # point of A [m]
    on_b: tuple[float, float]  # point of B
    turned: bool = False  # True: it is a joint from B to A


Pose = tuple[float, float, float]  # x, y [m], angle [rad]


class OneSidedKind(ContactGeometry):
    """Interface of the one-sided kinds; the defaults are those of one contact of a follower."""

    joint: ClassVar[str]  # the kind of joint that is one-sided with `contact`
    chosen: ClassVar[bool] = True  # False: the joint always has these contacts, by a law of its own
    stiff_in_kinematics: ClassVar[bool] = False  # True: kinematics takes the rows of the joint instead
    records: ClassVar[tuple[str, ...]] = ()  # names of its two forces [N], the larger first, instead of N
    rounded = False
    slides = False
    has_radius = False

    @staticmethod
    def suits(fields: Fields) -> bool:
        """True if a joint with these fields has these contacts: a kind of joint may have several kinds."""
        return True

    @classmethod
    def count(cls, fields: Fields, corners: Corners) -> int:
        """How many there are; corners: of B that may touch, of a kind of joint that has such."""
        return cls.contacts

    @classmethod
    def labels(cls, fields: Fields, corners: Corners) -> tuple[str, ...]:
        """What its contacts are called in results and events, each; none if a joint has one contact only."""
        return ()

    @classmethod
    def held(
        cls, fields: Fields, on_a: tuple[float, float], corners: Corners, corner: int, a: Pose, b: Pose, sticks: bool
    ) -> tuple[Held, ...]:
        """The joints by which contact `corner` is held where the bodies are; sticks: it rolls or sticks too.

        None of a kind that is never held.
        """
        return ()

    @staticmethod
    def parameters(fields: Fields, constants: Sequence[float], corners: Corners) -> Sequence[float | LocalFunction]:
        """What the kernel takes after the points: numbers [SI] and functions; constants: that the start has set."""
        return tuple(fields.values())


class StopKind(ContactGeometry):
    """Interface of the kinds of stop; fields `min` and `max` are its ends.

    It is named after the driver that moves the same coordinate, or `stops` of a kind of joint that it holds alone.
    """

    contacts = 2
    wall = "a stop"
    rounded = False
    slides = False
    has_radius = False
    column = at.STOP

    @staticmethod
    def scale(p: Sequence[float], size: float) -> float:
        """The range between the ends, but no more than the size."""
        return least(size, p[at.POINTS + 1] - p[at.POINTS])

    @staticmethod
    def sense(corner: int) -> int:
        """The force on B is positive at the least value, negative at the largest."""
        return 1 if corner == 0 else -1


class ClutchKind(ContactGeometry):
    """Interface of the contacts of clutches."""

    wall = "a clutch"
    angular = True
    rounded = False
    slides = False
    has_radius = False
    column = at.EFFORT

    @staticmethod
    def levers(p: Sequence[float]) -> tuple[float, float]:
        """No points touch."""
        return 0.0, 0.0


class ContactKind:
    """Interface of the contact models; the defaults are those of a joint whose clearance is ignored."""

    contacts: ClassVar[bool] = False  # True: contacts replace the rows of the joint
    link: ClassVar[bool] = False  # True: the row of a massless link replaces them, on joints that have one
    oiled: ClassVar[bool] = False  # True: an oil film in the clearance, in parallel with a compliant contact
    shares_by_stiffness: ClassVar[str] = ""  # that of its restitution laws that shares impulses by stiffness, if any
    assumes: ClassVar[str]  # what the model takes as true and what it leaves out, in plain words for a report
