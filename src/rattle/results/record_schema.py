"""What the record of a result holds, as types; a file that somebody made is compared with them before it is used.

The types of `Trust` are those of its fields; those of the geometry stand here, as `columns.geometry` writes it.
"""

# no postponed annotations here: TypedDict would not see which keys are NotRequired

import json
from collections.abc import Collection, Mapping
from types import NoneType, UnionType
from typing import Any, NotRequired, TypedDict, Union, get_args, get_origin, get_type_hints, is_typeddict

from numpy import ndarray

from rattle.results.trust import Trust
from rattle.value_types import Tree

Pair = tuple[float, float]


class Oil(TypedDict):
    """The oil of a joint: thickness of the boundary film [m], density [kg/m^3], specific heat [J/(kg K)]."""

    boundary: float
    density: float
    specific_heat: float


class JointForm(TypedDict):
    """A joint; lists of numbers under other keys are dimensions of its play."""

    type: str
    bodies: tuple[str, str]
    points: tuple[Pair, Pair]
    clearance: float
    contact: str
    rigid: NotRequired[bool]
    rigid_stop: NotRequired[bool]
    fields: NotRequired[dict[str, float | list[float]]]
    sense: NotRequired[float]
    coordinate: NotRequired[str]
    axis: NotRequired[float]
    travel: NotRequired[float]
    outline: NotRequired[list[Pair]]
    borne_outline: NotRequired[list[Pair]]
    stop: NotRequired[tuple[float | None, float | None]]
    oil: NotRequired[Oil]
    bush_radius: NotRequired[float]
    corners: NotRequired[dict[str, Pair]]
    mu: NotRequired[float]


class LoadForm(TypedDict):
    """A load."""

    type: str
    bodies: tuple[str, str]
    points: tuple[Pair, Pair]
    fields: NotRequired[dict[str, float | list[float]]]
    coordinate: NotRequired[str]
    power: NotRequired[float]
    quantities: NotRequired[list[str]]


class BodyForm(TypedDict):
    """A body: its points, and the rings of its plate [m]."""

    points: dict[str, Pair]
    outline: NotRequired[list[list[Pair]]]


class GroundForm(TypedDict):
    """The ground: its points [m]."""

    points: dict[str, Pair]


class Geometry(TypedDict):
    """Everything that is drawn; of what is not drawn all tables are empty."""

    bodies: dict[str, BodyForm]
    ground: NotRequired[GroundForm]
    joints: NotRequired[dict[str, JointForm]]
    loads: NotRequired[dict[str, LoadForm]]
    driven: NotRequired[list[str]]
    drivers: NotRequired[dict[str, str]]  # the joint of each


class Change(TypedDict):
    """By how much a parameter is changed in one derivative: in its unit, and in words."""

    size: float
    unit: str
    words: str


class Provenance(TypedDict):
    """How a result came to be; which settings there are depends on the analysis."""

    model: NotRequired[str | None]
    program: NotRequired[str]
    analysis: NotRequired[str]
    method: NotRequired[str | None]
    rtol: NotRequired[float | None]
    atol: NotRequired[float | None]
    step: NotRequired[float | None]
    t_end: NotRequired[float | None]
    of: NotRequired[list[str]]
    changes: NotRequired[dict[str, Change]]
    parameters: NotRequired[dict[str, float]]
    document: NotRequired[str]
    effort_at: NotRequired[str | dict[str, str]]


def misfit(value: object, wanted: Any, where: str) -> str:
    """Where a value of JSON is not of a type, such as "geometry.joints.O.clearance"; "" if all of it is."""
    if is_typeddict(wanted):
        return _table_misfit(value, wanted, where)
    kind, parts = get_origin(wanted) or wanted, get_args(wanted)
    if kind in (UnionType, Union):
        return "" if any(not misfit(value, part, where) for part in parts) else where
    if kind is ndarray:  # of intervals
        return misfit(value, list[Pair], where)
    if kind in (list, tuple):
        return _list_misfit(value, kind is tuple and parts[-1:] != (Ellipsis,), parts, where)
    if kind in (dict, Mapping):
        return _mapping_misfit(value, parts[1], where)
    fits = {float: (int, float), int: (int,), str: (str,), bool: (bool,), NoneType: (NoneType,)}[kind]
    return "" if type(value) in fits else where


def _list_misfit(value: object, counted: bool, parts: tuple[Any, ...], where: str) -> str:
    """The same of a list whose items are of one type, or `counted`: one type each."""
    if not isinstance(value, list | tuple) or (counted and len(value) != len(parts)):
        return where
    return _first(zip(value, parts if counted else parts[:1] * len(value), strict=True), where)


def _mapping_misfit(value: object, wanted: Any, where: str) -> str:
    """The same of a mapping of names to values of one type."""
    if not isinstance(value, dict) or not all(isinstance(key, str) for key in value):
        return where
    return next(filter(None, (misfit(item, wanted, f"{where}.{key}") for key, item in value.items())), "")


def _first(pairs: Any, where: str) -> str:
    """The first misfit among values with their types."""
    return next(filter(None, (misfit(item, wanted, f"{where}[{n}]") for n, (item, wanted) in enumerate(pairs))), "")


def _table_misfit(value: object, wanted: Any, where: str) -> str:
    if not isinstance(value, dict):
        return where
    for key, hint in get_type_hints(wanted).items():
        if key in value:
            if place := misfit(value[key], hint, f"{where}.{key}"):
                return place
        elif key in wanted.__required_keys__:
            return f"{where}.{key}"
    return ""


def misfit_of(record: Tree) -> str:
    """Where a record is not as a result is written; "" if it is.  Its names are checked before."""
    trust, geometry, provenance = record["trust"], record["geometry"], record["provenance"]
    hints = get_type_hints(Trust)
    if not isinstance(trust, dict):
        return "trust"
    place = next(filter(None, (misfit(trust[key], hints[key], f"trust.{key}") for key in trust if key in hints)), "")
    return (
        place
        or misfit(geometry, Geometry, "geometry")
        or misfit(record.get("peaks", {}), dict[str, list[float]], "peaks")
        or misfit(provenance, Provenance, "provenance")
        or _stranger(geometry)
        or _film_without_oil(geometry, record["names"])
        or _no_document(provenance)
    )


def _stranger(geometry: Geometry) -> str:
    """Where a part of the geometry names another that is not there."""
    bodies, joints = {*geometry["bodies"], "ground"}, geometry.get("joints", {})
    for family, forms in (("joints", joints), ("loads", geometry.get("loads", {}))):
        for name, form in forms.items():
            if not bodies.issuperset(form["bodies"]):
                return f"geometry.{family}.{name}.bodies"
    if not joints.keys() >= {*geometry.get("driven", ())}:
        return "geometry.driven"
    return "" if joints.keys() >= {*geometry.get("drivers", {}).values()} else "geometry.drivers"


def _film_without_oil(geometry: Geometry, names: Collection[str]) -> str:
    """Where a joint has the curve of an oil film, but not the oil that is needed to read it."""
    dry = [name for name, form in geometry.get("joints", {}).items() if "oil" not in form]
    return next((f"geometry.joints.{name}.oil" for name in dry if f"{name}.film_thickness" in names), "")


def _no_document(provenance: Provenance) -> str:
    """Where the model that a result holds is no table."""
    if document := provenance.get("document"):
        try:
            return "" if isinstance(json.loads(document), dict) else "provenance.document"
        except (ValueError, RecursionError):
            return "provenance.document"
    return ""
