"""Whether a roller can be on a curve everywhere, and where its centre then is: looked at when a model is read."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rattle.elements.profile import around, degrees
from rattle.elements.rolling import FLAT, LONG, STEPS
from rattle.language.local_function import LocalFunction

EVERY = 4  # of the directions of `profile.around`, those in which the search of `rolling.above` is tried
CLOSE = 0.02  # [rad] within which directions are neighbours
KINK = 0.02  # turn of the normal [rad] between them that the curvature does not explain

Array = NDArray[np.float64]
OVERLAP = 0.999  # of the radius of a roller, below which a second place of the cam is inside of it
REACHED = 1e-9  # [rad] within which the search of `rolling.above` ends where the roller touches


class RollerPath:
    """What a roller of a radius [m] meets on a curve: the path of its centre and what is in its way."""

    def __init__(self, curve: LocalFunction, radius: float):
        self.curve, self.radius = curve, radius
        self.a, (f, df, ddf) = around(curve)
        self.size = np.hypot(f, df)
        cos, sin = np.cos(self.a), np.sin(self.a)
        self.points = np.column_stack([f * cos, f * sin])
        self.normals = np.column_stack([f * cos + df * sin, f * sin - df * cos]) / self.size[:, None]
        self.curvature = (f * f + 2.0 * df * df - f * ddf) / self.size**3
        self.centres = self.points + radius * self.normals

    def fault(self) -> str:
        """Why the roller cannot be on the curve everywhere, in words; "" if it can."""
        return self.hollow() or self.kink() or self.two_places() or self.lost()

    def hollow(self) -> str:
        """Where the curve is more hollow than the roller is round."""
        k = int(self.curvature.argmin())
        if 1.0 + self.curvature[k] * self.radius > 0.0:
            return ""
        return (
            f"roller: its radius, {self.radius:.4g} m, is larger than that of the hollow of the cam at a ="
            f" {degrees(self.a[k])}, {-1.0 / self.curvature[k]:.4g} m: it would bridge the hollow. Make the roller"
            " smaller or the hollow wider"
        )

    def kink(self) -> str:
        """Where the curve has a corner."""
        if len(self.a) < 2:
            return ""
        turn = np.arctan2(self.normals[:, 1], self.normals[:, 0])
        turned = np.remainder(np.diff(turn) + np.pi, 2.0 * np.pi) - np.pi
        bend, step = self.curvature * self.size, np.diff(self.a)  # d(turn)/da
        jump = turned - 0.5 * (bend[1:] + bend[:-1]) * step
        beside = (step < CLOSE) & (np.abs(jump) > KINK + np.abs(np.diff(bend)) * step)
        if not beside.any():
            return ""
        return (
            f"roller: the curve of the cam has a corner near a = {degrees(self.a[int(beside.argmax())])}, over which a"
            " roller would jump; give a smooth curve (a table of kind spline), or without roller the path of its centre"
        )

    def two_places(self) -> str:
        """Where the roller would touch the curve in two places at once."""
        for centre, a in zip(self.centres, self.a, strict=True):
            apart = np.hypot(*(self.points - centre).T)
            if (least := float(apart.min())) < OVERLAP * self.radius:
                other = degrees(self.a[int(apart.argmin())])
                return (
                    f"roller: on the cam at a = {degrees(a)} it would stand {self.radius - least:.3g} m in the cam at a"
                    f" = {other}; make the roller smaller or the hollow wider"
                )
        return ""

    def lost(self) -> str:
        """Where Newton's method does not lead from the direction of the centre to where the roller touches."""
        centre, touch = self.centres[::EVERY], self.a[::EVERY]
        a = np.arctan2(centre[:, 1], centre[:, 0])
        for _ in range(STEPS):
            f, df, ddf = self.curve(a)
            cos, sin = np.cos(a), np.sin(a)
            along, across = centre[:, 0] * cos + centre[:, 1] * sin - f, centre[:, 1] * cos - centre[:, 0] * sin
            square = f * f + df * df
            bend = np.maximum(square - along * (ddf - f) - 2.0 * across * df, FLAT * square)
            step = (along * df + across * f) / bend
            a = a + step / np.sqrt(1.0 + (step / LONG) ** 2)
        missed = np.abs(np.remainder(a - touch + np.pi, 2.0 * np.pi) - np.pi)
        if not len(missed) or not missed.max() > REACHED:
            return ""
        return (
            f"roller: where it touches the cam at a = {degrees(touch[int(missed.argmax())])} is not found from the"
            " direction of its centre; the cam is too steep there for a roller this large. Make the roller smaller, or"
            " give the path of its centre as radius, without roller"
        )
