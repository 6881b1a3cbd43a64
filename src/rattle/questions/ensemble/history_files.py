"""Curves of samples as netCDF: one file per piece, a variable (sample, t) per curve, in SI units."""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from rattle.results.archive import package, require_whole, sealed

FOR = "a folder of histories"


class Damaged(Exception):
    """A file is not as it was written."""


def content(first: int, t: np.ndarray, curves: Mapping[str, np.ndarray], units: Mapping[str, str]) -> bytes:
    """The file of samples from `first` on: instants t (m,) [s], curves (c, m) by name.  Raises MissingPackage."""
    package("h5py", FOR)
    h5netcdf, buffer = package("h5netcdf", FOR), io.BytesIO()
    count = len(next(iter(curves.values())))
    with h5netcdf.File(buffer, "w") as file:
        file.attrs["title"] = "histories of rattle"
        file.dimensions = {"sample": count, "t": len(t)}
        numbers = file.create_variable("sample", ("sample",), np.dtype("<i8"), data=np.arange(first, first + count))
        numbers.attrs["long_name"] = "number of the sample"
        for name, values in {"t": t, **curves}.items():
            over = ("t",) if name == "t" else ("sample", "t")
            variable = file.create_variable(name, over, np.dtype("<f8"), data=np.ascontiguousarray(values, "<f8"))
            variable.attrs["units"] = "s" if name == "t" else units[name]
    return sealed(buffer.getvalue())


def require(path: Path) -> None:
    """Raise Damaged unless a file is there and whole."""
    try:
        if not require_whole(path):
            raise Damaged(f"{path.name} is not whole")
    except (OSError, ValueError) as error:
        raise Damaged(f"{path.name}: {getattr(error, 'strerror', None) or 'its checksum is another one'}") from error


def read(path: Path, name: str, sample: int | None = None) -> np.ndarray:
    """(c, m) the curves of a file [SI], or (m,) that of its sample with this place.  Raises OSError."""
    h5py = package("h5py", FOR)
    with h5py.File(path, "r", locking=False) as file:
        return np.asarray(file[name][()] if sample is None else file[name][sample], dtype=np.float64)
