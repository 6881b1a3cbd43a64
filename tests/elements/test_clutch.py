"""One-way clutches: two flywheels, a torque converter, networks, slipping, oil, wind-up, teeth, impacts."""

import itertools
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import rattle as rt
from rattle.errors import ModelError
from rattle.results.contact_summary import contact_lines

nojit = pytest.mark.nojit
FINE = {"rtol": 1e-11, "atol": 1e-13}


def rotors(inertias, joints, torques=(), initial="", more=""):
    """Rotors r0, r1 ... about the origin; joints: their tables; torques: by rotor, expressions."""
    bodies = "".join(
        f"[bodies.r{n}]\npoints = {{ C = [0, 0] }}\nmass = 1\ninertia = {float(one)!r}\n"
        f'[joints.pin{n}]\ntype = "revolute"\nconnect = ["ground.O", "r{n}.C"]\n'
        for n, one in enumerate(inertias)
    )
    ties = "".join(f'[joints.{name}]\ntype = "clutch"\n{table}\n' for name, table in joints.items())
    loads = "".join(f'[loads.t{n}]\ntype = "torque"\nbody = "r{n}"\ntorque = "{law}"\n' for n, law in torques)
    head = "format = 1\ngravity = [0, 0]\n[ground.points]\nO = [0, 0]\n"
    return f"{head}{bodies}{ties}{loads}{more}\n[initial]\n{initial}\n"


def flywheels(table='model = "ideal"', push="10*sin(2*pi*t)", drag="-0.5*r1.omega", initial=""):
    """1 kg m^2 with a torque drives 2 kg m^2 with drag."""
    way = f'connect = ["r0", "r1"]\n{table}'
    return rt.loads(rotors([1, 2], {"way": way}, [(0, push), (1, drag)], initial))


def times(r, joint, kind):
    return [event.t for event in r.events if event.joint == joint and event.kind == kind]


# ---------------------------------------------------------------- ideal
@nojit
def test_freewheel_locks_and_lets_go_where_its_torque_and_its_rate_are_zero():
    """Against the integration of each mode by SciPy, with events."""
    r = flywheels().simulate(1.6, t_eval=[0, 0.25, 1, 1.6], **FINE)
    push = lambda t: 10 * math.sin(2 * math.pi * t)  # noqa: E731
    locked = lambda t, w: [(push(t) - 0.5 * w[0]) / 3, (push(t) - 0.5 * w[0]) / 3]  # noqa: E731
    free = lambda t, w: [push(t), -0.25 * w[1]]  # noqa: E731
    torque = lambda t, w: 2 * locked(t, w)[1] + 0.5 * w[1]  # noqa: E731
    ahead = lambda t, w: w[1] - w[0] + 1e-14  # noqa: E731
    found, t, w = [], 0.0, [0.0, 0.0]
    for law, event in ((locked, torque), (free, ahead), (locked, torque)):
        event.terminal, event.direction = True, -1
        part = solve_ivp(law, (t, 2), w, method="DOP853", rtol=1e-13, atol=1e-15, events=event, max_step=0.05)
        t, w = part.t[-1], part.y[:, -1]
        found.append(t)
    assert times(r, "way", "free") == pytest.approx([found[0], found[2]], abs=2e-12)
    assert times(r, "way", "lock") == pytest.approx([0, found[1]], abs=2e-12)
    assert r["way.torque"][1:3] == pytest.approx([(20 + 0.5 * r["r1.omega"][1]) / 3, 0], abs=1e-9)
    assert list(r["way.locked"]) == [1, 1, 0, 0]
    assert r["way.slip"] == pytest.approx(r["r1.omega"] - r["r0.omega"], abs=1e-15)
    assert r["energy.dissipated"].max() < 1e-12


@nojit
def test_a_clutch_may_name_its_bodies_by_points():
    """It acts on their rotations alone: where the points are means nothing."""
    by_body = flywheels().simulate(0.3, t_eval=[0, 0.3])
    tables = {"way": 'connect = ["r0.C", "r1.C"]\nmodel = "ideal"'}
    by_point = rt.loads(rotors([1, 2], tables, [(0, "10*sin(2*pi*t)"), (1, "-0.5*r1.omega")])).simulate(
        0.3, t_eval=[0, 0.3]
    )
    for name in ("r1.angle", "way.torque", "energy.kinetic"):
        assert list(by_point[name]) == list(by_body[name])


