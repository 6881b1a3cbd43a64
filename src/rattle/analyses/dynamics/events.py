"""Events of a run, from the rows that the steppers wrote, and notes on contacts for `Trust`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from operator import itemgetter
from typing import Any

import numpy as np

from rattle import registry
from rattle.analyses.law_check import law_faults
from rattle.description.model import Joint, Model
from rattle.equations.compliant import contact_duration
from rattle.equations.contact_table import ContactGroup, contact_groups, contact_labels, effective_mass
from rattle.equations.state import IMPULSE, LOSS, state_layout
from rattle.equations.system import System
from rattle.errors import ModelError, Problem
from rattle.jit import layout as at  # fmt: skip
from rattle.jit.families import call_stiffness
from rattle.jit.workspace import Workspace
from rattle.results.event import Event

SHORTEST = 1e-12  # steps below this count as impossible [s]
ROUNDING = 1e-9  # share of the energy exchanged by an impact below which what it creates is rounding
GAIN = 1e-12  # energy created by an impact, as a share of that of the run, below which it is rounding
STEPS_WANTED = 10  # steps that the shortest contact should have
DEEP = STEPS_WANTED * SHORTEST / 3.0  # depth of a contact at 1 m/s that lasts so long [m], see `contact_duration`
SENTENCES = {  # of notes, also in pages
    "gains": "{impacts} created energy, {gain:.3g} J in total: Newton's and Poisson's restitution with friction can;"
    ' restitution_law = "energetic" cannot',
}
KINDS = ("contact", "release", "impact", "stick", "slip")  # in the order of their numbers in `plane`


def event_owners(system: System) -> list[tuple[str, str]]:
    """Joint and label of every contact, then of every friction of a joint: what events are numbered by."""
    rolls = system.arrays["dry"][:, at.DRY_FORM] == at.DRY_ROLLER
    dry = [(name, "rolling" if roller else "") for name, roller in zip(system.dry_joints, rolls, strict=True)]
    return [*contact_labels(system.model), *dry]


def contact_events(system: System, rows: Sequence[np.ndarray], workspace: Workspace, t: float) -> tuple[Event, ...]:
    """Events in order of time; contacts that last to the end of the run, t [s], are listed with their values so far.

    rows: arrays (n, 8) of the steppers: time [s], contact, kind, then up to five values of `Event` [SI].
    """
    owners_of = event_owners(system)
    joints, labels = [name for name, _ in owners_of], [label for _, label in owners_of]
    written = np.concatenate(rows) if rows else np.zeros((0, at.width("events")))
    bare = (written[:, at.EVENT_KIND] != at.CONTACT_EVENT) & (written[:, at.EVENT_KIND] != at.IMPACT_EVENT)
    written[bare, at.EVENT_DURATION :] = 0.0  # only contacts and impacts have more than a speed
    instants, contact, what, *values = written.T.tolist()
    own = [system.model.joints[name].leaf.events for name in joints]
    owners = [joints[int(n)] for n in contact]
    kinds = [own[int(n)].get(KINDS[int(k)], KINDS[int(k)]) for n, k in zip(contact, what, strict=True)]
    corners = [labels[int(n)] for n in contact]
    events = [Event._make(fields) for fields in zip(instants, owners, kinds, *values, corners, strict=True)]
    memory, y, layout = workspace.contact_memory, workspace.state, state_layout(system)
    for n in np.flatnonzero(memory[:, at.CLOSED] == at.SHUT):
        account = y[layout.account(int(n))]
        since, speed, peak = (float(memory[n, c]) for c in (at.SINCE, at.SPEED, at.PEAK))
        impulse = float(account[IMPULSE] - memory[n, at.IMPULSE_0])
        lost = float(account[LOSS] - memory[n, at.LOSS_0])
        kind, so_far = own[n].get("contact", "contact"), (speed, t - since, peak, impulse, lost)
        events.append(Event(since, joints[n], kind, *so_far, labels[n]))
    return tuple(sorted(events, key=itemgetter(0)))


def require_workable(system: System) -> None:
    """Raise ModelError, with the joint, for contacts so stiff that no step could resolve them."""
    problems = []
    for joint, group in _groups(system.model):
        contact, angular = group.contact, group.kind.leaf.angular
        if contact.static is None:
            continue
        kind, mass = registry.kinds("stiffness")[contact.static.kind], effective_mass(system.model, joint, angular)
        p = np.array([*kind.leaf.pack(contact.static.values), 0.0])
        if call_stiffness(kind.kernel, (DEEP, p, 0)) * DEEP <= mass:  # at 1 m/s it goes deeper
            continue
        lasting = float(contact_duration.python(kind.kernel, p, 0, mass, 1.0))
        if lasting < STEPS_WANTED * SHORTEST:
            unit = "rad" if angular else "m"
            words = (
                f"so stiff that a contact at 1 {unit}/s would last {lasting:.1g} s and steps fall below {SHORTEST:g} s;"
                ' lower the stiffness, or use contact = "impact" for rigid bodies'
            )
            problems.append(Problem(group.path, words))
    if problems:
        raise ModelError(problems)


def _groups(model: Model) -> list[tuple[Joint, ContactGroup]]:
    """All contacts of a mechanism, with their joints."""
    return [(joint, group) for joint in model.joints.values() for group in contact_groups(joint)]


def contact_counts(system: System, events: Sequence[Event], fewest: float) -> dict[str, Any]:
    """Fields of `Trust` on contacts: number of contacts and impacts, steps of the shortest contact."""
    if not len(system.arrays["contact"]):
        return {}
    return {
        "contacts": sum(event.kind == "contact" for event in events),
        "impacts": sum(event.kind == "impact" for event in events),
        "fewest_steps": fewest if fewest < math.inf else None,
    }


def unused_notes(model: Model) -> list[str]:
    """Notes on keys that only other contact models use than the one of the joint."""
    joints: dict[str, list[str]] = {}
    for name, joint in model.joints.items():
        used = [joint.contact] if joint.clearance > 0.0 else []
        for contact in (*used, joint.stop.contact if joint.stop else None):
            if contact is not None and contact.unused:
                what = f"{contact.title} does not use {', '.join(contact.unused)}"
                joints.setdefault(what, []).append(name)
    return [f"{', '.join(names)}: {what}" for what, names in joints.items()]


def _gains(events: Sequence[Event], energy: float) -> list[float]:
    """Energy [J] created by impacts, each with all its contacts, where it is more than rounding.

    energy: a large energy of the run [J].
    """
    gained: dict[float, float] = {}
    least: dict[float, float] = {}
    for event in events:
        if event.kind == "impact":
            gained[event.t] = gained.get(event.t, 0.0) - event.energy_lost
            least[event.t] = least.get(event.t, 0.0) + ROUNDING * (event.impulse * event.normal_speed)
            least[event.t] += ROUNDING * abs(event.energy_lost)
    return [gain for t, gain in gained.items() if gain > max(least[t], GAIN * energy)]


def contact_notes(system: System, events: Sequence[Event], energy: float) -> tuple[str, ...]:
    """Notes on contacts: values not used, laws outside their range, laws of the user that create energy.

    energy: a large energy of this run [J]; gains below the share GAIN of it are rounding.
    """
    notes = [*unused_notes(system.model), *law_faults(system.model)]
    if gains := _gains(events, energy):
        impacts = f"{len(gains)} impact{'s' if len(gains) > 1 else ''}"
        notes.append(SENTENCES["gains"].format(impacts=impacts, gain=sum(gains)))
    for joint, group in _groups(system.model):
        name, contact = joint.name, group.contact
        if contact.normal is None or contact.static is None:
            continue
        peak = max((event.peak_force for event in events if event.joint == name), default=0.0)
        static, normal = (
            registry.kinds("stiffness")[contact.static.kind],
            registry.normal_law(contact.normal.kind),
        )
        notes += [f"{name}, {contact.static.kind}: {note}" for note in static.leaf.notes(contact.static.values, peak)]
        if contact.normal.number("effective_mass", 1.0) > 0.0:
            notes += [f"{name}, {contact.normal.kind}: {note}" for note in normal.leaf.notes(contact.normal.values)]
    return tuple(notes)
