"""What other rooms need to know of joints and drivers: the interface of these kinds.

No code tests for the name of a joint or of its fields: what it needs to know is an attribute or method of the kind.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import ClassVar, NamedTuple

import numpy as np

from rattle.interfaces.contacts import OwnContact
from rattle.interfaces.fields import Field, Fields


class Motor(NamedTuple):
    """The motor of the coordinate that a joint leaves free."""

    driver: str  # kind of driver
    effort: str  # name of its force or torque
    unit: str  # of the effort: N or N*m


class Fit(NamedTuple):
    """A distance at which the points of a joint have to be although its rows do not hold it."""

    distance: float  # [m]
    line: float | None  # None: of the points; else of B's point to the right of a line in this direction of A [rad]
    why: str  # what needs it, in words, with {} for the distance
    needed: bool = True  # False: another distance is a note, not an error
    slack: float = 0.0  # [m] by which it may be missed
    least: bool = False  # True: only a shorter distance is wrong

    def missed(self, distance: np.ndarray) -> np.ndarray:
        """How far distances [m] are from the one that is needed [m], 0 where they are within the slack."""
        if self.least:
            return np.maximum(self.distance - distance, 0.0)
        return np.maximum(np.abs(distance - self.distance) - self.slack, 0.0)


class Strand(NamedTuple):
    """The law of a strand: its force while it is stretched."""

    stiffness: float  # [N/m]
    damping: float  # [N*s/m]


class Grip(NamedTuple):
    """How much the tensions of two strands may differ."""

    mu: float  # coefficient of friction
    source: str  # ", assumed" if it is
    wrap: np.ndarray  # (n,) smallest angle of wrap [rad]
    ratio: np.ndarray  # (n,) largest ratio of the tensions


class JointKind:
    """Interface of the kinds of joint; the defaults are those of a pin that both bodies share."""

    rows: ClassVar[tuple[str, ...]]  # unit of every row, m or rad
    rows_in_ground: ClassVar[bool] = False  # rows are along the axes of the ground, not of A
    moment: ClassVar[bool] = False  # True: the joint transmits a moment
    bodies: ClassVar[bool] = False  # True: it connects bodies wherever they are, and not points of them
    events: ClassVar[Mapping[str, str]] = {}  # what events of its own contact are called: contact, release ...
    motor: ClassVar[Motor | None] = None  # None: no coordinate that a driver could move
    stops: ClassVar[str] = ""  # kind of stop (and coordinate) of a joint without motor that its stops may hold alone
    coordinate: ClassVar[str] = ""  # what expressions and results know of it, with its rate: angle | position
    massless: ClassVar[str] = ""  # kind of joint for the clearance as a massless link; its one field is the clearance
    drawn_as: ClassVar[str] = ""  # a form of rattle.drawings.forms: pin, rod, guide ...; "" if it is not drawn
    rubs: ClassVar[bool] = False  # True: it may have friction by its own reaction, as a pin or (with a line) a guide
    tangents: ClassVar[tuple[str, ...]] = ()  # kinds of rows along which its friction acts; none: its coordinate's
    rubs_with: ClassVar[Mapping[str, Field]] = {}  # what its friction needs besides its model
    places: ClassVar[bool] = True  # False: its rows do not say where the point of B is
    lifting: ClassVar[tuple[str, Mapping[str, str]] | None] = None  # kind that it is with `contact`, names of its keys
    touches: ClassVar[bool] = False  # True: bodies that touch and part outside of any joint, with a gap between them
    from_start: ClassVar[int] = 0  # number of constants that the start sets; they make its rows vanish there
    placing: ClassVar[int] = 0  # of such a kind: its first rows, which do not count; with friction these act alone
    presses: ClassVar[bool] = False  # rows along the normal of a line of A, then along it: results have both forces

    @staticmethod
    def faults(written: Mapping[str, object], fields: Fields) -> Iterable[tuple[str, str]]:
        """What is wrong with keys that were `written`, or missing (key ""), besides what each field says by itself."""
        return ()

    @staticmethod
    def start_constants(residual: tuple[float, ...], d: tuple[float, float]) -> tuple[float, ...]:
        """Its constants, from its rows at the start without constants [m or rad] and the offset d of its points [m]."""
        return residual

    @staticmethod
    def resting(constants: tuple[float, ...]) -> tuple[float, ...]:
        """Its constants in the search of equilibria, where bodies may be anywhere."""
        return constants

    @staticmethod
    def strand(fields: Fields) -> Strand | None:
        """The law of its one-sided contacts, if these are strands; None otherwise."""
        return None

    @staticmethod
    def grip(fields: Fields, distance: np.ndarray) -> Grip | None:
        """By what its two strands hold without slip, at distances (n,) of its points [m]; None if they always do."""
        return None

    @staticmethod
    def own_contact(fields: Fields) -> OwnContact | None:
        """The contact that it consists of; None if it has none."""
        return None

    @staticmethod
    def kept_angle(fields: Fields) -> float | None:
        """Angle of B relative to A [rad] that the joint enforces; None if B can turn."""
        return None

    @staticmethod
    def line(fields: Fields) -> float | None:
        """Direction in A's frame [rad] of the line through A's point on which B's point moves; None if no such line."""
        return None

    @staticmethod
    def travel(fields: Fields) -> float:
        """Largest distance [m] of B's point along the line from A's point, in either direction."""
        return float("inf")

    @staticmethod
    def ends(fields: Fields) -> str:
        """What a check says about how far B's point may go, in words; "" if nothing."""
        return ""

    @staticmethod
    def distance(fields: Fields) -> float:
        """Distance of the two points [m] that the joint enforces."""
        return 0.0

    @staticmethod
    def fit(fields: Fields) -> Fit | None:
        """The distance at which its points have to be, which its rows do not hold; None if there is none."""
        return None

    @staticmethod
    def fault(fields: Fields) -> str:
        """What is wrong with values of the fields that are possible one by one, in words; "" if nothing."""
        return ""

    @staticmethod
    def friction_fault(fields: Fields) -> str:
        """Why it has no friction with these values of the fields, in words; "" if it may have."""
        return ""

    @staticmethod
    def friction_arm(fields: Fields, own: Fields) -> float:
        """Moment of its friction by mu and its reaction [m], 1 where it slides; own: what `rubs_with` names.

        Raises ValueError, in words, for values that do not fit the fields.
        """
        return 1.0

    @staticmethod
    def bears(fields: Fields) -> str:
        """What of A bears, of a kind that `touches`, in words."""
        return ""

    @staticmethod
    def curvature(fields: Fields) -> float:
        """Relative curvature [1/m] of a disc of B and what it rolls on, of a kind that `touches`; 0 without a disc."""
        return 0.0

    @staticmethod
    def passing(fields: Fields) -> str:
        """What it is, with an article, if it consists of contacts that bodies come to and leave; "" if it holds them.

        Then it has no part in putting the mechanism together, and without contacts there is no such joint.
        """
        return ""

    @staticmethod
    def held_by_stops(fields: Fields) -> bool:
        """True if it has no rows and only the stops of its coordinate hold it, as a rope."""
        return False

    @staticmethod
    def held_at(value: float) -> dict[str, float]:
        """Fields of such a joint whose rows hold its coordinate at a value [m]."""
        return {}

    @staticmethod
    def assumed_radius(fields: Fields) -> float:
        """Radius of its bush [m] where contacts need it and it is not given; 0: they do not."""
        return 0.0

    @staticmethod
    def doubt(fields: Fields) -> str:
        """What is noted with every run about values of the fields that are possible, in words; "" if nothing."""
        return ""

    @staticmethod
    def bearing_outline(fields: Fields) -> np.ndarray | None:
        """Points (n, 2) [m] of the outline of A that the fields give, in A's frame about A's point; None if none."""
        return None

    @staticmethod
    def borne_outline(fields: Fields) -> np.ndarray | None:
        """The same of B."""
        return None


class DriverKind:
    """Interface of the kinds of driver."""

    rows: ClassVar[tuple[str, ...]]  # unit of every row, m or rad
    drives: ClassVar[str]  # "joint" (those whose motor it is) or "body"
    effort: ClassVar[tuple[str, str]]  # name and unit of the force or moment on B
    sets_angle: ClassVar[bool] = False  # its function is the angle of B relative to A
    along_line: ClassVar[bool] = False  # its parameters begin with the direction of the joint's line
    rate_of: ClassVar[str] = ""  # the kind whose function is the integral of what is written; "": this kind's own
    from_start: ClassVar[int] = 0  # number of constants that the start sets; they stand before the function
