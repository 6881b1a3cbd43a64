"""A document (nested tables, as TOML or JSON give them) -> `Model`, with every problem found at once."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from rattle import catalog
from rattle.catalog import REQUIRED, Field
from rattle.errors import ModelError, Problem, suggest
from rattle.expression import RESERVED, ExpressionError, Node, dimension, names, parse, value
from rattle.model import Body, Contact, Driver, Initial, Joint, Load, Model, Parameter, Point, Settings, Vector
from rattle.quantity import Dimension, QuantityError, describe, dimension_of, parse_quantity, unit_name

Path = tuple[str | int, ...]
Document = Mapping[str, Any]

STATE_UNITS = {"x": "m", "y": "m", "angle": "rad", "vx": "m/s", "vy": "m/s", "omega": "rad/s"}
METHODS = ("dop853", "rk4")
TABLES = ("format", "name", "gravity", "parameters", "signals", "ground", "bodies", "joints", "drivers", "loads", "initial", "simulate")
TAKEN = RESERVED | {"ground", "energy"}


def read(document: Document, file: str = "") -> Model:
    """Check a document and turn it into a `Model`.

    Raises ModelError with all problems, in the order of the document's tables.
    """
    reader = _Reader(document)
    model = reader.model()
    if reader.problems:
        raise ModelError(reader.problems, file)
    assert model is not None
    return model


class _Reader:
    def __init__(self, document: Document) -> None:
        self.document = document
        self.problems: list[Problem] = []
        self.constants: dict[str, float] = {}
        self.dimensions: dict[str, Dimension | None] = {}  # of parameters, signals and states
        self.live: set[str] = set()  # names that change during a run
        self.broken: set[str] = set()  # names whose definition has a problem of its own

    # ------------------------------------------------------------ small things
    def wrong(self, path: Path, message: str) -> None:
        self.problems.append(Problem(path, message))

    def table(self, value: Any, path: Path) -> Mapping[str, Any]:
        if isinstance(value, Mapping):
            return value
        self.wrong(path, f"wanted a table, got {_said(value)}")
        return {}

    def keys(self, given: Mapping[str, Any], allowed: Iterable[str], path: Path) -> None:
        known = list(allowed)
        for key in given:
            if key not in known:
                self.wrong((*path, key), "unknown key" + suggest(key, known))

    def named(self, key: str) -> Mapping[str, Mapping[str, Any]]:
        """The table `key` whose entries are tables with names of the user's choice."""
        found = {}
        for name, entry in self.table(self.document.get(key, {}), (key,)).items():
            if not isinstance(entry, Mapping):
                self.wrong((key, name), f"wanted a table, got {_said(entry)}")
                continue
            self.name(name, (key, name))
            found[name] = entry
        return found

    def name(self, name: str, path: Path) -> None:
        if not name.isidentifier():
            self.wrong(path, f"'{name}' is not a name; wanted letters, digits and _, not starting with a digit")
        elif name in TAKEN:
            self.wrong(path, f"'{name}' has a meaning of its own; choose another name")

    # ------------------------------------------------------------ numbers
    def expression(self, text: str, path: Path, allowed: Callable[[str], bool], unit: str | None) -> Node | None:
        """Parse an expression, look its names up, check its dimension."""
        try:
            node = parse(text)
        except ExpressionError as error:
            self.wrong(path, f"{error}{_point_at(text, error)}")
            return None
        unknown = [one for one in sorted(names(node)) if not allowed(one)]
        for one in unknown:
            if one in self.live or one == "t":
                self.wrong(path, f"'{one}' changes during the run; only parameters may stand here")
            elif one not in self.broken:
                known = [*self.constants, *(x for x in self.live if allowed(x))]
                hint = suggest(one, known) if known else ""
                wanted = f"; wanted a quantity like '5 {unit}' or an expression" if unit and text.strip() == one and not hint else ""
                self.wrong(path, f"unknown name '{one}' in '{text}'{hint}{wanted}")
        if unknown:
            return None
        try:
            seen = dimension(node, self._dimension_of)
        except ExpressionError as error:
            self.wrong(path, f"{error}{_point_at(text, error)}")
            return None
        if unit is not None and seen is not None and seen != dimension_of(unit):
            self.wrong(path, f"'{text}' is not {describe(dimension_of(unit))}; wanted {_wanted(unit)}, got {unit_name(seen) or 'a plain number'}")
            return None
        return node

    def _dimension_of(self, name: str) -> Dimension | None:
        return dimension_of("s") if name == "t" else self.dimensions.get(name)

    def value(self, given: Any, unit: str, path: Path, least: str = "", live: bool = False) -> Any:
        """A float in SI, or a Node when `live` and the value changes during the run; nan after a problem."""
        number = math.nan
        if isinstance(given, bool) or not isinstance(given, int | float | str):
            self.wrong(path, f"wanted {_wanted(unit)} as a number or a text like '5 {unit}', got {_said(given)}")
            return number
        if isinstance(given, str):
            try:
                quantity = parse_quantity(given)
            except QuantityError as error:
                self.wrong(path, f"{error}; wanted {_wanted(unit)}")
                return number
            if quantity is None:
                node = self.expression(given, path, lambda one: one in self.constants or (live and (one == "t" or one in self.live)), unit)
                if node is None:
                    return number
                if any(one == "t" or one in self.live for one in names(node)):
                    return node
                try:
                    number = value(node, self.constants)
                except ExpressionError as error:
                    self.wrong(path, f"{error}{_point_at(given, error)}")
                    return number
            else:
                number, seen = quantity
                if seen is not None and seen != dimension_of(unit):
                    self.wrong(path, f"'{given}' is not {describe(dimension_of(unit))}; wanted {_wanted(unit)}")
                    return math.nan
        else:
            try:
                number = float(given)
            except OverflowError:
                number = math.inf
        if not math.isfinite(number):
            self.wrong(path, f"{given} is not a finite number")
            return math.nan
        if (least == "positive" and number <= 0) or (least == "not negative" and number < 0):
            self.wrong(path, f"{given} must {'be positive' if least == 'positive' else 'not be negative'}")
            return math.nan
        return number

    def vector(self, given: Any, unit: str, path: Path, live: bool = False) -> Any:
        if not isinstance(given, list | tuple) or len(given) != 2:
            self.wrong(path, f"wanted [x, y] in {unit}, got {_said(given)}")
            return (math.nan, math.nan)
        return tuple(self.value(one, unit, (*path, k), live=live) for k, one in enumerate(given))

    # ------------------------------------------------------------ parameters and signals
    def parameters(self) -> dict[str, Parameter]:
        table = self.table(self.document.get("parameters", {}), ("parameters",))
        texts: dict[str, tuple[Any, Path]] = {}
        for name, given in table.items():
            path: Path = ("parameters", name)
            self.name(name, path)
            if isinstance(given, Mapping):
                self.keys(given, ("value", "min", "max", "tol", "dist"), path)
                if "value" not in given:
                    self.wrong(path, "wanted { value = ... }")
                    self.broken.add(name)
                    continue
                texts[name] = (given["value"], (*path, "value"))
            else:
                texts[name] = (given, path)
        nodes = {}
        for name, (given, path) in texts.items():
            before = len(self.problems)
            quantity = self._quantity(given, path)
            if quantity is not None:
                self.constants[name], self.dimensions[name] = quantity
            elif isinstance(given, str) and len(self.problems) == before:
                try:
                    nodes[name] = parse(given)
                except ExpressionError as error:
                    self.wrong(path, f"{error}{_point_at(given, error)}")
            if len(self.problems) > before:
                self.broken.add(name)
        self._dependent_parameters(nodes, texts)
        for name in texts:
            if name not in self.constants:
                self.broken.add(name)
        return {name: self._parameter(name, table[name]) for name in self.constants}

    def _quantity(self, given: Any, path: Path) -> tuple[float, Dimension | None] | None:
        if isinstance(given, str):
            try:
                found = parse_quantity(given)
            except QuantityError as error:
                self.wrong(path, str(error))
                return None
            return found
        number = self.value(given, "", path)
        return None if math.isnan(number) else (number, None)

    def _dependent_parameters(self, nodes: dict[str, Node], texts: Mapping[str, tuple[Any, Path]]) -> None:
        for name in _in_order(nodes, lambda cycle: self.wrong(texts[cycle[0]][1], "defined by itself: " + " -> ".join([*cycle, cycle[0]]))):
            given, path = texts[name]
            node = self.expression(given, path, lambda one: one in self.constants, None)
            if node is not None:
                try:
                    self.constants[name] = value(node, self.constants)
                    self.dimensions[name] = dimension(node, self._dimension_of)
                except ExpressionError as error:
                    self.wrong(path, f"{error}{_point_at(given, error)}")

    def _parameter(self, name: str, given: Any) -> Parameter:
        seen = self.dimensions.get(name)
        unit = unit_name(seen) if seen is not None else ""
        more: dict[str, float] = {}
        dist = ""
        if isinstance(given, Mapping):
            path: Path = ("parameters", name)
            for key in ("min", "max", "tol"):
                if key in given:
                    quantity = self._quantity(given[key], (*path, key))
                    if quantity is None and isinstance(given[key], str) and all(p.path != (*path, key) for p in self.problems):
                        quantity = (self.value(given[key], unit, (*path, key)), seen)
                    if quantity is not None:
                        if seen is not None and quantity[1] is not None and quantity[1] != seen:
                            self.wrong((*path, key), f"'{given[key]}' is not {describe(seen)}; wanted {unit}")
                        more[key] = quantity[0]
            dist = given.get("dist", "")
            if dist not in ("", "uniform", "normal", "triangular"):
                self.wrong((*path, "dist"), f"unknown distribution {_said(dist)}; wanted uniform, normal or triangular")
            if "min" in more and "max" in more and not more["min"] <= self.constants[name] <= more["max"]:
                self.wrong(path, f"the value is not between min and max ({more['min']:g} to {more['max']:g})")
            if more.get("tol", 0.0) < 0:
                self.wrong((*path, "tol"), "must not be negative")
        return Parameter(name, self.constants[name], unit, more.get("min"), more.get("max"), more.get("tol"), dist)

    def signals(self) -> tuple[dict[str, Node], dict[str, str]]:
        table = self.table(self.document.get("signals", {}), ("signals",))
        self.live.update(table)
        nodes: dict[str, Node] = {}
        for name, given in table.items():
            path: Path = ("signals", name)
            self.name(name, path)
            if name in self.constants:
                self.wrong(path, f"'{name}' is a parameter already; choose another name")
            text = given if isinstance(given, str) else repr(given)
            if isinstance(given, bool) or not isinstance(given, int | float | str):
                self.wrong(path, f"wanted an expression, got {_said(given)}")
                continue
            node = self.expression(text, path, lambda one: one in self.constants or one in self.live or one == "t", None)
            if node is not None:
                nodes[name] = node
        order = _in_order(nodes, lambda cycle: self.wrong(("signals", cycle[0]), "defined by itself: " + " -> ".join([*cycle, cycle[0]])))
        units = {}
        for name in order:
            try:
                self.dimensions[name] = seen = dimension(nodes[name], self._dimension_of)
                units[name] = unit_name(seen) if seen is not None else ""
            except ExpressionError as error:
                self.wrong(("signals", name), f"{error}{_point_at(str(table[name]), error)}")
        return {name: nodes[name] for name in order}, units

    # ------------------------------------------------------------ bodies and points
    def ground(self) -> dict[str, Vector]:
        table = self.table(self.document.get("ground", {}), ("ground",))
        self.keys(table, ("points",), ("ground",))
        return self.points(table.get("points", {}), ("ground", "points"))

    def points(self, given: Any, path: Path) -> dict[str, Vector]:
        found = {}
        for name, at in self.table(given, path).items():
            if not name.isidentifier():
                self.wrong((*path, name), f"'{name}' is not a name; wanted letters, digits and _, not starting with a digit")
            found[name] = self.vector(at, "m", (*path, name))
        return found

    def body(self, name: str, given: Mapping[str, Any]) -> Body:
        path: Path = ("bodies", name)
        bar = "bar" in given
        self.keys(given, ("bar", "length", "points", "mass", "inertia") if bar else ("points", "center", "mass", "inertia"), path)
        mass = math.nan
        if "mass" in given:
            mass = self.value(given["mass"], "kg", (*path, "mass"), "positive")
        else:
            self.wrong(path, "needs a mass in kg")
        points = self.points(given.get("points", {}), (*path, "points"))
        inertia = math.nan
        if "inertia" in given:
            inertia = self.value(given["inertia"], "kg*m^2", (*path, "inertia"), "positive")
        if not bar:
            center = self.vector(given["center"], "m", (*path, "center")) if "center" in given else (0.0, 0.0)
            if "inertia" not in given:
                self.wrong(path, "needs an inertia about its mass centre in kg*m^2 (only a bar has a default)")
            points = {key: (x - center[0], y - center[1]) for key, (x, y) in points.items()}
            return Body(name, mass, inertia, points)
        length = math.nan
        if "length" in given:
            length = self.value(given["length"], "m", (*path, "length"), "positive")
        else:
            self.wrong(path, "a bar needs a length in m")
        ends = given["bar"]
        if not (isinstance(ends, list | tuple) and len(ends) == 2 and all(isinstance(e, str) and e.isidentifier() for e in ends)):
            self.wrong((*path, "bar"), f'wanted two end names like ["A", "B"], got {_said(ends)}')
            return Body(name, mass, inertia, points, True)
        for end in ends:
            if end in points or ends[0] == ends[1]:
                self.wrong((*path, "bar"), f"the point name '{end}' is used twice")
                break
        ends_at = {ends[0]: (-length / 2, 0.0), ends[1]: (length / 2, 0.0)}
        return Body(name, mass, inertia if "inertia" in given else mass * length**2 / 12, {**ends_at, **points}, True)

    def point(self, given: Any, path: Path, alone: bool = False) -> Point:
        """ "body.point", or with `alone` just "body" (its mass centre; the origin for the ground)."""
        nowhere = Point("", "", (math.nan, math.nan))
        if not isinstance(given, str):
            self.wrong(path, f"wanted \"body.point\", got {_said(given)}")
            return nowhere
        body, dot, point = given.partition(".")
        if body != "ground" and body not in self.bodies:
            self.wrong(path, f"no body '{body}'{suggest(body, ['ground', *self.bodies])}")
            return nowhere
        points = self.ground_points if body == "ground" else self.bodies[body].points
        if not dot and alone:
            return Point(body, "", (0.0, 0.0))
        if point not in points:
            hint = suggest(point, points) if point else "; wanted \"body.point\"" + suggest("", points)
            whose = "the ground" if body == "ground" else f"body '{body}'"
            self.wrong(path, f"no point '{point}' on {whose}{hint}")
            return nowhere
        return Point(body, point, points[point])

    def connect(self, given: Mapping[str, Any], path: Path, alone: bool = False) -> tuple[Point, Point]:
        nowhere = Point("", "", (math.nan, math.nan))
        if "connect" not in given:
            self.wrong(path, 'needs connect = ["body.point", "body.point"]')
            return nowhere, nowhere
        both = given["connect"]
        if not isinstance(both, list | tuple) or len(both) != 2:
            self.wrong((*path, "connect"), f'wanted ["body.point", "body.point"], got {_said(both)}')
            return nowhere, nowhere
        a, b = (self.point(one, (*path, "connect", k), alone) for k, one in enumerate(both))
        if a.body and a.body == b.body:
            self.wrong((*path, "connect"), f"both ends are on '{a.body}'; wanted two different bodies")
        return a, b

    # ------------------------------------------------------------ joints, drivers, loads
    def choose(self, given: Mapping[str, Any], family: str, path: Path, key: str = "type") -> catalog.Kind | None:
        known = catalog.kinds(family)
        if key not in given:
            self.wrong(path, f"needs a {key}: " + ", ".join(known))
            return None
        name = given[key]
        if not isinstance(name, str) or name not in known:
            self.wrong((*path, key), f"unknown {family} {_said(name)}{suggest(str(name), known)}")
            return None
        return known[name]

    def field(self, one: Field, key: str, given: Mapping[str, Any], read: Mapping[str, Any], path: Path) -> Any:
        """One field of a kind, as the user wrote it or its default."""
        if key not in given:
            if one.default is REQUIRED:
                self.wrong(path, f"needs {key}: {one.meaning}" + (f" [{one.unit}]" if one.unit else ""))
                return (math.nan, math.nan) if one.shape == "pair" else math.nan
            default = one.default(read) if callable(one.default) else one.default
            return float(one.choices.index(default)) if one.shape == "choice" else default
        here = (*path, key)
        if one.shape == "choice":
            if given[key] not in one.choices:
                self.wrong(here, f"wanted one of {', '.join(one.choices)}, got {_said(given[key])}")
                return math.nan
            return float(one.choices.index(given[key]))
        if one.shape == "pair":
            return self.vector(given[key], one.unit, here, one.live)
        return self.value(given[key], one.unit, here, one.least, one.live)

    def joint(self, name: str, given: Mapping[str, Any]) -> Joint | None:
        path: Path = ("joints", name)
        a, b = self.connect(given, path)
        found = self.choose(given, "joint", path)
        if found is None:
            return None
        common = ["type", "connect", "clearance", "contact"] + (["block"] if found.name == "prismatic" else [])
        self.keys(given, [*common, *found.fields], path)
        fields: dict[str, float] = {}
        for key, one in found.fields.items():
            fields[key] = self.field(one, key, given, fields, path)
        clearance = 0.0
        contact = None
        if "clearance" in given:
            clearance = self.value(given["clearance"], "m", (*path, "clearance"), "not negative")
            contact = self.contact(given, found.name, path)
        elif "contact" in given:
            self.wrong((*path, "contact"), "needs a clearance: the radial play of the joint in m")
        block = None
        if "block" in given:
            table = self.table(given["block"], (*path, "block"))
            self.keys(table, ("length", "height"), (*path, "block"))
            block = tuple(self.field(Field("m", f"{key} of the block", least="positive"), key, table, {}, (*path, "block")) for key in ("length", "height"))
        return Joint(name, found.name, a, b, fields, clearance, contact, block)  # type: ignore[arg-type]

    def contact(self, given: Mapping[str, Any], joint: str, path: Path) -> Contact | None:
        written = given.get("contact", "massless-link")
        here: Path = (*path, "contact") if "contact" in given else path
        table = {"model": written} if isinstance(written, str) else self.table(written, here)
        if "contact" in given and isinstance(written, str) and written not in catalog.kinds("contact"):
            self.wrong(here, f"unknown contact {_said(written)}{suggest(written, catalog.kinds('contact'))}")
            return None
        found = self.choose(table, "contact", here, "model")
        if found is None:
            return None
        self.keys(table, ["model", *found.fields], here)
        if joint not in found.leaf.joints:  # type: ignore[attr-defined]
            self.wrong(here, f"'{found.name}' works on {' and '.join(found.leaf.joints)} joints, not on {joint}")  # type: ignore[attr-defined]
        fields: dict[str, float] = {}
        for key, one in found.fields.items():
            fields[key] = self.field(one, key, table, fields, here)
        return Contact(found.name, fields)

    def driver(self, name: str, given: Mapping[str, Any], taken: dict[str, str]) -> Driver | None:
        path: Path = ("drivers", name)
        known = catalog.kinds("driver")
        self.keys(given, ["joint", *known], path)
        if "joint" not in given:
            self.wrong(path, "needs joint: the joint to drive")
            return None
        joint = given["joint"]
        if joint not in self.joints:
            if joint not in self.named_joints:
                self.wrong((*path, "joint"), f"no joint {_said(joint)}{suggest(str(joint), self.named_joints)}")
            return None
        wanted = [one for one in known.values() if one.leaf.drives == self.joints[joint].kind]  # type: ignore[attr-defined]
        if not wanted:
            drivable = sorted({one.leaf.drives for one in known.values()})  # type: ignore[attr-defined]
            self.wrong((*path, "joint"), f"a {self.joints[joint].kind} joint has nothing to drive; wanted {' or '.join(drivable)}")
            return None
        if joint in taken:
            self.wrong((*path, "joint"), f"joint '{joint}' is driven by '{taken[joint]}' already: two drivers on one freedom")
            return None
        taken[joint] = name
        found = wanted[0]
        for other in known:
            if other in given and other != found.name:
                self.wrong((*path, other), f"a {self.joints[joint].kind} joint is driven by '{found.name}', not by '{other}'")
        return Driver(name, found.name, joint, self.field(found.fields[found.name], found.name, given, {}, path))

    def load(self, name: str, given: Mapping[str, Any]) -> Load | None:
        path: Path = ("loads", name)
        found = self.choose(given, "load", path)
        if found is None:
            return None
        self.keys(given, ["type", *found.fields], path)
        a = b = Point("ground", "", (0.0, 0.0))
        values: list[Any] = []
        points = False
        for key, one in found.fields.items():
            if one.shape == "connect":
                a, b = self.connect(given, path, alone=True)
                points = True
                values += [*a.at, *b.at]
            elif one.shape in ("point", "body"):
                if key not in given:
                    self.wrong(path, f"needs {key}: {one.meaning}")
                    continue
                points = one.shape == "point"
                b = self.point(given[key], (*path, key), alone=one.shape == "body")
                if one.shape == "body" and b.name:
                    self.wrong((*path, key), f"wanted a body, got the point '{given[key]}'")
                values += b.at if points else ()
            elif one.shape == "pair":
                values += self.field(one, key, given, {}, path)
            else:
                values.append(self.field(one, key, given, {}, path))
        return Load(name, found.name, a, b, tuple(values), points)

    # ------------------------------------------------------------ start and settings
    def initial(self) -> Initial:
        table = self.table(self.document.get("initial", {}), ("initial",))
        bodies: dict[str, dict[str, float]] = {}
        offsets = {}
        play = {name: joint for name, joint in self.joints.items() if joint.contact is not None}
        for name, given in table.items():
            path: Path = ("initial", name)
            entry = self.table(given, path)
            if name in self.bodies:
                self.keys(entry, STATE_UNITS, path)
                bodies[name] = {key: self.value(entry[key], unit, (*path, key)) for key, unit in STATE_UNITS.items() if key in entry}
            elif name in self.named_joints:
                self.keys(entry, ("offset",), path)
                if "offset" in entry:
                    if name in self.joints and name not in play:
                        self.wrong(path, f"joint '{name}' has no clearance, so no offset")
                    offsets[name] = self.vector(entry["offset"], "m", (*path, "offset"))
            else:
                self.wrong(path, f"no body or clearance joint '{name}'{suggest(name, [*self.bodies, *play])}")
        return Initial(bodies, offsets)

    def settings(self) -> Settings:
        table = self.table(self.document.get("simulate", {}), ("simulate",))
        path: Path = ("simulate",)
        units = {"t_end": "s", "rtol": "", "atol": "", "step": "s", "output": "s"}
        self.keys(table, [*units, "method"], path)
        found: dict[str, Any] = {key: self.value(table[key], unit, (*path, key), "positive") for key, unit in units.items() if key in table}
        if "method" in table:
            if table["method"] not in METHODS:
                self.wrong((*path, "method"), f"unknown method {_said(table['method'])}{suggest(str(table['method']), METHODS)}")
            found["method"] = table["method"]
        return Settings(**found)

    # ------------------------------------------------------------ the whole
    def namespaces(self) -> None:
        """Bodies, joints, drivers and signals share one namespace."""
        seen: dict[str, str] = {}
        for table in ("bodies", "joints", "drivers", "signals"):
            entries = self.document.get(table, {})
            for name in entries if isinstance(entries, Mapping) else ():
                if name in seen:
                    self.wrong((table, name), f"the name '{name}' is used in {seen[name]} already; choose another")
                seen.setdefault(name, table)

    def model(self) -> Model | None:
        document = self.table(self.document, ())
        self.keys(document, TABLES, ())
        if document.get("format") != 1:
            said = f"got {_said(document['format'])}" if "format" in document else "it is missing"
            self.wrong(("format",), f"wanted format = 1, {said}")
        title = document.get("name", "")
        if not isinstance(title, str):
            self.wrong(("name",), f"wanted a text, got {_said(title)}")
        self.namespaces()
        parameters = self.parameters()
        bodies = self.named("bodies")
        for name in bodies:
            for key, unit in STATE_UNITS.items():
                self.live.add(f"{name}.{key}")
                self.dimensions[f"{name}.{key}"] = dimension_of(unit)
        signals, units = self.signals()
        gravity = self.vector(document.get("gravity", (0.0, 0.0)), "m/s^2", ("gravity",))
        self.ground_points = self.ground()
        self.bodies = {name: self.body(name, given) for name, given in bodies.items()}
        if not self.bodies and not self.problems:
            self.wrong(("bodies",), "a mechanism needs at least one body")
        self.named_joints = self.named("joints")
        joints = {name: self.joint(name, given) for name, given in self.named_joints.items()}
        self.joints = {name: one for name, one in joints.items() if one is not None}
        taken: dict[str, str] = {}
        drivers = {name: self.driver(name, given, taken) for name, given in self.named("drivers").items()}
        loads = {name: self.load(name, given) for name, given in self.named("loads").items()}
        initial, settings = self.initial(), self.settings()
        self._drivers_follow_time(drivers, signals)
        if self.problems:
            return None
        return Model(
            title, gravity, parameters, signals, units, self.ground_points, self.bodies, self.joints,
            {name: one for name, one in drivers.items() if one is not None},
            {name: one for name, one in loads.items() if one is not None},
            initial, settings, self.constants,
        )  # fmt: skip

    def _drivers_follow_time(self, drivers: Mapping[str, Driver | None], signals: Mapping[str, Node]) -> None:
        moving = {name for name in self.live if "." in name}
        for name, node in signals.items():  # in order of evaluation
            if names(node) & moving:
                moving.add(name)
        for name, driver in drivers.items():
            if driver is not None and not isinstance(driver.value, float):
                for one in sorted(names(driver.value) & moving):
                    self.wrong(("drivers", name, driver.kind), f"a driver follows time alone, but '{one}' depends on the motion")


