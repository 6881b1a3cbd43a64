"""The largest tolerance, or clearance, that keeps an accuracy."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rattle.language.times import Seconds, seconds_or_none
from rattle.question import question

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism
    from rattle.questions.ensemble.fields import Vary
    from rattle.questions.tolerance.largest import Largest
    from rattle.questions.tolerance.required_accuracy import Within


@question(
    asks="The largest tolerance, or clearance, that keeps an accuracy.",
    order=175,
    command="",
)
def tolerance_for(
    m: Mechanism, of: str, within: Within, parameter: str, share: float = 0.997, *, vary: Vary = None,
    analysis: str = "simulate", t_end: Seconds | None = None, n: int | None = None, seed: int = 0,
    threads: int | None = None, progress: bool = False,
) -> Largest:  # fmt: skip
    """The largest tolerance, or clearance, that keeps an accuracy: `m.tolerance_for("final(x)", "1 mm", "l2")`.

    of, vary, analysis, t_end: as in `tolerance`; vary=[] leaves the others as they are.
    within: deviation that is allowed, [SI] or such as "0.1 deg", or two limits (low, high).
    parameter: whose tolerance is sought, with the distribution of its field.  The clearance itself is sought of a
    parameter that is the clearance of joints and has no tolerance: deviations are then from the mechanism without
    play, and with kinematics and inverse-dynamics all positions of the pins count.
    share: of the mechanisms that have to keep the limits.  n: samples for each value that is tried (default
    16 384 side by side, 1024 one by one, 512 if all positions of the pins count).

    Returns a float [SI], to 0.1 %, that also has `report`, `share` and `unit`.
    Raises what `tolerance` raises; ValueError if no value keeps the limits.
    """
    from rattle.questions.tolerance.largest import tolerance_for

    return tolerance_for(
        m, of, within, parameter, share, vary=vary, analysis=analysis, t_end=seconds_or_none(t_end, "t_end"),
        n=n, seed=seed, threads=threads, progress=progress,
    )  # fmt: skip
