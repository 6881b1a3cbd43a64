"""A block in a guide with clearance: four corners against two walls.

The walls lie at +-(b + c) beside the line of direction u through the point of A; the block on B has the
length 2a and the height 2b and is centred on the point of B.  Contacts 0 and 1 are with the upper wall
(n = u turned by +90 degrees), 2 and 3 with the lower one (n = u turned by -90 degrees).  Each belongs to one diagonal
of the block and is at the end nearer to the wall, so that a block may turn over.  The end changes where the
diagonal is parallel to the wall; then both ends are as far from it as the point of B, and the other diagonal is nearer.

d = corner - point of A, p_A and p_B its arms from the mass centres, r its velocity relative to the material of A there
    g = b + c - n . d,  slip = t . r
    n . r = -g'        d/dt = J_n dv - gamma_n
    t . r = slip       d/dt = J_t dv - gamma_t
    gamma = p_B w_B^2 - p_A w_A^2 + 2 w_A (-r_y, r_x), along n and t
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from rattle.interfaces.contacts import ClearanceKind, FreePlay
from rattle.interfaces.fields import Fields
from rattle.jit import layout as at
from rattle.jit.choices import select
from rattle.jit.functions import kernel
from rattle.jit.geometry import direction, turn_x, turn_y
from rattle.language.recorded import hypot
from rattle.registry import Field, kind

Pair = tuple[float, ...]
AT_MOST = 1e-12  # share of the largest turn within which a block has turned so far


@kernel("clearance")
def guide(body, a, b, p, k, corner, row, kinematics):
    """Write gap [m], its rate [m/s], normal, arms [m], slip [m/s] and gamma [m/s^2] of a contact into its row."""
    c = p[k + at.CLEARANCE]
    f = k + at.FIELDS
    axis, angle = p[f], p[f + 1]
    half_length, half_height = 0.5 * p[f + 2], 0.5 * p[f + 3]
    sax = turn_x(body, a, p[k], p[k + 1])
    say = turn_y(body, a, p[k], p[k + 1])
    ux, uy = direction(body, a, axis)
    side = 1.0 if corner < 2 else -1.0
    nx, ny = -side * uy, side * ux
    # the corner in B's frame; the block lies along the line when B is at `angle` to A
    lx = half_length if corner == 0 or corner == 3 else -half_length
    ly = side * half_height
    cb, sb = math.cos(axis - angle), math.sin(axis - angle)
    dx, dy = cb * lx - sb * ly, sb * lx + cb * ly
    over = nx * turn_x(body, b, dx, dy) + ny * turn_y(body, b, dx, dy) < 0.0
    end = select(over, -1.0, 1.0)  # turned over: the other one
    dx, dy = end * dx, end * dy
    pbx = turn_x(body, b, p[k + 2] + dx, p[k + 3] + dy)
    pby = turn_y(body, b, p[k + 2] + dx, p[k + 3] + dy)
    pax = body[b, at.X] + pbx - body[a, at.X]
    pay = body[b, at.Y] + pby - body[a, at.Y]
    wa, wb = body[a, at.W], body[b, at.W]
    # velocity of the corner relative to the material of A at the same place
    rx = body[b, at.VX] - wb * pby - body[a, at.VX] + wa * pay
    ry = body[b, at.VY] + wb * pbx - body[a, at.VY] - wa * pax
    along, across = nx * rx + ny * ry, nx * ry - ny * rx
    # acceleration of the corner relative to A = J dv - gamma, with gamma from centripetal and Coriolis terms
    gx = pbx * wb * wb - pax * wa * wa - 2.0 * wa * ry
    gy = pby * wb * wb - pay * wa * wa + 2.0 * wa * rx

    kinematics[row, at.GAP] = half_height + c - nx * (pax - sax) - ny * (pay - say)
    kinematics[row, at.DGAP] = -along
    kinematics[row, at.NX], kinematics[row, at.NY] = nx, ny
    kinematics[row, at.PAX], kinematics[row, at.PAY] = pax, pay
    kinematics[row, at.PBX], kinematics[row, at.PBY] = pbx, pby
    kinematics[row, at.SLIP] = across
    kinematics[row, at.GAMMA_N] = nx * gx + ny * gy
    kinematics[row, at.GAMMA_T] = nx * gy - ny * gx


class BetweenWalls(FreePlay):
    """Displacements of a block (length 2a, height 2b, walls at +-(b + c)): across by e_0 [m], rotation by e_1 [rad].

        |e_0| <= room(e_1) = b + c - a |sin e_1| - b |cos e_1|

    The region has four sides that curve inwards and corners (tips) at (+-c, 0) and (0, +-theta_m), where
    sin(theta_m + atan(b/a)) = (b + c)/hypot(a, b).  A block whose diagonal fits between the walls can turn over.
    """

    two_tips = True

    def __init__(self, clearance: float, block: Pair | None) -> None:
        super().__init__(clearance)
        self.block = block
        self.a, self.b = (0.5 * block[0], 0.5 * block[1]) if block else (math.inf, 0.0)
        self.steps = (clearance, clearance / self.a)

    def first_order(self, y: np.ndarray) -> tuple[float, np.ndarray]:
        """Extreme over the rhombus |e_0 +- a e_1| <= c, which is at one of its corners; see `FreePlay.first_order`."""
        c, turn = self.clearance, self.clearance / self.a
        ends = (c * abs(float(y[0])), turn * abs(float(y[1])))
        if ends[0] >= ends[1]:
            return ends[0], np.array([math.copysign(c, y[0]), 0.0])
        return ends[1], np.array([0.0, math.copysign(turn, y[1])])

    @property
    def largest_turn(self) -> float:
        """Largest rotation of the block in either direction [rad]; inf if it can turn over, 0 without a block."""
        if not self.block:
            return 0.0
        a, b = self.a, self.b
        if math.hypot(a, b) <= b + self.clearance:
            return math.inf
        return math.asin((b + self.clearance) / math.hypot(a, b)) - math.atan2(b, a)

    def room(self, turn: float) -> float:
        """Largest displacement across [m], in either direction, of the block rotated by `turn` [rad]."""
        if not self.block:
            return self.clearance
        a, b = self.a, self.b
        return max(b + self.clearance - a * abs(math.sin(turn)) - b * abs(math.cos(turn)), 0.0)

    def tip(self, y: np.ndarray, second: bool | None) -> np.ndarray:
        """The corner with a displacement across, or (second) with a rotation; see `FreePlay.tip`."""
        most = self.largest_turn
        if second is None:
            second = most * abs(float(y[1])) > self.clearance * abs(float(y[0]))
        if second:
            return np.array([0.0, math.copysign(most, y[1])])
        return np.array([math.copysign(self.clearance, y[0]), 0.0])

    def side(self, e: np.ndarray, y: np.ndarray) -> tuple[float, Callable[[float], np.ndarray]] | None:
        """The side next to e if y . e grows along it, as a function of the rotation [rad]; see `FreePlay.side`."""
        if not self.block:
            return None
        a, b, most = self.a, self.b, self.largest_turn
        across = math.copysign(1.0, e[0]) if e[0] != 0.0 else math.copysign(1.0, y[0])
        turned = abs(float(e[1]))
        sense = math.copysign(1.0, e[1]) if turned > 0.0 else math.copysign(1.0, y[1])
        climb = sense * y[1] + across * y[0] * (b * math.sin(turned) - a * math.cos(turned))  # along growing |theta|
        if (turned == 0.0 and climb <= 0.0) or (turned >= most * (1.0 - AT_MOST) and climb >= 0.0):
            return None
        return most, lambda turn: np.array([across * self.room(turn), sense * turn])

    @property
    def unbounded(self) -> str:
        """Clause for a block that can turn over because its diagonal fits between the walls."""
        if not self.block or self.largest_turn < math.inf:
            return ""
        high = self.block[1] + 2 * self.clearance
        return (
            f"can turn over: its diagonal of {1e3 * math.hypot(*self.block):.4g} mm fits between"
            f" walls {1e3 * high:.4g} mm apart; nothing bounds its angle"
        )


@kind("clearance", "guide", guide)
class BlockInGuide(ClearanceKind):
    """A block in a guide: four corners against two walls.

    Source: Flores, Leine, Glocker, Modeling and analysis of planar rigid multibody systems with translational
    clearance joints based on the non-smooth dynamics approach, Multibody Syst. Dyn. 23 (2010) 165-190.
    """

    joint = "prismatic"
    borne, bearer = "block", "guide"
    wall = "a guide"
    contacts = 4
    walls_turn = True
    rounded = False
    has_radius = False
    dimensions = {
        "block": {
            "length": Field("m", "length of the block along the guide", least="positive"),
            "height": Field("m", "height of the block across the guide", least="positive"),
        }
    }

    @staticmethod
    def levers(p: Sequence[float]) -> tuple[float, float]:
        """Arms [m] of the guide's point and of the farthest corner."""
        f = at.FIELDS
        return hypot(p[0], p[1]), hypot(p[2], p[3]) + 0.5 * hypot(p[f + 2], p[f + 3])

    @staticmethod
    def displaced(fields: Fields, e: np.ndarray) -> tuple[float, float, Mapping[str, float]]:
        """Displaced across by e_0 [m] and rotated by e_1 [rad]; see `ClearanceKind.displaced`."""
        axis = fields["axis"]
        return -math.sin(axis) * float(e[0]), math.cos(axis) * float(e[0]), {"angle": float(e[1])}

    @staticmethod
    def free_play(clearance: float, fields: Fields, dimensions: Mapping[str, Pair]) -> BetweenWalls:
        """The displacements with all corners between the walls, clearance in m."""
        return BetweenWalls(clearance, dimensions.get("block"))
