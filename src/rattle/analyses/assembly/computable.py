"""Whether numbers that a model may hold, each by itself, can be computed with together."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from rattle.equations.system import System
from rattle.errors import AssemblyError, InputError

DIGITS = 1e-3  # largest rounding of a position, in lengths of the mechanism, with which its joints still say anything


@contextmanager
def computable(file: str) -> Iterator[None]:
    """Whatever the equations of a model cannot be computed with is an AssemblyError; file: that of the model."""
    try:
        yield
    except InputError:
        raise
    except (ArithmeticError, ValueError) as error:  # overflow, a domain, singular values that are no numbers
        raise AssemblyError(
            f"{f'{file}: ' if file else ''}the mechanism cannot be put together, as its numbers are too large or too"
            f" unlike each other to be computed with ({error}); are units and values as meant?"
        ) from error


def finite(matrix: np.ndarray) -> np.ndarray:
    """The same matrix.  Raises AssemblyError if it holds what is no number, of which LAPACK would print lines."""
    if not np.isfinite(matrix).all():
        raise not_finite()
    return matrix


def not_finite() -> AssemblyError:
    """That constraints have no finite values."""
    return AssemblyError(
        "the constraints have no finite values here: numbers of the model are too large or too unlike each other"
        " to be computed with; are units and values as meant?"
    )


def require_digits(system: System, q: np.ndarray) -> None:
    """Raise AssemblyError if positions (3 nb,) [m, m, rad] are so far away that rounding is as large as the bodies."""
    places = np.abs(q.reshape(-1, 3)[:, :2])
    lengths = [abs(x) + abs(y) for body in system.model.bodies.values() for x, y in body.points.values()]
    longest = max(lengths, default=0.0)
    if longest == 0.0 or not places.size:
        return
    farthest = float(places.max())
    if not np.finfo(float).eps * farthest <= DIGITS * longest:
        raise AssemblyError(
            f"the mechanism lies {farthest:.3g} m from the origin, where numbers have no digits left for its lengths of"
            f" {longest:.3g} m; give the points of the ground closer to the origin"
        )
