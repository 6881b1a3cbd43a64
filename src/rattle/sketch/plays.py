"""Play as it is typed and shown: a length, a fit with its diameter, or the number of a rolling bearing."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any, NamedTuple

from rattle.catalogue.bearings import BearingPlay, bearing
from rattle.catalogue.fits import USUAL, Fit, fit
from rattle.errors import InputError
from rattle.language.units import QuantityError, parse_quantity

HINT = "bush radius minus pin radius, such as 0.2 mm; a fit, such as H7/g6 8 mm; a bearing, such as 6208 C3; or empty"
OFFERS = ("0.1 mm", *(f"{name} 8 mm" for name in USUAL), "6204", "6208 C3")
_FIT = re.compile(r"\s*([A-Za-z]+\d+\s*/\s*[A-Za-z]+\d+)\s+(?:of\s+)?(\S.*?)\s*")  # "H7/g6 8 mm"
_BEARING = re.compile(r"\s*6\d{2,4}(?:[-\s/]+[A-Z0-9]+|[A-Z]+\d*)*\s*", re.IGNORECASE)  # "6208 C3", "6004-2RS C3"


class Typed(NamedTuple):
    """What a text for a play stands for: a key of the joint, what is written there, and what it is."""

    key: str
    value: Any
    named: Fit | BearingPlay


def typed_play(text: str) -> Typed | None:
    """A fit or a rolling bearing; None for what is neither.  Raises InputError for one that leaves no play."""
    if match := _FIT.fullmatch(text):
        name, diameter = "".join(match[1].split()), match[2]
        return Typed("clearance", {"fit": name, "diameter": diameter}, fit(name, diameter))
    if _BEARING.fullmatch(text) and not _is_length(text):
        try:
            return Typed("bearing", text.strip(), bearing(text))
        except InputError as error:
            raise InputError(f"{error}; a length has a unit, such as 0.2 mm") from None
    return None


def _is_length(text: str) -> bool:
    """True of a number with a unit, such as "600 um"."""
    try:
        quantity = parse_quantity(text)
    except QuantityError:
        return False
    return quantity is not None and quantity[1] is not None


def play_text(entry: Mapping[str, Any]) -> object:
    """What the play of a joint was written as: a text, or a number [m]; "" without."""
    if "bearing" in entry:
        rolling = entry["bearing"]
        return rolling if isinstance(rolling, str) else bearing(rolling).title
    clearance = entry.get("clearance", "")
    if isinstance(clearance, Mapping):
        fitted = f"{clearance.get('fit')} {clearance.get('diameter')}"
        return fitted if "fit" in clearance else clearance.get("radial", "")
    return clearance
