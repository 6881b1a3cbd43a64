"""Calls of one kernel by another, in LLVM's language."""

from __future__ import annotations

import ast
from collections.abc import Sequence
from typing import Any

from rattle.jit import families, functions, machine
from rattle.jit.families import Kind
from rattle.jit.translation.expressions import SAID, Expressions
from rattle.jit.translation.local_arrays import LocalArrays
from rattle.jit.translation.values import (
    NOTHING,
    Record,
    TranslationError,
    Value,
    is_array,
    is_number,
    members,
    parts_of,
    python_function,
    said,
)

# kinds of arguments
LETTERS: dict[str, Kind] = {"f": "f", "i": "i", "h": "h", "v": "f1", "m": "f2", "w": "i1", "n": "i2", "b": "b"}


def kinds_of(letters: Sequence[Any]) -> tuple[Kind, tuple[Kind, ...]]:
    """The kinds of the result and of the arguments, from their letters, see `families.SIGNATURE`.

    A result may also be given by its kind: a tuple.
    """
    result, *arguments = letters
    if result == "void":
        kind: Kind = NOTHING
    elif isinstance(result, tuple):
        kind = result
    else:
        kind = LETTERS[result] if len(result) == 1 else tuple(LETTERS[letter] for letter in result)
    return kind, tuple(LETTERS[letter] for letter in arguments)


def letters_of(result: Kind, kinds: Sequence[Kind]) -> tuple[str, ...]:
    """The letters of the result and of the arguments.  Raises TranslationError for a result that is an array."""
    letters = {kind: letter for letter, kind in LETTERS.items()}
    several = result if isinstance(result, tuple) else (result,) if result else ()
    if not all(map(is_number, several)):
        raise TranslationError(f"it returns {said(result)}, which cannot be passed to Python")
    return "".join(letters[kind] for kind in several) or "void", *(letters[kind] for kind in kinds)


def structure(kind: Kind) -> str:
    """LLVM's type of a result that is left at a place for it."""
    return f"{{ {', '.join('i8' if part == 'i1' else part for part in parts_of(kind))} }}"


class Calls(LocalArrays, Expressions):
    """What turns calls of compiled functions into instructions."""

    def kernel(self, called: object, arguments: list[Value], node: ast.Call) -> Value:
        """The result of another compiled function, of a function of the user or of one from outside."""
        family = next((name for name, caller in families.CALLERS.items() if caller is called), "")
        if family and len(arguments) == 2 and isinstance(arguments[1].kind, tuple):
            return self._of_table(family, arguments[0], members(arguments[1]))
        if isinstance(called, machine.Entry):
            return self._at(str(called.address), called.letters, flattened(arguments))
        if isinstance(called, type) and issubclass(called, tuple) and hasattr(called, "_fields"):
            packed = self.together(arguments)
            return Value(Record(packed.kind, called._fields), packed.parts)
        if isinstance(called, functions.KernelFunction) and called.native:
            name = f'@"{called.symbol}"'
            self.unit.declare(called.symbol, f"{name} = external global i64")
            return self._at(self._found(name), called.letters, arguments)
        if not isinstance(called, functions.KernelFunction) and python_function(called) is None:
            raise TranslationError(f"'{ast.unparse(node)}': {called!r} is no compiled function; {SAID}")
        return self._inside(called, arguments)

    def _inside(self, called: object, values: list[Value]) -> Value:
        """Call of a function of the same unit."""
        name, result, fails = self.unit.part(called, [value.kind for value in values])
        arguments = [
            f"{type_} {part}" for value in values for type_, part in zip(parts_of(value.kind), value.parts, strict=True)
        ]
        whole = f"{{ {', '.join(['i32', *parts_of(result)])} }}"
        returned = self.put(f'call {whole} @"{name}"({", ".join(arguments)})')
        if fails:
            status = self.put(f"extractvalue {whole} {returned}, 0")
            self.fail_if(self.put(f"icmp ne i32 {status}, 0"))
        some = (f"extractvalue {whole} {returned}, {n + 1}" for n, _ in enumerate(parts_of(result)))
        return Value(result, tuple(self.put(instruction) for instruction in some))

    def _of_table(self, family: str, entry: Value, arguments: list[Value]) -> Value:
        """Call of a kernel at an address from a table, or at a place that holds its address."""
        address = self.converted(entry, "i").parts[0]
        if family in families.BY_PLACE:
            address = self._found(self.put(f"inttoptr i64 {address} to ptr"))
        return self._at(address, families.SIGNATURE[family], arguments)

    def _found(self, place: str) -> str:
        """The address at a place; it is requested if there is none yet."""
        address = self.put(f"load i64, ptr {place}")
        asked, done = self.label(), self.label()
        missing = self.put(f"icmp eq i64 {address}, 0")
        self.keep((place, "address"), Value("i", (address,)))
        self.do(f"br i1 {missing}, label %{asked}, label %{done}, !prof !5")
        self.begin(asked)
        address = self.called("i64", machine.FIND, [("i64", self.put(f"ptrtoint ptr {place} to i64"))])
        self.keep((place, "address"), Value("i", (address,)))
        self.jump(done)
        self.begin(done)
        return self.kept((place, "address")).parts[0]

    def _at(self, address: str, letters: Sequence[Kind], values: list[Value]) -> Value:
        """Call of the function at an address; what it fails with is passed on."""
        result, wanted = kinds_of(letters)
        if len(wanted) != len(values):
            raise TranslationError(f"{len(wanted)} arguments are expected, {len(values)} are given")
        room = self.room(structure(result))
        arguments = [f"ptr {room}"]
        for kind, value in zip(wanted, values, strict=True):
            if is_array(kind) and value.kind != kind:
                raise TranslationError(f"{said(value.kind)} where {said(kind)} is needed")
            parts = self.converted(value, kind).parts
            arguments += [f"{type_} {part}" for type_, part in zip(parts_of(kind), parts, strict=True)]
        target = self.put(f"inttoptr i64 {address} to ptr")
        status = self.put(f"call i32 {target}({', '.join(arguments)})")
        self.fail_if(self.put(f"icmp ne i32 {status}, 0"))
        results = []
        for n, type_ in enumerate(parts_of(result)):
            at = self.put(f"getelementptr {structure(result)}, ptr {room}, i32 0, i32 {n}")
            results.append(self.put(f"load {type_}, ptr {at}"))
        return Value(result, tuple(results))


def flattened(values: Sequence[Value]) -> list[Value]:
    """Values with the members of tuples in their places."""
    return [
        part for value in values for part in (flattened(members(value)) if isinstance(value.kind, tuple) else [value])
    ]
