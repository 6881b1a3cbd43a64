"""Types that every room has: arrays by the kind of their numbers, functions of any kind, and what JSON holds."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats: TypeAlias = NDArray[np.float64]
Ints: TypeAlias = NDArray[np.int64]
Plain: TypeAlias = Callable[..., Any]  # of the compiled layer, whose types follow from its text, or of a user
Json: TypeAlias = "bool | int | float | str | Sequence[Json] | Mapping[str, Json] | None"
Tree: TypeAlias = Mapping[str, Any]  # tables within tables, as files and records hold them: who reads knows the form
