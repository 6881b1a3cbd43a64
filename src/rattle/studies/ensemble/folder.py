"""Samples in a folder: written piece by piece, resumed after any end, read column by column.

    manifest.json                                    what the samples are of, see `identity`
    samples-000000000000-000000004095.parquet        one row per sample: number, parameters, outputs, status, message

Every file is written under a temporary name, with a dot in front, and renamed when it is whole: what has a name is
complete, however a run ended.  A file also has checksums, for what may happen to it later.  Which samples are there
is known from the files alone.  Where files overlap, as those of two processes may, a sample is taken once: samples
are placed by their number, and its numbers are the same in both.
"""

from __future__ import annotations

import io
import json
import logging
import os
import re
import time
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from rattle.atomic_file import atomic
from rattle.results.archive import package
from rattle.studies.ensemble import identity
from rattle.studies.ensemble.pieces import STATUS, WAITING, Piece
from rattle.studies.ensemble.plans import Plan
from rattle.studies.ensemble.store import Memory, Store, add_counts
from rattle.studies.runs.task import Task

log = logging.getLogger("rattle")

MANIFEST = "manifest.json"
DAMAGED = ".damaged"  # added to the name of a file that cannot be read
NAME = re.compile(r"samples-(\d+)-(\d+)\.parquet")
LEFTOVER = re.compile(r"\.(manifest|samples-\d+-\d+)-[0-9a-f]{8}\.(json|parquet)")
STALE = 10.0  # seconds after which a temporary file is taken for one of a run that was killed
OWN = ("sample", "status", "generic", "message")  # columns besides those of parameters and outputs
REASONS = b"rattle.reasons"
CODES = {text: code for code, text in STATUS.items()}


def store_of(task: Task, plan: Plan, folder: str | os.PathLike[str] | None, resume: bool = True) -> Store:
    """Where the samples of a task are kept: in memory, or in a folder.  Raises what `Folder` raises."""
    if folder is None:
        return Memory(plan.names, task.texts, plan.count)
    return Folder(folder, task, plan, resume)


class _File(NamedTuple):
    path: Path
    first: int  # number of its first sample
    last: int  # one after that of its last one


