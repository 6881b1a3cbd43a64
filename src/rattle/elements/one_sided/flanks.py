"""Two flanks of involute teeth: the gear pair with a pressure angle, whose centres may move and whose teeth have play.

The line of action touches both base circles, a = R_A cos(alpha), b = R cos(alpha) (R = R_B, inside of a ring -R_B), see
`elements.wrapped`:

g_i = +-X + k (F(l) - F(l_0)) + j_0/2 >= 0,   k = 1, inside of a ring -1                                       [m]

l_0: distance at which the pitch circles touch;  j_0: backlash there, along the line of action.  The angle of the force
to p is the working pressure angle, cos = (base radii)/l; the ratio of the wheels does not depend on l.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from rattle.elements.wrapped import Wrapped, bow_of, length_of, write_line
from rattle.interfaces.contacts import Corners, OneSidedKind
from rattle.interfaces.fields import Fields, pair
from rattle.jit.functions import kernel
from rattle.language.local_function import LocalFunction
from rattle.language.recorded import cos, largest
from rattle.registry import kind

LEAST = 1e-3  # of the radii: gaps are judged by no less, whatever the backlash


@kernel("clearance")
def flanks(body, a, b, p, k, corner, row, kinematics):
    """Write gap [m], its rate [m/s], normal, arms [m] and gamma [m/s^2] of one flank into its row."""
    write_line(body, a, b, p, k, 1.0 if corner == 0 else -1.0, row, kinematics)


def base(fields: Fields) -> tuple[float, float, float]:
    """Base radii a, b (negative inside of a ring) and the distance l_0 of the centres [m]."""
    (ra, rb), turned = pair(fields, "radii"), -1.0 if fields["internal"] else 1.0
    share = cos(fields["pressure_angle"])
    return ra * share, turned * rb * share, ra + turned * rb


@kind("one-sided", "flanks", flanks)
class Flanks(OneSidedKind):
    """The two flanks of involute teeth, each of which only pushes, with backlash between them.

    Source: Dudley, Handbook of Practical Gear Design (1994), involute geometry; Pfeiffer, Glocker, Multibody Dynamics
    with Unilateral Contacts (1996), backlash of gears.
    """

    joint = "gear"
    contacts = 2
    wall = "the teeth of its partner"

    @staticmethod
    def parameters(fields: Fields, constants: Sequence[float], corners: Corners) -> Sequence[float | LocalFunction]:
        """Base circles, phase and backlash."""
        (a, b, distance), side = base(fields), -1.0 if fields["internal"] else 1.0
        play = 0.5 * fields["backlash"] - side * length_of(distance, a + b)
        phase = constants[0] * cos(fields["pressure_angle"]) if constants else math.nan
        scale = largest(fields["backlash"], LEAST * (a + abs(b)))
        return Wrapped(a, b, phase, side, play, 0.0, 0.0, scale)

    @staticmethod
    def scale(p: Sequence[float], size: float) -> float:
        """The backlash [m], but no less than a small part of the radii."""
        return p[11]

    @staticmethod
    def bends(fields: Fields, constants: Sequence[float]) -> tuple[float, float, float]:
        """The larger base radius [m], and how fast the line of action turns as the centres move [1/m]."""
        a, b, distance = base(fields)
        return largest(a, abs(b)), 0.0, bow_of(distance, a + b)
