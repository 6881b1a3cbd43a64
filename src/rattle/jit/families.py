"""Families of kernels: their signatures, and how kernels of a table are called.

A table differs from run to run, so machine code calls what stands at a number in it; see
`translation.calls`.  In plain Python a table holds the functions themselves.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

from rattle.value_types import Plain

# one line per family: result and arguments of its kernels; i: int64, f: float64, v: (n,) and m: (n, k) of float64,
# h: (n,) of int64
SIGNATURE = {
    "joint": ("void", "m", "i", "i", "v", "i", "i", "m"),  # body, a, b, p, k, row, rows
    "load": ("void", "f", "m", "i", "i", "v", "i", "m", "v"),  # t, body, a, b, p, k, force, energy
    "clearance": ("void", "m", "i", "i", "v", "i", "i", "i", "m"),  # body, a, b, p, k, corner, row, kinematics
    "stiffness": ("f", "f", "v", "i"),  # delta, p, k -> F
    "normal": ("f", "f", "f", "f", "f", "v", "i"),  # F_static, delta, ddelta, v0, p, k -> F
    "friction": ("f", "f", "f", "v", "v", "i", "v"),  # u, N, z, p, k, dz -> T
    "film": ("void", *"ffffff", "v", "i", "v", "v"),  # e_x, e_y, v_x, v_y, w_A, w_B, p, k, table, out
    "closed contacts": ("void", "h"),  # m, see rattle.equations.unilateral
    "stepper": ("fi", "h", "f", "f", "f", "f", "i"),  # m, t, h, rtol, atol, 1 to project stages -> error, signs change
    "dense output": ("void", "h", "f", "f"),  # m, t, h
    "problem": ("i", "h", "i"),  # m, number of contacts, see rattle.equations.unilateral
}
BY_PLACE = (
    "closed contacts",
    "problem",
    "stepper",
    "dense output",
)  # tables of our own large functions, made by `entries`

Kind: TypeAlias = "str | tuple[Kind, ...]"  # of a value or of several together, see `translation.values`
Arguments = tuple[object, ...]


def call_joint(entry: Plain, arguments: Arguments) -> None:
    """Call one joint kernel of a table."""
    entry(*arguments)


def call_load(entry: Plain, arguments: Arguments) -> None:
    """Call one load kernel of a table."""
    entry(*arguments)


def call_clearance(entry: Plain, arguments: Arguments) -> None:
    """Call one clearance kernel of a table: the geometry of one contact."""
    entry(*arguments)


def call_stiffness(entry: Any, arguments: Arguments) -> Any:
    """Static contact force [N] by one stiffness kernel of a table."""
    return entry(*arguments)


def call_normal(entry: Callable[..., float], arguments: Arguments) -> float:
    """Normal force [N] by one normal kernel of a table."""
    return entry(*arguments)


def call_friction(entry: Callable[..., float], arguments: Arguments) -> float:
    """Friction force [N] by one friction kernel of a table."""
    return entry(*arguments)


def call_film(entry: Plain, arguments: Arguments) -> None:
    """Call one film kernel of a table: force, moments and loss of a film."""
    entry(*arguments)


def call_stepper(entry: Callable[..., tuple[float, int]], arguments: Arguments) -> tuple[float, int]:
    """Take a step; returns its error as a share of the tolerance, and 1 if monitored forces have changed signs."""
    return entry(*arguments)


def call_dense_output(entry: Plain, arguments: Arguments) -> None:
    """Compute the terms that the stepper of a run adds to the dense output of a step."""
    entry(*arguments)


def call_closed_contacts(entry: Plain, arguments: Arguments) -> None:
    """Call the kernel that adds the forces of closed set-valued contacts."""
    entry(*arguments)


def call_problem(entry: Callable[..., int], arguments: Arguments) -> int:
    """Call one part of the solution of contact problems."""
    return entry(*arguments)


CALLERS: dict[str, Plain] = {
    "joint": call_joint,
    "load": call_load,
    "clearance": call_clearance,
    "stiffness": call_stiffness,
    "normal": call_normal,
    "friction": call_friction,
    "film": call_film,
    "stepper": call_stepper,
    "dense output": call_dense_output,
    "closed contacts": call_closed_contacts,
    "problem": call_problem,
}
