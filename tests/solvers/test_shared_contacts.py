"""Contacts beside each other: corners of short blocks, and corners that share a force in more ways than one."""

import math

import numpy as np
import pytest

import rattle as rt


def toy(k, block="1 um"):
    """The woodpecker with lengths across times k and the blocks of its points at that size."""
    text = rt.examples()["woodpecker"].read_text().replace("1 um", block)
    return rt.loads(text).set(k=k)


def test_short_block_that_is_tilted_touches_with_one_corner_however_near_the_other_is():
    beat = {}
    for k in (10, 30, 100):
        run = toy(k).simulate(0.9)
        assert run.success, run.message
        beat[k] = np.diff([e.t for e in run.events if e.kind == "impact" and e.joint == "beak"])[-1]
    # angles are 1/k of the true ones: what the small angles leave out of a beat is of first order in 1/k, then 1/k^2
    ratio = (1 / 10 - 1 / 30) / (1 / 30 - 1 / 100)
    assert (beat[10] - beat[30]) / (beat[30] - beat[100]) == pytest.approx(ratio, rel=0.1)


def test_motion_depends_on_the_size_of_a_short_block_in_proportion_to_it():
    down = []
    for block in ("10 um", "1 um", "3 nm"):
        run = toy(10, block).simulate(0.3)
        assert run.success, run.message
        down.append(run["sleeve.y"][-1])
    assert (down[0] - down[2]) / (down[1] - down[2]) == pytest.approx((10 - 0.003) / (1 - 0.003), rel=5e-3)


def slab(friction, speed):
    """A slab that cannot turn, 1 mm above a floor: which of its two corners bears it nothing says."""
    return rt.loads(f"""
format = 1
gravity = [0, -9.81]
[ground.points]
G = [0, 0]
[bodies.slab]
mass = 1
inertia = 0.01
points = {{ C = [0, 0] }}
[drivers.upright]
body = "slab"
coordinate = "angle"
angle = 0
[joints.floor]
type = "prismatic"
connect = ["ground.G", "slab.C"]
axis = "0 deg"
angle = 0
clearance = "1 mm"
block = {{ length = "100 mm", height = "20 mm" }}
contact = {{ model = "impact", restitution = 0, friction = {friction} }}
[initial]
slab = {{ x = 0, y = 0, angle = 0, vx = {speed}, vy = 0, omega = 0 }}
""")


@pytest.mark.parametrize("friction", [0.0, 0.3, 2.0])
def test_corners_that_share_a_force_are_said_and_the_motion_goes_on(friction):
    run = slab(friction, 1.0).simulate(0.3)
    fall, g = math.sqrt(2 * 1e-3 / 9.81), 9.81
    after = 1.0 - friction * g * fall  # the floor takes the fall away at once, and friction mu times that
    left = 0.3 - fall
    if friction:
        left = min(left, after / (friction * g))
    assert run.success, run.message
    assert run["slab.x"][-1] == pytest.approx(fall + after * left - 0.5 * friction * g * left**2, rel=1e-9)
    assert run["floor.normal"][-1] == pytest.approx(g, rel=1e-12)
    assert any("share a force at joint 'floor'" in note for note in run.trust.notes)


def test_corners_whose_forces_are_told_by_the_moment_are_not_called_shared():
    text = slab(0.3, 1.0).to_toml()
    free = rt.loads(text[: text.index("[drivers")] + text[text.index("[joints") :])
    run = free.simulate(0.3)
    assert run.success, run.message
    assert not any("share a force" in note for note in run.trust.notes)
    assert np.abs(run["slab.angle"]).max() < 1e-9  # mu times its half height is below its half length: it stays flat
