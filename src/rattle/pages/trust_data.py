"""What a page says about how far a run that it computes can be trusted: the package's own sentences and limits as data.

`viewer/core_trust.js` and `viewer/trust_words.js` fill the sentences in as `str.format` does.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from rattle import registry
from rattle.analyses import grip
from rattle.analyses import timetable as times
from rattle.analyses.dynamics import (
    contact_trouble,
    event_driven_run,
    events,
    failure,
    moreau_jean_run,
    oil_notes,
    report,
    singular_passages,
    soundness,
)
from rattle.analyses.dynamics.methods import note_choice
from rattle.analyses.dynamics.run import Run, start_state
from rattle.analyses.law_check import law_faults
from rattle.analyses.travel import doubts_of_fields
from rattle.description.model import Contact, Model
from rattle.equations.contact_table import contact_groups
from rattle.equations.system import System
from rattle.jit import layout as at
from rattle.language.bytecode import SIDE
from rattle.results import contact_summary, trust
from rattle.results.columns import geometry, width
from rattle.solvers import singular_passage, step_audit
from rattle.solvers.contacts import penetration
from rattle.solvers.nonsmooth import event_driven, jams
from rattle.solvers.output_row import record
from rattle.solvers.stepper import TIME_STEPPING, stepper_of
from rattle.value_types import Json

SENTENCES = {
    "trust": trust.SENTENCES,
    "joint": contact_summary.SENTENCES,
    "report": report.SENTENCES,
    "sound": soundness.SENTENCES,
    "event": events.SENTENCES,
    "lock": event_driven_run.SENTENCES,
    "passage": singular_passages.SENTENCES,
    "oil": oil_notes.SENTENCES,
    "jolt": times.SENTENCES,
    "grip": grip.SENTENCES,
    "shared": {
        "torque": contact_trouble.SHARED_TORQUE,
        "force": contact_trouble.SHARED_FORCE,
        "free": contact_trouble.FREE_FRICTION,
    },
    "trouble": contact_trouble.SENTENCES,
    "failure": failure.SENTENCES,
    "peaks": {"steps": moreau_jean_run.PEAKS, "impacts": moreau_jean_run.OF_IMPACTS},
}
WRITTEN = "the model as it is written: "  # before what is said of other values of parameters than those of a run
LIMITS = {
    trust: ("POOR", "FEW"),
    contact_summary: ("TOWERS", "USUAL", "ENOUGH", "ON_EDGE", "RISING", "OFTEN", "ROUNDING"),
    report: ("LOW",),
    soundness: ("SAID", "SUNK", "SWIFT", "SHORTER", "OF_OPENING", "FASTEST_BODY", "ITS_DRIVER"),
    step_audit: ("TOO_FAR",),
    failure: ("TINY", "BEYOND", "STATE"),
    event_driven: ("MOST_IN_A_ROW", "CROWDED"),
    penetration: ("DEEP",),
    events: ("GAIN",),
    event_driven_run: ("LEAST_SAID", "NEARLY_LOCKED"),
    singular_passages: ("NAMED",),
    singular_passage: ("PASSED", "SINGULAR"),
    grip: ("CARRIES",),
    oil_notes: ("INERTIA", "VORTICES", "HARD"),
}


def trust_data(run: Run, asked: str | None) -> dict[str, Json]:
    """Sentences, limits and facts of a model for the trust of its runs; run: one before its first step.

    asked: the stepper that the model, or the user, asks for.
    """
    system, stepper = run.system, run.stepper.leaf
    limits = {name: getattr(module, name) for module, names in LIMITS.items() for name in names}
    return {
        "sentences": SENTENCES,
        "written": WRITTEN,
        "limits": {**limits, "JOLTS": times.FEW, "NEARLY_GONE": contact_trouble.NEARLY_LOCKED},
        "units": times.UNITS,
        "method": {"title": stepper.title, "adaptive": bool(stepper.adaptive), "loop": type(run).loop},
        "loops": {"by_events": at.RUNS_BY_EVENTS, "equal_steps": at.RUNS_EQUAL_STEPS},
        "doubts": [f"joint '{name}': {doubt}" for name, doubt in doubts_of_fields(system.model)],
        "choice": note_choice(system, asked, run.stepper),
        "unused": [*events.unused_notes(system.model), *law_faults(system.model)],
        "laws": list(_of_laws(system.model)),
        "timed": [switch.name for switch in system.switches if switch.timed],
        **_at_the_start(run),
        "cornered": report.cornered_surfaces(system),
        "dry": list(system.dry_joints),
        "rough": list(system.rough_joints),
        "other": f"method {stepper_of(TIME_STEPPING)}",
        "about": jams.ABOUT,
        "side": SIDE,
        "clutches": (system.arrays["contact"][:, at.LEVEL] == 1).tolist(),
        "drivers": [_driver(system, name) for name in system.model.drivers],
        "bodies": list(system.bodies),
        "links": {name: _link(system.model, name) for name in system.watched},
        **_joints(system.model),
        "oil": {name: told for name in system.model.joints if (told := _film(system.model, name))},
    }


def _of_laws(model: Model) -> Iterator[str | dict[str, Json]]:
    """Notes on contact laws, and on those that are valid up to a force {joint, kind, limit}."""
    for joint in model.joints.values():
        for group in contact_groups(joint):
            contact = group.contact
            if contact.normal is None or contact.static is None:
                continue
            static = registry.kinds("stiffness")[contact.static.kind].leaf
            limit = (
                math.inf if static.notes(contact.static.values, math.inf) == [] else static.limit(contact.static.values)
            )
            always = static.notes(contact.static.values, 0.0)
            yield from (f"{joint.name}, {contact.static.kind}: {note}" for note in always)
            if not always and limit < math.inf:
                sentence = f"{joint.name}, {contact.static.kind}: {static.too_large}"
                yield {"joint": joint.name, "limit": limit, "sentence": sentence}
            yield from _of_damping(joint.name, contact)


def _of_damping(joint: str, contact: Contact) -> Iterator[str]:
    """Notes on the law of a contact that dissipates."""
    law = contact.normal
    if law is not None and law.number("effective_mass", 1.0) > 0.0:
        yield from (f"{joint}, {law.kind}: {note}" for note in registry.normal_law(law.kind).leaf.notes(law.values))


def _at_the_start(run: Run) -> dict[str, Json]:
    """Joints whose reactions are not unique where the constraints depend on each other from the start."""
    system, workspace = run.system, run.system.workspace()
    record(workspace, run.start.t, start_state(system, run.start), np.zeros(width(system)))
    nonunique, note = report.nonunique_at_start(system, workspace)
    return {"nonunique": nonunique, "friction_note": note}


def _driver(system: System, name: str) -> dict[str, Json]:
    unit = system.rows[system.first_row(name)].unit
    return {"name": name, "slot": system.driver_slot(name), "unit": unit}


def _link(model: Model, name: str) -> dict[str, Json]:
    """Where the ends of a massless link are: body and point [m]."""
    joint = model.joints[name]
    return {"clearance": joint.clearance, "ends": [[end.body, *end.at] for end in (joint.a, joint.b)]}


def facts(model: Model, watched: Sequence[str]) -> Iterator[tuple[tuple[str | int, ...], Any]]:
    """Numbers of `trust_data` that may follow from parameters: where they stand in it, and their values [SI].

    watched: joints with massless links.
    """
    for name in watched:
        joint = model.joints[name]
        yield ("links", name, "clearance"), joint.clearance
        for end, point in enumerate((joint.a, joint.b)):
            yield from ((("links", name, "ends", end, 1 + k), x) for k, x in enumerate(point.at))
    for name, joint in model.joints.items():
        film = joint.contact.film if joint.contact is not None and joint.is_loose else None
        if film is None:
            continue
        law = film.law
        sizes = {"boundary": film.boundary, "clearance": joint.clearance, "density": film.density}
        sizes |= {"radius": law.number("bush_radius"), "viscosity": law.number("viscosity")}
        yield from ((("oil", name, key), value) for key, value in sizes.items())


def _joints(model: Model) -> dict[str, Json]:
    """Joints in their order, rigid ones, and those that can lose contact, with the name of their force."""
    forms = geometry(model)["joints"]
    return {
        "joints": list(forms),
        "rigid": [name for name, form in forms.items() if form["rigid"]],
        "loose": [name for name, form in forms.items() if form["contact"] not in ("", "ideal")],
        "stops": [name for name, form in forms.items() if form.get("stop")],
    }


def _film(model: Model, name: str) -> dict[str, Json] | None:
    """Notes on the oil in a joint, and what its runs are compared with; None without oil."""
    joint = model.joints[name]
    film = joint.contact.film if joint.contact is not None else None
    if film is None or not joint.is_loose:
        return None
    return {
        "notes": oil_notes.notes_of_film(name, film), "boundary": film.boundary, "clearance": joint.clearance,
        "radius": float(film.law.number("bush_radius")), "viscosity": float(film.law.number("viscosity")),
        "density": film.density, "bodies": [joint.a.body, joint.b.body],
    }  # fmt: skip
