"""The functions of time that drawing writes and changes: "90 deg + 60 rpm*t", a start and a rate."""

from __future__ import annotations

import math
import re
from typing import NamedTuple

from rattle.errors import InputError
from rattle.language.units import parse_quantity
from rattle.sketch.numbers import degrees, in_unit_of, length, plain, shortest

_LEAD = re.compile(r"\s*([+-]?\s*[\d.]+(?:[eE][+-]?\d+)?(?:\s*[A-Za-z]+)?)\s*(?=[+-]|$)")
_OF_TIME = re.compile(r"(.*\S)\s*\*\s*t\s*")
_EXPONENT = re.compile(r"\d[eE]$")
_NUMBER = re.compile(r"\d[\d.]*(?:[eE][+-]?\d+)?")
_PRODUCT = re.compile(r"[\w.\s*/]+")


def shifted(written: object, start: float, change: float, turns: bool) -> str | float:
    """A function of time with another value at the start, its rate as it was.

    start: its value at t = 0 [rad or m].  change: by which it is to differ.  turns: an angle, otherwise a length.
    """
    if isinstance(written, int | float):
        return math.remainder(written + change, math.tau) if turns else length(written + change)
    text = str(written)
    match = _LEAD.match(text) if re.search(r"\bif\b", text) is None else None  # a start of one way would be no start
    lead = parse_quantity(match[1].replace(" ", "", 1) if match[1][0] in "+-" else match[1]) if match else None
    if match and lead is not None:
        if turns:
            first = degrees(lead[0] + change)
        else:
            first_value = in_unit_of(match[1], lead[0] + change)
            first = first_value if isinstance(first_value, str) else f"{plain(first_value)} m"
        rest = text[match.end() :].lstrip()
        return f"{first} {rest[0]} {rest[1:].lstrip()}" if rest else first
    first = degrees(change) if turns else f"{plain(length(change))} m"
    return f"{first} + {text}" if _PRODUCT.fullmatch(text) else f"{first} + ({text})"


class Rate(NamedTuple):
    """The factor of t in "start + rate*t", with its sign."""

    before: str  # what stands in front of it, "" if nothing
    text: str


def rate_of(written: object) -> Rate | None:
    """What stands before "*t" at the end of a function of time; None where it is written otherwise."""
    match = _OF_TIME.fullmatch(written) if isinstance(written, str) else None
    if match is None or re.search(r"\b(t|if)\b", match[1]):  # then it is not all of the rate
        return None
    head, depth = match[1], 0
    for k in range(len(head) - 1, -1, -1):
        depth += (head[k] == ")") - (head[k] == "(")
        if head[k] in "+-" and depth == 0 and not _EXPONENT.search(head[:k]):
            rate = head[k + 1 :].strip()
            return Rate(head[:k].strip(), f"-{rate}" if head[k] == "-" else rate)
    return Rate("", head.strip())


def with_rate(written: object, rate: str) -> str:
    """A function of time with another rate.  Raises InputError where it is not "start + rate*t"."""
    old = rate_of(written)
    if old is None:
        raise InputError(f"the function is {written!r}, not a start and a rate: write it under Text")
    back, factor = rate.startswith("-"), rate.removeprefix("-").strip()
    factor = f"({factor})" if re.search(r"[+-]", _NUMBER.sub("", factor)) else factor
    if old.before:
        return f"{old.before} {'-' if back else '+'} {factor}*t"
    return f"{'-' if back else ''}{factor}*t"


def turned(angle: float) -> float:
    """An angle between -pi and pi, of which -pi is not one."""
    return math.remainder(angle, math.tau)


def two_digits(value: float) -> float:
    """A number with two digits, for what nobody has asked for."""
    return shortest(value, 0.05 * 10.0 ** math.floor(math.log10(abs(value)))) if value else 0.0
