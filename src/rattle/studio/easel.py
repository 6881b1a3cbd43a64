"""What a session draws: the drawing of its text, the acts of a hand on it, the mechanism that a hand turns.

Everything here is run aside, one thing after the other; what it returns are messages to the page.
"""

from __future__ import annotations

import base64
import binascii
import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from rattle.description import file as model_file
from rattle.errors import InputError, ModelError, suggest
from rattle.results.display import quantity
from rattle.sketch.acts import act, caught, place_of
from rattle.sketch.drawn import Drawn, Spot, drawn, framed
from rattle.sketch.measuring import message_of, readings
from rattle.sketch.model_text import revised
from rattle.sketch.numbers import length, typed_number
from rattle.sketch.picture import picture_of, underlay_of
from rattle.sketch.pull import Pull, Pulled
from rattle.sketch.revision import Drawing
from rattle.studio.folder import Folder

Message = dict[str, Any]


class Act(NamedTuple):
    """What an act has made: the new text, and the message that shows it."""

    text: str
    message: Message


class Easel:
    """The drawing of one session."""

    def __init__(self, folder: Folder) -> None:
        self.folder = folder
        self._drawn: Drawn | None = None
        self._pull: Pull | None = None  # while a hand holds a body
        self._held: Spot | None = None  # where it began to pull with a force [m]

    def drawing(self, text: str, file: str) -> Drawn:
        """The drawing of a text.  Raises ModelError."""
        last = self._drawn
        if last is None or last.text != text or last.mechanism._file != file:
            self._drawn = drawn(text, file, last.places if last else None)
        assert self._drawn is not None
        return self._drawn

    def shown(self, text: str, file: str) -> Message:
        """The drawing of a text as the page shows it, or what is wrong with the text."""
        try:
            return {"kind": "sketch", "drawing": picture_of(self.drawing(text, file))}
        except ModelError as error:
            return {"kind": "sketch", "trouble": f"Drawing waits for the text: {first_problem(error)}"}

    def acted(self, text: str, file: str, message: Mapping[str, Any]) -> Act:
        """What an act makes of a text, the same text if it changes nothing.  Raises InputError."""
        name = str(message.get("act"))
        try:
            if name in PICTURES:
                after, words = PICTURES[name](self, text, message)
                sketch = self.drawing(after, file)
                told = {"words": words, "chosen": "", "field": ""}
            else:
                before = self.drawing(text, file)
                made = act(before, message, file) or Drawing(before)
                self._drawn = sketch = made.sketch
                told = {"words": made.words, "chosen": made.chosen, "field": made.field}
        except ModelError as error:
            raise InputError(first_problem(error)) from None
        more = {"number": message.get("number"), "act": name, "changed": sketch.text != text}
        return Act(sketch.text, {"kind": "sketch", "drawing": picture_of(sketch), **told, **more})

    # ------------------------------------------------------------ by hand
    def grab(
        self, text: str, file: str, body: str, at: Spot, places: Mapping[str, Any] | None, force: bool = False
    ) -> None:
        """A hand takes a body at a spot of the plane [m], where the body is drawn or at these places.

        force: it pulls with a force while the motors hold, so that play alone lets the body follow.
        Raises InputError, ModelError, AssemblyError.
        """
        self._pull = None  # of another text, perhaps
        sketch = self.drawing(text, file)
        m = sketch.mechanism
        now = dict(sketch.places) | {name: place_of(place) for name, place in (places or {}).items()}
        if body not in now:
            raise InputError(f"there is no body '{body}' in the drawing{suggest(body, sketch.bodies)}")
        start = m.start.q.reshape(-1, 3)
        q = np.array([now.get(name, start[k]) for k, name in enumerate(m.system.bodies)], float).ravel()
        self._pull = Pull(m, body, framed(now[body], at), q, motors=force)
        self._held = self._pull.place if force else None

    def pulled(self, at: Spot) -> Message:
        """The hand is at a spot of the plane [m]: where the mechanism is then."""
        if self._pull is None:
            raise InputError("nothing is held: press on a body first")
        pulled = self._pull.to(*at) if self._held is None else self._pulled_by_force(self._pull, self._held, at)
        places = dict(zip(self._pull.movable.system.bodies, pulled.q.reshape(-1, 3).tolist(), strict=True))
        return {"kind": "pulled", "places": places, "words": pulled.words}

    @staticmethod
    def _pulled_by_force(pull: Pull, held: Spot, at: Spot) -> Pulled:
        """Where play lets a force towards a spot take the point that is held."""
        pulled = pull.by_force(at[0] - held[0], at[1] - held[1])
        gives = math.dist(pull.place, held)
        return pulled._replace(words=f"{pull.body} gives {quantity(gives, 'm')} this way, motors held")

    def measured(self, text: str, file: str, spots: Sequence[Any], snap: float) -> Message:
        """What clicks of the measuring tool tell.  Raises InputError, ModelError, AssemblyError."""
        sketch = self.drawing(text, file)
        if not sketch.bodies:
            raise InputError("there is nothing to measure yet")
        return message_of(readings(sketch, [caught(sketch, spot, snap) for spot in spots]))

    def let_go(self) -> None:
        """The hand holds nothing any more."""
        self._pull = None

    # ------------------------------------------------------------ a picture below the drawing
    def _put_picture(self, text: str, message: Mapping[str, Any]) -> tuple[str, str]:
        try:
            content = base64.b64decode(str(message.get("data")), validate=True)
        except (binascii.Error, ValueError):
            raise InputError("the picture has not arrived as a whole; choose it again") from None
        file = self.folder.keep_picture(str(message.get("name")), content, str(message.get("model", "")))
        value = {"file": file, **{key: message[key] for key in ("scale", "origin", "angle")}}
        return _with_picture(
            text, value
        ), f"{file} lies below the drawing: click two points of it whose distance is known"

    def _scale_picture(self, text: str, message: Mapping[str, Any]) -> tuple[str, str]:
        """Let two points of the picture be at a distance; the first one stays."""
        picture = underlay_of(model_file.parse(text))
        text_typed = str(message.get("text"))
        if picture is None:
            raise InputError("there is no picture below the drawing")
        try:
            distance = typed_number(text_typed, "m")
        except InputError:
            distance = None
        if distance is None or not distance > 0.0:
            raise InputError(f"'{text_typed}' is not a distance: type a length such as 0.5 m or 120 mm")
        (px, py), (qx, qy) = message["from"], message["to"]
        if not (apart := math.hypot(qx - px, qy - py)) > 0.0:
            raise InputError("the two points are one: click two points of the picture that are apart")
        factor, (ox, oy) = distance / apart, picture["origin"]
        value = {
            **picture,
            "scale": length(picture["scale"] * factor),
            "origin": [length(px + factor * (ox - px), 1.0), length(py + factor * (oy - py), 1.0)],
        }
        return _with_picture(text, value), f"the two points are {message['text']} apart"

    def _no_picture(self, text: str, message: Mapping[str, Any]) -> tuple[str, str]:
        return revised(text, [(("picture",), None)]), "no picture below the drawing"


PICTURES = {"picture": Easel._put_picture, "scale-picture": Easel._scale_picture, "no-picture": Easel._no_picture}


def _with_picture(text: str, value: Mapping[str, Any]) -> str:
    if "picture" in model_file.parse(text):
        return revised(text, [(("picture", key), part) for key, part in value.items()])
    return revised(text, [(("picture",), value)])


def first_problem(error: ModelError) -> str:
    """The first problem of a text, in one line."""
    first = error.problems[0]
    place = f"line {first.line}, " if first.line else ""
    return f"{place}{first.key}: {first.message}" if first.key else f"{place}{first.message}"
