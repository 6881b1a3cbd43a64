"""Exact derivatives of curves by parameters: which dimension matters, when, and how much."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rattle.language.times import Seconds, times
from rattle.question import FormField, Tab, question

if TYPE_CHECKING:
    import numpy as np

    from rattle.mechanism import Mechanism
    from rattle.results.result import Result


@question(
    asks="Exact derivatives of curves by parameters: which dimension matters, when, and how much.",
    order=140,
    wants=(("which dimension matters, when, and how much", "sensitivity"),),
    examples=(("rattle sensitivity F --of rocker.angle", 'm.sensitivity(["rocker.angle"], ["l2"], t)'),),
    tab=Tab(
        "sensitivity",
        "Sensitivity",
        40,
        (
            FormField("of", "of", usual="output", offers_curves=True, size=22),
            FormField("to", "to", usual="dimensions", size=22),
        ),
    ),
)
def sensitivity(
    m: Mechanism, outputs: Sequence[str], parameters: Sequence[str],
    t_eval: Seconds | Sequence[Seconds] | np.ndarray | None = None, analysis: str = "simulate", *,
    rtol: float | None = None, atol: float | None = None, strict: bool = False,
) -> Result:  # fmt: skip
    """Exact derivatives of curves by parameters, for all of them at once: `s["d(rocker.angle)/d(l2)"]` [SI].

    outputs: names of a result, and numbers of the whole run, "max(abs(B.force))", "mean(...)", of contacts
    "time(B.contacts, 2)", "speed(...)", "peak(...)", whose derivatives are the same at all instants.
    parameters: names of parameters; all else that is written with them follows.
    t_eval: output instants [s] (default: those of the model; t = 0 for an equilibrium).
    analysis: "simulate" integrates the derivatives along with the motion, start included, and controls the errors
    of both; "kinematics", "inverse-dynamics" and "equilibrium" (one instant, or a quasi-static path) solve for
    them at every position.
    rtol (default 1e-10), atol: of a motion, as in `simulate`.

    The result holds the outputs and, for each parameter, their derivatives.  Where they grow exponentially,
    `trust` says how fast, and how long they tell what a change does.  Where an expression switches, and where
    contacts begin and end, the jump of the derivatives is exact: contacts with force laws, rigid ones that
    bounce, stick, slip, rest and let go, one-way clutches, and joints with dry friction, which stick and slip,
    beside contacts too; a contact that grazes is told.  What cannot go on ends the result with success = False and
    a message (strict=True raises SolverError).
    Raises TraceError, with the reason, for oil, wear, ratchets, clutches with max_torque, two-phase impacts beside
    joints that rub, for loads written in Python, for drivers that switch, and where the start does not follow from
    [initial]; UnknownName, and what the analysis itself raises.

    Source: docs/theory.md, section 10.
    """
    from rattle.questions.sensitivity.compute import sensitivity

    return sensitivity(
        m._document, m.system, m.start, outputs, parameters, times(t_eval, "t_eval"), analysis,
        rtol=rtol, atol=atol, strict=strict,
    )  # fmt: skip
