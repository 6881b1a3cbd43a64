"""What contributes to the deviation of an output: independent draws, each of one parameter or of a group.

A contributor moves all its parameters from one end of their fields to the other; its first-order effect is

    E_i = sum_k s_k T_k over its parameters,   s_k = dF/dp_k,   T_k = max |p_k - nominal|

T_k is the tolerance, and for a table of values the greatest deviation from the nominal value.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rattle.questions.ensemble.fields import Field, Fields


def members(fields: Fields) -> tuple[tuple[int, ...], ...]:
    """Places of the parameters of each contributor (d,)."""
    return tuple(tuple(n for n, draw in enumerate(fields.draw) if draw == c) for c in range(fields.draws))


def labels(fields: Fields) -> tuple[str, ...]:
    """Names of the contributors (d,): that of the parameter, or those of a group: "l2, l3"."""
    return tuple(", ".join(fields.names[n] for n in places) for places in members(fields))


def half_width(field: Field) -> float:
    """T: greatest deviation from the nominal value [SI]."""
    return max(field.high - field.nominal, field.nominal - field.low) if field.values else field.tol


def half_widths(fields: Fields) -> np.ndarray:
    """(k,) T of all parameters [SI]."""
    return np.array([half_width(field) for field in fields.fields])


def nominal(fields: Fields) -> np.ndarray:
    """(k,) values without deviations [SI]."""
    return np.array([field.nominal for field in fields.fields])


def added(fields: Fields, parts: Sequence[float] | np.ndarray) -> np.ndarray:
    """(d,) sums over the parameters of each contributor of parts (k,)."""
    return np.bincount(fields.draw, weights=np.asarray(parts, dtype=float), minlength=fields.draws)


def at_ends(fields: Fields, high: np.ndarray) -> np.ndarray:
    """(k, n) values [SI] where contributors are at the upper ends of their fields, high (n, d), or at the lower."""
    low, top = (np.array([getattr(field, end) for field in fields.fields])[:, None] for end in ("low", "high"))
    return np.where(np.asarray(high, dtype=bool)[:, list(fields.draw)].T, top, low)
