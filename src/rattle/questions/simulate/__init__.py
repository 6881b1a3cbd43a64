"""Motion in time: joint forces, energy, and how far the result can be trusted."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rattle.language.times import Seconds, seconds_or_none, times
from rattle.question import Tab, question

if TYPE_CHECKING:
    import numpy as np

    from rattle.mechanism import Mechanism
    from rattle.results.result import Result


@question(
    asks="Motion in time: joint forces, energy, and how far the result can be trusted.",
    order=50,
    command="run",
    title="Motion",
    wants=(("what really happens in time: free motion, play with impacts", "simulation"),),
    examples=(("rattle run F", "m.simulate(t_end)"),),
    tab=Tab("forces", "Forces", 10),
)
def simulate(
    m: Mechanism, t_end: Seconds | None = None, *, t_eval: Sequence[Seconds] | np.ndarray | None = None,
    method: str | None = None, rtol: float | None = None, atol: float | None = None, step: Seconds | None = None,
    progress: bool = False, strict: bool = False, horizon: bool = False, most_steps: int | None = None,
) -> Result:  # fmt: skip
    """Motion in time from the assembled start; all curves in SI units.

    t_end: end of the run [s].  t_eval: output instants [s] (default: the model's output interval, or 1000
    outputs).  Every time may also be a text: t_end="20 ms".
    method: a stepper (`rattle kinds stepper`); default: as in the model, otherwise "dop853", for impact contacts
    "event", with oil films "radau".
    rtol, atol: relative and absolute tolerance per step of an adaptive stepper on positions and rates
    [m, rad, m/s, rad/s].
    step: step of one with fixed steps, largest step of an adaptive one [s].
    progress: show a progress bar.  horizon: run once more with a ten times tighter tolerance (1e-8 where rtol is
    looser than 1e-7) and report how long both agree within 1 % of every curve's range.
    With rigid contacts two further runs tell what elastic bushes would show in their place (`trust.elastic`).
    most_steps: the run ends after this many steps (default: when 200 000 steps advance it by less than 1e-4 of
    its duration).

    Steps end where expressions of loads and drivers switch.  A jump in the speed of a driver is an impulse (event
    "jolt"); a jump in its position raises ModelError.

    A run ends before the drift exceeds 1e-3 (of the mechanism's extent, or of 1 rad) or the energy error exceeds
    1e-3 (of the largest of kinetic energy, work and range of the potential); for Moreau-Jean the energy may be
    off by 0.2.  A run that cannot go on returns what was computed, with success = False and a message
    (strict=True raises SolverError).  Source: docs/theory.md, section 3; Grigore et al., equation (1).
    """
    from rattle.analyses.dynamics import simulate as simulation

    result = simulation.simulate(
        m.system, m.start, t_end=seconds_or_none(t_end, "t_end"), t_eval=times(t_eval, "t_eval"),
        method=method, rtol=rtol, atol=atol, step=seconds_or_none(step, "step"), progress=progress, strict=strict,
        horizon=horizon, most_steps=most_steps,
    )  # fmt: skip
    if horizon and result.success and not result.stats.get("horizon_interrupted"):
        from dataclasses import replace

        from rattle.analyses.elastic_bushes import elastic_bushes
        from rattle.results.contact_summary import unread

        elastic, bushes = elastic_bushes(m, result.trust.t_end)
        result.trust = replace(result.trust, elastic=elastic, bushes=bushes)
        result.trust = replace(result.trust, unread=unread(result))
    if m._told:
        result.provenance["document"] = m.to_json()
    return result
