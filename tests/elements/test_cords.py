"""Springs that only pull, and springs whose ends coincide: against other programs and closed forms."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import rattle as rt
from rattle.errors import TraceError

pytestmark = [pytest.mark.nojit, pytest.mark.plain]
G, MASS = 9.81, 2.0
FINE = {"rtol": 1e-11, "atol": 1e-13}
T = np.linspace(0.0, 1.5, 31)


def falling(damping, stiffness=500, **more):
    """A body that falls into a cord of 0.5 m below the ground's point."""
    m = rt.Mechanism(gravity=[0, -G]).ground(O=[0, 0]).body("b", mass=MASS, inertia=1, points={"P": [0, 0]})
    m.parameter("k", stiffness).parameter("c", damping).parameter("l0", 0.5)
    cord = {"stiffness": "k", "damping": "c", "free_length": "l0", "tension_only": True, **more}
    m.load("cord", "spring", connect=["ground.O", "b.P"], **cord)
    return m.initial("b", x=0, y=-0.1, angle=0, vx=0, vy=0, omega=0)


def pieces(damping, stiffness=500.0, free=0.5):
    """Depth (n,) at T, and the instants at which the cord begins and ceases to pull, piece by piece by SciPy."""

    def pull(y):
        return stiffness * (y[0] - free) + damping * y[1]

    taut = {0: (lambda _, y: min(y[0] - free, pull(y)), 1), 1: (lambda _, y: pull(y), -1)}
    t, y, mode, depth, instants = 0.0, np.array([0.1, 0.0]), 0, np.zeros_like(T), []
    while t < T[-1]:
        ends, sense = taut[mode]
        ends.terminal, ends.direction = True, sense
        acts = mode
        piece = solve_ivp(
            lambda _, y, acts=acts: [y[1], G - acts * pull(y) / MASS], (t, T[-1]), y, "DOP853",
            events=ends, rtol=1e-12, atol=1e-14, dense_output=True,
        )  # fmt: skip
        inside = (t <= T) & (piece.t[-1] >= T)
        depth[inside] = piece.sol(T[inside])[0] if inside.any() else 0.0
        t, y, mode = piece.t[-1], piece.y[:, -1], 1 - mode
        instants += [t] if piece.status == 1 else []
    return depth, instants


@pytest.mark.parametrize("method", ["dop853", "radau", "rk4", "event", "moreau"])
@pytest.mark.parametrize("damping", [0.0, 20.0, 100.0])
@pytest.mark.machine
def test_cord_pulls_and_lets_go_as_two_smooth_motions_put_together(damping, method):
    """With steps of 1 ms too, errors are those of a smooth motion: both switches are steps' ends."""
    depth, instants = pieces(damping)
    how = {"step": 1e-3} if method in ("rk4", "moreau") else FINE
    r = falling(damping).simulate(T[-1], t_eval=T, method=method, **how)
    np.testing.assert_allclose(-r["b.y"], depth, atol=1e-8)
    assert r.stats["switchings"] >= len(instants) >= 1


def test_cord_pulls_at_once_where_it_has_a_damper_and_lets_go_before_it_is_short():
    """It takes hold with c l' and lets go where k (l - l0) = -c l': its force jumps up and ends at 0."""
    _, (hold, release, *_) = pieces(20.0)
    beside = np.array([hold - 1e-9, hold + 1e-9, release - 1e-6, release + 1e-6])
    r = falling(20.0).simulate(0.7, t_eval=beside, **FINE)
    speed = -r["b.vy"][0]
    np.testing.assert_allclose(r["cord.force"], [0.0, 20.0 * speed, 0.0, 0.0], atol=1e-3)
    assert r["cord.slack"].tolist() == [1.0, 0.0, 0.0, 1.0]
    assert r["cord.length"][2] > 0.501


def test_energy_of_a_cord_is_booked_where_the_damper_takes_all_of_its_force():
    r = falling(20.0).simulate(1.5, t_eval=T, **FINE)
    np.testing.assert_allclose(r["energy.balance"], 0.0, atol=1e-8)
    assert (np.diff(r["energy.dissipated"]) >= -1e-12).all()
    taut = r["cord.slack"] == 0.0
    assert taut.any()
    stretch = np.maximum(r["cord.length"] - 0.5, 0.0)
    np.testing.assert_allclose(r["energy.potential"] - MASS * G * r["b.y"], 250 * stretch**2, atol=1e-9)
    assert r["energy.work"].tolist() == [0.0] * len(T)


