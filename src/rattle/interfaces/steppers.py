"""What other rooms need to know of steppers: the interface of these kinds, see `rattle.solvers.stepper`."""

from __future__ import annotations

from typing import ClassVar

from rattle.interfaces.fields import Field
from rattle.jit.functions import KernelFunction


class StepperKind:
    """Interface of the time integration methods."""

    order: ClassVar[int]  # power of the step with which the error decreases, at least
    error_order: ClassVar[int] = 0  # power with which the estimated error of one step grows; 0: its order
    implicit: ClassVar[bool] = False  # it solves equations with the Jacobian, for which it needs arrays
    adaptive: ClassVar[bool]  # steps follow the tolerances; otherwise all have the length `step`
    loop: ClassVar[str]  # the loop that takes its steps
    works_with: ClassVar[tuple[str, ...]]  # contacts
    usual_with: ClassVar[tuple[str, ...]] = ()  # contacts with which it runs unless another is chosen that works
    usual_since: ClassVar[str] = ""  # why, where a run should say so
    refuses: ClassVar[tuple[str, ...]] = ()  # contacts with which no other stepper runs in its place
    unfit: ClassVar[dict[str, str]]  # by contacts: why it does not run with them, as words that follow its name
    refinement: ClassVar[float]  # `step` is divided by this for a run that is more accurate by one digit
    step: ClassVar[Field]
    stages: ClassVar[int] = 0  # of a step; the first is the end of the step before
    dense_stages: ClassVar[int] = 0  # further ones that its dense output needs
    dense_output: ClassVar[KernelFunction | None] = None
    integrates_by: ClassVar[str] = ""  # the stepper whose kernels are called, if not its own
    if_stiff: ClassVar[str] = ""  # the one whose kernels are called instead for models with oil films
    restitution_laws: ClassVar[tuple[str, ...]] = ()  # restitution laws that it can use; empty: all
    energy_limit: ClassVar[float] = 1e-3  # share of the largest energy that may be unaccounted for
    title: ClassVar[str] = ""  # its name in messages about its design
