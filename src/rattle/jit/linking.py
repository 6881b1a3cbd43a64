"""All kernels that some functions reach, as one text in LLVM's language that needs nothing else of the package.

Functions are called as everywhere, see `machine`: with the place of the result, then numbers, addresses and shapes;
they return 0, or 1 if they failed.  Calls of other natives, which machine code makes by a place that the linker knows,
become calls of the function itself.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from rattle.jit import families, functions, machine
from rattle.jit.functions import KernelFunction
from rattle.jit.translation.calls import kinds_of
from rattle.jit.translation.unit import ABOUT, Unit, function, told_where
from rattle.jit.translation.values import parts_of

MISSING = "a kernel of the family '{}' was called, but it is not in the table of this workspace"
LEFT_OUT = "{} is not among these kernels"
PLACE = "rattle.place."  # how symbols of natives begin


class Linked(NamedTuple):
    """Functions that need nothing but each other, in LLVM's language, without `ABOUT`.

    They are "call.NAME" for what is offered, "code.SYMBOL" for natives and "trap.FAMILY"; their places hold them.
    """

    text: str
    offered: dict[str, tuple[str, ...]]  # name: letters of result and arguments, see `families.SIGNATURE`
    kernels: dict[str, str]  # family by symbol, of what stands in tables


def link(
    offered: Mapping[str, tuple[KernelFunction, Sequence[str]]], kernels: Iterable[KernelFunction],
    without: Iterable[KernelFunction] = (),
) -> Linked:  # fmt: skip
    """The text of all that these functions and kernels reach.

    offered: by name, with the letters of result and arguments.  kernels: those that may stand in tables.  without:
    natives that nobody who calls the offered ones has a use for; they fail with words.
    Raises TranslationError for what kernels cannot use.
    """
    left_out = {native.symbol: native for native in without}
    unit, texts = Unit(), []
    table = sorted(kernels, key=lambda kernel: kernel.symbol)
    for name, (kernel, letters) in sorted(offered.items()):
        texts.append(_called(unit, f"call.{name}", kernel, letters))
    natives = {native.symbol: native for native in functions.natives()}
    done: set[str] = set()
    ahead = {kernel.symbol for kernel in table} | _places(unit)
    while ahead:
        for symbol in sorted(ahead - left_out.keys()):
            text = _called(unit, f"code.{symbol}", natives[symbol], natives[symbol].letters)
            texts.append(text.replace("define i32", "define internal i32", 1))
        done |= ahead
        ahead = _places(unit) - done
    whole = unit.whole("\n".join(texts)).replace(ABOUT, "")
    traps = [
        _failing(f"trap.{family}", letters, MISSING.format(family)) for family, letters in families.SIGNATURE.items()
    ]
    traps += [
        _failing(f"code.{symbol}", left_out[symbol].letters, LEFT_OUT.format(symbol.removeprefix(PLACE)))
        for symbol in sorted(done & left_out.keys())
    ]
    return Linked(
        "\n".join([_own_places(whole, done), *traps]),
        {name: tuple(offered[name][1]) for name in sorted(offered)},
        {kernel.symbol: kernel.family for kernel in table},
    )


def _called(unit: Unit, name: str, kernel: KernelFunction, letters: Sequence[str]) -> str:
    """The text of a function as others call it by its address."""
    result, kinds = kinds_of(letters)
    translated = function(unit, kernel.python, kinds)
    return told_where(translated, lambda: translated.written(name, outer=result))


def _failing(name: str, letters: Sequence[str], words: str) -> str:
    """The text of a function that fails with a RuntimeError."""
    _, kinds = kinds_of(letters)
    types, words = ["ptr", *(type_ for kind in kinds for type_ in parts_of(kind))], f"RuntimeError: {words}"
    return f"""@"words.{name}" = private constant [{len(words) + 1} x i8] c"{words}\\00"
define internal i32 @"{name}"({", ".join(types)}) noinline cold {{
  call void @"{machine.FAULT}"(ptr @"words.{name}")
  ret i32 1
}}"""


def _places(unit: Unit) -> set[str]:
    """Symbols of all natives that the functions of a unit call."""
    places, seen, ahead = set(unit.declared), set(), list(unit.parts.values())
    while ahead:
        part = ahead.pop()
        if part.name not in seen:
            seen.add(part.name)
            places |= set(part.unit.declared)
            ahead += part.unit.parts.values()
    return {name for name in places if name.startswith(PLACE)}


def _own_places(text: str, symbols: Iterable[str]) -> str:
    """A text whose places hold the functions that they stand for, and that does not declare FIND and FAULT."""
    places = [
        f'@"{symbol}" = internal constant i64 ptrtoint (ptr @"code.{symbol}" to i64)' for symbol in sorted(symbols)
    ]
    lines = [line for line in text.split("\n") if not line.endswith(" = external global i64")]
    outside = re.compile(rf'declare \w+ @"({re.escape(machine.FIND)}|{re.escape(machine.FAULT)})"')
    return "\n".join([*places, *(line for line in lines if not outside.match(line))])