@pytest.mark.machine
@nojit
def test_other_sense_is_the_mirror_image():
    one, two = flywheels().simulate(0.6, **FINE), flywheels("sense = -1", "-10*sin(2*pi*t)").simulate(0.6, **FINE)
    for name in ("r0.omega", "r1.angle", "way.torque"):
        assert two[name] == pytest.approx(-one[name], abs=1e-12)
    assert two["way.slip"] == pytest.approx(one["way.slip"], abs=1e-12)


def converter(load, start=25.0, clutch=""):
    """Weighted arm on a crank; its crosshead swings two rockers against each other, each with a clutch to the rotor."""
    swing = math.asin((0.285**2 - 0.09) / (0.12 * 0.285))
    pins = (
        ("crank.A", "arm.A"),
        ("ground.O", "crank.O"),
        *(("ground.S", f"{b}.S") for b in ("rock1", "rock2", "rotor")),
    )
    joints = "".join(
        f'[joints.p{n}]\ntype = "revolute"\nconnect = ["{a}", "{b}"]\n' for n, (a, b) in enumerate(pins)
    ) + "".join(
        f'[joints.{name}]\ntype = "rod"\nconnect = ["{a}", "{b}"]\nlength = {length}\n'
        for name, a, b, length in (
            ("r0", "arm.B", "head.P", 0.3),
            ("r1", "head.P", "rock1.E", '"sqrt(0.0936)"'),
            ("r2", "head.P", "rock2.E", '"sqrt(0.0936)"'),
        )
    )  # fmt: skip
    body = lambda name, points, mass, inertia, more="": (  # noqa: E731
        f"[bodies.{name}]\npoints = {{ {points} }}\nmass = {mass}\ninertia = {inertia}\n{more}\n"
    )
    return rt.loads(
        "format = 1\ngravity = [0, -9.81]\n[ground.points]\nO = [0, 0]\nG = [0, 0.1]\nS = [0.6, 0.1]\n"
        + body("crank", "O = [0, 0], A = [0.015, 0]", 1, 1)
        + body("arm", "A = [0, 0], B = [0, 0.1]", 1, 0.005, "center = [0, -0.2]")
        + body("head", "P = [0, 0]", 0.05, 1)
        + "".join(body(f"rock{k}", f"S = [0, 0], E = [0, {e}]", 1, 1e-4) for k, e in ((1, 0.06), (2, -0.06)))
        + body("rotor", "S = [0, 0]", 1, 0.5)
        + joints
        + '[joints.rail]\ntype = "prismatic"\nconnect = ["ground.G", "head.P"]\nangle = 0\n'
        + "".join(f'[joints.c{k}]\ntype = "clutch"\nconnect = ["rock{k}", "rotor"]\n{clutch}\n' for k in (1, 2))
        + '[drivers.motor]\njoint = "p1"\nangle = "100*t"\n'
        + f'[loads.brake]\ntype = "torque"\nbody = "rotor"\ntorque = "-({load})"\n'
        + "[initial]\narm = { angle = 0, omega = 0 }\nhead = { x = 0.315 }\n"
        + f"rock1 = {{ angle = {swing} }}\nrock2 = {{ angle = {-swing} }}\nrotor = {{ omega = {start} }}\n"
    )


def test_torque_converter_takes_and_lets_go_as_in_minimal_coordinates():
    """Times and state of an integration in two minimal coordinates with located events (DOP853, 1e-12)."""
    end = 0.2 * math.pi
    r = converter(10).simulate(end, t_eval=[0, end], **FINE)
    changes = sorted((e.t, e.joint, e.kind) for e in r.events if e.kind in ("lock", "free"))[:6]
    assert [one[1:] for one in changes[:4]] == [("c1", "lock"), ("c1", "free"), ("c2", "lock"), ("c2", "free")]
    expected = [0.007152063641, 0.015209807626, 0.036040934592, 0.047868836515, 0.065891575369, 0.078100284999]
    assert [one[0] for one in changes] == pytest.approx(expected, abs=2e-12)
    assert r["rotor.omega"][-1] == pytest.approx(25.212481005, abs=2e-9)
    assert r["arm.omega"][-1] == pytest.approx(5.7082277479, abs=2e-9)
    assert r["energy.work"][-1] + 10 * r["rotor.angle"][-1] == pytest.approx(161.744673579, abs=1e-7)  # of the motor
    assert abs(r["energy.balance"]).max() < 1e-8
    assert r["energy.dissipated"][-1] == 0


