"""Expressions of kernels in LLVM's language.

Every expression becomes instructions and a `Value`.  Instructions give the bits that Python gives for the same numbers;
divided by zero, a float is inf or nan.  Indices count from the start of an array and are not checked, unless
RATTLE_BOUNDSCHECK=1 asks for it.  In functions of users they may count from the end, and are checked.
"""

from __future__ import annotations

import ast
import builtins
import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from types import FunctionType, ModuleType

import numpy as np

from rattle.jit.families import Kind
from rattle.jit.machine import Entry
from rattle.jit.translation.library import (
    ABSOLUTE,
    CONVERSIONS,
    EXTREMES,
    INTRINSIC,
    LIBRARY,
    WHOLE,
    WITH_TWO,
    WRITTEN,
    _largest,
    _logarithm,
    _smallest,
)
from rattle.jit.translation.local_arrays import MAKING
from rattle.jit.translation.values import (
    NOTHING,
    Record,
    TranslationError,
    Value,
    is_array,
    is_number,
    joined,
    known,
    members,
    number,
    parts_of,
    python_function,
    said,
)
from rattle.jit.translation.writing import Writing

COMPARISONS = {ast.Lt: "lt", ast.LtE: "le", ast.Gt: "gt", ast.GtE: "ge", ast.Eq: "eq", ast.NotEq: "ne"}
ARITHMETIC = {ast.Add: "add", ast.Sub: "sub", ast.Mult: "mul"}
ON_BITS = {ast.BitAnd: "and", ast.BitOr: "or", ast.BitXor: "xor", ast.RShift: "ashr", ast.LShift: "shl"}
SAID = "kernels are written with numbers, arrays, tuples, loops and calls of kernels, see docs/adding-a-kind.md"


