"""Event-driven integration: smooth motion between located events; see `nonsmooth.event_driven`."""

from __future__ import annotations

from rattle.registry import kind
from rattle.solvers.stepper import EVENT_DRIVEN, SET_VALUED, AdaptiveStepper, SetValuedStepper


@kind("stepper", "event")
class Event(SetValuedStepper):
    """Locates every impact, release, stick and slip of impact contacts; their default.

    Steps are those of dop853, or of radau beside oil films.
    Source: Pfeiffer, Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapters 5 to 9.
    """

    order = 8
    adaptive = True
    loop = EVENT_DRIVEN
    usual_with = (SET_VALUED,)
    integrates_by = "dop853"
    if_stiff = "radau"
    refinement = 10.0  # most steps end at events
    rtol, atol, step = AdaptiveStepper.rtol, AdaptiveStepper.atol, AdaptiveStepper.step
