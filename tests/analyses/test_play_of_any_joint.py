"""Any joint of a mechanism that can be put together may be made loose: the start is near that without play."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

import rattle as rt
from rattle.description.model import Joint

PLAY = 5e-5  # [m]
ELASTIC = ("exact", "hunt-crossley", "kelvin-voigt", "flores", "hertz")


def laws(names: tuple[str, ...]) -> dict[str, Any]:
    known: dict[str, Any] = {
        "massless-link": "massless-link",
        "impact": {"model": "impact", "restitution": 0.5},
        "lubricated": {"model": "lubricated", "viscosity": 0.2, "length": 0.02},
        "hertz": {"model": "hertz", "stiffness": 1e9},
    }
    elastic = {name: {"model": name, "stiffness": 1e9, "restitution": 0.5} for name in ELASTIC}
    return {name: {**elastic, **known}[name] for name in names}


def loosened(joint: Joint, names: tuple[str, ...]) -> Iterator[dict[str, Any]]:
    """Fields of this joint with play, one set for each contact model that it can have."""
    if joint.contact is not None or joint.friction is not None:
        return
    for name, law in laws(names).items():
        if joint.kind == "revolute":
            yield {"clearance": PLAY, "contact": law if isinstance(law, str) else {**law, "bush_radius": 0.008}}
        elif name in ("massless-link", "lubricated"):
            continue
        elif joint.kind == "prismatic":
            yield {"clearance": PLAY, "contact": law, "block": {"length": 0.02, "height": 0.01}}
        elif joint.kind == "slot":
            yield {"clearance": PLAY, "contact": law}
        elif joint.kind == "gear":
            yield {"pressure_angle": "20 deg", "backlash": 1e-4, "contact": law}
        elif joint.kind in ("cam", "flat-follower"):
            yield {"contact": law}


def changed(m: rt.Mechanism, joints: dict[str, dict[str, Any]]) -> rt.Mechanism:
    return m.set({f"joints.{name}.{key}": value for name, fields in joints.items() for key, value in fields.items()})


def roughly(m: rt.Mechanism, degrees: float) -> rt.Mechanism:
    """With start angles that are off by so much, to either side."""
    signs, changes = 1.0, {}
    for body, values in m.model.initial.bodies.items():
        if "angle" in values:
            changes[f"initial.{body}.angle"] = float(values["angle"] + signs * math.radians(degrees))
            signs = -signs
    return m.set(changes) if changes else m


def require_near(m: rt.Mechanism, loose: rt.Mechanism) -> None:
    """The pins are inside (assembly refuses others), and no body is farther away than many plays let it be."""
    size = m.system.size
    away = np.abs(loose.start.q - m.start.q) / np.tile([size, size, 1.0], m.system.body_count)
    assert away.max() < 0.05


@pytest.mark.parametrize("name", sorted(rt.examples()))
def test_every_joint_of_the_examples_can_be_made_loose(name):
    m = rt.example(name)
    for joint in m.model.joints.values():
        for fields in loosened(joint, ("massless-link", "impact")):
            require_near(m, changed(m, {joint.name: fields}))


@pytest.mark.parametrize("law", ["massless-link", "impact", "exact", "lubricated"])
@pytest.mark.parametrize(
    "name", ["five_bar", "quick_return", "toggle", "slider_crank", "scissor_lift", "piston_engine"]
)
def test_all_pins_at_once_can_be_made_loose_with_rough_angles(name, law):
    m = roughly(rt.example(name), 3.0)
    loose = {one.name: next(loosened(one, (law,)), None) for one in m.model.joints.values() if one.is_hinge}
    require_near(m, changed(m, {joint: fields for joint, fields in loose.items() if fields}))


# rough angles of these put a pin or foot where no joint holds it: into the pole, the floor, or through a flank
PLACED_BY_CONTACT = {"woodpecker", "geneva", "step_ladder"}
SEARCHES = {("squeezer", 3.0), ("chain", 3.0)}  # long ones
PLACES = [(name, 0.0) for name in sorted(rt.examples())]
PLACES += [(name, 3.0) for name in sorted(set(rt.examples()) - PLACED_BY_CONTACT)]
EXACT = {(name, 0.0) for name in {"squeezer"} | PLACED_BY_CONTACT}  # of the others rough angles are enough
QUICK = EXACT | ({place for place in PLACES if place[1] > 0.0} - SEARCHES)


@pytest.mark.parametrize(
    ("name", "degrees"), [pytest.param(*at, marks=[] if at in QUICK else [pytest.mark.long]) for at in PLACES]
)
def test_every_joint_of_the_examples_can_be_made_loose_with_every_contact(name, degrees):
    m = roughly(rt.example(name), degrees)
    for joint in m.model.joints.values():
        for fields in loosened(joint, ("massless-link", "impact", "lubricated", *ELASTIC)):
            require_near(m, changed(m, {joint.name: fields}))


PRESS = """
format = 1
[ground.points]
O = [0, 0]
[bodies.crank]
bar = ["O", "A"]
length = 0.08
mass = 60
[bodies.rod]
bar = ["A", "B"]
length = 0.5
mass = 50
[bodies.ram]
points = { B = [0, 0] }
mass = 300
inertia = 10
[joints]
O = { type = "revolute", connect = ["ground.O", "crank.O"] }
A = { type = "revolute", connect = ["rod.A", "crank.A"], clearance = 6e-5, contact = CONTACT }
B = { type = "revolute", connect = ["rod.B", "ram.B"] }
guide = { type = "prismatic", connect = ["ground.O", "ram.B"], axis = "-90 deg", angle = 0 }
[drivers.motor]
joint = "O"
angle = "DRIVE deg + 9*t"
[initial]
rod = { angle = "ROD deg" }
"""


@pytest.mark.parametrize("contact", ["impact", "exact", "lubricated"])
@pytest.mark.parametrize(("drive", "rod"), [(90, -90), (0, -90), (0, -80.8), (200, -100), (-60, -85)])
def test_the_pin_of_a_press_starts_in_the_middle_of_its_bush(contact, drive, rod):
    law = {
        "impact": '{ model = "impact", restitution = 0.5 }',
        "exact": '{ model = "exact", stiffness = 1e9, restitution = 0.5 }',
        "lubricated": '{ model = "lubricated", viscosity = 0.2, length = 0.08, bush_radius = 0.06 }',
    }[contact]
    text = PRESS.replace("CONTACT", law).replace("DRIVE", str(drive)).replace("ROD", str(rod))
    m = rt.loads(text)
    require_near(m.ideal(), m)
    r = m.simulate(1e-6)
    assert math.hypot(r["A.ex"][0], r["A.ey"][0]) < 6e-5
