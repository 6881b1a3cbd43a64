"""Gravity and points of the ground over time: a shaken frame is one in which gravity is that much larger."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import rattle as rt
from rattle.drawings.forms import display_list

SHAKE, W = 0.03, 22.0  # more than gravity
STILL = f'[0, "-9.81 + {SHAKE}*{W}*{W}*sin({W}*t)"]'
BLOCK = "bodies.s = { points = { P = [0, 0] }, mass = 2, inertia = 1 }\n"
BOB = "bodies.bob = { points = { O = [0, 0.3] }, center = [0, 0], mass = 1.3, inertia = 0.02 }\n"
RIGID = '{ model = "impact", restitution = 0.5 }'
SOFT = '{ model = "hertz", stiffness = 1e5, exponent = 1, restitution = 0.5 }'


def head(points, gravity="[0, -9.81]"):
    return f"format = 1\ngravity = {gravity}\nground.points = {{ {points} }}\n"


def rail(stop):
    return (
        f'joints.rail = {{ type = "prismatic", connect = ["ground.O", "s.P"], axis = "90 deg"{stop} }}\n'
        'loads.k = { type = "spring", connect = ["ground.A", "s.P"], stiffness = 300, free_length = 0.4, damping = 3 }'
        "\n"
    )


def pin(more):
    return f'joints.O = {{ type = "revolute", connect = ["ground.O", "bob.O"]{more} }}\n'


def table(contact):
    block = "bodies.s = { points = { P = [-0.1, -0.05], Q = [0.1, -0.05] }, center = [0, 0], mass = 2, inertia = 0.01 }"
    floor = 'type = "surface", connect = ["ground.O", "s.P"], axis = "0 deg", corners = ["P", "Q"]'
    return f"{block}\njoints.floor = {{ {floor}, contact = {contact} }}\n"


ON_TABLE = f"s = {{ y = 0.05, vy = {SHAKE * W}, omega = 0 }}", "s = { y = 0.05, vy = 0, omega = 0 }"
SHAKEN = {  # parts, start of the shaken mechanism, start in its frame
    "spring": (BLOCK + rail(""), "s = { y = 0.02, vy = 0 }", f"s = {{ y = 0.02, vy = {-SHAKE * W} }}"),
    "rigid stop": (
        BLOCK + rail(f", stop = {{ min = -0.03, contact = {RIGID} }}"),
        "s = { y = 0.02, vy = 0 }", f"s = {{ y = 0.02, vy = {-SHAKE * W} }}",
    ),
    "soft stop": (
        BLOCK + rail(f", stop = {{ min = -0.03, contact = {SOFT} }}"),
        "s = { y = 0.02, vy = 0 }", f"s = {{ y = 0.02, vy = {-SHAKE * W} }}",
    ),
    "rubbing pin": (
        BOB + pin(', friction = { mu = 0.3, pin_radius = "20 mm" }'),
        "bob = { angle = 0.4, omega = 0 }", "bob = { angle = 0.4, omega = 0 }",
    ),
    "play": (
        BOB + pin(f', clearance = "1 mm", contact = {RIGID}'),
        f"bob = {{ angle = 0.4, omega = 0, vx = 0, vy = {SHAKE * W} }}",
        "bob = { angle = 0.4, omega = 0, vx = 0, vy = 0 }",
    ),
    "box on a shaken table": (table('{ model = "impact", restitution = 0.3, friction = 0.2 }'), *ON_TABLE),
    "box on a shaken soft table": (table(SOFT), *ON_TABLE),
    "massless link": (
        BOB + pin(', clearance = "1 mm"'), "bob = { angle = 0.4, omega = 0 }", "bob = { angle = 0.4, omega = 0 }"
    ),
}  # fmt: skip


def shaken_and_still(parts, start, start_in_frame):
    points = f'O = [0, "{SHAKE}*sin({W}*t)"], A = [0, "-0.4 + {SHAKE}*sin({W}*t)"]'
    shaken = rt.loads(head(points) + parts + f"initial.{start}\n")
    return shaken, rt.loads(head("O = [0, 0], A = [0, -0.4]", STILL) + parts + f"initial.{start_in_frame}\n")


@pytest.mark.parametrize("case", SHAKEN)
def test_a_shaken_ground_is_a_change_of_gravity_in_its_frame(case):
    t = np.linspace(0, 0.5, 6)
    runs = [m.simulate(0.5, t_eval=t, rtol=1e-10, atol=1e-12) for m in shaken_and_still(*SHAKEN[case])]
    body = "s" if "s.y" in runs[0].names else "bob"
    lifted = runs[0][f"{body}.y"] - SHAKE * np.sin(W * t)
    np.testing.assert_allclose(lifted, runs[1][f"{body}.y"], atol=1e-7)  # of contacts, which double errors
    np.testing.assert_allclose(runs[0][f"{body}.angle"], runs[1][f"{body}.angle"], atol=1e-6)
    for run in runs:
        assert run.success
        assert np.abs(run["energy.balance"]).max() < 1e-8
    assert len(runs[0].events) == len(runs[1].events)


@pytest.mark.parametrize("method", ["dop853", "radau", "event", "moreau", "rk4"])
def test_a_shaken_pendulum_follows_its_equation(method):
    times, how = [0, 0.3, 0.7], {"step": 5e-5} if method in ("moreau", "rk4") else {"rtol": 1e-10, "atol": 1e-12}
    m = rt.loads(
        head('O = ["0.02*sin(25*t)", "0.05*sin(40*t)"]') + BOB + pin("") + "initial.bob = { angle = 0.6, omega = 0 }\n"
    )
    run = m.simulate(0.7, t_eval=times, method=method, **how)

    def swing(t, y):  # of a point pendulum with moment of inertia, about a pivot that moves
        ax, ay = -0.02 * 625 * np.sin(25 * t), -0.05 * 1600 * np.sin(40 * t)
        c, s = np.cos(y[0]), np.sin(y[0])
        return [y[1], -1.3 * 0.3 * (ax * c + (9.81 + ay) * s) / (0.02 + 1.3 * 0.09)]

    exact = solve_ivp(swing, (0, 0.7), [0.6, 0.0], t_eval=times, rtol=1e-11, atol=1e-13).y
    np.testing.assert_allclose(run["bob.angle"], exact[0], atol=1e-6 if method == "moreau" else 1e-8)
    work = run["energy.kinetic"] + run["energy.potential"]
    slack = 1e-4 if method == "moreau" else 1e-7  # its energy is that of the middle of steps
    np.testing.assert_allclose(work - work[0], run["energy.work"], atol=slack)


def test_position_rate_and_acceleration_of_a_ground_point_are_exact():
    m = rt.loads(
        head('O = ["0.1*t**2", "0.05*sin(40*t)"]') + BOB + pin("") + 'drivers.m = { joint = "O", angle = "0" }\n'
    )
    t = np.array([0.0, 0.2, 0.35])
    for moved in (m.kinematics(t), m.inverse_dynamics(t), m.simulate(0.35, t_eval=t)):
        np.testing.assert_allclose(moved["bob.x"], 0.1 * t**2, atol=1e-12)
        np.testing.assert_allclose(moved["bob.y"], 0.05 * np.sin(40 * t) - 0.3, atol=1e-12)
        np.testing.assert_allclose(moved["bob.vy"], 2 * np.cos(40 * t), atol=1e-11)
        np.testing.assert_allclose(moved["bob.ax"], 0.2, atol=1e-10)
        np.testing.assert_allclose(moved["bob.ay"], -80 * np.sin(40 * t), atol=1e-9)
    forces = m.inverse_dynamics(t)
    np.testing.assert_allclose(forces["O.fy"], 1.3 * (9.81 - 80 * np.sin(40 * t)), atol=1e-8)
    np.testing.assert_allclose(forces["ground.O.y.force"], forces["O.fy"], atol=1e-9)  # what moves it bears the pin


def test_a_loop_closes_the_same_way_over_a_ground_point_that_moves():
    fourbar = """
