"""What a load written in Python acts on: one body, the line between two points, or two bodies at a point.

A form makes of a law the kernel of its loads: it finds the arguments of the law and applies what it returns.  The
source of a kernel serves plain Python and machine code.  `fields` takes the values of the fields from the parameters p
from k on.  Forces become nan first and stay so if the law raises: a run does not stop at an exception.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from rattle.elements.custom.law_kernel import Law
from rattle.jit import layout as at
from rattle.jit.families import Kind
from rattle.jit.geometry import ends, line_of
from rattle.registry import Field
from rattle.value_types import Floats as Array


class Form(NamedTuple):
    """A form of laws."""

    place: dict[str, Field]  # the key of the model file that says where the load acts
    kernel: Callable[[Law, Law], Law]  # from law and fields
    sizes: tuple[int, ...]  # of the arguments of a law: 0 for a number, n for a tuple
    result: Kind  # kind of what a law returns


# ---------------------------------------------------------------- one body
def _on_body(law: Law, fields: Law) -> Law:
    def run(t: float, body: Array, a: int, b: int, p: Array, k: int, force: Array, energy: Array) -> None:
        kept = force[b, at.X]
        force[b, at.X] = math.nan
        state = (body[b, at.X], body[b, at.Y], body[b, at.PHI], body[b, at.VX], body[b, at.VY], body[b, at.W])
        try:
            fx, fy, torque = law(t, state, fields(p, k))
        except Exception:
            return
        force[b, at.X] = kept + fx
        force[b, at.Y] += fy
        force[b, at.PHI] += torque
        energy[at.OUTSIDE] += fx * body[b, at.VX] + fy * body[b, at.VY] + torque * body[b, at.W]

    return run


# ---------------------------------------------------------------- two points
def _along_line(law: Law, fields: Law) -> Law:
    def run(t: float, body: Array, a: int, b: int, p: Array, k: int, force: Array, energy: Array) -> None:
        sax, say, sbx, sby, dx, dy, ddx, ddy = ends(body, a, b, p, k)
        nx, ny, length = line_of(dx, dy, ddx, ddy)  # zero where the ends coincide and rest: no direction, no force
        kept = force[b, at.X]
        force[b, at.X] = math.nan
        try:
            push = law(t, length, nx * ddx + ny * ddy, fields(p, k + 4))
        except Exception:
            return
        fx, fy = push * nx, push * ny
        force[a, at.X] -= fx
        force[a, at.Y] -= fy
        force[a, at.PHI] -= sax * fy - say * fx
        force[b, at.X] = kept + fx
        force[b, at.Y] += fy
        force[b, at.PHI] += sbx * fy - sby * fx
        energy[at.OUTSIDE] += fx * ddx + fy * ddy

    return run


# ---------------------------------------------------------------- two bodies
def _between_bodies(law: Law, fields: Law) -> Law:
    """The reaction acts on A at the point of B, so that angular momentum is kept."""

    def run(t: float, body: Array, a: int, b: int, p: Array, k: int, force: Array, energy: Array) -> None:
        sax, say, sbx, sby, dx, dy, ddx, ddy = ends(body, a, b, p, k)
        wa, wb = body[a, at.W], body[b, at.W]
        ax, ay = body[a, at.X] + sax, body[a, at.Y] + say
        vax, vay = body[a, at.VX] - wa * say, body[a, at.VY] + wa * sax
        state_a = (ax, ay, body[a, at.PHI], vax, vay, wa)
        state_b = (ax + dx, ay + dy, body[b, at.PHI], vax + ddx, vay + ddy, wb)
        kept = force[b, at.X]
        force[b, at.X] = math.nan
        try:
            fx, fy, torque = law(t, state_a, state_b, fields(p, k + 4))
        except Exception:
            return
        force[a, at.X] -= fx
        force[a, at.Y] -= fy
        force[a, at.PHI] -= (sax + dx) * fy - (say + dy) * fx + torque
        force[b, at.X] = kept + fx
        force[b, at.Y] += fy
        force[b, at.PHI] += sbx * fy - sby * fx + torque
        # speed of B's point against the material of A that is there
        energy[at.OUTSIDE] += fx * (ddx + wa * dy) + fy * (ddy - wa * dx) + torque * (wb - wa)

    return run


# ---------------------------------------------------------------- all forms, by the word of `load_law(between=...)`
_ONE = {"body": Field("", "body on which the load acts", shape="body")}
_TWO = {"connect": Field("", "its two ends", shape="connect")}
_FORCES = ("f", "f", "f")
FORMS = {
    "": Form(_ONE, _on_body, (0, 6), _FORCES),
    "points": Form(_TWO, _along_line, (0, 0, 0), "f"),
    "bodies": Form(_TWO, _between_bodies, (0, 6, 6), _FORCES),
}
