"""The methods of `Mechanism` and `Result` that questions add; asked.pyi holds their signatures, see `signatures`."""

from __future__ import annotations

from rattle.question import asked_of


class OfMechanism:
    """Every question that is asked of a mechanism, as a method."""


class OfResult:
    """Every question that is asked of a result, as a method."""


for _class, _what in ((OfMechanism, "mechanism"), (OfResult, "result")):
    for _name, _question in asked_of(_what).items():
        setattr(_class, _name, _question.answer)
