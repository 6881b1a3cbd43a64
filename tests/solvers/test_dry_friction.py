"""Dry friction in joints without play, by their own reaction, against closed forms and an independent integration."""

from __future__ import annotations

from math import cos, pi, sin

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, fsolve

import rattle as rt
from rubbing import two_shafts

pytestmark = [pytest.mark.nojit, pytest.mark.plain]

FINE = {"rtol": 1e-11, "atol": 1e-13}
G = 9.81


def wheel(friction: str) -> str:
    return f"""
format = 1
gravity = [0, -9.81]
[ground.points]
O = [0, 0]
[bodies.disc]
points = {{ C = [0, 0] }}
mass = 2
inertia = 0.001
[joints.pin]
type = "revolute"
connect = ["ground.O", "disc.C"]
{friction}
[initial]
disc = {{ omega = 10 }}
"""


def block(friction: str, start: str = "x = 0, vx = 1", more: str = "", guide: str = "ground.O") -> str:
    return f"""
format = 1
gravity = [0, -9.81]
[ground.points]
O = [0, 0]
[bodies.block]
points = {{ C = [0, 0], H = [0, 0.5] }}
mass = 1
inertia = 1
[joints.guide]
type = "prismatic"
connect = ["{guide}", "block.C"]
angle = 0
{friction}
{more}
[initial]
block = {{ {start} }}
"""


def pendulum(mu: float, second: float = 0.0, start: float = 0.3, rates: tuple[float, float] = (0.0, 0.0)) -> str:
    """Two bars of 1 m and 1 kg that hang one below the other, pins of 40 mm radius; angles from the horizontal."""
    friction = f'friction = {{ model = "coulomb", mu = {mu}, pin_radius = "40 mm" }}'
    return f"""
format = 1
gravity = [0, -9.81]
[ground.points]
O = [0, 0]
[bodies.one]
bar = ["A", "B"]
length = 1
mass = 1
[bodies.two]
bar = ["A", "B"]
length = 1
mass = 1
[joints.upper]
type = "revolute"
connect = ["ground.O", "one.A"]
{friction}
[joints.lower]
type = "revolute"
connect = ["one.B", "two.A"]
{friction}
[initial]
one = {{ angle = {start - pi / 2!r}, omega = {rates[0]!r} }}
two = {{ angle = {second - pi / 2!r}, omega = {rates[1]!r} }}
"""


def kinds(run, joint: str, what: str) -> np.ndarray:
    return np.array([one.t for one in run.events if one.joint == joint and one.kind == what])


def test_a_disc_on_its_pin_loses_its_rate_evenly_and_stays_at_rest():
    run = rt.loads(wheel('friction = { model = "coulomb", mu = 0.1, pin_radius = "8 mm" }')).simulate(
        1.0, t_eval=[0, 0.3, 1.0], **FINE
    )
    stop = 0.001 * 10 / (0.1 * 0.008 * 2 * G)
    assert abs(run["disc.omega"][1] - (10 - 3 / stop)) < 1e-10
    assert abs(run["disc.angle"][2] - 5 * stop) < 1e-11
    assert abs(run["disc.omega"][2]) < 1e-14
    assert np.allclose(kinds(run, "pin", "stick"), [stop], atol=1e-12, rtol=0)
    assert abs(run["energy.balance"]).max() < 1e-12  # the loss is the kinetic energy
    assert abs(run["energy.dissipated"][2] - 0.05) < 1e-12


def test_a_guide_brakes_by_its_normal_force_or_by_its_moment_whichever_presses_more():
    run = rt.loads(block("friction = 0.1")).simulate(2.0, t_eval=[0, 0.5, 2.0], **FINE)
    assert np.allclose(run["block.x"][1:], [0.5 - 0.981 * 0.125, 0.5 / 0.981], atol=1e-12, rtol=0)
    for weight, normal in ((0.0, 10 * 0.5 / 0.1), (60.0, 60.0)):  # moment 5 N m over 0.1 m, or the weight
        hand = f'[loads.hand]\ntype = "force"\nat = "block.H"\nforce = [10, {G - weight!r}]'
        more = "block = { length = 0.2, height = 0.05 }\nfriction = 0.1"
        run = rt.loads(block(more, "x = 0, vx = 0.5", hand)).simulate(0.02, t_eval=[0, 0.02], **FINE)
        assert abs(run["block.x"][1] - (0.01 + (10 - 0.1 * normal) * 2e-4)) < 1e-12


