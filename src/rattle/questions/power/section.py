"""Where the energy of a cycle goes, in a report."""

from __future__ import annotations

import numpy as np

from rattle.jit.choices import TINY
from rattle.pages.report_html import Section, figure, handy, paragraph, table
from rattle.pages.report_study import Study, tried
from rattle.questions.power.compute import Power
from rattle.questions.power.pictures import Spacing, plot_cycle

FLOW = Spacing(1.25, 0.75, 0.52, 7.2)  # of the flow of energy
SEEN = 1e-6  # share of the largest energy below which one is not told
ADD_UP = 1e-6  # share of the largest power within which those of every body have to balance to be called so


def gather(study: Study) -> None:
    run = study.run
    if run is None or not run.success:
        return

    def flows() -> Power | None:
        power = run.power()
        cycle = power.cycle  # found here, where it may fail
        return power if float(np.abs(cycle.into).max(initial=0.0)) > 0.0 else None

    study.keep("power", tried(study, "power", "following the energy", flows))
    if study.answer("power", Power) is None:
        study.reasons.setdefault("power", "no energy is exchanged")


def section(s: Study) -> Section:
    """Where the energy of a cycle goes."""
    power = s.answer("power", Power)
    if power is None:
        return s.left_out("Power", "power")
    rows, left = [], 0.0
    cycle = power.cycle
    for name, kind, *energies in power.balance():
        supplied, lost, stored, _ = energies
        left += supplied - lost - stored
        sizes = [handy(value, "J") if abs(value) > SEEN * float(cycle.into.max()) else "" for value in energies]
        if any(sizes):
            rows.append((name, "driver" if name in s.m.model.drivers else kind.replace("-", " "), *sizes))
    head = ("element", "type", "supplied from outside", "lost", "stored", "goes back and forth")
    if abs(left) > SEEN * float(cycle.into.max()):
        rows.append(("all bodies", "kinetic energy", "", "", handy(left, "J"), ""))
    span = f"Energies from t = {handy(power.t0, 's')} to {handy(power.t1, 's')}"
    checked = f"In every body powers and the rate of kinetic energy agree within {cycle.residual:.1g} W."
    return Section("Power", _figure(power) + table(head, rows, span) + paragraph(checked))


def _figure(power: Power) -> str:
    """Where the energy of a cycle goes."""
    picture = plot_cycle(power, FLOW)
    picture.axes[0].set_title("", loc="left")
    words = "Where the energy goes: from what drives on the left, through the bodies, to losses and loads on the right"
    return figure(picture, f"{words}; \N{RIGHTWARDS ARROW OVER LEFTWARDS ARROW} goes back and forth.")


def holds(s: Study) -> list[str]:
    """What the powers prove of the motion."""
    power = s.answer("power", Power)
    if power is None:
        return []
    share = power.residual / max(float(abs(power.cycle.peak).max()), TINY)
    return ["powers of every body add up to the rate of its kinetic energy"] if share < ADD_UP else []


SECTIONS = ((80, section),)