def test_time_stepping_converges_at_a_heavy_load():
    """With the row at the middle of the step instead of its end it would create 3 W here."""
    end, model = 0.1, converter(25, 12)
    exact = model.simulate(end, t_eval=[0, end], rtol=1e-10, atol=1e-12)["rotor.omega"][-1]
    r = model.simulate(end, t_eval=[0, end], method="moreau", step=2e-5)
    assert r["rotor.omega"][-1] == pytest.approx(exact, abs=5e-6)
    assert abs(r["energy.balance"][-1]) < 1e-3  # 0.3 J would be created


# ---------------------------------------------------------------- many clutches, by all modes
def reference(inertias, laws, ties, end):
    """Rotors from rest with torques a sin(w t + f) - c v: each piece by SciPy, modes by trying all of them."""
    n = len(inertias)
    rows = np.zeros((len(ties), n))
    for k, (a, b, s) in enumerate(ties):
        rows[k, [i for i in (b,) if i >= 0]] += s
        rows[k, [i for i in (a,) if i >= 0]] -= s
    amplitude, rate, phase, drag = laws

    def motion(t, v, on):
        free = (amplitude * np.sin(rate * t + phase) - drag * v) / inertias
        w = rows[list(on)]
        torque = np.linalg.lstsq(w / inertias @ w.T, -w @ free, rcond=None)[0]
        return free + torque @ w / inertias, torque

    def choose(t, v, still):
        for on in itertools.chain(*(itertools.combinations(still, r) for r in range(len(still) + 1))):
            rest, dt = [k for k in still if k not in on], 1e-7
            a, torque = motion(t, v, on)
            later, pressed = motion(t + dt, v + dt * a, on)
            ahead = rows[rest] @ (v + dt * (a + later) / 2)
            if (np.r_[torque, rows[rest] @ a] > -1e-9).all() and (pressed > -1e-12).all() and (ahead > -1e-13).all():
                return on
        raise AssertionError("no mode fits")

    t, v = 0.0, np.zeros(n)
    on = choose(t, v, range(len(ties)))
    while True:
        events = []
        for k in range(len(ties)):
            at = on.index(k) if k in on else -1
            event = lambda t, v, k=k, at=at, on=on: motion(t, v, on)[1][at] if at >= 0 else rows[k] @ v  # noqa: E731
            event.terminal, event.direction = True, -1
            events.append(event)
        part = solve_ivp(
            lambda t, v, on=on: motion(t, v, on)[0], (t, end), v, "DOP853", rtol=1e-12, atol=1e-13, events=events,
            first_step=1e-4,
        )  # fmt: skip
        t, v = part.t[-1], part.y[:, -1]
        if part.status == 0:
            return v
        who = next(k for k in range(len(ties)) if len(part.t_events[k]))
        still = sorted({k for k in range(len(ties)) if abs(rows[k] @ v) < 1e-9} | set(on) | {who})
        w = rows[still]
        v = v - np.linalg.lstsq(w / inertias @ w.T, w @ v, rcond=None)[0] @ w / inertias
        on = choose(t, v, still)


@pytest.mark.parametrize("seed", [6, 15, 35, 59])
def test_networks_of_clutches_follow_the_only_possible_modes(seed):
    random = np.random.default_rng(seed)
    n, k = int(random.integers(2, 5)), int(random.integers(1, 5))
    inertias = random.uniform(0.5, 2, n)
    torque = random.uniform(2, 10, n) * (random.random(n) < 0.8)
    laws = (torque, random.uniform(2, 9, n), random.uniform(0, 6, n), random.uniform(0.1, 1, n))
    ties = []
    for _ in range(k):
        a, b = random.choice(n + 1, 2, replace=False) - 1
        ties.append((int(a), int(b), int(random.choice([-1, 1]))))
    name = lambda i: "ground" if i < 0 else f"r{i}"  # noqa: E731
    tables = {f"c{j}": f'connect = ["{name(a)}", "{name(b)}"]\nsense = {s}' for j, (a, b, s) in enumerate(ties)}
    law = [f"{a!r}*sin({w!r}*t + {f!r}) - {c!r}*r{i}.omega" for i, (a, w, f, c) in enumerate(np.array(laws).T.tolist())]
    r = rt.loads(rotors(inertias, tables, enumerate(law))).simulate(3.0, t_eval=[0, 3.0], **FINE)
    assert [r[f"r{i}.omega"][-1] for i in range(n)] == pytest.approx(reference(inertias, laws, ties, 3.0), abs=1e-9)


