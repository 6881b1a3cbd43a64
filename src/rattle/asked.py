"""The methods of `Mechanism` and `Result` that questions add; asked.pyi holds their signatures, see `signatures`."""

from __future__ import annotations

from rattle.question import methods_of, require_free_names


class OfMechanism:
    """Every question that is asked of a mechanism, as a method."""

    def __init_subclass__(cls) -> None:
        require_free_names(cls)


class OfResult:
    """Every question that is asked of a result, as a method."""

    def __init_subclass__(cls) -> None:
        require_free_names(cls)


methods_of(mechanism=OfMechanism, result=OfResult)
