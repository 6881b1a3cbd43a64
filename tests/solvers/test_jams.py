"""Jams by friction: passed where slip can end at once, said where bodies that no force makes slip are pushed on."""

import math
import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import rattle as rt
from linkages import BORE, loose_parallelogram
from rattle.analyses.dynamics.contact_trouble import firmness, friction_locks
from rattle.equations.complementarity import BACKWARD, FORWARD, STICK
from rattle.jit import layout as at
from rattle.solvers.nonsmooth import jams

DATA = Path(__file__).parents[1] / "data"


@pytest.mark.parametrize(("play", "friction"), [(1e-3, 0.3), (1e-3, 0.6), (3e-4, 0.6)])
def test_loose_parallelogram_passes_its_change_points_by_impacts_that_end_slip(play, friction):
    mechanism = loose_parallelogram(play, friction)
    run = mechanism.simulate(1.0, rtol=1e-8)
    assert run.success, run.message
    assert run.trust.energy_balance < 1e-5  # of the 1 J that goes round; before a jam forces reach 1e11 N
    jam = next(e.t for e in run.events if e.kind == "impact" and e.normal_speed < 1e-9 and e.energy_lost > 1e-6)
    near = mechanism.simulate(jam + 1e-5, rtol=1e-8, t_eval=jam + np.array([-1e-6, -5e-7, 1e-6, 2e-6]))
    slip = []
    for k in (0, 2):  # rates of the centre of the pin round that of the bush, then of their surfaces at the contact
        turned = np.diff(np.unwrap(np.arctan2(near["C.ey"], near["C.ex"])[k : k + 2])) / np.diff(near.t[k : k + 2])
        pin, bush = near["rocker.omega"][k : k + 2].mean(), near["coupler.omega"][k : k + 2].mean()
        slip.append(abs(float(play * turned[0] + (BORE - play) * pin - BORE * bush)))
    assert slip[0] > 0.01
    assert slip[1] < 1e-3 * slip[0]
    assert np.hypot(near["C.ex"], near["C.ey"]) == pytest.approx(play, rel=1e-9)  # closed before and after


@pytest.mark.parametrize("rtol", [1e-6, 1e-7, 3e-8, 1e-8, 1e-9])  # whatever ends it there: steps, modes or energy
def test_dead_end_that_friction_holds_is_named_at_any_tolerance(rtol):
    run = loose_parallelogram(1e-4, 0.6).simulate(1.0, rtol=rtol)
    assert not run.success
    assert "friction holds 'C'" in run.message
    assert "dead end" in run.message
    assert "step" not in run.message


def test_dead_end_that_friction_holds_lies_in_the_cone():
    mechanism = loose_parallelogram(1e-4, 0.6)
    run = mechanism.simulate(1.0, rtol=1e-9)
    end = float(re.search(r"t = ([\d.]+) s", run.message).group(1))
    last = mechanism.simulate(end - 1e-9, rtol=1e-9, t_eval=[end - 1e-9])
    # the point of contact is on the line from pin B to pin D, so the distance of B and D cannot grow unless it slips;
    # and that line is within the cone of friction: no force along it makes the contact slip
    offset = np.array([last["C.ex"][0], last["C.ey"][0]])
    normal = offset / np.hypot(*offset)
    touching = np.array([last["coupler.C.x"][0], last["coupler.C.y"][0]]) + BORE * normal
    b = np.array([last["coupler.B.x"][0], last["coupler.B.y"][0]])
    line = np.array([0.3, 0.0]) - b
    line /= np.hypot(*line)
    away = touching - b
    assert abs(line[0] * away[1] - line[1] * away[0]) < 1e-5  # m, of bars of 0.1 and 0.3 m
    assert 0.4 < math.acos(abs(line @ normal)) < math.atan(0.6)


def test_contacts_that_lock_together_are_told_though_each_alone_would_not(monkeypatch):
    """Each is pushed open by friction of the other alone: (1, -mu; -mu, 1) N is what the forces part them by."""
    system = loose_parallelogram(1e-3, 0.3, loose="CD").system
    contact, lines = system.arrays["contact"], np.eye(4)
    lines[0, 3] = lines[3, 0] = lines[1, 2] = lines[2, 1] = -1.0
    values = system.arrays["values"].copy()
    arrays = {"mode": np.array([FORWARD, FORWARD]), "active": np.arange(2), "delassus": lines, "values": values}
    workspace = SimpleNamespace(**arrays)
    monkeypatch.setattr(jams, "lock_share", lambda handle, t: 1.0 + lines[0, 1])  # that of each alone: G_nt of its own
    for friction, together in ((0.5, False), (0.999, False), (1.0, True)):
        values[contact[:, at.NORMAL_P] + 2] = friction
        assert firmness(system, workspace) == pytest.approx(1.0 - friction, abs=1e-12)
        assert friction_locks(system, workspace, 0.0) == together
    workspace.mode[1] = BACKWARD  # (1, mu; -mu, 1): firm, whatever the friction
    assert firmness(system, workspace) == pytest.approx(math.sqrt(2.0), rel=1e-12)
    workspace.mode[:] = STICK  # nothing slides, nothing locks
    assert not friction_locks(system, workspace, 0.0)


