"""Laws of motion from rest to rest, for cams and drivers: functions of expressions that go from 0 to 1 with u.

u is the share of the rise, `t/rise_time` or `angle/rise_angle`: below 0 a law is 0, above 1 it is 1.  Each is written
with the operations that expressions have, so that derivatives, switches and units follow.  With a rise h in the time T
the largest velocity is C_v h/T, the largest acceleration C_a h/T^2:

    law                  C_v     C_a     acceleration
    harmonic            1.571   4.935    jumps at both ends
    cycloid             2.000   6.283    sine
    poly345             1.875   5.774    cubic
    poly4567            2.188   7.513    without a jump of its slope at the ends
    modified_sine       1.760   5.528    sine, at the ends four times as fast as between
    modified_trapezoid  2.000   4.888    constant between quarters of a sine

Source: VDI 2143-1 (1980), section 4; Norton, Cam Design and Manufacturing Handbook (2009), chapters 3 and 4.
"""

from __future__ import annotations

from collections.abc import Mapping

_SINE = "4*(4 + pi)"
_TRAPEZOID = "8*pi/(2 + pi)"  # the acceleration of its middle
_LIFT = f"{_TRAPEZOID}/(4*pi)*(1/8 - 1/(4*pi))"  # at the end of the first eighth
_RATE = f"{_TRAPEZOID}/(4*pi)"


def _half(w: str) -> str:
    """The first half of the modified trapezoid, w from 0 to 1/2."""
    quarter = f"{_RATE}*({w} - sin(4*pi*{w})/(4*pi))"
    middle = f"{_LIFT} + {_RATE}*({w} - 1/8) + {_TRAPEZOID}/2*({w} - 1/8)**2"
    end = (
        f"{_LIFT} + {_RATE}/4 + {_TRAPEZOID}/32 + ({_RATE} + {_TRAPEZOID}/4)*({w} - 3/8)"
        f" + {_TRAPEZOID}/(16*pi**2)*(1 - cos(4*pi*({w} - 3/8)))"
    )
    return f"({quarter} if {w} < 1/8 else {middle} if {w} < 3/8 else {end})"


# name: the law between 0 and 1
LAWS: Mapping[str, str] = {
    "harmonic": "(1 - cos(pi*u))/2",
    "cycloid": "u - sin(2*pi*u)/(2*pi)",
    "poly345": "u**3*(10 - 15*u + 6*u**2)",
    "poly4567": "u**4*(35 - 84*u + 70*u**2 - 20*u**3)",
    "modified_sine": f"(4*pi*u - sin(4*pi*u))/({_SINE}) if u < 1/8"
    f" else (8 + 4*pi*u - 9*sin(4/3*pi*u + pi/3))/({_SINE}) if u < 7/8"
    f" else (16 + 4*pi*u - sin(4*pi*u))/({_SINE})",
    "modified_trapezoid": f"{_half('u')} if u < 1/2 else 1 - {_half('(1 - u)')}",
}
MEANING: Mapping[str, str] = {
    name: f"from 0 to 1 as u goes from 0 to 1, at rest before and after: {law}"
    for name, law in {
        "harmonic": "half a cosine; its acceleration jumps at both ends",
        "cycloid": "inclined sine, u - sin(2 pi u)/(2 pi)",
        "poly345": "polynomial 3-4-5",
        "poly4567": "polynomial 4-5-6-7, whose jerk does not jump",
        "modified_sine": "modified sine, the smallest peak power",
        "modified_trapezoid": "modified trapezoid, a small largest acceleration",
    }.items()
}


def law_text(name: str) -> str:
    """A law for all u as an expression of `u`."""
    return f"0 if u <= 0 else 1 if u >= 1 else ({LAWS[name]})"
