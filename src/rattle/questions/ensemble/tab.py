"""Many mechanisms of one drawing, in the studio: a histogram whose bars are samples."""

from __future__ import annotations

import numpy as np

from rattle.answers.blocks import Block, Content, content, table, words
from rattle.errors import InputError
from rattle.mechanism import Mechanism
from rattle.plots.curves import axis_label
from rattle.questions.ensemble.compute import Ensemble
from rattle.questions.ensemble.fields import Vary
from rattle.questions.ensemble.shares import bounded, together
from rattle.results.display import quantity
from rattle.results.handy_units import QUANTITY, handy_unit
from rattle.studio.jobs.motion import usual_force
from rattle.studio.shelf import Shelf, Source

MOST = 100_000
BINS = 32
FAR = 5.0  # distances between the quartiles beyond them, from which numbers share the outermost bar
SHARE = 0.01  # by which parameters differ where none has a tolerance


def tab(shelf: Shelf, source: Source, of: str = "", n: str = "64") -> Content:
    """The histogram of a number over mechanisms whose parameters differ by their tolerances."""
    m = shelf.mechanism(source)
    try:
        count = int(float(n))
    except (ValueError, OverflowError):
        count = 0
    if not 2 <= count <= MOST:
        raise InputError(f"mechanisms: give a whole number from 2 to {MOST}")
    output = of.strip() or usual_force(shelf.motion(source))
    vary, note = _vary(m)
    e = m.ensemble(count, [output], vary, progress=True)
    if e.interrupted:
        raise KeyboardInterrupt
    shelf.studies["ensemble"] = e
    output = e.outputs[0]
    counts = e.counts()
    failed = {key: value for key, value in counts.items() if value and key not in ("ok", "samples")}
    told = f"{count} mechanisms: {e.how.partition(':')[0]}" + "".join(
        f", {value} {key}" for key, value in failed.items()
    )
    return content(
        told, words("\n".join([*note, *e.notes]), "care"), _histogram(e, output), words(_outside(e, output), "care"),
        words("Click a bar: one of its mechanisms is replayed in Motion."), _numbers(e, output), _shares(e, output),
        table(("how many", "why they have no number"), [(str(value), key) for key, value in e.why().items()]),
    )  # fmt: skip


def _vary(m: Mechanism) -> tuple[Vary, list[str]]:
    """What differs: parameters with a tolerance, otherwise all by 1 %; and what is to be said of that."""
    every = m.model.parameters
    if any(parameter.tol for parameter in every.values()):
        return None, []
    if not every:
        raise InputError("the model has no parameters that could differ; write a dimension as one in Text, with a tol")
    follow = {other for name in every for other in m.following([name]) - {name}}
    vary = {name: SHARE * (abs(parameter.value) or 1.0) for name, parameter in every.items() if name not in follow}
    note = (
        f'no parameter has a tolerance, so each is varied by {100 * SHARE:g} %; tol = "0.1 mm" in Text says otherwise'
    )
    return vary, [note]


def _fences(values: np.ndarray) -> tuple[float, float]:
    """Limits outside of which a value is far from the others: it alone would leave one bar for all of them."""
    low, high = np.quantile(values, (0.25, 0.75))
    reach = FAR * (high - low)
    return (float(low - reach), float(high + reach)) if reach > 0.0 else (-np.inf, np.inf)


def _outside(e: Ensemble, output: str) -> str:
    """Which mechanisms lie far away from the others, in words; "" if none does."""
    values = e[output]
    finite = np.flatnonzero(np.isfinite(values))
    if not len(finite):
        return ""
    low, high = _fences(values[finite])
    far = finite[(values[finite] < low) | (values[finite] > high)]
    if not len(far):
        return ""
    most = far[np.argsort(-np.abs(values[far] - 0.5 * (low + high)))][:3]
    named = ", ".join(f"number {k} with {quantity(float(values[k]), e.unit(output))}" for k in most)
    what = "1 mechanism lies" if len(far) == 1 else f"{len(far)} mechanisms lie"
    return f"{what} far outside, and in the outermost bar: {named}{' ...' if len(far) > 3 else ''}"


def _histogram(e: Ensemble, output: str) -> Block | None:
    """Bars with the numbers of the samples in them, the middle one first."""
    values, unit = e[output], e.unit(output)
    finite = np.flatnonzero(np.isfinite(values))
    if not len(finite):
        return None
    near = np.clip(values[finite], *_fences(values[finite]))
    factor, shown = handy_unit(unit, float(np.abs(near).max()))
    edges = np.histogram_bin_edges(factor * near, min(BINS, max(6, int(np.sqrt(len(finite)) * 1.5))))
    places = np.clip(np.searchsorted(edges, factor * near, side="right") - 1, 0, len(edges) - 2)
    samples = []
    for k in range(len(edges) - 1):
        mine = finite[places == k]
        samples.append(int(mine[np.argsort(values[mine])[len(mine) // 2]]) if len(mine) else -1)
    marks = [{"x": factor * float(q), "label": f"{share} %"} for share, q in
             zip((5, 50, 95), np.quantile(values[finite], (0.05, 0.5, 0.95)), strict=True)]  # fmt: skip
    nominal = float(e.nominal[0])
    if np.isfinite(nominal):
        marks.append({"x": factor * nominal, "label": "nominal"})
    return {
        "kind": "histogram", "title": output, "x": axis_label(QUANTITY.get(unit, "value"), shown), "edges": edges,
        "counts": np.bincount(places, minlength=len(edges) - 1), "samples": samples, "marks": marks,
    }  # fmt: skip


def _numbers(e: Ensemble, output: str) -> Block | None:
    answer, unit = e.statistics(output), e.unit(output)
    rows = [("nominal", float(e.nominal[0])), ("mean", answer.mean.value), ("standard deviation", answer.sd.value),
            ("least", answer.least), ("largest", answer.most)]  # fmt: skip
    rows += [(f"{100 * share:.0f} % are below", quantile.value) for share, quantile in answer.quantiles.items()]
    return table(("", output), [(name, quantity(value, unit, 5)) for name, value in rows])


def _shares(e: Ensemble, output: str) -> Block | None:
    """Which parameter causes how much of the scatter."""
    try:
        indices = e.contributions(output)
    except ValueError as error:
        return words(f"Which tolerance matters: {error}")
    order = sorted(range(len(indices.names)), key=lambda k: -indices.indices[k].value)
    rows = [(indices.names[k], bounded(indices.indices[k])) for k in order]
    what = "variance of its ranks" if indices.ranks else "variance"
    return table(("parameter", f"share of the {what} (95 % bounds)"), rows, together(indices))
