"""Ropes: rods that their stops hold in place of a length, against closed forms and independent integrations."""

from __future__ import annotations

from math import hypot, inf, pi, sqrt

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import rattle as rt
from drawn_mechanisms import instants
from rattle.drawings.forms import display_list
from rattle.drawings.played import Stage
from rattle.plots.scene import Scene

pytestmark = [pytest.mark.nojit, pytest.mark.plain]

FINE = {"rtol": 1e-11, "atol": 1e-13}


def bob(contact: str, start: str, more: str = "max = 1", gravity: float = 10.0, arm: float = 0.0) -> str:
    """A body of 1 kg, 0.1 kg m^2, that a rope of 1 m ties to the origin, at a point `arm` from its mass centre."""
    return f"""
format = 1
gravity = [0, {-gravity}]
ground.points = {{ O = [0, 0] }}
bodies.b = {{ points = {{ P = [{arm}, 0] }}, center = [0, 0], mass = 1, inertia = 0.1 }}
joints.rope = {{ type = "rod", connect = ["ground.O", "b.P"], stop = {{ {more}, contact = {contact} }} }}
initial.b = {{ {start} }}
"""


TWO = """
format = 1
gravity = [0, 0]
bodies.a = { points = { P = [0.1, 0.05] }, center = [0, 0], mass = 1, inertia = 0.02 }
bodies.b = { points = { P = [-0.1, 0.02] }, center = [0, 0], mass = 3, inertia = 0.03 }
joints.r = { type = "rod", connect = ["a.P", "b.P"], stop = { max = 0.5, min = 0.2, contact = CONTACT } }
initial.a = { x = 0, y = 0, vx = -1, vy = 0.5, omega = 4 }
initial.b = { x = 0.6, y = 0.1, vx = 1, vy = -0.2, omega = -3 }
signals.twice = "2*r.position"
signals.speed = "r.rate"
"""


# ---------------------------------------------------------------- motion
def test_it_falls_free_jerks_and_swings() -> None:
    """Free until (0.1, 0.9 - 5 t^2) is 1 m away; then the speed along the rope is lost and it is a pendulum."""
    m = rt.loads(bob('{ model = "impact" }', "x = 0.1, y = 0.9"))
    r = m.simulate(2.0, t_eval=np.linspace(0, 2, 41), **FINE)
    taut = brentq(lambda t: hypot(0.1, 0.9 - 5 * t * t) - 1, 0.3, 1.0)
    place = np.array([0.1, 0.9 - 5 * taut**2])
    (jerk, *_) = [event for event in r.events if event.kind == "impact"]
    along = 10 * taut * -place[1]
    assert [jerk.t, jerk.normal_speed] == pytest.approx([taut, along], rel=1e-12)
    assert jerk.energy_lost == pytest.approx(along**2 / 2, rel=1e-10)
    slack = r.t < taut
    assert np.abs(r["rope.force"][slack]).max() == 0.0
    assert r["rope.position"][slack] == pytest.approx(np.hypot(0.1, 0.9 - 5 * r.t[slack] ** 2), abs=1e-12)
    turned, spin = np.arctan2(place[0], -place[1]), -10 * taut * place[0]  # from the vertical, anticlockwise
    after = solve_ivp(
        lambda t, y: [y[1], -10 * np.sin(y[0])], (taut, 2.0), [turned, spin], t_eval=r.t[~slack], rtol=1e-12, atol=1e-13
    ).y
    np.testing.assert_allclose(r["b.x"][~slack], np.sin(after[0]), atol=1e-9)
    np.testing.assert_allclose(r["rope.force"][~slack], after[1] ** 2 + 10 * np.cos(after[0]), atol=1e-7)
    np.testing.assert_allclose(r["rope.stop"], -r["rope.force"], atol=1e-12)
    assert r["energy.dissipated"][-1] == pytest.approx(along**2 / 2, rel=1e-10)
    assert np.abs(r["energy.balance"]).max() < 1e-9


