"""The scoreboard: error against processor time, from the file that `make bench` writes; no other program is needed."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from making.text import anchor, paragraph, table
from making.tree import module_with
from making.validation import power

RESULTS = Path(__file__).with_suffix(".toml")
OURS = "rattle"
WIDE, HIGH, DOTS = 6.4, 3.6, 100  # inches, inches, dots per inch
NAMES = {"rattle": "rattle", "exudyn": "Exudyn", "mujoco": "MuJoCo", "numpy": "NumPy"}


def pages(folder: Path) -> dict[str, str]:
    """The whole board; pictures go into `folder`/pictures."""
    (folder / "pictures").mkdir(exist_ok=True)
    results = tomllib.loads(RESULTS.read_text(encoding="utf-8"))
    parts = [_measured(results), _summary(results["cases"])]
    for case in results["cases"]:
        _draw(folder / "pictures" / _picture(case), case)
        parts += [
            f"### {paragraph(case['title'])}",
            paragraph(case["about"]),
            f"![Error against processor time: {case['title']}](generated/pictures/{_picture(case)})",
            _times(case),
        ]
    return {"scoreboard": "\n\n".join(parts) + "\n"}


def _measured(results: Mapping[str, Any]) -> str:
    versions = ", ".join(f"{NAMES[name]} {version}" for name, version in results["versions"].items())
    return (
        f"Measured on {results['date']:%d %B %Y} on {results['cores']} cores of {paragraph(results['processor'])}, "
        f"Python {results['python']}, {versions}."
    )


def _programs(case: Mapping[str, Any]) -> list[str]:
    return list(dict.fromkeys(point["program"] for point in case["points"]))


def _summary(cases: Sequence[Mapping[str, Any]]) -> str:
    """For each case and peer: how many times our time it needs, at the errors that both reach."""
    peers = list(dict.fromkeys(name for case in cases for name in _programs(case) if name != OURS))
    rows = [
        (f"[{paragraph(case['title'])}](#{anchor(case['title'])})", *(_ratios(case, peer) for peer in peers))
        for case in cases
    ]
    return table(("case", *(f"{peer}: its time over ours" for peer in peers)), rows)


def _ratios(case: Mapping[str, Any], peer: str) -> str:
    if peer not in _programs(case):
        return "not compared"
    shared = [row for row in case["equal"] if peer in row and OURS in row]
    if not shared:
        return "no error in common"
    return "; ".join(f"{_spell(row[peer] / row[OURS])} at {_power(row['error'])} {case['unit']}" for row in shared)


def _power(error: float) -> str:
    return power(error).removeprefix("1·")


def _spell(ratio: float) -> str:
    """Two digits; bold where the other program is faster."""
    text = f"{ratio:.2g}" if ratio < 100 else f"{float(f'{ratio:.2g}'):.0f}"
    return f"**{text}**" if ratio < 1.0 else text


def _times(case: Mapping[str, Any]) -> str:
    programs = _programs(case)
    rows = [
        (
            f"{_power(row['error'])} {case['unit']}",
            *(_milliseconds(row[name]) if name in row else "not reached" for name in programs),
        )
        for row in case["equal"]
    ]
    return table(("error", *programs), rows)


def _milliseconds(seconds: float) -> str:
    return f"{seconds * 1e3:.3g} ms"


def _picture(case: Mapping[str, Any]) -> str:
    return f"scoreboard-{case['key']}.png"


def _draw(path: Path, case: Mapping[str, Any]) -> None:
    """Every setting as a dot, and a line along the best ones of each program."""
    from matplotlib.figure import Figure

    plot = module_with("robust_limits", "tidy")
    figure = Figure(figsize=(WIDE, HIGH), layout="constrained")
    ax = plot.tidy(figure.subplots())
    for name, color, mark in zip(_programs(case), (plot.BLUE, plot.ORANGE, plot.GREEN), "os^", strict=False):
        points = [point for point in case["points"] if point["program"] == name]
        ax.plot(
            [one["error"] for one in points],
            [one["seconds"] * 1e3 for one in points],
            mark,
            color=color,
            markersize=3,
            alpha=0.4,
        )
        best = sorted((one for one in points if "best" in one), key=lambda one: one["error"])
        errors, seconds = [one["error"] for one in best], [one["seconds"] * 1e3 for one in best]
        ax.plot(errors, seconds, f"-{mark}", color=color, markersize=4.5, linewidth=1.4, label=name)
    ax.set(xscale="log", yscale="log", xlabel=f"error [{case['unit']}]", ylabel="processor time [ms]")
    ax.set_xlim(3e-16, 1.0)
    ax.invert_xaxis()
    ax.legend(frameon=False)
    figure.savefig(path, dpi=DOTS)
