"""Results of a report: forces, contacts, oil, wear, equilibria, accuracy, power, events, as tables and pictures."""

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
    listed,
    paragraph,
    said,
    sentence,
    table,
)
from rattle.pages.report_study import Study
from rattle.results.contact_summary import contact_lines, force_rounding, readable, rigid_joints, why_unread
from rattle.results.event import Event
from rattle.results.film_summary import film_rows
from rattle.results.result import Result

MOTION, FORCES, CONTACTS = "Motion", "Forces and efforts", "Play, contacts and impacts"  # titles
MOST_EVENTS = 10
NOT_READ = "not to be read"  # in place of a force that says nothing of a real one
ROUNDING = 1e-9  # moment over force times size below which it is rounding
SEEN = 1e-6  # share of the largest energy below which one is not told
MOST_RESTS = 8
KINDS = {
    "contact": "touches", "release": "lifts off", "impact": "impact", "stick": "sticks", "slip": "slips",
    "jolt": "jump of the driver's speed", "lock": "locks", "free": "runs free", "side": "changes sides",
}  # fmt: skip


def motion_section(s: Study) -> Section:
    """What moves and how."""
    pictures = figures.motion_figures(s)
    marks = figures.key(s)
    body = (paragraph(marks, "lead") if marks else "") + gallery(pictures)
    return Section(MOTION, body, "" if pictures else s.reasons.get("motion", "there is no motion"))


def force_section(s: Study) -> Section:
    """Efforts of drivers, forces of joints: pictures, and a table with instants."""
    run = s.run
    if run is None or not len(run.t):
        return Section(FORCES, "", s.reasons.get("motion", "there is no motion"))
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
            rows.append([name, said(0.0, "N"), "", said(0.0, "N"), *[""] * 3])
            continue
        row = [name, said(force, "N"), _at(run, when), said(run.rms(f"{name}.force"), "N")]
        ideal = s.ideal.peak(f"{name}.force")[0] if s.ideal is not None and f"{name}.fx" in s.ideal else math.nan
        row += [said(ideal, "N"), f"{force / ideal:.3g}"] if 1e-9 * force < ideal else ["", ""]
        shown = f"{name}.moment" in run and readable(run, f"{name}.moment")
        moment = run.peak(f"{name}.moment")[0] if shown else 0.0
        rows.append([*row, said(moment, "N*m") if moment > ROUNDING * force * s.m.system.extent else ""])
    head = ("joint", "peak force", "at t", "RMS force", "peak without play", "ratio", "peak moment")
    between = " between impacts" if rigid_joints(run) else ""
    caption = f"Joint forces over the whole run{between}; peaks are found within the steps"
    return table(head, rows, caption) + _late_note(rows)


def _clutches(s: Study, run: Result) -> str:
    rows = []
    for name, joint in s.m.model.joints.items():
        if joint.leaf.bodies and f"{name}.torque" in run:
            moment, when = run.peak(f"{name}.torque")
            rms = said(run.rms(f"{name}.torque"), "N*m")
            shown = readable(run, f"{name}.torque")
            share = f"{100 * float(np.mean(run[f'{name}.locked'] > 0.0)):.3g} %"
            force = (said(moment, "N*m"), _at(run, when), rms) if shown else (NOT_READ, "", "")
            rows.append((name, *force, share))
    head = ("clutch", "peak moment", "at t", "RMS moment", "share of outputs at which it drives")
    return table(head, rows, "Clutches over the whole run") + _late_note(rows)


def late(run: Result, t: float) -> bool:
    """True for an instant [s] after the horizon: what happens there is one of many possible motions."""
    return run.trust.horizon is not None and t > run.trust.horizon


def _at(run: Result, t: float) -> str:
    return said(t, "s") + (" *" if late(run, t) else "")


def _late_note(rows: Sequence[Sequence[str]]) -> str:
    if not any(cell.endswith(" *") for row in rows for cell in row):
        return ""
    words = "* after the horizon: this peak is one of many possible ones, a repeated run may have another."
    return paragraph(words, "fine")


def _drivers(s: Study, run: Result) -> str:
    rows = []
    for name, driver in s.m.model.drivers.items():
        effort = f"{name}.{registry.kinds('driver')[driver.kind].leaf.effort[0]}"
        if effort not in run:
            continue
        unit, (peak, when), (power, at) = run.unit(effort), run.peak(effort), run.peak(f"{name}.power")
        row = [name, NOT_READ, "", "", NOT_READ, ""]
        if readable(run, effort):
            row[1:4] = said(peak, unit), _at(run, when), said(run.rms(effort), unit)
        if readable(run, f"{name}.power"):
            row[4:6] = said(power, "W"), _at(run, at)
        rows.append(row)
    head = ("driver", "peak effort", "at t", "RMS effort", "peak power", "at t")
    return table(head, rows, "Efforts of the drivers") + _late_note(rows)


