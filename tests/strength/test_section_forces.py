"""Forces along bars: closed forms of statics, and of bars that bend by their own inertia."""

import numpy as np
import pytest

import rattle as rt
from bars import beam, slider_crank, turning
from random_mechanisms import FAMILIES, mechanism

AREA, INERTIA, MODULUS, E = 1e-4, 1e-8 / 12, 1e-6 / 6, 210e9
ROUNDING = 1e-10  # of the largest value: some thousand operations on doubles


def borne(text, t=(0.0, 1.0), body="bar"):
    return rt.loads(text).strength(body, t_eval=list(t), analysis="inverse-dynamics")


def thin(ends, length, mass):
    """The line of a bar."""
    section = "{ area = 1e-4, inertia = 1e-9, modulus = 2e-7 }"
    return f'bodies.bar = {{ bar = {ends}, length = {length}, mass = {mass}, section = {section}, material = "steel" }}'


def close(value, wanted):
    return pytest.approx(wanted, abs=ROUNDING * max(np.abs(wanted).max(), 1e-300)) == value


# ---------------------------------------------------------------- at rest
def test_a_bar_on_two_pins_bears_its_weight_as_a_parabola():
    s, q, length = borne(beam(gravity=100.0)), 7850 * AREA * 100.0, 0.3
    assert close(s.moment[0], q * s.x * (length - s.x) / 2)
    assert close(s.shear[0], q * (length / 2 - s.x))
    assert s.normal[0] == pytest.approx(0.0, abs=1e-12 * q)
    assert close(s.deflection[0], -q / (24 * E * INERTIA) * (s.x**4 - 2 * length * s.x**3 + length**3 * s.x))
    assert s.peak == pytest.approx(q * length**2 / 8 / MODULUS)
    assert s.peak_at == pytest.approx((0.0, 0.15))
    assert s.safety == pytest.approx(300e6 / s.peak)


def test_two_forces_between_two_pins_add_and_each_is_a_station_twice():
    forces = """loads.f = { type = "force", at = "bar.P", force = [0, -60] }
loads.g = { type = "force", at = "bar.R", force = [0, 90] }"""
    s = borne(beam(forces, body="mass = 1e-9\npoints = { P = [-0.05, 0], R = [0.1, 0] }"))

    def alone(force, at):
        return force * np.where(s.x < at, s.x * (0.3 - at) / 0.3, (0.3 - s.x) * at / 0.3)

    assert close(s.moment[0], alone(60, 0.1) - alone(90, 0.25))
    for place, jump in ((0.1, -60.0), (0.25, 90.0)):
        before, after = np.flatnonzero(np.abs(s.x - place) < 1e-12)
        assert s.shear[0, after] - s.shear[0, before] == pytest.approx(jump)
    assert (s.x[0], s.x[-1]) == (0.0, 0.3)
    assert (np.diff(s.x) >= 0.0).all()


def test_the_torque_of_a_driver_is_the_moment_at_the_root_and_nothing_is_beyond_the_force():
    more = 'loads.f = { type = "force", at = "bar.P", force = [30, -80], frame = "body" }'
    s = borne(turning("mass = 0.5\npoints = { P = [0.05, 0.01] }", speed=0.0, length=0.2, more=more))
    before = s.x < 0.15 - 1e-9
    after = s.x > 0.15 + 1e-9
    assert close(s.moment[0][before], -0.3 - 80 * (0.15 - s.x[before]))  # 0.3 N m: the force acts 10 mm beside the axis
    assert s.moment[0][after] == pytest.approx(0.0, abs=1e-12)
    assert close(s.normal[0][before], np.full(before.sum(), 30.0))
    assert close(s.shear[0][before], np.full(before.sum(), 80.0))
    assert s.moment[0, 0] == pytest.approx(-12.3)


def test_a_couple_makes_the_moment_jump():
    torque = 'loads.c = { type = "torque", body = "bar", torque = 6 }'
    s = borne(beam(torque, body="mass = 1e-9"))
    after = s.x > 0.15
    after[np.flatnonzero(s.x == 0.15)[1]] = True
    assert close(s.moment[0], 20 * s.x - 6 * after)


