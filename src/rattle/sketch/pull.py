"""Pulling a point of a mechanism with the mouse.

The motors let go.  With r(q) the point that is held, h the mouse and u = scale q (see `movable`), every move looks for

    min |r(q) - h|^2 + 1e-3 |u(q) - u_0|^2      Phi(q) = 0,  g(q) >= 0

from the last position q_0: Newton's method with the curvature of joints and of pressed contacts, in the motions that
the joints leave.  Its step is the nearest one that the gaps allow (`nearest_step`); the joints are then closed with the
least change, and the step is halved where they do not close, where closing them changes more than half of the step, so
that a mechanism stays on its branch, and where nothing is gained.  At a dead centre the way on is not unique: it goes
back to the side from which it came.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from rattle.errors import InputError, suggest
from rattle.mechanism import Mechanism
from rattle.sketch.descent import Aim, Descent, Force, Hand
from rattle.sketch.movable import Movable
from rattle.sketch.nearest_step import pressures
from rattle.sketch.pull_words import why_not

NEAR = 1e-6  # sizes of the mechanism: a distance or move that is none
ASIDE = (0.0, 1e-3, -1e-3, 1e-2)  # shares of a force that are put across it, one after the other
PASSES = 4  # times that a move begins anew where it has come, until the part held back by the masses is gone


class Pulled(NamedTuple):
    """Where a mechanism is after a move of the mouse."""

    q: np.ndarray  # (3 nb,) x, y, angle of every body [m, m, rad]
    reached: bool  # the point is where the mouse is
    words: str  # why it is not; "" if it is


class Pull:
    """A point of a body, held by the mouse: `Pull(m, "coupler", (0.1, 0)).to(x, y)`; [m], in the frame of the body.

    q: (3 nb,) positions at which it is taken, by default those of the start [m, m, rad].
    Raises InputError for an unknown body or numbers that are none, ModelError, AssemblyError.
    """

    def __init__(
        self, m: Mechanism, body: str, point: tuple[float, float], q: np.ndarray | None = None, motors: bool = False
    ) -> None:
        system = m.system
        if body not in m.model.moving_bodies:
            raise InputError(f"no body '{body}' can be pulled{suggest(body, m.model.moving_bodies)}")
        start = m.start.q if q is None else np.array(q, float)
        if start.shape != (3 * system.body_count,) or not np.isfinite([*start, *point]).all():
            count = 3 * system.body_count
            raise InputError(f"q needs {count} finite numbers, x, y, angle of each body, and a point two")
        self.body, self.point = body, point
        self.movable = Movable(system, start, motors)
        if len(self.movable.acts):
            pressures(np.eye(1), np.ones(1))  # loads what is needed, before the mouse moves
        closed = self.movable.closed(start)
        self.q = start if closed is None else closed
        self.descent = Descent(self.movable, system.bodies.index(body), point)

    @property
    def place(self) -> tuple[float, float]:
        """Where the point is [m]."""
        x, y = self.descent.place(self.q).tolist()
        return x, y

    def to(self, x: float, y: float) -> Pulled:
        """Move the mouse to x, y [m] in the plane of the ground; the mechanism follows as far as it can.

        Raises InputError for numbers that are not finite.
        """
        if not (math.isfinite(x) and math.isfinite(y)):
            raise InputError(f"the mouse needs two finite numbers, got {x:g}, {y:g}")
        hand = Hand(np.array([x, y]))
        moved = math.inf
        for _ in range(PASSES):
            q, before = self.q, moved
            self._go(hand)
            moved = float(np.linalg.norm((self.q - q) * self.movable.scale))
            share = moved / before if before < math.inf else 1.0
            if moved * min(1.0, share) <= NEAR * self.movable.size:  # that is how far the next one would go
                break
        far = float(np.hypot(*(self.descent.place(self.q) - hand.at)))
        reached = far <= NEAR * self.movable.size
        words = "" if reached else why_not(self.movable, self.descent.end, far)
        return Pulled(self.q.copy(), reached, words)

    def by_force(self, fx: float, fy: float) -> Pulled:
        """Pull with a force [N] that only play lets follow: where its work is largest, so on what side pins lie.

        For a mechanism of which nothing else can move (`motors` = True).  Raises InputError for no force.
        """
        size = math.hypot(fx, fy)
        if not 0.0 < size < math.inf:
            raise InputError("pulling by a force needs one, finite and not zero")
        along, start, number = np.array([fx, fy]) / size, self.q, self.movable.system.bodies.index(self.body)
        for aside in ASIDE:  # from the very middle of a bush the force alone may lead nowhere
            self.q, self.descent = start, Descent(self.movable, number, self.point)
            self._go(Force(along + aside * np.array([-along[1], along[0]])))
            if self.descent.end.settled:
                break
        settled = self.descent.end.settled
        return Pulled(self.q.copy(), settled, "" if settled else "more than play gives way: hold it by a motor")

    def _go(self, aim: Aim) -> None:
        self.q = self.descent.lowest(self.q, aim)
        self.movable.seat(self.q)