def contact_section(s: Study) -> Section:
    """Orbits, contacts and impacts of joints with play, stops and one-sided joints."""
    run = s.run
    if run is None:
        return Section(CONTACTS, "", s.reasons.get("motion", "there is no motion"))
    rows = []
    for name, one in run.contacts.items():
        hits = [event.impulse for event in run.events if event.joint == name and event.kind == "impact"]
        angular = _angular(s, name)
        unit, impulse = ("N*m", "N*m*s") if angular else ("N", "N*s")
        link = name in run.trust.pulled
        rows.append(
            (
                name, f"{100 * one.share:.3g} %", "" if link else str(one.contacts), "" if link else str(one.impacts),
                said(max(hits), impulse) if hits else "", said(one.peak, unit) if one.readable else NOT_READ,
                said(one.rms, unit) if one.readable else "",
                said(one.longest_flight, "s") if one.longest_flight > 0.0 else "",
                "" if link else said(one.energy_lost, "J"), "" if link else said(one.power_lost, "W"),
            )
        )  # fmt: skip
    head = (
        "joint", "pressing", "contacts", "impacts", "hardest impact", "peak normal force", "RMS", "longest flight",
        "energy lost", "mean power lost",
    )  # fmt: skip
    body = table(head, rows, "Contacts over the whole run; forces between impacts")
    body += listed(map(sentence, contact_lines(run))) + figures.orbit_figures(s)
    return Section(CONTACTS, body, "no joint has play, a stop or a one-sided contact")


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


def wear_section(s: Study) -> Section:
    """What the model says about wear; the depths over many cycles are a study of their own."""
    rows = []
    for name, joint in s.m.model.joints.items():
        one = joint.wear
        if one is None:
            continue
        deepest = [said(max(side), "m") for side in one.profile] if one.profile is not None else ["new", "new"]
        cycle = said(one.cycle, "s") if math.isfinite(one.cycle) else "one turn of the driver"
        rows.append(
            (
                name, f"{1e9 * one.bush:.3g} mm³/(N·m)", f"{1e9 * one.pin:.3g} mm³/(N·m)", *deepest, said(one.wall, "m")
                if math.isfinite(one.wall) else "", f"{one.cycles:g} of {cycle}",
            )
        )  # fmt: skip
    if not rows:
        return Section("Wear", "", "no joint wears")
    head = (
        "joint",
        "wear of bush",
        "wear of pin",
        "bush worn by",
        "pin worn by",
        "worn through at",
        "cycles of a study",
    )
    lead = "This report is of the mechanism as it is now. The wear of many cycles is a study of its own (rattle wear)."
    return Section("Wear", paragraph(lead) + table(head, rows))


# ---------------------------------------------------------------- at rest, over a cycle, under play
def rest_section(s: Study) -> Section:
    """Equilibria and natural frequencies of a mechanism without drivers."""
    if not s.rest:
        return Section("Equilibrium and vibration", "", s.reasons.get("equilibrium", ""))
    rows, least = [], ROUNDING * min(s.m.system.extent, 1.0)
    for n, one in enumerate(s.rest[:MOST_RESTS]):
        units = {"x": "m", "y": "m", "angle": "rad"}
        places = [
            f"{body} {', '.join(said(_rounded(one[f'{body}.{key}'], least), unit) for key, unit in units.items())}"
            for body in list(s.m.model.bodies)[:6]
        ]
        pulls = f"no: {', '.join(one.pulled)} would have to pull" if one.pulled else "yes"
        rows.append((str(n + 1), "yes" if one.stable else "no", pulls, "; ".join(places)))
    many = f" (the first {MOST_RESTS} of {len(s.rest)})" if len(s.rest) > MOST_RESTS else ""
    body = table(("", "stable", "possible", "bodies at x, y, angle"), rows, f"Equilibria{many}")
    body += paragraph(sentence(f"How far the search went: {s.rest.extent}")) if s.rest.extent else ""
    if s.modes is not None and len(s.modes):
        head = ("mode", "natural frequency", "damping", "bodies that move most")
        body += table(head, s.modes.rows(), "Small vibrations about the first equilibrium")
    return Section("Equilibrium and vibration", body)


def _rounded(value: float, least: float) -> float:
    """A coordinate [m or rad], 0 where it is rounding."""
    return value if abs(value) > least else 0.0