def test_a_force_beyond_the_end_of_a_bar_acts_at_the_end_with_its_lever():
    s = borne(
        beam(
            'loads.f = { type = "force", at = "bar.P", force = [0, -10] }',
            "clamped",
            body="mass = 1e-9\npoints = { P = [0.25, 0] }",
        )
    )
    assert close(s.moment[0], -10 * (0.4 - s.x))  # P is 0.4 m from A, B 0.3 m
    assert s.shear[0] == pytest.approx(10.0)


def test_a_force_along_a_clamped_bar_stretches_it():
    s = borne(beam('loads.f = { type = "force", at = "bar.B", force = [700, 0] }', "clamped", body="mass = 1e-9"))
    assert close(s.normal[0], np.full(len(s.x), 700.0))
    assert close(s.elongation[0], 700 * s.x / (E * AREA))


# ---------------------------------------------------------------- by its own inertia
def test_a_turning_bar_bears_the_pull_of_what_is_outside():
    s = borne(turning(), [0.0, 0.01])
    pull = 7850 * AREA * 300**2 * (0.5**2 - s.x**2) / 2
    assert close(s.normal, np.tile(pull, (2, 1)))
    assert s.peak == pytest.approx(8.83125e7, rel=1e-9)
    assert s.elongation[0, -1] == pytest.approx(7850 * 300**2 * 0.5**3 / (3 * E))
    assert max(np.abs(s.moment).max(), np.abs(s.shear).max()) < 1e-9
    assert np.isinf(s.buckling).all()


def test_a_bar_that_tapers_bears_its_own_distribution_of_mass():
    m = rt.loads(turning('mass_per_length = [[0, 2.0], ["0.5 m", 1.0]]', speed=120.0))
    s = m.strength("bar", [0.0, 0.01], analysis="inverse-dynamics")
    assert close(s.normal[0], 120.0**2 * (0.5**2 - s.x**2 - (0.5**3 - s.x**3) * 2 / 3))
    assert m.kinematics([0.0])["bar.x"][0] == pytest.approx(0.5 * 4 / 9)


def test_a_rod_that_is_swung_across_at_one_end_bends_as_a_triangular_load():
    text = """
format = 1
ground.points = { O = [0, 0] }
bodies.lift = { points = { C = [0, 0] }, mass = 1, inertia = 1 }
joints.guide = { type = "prismatic", connect = ["ground.O", "lift.C"], axis = "90 deg", angle = 0 }
joints.B = { type = "revolute", connect = ["ground.O", "bar.B"] }
joints.A = { type = "slot", connect = ["lift.C", "bar.A"], axis = 0 }
drivers.up = { joint = "guide", position = "6000*t**2" }
initial = { bar = { angle = 0 }, lift = { angle = 0, x = 0.12 } }
""" + thin('["B", "A"]', 0.12, 0.21)
    s = borne(text, [0.0, 1e-6])
    largest = 0.21 * 12000 * 0.12 / (9 * np.sqrt(3))
    share = s.x / 0.12
    wanted = -0.21 * 12000 * 0.12 / 6 * share * (1 - share**2)
    assert close(s.moment[0], wanted) or close(s.moment[0], -wanted)
    assert np.abs(s.moment[0]).max() == pytest.approx(largest, rel=1e-4)
    assert s.x[np.abs(s.moment[0]).argmax()] == pytest.approx(0.12 / np.sqrt(3), abs=0.12 / 100)


@pytest.mark.parametrize("rod", ["mass = 0.21", "mass = 0.21\ninertia = 4e-4", "mass = 0.21\ninertia = 1e-4"])
def test_there_is_no_moment_at_pins_whatever_the_inertia(rod):
    s = borne(slider_crank(rod=rod), np.linspace(0.001, 0.1, 9), "rod")
    assert np.abs(s.moment[:, [0, -1]]).max() < 1e-9 * np.abs(s.moment).max()


def test_ends_that_need_negative_masses_are_named():
    fine, bad = (borne(slider_crank(rod=f"mass = 0.21\ninertia = {j}"), [0.01, 0.02], "rod") for j in (4e-4, 1e-4))
    assert not any("not physical" in remark for remark in fine.remarks)
    assert any("not physical" in remark for remark in bad.remarks)


