"""How fast neighbouring motions part: the largest Lyapunov exponent."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rattle.language.times import Seconds, seconds_or_none
from rattle.question import question

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism
    from rattle.questions.lyapunov.compute import Lyapunov


@question(
    asks="How fast neighbouring motions part: the largest Lyapunov exponent.",
    order=86,
    command="",
)
def lyapunov(
    m: Mechanism, t_end: Seconds | None = None, *, stretch: Seconds | None = None, rtol: float = 1e-10
) -> Lyapunov:
    """Largest Lyapunov exponent [1/s] with its uncertainty: it explains the horizon.

    By exact variational equations where the model can be recorded, else by two neighbouring runs: see `.how`.
    t_end: end of the run [s].  stretch: time between two readings of the growth [s].  rtol: relative tolerance.
    """
    from rattle.questions.lyapunov.compute import lyapunov

    return lyapunov(m, seconds_or_none(t_end, "t_end"), stretch=seconds_or_none(stretch, "stretch"), rtol=rtol)
