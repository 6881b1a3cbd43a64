"""A file of measured numbers that was dropped on the page: what the page shows beside the motion.

Nothing of it goes into the model.  The page keeps the numbers, and compares them with every motion that it shows.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rattle.errors import InputError
from rattle.exchange.measured import belonging, suits
from rattle.exchange.recording import Recording, Title, recording_of
from rattle.pages.scene import packed

MOST_COLUMNS = 50  # of a file whose numbers are sent
FEW = 3  # columns called as curves are, which are shown even if these are not yet


def measured_columns(file: str, text: str, curves: Mapping[str, str], shown: Sequence[str]) -> dict[str, Any]:
    """The columns of a file with their numbers, and the curves that they belong to.

    curves: SI units by the names of the curves of the motion.  shown: those that are shown.  Raises InputError with the
    line for a file that cannot be read.
    """
    recording = recording_of(text, file)
    belong = _belong(recording, curves, shown)
    columns, troubles = [], []
    for title in recording.columns[:MOST_COLUMNS]:
        try:
            columns.append({**_column(recording, title, curves), "curve": belong.get(title.place, "")})
        except InputError as error:
            troubles.append(str(error))
    if not columns:
        raise InputError(troubles[0] if troubles else f"{file}: no column besides time")
    return {"kind": "measured", "file": file, "t": packed(recording.t.astype("<f8")), "columns": columns}


def _belong(recording: Recording, curves: Mapping[str, str], shown: Sequence[str]) -> dict[int, str]:
    """Which columns belong to a curve by themselves, by their places."""
    try:
        pairs = belonging(recording, curves, shown) or belonging(recording, curves, ())[:FEW]
    except InputError:  # several may be meant: the user chooses
        return {}
    return {title.place: curve for title, curve in pairs}


def _column(recording: Recording, title: Title, curves: Mapping[str, str]) -> dict[str, Any]:
    """One column for the page: its numbers in SI, and the units of the curves that it can be compared with."""
    scale, dimension = title.scale(recording.place)
    values = scale * recording.values(title)
    units = sorted({unit for unit in curves.values() if suits(title, dimension, unit)})
    return {"name": title.name or title.text, "head": title.text, "units": units, "y": packed(values.astype("<f8"))}
