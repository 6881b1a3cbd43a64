"""A block that rocks between two walls: no energy goes astray, however wide its guide and however short the block."""

import math

import pytest

import rattle as rt

G, HEIGHT, LENGTH = 9.81, 0.0696, 0.0149


def rocking(c, law="newton", length=LENGTH, height=HEIGHT, **start):
    """A block of 1 kg that stands tilted on one corner on the lower wall of a guide with the clearance c [m]."""
    tilt = -0.1286
    lowest = 0.5 * (length * math.sin(-tilt) + height * (math.cos(tilt) - 1.0))
    state = {"x": 0.0, "y": lowest - c, "angle": tilt, "vx": 0.0, "vy": 0.0, "omega": 0.0, **start}
    return rt.loads(f"""
format = 1
gravity = [0, {-G}]
[ground.points]
O = [0, 0]
[bodies.B]
mass = 1
inertia = 4.2e-4
points = {{ P = [0, 0] }}
[joints.J]
type = "prismatic"
connect = ["ground.O", "B.P"]
axis = 0
angle = 0
clearance = {c}
block = {{ length = {length}, height = {height} }}
contact = {{ model = "impact", restitution = 0.1, friction = 1.0, restitution_law = "{law}" }}
[initial]
B = {{ {", ".join(f"{key} = {value!r}" for key, value in state.items())} }}
""")


@pytest.mark.parametrize("law", ["newton", "poisson", "energetic"])
def test_energy_of_a_rocking_block_is_accounted_for_whatever_the_clearance(law):
    for c in (1.0, 0.01, 0.001):
        run = rocking(c, law).simulate(2.5, t_eval=[0.0, 0.1, 2.5])
        assert run.success, run.message
        assert run["B.angle"][-1] == pytest.approx(0.0, abs=1e-9)
        height = run["B.y"][0] - run["B.y"][-1]
        # at rest all energy of the start is lost
        assert run["energy.dissipated"][-1] == pytest.approx(G * height, rel=1e-6)
        assert run.trust.energy_share < 1e-6


def test_share_of_the_energy_error_is_that_of_the_energy_exchanged():
    run = rocking(0.01).simulate(1.5, rtol=1e-4)
    exchanged = run["energy.potential"].max() - run["energy.potential"].min()
    off = abs(run["energy.balance"]).max()
    assert off > 1e-6 * exchanged
    # the error is looked at after every step, not only at outputs, and compared with the tolerance besides
    assert 0.3 * off / exchanged < run.trust.energy_share < 10.0 * off / exchanged


@pytest.mark.parametrize("law", ["newton", "poisson", "energetic"])
@pytest.mark.parametrize("side", [1e-6, 1e-9, 1e-12])
def test_a_block_that_is_nearly_a_point_loses_what_a_point_loses(law, side):
    # all its corners are within 1e-6 of a wide clearance of each other; it falls 10 mm, turning, and bounces
    for angle in (-0.1286, 0.0):
        run = rocking(1.0, law, side, side, y=-0.99, angle=angle, omega=3.0).simulate(0.05, t_eval=[0.0, 0.05])
        assert run.success, run.message
        first = next(e.t for e in run.events if e.kind == "impact")
        lost = sum(e.energy_lost for e in run.events if e.kind == "impact" and e.t < 1.001 * first)
        assert lost == pytest.approx(G * 0.01 * (1.0 - 0.1**2), rel=2.0 * side / 0.01 + 1e-8)
