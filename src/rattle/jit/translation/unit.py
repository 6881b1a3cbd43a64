"""Functions that are translated and compiled together: one that is called by its address, and all that it contains."""

from __future__ import annotations
import __future__

import ast
import functools
import hashlib
import itertools
import linecache
import math
import os
import re
import textwrap
from collections import Counter
from collections.abc import Callable, Sequence
from inspect import isfunction
from types import CodeType
from typing import Any, NamedTuple

import llvmlite.binding as llvm
import numpy as np

from rattle.jit import machine
from rattle.jit.families import Kind
from rattle.jit.translation.calls import kinds_of, letters_of
from rattle.jit.translation.statements import Function
from rattle.jit.translation.values import TranslationError, Value, number
from rattle.jit.workspace import ARRAYS
from rattle.value_types import Plain

PLACES = {name: (place, array.kind) for place, (name, array) in enumerate(ARRAYS.items())}
FLOATS, WHOLE = ("double", number), ("i64", str)  # LLVM's type, and how a number is written
# the same for all functions: what may share memory, what is seldom
ABOUT = """
attributes #0 = { nounwind }
attributes #1 = { nounwind alwaysinline }
!0 = !{!"numbers"}
!1 = !{!"float", !0}
!2 = !{!1, !1, i64 0}
!6 = !{!"integer", !0}
!3 = !{!6, !6, i64 0}
!4 = !{}
!5 = !{!"branch_weights", i32 1, i32 1000}
"""


class Unit:
    """What one function needs besides its own text; see `writing.Unit`."""

    def __init__(self) -> None:
        self.checks = os.environ.get("RATTLE_BOUNDSCHECK", "0") not in ("", "0")
        self.arrays = PLACES
        self.declared: dict[str, str] = {}  # text by name: functions from outside, constants
        self.parts: dict[str, Part] = {}  # by name

    def constant(self, array: np.ndarray) -> Value:
        """An array that does not change.  Raises TranslationError if it is not one of numbers."""
        whole = array.dtype.kind in "iub"
        if array.ndim not in (1, 2) or array.dtype.kind not in "iubf":
            raise TranslationError(f"an array of {array.dtype} with {array.ndim} dimensions is not known here")
        kept = np.ascontiguousarray(array, np.int64 if whole else np.float64)
        type_, write = WHOLE if whole else FLOATS
        numbers = ", ".join(f"{type_} {write(entry)}" for entry in kept.ravel().tolist())
        name = self._named(f"private constant [{kept.size} x {type_}] [{numbers}], align 16")
        return Value(f"{'i' if whole else 'f'}{kept.ndim}", (name, *map(str, kept.shape)))

    def text(self, words: str) -> str:
        """The address of a text."""
        code = words.encode() + b"\0"
        written = "".join(f"\\{byte:02X}" for byte in code)
        return self._named(f'private constant [{len(code)} x i8] c"{written}"')

    def _named(self, what: str) -> str:
        """The name of a constant."""
        name = f"@constant.{hashlib.sha256(what.encode()).hexdigest()[:16]}"
        self.declared[name] = f"{name} = {what}"
        return name

    def declare(self, name: str, line: str) -> None:
        """Something from outside that functions use."""
        self.declared[name] = line

    def part(self, called: Any, kinds: Sequence[Kind]) -> tuple[str, Kind, bool]:
        """Another function for arguments of these kinds: its name, the kind of its result, whether it may fail."""
        key, parts = (called, tuple(kinds), self.checks), _users_parts if isfunction(called) else _parts
        if key not in parts:
            if key in _under_way:
                raise TranslationError(f"{called.__name__} calls itself; a function that does needs fixed types")
            _under_way.append(key)
            try:
                name = f"{called.__module__}.{called.__name__}.{next(_numbers)}"
                translation = function(Unit(), getattr(called, "python", called), kinds, careful=isfunction(called))
                text = told_where(translation, lambda: translation.written(name))
                parts[key] = Part(
                    name,
                    translation.result if translation.result is not None else "",
                    translation.fails,
                    text,
                    translation.unit,
                )
            finally:
                _under_way.pop()
        part = parts[key]
        self.parts[part.name] = part
        return part.name, part.result, part.fails

    def whole(self, text: str) -> str:
        """The text of a function with all that it needs."""
        needed, ahead, declared = {}, list(self.parts.values()), dict(self.declared)
        while ahead:
            part = ahead.pop()
            if part.name not in needed:
                needed[part.name] = part.text
                declared |= part.unit.declared
                ahead += part.unit.parts.values()
        calls = Counter(_NAMED.findall("\n".join([*needed.values(), text])))  # and one for its own text
        inside = [
            part.replace(") #0 {", ") #1 {", 1) if part.count("\n") < SMALL or calls[name] == 2 else part
            for name, part in needed.items()
        ]
        return "\n".join([*declared.values(), *inside, text, ABOUT])


