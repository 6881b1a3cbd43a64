"""The sources of the package: which module defines a name, and how each module describes itself.

Modules are found by what they define, so that no page names the place of a module.
"""

from __future__ import annotations

import ast
import importlib
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from types import ModuleType

import rattle

PACKAGE = Path(rattle.__file__).parent
ROOT = Path(__file__).parents[2]


@dataclass(frozen=True)
class Source:
    """One module: its dotted name, its file and what stands in it, which is parsed where it is asked for."""

    name: str
    path: Path
    content: str

    @cached_property
    def tree(self) -> ast.Module:
        """Its syntax tree."""
        return ast.parse(self.content)

    @cached_property
    def names(self) -> frozenset[str]:
        """The top-level names that it defines."""
        return frozenset(_defined(self.tree))

    @property
    def text(self) -> str:
        """Its docstring."""
        return ast.get_docstring(self.tree) or ""

    @property
    def shown(self) -> str:
        """The file as it is seen from the package's folder."""
        return self.path.relative_to(PACKAGE).as_posix()

    @property
    def summary(self) -> str:
        """First sentence of the docstring, on one line."""
        first = self.text.strip().split("\n\n")[0]
        return " ".join(first.split())


@cache
def sources() -> dict[str, Source]:
    """All modules of the package by dotted name."""
    modules = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
        name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
        modules[name] = Source(name, path, path.read_text(encoding="utf-8"))
    return modules


def _defined(tree: ast.Module) -> set[str]:
    names = set()
    for node in tree.body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            names.add(node.name)
        elif isinstance(node, ast.Assign):
            names |= {part.id for target in node.targets for part in ast.walk(target) if isinstance(part, ast.Name)}
        elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            names.add(node.target.id)
    return names


def source_of(*names: str) -> Source:
    """The one module that defines all these names.  Raises LookupError where there is none, or more than one."""
    mentioned = (module for module in sources().values() if all(name in module.content for name in names))
    modules = [module for module in mentioned if module.names.issuperset(names)]
    if len(modules) != 1:
        where = [module.name for module in modules] or "no module"
        raise LookupError(f"{' and '.join(names)}: defined together in {where}")
    return modules[0]


def module_with(*names: str) -> ModuleType:
    """The same, imported."""
    return importlib.import_module(source_of(*names).name)


def definition(source: Source, name: str) -> ast.AST:
    """The syntax tree of a name's definition in a module.  Raises LookupError."""
    for node in source.tree.body:
        targets = getattr(node, "targets", [getattr(node, "target", node)])
        if any(name in (getattr(one, "id", ""), getattr(one, "name", "")) for one in targets):
            return node
    raise LookupError(f"{source.name} does not define {name}")


def trailing_comments(source: Source, first: int, last: int) -> dict[int, str]:
    """Comments at the end of the lines of a module, by line number."""
    lines = source.path.read_text(encoding="utf-8").splitlines()
    return {
        number: lines[number - 1].rpartition("  # ")[2].strip()
        for number in range(first, last + 1)
        if "  # " in lines[number - 1]
    }
