"""Geneva drive: slots with mouths and a locking disc turn the wheel by one slot per turn of the crank and hold it."""

import math

import matplotlib.pyplot as plt
import numpy as np
import pytest

import rattle as rt
from rattle.plots.sketch import draw_at

nojit = pytest.mark.nojit
CRANK, SPEED, PLAY = 0.05, 4 * math.pi, 1e-4  # [m], [rad/s], of slots and disc [m]
WIDTH = 3.1e-3  # half the width of a slot [m]
RIGID = "model = 'impact', restitution = 0.2"
SOFT = "model = 'flores', restitution = 0.4, stiffness = 1e10"


class Geneva:
    """Dimensions of a drive with n slots."""

    def __init__(self, n):
        self.n = n
        self.axes, self.rim = CRANK / math.sin(math.pi / n), CRANK / math.tan(math.pi / n)
        self.disc = (0.6 if n > 3 else 0.7) * CRANK
        self.deep = self.axes - CRANK

    @property
    def horn(self):
        """Angle beta of the horns of an arc, seen from the disc [rad]."""
        r = self.disc + PLAY
        return math.acos((self.axes**2 + r**2 - self.rim**2) / (2 * r * self.axes))

    @property
    def play(self):
        """Angle by which the wheel may turn between its horns, to either side [rad]; with slots: whatever is larger."""
        return PLAY / (self.axes * math.sin(self.horn))

    def model(self, law=RIGID, sense=1, friction=0.0, drag="0", begin=None, driver="", slots=True):
        """begin: angle of the crank at the start, from the line of the axes [rad]; the pin then enters a slot."""
        n, middle, step = self.n, 0.5 * (self.rim + self.deep), 2 * math.pi / self.n
        begin = -sense * (math.pi / 2 - math.pi / n) if begin is None else begin
        spots = ", ".join(f"S{k} = [{middle * math.cos(k * step)}, {middle * math.sin(k * step)}]" for k in range(n))
        rubs = f", friction = {friction}" if friction else ""
        text = f"""
format = 1
[ground.points]
O = [0, 0]
W = [{self.axes}, 0]
[bodies.crank]
points = {{ O = [0, 0], P = [{CRANK}, 0] }}
mass = 0.3
inertia = 2e-4
[bodies.wheel]
points = {{ W = [0, 0], {spots} }}
mass = 0.6
inertia = 2e-3
[joints.axis]
type = "revolute"
connect = ["ground.O", "crank.O"]
[joints.shaft]
type = "revolute"
connect = ["ground.W", "wheel.W"]
[joints.lock]
type = "locking-disc"
connect = ["crank.O", "wheel.W"]
radius = {self.disc}
arcs = {n}
axle_distance = {self.axes}
rim = {self.rim}
play = {PLAY}
contact = {{ {law}{rubs} }}
[drivers.motor]
joint = "axis"
angle = "{driver or f"{sense * SPEED}*t + {begin}"}"
[loads.drag]
type = "torque"
body = "wheel"
torque = "{drag}"
[initial]
wheel = {{ angle = {math.pi + sense * math.pi / n}, omega = 0 }}
"""
        for k in range(n) if slots else ():
            text += f"""
[joints.slot{k}]
type = "slot"
connect = ["wheel.S{k}", "crank.P"]
axis = {k * step}
length = {self.rim - self.deep + 2 * PLAY}
open = true
clearance = {PLAY}
contact = {{ {law}{rubs}, bush_radius = {WIDTH} }}
"""
        return rt.loads(text)

    def angle(self, crank):
        """Turn of the wheel from its first dwell [rad] for the angle of the crank (n,) from where a pin enters."""
        half = math.pi / 2 - math.pi / self.n
        turns, rest = np.divmod(crank + 1e-9, 2 * math.pi)
        a = np.minimum(rest, 2 * half) - half
        m = self.axes / CRANK
        return turns * 2 * math.pi / self.n + np.arctan2(np.sin(a), m - np.cos(a)) + math.pi / self.n


def follows(drive, r, sense, share=1.0, loose=1.0):
    """The wheel goes as the closed form says, within what slots and disc leave it; in the dwell within the disc's.

    loose: a wheel that a load presses on comes into its slot this much later, over the round corner of its mouth.
    """
    crank = SPEED * r.t
    expected = -sense * drive.angle(crank)
    off = abs(r["wheel.angle"] - r["wheel.angle"][0] - expected)
    nearest = drive.deep / drive.rim  # where the pin is nearest to the axis the same play is a larger angle
    in_slot = (PLAY + 2 * PLAY) / drive.rim / nearest
    half = math.pi - 2 * math.pi / drive.n
    rest = crank % (2 * math.pi)
    held = (rest > half + drive.horn) & (rest < 2 * math.pi - drive.horn)  # both horns of the arc are on the disc
    assert held.any()
    assert off[held].max() <= share * 2 * drive.play
    assert off.max() <= loose * share * max(in_slot, 4 * drive.play)


