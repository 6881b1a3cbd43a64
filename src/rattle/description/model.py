"""A mechanism as frozen data: what the model file says, checked and in SI units.

Nothing here computes: `reader` makes a `Model`, `system` turns it into flat arrays.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from rattle.language.expression import Node

Vector = tuple[float, float]
Value = float | Node  # a number, or an expression over t, state and signals


@dataclass(frozen=True)
class Point:
    """A point of a body, in the body's frame relative to its mass centre [m]."""

    body: str
    name: str
    at: Vector


@dataclass(frozen=True)
class Body:
    """A rigid body. Points are in its frame, relative to its mass centre [m]."""

    name: str
    mass: float  # [kg]
    inertia: float  # about the mass centre [kg*m^2]
    points: Mapping[str, Vector]
    bar: bool = False


@dataclass(frozen=True)
class Choice:
    """A kind of some family and the values of its fields."""

    kind: str
    values: Mapping[str, Any]


@dataclass(frozen=True)
class Contact:
    """How the play of a joint is treated.

    `model` is a kind of the family "contact", or "compliant": then `normal`, `static` and `friction` are its laws.
    """

    model: str
    fields: Mapping[str, float] = field(default_factory=dict)
    bush_radius: float = 0.0  # [m]
    normal: Choice | None = None
    static: Choice | None = None
    friction: Choice | None = None
    unused: tuple[str, ...] = ()  # what is written for other models

    @property
    def title(self) -> str:
        """The word the user writes for it."""
        return self.normal.kind if self.normal else self.model


@dataclass(frozen=True)
class Joint:
    """A joint between A (bush or guide side) and B (pin or block side)."""

    name: str
    kind: str
    a: Point
    b: Point
    fields: Mapping[str, float]
    clearance: float = 0.0  # radial [m]
    contact: Contact | None = None
    block: Vector | None = None  # length, height of a block in a guide [m]


@dataclass(frozen=True)
class Driver:
    """A joint's degree of freedom, or a coordinate of a body, as a function of time."""

    name: str
    kind: str
    joint: str  # "" where a body is driven
    value: Value
    point: Point | None = None  # of the body that is driven

    @property
    def on(self) -> str:
        """What is driven, in words."""
        return f"joint '{self.joint}'" if self.point is None else f"body '{self.point.body}'"


@dataclass(frozen=True)
class Load:
    """A load: values in the order of the kind's fields (points apart)."""

    name: str
    kind: str
    a: Point
    b: Point
    values: tuple[Value, ...]
    points: bool  # the kernel wants the two points before the values
    law: Callable[..., object] | None = None


@dataclass(frozen=True)
class Parameter:
    """A named number; min and max make sliders, tol and dist feed tolerance studies."""

    name: str
    value: float
    unit: str
    minimum: float | None = None
    maximum: float | None = None
    tol: float | None = None
    dist: str = ""


@dataclass(frozen=True)
class Initial:
    """What the user said about the start: per body any of x, y, angle, vx, vy, omega; per joint the offset."""

    bodies: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    offsets: Mapping[str, Vector] = field(default_factory=dict)


@dataclass(frozen=True)
class Settings:
    """The [simulate] table: None where the program decides."""

    t_end: float = 1.0
    method: str = "dop853"
    rtol: float | None = None
    atol: float | None = None
    step: float | None = None
    output: float | None = None


@dataclass(frozen=True)
class Model:
    """Everything a model file says."""

    name: str
    gravity: Vector
    parameters: Mapping[str, Parameter]
    signals: Mapping[str, Node]  # in the order in which they are to be evaluated
    signal_units: Mapping[str, str]
    ground: Mapping[str, Vector]
    bodies: Mapping[str, Body]
    joints: Mapping[str, Joint]
    drivers: Mapping[str, Driver]
    loads: Mapping[str, Load]
    initial: Initial
    settings: Settings
    constants: Mapping[str, float]
    remarks: tuple[str, ...] = ()  # on values that may not be what was meant


def driven_ends(model: Model, driver: Driver) -> tuple[Point, Point, tuple[float, ...]]:
    """Points A and B between which a driver acts, and the parameters that stand before its function."""
    if driver.point is not None:
        return Point("ground", "", (0.0, 0.0)), driver.point, ()
    joint = model.joints[driver.joint]
    return joint.a, joint.b, tuple(joint.fields.values())
