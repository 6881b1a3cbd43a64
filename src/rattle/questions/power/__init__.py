"""Where energy goes: who gives it to which body, what comes back, where it is lost."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rattle.question import Tab, question

if TYPE_CHECKING:
    from rattle.questions.power.compute import Power
    from rattle.results.result import Result


@question(
    asks="Where energy goes: who gives it to which body, what comes back, where it is lost.",
    order=220,
    of="result",
    tab=Tab("power", "Power", 60),
)
def power(r: Result, t0: float | None = None, t1: float | None = None) -> Power:
    """Powers [W] between elements and bodies, and their energies [J] from t0 to t1 [s].

    By default the last turn of the driver, or the whole run if no driver turns steadily or it is shorter than that.
    The run of a motion in time is repeated from the model that the result holds.
    Raises InputError for a result of another analysis or times outside of the run, ModelError for a model with laws
    in Python that are not known here.
    """
    from rattle.questions.power.compute import power

    return power(r, t0, t1)