@pytest.mark.machine
@nojit
def test_a_run_says_how_often_a_clutch_locks_and_what_it_bears():
    r = rt.example("ratchet").simulate()
    locks = sum(event.kind == "lock" and event.joint == "drive" for event in r.events)
    assert locks > 1
    (line,) = [line for line in contact_lines(r) if line.startswith("drive: ")]
    assert f"locks {locks} times" in line
    assert f"largest torque {r.peak('drive.torque')[0]:.4g} N*m" in line


def test_body_at_rest_without_load_does_not_make_clutches_change_without_end():
    ties = {"c0": 'connect = ["r0", "r1"]', "c1": 'connect = ["ground", "r0"]', "c2": 'connect = ["r1", "ground"]'}
    r = rt.loads(rotors([1, 1], ties, [(1, "sin(3*t)")])).simulate(2.0, rtol=1e-9)
    assert r.success
    assert abs(r["r0.omega"]).max() < 1e-12  # c1 and c2 hold r1 >= r0 >= 0 >= r1


# ---------------------------------------------------------------- starts, impacts, contacts
@pytest.mark.parametrize("method", ["event", "moreau"])
def test_driving_body_that_starts_ahead_takes_the_other_along_without_bounce(method):
    m = flywheels(push="0", drag="0", initial="r0 = { omega = 3 }")
    r = m.simulate(0.1, method=method, t_eval=[0, 0.1])
    assert r["r0.omega"][-1] == pytest.approx(1)
    assert r["r1.omega"][-1] == pytest.approx(1)
    assert r["energy.dissipated"][-1] == pytest.approx(3)  # of 4.5 J


def struck(table, sense):
    """Rotor r1 runs into a stop (e = 0.5); r0, with which it turns, is behind a clutch of one sense or the other."""
    text = rotors(
        [1, 2],
        {"way": f'connect = ["r0", "r1"]\nsense = {sense}\n{table}'},
        initial="r0 = { omega = 1 }\nr1 = { omega = 1 }",
    )
    stop = 'stop = { max = 0.5, contact = { model = "impact", restitution = 0.5 } }'
    return rt.loads(text.replace('["ground.O", "r1.C"]', f'["ground.O", "r1.C"]\n{stop}'))


@nojit
def test_impact_of_another_joint_goes_through_a_clutch_in_its_sense_only():
    r = struck("", 1).simulate(0.6, rtol=1e-10)  # r1 is thrown back to -0.5, and r0 must not get ahead of it
    assert [r["r0.omega"][-1], r["r1.omega"][-1]] == pytest.approx([-0.5, -0.5], abs=1e-9)
    r = struck("", -1).simulate(0.6, rtol=1e-10)  # r0 may go on
    assert [r["r0.omega"][-1], r["r1.omega"][-1]] == pytest.approx([1, -0.5], abs=1e-9)


@nojit
def test_clutch_with_a_largest_torque_passes_no_impulse():
    r = struck("max_torque = 2", 1).simulate(0.6, t_eval=[0, 0.5 + 1e-9, 0.6], rtol=1e-10)
    assert [r["r0.omega"][1], r["r1.omega"][1]] == pytest.approx([1, -0.5], abs=1e-7)
    assert [r["r0.omega"][-1], r["r1.omega"][-1]] == pytest.approx([1 - 0.2, -0.5 + 0.1], abs=1e-7)