MU, COS, SIN = 1.6, math.cos(math.radians(55)), math.sin(math.radians(55))
FREE = np.array([[1 + 3 * COS**2, 3 * COS * SIN], [3 * COS * SIN, 1 + 3 * SIN**2]])  # of the end of a rod of 2 m, 1 kg


def pulled_rod(sense):
    """A tilted rod stands on the bottom of a bush with 1 N and is pulled along it more and more, all in balance."""
    pin, bush = 0.009, 0.01
    force = f"{sense * MU / 0.1} * t"
    return rt.loads(f"""
format = 1
gravity = [0, 0]
[ground.points]
O = [0, 0]
[bodies.rod]
points = {{ P = [{COS}, {pin - SIN}], M = [0, 0] }}
mass = 1
inertia = {1 / 3}
[joints.end]
type = "revolute"
connect = ["ground.O", "rod.P"]
clearance = {bush - pin}
contact = {{ model = "impact", restitution = 0, friction = {MU}, bush_radius = {bush} }}
[loads.push]
type = "force"
at = "rod.M"
force = ["{force}", -1]
[loads.balance]
type = "torque"
body = "rod"
torque = "{SIN} * {force} - {COS}"
[initial]
rod = {{ x = {-COS}, y = {SIN - bush}, angle = 0, vx = 0, vy = 0, omega = 0 }}
""")


def on_springs(sense, t_end):
    """Gap and slip [m] of that rod's end on stiff springs, the one along the wall with a slider, in small steps."""
    stiff, damping, h = 1e9, 1e4, 4e-7
    place, speed, stretch, t = np.array([-1 / stiff, 0.0]), np.zeros(2), sense * MU * 0.98 / stiff, 0.098
    while t < t_end:
        press = max(0.0, -stiff * place[0] - damping * speed[0])
        stretch = min(max(stretch + h * speed[1], -MU * press / stiff), MU * press / stiff)
        load = np.array([-1.0, sense * MU * t / 0.1])  # what holds 1 N and T = -load in balance
        speed += h * (FREE @ (np.array([press, -stiff * stretch]) + load))
        place += h * speed
        t += h
    return place


def test_end_that_friction_would_lock_as_it_slips_lifts_off_when_it_breaks_away():
    """Sticking and sliding are solutions before, none of them after: of both that are left one turns back at once."""
    run = pulled_rod(1.0).simulate(0.105, rtol=1e-9)
    assert run.success, run.message
    assert [e.kind for e in run.events if e.t > 0.0 and e.kind != "contact"] == ["release"]
    assert run.events[-1].t == pytest.approx(0.1, rel=1e-6)
    later, lift = 0.005, -float((FREE @ [1.0, -MU])[0])  # rate of the gap with no force, from balance with 1 N
    assert lift > 0.0
    assert run["rod.y"][-1] - run["rod.y"][0] == pytest.approx(-0.5 * later**2, rel=1e-5)
    moment, growth = SIN * MU - COS, SIN * MU / 0.1
    turned = 3 * (moment * later**2 / 2 + growth * later**3 / 6)
    assert run["rod.angle"][-1] == pytest.approx(turned, rel=1e-5)
    gap = on_springs(1.0, 0.105)[0]
    # 5 ms later; the springs let go 0.2 ms late or so, by which a way that grows with t^2 is 2 x 4 % too short
    assert gap == pytest.approx(lift * later**2 / 2 + float(FREE[0, 1]) * MU / 0.1 * later**3 / 6, rel=0.12)
    assert gap < lift * later**2 / 2 + float(FREE[0, 1]) * MU / 0.1 * later**3 / 6


def test_end_that_friction_does_not_lock_slips_when_it_breaks_away():
    run = pulled_rod(-1.0).simulate(0.105, rtol=1e-9)
    assert run.success, run.message
    assert [(e.kind, round(e.t, 6)) for e in run.events if e.t > 0.0] == [("slip", 0.1)]
    gap, slip = on_springs(-1.0, 0.105)
    assert abs(gap) < 2e-6  # the spring itself
    end = run["rod.x"][-1] + COS * math.cos(run["rod.angle"][-1]) + SIN * math.sin(run["rod.angle"][-1])
    assert end == pytest.approx(slip, rel=0.02)  # the springs let go a little late


@pytest.mark.parametrize("rtol", [1e-8, 1e-10])
def test_steps_that_collapse_before_a_jam_end_the_run_with_its_name(rtol):
    # the normal force grows as one over the time that is left, so that steps shrink and never get there
    run = rt.load(DATA / "pins_that_jam.toml").simulate(0.03, rtol=rtol, t_eval=[0.0, 0.03])
    assert not run.success
    assert "the normal force grows without bound" in run.message
    assert run.stats["steps"] < 20_000