# ---------------------------------------------------------------- of a result
def test_a_run_in_time_and_inverse_dynamics_bear_the_same():
    m, t = rt.loads(slider_crank()), np.linspace(0.0, 0.1, 11)
    driven = m.inverse_dynamics(t).strength("rod")
    run = m.simulate(0.1, t_eval=t, rtol=1e-11, atol=1e-13).strength("rod")
    for name in ("normal", "shear", "moment", "stress", "deflection"):
        wanted = getattr(driven, name)
        # eleven digits of positions lose some four in accelerations
        assert getattr(run, name) == pytest.approx(wanted, abs=1e-7 * np.abs(wanted).max()), name


def test_a_result_that_was_saved_bears_the_same(tmp_path):
    r = rt.loads(slider_crank()).inverse_dynamics(np.linspace(0.001, 0.1, 5), effort_at={"motor": "guide"})
    r.save(tmp_path / "r.npz")
    again = rt.load_result(tmp_path / "r.npz")
    assert again.strength("crank").moment == pytest.approx(r.strength("crank").moment, abs=1e-12)


def test_a_motor_at_the_slider_leaves_no_torque_in_the_crank_pin():
    m, t = rt.loads(slider_crank()), np.linspace(0.001, 0.1, 7)
    at_crank = m.inverse_dynamics(t).strength("crank")
    at_slider = m.inverse_dynamics(t, effort_at="guide").strength("crank")
    assert at_crank.moment[:, 0] == pytest.approx(-m.inverse_dynamics(t)["motor.torque"])
    assert np.abs(at_slider.moment[:, 0]).max() < 1e-9 * np.abs(at_crank.moment).max()
    rod = [m.inverse_dynamics(t, effort_at=at).strength("rod") for at in (None, "guide")]
    assert np.abs(rod[0].normal - rod[1].normal).max() > 1.0  # the force of the gas no longer goes through the rod


def test_a_motor_that_pushes_along_a_bar_acts_where_its_slider_is():
    text = """
format = 1
ground.points = { O = [0, 0] }
joints.O = { type = "revolute", connect = ["ground.O", "bar.A"] }
bodies.bead = { points = { P = [0, 0] }, mass = 2, inertia = 0.01 }
joints.on = { type = "prismatic", connect = ["bar.A", "bead.P"], axis = 0 }
drivers.turn = { joint = "O", angle = "4*t" }
drivers.out = { joint = "on", position = "0.1 + 0.1*t" }
""" + thin('["A", "B"]', 0.4, 1e-9)
    s = borne(text, np.linspace(0.0, 2.0, 5))
    for row, t in enumerate(s.t):
        place = 0.1 + 0.1 * t
        inside, outside = s.x < place - 1e-9, s.x > place + 1e-9
        across = 2 * 2 * 4 * 0.1  # Coriolis, 2 m w v
        assert s.normal[row][inside] == pytest.approx(2 * 16 * place)  # m w^2 r
        assert s.moment[row][inside] == pytest.approx(-across * (place - s.x[inside]), abs=1e-6)
        assert s.moment[row][outside] == pytest.approx(0.0, abs=1e-6)
        assert s.normal[row][outside] == pytest.approx(0.0, abs=1e-6)


def test_the_largest_stress_is_found_at_a_load_that_moves_between_stations():
    text = """
format = 1
ground.points = { O = [0, 0], Q = [0.3, 0] }
joints.A = { type = "revolute", connect = ["ground.O", "bar.A"] }
joints.B = { type = "slot", connect = ["ground.Q", "bar.B"], axis = 0 }
bodies.wheel = { points = { P = [0, 0] }, mass = 1e-9, inertia = 1e-9 }
joints.on = { type = "prismatic", connect = ["bar.A", "wheel.P"], axis = 0 }
drivers.along = { joint = "on", position = "0.1505 + 0*t" }
loads.f = { type = "force", at = "wheel.P", force = [0, -60] }
""" + thin('["A", "B"]', 0.3, 1e-9)
    s = borne(text)
    assert s.peak == pytest.approx(60 * 0.1505 * 0.1495 / 0.3 / 2e-7, rel=1e-6)
    assert s.peak_at[1] == pytest.approx(0.1505)


def test_a_missing_load_is_noticed_at_the_end_of_the_bar(monkeypatch):
    from rattle.questions.strength import section_forces

    every = section_forces.wrenches_on
    monkeypatch.setattr(section_forces, "wrenches_on", lambda *where: every(*where)[:-1])
    with pytest.raises(rt.SolverError, match="do not close at its end 'B'"):
        borne(slider_crank(), [0.01], "rod")