# ---------------------------------------------------------------- slipping
@nojit
def test_clutch_slips_at_its_largest_torque_until_the_rates_are_equal():
    m = flywheels("max_torque = 3", "0", "-0.5", "r0 = { omega = 10 }")
    r = m.simulate(4, t_eval=[0, 1, 4], **FINE)
    assert r["r0.omega"][1:] == pytest.approx([7, 8 / 3], abs=1e-11)
    assert r["r1.omega"][1:] == pytest.approx([1.25, 8 / 3], abs=1e-11)
    assert r["way.torque"] == pytest.approx([3, 3, 1 / 6], abs=1e-10)
    assert list(r["way.locked"]) == [0, 0, 1]
    slips = 10 / 4.25  # s, from 10 rad/s
    assert times(r, "way", "lock") == pytest.approx([slips], abs=1e-11)
    assert r["energy.dissipated"][-1] == pytest.approx(3 * 5 * slips, abs=1e-9)
    assert abs(r["energy.balance"]).max() < 1e-9


@nojit
def test_clutch_breaks_away_where_more_than_its_largest_torque_is_needed():
    """Held, it passes 2/3 of the torque 9 t: 3 N m at 0.5 s, and then r0 gets ahead at the rate (9 t - 4.5)/1 - ..."""
    r = flywheels("max_torque = 3", "9*t", "0").simulate(1.0, t_eval=[0, 0.4, 1], **FINE)
    assert times(r, "way", "slip") == pytest.approx([0.5], abs=1e-11)
    assert r["way.torque"] == pytest.approx([0, 2.4, 3], abs=1e-9)
    w = 1.5 * 0.25  # of both at 0.5 s
    assert [r["r0.omega"][-1], r["r1.omega"][-1]] == pytest.approx([w + 4.5 * 0.75 - 1.5, w + 0.75], abs=1e-10)


@nojit
def test_slipping_converges_in_time_stepping():
    m = flywheels("max_torque = 3", "8*sin(2*pi*t)", "-0.5", "r0 = { omega = 10 }")
    exact = m.simulate(3.0, t_eval=[0, 3.0], **FINE)["r0.omega"][-1]
    error = [
        abs(m.simulate(3.0, t_eval=[0, 3.0], method="moreau", step=h)["r0.omega"][-1] - exact) for h in (8e-3, 2e-3)
    ]
    assert error[0] < 0.05
    assert error[1] < 0.01


# ---------------------------------------------------------------- oil and wind-up
@nojit
def test_viscous_clutch_is_a_damper_in_one_sense():
    """Locked: w0 - w1 decays with the rate c (1/J0 + 1/J1) to a constant lag; free: nothing."""
    m = flywheels('model = "viscous"\ndamping = 4', "0", "0", "r0 = { omega = 3 }")
    r = m.simulate(1.0, **FINE)
    lag = 3 * np.exp(-6 * r.t)
    assert r["r0.omega"] == pytest.approx(1 + 2 / 3 * lag, abs=1e-9)
    assert r["way.torque"] == pytest.approx(4 * lag, abs=1e-8)
    assert r["energy.dissipated"] == pytest.approx(3 * (1 - np.exp(-12 * r.t)), abs=1e-9)  # tau^2/c
    r = flywheels('model = "viscous"\ndamping = 4', "-1", "0").simulate(1.0)
    assert r["way.torque"].max() == 0
    assert times(r, "way", "lock") == []


@pytest.mark.machine
@nojit
def test_viscous_clutch_changes_where_the_rates_are_equal():
    r = flywheels('model = "viscous"\ndamping = 1000').simulate(1.6, t_eval=[0, 1.6], rtol=1e-10, atol=1e-12)
    law = lambda t, w: [  # noqa: E731
        10 * math.sin(2 * math.pi * t) - 1000 * max(0, w[0] - w[1]),
        (1000 * max(0, w[0] - w[1]) - 0.5 * w[1]) / 2,
    ]
    y = solve_ivp(law, (0, 1.6), [0, 0], "LSODA", rtol=1e-11, atol=1e-13, max_step=1e-3).y[:, -1]
    assert [r["r0.omega"][-1], r["r1.omega"][-1]] == pytest.approx(y, abs=1e-7)
    assert abs(r["energy.balance"][-1]) < 1e-6


