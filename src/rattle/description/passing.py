"""Joints that bodies come to and leave, such as slots with open ends: what cannot be asked of mechanisms with them."""

from __future__ import annotations

from rattle.description.model import Model
from rattle.errors import ModelError, Problem


def require_none_passing(model: Model, what: str, surfaces: bool = False) -> None:
    """Raise ModelError if a joint comes and goes; what: what was asked for, with an article.

    surfaces: they are followed.
    """
    passing = [
        (name, joint) for name, joint in model.joints.items() if joint.passing and not (surfaces and joint.leaf.touches)
    ]
    if passing:
        (name, first), names = passing[0], ", ".join(f"'{name}'" for name, _ in passing)
        raise ModelError([
            Problem(
                ("joints", name),
                f"{first.leaf.passing(first.fields)} holds only where the bodies touch, which {what} does not follow"
                f" ({names}): use simulate, until it rests",
            )
        ])  # fmt: skip
