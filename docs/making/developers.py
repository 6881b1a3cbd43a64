"""The map of the sources: rooms and modules, families of kernels, the life of a run, the arrays of a run."""

from __future__ import annotations

from itertools import groupby
from pathlib import Path

from making.text import code, fence, paragraph, table
from making.tree import PACKAGE, definition, module_with, source_of, sources, trailing_comments

STEPS = (  # one function of each stage of a run, in the order in which they are called
    ("The command line reads its arguments", ("run", "_peaks")),
    ("Text becomes a document with the line of every entry", ("parse", "point_out")),
    (
        "The document is checked, all problems at once, and becomes a frozen model in SI units",
        ("read", "DEEPEST"),
    ),
    ("The model becomes flat arrays", ("compile_system",)),
    ("The mechanism is assembled: positions, then rates", ("assemble",)),
    ("The analysis makes the workspace of a run and integrates interval by interval", ("simulate", "output_times")),
    ("Time integration steps, with contacts and switches located", ("advance", "first_event")),
    ("The equations at one instant: bodies, constraint rows, loads, accelerations", ("solve_motion", "derivative")),
    ("Multipliers follow from the constraint rows: the sparse factor", ("factorise", "analyse")),
    ("Recorded values get names and units", ("columns", "quantities")),
    ("How far to trust it: constraints, energy, a second run", ("agreement",)),
    ("Numbers, names, units, trust", ("Result", "load_result")),
)


def pages(folder: Path) -> dict[str, str]:
    """The tables of the map, and the listing of a leaf."""
    listing = fence(leaf(), "python") + "\n"
    return {"rooms": rooms(), "run": life(), "families": families(), "workspace": workspace(), "leaf": listing}


LEAF = '''"""Drag of a body: F = -c |v| v at the mass centre, power -c |v|^3."""

from __future__ import annotations

import math

{imports}


@kernel("load")
def drag(t, body, a, b, p, k, force, energy):
    c = p[k]
    vx, vy = body[b, at.VX], body[b, at.VY]
    speed = math.sqrt(vx * vx + vy * vy)
    force[b, at.X] -= c * speed * vx
    force[b, at.Y] -= c * speed * vy
    energy[at.DISSIPATED] += c * speed * speed * speed


@kind("load", "drag", drag)
class Drag(LoadKind):
    """Drag that grows with the square of the speed of the mass centre.

    Source: definition.
    """

    body = Field("", "body on which the drag acts", shape="body")
    c = Field("kg/m", "force per square of the speed", live=True)
'''


def leaf() -> str:
    """A complete leaf file, with its imports from where the package keeps them."""
    homes: dict[str, list[str]] = {}
    for name, beside in (("LoadKind", "LoadRecord"), ("kernel", "compiled"), ("kind", "Kind")):
        homes.setdefault(source_of(name, beside).name, []).append(name)  # two names tell modules apart that share one
    homes[source_of("kind", "Kind").name].insert(0, "Field")  # it hands on what leaves declare
    columns = source_of("DISSIPATED", "POTENTIAL").name
    homes[f"{columns.rpartition('.')[0]}"] = [f"{columns.rpartition('.')[2]} as at"]
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
    return table(("family", "arguments", "result", "meaning"), rows) + "\n"


def workspace() -> str:
    """Arrays of a run by name, kind, shape, unit and meaning, and the columns of those that have named ones."""
    arrays, columns = module_with("Workspace", "ARRAYS").ARRAYS, module_with("COLUMNS", "Column").COLUMNS
    rows = [(code(name), code(one.kind), one.shape, one.unit, paragraph(one.meaning)) for name, one in arrays.items()]
    parts = [table(("array", "kind", "shape", "unit", "content"), rows)]
    for name in (one for one in arrays if one in columns):
        named = [(code(key), one.unit, paragraph(one.meaning)) for key, one in columns[name].items()]
        parts += [f"### Columns of {code(name)}", table(("column", "unit", "meaning"), named)]
    return "\n\n".join(parts) + "\n"
