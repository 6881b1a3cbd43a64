"""Lasting rigid contacts let go when their force says, however short that is against a step."""

import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import rattle as rt
from rattle.solvers.nonsmooth import event_search
from rattle.solvers.peaks.samples import sample_arrays


def pressed(share, w):
    """1 kg in a vertical slot, pressed onto its wall by 10 kN (1 + share cos(w t)), with no gravity."""
    return rt.loads(f"""
format = 1
gravity = [0, 0]
[ground.points]
O = [0, 0]
[bodies.mass]
points = {{ P = [0, 0] }}
mass = 1
inertia = 1e-3
[joints.track]
type = "prismatic"
connect = ["ground.O", "mass.P"]
axis = "90 deg"
[joints.wall]
type = "revolute"
connect = ["ground.O", "mass.P"]
clearance = 0.001
contact = {{ model = "impact", restitution = 0, friction = 0 }}
[loads.press]
type = "force"
at = "mass.P"
force = [0, "-1e4*(1 + {share}*cos({w}*t))"]
[initial.mass]
x = 0
y = -0.001
vx = 0
""")


@pytest.mark.parametrize("rtol", [1e-3, 1e-6, 1e-10])
@pytest.mark.parametrize(("share", "w"), [(1.02, 300.0), (1.001, 300.0), (1.02, 2500.0), (1.0001, 8.0)])
def test_a_contact_lets_go_as_often_as_its_load_turns_however_short_and_long_the_steps(share, w, rtol):
    # N = 1e4 (1 + share cos(w t)) is below zero for 2 to 6 % of a turn, or less; nothing moves before, so that steps
    # would go to the end of the run.  It flies for three times as long or so and lands without a bounce.  Ends of loose
    # steps beyond the wall are no states of the run: the work of 10 kN over their error may exceed its few mJ.
    first = (math.pi - math.acos(1.0 / share)) / w
    true = np.arange(first, 6.5 * math.pi / w, 2.0 * math.pi / w)
    assert len(true) == 3
    r = pressed(share, w).simulate(6.5 * math.pi / w, rtol=rtol, t_eval=[0.0, 6.5 * math.pi / w])
    assert r.success or (rtol == 1e-3 and "energy error" in r.message and "smaller rtol" in r.message), r.message
    released = [event.t for event in r.events if event.kind == "release"]
    assert len(released) == 3 or (not r.success and len(released) == 2)
    assert released == pytest.approx(true[: len(released)], rel=1e-9)


@pytest.mark.parametrize("rtol", [1e-4, 1e-7, 1e-11])
@pytest.mark.parametrize("share", [2.1, 3.0, 4.0, 4.9])
def test_pin_that_runs_up_its_bush_too_slowly_leaves_it_where_gravity_alone_turns_it(share, rtol):
    # v^2 = share g c at the bottom, v^2 = (share - 2 (1 + s)) g c at the height s c, N = m (v^2 / c - g s): it
    # vanishes at s = (share - 2) / 3
    c, g = 0.1, 9.81
    model = rt.loads(f"""
format = 1
gravity = [0, {-g}]
[ground.points]
O = [0, 0]
[bodies.pin]
mass = 2
inertia = 1e-3
points = {{ P = [0, 0] }}
[joints.bush]
type = "revolute"
connect = ["ground.O", "pin.P"]
clearance = {c}
contact = {{ model = "impact", restitution = 0, friction = 0 }}
[initial]
pin = {{ x = 0, y = {-c}, vx = {math.sqrt(share * g * c)}, omega = 0 }}
""")
    r = model.simulate(0.5, rtol=rtol)
    first = next(one.t for one in r.events if one.kind == "release")
    at = model.simulate(0.5, rtol=rtol, t_eval=[first])
    assert at["pin.y"][0] == pytest.approx(c * (share - 2.0) / 3.0, abs=max(1e3 * rtol, 1e-9) * c)


def hanging(pins, friction):
    """Links of 0.2 m below each other, a little bent, each pin at the bottom of its bush."""
    lines = ["format = 1", "gravity = [0, -9.81]", "[ground.points]", "G = [0, 0]"]
    joints, start, x, y, play = [], ["[initial]"], 0.0, 0.0, 1e-3
    for k in range(pins):
        lines += [f"[bodies.b{k}]", "mass = 0.5", "inertia = 1.7e-3", "points = { T = [-0.1, 0], B = [0.1, 0] }"]
        joints += [f"[joints.p{k}]", 'type = "revolute"', f"clearance = {play}"]
        joints += [f'connect = ["{f"b{k - 1}.B" if k else "ground.G"}", "b{k}.T"]']
        joints += [f'contact = {{ model = "impact", restitution = 0.3, friction = {friction}, bush_radius = 0.01 }}']
        angle = 0.4 * math.cos(1.3 * k) - math.pi / 2
        x, y = x + 0.1 * math.cos(angle), y - play + 0.1 * math.sin(angle)
        start += [f"b{k} = {{ x = {x!r}, y = {y!r}, angle = {angle!r}, vx = 0, vy = 0, omega = 0 }}"]
        x, y = x + 0.1 * math.cos(angle), y + 0.1 * math.sin(angle)
    return rt.loads("\n".join([*lines, *joints, *start]))


