"""How warm joints become by their friction, with oil and play as they are at that temperature."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from rattle.language.quantities import Quantity
from rattle.language.times import Seconds, seconds_or_none
from rattle.question import Argument, question

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism
    from rattle.questions.heat.compute import Heat


@question(
    asks="How warm joints become by their friction, with oil and play as they are at that temperature.",
    order=245,
    wants=(("how warm its joints become", "[heat](heat-and-life.md)"),),
    examples=(('rattle heat press --ambient "25 degC" --cooling "O=5 W/K"', 'm.heat(ambient="25 degC", cooling=...)'),),
    arguments={
        "ambient": Argument("Temperature of the air.", unit="K"),
        "cooling": Argument('Conductance from joints to the air, "pin=2 W/K, slider=1 W/K".'),
        "conduction": Argument('Conductance between joints, "pin,slider=0.5 W/K".'),
        "t_end": Argument("End of every run.", unit="s"),
    },
    in_blocks=True,
)
def heat(
    m: Mechanism, *, ambient: Quantity | None = None, cooling: Mapping[str, Quantity] | str | None = None,
    conduction: Mapping[tuple[str, str], Quantity] | str | None = None, t_end: Seconds | None = None,
) -> Heat:  # fmt: skip
    """Steady temperatures of joints from what they lose by friction.

    What a joint loses is the mean over the last turn of the driver, or over the whole run.  It flows to the air and
    between joints by conductances that have to be known.  Oil and play are those at the temperature of their joint,
    found by repeated runs.  What is left out is as in the table [heat] of the model.

    ambient: temperature of the air, "20 degC"; a number is kelvin.  cooling: to the air, {"pin": "2 W/K"}.
    conduction: between joints, {("pin", "slider"): "0.5 W/K"}.  t_end: end of the runs [s] (default: the model's).
    `h.temperature["pin"]` [K], `h.loss["pin"]` [W], `h.iterations` runs, `h.mechanism` with these temperatures,
    `h.table` [degC], `h.plot()`, `h.remarks`.  Losses are those of `r.power()`.
    Raises InputError for heat that cannot leave, unknown joints and wrong units; SolverError where a joint seizes,
    oil leaves -30 ... 200 degC, or no steady temperatures are reached.

    Source: docs/heat-and-life.md.
    """
    from rattle.questions.heat.compute import heat

    return heat(m, ambient, cooling, conduction, seconds_or_none(t_end, "t_end"))
