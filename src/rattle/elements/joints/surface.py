"""Surface: a line, a segment or a disc of A, which points, corners or a disc of B touch and leave.

The line goes through the point of A in the direction `axis` of A; its free side is to the left.  `length` makes a
segment of it, about that point.  The disc has the `radius` R about the point of A; B is outside of it, or inside if it
is `hollow`.  What touches on B are `corners` (points of B), all corners of its plate (`outline`), a disc of the radius
`roller` about its point, or its point alone.  There are no rows: all that it does are the contacts of
`elements.one_sided`: `on_line`, `on_segment`, `on_disc`, `by_outline`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from rattle.interfaces.fields import Fields, absent
from rattle.interfaces.joints import JointKind
from rattle.interfaces.laws import TangentKind
from rattle.jit.functions import kernel
from rattle.jit.geometry import angle_row
from rattle.registry import Field, kind

OF_B = ("corners", "outline", "roller")  # keys of what touches on B, one of which may be given


@kernel("joint")
def turning_of_b(body, a, b, p, k, row, rows):
    """Write the row of w_B - w_A [rad/s]."""
    angle_row(body, a, b, 0.0, 0.0, 0.0, row, rows)


@kind("tangent", "rolling", turning_of_b)
class Rolling(TangentKind):
    """Turning of B against A: the resistance of a disc that rolls on a surface.

    Source: Johnson, Contact Mechanics (1985), section 9.1.
    """

    unit = "N*m"


@kernel("joint")
def free(body, a, b, p, k, row, rows):
    """A surface has no constraint rows."""


@kind("joint", "surface", free)
class Surface(JointKind):
    """A line, segment or disc of A that points, corners, the outline or a disc of B touch, with friction.

    Source: Pfeiffer, Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapter 2.
    """

    rows = ()
    moment = True
    places = False
    touches = True
    drawn_as = "surface"
    tangents = ("rolling",)  # along which the resistance of a disc that rolls acts, see `description.read_friction`
    axis = Field("rad", "direction of a line through A's point; its free side is to the left", default=absent)
    length = Field(
        "m", "of a segment of that line, about A's point (default: endless)", default=absent, least="positive"
    )
    radius = Field("m", "of a disc about A's point, in place of a line", default=absent, least="positive")
    hollow = Field("", "B is inside of that disc", default=False, shape="flag")
    roller = Field("m", "radius of a disc about B's point (default: the point)", default=absent, least="positive")
    corners = Field(
        "",
        "points of B that may touch",
        default=lambda fields: (),
        shape="labels",
        fewest=1,
        like="a list of names of points of B, at least one",
    )
    outline = Field("", "all corners of B's plate may touch", default=False, shape="flag")

    @staticmethod
    def faults(written: Mapping[str, object], fields: Fields) -> Iterator[tuple[str, str]]:
        """A line and a disc at once, or neither; two things of B that touch; parts of one on the other."""
        disc = "radius" in written
        if disc == ("axis" in written):
            both = "radius" if disc else ""
            yield both, "give axis, the direction of a line of A, or radius, that of a disc of A" + ", not both" * disc
        elif disc and "length" in written:
            yield "length", "a disc has no length: it is that of a segment, along axis"
        if fields["hollow"] and not disc:
            yield "hollow", "only a disc of A is hollow: give its radius"
        if len(ways := [key for key in OF_B if written.get(key)]) > 1:
            yield ways[-1], f"give {' or '.join(ways)}: one of them says what of B touches"
        if fields["hollow"] and disc and not fields["roller"] < fields["radius"]:
            roller, radius = fields["roller"], fields["radius"]
            yield "roller", f"roller = {roller:g} m does not fit in a hollow of radius = {radius:g} m"

    @staticmethod
    def curvature(fields: Fields) -> float:
        """1/r on a line, 1/r + 1/R on a disc, 1/r - 1/R in a hollow; nan where these are wrong, 0 without a roller."""
        if fields["roller"] == 0.0:
            return 0.0
        if fields["hollow"] and not fields["roller"] < fields["radius"]:
            return math.nan
        other = 1.0 / fields["radius"] if fields["radius"] > 0.0 else 0.0
        return 1.0 / fields["roller"] + (-other if fields["hollow"] else other)

    @staticmethod
    def bears(fields: Fields) -> str:
        """A line, a segment, a disc or its hollow."""
        if fields["radius"] > 0.0:
            return "the hollow of a disc" if fields["hollow"] else "a disc"
        return "a segment" if fields["length"] > 0.0 else "a line"

    @staticmethod
    def passing(fields: Fields) -> str:
        """B comes to it and leaves it."""
        return "a surface"
