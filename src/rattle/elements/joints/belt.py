"""Belt or chain about two pulleys; their centres may move.

d = (r_B + s_B) - (r_A + s_A) from the centre of A to that of B,  l = |d|,  psi: direction of d,  p: d turned by 90 deg
open belt:  R = -R_B     crossed:  R = R_B,     S = R_A + R

    Phi   = R_A phi_A + R phi_B - S psi - c = 0          the row where the belt cannot stretch  [m]
    gamma = S (p . d0/l^2 - 2 (d . d') (p . d')/l^4),   d0 = s_A w_A^2 - s_B w_B^2              [m/s^2]

Eytelwein: it would slip where  tight/slack > exp(mu wrap),  wrap = pi - 2 asin(|R_A - R_B|/l) about the smaller
pulley, crossed pi + 2 asin((R_A + R_B)/l).  Here it does not slip; a run says where it would.

In a run in time the belt is two strands that stretch, see `one_sided.strands`; kinematics and the start take it as
stiff.  psi is known up to whole turns only, see `elements.wrapped`.
"""

from __future__ import annotations

import math

import numpy as np

from rattle.elements.wrapped import SMALL, turned_by, write_turning
from rattle.interfaces.fields import Fields, pair
from rattle.interfaces.joints import Fit, Grip, JointKind, Strand
from rattle.jit import layout as at
from rattle.jit.choices import select
from rattle.jit.functions import kernel
from rattle.jit.geometry import ends
from rattle.registry import Field, kind

USUAL = 0.3  # coefficient of friction of a belt on its pulleys, where none is given


@kernel("joint")
def belt(body, a, b, p, k, row, rows):
    """Write the row of the belt [m]; p[k + 4:] = R_A, R_B [m], 1 if crossed, 3 of strands, 2 of slip, 4 of start."""
    _, _, _, _, dx, dy, _, _ = ends(body, a, b, p, k)
    ra, rb = p[k + 4], p[k + 5] * (2.0 * p[k + 6] - 1.0)
    s = ra + rb
    wheels = ra * body[a, at.PHI] + rb * body[b, at.PHI] - p[k + 12]
    near = select(abs(s) < SMALL * (ra + abs(rb)), 1.0, p[k + 15])
    write_turning(body, a, b, p, k, ra, rb, turned_by(wheels, s, near, p[k + 14], dx, dy), row, rows)


@kind("joint", "belt", belt)
class Belt(JointKind):
    """Belt or chain about two pulleys, open or crossed: two strands that pull only while they are stretched.

    Source: Shigley, Mechanical Engineering Design (2011), chapter 17 (geometry of open and crossed belts).
    """

    rows = ("m",)
    places = False
    from_start = 4
    drawn_as = "belt"
    radii = Field("m", "radii of the pulleys on A and B", shape="pair", least="positive")
    crossed = Field("", "the pulleys turn against each other", default=False, shape="flag")
    stiffness = Field("N/m", "of one strand", least="positive")
    damping = Field("N*s/m", "of one strand, while it is stretched", default=0.0, least="not negative")
    pretension = Field("N", "tension of both strands at the start", default=0.0, least="not negative")

    friction = Field(
        "", "coefficient of friction of belt and pulleys, by which a run says where it would slip (default: 0.3)",
        default=0.0, least="positive",
    )  # fmt: skip
    toothed = Field("", "a chain or a toothed belt, which cannot slip", default=False, shape="flag")

    @staticmethod
    def grip(fields: Fields, distance: np.ndarray) -> Grip | None:
        """Eytelwein: tight/slack < exp(mu wrap), by the pulley of the smaller wrap, at distances (n,) [m]."""
        if fields["toothed"]:
            return None
        ra, rb = pair(fields, "radii")
        across = np.clip((ra + rb if fields["crossed"] else -abs(ra - rb)) / distance, -1.0, 1.0)
        wrap = np.pi + 2.0 * np.arcsin(across)
        rough = fields["friction"] > 0.0
        mu = fields["friction"] if rough else USUAL
        return Grip(mu, "" if rough else ", assumed", wrap, np.exp(mu * wrap))

    @staticmethod
    def start_constants(residual: tuple[float, ...], d: tuple[float, float]) -> tuple[float, ...]:
        """Phase [m], distance of the centres [m] and its direction [rad]; 0: pulleys tell how often that has turned."""
        return (residual[0], math.hypot(*d), math.atan2(d[1], d[0]), 0.0)

    @staticmethod
    def resting(constants: tuple[float, ...]) -> tuple[float, ...]:
        """In statics a pulley may be anywhere: the direction is next to that of the start."""
        return (*constants[:3], 1.0)

    @staticmethod
    def strand(fields: Fields) -> Strand:
        """The law of a strand."""
        return Strand(fields["stiffness"], fields["damping"])

    @staticmethod
    def fit(fields: Fields) -> Fit:
        """The pulleys must not overlap, and the pretension must not stretch the strands by more than their length."""
        ra, rb = pair(fields, "radii")
        words = f"its pulleys of {ra:.9g} m and {rb:.9g} m need their centres farther apart than {{}}"
        stretch = fields["pretension"] / fields["stiffness"]
        needed = math.hypot(stretch, ra + rb if fields["crossed"] else ra - rb)
        if needed > ra + rb:
            words = (
                f"its pretension of {fields['pretension']:.6g} N stretches strands of {fields['stiffness']:.6g} N/m by"
                f" {stretch:.4g} m, more than they are long: the belt is too short for its path. Less pretension, a"
                " stiffer belt, or centres farther apart than {}"
            )
        return Fit(max(needed, ra + rb), None, words, least=True)
