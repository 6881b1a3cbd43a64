"""A hand without a page: acts on a text, as the studio tells them."""

import itertools
import math

from rattle.sketch.acts import act
from rattle.sketch.drawn import drawn

EMPTY = "# by hand\nformat = 1\ngravity = [0, -9.81]   # down\n"
SNAP = 0.01


class Sheet:
    """A drawing and all texts that it has had."""

    def __init__(self, text=EMPTY):
        self.sketch = drawn(text)
        self.texts = [self.sketch.text]
        self.words = ""

    def do(self, name, **message):
        made = act(self.sketch, {"act": name, "snap": SNAP, "within": 0.004, **message})
        if made is None:
            return None
        self.sketch, self.words = made.sketch, made.words
        self.texts.append(made.text)
        return made

    @property
    def table(self):
        return self.sketch.document

    def at(self, x, y):
        """What is caught at a place: a point, the line of a bar, or nothing."""
        for name, spot in sorted(self.sketch.points.items(), key=lambda one: not one[0].startswith("ground.")):
            if math.dist(spot, (x, y)) < 1e-6:
                return {"at": [x, y], "point": name}
        return {"at": [x, y]}

    def on(self, body, x, y):
        return {"at": [x, y], "line": body}

    def ground(self, *spots):
        for spot in spots:
            self.do("ground", at=self.at(*spot))

    def bars(self, *spots):
        """Bars from one spot to the next."""
        for first, last in itertools.pairwise(spots):
            self.do("bar", **{"from": self.at(*first), "to": self.at(*last)})

    def type(self, chosen, field, text):
        return self.do("type", chosen=chosen, field=field, text=text)

    def place(self, point):
        return self.sketch.points[point]


PINS = [(-0.12, -0.04), (-0.12, 0.02), (0.04, 0.1), (0.08, -0.04)]


def fourbar():
    sheet = Sheet()
    sheet.ground(PINS[0], PINS[3])
    sheet.bars(*PINS)
    sheet.do("motor", at=sheet.at(*PINS[0]))
    return sheet
