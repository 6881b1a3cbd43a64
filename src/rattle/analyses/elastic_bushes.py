"""What elastic bushes would show in place of rigid contacts: two runs that bracket the largest force.

A rigid contact has impulses, not peaks, and its force of lasting contact may rise without meaning: the pin follows
its bush on the circle of the play, with m_n u^2 / c.  An elastic one gives way.  The two runs have Hertz' stiffness of
the materials that the model states, or of steel, and a hundredth of it, as housings and pins that bend have.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol, Self

import numpy as np

from rattle import registry
from rattle.analyses.assembly.assembly import Assembled
from rattle.analyses.dynamics.methods import choose_stepper, new_run
from rattle.analyses.dynamics.peak_values import peak_values
from rattle.analyses.dynamics.run import How
from rattle.description.model import Model
from rattle.description.switch_contact import recontact
from rattle.equations.system import System
from rattle.errors import AssemblyError, InputError, ModelError
from rattle.jit import layout as at
from rattle.jit.families import call_stiffness
from rattle.solvers.stepper import ATOL
from rattle.value_types import Json

SOFTER = 0.01  # stiffness of the softer bushes, in those of Hertz for full solids
LAW = "exact"
DEPTH = 1e-6  # [m] at which a stiffness of any geometry is compared with F = K delta^1.5
RADII = 10.0  # bush radius that is assumed if none is given, in clearances
CORNER = 1e9  # stiffness of a guide's corner that is assumed if none is given [N/m^1.5]
LEAST_RESTITUTION = 0.05  # a law of this family damps without bound towards 0
RTOL = 1e-7  # enough for two digits of a peak
MOST_STEPS = 100_000  # a run that takes more gives no bracket: a look aside must not take longer than the run itself


class Loosened(Protocol):
    """The part of a mechanism that is used here."""

    @property
    def model(self) -> Model: ...
    @property
    def system(self) -> System: ...
    @property
    def start(self) -> Assembled: ...
    def contact_of(self, joint: str) -> Any: ...
    def set(self, changes: Mapping[str, object], /) -> Self: ...


def elastic_bushes(m: Loosened, t_end: float) -> tuple[dict[str, tuple[float, float]], dict[str, str]]:
    """Largest normal forces [N] up to t_end [s] with softer and with stiffer bushes, and which bushes, by rigid joint.

    Empty if there are none, or if one of the runs does not reach its end.
    """
    try:
        stiff, words = _stiff(m)
        if not words:
            return {}, {}
        softer = {
            f"joints.{name}.contact": _with_stiffness(stiff.contact_of(name), SOFTER * _stiffness(stiff, name))
            for name in words
        }
        peaks = [_peaks(mechanism, t_end, list(words)) for mechanism in (stiff.set(softer), stiff)]
    except (ModelError, AssemblyError, InputError):
        return {}, {}
    if not all(peaks):
        return {}, {}
    pairs = {name: (peaks[0][name], peaks[1][name]) for name in words}
    return {name: (min(pair), max(pair)) for name, pair in pairs.items()}, words


def _stiff(m: Loosened) -> tuple[Loosened, dict[str, str]]:
    """The mechanism with elastic contacts in place of rigid ones, and which bushes they have, in words."""
    changes, words = {}, {}
    for name, joint in m.model.joints.items():
        if not (joint.clearance > 0.0 and joint.contact is not None and joint.contact.rigid):
            continue
        old = m.contact_of(name)
        table = recontact(old, LAW)
        written: dict[str, object] = {"model": table} if isinstance(table, str) else dict(table)
        own = rigid_restitution(joint.contact.fields)
        written["restitution"] = max(own, LEAST_RESTITUTION)
        stated = any(key == "stiffness" or key.endswith("material") for key in written)
        if stated:
            bush = "of the stated material"
        elif joint.play.from_materials:
            radius = joint.contact.bush_radius or RADII * joint.clearance
            assumed = "" if joint.contact.bush_radius else f", assumed bush radius {1e3 * radius:.3g} mm"
            written |= {"bush_radius": radius, "bush_material": "steel", "pin_material": "steel"}
            bush = f"steel{assumed}"
        else:
            written |= {"stiffness": CORNER, "exponent": 1.5}
            bush = f"assumed stiffness {CORNER:.0e} N/m^1.5"
        changes[f"joints.{name}.contact"] = written
        if own < LEAST_RESTITUTION:
            bush += f", restitution {LEAST_RESTITUTION:g} in place of {own:g}"
        words[name] = f"{bush}; full stiffness of Hertz and a hundredth of it"
    return (m.set(changes) if changes else m), words


def rigid_restitution(fields: Mapping[str, float]) -> float:
    """Restitution of a rigid contact [-]."""
    return float(fields.get("restitution", 0.0))


def _stiffness(m: Loosened, joint: str) -> float:
    """K of F = K delta^1.5 [N/m^1.5] that is as stiff as the contact of a joint at a depth of DEPTH."""
    contact = m.model.joints[joint].contact
    assert contact is not None, "a joint with play has a contact"
    assert contact.static is not None, "an elastic contact has a stiffness"
    kind = registry.kinds("stiffness")[contact.static.kind]
    packed = np.array([*kind.leaf.pack(contact.static.values), 0.0])
    force = float(call_stiffness(kind.kernel, (DEPTH, packed, 0)))
    return force / float(DEPTH**1.5)


def _with_stiffness(written: Any, stiffness: float) -> dict[str, Json]:
    """The table of an elastic contact with this stiffness [N/m^1.5] in place of materials."""
    kept = {key: written[key] for key in ("model", "restitution", "friction", "bush_radius") if key in written}
    return {**kept, "stiffness": stiffness, "exponent": 1.5}


def _peaks(m: Loosened, t_end: float, joints: list[str]) -> dict[str, float]:
    """Largest normal force [N] of each joint in a run to t_end [s]; empty if it does not reach its end."""
    system = m.system
    stepper, step = choose_stepper(system, None, None, t_end)
    run = new_run(system, m.start, np.array([0.0]), t_end, How(stepper, RTOL, ATOL * RTOL, step))
    run.most_steps = MOST_STEPS
    run.go()
    if run.interrupted:
        raise KeyboardInterrupt
    if run.message or float(run.clock[at.T]) < t_end:
        return {}
    values = peak_values(system, run.workspace, t_end)
    return {name: values[f"{name}.normal"].value for name in joints if f"{name}.normal" in values}