class Expressions(Writing, ABC):
    """What turns expressions into instructions."""

    def value(self, node: ast.expr) -> Value:
        """The value of an expression."""
        self.line = node.lineno
        method = getattr(self, f"_{type(node).__name__.lower()}", None)
        if method is None:
            raise TranslationError(f"'{ast.unparse(node)}' is not known here: {SAID}")
        value: Value = method(node)
        return value

    def number(self, node: ast.expr, kind: str = "") -> Value:
        """The value of an expression that must be a number, converted to a kind if one is given."""
        value = self.value(node)
        if not is_number(value.kind):
            raise TranslationError(f"'{ast.unparse(node)}' is {said(value.kind)}; a number is needed here")
        return self.converted(value, kind) if kind else value

    def index(self, node: ast.expr, size: str = "") -> str:
        """An index, checked against the size of its dimension, or a limit of a part."""
        value = self.number(node)
        if value.kind == "f":
            raise TranslationError(f"'{ast.unparse(node)}' is a float; an index must be an integer")
        place = self.converted(value, "i").parts[0]
        if self.careful and not isinstance(value.thing, int):
            if not size:
                raise TranslationError(f"'{ast.unparse(node)}': parts of an array have known limits here")
            below, moved = self.put(f"icmp slt i64 {place}, 0"), self.put(f"add i64 {place}, {size}")
            place = self.put(f"select i1 {below}, i64 {moved}, i64 {place}")
        elif isinstance(value.thing, int) and value.thing < 0:
            if not (self.careful and size):
                raise TranslationError(f"'{ast.unparse(node)}': an index cannot count from the end")
            place = self.put(f"add i64 {place}, {size}")
        if size:
            self.check(place, size)
        return place

    def truth(self, node: ast.expr) -> str:
        """Whether an expression is true, as an i1."""
        return self.true(self.value(node))

    # ---------------------------------------------------------------- names and constants
    def _constant(self, node: ast.Constant) -> Value:
        if isinstance(node.value, int) and abs(node.value) >= 2**63:
            raise TranslationError(f"{node.value} has more than 64 bits")
        value = Value(NOTHING, (), node.value) if isinstance(node.value, str) else known(node.value)
        if value is None:
            raise TranslationError(f"{node.value!r} is not known here: {SAID}")
        return value

    def _name(self, node: ast.Name) -> Value:
        if node.id in self.variables:
            return self.load(node.id)
        if node.id in self.outside:
            return self._outside(self.outside[node.id], node)
        if hasattr(builtins, node.id):
            return Value(NOTHING, (), getattr(builtins, node.id))
        raise TranslationError(f"'{node.id}' is used before it has a value")

    def _outside(self, thing: object, node: ast.expr) -> Value:
        """Something from outside of the function that does not change."""
        if (value := known(thing)) is not None:
            return value
        if isinstance(thing, np.ndarray):
            return self.unit.constant(thing)
        if isinstance(thing, tuple) and all(isinstance(member, tuple) or known(member) is not None for member in thing):
            record = self.together([self._outside(member, node) for member in thing])
            return record._replace(kind=Record(record.kind, thing._fields)) if hasattr(thing, "_fields") else record
        if isinstance(thing, list) and self.careful and np.asarray(thing).dtype.kind in "iubf":
            return self.unit.constant(np.asarray(thing))
        if callable(thing) or isinstance(thing, ModuleType | Entry):
            return Value(NOTHING, (), thing)
        raise TranslationError(f"'{ast.unparse(node)}' is a {type(thing).__name__}: {SAID}")

    def _attribute(self, node: ast.Attribute) -> Value:
        owner = self.value(node.value)
        if owner.kind == "h":
            return self.array_of(owner, node.attr)
        if isinstance(owner.thing, ModuleType) and hasattr(owner.thing, node.attr):
            return self._outside(getattr(owner.thing, node.attr), node)
        if isinstance(owner.kind, Record) and node.attr in owner.kind.names:
            return members(owner)[owner.kind.names.index(node.attr)]
        if is_array(owner.kind) and node.attr == "shape":
            return self.together([Value("i", (size,)) for size in owner.parts[1:]])
        raise TranslationError(f"'{ast.unparse(node)}' is not known here: {SAID}")

    def _tuple(self, node: ast.Tuple) -> Value:
        return self.together([self.value(element) for element in node.elts])

    def _list(self, node: ast.List) -> Value:
        if not self.careful:
            raise TranslationError(f"'{ast.unparse(node)}' is not known here: {SAID}")
        return self.together([self.value(element) for element in node.elts])

    # ---------------------------------------------------------------- arithmetic
    def _unaryop(self, node: ast.UnaryOp) -> Value:
        operand = self.number(node.operand)
        if isinstance(node.op, ast.Not):
            return Value("b", (self.put(f"xor i1 {self.true(operand)}, true"),))
        if isinstance(node.op, ast.UAdd):
            return self.converted(operand, joined(operand.kind, "i"))
        if not isinstance(node.op, ast.USub):
            raise TranslationError(f"'{ast.unparse(node)}' is not known here: {SAID}")
        if operand.thing is not None and operand.kind != "b":
            return known(-operand.thing) or operand
        if operand.kind == "f":
            return Value("f", (self.put(f"fneg double {operand.parts[0]}"),))
        return Value("i", (self.put(f"sub i64 0, {self.converted(operand, 'i').parts[0]}"),))

    def _binop(self, node: ast.BinOp) -> Value:
        return self.combined(node.op, self.number(node.left), self.number(node.right))

    def combined(self, op: ast.operator, a: Value, b: Value) -> Value:
        """Two numbers combined by an operator."""
        if type(op) in ON_BITS:
            return self._of_bits(op, a, b)
        if isinstance(op, ast.Pow):
            return self._power(a, b)
        kind = "f" if isinstance(op, ast.Div) else joined(joined(a.kind, b.kind), "i")
        x, y = (self.converted(operand, kind).parts[0] for operand in (a, b))
        if isinstance(op, ast.Div):
            return Value("f", (self.put(f"fdiv double {x}, {y}"),))
        if type(op) in ARITHMETIC:
            word = ARITHMETIC[type(op)]
            return Value(kind, (self.put(f"f{word} double {x}, {y}" if kind == "f" else f"{word} i64 {x}, {y}"),))
        if isinstance(op, ast.Mod) and kind == "f":
            return self._remainder(x, y)
        if isinstance(op, ast.FloorDiv) and kind == "f":
            return self._floored(x, y)
        if isinstance(op, ast.Mod | ast.FloorDiv) and kind == "i":
            return self._divided(op, x, y)
        raise TranslationError(f"{type(op).__name__} of {said(a.kind)} and {said(b.kind)} is not known here: {SAID}")

    def _divided(self, op: ast.Mod | ast.FloorDiv, x: str, y: str) -> Value:
        """Quotient or rest of two whole numbers."""
        if self.careful:
            told = f"ZeroDivisionError: integer division or modulo by zero: {self.whereabouts()}"
            self.fail_if(self.put(f"icmp eq i64 {y}, 0"), self.fault(told))
        quotient, rest = self._floor_division(x, y)
        return Value("i", (rest if isinstance(op, ast.Mod) else quotient,))

    def _of_bits(self, op: ast.operator, a: Value, b: Value) -> Value:
        """Two numbers combined bit by bit."""
        kind = joined(a.kind, b.kind)
        if isinstance(op, ast.LShift | ast.RShift):
            kind = joined(kind, "i")
        if kind == "f":
            raise TranslationError("bits of a float cannot be combined")
        x, y = (self.converted(operand, kind).parts[0] for operand in (a, b))
        return Value(kind, (self.put(f"{ON_BITS[type(op)]} {parts_of(kind)[0]} {x}, {y}"),))

    def _power(self, a: Value, b: Value) -> Value:
        """a ** b; a whole power that is written as such is a product."""
        if b.kind == "i" and b.thing is not None and b.thing >= 0:
            kind, left, product = joined(a.kind, "i"), b.thing, None
            word, factor = ("fmul double" if kind == "f" else "mul i64"), self.converted(a, kind).parts[0]
            while left:
                if left & 1:
                    product = factor if product is None else self.put(f"{word} {product}, {factor}")
                left >>= 1
                if left:
                    factor = self.put(f"{word} {factor}, {factor}")
            return Value(kind, (product or ("1" if kind == "i" else number(1.0)),))
        return self._library("pow", a, b)

    def _remainder(self, x: str, y: str) -> Value:
        """x % y of floats, with the sign of y."""
        rest = self.put(f"frem double {x}, {y}")
        none = self.put(f"fcmp oeq double {rest}, {number(0.0)}")
        below, negative = (self.put(f"fcmp olt double {side}, {number(0.0)}") for side in (rest, y))
        unlike = self.put(f"xor i1 {below}, {negative}")
        moved = self.put(f"select i1 {unlike}, double {self.put(f'fadd double {rest}, {y}')}, double {rest}")
        zero = self.called("double", "llvm.copysign.f64", [("double", number(0.0)), ("double", y)])
        return Value("f", (self.put(f"select i1 {none}, double {zero}, double {moved}"),))

    def _floored(self, x: str, y: str) -> Value:
        """x // y of floats, as Python computes it."""
        rest = self._remainder(x, y).parts[0]
        share = self.put(f"fdiv double {self.put(f'fsub double {x}, {rest}')}, {y}")
        down = self.called("double", "llvm.floor.f64", [("double", share)])
        above = self.put(f"fcmp ogt double {self.put(f'fsub double {share}, {down}')}, {number(0.5)}")
        moved = self.put(f"select i1 {above}, double {self.put(f'fadd double {down}, {number(1.0)}')}, double {down}")
        sign = ("double", self.put(f"fdiv double {x}, {y}"))
        zero = self.called("double", "llvm.copysign.f64", [("double", number(0.0)), sign])
        none = self.put(f"fcmp oeq double {share}, {number(0.0)}")
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
        lower, moved = (self.put(f"select i1 {nothing}, i64 0, i64 {part}") for part in (lower, moved))
        return lower, moved

    def _library(self, name: str, *arguments: Value) -> Value:
        if len(arguments) != (2 if name in WITH_TWO else 1):
            raise TranslationError(f"{name} with {len(arguments)} arguments is not known here")
        numbers = [("double", self.converted(argument, "f").parts[0]) for argument in arguments]
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
        among = "false"
        for member in members(right):
            among = self.put(f"or i1 {among}, {self._compared(ast.Eq(), left, member)}")
        return among

    def _compared(self, op: ast.cmpop, a: Value, b: Value) -> str:
        if type(op) not in COMPARISONS or not (is_number(a.kind) and is_number(b.kind)):
            raise TranslationError(f"{said(a.kind)} and {said(b.kind)} cannot be compared like this: {SAID}")
        kind, word = joined(joined(a.kind, b.kind), "i"), COMPARISONS[type(op)]
        x, y = (self.converted(operand, kind).parts[0] for operand in (a, b))
        if kind == "f":
            return self.put(f"fcmp {'u' if word == 'ne' else 'o'}{word} double {x}, {y}")
        return self.put(f"icmp {word if word in ('eq', 'ne') else 's' + word} i64 {x}, {y}")

    def _boolop(self, node: ast.BoolOp) -> Value:
        """`and`, `or`: the first value that decides; the rest is not computed."""
        done = self.label()
        for place, operand in enumerate(node.values):
            value = self.value(operand)
            self.keep(node, value)
            if place == len(node.values) - 1:
                break
            more = self.label()
            truth = self.true(value)
            self.branch(truth, *((more, done) if isinstance(node.op, ast.And) else (done, more)))
            self.begin(more)
        self.jump(done)
        self.begin(done)
        return self.kept(node)

    def _ifexp(self, node: ast.IfExp) -> Value:
        yes, no, done = self.label(), self.label(), self.label()
        self.branch(self.truth(node.test), yes, no)
        for start, branch in ((yes, node.body), (no, node.orelse)):
            self.begin(start)
            self.keep(node, self.value(branch))
            self.jump(done)
        self.begin(done)
        return self.kept(node)

    # ---------------------------------------------------------------- elements of arrays
    def _subscript(self, node: ast.Subscript) -> Value:
        owner = self.value(node.value)
        if isinstance(owner.kind, tuple):
            at = self.value(node.slice)
            place = at.thing
            if at.kind == "i" and place is None and self.careful:
                return self._chosen(owner, node)
            if isinstance(place, int) and place < 0 and self.careful:
                place += len(owner.kind)
            if not isinstance(place, int) or not 0 <= place < len(owner.kind):
                raise TranslationError(f"'{ast.unparse(node)}': a member of a tuple is chosen by a known number")
            return members(owner)[place]
        if not is_array(owner.kind):
            raise TranslationError(f"'{ast.unparse(node)}': {said(owner.kind)} has no elements")
        if isinstance(node.slice, ast.Slice):
            return self._sliced(owner, node.slice, node)
        if owner.kind[1] == "2" and not isinstance(node.slice, ast.Tuple):
            row = self.index(node.slice, owner.parts[1])
            first = self.put(f"mul i64 {row}, {owner.parts[2]}")
            return Value(f"{owner.kind[0]}1", (self.address(owner, first), owner.parts[2]))
        return self.read(owner.kind[0], self.element(owner, node))

    def element(self, owner: Value, node: ast.Subscript) -> str:
        """The address of an element of an array.  Raises TranslationError where a constant is to be changed."""
        if owner.parts[0].startswith("@") and not isinstance(node.ctx, ast.Load):
            raise TranslationError(f"'{ast.unparse(node)}': an array from outside does not change")
        places = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        if len(places) != len(owner.parts) - 1:
            raise TranslationError(f"'{ast.unparse(node)}' is no element of {said(owner.kind)}")
        at = [self.index(index, size) for index, size in zip(places, owner.parts[1:], strict=True)]
        if len(at) == 1:
            return self.address(owner, at[0])
        return self.address(owner, self.put(f"add i64 {self.put(f'mul i64 {at[0]}, {owner.parts[2]}')}, {at[1]}"))

    def _chosen(self, owner: Value, node: ast.Subscript) -> Value:
        """The member of a tuple of numbers at a place that is computed."""
        several = members(owner)
        kind = joined(several[0].kind, several[len(several) - 1].kind) if several else NOTHING
        for value in several:
            kind = joined(kind, value.kind)
        if not is_number(kind):
            raise TranslationError(f"'{ast.unparse(node)}': a member of {said(owner.kind)} is chosen by a known number")
        place, type_ = self.index(node.slice, str(len(several))), parts_of(kind)[0]
        chosen, *others = (self.converted(value, kind).parts[0] for value in several)
        for n, other in enumerate(others, 1):
            here = self.put(f"icmp eq i64 {place}, {n}")
            chosen = self.put(f"select i1 {here}, {type_} {other}, {type_} {chosen}")
        return Value(kind, (chosen,))

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
        if called is None:
            raise TranslationError(f"'{ast.unparse(node)}': kernels are called by name")
        arguments = self._arguments(node)
        user = python_function(called)
        if user is not None:
            return self.kernel(user, self._in_order(user, arguments, node), node)
        if called in MAKING:
            return self.made_array(called, arguments, node.keywords, node)
        if node.keywords and called is not zip:  # which may be strict
            raise TranslationError(f"'{ast.unparse(node)}': kernels are called with arguments in order")
        try:
            result = self._known(called, arguments, node)
        except IndexError:
            raise TranslationError(f"'{ast.unparse(node)}': arguments are missing") from None
        return self.kernel(called, arguments, node) if result is None else result

    def _arguments(self, node: ast.Call) -> list[Value]:
        arguments = []
        for argument in node.args:
            if not isinstance(argument, ast.Starred):
                arguments.append(self.value(argument))
            elif isinstance((several := self.value(argument.value)).kind, tuple):
                arguments += members(several)
            else:
                raise TranslationError(f"'{ast.unparse(argument)}': only a tuple is passed as several arguments")
        return arguments

    def _in_order(self, user: FunctionType, arguments: list[Value], node: ast.Call) -> list[Value]:
        """The arguments of a function of the user in order, with those that have their defaults."""
        code = user.__code__
        names = code.co_varnames[: code.co_argcount + code.co_kwonlyargcount]
        values = dict(user.__kwdefaults__ or {})
        values |= zip(names[: code.co_argcount][::-1], (user.__defaults__ or ())[::-1], strict=False)
        named = {keyword.arg: self.value(keyword.value) for keyword in node.keywords}
        ordered = list(arguments)
        for name in names[len(arguments) :]:
            if name in named:
                ordered.append(named.pop(name))
            elif name in values:
                ordered.append(self._outside(values[name], node))
        if len(ordered) != len(names) or None in named or named:
            raise TranslationError(f"'{ast.unparse(node)}': its arguments are not those of {user.__name__}")
        return ordered

    def _known(self, called: object, arguments: list[Value], node: ast.Call) -> Value | None:
        """The result of a function of Python, `math` or NumPy; None if it is none of these."""
        if called in ABSOLUTE or called in INTRINSIC:
            return self._intrinsic(called, [self._of_number(argument, node) for argument in arguments])
        if called is math.log and len(arguments) == 2:
            return self.kernel(_logarithm, arguments, node)
        if called in LIBRARY:
            return self._library(LIBRARY[called], *(self._of_number(argument, node) for argument in arguments))
        if called in EXTREMES:
            return self._extreme_of(called, arguments, node)
        if called in CONVERSIONS and len(arguments) == 1:
            return self._conversion(called, arguments[0], node)
        if called in WRITTEN:
            return self.kernel(WRITTEN[called], arguments, node)
        if called is np.logical_not and len(arguments) == 1:
            return Value("b", (self.put(f"xor i1 {self.true(arguments[0])}, true"),))
        return self._of_several(called, arguments)

    def _conversion(self, called: type, argument: Value, node: ast.Call) -> Value | None:
        """The result of `float` and the like; of a text that is known, as "inf"."""
        if isinstance(argument.thing, str) and called is float:
            return known(float(argument.thing))
        return self._as(CONVERSIONS[called], self._of_number(argument, node))

    def _extreme_of(self, called: object, arguments: list[Value], node: ast.Call) -> Value:
        """The smallest or largest number of an array, of a tuple, or of the arguments."""
        if len(arguments) == 1 and is_array(arguments[0].kind):
            return self.kernel(_smallest if EXTREMES[called] == "lt" else _largest, arguments, node)
        if called not in (min, max) and len(arguments) != 1:
            raise TranslationError(f"'{ast.unparse(node)}': the second argument of NumPy is an axis")
        several = members(arguments[0]) if len(arguments) == 1 and isinstance(arguments[0].kind, tuple) else arguments
        return self._extreme(EXTREMES[called], [self._of_number(value, node) for value in several])

    def _of_several(self, called: object, arguments: list[Value]) -> Value | None:
        """The result of `len`, `enumerate` or `zip`; None if it is none of these."""
        if called is len and isinstance(arguments[0].kind, tuple):
            return known(len(arguments[0].kind))
        if called is len and is_array(arguments[0].kind):
            return Value("i", (arguments[0].parts[1],))
        if called is enumerate and isinstance(arguments[0].kind, tuple) and len(arguments) == 1:
            pairs = enumerate(members(arguments[0]))
            return self.together([self.together([known(n) or member, member]) for n, member in pairs])
        if called is zip and arguments and all(isinstance(argument.kind, tuple) for argument in arguments):
            return self.together([self.together(some) for some in zip(*map(members, arguments), strict=False)])
        return None

    def _of_number(self, value: Value, node: ast.expr) -> Value:
        if not is_number(value.kind):
            raise TranslationError(
                f"'{ast.unparse(node)}' is computed from {said(value.kind)}; a number is needed here"
            )
        return value

    def _intrinsic(self, called: object, arguments: list[Value]) -> Value:
        if arguments[0].kind != "f" and (called in ABSOLUTE or called in WHOLE):
            x = self.converted(arguments[0], "i").parts[0]
            if called in WHOLE:
                return Value("i", (x,))
            below = self.put(f"icmp slt i64 {x}, 0")
            return Value("i", (self.put(f"select i1 {below}, i64 {self.put(f'sub i64 0, {x}')}, i64 {x}"),))
        name = "fabs" if called in ABSOLUTE else INTRINSIC[called]
        if len(arguments) != (2 if name in WITH_TWO else 1):
            raise TranslationError(f"{name} with {len(arguments)} arguments is not known here")
        numbers = [("double", self.converted(argument, "f").parts[0]) for argument in arguments]
        result = Value("f", (self.called("double", f"llvm.{name}.f64", numbers),))
        return self.whole_number(result) if called in WHOLE else result

    def _extreme(self, word: str, values: list[Value]) -> Value:
        """The largest or smallest of several numbers, as Python finds it, also with nan."""
        kind: Kind = "i"
        for value in values:
            kind = joined(kind, value.kind)
        word = ("fcmp o" if kind == "f" else "icmp s") + word
        type_ = parts_of(kind)[0]
        best, *others = (self.converted(value, kind).parts[0] for value in values)
        for other in others:
            best = self.put(f"select i1 {self.put(f'{word} {type_} {other}, {best}')}, {type_} {other}, {type_} {best}")
        return Value(kind, (best,))

    def _as(self, kind: str, value: Value) -> Value:
        if kind == "b":
            return Value("b", (self.true(value),))
        if kind == "i" and value.kind == "f":
            return self.whole_number(value)
        return self.converted(value, kind)

    @abstractmethod
    def kernel(self, called: object, arguments: list[Value], node: ast.Call) -> Value:
        """The result of another compiled function."""

    @abstractmethod
    def made_array(
        self, called: object, arguments: list[Value], keywords: Sequence[ast.keyword], node: ast.Call
    ) -> Value:
        """The array that a call of NumPy makes."""