HOW = {"event": (RIGID, {}), "stepped": (RIGID, {"method": "moreau"}), "compliant": (SOFT, {})}


@pytest.mark.parametrize("n", [3, 4, 5, 6, 8])
@pytest.mark.parametrize("how", HOW)
def test_a_wheel_is_turned_by_one_slot_per_turn_and_held_in_between(n, how):
    law, settings = HOW[how]
    drive, sense = Geneva(n), 1 if n % 2 else -1
    r = drive.model(law, sense, friction=0.05).simulate(3 * 2 * math.pi / SPEED, **settings)
    assert r.success, r.message
    follows(drive, r, sense, 1.1 if how == "compliant" else 1.0)
    assert not [note for note in r.trust.notes if "apart" in note]


def test_ten_turns_take_few_steps():
    """Slots that the pin is far from cost no steps: about 60 per turn, with four series of bounces in each two."""
    r = Geneva(4).model(friction=0.05).simulate(10 * 2 * math.pi / SPEED)
    assert r["wheel.angle"][0] - r["wheel.angle"][-1] == pytest.approx(5 * math.pi, abs=0.01)
    assert r.stats["steps"] < 2000
    assert r.stats["evaluations"] < 60_000


@pytest.mark.parametrize("drag", ["0.5", "-0.5", "-0.5*tanh(wheel.omega/0.01)"])
def test_a_loaded_wheel_is_turned_too(drag):
    drive = Geneva(4)
    r = drive.model(drag=drag).simulate(2.9 * 2 * math.pi / SPEED)  # up to the dwell after the third engagement
    assert r.success, r.message
    follows(drive, r, 1, loose=2.0)


@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize("law", [RIGID, SOFT])
def test_a_horn_on_the_disc_holds_a_moment_about_the_wheel_and_none_about_the_disc(law, sense):
    """The wheel leans on one horn: N = M/(C sin beta), along the line from the axis of the disc to the horn."""
    drive, moment, elastic = Geneva(4), 2.0, law == SOFT
    m = drive.model(law, drag=f"{sense * moment}", driver=f"{math.pi} + 0*t")
    r = m.simulate(1.0, method="moreau") if not elastic else m.simulate(0.3)
    assert r.success, r.message
    turned = r["wheel.angle"][-1] - r["wheel.angle"][0]
    assert turned == pytest.approx(sense * drive.play, rel=0.05)
    assert r["lock.normal"][-1] == pytest.approx(moment / (drive.axes * math.sin(drive.horn)), rel=0.02)
    assert r["motor.torque"][-1] == pytest.approx(0.0, abs=1e-6)


def test_the_disc_lets_the_wheel_go_while_a_pin_drives_it():
    """Without slots, and the crank in the middle of an engagement, a moment turns the wheel freely for a while."""
    drive = Geneva(4)
    r = drive.model(drag="0.1", driver="0*t", slots=False).simulate(0.05)
    assert r["wheel.angle"][-1] - r["wheel.angle"][0] == pytest.approx(0.5 * 0.1 / 2e-3 * 0.05**2, rel=1e-6)


@nojit
@pytest.mark.parametrize(
    ("words", "changes"),
    [
        ("expected a whole number of at least 3", {"joints.lock.arcs": 2}),
        ("rim must be more than", {"joints.lock.rim": 0.2}),
        ("must be less than 180 deg", {"joints.lock.opening": 3.2}),
        ("a locking disc needs a contact that acts", {"joints.lock.contact": "ideal"}),
        ("less than a quarter", {"joints.lock.rounding": 0.01}),
    ],
)
def test_a_disc_that_cannot_be_is_refused(words, changes):
    with pytest.raises(rt.ModelError, match=words):
        _ = Geneva(4).model().set(changes).model


@nojit
def test_axes_that_do_not_fit_the_arcs_are_noted():
    m = Geneva(4).model().set({"joints.lock.axle_distance": 0.0702, "joints.lock.rim": 0.0495})
    assert "the arcs fit the disc where the axes are 0.0702 m apart" in str(m.check())


def test_disc_and_wheel_are_drawn():
    drive = Geneva(4)
    r = drive.model().simulate(0.01)
    figure, ax = plt.subplots()
    draw_at(ax, r, 0)
    reach = [np.nanmax(np.hypot(*line.get_xydata().T)) for line in ax.lines if len(line.get_xydata()) > 60]
    assert min(reach) == pytest.approx(drive.disc, rel=1e-6)
    assert max(reach) == pytest.approx(drive.axes + drive.rim, rel=2e-2)
    plt.close(figure)
