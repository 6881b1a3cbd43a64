"""The map of the sources: rooms and modules, families of kernels, the life of a run, the arrays of a run."""

from __future__ import annotations

import ast
from itertools import groupby
from pathlib import Path

from making.text import code, fence, paragraph, table
from making.tree import PACKAGE, Source, definition, module_with, source_of, sources, trailing_comments

ARRAYS = "FIELDS"  # the list of the arrays of a run
STEPS = (  # one function of each stage of a run, in the order in which they are called
    ("The command line reads its words", ("run", "warmup")),
    ("Text becomes a document with the line of every entry", ("parse", "point_out")),
    ("The document is checked, all problems at once, and becomes a frozen model in SI units", ("read", "METHODS")),
    ("The model becomes flat arrays", ("compile_system",)),
    ("The mechanism is put together: positions, then rates", ("assemble",)),
    ("The analysis makes the memory of a run and calls the steppers piece by piece", ("simulate", "output_times")),
    ("Step after step, with contacts and switches located", ("advance", "finish_step")),
    ("Everything at one instant: bodies, rows, loads, accelerations", ("solve_motion", "derivative")),
    ("Rows become multipliers: the sparse factor", ("factorise", "analyse")),
    ("What was recorded gets names and units", ("columns", "quantities")),
    ("How far to trust it: constraints, energy, a second run", ("agreement",)),
    ("Numbers, names, units, trust", ("Result", "Trust")),
)


def pages(folder: Path) -> dict[str, str]:
    """Pieces of the map."""
    listing = fence(leaf(), "python") + "\n"
    return {"rooms": rooms(), "run": life(), "families": families(), "workspace": workspace(), "leaf": listing}


LEAF = '''"""Drag of a body: F = -c |v| v at the mass centre, power -c |v|^3."""

from __future__ import annotations

import math

{imports}


@kernel("load")
def drag(t, body, a, b, p, k, force, energy):
    c = p[k]
    vx, vy = body[b, VX], body[b, VY]
    speed = math.sqrt(vx * vx + vy * vy)
    force[b, X] -= c * speed * vx
    force[b, Y] -= c * speed * vy
    energy[DISSIPATED] += c * speed * speed * speed


@kind("load", "drag", drag)
class Drag:
    """Drag that grows with the square of the speed of the mass centre.

    Source: definition.
    """

    body = Field("", "body that is braked", shape="body")
    c = Field("kg/m", "force per square of the speed", live=True)
'''


def leaf() -> str:
    """A whole leaf file, with the imports that it needs where the package keeps them."""
    homes: dict[str, list[str]] = {}
    for name, beside in (("Field", "Kind"), ("kernel", "compiled"), ("kind", "Kind"), ("DISSIPATED", "POTENTIAL"),
                         ("VX", "PHI"), ("VY", "PHI"), ("X", "PHI"), ("Y", "PHI")):  # fmt: skip
        homes.setdefault(source_of(name, beside).name, []).append(name)  # two names tell modules apart that share one
    lines = (f"from {home} import {', '.join(names)}" for home, names in sorted(homes.items()))
    return LEAF.format(imports="\n".join(lines))


def rooms() -> str:
    """Every folder with its modules and the first sentence of each."""
    parts = []
    listed = sorted(sources().values(), key=lambda one: (one.path.parent != PACKAGE, one.path.parent, one.path.name))
    for folder, modules in groupby(listed, key=lambda one: one.path.parent):
        files = list(modules)
        name = folder.relative_to(PACKAGE.parent).as_posix()
        own = next((one.summary for one in files if one.path.name == "__init__.py"), "")
        rows = [(code(one.path.name), paragraph(one.summary)) for one in files if one.path.name != "__init__.py"]
        parts += [f"### {name}/", paragraph(own), table(("module", "what it is"), rows) if rows else ""]
    return "\n\n".join(part for part in parts if part) + "\n"


def life() -> str:
    """The stages of a run with the module of each."""
    rows = [
        (str(n), words, code(names[0]), code(source_of(*names).shown))
        for n, (words, names) in enumerate(STEPS, start=1)
    ]
    return table(("", "stage", "where it begins", "module"), rows) + "\n"


def families() -> str:
    """Kernel signatures, with what their letters mean."""
    source = source_of("SIGNATURE")
    node = definition(source, "SIGNATURE")
    comments = trailing_comments(source, node.lineno, node.end_lineno or node.lineno)
    signatures = module_with("SIGNATURE").SIGNATURE
    lines = {one.value: one.lineno for one in getattr(node.value, "keys", [])}  # type: ignore[attr-defined]
    rows = [
        (code(name), code(", ".join(kinds[1:])), code(kinds[0]), paragraph(comments.get(lines[name], "")))
        for name, kinds in signatures.items()
    ]
    return table(("family", "arguments", "result", "what they are"), rows) + "\n"


def workspace() -> str:
    """Arrays of a run by name, kind and meaning, in the parts that the list has."""
    source, node = _list_of_arrays()
    parts: list[str] = []
    rows: list[tuple[str, str, str]] = []
    for _, (name, kind, said) in _arrays(source, node):
        if name:
            rows.append((code(name), code(kind), paragraph(said)))
            continue
        parts += [table(("array", "kind", "what it holds"), rows)] if rows else []
        parts += [f"**{paragraph(said[:1].upper() + said[1:])}**"]
        rows = []
    return "\n\n".join([*parts, table(("array", "kind", "what it holds"), rows)]) + "\n"


def _list_of_arrays() -> tuple[Source, ast.Dict]:
    """The table of all arrays: the longest table of that name."""
    tables = [
        (one, getattr(definition(one, ARRAYS), "value", None)) for one in sources().values() if ARRAYS in one.names
    ]
    return max(((one, node) for one, node in tables if isinstance(node, ast.Dict)), key=lambda pair: len(pair[1].keys))


def _arrays(source: Source, node: ast.Dict) -> list[tuple[int, tuple[str, str, str]]]:
    """(line, (name, kind, comment)) of every array; a comment on a line of its own has no name."""
    comments = trailing_comments(source, node.lineno, node.end_lineno or node.lineno)
    found = []
    for key, value in zip(node.keys, node.values, strict=True):
        name = ast.literal_eval(key) if key else ""
        kind = value.value if isinstance(value, ast.Constant) else ast.unparse(value)
        found.append((value.lineno, (str(name), str(kind), comments.get(value.end_lineno or 0, ""))))
    lines = source.path.read_text(encoding="utf-8").splitlines()
    for number in range(node.lineno, (node.end_lineno or node.lineno) + 1):
        if lines[number - 1].strip().startswith("# "):
            found.append((number, ("", "", lines[number - 1].strip()[2:])))
    return sorted(found)