@pytest.mark.parametrize(
    "contact",
    [
        '{ model = "impact", restitution = 1 }',
        '{ model = "impact", restitution = 0.4 }',
        pytest.param(
            '{ model = "exact", stiffness = 1e5, exponent = 1.5, restitution = 0.7 }', marks=pytest.mark.machine
        ),
        '{ model = "hertz", stiffness = 1e5, exponent = 1, damping = 30 }',
    ],
)
def test_between_two_spinning_bodies_momenta_are_kept(contact: str) -> None:
    r = rt.loads(TWO.replace("CONTACT", contact)).simulate(2.0, t_eval=np.linspace(0, 2, 101), **FINE)
    px, py = r["a.vx"] + 3 * r["b.vx"], r["a.vy"] + 3 * r["b.vy"]
    spin = r["a.x"] * r["a.vy"] - r["a.y"] * r["a.vx"] + 3 * (r["b.x"] * r["b.vy"] - r["b.y"] * r["b.vx"])
    spin += 0.02 * r["a.omega"] + 0.03 * r["b.omega"]
    assert max(np.ptp(px), np.ptp(py)) < 1e-12
    assert np.ptp(spin) < 1e-9
    assert np.abs(r["energy.balance"]).max() < 1e-8
    if "restitution = 1 " in contact:
        assert abs(r["energy.dissipated"][-1]) < 1e-12
    if "impact" in contact:
        assert r["r.position"].max() <= 0.5 + 1e-9
        assert r["r.position"].min() >= 0.2 - 1e-9
    np.testing.assert_allclose(r["twice"], 2 * r["r.position"], atol=1e-12)
    np.testing.assert_allclose(r["speed"], r["r.rate"], atol=1e-12)
    dx = r["b.P.x"] - r["a.P.x"]
    dy = r["b.P.y"] - r["a.P.y"]
    np.testing.assert_allclose(r["r.position"], np.hypot(dx, dy), atol=1e-12)
    pull = np.abs(r["r.fx"] * dy - r["r.fy"] * dx)  # it acts along the rope only
    assert pull.max() < 1e-9 * max(1.0, r["r.force"].max())


def test_an_elastic_rope_is_a_spring_that_only_pulls() -> None:
    """SciPy: m d'' = m g - max(0, K (|d| - 1)) d/|d|, the point being the mass centre."""
    m = rt.loads(bob('{ model = "hertz", stiffness = 800, exponent = 1 }', "x = 0.4, y = 0.2"))
    r = m.simulate(3.0, t_eval=np.linspace(0, 3, 31), **FINE)

    def fall(t: float, y: np.ndarray) -> list[float]:
        away = hypot(y[0], y[1])
        pull = max(0.0, 800 * (away - 1.0)) / away
        return [y[2], y[3], -pull * y[0], -10 - pull * y[1]]

    y = solve_ivp(fall, (0, 3), [0.4, 0.2, 0, 0], t_eval=r.t, rtol=1e-11, atol=1e-12, max_step=2e-3).y
    np.testing.assert_allclose(r["b.x"], y[0], atol=1e-6)
    np.testing.assert_allclose(r["b.y"], y[1], atol=1e-6)
    assert len([event for event in r.events if event.kind == "contact"]) >= 3


@pytest.mark.machine
def test_no_end_is_missed_and_none_invented() -> None:
    """Straight flights past a small least distance, from 0.1 to 1000 m/s, in one step: roots of |p + v t| are known."""
    rng = np.random.default_rng(3)
    near = 0
    for trial in range(60):
        least, most, v = 10 ** rng.uniform(-4, -1), 10 ** rng.uniform(-0.5, 1), 10 ** rng.uniform(-1, 3)
        aside, way = least * rng.uniform(-2, 2), rng.uniform(0.2, 0.9) * most
        angle = rng.uniform(0, 2 * pi)
        d, across = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
        x, y = aside * across - way * d
        touches = abs(aside) < least
        t = (way - sqrt(least**2 - aside**2)) / v if touches else (way + sqrt(most**2 - aside**2)) / v
        near += touches
        contact = '"impact"' if trial % 2 else '{ model = "hertz", stiffness = 1e7, exponent = 1 }'
        start = f"x = {float(x)!r}, y = {float(y)!r}, vx = {float(v * d[0])!r}, vy = {float(v * d[1])!r}"
        m = rt.loads(bob(contact, start, f"min = {least!r}, max = {most!r}", gravity=0.0))
        r = m.simulate(1.1 * t, t_eval=[0, 1.1 * t])
        assert r.success
        (first, *_) = [event for event in r.events if event.kind in ("impact", "contact")]
        assert first.t == pytest.approx(t, rel=1e-9)
    assert near > 15


def test_a_least_distance_pushes_and_both_ends_hold() -> None:
    """A point that spirals between two distances, without loss: angular momentum and energy stay."""
    text = bob('{ model = "impact", restitution = 1 }', "x = 0.5, y = 0, vx = 2, vy = 1", "min = 0.2, max = 1", 0.0)
    r = rt.loads(text).simulate(5.0, t_eval=np.linspace(0, 5, 201), **FINE)
    assert r["rope.position"].min() >= 0.2 - 1e-9
    assert r["rope.position"].max() <= 1 + 1e-9
    assert np.ptp(r["b.x"] * r["b.vy"] - r["b.y"] * r["b.vx"]) < 1e-9
    assert len([event for event in r.events if event.kind == "impact"]) >= 6


