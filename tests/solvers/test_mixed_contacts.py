"""Impact, compliant and lubricated contacts side by side in one model: each as alone, and together as they should."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import rattle as rt

G = 9.81
TIGHT = {"rtol": 1e-10, "atol": 1e-13}
HARD = '{ model = "impact", restitution = 0.6, friction = 0.1, bush_radius = 0.01 }'
RUBS = 'friction = { model = "coulomb-smooth", mu = 0.1, v1 = 1e-3 }, bush_radius = 0.01'
SOFT = f'{{ model = "lankarani-nikravesh", restitution = 0.7, stiffness = 5e8, exponent = 1.5, {RUBS} }}'
WET = '{ model = "lubricated", film = "short", viscosity = 0.05, length = 0.01, bush_radius = 0.01 }'
PINS = {  # contact, clearance [m], place, velocity [m, m/s]
    "hard": (HARD, 1e-3, (2e-4, 1e-4, 0.7, 0.3)),
    "soft": (SOFT, 1e-3, (-3e-4, 2e-4, 0.4, 0.8)),
    "wet": (WET, 5e-5, (0.0, -1e-5, 2e-3, 5e-3)),
}


def pins(*names):
    """Spinning bodies that do not know of each other, each with a pin in a bush of the ground."""
    places = "".join(f"O_{name} = [{0.1 * list(PINS).index(name)}, 0]\n" for name in names)
    text, start = f"format = 1\ngravity = [0, {-G}]\n[ground.points]\n{places}", "[initial]\n"
    for name in names:
        contact, clearance, (x, y, vx, vy) = PINS[name]
        text += f"""
