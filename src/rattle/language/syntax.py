"""Syntax of expressions: tokens, precedence, and the tree that `parse` returns.

Precedence is that of Python; `parse` refuses everything but numbers, names, operators, the functions of
`FUNCTIONS` and `a if x < y else b`, where conditions are joined by `and`, `or`, `not`.  Nesting is limited, and
the tree is walked in loops, so that no text leads to deep recursion.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from keyword import kwlist

from rattle.errors import suggest
from rattle.language.composed import COMPOSED, Composed, sizes
from rattle.language.motion_laws import LAWS
from rattle.language.operations import FUNCTIONS as FUNCTIONS
from rattle.language.operations import RESERVED as RESERVED_FUNCTIONS
from rattle.language.operations import SAME
from rattle.language.tokens import ExpressionError as ExpressionError
from rattle.language.tokens import number_of, tokens
from rattle.language.units import DIMENSIONLESS, UNITS, Dimension, from_zero, scaled

MAX_LENGTH = 2000  # characters
MAX_DEPTH = 50
MAX_NODES = 1000

CALLABLE: Mapping[str, int] = {**FUNCTIONS, **sizes()}
# not allowed as name of a parameter, signal or body; some functions are, which with a parenthesis are functions
RESERVED = frozenset(kwlist) | RESERVED_FUNCTIONS | {"pi", "t"}

_BINDING = {
    "if": 1, "or": 2, "and": 3, "<": 5, "<=": 5, ">": 5, ">=": 5, "+": 6, "-": 6, "*": 7, "/": 7, "**": 9,
}  # fmt: skip
_NOT = 4  # not x < y is not (x < y)
_SIGN = 8  # -x**2 is -(x**2), -x*y is (-x)*y
COMPARISONS = ("<", "<=", ">", ">=")
JOINING = ("and", "or", "not")

OTHERWISE = {  # functions of other languages that have another name here, or none
    "log10": "write log(x)/log(10)",
    "log2": "write log(x)/log(2)",
    "pow": "write x**y",
    "arcsin": "write asin",
    "arccos": "write acos",
    "arctan": "write atan",
    "arctan2": "write atan2",
    "sgn": "write sign",
    "heaviside": "write step",
    "fmod": "write mod",
    "ceil": "write -floor(-x)",
    "round": "write floor(x + 0.5)",
}
KNOWN = (
    "an expression may use t, parameters, signals and names such as <body>.x .y .angle, <body>.<point>.x,"
    " <joint>.angle, <load>.force: `rattle kinds names`"
)


@dataclass(frozen=True, slots=True)
class Grammar:
    """What an expression may contain beside numbers, operators and `a if x < y else b`."""

    functions: Mapping[str, int] = field(default_factory=lambda: CALLABLE)  # as in FUNCTIONS
    conditions: frozenset[str] = frozenset()  # those functions whose argument is a comparison
    parts: int = 3  # of a name, at most: "body.point.x" has three
    compared: bool = False  # the whole may be a comparison
    otherwise: Mapping[str, str] = field(default_factory=dict)  # more of OTHERWISE
    known: str = KNOWN
    joined: str = ""  # what is said where conditions are joined in a function of one condition


MODEL = Grammar()  # of model files


@dataclass(frozen=True, slots=True, eq=False)
class Number:
    """A number [SI], or pi.

    dimension: None if it was written without a unit.  others: names in its unit beyond the first.
    implied: it stands in the formula of a function, so nobody gave it a unit.  zero: where the zero of its unit lies
    [SI], if not at 0: a temperature in degC.
    """

    value: float
    column: int
    dimension: Dimension | None = None
    others: frozenset[str] = frozenset()
    implied: bool = False
    zero: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Name:
    """A parameter, a signal, a state name or `t`."""

    name: str
    column: int


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Apply:
    """An operator, function or choice: "+", "neg", "sin", "if<" (left, right, then, otherwise).

    A choice by conditions that are joined is "choose" (condition, then, otherwise); its condition consists of
    comparisons ("<"), "and", "or" and "not".
    """

    name: str
    operands: tuple[Node, ...]
    column: int
    called: str = ""  # the function in whose formula it stands, where errors name that


Node = Number | Name | Apply


CALL = "()"  # at the end of the name of an operation that is a table's


def call_name(table: str) -> str:
    """The name of the operation that reads a table."""
    return table + CALL


def parse(text: str, grammar: Grammar = MODEL, tables: Collection[str] = ()) -> Node:
    """Read an expression.  tables: names of tables, which are functions of one number in a model.

    Raises ExpressionError if the text is not an expression or is too long.
    """
    if len(text) > MAX_LENGTH:
        raise ExpressionError(f"the expression has {len(text)} characters; at most {MAX_LENGTH} are read", 0)
    return _of_model(text, tuple(tables)) if grammar is MODEL else _Parser(text, grammar).read()


@functools.lru_cache(maxsize=256)
def _of_model(text: str, tables: tuple[str, ...]) -> Node:
    """An expression of a model; a model is read again and again with other values of its parameters."""
    return _Parser(text, MODEL, tables).read()


def names(node: Node) -> set[str]:
    """All names that the expression uses, including `t`, without `pi` and functions."""
    return {part.name for part in walk(node) if isinstance(part, Name)}


def replaced(node: Node, parts: Mapping[str, Node]) -> Node:
    """The expression with other nodes in place of the names that `parts` has."""
    stack: list[Node] = []
    for part in walk(node):
        if isinstance(part, Apply):
            operands = tuple(stack[-len(part.operands) :])
            del stack[-len(operands) :]
            stack.append(replace(part, operands=operands))
        else:
            stack.append(parts.get(part.name, part) if isinstance(part, Name) else part)
    return stack[0]


def walk(node: Node) -> list[Node]:
    """All nodes from left to right, operands before the operation that uses them."""
    nodes, waiting = [], [node]
    while waiting:
        part = waiting.pop()
        nodes.append(part)
        if isinstance(part, Apply):
            waiting.extend(part.operands)
    nodes.reverse()
    return nodes


@functools.cache
def _formula(function: Composed) -> Node:
    """The formula of a function."""
    return _Parser(function.formula, MODEL).read()


def _placed(name: str, arguments: Sequence[Node], column: int) -> Node:
    """A formula with the arguments in place of its variables; what is wrong is wrong at `column`."""
    function = COMPOSED[name]
    values, called = dict(zip(function.variables, arguments, strict=True)), name if function.named else ""
    stack: list[Node] = []
    for part in walk(_formula(function)):
        if isinstance(part, Apply):
            operands = tuple(stack[-len(part.operands) :])
            del stack[-len(operands) :]
            stack.append(Apply(part.name, operands, column, called))
        elif isinstance(part, Name):
            stack.append(values[part.name])
        else:
            stack.append(Number(part.value, column, DIMENSIONLESS, implied=function.named))
    return stack[0]


def _refuse_celsius(node: Node) -> None:
    """Raise ExpressionError for a temperature in degC in a sum or product, where it may be meant as a difference."""
    if isinstance(node, Number) and node.zero:
        degrees = f"{node.value - node.zero:.9g}"
        raise ExpressionError(
            f"{degrees} degC in a sum or product: write {degrees} K for a difference,"
            f" {node.value:.9g} K for the temperature",
            node.column,
        )


class _Parser:
    """Operator-precedence parser; `expression(least)` reads operators of precedence `least` or higher."""

    def __init__(self, text: str, grammar: Grammar, tables: Collection[str] = ()) -> None:
        self.text = text
        self.grammar = grammar
        self.tables = tables
        self.tokens = tokens(text, grammar.parts, grammar.known)
        self.at = 0
        self.depth = 0
        self.nodes = 0

    def read(self) -> Node:
        node = self.expression(1)
        if self.tokens[self.at][0] != "end":
            raise self.no_operator()
        if not self.grammar.compared or (isinstance(node, Apply) and node.name in JOINING):
            self.refuse_condition(node)
        return node

    def no_operator(self) -> ExpressionError:
        """The error for a token that cannot follow an operand, with advice."""
        (before, number, _), (kind, word, column) = self.tokens[self.at - 1 : self.at + 1]
        hint = ""
        if before == "number" and kind == "name":
            hint = self.unit_or_product(number, word)
        elif before == "number" and word == ",":
            hint = "; a decimal point is written '.', as in 0.21"
        elif word == "(":
            hint = "; a product is written with *"
        return ExpressionError(f"expected an operator, found '{word}'{hint}", column)

    @staticmethod
    def unit_or_product(number: str, word: str) -> str:
        """Advice for a name that follows a number directly."""
        if word == "t":
            return f"; write {number}*t for the time, {number}e3 kg for a mass"
        same = [unit for unit in UNITS if unit.casefold() == word.casefold()]
        if same:
            return f"; did you mean {number} {same[0]}?"
        return f"; {word} is not a unit: write {number}*{word} for a product"

    def expression(self, least: int) -> Node:
        self.depth += 1
        if self.depth > MAX_DEPTH:
            raise ExpressionError(f"nested more than {MAX_DEPTH} deep", self.tokens[self.at][2])
        left = self.operand()
        while True:
            _, word, column = self.tokens[self.at]
            binding = _BINDING.get(word, 0)
            if binding < least:
                break
            self.at += 1
            if word == "if":
                left = self.choice(left, column)
            else:
                right = self.expression(binding if word == "**" else binding + 1)
                left = self.apply(word, (left, right), column)
        self.depth -= 1
        return left

    def operand(self) -> Node:
        kind, word, column = self.tokens[self.at]
        self.at += 1
        if kind == "number":
            return self.number(word, column)
        if kind == "quantity":
            return self.quantity(word, column)
        if kind == "name" and word != "not":
            return self.name(word, column)
        if word == "-":
            return self.negative(self.expression(_SIGN), column)
        if word == "+":
            return self.expression(_SIGN)
        if word == "not":
            return self.apply("not", (self.expression(_NOT),), column)
        if word == "(":
            inner = self.expression(1)
            self.expect(")", f"the '(' in column {column + 1} is not closed")
            return inner
        there = "the end" if kind == "end" else f"'{word}'"
        raise ExpressionError(f"expected a number, a name or '(', found {there}", column)

    def number(self, word: str, column: int) -> Node:
        value = float(word)
        if not math.isfinite(value):
            raise ExpressionError("the number is too large", column)
        self.count(column)
        return Number(value, column)

    def quantity(self, word: str, column: int) -> Node:
        number, unit = number_of(word)
        value = from_zero(scaled(number, unit.scale), unit.zero)
        if not math.isfinite(value):
            raise ExpressionError("the number is too large", column)
        self.count(column)
        return Number(value, column, unit.dimension, unit.others, zero=unit.zero)

    def negative(self, node: Node, column: int) -> Node:
        """What stands behind a minus sign, negated; -5 degC are 268.15 K."""
        if isinstance(node, Number) and node.zero:
            return replace(node, value=from_zero(node.zero - node.value, node.zero), column=column)
        return self.apply("neg", (node,), column)

    def name(self, word: str, column: int) -> Node:
        if self.tokens[self.at][1] == "(":
            return self.call(word, column)
        if word in kwlist:
            raise ExpressionError(f"'{word}' is not allowed here", column)
        if word in FUNCTIONS and word in RESERVED:
            raise ExpressionError(f"'{word}' is a function; write {word}(...)", column)
        if word in self.tables:
            raise ExpressionError(f"'{word}' is a table; write {word}(x)", column)
        self.count(column)
        return Number(math.pi, column) if word == "pi" else Name(word, column)

    def call(self, word: str, column: int) -> Node:
        functions = {**self.grammar.functions, **sizes(), **dict.fromkeys(self.tables, 1)}
        if word not in functions:
            raise self.no_function(word, functions, column)
        arguments, wanted = self.arguments(word), functions[word]
        if len(arguments) != wanted and (wanted > 0 or len(arguments) < -wanted):
            count = f"{abs(wanted)}{' or more' * (wanted < 0)} argument{'s' * (abs(wanted) > 1 or wanted < 0)}"
            raise ExpressionError(f"{word} takes {count}, not {len(arguments)}", column)
        if word in self.grammar.conditions:
            return self.condition(word, arguments[0], column)
        if word in COMPOSED and word not in self.tables:
            return self.composed(word, arguments, column)
        first = wanted if wanted > 0 else min(len(arguments), 2)
        word = call_name(word) if word in self.tables else SAME.get(word, word)
        node = self.apply(word, tuple(arguments[:first]), column)
        for argument in arguments[first:]:
            node = self.apply(word, (node, argument), column)
        return node

    def no_function(self, word: str, functions: Mapping[str, int], column: int) -> ExpressionError:
        """The error for a function that there is not, with advice."""
        other = {**OTHERWISE, **self.grammar.otherwise}
        hint = f"; {other[word]}" if word in other else suggest(word[:40], functions)
        listed = ", ".join(name for name in functions if name not in LAWS)
        return ExpressionError(f"there is no function '{word[:40]}'{hint or '; known: ' + listed}", column)

    def arguments(self, word: str) -> list[Node]:
        """What stands in the parentheses of a function."""
        self.at += 1
        arguments: list[Node] = []
        while self.tokens[self.at][1] != ")" or arguments:
            arguments.append(self.expression(1))
            if self.tokens[self.at][1] != ",":
                break
            self.at += 1
        if self.tokens[self.at][0] in ("name", "number"):
            raise self.no_operator()
        self.expect(")", f"the '(' of {word} is not closed")
        return arguments

    def composed(self, word: str, arguments: Sequence[Node], column: int) -> Node:
        """A function that stands for a formula of its arguments."""
        for argument in arguments:
            self.refuse_condition(argument)
        function = COMPOSED[word]
        written = walk(_formula(function))
        added = {name: len(walk(part)) - 1 for name, part in zip(function.variables, arguments, strict=True)}
        self.count(column, len(written) + sum(added[part.name] for part in written if isinstance(part, Name)))
        return _placed(word, arguments, column)

    def condition(self, word: str, test: Node, column: int) -> Apply:
        """A function of a comparison."""
        if isinstance(test, Apply) and test.name in JOINING:
            raise ExpressionError(
                f"{word} takes one comparison, without '{test.name}'; {self.grammar.joined}", test.column
            )
        if not isinstance(test, Apply) or test.name not in COMPARISONS:
            raise ExpressionError(f"{word} takes a condition, as in {word}(x > 0)", test.column)
        self.count(column)
        return Apply(word, (test,), column)

    def choice(self, then: Node, column: int) -> Node:
        test = self.expression(2)
        if not _is_condition(test):
            raise ExpressionError("after 'if' two values must be compared with < <= > >=", test.column)
        self.expect("else", "this 'if' has no 'else'", column)
        otherwise = self.expression(1)
        if isinstance(test, Apply) and test.name in COMPARISONS:
            return self.apply(f"if{test.name}", (*test.operands, then, otherwise), column)
        for branch in (then, otherwise):
            self.refuse_condition(branch)
        self.count(column)
        return Apply("choose", (test, then, otherwise), column)

    def expect(self, word: str, message: str, column: int | None = None) -> None:
        if self.tokens[self.at][1] != word:
            raise ExpressionError(message, self.tokens[self.at][2] if column is None else column)
        self.at += 1

    def apply(self, name: str, operands: tuple[Node, ...], column: int) -> Apply:
        for operand in operands:
            if name in _BINDING and name not in COMPARISONS:
                _refuse_celsius(operand)
            if name not in JOINING:
                self.refuse_condition(operand)
            elif not _is_condition(operand):
                joins = "joins two conditions" if name != "not" else "takes a condition"
                raise ExpressionError(f"'{name}' {joins}, as in {_JOINED[name]}", operand.column)
        self.count(column)
        return Apply(name, operands, column)

    def count(self, column: int, nodes: int = 1) -> None:
        self.nodes += nodes
        if self.nodes > MAX_NODES:
            raise ExpressionError(f"the expression has more than {MAX_NODES} parts", column)

    def refuse_condition(self, node: Node) -> None:
        if isinstance(node, Apply) and _is_condition(node):
            places = "".join(f" and in {word}(...)" for word in sorted(self.grammar.conditions))
            raise ExpressionError(f"'{node.name}' is allowed only between 'if' and 'else'{places}", node.column)


_JOINED = {"and": "x > 0 and y > 0", "or": "x > 0 or y > 0", "not": "not x > 0"}


def _is_condition(node: Node) -> bool:
    return isinstance(node, Apply) and (node.name in COMPARISONS or node.name in JOINING)
