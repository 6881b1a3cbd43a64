"""Numbers that others wrote, measured at every build: a summary, and a page for each source with curves and models."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from making.gallery import mechanism_to_scale
from making.text import anchor, fence, paragraph, table
from making.tree import module_with
from making.validation import module_of_tests, power

LINE = 300  # instants of a drawn curve
WIDE, HIGH, DOTS = 6.6, 2.4, 100  # inches, inches of a row, dots per inch: as wide as the text
CONSTANT = 1e-6  # range over size below which a curve is a constant
LEANEST = 0.6  # of its longer side, the shorter one of a drawn mechanism's axes
FEW, MANY = 6, 10  # digits of numbers side by side; with more of them columns grow too wide
NAMED = 5  # differences with a legend; more would cover them
LEAST = 1e-9  # share of what is allowed below which a difference is drawn as this


def pages(folder: Path) -> dict[str, str]:
    """The summary, where we differ, and a page for each source; pictures go into `folder`/pictures."""
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
    return {"foreign": _summary(by_source), "foreign-differing": _differing(cases), **texts}


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
        rows.append((link, _counted(counts), f"{power(float(np.median(shares)))}; {_share(max(shares))}"))
    rows.append(("all", _counted(total), ""))
    return f"{table(('source', 'compared', 'difference over allowed: median; largest'), rows)}\n"


def _share(value: float) -> str:
    return f"{value:.2f}" if value >= 0.01 else power(value)


def _counted(counts: Sequence[int]) -> str:
    return ", ".join(
        f"{n} {word}{'s' if n > 1 else ''}" for n, word in zip(counts, ("case", "curve", "number"), strict=True)
    )


def _differing(cases: Sequence[Any]) -> str:
    """Every curve whose difference is larger than allowed, with the reason that we see."""
    rows = [
        (
            f"[{paragraph(case.title)}](generated/foreign/{case.source.key}.md#{anchor(case.title)}), "
            f"{paragraph(each.curve.theirs)}",
            *_at_largest(each),
            f"{power(each.largest)}, allowed {power(each.curve.tolerance)}",
            paragraph(each.curve.wrong),
        )
        for case in cases
        for each in case.compared
        if each.curve.wrong
    ]
    return f"{_stacked(('case', 'theirs', 'ours', 'difference', 'what we see'), rows)}\n"


def _at_largest(each: Any) -> tuple[str, str]:
    """Theirs and ours where they differ most, with as many digits as tell them apart, if that is not rounding."""
    n = int(np.abs(each.difference if each.largest else each.curve.values).argmax())
    size = max(abs(each.curve.values[n]), abs(each.measured[n]))
    apart = np.ceil(np.log10(size / each.largest)) + 2 if 0 < each.largest < size else FEW
    digits = int(apart) if FEW <= apart <= MANY else FEW
    theirs, ours = (f"{number:.{digits}g} {each.curve.unit}" for number in (each.curve.values[n], each.measured[n]))
    return theirs.strip(), ours.strip()


def _source_page(source: Any, cases: list[Any]) -> str:
    facts = [
        ("Where", f"<{source.address}>" if source.address.startswith("http") else paragraph(source.address)),
        ("Commit or edition", paragraph(source.commit)),
        ("Licence", paragraph(source.licence)),
        ("What it has", paragraph(source.what)),
        ("What stands here", paragraph(source.kept)),
    ]
    parts = [
        f"# {paragraph(source.name)}",
        "\n".join(f"* **{title}**: {text}" for title, text in facts),
        READ,
        *map(_case, cases),
        "[Validation](../../validation.md)",
    ]
    return "\n\n".join(parts) + "\n"


READ = (
    "Models are written in our words; where they differ from those of the source, it is said. Tables show both numbers "
    "where they are farthest apart, and the largest difference of all numbers of a curve, beside what may be expected "
    "of the two programs. Dots are theirs, lines are ours. Should we have misread something, we are glad to hear of it."
)


def _case(case: Any) -> str:
    parts = [
        f"## {paragraph(case.title)}",
        f"{paragraph(case.file)}. {paragraph(case.says)}",
        paragraph(case.note),
        f"![{case.title}: mechanism, curves and differences](../pictures/{_picture(case)})",
        _stacked(("curve", "theirs", "ours", "difference", "allowed, and why"), map(_row, case.compared)),
        _dropdown("The model", fence(case.model.strip(), "toml")),
        _dropdown("All numbers", fence("\n\n".join(map(_numbers, case.compared)))),
    ]
    return "\n\n".join(part for part in parts if part)


def _row(each: Any) -> tuple[str, ...]:
    curve = each.curve
    count = f"{len(curve.t)} numbers" if len(curve.t) > 1 else "one number"
    unit = f" {curve.unit}" if curve.unit else ""
    why = f"{power(curve.tolerance)}{unit}: {paragraph(curve.why)}"
    seen = (
        f". **Differs**: {paragraph(curve.wrong)}. Ours are held to {paragraph(curve.right_by)}" if curve.wrong else ""
    )
    name = f"`{_formula(curve)}`, theirs: {paragraph(curve.theirs)}; {count}"
    return name, *_at_largest(each), f"{power(each.largest)}{unit}", why + seen


def _stacked(head: Sequence[str], rows: Iterable[tuple[str, ...]]) -> str:
    """A table whose rows become blocks on a narrow screen."""
    return f"::::{{div}} compared\n{table(head, rows)}\n::::"


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
    result = case.run(_between(case))
    if len(result.t) < 2:
        drawn = []  # nothing but an instant
    shown = [drawn[0], drawn[-1]] if len(drawn) > 1 else drawn
    single = shown and all(len(each.curve.t) == 1 for each in case.compared)  # the table says it all
    axes = _axes(Figure(), 1 + len(shown) + (not single))
    mechanism_to_scale(axes[0], result, 0.0)
    _widen(axes[0])
    for ax, each in zip(axes[1:], shown, strict=False):
        curve = each.curve
        plot.tidy(ax).plot(result.t, curve.times * result[curve.name] + curve.plus, color=plot.BLUE, linewidth=1)
        ax.plot(curve.t, curve.values, "o", color=plot.ORANGE, markersize=3.5)
        ax.set(xlabel="t [s]", title=f"{_formula(curve)} [{curve.unit}]" if curve.unit else _formula(curve))
        _leave_rounding_out(ax)
    if not single:
        _draw_differences(plot.tidy(axes[-1]), case)
    for ax in axes:
        ax.title.set_fontsize(9)
        ax.xaxis.label.set_fontsize(8)
        ax.tick_params(labelsize=8)
    (left, right), (low, high) = axes[0].get_xlim(), axes[0].get_ylim()
    nbins = 4 if right - left > 0.8 * (high - low) else 2  # numbers side by side
    axes[0].locator_params(axis="x", nbins=nbins, min_n_ticks=1)
    axes[0].figure.savefig(path, dpi=DOTS)


def _axes(figure: Any, count: int) -> list[Any]:
    """So many axes in rows of two, a last one alone as wide as both; margins are our own, a search takes longer."""
    rows = (count + 1) // 2
    figure.set_size_inches(WIDE, HIGH * rows)
    cells = figure.add_gridspec(rows, 2)
    axes = [figure.add_subplot(cells[divmod(n, 2)]) for n in range(count - count % 2)]
    if count % 2:
        axes.append(figure.add_subplot(cells[-1, :]))
    down = 0.46 / (HIGH * rows)  # [of the height] for the labels of an axis
    figure.subplots_adjust(left=0.08, right=0.985, bottom=down, top=1 - 0.6 * down, wspace=0.22, hspace=0.45)
    return axes


def _leave_rounding_out(ax: Any) -> None:
    """What is constant but for rounding is drawn as a constant."""
    low, high = ax.get_ylim()
    middle = (low + high) / 2
    if high - low < CONSTANT * abs(middle):
        ax.set_ylim(middle - 0.1 * abs(middle), middle + 0.1 * abs(middle))


def _widen(ax: Any) -> None:
    """Room beside a mechanism that is all height, or above one that is all length: its numbers would run together."""
    (left, right), (low, high) = ax.get_xlim(), ax.get_ylim()
    wide, tall = max(right - left, LEANEST * (high - low)), max(high - low, LEANEST * (right - left))
    ax.set_xlim((left + right - wide) / 2, (left + right + wide) / 2)
    ax.set_ylim((low + high - tall) / 2, (low + high + tall) / 2)


def _draw_differences(ax: Any, case: Any) -> None:
    """Differences over what is allowed: of curves over time, or else of lists of numbers."""
    over_time = [each for each in case.compared if each.curve.over_time]
    drawn = over_time or case.compared
    for each in drawn:
        share = np.maximum(np.abs(each.difference) / each.curve.tolerance, LEAST)
        ax.plot(each.curve.t, share, ".-", linewidth=0.7, markersize=4, label=_formula(each.curve))
    ax.axhline(1.0, color="0.3", linewidth=0.8, linestyle="--")
    ax.set(yscale="log", title="difference over allowed", ylim=(LEAST / 2, None))
    ax.set_xlabel("t [s]" if over_time else "number")
    if len(drawn) <= NAMED:
        ax.legend(fontsize=7, loc="lower right", framealpha=0.7, borderpad=0.2, labelspacing=0.2)


def _between(case: Any) -> Any:
    """Instants of the drawn line: a motion in time is drawn from its start.  None for what is at rest."""
    if case.analysis in ("equilibrium", "modes"):
        return None
    instants = [each.curve.t for each in case.compared if each.curve.over_time]
    if not instants:
        return np.linspace(0.0, case.t_end, LINE)
    first = 0.0 if case.analysis == "simulate" else min(t[0] for t in instants)
    return np.linspace(first, max(t[-1] for t in instants), LINE)
