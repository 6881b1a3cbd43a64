"""Building a mechanism in code: one call per part, with the names and values of a model file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Self

from rattle.description.changes import Change, plain, through_points
from rattle.errors import ModelError, Problem

Pair = Sequence[float | str]


class Building:
    """Adds parts to a document like that of a model file; every method returns the mechanism itself.

    Numbers are SI: m, rad, kg, s, N, Pa; a text is a quantity ("5 mm") or an expression over parameters.
    A name that is taken raises ModelError; everything else is checked when the model is first used.  Further keys of a
    table, see `rattle kinds`, are keywords too.
    """

    def __init__(self, name: str = "", gravity: Pair = (0.0, 0.0)) -> None:
        self._document: dict[str, Any] = {
            "format": 1,
            "name": name,
            "gravity": list(gravity) if isinstance(gravity, Sequence) else gravity,
        }
        self._text: str | None = None
        self._file = ""
        self._changes: list[Change] = []
        self._near: Mapping[str, tuple[float, float, float]] = {}  # see `model.Initial`
        self._told = True  # whether notes on its start are made, and results hold the model
        self._near_shut: Mapping[str, tuple[float, float, float]] = {}
        self._held: Mapping[str, Mapping[str, float]] = {}  # places of bodies that only loads hold, of that start

    def _enter(self, table: str, name: str, entry: dict[str, Any]) -> Self:
        entries = self._document.setdefault(table, {})
        if name in entries:
            raise ModelError([Problem((table, name), f"the name '{name}' is taken")])
        entries[name] = {key: value for key, value in entry.items() if value is not None}
        self._forget()
        return self

    def _forget(self) -> None:
        self._text = None
        for key in ("model", "system", "start", "_beside_its_start", "_forms"):
            self.__dict__.pop(key, None)

    def parameter(self, name: str, value: float | str, **more: Any) -> Self:
        """A named number [SI, or a text with its unit]; more: min, max, tol (same unit), dist, and
        label and description for those who turn it.

        dist: "uniform", "normal", "triangular" or {"values": [...], "weights": [...]}.
        """
        self._document.setdefault("parameters", {})[name] = {"value": value, **more} if more else value
        self._forget()
        return self

    def group(self, *parameters: str) -> Self:
        """Parameters that are made together: one draw moves all of them within their tolerances."""
        self._document.setdefault("tolerances", {}).setdefault("groups", []).append(list(parameters))
        self._forget()
        return self

    def table(
        self, name: str, x: Sequence[float | str], y: Sequence[float | str], *, kind: str = "linear",
        period: float | str | None = None, **more: Any,
    ) -> Self:  # fmt: skip
        """A function y(x) through points with increasing x, which expressions use as `name(x)`; numbers in SI units.

        kind: "linear", "monotone" (without overshoot) or "spline" (with continuous second derivative).
        period: in x, after which y repeats.
        """
        return self._enter(
            "tables", name, {"x": plain(x), "y": plain(y), "kind": kind, "period": plain(period), **more}
        )

    def signal(self, name: str, expression: str) -> Self:
        """A named quantity: an expression in parameters, the time t [s] and the state [SI]; results record it."""
        self._document.setdefault("signals", {})[name] = expression
        self._forget()
        return self

    def state(self, name: str, rate: float | str, start: float | str = 0.0, **more: Any) -> Self:
        """A state of the model's own: its rate, an expression in parameters, t, the motion, signals and states [SI/s],
        and its value at the start [SI]; loads, signals and rates of states may use it, and results record it.

        `m.state("i", "(U - R*i - k*rotor.omega)/L")`
        """
        return self._enter("states", name, {"rate": rate, "start": start, **more})

    def ground(self, **points: Pair) -> Self:
        """Points of the ground [m], also over time: `m.ground(O=[0, 0], A=[1, "0.05*sin(40*t)"])`."""
        self._document.setdefault("ground", {}).setdefault("points", {}).update({k: list(v) for k, v in points.items()})
        self._forget()
        return self

    def bar(
        self, name: str, first: str, second: str, *, length: float | str, mass: float | str,
        inertia: float | str | None = None, points: Mapping[str, Pair] | None = None, **more: Any,
    ) -> Self:  # fmt: skip
        """A uniform bar between the points `first` and `second`, `length` [m] apart.

        mass [kg], 0 if joints determine its motion; inertia about the mass centre [kg*m^2], default m l^2/12; points:
        more points [m] in the frame of the bar, with the origin at the mass centre and the x axis along the bar.
        """
        keys = {"length": length, "mass": mass, "inertia": inertia, "points": points, **more}
        return self._enter("bodies", name, {"bar": [first, second], **keys})

    def plate(
        self, name: str, polygon: Sequence[Pair], *, thickness: float | str | None = None,
        density: float | str | None = None, mass: float | str | None = None, holes: Sequence[Sequence[Pair]] = (),
        points: Mapping[str, Pair] | None = None, **more: Any,
    ) -> Self:  # fmt: skip
        """A plate with these corners [m] in order around: mass centre and inertia follow from its shape.

        thickness [m] and density [kg/m^3], or mass [kg].  holes: corners of each hole [m]; points: named points [m];
        all in one frame fixed to the body.
        """
        keys = {"polygon": plain(polygon), "holes": plain(holes) or None, "points": plain(points), **plain(more)}
        return self._enter("bodies", name, {**keys, "thickness": thickness, "density": density, "mass": mass})

    def body(
        self, name: str, *, mass: float | str, inertia: float | str, points: Mapping[str, Pair],
        center: Pair = (0.0, 0.0), **more: Any,
    ) -> Self:  # fmt: skip
        """A rigid body: mass [kg], inertia about the mass centre [kg*m^2]; 0 where joints determine its motion.

        points, center: named points and the mass centre [m], in any one frame fixed to the body.
        """
        named = {key: list(at) for key, at in points.items()}
        keys = {"points": named, "center": list(center), "mass": mass, "inertia": inertia, **more}
        return self._enter("bodies", name, keys)

    def joint(self, name: str, type: str, a: str, b: str, **fields: Any) -> Self:
        """A joint of any kind between "body.point" a (bush side) and b (pin side), fields in SI units or as quantities.

        `rattle kinds` lists the kinds and their fields.
        """
        return self._enter("joints", name, {"type": type, "connect": [a, b], **fields})

    def revolute(self, name: str, a: str, b: str, **fields: Any) -> Self:
        """A revolute joint; fields: clearance [m], contact."""
        return self.joint(name, "revolute", a, b, **fields)

    def prismatic(self, name: str, a: str, b: str, **fields: Any) -> Self:
        """A prismatic joint; fields: axis [rad], angle [rad], clearance [m], contact, block [m]."""
        return self.joint(name, "prismatic", a, b, **fields)

    def fixed(self, name: str, a: str, b: str, **fields: Any) -> Self:
        """A rigid connection; fields: angle [rad]."""
        return self.joint(name, "fixed", a, b, **fields)

    def rod(self, name: str, a: str, b: str, **fields: Any) -> Self:
        """A massless rigid link between two points; fields: length [m], friction.

        A rope has a stop in place of the length: `m.rod("rope", "ground.O", "load.P", stop={"max": "1 m"})`.
        """
        return self.joint(name, "rod", a, b, **fields)

    def driver(self, name: str, joint: str | None = None, **function: Any) -> Self:
        """Prescribe the motion of a joint, or of a coordinate of a body, as a function of time t [s].

        `m.driver("motor", "O1", angle="10*t")` in rad; position=... in m on a prismatic joint; speed=... in rad/s or
        m/s, whose integral goes on from the start;
        `m.driver("push", body="slider", coordinate="x", position="0.1*t")`, or with coordinate "y" or "angle".
        """
        return self._enter("drivers", name, {"joint": joint, **function})

    def load(self, name: str, type: str, **fields: Any) -> Self:
        """A load of any kind: `m.load("M", "torque", body="rocker", torque="40 N*m")`; see `rattle kinds`.

        A value that changes in time may be given by its points, instants [s] and values [SI], with straight lines
        between them: `torque=(t, measured)`, `force=[(t, fx), 0]`.  They become a table, see `table`.
        """
        entry: dict[str, Any] = {"type": type}
        for key, value in fields.items():
            entry[key], tables = through_points(f"{name}_{key}", value)
            for table, points in tables.items():
                self._enter("tables", table, points)
        return self._enter("loads", name, entry)

    def actuator(self, name: str, a: str, b: str, *, force: float | str) -> Self:
        """A force [N] along the line between the points a and b, which it pushes apart; an expression may be given."""
        return self.load(name, "actuator", connect=[a, b], force=force)

    def motor(self, name: str, housing: str, rotor: str, *, torque: float | str) -> Self:
        """A moment [N*m] on the body `rotor` and back on `housing`; an expression may use `speed`, the rotor's rate
        relative to the housing [rad/s]: `m.motor("M", "ground", "crank", torque="2 - 0.1*speed")`.
        """
        return self.load(name, "motor", connect=[housing, rotor], torque=torque)

    def initial(self, name: str, **values: Any) -> Self:
        """Start of a body: x, y [m], angle [rad], vx, vy [m/s], omega [rad/s]; of a clearance joint: offset [m]."""
        self._document.setdefault("initial", {}).setdefault(name, {}).update(values)
        self._forget()
        return self

    def settings(self, **values: Any) -> Self:
        """Defaults of `simulate`: t_end [s], method, rtol [-], atol, step [s], output [s]."""
        self._document.setdefault("simulate", {}).update(values)
        self._forget()
        return self