class Folder:
    """The samples of a task in a folder; memory is needed for the columns that are asked for only."""

    def __init__(self, path: str | os.PathLike[str], task: Task, plan: Plan, resume: bool = True) -> None:
        """Open a folder, made if it is not there.

        resume: go on with what is there; otherwise a folder with samples is refused.
        Raises ValueError for a folder of another run, OSError for one that cannot be used, MissingPackage.
        """
        package("pyarrow", "a folder of samples")
        self.path = Path(path).expanduser()
        self._plan, self._count = plan, plan.count
        self._units = {name: one.unit for name, one in task.mechanism.model.parameters.items() if name in plan.names}
        self._units |= {one.text: one.unit for one in task.outputs}
        self._columns = {name: f"parameter {name}" if name in OWN else name for name in (*plan.names, *task.texts)}
        self._order = [*plan.names, *task.texts]
        self._reasons: dict[str, int] = {}
        self._files: list[_File] = []
        self._open(identity.identity(task, plan), resume)
        self._find()

    # ---------------------------------------------------------------- opening
    def _open(self, now: dict[str, Any], resume: bool) -> None:
        """Compare with the manifest, or write one.  Raises as `__init__`."""
        if self.path.exists() and not self.path.is_dir():
            raise NotADirectoryError(f"{self.path} is a file; give the name of a folder")
        self.path.mkdir(parents=True, exist_ok=True)
        manifest = self.path / MANIFEST
        if not manifest.exists():
            others = sorted(one.name for one in self.path.iterdir() if not LEFTOVER.fullmatch(one.name))
            if others:
                raise FileExistsError(
                    f"{self.path} holds other files ({', '.join(others[:3])}{', ...' if others[3:] else ''}) and no"
                    f" {MANIFEST}; give a new or an empty folder"
                )
            self._write_manifest(manifest, now)
            return
        if not resume:
            raise FileExistsError(f"{self.path} holds a run already; give another folder, or resume=True to go on")
        before = _read_manifest(manifest)
        if before["format"] != now["format"]:
            raise ValueError(f"{self.path} has format {before['format']}, this version of rattle has {now['format']}")
        if said := identity.difference(before, now):
            raise ValueError(f"{self.path} holds another run, {said}; give another folder")
        if before["n"] != self._count and not self._plan.grows:
            what = f"n = {before['n']}, now {self._count}, and the first samples of its design depend on n"
            raise ValueError(f"{self.path} holds another run, {what}; give another folder")
        self._made_with = before.get("made with", {})
        if before["n"] < self._count:
            self._write_manifest(manifest, {**before, **now})

    def _write_manifest(self, manifest: Path, now: Mapping[str, Any]) -> None:
        self._made_with = now.get("made with", identity.versions())
        text = json.dumps({**now, "n": self._count, "made with": self._made_with}, indent=1)
        with atomic(manifest) as file:
            file.write_text(text, encoding="utf-8")

    def _find(self) -> None:
        """Find the samples that are there; what killed runs have left is removed, damaged files are put aside."""
        found = []
        for path in sorted(self.path.iterdir()):
            if LEFTOVER.fullmatch(path.name):
                with suppress(OSError):  # another process may have removed it
                    if time.time() - path.stat().st_mtime > STALE:
                        path.unlink()
            elif match := NAME.fullmatch(path.name):
                found.append(_File(path, int(match[1]), int(match[2]) + 1))
        reached = 0
        for file in sorted(found, key=lambda one: (one.first, -one.last)):
            new = min(file.last, self._count) - max(file.first, reached)
            if new <= 0:
                continue
            try:
                reasons = self._checked(file)
            except _Damaged as error:
                aside = file.path.with_name(file.path.name + DAMAGED)
                os.replace(file.path, aside)
                log.warning(f"{file.path} is damaged ({error}): it is now {aside.name}, and its samples are run again")
                continue
            reached = file.last
            self._files.append(file)
            add_counts(self._reasons, {said: min(count, new) for said, count in reasons.items()})

    def _checked(self, file: _File) -> dict[str, int]:
        """Why samples of a file could not run side by side.  Raises _Damaged, and ValueError for other samples."""
        table = self._read(file)
        missing = {*OWN, *self._columns.values()} - {*table.column_names}
        numbers = np.arange(file.first, file.last)
        if missing or not np.array_equal(table["sample"].to_numpy(), numbers):
            raise _Damaged("its samples are not those of its name" if not missing else f"no column {min(missing)}")
        last = min(file.last, self._count)
        parameters = self._plan.values(file.first, last)
        for name, values in zip(self._plan.names, parameters, strict=True):
            if not np.array_equal(table[self._columns[name]].to_numpy()[: last - file.first], values):
                raise ValueError(
                    f"{file.path}: its values of {name} are not those of this design and seed; it was made with"
                    f" {_listed(self._made_with)}, this is {_listed(identity.versions())}: give another folder"
                )
        return dict(json.loads((table.schema.metadata or {}).get(REASONS, b"{}")))

    def _read(self, file: _File, columns: list[str] | None = None) -> Any:
        """Columns of a file, by default all, as a table.  Raises _Damaged, PermissionError."""
        import pyarrow
        from pyarrow import parquet

        try:
            with file.path.open("rb") as opened:
                return parquet.ParquetFile(opened, page_checksum_verification=True).read(columns)
        except PermissionError:
            raise
        except (OSError, pyarrow.ArrowException) as error:
            raise _Damaged(str(error).partition("\n")[0]) from error

    # ---------------------------------------------------------------- writing
    @property
    def place(self) -> str:
        """Where samples are kept."""
        return str(self.path)

    def add(self, piece: Piece) -> None:
        """Write a piece.  Raises OSError if it cannot be written; those before it are kept."""
        file = _File(self.path / f"samples-{piece.first:012d}-{piece.last - 1:012d}.parquet", piece.first, piece.last)
        content = self._content(piece)
        try:
            with atomic(file.path) as temporary:
                temporary.write_bytes(content)
        except OSError as error:
            kept = self._count - sum(b - a for a, b in self.missing())
            said = f"{error}; {kept} samples are kept, and the same call goes on once the folder can be written"
            named = type(error)(said)
            named.errno = error.errno
            raise named from error
        self._files.append(file)
        add_counts(self._reasons, piece.reasons)

    def _content(self, piece: Piece) -> bytes:
        """A piece as a Parquet file; made in memory first, so that a full disk leaves no partial file."""
        import pyarrow
        from pyarrow import parquet

        numbers = range(piece.first, piece.last)
        columns: dict[str, Any] = {"sample": pyarrow.array(np.arange(piece.first, piece.last, dtype=np.int64))}
        for name, values in zip(self._order, [*piece.parameters, *piece.values], strict=True):
            columns[self._columns[name]] = pyarrow.array(np.ascontiguousarray(values, dtype=np.float64))
        columns["status"] = pyarrow.array([STATUS[int(one)] for one in piece.status])
        columns["generic"] = pyarrow.array(piece.generic)
        columns["message"] = pyarrow.array([piece.messages.get(n, "") for n in numbers], pyarrow.string())
        units = {self._columns[name]: {b"unit": unit.encode()} for name, unit in self._units.items()}
        schema = pyarrow.schema(
            [pyarrow.field(name, one.type, metadata=units.get(name)) for name, one in columns.items()],
            metadata={REASONS: json.dumps(piece.reasons).encode()},
        )
        buffer = io.BytesIO()
        table = pyarrow.Table.from_arrays(list(columns.values()), schema=schema)
        parquet.write_table(table, buffer, compression="zstd", write_page_checksum=True)
        return buffer.getvalue()

    # ---------------------------------------------------------------- reading
    def missing(self) -> list[tuple[int, int]]:
        """Ranges (first, last) of samples that have not been run, increasing."""
        found, reached = [], 0
        for file in sorted(self._files, key=lambda one: one.first):
            found.append((reached, file.first))
            reached = max(reached, file.last)
        return [(a, b) for a, b in [*found, (reached, self._count)] if a < b]

    def column(self, name: str) -> np.ndarray:
        """(n,) a parameter or output [SI], nan where it is not known."""
        found, column = np.full(self._count, np.nan), self._columns[name]
        for place, table in self._tables(column):
            found[place] = table[column].to_numpy()[: place.stop - place.start]
        return found

    def status(self) -> np.ndarray:
        """(n,) int8, see `pieces`."""
        from pyarrow import array, compute

        found = np.full(self._count, WAITING, dtype=np.int8)
        codes = np.array(list(CODES.values()), dtype=np.int8)
        for place, table in self._tables("status"):
            texts = compute.index_in(table["status"], value_set=array(list(CODES)))
            found[place] = codes[texts.to_numpy()][: place.stop - place.start]
        return found

    def generic(self) -> np.ndarray:
        """(n,) bool: run one by one."""
        found = np.zeros(self._count, dtype=bool)
        for place, table in self._tables("generic"):
            found[place] = table["generic"].to_numpy()[: place.stop - place.start]
        return found

    def messages(self) -> dict[int, str]:
        """Why samples failed, by number."""
        from pyarrow import compute

        found: dict[int, str] = {}
        for _, table in self._tables("sample", "message"):
            said = table.filter(compute.not_equal(table["message"], ""))
            found |= zip(said["sample"].to_pylist(), said["message"].to_pylist(), strict=True)
        return {n: found[n] for n in sorted(found) if n < self._count}

    def reasons(self) -> dict[str, int]:
        """Why samples could not run side by side, and how many."""
        return self._reasons

    def _tables(self, *columns: str) -> Iterator[tuple[slice, Any]]:
        """The files one by one: the places of their samples in arrays (n,), and columns of them.  Raises OSError."""
        for file in self._files:
            try:
                yield slice(file.first, min(file.last, self._count)), self._read(file, list(columns))
            except _Damaged as error:
                raise OSError(
                    f"{file.path} was damaged meanwhile ({error}); the same call runs its samples again"
                ) from error


class _Damaged(Exception):
    """A file is not as it was written."""


def _read_manifest(manifest: Path) -> dict[str, Any]:
    """What a manifest says.  Raises ValueError."""
    try:
        found = json.loads(manifest.read_text(encoding="utf-8"))
        right = isinstance(found["format"], int) and isinstance(found["n"], int)
    except (ValueError, KeyError, TypeError, RecursionError):
        right = False
    if not right:
        raise ValueError(f"{manifest} is damaged, or is not of rattle; give another folder")
    return dict(found)


def _listed(made_with: Mapping[str, str]) -> str:
    return ", ".join(f"{name} {version}" for name, version in made_with.items()) or "unknown versions"