FUTURE = functools.reduce(
    lambda a, b: a | b, (getattr(__future__, name).compiler_flag for name in __future__.all_feature_names)
)
SMALL = 100  # lines of a function that becomes part of others, however many they are
_NAMED = re.compile(r'@"([^"]+)"\(')


class Part(NamedTuple):
    """A function for arguments of some kinds, as others contain it."""

    name: str
    result: Kind  # kind
    fails: bool
    text: str
    unit: Any


_parts: dict[object, Part] = {}  # by function and kinds: written once in a process
_users_parts: dict[object, Part] = {}  # those of functions of users, for one translation: what they use may change
_under_way: list[object] = []
_numbers = itertools.count()  # parts of one name are told apart, also where one contains another


def function(unit: Unit, python: Plain, kinds: Sequence[Kind], careful: bool = False) -> Function:
    """A function that is to be translated, with its source; careful: it is not a kernel but written by a user."""
    tree = source(python)
    if careful and not hasattr(python, "source"):
        _require_loaded(python, tree)
    return Function(unit, python, tree, kinds, careful)


def told_where(translation: Function, write: Callable[[], str]) -> str:
    """The text of a function; an error says where it is."""
    try:
        return write()
    except TranslationError as error:
        if ", line " in str(error):
            raise
        python = translation.function
        raise TranslationError(f"{python.__module__}.{python.__name__}, line {translation.place}: {error}") from None


def translated(python: Plain, symbol: str, letters: Sequence[str]) -> str:
    """The text in LLVM's language of a function with fixed types, and of all that it contains.

    Raises TranslationError for what kernels cannot use, with the place.
    """
    _users_parts.clear()
    unit = Unit()
    result, kinds = kinds_of(letters)
    translation = function(unit, python, kinds)
    return unit.whole(told_where(translation, lambda: translation.written(symbol, outer=result)))


def with_result(python: Plain, kinds: Sequence[Kind] | None) -> tuple[str, ...]:
    """The letters of a function for arguments of these kinds; its result follows from its text."""
    if kinds is None:
        raise TranslationError(f"{python.__name__} takes numbers and contiguous arrays of float64 or int64")
    _users_parts.clear()
    translation = function(Unit(), python, kinds)
    told_where(translation, lambda: translation.written("any"))
    return letters_of(translation.result or "", kinds)


def native(python: Plain, symbol: str, letters: Sequence[str]) -> machine.Code:
    """Machine code of a function with fixed types, to be called by its address."""
    return _compiled(translated(python, symbol, letters), symbol)


def for_kinds(python: Plain, symbol: str, kinds: Sequence[Kind] | None) -> tuple[tuple[str, ...], machine.Code]:
    """Letters and machine code of a function for arguments of these kinds, to be called by its address."""
    letters = with_result(python, kinds)
    return letters, native(python, symbol, letters)


def _compiled(text: str, symbol: str) -> machine.Code:
    """Machine code of a text.

    Small functions, and those called once, become part of what calls them before anything else is done; then each
    function is simplified once.  LLVM's usual way, which decides that as it simplifies, took half as long again.
    So did unrolled and vectorised loops, and made a run no faster: most go over three coordinates or a few bodies.
    """
    module, target = machine.parsed(text), machine.target()
    needs = [part.name for part in (*module.functions, *module.global_variables) if part.is_declaration]
    module.triple, module.data_layout = llvm.get_process_triple(), str(target.target_data)
    options = llvm.create_pipeline_tuning_options(speed_level=1)
    options.loop_unrolling = options.loop_vectorization = options.slp_vectorization = False
    builder, together = llvm.create_pass_builder(target, options), llvm.create_new_module_pass_manager()
    together.add_sroa_pass()
    together.add_simplify_cfg_pass()
    together.add_always_inliner_pass()
    together.add_post_order_function_attributes_pass()
    together.run(module, builder)
    each = builder.getFunctionPassManager()
    for part in module.functions:
        if not part.is_declaration:
            each.run(part, builder)
    object_code = bytes(target.emit_object(module))
    return machine.Code(symbol, object_code, tuple(name for name in needs if not name.startswith("llvm.")))


