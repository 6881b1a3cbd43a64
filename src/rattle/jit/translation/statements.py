"""Statements of kernels, and whole functions, in LLVM's language.

A function that only others of its unit call returns a structure: 0, or 1 if it failed, then the parts of its result.
A function that is called by its address gets the place of the result, then its arguments: numbers, workspaces by their
address, arrays by the address of their first number and their shape.  It returns 0, or 1 if it failed; `rattle.fault`
has been told why.
"""

from __future__ import annotations

import ast
import builtins
from collections.abc import Sequence

from rattle.jit.families import Kind
from rattle.jit.translation.calls import Calls, structure
from rattle.jit.translation.expressions import SAID
from rattle.jit.translation.local_arrays import MAKING, has_array
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
from rattle.jit.translation.writing import FAILED, ZEROS, Unit
from rattle.value_types import Plain

MOST = 20  # times that a function is written again


class Function(Calls):
    """One function for arguments of given kinds."""

    def __init__(
        self,
        unit: Unit,
        function: Plain,
        tree: ast.FunctionDef,
        kinds: Sequence[Kind],
        careful: bool = False,
    ) -> None:
        super().__init__(unit, function, careful)
        self.tree, self.given = tree, tuple(kinds)
        self.names = [argument.arg for argument in (*tree.args.posonlyargs, *tree.args.args, *tree.args.kwonlyargs)]
        self.assigned = {
            node.id for node in ast.walk(tree) if isinstance(node, ast.Name) and not isinstance(node.ctx, ast.Load)
        }
        self.outer = False  # whether it is called by its address

    def written(self, name: str, outer: Kind | None = None) -> str:
        """The text of the function.  outer: kind of its result if it is called by its address."""
        if len(self.names) != len(self.given) or self.tree.args.vararg or self.tree.args.kwarg:
            raise TranslationError(f"{len(self.names)} arguments are expected, {len(self.given)} are given")
        self.outer = outer is not None
        if self.outer:
            self.result = outer or None
        for _ in range(MOST):
            self.restart()
            parameters = self._parameters()
            for node in self.tree.body:
                self.statement(node)
            if self.open:
                self._left(Value(NOTHING))
            if self.fails:
                self.begin(FAILED)
                self.end(self._failure())
            if not self.changed:
                head = f'define {"i32" if self.outer else f"internal {self.whole()}"} @"{name}"'
                first = f"{head}({', '.join(['ptr %result'] * self.outer + parameters)}) #0 {{"
                return "\n".join([first, "entry:", *self.stack(), *self.lines, "}\n"])
        raise TranslationError("the kinds of its variables do not become stable")

    def _parameters(self) -> list[str]:
        """Parameters in LLVM's text; the arguments become variables."""
        parameters = []
        for place, (kind, name) in enumerate(zip(self.given, self.names, strict=True)):
            types = parts_of(kind)
            parts = tuple(f"%a{place}.{n}" for n in range(len(types)))
            if name in self.assigned:
                self.keep(name, Value(kind, parts))
            else:
                self.fixed[name] = Value(kind, parts)
            parameters += [f"{type_} {part}" for type_, part in zip(types, parts, strict=True)]
        return parameters

    def whole(self) -> str:
        """LLVM's type of the result for calls within the unit."""
        return f"{{ {', '.join(['i32', *parts_of(self.result or NOTHING)])} }}"

    def _failure(self) -> str:
        """The instruction that returns without a result."""
        if self.outer:
            return "ret i32 1"
        zeros = ", ".join(f"{part} {ZEROS[part]}" for part in parts_of(self.result or NOTHING))
        return f"ret {self.whole()} {{ i32 1{', ' * bool(zeros)}{zeros} }}"

    def _left(self, value: Value) -> None:
        """Return from the function."""
        if self.careful and value.kind == NOTHING and self.result:
            raise TranslationError("there is a way to its end without a value to return")
        kind = self.result if value.kind == NOTHING and self.result else joined(self.result or value.kind, value.kind)
        if kind != (self.result or NOTHING):
            if self.outer:
                raise TranslationError(f"it returns {said(kind)}, not {said(self.result or NOTHING)}")
            self.changed |= self.result is not None
            self.result = kind
        parts = [ZEROS[part] for part in parts_of(kind)]  # where the end is reached without a value
        if value.kind != NOTHING or kind == NOTHING:
            parts = list(self.converted(value, kind).parts)
        if self.outer:
            self._return_to_caller(kind, parts)
        else:
            self._return_inside(kind, parts)

    def _return_inside(self, kind: Kind, parts: Sequence[str]) -> None:
        """Return within the unit: a structure of the status and the result."""
        returned = "{ i32 0" + "".join(f", {part} undef" for part in parts_of(kind)) + " }"
        for n, (type_, part) in enumerate(zip(parts_of(kind), parts, strict=True)):
            returned = self.put(f"insertvalue {self.whole()} {returned}, {type_} {part}, {n + 1}")
        self.end(f"ret {self.whole()} {returned}")

    def _return_to_caller(self, kind: Kind, parts: Sequence[str]) -> None:
        """Return from a function that is called by its address: the result goes to its place."""
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
        method = getattr(self, f"_{type(node).__name__.lower()}_", None)
        if method is None:
            raise TranslationError(f"'{ast.unparse(node).splitlines()[0]}' is not known here: {SAID}")
        method(node)

    def _all(self, nodes: Sequence[ast.stmt]) -> None:
        for node in nodes:
            self.statement(node)

    def _expr_(self, node: ast.Expr) -> None:
        if not isinstance(node.value, ast.Constant):  # a docstring
            self.value(node.value)

    def _pass_(self, node: ast.Pass) -> None:
        """Nothing."""

    def _return_(self, node: ast.Return) -> None:
        value = Value(NOTHING) if node.value is None else self.value(node.value)
        if self.careful and has_array(value.kind):
            if not self._makes(node.value) or value.kind[1] != "1":
                raise TranslationError(f"'{ast.unparse(node)}': {said(value.kind)} cannot be returned here")
            value = self._unpacked(value, int(value.parts[1]))
        self._left(value)

    def _makes(self, node: ast.expr | None) -> bool:
        """True for a call of NumPy that makes an array."""
        return isinstance(node, ast.Call) and self.value(node.func).thing in MAKING

    def _assign_(self, node: ast.Assign) -> None:
        value = self.value(node.value)
        self.require_own(value, node.value, self._makes(node.value) and len(node.targets) == 1)
        for target in node.targets:
            self._set(target, value)

    def _annassign_(self, node: ast.AnnAssign) -> None:
        if node.value is not None:
            value = self.value(node.value)
            self.require_own(value, node.value, self._makes(node.value))
            self._set(node.target, value)

    def _unpacked(self, array: Value, count: int) -> Value:
        """The numbers of a vector as a tuple; it must have as many."""
        wrong = self.put(f"icmp ne i64 {array.parts[1]}, {count}")
        self.fail_if(wrong, self.fault(f"ValueError: {count} numbers are expected: {self.whereabouts()}"))
        return self.together([self.read(array.kind[0], self.address(array, str(n))) for n in range(count)])

    def _set(self, target: ast.expr, value: Value) -> None:
        """Assign a value to a variable, an element of an array, or to several of them."""
        if isinstance(target, ast.Name):
            if value.kind == NOTHING:
                raise TranslationError(f"'{target.id}' gets no value")
            self.keep(target.id, value)
        elif isinstance(target, ast.Tuple | ast.List) and self.careful and value.kind in ("f1", "i1"):
            self._set(target, self._unpacked(value, len(target.elts)))
        elif (
            isinstance(target, ast.Tuple | ast.List)
            and isinstance(value.kind, tuple)
            and len(target.elts) == len(value.kind)
        ):
            for element, part in zip(target.elts, members(value), strict=True):
                self._set(element, part)
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

    # ---------------------------------------------------------------- failures
    def _raise_(self, node: ast.Raise) -> None:
        raised = node.exc.func if isinstance(node.exc, ast.Call) else node.exc
        name = ast.unparse(raised) if raised is not None else ""
        known_here = isinstance(kind := getattr(builtins, name, None), type) and issubclass(kind, Exception)
        words = [argument.value for argument in getattr(node.exc, "args", ()) if isinstance(argument, ast.Constant)]
        told = f"{name if known_here else 'RuntimeError'}: {str(words[0]) if words else ast.unparse(node)}"
        self.fail(self.fault(f"{told} ({self.whereabouts()})"))

    def _assert_(self, node: ast.Assert) -> None:
        wrong = self.put(f"xor i1 {self.truth(node.test)}, true")
        self.fail_if(wrong, self.fault(f"AssertionError: {self.whereabouts()}"))

    def _try_(self, node: ast.Try) -> None:
        """What is done if a law of the user fails."""
        if self.careful or len(node.handlers) != 1 or node.orelse or node.finalbody:
            raise TranslationError("'try' is not known here: machine code divides by zero without an exception")
        handler, done = self.label(), self.label()
        self.handlers.append(handler)
        self._all(node.body)
        self.handlers.pop()
        reached = self.open
        self.jump(done)
        self.begin(handler)
        self._all(node.handlers[0].body)
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
            self._counted(node)
            return
        over = self.value(node.iter)
        if over.kind in ("f1", "i1"):
            self._counted(node, over)
            return
        if not isinstance(over.kind, tuple):
            raise TranslationError(f"'{ast.unparse(node.iter)}': a loop goes over a range, a tuple or a vector")
        done = self.label()
        for member in members(over):
            following = self.label()
            start = self.label()
            self.jump(start)
            self.begin(start)
            self.require_own(member, node.iter, False)
            self._set(node.target, member)
            body = self.label()
            self.jump(body)
            self._turn(body, following, done, node)
            self.jump(following)
            self.begin(following)
        self.jump(done)
        self.begin(done)

    def _counted(self, node: ast.For, over: Value | None = None) -> None:
        """A loop over a range, or over the numbers of a vector."""
        if over is None and isinstance(node.iter, ast.Call):
            numbers = [self.converted(self.number(argument), "i") for argument in node.iter.args]
        elif over is not None:
            numbers = [Value("i", (over.parts[1],))]
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
        if over is not None:
            now = self.read(over.kind[0], self.address(over, now.parts[0]))
        self._set(node.target, now)
        inside = self.label()
        self.jump(inside)
        self._turn(inside, again, done, node)
        self.jump(again)
        self.begin(again)
        self.keep(node, Value("i", (self.put(f"add i64 {self.kept(node).parts[0]}, {step.parts[0]}"),)))
        self.jump(test)
        self.begin(done)
