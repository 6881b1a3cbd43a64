"""One act of drawing: changes of a text that belong together, and the places of bodies that are meant after them.

An act is checked by drawing the new text: where bodies would stand elsewhere than meant, their angles are written into
[initial], so that the picture is what was drawn.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from rattle.description import file as model_file
from rattle.description.changes import Change, Path, copied
from rattle.errors import InputError
from rattle.language.expression import value
from rattle.language.syntax import parse
from rattle.mechanism import Mechanism
from rattle.sketch.drawn import Drawn, Place, Spot, drawn, drawn_mechanism, framed, placed, reached
from rattle.sketch.expressions import shifted, turned
from rattle.sketch.model_text import renamed, revised, texts_of
from rattle.sketch.numbers import degrees, in_unit_of, length, number_of

NAMES = ("bodies", "joints", "drivers", "signals", "states", "loads")  # they share their names
MISSED = 1e-9  # share of the size by which a body may stand elsewhere than drawn
LESS = 0.5  # share of what bodies are off by to which starts in the text have to bring it
SAME = 1e-12  # change of a coordinate below which a driver starts as before [m, rad]
MOST_USES = 4  # entries that are named where a parameter changes, bodies where joints take them along
WORDS = ("label", "description", "joint", "body", "at", "type", "contact", "model", "file", "profile")  # no expressions
SAME_LENGTH = 1e-12  # share of the size by which two values of a parameter are one


class Drawing(NamedTuple):
    """What an act has made: the new text, what it looks like, and what is to be told."""

    sketch: Drawn
    words: str = ""
    chosen: str = ""  # what is chosen after it, such as "body bar1"
    field: str = ""  # that has the focus

    @property
    def text(self) -> str:
        """The model text."""
        return self.sketch.text


class Caught(NamedTuple):
    """Where a hand let go: on a point, on the line of a bar, or on the bare sheet."""

    at: Spot
    point: str = ""  # "body.point"
    line: str = ""  # body


class Revision:
    """Changes of a drawing until they are one new text.

    file: of the model, in whose folder its tables are.  near: bodies are meant where they then close nearest to where
    they were, instead of exactly at `places`.
    """

    def __init__(self, sketch: Drawn, file: str = "") -> None:
        self.sketch, self.file = sketch, file
        self.document: dict[str, Any] = copied(sketch.document)
        self.changes: list[Change] = []
        self.places: dict[str, Place] = {name: sketch.places[name] for name in sketch.bodies}
        self.moved: list[str] = []  # bodies that stand elsewhere, or are new
        self.words: list[str] = []
        self.renaming: tuple[str, str, str] | None = None  # table, old and new name of an entry
        self.parameters: dict[str, float] = {}  # parameters that get another value [SI]

    # ------------------------------------------------------------ entries
    def enter(self, path: Path, value: object) -> None:
        """Put a value into the text, None to remove it."""
        self.changes.append((path, value))
        table = self.document
        for key in path[:-1]:
            if isinstance(table, list):
                table = table[int(key)]
            else:
                table = table.setdefault(key, {})
        if isinstance(table, list):
            table[int(path[-1])] = value
        elif value is None:
            table.pop(path[-1], None)
        else:
            table[path[-1]] = value

    def free_name(self, stem: str, first: str = "1") -> str:
        """The next name of these that nothing has: bar1, bar2; with first "", motor, motor2."""
        taken = {name for table in NAMES for name in self.document.get(table, {})} | {"ground"}
        taken |= set(self.document.get("parameters", {})) | set(self.document.get("tables", {}))
        return next(name for n in range(1, 100_000) if (name := f"{stem}{n if n > 1 else first}") not in taken)

    def joint(self, entry: Mapping[str, object], name: str = "") -> str:
        """A new joint; its name."""
        name = name or self.free_name("J")
        self.enter(("joints", name), dict(entry))
        return name

    def pin(self, first: str, second: str) -> str:
        """A revolute joint between two points; its name."""
        return self.joint({"type": "revolute", "connect": [first, second]})

    def ground_point(self, at: Spot, stem: str = "O") -> str:
        """A new point of the ground; "ground.O1"."""
        points = self.document.get("ground", {}).get("points", {})
        name = next(f"{stem}{n}" for n in range(1, 100_000) if f"{stem}{n}" not in points)
        self.enter(("ground", "points", name), [length(at[0], self.sketch.size), length(at[1], self.sketch.size)])
        return f"ground.{name}"

    def body_point(self, body: str, at: Spot) -> str:
        """A new point of a body at a spot of the plane; "body.C"."""
        entry = self.document["bodies"][body]
        taken = {*entry.get("points", {}), *entry.get("bar", ())}
        name = next(sign for sign in point_names() if sign not in taken)
        spot = [length(value, self.sketch.size) for value in self.as_written(body, self.sketch.in_frame(body, at))]
        if "points" in entry:
            self.enter(("bodies", body, "points", name), spot)
        else:
            self.enter(("bodies", body, "points"), {name: spot})
        return f"{body}.{name}"

    def end(self, caught: Caught) -> str:
        """The point at which a hand let go, made on a line if need be; "" on the bare sheet."""
        if caught.point:
            return caught.point
        return self.body_point(caught.line, caught.at) if caught.line else ""

    def spot(self, caught: Caught) -> Spot:
        """Where a hand let go [m]."""
        return self.sketch.points[caught.point] if caught.point else caught.at

    # ------------------------------------------------------------ numbers
    def as_written(self, body: str, spot: Spot) -> Spot:
        """A spot of the frame about the mass centre, in the frame in which the text gives the points of a body."""
        first = self._centre(body)
        return spot[0] + first[0], spot[1] + first[1]

    def in_new_frame(self, body: str, spot: Spot) -> Spot:
        """Where a spot of the plane is in the frame of a body at the place where that is meant to be [m]."""
        return framed(self.places[body], spot)

    def in_new_plane(self, body: str, spot: Spot) -> Spot:
        """Where a spot of a body is at the place where that is meant to be [m]."""
        return placed(self.places[body], spot)

    def _centre(self, body: str) -> Spot:
        """The mass centre of a body in the frame of its text [m]."""
        entry, points = self.sketch.document["bodies"].get(body, {}), self.sketch.model.bodies[body].points
        if "bar" in entry or not points:
            return 0.0, 0.0
        name, about = next(iter(points.items()))
        written = entry.get("points", {}).get(name, (0.0, 0.0))
        x, y = (self.number(part) for part in written)
        return x - about[0], y - about[1]

    def number(self, written: object) -> float:
        """The number that an entry says [SI]."""
        if (plain := number_of(written)) is not None:
            return plain
        parameters = {name: parameter.value for name, parameter in self.sketch.model.parameters.items()}
        for name, entry in self.document.get("parameters", {}).items():  # those that this act has changed
            now = entry.get("value") if isinstance(entry, Mapping) else entry
            if (plain := number_of(now)) is not None:
                parameters[name] = plain
        return value(parse(str(written)), parameters)

    def set_length(self, path: Path, value: float, what: str) -> None:
        """Give a length or coordinate this value [m], in the text or in the parameter that it is.

        Raises InputError where the text has an expression.
        """
        written: Any = self.document
        for key in path:
            written = written[int(key)] if isinstance(written, list) else written.get(key)
        if isinstance(written, str) and number_of(written) is None:
            self._set_parameter(written, value, what)
            return
        self.enter(path, in_unit_of(written, value, self.sketch.size))

    def _set_parameter(self, written: str, value: float, what: str) -> None:
        name, parameters = written.strip(), self.document.get("parameters", {})
        if name not in parameters:
            raise InputError(f"{what} is {written}: type a number to replace it")
        path = parameter_path(parameters, name)
        old = _at_path(self.document, path)
        if isinstance(old, str) and number_of(old) is None:
            self._set_parameter(old, value, f"{what}, {name},")
            return
        if abs(self.parameters.setdefault(name, value) - value) > SAME_LENGTH * max(abs(value), self.sketch.size):
            raise InputError(f"{what} is {name}, which would have to be two lengths: type a number to replace it")
        new = in_unit_of(old, value, self.sketch.size)
        self.enter(path, new)
        unit = "" if isinstance(new, str) else " m"
        self.words.append(f"parameter {name} is {new}{unit} now{self.uses(name)}")

    def uses(self, parameter: str) -> str:
        """Where else a parameter is used, in words."""
        sign = re.compile(rf"(?<![\w.]){re.escape(parameter)}(?!\w)")
        paths = [
            ".".join(path)
            for path, text in texts_of(self.document)
            if sign.search(text) and number_of(text) is None and not _is_word(path)
        ]
        more = f" and {len(paths) - MOST_USES} more" if len(paths) > MOST_USES else ""
        return f", in {', '.join(paths[:MOST_USES])}{more}" if len(paths) > 1 else ""

    # ------------------------------------------------------------ the new text
    def finish(self, words: str = "", chosen: str = "", field: str = "", near: bool = False) -> Drawing:
        """The new text, drawn.  Raises ModelError, InputError where it would be wrong."""
        if self.renaming is None:
            self._drive(self.sketch)
            self._hold()
            if near:
                self._close_near()
            self._start(self.moved)
        sketch = self._drawn()
        if self.renaming is None and self._recentre(sketch):
            sketch = self._drawn()
        if (self.parameters or self.moved) and not sketch.trouble and self._drive(sketch):
            sketch = self._drawn()  # functions have parameters that change, or joints points that move in their bodies
        if self.renaming is None:
            sketch = self._started(sketch)
            self._tell_followers(sketch)
        every = "; ".join(part for part in (words, *dict.fromkeys(self.words)) if part)
        return Drawing(sketch, every, chosen, field)

    def _started(self, sketch: Drawn) -> Drawn:
        """The drawing with starts in the text that keep bodies where they are meant to be, where joints allow it."""
        for start in (self._start_angles, self._start_places):  # angles are enough where joints say the rest
            astray = self._astray(sketch)
            if not astray:
                break
            start([*self.moved, *self._beside(astray)])
            after = self._drawn()
            if sketch.trouble or self._keeps(after, astray):  # else joints move them: no start in the text holds them
                sketch = after
        return sketch

    def _tell_followers(self, sketch: Drawn) -> None:
        """Name bodies that are elsewhere than they were meant to be, since joints take them along."""
        follow = [] if sketch.trouble else list(self._astray(sketch))
        if follow:
            more = f" and {len(follow) - MOST_USES} more" if len(follow) > MOST_USES else ""
            self.words.append(f"joints take along {', '.join(follow[:MOST_USES])}{more}")

    def _text(self) -> str:
        """The text with all changes; entries that are new come with what was changed in them since."""
        new = {
            path
            for path, value in self.changes
            if isinstance(value, Mapping) and not _at_path(self.sketch.document, path)
        }
        changes: dict[Path, object] = {}
        for path, entry in self.changes:
            root = next((path[:n] for n in range(1, len(path) + 1) if path[:n] in new), None)
            changes[root or path] = _at_path(self.document, root) if root else entry
        kept = [(path, value) for path, value in changes.items() if path not in new or value is not None]
        return revised(self.sketch.text, kept)

    def read(self) -> None:
        """Raise ModelError where the new text would be wrong."""
        Mechanism.from_text(self._text(), self.file)

    def _drawn(self) -> Drawn:
        text = self._text()
        return drawn(renamed(text, *self.renaming) if self.renaming else text, self.file, self.places)

    def _close_near(self) -> None:
        """Mean the places at which the changed mechanism closes, near those where it was, if it closes there."""
        text = self._text()
        m = Mechanism.from_text(text, self.file).near(self.places)
        beside = drawn_mechanism(text, model_file.parse(text), m, self.places)
        if not beside.trouble:
            self.places = {name: beside.places[name] for name in beside.bodies}
            self.moved += [name for name in self.document.get("initial", {}) if name in self.places]

    def _recentre(self, sketch: Drawn) -> bool:
        """Let points of bodies stand whose mass centre is elsewhere in them now, by a corner or parameter; True if any.

        sketch: of the new text.
        """
        new, before = Revision(sketch), len(self.moved)
        for body in self.sketch.bodies:
            if body in self.places and body in sketch.model.bodies:
                (x, y), (u, v) = self._centre(body), new._centre(body)
                if math.dist((x, y), (u, v)) > SAME * self.sketch.size:
                    self.places[body] = (*placed(self.places[body], (u - x, v - y)), self.places[body][2])
                    self.moved.append(body)
        self._start(self.moved[before:])
        return len(self.moved) > before

    def _drive(self, sketch: Drawn) -> bool:
        """Let drivers start where their joints are meant to be, from where this drawing has them; True if any does."""
        before = len(self.changes)
        for name, driver in self.sketch.model.drivers.items():
            entry = self.document.get("drivers", {}).get(name)
            key = next((key for key in ("angle", "position") if isinstance(entry, Mapping) and key in entry), "")
            if not key or not driver.joint or driver.joint not in self.document.get("joints", {}):
                continue
            old, new = (self.coordinate(driver.joint, places, sketch) for places in (sketch.places, self.places))
            change = turned(new - old) if key == "angle" else new - old
            if abs(change) > SAME:
                assert entry is not None
                self.enter(("drivers", name, key), shifted(entry[key], old, change, key == "angle"))
        return len(self.changes) > before

    def _hold(self) -> None:
        """Let welds and guides hold the relative angles that are meant."""
        for name, joint in {} if self.sketch.stand_in else self.sketch.model.joints.items():
            entry = self.document.get("joints", {}).get(name)
            if joint.kind not in ("fixed", "prismatic") or not isinstance(entry, Mapping):
                continue
            old, new = (self.turn(joint.a.body, joint.b.body, places) for places in (self.sketch.places, self.places))
            if abs(turned(new - old)) > SAME:
                written = entry.get("angle", degrees(old))
                self.enter(("joints", name, "angle"), shifted(written, old, turned(new - old), turns=True))

    @staticmethod
    def turn(a: str, b: str, places: Mapping[str, Place]) -> float:
        """Angle of one body relative to another [rad]."""
        nowhere = (0.0, 0.0, 0.0)
        return places.get(b, nowhere)[2] - places.get(a, nowhere)[2]

    def coordinate(self, joint: str, places: Mapping[str, Place], sketch: Drawn | None = None) -> float:
        """Angle [rad] or position [m] of B relative to A at these places."""
        form = (sketch or self.sketch).model.joints[joint]
        a, b = (places.get(point.body, (0.0, 0.0, 0.0)) for point in (form.a, form.b))
        if form.coordinate == "angle":
            return b[2] - a[2]
        (ax, ay), (bx, by) = (placed(place, point.at) for place, point in ((a, form.a), (b, form.b)))
        along = a[2] + (form.line or 0.0)
        return (bx - ax) * math.cos(along) + (by - ay) * math.sin(along)

    def _start(self, bodies: Iterable[str]) -> None:
        """Write where these bodies start: all of new ones and of those that no joint holds, else what is written."""
        held, initial = reached(self.document), self.document.get("initial", {})
        for body in dict.fromkeys(bodies):
            new = body not in self.sketch.places or self.sketch.stand_in
            if body in initial or new or body not in held:
                self._write_start(body, place=body not in held)
        for body in held & set(initial):
            entry = initial.get(body, {})
            if body not in self.sketch.grounded and {"x", "y"} & set(entry):
                self.enter(("initial", body), {key: part for key, part in entry.items() if key not in ("x", "y")})

    def _start_angles(self, bodies: Iterable[str]) -> None:
        """Write the angles of these bodies, and the places of those that no joint holds."""
        held = reached(self.document)
        for body in dict.fromkeys(bodies):
            self._write_start(body, place=body not in held)

    def _start_places(self, bodies: Iterable[str]) -> None:
        """Write angles and places of these bodies."""
        for body in dict.fromkeys(bodies):
            self._write_start(body, place=True)

    def _write_start(self, body: str, place: bool) -> None:
        if body not in self.document.get("bodies", {}):
            return
        x, y, angle = self.places[body]
        values: dict[str, object] = {"angle": degrees(angle)}
        if place:
            values = {"x": length(x, self.sketch.size), "y": length(y, self.sketch.size), **values}
        entry = self.document.get("initial", {}).get(body)
        if entry is None:
            self.enter(("initial", body), values)
            return
        for key, start in values.items():
            if entry.get(key) != start:
                self.enter(("initial", body, key), start)

    def _keeps(self, sketch: Drawn, astray: Mapping[str, float]) -> bool:
        """True if fewer bodies are astray than these were, or far less."""
        now = self._astray(sketch)
        return len(now) < len(astray) or sum(now.values()) < LESS * sum(astray.values())

    def _astray(self, sketch: Drawn) -> dict[str, float]:
        """Bodies that would stand elsewhere than meant, and by how much [m]."""
        size, astray = max(sketch.size, self.sketch.size), {}
        for body, (x, y, angle) in self.places.items():
            place = sketch.places.get(body)
            if place is None:
                continue
            gap = max(abs(place[0] - x), abs(place[1] - y), size * abs(turned(place[2] - angle)))
            if gap > MISSED * size:
                astray[body] = gap
        return astray

    def _beside(self, bodies: Iterable[str]) -> list[str]:
        """These bodies, and those that joints connect with them."""
        near = {other for body in bodies for other in reached(self.document, body, moving=True)}
        return [name for name in self.places if name in near or name in set(bodies)]


def _is_word(path: Path) -> bool:
    """True for a text of a document that is no expression."""
    return len(path) == 1 or path[-2] == "connect" or (len(path) > 2 and path[-1] in WORDS)


def parameter_path(parameters: Mapping[str, Any], name: str) -> Path:
    """Where the value of a parameter stands."""
    return ("parameters", name, "value") if isinstance(parameters[name], Mapping) else ("parameters", name)


def _at_path(document: Mapping[str, Any], path: Path) -> Any:
    """What stands at a path of a document; None if nothing does."""
    part: Any = document
    for key in path:
        part = part.get(key) if isinstance(part, Mapping) else part[int(key)] if isinstance(part, list) else None
    return part


def point_names() -> Iterable[str]:
    """A, B, ... Z, A2, ..."""
    letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZ"
    yield from letters
    for n in range(2, 1000):
        yield from (f"{letter}{n}" for letter in letters)
