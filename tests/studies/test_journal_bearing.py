"""Journal bearings: static positions, stiffness, whirl and squeeze against closed forms and published numbers."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import rattle as rt
from oil_films import OIL, film

pytestmark = [pytest.mark.nojit, pytest.mark.plain]
W = 150.0  # speed [rad/s]


def closed_form(e):
    """W c^2/(mu w R L^3), attitude [rad], S (L/D)^2, p_max c^2/(mu w L^2) of a short film under a steady load."""
    s2 = 1 - e * e
    root = math.sqrt(math.pi**2 * s2 + 16 * e * e)
    m = (math.sqrt(1 + 24 * e * e) - 1) / (4 * e)
    load, sommerfeld = e * root / (4 * s2**2), s2**2 / (math.pi * e * root)
    return (
        load,
        math.atan2(math.pi * math.sqrt(s2), 4 * e),
        sommerfeld,
        0.75 * e * math.sqrt(1 - m * m) / (1 - e * m) ** 3,
    )


@pytest.mark.parametrize("e", [0.05, 0.3, 0.5, 0.8, 0.95])
@pytest.mark.parametrize("turning", [W, -W])
def test_a_short_bearing_settles_where_the_closed_form_says(e, turning):
    one = film("short")
    load, attitude, sommerfeld, peak = closed_form(e)
    p = one.static(load * OIL["viscosity"] * W * one.radius * one.length**3 / one.clearance**2, turning)
    assert (p.eccentricity, p.attitude, p.sommerfeld) == pytest.approx((e, attitude, 4 * sommerfeld), rel=1e-12)
    assert p.film_thickness == pytest.approx(one.clearance * (1 - e), rel=1e-12)
    assert p.pressure == pytest.approx(peak * OIL["viscosity"] * W * (one.length / one.clearance) ** 2, rel=1e-12)
    assert p.leakage == pytest.approx(one.radius * one.length * one.clearance * e * W, rel=1e-12)
    # friction of the pin (Raimondi, Boyd): f R/c = 2 pi^2 S/s + e sin(attitude)/2
    s = math.sqrt(1 - e * e)
    known = 2 * math.pi**2 * p.sommerfeld / s + 0.5 * e * math.sin(p.attitude)
    assert p.friction * one.radius / one.clearance == pytest.approx(known, rel=1e-12)
    assert p.loss == pytest.approx(p.friction * p.load * one.radius * W, rel=1e-12)


def test_stiffness_and_damping_of_a_published_example():
    # Friswell, Penny, Garvey, Lees (2010), Dynamics of Rotating Machines, example 5.5.1; axes turned: load along x
    one = rt.Film("0.1 Pa*s", length="30 mm", radius="50 mm", clearance="0.1 mm", model="short")
    p = one.static("525 N", "1500 rpm")
    np.testing.assert_allclose(p.stiffness, [[8815302.74, 25060393.28], [-16393593.25, 12807959.58]], rtol=1e-8)
    np.testing.assert_allclose(p.damping, [[294911.62, 81924.37], [81924.37, 232896.93]], rtol=1e-7)


# e, whirl/speed and m c w^2/W at the threshold of a rigid rotor on short bearings; beyond 0.75603 none whirls
WHIRL = [
    (0.1, 0.5029383929, 7.514608561),
    (0.3, 0.5194173871, 6.790119781),
    (0.5, 0.5146401448, 6.460395752),
    (0.7, 0.3445663369, 13.16109701),
    (0.756, 0.0, 1e4),
    (0.7561, None, math.inf),
]


@pytest.mark.parametrize(("e", "rate", "mass"), WHIRL)
def test_oil_whirl_begins_at_half_the_speed_or_not_at_all(e, rate, mass):
    one = film("short")
    row = one.table([e]).iloc[0]
    if e == 0.756:  # just before the last eccentricity that whirls: slow, and for very heavy rotors only
        assert 0.0 < row["whirl"] < 0.02
        assert row["critical_mass"] > mass
        return
    assert row["critical_mass"] == pytest.approx(mass, rel=1e-8)
    assert math.isnan(row["whirl"]) if rate is None else row["whirl"] == pytest.approx(rate, rel=1e-8)
    load = closed_form(e)[0] * OIL["viscosity"] * W * one.radius * one.length**3 / one.clearance**2
    assert one.critical_mass(load, W) == pytest.approx(mass * load / (one.clearance * W * W), rel=1e-8)


def test_at_the_critical_mass_a_mode_neither_grows_nor_decays():
    one = film("finite", ratio=0.8)
    p = one.static(200.0, W)
    m = one.critical_mass(200.0, W)
    growth = []
    for mass in (0.98 * m, m, 1.02 * m):
        rows = np.block([[np.zeros((2, 2)), np.eye(2)], [-p.stiffness / mass, -p.damping / mass]])
        growth.append(max(np.linalg.eigvals(rows).real) / W)
    assert growth[0] < -1e-4
    assert abs(growth[1]) < 1e-9
    assert growth[2] > 1e-4


def test_a_full_film_carries_across_and_always_whirls():
    p = film(cavitation="full").static(50.0, W)
    assert p.attitude == pytest.approx(math.pi / 2, abs=1e-12)
    assert film(cavitation="full").critical_mass(50.0, W) < 1e-9


# L/D, e, S, attitude [deg]: Raimondi, Boyd (1958), Trans. ASLE 1, 159-209, from 0.4 on, where the groove at which their
# film begins does not matter; and two-dimensional solutions without groove
CHARTS = [
    (1, 0.4, 0.264, 63.10, 0.260206, 65.132),
    (1, 0.6, 0.121, 50.58, 0.121411, 51.978),
    (1, 0.9, 0.0188, 26.45, 0.0188607, 26.702),
    (0.5, 0.6, 0.319, 48.14, 0.319934, 48.260),
    (0.5, 0.8, 0.0923, 33.31, 0.0917929, 32.984),
    (0.25, 0.4, 2.83, 60.86, 2.84343, 61.306),
    (0.25, 0.9, 0.0736, 21.85, 0.0736584, 21.788),
]


@pytest.mark.parametrize(("ratio", "e", "chart", "angle", "sommerfeld", "attitude"), CHARTS)
def test_finite_bearings_are_where_the_charts_have_them(ratio, e, chart, angle, sommerfeld, attitude):
    one = film(ratio=ratio)
    load = OIL["viscosity"] * W / math.pi * one.radius * one.length / sommerfeld * (one.radius / one.clearance) ** 2
    p = one.static(load, W)
    assert p.eccentricity == pytest.approx(e, abs=2e-4)
    assert math.degrees(p.attitude) == pytest.approx(attitude, abs=0.05)
    assert p.sommerfeld == pytest.approx(chart, rel=0.02)
    assert math.degrees(p.attitude) == pytest.approx(angle, abs=2.1)


def squeezed(e):
    """A(e), the antiderivative of I1 along a diameter: m v + mu R L^3/c^2 A - load t is constant."""
    s2 = (1 - e) * (1 + e)
    return 1 / s2 + e * (math.pi - math.acos(e)) / s2**1.5


@pytest.mark.parametrize(("beta", "e"), [(1.0, 0.3582446567902), (10.0, 0.78791963969275), (100.0, 0.95086394240895)])
def test_oil_stops_a_pin_before_it_touches(beta, e):
    # m v + mu R L^3/c^2 A(e) is constant, so a free pin stops where A = A(0) + beta, whatever its mass
    assert squeezed(e) == pytest.approx(1 + beta, rel=1e-9)
    one = film("short")
    c, k = one.clearance, OIL["viscosity"] * one.radius * one.length**3 / one.clearance**2

    def motion(t, y):
        return [y[1], one.force(y[0], 0.0, y[1], 0.0)[0]]  # of 1 kg

    run = solve_ivp(motion, (0, 400 * c / k), [0.0, beta * k], method="LSODA", rtol=1e-9, atol=1e-14)
    assert run.success
    assert run.y[0, -1] / c == pytest.approx(e, rel=3e-7)  # the tolerance of the integration
    kept = run.y[1] / k + np.array([squeezed(x / c) for x in run.y[0]])
    np.testing.assert_allclose(kept, 1 + beta, rtol=1e-6)


def test_a_film_under_load_sinks_as_the_closed_form_says():
    one = film("short")
    k = OIL["viscosity"] * one.radius * one.length**3 / one.clearance**2
    for e in (-0.9, 0.1, 0.5, 0.9):  # without inertia the speed is the load over the damping, k A'(e)/c
        h = 1e-5
        slope = (squeezed(e + h) - squeezed(e - h)) / (2 * h)
        force = one.force(e * one.clearance, 0.0, 1e-3, 0.0)[0]
        assert -force == pytest.approx(k * slope * 1e-3 / one.clearance, rel=1e-7)


def test_quantities_may_be_texts():
    same = rt.Film("50 cP", "1 cm", "10 mm", "50 um"), rt.Film("0.5 P", 0.01, 0.01, 5e-5), rt.Film(**OIL)
    assert len({repr(one) for one in same}) == 1
    assert len({one.static("0.5 kN", "1000 rpm").eccentricity for one in same}) == 1


@pytest.mark.parametrize(
    ("load", "speed", "said"),
    [
        (0.0, W, "load must be positive"),
        (-5.0, W, "load must be positive"),
        ("5 kg", W, "is a mass; expected a force"),
        (100.0, 0.0, "speed must be finite and not zero"),
        (100.0, "5 m/s", "is a velocity; expected an angular velocity"),
        (1e30, W, "needs a film thinner than 5e-11 m; there it carries"),
    ],
)
def test_loads_that_no_film_carries_are_refused(load, speed, said):
    with pytest.raises(ValueError, match=said):
        film().static(load, speed)


def test_an_eccentricity_beyond_the_clearance_is_refused():
    with pytest.raises(ValueError, match="between 0 and 1 clearances, not 1"):
        film().table([0.5, 1.0])
    with pytest.raises(ValueError, match="finite places and speeds"):
        film().force(math.nan, 0.0, 0.0, 0.0)


def test_a_short_film_that_is_long_is_remarked():
    assert "too strong" in film("short", ratio=0.6).notes[0]
    assert film("short", ratio=0.2).notes == film(ratio=0.6).notes == []


def test_the_table_is_the_same_for_every_load_and_speed():
    one = film(ratio=0.5)
    table = one.table()
    assert table["eccentricity"].is_monotonic_increasing
    assert (np.diff(table["sommerfeld"]) < 0).all()
    row = table[table["eccentricity"] == 0.6].iloc[0]
    load = (
        OIL["viscosity"] * W / math.pi * one.radius * one.length / row["sommerfeld"] * (one.radius / one.clearance) ** 2
    )
    p = one.static(load, W)
    found = {
        "attitude": p.attitude,
        "friction": p.friction * one.radius / one.clearance,
        "pressure": p.pressure * 2 * one.radius * one.length / load,
        "leakage": p.leakage / (one.radius * one.clearance * W / (2 * math.pi) * one.length),
        "k_xy": p.stiffness[0, 1] * one.clearance / load,
        "c_yy": p.damping[1, 1] * one.clearance * W / load,
    }
    for name, value in found.items():
        assert row[name] == pytest.approx(value, rel=1e-6), name


def test_the_chart_has_the_point_of_the_load():
    one = film()
    p = one.static(500.0, 100.0)
    figure = one.plot(500.0, 100.0)
    top, below, circle = figure.axes
    assert [top.lines[-1].get_xdata()[0], top.lines[-1].get_ydata()[0]] == [p.sommerfeld, p.eccentricity]
    assert below.lines[-1].get_ydata()[0] == pytest.approx(math.degrees(p.attitude))
    x, y = (float(one[0]) for one in circle.lines[-1].get_data())
    assert math.hypot(x, y) == pytest.approx(p.eccentricity)
    assert math.atan2(x, -y) == pytest.approx(p.attitude)  # the load points down, the pin turns to the left
    with pytest.raises(ValueError, match="both, load and speed"):
        one.plot(500.0)


# ---------------------------------------------------------------- Stribeck's curve
STRIBECK = [  # speed [rad/s], e/c, attitude [deg], dry share, friction with the dry part at the bush: solved elsewhere
    (0.1, 0.99941351, -5.34101, 0.970676, 0.0970838), (1.0, 0.99501291, -2.02852, 0.750645, 0.0752264),
    (3.0, 0.98513937, 5.28587, 0.256968, 0.0261765), (10.0, 0.96857033, 11.40351, 0.0, 0.0009840),
    (100.0, 0.90196645, 20.60628, 0.0, 0.0037038), (1000.0, 0.70479037, 38.32822, 0.0, 0.0188064),
]  # fmt: skip


def test_stribeck_curve_of_a_short_bearing():
    f = rt.Film("50 mPa*s", "10 mm", "10 mm", "50 um", "short")
    speeds = [row[0] for row in STRIBECK]
    found = f.stribeck("500 N", speeds, boundary_film="1 um", friction=0.1, stiffness=5e8)
    friction = found["friction"] + 0.1 * found["dry"] * 5e-5 / 10e-3  # here it acts at the pin's radius
    seen = np.array([found["eccentricity"], np.degrees(found["attitude"]), found["dry"], friction]).T
    np.testing.assert_allclose(seen, np.array(STRIBECK)[:, 1:], atol=3e-6)
    # what is lost is what the torque gives
    np.testing.assert_allclose(found["loss"], found["torque"] * found["speed"], rtol=1e-9)


def test_stribeck_curve_goes_from_dry_friction_over_its_valley_to_the_film_alone():
    f = rt.Film("50 mPa*s", "10 mm", "10 mm", "50 um")
    found = f.stribeck(500, boundary_film=1e-6)
    # pressed and rubbing at right angles, at the radius of the pin
    assert found["friction"].iloc[0] == pytest.approx(0.1 / math.hypot(1, 0.1) * (1 - 5e-5 / 10e-3), rel=2e-3)
    alone = found[found["dry"] == 0]
    assert alone["friction"].is_monotonic_increasing
    assert found["friction"].idxmin() == alone.index[0]
    last = found.iloc[-1]
    assert last["friction"] == pytest.approx(f.static(500, last["speed"]).friction, rel=1e-9)
    with pytest.raises(ValueError, match="thinner than half the clearance"):
        f.stribeck(500, boundary_film="25 um")
    with pytest.raises(ValueError, match="boundary_film must be positive"):
        f.stribeck(500, boundary_film=0)


def test_film_of_a_joint_has_its_sizes():
    m = rt.example("slider_crank_oil")
    f = m.film("B")
    assert (f.viscosity, f.length, f.radius, f.clearance, f.model) == pytest.approx((0.1, 0.02, 0.01, 1e-4, "finite"))
    with pytest.raises(rt.ModelError, match="needs oil in the joint"):
        m.film("A")
    with pytest.raises(KeyError, match="no joint 'b'; known: O, A, B"):
        m.film("b")