# ---------------------------------------------------------------- an independent way, slowly
@pytest.mark.parametrize("seed", range(6))
def test_random_trees_and_loops_bear_what_slow_integration_gives(seed):
    """Forces of joints from the result, inertia summed up by quadrature over the part before x."""
    rng = np.random.default_rng(seed)
    text, bars = (_tree if seed % 2 else _loop)(rng)
    t = np.sort(rng.uniform(0.05, 0.4, 4))
    r = rt.loads(text).inverse_dynamics(t)
    nodes, weights = np.polynomial.legendre.leggauss(6)
    for bar in bars:
        s = r.strength(bar.name)
        scale = [np.abs(part).max() for part in (s.normal, s.shear, s.moment)]
        for k in range(len(t)):
            angle, rate = r[f"{bar.name}.angle"][k], r[f"{bar.name}.omega"][k]
            turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
            centre = turn @ [r[f"{bar.name}.ax"][k], r[f"{bar.name}.ay"][k] + 9.81]  # less what gravity gives
            for x in bar.length * rng.uniform(0.02, 0.98, 5):
                total, moment = np.zeros(2), 0.0
                for at, name, side in bar.joints:
                    if at < x:
                        force = turn @ (side * np.array([r[f"{name}.fx"][k], r[f"{name}.fy"][k]]))
                        total += force
                        moment += force[1] * (x - at)
                        for driver, joint in bar.drivers:
                            moment -= side * r[f"{driver}.torque"][k] if joint == name else 0.0
                for u, w in zip(x * (nodes + 1) / 2, x * weights / 2, strict=True):
                    arm = u - bar.centre
                    a = centre + np.array([-(rate**2) * arm, r[f"{bar.name}.alpha"][k] * arm])
                    total -= w * bar.density(u) * a
                    moment -= w * bar.density(u) * a[1] * (x - u)
                along = [np.interp(x, s.x, part[k]) for part in (s.normal, s.shear, s.moment)]
                wanted = [-total[0], total[1], moment]
                for value, other, size in zip(along, wanted, scale, strict=True):
                    assert value == pytest.approx(other, abs=2e-4 * size)  # straight between stations


class _Bar:
    def __init__(self, name, length, first, last, joints, drivers=()):
        self.name, self.length, self.first, self.last = name, length, first, last
        self.joints, self.drivers = joints, drivers
        self.centre = length * (first + 2 * last) / (3 * (first + last))

    def density(self, x):
        return self.first + (self.last - self.first) * x / self.length

    def text(self, ends):
        return f"""
[bodies.{self.name}]
bar = {ends}
length = {self.length!r}
mass_per_length = [[0, {self.first!r}], [{self.length!r}, {self.last!r}]]
section = {{ shape = "round", diameter = "10 mm" }}
material = "steel"
"""


def _tree(rng):
    """Two or three bars hang on each other at their ends, each driven."""
    count, bars, text = (
        int(rng.integers(2, 4)),
        [],
        "format = 1\ngravity = [0, -9.81]\nground.points = { P = [0, 0] }\n",
    )
    for n in range(count):
        before = f"b{n - 1}.B" if n else "ground.P"
        text += f'joints.j{n} = {{ type = "revolute", connect = ["{before}", "b{n}.A"] }}\n'
        angle = f"{rng.uniform(-1, 1)} + {rng.uniform(2, 9)}*t + 0.3*sin(7*t)"
        text += f'drivers.d{n} = {{ joint = "j{n}", angle = "{angle}" }}\n'
    for n in range(count):
        joints = [(0.0, f"j{n}", 1.0)]
        bars.append(
            _Bar(f"b{n}", *map(float, rng.uniform([0.2, 0.5, 0.5], [0.6, 3.0, 3.0])), joints, ((f"d{n}", f"j{n}"),))
        )
    return text + "".join(bar.text(["A", "B"]) for bar in bars), bars


