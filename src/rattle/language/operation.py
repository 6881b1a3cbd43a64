"""What one operation of expressions is: a record with everything that the interpreters of expressions ask for.

Programs (`bytecode`), their rates (`jets`), bounds (`intervals`), arrays of results (`arrays`), units (`expression`,
`unit_of`), switches (`switching`), recorded models (`rattle.trace`) and the reference take their tables from the
records of `operations`.  Rules of one operand are functions of x, its value f and its slope f1; of two x, y, z.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum, auto
from typing import Any

from rattle.jit.functions import KernelFunction, compiled

Rule = Callable[..., Any]  # becomes a kernel: written with what kernels know


class Units(Enum):
    """How the unit of the result follows from those of the operands."""

    PLAIN = auto()  # of a plain number or an angle a plain number
    NUMBER = auto()  # of anything a plain number
    KEPT = auto()  # that of the operand
    ROOT = auto()  # its square root
    COMMON = auto()  # that which the operands share
    ANGLE = auto()  # a plain number, of operands that share a unit
    COMPARISON = auto()  # a condition, of operands that share a unit
    JOINING = auto()  # a condition, of conditions
    PRODUCT = auto()
    QUOTIENT = auto()
    POWER = auto()
    CHOICE = auto()  # that which the last two operands share


@dataclass(frozen=True, slots=True)
class Branches:
    """What a switch is on a given side of its switching function s: the operand, or the difference of two."""

    value: KernelFunction  # (side, operands)
    slope: KernelFunction | None = None  # (side), where its value does not jump but its slope does
    switching: KernelFunction | None = None  # s of the operands where it is another one, and
    switching_span: KernelFunction | None = None  # its bounds, of spans


@dataclass(frozen=True, slots=True, eq=False)
class Operation:
    """One operation of expressions; its functions are kernels but for `array`.

    A smooth one of one operand has slope and bend, one of two operands rates, or a jet if it has sides.
    """

    name: str  # in the tree of an expression
    operands: int
    units: Units
    value: KernelFunction  # (x) or (x, y)
    array: Rule  # the same for arrays of NumPy
    span: KernelFunction  # bounds, of spans; of a switch (side, spans)
    slope: KernelFunction | None = None  # f' (x, f)
    bend: KernelFunction | None = None  # f'' (x, f, f1)
    rates: KernelFunction | None = None  # (x, dx, ddx, y, dy, ddy, z) -> dz, ddz
    jet: KernelFunction | None = None  # (side, x, dx, ddx, y, dy, ddy) -> z, dz, ddz
    partials: tuple[KernelFunction, ...] = ()  # of two operands: slopes by x and by y, (x, y, z), in recorded models
    branches: Branches | None = None
    recorded: str = ""  # operation of a graph, see `trace.graph`, where `value` itself cannot be recorded
    function: bool = True  # it is called by its name
    also: str = ""  # another name of the function
    more: bool = False  # it takes more arguments than two, one after the other
    reserved: bool = True  # its name is not allowed as that of a parameter
    arguments: str = ""  # their names in the reference
    meaning: str = ""  # in the reference

    @property
    def size(self) -> int:
        """Number of arguments, -2 for two or more."""
        return -self.operands if self.more else self.operands


def operation(name: str, units: Units, *, value: Rule, array: Rule, span: Rule, **more: Any) -> Operation:
    """The record of an operation, whose rules may be plain functions.

    sides: rules of `Branches`, if it is a switch.  Others: those of `Operation`.
    """
    if sides := more.pop("sides", None):
        more["branches"] = Branches(**{part: _kernel(name, f"{part} on a side", rule) for part, rule in sides.items()})
    rules = {"value": value, "span": span, **{part: more.pop(part) for part in RULES if part in more}}
    kernels: dict[str, Any] = {part: _kernel(name, part, rule) for part, rule in rules.items()}
    more["partials"] = tuple(_kernel(name, f"partial {n}", rule) for n, rule in enumerate(more.get("partials", ())))
    operands = kernels["value"].python.__code__.co_argcount
    return Operation(name, operands, units, array=array, **kernels, **more)


RULES = ("slope", "bend", "rates", "jet")


def _kernel(name: str, part: str, rule: Rule) -> KernelFunction:
    if isinstance(rule, KernelFunction):
        return rule
    kernel = compiled(rule)
    kernel.__name__ = f"{name} {part}"  # lambdas are told apart
    return kernel


def dispatch(
    module: str, name: str, arguments: str, cases: Mapping[int, tuple[str, Mapping[str, object]]], otherwise: str = "",
    kernels: Mapping[str, object] | None = None,
) -> KernelFunction:  # fmt: skip
    """A kernel (op, arguments) of a module that does for each code of an operation what its case says.

    cases: for each code a text with the names of kernels, and these.  otherwise: the text for all other codes, with its
    `kernels`; without it they are not met, and the last case needs no test.
    """
    lines: list[str] = [f"def {name}(op, {arguments}):"]
    names: dict[str, Any] = {"__name__": module, **(kernels or {})}
    last = -1 if otherwise else next(reversed(cases))
    for code, (text, rules) in cases.items():
        for rule, kernel in rules.items():
            names[f"{rule}_{code}"] = kernel
            text = text.replace(f"{rule}(", f"{rule}_{code}(")
        indent = "    " if code == last else "        "
        lines += [] if code == last else [f"    if op == {code}:"]
        lines += [f"{indent}{line}" for line in text.splitlines()]
    lines += [f"    {otherwise}"] if otherwise else []
    exec("\n".join(lines), names)  # of texts written in this room
    function: Any = names[name]
    function.source = [f"{line}\n" for line in lines]  # for the translation
    return compiled(function)
