"""A pin in a bush with play: which rows it has while a contact model holds it.

    e = d = (r_B + s_B) - (r_A + s_A)     pin centre minus bush centre, bush on A, pin on B
"""

from __future__ import annotations

from rattle.catalog import kind


@kind("contact", "ideal")
class Ideal:
    """The clearance is ignored: the joint is the plain one.

    Source: definition.
    """

    replaces = {}
    joints = ("revolute", "prismatic")


@kind("contact", "massless-link")
class MasslessLink:
    """The pin stays on the bush wall: a massless rigid link of length = clearance, two-sided.

    Its force N is positive when the pin presses on the wall; N < 0 means that the wall would have to
    pull, and every such interval is reported.

    Source: Grigore et al., Application to the motion and equilibrium of planar kinematic chains, section 1.
    """

    replaces = {"revolute": "rod"}  # the joint's rows give way to the rows of this kind, its length the clearance
    joints = ("revolute",)
