"""Derivatives through rigid contacts that rest, stick and slip, several at once: closed forms, differences of runs."""

import math

import numpy as np
import pytest

import rattle as rt
from balls import G
from blocks import against_a_wall, block
from rattle.trace.recorded_rigid import SLOTS

FINE = {"rtol": 1e-11, "atol": 1e-14}
PUSH = '[loads.push]\ntype = "force"\nat = "block.C"\n'


def slopes(m, outputs, parameters, t):
    s = m.sensitivity(outputs, parameters, [0.0, t], **FINE)
    assert s.success, s.message
    return {(of, to): s[f"d({of})/d({to})"][-1] for of in outputs for to in parameters}


def differences(m, outputs, name, t, step=1e-6):
    """The same slopes by differences of runs."""
    here = float(m.parameters[name])
    h = step * abs(here)
    asked = [of if "(" in of else f"final({of})" for of in outputs]
    found = m.many({name: [here - h, here + h]}, asked, t_end=t, **FINE)
    return {(of, name): (found[key][1] - found[key][0]) / (2 * h) for of, key in zip(outputs, asked, strict=True)}


def assert_alike(m, outputs, names, t, rel=1e-6, floor=1e-7):
    got = slopes(m, outputs, names, t)
    for name in names:
        for key, want in differences(m, outputs, name, t).items():
            assert got[key] == pytest.approx(want, rel=rel, abs=floor), key


def test_a_block_slides_to_rest():
    found = slopes(rt.loads(block()), ["block.x", "block.vx"], ["mu", "v"], 1.0)
    mu, v = 0.3, 1.0
    assert found["block.x", "v"] == pytest.approx(v / (mu * G), rel=1e-9)
    assert found["block.x", "mu"] == pytest.approx(-(v**2) / (2 * mu**2 * G), rel=1e-9)
    assert found["block.vx", "v"] == pytest.approx(0.0, abs=1e-12)


def test_a_block_that_is_pushed_breaks_away():
    """m x'' = F t - mu m g from t = mu m g/F on."""
    text = block(PUSH + 'force = ["F*t", 0]\n', vx="0").replace("F = 0.0", "F = 20.0")
    found = slopes(rt.loads(text), ["block.x", "block.vx"], ["mu", "F"], 0.6)
    m, mu, F, t = 2.0, 0.3, 20.0, 0.6
    late = t - mu * m * G / F
    by_mu = -m * G / F  # of `late`; by F it is mu m g/F^2
    assert found["block.x", "mu"] == pytest.approx(F * late**2 / (2 * m) * by_mu, rel=1e-8)
    assert found["block.vx", "mu"] == pytest.approx(F * late / m * by_mu, rel=1e-8)
    by_F = late**3 / (6 * m) + F * late**2 / (2 * m) * mu * m * G / F**2
    assert found["block.x", "F"] == pytest.approx(by_F, rel=1e-8)


@pytest.mark.long
def test_a_block_that_is_shaken_sticks_and_slips():
    text = block(PUSH + 'force = ["F*sin(20*t)", 0]\n', vx="0").replace("F = 0.0", "F = 20.0")
    assert_alike(rt.loads(text), ["block.x", "block.vx"], ["mu", "F"], 0.7)


def test_a_block_falls_flat_and_bounces():
    low = block().replace("y = 0.1", "y = 0.15").replace("restitution = 0,", "restitution = 0.4,")
    assert_alike(rt.loads(low), ["block.x", "block.y", "time(floor.contacts, 1)"], ["mu", "v"], 0.5)


def test_three_contacts_with_friction_at_once():
    m = rt.loads(against_a_wall()).set(v=2.0)
    assert len(m.system.arrays["contact"]) > SLOTS
    found = slopes(m, ["block.x", "time(wall.contacts, 1)"], ["mu", "v"], 0.3)
    mu, v, way = 0.3, 2.0, 0.3
    root = math.sqrt(v**2 - 2 * mu * G * way)
    t = (v - root) / (mu * G)
    assert found["block.x", "mu"] == pytest.approx(0.0, abs=1e-9)
    assert found["block.x", "v"] == pytest.approx(0.0, abs=1e-9)
    assert found["time(wall.contacts, 1)", "v"] == pytest.approx(-t / root, rel=1e-9)
    assert found["time(wall.contacts, 1)", "mu"] == pytest.approx(G * t**2 / (2 * root), rel=1e-9)


@pytest.mark.parametrize(("name", "t"), [("c", 0.012), ("e", 0.02), ("mu", 0.02)])
def test_a_block_in_its_guide_bounces_to_rest_on_both_corners(name, t):
    assert_alike(rt.example("guide_play"), ["crank.angle", "slider.y", "time(guide.contacts, 1)"], [name], t)


