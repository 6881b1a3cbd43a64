"""Results as files: netCDF (`.nc`), or `.npz`, which needs no package beyond NumPy; both hold the same.

Every curve is an array under its own name; everything else is one JSON text, the record.  The SHA-256 of all of it is
stored beside.  A netCDF file also ends in the SHA-256 of its bytes, so that a damaged one never reaches the HDF5
library.  Nothing in a file is executed, links to other files are refused, and sizes are checked before memory is
allocated.
"""

from __future__ import annotations

import hashlib
import importlib
import io
import json
import os
import zipfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rattle.atomic_file import atomic, is_special
from rattle.errors import InputError, MissingPackage, WrongType, shown
from rattle.results.record_schema import misfit_of
from rattle.user_paths import expanded
from rattle.value_types import Tree

Array = NDArray[np.float64]
FORMAT = 2  # 1: without checksum, netCDF only
RECORD, DIGEST = "rattle.record", "sha256"
SUFFIXES = (".nc", ".npz")
TRAILER = b"\nrattle sha256 "  # after the HDF5 data, followed by 64 hexadecimal digits and a line end
PACKED = 1100  # largest compression ratio that deflate can reach, in a netCDF file
LARGEST = 1e300  # whole number in a record: Python reads larger ones than it can turn into a float
NETCDF = b"\x89HDF\r\n\x1a\n"
ZIP = b"PK\x03\x04"
HINT = "pip install h5netcdf h5py xarray pandas"
STUDIO = "pip install uvicorn starlette websockets"
HINTS = {
    "pyarrow": "pip install pyarrow",
    "distributed": "pip install distributed",
    "anywidget": "pip install anywidget",
    "uvicorn": STUDIO,
    "starlette": STUDIO,
    "websockets": STUDIO,
}  # where other packages are needed


