"""Exact derivatives of a graph: its own operations differentiated one by one, as new operations of the same graph.

For z = f(x, y) with slopes f_x, f_y at the values that the graph computes:

    forward   dz = f_x dx + f_y dy              from the inputs on, one direction at a time
    reverse   x' += f_x z',  y' += f_y z'       from one output back (z' = d output/dz), all inputs at once

Both take functions as they are (sine, power ...): derive first, `elementary.lower` after.  A derivative is a graph
like any other, so it can be derived again.  Zeros are folded and common parts shared, between directions too.

At a switch the derivative is that of the branch that the value comes from (abs: of x at 0); what a branch that is not
taken would give, infinite or nan, goes nowhere.  At a singular point (sqrt at 0) the formula holds: inf or nan; but
a length (hypot) at 0 whose operands do not change does not change.

Source: Griewank and Walther, Evaluating Derivatives, 2nd ed. (2008), ch. 3 (both modes).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from rattle.errors import TraceError
from rattle.jit.functions import KernelFunction
from rattle.language.functions_of_two import HYPOT
from rattle.language.operations import OPERATIONS
from rattle.language.recorded import Flag, Operand
from rattle.trace.graph import FLAGS, Graph, Symbol, select
from rattle.trace.recorded_language import Copies

Rule = Callable[[Operand, Sequence[Operand], Symbol], Operand]  # (v, operands, result): slope by one operand, times v
Case = frozenset[tuple[int, bool]]  # flags that are so: places and truth values
When = frozenset[Case]  # where a number counts: any of these cases
Share = tuple[When, Operand]  # where it counts, and the number

ALWAYS: When = frozenset([frozenset()])
CASES = 8  # more of them become one new flag


def tangent(graph: Graph, outputs: Sequence[Operand], seeds: Mapping[int, Operand]) -> list[Operand]:
    """Derivatives (n_out,) of the outputs in one direction, forward: operations of the same graph, or numbers.

    seeds: what each input changes by, a symbol of the graph or a number, by the input's place; the others do not
    change.  Flags have derivative 0.  Raises TraceError for a graph that `elementary.lower` has taken apart.
    """
    rates = {_input(graph, place): _value(seed) for place, seed in seeds.items()}
    for place in graph.live(outputs):
        operands = graph.operands[place]
        changes = [rates.get(k, 0.0) for k in operands]
        if any(not _zero(v) for v in changes):
            rates[place] = _forward(graph, place, changes)
    return [rates.get(graph.place(x), 0.0) for x in outputs]


def gradient(graph: Graph, output: Operand, with_respect_to: Sequence[Symbol]) -> list[Operand]:
    """Derivatives (n_in,) of one output by inputs, in reverse: operations of the same graph, or numbers.

    Raises TraceError for a graph that `elementary.lower` has taken apart.
    """
    wanted = [_input(graph, x.place) for x in with_respect_to]
    order = graph.live([output])
    changing = set(wanted)
    for place in order:
        if any(k in changing for k in graph.operands[place]):
            changing.add(place)
    slopes: dict[int, Operand] = {}
    arriving: dict[int, list[Share]] = {graph.place(output): [(ALWAYS, 1.0)]}
    for place in reversed(order):
        if place not in changing or place not in arriving:
            continue
        when, value = _gathered(graph, arriving.pop(place))
        if graph.ops[place] == "input":
            slopes[place] = _guarded(graph, when, ALWAYS, value)
            continue
        for k, share in _shares(graph, place, when, value, changing):
            if not _zero(share[1]):
                arriving.setdefault(k, []).append(share)
    return [slopes.get(place, 0.0) for place in wanted]


def jacobian(graph: Graph, outputs: Sequence[Operand], inputs: Sequence[Symbol]) -> list[list[Operand]]:
    """d outputs/d inputs (n_out, n_in): forward or in reverse, by the fewer of the inputs and outputs that count."""
    used = set(graph.live(outputs))
    columns = sum(x.place in used for x in inputs)
    rows = len({x.place for x in outputs if isinstance(x, Symbol)})
    if rows < columns:
        return [gradient(graph, x, inputs) for x in outputs]
    directions = [tangent(graph, outputs, {x.place: 1.0}) if x.place in used else [0.0] * len(outputs) for x in inputs]
    return [[column[n] for column in directions] for n in range(len(outputs))]


def _input(graph: Graph, place: int) -> int:
    if place not in graph.inputs:
        raise TraceError(f"derivatives are taken by inputs of the graph, not by its operation {place}")
    return place


def _value(x: Operand) -> Operand:
    return x if isinstance(x, Symbol) else float(x)


def _zero(x: Operand) -> bool:
    return not isinstance(x, Symbol) and x == 0.0


def _step(graph: Graph, place: int) -> tuple[tuple[Rule, ...], list[Operand], Symbol]:
    """Rules of an operation, its operands (symbols or numbers), its result.  Raises TraceError if it has no rules."""
    rules = RULES.get(graph.ops[place])
    if rules is None:
        raise TraceError(f"'{graph.ops[place]}' has no derivative: derive a graph before its functions are taken apart")
    return rules, [graph.numbers.get(k, Symbol(graph, k)) for k in graph.operands[place]], Symbol(graph, place)


# ---------------------------------------------------------------- forward
def _forward(graph: Graph, place: int, changes: Sequence[Operand]) -> Operand:
    """Change of one operation's result for changes of its operands."""
    op = graph.ops[place]
    if op == "select":
        return graph.apply("select", Symbol(graph, graph.operands[place][0]), changes[1], changes[2])
    if op in FLAGS:
        return 0.0
    rules, operands, result = _step(graph, place)
    if op == "div":  # one product less than by its rules
        return _over(changes[0] - result * changes[1], operands[1], result)
    total: Operand = 0.0
    for rule, v in zip(rules, changes, strict=True):
        if not _zero(v):
            total = _sum(graph, total, rule(v, operands, result))
    return total


