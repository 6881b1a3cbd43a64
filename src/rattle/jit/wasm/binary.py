"""WebAssembly modules as bytes: sections are read, chosen and written, and an object of LLVM becomes a whole module.

LLVM leaves an object whose code and data are numbered as if nothing else were linked to it: functions from the first
import on, entries of the table from 1, memory from 0.  So an object that needs nothing from outside becomes a module
without relocation: what it imports for the linker (memory, table, stack pointer) is defined instead, each being the
only one of its kind, and what only a linker reads is left out.

Source: WebAssembly Core Specification 2.0, chapter 5 (binary format); Tool Conventions, Linking.md (section `linking`).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import NamedTuple

MAGIC = b"\0asm\1\0\0\0"
PAGE = 65536  # bytes of a page of memory
CUSTOM, TYPE, IMPORT, FUNCTION, TABLE, MEMORY, GLOBAL, EXPORT, START, ELEMENT, CODE, DATA, DATA_COUNT = range(13)
ORDER = (TYPE, IMPORT, FUNCTION, TABLE, MEMORY, GLOBAL, EXPORT, START, ELEMENT, DATA_COUNT, CODE, DATA, CUSTOM)
OF_FUNCTION, OF_TABLE, OF_MEMORY, OF_GLOBAL = range(4)  # kinds of imports and exports
FUNCREF, I32, IMMUTABLE, MUTABLE, I32_CONST, END = 0x70, 0x7F, 0, 1, 0x41, 0x0B
SYMBOL_TABLE = 8  # in the section `linking`
NOT_DEFINED, NAMED, ABSOLUTE = 0x10, 0x40, 0x200  # flags of a symbol


class BrokenModule(ValueError):
    """Bytes that are no WebAssembly module, or an object that cannot become a whole one; the message says why."""


class Section(NamedTuple):
    """One section of a module."""

    kind: int
    body: bytes


class Symbol(NamedTuple):
    """A symbol of an object: a function by its number, or data by its place in memory."""

    kind: int  # 0 function, 1 data
    value: int


# ---------------------------------------------------------------- numbers
def unsigned(n: int) -> bytes:
    """A number that is not negative, in LEB128."""
    written = bytearray()
    while True:
        low, n = n & 0x7F, n >> 7
        written.append(low | 0x80 if n else low)
        if not n:
            return bytes(written)


def signed(n: int) -> bytes:
    """A number in signed LEB128."""
    written = bytearray()
    while True:
        low, n = n & 0x7F, n >> 7
        last = (n == 0 and not low & 0x40) or (n == -1 and bool(low & 0x40))
        written.append(low if last else low | 0x80)
        if last:
            return bytes(written)


def sized(body: bytes) -> bytes:
    """Bytes after their number."""
    return unsigned(len(body)) + body


def listed(items: Iterable[bytes]) -> bytes:
    """Items after their number."""
    every = list(items)
    return unsigned(len(every)) + b"".join(every)


class Reader:
    """Bytes that are read from the first on.  Raises BrokenModule where they end too early."""

    def __init__(self, content: bytes) -> None:
        self.content, self.at = content, 0

    def __bool__(self) -> bool:
        return self.at < len(self.content)

    def byte(self) -> int:
        """The next byte."""
        return self.take(1)[0]

    def take(self, count: int) -> bytes:
        """The next bytes."""
        if self.at + count > len(self.content):
            raise BrokenModule("a WebAssembly module ends too early")
        self.at += count
        return self.content[self.at - count : self.at]

    def unsigned(self) -> int:
        """A number that is not negative."""
        value = shift = 0
        while True:
            byte = self.byte()
            value |= (byte & 0x7F) << shift
            shift += 7
            if byte < 0x80:
                return value
            if shift > 63:
                raise BrokenModule("a number of a WebAssembly module is too long")

    def signed(self) -> int:
        """A number."""
        start = self.at
        value = self.unsigned()
        bits = 7 * (self.at - start)
        return value - (1 << bits) if value >> (bits - 1) & 1 else value

    def sized(self) -> bytes:
        """Bytes after their number."""
        return self.take(self.unsigned())

    def name(self) -> str:
        """A name."""
        return self.sized().decode()

    def constant(self) -> int:
        """The value of an expression that is a constant of 32 bits."""
        if self.byte() != I32_CONST:
            raise BrokenModule("an offset of a WebAssembly module is no constant")
        value = self.signed()
        if self.byte() != END:
            raise BrokenModule("an offset of a WebAssembly module is no constant")
        return value


# ---------------------------------------------------------------- sections
def sections(module: bytes) -> Iterator[Section]:
    """The sections of a module.  Raises BrokenModule where it is none, or where they are out of order."""
    if module[: len(MAGIC)] != MAGIC:
        raise BrokenModule("these bytes are no WebAssembly module")
    reader, last = Reader(module[len(MAGIC) :]), -1
    while reader:
        section = Section(reader.byte(), reader.sized())
        if section.kind not in ORDER:
            raise BrokenModule(f"a WebAssembly module has a section of the unknown kind {section.kind}")
        if section.kind != CUSTOM:
            if ORDER.index(section.kind) <= last:
                raise BrokenModule("the sections of a WebAssembly module are out of order")
            last = ORDER.index(section.kind)
        yield section


def written(parts: Iterable[Section]) -> bytes:
    """A module of these sections."""
    return MAGIC + b"".join(bytes([part.kind]) + sized(part.body) for part in parts)


def custom(name: str, content: bytes) -> Section:
    """A section that the machine ignores."""
    return Section(CUSTOM, sized(name.encode()) + content)


def custom_sections(module: bytes) -> dict[str, bytes]:
    """What stands in the sections that the machine ignores, by name."""
    sections_by_name = {}
    for section in sections(module):
        if section.kind == CUSTOM:
            reader = Reader(section.body)
            name = reader.name()
            sections_by_name[name] = reader.content[reader.at :]
    return sections_by_name


def imports(module: bytes) -> list[tuple[str, int]]:
    """Names and kinds of what a module needs from outside."""
    entries = []
    for body in (section.body for section in sections(module) if section.kind == IMPORT):
        reader = Reader(body)
        for _ in range(reader.unsigned()):
            reader.name()  # of a module
            name, kind = reader.name(), reader.byte()
            entries.append((name, kind))
            if kind == OF_FUNCTION:
                reader.unsigned()
            elif kind == OF_GLOBAL:
                reader.take(2)
            else:
                if kind == OF_TABLE:
                    reader.byte()
                _limits(reader)
    return entries


def _limits(reader: Reader) -> tuple[int, int]:
    bounded = reader.byte() & 1
    least = reader.unsigned()
    return least, reader.unsigned() if bounded else least


def exports(module: bytes) -> list[str]:
    """Names of what a module offers."""
    entries = []
    for body in (section.body for section in sections(module) if section.kind == EXPORT):
        reader = Reader(body)
        for _ in range(reader.unsigned()):
            entries.append(reader.name())
            reader.byte()
            reader.unsigned()
    return entries


def segments(body: bytes) -> list[tuple[int, bytes]]:
    """Pieces of memory of a section of data: where each begins, and its bytes."""
    reader, entries = Reader(body), []
    for _ in range(reader.unsigned()):
        if reader.unsigned() != 0:
            raise BrokenModule("a piece of data of a WebAssembly module has no place")
        entries.append((reader.constant(), reader.sized()))
    return entries


def symbols(linking: bytes, pieces: list[tuple[int, bytes]]) -> dict[str, Symbol]:
    """Functions and data that an object defines, by name; linking: its section of that name."""
    reader, table = Reader(linking), {}
    reader.unsigned()  # version
    while reader:
        kind, part = reader.unsigned(), Reader(reader.sized())
        if kind != SYMBOL_TABLE:
            continue
        for _ in range(part.unsigned()):
            what, flags = part.byte(), part.unsigned()
            if what == 1:
                name = part.name()
                if not flags & NOT_DEFINED:
                    piece, offset, _ = part.unsigned(), part.unsigned(), part.unsigned()
                    table[name] = Symbol(1, offset if flags & ABSOLUTE else pieces[piece][0] + offset)
            elif what == 3:
                part.unsigned()
            else:
                number = part.unsigned()
                if not flags & NOT_DEFINED or flags & NAMED:
                    name = part.name()
                    if what == 0 and not flags & NOT_DEFINED:
                        table[name] = Symbol(0, number)
    return table


# ---------------------------------------------------------------- from an object to a module
class Linked(NamedTuple):
    """An object of LLVM that needs nothing from outside, taken apart."""

    parts: Mapping[int, bytes]  # sections by kind
    symbols: Mapping[str, Symbol]
    memory: bytes  # of its data, from address 0

    def word(self, place: int) -> int:
        """A number of four bytes in memory."""
        return int.from_bytes(self.memory[place : place + 4], "little")


def linked(object_code: bytes) -> Linked:
    """An object of LLVM taken apart.  Raises BrokenModule, with their names, for functions that it does not have."""
    missing = sorted(name for name, kind in imports(object_code) if kind == OF_FUNCTION)
    if missing:
        raise BrokenModule(f"functions are needed from outside: {', '.join(missing)}")
    parts = {section.kind: section.body for section in sections(object_code) if section.kind != CUSTOM}
    pieces = segments(parts.get(DATA, b"\0"))
    memory = bytearray(max([start + len(piece) for start, piece in pieces], default=0))
    for start, piece in pieces:
        memory[start : start + len(piece)] = piece
    return Linked(parts, symbols(custom_sections(object_code)["linking"], pieces), bytes(memory))


def top(linked_module: Linked, stack: int) -> int:
    """The first free place in the memory of a module, behind its data and a stack of so many bytes."""
    return -(-(len(linked_module.memory) + stack) // 16) * 16


def module(linked_module: Linked, offered: Mapping[str, str], stack: int, extra: Iterable[Section]) -> bytes:
    """The module that offers its memory and these functions, names by symbols.

    stack: its size in bytes; it is filled from its end.
    """
    end = top(linked_module, stack)
    pages = -(-end // PAGE)
    elements = Reader(linked_module.parts.get(ELEMENT, b"\0"))
    entries = 1  # the first stands for no function
    for _ in range(elements.unsigned()):
        if elements.unsigned() != 0:
            raise BrokenModule("entries of the table of a WebAssembly module have no place")
        entries = max(entries, elements.constant() + (count := elements.unsigned()))
        for _ in range(count):
            elements.unsigned()
    numbers = ((name, linked_module.symbols[symbol].value) for name, symbol in sorted(offered.items()))
    functions = [sized(name.encode()) + bytes([OF_FUNCTION]) + unsigned(number) for name, number in numbers]
    offers = [sized(b"memory") + bytes([OF_MEMORY]) + unsigned(0), *functions]
    data = listed([b"\0" + _placed(0) + sized(linked_module.memory)])
    own = {
        TABLE: listed([bytes([FUNCREF, 1]) + unsigned(entries) + unsigned(entries)]),
        MEMORY: listed([b"\0" + unsigned(pages)]),
        GLOBAL: listed([bytes([I32, MUTABLE]) + _placed(end)]),
        EXPORT: listed(offers),
        DATA: data,
    }
    kept = {kind: body for kind, body in linked_module.parts.items() if kind not in (IMPORT, DATA_COUNT)} | own
    ordered = [Section(kind, kept[kind]) for kind in ORDER if kind in kept]
    return written([*ordered, *extra])


def _placed(value: int) -> bytes:
    return bytes([I32_CONST]) + signed(value) + bytes([END])