bodies.crank = { bar = ["O", "B"], length = 0.1, mass = 1 }
bodies.rod = { bar = ["B", "C"], length = 0.35, mass = 1 }
bodies.rocker = { bar = ["C", "A"], length = 0.25, mass = 1 }
joints.O = { type = "revolute", connect = ["ground.O", "crank.O"] }
joints.B = { type = "revolute", connect = ["crank.B", "rod.B"] }
joints.C = { type = "revolute", connect = ["rod.C", "rocker.C"] }
joints.A = { type = "revolute", connect = ["ground.A", "rocker.A"] }
drivers.m = { joint = "O", angle = "0.7 + 5*t" }
"""
    fixed, moving = (
        rt.loads(head(f"O = [0, 0], A = {at}") + fourbar) for at in ("[0.4, 0]", '["0.4 - 0.1*t", "0.2*t"]')
    )
    np.testing.assert_allclose(moving.start.q[: len(fixed.start.q)], fixed.start.q, atol=1e-12)
    assert moving.check().loops == fixed.check().loops
    assert (moving.check().bodies, moving.check().mobility) == (3, 0)
    t = np.linspace(0, 0.5, 6)
    moved = moving.kinematics(t)
    a = np.array([0.4 - 0.1 * t, 0.2 * t])
    c = np.array([moved["rod.C.x"], moved["rod.C.y"]])
    np.testing.assert_allclose(np.hypot(*(c - a)), 0.25, atol=1e-12)
    np.testing.assert_allclose(
        c - a, -0.25 * np.array([np.cos(moved["rocker.angle"]), np.sin(moved["rocker.angle"])]), atol=1e-12
    )


def test_derivatives_by_parameters_of_gravity_and_ground_points():
    text = head('O = ["a*sin(5*t)", 0]', '["g*sin(3*t)", "-g"]') + "parameters = { a = 0.1, g = 9.0 }\n" + BOB + pin("")
    m = rt.loads(text + "initial.bob = { angle = 0.2, omega = 0 }\n")
    times, exact = [0, 0.5, 1.0], {"rtol": 1e-11, "atol": 1e-13}
    slopes = m.sensitivity(["bob.angle"], ["a", "g"], times, rtol=1e-9)
    for name, value in (("a", 0.1), ("g", 9.0)):
        ahead, behind = (
            m.set({name: value + h}).simulate(1.0, t_eval=times, **exact)["bob.angle"] for h in (1e-4, -1e-4)
        )
        np.testing.assert_allclose(slopes[f"d(bob.angle)/d({name})"], (ahead - behind) / 2e-4, atol=1e-6)
    many = m.many({"a": [0.05, 0.2]}, ["final(bob.angle)"], 1.0, rtol=1e-10)
    alone = [m.set({"a": a}).simulate(1.0, t_eval=[0, 1.0], **exact)["bob.angle"][-1] for a in (0.05, 0.2)]
    np.testing.assert_allclose(many["final(bob.angle)"], alone, atol=1e-8)


@pytest.mark.parametrize("method", ["dop853", "radau", "event", "moreau"])
def test_the_change_of_gravity_is_work_also_where_it_jumps(method):
    m = rt.loads(
        head("O = [0, 0]", '[0, "-9.81*step(t - 0.5)"]')
        + "bodies.b = { points = { P = [0, 0] }, mass = 2, inertia = 1 }\ninitial.b = { y = 3, vy = 1 }\n"
    )
    run = m.simulate(1.0, t_eval=[0, 0.4, 1.0], method=method, **({"step": 1e-3} if method == "moreau" else {}))
    assert run["b.y"][-1] == pytest.approx(4 - 0.5 * 9.81 * 0.25, abs=1e-8)
    np.testing.assert_allclose(run["energy.work"], [0, 0, 2 * 9.81 * 3.5], atol=1e-7)  # m dg y, at its height then
    np.testing.assert_allclose(run["energy.potential"], [0, 0, 2 * 9.81 * run["b.y"][-1]], atol=1e-7)
    assert np.abs(run["energy.balance"]).max() < 1e-9


@pytest.mark.parametrize("method", ["dop853", "radau"])
def test_the_work_of_gravity_is_counted_where_nothing_moves(method):
    held = "bodies.s = { points = { P = [0, -0.5] }, center = [0, 0], mass = 2, inertia = 1 }\n"
    held += 'joints.A = { type = "fixed", connect = ["ground.O", "s.P"] }\n'
    m = rt.loads(head("O = [0, 0]", '[0, "-9.81 + sin(12*t)"]') + held)
    run = m.simulate(20.0, t_eval=[0, 20.0], method=method, rtol=1e-8)
    change = -2 * 0.5 * np.sin(240.0)  # of -m g y, y = 0.5
    assert run["energy.work"][-1] == pytest.approx(change, abs=1e-6)
    assert np.abs(run["energy.balance"]).max() < 1e-6


def test_books_of_power_close_with_gravity_over_time():
    m = rt.loads(
        head("O = [0, 0]", '["3*sin(4*t)", "-9.81 + 5*t"]')
        + BOB
        + pin("")
        + "initial.bob = { angle = 0.3, omega = 0 }\n"
    )
    run = m.simulate(1.0, rtol=1e-10, atol=1e-12)
    power = run.power()
    assert power.residual < 1e-8
    (gravity,) = [row for row in power.balance() if row[0] == "gravity"]
    _, _, supplied, _, stored, _ = gravity
    assert supplied == pytest.approx(run["energy.work"][-1], abs=1e-8)
    assert stored == pytest.approx(run["energy.potential"][-1] - run["energy.potential"][0], abs=1e-8)


def test_equilibrium_takes_gravity_and_ground_points_at_the_start():
    m = rt.loads(head('O = ["0.2 + t", 0]', '["1 + t", "-1 - t**2"]') + BOB + pin(""))
    rest = next(one for one in m.equilibrium() if one.stable)
    assert rest.t == 0.0
    assert rest["bob.angle"] == pytest.approx(np.pi / 4, abs=1e-9)
    assert rest["bob.x"] == pytest.approx(0.2 + 0.3 * np.sin(np.pi / 4), abs=1e-9)
    later = next(one for one in m.equilibrium(t=1.0) if one.stable)  # unless another instant is asked for
    assert later["bob.angle"] == pytest.approx(np.pi / 4, abs=1e-9)
    assert later["bob.x"] == pytest.approx(1.2 + 0.3 * np.sin(np.pi / 4), abs=1e-9)


def test_a_ground_point_that_jumps_is_refused_and_one_that_jolts_strikes():
    with pytest.raises(rt.ModelError, match=r"ground\.points\.O\[1\]: driver 'ground\.O\.y' jumps by 0\.05 m"):
        rt.loads(head('O = [0, "0.05*step(t - 0.5)"]') + BOB + pin("")).simulate(1.0)
    run = rt.loads(head('O = ["0.5*max(0, t - 0.5)", 0]') + BOB + pin("")).simulate(1.0, t_eval=[0, 0.5])
    struck = -0.5 * 1.3 * 0.3 / (0.02 + 1.3 * 0.09)  # rate after the pivot of a pendulum at rest is struck
    assert run["bob.omega"][-1] == pytest.approx(struck, rel=1e-9)
    assert np.abs(run["energy.balance"]).max() < 1e-10


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (head("O = [0, 0]", '["bob.x", 0]'), "gravity[0]: gravity must depend on time only, but 'bob.x' depends"),
        (head("O = [0, 0]", '[0, "z"]'), "gravity[1]: gravity must depend on time only, but 'z' is a state"),
        (head("O = [0, 0]", '[0, "log(t)"]'), "gravity[1]: the result is not a finite number"),
        (head('O = [0, "bob.y"]'), "ground.points.O[1]: a point of the ground must depend on time only"),
        (head('O = ["1/t", 0]'), "ground.points.O[0]: the result is not a finite number"),
        (head('O = ["5 s", 0]'), "ground.points.O[0]: '5 s' is a time; expected a length"),
    ],
)  # fmt: skip
def test_what_is_no_function_of_time_alone_is_refused(text, words):
    with pytest.raises(rt.ModelError) as caught:
        rt.loads(text + BOB + pin("") + 'states.z = { rate = "1" }\n')
    assert words in str(caught.value)


def test_a_ground_point_that_moves_is_ground_to_the_rest_of_the_model():
    moving = head('O = ["t", 0], P = [0, 0]') + BOB + pin("")
    for more, words in (
        ('drivers.d = { body = "ground.O", coordinate = "x", position = 1 }\n', "the ground does not move"),
        ('initial."ground.O" = { x = 1 }\n', "no body or clearance joint 'ground.O'"),
        (
            'loads.k = { type = "spring", connect = ["ground.O", "ground.P"], stiffness = 1 }\n',
            "both ends are on 'ground'",
        ),
    ):
        with pytest.raises(rt.ModelError, match=words):
            rt.loads(moving + more)
    seen = rt.loads(moving + 'signals.ahead = "ground.O.x - bob.x"\nsignals.v = "ground.O.vx"\n')
    run = seen.simulate(1.0, t_eval=[0, 1.0])
    np.testing.assert_allclose(run["ahead"], run["ground.O.x"] - run["bob.x"], atol=1e-12)
    np.testing.assert_allclose(run["v"], 1.0, atol=1e-12)


def test_a_ground_point_that_moves_is_drawn_as_a_foot_that_moves():
    drawn = display_list(rt.loads(head('O = ["t", 0]') + BOB + pin("")).simulate(0.1).geometry)["drawn"]
    assert [one["frame"] for one in drawn if one["draw"] == "wall"] == ["ground.O"]
    assert [one["body"] for one in drawn if "body" in one] == ["bob"]  # it is no body of the mechanism