@pytest.mark.parametrize("name", ["l0", *(pytest.param(x, marks=pytest.mark.machine) for x in ("k", "c"))])
def test_derivatives_through_its_switches_are_those_of_neighbours(name):
    m, at, by = falling(20.0), [0.2, 0.45, 0.9], {"k": 0.05, "c": 0.002, "l0": 5e-5}[name]
    exact = m.sensitivity(["b.y", "cord.force"], [name], at)
    value = m.model.parameters[name].value
    sides = [m.set({f"parameters.{name}": value + side * by}).simulate(0.9, t_eval=at, **FINE) for side in (1, -1)]
    for curve in ("b.y", "cord.force"):
        slope = (sides[0][curve] - sides[1][curve]) / (2 * by)
        np.testing.assert_allclose(exact[f"d({curve})/d({name})"], slope, rtol=1e-5, atol=1e-9)


def between_walls(tension_only):
    """A mass on a rail between two cords of 0.4 m from walls 1 m apart: at rest one of them is slack."""
    m = rt.Mechanism().ground(O=[0, 0], A=[-0.5, 0], B=[0.5, 0]).body("b", mass=3, inertia=1, points={"P": [0, 0]})
    m.prismatic("rail", "ground.O", "b.P", axis=0).load("push", "force", at="b.P", force=[60, 0])
    for name, wall, stiffness in (("left", "A", 200), ("right", "B", 900)):
        fields = {"stiffness": stiffness, "free_length": 0.4, "tension_only": tension_only, "damping": 6}
        m.load(name, "spring", connect=[f"ground.{wall}", "b.P"], **fields)
    return m.initial("b", x=0.05)


@pytest.mark.machine
def test_slack_cord_has_neither_force_nor_stiffness_nor_damping_at_rest():
    """The left cord alone holds 60 N, 200 (0.1 + x) = 60; with two springs 200 (0.1 + x) - 900 (0.1 - x) = 60."""
    for tension_only, x, stiffness, damping in ((True, 0.2, 200, 6), (False, (60 + 70) / 1100, 1100, 12)):
        m = between_walls(tension_only)
        (rest,) = (rest for rest in m.equilibrium() if abs(rest["b.x"]) < 0.5)
        assert rest["b.x"] == pytest.approx(x, abs=1e-10)
        modes = m.modes()
        assert modes.omega[0] == pytest.approx(np.sqrt(stiffness / 3), rel=1e-9)
        assert modes.damping[0] == pytest.approx(damping / (2 * np.sqrt(3 * stiffness)), rel=1e-9)


def test_expressions_and_other_names_know_that_it_is_slack():
    m = falling(0.0).signal("taut", "1 - cord.slack")
    r = m.simulate(0.4, t_eval=[0.1, 0.35])
    assert r["taut"].tolist() == [0.0, 1.0]
    plain = falling(0.0, tension_only=False).signal("taut", "1 - cord.slack")
    with pytest.raises(rt.ModelError, match=r"cord\.slack"):
        _ = plain.model
    with pytest.raises(rt.ModelError, match=r"loads\.cord\.tension_only: expected true or false"):
        _ = falling(0.0, tension_only="yes").model


# ---------------------------------------------------------------- no length
def at_the_origin(velocity=(0.0, 0.0), gravity=(0, -G), **fields):
    m = rt.Mechanism(gravity=gravity).ground(O=[0, 0]).body("b", mass=MASS, inertia=1, points={"P": [0, 0]})
    m.parameter("k", 500).load("s", "spring", connect=["ground.O", "b.P"], **{"stiffness": "k", **fields})
    vx, vy = velocity
    return m.initial("b", x=0, y=0, angle=0, vx=vx, vy=vy, omega=0)


