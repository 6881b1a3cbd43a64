"""What a stepper says of itself: reader, schema, help, runs and messages read it here and know no stepper by name.

A leaf in `rattle.solvers.steppers` is one class.  It derives from one of the three below, says its `order` and, if it
is explicit, brings its kernels:

    step           from (t, y), with y' in `rate`, to y_new at t + h; returns its error as a share of the tolerance
                   (0 with fixed steps, inf where y_new is not finite) and whether `watched_change` was true at a stage
    dense_output   rows 3 to 6 of `dense`: zero where the cubic through both ends will do
"""

from __future__ import annotations

import math
from typing import ClassVar

from rattle.jit.functions import KernelFunction
from rattle.registry import Field, kinds
from rattle.solvers.peaks.samples import CUT

FREE, COMPLIANT, SET_VALUED = "free", "compliant", "impact"  # contacts of a mechanism: none, or their model
SMOOTH, EVENT_DRIVEN, TIME_STEPPING = "smooth", "event-driven", "time-stepping"  # loops
RTOL, ATOL = 1e-8, 1e-2  # relative tolerance, and the absolute one as a share of it, where nothing is said
LONGEST = 1e-4  # step [s] of steppers with fixed steps, where nothing is said


def equal_steps(fewest: int) -> Field:
    """The length of steps that are all equal; fewest: of a run, where it is not given."""
    said = f"length of all steps; where it is not given 0.1 ms, or 1/{fewest} of the run if that is shorter"
    return Field("s", said, default=lambda span: min(LONGEST, span / fewest), least="positive")


class Stepper:
    """A method of integration in time."""

    order: ClassVar[int]  # power of the step with which the error at the end of a smooth motion falls
    adaptive: ClassVar[bool]  # steps follow the tolerances; else all are as long as `step`
    loop: ClassVar[str]  # what takes its steps
    works_with: ClassVar[tuple[str, ...]]  # contacts
    usual_with: ClassVar[tuple[str, ...]] = ()  # contacts with which it runs where none that works is asked for
    refuses: ClassVar[tuple[str, ...]] = ()  # contacts with which nothing runs in its place
    unfit: ClassVar[dict[str, str]]  # by contacts: why it does not run with them, after its name
    refinement: ClassVar[float]  # what `step` is divided by for a run that is to be more exact by a digit
    step: ClassVar[Field]
    stages: ClassVar[int] = 0  # evaluations of the right-hand side in a step
    samples: ClassVar[int] = CUT  # where its stages lie, see `peaks.samples`; CUT: the dense output is asked instead
    dense_output: ClassVar[KernelFunction | None] = None
    integrates_by: ClassVar[str] = ""  # the stepper whose kernels are called, if they are not its own
    restitution_laws: ClassVar[tuple[str, ...]] = ()  # that it follows at impacts; none: all
    energy_limit: ClassVar[float] = 1e-3  # share of the largest energy that may be unaccounted for
    title: ClassVar[str] = ""  # its name in a sentence about what it does by design


class AdaptiveStepper(Stepper):
    """Explicit, with steps that follow the tolerances."""

    adaptive = True
    loop = SMOOTH
    works_with = (FREE, COMPLIANT)
    unfit = {SET_VALUED: "knows no impacts"}
    rtol = Field("", "error allowed per step, as a share of each position and rate", default=RTOL, least="positive")
    atol = Field(
        "m, rad, m/s, rad/s", "error per step that is always allowed; where it is not given a hundredth of rtol",
        default=lambda rtol: ATOL * rtol, least="positive",
    )  # fmt: skip
    step = Field("s", "largest step", default=math.inf, least="positive")


class FixedStepper(Stepper):
    """Explicit, with equal steps: for motion without contacts, which want their own instants."""

    adaptive = False
    loop = SMOOTH
    works_with = (FREE,)
    refuses = (COMPLIANT,)
    unfit = {SET_VALUED: "knows no impacts", COMPLIANT: "takes fixed steps, which contacts do not allow"}
    step = equal_steps(1000)


class SetValuedStepper(Stepper):
    """For set-valued contacts alone."""

    works_with = (SET_VALUED,)
    unfit = dict.fromkeys((FREE, COMPLIANT), "is for impact contacts, of which this model has none")


def usual_stepper(contacts: str) -> str:
    """Name of the stepper that runs with these contacts where none that works is asked for."""
    return next(name for name, one in kinds("stepper").items() if contacts in one.leaf.usual_with)


def stepper_of(loop: str) -> str:
    """Name of a stepper whose steps this loop takes."""
    return next(name for name, one in kinds("stepper").items() if one.leaf.loop == loop)
