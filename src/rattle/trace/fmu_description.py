"""What a Functional Mock-up Unit (FMI 3.0) says of itself: the file modelDescription.xml."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import Enum
from typing import NamedTuple
from xml.etree import ElementTree

from rattle.errors import shown
from rattle.language.units import dimension_of
from rattle.trace.fmu import xml
from rattle.version import __version__


class Kind(Enum):
    """What a variable is.

    INPUT: a parameter that may change during a run, FOLLOWING: one given by others, CURVE: a result column that is
    not a state.
    """

    TIME, PARAMETER, INPUT, FOLLOWING, STATE, RATE, CURVE = range(7)


ATTRIBUTES: Mapping[Kind, Mapping[str, str]] = {
    Kind.TIME: {"causality": "independent", "variability": "continuous"},
    Kind.PARAMETER: {"causality": "parameter", "variability": "fixed", "initial": "exact"},
    Kind.INPUT: {"causality": "input", "variability": "continuous"},
    Kind.FOLLOWING: {"causality": "calculatedParameter", "variability": "fixed", "initial": "calculated"},
    Kind.STATE: {"causality": "output", "variability": "continuous", "initial": "calculated"},
    Kind.RATE: {"causality": "local", "variability": "continuous", "initial": "calculated"},
    Kind.CURVE: {"causality": "output", "variability": "continuous", "initial": "calculated"},
}
CATEGORIES = {
    "logStatusWarning": "energy errors",
    "logStatusDiscard": "states at which the equations do not hold",
    "logStatusError": "why a call failed",
}
DEGREES = "57.29577951308232"  # in a rad


class Variable(NamedTuple):
    """A variable; its value reference is its place in the list of all."""

    name: str
    kind: Kind
    unit: str
    description: str
    start: float | None = None
    least: float | None = None
    most: float | None = None
    nominal: float | None = None
    state: int | None = None  # of a rate: the value reference of its state


class Experiment(NamedTuple):
    """How a user probably runs it [s]."""

    stop: float
    tolerance: float
    step: float | None


def description(
    variables: Sequence[Variable], identifier: str, title: str, token: str, experiment: Experiment, *,
    exchange: bool = True,
) -> bytes:  # fmt: skip
    """The file modelDescription.xml.  exchange: for model exchange too; otherwise for co-simulation, with events."""
    root = ElementTree.Element(
        "fmiModelDescription", fmiVersion="3.0", modelName=title, instantiationToken=token,
        generationTool=f"rattle {__version__}", variableNamingConvention="structured",
    )  # fmt: skip
    every = {"modelIdentifier": identifier, "canGetAndSetFMUState": "true"}
    if exchange:
        ElementTree.SubElement(root, "ModelExchange", every, needsCompletedIntegratorStep="true")
    steps = ["canHandleVariableCommunicationStepSize"]
    if not exchange:
        steps += ["hasEventMode", "mightReturnEarlyFromDoStep"]
    ElementTree.SubElement(root, "CoSimulation", every | dict.fromkeys(steps, "true"))
    _units(ElementTree.SubElement(root, "UnitDefinitions"), variables)
    categories = ElementTree.SubElement(root, "LogCategories")
    for name, text in CATEGORIES.items():
        ElementTree.SubElement(categories, "Category", name=name, description=text)
    run = {"startTime": "0", "stopTime": repr(experiment.stop), "tolerance": repr(experiment.tolerance)}
    if experiment.step is not None:
        run["stepSize"] = repr(experiment.step)
    ElementTree.SubElement(root, "DefaultExperiment", run)
    listed = ElementTree.SubElement(root, "ModelVariables")
    for reference, variable in enumerate(variables):
        ElementTree.SubElement(listed, "Float64", _attributes(variable, reference))
    _structure(ElementTree.SubElement(root, "ModelStructure"), variables)
    return xml(root)


def _attributes(variable: Variable, reference: int) -> dict[str, str]:
    attributes = {"name": variable.name, "valueReference": str(reference), **ATTRIBUTES[variable.kind]}
    numbers = {"min": variable.least, "max": variable.most, "nominal": variable.nominal, "start": variable.start}
    texts = {"description": shown(variable.description), "unit": variable.unit}
    attributes |= {key: text for key, text in texts.items() if text}
    attributes |= {key: repr(float(x)) for key, x in numbers.items() if x is not None}
    if variable.unit == "rad":
        attributes["displayUnit"] = "deg"
    if variable.state is not None:
        attributes["derivative"] = str(variable.state)
    return attributes


def _units(parent: ElementTree.Element, variables: Sequence[Variable]) -> None:
    """Units of the variables, all of SI; without base units where a power is broken, which FMI cannot say."""
    for name in sorted({variable.unit for variable in variables if variable.unit}):
        unit = ElementTree.SubElement(parent, "Unit", name=name)
        powers = dimension_of(name)._asdict()
        if name.startswith("rad"):
            powers["rad"] = 1
        if all(x == int(x) for x in powers.values()):
            ElementTree.SubElement(unit, "BaseUnit", {key: str(int(x)) for key, x in powers.items() if x})
        if name == "rad":
            ElementTree.SubElement(unit, "DisplayUnit", name="deg", factor=DEGREES)


def _structure(parent: ElementTree.Element, variables: Sequence[Variable]) -> None:
    for kinds, name in (
        ((Kind.STATE, Kind.CURVE), "Output"), ((Kind.RATE,), "ContinuousStateDerivative"),
        ((Kind.FOLLOWING, Kind.STATE, Kind.RATE, Kind.CURVE), "InitialUnknown"),
    ):  # fmt: skip
        for reference, variable in enumerate(variables):
            if variable.kind in kinds:
                ElementTree.SubElement(parent, name, valueReference=str(reference))
