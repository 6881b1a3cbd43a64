"""What joints and contacts of Geneva drives share: open ends of a slot, and how wide an arc of the wheel is."""

from __future__ import annotations

import math

from rattle.interfaces.fields import Fields
from rattle.language.recorded import acos

OPEN = ("none", "start", "end", "both")  # which ends are open; `end` is the one in the direction of the axis
AT_START, AT_END, BOTH = 1.0, 2.0, 3.0


def open_at(fields: Fields) -> tuple[bool, bool]:
    """True for each end of a slot that is open: the start, and the end in the direction of the axis."""
    return fields["open"] in (AT_START, BOTH), fields["open"] in (AT_END, BOTH)


def half_angle(fields: Fields) -> float:
    """beta [rad]: half the angle of an arc, as seen from its centre; nan if it does not reach the rim."""
    radius, distance = fields["radius"] + fields["play"], fields["axle_distance"]
    cos = (distance**2 + radius**2 - fields["rim"] ** 2) / (2.0 * radius * distance)
    return acos(cos) if -1.0 < cos < 1.0 else math.nan
