"""Flat face of B that a cam of A pushes: the flat follower, which may lift off.

n', m, d, x, h: normal of the face, n' turned by 90 deg, offset, direction in A, support, see `joints.flat_follower`

g     = n' . d - h(x)                                                     gap: the least distance of face and cam  [m]
n     = -n',  at  p_A = s_A + h n' + h' m  on the cam,  p_B = s_B - d + (n' . d) n' + h' m  on the face
gamma = -(gamma of the row of the joint)                                                                   [m/s^2]
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from rattle.elements.profile import around
from rattle.interfaces.contacts import OneSidedKind
from rattle.interfaces.fields import Fields, function
from rattle.jit import layout as at
from rattle.jit.functions import kernel
from rattle.jit.geometry import direction, ends
from rattle.language.local_jet import function_jet
from rattle.registry import kind


@kernel("clearance")
def flat_face(body, a, b, p, k, corner, row, kinematics):
    """Write gap [m], its rate [m/s], normal, arms [m] and gamma [m/s^2] of the face into its row."""
    sax, say, sbx, sby, dx, dy, ddx, ddy = ends(body, a, b, p, k)
    nx, ny = direction(body, b, p[k + 4])
    wa, wb = body[a, at.W], body[b, at.W]
    cos, sin = body[a, at.COS], body[a, at.SIN]
    h, dh, ddh = function_jet(p, k + 5, math.atan2(cos * ny - sin * nx, cos * nx + sin * ny))
    turning = wb - wa
    reach, across = nx * dx + ny * dy, nx * dy - ny * dx
    on_x, on_y = -dh * ny, dh * nx

    kinematics[row, at.GAP] = reach - h
    kinematics[row, at.DGAP] = nx * ddx + ny * ddy + wb * across - dh * turning
    kinematics[row, at.NX], kinematics[row, at.NY] = -nx, -ny
    kinematics[row, at.PAX], kinematics[row, at.PAY] = sax + h * nx + on_x, say + h * ny + on_y
    kinematics[row, at.PBX], kinematics[row, at.PBY] = sbx - dx + reach * nx + on_x, sby - dy + reach * ny + on_y
    kinematics[row, at.GAMMA_N] = (
        nx * (sax * wa * wa - sbx * wb * wb)
        + ny * (say * wa * wa - sby * wb * wb)
        + 2.0 * wb * (nx * ddy - ny * ddx)
        - wb * wb * reach
        - ddh * turning * turning
    )


@kind("one-sided", "flat-face", flat_face)
class FlatFace(OneSidedKind):
    """A flat face on a convex cam, which only pushes.

    Source: do Carmo, Differential Geometry of Curves and Surfaces (1976), section 1-7; Pfeiffer, Glocker, Multibody
    Dynamics with Unilateral Contacts (1996), chapter 2.
    """

    joint = "flat-follower"
    wall = "a cam"
    walls_turn = True
    turning = at.B_BODY

    @staticmethod
    def bends(fields: Fields, constants: Sequence[float]) -> tuple[float, float, float]:
        """Largest |h'| and |h''| [m] around the cam."""
        jets = around(function(fields, "support"))[1]
        return float(np.abs(jets[1]).max()), float(np.abs(jets[2]).max()), 0.0
