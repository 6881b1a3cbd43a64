"""An oil film between pin and bush: what it carries, how thick it is, when the pin whirls."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rattle.question import question

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism
    from rattle.questions.film.bearing import Film


@question(
    asks="An oil film between pin and bush: what it carries, how thick it is, when the pin whirls.",
    order=230,
)
def film(m: Mechanism, joint: str) -> Film:
    """The oil film of a joint as a calculator: static positions, whirl, Stribeck curve, chart; see `rt.Film`.

    Raises UnknownName for a joint that is not there, ModelError for one without oil.
    """
    from rattle.errors import suggest
    from rattle.questions.film.bearing import Film
    from rattle.results.result import UnknownName

    joints = m.model.joints
    if joint not in joints:
        raise UnknownName(f"the model has no joint {joint!r}{suggest(joint, joints)}")
    return Film.of_joint(joints[joint])
