"""Moreau-Jean time stepping; its loop is in `nonsmooth.moreau_jean`."""

from __future__ import annotations

from rattle.registry import kind
from rattle.solvers.stepper import TIME_STEPPING, SetValuedStepper, equal_steps


@kind("stepper", "moreau")
class Moreau(SetValuedStepper):
    """Time stepping for impact contacts without locating events: impulses over fixed steps, for many contacts.

    Compliant contacts and oil films beside them act with their forces at the end of a step, however stiff they are.
    Source: Jean, The non-smooth contact dynamics method, Comput. Methods Appl. Mech. Eng. 177 (1999) 235-257; Moreau,
    Unilateral contact and dry friction in finite freedom dynamics (1988).
    """

    order = 1
    adaptive = False
    loop = TIME_STEPPING
    restitution_laws = ("newton",)
    energy_limit = 0.2  # its energy error is proportional to the step
    title = "Moreau-Jean"
    refinement = 10.0
    step = equal_steps(20_000)