def _loop(rng):
    """A four-bar linkage that turns."""
    a, b, c = (float(length) for length in rng.uniform([0.1, 0.4, 0.4], [0.15, 0.5, 0.5]))
    text = f"""format = 1
gravity = [0, -9.81]
ground.points = {{ A = [0, 0], D = [0.5, 0] }}
joints.A = {{ type = "revolute", connect = ["ground.A", "crank.A"] }}
joints.B = {{ type = "revolute", connect = ["crank.B", "coupler.B"] }}
joints.C = {{ type = "revolute", connect = ["coupler.C", "rocker.C"] }}
joints.D = {{ type = "revolute", connect = ["ground.D", "rocker.D"] }}
drivers.motor = {{ joint = "A", angle = "0.5 + {rng.uniform(5, 20)}*t" }}
initial = {{ crank = {{ angle = 0.5 }}, coupler = {{ angle = 0.5 }}, rocker = {{ angle = 1.8 }} }}
"""
    densities = [tuple(map(float, pair)) for pair in rng.uniform(0.5, 3.0, (3, 2))]
    bars = [
        _Bar("crank", a, *densities[0], [(0.0, "A", 1.0)], (("motor", "A"),)),
        _Bar("coupler", b, *densities[1], [(0.0, "B", 1.0)]),
        _Bar("rocker", c, *densities[2], [(0.0, "D", 1.0)]),
    ]
    ends = (["A", "B"], ["B", "C"], ["D", "C"])
    return text + "".join(bar.text(names) for bar, names in zip(bars, ends, strict=True)), bars


# ---------------------------------------------------------------- the forces of all elements
def unbalanced(motion):
    """Largest force that inertia does not balance, as a share of the largest of all."""
    from rattle.questions.power.ports import Ports

    bodies, mass, fall = motion.bodies(), motion.system.arrays["mass"][1:], motion.gravity()
    left = -mass * bodies[:, :, 2]
    largest = np.abs(left).max()
    left[:, :, :2] += mass[:, :2] * fall[:, None]
    for port in Ports(motion.system).list:
        if port.column >= 0:
            force = motion.rows[:, port.column : port.column + 3]
            left[:, port.body - 1] += force
            largest = max(largest, np.abs(force).max())
    return np.abs(left).max() / largest


@pytest.mark.parametrize("family", FAMILIES)
def test_forces_of_all_elements_balance_random_mechanisms_with_friction_clutches_and_stops(family):
    from rattle.questions.strength.known_motion import known_motion

    followed = 0
    for seed in range(6):  # what cannot be put together, or ends early, is left out
        try:
            r = rt.loads(mechanism(seed, family)).simulate(0.05, t_eval=np.linspace(0.0, 0.05, 6), strict=True)
        except (rt.ModelError, rt.AssemblyError, rt.SolverError):
            continue
        followed += 1
        assert unbalanced(known_motion(r, "balance")) < 1e-9, seed
    assert followed > 2


@pytest.mark.parametrize("seed", range(8))
def test_forces_of_all_elements_in_a_driven_sweep_balance_the_inertia_of_every_body(seed):
    from rattle.questions.strength.known_motion import known_motion

    rng = np.random.default_rng(100 + seed)
    text, _ = (_tree if seed % 2 else _loop)(rng)
    body = "b0" if seed % 2 else "coupler"
    pivot, far = ("P", "B") if seed % 2 else ("A", "C")
    text += f"""
[loads.k]
type = "spring"
connect = ["ground.{pivot}", "{body}.{far}"]
stiffness = 300
[loads.twist]
type = "torque"
body = "{body}"
torque = "3*sin(5*t)"
"""
    motion = known_motion(rt.loads(text).inverse_dynamics(np.linspace(0.05, 0.4, 5)), "balance")
    assert unbalanced(motion) < 1e-9


def test_a_body_that_rests_on_a_bar_presses_it_where_it_touches():
    ball = """bodies.ball = { points = { M = [0, 0], P = [0, -0.01] }, center = [0, 0], mass = 2, inertia = 0.01 }
joints.on = { type = "surface", connect = ["bar.A", "ball.M"], axis = 0, corners = ["P"], contact = "impact" }
joints.up = { type = "prismatic", connect = ["ground.S", "ball.M"], axis = "90 deg", angle = 0 }
initial = { ball = { x = 0.1, y = 0.01, angle = 0 } }
"""
    s = rt.loads(beam(ball, gravity=10.0, body="mass = 1e-9")).strength("bar", [0.0, 0.01])
    wanted = 20 * np.where(s.x < 0.1, s.x * 2 / 3, (0.3 - s.x) / 3)
    assert s.moment[-1] == pytest.approx(wanted, abs=1e-6)
    assert s.peak == pytest.approx(20 * 0.2 / 3 * 6e6, rel=1e-6)  # where it touches, between two stations
