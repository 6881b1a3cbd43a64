"""A pin in a bush with worn surfaces: one contact whose gap is that of the node with the least.

g = min over the nodes i of c + h_A,i + h_B,i - lambda e . u_i      see `rattle.elements.worn_bins`

Its normal and its arms are those at this node; the force itself is that of all nodes, see `equations.worn_contact`,
which replaces them by those of the resultant.
"""

from __future__ import annotations

import math

import numpy as np

from rattle.elements.worn_bins import CHORD, COUNT, LEAST, around, depth_at, pin_place, pin_slope, window
from rattle.interfaces.contacts import FreePlay, WornKind, WornSurfaces
from rattle.jit import layout as at
from rattle.jit.functions import kernel
from rattle.jit.geometry import ends
from rattle.registry import kind


@kernel("clearance")
def worn_pin(body, a, b, p, k, corner, row, kinematics):
    """Write gap [m], its rate [m/s], normal, arms [m] and slip [m/s] of the contact into its row."""
    sax, say, sbx, sby, ex, ey, dex, dey = ends(body, a, b, p, k)
    n, c, chord = int(p[k + COUNT]), p[k + at.CLEARANCE], p[k + CHORD]
    cos_a, sin_a = body[a, at.COS], body[a, at.SIN]
    x, y = cos_a * ex + sin_a * ey, cos_a * ey - sin_a * ex
    wide = 2.0 * math.pi / n
    first, part = pin_place(p, k, body[a, at.PHI] - body[b, at.PHI])
    best = around(min(max(math.floor(math.atan2(y, x) / wide), -n), n - 1), n)
    theta = (best + 0.5) * wide
    most = chord * (x * math.cos(theta) + y * math.sin(theta)) - depth_at(p, k, best, first, part)
    start, count = window(p, k, x, y, most + p[k + LEAST])
    cos, sin = math.cos((start + 0.5) * wide), math.sin((start + 0.5) * wide)
    step_cos, step_sin, least = math.cos(wide), math.sin(wide), p[k + LEAST]
    for s in range(count):
        i = around(start + s, n)
        reach = chord * (x * cos + y * sin)
        if reach - least > most:
            value = reach - depth_at(p, k, i, first, part)
            if value > most:
                most, best = value, i
        cos, sin = cos * step_cos - sin * step_sin, sin * step_cos + cos * step_sin
    theta = (best + 0.5) * wide
    cos, sin = math.cos(theta), math.sin(theta)
    nx, ny = cos_a * cos - sin_a * sin, sin_a * cos + cos_a * sin
    along, across = nx * dex + ny * dey, nx * dey - ny * dex
    slope = pin_slope(p, k, best, first, part)
    wa, wb = body[a, at.W], body[b, at.W]
    e, et = nx * ex + ny * ey, nx * ey - ny * ex
    on_a = p[k + at.RADIUS] - 0.5 * (c - e)
    on_b = on_a - e

    kinematics[row, at.GAP] = c - most
    kinematics[row, at.DGAP] = -(chord * along + wa * (chord * et - slope) + wb * slope)
    kinematics[row, at.NX], kinematics[row, at.NY] = nx, ny
    kinematics[row, at.PAX], kinematics[row, at.PAY] = sax + on_a * nx, say + on_a * ny
    kinematics[row, at.PBX], kinematics[row, at.PBY] = sbx + on_b * nx, sby + on_b * ny
    kinematics[row, at.SLIP] = across + wb * on_b - wa * on_a
    kinematics[row, at.ACROSS] = across
    kinematics[row, at.GAMMA_N], kinematics[row, at.GAMMA_T], kinematics[row, at.TURN] = 0.0, 0.0, 0.0


class WornPlay(FreePlay):
    """The displacements of a pin in a worn bush: a convex polygon, e . u_i <= c + h_A,i + the largest h_B.

    Corners follow from the hull of the dual points u_i/(c + h_i).
    """

    def __init__(self, clearance: float, bush: np.ndarray, pin: np.ndarray) -> None:
        from scipy.spatial import ConvexHull

        super().__init__(clearance)
        theta = (np.arange(len(bush)) + 0.5) * 2.0 * math.pi / len(bush)
        far = clearance + bush + float(pin.max())
        dual = np.array([np.cos(theta), np.sin(theta)]).T / far[:, None]
        kept = dual[ConvexHull(dual).vertices]
        self._corners = np.array(
            [
                np.linalg.solve([normal, next_normal], [1.0, 1.0])
                for normal, next_normal in zip(kept, np.roll(kept, -1, 0), strict=True)
            ]
        )

    def first_order(self, y: np.ndarray) -> tuple[float, np.ndarray]:
        reached = self._corners @ y
        best = int(reached.argmax())
        return float(reached[best]), self._corners[best].copy()


@kind("worn", "pin", worn_pin)
class WornPin(WornKind):
    """A worn pin in a worn bush: an elastic foundation between two profiles; it takes the place of `pin`.

    Source: this package; Johnson, Contact Mechanics (1985), section 4.3 (elastic foundation).
    """

    joint = ""  # chosen by the profiles of a joint, not by its kind
    worn = 1
    from_materials = True
    holds_oil = True
    orbit = True

    @staticmethod
    def worn_play(wear: WornSurfaces, clearance: float) -> FreePlay:
        """The displacements that the clearance and the profiles of a joint allow."""
        bush, pin = _depths(wear)
        return WornPlay(clearance, bush, pin)

    @staticmethod
    def parameters(wear: WornSurfaces) -> tuple[float, ...]:
        """Parameters of the kernel after those of `pin`, in the order of `worn_bins`."""
        bush, pin = _depths(wear)
        n, wide = len(bush), 2.0 * math.pi / len(bush)
        chord = 12.0 * (1.0 - math.cos(wide)) / (wide * wide * (4.0 + 2.0 * math.cos(wide)))
        bed = wear.foundation * wear.radius * wear.length * wide
        return (float(n), bed, float(bush.min() + pin.min()), chord, float(pin.any()), *bush.tolist(), *pin.tolist())


def _depths(wear: WornSurfaces) -> tuple[np.ndarray, np.ndarray]:
    """Depths of bush and pin (n,) [m]."""
    assert wear.profile is not None, "a joint without profiles has another kind of clearance"
    bush, pin = wear.profile
    return np.asarray(bush, dtype=float), np.asarray(pin, dtype=float)
