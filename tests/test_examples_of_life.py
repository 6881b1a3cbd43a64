"""Examples from the drawing to the life of the machine: each against a closed form or a number of a book."""

import math

import numpy as np
import pytest

import rattle as rt

HOUR = 3600.0


# ---------------------------------------------------------------- connecting rod
def moments_of_rod(r, length, mass, turning, slider, angle, x):
    """Bending moments [N*m] at x [m] from the crank pin of a uniform rod between a crank at rate `turning` and a mass
    that slides: inertia by second differences of positions, summed up from the slider over the places behind x."""

    def ends(phi):
        a = r * np.array([math.cos(phi), math.sin(phi)])
        return a, np.array([a[0] + math.sqrt(length**2 - a[1] ** 2), 0.0])

    h = 1e-4
    (a0, b0), (a1, b1), (a2, b2) = ends(angle - h), ends(angle), ends(angle + h)
    at_a, at_b = (
        turning**2 * (first - 2 * middle + last) / h**2 for first, middle, last in ((a0, a1, a2), (b0, b1, b2))
    )
    along = (b1 - a1) / length
    across = np.array([-along[1], along[0]])
    shares = (np.arange(4000) + 0.5) / 4000
    pull = mass * (np.outer(1 - shares, at_a) + np.outer(shares, at_b)) / 4000  # what accelerates each piece
    about = (shares[:, None] * length * pull @ across[:, None])[:, 0].sum()  # moments about A: the guide gives its part
    push = slider * at_b[0]  # of the rod on the slider along its way
    guide = (about + push * length * across[0]) / (length * across[1])
    of_slider = np.array([-push, guide])  # of the slider on the rod
    behind = shares * length > x
    arms = shares[behind] * length - x
    return (length - x) * of_slider @ across - (arms * (pull[behind] @ across)).sum()


def test_a_connecting_rod_is_bent_by_its_own_inertia_as_summing_it_up_says():
    s = rt.example("connecting_rod").set(peak=0).strength("rod")
    turning, largest = 5000 * math.pi / 30, np.abs(s.moment).max()
    for k in range(0, len(s.t), 24):
        for n in range(10, len(s.x), 30):
            moment = moments_of_rod(0.05, 0.12, 0.21, turning, 0.14, turning * s.t[k], s.x[n])
            assert s.moment[k, n] == pytest.approx(moment, abs=2e-3 * largest)
    book = 0.21 * 0.05 * turning**2 * 0.12 / (9 * math.sqrt(3))  # only the crank's end accelerated
    assert book == pytest.approx(22.16, abs=0.01)  # as the example says
    assert largest == pytest.approx(24.0, abs=0.6)


def test_a_connecting_rod_is_pressed_most_where_the_gas_burns():
    m = rt.example("connecting_rod")
    s = m.strength("rod")
    assert 0.0 < s.peak_at[0] < 2e-3
    assert 1.0 < s.safety < 20.0
    assert 10.0 < s.buckling.min() < 200.0
    assert s.peak > m.set(peak=0).strength("rod").peak


# ---------------------------------------------------------------- press
def test_a_press_gets_as_warm_as_petroff_says():
    """2 pi mu(T) w^2 R^3 L/c(T) = G (T - T_air): the pin runs nearly in the middle of its bush."""
    m = rt.example("press").set(work=0)
    oil, fit, turning = rt.oil("ISO VG 68"), rt.fit("H7/f7", "60 mm"), 600 * math.pi / 30
    low, high = 293.15, 393.15
    for _ in range(60):
        warm = 0.5 * (low + high)
        play = fit.radial + 0.03 * (18.2e-6 - 11.5e-6) * (warm - 293.15)
        loss = 2 * math.pi * oil.viscosity(warm) * turning**2 * 0.03**3 * 0.04 / play
        low, high = (warm, high) if 2.0 * (warm - 293.15) < loss else (low, warm)
    h = m.heat()
    assert h.temperature["O"] == pytest.approx(warm, abs=1.0)
    assert h.loss["O"] == pytest.approx(2.0 * (h.temperature["O"] - 293.15), rel=1e-2)
    loaded = rt.example("press").heat()
    assert loaded.temperature["O"] > h.temperature["O"]  # under load it loses more


# ---------------------------------------------------------------- excavator
def test_the_link_of_a_bucket_bears_the_moment_of_the_teeth_over_its_lever():
    m = rt.example("bucket_pins").set(gravity=[0, 0])
    for joint in "RDKB":
        m = m.set({f"joints.{joint}.friction.mu": 0})
    for body in ("rocker", "link", "bucket"):
        m = m.set({f"bodies.{body}.mass": 1e-6, f"bodies.{body}.inertia": 1e-6})
    r = m.inverse_dynamics([1.0, 2.0])
    for k, t in enumerate(r.t):
        d, f, b = (np.array([r[f"{point}.x"][k], r[f"{point}.y"][k]]) for point in ("link.D", "link.K", "bucket.B"))
        (ux, uy), (x, y) = (f - d) / math.dist(f, d), b - d
        lever = abs(ux * y - uy * x)
        force = 30e3 * math.sin(2 * math.pi * t / 8.0)
        assert r["K.force"][k] == pytest.approx(
            0.9 * force / lever, rel=1e-6
        )  # the teeth are 0.9 m from B, square to it


def test_the_pins_of_a_bucket_are_pressed_by_force_over_their_area():
    d = rt.example("bucket_pins").durability()
    table = d.table
    for joint in "RDKB":
        row = table.loc[joint]
        load, pressure = (
            float(row[next(c for c in table.columns if c.startswith(key))]) for key in ("load", "pressure")
        )
        assert pressure == pytest.approx(load / (2 * 0.03 * 0.1), rel=1e-9)


# ---------------------------------------------------------------- gripper
def test_a_gripper_gives_by_the_plays_of_its_four_pins():
    """2 c (1 + 2 a/h) with c = 8.5 um; made parts: each play has sd hypot(15, 9)/sqrt(48) um, of two diameters."""
    m = rt.example("gripper")
    lever = 50 / 40
    assert m.equilibrium()[0]["gives"] == pytest.approx(2 * 8.5e-6 * (1 + 2 * lever), rel=1e-6)
    table = m.ensemble(512, ["final(gives)"], analysis="equilibrium").table
    gives = 1e6 * np.asarray(table["final(gives)"])
    spread = math.hypot(15, 9) / math.sqrt(48) * math.sqrt(2 * (1 + lever) ** 2 + 2 * lever**2)
    assert gives.std() == pytest.approx(spread, rel=0.05)
    assert gives.mean() == pytest.approx(59.5, abs=1.5)
    assert gives.max() <= 14.5 * 2 * (1 + 2 * lever)
    assert gives.min() >= 2.5 * 2 * (1 + 2 * lever)


# ---------------------------------------------------------------- wiper
def test_a_wiper_is_worn_by_pressure_and_sliding_of_all_its_cases():
    m = rt.example("wiper")
    rate = 0.0
    for case in m.model.duty:
        r = m.set(case.changes).simulate()
        slid = 0.004 * np.abs(r["M.rate"])
        depths = 1.3e-15 * r["M.force"] / (2 * 0.004 * 0.01) * slid
        rate += case.share * np.trapezoid(depths, r.t) / r.t[-1]
    table = m.durability().table
    (column,) = (column for column in table.columns if column.startswith("wear"))
    assert float(table.loc["M", column]) == pytest.approx(2e-4 / rate / HOUR, rel=1e-3)
