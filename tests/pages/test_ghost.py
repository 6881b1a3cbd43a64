"""The ghost of a motion is that of the mechanism without play, where its drivers determine it."""

import numpy as np
import pytest

import rattle as rt
from any_motion import any_motion
from rattle.pages.ghost import ghost_of

pytestmark = [pytest.mark.nojit, pytest.mark.plain]


def in_time(name):
    """A result of an example with made-up numbers, which holds its model."""
    r = any_motion(name, t_end=0.002)
    r.provenance |= {"analysis": "simulate", "document": rt.example(name).to_json()}
    return r


def test_ghost_of_a_slider_crank_is_its_closed_form():
    r = in_time("slider_crank_play")
    ghost = ghost_of(r)
    assert ghost is not None
    np.testing.assert_array_equal(ghost.t, r.t)
    crank, length = 0.05, 0.12
    along, up = crank * np.cos(ghost["crank.angle"]), crank * np.sin(ghost["crank.angle"])
    np.testing.assert_allclose(ghost["slider.x"], along + np.sqrt(length**2 - up**2), atol=1e-9)


@pytest.mark.parametrize("name", ["slider_crank", "woodpecker", "three_plays"])
def test_no_ghost_without_play_or_where_nothing_drives(name):
    assert ghost_of(in_time(name)) is None


def test_no_ghost_without_a_model():
    assert ghost_of(any_motion("slider_crank_play")) is None
