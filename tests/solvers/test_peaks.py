"""Peaks and mean squares come from within the steps: how many outputs a run has does not change them."""

import json
import math

import numpy as np
import pytest
from click.testing import CliRunner

import rattle as rt
from rattle.cli.main import main
from rattle.results.contact_summary import extreme, rms
from rattle.results.evaluation import evaluate
from rattle.results.reductions import Known, read

FORCES = (".force", ".moment", ".torque", ".power", ".normal")


def peaks_of(m, t_end, interval, **options):
    times = np.linspace(0.0, t_end, round(t_end / interval) + 1)
    return m.simulate(t_end, t_eval=times, **options)


@pytest.mark.parametrize(
    ("name", "contact", "t_end", "intervals", "options"),
    [
        ("fourbar", None, 0.1, (1e-3, 1e-5, 2e-6), {}),
        ("slider_crank_play", None, 0.005, (1e-3, 2e-7), {}),
        ("fourbar", "impact", 0.01, (1e-3, 1e-6), {}),
        ("fourbar", None, 0.05, (1e-3, 1e-5), {"method": "rk4", "step": 5e-5}),
    ],
)
def test_no_number_of_outputs_changes_a_peak_and_dense_outputs_find_no_larger_one(
    name, contact, t_end, intervals, options
):
    m = rt.example(name)
    m = m.with_contact(contact) if contact else m
    runs = [peaks_of(m, t_end, interval, **options) for interval in intervals]
    for r in runs[1:]:
        assert r.peaks == runs[0].peaks
    dense = runs[-1]
    largest = max(one.value for one in dense.peaks.values())
    for key, one in dense.peaks.items():
        if key not in dense or one.value < 1e-9 * largest:  # what is zero but for rounding
            continue
        sampled = np.abs(dense[key])
        assert one.value >= sampled.max() * (1 - 1e-6), key
        assert one.value <= sampled.max() * (1.0 + 1e-3), key  # outputs beside a top fall short of it
        # the trapezoidal rule at the outputs is good to some 1e-4 where contacts last tens of them
        assert one.rms == pytest.approx(rms(dense.t, sampled), rel=2e-3), key


def pendulum():
    """A uniform bar of 1 m and 2 kg, let go where it is level."""
    m = rt.Mechanism("pendulum", gravity=[0, -10])
    m.ground(O=[0, 0])
    m.bar("rod", "A", "B", length=1.0, mass=2.0)
    m.revolute("O", "ground.O", "rod.A")
    return m


def test_peak_of_a_pendulum_is_two_and_a_half_weights_at_the_lowest_point():
    r = pendulum().simulate(3.0, t_eval=[3.0], rtol=1e-10)
    value, t = r.peak("O.force")
    assert value == pytest.approx(2.5 * 2.0 * 10.0, rel=1e-7)  # dense output: order 7
    lowest = pendulum().simulate(3.0, t_eval=np.linspace(0, 3.0, 30001), rtol=1e-10)
    assert abs(np.interp(t, lowest.t, lowest["rod.x"])) < 1e-3  # a flat top: its time is good to sqrt(1e-7)
    # energy: F^2 = (m g)^2 (1/16 cos^2 + (5/2 sin)^2) of the angle below the level
    s = np.sin(lowest["rod.angle"])
    square = 400.0 * ((1 - s**2) / 16 + 6.25 * s**2)
    assert r.rms("O.force") == pytest.approx(math.sqrt(np.trapezoid(square, lowest.t) / 3.0), rel=1e-6)


def test_a_load_that_acts_for_a_fiftieth_of_a_step_is_not_missed():
    m = rt.Mechanism("driven", gravity=[0, 0])
    m.ground(O=[0, 0])
    m.bar("rod", "A", "B", length=1.0, mass=2.0)
    m.revolute("O", "ground.O", "rod.A")
    m.driver("motor", joint="O", angle="2*t")
    m.load("pulse", type="force", at="rod.B", force=["1000/(1 + ((t - 0.5)/0.01)**2)", 0])
    r = m.simulate(1.0, t_eval=[1.0])
    assert r.peak("motor.torque")[0] == pytest.approx(1000 * math.sin(1.0), rel=2e-3)  # the arm turns a little
    # the integral of 1/(1 + u^2)^2 is pi/2; 4 N of the turning mass beside it
    assert r.rms("O.force") == pytest.approx(1000 * math.sqrt(0.01 * math.pi / 2), rel=0.01)


def test_peaks_of_a_run_that_is_cut_off_are_those_up_to_there():
    m = rt.example("fourbar")
    short, long = peaks_of(m, 0.01, 1e-3), peaks_of(m, 0.02, 1e-5)
    before = np.abs(long["O4.force"][long.t <= 0.01]).max()
    assert short.peak("O4.force")[0] == pytest.approx(before, rel=1e-4)


