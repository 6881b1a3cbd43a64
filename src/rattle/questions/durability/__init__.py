"""How long joints and links last over duty cases, what fails first, and what would help."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from rattle.question import Argument, question

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism
    from rattle.questions.durability.compute import Durability


@question(
    asks="How long joints and links last over duty cases, what fails first, and what would help.",
    order=255,
    wants=(("how long it lasts, and what fails first", "[durability](heat-and-life.md)"),),
    examples=(("rattle durability wiper --hours 1440", "m.durability(hours=1440)"),),
    arguments={
        "duty": Argument('Cases, "0.7: M=30; 0.3: M=60, speed=20", by their shares of time.'),
        "hours": Argument("Hours that it needs to last."),
    },
    in_blocks=True,
)
def durability(
    m: Mechanism, duty: Sequence[Mapping[str, Any]] | str | None = None, hours: float | None = None
) -> Durability:
    """How long joints and links last: load, pressure, PV, film, wear life, fatigue life, safety, what fails first.

    One run per duty case.  Joints wear by k p v with `wear`, `length` and the radius of their pin, those with play
    by the map of `rattle wear`; bars with `section` and `material` tire by the cycles of their stress.  Bands about
    a life are assumptions unless the model says them.

    duty: cases, [{"share": 0.7, "set": {"M": 30}}, ...] or "0.7: M=30; 0.3: M=60", shares of time in proportion
    (default: [duty] of the model, else the model as it is).  hours: that it needs to last, to compare with.
    `d.table`, one row per joint and link: load [N], pressure and shear of its pin [Pa], pv [Pa m/s], film (least
    thickness over roughness), wear life [h], fatigue life [h], safety; nan where something is missing, which
    `d.remarks` says.
    `d.first` (name, what, hours), `d.bands` (10, 50, 90 % of the first failure [h]), `d.advice`, `d.plot()`.
    Raises ModelError, InputError for cases that make no sense, SolverError for a run that fails.

    Source: docs/heat-and-life.md.
    """
    from rattle.questions.durability.compute import durability

    return durability(m, duty, hours)
