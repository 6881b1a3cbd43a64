"""The first page of a report: what was found in a few numbers, and how far it can be trusted."""

from __future__ import annotations

from html import escape
from typing import Any

from rattle import registry
from rattle.pages.report_html import Section, count, handy, listed, paragraph, sentence
from rattle.pages.report_study import NOT_READ, Headline, Study, late, section_parts
from rattle.results.contact_summary import readable, why_unread
from rattle.results.display import printed
from rattle.results.result import Result


def headline(s: Study) -> str:
    """A few numbers that a reader wants first, each with its unit and what it is."""
    numbers = _numbers(s)
    cells = "".join(
        f"<div><dt>{escape(what)}</dt><dd>{escape(number)}</dd><dd class='more'>{escape(printed(more))}</dd></div>"
        for what, number, more in numbers
    )
    return f'<dl class="numbers">{cells}</dl>' if numbers else ""


def _numbers(s: Study) -> list[Headline]:
    """What it is, number, where or when."""
    run = s.run
    if run is None or not len(run.t):
        return []
    numbers = _largest_force(s, run)
    for name, driver in list(s.m.model.motors.items())[:1]:
        effort = f"{name}.{registry.kinds('driver')[driver.kind].leaf.effort[0]}"
        if effort in run and not readable(run, effort):
            numbers.append((f"Peak effort of {name}", NOT_READ, why_unread(run, effort)))
        elif effort in run:
            (peak, when), unit = run.peak(effort), run.unit(effort)
            more = f"at t = {handy(when, 's')}; RMS {handy(run.rms(effort), unit)}{_late(run, when)}"
            numbers.append((f"Peak effort of {name}", handy(peak, unit), more))
    numbers += _touching(run)
    for name, film in list(run.films.items())[:1]:
        pressure = f"pressure up to {handy(film.peak_pressure, 'Pa', 3)}"
        numbers.append((f"Least oil film in {name}", handy(film.least_film, "m", 3), pressure))
    for part in section_parts():
        numbers += getattr(part, "headline", _nothing)(s)
    return numbers


def _late(run: Result, t: float) -> str:
    return " (after the horizon: one of many possible values)" if late(run, t) else ""


def verdict(s: Study) -> str:
    """A line that says how much there is that cannot be vouched for."""
    if s.run is None:
        return ""
    n = len(s.run.trust.doubts(s.m.system.extent))
    link = '<a href="#how-far-this-can-be-trusted">How far this can be trusted</a>'
    if not n:
        return f'<p class="verdict good">All checks of the computation hold. {link}</p>'
    return f'<p class="verdict bad">{count(n, "thing")} this report cannot vouch for. {link}</p>'


def _largest_force(s: Study, run: Result) -> list[Headline]:
    joints = [name for name in run.geometry["joints"] if f"{name}.fx" in run and readable(run, f"{name}.force")]
    if not joints:
        return []
    name = max(joints, key=lambda joint: run.peak(f"{joint}.force")[0])
    force, when = run.peak(f"{name}.force")
    ideal = s.ideal.peak(f"{name}.force")[0] if s.ideal is not None and f"{name}.fx" in s.ideal else 0.0
    more = f", {force / ideal:.3g} times that without play" if ideal > 1e-9 * force else ""
    return [("Largest joint force", handy(force, "N"), f"in {name} at t = {handy(when, 's')}{more}{_late(run, when)}")]


def _touching(run: Result) -> list[Headline]:
    loose = {name: counts for name, counts in run.contacts.items() if name not in run.trust.pulled}
    hits = sum(counts.impacts + counts.contacts for counts in loose.values())
    if not hits:
        return []
    lost = sum(counts.energy_lost for counts in loose.values())
    return [("Impacts and contacts", str(hits), f"in {', '.join(loose)}; {handy(lost, 'J')} lost in them")]


def trust_section(s: Study) -> Section:
    """What was checked and holds, and what nobody should rely on."""
    title = "How far this can be trusted"
    run = s.run
    if run is None:
        return Section(title, paragraph("There is no result: see the top of this page.", "bad"))
    size = s.m.system.extent
    good, bad = run.trust.holds(size), run.trust.doubts(size)
    good += tuple(words for part in section_parts() for words in getattr(part, "holds", _nothing)(s))
    parts = [_said("What was checked and holds", good, "good"), _said("What this report cannot vouch for", bad, "bad")]
    if not bad and not run.trust.notes:
        parts.append(paragraph("Beyond the assumptions below there is nothing in the numbers that needs a warning."))
    parts.append(_said("Also said by the run", run.trust.notes, "note"))
    return Section(title, "".join(parts))


def _said(head: str, sentences: tuple[str, ...], kind: str) -> str:
    items = [sentence(text[:1].upper() + text[1:] if text.partition(" ")[0].islower() else text) for text in sentences]
    return f"<h3>{escape(head)}</h3>{listed(items, kind)}" if items else ""


def _nothing(s: Study) -> list[Any]:
    """What a question adds that adds nothing."""
    return []