# ---------------------------------------------------------------- statics, modes, what else knows it
@pytest.mark.parametrize("contact", ['"impact"', '{ model = "hertz", stiffness = 1e4, exponent = 1 }'])
def test_a_weight_hangs_and_swings(contact: str) -> None:
    """At rest the rope carries m g; point and mass centre 0.2 m apart: the two modes of a double pendulum."""
    m = rt.loads(bob(contact, "x = 0, y = -1.1, angle = 1.4", arm=0.2))
    (rest, *_) = [e for e in m.equilibrium() if e.stable and e.admissible]
    sunk = 0.0 if "impact" in contact else 10 / 1e4
    assert rest["rope.stop"] == pytest.approx(-10, abs=1e-9)
    assert [rest["rope.fx"], rest["rope.fy"]] == pytest.approx([0, 10], abs=1e-8)
    assert rest["rope.position"] == pytest.approx(1 + sunk, abs=1e-9)
    assert rest["b.y"] == pytest.approx(-1.2 - sunk, abs=1e-9)
    away = 1 + sunk
    mass = np.array([[away**2, away * 0.2], [away * 0.2, 0.2**2 + 0.1]])  # of the angles of rope and body
    stiff = np.diag([10 * away, 10 * 0.2])
    omega = np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(mass, stiff)).real))
    modes = m.modes(equilibrium=rest)
    np.testing.assert_allclose(modes.omega[:2], omega, rtol=1e-6)
    assert len(modes) == (2 if "impact" in contact else 3)


def test_two_ropes_share_a_load() -> None:
    text = """
format = 1
gravity = [0, -9.81]
ground.points = { O = [0, 0], R = [1, 0] }
bodies.b = { points = { P = [-0.3, 0], Q = [0.3, 0] }, center = [0, 0], mass = 1, inertia = 0.02 }
joints.l = { type = "rod", connect = ["ground.O", "b.P"], stop = { max = 1 } }
joints.r = { type = "rod", connect = ["ground.R", "b.Q"], stop = { max = 1 } }
initial.b = { x = 0.3, y = -0.9 }
"""
    m = rt.loads(text)
    stable = [e for e in m.equilibrium() if e.stable]
    down = sqrt(1 - 0.2**2)
    assert len(stable) == 1
    assert [stable[0]["l.stop"], stable[0]["r.stop"]] == pytest.approx([-9.81 / 2 / down] * 2, rel=1e-9)
    assert [stable[0]["b.x"], stable[0]["b.y"]] == pytest.approx([0.5, -down], abs=1e-9)
    r = m.simulate(3.0, t_eval=np.linspace(0, 3, 61), **FINE)
    assert max(r["l.position"].max(), r["r.position"].max()) < 1 + 1e-9
    assert np.abs(r["energy.balance"]).max() < 1e-8
    report = str(m.check())
    assert "3 degrees of freedom" in report
    assert "stop: l to 1 m, impact, no row: free between its ends" in report
    assert "loop" not in report


def test_power_books_the_jerk_and_the_rope_gives_nothing_back() -> None:
    r = rt.loads(bob('{ model = "impact", restitution = 0.3 }', "x = 0.1, y = 0.9")).simulate(3.0, **FINE)
    lost = sum(event.energy_lost for event in r.events)
    assert r["energy.dissipated"][-1] == pytest.approx(lost, rel=1e-9)
    assert lost > 1


@pytest.mark.machine
def test_moreau_converges_to_the_event_driven_run() -> None:
    m = rt.loads(bob('{ model = "impact", restitution = 0.5 }', "x = 0.1, y = 0.9"))
    exact = m.simulate(1.0, t_eval=[0, 1.0], **FINE)
    error = [
        abs(m.simulate(1.0, t_eval=[0, 1.0], method="moreau", step=step)["b.y"][-1] - exact["b.y"][-1])
        for step in (4e-4, 1e-4)
    ]
    assert error[1] < error[0] / 2 < 2e-3


def test_kinematics_says_where_a_rope_would_have_been_taut() -> None:
    text = bob('"impact"', "x = 0.5, y = 0, angle = 0", gravity=0.0)
    driven = """
joints.rail = { type = "prismatic", connect = ["ground.O", "b.P"], axis = 0 }
drivers.pull = { joint = "rail", position = "0.5 + t" }
"""
    m = rt.loads(text + driven)
    r = m.kinematics([0.0, 0.25, 1.0])
    assert r["rope.position"] == pytest.approx([0.5, 0.75, 1.5])
    assert "joint 'rope' goes beyond its stop (max), by up to 0.5 m" in str(r.trust.notes)
    assert m.inverse_dynamics([0.0, 0.25])["pull.force"] == pytest.approx([0, 0], abs=1e-12)


