"""Equilibria and vibrations about them in a report, or the motion through equilibria of a driven mechanism."""

from __future__ import annotations

import math

import numpy as np

from rattle.pages.report_html import Section, handy, paragraph, sentence, table
from rattle.pages.report_study import POSITIONS, Headline, Study, tried
from rattle.questions.check.compute import Check
from rattle.questions.equilibrium.position import Equilibria
from rattle.questions.modes.compute import Modes

MOST_RESTS = 8
ROUNDING = 1e-9  # share of the size of the mechanism below which a coordinate is rounding


def gather(study: Study) -> None:
    m = study.m
    if not m.model.drivers:
        rest = tried(study, "equilibrium", "searching for equilibria", m.equilibrium)
        study.keep("equilibrium", rest)
        if rest:
            first = rest[0]
            modes = tried(study, "modes", "computing natural frequencies", lambda: m.modes(equilibrium=first))
            study.keep("modes", modes)
        elif rest is not None:
            study.reasons["equilibrium"] = rest.note or "no position was found in which all forces balance"
        return
    study.reasons["equilibrium"] = "drivers hold the mechanism"
    run = study.run
    check = study.answer("check", Check)
    fully = check is not None and check.mobility == 0
    if run is not None and fully and m.model.loads and not m.model.remembers and not study.loose:
        times = np.linspace(0.0, run.trust.t_end, POSITIONS)
        study.path = tried(study, "quasi-static", "computing the quasi-static motion", lambda: m.equilibrium(times))


def section(s: Study) -> Section:
    """Equilibria and natural frequencies of a mechanism without drivers."""
    rest, modes = s.answer("equilibrium", Equilibria), s.answer("modes", Modes)
    if not rest:
        return s.left_out("Equilibrium and vibration", "equilibrium")
    rows, least = [], ROUNDING * min(s.m.system.extent, 1.0)
    for n, position in enumerate(rest[:MOST_RESTS]):
        units = {"x": "m", "y": "m", "angle": "rad"}
        places = [
            f"{body} {', '.join(handy(_rounded(position[f'{body}.{key}'], least), u) for key, u in units.items())}"
            for body in list(s.m.model.bodies)[:6]
        ]
        pulls = f"no: {', '.join(position.pulled)} would have to pull" if position.pulled else "yes"
        rows.append((str(n + 1), "yes" if position.stable else "no", pulls, "; ".join(places)))
    many = f" (the first {MOST_RESTS} of {len(rest)})" if len(rest) > MOST_RESTS else ""
    body = table(("", "stable", "possible", "bodies at x, y, angle"), rows, f"Equilibria{many}")
    body += paragraph(sentence(f"How far the search went: {rest.extent}")) if rest.extent else ""
    if modes is not None and len(modes):
        head = ("mode", "natural frequency", "damping", "bodies that move most")
        body += table(head, modes.rows(), "Small vibrations about the first equilibrium")
    return Section("Equilibrium and vibration", body)


def _rounded(value: float, least: float) -> float:
    """A coordinate [m or rad], 0 where it is rounding."""
    return value if abs(value) > least else 0.0


def headline(s: Study) -> list[Headline]:
    """How many stable equilibria there are, and how fast it vibrates about the first."""
    rest, modes = s.answer("equilibrium", Equilibria), s.answer("modes", Modes)
    if not rest:
        return []
    stable = sum(position.stable and position.admissible for position in rest)
    first = "" if modes is None or not len(modes) else f"first natural frequency {_frequency(modes)}"
    return [("Stable equilibria", str(stable), first)]


def _frequency(modes: Modes) -> str:
    value = float(modes.frequency[0])
    return handy(value, "Hz") if math.isfinite(value) else "none"


SECTIONS = ((70, section),)