def package(module: str, what: str) -> Any:
    """Import an optional package that `what` needs.  Raises MissingPackage."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        lacking = (error.name or "").partition(".")[0]
        missing = lacking if lacking in HINTS else module  # a package may lack one that it needs itself
        raise MissingPackage(f"{what} needs {missing}; install it with: {HINTS.get(missing, HINT)}") from error


def require(path: str | os.PathLike[str]) -> None:
    """Raise InputError or MissingPackage if a result cannot be saved under this name."""
    suffix = Path(path).suffix.lower()
    if suffix not in SUFFIXES and not is_special(path):
        raise InputError(
            f"{os.fspath(path)}: a result is saved as .nc (netCDF) or .npz; give a name ending in one of them"
            " (to_csv writes CSV)"
        )
    if suffix == ".nc":
        try:
            importlib.import_module("h5py")
            importlib.import_module("h5netcdf")
        except ImportError as error:
            raise MissingPackage(
                f"saving as .nc needs h5netcdf and h5py, which are not installed ({HINT}); .npz needs nothing more"
            ) from error


# ---------------------------------------------------------------- writing
def write(path: str | os.PathLike[str], record: Tree, t: Array, data: Array) -> None:
    """Write curves and record; the file is made in memory first, so that a full disk leaves no partial file.

    record: names, units and other plain data.  t: (n,) [s].  data: (n, len(names)), SI units.
    Raises InputError, MissingPackage, OSError.
    """
    require(path)
    text = json.dumps({"format": FORMAT, **record}, default=_plain)
    curves = {name: np.ascontiguousarray(data[:, k], "<f8") for k, name in enumerate(record["names"])}
    digest = _digest(text, np.ascontiguousarray(t, "<f8"), list(curves.values()))
    make = _netcdf if Path(path).suffix.lower() == ".nc" else _npz
    content = make(text, digest, np.ascontiguousarray(t, "<f8"), curves, record["units"])
    with atomic(path) as file:
        file.write_bytes(content)


def _plain(value: Any) -> Any:
    """A NumPy value in plain data as what JSON can write."""
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    raise WrongType(f"a result holds plain data only, not {type(value).__name__}")


def _digest(text: str, t: Array, curves: Sequence[Array]) -> str:
    digest = hashlib.sha256(text.encode("utf-8", "surrogatepass"))
    for curve in (t, *curves):
        digest.update(np.ascontiguousarray(curve, "<f8").tobytes())
    return digest.hexdigest()


def _netcdf(text: str, digest: str, t: Array, curves: Mapping[str, Array], units: Mapping[str, str]) -> bytes:
    h5py, h5netcdf = package("h5py", "save"), package("h5netcdf", "save")
    buffer = io.BytesIO()
    with h5netcdf.File(buffer, "w") as file:
        file.attrs["title"] = "result of rattle"
        file.attrs["rattle_format"] = FORMAT
        file.dimensions["t"] = len(t) or None
        for name, curve in {"t": t, **curves}.items():
            variable = file.create_variable(name, ("t",), np.dtype("<f8"), data=curve if len(t) else None)
            variable.attrs["units"] = "s" if name == "t" else units[name]
        record = file.create_variable(RECORD, (), h5py.string_dtype())
        record[...] = text
        record.attrs[DIGEST] = digest
    content = buffer.getvalue()
    return sealed(content)


def sealed(content: bytes) -> bytes:
    """An HDF5 file as bytes with their checksum behind."""
    return content + TRAILER + hashlib.sha256(content).hexdigest().encode() + b"\n"


def _npz(text: str, digest: str, t: Array, curves: Mapping[str, Array], units: Mapping[str, str]) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_STORED) as file:
        words = {RECORD: np.array(text.encode("utf-8", "surrogatepass")), DIGEST: np.array(digest.encode())}
        for name, values in {"t": t, **curves, **words}.items():
            with file.open(zipfile.ZipInfo(f"{name}.npy"), "w", force_zip64=True) as out:
                np.lib.format.write_array(out, values, allow_pickle=False)
    return buffer.getvalue()


# ---------------------------------------------------------------- reading
def read(path: str | os.PathLike[str]) -> tuple[dict[str, Any], Array, Array]:
    """Record, t (n,) [s] and data (n, k) in SI units of a file that `write` wrote.

    Raises FileNotFoundError, OSError if the file cannot be opened, MissingPackage, and ValueError for a file that
    is damaged or is not a result.
    """
    file = expanded(path)
    if not file.is_file():
        raise FileNotFoundError(f"no such file: {file}")
    with file.open("rb") as opened:
        head = opened.read(8)
    if not head.startswith(ZIP) and head != NETCDF:
        model = file.suffix.lower() in (".toml", ".json")
        hint = f"; run a model file first: rattle run {file} -o out.npz" if model else ""
        raise InputError(f"{file} {NO_RESULT}{hint}")
    own = False
    if head == NETCDF:
        package("h5py", f"reading {file.name}, which is netCDF,")
        own = require_whole(file)
    try:
        text, record, digest, t, curves = _read_netcdf(file, own) if head == NETCDF else _read_npz(file)
        _require_not_later(record)
        _require_plain(record, len(curves))
        _require_in_order(t)
    except Damaged as error:
        raise InputError(f"{file} {error}") from None
    except Exception as error:  # h5py, zipfile and json raise many kinds of errors; all mean the same here
        raise InputError(f"{file} {NO_RESULT}") from error
    if (digest or record["format"] > 1) and digest != _digest(text, t, curves):
        raise InputError(f"{file} is damaged: its content does not match its checksum; compute it again")
    return record, t, np.column_stack(curves) if curves else np.empty((len(t), 0))


NO_RESULT = "is not a result of rattle (a .nc or .npz file written by `rattle run -o` or Result.save), or is damaged"
Found = tuple[str, dict[str, Any], str, Array, list[Array]]  # record as text and read, its digest, t, curves


class Damaged(Exception):
    """Something is wrong with a file that seems to be a result."""


def require_whole(file: Path) -> bool:
    """Compare the checksum after the data with the bytes; False if there is none.  Raises InputError, OSError."""
    size, length = file.stat().st_size, len(TRAILER) + 65
    with file.open("rb") as opened:
        opened.seek(max(0, size - length))
        trailer = opened.read()
        if not trailer.startswith(TRAILER):
            return False
        opened.seek(0)
        digest, left = hashlib.sha256(), size - length
        while left > 0:
            part = opened.read(min(left, 1 << 20))
            digest.update(part)
            left -= len(part)
            if not part:
                break
    if trailer[len(TRAILER) :].strip() != digest.hexdigest().encode():
        raise InputError(f"{file} is damaged: its bytes do not match its checksum; compute it again")
    return True


def _fits(count: int, n: int, size: int, packed: int = PACKED) -> None:
    """Refuse a file that is too small for the curves it declares, before memory is allocated."""
    if 8 * n * count > packed * size:
        raise Damaged(f"declares {count} curves of {n} instants, more than {size} bytes can hold")


def _dataset(h5py: Any, opened: Any, name: str, own: bool, places: set[int]) -> Any:
    """A data set of an open file, which has no other name in `places`."""
    link = opened.get(name, getlink=True)
    if link is None:
        raise KeyError(name)
    dataset = opened[name] if type(link) is h5py.HardLink else None
    if not isinstance(dataset, h5py.Dataset) or dataset.is_virtual or dataset.external:
        raise Damaged("has links to other files, which no result has")
    if own and dataset.id.get_create_plist().get_nfilters():
        raise Damaged(f"holds '{name}' packed, as no result does: a small file could fill the memory")
    place = h5py.h5o.get_info(dataset.id).addr
    if place in places:
        raise Damaged(f"holds '{name}' under another name too: a small file could fill the memory")
    places.add(place)
    return dataset


def _read_netcdf(file: Path, own: bool) -> Found:
    """own: rattle wrote the file, which packs nothing; other programs that copy a result may."""
    h5py = package("h5py", "load_result")
    size = file.stat().st_size
    places: set[int] = set()
    with h5py.File(file, "r", locking=False) as opened:
        record = _dataset(h5py, opened, RECORD, own, places)
        if record.shape != () or h5py.check_string_dtype(record.dtype) is None:
            raise InputError("no text")
        text = record.asstr()[()]
        parsed, digest = json.loads(text), record.attrs.get(DIGEST, "")
        t = _dataset(h5py, opened, "t", own, places)
        n = int(t.shape[0]) if t.ndim == 1 else -1
        columns = list(parsed["names"])
        _fits(len(columns) + 1, n, size, packed=1 if own else PACKED)
        curves = [_dataset(h5py, opened, name, own, places) for name in columns]
        if any(curve.shape != (n,) or curve.dtype.kind != "f" or curve.dtype.itemsize != 8 for curve in (t, *curves)):
            raise InputError("no curves")
        if parsed["format"] == 1:
            parsed["units"] = {name: str(curve.attrs["units"]) for name, curve in zip(columns, curves, strict=True)}
        numbers = [np.asarray(curve[()], dtype=np.float64) for curve in (t, *curves)]
    return text, parsed, str(digest), numbers[0], numbers[1:]


def _read_npz(file: Path) -> Found:
    size = file.stat().st_size
    with zipfile.ZipFile(file) as opened:

        def member(name: str) -> tuple[np.dtype[Any], tuple[int, ...], bytes]:
            info = opened.getinfo(f"{name}.npy")
            if info.compress_type != zipfile.ZIP_STORED:
                raise Damaged(f"holds '{name}' packed, as no result does: a small file could fill the memory")
            if info.file_size > size:
                raise Damaged(f"declares {info.file_size} bytes, more than {size} bytes can hold")
            content = io.BytesIO(opened.read(info))
            version = np.lib.format.read_magic(content)
            read_header = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}
            shape, _, dtype = read_header[version](content)
            return dtype, shape, content.read()

        def curve(name: str, n: int = -1) -> Array:
            dtype, shape, content = member(name)
            if dtype != np.dtype("<f8") or len(shape) != 1 or n not in (-1, shape[0]) or len(content) != 8 * shape[0]:
                raise InputError("no curve")
            return np.frombuffer(content, "<f8").astype(np.float64)

        def word(name: str) -> str:
            dtype, shape, content = member(name)
            if dtype.kind != "S" or shape != ():
                raise InputError("no text")
            return content.decode("utf-8", "surrogatepass")

        text, digest, t = word(RECORD), word(DIGEST), curve("t")
        record = json.loads(text)
        _fits(len(record["names"]) + 1, len(t), size, packed=1)
        return text, record, digest, t, [curve(name, len(t)) for name in record["names"]]


# ---------------------------------------------------------------- what a record may contain
def _require_not_later(record: Any) -> None:
    """Refuse a record of a later format, which may hold anything."""
    form = record["format"]
    if type(form) is int and form > FORMAT:
        raise Damaged(f"has format {form}; this version of rattle reads up to {FORMAT}: install a newer one")


def _has_heads(record: Any, count: int) -> bool:
    """True if the heads of a record are of their types, with `count` names of curves."""
    names = record["names"]
    return (
        type(record["format"]) is int
        and record["format"] >= 1
        and isinstance(names, list)
        and len(names) == count == len(set(names))
        and all(isinstance(name, str) and name.isprintable() and name[:1] not in "=+-@ " for name in names)
        and isinstance(record["success"], bool)
        and isinstance(record["message"], str)
        and all(isinstance(record[key], dict) for key in ("geometry", "trust", "stats", "provenance", "units"))
        and isinstance(record["events"], list)
    )


def _require_plain_values(record: object) -> None:
    """Refuse texts with control characters, and numbers too large, anywhere in a record."""
    ahead: list[object] = [record]
    while ahead:
        item = ahead.pop()
        if isinstance(item, dict | list):
            ahead += [*item, *item.values()] if isinstance(item, dict) else item
        elif isinstance(item, str) and not item.isprintable() and shown(item) != item:
            raise InputError("texts with control characters")
        elif type(item) is int and abs(item) > LARGEST:
            raise InputError("a whole number that is too large to be computed with")


def _require_plain(record: Any, count: int) -> None:
    """Refuse a record that is not as `Result.save` writes it.  Raises InputError, TypeError, KeyError."""
    if not _has_heads(record, count):
        raise InputError("not as a result is written")
    units = (record["units"][name] for name in record["names"])
    if not all(isinstance(unit, str) and unit.isprintable() for unit in units):
        raise InputError("units are texts")
    _require_plain_values(record)
    for event in record["events"]:
        _, joint, kind, *numbers = event
        corner = numbers.pop() if numbers and isinstance(numbers[-1], str) else ""  # not in results of before
        texts = isinstance(joint, str) and isinstance(kind, str) and corner.isprintable()
        if not texts or not all(type(item) in (int, float) for item in (event[0], *numbers)):
            raise InputError("an event is a time, a joint, a kind and numbers")
    if where := misfit_of(record):
        raise Damaged(f"{NO_RESULT}: {where} in its record is not as a result has it")


def _require_in_order(t: Array) -> None:
    """Refuse instants that are no numbers, go back or stand still; one may be there twice, on both sides of a jump."""
    if not (np.isfinite(t).all() and (np.diff(t) >= 0.0).all() and (len(t) < 2 or t[0] < t[-1])):
        raise Damaged(f"{NO_RESULT}: its instants are not in order")


def require_ending(path: str | os.PathLike[str], what: str, suffix: str) -> None:
    """Raise InputError for a file name that does not end as a file of this kind does."""
    if Path(path).suffix.lower() != suffix:
        raise InputError(f"{os.fspath(path)}: a {what} needs a name ending in {suffix}")


def write_content(content: bytes, path: str | os.PathLike[str], fallback: str | os.PathLike[str] | None = None) -> Path:
    """Write a file completely or not at all, under `path` or in `fallback`; returns the file written."""

    def write(place: Path) -> None:
        with atomic(place) as file:
            file.write_bytes(content)

    return first_place(write, path, fallback)


def first_place(
    write: Callable[[Path], None], path: str | os.PathLike[str], fallback: str | os.PathLike[str] | None
) -> Path:
    """Write under `path`, or in the folder `fallback` if the system cannot; returns the file written."""
    try:
        write(Path(path))
        return Path(path)
    except OSError:
        if fallback is None:
            raise
    place = expanded(fallback) / Path(path).name
    write(place)
    return place
