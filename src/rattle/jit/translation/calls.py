"""Calls of one kernel by another, in LLVM's language."""

from __future__ import annotations

import ast
from collections.abc import Sequence
from typing import Any

from rattle.jit import families, functions, machine
from rattle.jit.translation.expressions import SAID, Expressions
from rattle.jit.translation.values import NOTHING, TranslationError, Value, is_array, members, parts_of, said
from rattle.jit.translation.writing import CALLER

LETTERS = {"f": "f", "i": "i", "h": "h", "v": "f1", "m": "f2", "w": "i1", "n": "i2", "b": "b"}  # kinds of arguments


def kinds_of(letters: Sequence[str]) -> tuple[Any, tuple[Any, ...]]:
    """The kinds of the result and of the arguments, from their letters, see `families.SIGNATURE`."""
    result, *given = letters
    if result == "void":
        found: Any = NOTHING
    else:
        found = LETTERS[result] if len(result) == 1 else tuple(LETTERS[one] for one in result)
    return found, tuple(LETTERS[one] for one in given)


def letters_of(result: Any, kinds: Sequence[Any]) -> tuple[str, ...]:
    """The letters of the result and of the arguments.  Raises TranslationError for a result that is an array."""
    letters = {kind: letter for letter, kind in LETTERS.items()}
    several = result if isinstance(result, tuple) else (result,) if result else ()
    if any(one not in ("f", "i", "b") for one in several):
        raise TranslationError(f"it returns {said(result)}, which cannot be passed to Python")
    return "".join(several) or "void", *(letters[one] for one in kinds)


def structure(kind: Any) -> str:
    """LLVM's type of a result that is left at a place for it."""
    return f"{{ {', '.join('i8' if one == 'i1' else one for one in parts_of(kind))} }}"


class Calls(Expressions):
    """What turns calls of compiled functions into instructions."""

    def kernel(self, called: Any, given: list[Value], node: ast.Call) -> Value:
        """The result of another compiled function."""
        family = next((name for name, one in families.CALLERS.items() if one is called), "")
        if family and len(given) == 2 and isinstance(given[1].kind, tuple):
            return self._of_table(family, given[0], members(given[1]))
        if not isinstance(called, functions.KernelFunction) or not called.ours:
            raise TranslationError(f"'{ast.unparse(node)}': {called!r} is no compiled function; {SAID}")
        if called.native:
            name = f'@"{called.symbol}"'
            self.unit.declare(called.symbol, f"{name} = external global i64")
            return self._at(self._found(name), called.letters, given, fails=True)
        return self._inside(called, given)

    def _inside(self, called: Any, given: list[Value]) -> Value:
        """Call of a function of the same unit."""
        name, result, fails = self.unit.part(called, [one.kind for one in given])
        arguments = [f"ptr {CALLER}"]
        for one in given:
            arguments += [f"{type_} {part}" for type_, part in zip(parts_of(one.kind), one.parts, strict=True)]
        whole = f"{{ {', '.join(['i32', *parts_of(result)])} }}"
        found = self.put(f'call {whole} @"{name}"({", ".join(arguments)})')
        if fails:
            status = self.put(f"extractvalue {whole} {found}, 0")
            self.fail_if(self.put(f"icmp ne i32 {status}, 0"))
        some = (f"extractvalue {whole} {found}, {n + 1}" for n, _ in enumerate(parts_of(result)))
        return Value(result, tuple(self.put(one) for one in some))

    def _of_table(self, family: str, entry: Value, given: list[Value]) -> Value:
        """Call of a kernel at an address from a table, or at a place that holds its address."""
        address = self.converted(entry, "i").parts[0]
        by_place = family in families.BY_PLACE
        if by_place:
            address = self._found(self.put(f"inttoptr i64 {address} to ptr"))
        else:
            said = f"a kernel of the family '{family}' was called, but it is not in the table of this workspace"
            none = self.put(f"icmp eq i64 {address}, 0")
            self.fail_if(none, self.fault(f"RuntimeError: {said}"))
        return self._at(address, families.SIGNATURE[family], given, fails=by_place)

    def _found(self, place: str) -> str:
        """The address at a place; it is requested if there is none yet."""
        known = self.put(f"load i64, ptr {place}")
        asked, done = self.label(), self.label()
        missing = self.put(f"icmp eq i64 {known}, 0")
        self.keep((place, "address"), Value("i", (known,)))
        self.do(f"br i1 {missing}, label %{asked}, label %{done}, !prof !5")
        self.begin(asked)
        made = self.called("i64", machine.FIND, [("i64", self.put(f"ptrtoint ptr {place} to i64"))])
        self.fail_if(self.put(f"icmp eq i64 {made}, 0"))
        self.keep((place, "address"), Value("i", (made,)))
        self.jump(done)
        self.begin(done)
        return self.kept((place, "address")).parts[0]

    def _at(self, address: str, letters: Sequence[str], given: list[Value], fails: bool) -> Value:
        """Call of the function at an address, with Numba's convention; what it fails with is passed on if `fails`."""
        result, wanted = kinds_of(letters)
        if len(wanted) != len(given):
            raise TranslationError(f"{len(wanted)} arguments are expected, {len(given)} are given")
        room = f"%r{len(self.rooms)}"
        self.rooms.append(structure(result))
        arguments = [("ptr", room), ("ptr", CALLER)]
        for kind, one in zip(wanted, given, strict=True):
            if is_array(kind):
                if one.kind != kind:
                    raise TranslationError(f"{said(one.kind)} where {said(kind)} is needed")
                arguments += self.flat(one)
            else:
                arguments += zip(parts_of(kind), self.converted(one, kind).parts, strict=True)
        target = self.put(f"inttoptr i64 {address} to ptr")
        status = self.put(f"call i32 {target}({', '.join(' '.join(one) for one in arguments)})")
        if fails:
            bad = (self.put(f"icmp ne i32 {status}, {one}") for one in machine.FINE)
            self.fail_if(self.put(f"and i1 {next(bad)}, {next(bad)}"))
        found = []
        for n, type_ in enumerate(parts_of(result)):
            at = self.put(f"getelementptr {structure(result)}, ptr {room}, i32 0, i32 {n}")
            found.append(self.put(f"load {type_}, ptr {at}"))
        return Value(result, tuple(found))
