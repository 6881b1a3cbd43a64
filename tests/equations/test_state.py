"""The state vector: a friction law may have as many states as it says, and nobody else has to know."""

import math

import numpy as np
import pytest

import rattle as rt
from linkages import block_in_guide
from rattle import registry
from rattle.analyses.dynamics.run import How
from rattle.analyses.dynamics.smooth_run import SmoothRun
from rattle.elements.custom.contact_law import friction_law
from rattle.equations.state import ACCOUNTS, ENERGIES, state_layout

G, SPEED, SPRING, WORN = 9.81, 0.1, 100.0, 40.0  # m/s^2, m/s, 1/m, 1/m


@pytest.fixture
def worn_spring(laws):
    """T / N = SPRING (way slid) + WORN (path slid), against the slip: bristles that do not let go, and wear."""

    @friction_law("worn-spring", states=2, spring="1/m", worn="1/m", v1="m/s")
    def worn_spring(u, N, z, p):
        root = math.sqrt(N)  # a way measured so gives no energy back when N changes, see contact_laws/friction.py
        return root * p.spring * z[0] + N * p.worn * z[1] * math.tanh(u / p.v1), (root * u, abs(u))

    return f'model = "worn-spring", spring = {SPRING}, worn = {WORN}, v1 = "0.01 mm/s"'


def block(friction):
    contact = f'{{ model = "exact", restitution = 0.3, stiffness = 1e11, friction = {{ {friction} }} }}'
    return rt.loads(block_in_guide(contact, 2e-4, 0.08, 1e-3, G, y=-2e-4, vx=SPEED))


def test_a_law_with_two_states_moves_a_block_as_its_closed_form_says(worn_spring):
    # on the way out the path is the way: x'' = -g (SPRING + WORN) x up to the turn at A; on the way back it is 2 A - x:
    # x'' = -g (SPRING + WORN) x + 2 g WORN A, a cosine about another middle
    w = math.sqrt(G * (SPRING + WORN))
    A, turn = SPEED / w, 0.5 * math.pi / w
    r = block(worn_spring).simulate(t_eval=np.linspace(0.0, 2.8 * turn, 400))
    middle = 2.0 * A * WORN / (SPRING + WORN)
    back = middle + (A - middle) * np.cos(w * (r.t - turn))
    x = np.where(r.t < turn, A * np.sin(w * r.t), back)
    assert r.success
    assert r["block.x"] == pytest.approx(x, abs=5e-3 * A)  # N is not its weight while it sinks in: 1 % of this time


def test_states_of_a_law_are_the_way_and_the_path_of_its_contact(worn_spring):
    m = block(worn_spring)
    t_eval = np.linspace(0.0, 0.1, 2001)
    run = SmoothRun(m.system, m.start, t_eval, 0.1, How(registry.kinds("stepper")["dop853"], 1e-9, 1e-12, None))
    run.go()
    layout = state_layout(m.system)
    assert layout.size == 6 + len(ENERGIES) + 4 * len(ACCOUNTS) + 4 * 2 == len(run.workspace.state)
    assert [name for name, _ in layout.units()[-8:]] == ["guide.state"] * 8
    way, path = run.workspace.state[layout.states].reshape(4, 2).T
    moved = run.raw[:, 0]
    pressed = path > 0.0
    assert pressed.sum() == 2  # the corners on the lower wall
    assert path[pressed] == pytest.approx(float(np.abs(np.diff(moved)).sum()), rel=1e-3)
    assert np.abs(way[pressed]) == pytest.approx(math.sqrt(0.5 * 2 * G) * abs(moved[-1]), rel=1e-2)  # while it sinks in
    assert (way[~pressed] == 0.0).all()


def test_a_number_of_states_below_zero_is_refused():
    with pytest.raises(ValueError, match="-1 states"):
        friction_law("less", states=-1)
