"""The file of results, which the page of the documentation is made from."""

from __future__ import annotations

import datetime
import importlib.metadata
import os
import platform
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from scoreboard.cases import ERRORS
from scoreboard.curves import Case, Point, front, seconds_at

PACKAGES = ("rattle", "exudyn", "mujoco", "numpy")


def write(path: Path, measured: Iterable[tuple[Case, Sequence[Point]]]) -> None:
    """All points, and the times at equal error, as TOML."""
    lines = [
        "# Written by `make bench`; docs/scoreboard.md shows it.",
        f"date = {datetime.date.today().isoformat()}",
        f'processor = "{processor()}"',
        f"cores = {os.cpu_count()}",
        f'python = "{platform.python_version()}"',
        "",
        "[versions]",
        *(f'{name} = "{version}"' for name, version in versions().items()),
    ]
    for case, points in measured:
        programs = dict.fromkeys(one.program for one in points)
        best = [one for name in programs for one in front(point for point in points if point.program == name)]
        lines += [
            "",
            "[[cases]]",
            f'key = "{case.key}"',
            f'title = "{case.title}"',
            f'about = "{case.about}"',
            f'unit = "{case.unit}"',
            "equal = [",
            *(f"    {_inline(row)}," for row in equal(points)),
            "]",
            "points = [",
            *(
                f'    {{ program = "{one.program}", setting = "{one.setting}", error = {one.error:.2e}, '
                f"seconds = {one.seconds:.3e}{', best = true' if one in best else ''} }},"
                for one in points
            ),
            "]",
        ]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def equal(points: Sequence[Point]) -> list[dict[str, float]]:
    """For each error the time of every program that gets there [s]."""
    rows = []
    for error in ERRORS:
        row = {"error": error}
        for program in dict.fromkeys(one.program for one in points):
            seconds = seconds_at([one for one in points if one.program == program], error)
            if seconds is not None:
                row[program] = seconds
        rows.append(row)
    return rows


def _inline(row: Mapping[str, float]) -> str:
    return "{ " + ", ".join(f"{key} = {value:.3e}" for key, value in row.items()) + " }"


def versions() -> dict[str, str]:
    """Of the programs that are here."""
    found = {}
    for name in PACKAGES:
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            continue
    return found


def processor() -> str:
    """The kind of processor, never the name of the machine."""
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()
