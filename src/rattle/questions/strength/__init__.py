"""What bars and necks of plates bear in a motion: forces, stresses, deflection, buckling, safety, life."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rattle.question import Tab, question

if TYPE_CHECKING:
    from rattle.questions.strength.answer import Strength
    from rattle.results.result import Result


@question(
    asks="What a bar or plate bears in a motion: forces and stresses, deflection, buckling, life.",
    order=225,
    of="result",
    wants=(("whether a bar or plate is strong enough: stress, buckling, life", "[strength](strength.md)"),),
    examples=(("rattle strength F --of rod", 'm.strength("rod")'),),
    tab=Tab("strength", "Strength", 65),
)
def strength(r: Result, body: str) -> Strength:
    """What a bar or the neck of a plate bears: normal and shear force, moment, stress, safety, life; of a bar also

    deflection and buckling.

    body: a bar with `section` and `material`, or "plate.neck" of a plate with `necks`.  The motion, of `simulate`
    or `inverse_dynamics`, is repeated from the model that the result holds; instants are those of the result.
    Raises InputError for another name or a result of another analysis, SolverError if forces do not balance the
    inertia.

    Source: Timoshenko, Strength of Materials I (1955); ASTM E1049-85; docs/theory.md, section 12.
    """
    from rattle.questions.strength.compute import strength

    return strength(r, body)
