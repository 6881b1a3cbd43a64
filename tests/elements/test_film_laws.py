"""Laws of oil films: closed forms, frames, moments and power, the potential, and what lies beyond the bush."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

import rattle as rt
from oil_films import LAWS, OIL, film, parts, states, unit
from rattle import registry
from rattle.elements.short_film import SWITCH, short_integrals, short_peak

pytestmark = pytest.mark.nojit
VARIATIONAL = [law for law in LAWS if law[0] != "pinkus-sternlicht"]


def by_quadrature(a, b):
    """I1 and I2 of the short film: integrals over the half circle with pressure."""
    top = math.atan2(b, a)
    points = [top] if abs(top) < math.pi / 2 else None
    return [
        quad(
            lambda t, f=f: math.cos(t) * f(t) / (1 - a * math.cos(t) - b * math.sin(t)) ** 3,
            -math.pi / 2, math.pi / 2, points=points, epsabs=0, epsrel=1e-12, limit=200,
        )[0]
        for f in (math.cos, math.sin)
    ]  # fmt: skip


def test_the_integrals_of_the_short_film_are_those_of_its_pressure():
    rng = np.random.default_rng(1)
    for _ in range(40):
        e, alpha = 1 - 10 ** rng.uniform(-3, 0), math.pi * rng.random()
        a, b = e * math.cos(alpha), -e * math.sin(alpha)
        found = np.array(short_integrals.python(a, b, math.sqrt((1 - e) * (1 + e)))[1:])
        exact = np.array(by_quadrature(a, b))
        assert np.hypot(*(found - exact)) < 2e-12 * np.hypot(*exact)  # the quadrature is good to 1e-12


def test_the_series_meets_the_closed_form_where_it_takes_over():
    for b in (0.0, -0.2, -0.3):
        # s = SWITCH |a| and s^2 + a^2 + b^2 = 1
        a = -math.sqrt((1 - b * b) / (1 + SWITCH**2))
        s = -SWITCH * a
        series, closed = (short_integrals.python(a, b, s * (1 + tiny)) for tiny in (-1e-15, 1e-15))
        np.testing.assert_allclose(series, closed, rtol=1e-12, atol=1e-15)  # bracket cancels to 1e-3 of its terms


def test_the_peak_of_the_short_film_is_the_largest_pressure():
    phi = np.linspace(-math.pi, math.pi, 200_001)
    for e, alpha in ((0.0, 1.0), (0.5, 0.4), (0.9, math.pi / 2), (0.95, 2.4), (0.99, math.pi), (0.999, 1.7)):
        pressure = 1.5 * np.cos(phi - alpha) / (1 - e * np.cos(phi)) ** 3
        assert short_peak.python(e, alpha) == pytest.approx(pressure.max(), rel=1e-6)


@pytest.mark.parametrize(
    ("e", "degrees", "normal", "tangential"),
    [  # integrals to 15 digits
        (0.5, 60, 4.902362739685887, 2.824400777744409),
        (0.5, 90, 16 / 9, math.pi / (2 * 0.75**1.5)),
        (0.5, 120, 0.06556443506130586, 1.364389427041982),
        (0.999, 0, 52681724.65621235, 0.0),
        (0.999, 180, -0.2670098288024687, 0.0),
    ],
)
def test_short_film_in_numbers(e, degrees, normal, tangential):
    found = parts(film("short"), e, math.radians(degrees), turned=0.0)
    np.testing.assert_allclose(found, (normal, tangential), rtol=1e-10, atol=1e-8 * abs(normal))


@pytest.mark.parametrize(("model", "cavitation"), LAWS)
def test_about_the_centre_a_film_damps_alike_in_all_directions(model, cavitation):
    one = film(model, cavitation)
    known = {"short": math.pi, "pinkus-sternlicht": 6 * math.pi * (one.radius / one.length) ** 2}
    lam = one.ratio
    known["finite"] = math.pi * 3 * (1 - math.tanh(lam) / lam) / lam**2
    for angle in (0.3, 2.0, 4.0):
        v = 1e-3 * np.array([math.cos(angle), math.sin(angle)])
        force = np.array(one.force(0.0, 0.0, *v)[:2]) / unit(one)
        near = np.array(one.force(1e-9 * one.clearance, 2e-9 * one.clearance, *v)[:2]) / unit(one)
        np.testing.assert_allclose(near, force, rtol=3e-8)  # continuous; the force changes by some e
        if (model, cavitation) == ("finite", "reynolds"):  # between half the full film and the short one
            assert 0.5 * known["finite"] < -force @ v / (v @ v) < 0.5 * math.pi
            np.testing.assert_allclose(force, -np.hypot(*force) * v / np.hypot(*v), rtol=1e-9)
            continue
        half = 0.5 if (model, cavitation) == ("short", "reynolds") else 1.0
        np.testing.assert_allclose(force, -half * known[model] * v, rtol=2e-5)  # the table is good to 1e-5 here
    assert one.force(0.0, 0.0, 0.0, 0.0) == (0.0,) * 5


@pytest.mark.parametrize(("model", "cavitation"), LAWS)
def test_a_film_is_the_same_seen_from_a_turning_frame(model, cavitation):
    one = film(model, cavitation)
    for ex, ey, vx, vy, wa, wb in states(one, 40, 2):
        here = np.array(one.force(ex, ey, vx, vy, wa, wb))
        there = np.array(one.force(ex, ey, vx - 37 * ey, vy + 37 * ex, wa + 37, wb + 37))
        force, moment = np.hypot(*here[:2]), abs(here[2]) + abs(here[3])
        assert np.max(np.abs(there - here) / (force, force, moment, moment, here[4])) < 1e-11  # v is a difference


@pytest.mark.parametrize("shear", ["whole", "wetted"])
@pytest.mark.parametrize(("model", "cavitation"), LAWS)
def test_moments_balance_and_power_is_the_loss(model, cavitation, shear):
    one = film(model, cavitation, shear=shear)
    for ex, ey, vx, vy, wa, wb in states(one, 40, 3):
        fx, fy, bush, pin, loss = one.force(ex, ey, vx, vy, wa, wb)
        across = ex * fy - ey * fx
        assert abs(bush + pin + across) < 1e-13 * (abs(bush) + abs(pin) + abs(across))
        terms = np.array([fx * vx, fy * vy, bush * wa, pin * wb, loss])
        assert abs(terms.sum()) < 1e-13 * np.abs(terms).max()
        assert loss >= 0.0


def test_the_shear_of_a_film_is_that_of_its_gap():
    for shear, e in (("whole", 0.7), ("wetted", 0.7)):
        one = film(shear=shear)
        bush, pin = one.force(e * one.clearance, 0.0, 0.0, 0.0, -40.0, 40.0)[2:4]  # w_m = 0: no pressure
        start, end = (-math.pi, math.pi) if shear == "whole" else (0.0, math.pi)
        arc = quad(lambda phi, e=e: 1 / (1 - e * math.cos(phi)), start, end)[0]
        shown = one.viscosity * one.radius**3 * one.length / one.clearance * 80.0
        whole = 2 * math.pi / math.sqrt(1 - e * e)
        assert (bush, pin) == pytest.approx((shown * (arc if shear == "whole" else 0.5 * whole), -bush), rel=1e-9)


@pytest.mark.parametrize(("model", "cavitation"), VARIATIONAL)
def test_the_force_is_the_slope_of_a_potential(model, cavitation):
    # F.m = -C |v| g and F.k = -C |v| g_alpha/2
    rng = np.random.default_rng(4)
    for ratio in (0.1, 0.35, 1.0, 1.9):
        one = film(model, cavitation, ratio)
        for _ in range(15):
            e, a, h = 0.02 + 0.96 * rng.random(), 0.1 + 2.9 * rng.random(), 3e-5
            g = []
            for b in (a - h, a, a + h):
                turn = np.array([[math.cos(b), math.sin(b)], [-math.sin(b), math.cos(b)]])
                g.append(turn @ parts(one, e, b))
            assert g[1][0] > 0.0
            slope = (g[2][0] - g[0][0]) / (4 * h)
            assert abs(g[1][1] - slope) < 1e-6 * np.hypot(*g[1])  # differences of second order


@pytest.mark.parametrize(("model", "cavitation"), LAWS)
def test_more_speed_meets_more_resistance(model, cavitation):
    # the potential is convex: (F(v) - F(w)).(v - w) <= 0; the long film promises F.v <= 0 only
    one = film(model, cavitation, 1.0)
    for (ex, ey, vx, vy, *_), (*_, wx, wy, _, _) in zip(states(one, 60, 5, 1.2), states(one, 60, 6), strict=True):
        first, second = (np.array(one.force(ex, ey, *v)[:2]) for v in ((vx, vy), (wx, wy)))
        if model == "pinkus-sternlicht":
            assert first @ (vx, vy) < 0.0
        else:
            assert (first - second) @ (vx - wx, vy - wy) < 0.0


@pytest.mark.parametrize(("model", "cavitation"), LAWS)
def test_beyond_the_bush_a_film_still_resists_with_a_finite_force(model, cavitation):
    one = film(model, cavitation)
    c = one.clearance
    forces = [one.force(e * c, 0.0, 1e-3, 5e-4, 0.0, 0.0) for e in (0.9999, 1 - 1e-6, 1 + 1e-6, 1.3, 40.0)]
    assert all(math.isfinite(x) for force in forces for x in force)
    assert forces[0][0] > forces[1][0] > -math.inf  # thinner is stronger
    # constant from the least film on; moments have the true arm of the force, the shear that of the least film
    np.testing.assert_allclose([one[:2] for one in forces[2:]], [forces[1][:2]] * 3, rtol=1e-6)
    assert forces[4][2] + forces[4][3] == pytest.approx(-40.0 * c * forces[4][1], rel=1e-12)


@pytest.mark.usefixtures("mode")
@pytest.mark.parametrize(("model", "cavitation"), LAWS)
def test_a_state_that_is_no_number_gives_no_number_and_no_error(model, cavitation):
    found = registry.kinds("film")[model]
    values = {"viscosity": 0.05, "length": 0.01, "bush_radius": 0.01, "cavitation": cavitation, "shear": "whole"}
    p, table = np.array(found.leaf.pack(values, 5e-5, 5e-11)), np.array(found.leaf.table(values))
    for wrong in (math.nan, math.inf):
        for k in range(6):
            state, out = [1e-5, 2e-5, 1e-3, 2e-3, 10.0, 20.0], np.zeros(5)
            state[k] = wrong
            with np.errstate(invalid="ignore"):
                found.kernel(*state, p, 0, table, out)
            assert not np.isfinite(out[4])


def test_a_finite_film_becomes_a_short_one():
    for ratio, most in ((1 / 40, 0.01), (1 / 400, 1e-4)):  # the difference falls with the square of L/D
        for e, alpha in ((0.0, 0.0), (0.3, 1.0), (0.6, 2.0), (0.8, 0.2), (0.8, 3.1)):
            short, finite = (parts(film(model, ratio=ratio), e, alpha) for model in ("short", "finite"))
            assert np.hypot(*(finite - short)) < most * np.hypot(*short)


def test_wedge_and_squeeze_of_a_long_film():
    # both are closed forms of a full circle (squeeze) and half a circle (wedge) of pressure
    one = film("pinkus-sternlicht")
    scale = (one.radius / one.length) ** 2
    for e in (0.2, 0.5, 0.9):
        s, long = math.sqrt(1 - e * e), 2 + e * e
        wedge = 24 * e / (long * s**2), 12 * math.pi / (long * s)
        np.testing.assert_allclose(parts(one, e, math.pi / 2), scale * np.array(wedge), rtol=1e-9)
        just = [parts(one, e, math.pi / 2 + tiny) for tiny in (-1e-9, 1e-9)]
        np.testing.assert_allclose(*just, rtol=1e-7)  # no jump where the approach turns into separation


@pytest.mark.usefixtures("mode")
@pytest.mark.parametrize(("model", "cavitation"), LAWS)
def test_kernels_of_films_are_the_same_as_machine_code(model, cavitation):
    found = registry.kinds("film")[model]
    values = {"viscosity": 0.05, "length": 0.01, "bush_radius": 0.01, "cavitation": cavitation, "shear": "wetted"}
    own = np.array(found.leaf.pack(values, 5e-5, 5e-11))
    first = 3  # both parameters and coefficients stand behind those of others
    own[6] = first
    p, table = np.concatenate([[9.0, 9.0], own]), np.concatenate([[7.0] * first, found.leaf.table(values)])
    one = film(model, cavitation, shear="wetted")
    for state in [*states(one, 6, 7, 1.1), (0.0,) * 6]:
        out, python = np.full(5, np.nan), np.full(5, np.nan)
        found.kernel(*state, p, 2, table, out)
        found.kernel.python(*state, p, 2, table, python)
        np.testing.assert_allclose(out, python, rtol=1e-13, atol=0.0)
        np.testing.assert_allclose(out, one.force(*state), rtol=1e-13, atol=0.0)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"viscosity": 0.0}, "viscosity must be positive"),
        ({"viscosity": None}, "viscosity is a dynamic viscosity in Pa"),
        ({"viscosity": "50 mm"}, "is a length; expected a dynamic viscosity"),
        ({"length": -0.01}, "length must be positive"),
        ({"radius": math.nan}, "radius must be positive and finite"),
        ({"clearance": math.inf}, "clearance must be positive and finite"),
        ({"clearance": True}, "clearance is a number in m"),
        ({"clearance": 2.1e-4}, r"0.021 of the radius; .* at most 0.02"),
        ({"length": 0.0401}, "L/D is 2"),
        ({"model": "shrt"}, "did you mean 'short'"),
        ({"cavitation": "none"}, "'reynolds' or 'full', not 'none'"),
        ({"model": "pinkus-sternlicht", "cavitation": "full"}, "of a film 'pinkus-sternlicht' is 'reynolds'"),
        ({"shear": "hole"}, "did you mean 'whole'"),
    ],
)
def test_what_makes_no_film_is_refused(given, said):
    with pytest.raises((ValueError, TypeError), match=said):
        rt.Film(**{**OIL, **given})
