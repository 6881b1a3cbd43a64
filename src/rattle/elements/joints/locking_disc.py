"""Locking disc of a Geneva drive: a disc of A holds a wheel of B by hollow arcs in its rim while no pin turns it.

The disc (radius R) turns about the point of A.  A sector of it is cut out, of the angle `opening` about the direction
`axis` of A, in which the pin lies: there the rim of the wheel passes.  The wheel has `arcs` hollow arcs of the radius
R + c, c = `play`.  Their centres are C = `axle_distance` away from the point of B, where the disc turns; the first one
in the direction `first`, the others evenly spaced.  They end at the radius `rim` of the wheel.  There are no rows: all
that it does are the contacts of `elements.one_sided.locked_arcs`.

In the dwell each horn of the arc in front, at the angle +-beta from the line of the axes as seen from the disc, leaves
the wheel a play of +-c/(C sin(beta)), cos(beta) = (C^2 + R^2 - rim^2)/(2 R C).

A pin at the radius r that enters a slot along its line does so with its arm at 90 deg - 180 deg/n to the line of the
axes: at that instant the edge of the disc has to be on this line, so that opening = 180 deg - 360 deg/n.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from rattle.elements.geneva import half_angle
from rattle.elements.profile import Array
from rattle.interfaces.fields import Fields
from rattle.interfaces.joints import Fit, JointKind
from rattle.jit.functions import kernel
from rattle.language.recorded import bare, cos, is_whole
from rattle.registry import Field, kind

FEWEST = 3  # arcs: with two the axes would have to coincide
POINTS = 96  # of an outline that is drawn
ROUND = 0.02  # radius of the corners by that of the disc, where it is not given


@kernel("joint")
def no_rows(body, a, b, p, k, row, rows):
    """A locking disc has no constraint rows."""


@kind("joint", "locking-disc", no_rows)
class LockingDisc(JointKind):
    """A disc of A, with a sector cut out, holds a wheel of B by hollow arcs in its rim.

    Source: Norton, Design of Machinery (2012), section 2.11 (Geneva mechanism); Bickford, Mechanisms for Intermittent
    Motion (1972), chapter 9.
    """

    rows = ()
    moment = True
    places = False
    drawn_as = "locking-disc"
    radius = Field("m", "radius of the disc about A's point", least="positive")
    arcs = Field("", "number of hollow arcs of the wheel, as many as its slots")
    axle_distance = Field("m", "distance of the centres of the arcs from B's point: that of the axes", least="positive")
    rim = Field("m", "radius of the wheel about B's point, where the arcs end", least="positive")
    play = Field("m", "radius of the arcs minus that of the disc", least="positive")
    axis = Field("rad", "direction in A of the middle of the sector that is cut out: that of the pin", default=0.0)
    opening = Field(
        "rad", "angle of that sector (default: 180 deg - 360 deg/arcs)", least="positive",
        default=lambda fields: math.pi - 2.0 * math.pi / fields["arcs"] if fields["arcs"] else math.nan,
    )  # fmt: skip
    first = Field(
        "rad", "direction in B of the middle of an arc (default: 180 deg/arcs, with a slot at 0)",
        default=lambda fields: math.pi / fields["arcs"] if fields["arcs"] else math.nan,
    )  # fmt: skip
    rounding = Field(
        "m", "radius of the corners of disc and arcs (default: a fiftieth of the disc)", least="positive",
        default=lambda fields: ROUND * fields["radius"],
    )  # fmt: skip

    @staticmethod
    def faults(written: Mapping[str, object], fields: Fields) -> Iterator[tuple[str, str]]:
        """A number of arcs that is no number of slots."""
        arcs = fields["arcs"]
        if not math.isnan(bare(arcs)) and (not is_whole(arcs) or arcs < FEWEST):
            yield "arcs", f"expected a whole number of at least {FEWEST}, got {arcs:g}"

    @staticmethod
    def fault(fields: Fields) -> str:
        """Dimensions that no disc and wheel can have."""
        radius, distance, rim = fields["radius"], fields["axle_distance"], fields["rim"]
        if not fields["opening"] < math.pi:
            return f"opening = {math.degrees(fields['opening']):.4g} deg must be less than 180 deg"
        if not fields["rounding"] < 0.25 * radius:
            return f"rounding = {fields['rounding']:g} m must be less than a quarter of radius = {radius:g} m"
        if not radius < distance:
            return f"radius = {radius:g} m must be less than axle_distance = {distance:g} m"
        beta = half_angle(fields)
        if not (beta < 0.5 * math.pi and distance * cos(beta) > radius):
            return (
                f"a wheel with rim = {rim:g} m has no arcs of radius = {radius:g} m about centres {distance:g} m away"
                f" that would hold it: rim must be more than {distance - radius - fields['play']:.4g} m and less than"
                f" {math.sqrt(max(distance**2 - radius**2, 0.0)):.4g} m"
            )
        return ""

    @staticmethod
    def fit(fields: Fields) -> Fit:
        """The axes have to be where the centres of the arcs are; another distance changes the play."""
        why = "the arcs fit the disc where the axes are {} apart"
        return Fit(fields["axle_distance"], None, why, needed=False, slack=fields["play"])

    @staticmethod
    def bearing_outline(fields: Fields) -> Array:
        """The disc with its sector cut out to the middle."""
        kappa = 0.5 * fields["opening"]
        turns = fields["axis"] + np.linspace(kappa, 2.0 * math.pi - kappa, POINTS)
        around = fields["radius"] * np.column_stack([np.cos(turns), np.sin(turns)])
        return np.vstack([around, [[0.0, 0.0]], around[:1]])

    @staticmethod
    def borne_outline(fields: Fields) -> Array:
        """The wheel without its slots: hollow arcs, and its rim between them."""
        hollow, beta, count = fields["radius"] + fields["play"], half_angle(fields), round(fields["arcs"])
        turns = math.pi - np.linspace(-beta, beta, POINTS // count)
        arc = np.column_stack([fields["axle_distance"] + hollow * np.cos(turns), hollow * np.sin(turns)])
        gamma = abs(math.atan2(arc[-1, 1], arc[-1, 0]))
        rim = np.linspace(gamma, 2.0 * math.pi / count - gamma, POINTS // count)[1:-1]
        sector = np.vstack([arc[np.argsort(arc[:, 1])], fields["rim"] * np.column_stack([np.cos(rim), np.sin(rim)])])
        ways = fields["first"] + 2.0 * math.pi / count * np.arange(count)
        whole = [sector @ np.array([[c, s], [-s, c]]) for c, s in zip(np.cos(ways), np.sin(ways), strict=True)]
        return np.vstack([*whole, whole[0][:1]])

    @staticmethod
    def passing(fields: Fields) -> str:
        """The arcs come to the disc and leave it."""
        return "a locking disc"
