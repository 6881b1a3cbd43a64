"""The two strands of a belt: straight lines that touch both pulleys, see `elements.wrapped`, with k = -1.

e_i = +-X + F(l) - F(l_0) + T_0/K,   g_i = -e_i                      stretch and gap of a strand                [m]
T_i = K e_i + c e_i'  while e_i > 0, never less than 0               tension                                    [N]

l_0, T_0: distance and pretension at the start;  K, c: stiffness and damping of a strand (`contact_laws.tension`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from rattle.elements.wrapped import SMALL, Wrapped, bow_of, length_of, write_line
from rattle.interfaces.contacts import Corners, OneSidedKind
from rattle.interfaces.fields import Fields, pair
from rattle.jit import layout as at
from rattle.jit.functions import kernel
from rattle.language.local_function import LocalFunction
from rattle.language.recorded import largest
from rattle.registry import kind

LEAST = 1e-3  # of the radii: gaps are judged by this


@kernel("clearance")
def strands(body, a, b, p, k, corner, row, kinematics):
    """Write gap [m], its rate [m/s], normal, arms [m] and gamma [m/s^2] of one strand into its row."""
    write_line(body, a, b, p, k, -1.0 if corner == 0 else 1.0, row, kinematics)


def turning(fields: Fields) -> tuple[float, float]:
    """Radii a, b [m] of the derivation."""
    ra, rb = pair(fields, "radii")
    return ra, rb if fields["crossed"] else -rb


@kind("one-sided", "strands", strands)
class Strands(OneSidedKind):
    """The two strands of a belt, each of which only pulls.

    Source: Shigley, Mechanical Engineering Design (2011), chapter 17 (geometry of open and crossed belts).
    """

    joint = "belt"
    contacts = 2
    wall = "its slack length"
    chosen = False
    stiff_in_kinematics = True
    records = ("tight", "slack")

    @classmethod
    def column_of(cls, corner: int) -> int:
        """The tensions stand in two columns."""
        return at.JOINT_NORMAL if corner == 0 else at.JOINT_TANGENT

    @staticmethod
    def parameters(fields: Fields, constants: Sequence[float], corners: Corners) -> Sequence[float | LocalFunction]:
        """Pulleys, phase and stretch at the start."""
        (a, b), (phase, distance, psi, near) = turning(fields), constants or (math.nan,) * 4
        apart = distance > abs(a + b)
        slack = (length_of(distance, a + b) if apart else math.nan) - fields["pretension"] / fields["stiffness"]
        size = a + abs(b)
        return Wrapped(a, b, phase, -1.0, slack, 1.0 if abs(a + b) < SMALL * size else near, psi, LEAST * size)

    @staticmethod
    def scale(p: Sequence[float], size: float) -> float:
        """A small part of the radii [m]."""
        return p[11]

    @staticmethod
    def bends(fields: Fields, constants: Sequence[float]) -> tuple[float, float, float]:
        """The larger radius [m], and how fast the strands turn as the centres move [1/m]."""
        (a, b), distance = turning(fields), constants[1] if constants else math.nan
        return largest(a, abs(b)), 0.0, bow_of(distance, a + b) if distance > abs(a + b) else math.nan