@pytest.mark.parametrize("law", ["newton", "poisson", "energetic"])
def test_what_hits_while_another_contact_lasts(law):
    """The block rests on the floor with a foot while its other end falls; mu makes it slip or stick there."""
    text = block().replace("y = 0.1, angle = 0,", "y = 0.2, angle = 0.3,").replace('vx = "v"', "vx = 0")
    text = text.replace("restitution = 0,", f'restitution = 0.2, restitution_law = "{law}",')
    outputs = ["block.x", "block.y", "block.angle", "time(floor.contacts, 1)"]
    assert_alike(rt.loads(text), outputs, ["mu"], 0.16, rel=1e-5)


@pytest.mark.parametrize("law", ["energetic", "lzb"])
def test_impacts_by_energy_of_one_contact(law):
    """v+ = e sqrt(2 g h) from the height h; of several at once there is no derivative, which is said."""
    text = """
format = 1
parameters = { e = 0.7, h = 0.2, low = 0.0 }
gravity = [0, -9.81]
ground.points = { O = [0, 0], P = [1, 0] }
bodies.a = { points = { C = [0, 0] }, mass = 1, inertia = 1 }
bodies.b = { points = { C = [0, 0] }, mass = 2, inertia = 1 }
initial = { a = { x = 0, y = "h" }, b = { x = 1, y = "low + 1" } }
"""
    for name, foot in (("a", "O"), ("b", "P")):
        text += f"""
[joints.stop_{name}]
type = "prismatic"
connect = ["ground.{foot}", "{name}.C"]
axis = "90 deg"
angle = 0
stop = {{ min = 0, contact = {{ model = "impact", restitution = "e", restitution_law = "{law}", stiffness = 1 }} }}
"""
    m, t = rt.loads(text), 0.3
    found = slopes(m, ["a.vy"], ["e", "h"], t)
    v = math.sqrt(2.0 * G * 0.2)
    assert found["a.vy", "e"] == pytest.approx(v, rel=1e-9)
    assert found["a.vy", "h"] == pytest.approx(G / v * (1.0 + 0.7), rel=1e-9)
    s = m.set(low=-0.8).sensitivity(["a.vy"], ["e"], [0.0, t])
    assert "of energetic and lzb restitution one" in s.message


def test_from_a_start_that_a_parameter_moves_off_its_wall_there_is_no_derivative():
    text = block().replace("y = 0.1,", 'y = "h",').replace("F = 0.0", "F = 0.0, h = 0.1")
    s = rt.loads(text).sensitivity(["block.x"], ["h"], [0.0, 0.1])
    assert "bodies touch in floor at the start already" in s.message


def test_of_a_contact_at_which_the_answer_ends_that_is_said():
    text = block().replace("y = 0.1,", 'y = "0.15 + h",').replace("F = 0.0", "F = 0.0, h = 0.0, w = 0.0")
    text = text.replace("omega = 0", 'omega = "w"')
    s = rt.loads(text).sensitivity(["time(floor.contacts, 1)"], ["w"], [0.0, 0.2])
    assert "several contacts begin or end there at once" in s.message
    assert any(note.startswith("time(floor.contacts, 1) is not known: derivatives end at t") for note in s.trust.notes)


@pytest.mark.parametrize("name", ["mu", "e", "F"])
def test_numbers_of_a_curve_that_jumps_at_an_instant_that_stays(name):
    """The first corner hits whatever mu and F are; rows beside that instant do not pass it."""
    text = (
        block(PUSH + 'force = ["F*sin(5*t)", 0]\n').replace("F = 0.0", "F = 2.0, e = 0.6").replace("v = 1.0", "v = 0.1")
    )
    text = text.replace("restitution = 0,", 'restitution = "e",').replace(
        "y = 0.1, angle = 0,", "y = 0.3, angle = 0.2,"
    )
    m = rt.loads(text)
    found = slopes(m, ["integral(block.vx)", "block.x", "max(block.vx)"], [name], 0.5)
    assert found["integral(block.vx)", name] == pytest.approx(found["block.x", name], rel=1e-7, abs=1e-9)
    want = differences(m, ["max(block.vx)"], name, 0.5)
    assert found["max(block.vx)", name] == pytest.approx(want["max(block.vx)", name], rel=1e-5, abs=1e-7)


