"""Where a changed mechanism closes near to where it was, and between which lengths of a bar it does."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from rattle.analyses.assembly.assembly import ideal_system
from rattle.description import file as model_file
from rattle.description.changes import copied, put
from rattle.equations.closure import close_position, open_by
from rattle.errors import AssemblyError, ModelError
from rattle.mechanism import Mechanism
from rattle.sketch.drawn import SHUT, Drawn, Place, drawn_mechanism
from rattle.sketch.revision import parameter_path

ROUNDS = 40  # of Newton's method
HALVINGS = 9  # of an interval in which the last length that closes lies
STEPS = 60  # in which a length goes to where it no longer closes
GROWTH = 1.25  # of the length in one such step


def closed_near(document: Mapping[str, Any], near: Mapping[str, Place]) -> dict[str, Place] | None:
    """Places of bodies where the mechanism of a document closes near these places; None where it does not."""
    text = model_file.dump_json(document)
    try:
        sketch = drawn_mechanism(text, dict(document), Mechanism.from_text(text).near(near), near)
    except ModelError:
        return None
    return None if sketch.trouble else {name: sketch.places[name] for name in sketch.bodies}


def closing_range(sketch: Drawn, bar: str, wanted: float, file: str = "") -> tuple[float, float]:
    """Least and largest length [m] of a bar with which the loops close, drivers where they start; 0, 0 if none does.

    wanted: a length that is enough to know: where it closes, the range goes no farther than there.
    """
    attempt = _Attempt(sketch, bar, file)
    length = math.dist(*(sketch.points[f"{bar}.{end}"] for end in sketch.document["bodies"][bar]["bar"]))
    if not attempt.closes(length):
        return 0.0, 0.0
    if attempt.reaches(length, wanted):
        return min(length, wanted), max(length, wanted)
    return attempt.last(length, 1.0 / GROWTH), attempt.last(length, GROWTH)


class _Attempt:
    """A mechanism whose bar is given one length after the other, each closed from where the last one closed."""

    def __init__(self, sketch: Drawn, bar: str, file: str) -> None:
        self.sketch, self.file = sketch, file
        written, parameters = sketch.document["bodies"][bar]["length"], sketch.document.get("parameters", {})
        shared = isinstance(written, str) and written.strip() in parameters  # other bars may have this length, too
        self.path = parameter_path(parameters, written.strip()) if shared else ("bodies", bar, "length")
        system = sketch.system
        assert system is not None
        self.first = self.q = np.array([sketch.places[name] for name in system.bodies]).ravel()

    def closes(self, length: float) -> bool:
        """True if the loops close with this length; the next one begins there."""
        document = copied(self.sketch.document)
        put(document, self.path, length)
        try:
            m = Mechanism.from_text(model_file.dump_json(document), self.file)
            system = ideal_system(m.model)
        except (ModelError, AssemblyError):
            return False
        workspace, q = system.workspace(), self.q.copy()
        open_by(workspace, 0.0, q, np.zeros_like(q))
        gap, _ = close_position(workspace, 0.0, q, np.zeros_like(q), SHUT * system.size, ROUNDS)
        if not gap <= SHUT * system.size:
            return False
        self.q = q
        return True

    def reaches(self, length: float, wanted: float) -> bool:
        """True if the loops close all the way from one length to another."""
        if not (wanted > 0.0 and abs(math.log(wanted / length)) < STEPS * math.log(GROWTH)):
            return False
        steps = math.ceil(abs(math.log(wanted / length)) / math.log(GROWTH))
        ways = [length * (wanted / length) ** (k / steps) for k in range(1, steps + 1)]
        return all(self.closes(way) for way in ways)

    def last(self, length: float, factor: float) -> float:
        """The last length that closes on the way from one that does; 0 or infinite where all do."""
        self.q = self.first
        inside, outside = length, length
        for _ in range(STEPS):
            outside = inside * factor
            if not self.closes(outside):
                break
            inside = outside
        else:
            return 0.0 if factor < 1.0 else math.inf
        for _ in range(HALVINGS):
            middle = (inside + outside) / 2
            if self.closes(middle):
                inside = middle
            else:
                outside = middle
        return inside
