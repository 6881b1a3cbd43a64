"""How far bodies travel while a mechanism is driven: a question of one's own, see docs/adding-a-question.md."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rattle.question import Argument, question

if TYPE_CHECKING:
    from rattle.answers.answer import Answer
    from rattle.mechanism import Mechanism


@question(
    asks="How far the mass centre of every body travels in x and y.",
    wants="how much room a mechanism needs",
    examples=(("rattle travel slider_crank --points 91", "m.travel()"),),
    arguments={
        "points": Argument("Number of positions, evenly spaced in time.", at_least=2),
        "least": Argument("Bodies that travel less are left out.", unit="m"),
    },
)
def travel(m: Mechanism, points: int = 181, least: float = 0.0) -> Answer:
    """How far the mass centre of every body travels in x and y [m].

    points: positions over the time of the model.  least: bodies that travel less are left out [m].
    """
    from rattle.answers.answer import Answer, Number
    from rattle.answers.blocks import of_result, table
    from rattle.results.display import quantity

    r = m.ideal().kinematics(np.linspace(0.0, m.model.settings.t_end, points))
    spans = {f"{body}.{axis}": float(np.ptp(r[f"{body}.{axis}"])) for body in m.model.bodies for axis in ("x", "y")}
    far = {name: span for name, span in spans.items() if span >= least}
    return Answer.of(
        f"the farthest travels {quantity(max(spans.values()), 'm')}",
        of_result("Mass centres", r, list(far)),
        table(("coordinate", "travels"), [(name, quantity(span, "m")) for name, span in far.items()]),
        numbers={"farthest": Number(max(spans.values()), "m")},
    )
