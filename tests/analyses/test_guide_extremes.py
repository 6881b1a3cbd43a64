"""Exact extremes of a guide's play: against brute force over every place at which the four corners are inside."""

import math

import numpy as np
import pytest

import rattle as rt
from linkages import slider_crank

nojit = pytest.mark.nojit


def loose(length: float, height: float, clearance: float, point: tuple[float, float] = (0.0, 0.0)) -> rt.Mechanism:
    """A slider-crank whose slider is a block in a wide guide, with a tool on it."""
    guide = f"""connect = ["ground.O", "slider.B"]
clearance = {clearance}
block = {{ length = {length}, height = {height} }}
contact = "ideal"
"""
    text = slider_crank().replace('connect = ["ground.O", "slider.B"]', guide)
    text = text.replace(
        "[bodies.slider]\npoints = { B = [0, 0]", f"[bodies.slider]\npoints = {{ T = {list(point)}, B = [0, 0]"
    )
    return rt.loads(text)


def inside(length: float, height: float, clearance: float, across: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """Whether all four corners of a block lie between its walls."""
    found = np.ones(np.broadcast(across, turn).shape, bool)
    for x in (-length / 2, length / 2):
        for y in (-height / 2, height / 2):
            found &= np.abs(across + x * np.sin(turn) + y * np.cos(turn)) <= height / 2 + clearance
    return found


@nojit
@pytest.mark.parametrize(
    ("length", "height", "clearance"), [(0.08, 0.03, 1e-3), (0.08, 0.06, 5e-3), (0.05, 0.02, 1e-4)]
)
def test_a_block_turns_until_two_corners_touch(length, height, clearance):
    found = loose(length, height, clearance).accuracy("slider.angle", [0.1], loaded=False)
    low, high = 0.0, 0.5  # the largest turn that leaves all corners inside, by bisection
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (
            (middle, high) if inside(length, height, clearance, np.zeros(1), np.array(middle))[0] else (low, middle)
        )
    assert found.high[0] == pytest.approx(low, rel=1e-9)
    assert found.low[0] == pytest.approx(-low, rel=1e-9)
    assert low > clearance / (0.5 * length)  # first order is on the small side


@pytest.mark.machine
@nojit
@pytest.mark.parametrize("point", [(0.03, 0.0), (0.01, 0.05), (0.045, 0.06), (-0.05, 0.09), (0.041, -0.08)])
def test_no_place_inside_the_guide_beats_the_extremes_of_a_tool(point):
    length, height, clearance = 0.08, 0.03, 1e-3
    found = loose(length, height, clearance, point).accuracy("slider.T.y", [0.1], loaded=False)
    across, turn = np.meshgrid(np.linspace(-clearance, clearance, 801), np.linspace(-0.026, 0.026, 2081))
    values = across + point[0] * np.sin(turn) + point[1] * np.cos(turn)
    values = values[inside(length, height, clearance, across, turn)]
    spacing = 2.5e-6 * 3  # of the grid, in the output
    assert values.max() <= found.high[0] + 1e-12
    assert values.max() >= found.high[0] - spacing
    assert values.min() >= found.low[0] - 1e-12
    assert values.min() <= found.low[0] + spacing


@nojit
def test_an_extreme_can_lie_on_a_curved_side():
    # a tool above the block: across + x sin + y cos with x a little beyond a and y beyond b is largest between two tips
    a, b, c, x, y = 0.04, 0.015, 1e-3, 0.0403, 0.06
    found = loose(2 * a, 2 * b, c, (x, y)).accuracy("slider.T.y", [0.1], loaded=False)
    turn = math.atan((x - a) / (y - b))  # where b + c - a sin - b cos + x sin + y cos is largest
    assert found.high[0] == pytest.approx(b + c + math.hypot(x - a, y - b), abs=1e-13)
    assert 0.0 < turn < 0.02


@nojit
def test_a_block_that_can_turn_over_has_no_extremes_and_that_is_said():
    found = loose(0.04, 0.08, 5e-3).accuracy("slider.angle", [0.1], loaded=False)
    assert np.isnan(found.low).all()
    assert np.isnan(found.high).all()
    assert "can turn over: its diagonal of 89.44 mm fits between walls 90 mm apart" in str(found)
    assert not loose(0.05, 0.08, 5e-3).accuracy("slider.angle", [0.1], loaded=False).notes
