"""Starts near a known one: what the kernels do with a mechanism whose positions are known in closed form."""

import math

import numpy as np
import pytest

import rattle as rt
from rattle.analyses.assembly.first_guess import ways_of_kernels
from rattle.equations.kept_values import MOVED, NOT_CLOSED
from rattle.equations.start_near import TOO_FAR, close_near, place_outward, rates_near

pytestmark = pytest.mark.nojit


def pendulum(length=1.0, angle=0.3):
    m = rt.Mechanism("pendulum", gravity=[0, -9.81])
    m.ground(O=[0, 0])
    m.bar("rod", "A", "B", length=length, mass=1)
    m.revolute("O", "ground.O", "rod.A")
    m.initial("rod", angle=angle, omega=2.0)
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
    m = rt.Mechanism("two rods", gravity=[0, -9.81])
    m.ground(O=[0, 0], C=[3, 0])
    m.bar("left", "A", "B", length=1, mass=1)
    m.bar("right", "A", "B", length=1, mass=1)
    m.revolute("O", "ground.O", "left.A")
    m.revolute("P", "left.B", "right.A")
    m.revolute("C", "ground.C", "right.B")
    system, q = m.system, np.array([0.5, 0.0, 0.1, 2.0, 0.0, -0.1])
    became, _ = close_near(system.assembly_workspace(), 0.0, q, np.full(6, math.nan), system.size, np.empty((2, 6)))
    assert became == NOT_CLOSED


def test_bodies_are_placed_by_their_joints_and_move_with_them():
    system, ways = pendulum(), ways_of_kernels(pendulum())
    workspace, q, nothing = system.assembly_workspace(), np.array([9.0, 9.0, 0.3]), np.full(3, math.nan)
    place_outward(workspace, q, nothing, np.array([[0.0, 0.01]]), np.zeros((1, 2)), ways)
    assert q == pytest.approx(hanging(1.0, 0.3) + np.array([0.0, 0.01, 0.0]), abs=1e-15)
    q, v = hanging(1.0, 0.3), np.zeros(3)
    rates_near(workspace, 0.0, q, v, np.array([math.nan, math.nan, 2.0]), system.size, ways)
    assert v == pytest.approx([-2.0 * q[1], 2.0 * q[0], 2.0], abs=1e-14)


SLANT = math.radians(30)


def block(kind, ends=("ground.O", "block.C"), **fields):
    """A block at the origin of the ground on a line, or at a distance."""
    m = rt.Mechanism("block")
    m.ground(O=[0, 0])
    m.body("block", mass=1, inertia=1, points={"C": [0.0, 0.0]})
    m.joint("j", kind, *ends, **fields)
    return m.system


def placed(system, q, given, line):
    q = np.array([*q, 0.0])
    ways = ways_of_kernels(system)
    given = np.array([*given, math.nan])
    place_outward(system.assembly_workspace(), q, given, np.zeros((1, 2)), np.array([line]), ways)
    return q[:2]


@pytest.mark.parametrize("ends", [("ground.O", "block.C"), ("block.C", "ground.O")])
def test_a_block_stays_where_it_is_along_its_line_unless_one_coordinate_is_given(ends):
    system, u = block("prismatic", ends, axis="30 deg"), np.array([math.cos(SLANT), math.sin(SLANT)])
    nothing, line = math.nan, (SLANT, 0.0)
    assert placed(system, (9.0, 1.0), (nothing, nothing), line) == pytest.approx(u @ [9.0, 1.0] * u, abs=1e-14)
    assert placed(system, (9.0, 1.0), (2.0, nothing), line) == pytest.approx(2.0 / u[0] * u, abs=1e-14)
    assert placed(system, (9.0, 1.0), (nothing, 2.0), line) == pytest.approx(2.0 / u[1] * u, abs=1e-14)
    assert placed(system, (9.0, 1.0), (3.0, 2.0), line) == pytest.approx([3.0, 2.0], abs=0.0)
    upright = (math.pi / 2, 0.0)  # x says nothing of the place along it
    assert placed(system, (9.0, 1.0), (0.0, nothing), upright) == pytest.approx([0.0, 1.0], abs=1e-14)


@pytest.mark.parametrize("ends", [("ground.O", "block.C"), ("block.C", "ground.O")])
def test_a_block_on_a_rod_is_at_its_length_in_the_direction_where_it_was(ends):
    system = block("rod", ends, length="2 m")
    assert placed(system, (0.3, 0.4), (math.nan, math.nan), (0.0, 2.0)) == pytest.approx([1.2, 1.6], abs=1e-14)
