"""Poincare section, bifurcation diagram over a parameter, largest Lyapunov exponent."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rattle.language.times import Seconds, seconds_or_none
from rattle.question import question

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism
    from rattle.questions.poincare.compute import Section


@question(
    asks="Poincare section, bifurcation diagram over a parameter, largest Lyapunov exponent.",
    order=80,
)
def poincare(
    m: Mechanism, *names: str, period: Seconds | None = None, crossing: str | None = None, level: float = 0.0,
    skip: int = 50, points: int = 500, method: str | None = None, rtol: float | None = None,
    atol: float | None = None, step: Seconds | None = None,
) -> Section:  # fmt: skip
    """Poincare section: values [SI] once per turn of the driver, or each time a curve rises through a level.

    For all details see `rattle.questions.poincare.compute.section`.
    period: time between two points [s] or an expression over parameters such as "2*pi/w".
    crossing, level: the curve and the level [SI] that it rises through.
    skip: points left out at the start.  points: how many are kept.  method, rtol, atol, step: as in `simulate`.
    """
    from rattle.questions.poincare.compute import section

    return section(
        m, names, period=period, crossing=crossing, level=level, skip=skip,
        points=points, method=method, rtol=rtol, atol=atol, step=seconds_or_none(step, "step"),
    )  # fmt: skip