def _sum(graph: Graph, a: Operand, b: Operand) -> Operand:
    return graph.apply("add", a, b)


# ---------------------------------------------------------------- reverse
def _shares(graph: Graph, place: int, when: When, value: Operand, changing: set[int]) -> list[tuple[int, Share]]:
    """What an operation hands on to those of its operands that change: their places, where it counts, how much."""
    op, places = graph.ops[place], graph.operands[place]
    if op in FLAGS:
        return []
    if op == "select":
        flag, holds = places[0], True
        while graph.ops[flag] == "not":
            flag, holds = graph.operands[flag][0], not holds
        cases = [(k, _and(when, flag, truth)) for k, truth in ((places[1], holds), (places[2], not holds))]
        return [(k, (case, value)) for k, case in cases if case and k in changing]
    rules, operands, result = _step(graph, place)
    return [(k, (when, rule(value, operands, result))) for rule, k in zip(rules, places, strict=True) if k in changing]


def _gathered(graph: Graph, arriving: Sequence[Share]) -> Share:
    """The sum of what arrives, and where it counts.  Elsewhere it may be anything: nobody reads it there."""
    sums: dict[When, Operand] = {}
    for when, value in arriving:
        sums[when] = _sum(graph, sums[when], value) if when in sums else value
    while (pair := _halves(sums)) is not None:  # the two branches of a choice, chosen in one operation
        taken, other, flag, rest = pair
        value = graph.apply("select", Symbol(graph, flag), sums.pop(taken), sums.pop(other))
        sums[rest] = _sum(graph, sums[rest], value) if rest in sums else value
    if len(sums) == 1:
        return next(iter(sums.items()))
    anywhere = _any(graph, list(sums))
    total: Operand = 0.0
    for when, value in sums.items():
        total = _sum(graph, total, _guarded(graph, when, anywhere, value))
    return anywhere, total


def _halves(sums: Mapping[When, Operand]) -> tuple[When, When, int, When] | None:
    """Two single cases that differ in one flag alone: where it is true, where not, the flag, and what they share."""
    for when in sums:
        if len(when) == 1:
            (case,) = when
            for flag, truth in case:
                other = frozenset([case - {(flag, truth)} | {(flag, not truth)}])
                if truth and other in sums:
                    return when, other, flag, frozenset([case - {(flag, truth)}])
    return None


def _guarded(graph: Graph, when: When, inside: When, value: Operand) -> Operand:
    """A value that counts only in some cases, made zero in the others of those `inside`."""
    if when == inside:
        return value
    return graph.apply("select", _flag(graph, when, frozenset.intersection(*inside)), value, 0.0)


def _flag(graph: Graph, when: When, settled: Case) -> Flag:
    """Whether one of the cases holds, where the known flags are so."""
    flag: Flag = False
    for case in sorted(when, key=sorted):
        holds: Flag = True
        for place, truth in sorted(case - settled):
            symbol = Symbol(graph, place)
            holds = graph.apply("both", holds, symbol if truth else ~symbol)
        flag = graph.apply("either", flag, holds)
    return flag


def _and(when: When, flag: int, truth: bool) -> When:
    return _simple([case | {(flag, truth)} for case in when if (flag, not truth) not in case])


