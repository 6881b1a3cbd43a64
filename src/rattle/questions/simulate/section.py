"""A motion in a report: what moves, forces, contacts, oil and events, as tables and pictures."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence

import numpy as np

from rattle import registry
from rattle.pages import report_figures as figures
from rattle.pages.report_html import (
    Section,
    abreast,
    count,
    enumerated,
    gallery,
    handy,
    listed,
    paragraph,
    sentence,
    table,
)
from rattle.pages.report_study import FORCES, MOTION, NOT_READ, Study, late, tried
from rattle.results.contact_summary import contact_lines, force_rounding, readable, rigid_joints, why_unread
from rattle.results.event import Event
from rattle.results.film_summary import film_rows
from rattle.results.result import Result

MOST_EVENTS = 10
NO_MOTION = "there is no motion"
NO_IDEAL = 1e-9  # [of the force] force without play below which a ratio says nothing
ROUNDING = 1e-9  # moment over force times size below which it is rounding
KINDS = {
    "contact": "touches", "release": "lifts off", "impact": "impact", "stick": "sticks", "slip": "slips",
    "jolt": "jump of the driver's speed", "lock": "locks", "free": "runs free", "side": "changes sides",
}  # fmt: skip


def gather(study: Study) -> None:
    run = study.run
    if not study.loose or run is None or not run.success:
        return
    ideal = tried(
        study, "without play", "computing the motion without play, for comparison",
        lambda: study.m.ideal().simulate(run.trust.t_end, t_eval=run.t).whole(),
    )  # fmt: skip
    study.ideal = ideal if ideal is not None and ideal.success else None


def motion_section(s: Study) -> Section:
    """What moves and how."""
    pictures = figures.motion_figures(s)
    marks = figures.key(s)
    body = (paragraph(marks, "lead") if marks else "") + gallery(pictures)
    return Section(MOTION, body) if pictures else s.left_out(MOTION, "motion", NO_MOTION)


def force_section(s: Study) -> Section:
    """Efforts of drivers, forces of joints: pictures, and a table with instants."""
    run = s.run
    if run is None or not len(run.t):
        return s.left_out(FORCES, "motion", NO_MOTION)
    tables = abreast([_drivers(s, run), _joints(s, run), _clutches(s, run)])
    pictures = [*figures.driver_figures(s), *figures.force_figures(s)]
    if s.path is not None:
        pictures.append(figures.path_figure(s))
    return Section(FORCES, tables + gallery(pictures), "no joint and no driver exerts a force")


def _joints(s: Study, run: Result) -> str:
    rows, rounding = [], force_rounding(run)
    for name in run.geometry["joints"]:
        if f"{name}.fx" not in run:
            continue
        force, when = run.peak(f"{name}.force")
        if not readable(run, f"{name}.force"):
            rows.append([name, f"{NOT_READ}: {why_unread(run, f'{name}.force')}", *[""] * 5])
            continue
        if force <= rounding:
            rows.append([name, handy(0.0, "N"), "", handy(0.0, "N"), *[""] * 3])
            continue
        row = [name, handy(force, "N"), _at(run, when), handy(run.rms(f"{name}.force"), "N")]
        ideal = s.ideal.peak(f"{name}.force")[0] if s.ideal is not None and f"{name}.fx" in s.ideal else math.nan
        row += [handy(ideal, "N"), f"{force / ideal:.3g}"] if NO_IDEAL * force < ideal else ["", ""]
        shown = f"{name}.moment" in run and readable(run, f"{name}.moment")
        moment = run.peak(f"{name}.moment")[0] if shown else 0.0
        rows.append([*row, handy(moment, "N*m") if moment > ROUNDING * force * s.m.system.extent else ""])
    head = ("joint", "peak force", "at t", "RMS force", "peak without play", "ratio", "peak moment")
    between = " between impacts" if rigid_joints(run) else ""
    caption = f"Joint forces over the whole run{between}; peaks are found within the steps"
    return table(head, rows, caption) + _late_note(rows)


def _clutches(s: Study, run: Result) -> str:
    rows = []
    for name, joint in s.m.model.joints.items():
        if joint.leaf.bodies and f"{name}.torque" in run:
            moment, when = run.peak(f"{name}.torque")
            rms = handy(run.rms(f"{name}.torque"), "N*m")
            shown = readable(run, f"{name}.torque")
            share = f"{100 * float(np.mean(run[f'{name}.locked'] > 0.0)):.3g} %"
            force = (handy(moment, "N*m"), _at(run, when), rms) if shown else (NOT_READ, "", "")
            rows.append((name, *force, share))
    head = ("clutch", "peak moment", "at t", "RMS moment", "share of outputs at which it drives")
    return table(head, rows, "Clutches over the whole run") + _late_note(rows)


def _at(run: Result, t: float) -> str:
    return handy(t, "s") + (" *" if late(run, t) else "")


def _late_note(rows: Sequence[Sequence[str]]) -> str:
    if not any(cell.endswith(" *") for row in rows for cell in row):
        return ""
    words = "* after the horizon: this peak is one of many possible ones, a repeated run may have another."
    return paragraph(words, "fine")


def _drivers(s: Study, run: Result) -> str:
    rows = []
    for name, driver in s.m.model.motors.items():
        effort = f"{name}.{registry.kinds('driver')[driver.kind].leaf.effort[0]}"
        if effort not in run:
            continue
        unit, (peak, when), (power, at) = run.unit(effort), run.peak(effort), run.peak(f"{name}.power")
        row = [name, NOT_READ, "", "", NOT_READ, ""]
        if readable(run, effort):
            row[1:4] = handy(peak, unit), _at(run, when), handy(run.rms(effort), unit)
        if readable(run, f"{name}.power"):
            row[4:6] = handy(power, "W"), _at(run, at)
        rows.append(row)
    head = ("driver", "peak effort", "at t", "RMS effort", "peak power", "at t")
    return table(head, rows, "Efforts of the drivers") + _late_note(rows)


def contact_section(s: Study) -> Section:
    """Orbits, contacts and impacts of joints with play, stops and one-sided joints."""
    run = s.run
    if run is None:
        return s.left_out("Play, contacts and impacts", "motion", NO_MOTION)
    rows = []
    for name, contact in run.contacts.items():
        hits = [event.impulse for event in run.events if event.joint == name and event.kind == "impact"]
        angular = _angular(s, name)
        unit, impulse = ("N*m", "N*m*s") if angular else ("N", "N*s")
        link = name in run.trust.pulled
        rows.append(
            (
                name, f"{100 * contact.share:.3g} %", "" if link else str(contact.contacts),
                "" if link else str(contact.impacts), handy(max(hits), impulse) if hits else "",
                handy(contact.peak, unit) if contact.readable else NOT_READ,
                handy(contact.rms, unit) if contact.readable else "",
                handy(contact.longest_flight, "s") if contact.longest_flight > 0.0 else "",
                "" if link else handy(contact.energy_lost, "J"), "" if link else handy(contact.power_lost, "W"),
            )
        )  # fmt: skip
    head = (
        "joint", "pressing", "contacts", "impacts", "hardest impact", "peak normal force", "RMS", "longest flight",
        "energy lost", "mean power lost",
    )  # fmt: skip
    body = table(head, rows, "Contacts over the whole run; forces between impacts")
    body += listed(map(sentence, contact_lines(run))) + figures.orbit_figures(s)
    return Section("Play, contacts and impacts", body, "no joint has play, a stop or a one-sided contact")


def _angular(s: Study, name: str) -> bool:
    joint = s.m.model.joints.get(name)
    return joint is not None and joint.clearance == 0.0 and (joint.stops_angle or joint.leaf.bodies)


def oil_section(s: Study) -> Section:
    """Films of oil, and what their regime was."""
    head, rows = film_rows(s.run) if s.run is not None else ((), [])
    if not rows:
        return Section("Oil films", "", "no joint has oil")
    lead = "The least film is found within the steps; pressure, power and leakage at the output instants. Mixed is the"
    lead += " share of time in which the surfaces touch through the film."
    return Section("Oil films", paragraph(lead) + table(("joint", *head[1:]), rows))


# ---------------------------------------------------------------- events
def event_section(s: Study) -> Section:
    """Events by joint and kind, and the hardest of them."""
    run = s.run
    if run is None or not run.events:
        return Section("Events", "", "nothing made or lost contact, stuck, slipped or jumped")
    counts = Counter((event.joint, event.kind) for event in run.events)
    by_joint: dict[str, list[str]] = {}
    for (joint, kind), n in counts.items():
        by_joint.setdefault(joint, []).append(f"{KINDS.get(kind, kind)} {n} time{'s' if n > 1 else ''}")
    body = listed(f"{joint}: {enumerated(told)}." for joint, told in by_joint.items())
    hardest = sorted(run.events, key=lambda event: (-max(event.impulse, 0.0), -event.peak_force, event.t))[:MOST_EVENTS]
    rows = [_event(s, event) for event in sorted(hardest, key=lambda event: event.t)]
    head = ("t", "joint", "event", "approach speed", "lasted", "peak force", "impulse", "energy lost")
    few = len(run.events) <= MOST_EVENTS
    caption = "All events" if few else f"The {MOST_EVENTS} hardest of {count(len(run.events), 'event')}"
    return Section("Events", body + table(head, rows, caption))


def _event(s: Study, event: Event) -> tuple[str, ...]:
    angular = _angular(s, event.joint)
    speed, force, impulse = ("rad/s", "N*m", "N*m*s") if angular else ("m/s", "N", "N*s")
    driver = s.m.model.drivers.get(event.joint)
    if driver is not None and driver.sets_angle:
        speed, impulse = "rad/s", "N*m*s"

    contact = s.run.contacts.get(event.joint) if s.run is not None and event.peak_force else None
    unread = contact is not None and not contact.readable

    def if_any(value: float, unit: str) -> str:
        return handy(value, unit) if value else ""

    where = f"{event.joint} {event.contact}".strip()
    return (
        handy(event.t, "s", 5), where, KINDS.get(event.kind, event.kind), if_any(event.normal_speed, speed),
        if_any(event.duration, "s"), NOT_READ if unread else if_any(event.peak_force, force),
        if_any(event.impulse, impulse), if_any(event.energy_lost, "J"),
    )  # fmt: skip


SECTIONS = ((20, motion_section), (30, force_section), (40, contact_section), (50, oil_section), (100, event_section))
