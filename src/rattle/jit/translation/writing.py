"""Writing the instructions of one function: variables, labels, memory, conversions.

The function is written again until the kinds of its variables are stable: a variable that holds an integer first and a
float later is a float.  Every variable has a place on the stack, which LLVM turns into registers.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from rattle.jit.families import Kind
from rattle.jit.machine import FAULT
from rattle.jit.translation.values import (
    NUMBERS,
    TranslationError,
    Value,
    is_number,
    joined,
    members,
    number,
    parts_of,
    said,
)
from rattle.value_types import Plain

FAILED = "failed"  # label of the place where a function returns without a result
ZEROS = {"double": number(0.0), "i64": "0", "i1": "false", "ptr": "null"}
ALIAS: dict[Kind, str] = {"f": "!2", "i": "!3"}  # floats and integers never share memory


class Unit(Protocol):
    """What functions that are translated together share."""

    checks: bool
    arrays: dict[str, tuple[int, str]]

    def constant(self, array: np.ndarray) -> Value:
        """An array that does not change."""

    def text(self, words: str) -> str:
        """The address of a text."""

    def declare(self, name: str, line: str) -> None:
        """Something from outside that functions use."""

    def part(self, called: object, kinds: Sequence[Kind]) -> tuple[str, Kind, bool]:
        """Another function for arguments of these kinds: its name, the kind of its result, whether it may fail."""


class Writing:
    """The text of one function while it is written."""

    def __init__(self, unit: Unit, function: Plain, careful: bool = False) -> None:
        self.unit, self.function = unit, function
        self.careful = careful  # whether it was written by a user: indices count from the end too, and are checked
        self.loops: list[tuple[str, str]] = []  # where `continue` and `break` go
        self.handlers: list[str] = []  # where it goes on if something fails
        code, cells = function.__code__, function.__closure__ or ()
        around = {name: cell.cell_contents for name, cell in zip(code.co_freevars, cells, strict=True)}
        self.variables = {*code.co_varnames, *code.co_cellvars}  # arguments too
        self.outside = {**function.__globals__, **around}  # what does not change
        self.fixed: dict[str, Value] = {}  # arguments that stay as they are
        self.kinds: dict[object, Kind] = {}  # of variables, and of values that several ways lead to
        self.result: Kind | None = None  # kind of the result; None until the first return
        self.fails = False  # whether it may return without a result
        self.changed = False  # whether one of these has changed since the text was begun
        self.line = 1  # from the first of the function

    @property
    def in_loop(self) -> bool:
        """True for what may be done several times."""
        return bool(self.loops)

    @property
    def place(self) -> int:
        """The present line of the file."""
        return self.function.__code__.co_firstlineno + self.line - 1

    def restart(self) -> None:
        """Begin the text."""
        self.lines: list[str] = []
        self.places: dict[object, list[str]] = {}  # of variables on the stack
        self.rooms: list[str] = []  # types of other places on the stack
        self.count, self.changed, self.open = 0, False, True

    # ---------------------------------------------------------------- instructions
    def name(self) -> str:
        """A new name."""
        self.count += 1
        return f"%x{self.count}"

    def room(self, type_: str) -> str:
        """A place on the stack."""
        self.rooms.append(type_)
        return f"%r{len(self.rooms) - 1}"

    def put(self, instruction: str) -> str:
        """An instruction with a result; returns its name."""
        name = self.name()
        self.lines.append(f"  {name} = {instruction}")
        return name

    def do(self, instruction: str) -> None:
        """An instruction without a result."""
        self.lines.append(f"  {instruction}")

    def label(self) -> str:
        """A new label."""
        self.count += 1
        return f"l{self.count}"

    def begin(self, label: str) -> None:
        """What follows stands at a label."""
        self.lines.append(f"{label}:")
        self.open = True

    def end(self, instruction: str) -> None:
        """An instruction after which nothing here is reached."""
        self.do(instruction)
        self.open = False

    def jump(self, label: str) -> None:
        """Go on at a label, unless this place is not reached."""
        if self.open:
            self.end(f"br label %{label}")

    def branch(self, truth: str, yes: str, no: str) -> None:
        """Go on at one of two labels."""
        self.end(f"br i1 {truth}, label %{yes}, label %{no}")

    def called(self, result: str, name: str, arguments: Sequence[tuple[str, str]], marks: str = "") -> str:
        """Call of a function from outside; returns its result."""
        types = ", ".join(kind for kind, _ in arguments)
        self.unit.declare(name, f'declare {result} @"{name}"({types}) {marks}')
        return self.put(f'call {result} @"{name}"({", ".join(" ".join(argument) for argument in arguments)})')

    def fail_if(self, truth: str, before: str = "") -> None:
        """Fail where something is true, after an instruction."""
        bad, good = self.label(), self.label()
        self.do(f"br i1 {truth}, label %{bad}, label %{good}, !prof !5")
        self.begin(bad)
        self.fail(before)
        self.begin(good)

    def fail(self, before: str = "") -> None:
        """Return without a result, or go on where failures are handled, after an instruction."""
        if before:
            self.do(before)
        self.fails |= not self.handlers
        self.jump(self.handlers[len(self.handlers) - 1] if self.handlers else FAILED)

    # ---------------------------------------------------------------- variables
    def _places(self, key: object) -> list[str]:
        if key not in self.places:
            self.places[key] = [f"%v{len(self.places)}.{n}" for n, _ in enumerate(parts_of(self.kinds[key]))]
        return self.places[key]

    def keep(self, key: object, value: Value) -> None:
        """Give a variable, or a value that several ways lead to, its value here."""
        kind = joined(self.kinds.get(key, value.kind), value.kind)
        if self.kinds.get(key) != kind:
            self.changed |= key in self.kinds
            self.kinds[key] = kind
            self.places.pop(key, None)
        value = self.converted(value, kind)
        for place, type_, part in zip(self._places(key), parts_of(kind), value.parts, strict=True):
            self.do(f"store {type_} {part}, ptr {place}")

    def kept(self, key: object) -> Value:
        """The present value of a variable."""
        kind = self.kinds[key]
        loads = (f"load {type_}, ptr {place}" for type_, place in zip(parts_of(kind), self._places(key), strict=True))
        return Value(kind, tuple(self.put(load) for load in loads))

    def load(self, name: str) -> Value:
        """The value of a variable of the function."""
        if name in self.fixed:
            return self.fixed[name]
        if name not in self.kinds:
            raise TranslationError(f"'{name}' is used before it has a value")
        return self.kept(name)

    def stack(self) -> list[str]:
        """Instructions that make room for all variables, with zeros."""
        lines = [f"  %r{n} = alloca {type_}" for n, type_ in enumerate(self.rooms)]
        for key, places in self.places.items():
            for place, type_ in zip(places, parts_of(self.kinds[key]), strict=True):
                lines += [f"  {place} = alloca {type_}", f"  store {type_} {ZEROS[type_]}, ptr {place}"]
        return lines

    # ---------------------------------------------------------------- values
    def together(self, values: Sequence[Value]) -> Value:
        """A tuple of values."""
        return Value(tuple(value.kind for value in values), tuple(part for value in values for part in value.parts))

    def converted(self, value: Value, kind: Kind) -> Value:
        """A value as another kind: numbers from truth to integer to float, and tuples of them."""
        if value.kind == kind:
            return value
        if isinstance(kind, tuple) and isinstance(value.kind, tuple) and len(kind) == len(value.kind):
            return self.together([self.converted(a, b) for a, b in zip(members(value), kind, strict=True)])
        if not (is_number(value.kind) and is_number(kind)) or NUMBERS.index(kind) < NUMBERS.index(value.kind):
            raise TranslationError(f"{said(value.kind)} cannot be {said(kind)}")
        if value.thing is not None and kind == "f":
            return Value("f", (number(float(value.thing)),), float(value.thing))
        if value.thing is not None:
            return Value("i", (str(int(value.thing)),), int(value.thing))
        if value.kind == "b":
            word = "uitofp i1 {} to double" if kind == "f" else "zext i1 {} to i64"
        else:
            word = "sitofp i64 {} to double"
        return Value(kind, (self.put(word.format(value.parts[0])),))

    def true(self, value: Value) -> str:
        """Whether a number is true, as an i1."""
        if value.kind == "b":
            return value.parts[0]
        if value.kind == "i":
            return self.put(f"icmp ne i64 {value.parts[0]}, 0")
        if value.kind == "f":
            return self.put(f"fcmp une double {value.parts[0]}, {number(0.0)}")
        raise TranslationError(f"{said(value.kind)} is neither true nor false")

    # ---------------------------------------------------------------- memory
    def array_of(self, workspace: Value, name: str) -> Value:
        """An array of a workspace: its address and shape stand in the table that machine code gets."""
        if name not in self.unit.arrays:
            raise TranslationError(f"a workspace has no array '{name}'")
        place, kind = self.unit.arrays[name]
        address, *shape = (
            self.put(f"getelementptr i64, ptr {workspace.parts[0]}, i64 {3 * place + n}")
            for n in range(1 + int(kind[1]))
        )
        first = self.put(f"load ptr, ptr {address}, align 8, !invariant.load !4")
        sizes = (self.put(f"load i64, ptr {size}, align 8, !invariant.load !4") for size in shape)
        return Value(kind, (first, *sizes))

    def address(self, array: Value, place: str) -> str:
        """The address of a number of an array, by its place from the first."""
        if place == "0":
            return array.parts[0]
        return self.put(f"getelementptr {parts_of(array.kind[0])[0]}, ptr {array.parts[0]}, i64 {place}")

    def read(self, kind: Kind, address: str) -> Value:
        """A number in memory."""
        return Value(kind, (self.put(f"load {parts_of(kind)[0]}, ptr {address}, align 8, !tbaa {ALIAS[kind]}"),))

    def write(self, kind: Kind, address: str, value: Value) -> None:
        """Store a number in memory."""
        if kind == "i" and value.kind == "f":
            value = self.whole_number(value)
        part = self.converted(value, kind).parts[0]
        self.do(f"store {parts_of(kind)[0]} {part}, ptr {address}, align 8, !tbaa {ALIAS[kind]}")

    def whole_number(self, value: Value) -> Value:
        """A float without its fraction."""
        if self.careful:
            return Value("i", (self.called("i64", "llvm.fptosi.sat.i64.f64", [("double", value.parts[0])]),))
        return Value("i", (self.put(f"fptosi double {value.parts[0]} to i64"),))

    def check(self, index: str, size: str) -> None:
        """With RATTLE_BOUNDSCHECK=1, and in functions of users, an index outside of its array raises IndexError."""
        if not (self.unit.checks or self.careful):
            return
        told = f"index is out of bounds: {self.whereabouts()}"
        outside = self.put(f"icmp uge i64 {index}, {size}")
        self.fail_if(outside, self.fault(f"IndexError: {told}"))

    def whereabouts(self) -> str:
        """The present place in the sources, for messages."""
        return f"{self.function.__module__}.{self.function.__name__}, line {self.place}"

    def fault(self, told: str) -> str:
        """The instruction that tells Python of an error, as "class: message"."""
        self.unit.declare(FAULT, f'declare void @"{FAULT}"(ptr)')
        return f'call void @"{FAULT}"(ptr {self.unit.text(told)})'