def _any(graph: Graph, parts: Sequence[When]) -> When:
    """Where any of the parts counts."""
    cases = _simple([case for when in parts for case in when])
    if len(cases) <= CASES:
        return cases
    return frozenset([frozenset([(graph.place(_flag(graph, cases, frozenset())), True)])])


def _simple(cases: Sequence[Case]) -> When:
    """The same cases without those inside others, and pairs made one where a flag does not matter."""
    kept = set(cases)
    more = kept
    while more:
        more = {
            case - {(flag, truth)}
            for case in kept
            for flag, truth in case
            if case - {(flag, truth)} | {(flag, not truth)} in kept
        } - kept
        kept |= more
        kept = {case for case in kept if not any(other < case for other in kept)}
    return frozenset(kept)


# ---------------------------------------------------------------- slopes
def _over(v: Operand, x: Operand, r: Symbol) -> Operand:
    """v/x; 1/x is one operation for all directions."""
    return v * (1.0 / x) if isinstance(x, Symbol) else r.graph.apply("div", v, x)


def _base(v: Operand, xy: Sequence[Operand], r: Symbol) -> Operand:
    """x^y by x: y x^(y - 1); 0 for y = 0, where x = 0 too."""
    x, y = xy
    if isinstance(y, Symbol):
        return v * select(r.graph.apply("equal", y, 0.0), 0.0, y * r.graph.apply("pow", x, y - 1.0))
    if y == 0.0:
        return 0.0
    less = y - 1.0
    product: Operand = 1.0
    if less in (0.0, 1.0, 2.0, 3.0):
        for _ in range(int(less)):
            product = product * x
    else:
        product = r.graph.apply("pow", x, less)
    return v * (y * product)


def _exponent(v: Operand, xy: Sequence[Operand], r: Symbol) -> Operand:
    """x^y by y: x^y ln x; 0 for x = 0 < y.  For x < 0 nan, unless y does not change there."""
    x, y = xy
    slope = r * r.graph.apply("log", x)
    vanishes = r.graph.apply("both", r.graph.apply("equal", x, 0.0), r.graph.apply("less", 0.0, y))
    still = r.graph.apply("equal", v, 0.0)
    return r.graph.apply("select", r.graph.apply("either", vanishes, still), 0.0, v * slope)


def _copied(v: Operand, xs: Sequence[Operand], r: Symbol) -> Operand:
    """|x| with the sign of s, by x."""
    x, s = xs
    size = _size(v, [x], r)
    return select(r.graph.apply("less", r.graph.apply("copysign", 1.0, s), 0.0), -size, size)


def _size(v: Operand, x: Sequence[Operand], r: Symbol) -> Operand:
    return select(r.graph.apply("less", x[0], 0.0), -v, v)


def _none(v: Operand, x: Sequence[Operand], r: Symbol) -> Operand:
    return 0.0


def _by_slope(slope: KernelFunction) -> tuple[Rule, ...]:
    """The rule of a function of expressions: its slope at x, where its value is r."""
    return (lambda v, x, r: v * COPIES.of(slope.python)(x[0], r),)


def _by_partial(partial: KernelFunction) -> Rule:
    """The same by one of two operands."""
    return lambda v, x, r: v * COPIES.of(partial.python)(x[0], x[1], r)


def _if_moving(rule: Rule) -> Rule:
    """A rule that has no value somewhere, as that of a length at 0, and does not count there while nothing changes."""
    return lambda v, x, r: select(r.graph.apply("equal", v, 0.0), 0.0, rule(v, x, r))


COPIES = Copies()
RECORDED = [record for record in OPERATIONS.values() if record.recorded]
RULES: dict[str, tuple[Rule, ...]] = {
    **{record.recorded: _by_slope(record.slope) for record in RECORDED if record.slope is not None},
    **{record.recorded: tuple(map(_by_partial, record.partials)) for record in RECORDED if record.partials},
    "hypot": tuple(_if_moving(_by_partial(partial)) for partial in HYPOT.partials),
    "add": (lambda v, x, r: v, lambda v, x, r: v),
    "sub": (lambda v, x, r: v, lambda v, x, r: -v),
    "mul": (lambda v, x, r: v * x[1], lambda v, x, r: v * x[0]),
    "div": (lambda v, x, r: _over(v, x[1], r), lambda v, x, r: -(_over(v, x[1], r) * r)),
    "neg": (lambda v, x, r: -v,),
    "abs": (_size,),
    "floor": (_none,),
    "pow": (_base, _exponent),
    "copysign": (_copied, _none),
}