def test_a_chain_of_pins_turns_and_sticks_at_the_same_instants_at_any_tolerance_and_output():
    # 1e-11 is the reference; a pin at the end of the chain that hardly presses may turn in its noise: the first six
    chain, end = hanging(12, 0.1), 0.03
    fine, coarse, often = (
        chain.simulate(end, rtol=rtol, t_eval=np.linspace(0.0, end, count))
        for rtol, count in ((1e-11, 2), (1e-7, 2), (1e-7, 201))
    )

    def found(r):
        some = [one for one in r.events if one.kind in ("stick", "slip") and int(one.joint[1:]) < 6]
        return [(one.joint, one.kind) for one in some], [one.t for one in some]

    assert len(found(fine)[0]) > 8
    for r in (coarse, often):
        assert r.success
        assert found(r)[0] == found(fine)[0]
        assert found(r)[1] == pytest.approx(found(fine)[1], abs=1e-6)  # s; rtol 1e-7, rates of 10 rad/s
    for joint in ("p0", "p3", "p11"):
        assert often.peak(f"{joint}.force")[0] == pytest.approx(fine.peak(f"{joint}.force")[0], rel=1e-5)


def test_moment_of_a_smooth_pin_is_rounding_and_its_force_has_its_peak():
    r = hanging(4, 0.0).simulate(0.05, t_eval=[0.0, 0.05])
    fine = hanging(4, 0.0).simulate(0.05, t_eval=np.linspace(0.0, 0.05, 20001))
    for k in range(4):
        sampled = np.hypot(fine[f"p{k}.fx"], fine[f"p{k}.fy"]).max()
        assert r.peak(f"p{k}.force")[0] == pytest.approx(sampled, rel=1e-5)  # 2.5 us between samples
        assert r.peak(f"p{k}.moment")[0] < 1e-12 * sampled


def test_contact_that_lets_go_takes_none_with_it_that_still_presses_however_hard_it_once_did():
    """A blow long ago is no measure of what a contact presses now: only the pin that is pulled up lets go."""
    text = "format = 1\ngravity = [0, -9.81]\n[ground.points]\nG = [0, 0]\n"
    contact = '{ model = "impact", restitution = 0, friction = 0.3, bush_radius = 0.01 }'
    for n, pull in (("a", 0.0), ("b", 2.0)):
        text += f'[bodies.{n}]\nmass = 1\ninertia = 0.01\npoints = {{ C = [0, 0] }}\n[drivers.d{n}]\nbody = "{n}"\n'
        text += f'coordinate = "angle"\nangle = 0\n[joints.j{n}]\ntype = "revolute"\nconnect = ["ground.G", "{n}.C"]\n'
        text += f'clearance = "1 mm"\ncontact = {contact}\n[loads.l{n}]\ntype = "force"\nat = "{n}.C"\n'
        text += f'force = [0, "-1e10*exp(-((t - 0.1)/0.005)**2) + {pull}*9.81*t/0.3"]\n'
    text += "[initial]\n" + "".join(
        f"{n} = {{ x = 0, y = -1e-3, angle = 0, vx = 0, vy = 0, omega = 0 }}\n" for n in "ab"
    )
    run = rt.loads(text).simulate(0.17)
    assert run.success, run.message
    assert [(e.joint, e.kind) for e in run.events if e.kind in ("impact", "release")] == [("jb", "release")]
    assert run.events[-1].t == pytest.approx(0.15, rel=1e-9)
    assert run["ja.normal"][-1] == pytest.approx(9.81, rel=1e-9)
    # m y'' = m g (2 t / 0.3 - 1) from rest at 0.15 s
    assert run["b.y"][-1] + 1e-3 == pytest.approx(9.81 * 2 / 0.3 * 0.02**3 / 6, rel=1e-6)


def test_peaks_and_mean_squares_of_steps_that_events_cut_are_those_of_the_motion():
    chain, end = hanging(6, 0.1), 0.05
    r = chain.simulate(end, t_eval=[0.0, end])
    assert len(r.events) > 15
    fine = chain.simulate(end, t_eval=np.linspace(0.0, end, 20001))  # 2.5 us apart, in which forces change by 1e-3
    for k in range(6):
        force = np.hypot(fine[f"p{k}.fx"], fine[f"p{k}.fy"])
        assert r.peak(f"p{k}.force")[0] == pytest.approx(force.max(), rel=1e-5)
        square = np.trapezoid(force**2, fine.t) / end
        assert r.rms(f"p{k}.force") == pytest.approx(math.sqrt(square), rel=1e-5)


