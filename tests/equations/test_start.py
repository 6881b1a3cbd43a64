"""Starts: what the kernels do with a mechanism whose positions are known in closed form."""

import math

import numpy as np
import pytest

import rattle as rt
from rattle.analyses.assembly.loop_map import loop_map
from rattle.analyses.assembly.searching import search_arrays
from rattle.equations.closure import open_by
from rattle.equations.kept_values import MOVED, NOT_CLOSED
from rattle.equations.start import TOO_FAR, close_near, rates_near
from rattle.equations.start_search import find_closing, guess_first, least_open

pytestmark = pytest.mark.nojit


def pendulum(length=1.0, angle=0.3):
    m = rt.Mechanism("pendulum", gravity=[0, -9.81])
    m.ground(O=[0, 0])
    m.bar("rod", "A", "B", length=length, mass=1)
    m.revolute("O", "ground.O", "rod.A")
    m.initial("rod", angle=angle, omega=2.0)
    return m.system


def too_short():
    """Two rods of 1 m between points that are 3 m apart."""
    m = rt.Mechanism("two rods", gravity=[0, -9.81])
    m.ground(O=[0, 0], C=[3, 0])
    m.bar("left", "A", "B", length=1, mass=1)
    m.bar("right", "A", "B", length=1, mass=1)
    m.revolute("O", "ground.O", "left.A")
    m.revolute("P", "left.B", "right.A")
    m.revolute("C", "ground.C", "right.B")
    return m.system


def hanging(length, angle):
    return np.array([0.5 * length * math.cos(angle), 0.5 * length * math.sin(angle), angle])


def test_a_longer_rod_keeps_its_given_angle():
    system, q, given = pendulum(1.2), hanging(1.0, 0.3), np.array([math.nan, math.nan, 0.3])
    became, _ = close_near(system.assembly_workspace(), 0.0, q, given, system.size, np.empty((2, 3)))
    assert became == MOVED
    assert q == pytest.approx(hanging(1.2, 0.3), abs=1e-14)


def test_a_start_on_the_other_side_is_too_far():
    system, q, given = pendulum(), hanging(1.0, 0.3), np.array([math.nan, math.nan, 0.3 + math.pi])
    became, _ = close_near(system.assembly_workspace(), 0.0, q, given, system.size, np.empty((2, 3)))
    assert became == TOO_FAR


def test_a_loop_that_is_too_short_stays_open():
    system, q = too_short(), np.array([0.5, 0.0, 0.1, 2.0, 0.0, -0.1])
    became, _ = close_near(system.assembly_workspace(), 0.0, q, np.full(6, math.nan), system.size, np.empty((2, 6)))
    assert became == NOT_CLOSED


def guessed(system, given=(math.nan, math.nan, math.nan), offsets=None):
    """The first guess of the positions of one body."""
    q = np.zeros(3)
    guess_first(system.assembly_workspace(**search_arrays(system, np.array(given), offsets or {})), 0.0, q)
    return q


def test_bodies_are_placed_by_their_joints_and_move_with_them():
    system, nothing = pendulum(), math.nan
    q = guessed(system, (nothing, nothing, 0.3), {"O": (0.0, 0.01)})
    assert q == pytest.approx(hanging(1.0, 0.3) + np.array([0.0, 0.01, 0.0]), abs=1e-15)
    q, v, ways = hanging(1.0, 0.3), np.zeros(3), loop_map(system).arrays["start_ways"]
    rates_near(system.assembly_workspace(), 0.0, q, v, np.array([nothing, nothing, 2.0]), system.size, ways)
    assert v == pytest.approx([-2.0 * q[1], 2.0 * q[0], 2.0], abs=1e-14)


def test_a_body_that_no_joint_leads_to_has_the_rates_that_are_given():
    m = rt.Mechanism("two bodies apart")
    m.body("left", mass=1, inertia=1, points={"P": [1.0, 0.0]})
    m.body("right", mass=1, inertia=1, points={"Q": [0.0, 0.0]})
    m.revolute("P", "left.P", "right.Q").initial("left", x=3, y=4, angle=0, vx=1, omega=2).initial("right", angle=0.5)
    assert m.start.q == pytest.approx([3, 4, 0, 4, 4, 0.5], abs=1e-12)
    assert m.start.v[[0, 2]] == pytest.approx([1, 2], abs=1e-12)


SLANT = math.radians(30)


def block(kind, ends=("ground.O", "block.C"), **fields):
    """A block at the origin of the ground on a line, or at a distance."""
    m = rt.Mechanism("block")
    m.ground(O=[0, 0])
    m.body("block", mass=1, inertia=1, points={"C": [0.0, 0.0]})
    m.joint("j", kind, *ends, **fields)
    return m.system


ENDS = [("ground.O", "block.C"), ("block.C", "ground.O")]


@pytest.mark.parametrize("ends", ENDS)
def test_a_block_on_a_line_is_guessed_where_a_coordinate_is_given_or_at_its_point(ends):
    system, u = block("prismatic", ends, axis="30 deg", angle=0), np.array([math.cos(SLANT), math.sin(SLANT)])
    nothing = math.nan
    assert guessed(system)[:2] == pytest.approx([0.0, 0.0], abs=0.0)
    assert guessed(system, (2.0, nothing, nothing))[:2] == pytest.approx(2.0 / u[0] * u, abs=1e-14)
    assert guessed(system, (nothing, 2.0, nothing))[:2] == pytest.approx(2.0 / u[1] * u, abs=1e-14)
    assert guessed(system, (3.0, 2.0, nothing))[:2] == pytest.approx([3.0, 2.0], abs=0.0)
    upright = block("prismatic", ends, axis="90 deg", angle=0)  # x says nothing of the place along it
    assert guessed(upright, (0.0, nothing, nothing))[:2] == pytest.approx([0.0, 0.0], abs=1e-14)


@pytest.mark.parametrize("ends", ENDS)
def test_a_block_on_a_rod_hangs_below_its_point_unless_a_place_is_given(ends):
    system = block("rod", ends, length="2 m")
    sign = 1.0 if ends[0] == "ground.O" else -1.0
    assert guessed(system)[:2] == pytest.approx([0.0, -2.0 * sign], abs=1e-14)
    assert guessed(system, (0.3, 0.4, math.nan))[:2] == pytest.approx([0.3, 0.4], abs=0.0)


def test_a_mechanism_that_cannot_be_closed_is_left_where_it_is_least_open():
    system, q, given = too_short(), np.zeros(6), np.full(6, math.nan)
    workspace = system.assembly_workspace(**search_arrays(system, given, {}))
    became, _ = find_closing(workspace, 0.0, q, q, 0)
    assert became == NOT_CLOSED
    least_open(workspace, 0.0, q)
    open_ = open_by(workspace, 0.0, q, np.zeros(6))
    assert open_ == pytest.approx(1.0 / 3.0, rel=1e-6)  # shared by three joints
    assert q == pytest.approx([0.5 + 1 / 3, 0, 0, 1.5 + 2 / 3, 0, 0], abs=1e-4)
