"""Numbers that others wrote, measured at every build: a summary, and a page for each source with curves and models."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from making.gallery import mechanism_to_scale
from making.text import anchor, fence, paragraph, table
from making.tree import module_with
from making.validation import module_of_tests, power

LINE = 300  # instants of a drawn curve
WIDE, HIGH, DOTS = 9.0, 2.1, 90  # inches, inches, dots per inch
LEAST = 1e-9  # share of what is allowed below which a difference is drawn as this


def pages(folder: Path) -> dict[str, str]:
    """The summary, what is wrong in the sources, and a page for each source; pictures go into `folder`/pictures."""
    for name in ("pictures", "foreign"):
        (folder / name).mkdir(exist_ok=True)
    cases = module_of_tests("foreign_cases").CASES
    for case in cases:
        _refuse_what_is_off(case)
        _draw(folder / "pictures" / _picture(case), case)
    by_source: dict[Any, list[Any]] = {}
    for case in cases:
        by_source.setdefault(case.source, []).append(case)
    texts = {f"foreign/{source.key}": _source_page(source, group) for source, group in by_source.items()}
    return {"foreign": _summary(by_source), "foreign-wrong": _wrong(cases), **texts}


def _refuse_what_is_off(case: Any) -> None:
    """Raise if a curve is not within its tolerance, or if one that is called wrong is."""
    for each in case.compared:
        if not each.as_claimed:
            raise ValueError(f"{case}: {each.curve.name} is {each.largest!r} off, allowed {each.curve.tolerance!r}")


# ---------------------------------------------------------------- texts
def _summary(by_source: dict[Any, list[Any]]) -> str:
    """How many numbers of whom, and how large the largest difference is of what is allowed."""
    rows, total = [], [0, 0, 0]
    for source, cases in by_source.items():
        compared = [each for case in cases for each in case.compared if not each.curve.wrong]
        shares = [each.largest / each.curve.tolerance for each in compared]
        counts = len(cases), len(compared), sum(len(each.curve.t) for each in compared)
        total = [a + b for a, b in zip(total, counts, strict=True)]
        link = f"[{paragraph(source.name)}](generated/foreign/{source.key}.md)"
        rows.append((link, *map(str, counts), f"{np.median(shares):.1g}", f"{max(shares):.2f}"))
    rows.append(("all", *map(str, total), "", ""))
    head = ("source", "cases", "curves", "numbers", "median of difference over allowed", "largest")
    return f"{table(head, rows)}\n"


def _wrong(cases: Sequence[Any]) -> str:
    """Every number of a source that is not right, with ours and the reason."""
    rows = [
        (
            f"[{paragraph(case.title)}](generated/foreign/{case.source.key}.md#{anchor(case.title)})",
            paragraph(f"{each.curve.theirs}: {_at_largest(each, each.curve.values)}"),
            _at_largest(each, each.measured),
            paragraph(each.curve.wrong),
        )
        for case in cases
        for each in case.compared
        if each.curve.wrong
    ]
    return f"{table(('case', 'source', 'here', 'why'), rows)}\n"


def _at_largest(each: Any, values: Any) -> str:
    return f"{values[int(np.abs(each.difference).argmax())]:.8g} {each.curve.unit}".strip()


def _source_page(source: Any, cases: list[Any]) -> str:
    facts = [
        ("where", f"<{source.address}>" if source.address.startswith("http") else paragraph(source.address)),
        ("commit or edition", paragraph(source.commit)),
        ("licence", paragraph(source.licence)),
        ("what it has", paragraph(source.what)),
        ("what stands here", paragraph(source.kept)),
    ]
    back = "[Validation](../../validation.md)"
    parts = [f"# {paragraph(source.name)}", table(("", ""), facts), *map(_case, cases), back]
    return "\n\n".join(parts) + "\n"


def _case(case: Any) -> str:
    rows = [_row(each) for each in case.compared]
    head = ("here", "there", "numbers", "largest", "difference", "allowed", "because")
    parts = [
        f"## {paragraph(case.title)}",
        f"{paragraph(case.file)}. {paragraph(case.says)}",
        paragraph(case.note),
        f"![{case.title}: mechanism, curves and differences](../pictures/{_picture(case)})",
        table(head, rows),
        _dropdown("The model", fence(case.model.strip(), "toml")),
        _dropdown("All numbers", fence("\n\n".join(map(_numbers, case.compared)))),
    ]
    return "\n\n".join(part for part in parts if part)


def _row(each: Any) -> tuple[str, ...]:
    curve = each.curve
    because = f"**theirs is not right**: {paragraph(curve.wrong)}" if curve.wrong else paragraph(curve.why)
    unit = f" {curve.unit}" if curve.unit else ""
    size = f"{np.abs(curve.values).max():.6g}{unit}"
    numbers = str(len(curve.t)), size, power(each.largest), power(curve.tolerance)
    return (f"`{_formula(curve)}`", paragraph(curve.theirs), *numbers, because)


def _formula(curve: Any) -> str:
    """What of ours is compared: a name, with factor and addend."""
    factor = {1.0: "", -1.0: "-"}.get(curve.times, f"{curve.times:.6g} ")
    return f"{factor}{curve.name}{f' + {curve.plus:.6g}' if curve.plus else ''}".replace("+ -", "- ")


def _numbers(each: Any) -> str:
    first = "t [s]" if each.curve.over_time else "number"
    head = f"{_formula(each.curve)}\n{first:>12} {'there':>24} {'here':>24} {'difference':>12}"
    lines = [
        f"{t:12.6g} {theirs:24.16g} {ours:24.16g} {ours - theirs:12.1e}"
        for t, theirs, ours in zip(each.curve.t, each.curve.values, each.measured, strict=True)
    ]
    return "\n".join([head, *lines])


def _dropdown(title: str, text: str) -> str:
    return f"::::{{dropdown}} {title}\n{text}\n::::"


# ---------------------------------------------------------------- pictures
def _picture(case: Any) -> str:
    return f"foreign-{case.source.key}-{case.key}.png"


def _draw(path: Path, case: Any) -> None:
    """The mechanism, up to two curves with the numbers of the source, and all differences over what is allowed."""
    from matplotlib.figure import Figure

    plot = module_with("robust_limits", "tidy")
    drawn = [each for each in case.compared if each.curve.over_time]
    shown = [drawn[0], drawn[-1]] if len(drawn) > 1 else drawn
    figure = Figure(
        figsize=(WIDE, HIGH)
    )  # with margins of our own: a layout that is searched for takes as long as the rest
    left, *middle, right = figure.subplots(1, 2 + len(shown), squeeze=False).flat
    result = case.run(_between(case))
    mechanism_to_scale(left, result, 0.0)
    for ax, each in zip(middle, shown, strict=True):
        curve = each.curve
        plot.tidy(ax).plot(result.t, curve.times * result[curve.name] + curve.plus, color=plot.BLUE, linewidth=1)
        ax.plot(curve.t, curve.values, "o", color=plot.ORANGE, markersize=3.5)
        ax.set(xlabel="t [s]", title=f"{_formula(curve)} [{curve.unit}]" if curve.unit else _formula(curve))
    plot.tidy(right)
    for each in case.compared:
        share = np.maximum(np.abs(each.difference) / each.curve.tolerance, LEAST)
        right.plot(each.curve.t, share, ".-", linewidth=0.7, markersize=4)
    right.axhline(1.0, color="0.3", linewidth=0.8, linestyle="--")
    right.set(yscale="log", title="difference over allowed", ylim=(LEAST / 2, None))
    for ax in (*middle, right):
        ax.title.set_fontsize(8)
        ax.tick_params(labelsize=7)
    left.tick_params(labelsize=7)
    left.locator_params(axis="x", nbins=3)
    for ax in (left, *middle):
        ax.xaxis.label.set_fontsize(8)
    figure.subplots_adjust(left=0.045, right=0.99, bottom=0.2, top=0.88, wspace=0.3)
    figure.savefig(path, dpi=DOTS)


def _between(case: Any) -> Any:
    """Instants of the drawn line: a motion in time is drawn from its start.  None for what is at rest."""
    if case.analysis in ("equilibrium", "modes"):
        return None
    instants = [each.curve.t for each in case.compared if each.curve.over_time]
    if not instants:
        return np.linspace(0.0, case.t_end, LINE)
    first = 0.0 if case.analysis == "simulate" else min(t[0] for t in instants)
    return np.linspace(first, max(t[-1] for t in instants), LINE)