RAIL = """
format = 1
parameters = { mu = 0.3, v = 0.0, F = 20.0, t1 = 0.2 }
gravity = [0, -9.81]
ground.points.O = [0, 0]
bodies.block = { points = { C = [0, 0] }, mass = 2, inertia = 1 }
initial.block = { x = 0, y = 0, angle = 0, vx = "v", vy = 0, omega = 0 }
[joints.rail]
connect = ["ground.O", "block.C"]
axis = 0
"""
RESTS = {
    "joint": RAIL.replace("y = 0, angle = 0, ", "").replace(", vy = 0, omega = 0", "")
    + 'type = "prismatic"\nfriction = { model = "coulomb", mu = "mu" }\n',
    "contact": RAIL + 'type = "surface"\ncontact = { model = "impact", restitution = 0, friction = "mu" }\n',
    "block": block(vx="0").replace("F = 0.0", "F = 20.0, t1 = 0.2"),
}


@pytest.mark.parametrize("rests", ["joint", "contact", pytest.param("block", marks=pytest.mark.long)])
def test_what_rests_is_pushed_away_where_a_load_jumps(rests):
    """x'' = F/m - mu g from t1 on."""
    m = rt.loads(RESTS[rests] + PUSH + 'force = ["F*(0.2 + 0.8*step(t - t1))", 0]\n')
    found = slopes(m, ["block.x", "block.vx"], ["t1", "F", "mu"], 0.5)
    a, late = 10.0 - 0.3 * G, 0.3
    assert found["block.vx", "t1"] == pytest.approx(-a, rel=1e-9)
    assert found["block.x", "t1"] == pytest.approx(-a * late, rel=1e-9)
    assert found["block.x", "F"] == pytest.approx(late**2 / 4, rel=1e-9)
    assert found["block.x", "mu"] == pytest.approx(-G * late**2 / 2, rel=1e-9)


def test_what_rests_is_lifted_where_a_load_jumps():
    text = block(PUSH + 'force = [0, "-F + 80*step(t - t1)"]\n').replace("F = 0.0", "F = 20.0, t1 = 0.1")
    found = slopes(rt.loads(text), ["block.x", "block.y"], ["t1", "F"], 0.3)
    assert found["block.y", "t1"] == pytest.approx(-(30.0 - G) * 0.2, rel=1e-9)
    assert found["block.y", "F"] == pytest.approx(-(0.2**2) / 4, rel=1e-9)
    assert found["block.x", "F"] == pytest.approx(-0.15 * (0.1**2 / 2 + 0.1 * 0.2), rel=1e-8)


def at_its_stop(push, x):
    """A block of 2 kg at rest at one of its stops."""
    return rt.loads(f"""
format = 1
parameters = {{ F = 10.0 }}
ground.points.O = [0, 0]
bodies.block = {{ points = {{ C = [0, 0] }}, mass = 2, inertia = 1 }}
loads.push = {{ type = "force", at = "block.C", force = ["{push}", 0] }}
initial.block = {{ x = {x}, vx = 0 }}
[joints.rail]
type = "prismatic"
connect = ["ground.O", "block.C"]
axis = 0
stop = {{ min = -0.1, max = 0.1, contact = {{ model = "impact", restitution = 0.4 }} }}
""")


AIR = " - 2*block.vx*abs(block.vx)"


@pytest.mark.parametrize("sense", ["", "-"])
@pytest.mark.parametrize("load", ["F*t", "F*t**2", "F*t" + AIR])
def test_what_rests_at_its_stop_is_pulled_off_by_a_load_that_begins_at_zero(sense, load):
    """x = F t^3/12, or F t^4/24 of its square; air takes part of the first."""
    force, air = load.removesuffix(AIR), AIR if load.endswith(AIR) else ""
    m = at_its_stop(f"{sense}{force}{air}", 0.1 if sense else -0.1)
    if air:
        assert_alike(m, ["block.x"], ["F"], 0.3)
        return
    t = np.array([0.0, 0.2, 0.3])
    s = m.sensitivity(["block.x"], ["F"], t)
    assert s.success, s.message
    want = t**3 / 12.0 if force == "F*t" else t**4 / 24.0
    assert s["d(block.x)/d(F)"] == pytest.approx(-want if sense else want, rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("push", ["-F*t", "-F*(1 - t)"])
def test_what_a_load_presses_on_its_stop_rests_there(push):
    s = at_its_stop(push, -0.1).sensitivity(["block.x", "rail.stop"], ["F"], [0.0, 0.5])
    assert s.success, s.message
    assert s["d(rail.stop)/d(F)"] == pytest.approx([float("(1" in push), 0.5], abs=1e-9)
    assert s["d(block.x)/d(F)"] == pytest.approx(0.0, abs=1e-12)
