"""What the equations and the solvers need to know of the geometry of a contact: the interface of its kinds.

A contact is one-sided: a gap g >= 0 and N >= 0 that opens it.  It may belong to a joint in place of its rows
(clearance, one-sided joint) or besides them (stop).  With n and the arms p_A, p_B, and the couple m (columns NX to PBY
and TURN of `contact_kinematics`), its normal row is

    -g' = w . v,   w = A (-n, -p_A x n - m), B (n, p_B x n + m)

so the gap is a length [m], N a force [N]; or, with n = 0 and m = +-1, an angle [rad] and a moment [N m].
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, NamedTuple

from rattle.jit import layout as at


class ContactGeometry:
    """Interface of the kinds of geometry; the defaults are those of a point on a curved wall."""

    contacts: ClassVar[int] = 1  # number of places that may touch; `corner` of the kernel is their index
    walls_turn: ClassVar[bool] = False  # True: straight walls, which turn with `turning`
    turning: ClassVar[int] = at.A_BODY  # the body whose walls turn: at.A_BODY or at.B_BODY
    rounded: ClassVar[bool] = True  # True: a curved wall, whose normal turns as B moves; its speed is in touch[ACROSS]
    wall: ClassVar[str]  # what bears, in messages, with an article
    angular: ClassVar[bool] = False  # True: the gap is an angle [rad], N a moment [N m]
    slides: ClassVar[bool] = True  # True: it has a tangential row, on which friction acts
    column: ClassVar[int] = at.JOINT_NORMAL  # of an output row of its joint: N of its contacts is added there
    has_radius: ClassVar[bool] = True  # True: forces depend on the radius of the bush, which the contact may give
    holds_oil: ClassVar[bool] = False  # True: a round pin in a round bush, between which a film of oil can be
    worn: ClassVar[int] = 0  # 1: its force is that of a foundation between two profiles, see `equations.worn_contact`
    from_materials: ClassVar[bool] = False  # True: stiffness from materials, by the formulas for a pin in a bush

    @staticmethod
    def levers(p: Sequence[float]) -> tuple[float, float]:
        """Longest arms [m] from the mass centres of A and B to the points that determine the gap (centres, corners)."""
        raise NotImplementedError

    @staticmethod
    def scale(p: Sequence[float], size: float) -> float:
        """Size of the gap by which tolerances are set [m or rad]; size: of the mechanism [m], or 1 rad."""
        raise NotImplementedError

    @staticmethod
    def bends(fields: Mapping[str, Any], constants: Sequence[float]) -> tuple[float, float, float]:
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
