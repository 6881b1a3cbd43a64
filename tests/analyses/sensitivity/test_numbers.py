"""Derivatives of numbers of whole runs: extremes, means, what lies between contacts."""

import math

import numpy as np
import pytest

import rattle as rt
from balls import G, ball
from rattle.errors import InputError
from rattle.questions.sensitivity.pictures import plot_effects

T1 = math.sqrt(2.0 / G)  # the first impact of a ball that falls by 1 m [s]


def test_numbers_of_a_ball_that_bounces():
    m = rt.loads(ball())
    end = 0.75
    names = {
        "max(ball.vy)": (0.8 * G * T1, G * T1, 0.5 * 0.8 * G * T1),
        "mean(ball.vy)": (None, G * T1 * (end - T1) / end, None),
        "time(rail.contacts, 1)/h": (T1, 0.0, -0.5 * T1),
        "at(ball.y, 0.7)*h": (None, G * T1 * (0.7 - T1), None),
    }
    s = m.sensitivity(["ball.y", *names], ["e", "h"], [0.0, 0.3, end])
    assert s.trust.notes == ()
    assert s["d(ball.y)/d(h)"][:2] == pytest.approx(1.0, rel=1e-9)
    for name, (value, by_e, by_h) in names.items():
        for found, want in ((s[name], value), (s[f"d({name})/d(e)"], by_e), (s[f"d({name})/d(h)"], by_h)):
            assert np.ptp(found) == 0.0
            if want is not None:
                assert found[0] == pytest.approx(want, rel=1e-7, abs=1e-9)


def test_numbers_of_a_driven_mechanism_follow_the_text_they_are_written_in():
    """The largest speed of a slider, against kinematics with another crank; its way is two cranks long."""
    m = rt.example("slider_crank")
    t, r, step = np.linspace(0.0, 0.02, 801), m.parameters["crank_length"], 1e-5
    s = m.sensitivity(["max(slider.vx)", "range(slider.x)/crank_length"], ["crank_length"], t, analysis="kinematics")
    high, low = (m.set(crank_length=r + change).kinematics(t).peak("slider.vx")[0] for change in (step, -step))
    assert s["d(max(slider.vx))/d(crank_length)"][0] == pytest.approx((high - low) / (2.0 * step), rel=1e-4)
    assert s["range(slider.x)/crank_length"][0] == pytest.approx(2.0, rel=1e-6)
    assert s["d(range(slider.x)/crank_length)/d(crank_length)"][0] == pytest.approx(0.0, abs=1e-4)


def test_numbers_are_not_of_an_equilibrium():
    with pytest.raises(InputError, match="a number of a whole motion"):
        rt.example("balanced_arm").sensitivity(["max(arm.angle)"], ["l"], analysis="equilibrium")


def test_numbers_are_drawn_as_bars_and_curves_over_time():
    m = rt.example("slider_crank")
    s = m.sensitivity(
        ["max(slider.vx)", "slider.x"], ["crank_length", "rod_length"], [0.0, 0.01, 0.02], analysis="kinematics"
    )
    bars, over_time = plot_effects(s).axes
    changes = [patch.get_width() for patch in bars.patches]
    assert abs(changes[0]) >= abs(changes[1]) > 0.0
    assert bars.get_xlabel().startswith("change of max(slider.vx) [")
    assert len(over_time.lines) == 2
    assert over_time.get_xlabel() == "time [s]"
