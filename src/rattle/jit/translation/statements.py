"""Statements of kernels, and whole functions, in LLVM's language.

A function that only others of its unit call gets the place of an exception, then its arguments; it returns a
structure: 0, or 1 if it failed, then the parts of its result.  A function that is called by its address follows
Numba's convention, so that Numba's functions and ours may call each other: the place of the result, the place of an
exception, the arguments; it returns 0, or 1 if it failed.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Sequence
from typing import Any

from rattle.jit.translation.calls import Calls, structure
from rattle.jit.translation.expressions import SAID
from rattle.jit.translation.values import (
    NOTHING,
    TranslationError,
    Value,
    is_array,
    joined,
    members,
    parts_of,
    said,
)
from rattle.jit.translation.writing import CALLER, ZEROS, Unit

MOST = 20  # times that a function is written again


class Function(Calls):
    """One function for arguments of given kinds."""

    def __init__(self, unit: Unit, function: Callable[..., Any], tree: ast.FunctionDef, kinds: Sequence[Any]) -> None:
        super().__init__(unit, function)
        self.tree, self.given = tree, tuple(kinds)
        self.names = [one.arg for one in tree.args.args]
        self.loops: list[tuple[str, str]] = []  # where `continue` and `break` go
        self.outer = False  # whether it is called by its address

    def written(self, name: str, outer: Any = None, packed: bool = False) -> str:
        """The text of the function.

        outer: kind of its result if it is called by its address; packed: its arguments are in one piece of memory then.
        """
        if len(self.names) != len(self.given):
            raise TranslationError(f"{len(self.names)} arguments are expected, {len(self.given)} are given")
        self.outer = outer is not None
        if self.outer:
            self.result = outer or None
        for _ in range(MOST):
            self.restart()
            parameters = self._unpacked() if packed else self._parameters()
            head = f'define i32 @"{name}"(ptr %result, ' if self.outer else f'define internal {self.whole()} @"{name}"('
            for one in self.tree.body:
                self.statement(one)
            if self.open:
                self._left(Value(NOTHING))
            if not self.changed:
                first = f"{head}{', '.join([f'ptr {CALLER}', *parameters])}) #0 {{"
                return "\n".join([first, "entry:", *self.stack(), *self.lines, "}\n"])
        raise TranslationError("the kinds of its variables do not become stable")

    def _parameters(self) -> list[str]:
        """Parameters in LLVM's text; the arguments become variables."""
        parameters = []
        for place, (kind, one) in enumerate(zip(self.given, self.names, strict=True)):
            types, used = parts_of(kind), slice(None)
            if self.outer and is_array(kind):  # as `flat` passes it
                dimensions = int(kind[1])
                types, used = ["ptr", "ptr", "i64", "i64", "ptr", *["i64"] * (2 * dimensions)], slice(4, 5 + dimensions)
            parts = [f"%a{place}.{n}" for n in range(len(types))]
            self.keep(one, Value(kind, tuple(parts[used])))
            parameters += [f"{type_} {part}" for type_, part in zip(types, parts, strict=True)]
        return parameters

    def _unpacked(self) -> list[str]:
        """The same for arguments in one piece of memory, eight bytes for each part."""
        place = 0
        for kind, one in zip(self.given, self.names, strict=True):
            parts = []
            for type_ in parts_of(kind):
                at = self.put(f"getelementptr i64, ptr %arguments, i64 {place}")
                parts.append(self.put(f"load {type_}, ptr {at}, align 8"))
                place += 1
            self.keep(one, Value(kind, tuple(parts)))
        return ["ptr %arguments"]

    def whole(self) -> str:
        """LLVM's type of the result for calls within the unit."""
        return f"{{ {', '.join(['i32', *parts_of(self.result or NOTHING)])} }}"

    def failure(self) -> str:
        """The instruction that returns without a result."""
        if self.outer:
            return "ret i32 1"
        zeros = ", ".join(f"{one} {ZEROS[one]}" for one in parts_of(self.result or NOTHING))
        return f"ret {self.whole()} {{ i32 1{', ' * bool(zeros)}{zeros} }}"

    def _left(self, value: Value) -> None:
        """Return from the function."""
        kind = self.result if value.kind == NOTHING and self.result else joined(self.result or value.kind, value.kind)
        if kind != (self.result or NOTHING):
            if self.outer:
                raise TranslationError(f"it returns {said(kind)}, not {said(self.result or NOTHING)}")
            self.result, self.changed = kind, True
        parts = [ZEROS[one] for one in parts_of(kind)]  # where the end is reached without a value
        if value.kind != NOTHING or kind == NOTHING:
            parts = list(self.converted(value, kind).parts)
        if not self.outer:
            made = "{ i32 0" + "".join(f", {one} undef" for one in parts_of(kind)) + " }"
            for n, (type_, part) in enumerate(zip(parts_of(kind), parts, strict=True)):
                made = self.put(f"insertvalue {self.whole()} {made}, {type_} {part}, {n + 1}")
            self.end(f"ret {self.whole()} {made}")
            return
        for n, (type_, part) in enumerate(zip(parts_of(kind), parts, strict=True)):
            at = self.put(f"getelementptr {structure(kind)}, ptr %result, i32 0, i32 {n}")
            whole = self.put(f"zext i1 {part} to i8") if type_ == "i1" else part
            self.do(f"store {'i8' if type_ == 'i1' else type_} {whole}, ptr {at}")
        self.end("ret i32 0")

    # ---------------------------------------------------------------- statements
    def statement(self, node: ast.stmt) -> None:
        """The instructions of a statement; none where it is not reached."""
        if not self.open:
            return
        self.line = node.lineno
        made = getattr(self, f"_{type(node).__name__.lower()}_", None)
        if made is None:
            raise TranslationError(f"'{ast.unparse(node).splitlines()[0]}' is not known here: {SAID}")
        made(node)

    def _all(self, nodes: Sequence[ast.stmt]) -> None:
        for one in nodes:
            self.statement(one)

    def _expr_(self, node: ast.Expr) -> None:
        if not isinstance(node.value, ast.Constant):  # a docstring
            self.value(node.value)

    def _pass_(self, node: ast.Pass) -> None:
        """Nothing."""

    def _return_(self, node: ast.Return) -> None:
        self._left(Value(NOTHING) if node.value is None else self.value(node.value))

    def _assign_(self, node: ast.Assign) -> None:
        value = self.value(node.value)
        for one in node.targets:
            self._set(one, value)

    def _set(self, target: ast.expr, value: Value) -> None:
        """Assign a value to a variable, an element of an array, or to several of them."""
        if isinstance(target, ast.Name):
            if value.kind == NOTHING:
                raise TranslationError(f"'{target.id}' gets no value")
            self.keep(target.id, value)
        elif isinstance(target, ast.Tuple) and isinstance(value.kind, tuple) and len(target.elts) == len(value.kind):
            for one, part in zip(target.elts, members(value), strict=True):
                self._set(one, part)
        elif isinstance(target, ast.Subscript) and is_array((owner := self.value(target.value)).kind):
            self.write(owner.kind[0], self.element(owner, target), value)
        else:
            raise TranslationError(f"'{ast.unparse(target)}' cannot get {said(value.kind)}")

    def _augassign_(self, node: ast.AugAssign) -> None:
        if isinstance(node.target, ast.Name):
            self.keep(node.target.id, self.combined(node.op, self.load(node.target.id), self.number(node.value)))
        elif isinstance(node.target, ast.Subscript) and is_array((owner := self.value(node.target.value)).kind):
            address = self.element(owner, node.target)
            before = self.read(owner.kind[0], address)
            self.write(owner.kind[0], address, self.combined(node.op, before, self.number(node.value)))
        else:
            raise TranslationError(f"'{ast.unparse(node.target)}' cannot be changed")

    def _if_(self, node: ast.If) -> None:
        yes, no, done = self.label(), self.label(), self.label()
        self.branch(self.truth(node.test), yes, no)
        reached = False
        for start, body in ((yes, node.body), (no, node.orelse)):
            self.begin(start)
            self._all(body)
            reached |= self.open
            self.jump(done)
        self.begin(done)
        if not reached:
            self.end("unreachable")

    # ---------------------------------------------------------------- loops
    def _while_(self, node: ast.While) -> None:
        test, body, done = self.label(), self.label(), self.label()
        self.jump(test)
        self.begin(test)
        self.branch(self.truth(node.test), body, done)
        self._turn(body, test, done, node)
        self.jump(test)
        self.begin(done)

    def _turn(self, start: str, again: str, done: str, node: ast.While | ast.For) -> None:
        """The body of a loop."""
        if node.orelse:
            raise TranslationError("a loop with else is not known here")
        self.begin(start)
        self.loops.append((again, done))
        self._all(node.body)
        self.loops.pop()

    def _continue_(self, node: ast.Continue) -> None:
        self.jump(self.loops[len(self.loops) - 1][0])

    def _break_(self, node: ast.Break) -> None:
        self.jump(self.loops[len(self.loops) - 1][1])

    def _for_(self, node: ast.For) -> None:
        if isinstance(node.iter, ast.Call) and self.value(node.iter.func).thing is range:
            self._counted(node, node.iter.args)
            return
        over = self.value(node.iter)
        if not isinstance(over.kind, tuple):
            raise TranslationError(f"'{ast.unparse(node.iter)}': a loop goes over a range or a tuple")
        done = self.label()
        for one in members(over):
            following = self.label()
            start = self.label()
            self.jump(start)
            self.begin(start)
            self._set(node.target, one)
            body = self.label()
            self.jump(body)
            self._turn(body, following, done, node)
            self.jump(following)
            self.begin(following)
        self.jump(done)
        self.begin(done)

    def _counted(self, node: ast.For, given: Sequence[ast.expr]) -> None:
        """A loop over a range."""
        numbers = [self.converted(self.number(one), "i") for one in given]
        first, last = numbers[:2] if len(numbers) > 1 else (Value("i", ("0",), 0), numbers[0])
        step = numbers[2] if len(numbers) > 2 else Value("i", ("1",), 1)
        if not isinstance(step.thing, int) or step.thing == 0:
            raise TranslationError(f"'{ast.unparse(node.iter)}': the step of a range must be a known number")
        test, body, again, done = self.label(), self.label(), self.label(), self.label()
        self.keep(node, first)
        self.jump(test)
        self.begin(test)
        now = self.kept(node)
        word = "slt" if step.thing > 0 else "sgt"
        self.branch(self.put(f"icmp {word} i64 {now.parts[0]}, {last.parts[0]}"), body, done)
        self.begin(body)
        self._set(node.target, now)
        inside = self.label()
        self.jump(inside)
        self._turn(inside, again, done, node)
        self.jump(again)
        self.begin(again)
        self.keep(node, Value("i", (self.put(f"add i64 {self.kept(node).parts[0]}, {step.parts[0]}"),)))
        self.jump(test)
        self.begin(done)
