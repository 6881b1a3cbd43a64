"""Runs that pass singular positions: parallelograms in line, scissors closed, cranks and rods that coincide."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import rattle as rt
from linkages import SCISSOR
from rattle.results.evaluation import evaluate
from rattle.results.reductions import Known, read

G = 9.81
TOLERANCES = [1e-6, 1e-8, 1e-10, 1e-12]

ISOSCELES = """
format = 1
gravity = [0, -9.81]
[ground.points]
O = [0, 0]
[bodies.crank]
bar = ["O", "A"]
length = 0.4
mass = 1.0
[bodies.rod]
bar = ["A", "B"]
length = 0.4
mass = 2.0
[bodies.slider]
points = { B = [0, 0] }
mass = 3.0
inertia = 0.01
[joints.O]
type = "revolute"
connect = ["ground.O", "crank.O"]
[joints.A]
type = "revolute"
connect = ["crank.A", "rod.A"]
[joints.B]
type = "revolute"
connect = ["rod.B", "slider.B"]
[joints.rail]
type = "prismatic"
connect = ["ground.O", "slider.B"]
axis = 0
[initial]
crank = { angle = "30 deg", omega = 9 }
rod = { angle = "-30 deg" }
"""


def windows(n: int) -> rt.Mechanism:
    """n four-bars of 1 m, 1 kg bars in series, upper points starting at 1 m/s (IFToMM benchmark A02)."""
    m = rt.Mechanism(f"{n} windows", gravity=[0, -G])
    for k in range(n + 1):
        m.ground(**{f"G{k}": [k, 0]})
        m.bar(f"p{k}", "G", "P", length=1, mass=1).revolute(f"G{k}", f"ground.G{k}", f"p{k}.G")
        m.initial(f"p{k}", angle="90 deg", omega=-1)
    for k in range(1, n + 1):
        m.bar(f"c{k}", "L", "R", length=1, mass=1).initial(f"c{k}", angle=0, omega=0)
        m.revolute(f"L{k}", f"p{k - 1}.P", f"c{k}.L").revolute(f"R{k}", f"c{k}.R", f"p{k}.P")
    return m


def pendulum_of(n: int, t_end: float) -> tuple[float, list[float]]:
    """Angle of the posts at t_end [rad] and instants [s] with all bars in line, from the one pendulum they are."""
    ratio = (9 * n + 3) / (8 * n + 2)  # m g l [(n+1)/2 + n] over m l^2 [(n+1)/3 + n]

    def rate(t, y):
        return [y[1], -G * ratio * np.cos(y[0])]

    def level(t, y):
        return np.sin(y[0])

    run = solve_ivp(rate, (0, t_end), [np.pi / 2, -1], "DOP853", rtol=1e-12, atol=1e-12, events=level)
    return float(run.y[0, -1]), run.t_events[0].tolist()


def swings_as_a_pendulum(n: int, rtol: float) -> None:
    """A run of n windows passes all positions in line, names them, and moves as a pendulum does."""
    r = windows(n).simulate(10.0, t_eval=[0.0, 10.0], rtol=rtol)
    assert r.success, r.message
    angle, instants = pendulum_of(n, 10.0)
    # the error of a swinging pendulum's phase grows with time and with the number of bodies in the norm of the error
    # a passage may be off by 1e-7 (CROSSED), which a pendulum that is nearly upright makes fifteen times as large
    assert r["p0.angle"][-1] == pytest.approx(angle, abs=max(3e-6, 3e3 * rtol))
    assert np.ptp([r[f"p{k}.angle"][-1] for k in range(n + 1)]) < 1e-6  # none has folded over
    assert r.trust.singular == pytest.approx(instants, abs=max(1e-5, 1e3 * rtol))
    # bars of 1 kg swinging at 6 rad/s: a force beyond 1 kN would be one of an instant in line
    assert max(r.peak(f"G{k}.force")[0] for k in range(n + 1)) < 1e3


@pytest.mark.parametrize("rtol", TOLERANCES)
@pytest.mark.parametrize("n", [1, 3, 20])
def test_four_bars_in_series_pass_all_positions_in_line(n, rtol):
    swings_as_a_pendulum(n, rtol)


@pytest.mark.long
@pytest.mark.parametrize("n", range(1, 81))
def test_any_number_of_four_bars_in_series_passes_them_at_every_tolerance(n):
    for digits in range(6, 13):
        swings_as_a_pendulum(n, 10.0**-digits)


@pytest.mark.parametrize("rtol", TOLERANCES)
def test_crank_and_rod_of_one_length_pass_the_position_in_which_they_coincide(rtol):
    r = rt.loads(ISOSCELES).simulate(1.0, t_eval=[0.0, 0.5, 1.0], rtol=rtol)
    assert r.success, r.message
    # crank angle q, rod -q, slider at 2 l cos q: J(q) q'' + J'(q) q'^2/2 = -V'(q)
    length, crank, rod, slider = 0.4, 1.0, 2.0, 3.0
    base = (crank / 3 + rod / 12) * length**2

    def inertia(q):
        across, along = 0.5 * length * np.cos(q), 1.5 * length * np.sin(q)
        return base + rod * (across**2 + along**2) + slider * (2 * length * np.sin(q)) ** 2

    def rate(t, y):
        q, w = y
        slope = (rod * (2.25 - 0.25) * length**2 + 4 * slider * length**2) * np.sin(2 * q)
        pull = -(crank + rod) * G * 0.5 * length * np.cos(q)
        return [w, (pull - 0.5 * slope * w * w) / inertia(q)]

    exact = solve_ivp(rate, (0, 1), [np.radians(30), 9.0], "DOP853", [0, 0.5, 1], rtol=1e-12, atol=1e-12)
    assert r["crank.angle"] == pytest.approx(exact.y[0], abs=max(1e-8, 1e3 * rtol))
    assert r["rod.angle"] == pytest.approx(-exact.y[0], abs=max(1e-8, 1e3 * rtol))
    assert len(r.trust.singular) >= 1
    assert "singular position" in r.trust.remarks()


def test_peaks_beside_a_singular_position_do_not_depend_on_the_tolerance():
    runs = [rt.loads(SCISSOR).simulate(0.8, t_eval=[0.0], rtol=rtol) for rtol in (1e-6, 1e-7, 1e-8, 1e-9, 1e-11, 1e-12)]
    assert all(r.success and len(r.trust.singular) == 1 for r in runs)
    for name in ("F.force", "M.force", "T1.force", "T2.force", "G.force"):
        peaks = [r.peak(name)[0] for r in runs]
        # they grow as 1/(t - t*) towards it; where the part left out begins is known to percent
        assert peaks == pytest.approx([peaks[-1]] * len(peaks), rel=0.05)
        rms = [r.rms(name) for r in runs]
        assert rms == pytest.approx([rms[-1]] * len(rms), rel=0.03)
    assert runs[0].trust.singular == pytest.approx(runs[-1].trust.singular, abs=1e-4)
    for joint in ("F", "M", "G", "T1", "T2"):
        assert joint in runs[2].trust.remarks()


def test_no_curve_shows_more_than_the_table_beside_a_singular_position():
    """Rows that the table leaves out are nan in what follows from reactions, and nowhere else."""
    for outputs in (101, 1001, 10001):
        r = rt.loads(SCISSOR).simulate(0.8, t_eval=np.linspace(0.0, 0.8, outputs))
        left = np.isnan(r["F.force"])
        assert (np.abs(r.t[left] - r.trust.singular[0]) < 0.004).all()
        assert left.any()
        np.testing.assert_array_equal(left, r.left_out)
        for joint in ("F", "M", "G", "T1", "T2"):
            np.testing.assert_array_equal(np.isnan(r[f"{joint}.fx"]), left)
            assert np.nanmax(r[f"{joint}.force"]) <= r.peak(f"{joint}.force")[0] * (1 + 1e-9)
        for name in r.stored:
            assert name.partition(".")[0] in ("F", "M", "G", "T1", "T2") or np.isfinite(r[name]).all()


def test_numbers_of_curves_leave_out_what_the_table_leaves_out():
    r = rt.loads(SCISSOR).simulate(0.8, t_eval=np.linspace(0.0, 0.8, 4001))

    def number(text):
        return evaluate(read(text, Known.of(r)), r)

    kept = ~r.left_out
    assert number("max(F.force)") == r.peak("F.force")[0]
    assert number("mean(F.force)") == pytest.approx(np.trapezoid(r["F.force"][kept], r.t[kept]) / 0.8, rel=1e-3)
    assert number("integral(F.fx)") == pytest.approx(np.trapezoid(r["F.fx"][kept], r.t[kept]), rel=1e-3)


BELL = """
[bodies.bell]
points = { C = [0, 0] }
mass = 1
inertia = 1
[joints.hang]
type = "revolute"
connect = ["ground.F", "bell.C"]
stop = { max = 0.3, contact = { model = "impact", restitution = 0.5 } }
[initial.bell]
omega = 2
"""


@pytest.mark.parametrize("rtol", [1e-6, 1e-8, 1e-10])
def test_a_run_with_impacts_passes_as_one_without(rtol):
    """Beside the scissor a bell strikes its stop at 0.15 s: nothing else changes."""
    alone = rt.loads(SCISSOR).simulate(0.8, t_eval=[0.0, 0.4, 0.8], rtol=rtol)
    r = rt.loads(SCISSOR + BELL).simulate(0.8, t_eval=[0.0, 0.4, 0.8], rtol=rtol)
    assert r.provenance["method"] == "event"
    assert r.success, r.message
    assert next(one.t for one in r.events if one.kind == "impact") == pytest.approx(0.15, abs=1e-9)
    assert r.trust.singular == pytest.approx(alone.trust.singular, abs=1e-5)
    for joint in ("F", "M", "G", "T1", "T2"):
        assert joint in r.trust.remarks()
        # they grow as 1/(t - t*); where the part left out begins is known to percent
        assert r.peak(f"{joint}.force")[0] == pytest.approx(alone.peak(f"{joint}.force")[0], rel=0.05)
    assert r["table.y"] == pytest.approx(alone["table.y"], abs=1e-5)


def test_a_position_that_is_nearly_singular_keeps_its_peak():
    # bars of 1 m and 1.0001 m: branches only come near each other, so that all forces are finite and determined
    m = windows(1).set({"bodies.c1.length": 1.002})
    ways = [m.simulate(0.6, t_eval=[0.0], rtol=rtol) for rtol in (1e-9, 1e-11)]
    assert all(r.success for r in ways), [r.message for r in ways]
    assert not any(r.trust.singular for r in ways)
    assert ways[0].peak("L1.force")[0] == pytest.approx(ways[1].peak("L1.force")[0], rel=1e-4)


PARALLELOGRAM = """
format = 1
gravity = [0, -9.81]
[ground.points]
O = [0, 0]
Q = [0.3, 0]
[bodies.crank]
bar = ["O", "A"]
length = 0.1
mass = 1
[bodies.coupler]
bar = ["A", "B"]
length = 0.3
mass = 1
[bodies.rocker]
bar = ["Q", "B"]
length = 0.1
mass = 1
[joints]
O = { type = "revolute", connect = ["ground.O", "crank.O"] }
A = { type = "revolute", connect = ["crank.A", "coupler.A"] }
B = { type = "revolute", connect = ["coupler.B", "rocker.B"] }
Q = { type = "revolute", connect = ["ground.Q", "rocker.Q"] }
[drivers.motor]
joint = "O"
angle = "PHASE deg + SPEED*t"
[initial]
coupler = { angle = 0 }
rocker = { angle = "PHASE deg" }
"""
DRIVEN_ISOSCELES = (
    ISOSCELES.replace('crank = { angle = "30 deg", omega = 9 }\n', "").replace("30 deg", "PHASE deg")
    + '[drivers.motor]\njoint = "O"\nangle = "PHASE deg + SPEED*t"\n'
)


@pytest.mark.parametrize("rtol", [1e-6, 2e-6, 1e-7, 1e-8, 1e-9, 1e-11])
@pytest.mark.parametrize(("speed", "phase"), [(5, 75), (6, 30), (7, 33), (7, 60), (10, 60), (13, 20), (20, 75)])
@pytest.mark.parametrize(("text", "first"), [(PARALLELOGRAM, 180), (DRIVEN_ISOSCELES, 90)])
def test_driven_motion_passes_and_names_every_singular_position(text, first, speed, phase, rtol):
    """Steps of a driven motion are longer than what its forces need: no stage need be near the instant."""
    m = rt.loads(text.replace("PHASE", str(phase)).replace("SPEED", str(speed)))
    r = m.simulate(0.55, t_eval=[0.0, 0.55], rtol=rtol)
    assert r.success, r.message
    instants = [np.radians(first + 180 * k - phase) / speed for k in range(8)]
    assert r.trust.singular == pytest.approx([t for t in instants if t < 0.55], abs=1e-5)
    # accelerations of some l w^2 on a few kg, and weights of 60 N: 1/(t - t*) is cut where the root is 0.03
    assert r.peak("O.force")[0] < 3e3 + 60 * speed**2


def test_coarse_steps_of_half_a_turn_name_every_singular_position():
    m = rt.loads(PARALLELOGRAM.replace("PHASE", "150").replace("SPEED", "7"))
    r = m.simulate(4.0, t_eval=[0.0, 4.0], rtol=1e-3)
    assert r.success, r.message
    instants = [np.radians(180 * k - 150) / 7 for k in range(1, 12)]
    assert r.trust.singular == pytest.approx([t for t in instants if t < 4.0], abs=1e-4)


def test_inverse_dynamics_leaves_out_the_forces_beside_branch_points():
    m = rt.loads(PARALLELOGRAM.replace("PHASE", "60").replace("SPEED", "10"))
    run = m.simulate(0.6, t_eval=np.linspace(0.0, 0.6, 601))
    r = m.inverse_dynamics(np.linspace(0.0, 0.6, 601))
    instants = [np.radians(180 * k - 60) / 10 for k in (1, 2)]
    assert r.trust.singular == pytest.approx(instants, abs=1e-6)
    left = np.isnan(r["O.force"])
    assert left.any()
    assert all(np.abs(r.t[left] - t).min() < 2e-3 for t in instants)
    # rods of some N w^2 l: what rounding makes of 0/0 is 20 kN
    assert np.nanmax(r["O.force"]) < 1.1 * run.peak("O.force")[0]
    assert not np.isnan(r["coupler.x"]).any()
    with pytest.raises(rt.InputError, match="not determined"):
        evaluate(read("at(O.force, 0.2094)", Known.of(r)), r)
