"""The end of a run is an output whatever the rounding of the last step."""

import pytest

import rattle as rt

WHEEL = """
format = 1
gravity = [0, 0]
[ground.points]
O = [0, 0]
[bodies.wheel]
points = { C = [0, 0] }
mass = 1
inertia = 1
[joints.pin]
type = "revolute"
connect = ["ground.O", "wheel.C"]
[initial]
wheel = { omega = 1 }
"""


@pytest.mark.nojit
def test_the_last_instant_is_never_lost():
    """A last step that begins before half of the run has a rounded length: t + h may fall short of the end."""
    wheel = rt.loads(WHEEL)
    for k in range(30):
        end = 0.85 + 0.005 * k
        r = wheel.simulate(end, t_eval=[0.0, end], rtol=1e-2, atol=1e-2)
        assert r.t.tolist() == [0.0, end]
        assert r["wheel.angle"][-1] == pytest.approx(end, abs=1e-14)