@pytest.mark.parametrize("damping", [0.0, 30.0])
def test_spring_without_length_begins_with_the_limit_of_its_force(damping):
    """Along one line it is the oscillator m x'' + c x' + k x = 0 from the start on.

    The length grows from an instant on at which it has shrunk before: its rate is told as the mean of both sides there.
    """
    r = at_the_origin((1.5, 2.0), gravity=(0, 0), damping=damping).simulate(0.1, t_eval=[0, 0.02, 0.1], **FINE)
    decay = damping / (2 * MASS)
    w = np.sqrt(500 / MASS - decay**2)
    way = 2.5 * np.exp(-decay * r.t) * np.sin(w * r.t) / w
    np.testing.assert_allclose(r["b.y"], 0.8 * way, atol=1e-11)
    assert [r[f"s.{key}"][0] for key in ("rate", "force", "length")] == [0.0, 0.0, 0.0]
    acceleration = -damping * 2.5 / MASS
    np.testing.assert_allclose(
        [r["b.ax"][0], r["b.ay"][0]], [0.6 * acceleration, 0.8 * acceleration], rtol=1e-14, atol=1e-90
    )
    np.testing.assert_allclose(r["energy.balance"], 0.0, atol=1e-9)


def test_spring_without_length_at_rest_exerts_nothing_and_is_as_stiff_in_all_directions():
    m = at_the_origin(gravity=(0, 0))
    r = m.simulate(0.1, t_eval=[0, 0.1])
    assert [r[f"s.{key}"].tolist() for key in ("force", "length", "rate")] == [[0.0, 0.0]] * 3
    np.testing.assert_allclose(m.modes().omega[1:], np.sqrt(500 / MASS), rtol=1e-9)


@pytest.mark.parametrize("damping", [0.0, 3.0])
def test_derivatives_of_a_start_without_length_are_those_of_neighbours(damping):
    m, at = at_the_origin(damping=damping), [0, 0.05, 0.1]
    exact = m.sensitivity(["s.force", "s.length", "b.y"], ["k"], at)
    sides = [m.set({"parameters.k": 500 + by}).simulate(0.1, t_eval=at, **FINE) for by in (0.01, -0.01)]
    for curve in ("s.force", "s.length", "b.y"):
        slope = (sides[0][curve] - sides[1][curve]) / 0.02
        np.testing.assert_allclose(exact[f"d({curve})/d(k)"], slope, rtol=1e-5, atol=1e-12)
    assert exact["d(s.force)/d(k)"][0] == 0.0


def test_parting_ends_have_a_direction_from_the_start():
    """A spring of 0.1 m pressed to nothing, and an actuator, push ends that part the way they go."""
    for load in ({"type": "spring", "stiffness": 500, "free_length": 0.1}, {"type": "actuator", "force": 50}):
        m = rt.Mechanism().ground(O=[0, 0]).body("b", mass=MASS, inertia=1, points={"P": [0, 0]})
        m.load("L", connect=["ground.O", "b.P"], **load).initial("b", x=0, y=0, vx=0.6, vy=0.8)
        r = m.simulate(0.01, t_eval=[0.0], **FINE)
        np.testing.assert_allclose([r["b.ax"][0], r["b.ay"][0]], [15.0, 20.0], rtol=1e-12)
        np.testing.assert_allclose(r["energy.balance"], 0.0, atol=1e-10)


def test_derivatives_where_ends_have_no_direction_are_refused():
    with pytest.raises(TraceError, match="points coincide"):
        at_the_origin(free_length=0.1).sensitivity(["b.y"], ["k"], 0.1)


def test_springs_with_length_move_as_before():
    """Force along the line, k (l - l0) + c l', against Newton's law with NumPy."""
    k, l0, c = 300.0, 0.3, 4.0

    def rate(_, y):
        d, v = y[:2], y[2:]
        length = np.hypot(*d)
        return [*v, *(-(k * (length - l0) + c * (d @ v) / length) * d / length / MASS)]

    start = [0.5, 0.1, -0.4, 1.0]
    m = rt.Mechanism().ground(O=[0, 0]).body("b", mass=MASS, inertia=1, points={"P": [0, 0]})
    m.load("s", "spring", connect=["b.P", "ground.O"], stiffness=k, free_length=l0, damping=c)
    r = m.initial("b", **dict(zip(("x", "y", "vx", "vy"), start, strict=True))).simulate(1.0, t_eval=[1.0], **FINE)
    end = solve_ivp(rate, (0, 1), start, "DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    np.testing.assert_allclose([r[f"b.{key}"][0] for key in ("x", "y", "vx", "vy")], end, atol=1e-9)
