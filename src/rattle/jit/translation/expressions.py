"""Expressions of kernels in LLVM's language.

Every expression becomes instructions and a `Value`.  Instructions give the bits that Python gives for the same numbers;
divided by zero, a float is inf or nan.  Indices count from the start of an array and are not checked, unless
NUMBA_BOUNDSCHECK=1 asks for it.
"""

from __future__ import annotations

import ast
import builtins
import math
from abc import abstractmethod
from types import ModuleType
from typing import Any

import numpy as np

from rattle.jit.translation.values import (
    NOTHING,
    TranslationError,
    Value,
    is_array,
    is_number,
    joined,
    known,
    members,
    number,
    parts_of,
    said,
)
from rattle.jit.translation.writing import Writing

COMPARISONS = {ast.Lt: "lt", ast.LtE: "le", ast.Gt: "gt", ast.GtE: "ge", ast.Eq: "eq", ast.NotEq: "ne"}
ARITHMETIC = {ast.Add: "add", ast.Sub: "sub", ast.Mult: "mul"}
ON_BITS = {ast.BitAnd: "and", ast.BitOr: "or", ast.BitXor: "xor", ast.RShift: "ashr", ast.LShift: "shl"}
INTRINSIC = {math.sqrt: "sqrt", math.fabs: "fabs", math.copysign: "copysign", math.floor: "floor"}
LIBRARY = ("sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "exp", "expm1", "log", "log1p",
           "pow", "hypot")  # fmt: skip
WITH_TWO = ("atan2", "pow", "hypot", "copysign")
FROM_LIBRARY = {getattr(math, name): name for name in LIBRARY}
SAID = "kernels are written with numbers, arrays, tuples, loops and calls of kernels, see docs/adding-a-kind.md"


