"""What a run over many samples is known by: it is resumed only where all of this is the same."""

from __future__ import annotations

import hashlib
import inspect
import json
from collections.abc import Iterator, Mapping
from importlib import metadata

from rattle import registry
from rattle.description.file import parse
from rattle.description.model import Model
from rattle.elements.custom.law_kernel import UsersKernel
from rattle.errors import ModelError
from rattle.questions.ensemble.plans import Plan
from rattle.studies.runs.task import Task
from rattle.value_types import Json, Tree
from rattle.version import __version__

FORMAT = 1
PACKAGES = ("numpy", "scipy", "llvmlite", "numba", "pyarrow")
LABELS = {  # entries that are compared as they are, in the order in which a difference is told
    "rattle": "version of rattle",
    "kind": "kind of study",
    "analysis": "analysis",
    "outputs": "outputs",
    "histories": "histories",
    "t_end": "end of the runs t_end [s]",
    "design": "design",
    "seed": "seed",
}
LONGEST = 60  # characters of a value that a message quotes


def identity(task: Task, plan: Plan) -> dict[str, Json]:
    """All that the numbers of samples follow from, as plain data."""
    record = {
        "format": FORMAT, "rattle": __version__, **plan.description, "analysis": task.analysis,
        "outputs": task.texts, "histories": list(task.histories), "t_end": task.t_end, "how": task.how._asdict(),
        "laws": python_laws(task.mechanism.model), "model": task.mechanism.to_toml(),
    }  # fmt: skip
    return dict(json.loads(json.dumps(record)))


def versions() -> dict[str, str]:
    """Versions of the packages that take part."""
    installed = {}
    for name in PACKAGES:
        try:
            installed[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    return installed


def difference(before: Tree, now: Tree) -> str:
    """How one identity differs from another, in words; "" if it does not."""
    for key, label in LABELS.items():
        if before.get(key) != now.get(key):
            return f"its {label}: {_short(before.get(key))}, now {_short(now.get(key))}"
    if before.get("model") != now.get("model") and (words := _of_models(str(before.get("model")), str(now["model"]))):
        return words
    for key, label in (("how", "setting"), ("fields", "field of"), ("axes", "values of"), ("laws", "Python code of")):
        for path, old, new in _differing(before.get(key, {}), now.get(key, {})):
            return f"its {label} {_dotted(path) or 'parameters'}: {_short(old)}, now {_short(new)}"
    same = before.get("draw") == now.get("draw") and [*before.get("fields", {})] == [*now.get("fields", {})]
    return "" if same else "its parameters vary together or in an order in another way"


def _of_models(before: str, now: str) -> str:
    """How two model texts differ in what they say; comments and order do not count."""
    try:
        old, new = parse(before), parse(now)
    except ModelError:
        return "its model cannot be read"
    path, first, second = next(_differing(old, new), ((), None, None))
    return f"its model has {_dotted(path)}: {_short(first)}, now {_short(second)}" if path else ""


def _differing(
    old: object, new: object, path: tuple[str, ...] = ()
) -> Iterator[tuple[tuple[str, ...], object, object]]:
    """Paths in nested tables with the values that differ; None where there is none."""
    if isinstance(old, Mapping) and isinstance(new, Mapping):
        for key in dict.fromkeys([*old, *new]):
            yield from _differing(old.get(key), new.get(key), (*path, str(key)))
    elif old != new or isinstance(old, bool) != isinstance(new, bool):
        yield path, old, new


def _dotted(path: tuple[str, ...]) -> str:
    return ".".join(path)


def _short(value: object) -> str:
    if value is None:
        return "none"
    text = ", ".join(map(str, value)) if isinstance(value, list) else str(value)
    return text if len(text) <= LONGEST else text[: LONGEST - 3] + "..."


# ---------------------------------------------------------------- laws written in Python
def python_laws(model: Model) -> dict[str, str]:
    """Laws of users in a model, "load 'drag'", each with a checksum of its code: a model text only names them."""
    used = {("load", load.kind) for load in model.loads.values()}
    for contact in (contact for joint in model.joints.values() for contact in joint.contacts):
        choices = {"normal": contact.normal, "friction": contact.friction}
        used |= {(family, law.kind) for family, law in choices.items() if law is not None}
    return {f"{family} '{name}'": code for family, name in sorted(used) if (code := _code(family, name))}


def unknown_laws(laws: Mapping[str, str]) -> list[str]:
    """Those of `python_laws` that this process does not have, or has otherwise."""
    return [law for law, code in laws.items() if _code(*law.rstrip("'").split(" '")) != code]


def _code(family: str, name: str) -> str:
    """Checksum of a law of the user; "" for one of the package or none."""
    kind = registry.kinds(family).get(name)
    if kind is None or not isinstance(kind.kernel, UsersKernel):
        return ""
    law = kind.kernel.law
    try:
        text = inspect.getsource(law)
    except (OSError, TypeError):  # typed in at a prompt
        text = law.__code__.co_code.hex() + repr(
            [constant for constant in law.__code__.co_consts if not inspect.iscode(constant)]
        )
    return hashlib.sha256(text.encode()).hexdigest()[:16]
