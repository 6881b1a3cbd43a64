"""A result as a MATLAB file (`.mat`, version 5), which Octave, Python and others read too.

It holds one struct `r`: `t` (n, 1) [s], `names` and `units` (cells, m), `values` (n, m), `parameters` (names, values),
`events`, `trust` (a cell of lines).
"""

from __future__ import annotations

import io
import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from rattle.errors import InputError
from rattle.results import archive
from rattle.results.chosen_units import column_unit
from rattle.results.event import Event
from rattle.results.result import Result
from rattle.results.trust import HOW

SUFFIX = ".mat"
LARGEST = 2**31 - 1  # bytes of one array of version 5
TITLE = b"MATLAB 5.0 MAT-file, curves of rattle"
TITLE_BYTES = 116  # of the text at the start of a file, in which scipy writes the date


def write_mat(
    result: Result, path: str | os.PathLike[str], *, fallback: str | os.PathLike[str] | None = None,
    units: str | Iterable[str] | None = None, names: Sequence[str] | None = None,
) -> Path:  # fmt: skip
    """`Result.to_mat`."""
    archive.require_ending(path, "MATLAB file", SUFFIX)
    return archive.write_content(mat_bytes(result, units, names), path, fallback)


def mat_bytes(result: Result, units: str | Iterable[str] | None = None, names: Sequence[str] | None = None) -> bytes:
    """The bytes of the file; the same result gives the same.  Raises InputError if it is too large for version 5."""
    from scipy.io import savemat

    words = [*units] if units is not None and not isinstance(units, str) else units
    chosen = result.names if names is None else tuple(dict.fromkeys(names))
    if 8 * len(result.t) * len(chosen) > LARGEST:
        raise InputError(
            f"{len(result.t)} instants of {len(chosen)} curves: an array of a .mat file of version 5 holds 2 GB; name"
            " fewer curves, or write .nc, which MATLAB reads too"
        )
    _, table = result.titled_columns(chosen, words)
    parameters = result.provenance.get("parameters") or {}
    record: dict[str, Any] = {
        "t": table[:, :1],
        "names": cells(chosen),
        "units": cells([column_unit(result.unit(name), words).unit for name in chosen]),
        "values": table[:, 1:],
        "t_unit": column_unit("s", words).unit,
        "parameters": {"names": cells(parameters), "values": np.array([*parameters.values()], float).reshape(-1, 1)},
        "events": _events(result.events),
        "trust": cells(line.replace(HOW, "") for line in (result.trust.word, *result.trust.why)),
        "success": result.success,
        "message": result.message,
    }
    out = io.BytesIO()
    savemat(out, {"r": record}, format="5", oned_as="column")
    content = out.getvalue()
    return TITLE.ljust(TITLE_BYTES) + content[TITLE_BYTES:]


def _events(events: Sequence[Event]) -> dict[str, Any]:
    """A field for each field of an event: numbers (k, 1), texts as cells."""
    columns = {}
    for key in Event._fields:
        values = [getattr(event, key) for event in events]
        texts = key in ("joint", "kind", "contact")
        columns[key] = cells(values) if texts else np.array(values, float).reshape(-1, 1)
    return columns


def cells(texts: Iterable[str]) -> np.ndarray:
    """Texts as a cell array of one column."""
    listed = list(texts)
    column = np.empty((len(listed), 1), object)
    column[:, 0] = listed
    return column
