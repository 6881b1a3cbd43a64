"""Samples in a folder: written piece by piece, resumed after any end, read column by column.

    manifest.json                                    what the samples are of, see `identity`
    samples-000000000000-000000004095.parquet        one row per sample: number, parameters, outputs, status, message
    histories-000000000000-000000004095.nc           curves of these samples, if they are asked for; written before

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
from collections.abc import Container, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from rattle.atomic_file import atomic
from rattle.errors import InputError
from rattle.questions.ensemble import history_files, identity
from rattle.questions.ensemble.history_files import Damaged
from rattle.questions.ensemble.pieces import OWN, STATUS, WAITING, Piece, column_name
from rattle.questions.ensemble.plans import Plan
from rattle.questions.ensemble.store import Memory, Store, add_counts
from rattle.results.archive import package
from rattle.studies.runs.task import Task
from rattle.user_paths import expanded
from rattle.value_types import Tree

log = logging.getLogger("rattle")

MANIFEST = "manifest.json"
DAMAGED = ".damaged"  # added to the name of a file that cannot be read
NAME = re.compile(r"samples-(\d+)-(\d+)\.parquet")
LEFTOVER = re.compile(r"\.(manifest|(samples|histories)-\d+-\d+)-[0-9a-f]{8}\.(json|parquet|nc)")
STALE = 10.0  # seconds after which a temporary file is taken for one of a run that was killed
REASONS = b"rattle.reasons"
CODES = {text: code for code, text in STATUS.items()}


def store_of(task: Task, plan: Plan, folder: str | os.PathLike[str] | None, resume: bool = True) -> Store:
    """Where the samples of a task are kept: in memory, or in a folder.  Raises what `Folder` raises."""
    if folder is None:
        return Memory(plan.names, task.texts, plan.count, task.histories, len(task.history_times))
    return Folder(folder, task, plan, resume)


class _File(NamedTuple):
    path: Path
    first: int  # number of its first sample
    last: int  # one after that of its last one

    @property
    def curves(self) -> Path:
        """The file of the histories of its samples."""
        return self.path.with_name(self.path.stem.replace("samples", "histories") + ".nc")


class Folder:
    """The samples of a task in a folder; memory is needed for the columns that are asked for only."""

    def __init__(self, path: str | os.PathLike[str], task: Task, plan: Plan, resume: bool = True) -> None:
        """Open a folder, made if it is not there.

        resume: go on with what is there; otherwise a folder with samples is refused.
        Raises InputError for a folder of another run, OSError for one that cannot be used, MissingPackage.
        """
        package("pyarrow", "a folder of samples")
        self.path = expanded(path)
        self._plan, self._count = plan, plan.count
        self._units = {
            name: parameter.unit for name, parameter in task.mechanism.model.parameters.items() if name in plan.names
        }
        self._units |= {output.text: output.unit for output in task.outputs}
        self._columns = {name: column_name(name) for name in (*plan.names, *task.texts)}
        self._order = [*plan.names, *task.texts]
        self._histories = dict(zip(task.histories, task.history_units, strict=True))
        self._times = task.history_times
        if self._histories:
            package("h5netcdf", history_files.FOR)
        self._reasons: dict[str, int] = {}
        self._files: list[_File] = []
        self._open(identity.identity(task, plan), resume)
        self._find()

    # ---------------------------------------------------------------- opening
    def _open(self, now: Tree, resume: bool) -> None:
        """Compare with the manifest, or write one.  Raises as `__init__`."""
        if self.path.exists() and not self.path.is_dir():
            raise NotADirectoryError(f"{self.path} is a file; give the name of a folder")
        self.path.mkdir(parents=True, exist_ok=True)
        manifest = self.path / MANIFEST
        if not manifest.exists():
            others = sorted(path.name for path in self.path.iterdir() if not LEFTOVER.fullmatch(path.name))
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
            raise InputError(f"{self.path} has format {before['format']}, this version of rattle has {now['format']}")
        if words := identity.difference(before, now):
            raise InputError(f"{self.path} holds another run, {words}; give another folder")
        if before["n"] != self._count and not self._plan.grows:
            what = f"n = {before['n']}, now {self._count}, and the first samples of its design depend on n"
            raise InputError(f"{self.path} holds another run, {what}; give another folder")
        self._made_with = before.get("made with", {})
        if before["n"] < self._count:
            self._write_manifest(manifest, {**before, **now})

    def _write_manifest(self, manifest: Path, now: Tree) -> None:
        self._made_with = now.get("made with", identity.versions())
        text = json.dumps({**now, "n": self._count, "made with": self._made_with}, indent=1)
        with atomic(manifest) as file:
            file.write_text(text, encoding="utf-8")

    def _find(self) -> None:
        """Find the samples that are there; what killed runs have left is removed, damaged files are put aside."""
        files, reached = [], 0
        for path in sorted(self.path.iterdir()):
            if match := NAME.fullmatch(path.name):
                files.append(_File(path, int(match[1]), int(match[2]) + 1))
        self._remove_leftovers({file.curves.name for file in files})
        for file in sorted(files, key=lambda file: (file.first, -file.last)):
            new = min(file.last, self._count) - max(file.first, reached)
            if new <= 0:
                continue
            try:
                reasons = self._checked(file)
            except Damaged as error:
                aside = file.path.with_name(file.path.name + DAMAGED)
                os.replace(file.path, aside)
                log.warning(f"{file.path} is damaged ({error}): it is now {aside.name}, and its samples are run again")
                continue
            reached = file.last
            self._files.append(file)
            add_counts(self._reasons, {reason: min(count, new) for reason, count in reasons.items()})

    def _remove_leftovers(self, wanted: Container[str]) -> None:
        """Remove temporary files, and histories without samples, that no process can be about to finish."""
        for path in self.path.iterdir():
            histories = path.name.startswith("histories-") and path.name not in wanted
            if LEFTOVER.fullmatch(path.name) or histories:
                with suppress(OSError):  # another process may have removed it
                    if time.time() - path.stat().st_mtime > STALE:
                        path.unlink()

    def _checked(self, file: _File) -> dict[str, int]:
        """Why samples of a file could not run side by side.  Raises Damaged, and ValueError for other samples."""
        table = self._read(file)
        missing = {*OWN, *self._columns.values()} - {*table.column_names}
        numbers = np.arange(file.first, file.last)
        if missing or not np.array_equal(table["sample"].to_numpy(), numbers):
            raise Damaged("its samples are not those of its name" if not missing else f"no column {min(missing)}")
        if self._histories:
            history_files.require(file.curves)
        last = min(file.last, self._count)
        parameters = self._plan.values(file.first, last)
        for name, values in zip(self._plan.names, parameters, strict=True):
            if not np.array_equal(table[self._columns[name]].to_numpy()[: last - file.first], values):
                raise InputError(
                    f"{file.path}: its values of {name} are not those of this design and seed; it was made with"
                    f" {_listed(self._made_with)}, this is {_listed(identity.versions())}: give another folder"
                )
        return dict(json.loads((table.schema.metadata or {}).get(REASONS, b"{}")))

    def _read(self, file: _File, columns: list[str] | None = None) -> Any:
        """Columns of a file, by default all, as a table.  Raises Damaged, PermissionError."""
        import pyarrow
        from pyarrow import parquet

        try:
            with file.path.open("rb") as opened:
                return parquet.ParquetFile(opened, page_checksum_verification=True).read(columns, use_threads=False)
        except PermissionError:
            raise
        except (OSError, pyarrow.ArrowException) as error:
            raise Damaged(str(error).partition("\n")[0]) from error

    # ---------------------------------------------------------------- writing
    @property
    def place(self) -> str:
        """Where samples are kept."""
        return str(self.path)

    def add(self, piece: Piece) -> None:
        """Write a piece.  Raises OSError if it cannot be written; those before it are kept."""
        file = _File(self.path / f"samples-{piece.first:012d}-{piece.last - 1:012d}.parquet", piece.first, piece.last)
        contents = {file.path: self._content(piece)}
        if self._histories:
            curves = dict(zip(self._histories, piece.curves, strict=True))
            contents = {
                file.curves: history_files.content(piece.first, self._times, curves, self._histories),
                **contents,
            }
        try:
            for path, content in contents.items():
                with atomic(path) as temporary:
                    temporary.write_bytes(content)
        except OSError as error:
            kept = self._count - sum(b - a for a, b in self.missing())
            words = f"{error}; {kept} samples are kept, and the same call goes on once the folder can be written"
            named = type(error)(words)
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
        columns["status"] = pyarrow.array([STATUS[int(code)] for code in piece.status])
        columns["generic"] = pyarrow.array(piece.generic)
        columns["message"] = pyarrow.array([piece.messages.get(n, "") for n in numbers], pyarrow.string())
        units = {self._columns[name]: {b"unit": unit.encode()} for name, unit in self._units.items()}
        schema = pyarrow.schema(
            [pyarrow.field(name, column.type, metadata=units.get(name)) for name, column in columns.items()],
            metadata={REASONS: json.dumps(piece.reasons).encode()},
        )
        buffer = io.BytesIO()
        table = pyarrow.Table.from_arrays(list(columns.values()), schema=schema)
        parquet.write_table(table, buffer, compression="zstd", write_page_checksum=True)
        return buffer.getvalue()

    # ---------------------------------------------------------------- reading
    def missing(self) -> list[tuple[int, int]]:
        """Ranges (first, last) of samples that have not been run, increasing."""
        ranges, reached = [], 0
        for file in sorted(self._files, key=lambda file: file.first):
            ranges.append((reached, file.first))
            reached = max(reached, file.last)
        return [(a, b) for a, b in [*ranges, (reached, self._count)] if a < b]

    def column(self, name: str) -> np.ndarray:
        """(n,) a parameter or output [SI], nan where it is not known."""
        values, column = np.full(self._count, np.nan), self._columns[name]
        for place, table in self._tables(column):
            values[place] = table[column].to_numpy()[: place.stop - place.start]
        return values

    def curves(self, name: str) -> np.ndarray:
        """(n, m) histories [SI], nan where they are not known."""
        curves = np.full((self._count, len(self._times)), np.nan)
        for file in self._files:
            last = min(file.last, self._count)
            curves[file.first : last] = history_files.read(file.curves, name)[: last - file.first]
        return curves

    def curve(self, name: str, sample: int) -> np.ndarray:
        """(m,) the history of a sample [SI], nan where it is not known."""
        for file in self._files:
            if file.first <= sample < file.last:
                return history_files.read(file.curves, name, sample - file.first)
        return np.full(len(self._times), np.nan)

    def status(self) -> np.ndarray:
        """(n,) int8, see `pieces`."""
        from pyarrow import array, compute

        status = np.full(self._count, WAITING, dtype=np.int8)
        codes = np.array(list(CODES.values()), dtype=np.int8)
        for place, table in self._tables("status"):
            texts = compute.index_in(table["status"], value_set=array(list(CODES)))
            status[place] = codes[texts.to_numpy()][: place.stop - place.start]
        return status

    def generic(self) -> np.ndarray:
        """(n,) bool: run one by one."""
        generic = np.zeros(self._count, dtype=bool)
        for place, table in self._tables("generic"):
            generic[place] = table["generic"].to_numpy()[: place.stop - place.start]
        return generic

    def messages(self) -> dict[int, str]:
        """Why samples failed, by number."""
        from pyarrow import compute

        messages: dict[int, str] = {}
        for _, table in self._tables("sample", "message"):
            failed = table.filter(compute.not_equal(table["message"], ""))
            messages |= zip(failed["sample"].to_pylist(), failed["message"].to_pylist(), strict=True)
        return {n: messages[n] for n in sorted(messages) if n < self._count}

    def reasons(self) -> dict[str, int]:
        """Why samples could not run side by side, and how many."""
        return self._reasons

    def _tables(self, *columns: str) -> Iterator[tuple[slice, Any]]:
        """The files one by one: the places of their samples in arrays (n,), and columns of them.  Raises OSError."""
        for file in self._files:
            try:
                yield slice(file.first, min(file.last, self._count)), self._read(file, list(columns))
            except Damaged as error:
                raise OSError(
                    f"{file.path} was damaged meanwhile ({error}); the same call runs its samples again"
                ) from error


def _read_manifest(manifest: Path) -> dict[str, Any]:
    """What a manifest says.  Raises InputError."""
    try:
        contents = json.loads(manifest.read_text(encoding="utf-8"))
        right = isinstance(contents["format"], int) and isinstance(contents["n"], int)
    except (ValueError, KeyError, TypeError, RecursionError):
        right = False
    if not right:
        raise InputError(f"{manifest} is damaged, or is not of rattle; give another folder")
    return dict(contents)


def _listed(made_with: Mapping[str, str]) -> str:
    return ", ".join(f"{name} {version}" for name, version in made_with.items()) or "unknown versions"
