"""What a stepper (time integration method) declares: reader, schema, help, runs and messages use no stepper's name.

A leaf in `rattle.solvers.steppers` is one class, which derives from one of the three below.  An explicit Runge-Kutta
method is a `tableau`, registered with the kernel of all of them, `explicit.step`; the rest follows.  Another method
declares its `order` and, if it takes the steps of smooth motion, its kernels:

    step           from (t, y), with y' in `rate`, to y_new at t + h; returns its error as a share of the tolerance
                   (0 with fixed steps, inf if y_new is not finite) and whether `watched_change` was true at a stage
    dense_output   rows 3 to 6 of `dense`: zero if the cubic through both ends is enough; a method whose derivative at
                   the ends says nothing about the step, because it is stiff, replaces rows 1 and 2 as well
"""

from __future__ import annotations

import math
from typing import ClassVar

from rattle.errors import InputError
from rattle.interfaces.steppers import StepperKind
from rattle.registry import Field, Kind, kinds
from rattle.solvers.explicit import prepare_dense
from rattle.solvers.tableau import Tableau

# contacts of a mechanism: none, or their model; OILED are compliant ones with an oil film beside at least one
FREE, COMPLIANT, OILED, SET_VALUED = "free", "compliant", "lubricated", "impact"
SMOOTH, EVENT_DRIVEN, TIME_STEPPING = "smooth", "event-driven", "time-stepping"  # loops
RTOL, ATOL = 1e-8, 1e-2  # default relative tolerance, and the absolute one as a share of it
LONGEST = 1e-4  # default step [s] of steppers with fixed steps


def equal_steps(fewest: int) -> Field:
    """Field for the length of equal steps [s]; fewest: number of steps of a run if the length is not given."""
    meaning = f"length of all steps; if not given 0.1 ms, or 1/{fewest} of the run if that is shorter"
    return Field("s", meaning, default=lambda span: min(LONGEST, span / fewest), least="positive")


class Stepper(StepperKind):
    """A time integration method."""

    tableau: ClassVar[Tableau | None] = None  # of an explicit method

    def __init_subclass__(cls) -> None:
        """Fill in what follows from a tableau.  Raises InputError for one that is not of the kind of its class."""
        tableau = cls.__dict__.get("tableau")
        if tableau is None:
            return
        if tableau.adaptive != cls.adaptive:
            kind = "an error estimate: derive from AdaptiveStepper" if tableau.adaptive else "no error estimate"
            raise InputError(f"{cls.__name__}: its tableau has {kind}")
        cls.order, cls.stages, cls.dense_stages = tableau.order, tableau.stages, tableau.dense_stages
        cls.dense_output, cls.refinement = prepare_dense, 10 ** (1 / tableau.order)


class AdaptiveStepper(Stepper):
    """A method whose steps follow the tolerances."""

    adaptive = True
    loop = SMOOTH
    works_with = (FREE, COMPLIANT, OILED)
    unfit = {SET_VALUED: "knows no impacts"}
    rtol = Field("", "relative tolerance per step on positions and rates", default=RTOL, least="positive")
    atol = Field(
        "m, rad, m/s, rad/s", "absolute tolerance per step; if not given a hundredth of rtol",
        default=lambda rtol: ATOL * rtol, least="positive",
    )  # fmt: skip
    step = Field("s", "largest step", default=math.inf, least="positive")


class FixedStepper(Stepper):
    """An explicit method with equal steps, for motion without contacts: contacts need steps that end at events."""

    adaptive = False
    loop = SMOOTH
    works_with = (FREE,)
    refuses = (COMPLIANT, OILED)
    unfit = {SET_VALUED: "knows no impacts"} | dict.fromkeys(refuses, "takes fixed steps, which contacts do not allow")
    step = equal_steps(1000)


class SetValuedStepper(Stepper):
    """A method for set-valued contacts only."""

    works_with = (SET_VALUED,)
    unfit = dict.fromkeys((FREE, COMPLIANT, OILED), "is for impact contacts, of which this model has none")


def usual_stepper(contacts: str) -> str:
    """Name of the stepper that runs with these contacts unless another that works is chosen."""
    return next(name for name, stepper in kinds("stepper").items() if contacts in stepper.leaf.usual_with)


def stepper_of(loop: str) -> str:
    """Name of a stepper that belongs to this loop."""
    return next(name for name, stepper in kinds("stepper").items() if stepper.leaf.loop == loop)


def tableau_of(stepper: Kind[StepperKind]) -> Tableau | None:
    """The tableau of an explicit method, otherwise None."""
    return stepper.leaf.tableau if issubclass(stepper.leaf, Stepper) else None