# ---------------------------------------------------------------- as written, as drawn
def test_it_is_built_in_code_and_written_again() -> None:
    text = bob('{ model = "impact", restitution = 0.3 }', "x = 0.1, y = 0.9", 'max = "100 cm"')
    m = rt.loads(text)
    assert rt.loads(m.to_toml()).model == m.model
    assert m.model.joints["rope"].fields["length"] == inf
    assert m.set({"joints.rope.stop.max": "0.95 m"}).model.joints["rope"].stop.maximum == 0.95
    built = rt.Mechanism(gravity=(0, -10)).ground(O=(0, 0))
    built.body("b", mass=1, inertia=0.1, points={"P": (0, 0)})
    built.rod("rope", "ground.O", "b.P", stop={"max": 1, "contact": {"model": "impact", "restitution": 0.3}})
    built.initial("b", x=0.1, y=0.9)
    one, two = (each.simulate(1.0, t_eval=[0, 1.0], **FINE)["b.y"][-1] for each in (m, built))
    assert one == two


@pytest.mark.parametrize("place", [(0.2, -0.17), (0.2, -0.67), (-0.6, 0.3), (0.1, -0.9), (0.6, -0.8), (0.0, -1.0)])
def test_it_is_drawn_slack_or_taut(place: tuple[float, float]) -> None:
    """As a curve that is about as long as the rope, and straight where it is taut."""
    x, y = place
    r = rt.loads(bob('"impact"', f"x = {x}, y = {y}")).simulate(1e-6, t_eval=[0, 1e-6])
    written, scene = display_list(r.geometry), Scene(r, instants(r), 1.0)
    shapes = Stage(written, r.geometry, scene, 1.0).shapes()
    (points,) = [shape.rings[0][0] for shape in shapes if (shape.style["line"] or [""])[0] == "grey"]
    chord = hypot(x, y)
    assert float(np.hypot(*(points[-1] - points[0]))) == pytest.approx(chord, abs=1e-5)
    drawn = np.hypot(*np.diff(points, axis=0).T).sum()
    assert drawn == pytest.approx(1.0, abs=1e-5 if chord == 1.0 else 0.15)
    lowest = points[:, 1].min()
    assert lowest < min(0.0, y) - 0.02 or chord > 0.9


@pytest.mark.parametrize(
    ("joint", "words"),
    [
        ("length = 1, stop = { max = 1 }", "a rod of one length has no stop; for a rope"),
        ("", "needs length"),
        ("stop = { contact = 'impact' }", "needs an end: min in m or max in m"),
        ("stop = { max = 1, min = 2 }", "must be less than max"),
        ("stop = { min = 0 }", "0 must be positive"),
        ("stop = { max = 1 }, friction = { mu = 0.1, pin_radius = 0.01 }", "which its stops hold, has no friction"),
        ("stop = { max = 1 }, contact = 'impact'", "has contacts at its stop only"),
        ("stop = { max = 1, contact = { model = 'impact', friction = 0.2 } }", "a stop has no friction"),
        ("stop = { max = 1 }, clearance = 0.01", "cannot have clearance"),
    ],
)
def test_what_a_rope_has_not_is_refused(joint: str, words: str) -> None:
    text = bob('"impact"', "x = 0.1, y = 0.9")
    line = next(line for line in text.splitlines() if line.startswith("joints.rope"))
    keys = f", {joint}" if joint else ""
    wrong = text.replace(line, f'joints.rope = {{ type = "rod", connect = ["ground.O", "b.P"]{keys} }}')
    with pytest.raises(rt.ModelError, match=words):
        rt.loads(wrong)


def test_a_start_that_it_does_not_allow_is_refused() -> None:
    with pytest.raises(rt.AssemblyError, match=r"'rope' starts at 1.50333 m, beyond max = 1 m of its stop"):
        rt.loads(bob('"impact"', "x = 0.1, y = 1.5")).simulate(0.1)
    for contact in ('"impact"', '{ model = "hertz", stiffness = 1e5 }'):
        with pytest.raises(rt.AssemblyError, match=r"both points of 'rope' start at one place"):
            rt.loads(bob(contact, "x = 0, y = 0", "min = 0.1")).simulate(0.1)
