"""One-sided versions of joints: contacts in place of their rows, without clearance; and the interface of these kinds.

The parameters of a kernel are, in this order: the points of A and B (x, y each) [m], then what `parameters` returns.
Where the joint without contact holds two surfaces together on both sides, here they only push.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

from rattle.elements.contact_geometry import ContactGeometry
from rattle.jit import layout as at
from rattle.language.recorded import hypot


class OneSidedKind(ContactGeometry):
    """Interface of the one-sided kinds; the defaults are those of one contact of a follower."""

    joint: ClassVar[str]  # the kind of joint that is one-sided with `contact`
    chosen: ClassVar[bool] = True  # False: the joint always has these contacts, by a law of its own
    stiff_in_kinematics: ClassVar[bool] = False  # True: kinematics takes the rows of the joint instead
    records: ClassVar[tuple[str, ...]] = ()  # names of its two forces [N], the larger first, instead of N
    rounded = False
    slides = False
    has_radius = False
    column = at.JOINT_NORMAL

    @staticmethod
    def parameters(fields: Mapping[str, Any], constants: Sequence[float]) -> Sequence[Any]:
        """What the kernel takes after the points: numbers [SI] and functions; constants: that the start has set."""
        return tuple(fields.values())

    @staticmethod
    def levers(p: Sequence[float]) -> tuple[float, float]:
        """Arms [m] of the two points."""
        return hypot(p[0], p[1]), hypot(p[2], p[3])

    @staticmethod
    def scale(p: Sequence[float], size: float) -> float:
        """The size [m] of the mechanism: no gap is given."""
        return size