[bodies.{name}]
points = {{ P = [0, 0] }}
mass = 1
inertia = 1e-3
[joints.J_{name}]
type = "revolute"
connect = ["ground.O_{name}", "{name}.P"]
clearance = {clearance}
contact = {contact}
"""
        x += 0.1 * list(PINS).index(name)
        start += f"{name} = {{ x = {x}, y = {y}, angle = 0, vx = {vx}, vy = {vy}, omega = 30 }}\n"
    return rt.loads(text + start)


@pytest.fixture(scope="module")
def together():
    return pins(*PINS).simulate(0.05, t_eval=np.linspace(0.0, 0.05, 201), **TIGHT)


@pytest.mark.parametrize("name", PINS)
def test_contacts_that_have_nothing_to_do_with_each_other_do_as_alone(together, name):
    alone = pins(name).simulate(0.05, t_eval=together.t, **TIGHT)
    assert together.success
    # beside oil steps are implicit, of order 5; errors of 1e-10 grow at every contact of the elastic pin
    for curve, least in (("x", 1e-9), ("y", 1e-9), ("vx", 1e-6), ("vy", 1e-6), ("omega", 1e-6)):
        key = f"{name}.{curve}"
        assert together[key] == pytest.approx(alone[key], abs=least)
    joint = f"J_{name}"
    mine, its = ([one for one in r.events if one.joint == joint] for r in (together, alone))
    assert [one.kind for one in mine] == [one.kind for one in its]
    if mine:
        table, want = (np.array([(one.t, *one[3:8]) for one in events]) for events in (mine, its))
        assert table[:, 3] == pytest.approx(want[:, 3], rel=1e-4)  # a largest force is that of some points of its steps
        table, want = np.delete(table, 3, axis=1), np.delete(want, 3, axis=1)
        assert table == pytest.approx(want, rel=1e-5, abs=1e-9)
    for key in alone.peaks:
        assert together.peaks[key].value == pytest.approx(alone.peaks[key].value, rel=1e-6, abs=1e-11)
        if key.endswith(".force"):
            assert together.peaks[key].rms == pytest.approx(alone.peaks[key].rms, rel=1e-5)


def test_a_run_with_all_kinds_says_what_each_did(together):
    assert together.trust.energy_balance < 1e-8
    kinds = {joint: {one.kind for one in together.events if one.joint == joint} for joint in ("J_hard", "J_soft")}
    assert kinds == {"J_hard": {"impact", "contact", "stick", "slip"} & kinds["J_hard"] | {"impact", "contact"},
                     "J_soft": {"contact", "release"}}  # fmt: skip
    hits, presses = together.contacts["J_hard"], together.contacts["J_soft"]
    assert together.trust.impacts == hits.impacts > 10
    assert presses.impacts == 0
    assert together.trust.contacts == hits.contacts + presses.contacts
    assert 10 < together.trust.fewest_steps < 100  # of the shortest elastic contact; rigid ones have no duration
    lost = math.fsum(one.energy_lost for one in (hits, presses))
    film = together.films["J_wet"]
    span = together.t[-1]
    assert together["energy.dissipated"][-1] == pytest.approx(lost + film.mean_power * span, rel=1e-3)


# ---------------------------------------------------------------- a column of pins
M1, M2, M3, C1, C2, C3 = 2.0, 1.0, 0.5, 1e-3, 5e-4, 5e-5
REBOUND, STIFFNESS, RETURN, VISCOSITY = 0.6, 2e8, 0.7, 0.005
SQUEEZE = VISCOSITY * 0.01 * 0.01**3 / C3**3  # [N s/m]
COLUMN = f"""
format = 1
gravity = [0, {-G}]
ground.points = {{ O = [0, 0] }}
bodies.outer = {{ points = {{ P = [0, 0] }}, mass = {M1}, inertia = 1e-3 }}
bodies.middle = {{ points = {{ P = [0, 0] }}, mass = {M2}, inertia = 1e-3 }}
bodies.inner = {{ points = {{ P = [0, 0] }}, mass = {M3}, inertia = 1e-3 }}
[joints.hard]
type = "revolute"
connect = ["ground.O", "outer.P"]
clearance = {C1}
contact = {{ model = "impact", restitution = {REBOUND} }}
[joints.soft]
type = "revolute"
connect = ["outer.P", "middle.P"]
clearance = {C2}
contact = {{ model = "hunt-crossley", restitution = {RETURN}, stiffness = {STIFFNESS}, exponent = 1.5 }}
[joints.wet]
type = "revolute"
connect = ["middle.P", "inner.P"]
clearance = {C3}
contact = {{ model = "lubricated", film = "short", viscosity = {VISCOSITY}, length = 0.01, bush_radius = 0.01 }}
[initial]
outer = {{ x = 0, y = {-C1}, angle = 0, vx = 0, vy = 0, omega = 0 }}
middle = {{ x = 0, y = {-C1}, angle = 0, vx = 0, vy = -0.3, omega = 0 }}
inner = {{ x = 0, y = {-C1}, angle = 0, vx = 0, vy = -0.3, omega = 0 }}
"""


class Column:
    """The same pins, one above the other, written anew: SciPy between events, each of which ends a piece."""

    def __init__(self):
        self.lies, self.side, self.came = True, 0, 0.0  # outer pin on its bush; wall at which the middle one presses

    def pressing(self, y):
        """Force [N] of the middle pin on the outer one, upwards; on the inner one its film."""
        n = 0.0
        if self.side:
            depth, rate = self.side * (y[1] - y[0]) - C2, self.side * (y[4] - y[3])
            a = 1.5 * (1 - RETURN)
            n = self.side * STIFFNESS * max(depth, 0.0) ** 1.5 * max(1 + a * rate / self.came, 0.0)
        v = y[5] - y[4]
        a = (y[2] - y[1]) / C3 * (1 if v >= 0 else -1)
        s = math.sqrt(max(1 - a * a, 1e-3))  # stages of steps that are refused go beyond
        film = -SQUEEZE * v * (3 * a * s + math.atan2(s, -a) * (s * s + 3 * a * a)) / s**5
        return n, film

    def weight(self, y):
        """Force [N] with which the ground holds the outer pin, upwards, while it lies."""
        return M1 * G - self.pressing(y)[0]

    def rates(self, t, y):
        n, film = self.pressing(y)
        first = 0.0 if self.lies else n / M1 - G
        return [y[3], y[4], y[5], first, -(n + film) / M2 - G, film / M3 - G]

    def run(self, y, times):
        t, rows, met, found = 0.0, [], [], []
        while t < times[-1]:
            tests = [
                lambda t, y: C2 - (y[1] - y[0]) if self.side < 1 else y[1] - y[0] - C2,
                lambda t, y: C2 + (y[1] - y[0]) if self.side > -1 else y[0] - y[1] - C2,
                lambda t, y: self.weight(y) if self.lies else y[0] + C1,
            ]
            for one in tests:
                one.terminal, one.direction = True, -1
            fine = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-15, "first_step": 1e-7}
            ahead = solve_ivp(self.rates, (t, times[-1]), y, events=tests, dense_output=True, **fine)
            inside = [one for one in times if t <= one <= ahead.t[-1]]
            rows += [(one, *ahead.sol(one)) for one in inside if not rows or one > rows[-1][0]]
            met += [self.weight(ahead.sol(one)) for one in ahead.t] if self.lies else []
            t, y = ahead.t[-1], ahead.y[:, -1].copy()
            which = next((n for n, one in enumerate(ahead.t_events) if len(one)), None)
            if which is None:
                break
            if which == 2 and self.lies:
                self.lies = False
                found.append(("release", t))
            elif which == 2:
                y[3] *= -REBOUND
                found.append(("impact", t))
            else:
                wall = 1 if which == 0 else -1
                self.side, self.came = (0, 0.0) if self.side == wall else (wall, wall * (y[4] - y[3]))
                found.append(("soft", t))
        return np.array(rows), met, found


def test_a_column_of_pins_moves_as_pieces_between_events_say():
    times = np.linspace(0.0, 0.03, 121)
    r = rt.loads(COLUMN).simulate(times[-1], t_eval=times, **TIGHT)
    rows, weights, found = Column().run(np.array([-C1, -C1, -C1, 0.0, -0.3, -0.3]), times)
    assert r.success
    assert {kind for kind, _ in found} == {"soft", "release", "impact"}
    for k, body in enumerate(("outer", "middle", "inner")):
        assert r[f"{body}.y"] == pytest.approx(rows[:, 1 + k], abs=1e-10)
        assert r[f"{body}.vy"] == pytest.approx(rows[:, 4 + k], abs=1e-6)
    soft = sorted(t for one in r.events if one.joint == "soft" and one.kind == "contact"
                  for t in (one.t, one.t + one.duration))  # fmt: skip
    hard = [one.t for one in r.events if one.joint == "hard" and one.kind in ("impact", "release")]
    assert soft[: len(found)] == pytest.approx([t for kind, t in found if kind == "soft"], abs=1e-9)
    assert sorted(hard) == pytest.approx([t for kind, t in found if kind != "soft"], abs=1e-9)
    # the ground carries what presses on the outer pin: the largest force is that of an elastic contact
    assert r.peaks["hard.normal"].value == pytest.approx(max(weights), rel=1e-4)  # of the reference: at ends of steps
    assert r.peaks["hard.normal"].value > 30 * M1 * G
    assert r.trust.energy_balance < 1e-9


# ---------------------------------------------------------------- equilibria
@pytest.mark.parametrize("hard_above", [True, False])
def test_pins_hang_on_a_rigid_and_an_elastic_bush_each_as_its_law_says(hard_above):
    """The rigid one holds at the end of its clearance, the elastic one gives way by (F/K)^(2/3) more; its stiffness
    there and the mass below it are a mode."""
    stiffness, c = 1e7, 1e-3
    rigid = f'clearance = {c}, contact = {{ model = "impact", restitution = 0.3 }}'
    elastic = f'clearance = {c}, contact = {{ model = "hertz", stiffness = {stiffness}, exponent = 1.5 }}'
    above, below = (rigid, elastic) if hard_above else (elastic, rigid)
    m = rt.loads(f"""