@nojit
def test_compliant_clutch_winds_up_and_lets_go_where_its_torque_is_zero():
    """Half a swing of the relative angle, of frequency sqrt(k (1/J0 + 1/J1)); then what x is left is lost."""
    k, c = 600.0, 6.0
    m = flywheels(f'model = "compliant"\nstiffness = {k}\ndamping = {c}', "0", "0", "r0 = { omega = 3 }")
    r = m.simulate(0.3, **FINE)
    decay, natural = 1.5 * c / 2, math.sqrt(1.5 * k)
    w = math.sqrt(natural**2 - decay**2)
    x = lambda t: 3 / w * math.exp(-decay * t) * math.sin(w * t)  # noqa: E731
    v = lambda t: 3 * math.exp(-decay * t) * (math.cos(w * t) - decay / w * math.sin(w * t))  # noqa: E731
    goes = (math.pi - math.atan2(w * c, k - c * decay)) / w  # k x + c x' = 0
    assert k * x(goes) + c * v(goes) == pytest.approx(0, abs=1e-9)
    assert times(r, "way", "free") == pytest.approx([goes], abs=1e-9)
    assert r["way.slip"][-1] == pytest.approx(-v(goes), abs=2e-8)
    lost = 0.5 * 2 / 3 * (9 - v(goes) ** 2)  # all that relative motion has lost, with the rest of x
    assert r["energy.dissipated"][-1] == pytest.approx(lost, abs=5e-8)
    assert abs(r["energy.balance"]).max() < 1e-8


# ---------------------------------------------------------------- ratchet
def rocking(teeth=24, method=None, end=1.6):
    """Arm -+20 deg, pawl, wheel of 1e-3 kg m^2 that an ideal clutch holds against its load."""
    ties = {"pawl": f'connect = ["r0", "r1"]\nmodel = "ratchet"\nteeth = {teeth}', "hold": 'connect = ["ground", "r1"]'}
    drive = '[drivers.arm]\njoint = "pin0"\nangle = "20/180*pi*sin(10*t)"\n'
    text = rotors([1, 1e-3], ties, [(1, "-0.5 - 0.1*r1.omega")], f"r1 = {{ omega = {math.pi / 0.9!r} }}", drive)
    return rt.loads(text).simulate(end, t_eval=np.array([0, 1, 3, 5]) * 0.1 * math.pi, method=method, rtol=1e-9)


@pytest.mark.parametrize(("method", "accuracy"), [("event", 1e-6), ("moreau", 0.02)])
def test_ratchet_goes_on_by_whole_teeth(method, accuracy):
    """First 20 deg; then floor(40/15) = 2 teeth a swing, after 10 deg of lost motion."""
    r = rocking(method=method)
    assert np.degrees(r["r1.angle"]) == pytest.approx([0, 20, 50, 80], abs=accuracy)


@nojit
def test_ratchet_may_start_behind_any_of_its_teeth():
    """Whole pitches behind or ahead of where it is given, it moves alike."""
    m = rt.example("ratchet")
    pitch, t = 360.0 / m.parameters["teeth"], np.linspace(0.0, 0.05, 6)
    turned = [
        m.set({"initial.wheel.angle": f"{angle!r} deg"}).simulate(t_eval=t)["wheel.angle"] - math.radians(angle)
        for angle in (-3.0, pitch - 3.0, -2.0 * pitch - 3.0)
    ]
    np.testing.assert_allclose(turned[1:], [turned[0]] * 2, atol=1e-9)


def test_pick_up_of_a_ratchet_is_an_impact_at_its_tooth():
    r = rocking()
    first = next(event for event in r.events if event.joint == "pawl" and event.kind == "impact")
    when = (math.pi + math.asin(0.5)) / 10 + math.pi / 10 - 2 * math.asin(0.5) / 10  # the arm is at -10 deg, rising
    assert first.t == pytest.approx(when, abs=1e-9)
    assert first.normal_speed == pytest.approx(20 / 180 * math.pi * 10 * math.cos(math.asin(0.5)), abs=1e-8)
    assert abs(r["energy.balance"]).max() < 1e-5


# ---------------------------------------------------------------- other analyses, bad input
@nojit
def test_analyses_that_cannot_know_the_torque_say_so():
    for table in ("", 'model = "compliant"\nstiffness = 10', 'model = "ratchet"\nteeth = 8'):
        for ask in (lambda m: m.equilibrium(), lambda m: m.modes()):
            with pytest.raises(ModelError, match="'way': a clutch that holds"):
                ask(flywheels(table))
    oil = flywheels('model = "viscous"\ndamping = 3', "0")
    assert len(oil.equilibrium())
    with pytest.raises(ModelError, match="small motion"):
        oil.modes()


