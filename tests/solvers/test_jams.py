"""Jams by friction: passed where slip can end at once, said where bodies that no force makes slip are pushed on."""

import math
import re
from types import SimpleNamespace

import numpy as np
import pytest

import rattle as rt
from rattle.analyses.dynamics.nonsmooth_run import ImpactRun
from rattle.equations.complementarity import BACKWARD, FORWARD, STICK
from rattle.jit import layout as at
from rattle.solvers.nonsmooth import jams

BORE, ARM, COUPLER = 0.01, 0.1, 0.3


def parallelogram(play, friction, jam="impact", loose="C"):
    """A driven parallelogram with a loose pin: where its bars are in line, its coupler and rocker may lock."""
    text = "format = 1\n[ground.points]\nA = [0, 0]\nD = [0.3, 0]\n"
    for name, ends, length, mass in (
        ("crank", "AB", ARM, 0.2),
        ("coupler", "BC", COUPLER, 0.5),
        ("rocker", "DC", ARM, 0.2),
    ):
        text += f'[bodies.{name}]\nbar = ["{ends[0]}", "{ends[1]}"]\nlength = {length}\nmass = {mass}\n'
    contact = f'model = "impact", bush_radius = {BORE}, restitution = 0.5, friction = {friction}, jam = "{jam}"'
    pins = (("A", "ground", "crank"), ("D", "ground", "rocker"), ("B", "crank", "coupler"), ("C", "coupler", "rocker"))
    for name, one, other in pins:
        text += f'[joints.{name}]\ntype = "revolute"\nconnect = ["{one}.{name}", "{other}.{name}"]\n'
        text += f"clearance = {play}\ncontact = {{ {contact} }}\n" if name in loose else ""
    text += '[drivers.m]\njoint = "A"\nangle = "0.7 + 10*t"\n'
    return rt.loads(text + "[initial]\ncoupler = { angle = 0 }\nrocker = { angle = 0.7 }\n")


@pytest.mark.parametrize(("play", "friction"), [(1e-3, 0.3), (1e-3, 0.6), (3e-4, 0.6)])
def test_loose_parallelogram_passes_its_change_points_by_impacts_that_end_slip(play, friction):
    mechanism = parallelogram(play, friction)
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


def test_dead_end_that_friction_holds_is_named_with_its_joint():
    mechanism = parallelogram(1e-4, 0.6)
    run = mechanism.simulate(1.0, rtol=1e-8)
    assert not run.success
    assert "friction holds 'C'" in run.message
    assert "dead end" in run.message
    assert "step" not in run.message
    end = float(re.search(r"t = ([\d.]+) s", run.message).group(1))
    last = mechanism.simulate(end - 1e-9, rtol=1e-8, t_eval=[end - 1e-9])
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
    run = ImpactRun.__new__(ImpactRun)
    run.system = parallelogram(1e-3, 0.3, loose="CD").system
    contact, lines = run.system.arrays["contact"], np.eye(4)
    lines[0, 3] = lines[3, 0] = lines[1, 2] = lines[2, 1] = -1.0
    values = run.system.arrays["values"].copy()
    arrays = {"mode": np.array([FORWARD, FORWARD]), "chosen": np.arange(2), "delassus": lines, "values": values}
    run.memory = SimpleNamespace(**arrays)
    monkeypatch.setattr(jams, "lock_share", lambda handle, t: 1.0 + lines[0, 1])  # that of each alone: G_nt of its own
    for friction, together in ((0.5, False), (0.999, False), (1.0, True)):
        values[contact[:, at.NORMAL_P] + 2] = friction
        assert run._firmness() == pytest.approx(1.0 - friction, abs=1e-12)
        assert run._locks(0.0) == together
    run.memory.mode[1] = BACKWARD  # (1, mu; -mu, 1): firm, whatever the friction
    assert run._firmness() == pytest.approx(math.sqrt(2.0), rel=1e-12)
    run.memory.mode[:] = STICK  # nothing slides, nothing locks
    assert not run._locks(0.0)