format = 1
gravity = [0, {-G}]
ground.points = {{ O = [0, 0] }}
bodies.upper = {{ points = {{ T = [0, 0.1], B = [0, -0.1] }}, center = [0, 0], mass = 2, inertia = 1e-2 }}
bodies.lower = {{ points = {{ T = [0, 0.1] }}, center = [0, 0], mass = 3, inertia = 1e-2 }}
joints.a = {{ type = "revolute", connect = ["ground.O", "upper.T"], {above} }}
joints.b = {{ type = "revolute", connect = ["upper.B", "lower.T"], {below} }}
""")
    one = m.equilibrium()[0]
    assert one.stable
    assert one.admissible
    mass = 3 if hard_above else 5
    depth = (mass * G / stiffness) ** (2 / 3)
    sunk = c + np.array([0.0, depth] if hard_above else [depth, 0.0])
    assert [-one["a.ey"], -one["b.ey"]] == pytest.approx(list(sunk), rel=1e-8)
    assert [one["a.normal"], one["b.normal"]] == pytest.approx([5 * G, 3 * G], rel=1e-8)
    bounce = math.sqrt(1.5 * stiffness * math.sqrt(depth) / mass) / (2 * math.pi)
    assert abs(m.modes().frequency - bounce).min() < 1e-4 * bounce
