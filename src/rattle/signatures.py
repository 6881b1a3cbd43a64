"""Write asked.pyi, in which editors and type checks find the methods that questions add: `make signatures`.

The declarations are read as texts, so that a signature is the one that was written, overloads and docstring included.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

from rattle.question import Question, asked_of

STUB = Path(__file__).with_name("asked.pyi")
HEAD = '''"""Methods that questions add; written by `python -m rattle.signatures` from their declarations."""
'''
CLASSES = {"OfMechanism": "mechanism", "OfResult": "result"}
INSIDE = "rattle.question", "rattle.asked"  # what a declaration imports and a signature does not


def stub() -> str:
    """The text of asked.pyi."""
    imports: dict[str, set[str]] = {}
    classes = []
    for name, what in CLASSES.items():
        methods = [_method(question, imports) for question in asked_of(what).values()]
        classes.append(f"class {name}:\n" + "\n".join(methods))
    lines = sorted(_import(module, names) for module, names in imports.items())
    return "\n".join([HEAD, *lines, "", *classes])


def _method(question: Question, imports: dict[str, set[str]]) -> str:
    """A question as a method, all its overloads; what its types need is added to the imports."""
    path = Path(question.answer.__code__.co_filename)
    tree = ast.parse(path.read_text(encoding="utf-8"))
    functions = [node for node in tree.body if isinstance(node, ast.FunctionDef) and node.name == question.name]
    types = {node.id for function in functions for part in _types(function) for node in ast.walk(part)
             if isinstance(node, ast.Name)}  # fmt: skip
    for module, name, shown in _imported(tree):
        if shown in types and module not in INSIDE:
            imports.setdefault(module, set()).add(name if name == shown else f"{name} as {shown}")
    if len(functions) > 1:
        imports.setdefault("typing", set()).add("overload")
    return "\n".join(_signature(function, len(functions) > 1) for function in functions if _stands(function, functions))


def _stands(function: ast.FunctionDef, functions: Sequence[ast.FunctionDef]) -> bool:
    """True unless it is what answers behind overloads, which a stub does not hold."""
    return len(functions) == 1 or function is not functions[-1]


def _signature(function: ast.FunctionDef, overloaded: bool) -> str:
    arguments = function.args
    arguments.args[0] = ast.arg("self")
    text = ast.get_docstring(function)
    body: list[ast.stmt] = [ast.Expr(ast.Constant(text))] if text else []
    shown = ast.FunctionDef(
        function.name, arguments, [*body, ast.Expr(ast.Constant(...))],
        [ast.Name("overload")] if overloaded else [], function.returns, lineno=0,
    )  # fmt: skip
    return "\n".join(f"    {line}".rstrip() for line in ast.unparse(ast.fix_missing_locations(shown)).splitlines())


def _types(function: ast.FunctionDef) -> Iterator[ast.expr]:
    """The types of its arguments, without the mechanism itself, and of what it returns."""
    takes = function.args
    every = [*takes.args[1:], *takes.kwonlyargs, *filter(None, (takes.vararg, takes.kwarg))]
    yield from (one.annotation for one in every if one.annotation is not None)
    if function.returns is not None:
        yield function.returns


def _imported(tree: ast.Module) -> Iterator[tuple[str, str, str]]:
    """Module, name there and name here of all that a declaration imports at its top; "" for whole modules."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.col_offset <= 4 and node.module is not None:
            yield from ((node.module, alias.name, alias.asname or alias.name) for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from (("", alias.name, alias.asname or alias.name) for alias in node.names)


def _import(module: str, names: set[str]) -> str:
    listed = ", ".join(sorted(names))
    return f"from {module} import {listed}" if module else "\n".join(f"import {name}" for name in sorted(names))


if __name__ == "__main__":
    STUB.write_text(stub(), encoding="utf-8")
    sys.stdout.write(f"{STUB}\n")