def power_section(s: Study) -> Section:
    """Where the energy of a cycle goes."""
    if s.power is None:
        return Section("Power", "", s.reasons.get("power", ""))
    power, rows, left = s.power, [], 0.0
    one = power.cycle
    for name, kind, *energies in power.balance():
        supplied, lost, stored, _ = energies
        left += supplied - lost - stored
        sizes = [said(value, "J") if abs(value) > SEEN * float(one.into.max()) else "" for value in energies]
        if any(sizes):
            rows.append((name, "driver" if name in s.m.model.drivers else kind.replace("-", " "), *sizes))
    head = ("element", "type", "supplied from outside", "lost", "stored", "goes back and forth")
    if abs(left) > SEEN * float(one.into.max()):
        rows.append(("all bodies", "kinetic energy", "", "", said(left, "J"), ""))
    span = f"Energies from t = {said(power.t0, 's')} to {said(power.t1, 's')}"
    checked = f"In every body powers and the rate of kinetic energy agree within {one.residual:.1g} W."
    return Section("Power", figures.power_figure(power) + table(head, rows, span) + paragraph(checked))


def accuracy_section(s: Study) -> Section:
    """How far play lets the output deviate."""
    one = s.accuracy
    if one is None:
        return Section("Accuracy", "", s.reasons.get("accuracy", ""))
    k = int(np.argmax(one.worst))
    total = one.worst[k]
    facts = [
        f"Worst case, every pin anywhere in its clearance: ±{said(total, one.unit)}, at t = {said(one.t[k], 's')}."
    ]
    facts.append(f"Root sum square, if the joints vary independently: ±{said(one.rss[k], one.unit)} there.")
    most = one.share[one.tighten]
    first = [name for name, share in one.share.items() if share > 0.99 * most]
    if len(one.joints) > 1:
        facts.append(f"To tighten first: {' or '.join(first)}.")
    rows = [
        (name, said(one.clearances[name], "m"), f"±{said(one.contributions[k, one.joints.index(name)], one.unit)}",
         f"{100 * share:.0f} %")
        for name, share in sorted(one.share.items(), key=lambda item: -item[1])
    ]  # fmt: skip
    body = paragraph(f"How far the play lets {one.of} deviate from its value without play.")
    shares = table(("joint", "clearance", "contribution at most", "share"), rows)
    body += abreast([listed(facts), shares]) + listed(map(sentence, one.notes))
    return Section("Accuracy under play", body + figures.accuracy_figures(one))


# ---------------------------------------------------------------- events
def event_section(s: Study) -> Section:
    """Events by joint and kind, and the hardest of them."""
    run = s.run
    if run is None or not run.events:
        return Section("Events", "", "nothing made or lost contact, stuck, slipped or jumped")
    counts = Counter((one.joint, one.kind) for one in run.events)
    by_joint: dict[str, list[str]] = {}
    for (joint, kind), n in counts.items():
        by_joint.setdefault(joint, []).append(f"{KINDS.get(kind, kind)} {n} time{'s' if n > 1 else ''}")
    body = listed(f"{joint}: {enumerated(told)}." for joint, told in by_joint.items())
    hardest = sorted(run.events, key=lambda one: (-max(one.impulse, 0.0), -one.peak_force, one.t))[:MOST_EVENTS]
    rows = [_event(s, one) for one in sorted(hardest, key=lambda one: one.t)]
    head = ("t", "joint", "event", "approach speed", "lasted", "peak force", "impulse", "energy lost")
    few = len(run.events) <= MOST_EVENTS
    caption = "All events" if few else f"The {MOST_EVENTS} hardest of {count(len(run.events), 'event')}"
    return Section("Events", body + table(head, rows, caption))


def _event(s: Study, one: Event) -> tuple[str, ...]:
    angular = _angular(s, one.joint)
    speed, force, impulse = ("rad/s", "N*m", "N*m*s") if angular else ("m/s", "N", "N*s")
    driver = s.m.model.drivers.get(one.joint)
    if driver is not None and driver.sets_angle:
        speed, impulse = "rad/s", "N*m*s"

    contact = s.run.contacts.get(one.joint) if s.run is not None and one.peak_force else None
    unread = contact is not None and not contact.readable

    def if_any(value: float, unit: str) -> str:
        return said(value, unit) if value else ""

    return (
        said(one.t, "s", 5), one.joint, KINDS.get(one.kind, one.kind), if_any(one.normal_speed, speed),
        if_any(one.duration, "s"), NOT_READ if unread else if_any(one.peak_force, force), if_any(one.impulse, impulse),
        if_any(one.energy_lost, "J"),
    )  # fmt: skip