def _in_order(nodes: Mapping[str, Node], cycle: Callable[[list[str]], None]) -> list[str]:
    """Names such that each comes after those it uses; names on a cycle are reported and left out."""
    order: list[str] = []
    state: dict[str, int] = {}
    for root in nodes:
        stack = [(root, iter(sorted(names(nodes[root]) & nodes.keys())))] if root not in state else []
        if stack:
            state[root] = 1
        while stack:
            name, following = stack[-1]
            for one in following:
                if state.get(one) == 1:
                    on_stack = [entry[0] for entry in stack]
                    cycle(on_stack[on_stack.index(one) :])
                elif one not in state:
                    state[one] = 1
                    stack.append((one, iter(sorted(names(nodes[one]) & nodes.keys()))))
                    break
            else:
                state[name] = 2
                order.append(name)
                stack.pop()
    return order


def _said(value: Any) -> str:
    text = f"'{value}'" if isinstance(value, str) else ("a table" if isinstance(value, Mapping) else str(value))
    return text if len(text) <= 60 else text[:57] + "..."


def _wanted(unit: str) -> str:
    return unit or "a plain number"


def _point_at(text: str, error: ExpressionError) -> str:
    """The spot in the expression, when it is not obvious."""
    column = error.column
    near = text[max(0, column - 12) : column + 12].strip()
    return f" (at character {column + 1} of '{text}')" if len(text) <= 60 else f" (near '{near}')"
