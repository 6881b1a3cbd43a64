"""Tilting moments of bearings from the offsets of the planes in which bodies move."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from rattle.language.quantities import Quantity
from rattle.question import question

if TYPE_CHECKING:
    from rattle.questions.bearing_moments.compute import BearingMoments
    from rattle.results.result import Result


@question(
    asks="Tilting moments and edge loads of bearings, from the offsets of the planes of bodies.",
    order=226,
    of="result",
    wants=(
        (
            "how bearings are tilted by bodies that move in planes beside each other",
            "[bearing moments](strength.md#bearings-that-are-tilted)",
        ),
    ),
    examples=(("rattle bearing-moments F --of pin", 'r.bearing_moments("pin")'),),
)
def bearing_moments(r: Result, joint: str, *, tilt_stiffness: Mapping[str, Quantity] | None = None) -> BearingMoments:
    """Force and tilting moment of a bearing on body B about its middle, in the axes of the ground.

    Planes of bodies and middles of joints are their `z`.  The motion is repeated from the model that the result
    holds.  In a tree of joints moments follow from balance alone; in a loop three are redundant, and bearings share
    them by their stiffness against tilting: equal, or tilt_stiffness [N m/rad] of all of them; along
    z they are rigid.
    Raises InputError for an unknown joint, one that is no bearing, or bodies that nothing holds against tipping.

    Source: Newton and Euler, Castigliano; docs/theory.md, section 12.
    """
    from rattle.questions.bearing_moments.compute import bearing_moments

    return bearing_moments(r, joint, tilt_stiffness)