@pytest.mark.parametrize(("mu", "moves"), [(0.19, True), (0.21, False)])
def test_a_drawer_pushed_beside_its_middle_jams_from_a_over_e_on(mu, moves):
    more = f"block = {{ length = 0.2, height = 0.05 }}\nfriction = {mu}"
    hand = f'[loads.hand]\ntype = "force"\nat = "block.H"\nforce = [10, {G!r}]'
    run = rt.loads(block(more, "x = 0, vx = 0", hand)).simulate(1.0, t_eval=[0, 1.0], **FINE)
    assert abs(run["block.x"][1] - (0.5 * 10 * (1 - 5 * mu) if moves else 0.0)) < 1e-11


@pytest.mark.machine
def test_a_block_on_a_belt_sticks_and_slips_with_the_period_of_the_closed_form():
    belt = """
[bodies.belt]
points = { C = [0, 0] }
mass = 1
inertia = 1
[joints.rail]
type = "prismatic"
connect = ["ground.O", "belt.C"]
[drivers.band]
joint = "rail"
position = "0.1*t"
[loads.spring]
type = "spring"
connect = ["ground.O", "block.C"]
stiffness = 10
free_length = 0.8
"""
    written = block('friction = { model = "coulomb", mu = 0.15, mu_static = 0.2 }', "x = 1, vx = 0", belt, "belt.C")
    run = rt.loads(written).simulate(7.0, t_eval=[0, 5.0, 7.0], **FINE)
    stick, slip = kinds(run, "guide", "stick"), kinds(run, "guide", "slip")
    # slips while the spring draws: x = centre + amplitude cos, first sticks where its rate reaches that of the belt
    centre, w = 0.8 + 0.15 * G / 10, 10**0.5
    assert (
        abs(stick[0] - (pi + np.arcsin(0.1 / (w * (1.0 - centre)))) / w) < 1.0
    )  # the first slip goes towards the spring
    far = 0.05 * G / 10  # from the centre, at both ends of sticking
    swing = (pi + 2 * np.arctan(0.1 / (w * far))) / w
    assert np.allclose(np.diff(slip), swing + 2 * far / 0.1, atol=1e-9, rtol=0)
    assert np.allclose(stick[1:] - slip[:-1], swing, atol=1e-9, rtol=0)


