"""Outputs: one number from the curves of a run, as in "max(abs(O3.normal))" or "(final(block.x) - 0.3)**2".

A reduction makes a number of a curve; its inside is any expression over result names, parameters and `t`.  Outside the
reductions stands arithmetic of reductions, numbers and parameters.  `ideal.<name>` is the curve of the same mechanism
without play.  In the parsed form an output is a list of reductions and a tree over their places:

    "max(O3.force) - 2*at(rocker.angle, T)"  ->  reductions (max, O3.force), (at, rocker.angle, T);  outer "#0 - 2*#1"

| kind | inside | number |
|---|---|---|
| max min range | x | greatest and least value, and their difference |
| mean rms sd | x | mean over time, root of the mean square, root of the mean square difference from the mean |
| integral | x | over time |
| at(x, t) | x, instant | value at an instant [s] |
| final | x | value at the last instant |
| quantile(x, p) | x, share | value that x does not exceed for the share p of the time |
| share(a > b) | g = a - b | share of the time in which g > 0 |
| first(a > b) | g = a - b | first instant with g > 0 [s]; nan if there is none |
| count | J.impacts | number of events of a joint |
| time speed peak | J.contacts, k | begin of the k-th contact of a joint [s], its speed, its largest force; nan: never |
| max | J.impulse | largest impulse of the impacts of a joint, 0 without any |

For a < b it is g = b - a; for >= and <= the condition is g >= 0 and `Reduction.strict` is False.
`results.evaluation` computes an output from a result.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

from rattle.description.toml_locations import caret_under
from rattle.errors import LONGEST, InputError, ModelError, Problem, suggest
from rattle.language import arrays
from rattle.language.expression import dimension
from rattle.language.syntax import (
    CALLABLE,
    COMPARISONS,
    FUNCTIONS,
    Apply,
    ExpressionError,
    Grammar,
    Name,
    Node,
    Number,
    names,
    parse,
    walk,
)
from rattle.language.unit_of import unit_of
from rattle.language.units import DIMENSIONLESS, TIME, Dimension, describe, dimension_of, unit_name
from rattle.results.result import Result

ONE = ("max", "min", "mean", "rms", "sd", "range", "integral", "final", "count")  # of one curve
TWO = ("at", "quantile")  # of a curve and a number
OF_CONTACT = ("time", "speed", "peak")  # of a joint, and the number of one of its contacts
CONDITIONS = ("share", "first")
KINDS = (*ONE, *TWO, *OF_CONTACT, *CONDITIONS)
HARDEST = "hardest"  # what max(J.impulse) is read as: impulses stand in events
OF_EVENTS = ("count", HARDEST, *OF_CONTACT)
MAY_LACK = ("first", *OF_CONTACT)  # nan of these is an answer: never
READ_OFF = ("at", "final", *OF_EVENTS)  # those that need no instants but their own
EVENTS = {  # words, and the kinds of events that they stand for: contacts begin with force laws, rigid, and in clutches
    "contacts": ("contact", "impact", "lock"), "impacts": ("impact",), "releases": ("release",), "sticks": ("stick",),
    "slips": ("slip",),
}  # fmt: skip
EVENTS_OF_CONTACT = ("contacts", "impacts")
LONGEST_LIST = 6  # of names in a message
IDEAL = "ideal."
EQUAL = "=="  # of a constraint
NAMES = "an output may use the names of a result, parameters and t"
GRAMMAR = Grammar(
    functions={
        **CALLABLE,
        **dict.fromkeys((*ONE, *CONDITIONS), 1),
        **dict.fromkeys((*TWO, *OF_CONTACT), 2),
        "max": -1,
        "min": -1,
    },
    conditions=frozenset(CONDITIONS),
    parts=4,  # ideal.body.point.x
    compared=True,
    otherwise={
        **dict.fromkeys(("average", "avg"), "write mean"),
        **dict.fromkeys(("std", "stdev", "stddev"), "write sd"),
        "median": "write quantile(x, 0.5)",
        "last": "write final",
        "int": "write integral",
    },
    known=NAMES,
    joined="where x and y are both positive min(x, y) is, and where one of them is max(x, y)",
)


class Meeting(NamedTuple):
    """How the contacts of a joint are."""

    rigid: bool  # they have impulses, no largest force
    turns: bool  # their speeds are those of an angle
    straight: bool = False  # their speeds are those of a way, or of both
    lasting: bool = (
        True  # some have force laws: they begin where they touch; rigid ones that stay shut begin by impacts
    )

    @property
    def speed(self) -> str:
        """SI unit of their speeds; "" if these differ."""
        return "" if self.turns and self.straight else "rad/s" if self.turns else "m/s"

    @property
    def force(self) -> str:
        """SI unit of their forces; "" if these differ."""
        return "" if self.turns and self.straight else "N*m" if self.turns else "N"


@dataclass(frozen=True)
class Known:
    """Names that an output may use."""

    units: Mapping[str, str]  # SI units of the curves; "" if a curve has none or it is not known
    parameters: Mapping[str, str] = field(default_factory=dict)  # SI units of the parameters, likewise
    joints: Mapping[str, Meeting] = field(default_factory=dict)  # whose events are counted

    @classmethod
    def of(cls, result: Result, parameters: Mapping[str, str] | None = None) -> Known:
        """Names of a result; parameters with their units, by default those of its provenance, without units."""
        named = dict.fromkeys(result.provenance.get("parameters", {}), "") if parameters is None else parameters
        return cls({name: result.unit(name) for name in result.names}, named, meetings(result.geometry))

    def unit(self, name: str) -> str | None:
        """SI unit of a curve, of `ideal.<curve>`, or of a parameter; None for an unknown name."""
        if name in self.units:
            return self.units[name]
        if name.startswith(IDEAL) and name[len(IDEAL) :] in self.units:
            return self.units[name[len(IDEAL) :]]
        return self.parameters.get(name)

    def impulse(self, node: Node) -> str:
        """SI unit of the impulses of a joint, if the node is its name; else ""."""
        owner, _, quantity = node.name.rpartition(".") if isinstance(node, Name) else ("", "", "")
        if quantity != "impulse" or owner not in self.joints or f"{owner}.impulse" in self.units:
            return ""
        force = "N" if f"{owner}.normal" in self.units else self.units.get(f"{owner}.stop", "N")
        return f"{force}*s"

    def dimension(self, name: str) -> Dimension | None:
        """Dimension of a name, None if it is not known."""
        unit = self.unit(name)
        return dimension_of(unit) if unit else None


@dataclass(frozen=True, slots=True, eq=False)
class Reduction:
    """One number from a curve."""

    kind: str  # one of KINDS, or HARDEST
    inner: (
        Node  # the curve x, or g of a condition; over curves, parameters and t.  Of OF_EVENTS: Name("<joint>.<events>")
    )
    argument: Node | None  # instant [s] of at, share of quantile; over parameters
    strict: bool  # the condition is g > 0, not g >= 0
    dimension: Dimension | None  # of the number; None if it is not known
    unit: str  # its SI unit, "" if it has none or it is not known
    column: int  # where it stands in the text
    number: int = 0  # of the contact, from 1


@dataclass(frozen=True, slots=True, eq=False)
class Output:
    """An output as read: `outer` is a tree over Name("#0"), Name("#1") ..., the reductions, and parameters."""

    text: str
    reductions: tuple[Reduction, ...]
    outer: Node
    dimension: Dimension | None  # None if it is not known
    unit: str  # SI unit, "" if it has none or it is not known
    names: frozenset[str]  # curves of the result that it needs
    ideal_names: frozenset[str]  # curves of the mechanism without play that it needs, without "ideal."


@dataclass(frozen=True, slots=True, eq=False)
class Constraint:
    """A comparison of two outputs, as in "max(O3.force) <= 500": fulfilled where `margin` is not negative, or zero
    for "=="."""

    text: str
    margin: Output  # the greater side minus the smaller side; for `text` see the constraint
    comparison: str  # < <= > >= ==; in numbers no difference is made between < and <=


def read(text: str, vocabulary: Known) -> Output:
    """Read an output.

    Raises ModelError with a caret below the place at fault if the text is not an output.
    """
    try:
        node = parse(text, GRAMMAR)
        if _compares(node):
            raise ExpressionError(
                "an output is one number; the share of time in which a condition holds is share(...), and a comparison"
                " of two outputs is a constraint",
                node.column,
            )
        return _output(text, node, vocabulary)
    except ExpressionError as error:
        raise _refused(text, "output", error) from None


def read_constraint(text: str, vocabulary: Known) -> Constraint:
    """Read a constraint.  Raises ModelError as `read` does."""
    equation = text.find(EQUAL)
    inside = ExpressionError(f"'{EQUAL}' stands between two outputs, not inside of one", equation)
    try:
        try:
            node = parse(text.replace(EQUAL, "<=", 1), GRAMMAR)  # of the same length: columns stay what they are
        except ExpressionError as error:
            raise inside if error.column == equation else error from None
        if equation >= 0 and isinstance(node, Apply) and node.column != equation:
            raise inside
        if not isinstance(node, Apply) or not _compares(node):
            raise ExpressionError("a constraint compares two outputs, as in max(O3.force) <= 500", 0)
        word = EQUAL if equation >= 0 else node.name
        return Constraint(text, _output(text, _difference(node), vocabulary, compared=True), word)
    except ExpressionError as error:
        raise _refused(text, "constraint", error) from None


def argument(reduction: Reduction, parameters: Mapping[str, float]) -> float:
    """The instant of an `at` [s] or the share of a `quantile`; parameters: values [SI].

    Raises InputError for the other kinds.
    """
    if reduction.argument is None:
        raise InputError(f"{reduction.kind} has no argument beside its curve")
    return float(arrays.evaluate(reduction.argument, parameters.__getitem__))


def needed_instants(output: Output, parameters: Mapping[str, float]) -> tuple[float, ...]:
    """Instants [s] of all `at` in an output, increasing: with them among the outputs of a run none is interpolated.

    parameters: values [SI].
    """
    return tuple(sorted({argument(reduction, parameters) for reduction in output.reductions if reduction.kind == "at"}))


# ---------------------------------------------------------------- reading
def _refused(text: str, what: str, error: ExpressionError) -> ModelError:
    """The error for a text that cannot be read, with the text and a caret."""
    problem = Problem((), f"{what}: {error}", column=error.column)
    line, begin = text.count("\n", 0, error.column), text.rfind("\n", 0, error.column) + 1
    problem.caret = caret_under((text.split("\n") or [""])[line], error.column - begin + 1)
    return ModelError([problem])


def _compares(node: Node) -> bool:
    return isinstance(node, Apply) and node.name in COMPARISONS


def _reduces(node: Node) -> bool:
    return isinstance(node, Apply) and node.name in KINDS and not (node.name in FUNCTIONS and len(node.operands) > 1)


def _difference(comparison: Apply) -> Apply:
    """The greater side of a comparison minus the smaller."""
    left, right = comparison.operands
    sides = (left, right) if comparison.name in (">", ">=") else (right, left)
    return Apply("-", sides, comparison.column)


def _choice(comparison: Apply) -> Apply:
    """A choice by a comparison, or by the difference of its sides, that has the dimension of a number."""
    return Apply("if<", (*comparison.operands, Number(0.0, 0), Number(0.0, 0)), comparison.column)


def _output(text: str, node: Node, vocabulary: Known, compared: bool = False) -> Output:
    """Take the reductions out of a tree, and check names and dimensions; compared: it was a comparison."""
    reductions: list[Reduction] = []
    stack: list[Node] = []
    for part in walk(node):
        if not isinstance(part, Apply):
            stack.append(part)
            continue
        operands = tuple(stack[-len(part.operands) :])
        del stack[-len(part.operands) :]
        if _reduces(part):
            stack.append(Name(f"#{len(reductions)}", part.column))
            reductions.append(_reduction(part, vocabulary))
        else:
            stack.append(replace(part, operands=operands))
    outer = stack[0]
    _require_numbers(outer, vocabulary)
    places = {f"#{k}": reduction for k, reduction in enumerate(reductions)}

    def unit(name: str) -> str:
        return places[name].unit if name in places else vocabulary.parameters[name]

    def dimension_of_place(name: str) -> Dimension | None:
        return places[name].dimension if name in places else vocabulary.dimension(name)

    if compared and isinstance(outer, Apply):
        _dimension(_choice(outer), dimension_of_place)  # its sides can be compared
    seen = _dimension(outer, dimension_of_place)
    used = {name for reduction in reductions if reduction.kind not in OF_EVENTS for name in names(reduction.inner)}
    used -= {"t", *vocabulary.parameters}
    ideal = {name for name in used if name not in vocabulary.units}
    return Output(
        text, tuple(reductions), outer, seen, unit_of(outer, unit, seen), frozenset(used - ideal),
        frozenset(name[len(IDEAL) :] for name in ideal),
    )  # fmt: skip


def _require_curve(node: Apply) -> None:
    """Refuse a reduction inside of another one."""
    for operand in node.operands:
        for part in walk(operand):
            if _reduces(part):
                word = part.name if isinstance(part, Apply) else ""
                raise ExpressionError(
                    f"{word}(...) is one number already and cannot stand inside {node.name}", part.column
                )


def _unit_of_reduced(kind: str, seen: Dimension | None, unit: str) -> tuple[Dimension | None, str]:
    """Dimension and unit of a reduction of a curve with these."""
    if kind == "share":
        return DIMENSIONLESS, ""
    if kind == "first":
        return TIME, "s"
    if kind == "integral":
        seen = None if seen is None else seen.times(TIME)
        return seen, "" if seen is None else unit_name(seen)
    return seen, unit


def _reduction(node: Apply, vocabulary: Known) -> Reduction:
    """One reduction with its names and dimensions checked."""
    kind, inside = node.name, node.operands[0]
    _require_curve(node)
    if kind in OF_CONTACT:
        return _of_contact(node, vocabulary)
    if kind == "count":
        _require_events(inside, vocabulary)
        return Reduction(kind, inside, None, True, DIMENSIONLESS, "", node.column)
    if kind == "max" and (unit := vocabulary.impulse(inside)):
        return Reduction(HARDEST, inside, None, True, dimension_of(unit), unit, node.column)
    strict = True
    if isinstance(inside, Apply) and kind in CONDITIONS:
        strict = inside.name in ("<", ">")
        _require_known(inside, vocabulary)
        _dimension(_choice(inside), vocabulary.dimension)  # its sides can be compared
        inside = _difference(inside)
    _require_known(inside, vocabulary)
    seen = _dimension(inside, vocabulary.dimension)
    seen, unit = _unit_of_reduced(kind, seen, unit_of(inside, lambda name: vocabulary.unit(name) or "", seen))
    number = node.operands[1] if kind in TWO else None
    if number is not None:
        _require_argument(kind, number, vocabulary)
    return Reduction(kind, inside, number, strict, seen, unit, node.column)


def _of_contact(node: Apply, vocabulary: Known) -> Reduction:
    """When, how fast or how hard a contact of a joint is."""
    kind, (inside, which) = node.name, node.operands
    name = inside.name if isinstance(inside, Name) else ""
    joint, _, events = name.rpartition(".")
    if joint not in vocabulary.joints or events not in EVENTS_OF_CONTACT:
        options = [f"{option}.contacts" for option in vocabulary.joints]
        if not options:
            raise ExpressionError(f"no joint has contacts, of which there is a {kind}", inside.column)
        curve = "; of a curve it is max(abs(x))" if kind == "peak" and vocabulary.unit(name) is not None else ""
        hint = suggest(name, options) if name else ""
        if "did you mean" not in hint:
            hint = f"; known: {', '.join(options[:LONGEST_LIST])}"
        raise ExpressionError(
            f"{kind} takes the contacts of a joint, as in {kind}({options[0]}, 1), not '{name}'{curve}{hint}",
            inside.column,
        )
    meeting = vocabulary.joints[joint]
    if kind == "peak" and meeting.rigid:
        raise ExpressionError(
            f"contacts of '{joint}' are rigid: they have impulses and no largest force; write max({joint}.impulse)",
            node.column,
        )
    number = _number_of(kind, which)
    unit = {"time": "s", "speed": meeting.speed, "peak": meeting.force}[kind]
    return Reduction(kind, inside, None, True, dimension_of(unit) if unit else None, unit, node.column, number)


def _number_of(kind: str, node: Node) -> int:
    """The number of a contact: a whole one from 1 on."""
    if isinstance(node, Number) and node.dimension in (None, DIMENSIONLESS) and 1.0 <= node.value == int(node.value):
        return int(node.value)
    unit = "" if not isinstance(node, Number) or node.dimension is None else f" {unit_name(node.dimension)}"
    got = f", not {node.value:g}{unit}" if isinstance(node, Number) else ""
    raise ExpressionError(f"contacts are counted from 1: {kind}(..., k) takes a whole number{got}", node.column)


def meetings(geometry: Mapping[str, Any]) -> dict[str, Meeting]:
    """How the contacts are of the joints that have some; geometry: as of a result."""
    met = {name: _meeting(form) for name, form in geometry.get("joints", {}).items()}
    return {name: meeting for name, meeting in met.items() if meeting is not None}


def _meeting(form: Mapping[str, Any]) -> Meeting | None:
    """How the contacts of a joint are that is drawn so; None if it has none."""
    stop, clutch = form.get("stop"), "sense" in form
    loose = bool(form.get("clearance")) or (bool(form.get("contact")) and not clutch)
    if not stop and not clutch and not loose:
        return None
    turns = clutch or (bool(stop) and form.get("coordinate") == "angle")
    rigid = ([bool(form.get("rigid"))] if loose else []) + ([bool(form.get("rigid_stop"))] if stop else [])
    return Meeting(any(rigid), turns, loose or (bool(stop) and not turns), not rigid or not all(rigid))


def _spots(node: Node) -> list[tuple[str, int]]:
    """Names of an expression with their columns, from left to right."""
    return [(part.name, part.column) for part in walk(node) if isinstance(part, Name)]


def _require_known(node: Node, vocabulary: Known) -> None:
    """Refuse names that are no curve, parameter or `t`."""
    for name, column in _spots(node):
        if name != "t" and vocabulary.unit(name) is None:
            raise ExpressionError(_unknown(name, vocabulary), column)


def _unknown(name: str, vocabulary: Known) -> str:
    """What is said about a name that is not known."""
    owner, _, last = name.rpartition(".")
    if last == "impulse" and owner in vocabulary.joints:
        return f"impulses stand in the events: write max({name}) alone"
    if last in EVENTS and owner in vocabulary.joints:
        more = f", or time({name}, 1) of the first" if last in EVENTS_OF_CONTACT else ""
        return f"'{name}' is counted: write count({name}){more}"
    if name in KINDS:
        return f"'{name}' is a reduction: write {name}(...)"
    prefix = IDEAL if name.startswith(IDEAL) else ""
    known_names = [*(prefix + option for option in vocabulary.units), *vocabulary.parameters]
    same = [option for option in known_names if option.rpartition(".")[0] == owner][:6]
    hint = suggest(name, known_names)
    if "did you mean" not in hint and owner and same:
        hint = f"; known of {owner}: " + ", ".join(same)
    return f"there is no curve or parameter '{name[:LONGEST]}'{hint or '; r.names of a result lists all curves'}"


def _require_numbers(outer: Node, vocabulary: Known) -> None:
    """Refuse curves outside reductions, and texts without any name."""
    spots = _spots(outer)
    for name, column in spots:
        if name.startswith("#") or name in vocabulary.parameters:
            continue
        if name != "t" and vocabulary.unit(name) is None:
            raise ExpressionError(_unknown(name, vocabulary), column)
        raise ExpressionError(
            f"'{name}' changes during the run; give one number of it: max({name}), final({name}), at({name}, 0.5) ...",
            column,
        )
    if not spots:
        raise ExpressionError("this number is the same in every run; give one of a curve, as in max(O3.force)", 0)


def _require_events(node: Node, vocabulary: Known) -> None:
    """Refuse what cannot be counted."""
    name = node.name if isinstance(node, Name) else ""
    joint, _, events = name.rpartition(".")
    if joint in vocabulary.joints and events in EVENTS:
        return
    options = [f"{option}.{what}" for option in vocabulary.joints for what in EVENTS]
    if joint.startswith(IDEAL) or joint == IDEAL[:-1]:
        raise ExpressionError("a joint without play has no impacts to count", node.column)
    if not options:
        raise ExpressionError("no joint has play or a stop, so there are no impacts to count", node.column)
    hint = suggest(name, options) if name else f", as in count({options[0]})"
    raise ExpressionError(f"count takes events of a joint with play or a stop: {', '.join(EVENTS)}{hint}", node.column)


def _require_argument(kind: str, node: Node, vocabulary: Known) -> None:
    """Refuse an instant or a share that is not one number, or has the wrong dimension or range."""
    what, right = ("the instant of at", TIME) if kind == "at" else ("the share of quantile", DIMENSIONLESS)
    for name, column in _spots(node):
        if name in vocabulary.parameters:
            continue
        if name == "t" or vocabulary.unit(name) is not None:
            raise ExpressionError(f"{what} may use numbers and parameters only; '{name}' changes in a run", column)
        raise ExpressionError(f"{what}: unknown parameter '{name}'{suggest(name, vocabulary.parameters)}", column)
    seen = _dimension(node, vocabulary.dimension)
    if seen not in (None, right):
        raise ExpressionError(f"{what} is {describe(seen or right)}; expected {describe(right)}", node.column)
    numbers: dict[str, float] = {}
    if kind == "quantile" and not names(node) and not 0.0 <= float(arrays.evaluate(node, numbers.__getitem__)) <= 1.0:
        raise ExpressionError("the share of quantile goes from 0 to 1", node.column)


def _dimension(node: Node, lookup: Callable[[str], Dimension | None]) -> Dimension | None:
    """Dimension of an expression, None if it is not known; `t` is a time, or the plain number of seconds if only that
    is consistent, as in a model file.  Raises ExpressionError."""
    try:
        return dimension(node, lookup)
    except ExpressionError:
        if "t" not in names(node):
            raise
        return dimension(node, lookup, DIMENSIONLESS)
