"""Restitution of velocities, of impulses and of work: closed forms, an incremental reference, and energy."""

import numpy as np
import pytest

import rattle as rt

LAWS = ("newton", "poisson", "energetic")


def struck(law, e, mu, spin=0.0, slide=-1.0, arm=(0.6, -0.8), inertia=0.08, corners=False) -> rt.Mechanism:
    """A rod of 1 kg whose end is about to hit rough ground below it with 1 m/s; no gravity.

    arm: the end, seen from the mass centre [m]; slide: speed of the end along the ground [m/s].  The ground is the
    lowest place of a bush of 1 m; or, with corners, the wall of a guide and the end a block of 0.1 mm with two corners.
    """
    x, y = arm
    above = -1 + 1e-7 - y  # a hit within a millionth of the clearance is one at once
    joint = """type = "revolute"
contact = { bush_radius = 1.000001, """
    if corners:
        joint = """type = "prismatic"
block = { length = 1e-4, height = 1e-4 }
contact = { """
    return rt.loads(f"""
format = 1
gravity = [0, 0]
[ground.points]
O = [0, 0]
[bodies.rod]
points = {{ P = [{x}, {y}] }}
mass = 1
inertia = {inertia}
[joints.tip]
connect = ["ground.O", "rod.P"]
clearance = 1
{joint}model = "impact", restitution = {e}, friction = {mu}, restitution_law = "{law}" }}
[initial]
rod = {{ x = {-x}, y = {above}, angle = 0, vx = {slide + spin * y}, vy = {-1 - spin * x}, omega = {spin} }}
""")


def after(m, arm=(0.6, -0.8), t=1e-7):
    """Velocity of the end after its one impact, at t = 0, and the sum of its percussions."""
    r = m.simulate(t, t_eval=[t], rtol=1e-10)
    assert r.success, r.message
    hits = [one for one in r.events if one.kind == "impact"]
    assert {one.t for one in hits} == {0.0}
    w, angle = r["rod.omega"][-1], r["rod.angle"][-1]
    x = arm[0] * np.cos(angle) - arm[1] * np.sin(angle)
    y = arm[0] * np.sin(angle) + arm[1] * np.cos(angle)
    return np.array([r["rod.vx"][-1] - w * y, r["rod.vy"][-1] + w * x]), sum(one.impulse for one in hits)


def incremental(e, mu, arm, inertia, slide, steps=400_000):
    """Darboux and Keller's equations in small increments of the normal impulse, ended by Stronge's work."""
    x, y = arm
    g = np.array([[1 + x * x / inertia, -x * y / inertia], [-x * y / inertia, 1 + y * y / inertia]])  # (n, t)
    rate, slip = -1.0, slide
    step = 3.0 / g[0, 0] / steps
    total, held, work, target = 0.0, 0.0, 0.0, None
    for _ in range(50 * steps):
        hold = -g[0, 1] / g[1, 1]
        if abs(slip) > 2 * mu * g[1, 1] * step:
            share = -mu * np.sign(slip)
        elif abs(hold) <= mu:
            share = hold - slip / (g[1, 1] * step)
        else:
            share = np.clip(hold, -mu, mu)
        old = rate
        rate += (g[0, 0] + g[0, 1] * share) * step
        slip += (g[0, 1] + g[1, 1] * share) * step
        total, held, work = total + step, held + share * step, work + 0.5 * (old + rate) * step
        if target is None and rate >= 0.0:
            target, work = -(e**2) * work, 0.0
        elif target is not None and work >= target:
            return np.array([slip, rate]), total, held
    raise AssertionError("the increments are too small")


def slider(n, e, law) -> rt.Mechanism:
    """n equal balls on a line that touch each other; the first comes in with 1 m/s."""
    text = "format = 1\ngravity = [0, 0]\n[ground.points]\nO = [0, 0]\n"
    joints, start = "", "[initial]\n"
    for k in range(n):
        text += f"[bodies.b{k}]\nmass = 1\ninertia = 1\npoints = {{ P = [0, 0] }}\n"
        joints += f'[joints.g{k}]\ntype = "prismatic"\nconnect = ["ground.O", "b{k}.P"]\naxis = 0\nangle = 0\n'
        start += (
            f"b{k} = {{ x = {-1e-3 * k - (1e-6 if k == 0 else 0)}, y = 0, angle = 0, vx = {1.0 if k == 0 else 0.0} }}\n"
        )
    for k in range(n - 1):
        joints += f"""[joints.c{k}]
type = "revolute"
connect = ["b{k + 1}.P", "b{k}.P"]
clearance = 1e-3
contact = {{ model = "impact", restitution = {e}, restitution_law = "{law}" }}
"""
    return rt.loads(text + joints + start)


# ---------------------------------------------------------------- where all laws agree
@pytest.mark.parametrize("e", [0.0, 0.4, 1.0])
def test_laws_agree_without_friction_at_one_contact(e):
    found = [after(struck(law, e, 0.0, spin=3.0))[0] for law in LAWS]
    assert found[0][1] == pytest.approx(e, abs=1e-5)  # the arm turns on between impact and output
    assert found[1] == pytest.approx(found[0], abs=1e-12)
    assert found[2] == pytest.approx(found[0], abs=1e-12)
