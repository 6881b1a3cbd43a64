"""Friction of teeth: they slide on each other at both sides of the pitch point, where they only roll.

At the distance s of the contact from the pitch point, along the line of action, teeth slide at s |w_B - w_A|, so that
mu F_n takes the power mu F_n s |w_B - w_A|.  With the tooth force F_t of the pitch circles, F_n = F_t/cos(alpha), and
the mean of s over a pitch p of teeth, between which F_n is shared evenly, this is a moment against w_B - w_A,

    |tau| = mu |F_t| e/cos(alpha),      e = mean of |s|,      p = pi m cos(alpha)

s goes from -g_B to g_A, up to where the tips leave the line of action, with teeth as high as their module m.  Tip of a
wheel of radius r, its tip circle of radius r_t = r + m, of a ring's, r_t = R - m, and of a rack's:

    g = sqrt(r_t^2 - (r cos)^2) - r sin      R sin - sqrt(r_t^2 - (R cos)^2)      m/sin

and no farther than the base circle of the other wheel, r' sin.  The part of the friction that changes sides with s has
no mean but a share of F_t, and does no work.  With contact ratios eps_i = g_i/p whose sum eps is between 1 and 2, e is
p/2 (1 - eps + eps_1^2 + eps_2^2), and the loss the share mu pi (1/z_1 +- 1/z_2) (1 - eps + eps_1^2 + eps_2^2) of the
power of the mesh: the loss factor of the standards.
"""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple

from rattle.elements.profile import degrees
from rattle.errors import InputError
from rattle.interfaces.fields import Fields
from rattle.interfaces.laws import TangentKind
from rattle.jit import layout as at
from rattle.jit.functions import kernel
from rattle.jit.geometry import angle_row
from rattle.registry import Field, kind

STEEPEST = math.radians(45.0)  # pressure angle
TEETH = {
    "module": Field(
        "m", "pitch diameter over number of teeth, from which follows how far they slide", least="positive"
    ),
    "pressure_angle": Field("rad", "of the teeth", default=math.radians(20.0), least="positive"),
}


class Reach(NamedTuple):
    """How far the contact of a wheel's teeth goes [m] from the pitch point, along the line of action."""

    own: float  # up to its tips
    other: float  # to the point at its base circle, that the tips of the other wheel do not pass


def wheel(radius: float, module: float, alpha: float) -> Reach:
    """Of a wheel with teeth outside."""
    base, far = radius * math.cos(alpha), radius * math.sin(alpha)
    return Reach(math.sqrt((radius + module) ** 2 - base**2) - far, far)


def ring(radius: float, module: float, alpha: float) -> Reach:
    """Of a ring with teeth inside."""
    base, far, tip = radius * math.cos(alpha), radius * math.sin(alpha), max(radius - module, 0.0)
    return Reach(far - math.sqrt(max(tip**2 - base**2, 0.0)), math.inf)


def straight(module: float, alpha: float) -> Reach:
    """Of a rack."""
    return Reach(module / math.sin(alpha), math.inf)


def arm(a: Reach, b: Reach, own: Fields) -> float:
    """e/cos(alpha) [m].  Raises InputError if teeth of this size would lose contact."""
    alpha = own["pressure_angle"]
    if alpha > STEEPEST:
        raise InputError(f"pressure_angle: {degrees(alpha)} is more than teeth have, {degrees(STEEPEST)}")
    pitch = math.pi * own["module"] * math.cos(alpha)
    first, last = min(a.own, b.other), min(b.own, a.other)
    if first + last < pitch:
        raise InputError(
            f"module: {own['module']:.6g} m is too large for these pitch radii: before a pair of teeth meets, the one"
            " before it has parted; the module is the pitch diameter over the number of teeth"
        )
    return mean_distance(first, last, pitch) / math.cos(alpha)


def mean_distance(first: float, last: float, pitch: float) -> float:
    """Mean over a pitch of the mean distance from 0 of all places between -last and first that are a pitch apart."""
    places = range(-math.ceil(last / pitch) - 1, math.ceil(first / pitch) + 1)
    total = 0.0
    for low, high in itertools.pairwise(sorted((0.0, first % pitch, -last % pitch, pitch))):
        middle = 0.5 * (low + high)  # in between no pair comes or goes, and none passes 0
        distances = [abs(middle + k * pitch) for k in places if -last < middle + k * pitch < first]
        total += (high - low) * sum(distances) / max(len(distances), 1)
    return total / pitch


@kernel("joint")
def turning(body, a, b, p, k, row, rows):
    """Write the row of the turning of B against A [rad/s], with N = |lambda|, the tooth force."""
    angle_row(body, a, b, 0.0, 0.0, 0.0, row, rows)
    rows[row, at.NU] = 1.0


@kind("tangent", "turning", turning)
class Turning(TangentKind):
    """Turning of two toothed wheels, or of a pinion and its rack, against each other, by which their teeth slide.

    Source: Ohlendorf, Verlustleistung und Erwaermung von Stirnraedern (1958); ISO/TR 14179-2 (2001), mesh losses.
    """

    unit = "N*m"
