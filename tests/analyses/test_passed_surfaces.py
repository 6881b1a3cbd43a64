"""Motions that are given go through rigid surfaces, and say so."""

import numpy as np
import pytest

import rattle as rt

SLIDER = """
format = 1
ground.points = {{ O = [0, 0], P = [0, 0] }}
bodies.ram = {{ points = {{ C = [0, 0], D = [0.1, 0] }}, center = [0, 0], mass = 2, inertia = 0.1 }}
joints.rail = {{ type = "prismatic", connect = ["ground.P", "ram.C"], axis = "90 deg" }}
drivers.motor = {{ joint = "rail", position = "0.01*cos(3*t)" }}
joints.floor = {{ type = "surface", connect = ["ground.O", "ram.C"], axis = 0, contact = {contact}{more} }}
"""
RIGID = '{ model = "impact" }'


def slider(contact=RIGID, more=""):
    return rt.loads(SLIDER.format(contact=contact, more=more))


def notes(r):
    return [note for note in r.trust.notes if "go into each other" in note]


@pytest.mark.parametrize("analysis", ["kinematics", "inverse_dynamics"])
@pytest.mark.parametrize(("more", "depth"), [("", 0.01), (', roller = "2 mm"', 0.012), (", length = 1", 0.01)])
def test_a_motion_that_goes_into_a_rigid_surface_says_how_deep_and_when(analysis, more, depth):
    """By 10 mm at pi/3, and by the radius of its roller more."""
    (note,) = notes(getattr(slider(more=more), analysis)(np.linspace(0.0, np.pi / 3, 401)))
    assert f"joint 'floor': its bodies go into each other, by up to {depth:g} m" in note
    first = np.arccos(0.2 if "roller" in more else 0.0) / 3
    assert float(note.split("t = ")[1].split(" s")[0]) == pytest.approx(first, abs=3e-3)


def test_between_two_instants_it_is_seen_too():
    r = slider().kinematics(np.linspace(0.0, 2 * np.pi / 3, 3))
    assert notes(r)
    assert not notes(slider().kinematics(np.linspace(0.0, 0.5, 3)))


def test_what_is_compliant_or_beside_a_segment_is_no_fault():
    soft = slider('{ model = "hertz", stiffness = 1e4, exponent = 1 }')
    assert not notes(soft.inverse_dynamics(np.linspace(0.0, 1.0, 101)))
    beside = slider(more=", length = 0.1").set(**{"ground.points.O": [1, 0]})
    assert not notes(beside.kinematics(np.linspace(0.0, 1.0, 101)))


def test_a_plate_that_is_driven_onto_the_end_of_a_segment_says_so():
    """By 10 mm down, onto an end 4 mm below it."""
    plate = "polygon = [[-0.1, 0], [0.1, 0], [0.1, 0.05], [-0.1, 0.05]], points = { C = [0, 0] }, mass = 2"
    text = SLIDER.format(contact=RIGID, more=', length = "20 mm", outline = true')
    text = text.replace("points = { C = [0, 0], D = [0.1, 0] }, center = [0, 0], mass = 2, inertia = 0.1", plate)
    wall = text.replace("O = [0, 0]", "O = [0, -0.014]").replace("axis = 0,", "axis = 1.5707963267948966,")
    wall = wall.replace('axis = "90 deg"', 'axis = "90 deg", angle = 0')
    (note,) = notes(rt.loads(wall).kinematics(np.linspace(0.0, np.pi / 3, 401)))
    assert "by up to 0.006 m" in note