def test_a_step_of_moreau_is_what_its_peaks_are_made_of():
    m = rt.example("bouncing_pin")
    joint = next(iter(m.model.joints))
    one, two = (m.simulate(0.05, t_eval=np.linspace(0, 0.05, n), method="moreau", step=1e-5) for n in (3, 5001))
    assert one.peaks == two.peaks
    assert one.peak(f"{joint}.force")[0] == pytest.approx(two[f"{joint}.force"].max(), rel=1e-9)
    assert "largest of its steps" in str(one.trust)


def test_peaks_survive_a_file(tmp_path):
    r = peaks_of(rt.example("fourbar"), 0.01, 1e-3)
    r.save(tmp_path / "out.nc")
    again = rt.load_result(tmp_path / "out.nc")
    assert again.peaks == r.peaks
    assert again.peak("O3.force") == r.peak("O3.force")
    assert again.contacts == r.contacts


def test_positions_need_not_be_dense_for_the_peak_between_them():
    m = rt.example("slider_crank").ideal()
    coarse, fine = (m.inverse_dynamics(np.linspace(0.0005, 0.0105, n)) for n in (101, 20001))
    for name in ("guide.force", "motor.torque"):
        most = fine[name].max()
        assert coarse[name].max() < most * (1 - 1e-6)
        assert coarse.peak(name)[0] == pytest.approx(most, rel=1e-4)


@pytest.mark.nojit
def test_a_maximum_is_refined_only_where_the_curve_is_smooth():
    t = np.linspace(0.0, 1.0, 21)
    assert extreme(t, np.sin(3 * t))[0] == pytest.approx(1.0, abs=1e-6)
    assert extreme(t, np.sin(3 * t))[1] == pytest.approx(math.pi / 6, abs=1e-4)
    jump = np.where(t < 0.52, t, -1.0)
    assert extreme(t, jump) == (0.5, 0.5)
    kink = -np.abs(t - 0.5)
    assert extreme(t, kink) == (0.0, 0.5)
    assert extreme(t[:3], t[:3]) == (0.1, 0.1)
    assert math.isnan(extreme(t, np.full(21, np.nan))[0])


def test_json_and_table_show_the_same_peak_whatever_the_output_interval():
    words = ["-q", "run", "fourbar", "--t-end", "0.1", "--no-horizon"]
    said = [CliRunner().invoke(main, [*words, "--set", f"simulate.output={dt}"]).output for dt in ("1 ms", "10 us")]
    assert said[0].splitlines()[:5] == said[1].splitlines()[:5]
    record = json.loads(CliRunner().invoke(main, [*words, "--json"]).stdout)
    assert record["peaks"]["O4.force"]["peak"] == pytest.approx(6076.54, rel=1e-5)  # 2 us outputs: 6076.5425
    assert record["peaks"]["O4.force"]["t"] == pytest.approx(0.014514, abs=1e-6)


def test_of_equal_peaks_the_first_instant_is_told():
    """The crank turns once: the start comes again at the end, and rounding must not choose between them."""
    run = rt.example("slider_crank").simulate()
    assert [run.peaks[name].t for name in ("O.force", "A.force", "B.force")] == [0.0, 0.0, 0.0]


def test_a_peak_next_to_a_singular_position_is_found_within_long_steps():
    """Jansen's leg is nearly stretched where its crank is loaded most, between the ends of its few steps."""
    m = rt.example("jansen_leg")
    largest = m.inverse_dynamics(np.linspace(1.06, 1.07, 201))["O.force"].max()
    assert m.simulate(1.2).peak("O.force")[0] == pytest.approx(largest, rel=1e-6)


@pytest.mark.parametrize("stiffness", [1e7, 1e11, 1e14])
def test_the_greatest_value_of_an_expression_in_a_short_contact_is_that_of_the_closed_form(stiffness):
    n, mass, v = 1.5, 2.0, 1.0
    r = rt.loads(f"""
format = 1
gravity = [0, 0]
ground.points = {{ O = [0, 0] }}
bodies.block = {{ points = {{ C = [0, 0] }}, mass = {mass}, inertia = 1 }}
[joints.guide]
type = "prismatic"
connect = ["ground.O", "block.C"]
stop = {{ max = 0.12, contact = {{ model = "hertz", stiffness = {stiffness}, exponent = {n}, damping = 0 }} }}
[initial]
block = {{ x = 0, vx = {v} }}
""").simulate(0.2)
    deep = (0.5 * (n + 1.0) * mass * v**2 / stiffness) ** (1.0 / (n + 1.0))
    pushes = evaluate(read("max(3*abs(guide.stop) + 1 N)", Known.of(r)), r)
    assert pushes == pytest.approx(3.0 * stiffness * deep**n + 1.0, rel=1e-6)
