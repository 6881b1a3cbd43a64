"""Pin in a slot: a point of B stays on a line fixed in A; B can turn.

u = direction of the line (fixed in A), n = u turned by 90 degrees, d = (r_B + s_B) - (r_A + s_A)
Phi   = n . d = 0                                                         [m]
gamma = n . (s_B w_B^2 - s_A w_A^2) + 2 w_A (u . d') + w_A^2 (n . d)      [m/s^2]

This is the first row of the prismatic joint.  Its friction is by |lambda| and the speed of the centre of the pin along
the slot: that the pin turns is left out.  Without `length` the line goes on for ever, through the point of A and out on
its other side.  The ends of the slot stop the pin, or let it out, only in a joint with clearance.
"""

from __future__ import annotations

import math

from rattle.elements.geneva import OPEN
from rattle.elements.joints.prismatic import on_line
from rattle.interfaces.fields import Fields
from rattle.interfaces.joints import JointKind, Motor
from rattle.jit.functions import kernel
from rattle.registry import Field, kind

SLENDER = 0.1  # half the width of a slot by its length, where nothing but a mouth depends on it and it is not given


@kernel("joint")
def slot(body, a, b, p, k, row, rows):
    """Write the row of the joint [m]; p[k + 4] = axis [rad]."""
    on_line(body, a, b, p, k, row, rows)


@kind("joint", "slot", slot)
class Slot(JointKind):
    """A pin of B slides along a straight slot of A and turns in it.

    Source: Nikravesh, Planar Multibody Dynamics (2018), revolute-translational joint.
    """

    rows = ("m",)
    motor = Motor("position", "thrust", "N")
    coordinate = "position"
    drawn_as = "slot"
    rubs = True
    axis = Field("rad", "direction of the slot in A's frame", default=0.0)
    length = Field(
        "m", "distance between the centres of its rounded ends, the point of A in the middle", default=math.inf,
        least="positive",
    )  # fmt: skip
    open = Field(
        "", "end at which the pin comes in and out: that in the direction of the axis (end, or true), start, or both",
        default="none", shape="choice", choices=OPEN, flags=("none", "end"),
    )  # fmt: skip

    @staticmethod
    def fault(fields: Fields) -> str:
        """An open end needs a place."""
        if fields["open"] > 0.0 and fields["length"] == math.inf:
            return "an open end needs the length of the slot: give `length`, with the point of A in the middle"
        return ""

    @staticmethod
    def passing(fields: Fields) -> str:
        """A slot with an open end does not hold a pin that is outside of it."""
        return "a slot with an open end" if fields["open"] > 0.0 else ""

    @staticmethod
    def assumed_radius(fields: Fields) -> float:
        """Half the width of a slot with an open end whose width is not given [m]."""
        return SLENDER * fields["length"] if fields["open"] > 0.0 else 0.0

    @staticmethod
    def line(fields: Fields) -> float:
        """The given angle [rad]."""
        return fields["axis"]

    @staticmethod
    def ends(fields: Fields) -> str:
        """Without length it has none."""
        return (
            "" if fields["length"] < math.inf else "a line without ends, which its pin never leaves; length gives ends"
        )

    @staticmethod
    def travel(fields: Fields) -> float:
        """Half the length [m]: up to the centres of the rounded ends."""
        return 0.5 * fields["length"]
