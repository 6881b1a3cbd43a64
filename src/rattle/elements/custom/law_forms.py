"""What a load written in Python acts on: one body, the line between two points, or two bodies at a point.

A form makes of a law the kernel of its loads: it finds the arguments of the law and applies what it returns.  The
source of a kernel serves plain Python and Numba: `law` and `given`, which takes the values of the fields from the
parameters p from k on, differ.  Forces become nan first and stay so if the law raises: machine code does not stop at
an exception.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from rattle.jit import layout as at
from rattle.jit.geometry import ends
from rattle.registry import Field

Made = Callable[..., Any]


class Form(NamedTuple):
    """A form of laws."""

    place: dict[str, Field]  # the key of the model file that says where the load acts
    kernel: Callable[[Made, Made], Made]  # from law and given
    called: Callable[[Any], Made]  # a law for Numba that calls a C function of (t, arguments, values, result)
    inputs: Callable[[Any], tuple[Any, ...]]  # arguments of a law from the numbers that this one passes
    size: int  # how many numbers these are
    results: int  # how many numbers a law returns


# ---------------------------------------------------------------- one body
def _on_body(law: Made, given: Made) -> Made:
    def run(t: Any, body: Any, a: Any, b: Any, p: Any, k: Any, force: Any, energy: Any) -> None:
        kept = force[b, at.X]
        force[b, at.X] = math.nan
        state = (body[b, at.X], body[b, at.Y], body[b, at.PHI], body[b, at.VX], body[b, at.VY], body[b, at.W])
        fx, fy, torque = law(t, state, given(p, k))
        force[b, at.X] = kept + fx
        force[b, at.Y] += fy
        force[b, at.PHI] += torque
        energy[at.OUTSIDE] += fx * body[b, at.VX] + fy * body[b, at.VY] + torque * body[b, at.W]

    return run


def _body_called(callback: Any) -> Made:
    def law(t: Any, state: Any, values: Any) -> Any:
        passed, found = np.array(state), np.empty(3)
        callback(t, passed.ctypes, values.ctypes, found.ctypes)
        return found[0], found[1], found[2]

    return law


# ---------------------------------------------------------------- two points
def _along_line(law: Made, given: Made) -> Made:
    def run(t: Any, body: Any, a: Any, b: Any, p: Any, k: Any, force: Any, energy: Any) -> None:
        sax, say, sbx, sby, dx, dy, ddx, ddy = ends(body, a, b, p, k)
        length = math.sqrt(dx * dx + dy * dy)
        inv = 1.0 / length if length > 1e-150 else 0.0  # coincident ends: no direction, no force
        nx, ny = dx * inv, dy * inv
        kept = force[b, at.X]
        force[b, at.X] = math.nan
        push = law(t, length, nx * ddx + ny * ddy, given(p, k + 4))
        fx, fy = push * nx, push * ny
        force[a, at.X] -= fx
        force[a, at.Y] -= fy
        force[a, at.PHI] -= sax * fy - say * fx
        force[b, at.X] = kept + fx
        force[b, at.Y] += fy
        force[b, at.PHI] += sbx * fy - sby * fx
        energy[at.OUTSIDE] += fx * ddx + fy * ddy

    return run


def _line_called(callback: Any) -> Made:
    def law(t: Any, length: Any, rate: Any, values: Any) -> Any:
        passed, found = np.array((length, rate)), np.empty(1)
        callback(t, passed.ctypes, values.ctypes, found.ctypes)
        return found[0]

    return law


# ---------------------------------------------------------------- two bodies
def _between_bodies(law: Made, given: Made) -> Made:
    """The reaction acts on A at the point of B, so that angular momentum is kept."""

    def run(t: Any, body: Any, a: Any, b: Any, p: Any, k: Any, force: Any, energy: Any) -> None:
        sax, say, sbx, sby, dx, dy, ddx, ddy = ends(body, a, b, p, k)
        wa, wb = body[a, at.W], body[b, at.W]
        ax, ay = body[a, at.X] + sax, body[a, at.Y] + say
        vax, vay = body[a, at.VX] - wa * say, body[a, at.VY] + wa * sax
        one = (ax, ay, body[a, at.PHI], vax, vay, wa)
        other = (ax + dx, ay + dy, body[b, at.PHI], vax + ddx, vay + ddy, wb)
        kept = force[b, at.X]
        force[b, at.X] = math.nan
        fx, fy, torque = law(t, one, other, given(p, k + 4))
        force[a, at.X] -= fx
        force[a, at.Y] -= fy
        force[a, at.PHI] -= (sax + dx) * fy - (say + dy) * fx + torque
        force[b, at.X] = kept + fx
        force[b, at.Y] += fy
        force[b, at.PHI] += sbx * fy - sby * fx + torque
        # speed of B's point against the material of A that is there
        energy[at.OUTSIDE] += fx * (ddx + wa * dy) + fy * (ddy - wa * dx) + torque * (wb - wa)

    return run


def _bodies_called(callback: Any) -> Made:
    def law(t: Any, one: Any, other: Any, values: Any) -> Any:
        passed, found = np.array(one + other), np.empty(3)
        callback(t, passed.ctypes, values.ctypes, found.ctypes)
        return found[0], found[1], found[2]

    return law


# ---------------------------------------------------------------- all forms, by the word of `load_law(between=...)`
_ONE = {"body": Field("", "body on which the load acts", shape="body")}
_TWO = {"connect": Field("", "its two ends", shape="connect")}
FORMS = {
    "": Form(_ONE, _on_body, _body_called, lambda x: (tuple(x),), 6, 3),
    "points": Form(_TWO, _along_line, _line_called, tuple, 2, 1),
    "bodies": Form(_TWO, _between_bodies, _bodies_called, lambda x: (tuple(x[:6]), tuple(x[6:])), 12, 3),
}