DRIVEN = '[drivers.a]\njoint = "pin0"\nangle = "sin(t)"\n[drivers.b]\njoint = "pin1"\nangle = "0.5*t"\n'


@nojit
def test_given_motion_against_the_sense_of_a_clutch_is_noted():
    m = rt.loads(rotors([1, 2], {"way": 'connect = ["r0", "r1"]'}, more=DRIVEN))
    notes = m.kinematics(np.linspace(0, 3, 7)).trust.notes
    assert any("clutch 'way' does not allow this motion: at 3 of 7 instants, first at t = 0 s" in one for one in notes)
    with pytest.raises(ModelError, match="inverse dynamics does not determine the torque of 'way'"):
        m.inverse_dynamics([0, 1])
    m = rt.loads(rotors([1, 2], {"way": 'connect = ["r0", "r1"]\nmodel = "viscous"\ndamping = 3'}, more=DRIVEN))
    r = m.inverse_dynamics(np.linspace(0, 3, 7))
    assert r["way.torque"] == pytest.approx(3 * np.maximum(np.cos(r.t) - 0.5, 0), abs=1e-12)
    assert r["b.torque"] == pytest.approx(-r["way.torque"], abs=1e-12)


@nojit
@pytest.mark.parametrize(
    ("table", "path", "said"),
    [
        ('connect = ["r0", "r0"]', "joints.way.connect", "both ends are on 'r0'"),
        ('connect = ["ground", "ground"]', "joints.way.connect", "both ends are on 'ground'"),
        ('connect = ["r0.D", "r1"]', "joints.way.connect[0]", "no point 'D' on body 'r0'"),
        ('connect = ["r0", "r7"]', "joints.way.connect[1]", "no body 'r7'"),
        ("", "joints.way", 'needs connect = ["body", "body"]'),
        ('connect = ["r0", "r1"]\nmodel = "oily"', "joints.way.model", "expected one of ideal, viscous"),
        ('connect = ["r0", "r1"]\nmodel = "viscous"', "joints.way", 'model = "viscous" needs damping'),
        ('connect = ["r0", "r1"]\nmodel = "compliant"', "joints.way", "needs stiffness"),
        ('connect = ["r0", "r1"]\nmodel = "ratchet"', "joints.way", "needs teeth"),
        ('connect = ["r0", "r1"]\nmodel = "ratchet"\nteeth = 7.5', "joints.way.teeth", "whole number of teeth"),
        ('connect = ["r0", "r1"]\nsense = 2', "joints.way.sense", "expected 1 (counter-clockwise) or -1"),
        ('connect = ["r0", "r1"]\ndamping = 2', "joints.way.damping", 'model = "ideal" has no damping'),
        ('connect = ["r0", "r1"]\nmodel = "viscous"\ndamping = 1\nmax_torque = 2', "way.max_torque", "has no max_t"),
        ('connect = ["r0", "r1"]\nmodel = "viscous"\ndamping = -1', "joints.way.damping", "must be positive"),
        ('connect = ["r0", "r1"]\nmax_torque = 0', "joints.way.max_torque", "must be positive"),
    ],
)  # fmt: skip
def test_bad_clutch_is_refused_at_its_place(table, path, said):
    with pytest.raises(ModelError) as caught:
        rt.loads(rotors([1, 1], {"way": table}))
    assert path in str(caught.value)
    assert said in str(caught.value)


@nojit
@pytest.mark.parametrize(("sense", "taken"), [(1, True), (-1, False)])
def test_impact_of_another_joint_engages_a_viscous_clutch(sense, taken):
    """From the impact on the lag 1.5 rad/s decays with the rate c (1/J0 + 1/J1), which gives no impulse."""
    c, late = 4.0, 0.1
    r = struck(f'model = "viscous"\ndamping = {c}', sense).simulate(0.5 + late, t_eval=[0, 0.5 + late], rtol=1e-10)
    lag = 1.5 * math.exp(-c * (1 / 1 + 1 / 2) * late) if taken else 1.5
    assert r["r0.omega"][-1] - r["r1.omega"][-1] == pytest.approx(lag, abs=1e-8)
    assert r["r0.omega"][-1] + 2 * r["r1.omega"][-1] == pytest.approx(0.0, abs=1e-9)  # momentum after the impact
    assert times(r, "way", "lock") == pytest.approx([0.5] if taken else [], abs=1e-6)