# ---------------------------------------------------------------- a small test
def _look_up(table: np.ndarray, k: int) -> float:
    value = math.inf
    for n in range(table.shape[0]):
        if n == k:
            value = 2.0 * table[n, 1]
    return value + 1.0


def check() -> None:
    """Translate, compile and call a small function.  Raises whatever this version of LLVM raises."""
    letters = ("f", "m", "i")
    call = machine.caller("look up", machine.load(native(_look_up, "rattle.look_up", letters)), letters)
    if call(np.array([[0.0, 1.0], [2.0, 3.0]]), 1) != 7.0:
        raise RuntimeError("a small function gives a wrong number")


# ---------------------------------------------------------------- sources
def source(python: Plain) -> ast.FunctionDef:
    """The syntax tree of a function.  Raises TranslationError if its source is not there."""
    code: Any = getattr(python, "__code__", None)
    if code is not None:
        linecache.checkcache(code.co_filename)
    lines = getattr(python, "source", None) or (
        [] if code is None else linecache.getlines(code.co_filename, python.__globals__)
    )
    if not lines:
        place = f"{python.__module__}.{python.__name__}, line {getattr(code, 'co_firstlineno', 0)}"
        raise TranslationError(f"{place}: its source is not there")
    first = code.co_firstlineno
    if python.__name__ == "<lambda>":
        return _source_of_lambda(python, "".join(lines), first)
    last = max(end for _, end, _, _ in code.co_positions() if end is not None)  # lines after it hold brackets at most
    while True:
        try:
            tree = ast.parse(textwrap.dedent("".join(lines[first - 1 : last]))).body[0]
            break
        except SyntaxError:
            if last == len(lines):
                raise
            last += 1
    if not isinstance(tree, ast.FunctionDef):
        raise TranslationError(f"{python.__name__} is not written as a function of its own")
    return tree


def _require_loaded(python: Plain, tree: ast.FunctionDef) -> None:
    """Refuse a function whose source is no longer the one that Python has loaded.

    Functions with `assert` are let pass: tools that run tests load something else than their source.
    """
    code: CodeType = python.__code__
    if any(isinstance(node, ast.Assert) for node in ast.walk(tree)):
        return
    text = "".join(linecache.getlines(code.co_filename, getattr(python, "__globals__", None)))
    flags = code.co_flags & FUTURE
    try:
        ahead = [compile(text, code.co_filename, "exec", flags, dont_inherit=True)]
    except (SyntaxError, ValueError):
        ahead = []
    while ahead:
        node = ahead.pop()
        if node.co_name == code.co_name and node.co_firstlineno == code.co_firstlineno and _alike(node, code):
            return
        ahead += [part for part in node.co_consts if isinstance(part, CodeType)]
    raise TranslationError("its source is not the one that was loaded: it was changed since")


def _alike(first: CodeType, other: CodeType) -> bool:
    """True for the same instructions on the same names and constants."""
    parts = [[repr(x) for x in code.co_consts if not isinstance(x, CodeType)] for code in (first, other)]
    return first.co_code == other.co_code and first.co_names == other.co_names and parts[0] == parts[1]


def _source_of_lambda(python: Plain, text: str, line: int) -> ast.FunctionDef:
    """The same for a lambda that is the only one of its line with these arguments."""
    names = python.__code__.co_varnames[: python.__code__.co_argcount]
    lambdas = [
        node
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Lambda) and node.lineno == line and tuple(arg.arg for arg in node.args.args) == names
    ]
    if len(lambdas) != 1:
        raise TranslationError(f"line {line} has several functions without a name")
    tree = ast.FunctionDef("lambda", lambdas[0].args, [ast.Return(lambdas[0].body, lineno=1)], [])
    for part in ast.walk(tree):
        if isinstance(part, ast.expr):
            part.lineno -= line - 1
    return tree
