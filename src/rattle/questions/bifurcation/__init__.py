"""Numbers once per turn of the driver, over the values of a parameter."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rattle.language.times import Seconds, seconds_or_none
from rattle.question import question

if TYPE_CHECKING:
    import numpy as np

    from rattle.mechanism import Mechanism
    from rattle.questions.bifurcation.compute import Bifurcation


@question(
    asks="Numbers once per turn of the driver, over the values of a parameter.",
    order=83,
    command="",
)
def bifurcation(
    m: Mechanism, parameter: str, values: Sequence[float] | np.ndarray, of: str, *, period: Seconds | None = None,
    skip: int = 100, points: int = 100, method: str | None = None, rtol: float | None = None,
    atol: float | None = None, step: Seconds | None = None, threads: int | None = None, progress: bool = False,
) -> Bifurcation:  # fmt: skip
    """Bifurcation diagram: an output [SI] once per turn of the driver, over the values of a parameter.

    For all details see `rattle.questions.bifurcation.compute`.
    parameter, values: the parameter and its values [SI].  of: a name of the result.  period: time between two
    points [s] or an expression such as "2*pi/w", for every value anew (default: a turn of the driver).
    skip, points: points left out, points kept, for each value.
    method, rtol, atol, step: as in `simulate`.
    """
    from rattle.questions.bifurcation.compute import bifurcation

    return bifurcation(
        m, parameter, values, of, period=period, skip=skip, points=points,
        method=method, rtol=rtol, atol=atol, step=seconds_or_none(step, "step"), threads=threads, progress=progress,
    )  # fmt: skip