@nojit
def test_smooth_clutch_brakes_beside_a_rigid_one():
    """r0 drives r1 rigidly, or lags; r1 drags on the ground by oil: against SciPy, mode after mode."""
    ties = {"one": 'connect = ["r0", "r1"]', "two": 'connect = ["r1", "ground"]\nmodel = "viscous"\ndamping = 1.5'}
    end, push = 1.6, lambda t: 10 * math.sin(2 * math.pi * t)
    r = rt.loads(rotors([1, 2], ties, [(0, "10*sin(2*pi*t)")])).simulate(end, t_eval=[0, end], **FINE)
    locked = lambda t, w: 2 * [(push(t) - 1.5 * w[0]) / 3]  # noqa: E731
    free = lambda t, w: [push(t), -0.75 * w[1]]  # noqa: E731
    torque = lambda t, w: push(t) - locked(t, w)[0]  # noqa: E731
    ahead = lambda t, w: w[1] - w[0]  # noqa: E731
    torque.terminal = ahead.terminal = True
    torque.direction = ahead.direction = -1
    t, w, lets_go = 0.0, np.zeros(2), []
    for mode, event in 3 * [(locked, torque), (free, ahead)]:
        piece = solve_ivp(mode, (t, end), w, rtol=1e-12, atol=1e-14, events=event)
        t, w = piece.t[-1], piece.y[:, -1]
        lets_go += [t] if mode is locked and t < end else []
        if t >= end:
            break
    assert w.min() > 0.0  # the oil holds all the time
    assert times(r, "one", "free") == pytest.approx(lets_go, abs=1e-9)
    assert [r["r0.omega"][-1], r["r1.omega"][-1]] == pytest.approx(list(w), abs=1e-8)
    assert abs(r["energy.balance"]).max() < 1e-9


REST = {
    "of oil": 'model = "viscous", damping = 0.4',
    "elastic": 'model = "compliant", stiffness = 200, damping = 1',
}


@pytest.mark.parametrize("name", REST)
def test_a_clutch_between_what_friction_holds_neither_takes_nor_lets_go_by_rounding(name):
    """A wheel with its weight beside its middle is turned against its stop by gears, another hangs still."""
    run = rt.loads(f"""
format = 1
gravity = [0, -9.81]
ground.points = {{ O = [0, 0], P = [0.15, 0], Q = [1, 0] }}
bodies.g = {{ points = {{ C = [0, 0] }}, mass = 1, inertia = 0.01 }}
bodies.h = {{ points = {{ C = [0, 0] }}, center = [0, 0.03], mass = 1, inertia = 0.02 }}
bodies.p = {{ points = {{ O = [0, 0] }}, center = [0.1, 0], mass = 1, inertia = 0.02 }}
joints.mesh = {{ type = "gear", connect = ["g.C", "h.C"], radii = [0.05, 0.1] }}
joints.C = {{ type = "clutch", connect = ["h", "p"], {REST[name]} }}
loads.m = {{ type = "torque", body = "g", torque = "2.9132*sin(2*t + 2)" }}
loads.n = {{ type = "torque", body = "h", torque = "2.9132*sin(14*t + 0.5)" }}
initial = {{ g = {{ angle = 0, omega = 0 }}, h = {{ angle = 0 }}, p = {{ angle = -1.57, omega = 0 }} }}
[joints.G]
type = "revolute"
connect = ["ground.O", "g.C"]
stop = {{ min = -0.5, max = 0.6, contact = {{ model = "impact", restitution = 0.3 }} }}
[joints.Hh]
type = "revolute"
connect = ["ground.P", "h.C"]
friction = {{ model = "coulomb", mu = 0.49466, mu_static = 0.74199, pin_radius = "15 mm" }}
stop = {{ min = -0.35, max = 0.25, contact = {{ model = "impact", restitution = 0 }} }}
[joints.Hp]
type = "revolute"
connect = ["ground.Q", "p.O"]
friction = {{ model = "coulomb", mu = 0.49466, pin_radius = "15 mm" }}
""").simulate(t_end=0.6, rtol=1e-10)
    assert run.success
    assert len([event for event in run.events if event.joint == "C"]) < 50
    assert run.stats["steps"] < 2000
