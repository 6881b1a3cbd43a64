"""Arguments of a question as they are written: on the command line, or into a field of a form."""

from __future__ import annotations

import inspect
import re
from typing import Any

from rattle.errors import InputError
from rattle.language.quantities import in_si
from rattle.language.times import Seconds, seconds
from rattle.question import Argument, Question

WORDS = {"True": True, "False": False, "true": True, "false": False, "yes": True, "no": False}


def types_of(question: Question) -> dict[str, str]:
    """The types of the arguments that a question takes, as they are declared, without None; else of what is usual."""
    parameters = inspect.signature(question.answer).parameters
    return {name: _type_of(parameters[name]) for name in question.takes}


def _type_of(parameter: inspect.Parameter) -> str:
    declared = parameter.annotation
    if declared is parameter.empty:
        return type(parameter.default).__name__
    if declared == Seconds:
        return "Seconds"
    text = declared if isinstance(declared, str) else inspect.formatannotation(declared)
    text = text.replace(" ", "").removeprefix("typing.").removeprefix("collections.abc.")
    return text[len("Optional[") : -1] if text.startswith("Optional[") else text.removesuffix("|None")


def takes_several(annotation: str) -> bool:
    """True for an argument that is a list."""
    return annotation.startswith(("Sequence[", "tuple[", "list["))


def read(question: Question, name: str, text: str) -> Any:
    """The value of an argument: a number in SI or with a unit, a time [s], a whole number, yes or no, a list, a text.

    Raises InputError.
    """
    told, kind = question.arguments.get(name, Argument("")), types_of(question)[name]
    if takes_several(kind):
        of = kind.partition("[")[2].rstrip("]").removesuffix(",...")
        return [_value(name, part, of, told) for part in listed(text)]
    return _value(name, text, kind, told)


def listed(*texts: str) -> list[str]:
    """The names in texts, with commas between them; those in parentheses stay."""
    return [name.strip() for text in texts for name in re.split(r",(?![^(]*\))", text) if name.strip()]


def _value(name: str, text: str, kind: str, told: Argument) -> Any:
    value: Any = text
    if "Seconds" in kind:
        value = seconds(text, name)
    elif told.unit:
        value = in_si(text, name, told.unit, f'"1 {told.unit}"')
    elif kind in NUMBERS:
        value = _number(name, text, kind)
    elif kind == "bool":
        if text not in WORDS:
            raise InputError(f"{name}: expected yes or no, got {text!r}")
        value = WORDS[text]
    if told.choices and text not in told.choices:
        raise InputError(f"{name}: expected {' or '.join(told.choices)}, got {text!r}")
    if told.at_least is not None and value < told.at_least:
        raise InputError(f"{name}: {value:g} is below {told.at_least:g}")
    return value


NUMBERS = {"int": "a whole number", "float": "a number"}


def _number(name: str, text: str, kind: str) -> float:
    try:
        number = float(text)
    except ValueError:
        number = float("nan")
    if number != number or (kind == "int" and not number.is_integer()):
        raise InputError(f"{name}: expected {NUMBERS[kind]}, got {text!r}")
    return int(number) if kind == "int" else number
