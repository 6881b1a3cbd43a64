"""What the page shows of a model beside its motion: knobs, contact models, settings, and what is wrong with it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rattle.description.read_contact import contact_models
from rattle.errors import ModelError, Problem
from rattle.language.units import parse_quantity
from rattle.mechanism import Mechanism
from rattle.registry import kinds
from rattle.results.handy_units import Units, handy_unit, written_units
from rattle.value_types import Json, Tree

SPAN = 0.5  # share of its value by which a parameter without limits may be changed up and down


def facts(m: Mechanism, document: Mapping[str, object]) -> dict[str, Json]:
    """Everything the left column shows; document: the tables of the model file as they are written."""
    lent = written_units(document)
    return {
        "title": m.name,
        "knobs": [_knob(m, document, lent, name) for name in m.model.parameters],
        "contacts": _contacts(document),
        "settings": _settings(m, document),
        "names": {"bodies": m.model.moving_bodies, "joints": list(m.model.joints), "loads": list(m.model.loads)},
        "wear": [name for name, joint in m.model.joints.items() if joint.wear is not None],
        "oil": [name for name, joint in m.model.joints.items() if joint.contact and joint.contact.film is not None],
        "tolerances": [name for name, parameter in m.model.parameters.items() if parameter.tol],
    }


def _knob(m: Mechanism, document: Tree, lent: Units, name: str) -> dict[str, Json]:
    """A parameter: its value [SI], between which values it can be turned, and in which unit it is shown."""
    parameter = m.model.parameters[name]
    written = document.get("parameters", {}).get(name)
    text = written.get("value") if isinstance(written, Mapping) else written
    follows = isinstance(text, str) and parse_quantity(text) is None
    size = abs(parameter.value) or 1.0
    reach = SPAN * size if parameter.value else size
    least = parameter.value - reach if parameter.minimum is None else parameter.minimum
    most = parameter.value + reach if parameter.maximum is None else parameter.maximum
    factor, unit = m.written_unit(name) if not follows else (1.0, "")
    if not unit:
        times, unit = handy_unit(parameter.unit, max(map(abs, (least, most, parameter.value))), lent)
        factor = 1.0 / times
    return {
        "name": name, "value": parameter.value, "unit": unit, "factor": factor, "min": least, "max": most,
        "label": parameter.label or name, "description": parameter.description,
        "bounded": [parameter.minimum is not None, parameter.maximum is not None],
        "follows": str(text) if follows else "",
    }  # fmt: skip


def _contacts(document: Tree) -> list[dict[str, Json]]:
    """Joints with a contact: the model that is written, and those that the joint may have."""
    contacts = []
    for name, joint in document.get("joints", {}).items():
        if "clearance" not in joint and "contact" not in joint:
            continue
        written = joint.get("contact", "massless-link")
        model = written if isinstance(written, str) else written.get("model", "")
        contacts.append({"joint": name, "model": model, "models": contact_models(str(joint.get("type", "")))})
    return contacts


def _settings(m: Mechanism, document: Tree) -> dict[str, Json]:
    settings = document.get("simulate", {})
    return {
        "gravity": [str(component) for component in document.get("gravity", [0, 0])],
        "t_end": str(settings.get("t_end", "")) or f"{m.model.settings.t_end:g} s",
        "method": str(settings.get("method", "")),
        "methods": list(kinds("stepper")),
    }


def problems_of(error: ModelError, text: str) -> list[dict[str, Json]]:
    """Problems for the editor: line and column counted from 1, 0 where they are not known."""
    lines = text.split("\n")
    return [_problem(problem, lines) for problem in error.problems]


def problem_without_place(words: str) -> dict[str, Json]:
    """A problem that stands nowhere in the text."""
    return {"line": 0, "column": 0, "width": 0, "where": "", "words": words}


def _problem(problem: Problem, lines: Sequence[str]) -> dict[str, Json]:
    column, width = 0, 0
    source, _, marks = problem.caret.rpartition("\n")
    if problem.line and source == lines[problem.line - 1].rstrip("\r"):  # otherwise a part of a very long line is shown
        column, width = len(marks) - len(marks.lstrip()) + 1, marks.count("^")
    return {"line": problem.line or 0, "column": column, "width": width, "where": problem.key, "words": problem.message}
