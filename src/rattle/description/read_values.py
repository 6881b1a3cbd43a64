"""Reading single values of a document - numbers, vectors, names, expressions - and collecting the problems."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import replace
from typing import Any, overload

from rattle.description.model import Value, Vector
from rattle.description.reading import Path, Place, Table, unforeseen_words
from rattle.errors import MOST, Problem, suggest
from rattle.language.expression import (
    RESERVED,
    Apply,
    ExpressionError,
    Name,
    Node,
    Number,
    argument_of,
    dimension,
    names,
    parse,
    replaced,
    require_finite,
    value,
    walk,
)
from rattle.language.materials import Material
from rattle.language.operation import Units
from rattle.language.operations import OPERATIONS
from rattle.language.recorded import as_number, bare
from rattle.language.syntax import CALL, KNOWN
from rattle.language.tables import NO_TABLES, Curve, Tables, tables_of
from rattle.language.units import (
    DIMENSIONLESS,
    TIME,
    UNITS,
    Dimension,
    QuantityError,
    describe,
    dimension_of,
    parse_quantity,
    unit_name,
)

Chosen = Callable[[float], float]  # makes of the value of a parameter [SI] the number that stands for it

MOST_CHARACTERS = 600_000  # of all expressions of a model, at most: two seconds of reading
# [SI]: products of a few numbers of a model stay numbers, see test_hostile_texts.py
SMALLEST, LARGEST = 1e-60, 1e60
RANGE = f"{SMALLEST:g} to {LARGEST:g} in SI units"
TAKEN = RESERVED | {"ground", "energy"}
LIMITS: Mapping[str, Callable[[float], bool]] = {"positive": lambda x: x > 0.0, "not negative": lambda x: x >= 0.0}


PLAIN = "#"  # stands for a function of a plain number in a formula
OF_NUMBERS = frozenset(record.name for record in OPERATIONS.values() if record.units is Units.PLAIN)


def _outside(node: Node) -> Node:
    """A formula with one name in place of every function of a plain number."""
    stack: list[Node] = []
    for part in walk(node):
        if isinstance(part, Apply):
            operands = tuple(stack[-len(part.operands) :])
            del stack[-len(part.operands) :]
            plain = part.name in OF_NUMBERS
            stack.append(Name(PLAIN, part.column) if plain else replace(part, operands=operands))
        else:
            stack.append(part)
    return stack[0]


def _functions(node: Node) -> list[Apply]:
    """Functions of plain numbers in a formula, outside of each other."""
    functions, waiting = [], [node]
    while waiting:
        part = waiting.pop()
        if isinstance(part, Apply) and part.name in OF_NUMBERS:
            functions.append(part)
        elif isinstance(part, Apply):
            waiting.extend(part.operands)
    return functions


class TooManyProblems(Exception):
    """Too many problems: reading stops."""


class Values:
    """The names known so far, with their values [SI] and dimensions, and the problems found so far.

    A reading method that finds a problem adds it to the list and returns nan (or None), so that reading continues.
    """

    def __init__(self, chosen: Mapping[str, Chosen] | None = None) -> None:
        self.chosen = chosen or {}
        self.problems: list[Problem] = []
        self.fault: Exception | None = None  # the first error that no reader has foreseen
        self.remarks: list[str] = []  # on values that may be mistakes
        self.characters = 0  # of the expressions read so far
        self.constants: dict[str, float] = {}  # parameters [SI]
        self.dimensions: dict[str, Dimension | None] = {}  # of parameters, signals and states
        self.live: dict[str, None] = {}  # names that change during a run, in the order of the file
        self.numbers: set[str] = set()  # live names that are plain numbers in a formula to which nobody gave units
        self.broken: set[str] = set()  # names whose own definition has a problem
        self.curves: dict[str, Curve] = {}  # tables
        self.tables: Tables = NO_TABLES  # the same
        self.broken_tables: set[str] = set()  # whose definition has a problem
        self.later_tables: set[str] = set()  # those that are read after the parameters
        self.materials: dict[str, Material] = {}  # of the model's own
        self.named_materials: dict[str, Material] = {}  # by the place at which a name stands for one
        self.broken_materials: set[str] = set()  # whose definition has a problem
        self.plays: dict[str, Any] = {}  # of joints by names of fits and bearings, see `read_play`; None: a problem
        self.local: dict[str, Node] = {}  # names of the field at hand, and what they stand for

    def wrong(self, path: Path, message: str, at_key: bool = False, column: int | None = None) -> None:
        """Add a problem to the list.  Raises TooManyProblems if there are very many."""
        self.problems.append(Problem(path, message, at_key, column))
        if len(self.problems) >= MOST:
            raise TooManyProblems

    def at(self, path: Path) -> Place:
        """While an entry or field is read: whatever goes wrong inside becomes a problem at this path."""
        return Place(path, self.wrong, self._unforeseen)

    def _unforeseen(self, path: Path, error: Exception) -> None:
        """Add the problem of an error that no reader has foreseen, unless it follows from another problem."""
        self.fault = self.fault or error
        if not self.problems:
            self.wrong(path, unforeseen_words(error))

    def set_constant(self, name: str, number: float, dimension: Dimension | None) -> None:
        """Enter a parameter with its value [SI]."""
        self.constants[name] = self.chosen[name](number) if name in self.chosen else number
        self.dimensions[name] = dimension

    def enter_table(self, name: str, curve: Curve | None) -> None:
        """Enter a table."""
        if curve is not None:
            self.curves[name] = curve
            self.tables = tables_of(self.curves)

    # ------------------------------------------------------------ tables and names
    def table(self, written: object, path: Path) -> Table:
        """A table; an empty one after a problem."""
        if isinstance(written, Mapping):
            return written
        self.wrong(path, f"expected a table, got {quoted(written)}")
        return {}

    def keys(self, table: Table, allowed: Iterable[str], path: Path) -> None:
        """Refuse unknown keys."""
        keys = list(allowed)
        for key in table:
            if key not in keys:
                self.wrong((*path, key), "unknown key" + suggest(key, keys), at_key=True)

    def name(self, name: str, path: Path) -> None:
        """Refuse names that cannot be used in expressions."""
        if not (name.isidentifier() and name.isascii()):
            self.wrong(
                path,
                f"{quoted(name)} is not a name; expected letters a-z, digits and _, not starting with a digit",
                at_key=True,
            )
        elif name in TAKEN:
            self.wrong(path, f"'{name}' is a reserved word; choose another name", at_key=True)

    @contextmanager
    def within(self, local: Mapping[str, tuple[Node, Dimension]]) -> Iterator[None]:
        """While a field is read, its expression may use these names too: what each stands for, and its dimension."""
        self.local = {name: node for name, (node, _) in local.items()}
        before = self.dimensions
        self.dimensions = {**before, **{name: dimension for name, (_, dimension) in local.items()}}
        try:
            yield
        finally:
            self.local, self.dimensions = {}, before

    # ------------------------------------------------------------ expressions
    def parse(self, text: str, path: Path) -> Node | None:
        """The tree of an expression; None after a problem."""
        self.characters += len(text)
        if self.characters > MOST_CHARACTERS:
            self.wrong(path, f"up to here the expressions have more than {MOST_CHARACTERS} characters in all")
            raise TooManyProblems
        try:
            node = parse(text, tables=(*self.curves, *self.broken_tables, *self.later_tables))
        except ExpressionError as error:
            self.in_expression(error, path)
            return None
        called = [part for part in walk(node) if isinstance(part, Apply) and part.name.endswith(CALL)]
        for part in called:
            name = part.name.removesuffix(CALL)
            if name in self.later_tables:
                said_of = f"the table '{name}' is made with parameters, so parameters cannot be made with it"
                self.wrong(path, said_of, column=part.column)
            if name not in self.curves:
                return None
        return node

    def in_expression(self, error: ExpressionError, path: Path) -> None:
        """Add the problem of an expression, with its column."""
        self.wrong(path, str(error), column=error.column)

    def expression(self, text: str, path: Path, unit: str | None, live: bool) -> Node | None:
        """Parse an expression, look up its names, check its dimension (any dimension if `unit` is None).

        live: `t`, state and signals are allowed.
        """
        node = self.parse(text, path)
        if node is None or not self.names_known(node, text, path, unit, live):
            return None
        if not self.dimension_fits(node, text, path, unit):
            return None
        return replaced(node, self.local) if self.local else node

    def units_are_clear(self, node: Node, path: Path) -> bool:
        """False if a word in the unit of a number is also a name of the model: "9.81 m/s^2*m" with a mass m."""
        for part in walk(node):
            if isinstance(part, Number):
                for word in sorted(part.others):
                    if word in self.constants or word in self.live or word in self.local:
                        either = f"in parentheses, as in (40 N)*{word}, for the name, or 40 Nm for the unit"
                        said_of = f"'{word}' in this unit is also a name of the model; write the quantity {either}"
                        self.wrong(path, said_of, column=part.column)
                        return False
        return True

    def names_known(self, node: Node, text: str, path: Path, unit: str | None, live: bool) -> bool:
        """True if every name is known and allowed here."""
        if not self.units_are_clear(node, path):
            return False
        spots = {part.name: part.column for part in reversed(walk(node)) if isinstance(part, Name)}
        for name in sorted(spots.keys() & self.local):
            if name in self.constants or name in self.live:
                kind = "parameter" if name in self.constants else "signal"
                self.wrong(path, f"here '{name}' has a meaning of its own; give the {kind} '{name}' another name")
                return False
        unknown = [name for name in sorted(spots) if not self._is_known(name, live)]
        for name in unknown:
            if self._is_known(name, live=True):
                only = " and ".join(["parameters", *self.local])
                what = f"'{name}' changes during the run; only {only} are allowed here"
            elif name not in self.broken:
                what = f"unknown name {quoted(name)} in {quoted(text)}{self._hint(name, text, path, unit, live)}"
            else:
                continue
            self.wrong(path, what, column=spots[name])
        return not unknown

    def _is_known(self, name: str, live: bool) -> bool:
        return name in self.constants or name in self.local or (live and (name == "t" or name in self.live))

    def _hint(self, name: str, text: str, path: Path, unit: str | None, live: bool) -> str:
        """What could stand instead of an unknown name."""
        if live and (own := ".".join([*map(str, path[1:2]), name])) in self.live:
            return f"; did you mean '{own}'?"
        hint = suggest(name, [*self.constants, *self.local, *(self.live if live else ())])
        if "did you mean" in hint:
            return hint
        if name in UNITS:
            return f"; {name} is a unit, which stands behind a number: 5 {name}"
        if "." in name:
            return f"; {KNOWN if live else 'only parameters are allowed here'}"
        if unit and text.strip() == name:
            return f"; expected {expected(unit)}: a quantity like '5 {unit}' or an expression"
        return hint

    def dimension_fits(self, node: Node, text: str, path: Path, unit: str | None) -> bool:
        """True if the dimension of an expression is consistent and is that of `unit` (any if None)."""
        try:
            seen = self.dimension(node, unit)
        except ExpressionError as error:
            self.in_expression(error, path)
            return False
        if unit is None or seen is None or seen == dimension_of(unit) or not self.has_units(node):
            return True
        self.wrong(path, f"{quoted(text)} is {describe(seen)}; expected {expected(unit)}")
        return False

    def has_units(self, node: Node) -> bool:
        """True if somebody gave units in a formula: to a number, a parameter, a state or a table.

        Others, such as `b.x - b.x**3` or `cos(w*t) - b.x`, are of plain numbers in SI units: an implied factor may have
        any unit, whether it is written or not.  Arguments of functions are formulas of their own.
        """
        for part in walk(_outside(node)):
            if isinstance(part, Number) and part.dimension is not None and not part.implied:
                return True
            if isinstance(part, Number) or (isinstance(part, Apply) and not part.name.endswith(CALL)):
                continue
            keys = (part.name, argument_of(part.name)) if isinstance(part, Apply) else (part.name,)
            if any(self.dimensions.get(key) is not None and key not in self.numbers for key in keys):
                return True
        return False

    def dimension(self, node: Node, unit: str | None = None) -> Dimension | None:
        """Dimension of an expression, None if unknown.  Raises ExpressionError if it is not consistent.

        It is unknown if there are only numbers and `t`: "sin(3*t)" may be any formula in SI units.  Beside names that
        have a dimension, `t` is a time, or the plain number of seconds if only that is consistent, as in "A*sin(t)".
        A formula without given units is of any dimension if it is not consistent, see `has_units`.
        """
        self._require_plain_arguments(node)
        outer = _outside(node)
        if all(self.dimensions.get(name) is None for name in names(outer)) and not self.has_units(node):
            return None
        try:
            seen = dimension(outer, self._dimension_of)
        except ExpressionError as error:
            if not self.has_units(node):
                return None
            with suppress(ExpressionError):
                return dimension(outer, self._dimension_of, DIMENSIONLESS if "t" in names(outer) else TIME)
            raise error from None
        if unit is None or seen is None or seen == dimension_of(unit) or "t" not in names(outer):
            return seen
        with suppress(ExpressionError):
            again = dimension(outer, self._dimension_of, DIMENSIONLESS)
            return again if again in (None, dimension_of(unit)) else seen
        return seen

    def _require_plain_arguments(self, node: Node) -> None:
        """Raise ExpressionError if a function of plain numbers is taken of something else."""
        for function in _functions(node):
            argument = function.operands[0]
            inside = self.dimension(argument, "rad")
            if inside is not None and inside != DIMENSIONLESS and self.has_units(argument):
                called = function.called or function.name
                raise ExpressionError(
                    f"cannot take {called} of {unit_name(inside)}; expected a plain number or angle", function.column
                )

    def _dimension_of(self, name: str) -> Dimension | None:
        return DIMENSIONLESS if name == PLAIN else self.dimensions.get(name)

    # ------------------------------------------------------------ numbers
    @overload
    def value(self, written: object, unit: str, path: Path, least: str = "") -> float: ...
    @overload
    def value(self, written: object, unit: str, path: Path, least: str, live: bool) -> float | Node: ...
    def value(self, written: object, unit: str, path: Path, least: str = "", live: bool = False) -> float | Node:
        """A float [SI], or a Node if `live` and the value changes during the run; nan after a problem."""
        number = self._number(written, unit, path, live)
        if number is None or isinstance(number, Node):
            return math.nan if number is None else number
        if fault := _fault(number, unit, least):
            self.wrong(path, f"{quoted(written)} {fault}")
            return math.nan
        if unit == "rad" and _is_bare(written) and abs(bare(number)) > 2.0 * math.pi:
            key = ".".join(str(part) for part in path)
            self.remarks.append(f'{key} = {number:g} is {number:g} rad; write "{number:g} deg" if degrees are meant')
        return number

    def _number(self, written: object, unit: str, path: Path, live: bool) -> float | Node | None:
        """Value [SI] of what stands for a number, before its limits are checked; None after a problem."""
        if isinstance(written, str):
            return self._text(written, unit, path, live)
        if isinstance(written, int | float) and not isinstance(written, bool):
            return _float(written)
        if callable(written):
            law = "write @rt.load_law(NAME) above it and give a load the type NAME"
            self.wrong(path, f"a Python function cannot stand for {expected(unit)}; {law}")
        else:
            like = f" as a number or a text like '5 {unit}'" if unit else ""
            self.wrong(path, f"expected {expected(unit)}{like}, got {quoted(written)}")
        return None

    def _text(self, text: str, unit: str, path: Path, live: bool) -> float | Node | None:
        """Value [SI] of a text, which is a quantity or an expression; None after a problem."""
        try:
            quantity = parse_quantity(text)
        except QuantityError as error:
            self.wrong(path, f"{error}; expected {expected(unit)}")
            return None
        if quantity is not None:
            number, seen = quantity
            if seen is None or seen == dimension_of(unit):
                return number
            self.wrong(path, f"{quoted(text)} is {describe(seen)}; expected {expected(unit)}")
            return None
        node = self.expression(text, path, unit, live)
        if node is None:
            return None
        if not names(node) <= self.constants.keys():
            return node if self.is_finite(node, path) else None
        return self.constant(node, path)

    def is_finite(self, node: Node, path: Path) -> bool:
        """False if a constant part of a live expression has no finite value."""
        try:
            require_finite(node, self.constants, self.tables)
        except ExpressionError as error:
            self.in_expression(error, path)
            return False
        return True

    def constant(self, node: Node, path: Path) -> float | None:
        """Value [SI] of an expression in parameters; None after a problem."""
        try:
            return value(node, self.constants, self.tables)
        except ExpressionError as error:
            self.in_expression(error, path)
            return None

    def any_number(self, written: object, path: Path) -> tuple[float, Dimension | None]:
        """A number of any unit [SI] and its dimension, None if it has none; nan after a problem."""
        if isinstance(written, str):
            try:
                quantity = parse_quantity(written)
            except QuantityError as error:
                self.wrong(path, str(error))
                return math.nan, None
            if quantity is not None:
                return quantity
            node = self.expression(written, path, None, live=False)
            number = self.constant(node, path) if node is not None else None
            return (math.nan, None) if node is None or number is None else (number, self.dimension(node))
        return self.value(written, "", path), None

    @overload
    def vector(self, written: object, unit: str, path: Path) -> Vector: ...
    @overload
    def vector(self, written: object, unit: str, path: Path, live: bool, least: str) -> tuple[Value, Value]: ...
    def vector(
        self, written: object, unit: str, path: Path, live: bool = False, least: str = ""
    ) -> tuple[Value, Value]:
        """Two values [SI]; if `live`, each may be a Node."""
        if not isinstance(written, list | tuple) or len(written) != 2:
            self.wrong(path, f"expected [x, y] in {unit}, got {quoted(written)}")
            return (math.nan, math.nan)
        x, y = (self.value(part, unit, (*path, k), least, live) for k, part in enumerate(written))
        return x, y

    def require_name(self, name: str, path: Path) -> None:
        """Note a key that is no name."""
        if not name.isidentifier():
            why = f"{quoted(name)} is not a name; expected letters, digits and _, not starting with a digit"
            self.wrong(path, why, at_key=True)

    def points(self, written: object, path: Path, live: bool) -> Mapping[str, tuple[Value, Value]]:
        """A table of named points [m]; if `live`, each coordinate may be a Node."""
        points = {}
        for name, at in self.table(written, path).items():
            self.require_name(name, (*path, name))
            points[name] = self.vector(at, "m", (*path, name), live, "")
        return points


def is_computable(number: float) -> bool:
    """True of a number [SI] whose products with a few others of its kind are numbers too."""
    return SMALLEST <= abs(bare(number)) <= LARGEST


def _float(number: float) -> float:
    try:
        return as_number(number)
    except OverflowError:
        return math.inf


def _fault(number: float, unit: str, least: str) -> str:
    """Why a number cannot be worked with, or is beyond its limit; "" if neither."""
    if not math.isfinite(bare(number)):
        return f"is not a finite number; expected {expected(unit)}"
    if abs(bare(number)) > LARGEST or (least and bare(number) != 0.0 and not is_computable(number)):
        return f"is beyond all numbers that can be computed with, {RANGE}"
    if least and not LIMITS[least](number):
        return f"must {'' if least == 'positive' else 'not '}be {least.removeprefix('not ')}"
    return ""


def _is_bare(written: object) -> bool:
    """True for a number that was written without a unit."""
    if not isinstance(written, str):
        return True
    quantity = parse_quantity(written)
    return quantity is not None and quantity[1] is None


def quoted(value: object) -> str:
    """A value as a message quotes it."""
    text = f"'{value}'" if isinstance(value, str) else ("a table" if isinstance(value, Mapping) else _plain(value))
    return text if len(text) <= 60 else text[:57] + "..."


def _plain(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int) and value.bit_length() > 200:
        return "a huge number"
    return str(value)


def expected(unit: str) -> str:
    """What a field takes, for messages: "a length in m", "a plain number"."""
    if not unit:
        return "a plain number"
    name = describe(dimension_of(unit))
    return f"a quantity in {unit}" if name.startswith("a quantity in") else f"{name} in {unit}"
