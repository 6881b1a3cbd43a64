"""Reading the fields of kinds and tables: what the user wrote, or the default."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any, TypeVar

from rattle import registry
from rattle.description.model import Vector
from rattle.description.polygon import MOST_CORNERS, fault
from rattle.description.read_values import Values, quoted
from rattle.description.reading import Path, Table
from rattle.description.tables import Either, Form, Part
from rattle.errors import shown, suggest
from rattle.language.expression import ExpressionError, Name, Node, Number
from rattle.language.local_function import LocalFunction, local_function
from rattle.language.units import QuantityError, dimension_of, parse_quantity
from rattle.registry import REQUIRED, Field

Leaf = TypeVar("Leaf")


class FieldReader:
    """Reads kinds and their fields; problems are collected in `values`."""

    def __init__(self, values: Values) -> None:
        self.values = values

    def choose(self, table: Table, kinds: Mapping[str, registry.Kind[Leaf]], path: Path) -> registry.Kind[Leaf] | None:
        """The kind of those of a family that an entry names as its type; None after a problem."""
        if "type" not in table:
            self.values.wrong(path, "needs a type: " + ", ".join(kinds))
            return None
        name = table["type"]
        if isinstance(name, str) and name in kinds:
            return kinds[name]
        family = next(iter(kinds.values())).family
        self.values.wrong((*path, "type"), f"unknown {family} {quoted(name)}{suggest(str(name), kinds)}")
        return None

    def field(self, field: Field, key: str, table: Table, read: Mapping[str, Any], path: Path) -> Any:
        """One field of a kind or table [SI], as the user wrote it or its default; nan or None after a problem."""
        here = (*path, key)
        if key not in table and field.default is REQUIRED:
            unit = f" [{field.unit}]" if field.unit else ""
            self.values.wrong(path, field.missing or f"needs {key}: {field.meaning}{unit}")
            return (math.nan,) * MANY[field.shape] if field.shape in MANY else math.nan
        if key not in table:
            default = field.default(read) if callable(field.default) else field.default
            if field.function_of:
                return read_function(self.values, default, field, here)
            if field.shape == "flag":
                return float(default)
            return float(field.choices.index(default)) if field.shape == "choice" else default
        if field.function_of:
            return read_function(self.values, table[key], field, here)
        if field.shape in SHAPES:
            return SHAPES[field.shape](self.values, field, table[key], here)
        return self.values.value(table[key], field.unit, here, field.least, field.live)

    def fields(
        self, kind: registry.Kind[object], table: Table, path: Path, unit: Callable[[str], str] = str
    ) -> dict[str, float]:
        """All fields of a kind [SI], in the order of its declaration; unit: what a unit of a field is here."""
        read: dict[str, float] = {}
        for key, field in kind.fields.items():
            read[key] = math.nan
            with self.values.at((*path, key)):
                read[key] = self.field(replace(field, unit=unit(field.unit)), key, table, read, path)
        return read

    def form(self, form: Form, table: Table, path: Path) -> dict[str, Any]:
        """All fields of a table [SI], in the order of its keys; unknown keys are refused.

        Those of its ways are read where they are written; what is no field, or of a shape in OWN, is left to its own
        reader, see `part`.
        """
        self.values.keys(table, form.keys, path)
        return self.read(form, table, path)

    def read(self, form: Form, table: Table, path: Path) -> dict[str, Any]:
        """As `form`, of a table whose keys were looked at before."""
        read: dict[str, Any] = {}
        for key, field in form.keys.items():
            if isinstance(field, Field) and field.shape not in OWN and (key in form.fields or key in table):
                read[key] = self.field(field, key, table, read, path)
        return read

    def part(self, part: Part, key: str, table: Table, path: Path) -> Any:
        """A key [SI] that may be written in one of several forms, or is a table; None if it is not there."""
        if key not in table:
            return None
        if isinstance(part, Form):
            return self.form(part, self.values.table(table[key], (*path, key)), (*path, key))
        if isinstance(part, Either):
            looks = next((form for form in part.forms if _is_of(form, table[key])), None)
            return self.part(looks or _of_numbers(part), key, table, path)
        assert isinstance(part, Field), "names and kinds have readers of their own"
        return self.field(part, key, table, {}, path)


def _is_of(form: Part, written: object) -> bool:
    """True if something is written as is usual in this form; numbers, which look in any way, are not asked."""
    if isinstance(form, Form):
        return isinstance(written, Mapping)
    if isinstance(form, Field) and form.shape == "each":
        return isinstance(written, list | tuple)
    if isinstance(form, Field) and form.shape == "constant":
        return isinstance(written, str) and written in form.choices
    return False


def _of_numbers(part: Either) -> Part:
    """The form that reads a number, and refuses what is of no form; the first one if none does."""
    fields = (form for form in part.forms if isinstance(form, Field) and form.shape not in ("constant", "each"))
    return next(fields, part.forms[0])


# ---------------------------------------------------------------- shapes of fields
def _choice(values: Values, field: Field, written: object, path: Path) -> float:
    """The number of a word among the choices; nan after a problem."""
    word = field.flags[written] if field.flags and isinstance(written, bool) else written
    if word in field.choices:
        return float(field.choices.index(word))
    hint = suggest(str(written), field.choices)
    values.wrong(path, f"expected one of {', '.join(field.choices)}, got {quoted(written)}{hint}")
    return math.nan


def _flag(values: Values, field: Field, written: object, path: Path) -> float:
    if not isinstance(written, bool):
        values.wrong(path, f"expected true or false, got {quoted(written)}")
    return float(written is True)


def _names(values: Values, field: Field, written: object, path: Path) -> tuple[str, str] | None:
    """Two names of points; None after a problem."""
    two = _texts(values, field, written, path)
    if two is not None and not all(text.isidentifier() for text in two):
        values.wrong(path, f"expected {field.like}, got {quoted(written)}")
        return None
    return two


def _texts(values: Values, field: Field, written: object, path: Path) -> tuple[str, str] | None:
    """Two texts; None after a problem."""
    if not isinstance(written, list | tuple) or len(written) != 2 or not all(isinstance(text, str) for text in written):
        values.wrong(path, f"expected {field.like}, got {quoted(written)}")
        return None
    return written[0], written[1]


def _labels(values: Values, field: Field, written: object, path: Path) -> tuple[str, ...]:
    """Different names; none after a problem."""
    if (
        not isinstance(written, list | tuple)
        or len(written) < field.fewest
        or not all(isinstance(label, str) for label in written)
    ):
        values.wrong(path, f"expected {field.like}, got {quoted(written)}")
        return ()
    if twice := next((label for n, label in enumerate(written) if label in written[:n]), ""):
        values.wrong(path, f"{quoted(twice)} is named twice")
        return ()
    return tuple(written)


def _text(values: Values, field: Field, written: object, path: Path) -> str:
    """A text for people, on one line; "" after a problem."""
    if not isinstance(written, str):
        values.wrong(path, f"{quoted(written)} is no text; write words in quotes")
        return ""
    text = " ".join(written.split())
    if field.longest and len(text) > field.longest:
        what = f"{len(text)} characters are too long for a {path[-1]}, {field.longest} at most"
        values.wrong(path, what)
    return text


def _ring(values: Values, field: Field, written: object, path: Path) -> list[Vector]:
    """Corners [m] in order around; none after a problem."""
    if not isinstance(written, list | tuple):
        values.wrong(path, f"expected corners in order around, [[x, y], [x, y], [x, y]], got {quoted(written)}")
        return []
    before = len(values.problems)
    corners = [values.vector(corner, "m", (*path, k)) for k, corner in enumerate(written[: MOST_CORNERS + 1])]
    if len(values.problems) == before and len(corners) <= MOST_CORNERS and (wrong := fault(corners)):
        values.wrong(path, wrong)
    return corners if len(values.problems) == before else []


def _rings(values: Values, field: Field, written: object, path: Path) -> list[list[Vector]] | None:
    """The corners of every hole [m]; None after a problem."""
    if not isinstance(written, list | tuple) or not all(isinstance(ring, list | tuple) for ring in written):
        values.wrong(path, f"expected a list of holes, each a list of corners [x, y], got {quoted(written)}")
        return None
    rings = [_ring(values, field, ring, (*path, k)) for k, ring in enumerate(written)]
    return rings if all(rings) else None


def _cuts(values: Values, field: Field, written: object, path: Path) -> dict[str, tuple[Vector, Vector]]:
    """Both ends of every cut [m], by name; without those that have a problem."""
    cuts = {}
    for name, ends in values.table(written, path).items():
        values.require_name(name, (*path, name))
        if not isinstance(ends, list | tuple) or len(ends) != 2:
            values.wrong((*path, name), f"expected two points, [[x, y], [x, y]], got {quoted(ends)}")
            continue
        before = len(values.problems)
        first, second = (values.vector(end, field.unit, (*path, name, k)) for k, end in enumerate(ends))
        if len(values.problems) == before:
            cuts[name] = (first, second)
    return cuts


def _word(words: str, names: Callable[[], Iterable[str]]) -> Callable[[Values, Field, object, Path], str]:
    """A reader of one of some names, "" after a problem; words: what they are names of."""

    def read(values: Values, field: Field, written: object, path: Path) -> str:
        choices = list(names())
        if isinstance(written, str) and written in choices:
            return written
        values.wrong(path, f"unknown {words} {quoted(written)}{suggest(str(written), choices)}")
        return ""

    return read


def geometries() -> list[str]:
    """Names of the formulas for the stiffness from materials: all laws but that of a given stiffness."""
    return [name for name in registry.kinds("stiffness") if name != "power"]


def _constant(values: Values, field: Field, written: object, path: Path) -> float:
    """A word in place of a number: nan."""
    return math.nan


def _triple(values: Values, field: Field, written: object, path: Path) -> tuple[float, ...]:
    """Three numbers [SI], along x, along y and of the angle; nan after a problem."""
    units = (field.unit, field.unit, field.turning)
    if not isinstance(written, list | tuple) or len(written) != len(units):
        values.wrong(path, f"expected [x, y, angle] in {', '.join(units)}, got {quoted(written)}")
        return (math.nan,) * len(units)
    parts = zip(written, units, strict=True)
    return tuple(values.value(part, unit, (*path, n), field.least) for n, (part, unit) in enumerate(parts))


def _each(values: Values, field: Field, written: object, path: Path) -> list[float]:
    """Two numbers [SI], one of each part; nan after a problem."""
    if not isinstance(written, list | tuple) or len(written) != 2:
        values.wrong(path, f"expected {field.like}, got {quoted(written)}")
        return [math.nan]
    return [values.value(part, field.unit, (*path, n), field.least) for n, part in enumerate(written)]


def _file(values: Values, field: Field, written: object, path: Path) -> object:
    """The name of a file, which was looked at before: see `with_files` and `with_profiles`."""
    return written


def _groups(values: Values, field: Field, written: object, path: Path) -> tuple[tuple[str, ...], ...]:
    """Groups of names; none after a problem."""
    if not isinstance(written, list | tuple):
        values.wrong(path, f'expected groups of parameters such as [["l2", "l3"]], got {quoted(written)}')
        return ()
    for n, group in enumerate(written):
        if not isinstance(group, list | tuple) or not all(isinstance(name, str) for name in group):
            like = 'expected a group of parameters such as ["l2", "l3"]'
            values.wrong((*path, n), f"{like}, got {quoted(group)}")
            return ()
    return tuple(tuple(group) for group in written)


def _numbers(values: Values, field: Field, written: object, path: Path) -> Sequence[object] | None:
    """What stands for numbers in a list; None after a problem."""
    if not isinstance(written, list | tuple):
        values.wrong(path, f"expected a list of {field.like}, got {quoted(written)}")
        return None
    if not written and field.fewest == 1:
        values.wrong(path, f"expected a list of {field.like}, got an empty one")
    return written


def _table(values: Values, field: Field, written: object, path: Path) -> Table | None:
    """A table; None after a problem."""
    if isinstance(written, Mapping):
        return written
    values.wrong(path, f"expected {field.like}, got {quoted(written)}")
    return None


def _title(values: Values, field: Field, written: object, path: Path) -> str:
    """A text that is shown in terminals and pictures."""
    if not isinstance(written, str):
        values.wrong(path, f"expected a text, got {quoted(written)}")
    return shown(str(written)).replace("\n", " ").replace("\t", " ")


def _version(values: Values, field: Field, written: object, path: Path) -> None:
    """The version of the format, of which there is one; REQUIRED stands for none that is given."""
    if written != 1 or isinstance(written, bool):
        got = "it is missing" if written is REQUIRED else f"got {quoted(written)}"
        values.wrong(path, f"expected format = 1, {got}")


def _line(values: Values, field: Field, written: object, path: Path) -> tuple[Vector, ...] | None:
    """Pairs of a place [m] and a number per length [SI]; None after a problem."""
    if not isinstance(written, list | tuple) or len(written) < 2:
        values.wrong(path, f"expected pairs [[x, {field.unit}], [x, {field.unit}], ...], got {quoted(written)}")
        return None
    pairs = []
    for n, pair in enumerate(written):
        if not isinstance(pair, list | tuple) or len(pair) != 2:
            values.wrong((*path, n), f"expected [x, {field.unit}], got {quoted(pair)}")
            return None
        place = values.value(pair[0], "m", (*path, n, 0), "not negative")
        pairs.append((place, values.value(pair[1], field.unit, (*path, n, 1), "not negative")))
    return tuple(pairs)


OWN = (  # shapes that depend on other parts of the model: of expressions on names, of joints on their kind
    "bearing", "cases", "contact", "coordinate", "distribution", "ends", "expression", "joint", "material of a body",
    "oil", "own friction", "place", "section", "stop", "ways",
)  # fmt: skip
MANY = {"pair": 2, "triple": 3}  # shapes of several numbers, and how many
SHAPES: Mapping[str, Callable[[Values, Field, Any, Path], Any]] = {  # of all shapes but numbers
    "choice": _choice,
    "constant": _constant,
    "cuts": _cuts,
    "each": _each,
    "file": _file,
    "film": _word("film", lambda: registry.kinds("film")),
    "flag": _flag,
    "geometry": _word("geometry", geometries),
    "groups": _groups,
    "names": _names,
    "numbers": _numbers,
    "pair": lambda values, field, written, path: values.vector(written, field.unit, path, field.live, field.least),
    "quantity": lambda values, field, written, path: values.any_number(written, path),
    "points": lambda values, field, written, path: values.points(written, path, field.live),
    "ring": _ring,
    "rings": _rings,
    "labels": _labels,
    "line": _line,
    "stepper": _word("method", lambda: registry.names("stepper")),
    "table": _table,
    "text": _text,
    "texts": _texts,
    "title": _title,
    "triple": _triple,
    "version": _version,
}


def read_function(values: Values, written: object, field: Field, path: Path) -> LocalFunction | float:
    """A field that is a function of a variable of its kind; nan after a problem."""
    node: Node | None = None
    quantity = None
    with values.within({field.function_of: (Name(field.function_of, 0), dimension_of(field.of_unit))}):
        if isinstance(written, str):
            with suppress(QuantityError):
                quantity = parse_quantity(written)
        if isinstance(written, str) and quantity is None:
            node = values.expression(written, path, field.unit, live=False)
        else:
            number = values.value(written, field.unit, path, field.least)
            node = None if math.isnan(number) else Number(number, 0)
    if node is None:
        return math.nan
    try:
        return local_function(node, field.function_of, values.constants, values.tables)
    except ExpressionError as error:
        values.in_expression(error, path)
        return math.nan