# ---------------------------------------------------------------- an independent integration of two bars
def reactions(q: np.ndarray, w: np.ndarray, a: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Forces of the ground on the first bar and of the first on the second [N]; angles from the horizontal."""

    def turned(angle, rate, acceleration, length):
        along, across = np.array([cos(angle), sin(angle)]), np.array([-sin(angle), cos(angle)])
        return length * (acceleration * across - rate * rate * along)

    first = turned(q[0], w[0], a[0], 0.5)
    second = turned(q[0], w[0], a[0], 1.0) + turned(q[1], w[1], a[1], 0.5)
    weight = np.array([0.0, G])
    return first + second + 2 * weight, second + weight


def bars(q: np.ndarray, w: np.ndarray, moments: np.ndarray) -> np.ndarray:
    """Angular accelerations of the bars for moments of the two pins on the lower body of each [N m]."""
    d = q[1] - q[0]
    mass = np.array([[4 / 3, 0.5 * cos(d)], [0.5 * cos(d), 1 / 3]])
    first = 0.5 * sin(d) * w[1] ** 2 - 1.5 * G * cos(q[0]) + moments[0] - moments[1]
    second = -0.5 * sin(d) * w[0] ** 2 - 0.5 * G * cos(q[1]) + moments[1]
    return np.linalg.solve(mass, [first, second])


def moving(q: np.ndarray, w: np.ndarray, modes: tuple[int, int], limit: float) -> tuple[np.ndarray, np.ndarray]:
    """Accelerations and moments of the pins that slip (+-1) or stick (0), by a general root finder."""

    def miss(moments):
        a = bars(q, w, moments)
        forces = [np.linalg.norm(one) for one in reactions(q, w, a)]
        relative = (a[0], a[1] - a[0])
        return [relative[k] if modes[k] == 0 else moments[k] + modes[k] * limit * forces[k] for k in range(2)]

    moments = fsolve(miss, [0.0, 0.0], xtol=1e-13)
    return bars(q, w, moments), moments


def test_a_pendulum_of_two_bars_with_dry_pins_moves_as_an_independent_integration():
    limit = 0.2 * 0.04
    q, w = np.array([0.3, -0.2]) - pi / 2, np.array([-1.0, 2.0])

    def rate(t, y):
        return np.concatenate([y[2:], moving(y[:2], y[2:], (-1, 1), limit)[0]])

    def stops(k):
        def event(t, y):
            return y[2] if k == 0 else y[3] - y[2]

        event.terminal = True
        return event

    found = solve_ivp(rate, (0, 1), [*q, *w], method="DOP853", rtol=1e-11, atol=1e-12, events=[stops(0), stops(1)])
    end = found.t[-1]
    run = rt.loads(pendulum(0.2, -0.2, 0.3, (-1.0, 2.0))).simulate(end + 0.1, t_eval=[0, 0.5 * end, end], **FINE)
    first = run.events[0]
    assert abs(first.t - end) < 1e-9
    assert first.joint == ("upper", "lower")[int(len(found.t_events[1]) > 0)]
    got = [run[name][2] for name in ("one.angle", "two.angle", "one.omega", "two.omega")]
    assert np.allclose(got, found.y[:, -1], atol=1e-9, rtol=0)
    # and what follows: sticking if the moment that it takes is within the limit
    k = int(len(found.t_events[1]) > 0)
    others = -1 if k == 1 else 1
    modes = (others, 0) if k == 1 else (0, others)
    a, moments = moving(found.y[:2, -1], found.y[2:, -1], modes, limit)
    sticks = abs(moments[k]) <= limit * np.linalg.norm(reactions(found.y[:2, -1], found.y[2:, -1], a)[k])
    assert first.kind == ("stick" if sticks else "slip")


def test_a_dry_pendulum_comes_to_rest_and_keeps_its_energy_balance():
    run = rt.loads(pendulum(0.5, 0.2, 0.2)).simulate(8.0, t_eval=np.linspace(0, 8, 41), rtol=1e-9, atol=1e-11)
    last = [one for one in run.events if one.joint == "upper"][-1]
    assert last.kind == "stick"
    assert abs(run["one.omega"][-1]) < 1e-12
    assert abs(run["two.omega"][-1]) < 1e-12
    assert abs(run["energy.balance"]).max() < 1e-7
    assert (np.diff(run["energy.dissipated"]) > -1e-12).all()


# ---------------------------------------------------------------- laws, drivers, contacts, refusals
def test_a_smooth_law_slows_a_disc_as_its_closed_form():
    law = 'friction = { model = "coulomb-smooth", mu = 0.1, v1 = "20 mm/s", pin_radius = "8 mm" }'
    run = rt.loads(wheel(law)).simulate(0.8, t_eval=[0, 0.3, 0.6, 0.8], **FINE)
    decay = 0.1 * 2 * G * 0.008**2 / 0.001 / 0.02  # sinh(R w/v1) decays exponentially
    exact = np.arcsinh(np.sinh(0.008 * 10 / 0.02) * np.exp(-decay * run.t)) * 0.02 / 0.008
    assert np.allclose(run["disc.omega"], exact, atol=1e-9, rtol=0)


def test_bristles_take_the_energy_of_dahl_law_at_constant_load():
    law = 'friction = { model = "dahl", mu = 0.1, sigma = 100, pin_radius = "8 mm" }'
    run = rt.loads(wheel(law)).simulate(0.3, t_eval=[0, 0.3], **FINE)
    way, limit = 0.008 * run["disc.angle"][1], 0.1 * 2 * G
    bent = 1 - np.exp(-100 * way / 0.1)
    assert abs(run["pin.friction"][1] + 0.008 * limit * bent) < 1e-11
    assert abs(0.0005 * (100 - run["disc.omega"][1] ** 2) - limit * (way - 0.001 * bent)) < 1e-11


def test_a_driven_pin_needs_the_moment_of_its_friction_in_the_sense_of_its_rate():
    motor = '[drivers.motor]\njoint = "pin"\nangle = "sin(2*pi*t)"'
    written = wheel('friction = { mu = 0.1, pin_radius = "8 mm" }').replace("[initial]\ndisc = { omega = 10 }", motor)
    model = rt.loads(written)
    run = model.simulate(1.0, t_eval=np.linspace(0, 1, 11), rtol=1e-10)
    inertia = -0.001 * (2 * pi) ** 2 * np.sin(2 * pi * run.t)
    rubbing = 0.1 * 0.008 * 2 * G
    assert np.allclose(run["motor.torque"], inertia + rubbing * np.sign(np.cos(2 * pi * run.t)), atol=1e-9, rtol=0)
    assert np.allclose(model.inverse_dynamics(run.t)["motor.torque"], run["motor.torque"], atol=1e-9, rtol=0)
    assert abs(run["energy.dissipated"][-1] - 4 * rubbing) < 1e-8
    assert np.allclose(kinds(run, "pin", "slip"), [0.25, 0.75], atol=1e-9, rtol=0)


@pytest.mark.parametrize(("wind", "holds"), [pytest.param(-0.1, True, marks=pytest.mark.machine), (-1.0, False)])
def test_a_disc_that_hits_its_stop_is_held_by_friction_or_leans_on_the_stop(wind, holds):
    stop = 'friction = { mu = 0.3, pin_radius = "50 mm" }\nstop = { min = 0 }'
    load = f'[loads.wind]\ntype = "torque"\nbody = "disc"\ntorque = "{wind} + {0.6 - wind}*step(t - 2)"\n[initial]'
    written = wheel(stop).replace("[initial]", load).replace("omega = 10", "angle = 0.1, omega = -1")
    written = written.replace("inertia = 0.001", "inertia = 0.1")
    run = rt.loads(written).simulate(3.0, t_eval=[0, 1, 3], **FINE)
    limit, brake = 0.3 * 0.05 * 2 * G, (0.3 * 0.05 * 2 * G + wind) / 0.1  # rate of slowing down before the stop
    hit = (1 - np.sqrt(1 - 0.2 * brake)) / brake
    assert abs(run.events[0].t - hit) < 1e-11
    assert abs(run["pin.friction"][1] - (0.1 if holds else limit)) < 1e-11
    assert abs(run["pin.stop"][1] - (0.0 if holds else 1.0 - limit)) < 1e-11
    assert abs(run["disc.omega"][2] - (0.6 - limit) / 0.1) < 1e-9  # pushed away from the stop after 2 s
    assert abs(run["energy.balance"]).max() < 1e-10


@pytest.mark.machine
def test_a_door_under_its_own_reaction_bounces_as_an_independent_integration():
    """No weight: the reaction is m r sqrt(alpha^2 + w^4), so that friction multiplies itself."""
    reach = 0.3 * 0.05

    def slowed(sense, w):
        miss = lambda a: a / 3 + 3.0 + sense * reach * 0.5 * np.sqrt(a * a + w**4)  # noqa: E731
        return brentq(miss, -100, 100, xtol=1e-14)

    t, y, sense, hits = 0.0, np.array([0.5, 0.0]), -1, []
    for _ in range(6):
        index = 0 if sense < 0 else 1

        def end(t, y, index=index):
            return y[index]

        end.terminal, end.direction = True, -1
        piece = solve_ivp(
            lambda t, y, sense=sense: [y[1], slowed(sense, y[1])], (t, t + 5), y, method="DOP853", rtol=1e-12,
            atol=1e-14, events=[end],
        )  # fmt: skip
        t, y = piece.t[-1], piece.y[:, -1]
        y = np.array([0.0, -0.5 * y[1]]) if sense < 0 else np.array([y[0], 0.0])
        hits += [t] if sense < 0 else []
        sense = -sense
    door = """
format = 1
[ground.points]
O = [0, 0]
[bodies.door]
bar = ["A", "B"]
length = 1
mass = 1
[joints.hinge]
type = "revolute"
connect = ["ground.O", "door.A"]
friction = { mu = 0.3, pin_radius = "50 mm" }
stop = { min = 0, contact = { model = "impact", restitution = 0.5 } }
[loads.wind]
type = "torque"
body = "door"
torque = -3
[initial]
door = { angle = 0.5, omega = 0 }
"""
    run = rt.loads(door).simulate(0.9, t_eval=[0, 0.9], **FINE)
    assert np.allclose(kinds(run, "hinge", "impact")[:3], hits, atol=1e-10, rtol=0)
    run = rt.loads(door).simulate(1.5, t_eval=[0, 1.5], **FINE)
    assert abs(run["hinge.stop"][1] - 3.0) < 1e-9  # no weight, no reaction, no friction


def two_doors(law: str, e: float) -> str:
    """Doors of 1 kg, 1 m and 2 m long, that hit their stops at the same instant with 1 rad/s; no weight."""
    doors = "".join(
        f"""
[bodies.{name}]
bar = ["A", "B"]
length = {length}
mass = 1
[joints.{name}_hinge]
type = "revolute"
connect = ["ground.{place}", "{name}.A"]
friction = {{ mu = 0.3, pin_radius = "50 mm" }}
stop = {{ min = 0, contact = {{ model = "impact", restitution = {e}, restitution_law = "{law}" }} }}
"""
        for name, place, length in (("left", "O", 1), ("right", "P", 2))
    )
    start = "angle = 1e-12, omega = -1"
    return f"""
format = 1
[ground.points]
O = [0, 0]
P = [5, 0]
{doors}
[initial]
left = {{ {start} }}
right = {{ {start} }}
"""


@pytest.mark.parametrize("law", ["newton", "poisson", "energetic"])
@pytest.mark.parametrize("e", [pytest.param(0.0, marks=pytest.mark.machine), 0.5])
def test_doors_that_hit_their_stops_together_rub_in_their_hinges_as_each_does_alone(law, e):
    """A hinge gives m r (1 + e) w, so that its friction takes mu R times that from the impulse of the stop.

    A door that bounces rubs against its rate after the impact and adds it instead.
    """
    run = rt.loads(two_doors(law, e)).simulate(1e-6, t_eval=[0, 1e-6], **FINE)
    hits = {event.joint: event.impulse for event in run.events if event.kind == "impact"}
    for name, length in (("left_hinge", 1.0), ("right_hinge", 2.0)):
        rubbing = 0.3 * 0.05 * 0.5 * length
        expected = (1 + e) * (length**2 / 3 + (rubbing if e > 0 else -rubbing))
        assert hits[name] == pytest.approx(expected, rel=1e-9)


def carriage(law: str, mu: float) -> str:
    """A carriage of 1 kg at 1 m/s with two bars that reach their stops on it at once and press it on its rail."""
    bars = "".join(
        f"""
[bodies.{name}]
bar = ["A", "B"]
length = 0.5
mass = 1
[joints.{name}_pin]
type = "revolute"
connect = ["carriage.{place}", "{name}.A"]
stop = {{ min = 0, contact = {{ model = "impact", restitution = 0, restitution_law = "{law}" }} }}
"""
        for name, place in (("left", "L"), ("right", "R"))
    )
    return f"""
format = 1
[ground.points]
O = [0, 0]
[bodies.carriage]
points = {{ C = [0, 0], L = [-0.3, 0], R = [0.2, 0] }}
mass = 1
inertia = 1
[joints.guide]
type = "prismatic"
connect = ["ground.O", "carriage.C"]
angle = 0
friction = {{ mu = {mu} }}
{bars}
[initial]
carriage = {{ x = 0, vx = 1 }}
left = {{ angle = 1e-12, omega = -2 }}
right = {{ angle = 1e-12, omega = -2 }}
"""


@pytest.mark.parametrize(
    "law", ["newton", *(pytest.param(x, marks=pytest.mark.machine) for x in ("poisson", "energetic"))]
)
def test_a_carriage_is_slowed_by_the_impulse_with_which_two_stops_press_it_on_its_rail(law):
    """Each bar loses m (l / 2) w of its momentum across the rail: 1 N s together, of which mu is lost along it.

    Bars along the rail turn no momentum along it into another one: 3 kg are slowed.
    """
    run = rt.loads(carriage(law, 0.2)).simulate(1e-6, t_eval=[0, 1e-6], **FINE)
    assert run["carriage.vx"][-1] == pytest.approx(1 - 0.2 * 1.0 / 3, abs=1e-5)


def lever(mu: float, law: str = "newton", e: float = 0.0, driven: bool = True) -> str:
    """A pin on a crank is about to strike the slot of a lever at rest, whose shaft rubs."""
    moves = '[drivers.motor]\njoint = "axis"\nangle = "0.3 + 2*t"' if driven else ""
    pushed = "" if driven else '[loads.push]\ntype = "torque"\nbody = "crank"\ntorque = 0.1'
    return f"""
format = 1
[ground.points]
O = [0, 0]
W = [0.07, 0]
[bodies.crank]
points = {{ O = [0, 0], P = [0.05, 0] }}
mass = 0.3
inertia = 2e-4
[bodies.lever]
points = {{ W = [0, 0], S = [0.03, 0] }}
mass = 0.6
inertia = 2e-3
[joints.axis]
type = "revolute"
connect = ["ground.O", "crank.O"]
[joints.shaft]
type = "revolute"
connect = ["ground.W", "lever.W"]
friction = {{ mu = {mu}, pin_radius = "8 mm" }}
[joints.slot]
type = "slot"
connect = ["lever.S", "crank.P"]
length = 0.06
open = true
clearance = "0.1 mm"
contact = {{ model = "impact", restitution = {e}, bush_radius = "4 mm", restitution_law = "{law}" }}
{moves}
{pushed}
[initial]
crank = {{ angle = 0.3{"" if driven else ", omega = 2"} }}
lever = {{ angle = 2.555 }}
"""


@pytest.mark.parametrize(
    "law", ["newton", *(pytest.param(x, marks=pytest.mark.machine) for x in ("poisson", "energetic"))]
)
@pytest.mark.parametrize("e", [pytest.param(0.0, marks=pytest.mark.machine), 0.4])
def test_a_driven_pin_strikes_a_lever_out_of_the_hold_of_its_shaft(law, e):
    """Across the slot the lever gets 1 + e times the rate of the pin, whatever its shaft takes."""
    model = rt.loads(lever(0.1, law, e))
    hit = kinds(model.simulate(0.05, **FINE), "slot", "impact")[0]
    run = model.simulate(hit + 1e-7, t_eval=[0, hit + 1e-7], **FINE)
    assert run.success, run.message
    pin = 0.05 * np.array([cos(0.3 + 2 * hit), sin(0.3 + 2 * hit)])
    angle = run["lever.angle"][0]
    rate = 2 * np.array([-pin[1], pin[0]]) @ [-sin(angle), cos(angle)]
    reach = (pin - [0.07, 0]) @ [cos(angle), sin(angle)]
    assert run["lever.omega"][-1] == pytest.approx((1 + e) * rate / reach, rel=1e-4)


@pytest.mark.machine
def test_a_clutch_drives_a_wheel_against_the_friction_of_its_pin():
    pair = """
format = 1
gravity = [0, -9.81]
[ground.points]
O = [0, 0]
Q = [1, 0]
[bodies.one]
points = { C = [0, 0] }
mass = 1
inertia = 1
[bodies.two]
points = { C = [0, 0] }
mass = 4
inertia = 2
[joints.first]
type = "revolute"
connect = ["ground.O", "one.C"]
[joints.second]
type = "revolute"
connect = ["ground.Q", "two.C"]
friction = { mu = 0.2, pin_radius = "100 mm" }
[joints.drive]
type = "clutch"
connect = ["one", "two"]
[loads.push]
type = "torque"
body = "one"
torque = "10*sin(2*pi*t)"
[initial]
one = { angle = 0, omega = 0 }
two = { angle = 0, omega = 0 }
"""
    run = rt.loads(pair).simulate(1.0, t_eval=[0, 1.0], **FINE)
    limit = 0.2 * 0.1 * 4 * G
    breaks = np.arcsin(limit / 10) / (2 * pi)
    free = 0.5 + np.arcsin(0.05 * limit) / (2 * pi)  # torque of the clutch 2 alpha + limit = 0
    rate = (10 / (2 * pi) * (cos(2 * pi * breaks) - cos(2 * pi * free)) - limit * (free - breaks)) / 3
    assert abs(kinds(run, "second", "slip")[0] - breaks) < 1e-10
    assert abs(kinds(run, "drive", "free")[0] - free) < 1e-10
    assert abs(run["two.omega"][1] - (rate - limit / 2 * (1.0 - free))) < 1e-9


@pytest.mark.parametrize(
    ("friction", "says"),
    [
        ("friction = 0.1", "needs pin_radius"),
        ('friction = { mu = 0.2, mu_static = 0.1, pin_radius = "8 mm" }', "must not be less than mu"),
        ('friction = { model = "coulom", mu = 0.2 }', "did you mean 'coulomb'"),
        ('clearance = "1 mm"\ncontact = "exact"\nfriction = { mu = 0.2, pin_radius = "8 mm" }', "one or the other"),
        ('friction = { model = "ambrosio", mu = 0.2, v0 = 1, pin_radius = "8 mm" }', "needs v0 < v1"),
    ],
)
def test_what_makes_no_sense_is_refused_where_it_stands(friction, says):
    with pytest.raises(rt.ModelError, match=says):
        rt.loads(wheel(friction))


def test_time_stepping_says_that_it_does_not_know_friction_in_joints():
    with pytest.raises(rt.ModelError, match="no dry friction of joints without play, only friction in contacts"):
        rt.loads(wheel('friction = { mu = 0.1, pin_radius = "8 mm" }\nstop = { min = -1 }')).simulate(
            0.1, method="moreau"
        )


@pytest.mark.machine
def test_joints_that_stick_together_hold_with_the_sum_of_their_limits():
    """Two blocks on one line, a rod between them: one degree of freedom, two joints that could hold it alone."""
    blocks = """
format = 1
gravity = [0, -9.81]
[ground.points]
O = [0, 0]
[bodies.one]
points = { C = [0, 0] }
mass = 1
inertia = 1
[bodies.two]
points = { C = [0, 0] }
mass = 2
inertia = 1
[joints.first]
type = "prismatic"
connect = ["ground.O", "one.C"]
friction = 0.1
[joints.second]
type = "prismatic"
connect = ["ground.O", "two.C"]
friction = 0.1
[joints.link]
type = "rod"
connect = ["one.C", "two.C"]
length = 1
[loads.hand]
type = "force"
at = "one.C"
force = ["30*t", 0]
[initial]
one = { x = 0, vx = 0 }
two = { x = 1, vx = 0 }
"""
    run = rt.loads(blocks).simulate(0.3, t_eval=[0, 0.05, 0.3], **FINE)
    limit, t = 0.1 * 3 * G, 0.3
    breaks = limit / 30
    assert max(one.t for one in run.events) == pytest.approx(breaks, abs=1e-12)
    assert abs(run["first.friction"][1] + run["second.friction"][1] + 1.5) < 1e-12
    assert abs(run["one.vx"][2] - (15 * (t * t - breaks**2) - limit * (t - breaks)) / 3) < 1e-10


@pytest.mark.parametrize(
    ("first", "second", "said"),
    [
        pytest.param("0.3", "0", "guide: friction by", marks=pytest.mark.machine),
        ("0", "0.3", "other: friction by"),
        ("0", "0", ""),
    ],
)
def test_that_friction_follows_a_reaction_which_is_not_unique_is_said(first, second, said):
    """Two guides on one line share the weight in any way, so the one that rubs may carry all of it or nothing."""
    rubs = f"friction = {second}\n" if second != "0" else ""
    other = f'[joints.other]\ntype = "prismatic"\nconnect = ["ground.O", "block.C"]\nangle = 0\n{rubs}'
    r = rt.loads(block(f"friction = {first}" if first != "0" else "", more=other)).simulate(0.01)
    assert r.trust.nonunique == ("guide", "other")
    notes = [one for one in r.trust.notes if "neither is the motion" in one]
    assert [one.startswith(said) for one in notes] == ([True] if said else [])


@pytest.mark.machine
def test_joints_that_stick_do_not_slip_by_the_error_of_the_steps():
    """A chain of three comes to rest joint by joint; its events do not depend on the tolerance."""
    m = rt.Mechanism(gravity=[0, -G]).ground(O=[0, 0])
    for k, (angle, bearing) in enumerate(((-1.2, "ground.O"), (-1.3, "bar0.B"), (-1.0, "bar1.B"))):
        m.bar(f"bar{k}", "A", "B", length=0.2, mass=0.5).initial(f"bar{k}", angle=angle)
        rubs = {"model": "coulomb", "mu": 0.4, "mu_static": 0.48, "pin_radius": 0.03}
        m.revolute(f"pin{k}", bearing, f"bar{k}.A", friction=rubs)
    found = []
    for rtol in (1e-5, 1e-7):
        found.append(m.simulate(1.25, t_eval=[0, 1.25], rtol=rtol).events)
    loose, tight = found
    assert [(e.kind, e.joint) for e in loose] == [(e.kind, e.joint) for e in tight]
    assert [e.t for e in loose] == pytest.approx([e.t for e in tight], abs=1e-3)
    assert [e.kind for e in tight].count("stick") == 2


def two_guides(share: float) -> str:
    """A block on a steep guide bears the guide of a second one; both are loaded beside their middles."""
    return f"""
format = 1
gravity = [0, -9.81]
[ground.points]
O = [0.105, -0.331]
[bodies.lower]
points = {{ O = [-0.393, 0.175], P = [0.096, -0.011], H = [-0.022, -0.058] }}
mass = 2.75
inertia = 0.073
[bodies.upper]
points = {{ P = [-0.678, -0.215] }}
mass = 0.72
inertia = 0.092
[joints.first]
type = "prismatic"
connect = ["ground.O", "lower.O"]
friction = {share * 0.338}
block = {{ length = 0.3, height = 0.05 }}
axis = 2.969
angle = 0.26
[joints.second]
type = "prismatic"
connect = ["lower.P", "upper.P"]
friction = {share * 0.338}
block = {{ length = 0.3, height = 0.05 }}
axis = 1.2526
angle = 1.6521
[loads.hand]
type = "force"
at = "lower.H"
force = [0.22, 2.63]
[initial]
lower = {{ x = 0.453, y = -0.386, angle = 0.26 }}
upper = {{ x = 0.119, y = 0.2, angle = 1.912 }}
"""


@pytest.mark.machine
def test_blocks_on_each_other_move_at_the_end_of_growing_friction_as_just_before():
    """Their forces have a second solution, of fifty times the size, where friction locks."""
    shares = np.linspace(0.9, 1.0, 11)
    runs = [rt.loads(two_guides(share)).simulate(1e-6, t_eval=[0, 1e-6]) for share in shares]
    assert all(run.success for run in runs), [run.message for run in runs]
    forces = np.array([[run["first.friction"][0], run["second.friction"][0]] for run in runs])
    assert abs(np.diff(forces, axis=0) / forces[1:]).max() < 0.02


@pytest.mark.parametrize(("force", "wide"), [(5.0, 0.3), (50.0, 0.01)])
def test_a_short_push_moves_what_sticks(force, wide):
    """Of F exp(-((t - 5)/w)^2): steps grow while the block rests, and must not pass the push."""
    push = f'[loads.push]\ntype = "force"\nat = "block.C"\nforce = ["{force}*exp(-((t - 5)/{wide})**2)", 0]\n'
    run = rt.loads(block("friction = 0.4", start="x = 0, vx = 0", more=push)).simulate(10, t_eval=[0, 10])
    limit = 0.4 * G
    begins = 5.0 - wide * np.sqrt(np.log(force / limit))

    def rate(t, y):
        return [y[1], force * np.exp(-(((t - 5.0) / wide) ** 2)) - limit]

    def rests(t, y):
        return y[1] if t > 5.0 else 1.0

    rests.terminal = True
    want = solve_ivp(
        rate, (begins, 10.0), [0.0, 0.0], "DOP853", rtol=1e-11, atol=1e-14, events=rests, max_step=wide / 9
    )
    assert run["block.x"][-1] == pytest.approx(want.y[0, -1], rel=1e-6)
    assert [event.kind for event in run.events] == ["slip", "stick"]


@pytest.mark.parametrize("load", ["3*t", "3*sin(2*t)", "6*sin(2*t)"])
def test_a_shaft_that_rubs_at_its_stop_is_pressed_on_it_once_its_friction_gives_way(load):
    """By an elastic clutch that is wound up: friction bears f of its torque at most, the stop all the rest."""
    stop = ', stop = { max = 0.1, min = -9, contact = { model = "impact", restitution = 0.3 } }'
    clutch = '["two", "one"], model = "compliant", stiffness = 300, damping = 1'
    m = rt.loads(two_shafts(clutch, "0", load, stop, begins="angle = 0.1")).set(g=0.0)
    run = m.simulate(t_eval=[0.0, 0.5, 1.0], **FINE)
    assert run.success
    np.testing.assert_allclose(run["p.friction"][1:], -0.6, rtol=1e-9)
    np.testing.assert_allclose(-run["p.stop"][1:], run["way.torque"][1:] - 0.6, rtol=1e-9)
    assert not run["one.omega"].any()


def test_a_shaft_that_friction_holds_at_its_stop_is_let_go_with_another_behind_a_clutch():
    """Both stick; from 3 t + 2 sin(9 t + 4) = f + g on they move together, and the stop holds nothing back."""
    stop = ', stop = { min = -1, max = 9, contact = { model = "impact", restitution = 0.3 } }'
    clutch = '["one", "two"], model = "ideal", max_torque = 1.5'
    text = two_shafts(clutch, "3*t", "2*sin(9*t + 4)", stop, begins="angle = -0.9")
    run = rt.loads(text).set(w=-2.0).simulate(t_eval=[0.0, 0.28, 0.3], **FINE)
    begins = brentq(lambda t: 3.0 * t + 2.0 * sin(9.0 * t + 4.0) - 1.2, 0.25, 0.3)

    def gained(t):
        return 1.5 * t * t - 2.0 / 9.0 * cos(9.0 * t + 4.0) - 1.2 * t

    want = [(gained(t) - gained(begins)) / 0.08 for t in (0.28, 0.3)]
    np.testing.assert_allclose(run["one.omega"][1:], want, rtol=1e-7)
    np.testing.assert_allclose(run["two.omega"][1:], want, rtol=1e-7)


def test_a_disc_that_its_hinge_and_a_floor_hold_rolls_nowhere_by_the_friction_of_either():
    """Both together bear more than its load: when the hinge gives way first, the floor resists, and drives nothing."""
    run = rt.loads("""
format = 1
gravity = [0, -9.81]
ground.points = { O = [0, 0], F = [0, -0.2] }
bodies.arm = { points = { O = [0, 0], E = [0.3, 0] }, center = [0.15, 0], mass = 1, inertia = 0.01 }
bodies.disc = { points = { C = [0, 0] }, mass = 0.5, inertia = 0.0006 }
loads.m = { type = "torque", body = "arm", torque = "0.7755*sin(9*t + 4)" }
loads.n = { type = "torque", body = "disc", torque = "0.23265*sin(9*t + 2)" }
initial = { arm = { angle = -0.3, omega = 0 }, disc = { angle = 0, omega = 0 } }
[joints.O]
type = "revolute"
connect = ["ground.O", "arm.O"]
friction = { model = "coulomb", mu = 0.195, mu_static = 0.292, pin_radius = "15 mm" }
[joints.E]
type = "revolute"
connect = ["arm.E", "disc.C"]
friction = { torque = 0.292 }
[joints.floor]
type = "surface"
connect = ["ground.F", "disc.C"]
axis = 0
roller = 0.05
contact = { model = "impact", restitution = 0.5, friction = 0.2 }
""").simulate(t_eval=[0.0, 0.5, 0.9, 1.0, 1.17], rtol=1e-9)
    assert run.success
    np.testing.assert_allclose(run["disc.angle"][2:], run["disc.angle"][1], rtol=0, atol=1e-9)
    np.testing.assert_allclose(run["energy.dissipated"][2:], run["energy.dissipated"][1], rtol=1e-9)