class Expressions(Writing):
    """What turns expressions into instructions."""

    def value(self, node: ast.expr) -> Value:
        """The value of an expression."""
        self.line = node.lineno
        made = getattr(self, f"_{type(node).__name__.lower()}", None)
        if made is None:
            raise TranslationError(f"'{ast.unparse(node)}' is not known here: {SAID}")
        found: Value = made(node)
        return found

    def number(self, node: ast.expr, kind: str = "") -> Value:
        """The value of an expression that must be a number, converted to a kind if one is given."""
        found = self.value(node)
        if not is_number(found.kind):
            raise TranslationError(f"'{ast.unparse(node)}' is {said(found.kind)}; a number is needed here")
        return self.converted(found, kind) if kind else found

    def index(self, node: ast.expr) -> str:
        """An index or a length."""
        found = self.number(node)
        if found.kind == "f":
            raise TranslationError(f"'{ast.unparse(node)}' is a float; an index must be an integer")
        if isinstance(found.thing, int) and found.thing < 0:
            raise TranslationError(f"'{ast.unparse(node)}': an index cannot count from the end")
        return self.converted(found, "i").parts[0]

    def truth(self, node: ast.expr) -> str:
        """Whether an expression is true, as an i1."""
        return self.true(self.value(node))

    # ---------------------------------------------------------------- names and constants
    def _constant(self, node: ast.Constant) -> Value:
        found = known(node.value)
        if found is None:
            raise TranslationError(f"{node.value!r} is not known here: {SAID}")
        return found

    def _name(self, node: ast.Name) -> Value:
        if node.id in self.variables:
            return self.load(node.id)
        if node.id in self.outside:
            return self._outside(self.outside[node.id], node)
        if hasattr(builtins, node.id):
            return Value(NOTHING, (), getattr(builtins, node.id))
        raise TranslationError(f"'{node.id}' is used before it has a value")

    def _outside(self, thing: Any, node: ast.expr) -> Value:
        """Something from outside of the function that does not change."""
        if (found := known(thing)) is not None:
            return found
        if isinstance(thing, np.ndarray):
            return self.unit.constant(thing)
        if isinstance(thing, tuple) and all(known(one) is not None for one in thing):
            return self.together([self._outside(one, node) for one in thing])
        if callable(thing) or isinstance(thing, ModuleType):
            return Value(NOTHING, (), thing)
        raise TranslationError(f"'{ast.unparse(node)}' is a {type(thing).__name__}: {SAID}")

    def _attribute(self, node: ast.Attribute) -> Value:
        owner = self.value(node.value)
        if owner.kind == "h":
            return self.array_of(owner, node.attr)
        if isinstance(owner.thing, ModuleType) and hasattr(owner.thing, node.attr):
            return self._outside(getattr(owner.thing, node.attr), node)
        if is_array(owner.kind) and node.attr == "shape":
            return self.together([Value("i", (one,)) for one in owner.parts[1:]])
        raise TranslationError(f"'{ast.unparse(node)}' is not known here: {SAID}")

    def _tuple(self, node: ast.Tuple) -> Value:
        return self.together([self.value(one) for one in node.elts])

    # ---------------------------------------------------------------- arithmetic
    def _unaryop(self, node: ast.UnaryOp) -> Value:
        given = self.number(node.operand)
        if isinstance(node.op, ast.Not):
            return Value("b", (self.put(f"xor i1 {self.true(given)}, true"),))
        if isinstance(node.op, ast.UAdd):
            return self.converted(given, joined(given.kind, "i"))
        if not isinstance(node.op, ast.USub):
            raise TranslationError(f"'{ast.unparse(node)}' is not known here: {SAID}")
        if given.thing is not None and given.kind != "b":
            return known(-given.thing) or given
        if given.kind == "f":
            return Value("f", (self.put(f"fneg double {given.parts[0]}"),))
        return Value("i", (self.put(f"sub i64 0, {self.converted(given, 'i').parts[0]}"),))

    def _binop(self, node: ast.BinOp) -> Value:
        return self.combined(node.op, self.number(node.left), self.number(node.right))

    def combined(self, op: ast.operator, a: Value, b: Value) -> Value:
        """Two numbers combined by an operator."""
        if type(op) in ON_BITS:
            kind = joined(a.kind, b.kind)
            if isinstance(op, ast.LShift | ast.RShift):
                kind = joined(kind, "i")
            if kind == "f":
                raise TranslationError("bits of a float cannot be combined")
            x, y = (self.converted(one, kind).parts[0] for one in (a, b))
            return Value(kind, (self.put(f"{ON_BITS[type(op)]} {parts_of(kind)[0]} {x}, {y}"),))
        if isinstance(op, ast.Pow):
            return self._power(a, b)
        kind = "f" if isinstance(op, ast.Div) else joined(joined(a.kind, b.kind), "i")
        x, y = (self.converted(one, kind).parts[0] for one in (a, b))
        if isinstance(op, ast.Div):
            return Value("f", (self.put(f"fdiv double {x}, {y}"),))
        if type(op) in ARITHMETIC:
            word = ARITHMETIC[type(op)]
            return Value(kind, (self.put(f"f{word} double {x}, {y}" if kind == "f" else f"{word} i64 {x}, {y}"),))
        if isinstance(op, ast.Mod) and kind == "f":
            return self._remainder(x, y)
        if isinstance(op, ast.Mod | ast.FloorDiv) and kind == "i":
            quotient, rest = self._floor_division(x, y)
            return Value("i", (rest if isinstance(op, ast.Mod) else quotient,))
        raise TranslationError(f"{type(op).__name__} of {said(a.kind)} and {said(b.kind)} is not known here: {SAID}")

    def _power(self, a: Value, b: Value) -> Value:
        """a ** b; a whole power that is written as such is a product."""
        if b.kind == "i" and b.thing is not None and b.thing >= 0:
            kind, left, found = joined(a.kind, "i"), b.thing, None
            word, factor = ("fmul double" if kind == "f" else "mul i64"), self.converted(a, kind).parts[0]
            while left:
                if left & 1:
                    found = factor if found is None else self.put(f"{word} {found}, {factor}")
                left >>= 1
                if left:
                    factor = self.put(f"{word} {factor}, {factor}")
            return Value(kind, (found or ("1" if kind == "i" else number(1.0)),))
        return self._library("pow", a, b)

    def _remainder(self, x: str, y: str) -> Value:
        """x % y of floats, with the sign of y."""
        rest = self.put(f"frem double {x}, {y}")
        none = self.put(f"fcmp oeq double {rest}, {number(0.0)}")
        below, negative = (self.put(f"fcmp olt double {one}, {number(0.0)}") for one in (rest, y))
        unlike = self.put(f"xor i1 {below}, {negative}")
        moved = self.put(f"select i1 {unlike}, double {self.put(f'fadd double {rest}, {y}')}, double {rest}")
        zero = self.called("double", "llvm.copysign.f64", [("double", number(0.0)), ("double", y)])
        return Value("f", (self.put(f"select i1 {none}, double {zero}, double {moved}"),))

    def _floor_division(self, x: str, y: str) -> tuple[str, str]:
        """x // y and x % y of integers; both are 0 if y is."""
        nothing = self.put(f"icmp eq i64 {y}, 0")
        divisor = self.put(f"select i1 {nothing}, i64 1, i64 {y}")
        quotient, rest = self.put(f"sdiv i64 {x}, {divisor}"), self.put(f"srem i64 {x}, {divisor}")
        unlike = self.put(f"icmp slt i64 {self.put(f'xor i64 {rest}, {divisor}')}, 0")
        down = self.put(f"and i1 {self.put(f'icmp ne i64 {rest}, 0')}, {unlike}")
        lower = self.put(f"sub i64 {quotient}, {self.put(f'zext i1 {down} to i64')}")
        moved = self.put(f"add i64 {rest}, {self.put(f'select i1 {down}, i64 {divisor}, i64 0')}")
        lower, moved = (self.put(f"select i1 {nothing}, i64 0, i64 {one}") for one in (lower, moved))
        return lower, moved

    def _library(self, name: str, *given: Value) -> Value:
        if len(given) != (2 if name in WITH_TWO else 1):
            raise TranslationError(f"{name} with {len(given)} arguments is not known here")
        numbers = [("double", self.converted(one, "f").parts[0]) for one in given]
        return Value("f", (self.called("double", name, numbers, "readnone nounwind willreturn"),))

    # ---------------------------------------------------------------- choices
    def _compare(self, node: ast.Compare) -> Value:
        """A comparison; in a chain, what stands after the first that is false is not computed."""
        left, done = self.value(node.left), self.label()
        for place, (op, other) in enumerate(zip(node.ops, node.comparators, strict=True)):
            right = self.value(other)
            if isinstance(op, ast.In | ast.NotIn):
                this = self._among(node, left, right)
                this = self.put(f"xor i1 {this}, true") if isinstance(op, ast.NotIn) else this
            else:
                this = self._compared(op, left, right)
            if len(node.ops) == 1:
                return Value("b", (this,))
            self.keep(node, Value("b", (this,)))
            if place < len(node.ops) - 1:
                more = self.label()
                self.branch(this, more, done)
                self.begin(more)
            left = right
        self.jump(done)
        self.begin(done)
        return self.kept(node)

    def _among(self, node: ast.Compare, left: Value, right: Value) -> str:
        if not isinstance(right.kind, tuple):
            raise TranslationError(f"'{ast.unparse(node)}': `in` is for tuples, not for {said(right.kind)}")
        found = "false"
        for one in members(right):
            found = self.put(f"or i1 {found}, {self._compared(ast.Eq(), left, one)}")
        return found

    def _compared(self, op: ast.cmpop, a: Value, b: Value) -> str:
        if type(op) not in COMPARISONS or not (is_number(a.kind) and is_number(b.kind)):
            raise TranslationError(f"{said(a.kind)} and {said(b.kind)} cannot be compared like this: {SAID}")
        kind, word = joined(joined(a.kind, b.kind), "i"), COMPARISONS[type(op)]
        x, y = (self.converted(one, kind).parts[0] for one in (a, b))
        if kind == "f":
            return self.put(f"fcmp {'u' if word == 'ne' else 'o'}{word} double {x}, {y}")
        return self.put(f"icmp {word if word in ('eq', 'ne') else 's' + word} i64 {x}, {y}")

    def _boolop(self, node: ast.BoolOp) -> Value:
        """`and`, `or`: the first value that decides; the rest is not computed."""
        done = self.label()
        for place, one in enumerate(node.values):
            given = self.value(one)
            self.keep(node, given)
            if place == len(node.values) - 1:
                break
            more = self.label()
            truth = self.true(given)
            self.branch(truth, *((more, done) if isinstance(node.op, ast.And) else (done, more)))
            self.begin(more)
        self.jump(done)
        self.begin(done)
        return self.kept(node)

    def _ifexp(self, node: ast.IfExp) -> Value:
        yes, no, done = self.label(), self.label(), self.label()
        self.branch(self.truth(node.test), yes, no)
        for start, one in ((yes, node.body), (no, node.orelse)):
            self.begin(start)
            self.keep(node, self.value(one))
            self.jump(done)
        self.begin(done)
        return self.kept(node)

    # ---------------------------------------------------------------- elements of arrays
    def _subscript(self, node: ast.Subscript) -> Value:
        owner = self.value(node.value)
        if isinstance(owner.kind, tuple):
            place = self.value(node.slice).thing
            if not isinstance(place, int) or not 0 <= place < len(owner.kind):
                raise TranslationError(f"'{ast.unparse(node)}': a member of a tuple is chosen by a known number")
            return members(owner)[place]
        if not is_array(owner.kind):
            raise TranslationError(f"'{ast.unparse(node)}': {said(owner.kind)} has no elements")
        if isinstance(node.slice, ast.Slice):
            return self._sliced(owner, node.slice, node)
        if owner.kind[1] == "2" and not isinstance(node.slice, ast.Tuple):
            row = self.index(node.slice)
            self.check(row, owner.parts[1])
            first = self.put(f"mul i64 {row}, {owner.parts[2]}")
            return Value(f"{owner.kind[0]}1", (self.address(owner, first), owner.parts[2]))
        return self.read(owner.kind[0], self.element(owner, node))

    def element(self, owner: Value, node: ast.Subscript) -> str:
        """The address of an element of an array.  Raises TranslationError where a constant is to be changed."""
        if owner.parts[0].startswith("@") and not isinstance(node.ctx, ast.Load):
            raise TranslationError(f"'{ast.unparse(node)}': an array from outside does not change")
        places = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        if len(places) != int(owner.kind[1]):
            raise TranslationError(f"'{ast.unparse(node)}' is no element of {said(owner.kind)}")
        at = [self.index(one) for one in places]
        for one, size in zip(at, owner.parts[1:], strict=True):
            self.check(one, size)
        if len(at) == 1:
            return self.address(owner, at[0])
        return self.address(owner, self.put(f"add i64 {self.put(f'mul i64 {at[0]}, {owner.parts[2]}')}, {at[1]}"))

    def _sliced(self, owner: Value, part: ast.Slice, node: ast.expr) -> Value:
        """Part of a vector, as far as the vector goes."""
        if owner.kind[1] != "1" or part.step is not None:
            raise TranslationError(f"'{ast.unparse(node)}': only a vector has parts, without a step")
        size = owner.parts[1]
        last = size if part.upper is None else self._less(self.index(part.upper), size)
        first = "0" if part.lower is None else self._less(self.index(part.lower), last)
        return Value(owner.kind, (self.address(owner, first), self.put(f"sub i64 {last}, {first}")))

    def _less(self, a: str, b: str) -> str:
        return self.put(f"select i1 {self.put(f'icmp slt i64 {a}, {b}')}, i64 {a}, i64 {b}")

    # ---------------------------------------------------------------- calls
    def _call(self, node: ast.Call) -> Value:
        called = self.value(node.func).thing
        if called is None or node.keywords or any(isinstance(one, ast.Starred) for one in node.args):
            raise TranslationError(f"'{ast.unparse(node)}': kernels are called by name, with arguments in order")
        if called in INTRINSIC or called is abs:
            return self._intrinsic(called, [self.number(one) for one in node.args])
        if called in FROM_LIBRARY:
            return self._library(FROM_LIBRARY[called], *(self.number(one) for one in node.args))
        if called in (min, max):
            return self._extreme(called, [self.number(one) for one in node.args])
        if called in (int, float, bool):
            return self._as(called, self.number(node.args[0]))
        given = [self.value(one) for one in node.args]
        if called is len and len(given) == 1:
            if isinstance(given[0].kind, tuple):
                return known(len(given[0].kind)) or given[0]
            if is_array(given[0].kind):
                return Value("i", (given[0].parts[1],))
        return self.kernel(called, given, node)

    def _intrinsic(self, called: Any, given: list[Value]) -> Value:
        if called is abs and given[0].kind != "f":
            x = self.converted(given[0], "i").parts[0]
            below = self.put(f"icmp slt i64 {x}, 0")
            return Value("i", (self.put(f"select i1 {below}, i64 {self.put(f'sub i64 0, {x}')}, i64 {x}"),))
        name = "fabs" if called is abs else INTRINSIC[called]
        if len(given) != (2 if name in WITH_TWO else 1):
            raise TranslationError(f"{name} with {len(given)} arguments is not known here")
        numbers = [("double", self.converted(one, "f").parts[0]) for one in given]
        found = self.called("double", f"llvm.{name}.f64", numbers)
        return Value("i", (self.put(f"fptosi double {found} to i64"),)) if name == "floor" else Value("f", (found,))

    def _extreme(self, called: Any, given: list[Value]) -> Value:
        """The largest or smallest of several numbers, as Python finds it, also with nan."""
        kind = "i"
        for one in given:
            kind = joined(kind, one.kind)
        word = ("fcmp o" if kind == "f" else "icmp s") + ("gt" if called is max else "lt")
        type_ = parts_of(kind)[0]
        best, *others = (self.converted(one, kind).parts[0] for one in given)
        for other in others:
            best = self.put(f"select i1 {self.put(f'{word} {type_} {other}, {best}')}, {type_} {other}, {type_} {best}")
        return Value(kind, (best,))

    def _as(self, called: Any, given: Value) -> Value:
        if called is bool:
            return Value("b", (self.true(given),))
        if called is int and given.kind == "f":
            return Value("i", (self.put(f"fptosi double {given.parts[0]} to i64"),))
        return self.converted(given, "i" if called is int else "f")

    @abstractmethod
    def kernel(self, called: Any, given: list[Value], node: ast.Call) -> Value:
        """The result of another compiled function."""