def test_friction_that_is_rounding_ends_no_step():
    # from rest the far end of a bent chain falls nearly freely: loads fade by half from pin to pin, to 1e-13 N
    r = hanging(60, 0.1).simulate(0.1, t_eval=[0.0, 0.1])
    assert r.success
    assert r.stats["steps"] < len(r.events) + 60  # the events, and what a chain of 12 pins takes between them


@pytest.mark.nojit
@pytest.mark.parametrize("fine_up_to", np.arange(1, 128) / 128)
def test_looks_beyond_those_that_are_kept_leave_no_stretch_of_a_step_unseen(fine_up_to, monkeypatch):
    """Stretches are halved to 1/128 of the step up to some share of it: more looks than there is room for."""
    stretches = []

    def look(m, t, h, share, row):
        assert row < event_search.LOOKS_KEPT
        m.looks[row, 0] = share

    def dip(m, i, count):
        return m.looks[i + 1, 0] - m.looks[i, 0] > (1 / 128 if m.looks[i, 0] < fine_up_to else 1.0)

    def between(m, t, h, i, best, who, what, guided):
        stretches.append((m.looks[i, 0], m.looks[i + 1, 0]))
        return best, who, what

    for name, other in (
        ("look", look), ("something_may_dip", dip), ("first_between", between), ("gauge", lambda *_: None),
        *((name, getattr(event_search, name).python)
          for name in ("move_looks", "make_room", "look_at_place", "note_largest")),
    ):  # fmt: skip
        monkeypatch.setattr(event_search, name, other)
    m = SimpleNamespace(
        contact=np.zeros((0, 15), np.int64), mode=np.zeros(0), contact_memory=np.zeros((0, 13)),
        looks=np.zeros((event_search.LOOKS_KEPT, 2)), tally=np.zeros(20, np.int64), **sample_arrays(None),
    )  # fmt: skip
    event_search.first_change.python(m, 0.0, 1.0, 0.0, 1.0, len(event_search.PLACES), 1.0, -1, 0)
    seen = 0.0
    for left, right in sorted(stretches):
        assert left <= seen
        assert right - left <= 1 / 128 or left >= fine_up_to
        seen = right
    assert seen == 1.0


@pytest.mark.parametrize("rtol", [1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11])
def test_a_slip_that_nearly_ends_as_it_reverses_does_not_change_modes_without_end(rtol):
    m = rt.load(Path(__file__).parents[1] / "data" / "pins_that_reverse.toml")
    for end in (0.0019, 0.003, 0.01):
        run = m.simulate(end, rtol=rtol, t_eval=[0.0, end])
        assert run.success, run.message


BLOCK = """
format = 1
parameters = {{ since = {since}, mu = 0.2 }}
gravity = ["{along}*{ramp}", "{across}*{ramp}"]
ground.points = {{ F = [0, 0] }}
bodies.b = {{ points = {{ C = [0, -0.05], P = [-0.1, -0.05], Q = [0.1, -0.05] }}, mass = 1, inertia = 0.005 }}
initial.b = {{ x = 0, y = 0.05, angle = 0, vx = 0, vy = 0, omega = 0 }}
[joints.floor]
type = "surface"
connect = ["ground.F", "b.C"]
axis = "0 deg"
corners = ["P", "Q"]
contact = {{ model = "impact", restitution = 0.3, friction = "mu" }}
"""


@pytest.mark.parametrize(
    ("ramp", "way"),  # way: of a unit of acceleration in 0.3 s
    [
        ("max(0, t - since)", 0.3**3 / 6.0),
        ("max(0, t - since)**2", 0.3**4 / 12.0),
        ("(1 - cos(30*max(0, t - since)))", 0.3**2 / 2.0 - (1.0 - math.cos(9.0)) / 900.0),  # rounding for a while
    ],
)
@pytest.mark.parametrize("since", [0.0, 0.137])
@pytest.mark.parametrize(("along", "across"), [(3, -9), (1, -9), (-9, -2), (3, 9)])
def test_a_block_that_nothing_presses_slides_sticks_or_flies_when_gravity_begins(ramp, way, since, along, across):
    """It lies on its floor without any force; force and friction begin at once."""
    end = 0.3
    m = rt.loads(BLOCK.format(since=since, along=along, across=across, ramp=ramp))
    r = m.simulate(since + end, t_eval=[0.0, since + end], rtol=1e-9)
    assert r.success, r.message
    pressed = max(0.0, -across)
    slides = max(0.0, abs(along) - 0.2 * pressed)
    assert r["b.x"][-1] == pytest.approx(np.sign(along) * slides * way, rel=1e-6, abs=1e-10)
    assert r["b.y"][-1] == pytest.approx(0.05 + max(0.0, across) * way, rel=1e-9)
    assert abs(r["b.angle"][-1]) < 1e-9
    assert not [event for event in r.events if event.kind == "impact"]
