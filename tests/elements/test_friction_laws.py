"""Friction laws: passive, bounded, odd in the slip, and their closed forms; all law kernels as machine code."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rattle import registry
from rattle.jit import families, functions

pytestmark = pytest.mark.nojit
LAWS = registry.kinds("friction")
STATELESS = sorted(name for name, found in LAWS.items() if found.leaf.states == 0)
BRISTLES = sorted(name for name, found in LAWS.items() if found.leaf.states == 1)
GIVEN = {"mu": 0.2, "mu_static": 0.3, "viscosity": 5.0, "sigma2": 0.1}


def numbers(name, **given):
    values = {}
    for key, entry in LAWS[name].fields.items():
        default = entry.default(values) if callable(entry.default) else entry.default
        values[key] = given.get(key, GIVEN.get(key, default))
    return np.array(LAWS[name].leaf.pack(values))


def friction(name, u, N, z=0.0, **given):
    """T and dz."""
    dz = np.zeros(1)
    T = LAWS[name].kernel.python(u, N, np.array([z]), numbers(name, **given), 0, dz)
    return T, dz[0]


slips = st.floats(-10, 10) | st.floats(-1e-3, 1e-3)
normals = st.floats(0, 1e5)


@given(st.sampled_from(STATELESS), slips, normals)
def test_friction_without_memory_only_takes_power(name, u, N):
    T, dz = friction(name, u, N)
    assert T * u >= 0.0
    assert dz == 0.0
    assert friction(name, -u, N)[0] == -T


@given(
    st.sampled_from(BRISTLES),
    slips,
    normals,
    st.floats(-0.1, 0.1),
    st.sampled_from([0.5, 1.0, 2.0]),
    st.sampled_from([0.0, 1.0, 1e3]),
)
def test_bristles_never_give_back_more_than_they_hold(name, u, N, z, alpha, damping):
    # T u - dS/dt >= 0 with S = sigma z^2/2, at every instant; S does not depend on N: so for every N(t)
    T, dz = friction(name, u, N, z, alpha=alpha, sigma1=damping)
    sigma = 1e4
    supplied, stored = T * u, sigma * z * dz
    assert supplied - stored >= -1e-12 * (abs(supplied) + abs(stored))  # rounding
    assert friction(name, -u, N, -z, alpha=alpha, sigma1=damping) == (-T, -dz)


@pytest.mark.plain
@pytest.mark.parametrize("name", BRISTLES)
@settings(max_examples=20)
@given(
    st.lists(st.tuples(st.floats(-0.05, 0.05), st.floats(0.1, 100)), min_size=2, max_size=6),
    st.integers(1, 3),
)
def test_no_cycle_of_slip_and_normal_force_yields_energy(name, stages, rounds):
    # slip and normal force follow a closed smooth path; z by Runge-Kutta 4; fails for T = N sigma zeta
    p, kernel, dz = numbers(name), LAWS[name].kernel.python, np.zeros(1)
    u, N = (np.array(column) for column in zip(*stages, strict=True))
    phase = 2 * np.pi * np.arange(len(stages)) / len(stages)
    steps, h = 400, 2e-3 / 400

    def rate(s, z):
        weight = np.exp(3 * np.cos(2 * np.pi * s - phase))
        slip, press = (weight @ u) / weight.sum(), (weight @ N) / weight.sum()
        T = kernel(slip, press, np.array([z]), p, 0, dz)
        return dz[0], T * slip

    z = work = moved = 0.0
    for step in range(steps * rounds):
        s = step / steps
        k1, w1 = rate(s, z)
        k2, w2 = rate(s + 0.5 / steps, z + 0.5 * h * k1)
        k3, w3 = rate(s + 0.5 / steps, z + 0.5 * h * k2)
        k4, w4 = rate(s + 1.0 / steps, z + h * k3)
        z += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        gained = h / 6 * (w1 + 2 * w2 + 2 * w3 + w4)
        work, moved = work + gained, moved + abs(gained)
    assert work - 0.5 * 1e4 * z * z >= -1e-5 * moved  # error of the integration


@given(st.sampled_from(sorted(set(LAWS) - {"viscous"})), slips, normals, st.floats(-0.1, 0.1))
def test_friction_stays_within_coulombs_cone(name, u, N, z):
    T, _ = friction(name, u, N, z, viscosity=0.0, sigma1=0.0, sigma2=0.0)
    assert abs(T) <= 0.3 * N * (1 + 1e-15)
    if "mu_static" not in LAWS[name].fields:
        assert abs(T) <= 0.2 * N * (1 + 1e-15)


@pytest.mark.parametrize("name", sorted(LAWS))
def test_friction_is_continuous_where_damping_brings_the_normal_force_to_zero(name):
    for u in (-1.0, 1e-3, 0.5):
        for z in (-1e-3, 0.0, 1e-3):
            at_zero = friction(name, u, 0.0, z)
            assert friction(name, u, -1.0, z) == at_zero
            assert friction(name, u, 1e-16, z) == pytest.approx(at_zero, rel=1e-6, abs=1e-7)


def slide(name, u, N, x, steps=2000, **given):
    """T after a slip x at constant speed and normal force, from z = 0."""
    z, h = 0.0, x / u / steps
    for _ in range(steps):
        k1 = friction(name, u, N, z, **given)[1]
        k2 = friction(name, u, N, z + 0.5 * h * k1, **given)[1]
        k3 = friction(name, u, N, z + 0.5 * h * k2, **given)[1]
        k4 = friction(name, u, N, z + h * k3, **given)[1]
        z += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return friction(name, u, N, z, **given)[0]


@pytest.mark.parametrize("N", [0.5, 200.0])
@pytest.mark.parametrize("x", [2e-6, 2e-5, 1e-4])
def test_dahl_at_constant_speed(N, x):
    Fc, stiffness = 0.2 * N, 1e4 * N
    assert slide("dahl", 0.03, N, x) == pytest.approx(Fc * (1 - math.exp(-stiffness * x / Fc)), rel=1e-9)


def test_dahl_with_another_exponent():
    # alpha = 2: T = Fc s/(1 + s), s = sigma x/Fc
    N, x = 50.0, 4e-5
    s = 1e4 * x / 0.2
    assert slide("dahl", 0.03, N, x, alpha=2.0) == pytest.approx(0.2 * N * s / (1 + s), rel=1e-8)


@pytest.mark.parametrize("u", [1e-3, 0.01, 0.2, -0.2])
@pytest.mark.parametrize("N", [0.5, 200.0])
def test_lugre_steady_state(u, N):
    g = 0.2 + 0.1 * math.exp(-((u / 0.01) ** 2))
    want = N * (math.copysign(g, u) + 0.1 * u)
    assert slide("lugre", u, N, math.copysign(2e-3, u), 4000) == pytest.approx(want, rel=1e-9)


def test_bristles_let_go_as_the_normal_force_falls():
    # loaded to sliding at 100 N, then 1 N: no more than mu times 1 N is left
    z = 0.2 / 1e4 * math.sqrt(100.0)
    assert friction("dahl", 0.0, 100.0, z)[0] == pytest.approx(0.2 * 100.0)
    assert friction("dahl", 0.0, 1.0, z)[0] == pytest.approx(0.2 * 1.0)


@pytest.mark.parametrize(
    ("name", "creep"),
    [
        ("coulomb-smooth", 1e-3 * math.atanh(0.5)),
        ("ambrosio", 1e-4 + 0.5 * 9e-4),
        ("threlfall", -1e-3 / 3 * math.log(0.5)),
    ],
)
def test_half_the_friction_is_held_at_the_creep_stated(name, creep):
    assert friction(name, creep, 100.0)[0] == pytest.approx(0.5 * 0.2 * 100.0, rel=1e-12)


def test_full_friction_at_large_slip():
    for name, want in (("coulomb-smooth", 20.0), ("ambrosio", 20.0), ("threlfall", 20.0 * (1 - math.exp(-3)))):
        assert friction(name, 0.5, 100.0)[0] == pytest.approx(want, rel=1e-12)
    assert friction("stribeck", 0.5, 100.0)[0] == pytest.approx(20.0 + 5.0 * 0.5, rel=1e-12)
    assert friction("stribeck", 5e-3, 100.0, viscosity=0.0)[0] == pytest.approx(
        100 * (0.2 + 0.1 * math.exp(-0.25)) * math.tanh(5.0), rel=1e-12
    )
    assert friction("viscous", 0.5, 100.0)[0] == 2.5


def test_ambrosio_needs_two_speeds_in_order():
    with pytest.raises(ValueError, match="v0 < v1"):
        numbers("ambrosio", v0=1e-3)


# ---------------------------------------------------------------- machine code
def test_every_kernel_gives_the_same_value_compiled():
    if not functions.start():
        pytest.skip("runs without machine code")
    rng = np.random.default_rng(3)
    dz, dz_python = np.zeros(1), np.zeros(1)
    pin = {"bush_radius": 0.01, "clearance": 5e-4, "length": 0.015, "bush_material": "steel", "pin_material": "nylon"}
    pin |= {"elements": 9.0, "element_stiffness": 8e9, "exponent": 1.5}  # of a rolling bearing
    pin["foundation"] = 1e14
    for found in registry.kinds("stiffness").values():
        p = np.array((0.0, *found.leaf.pack({**pin, "stiffness": 1e9, "exponent": 1.3})))
        for delta in (-1e-6, 0.0, *10.0 ** rng.uniform(-12, -1, 30)):
            assert found.kernel(delta, p, 1) == pytest.approx(found.kernel.python(delta, p, 1), rel=1e-14)
    for found in registry.kinds("normal").values():
        p = np.array((0.0, *found.leaf.pack({"restitution": 0.4, "least_speed": 1e-3, "effective_mass": 0.2})))
        for static, delta, ddelta in zip(*rng.uniform(-1, 1, (3, 30)), strict=True):
            for v0 in (0.0, 0.5):
                want = found.kernel.python(static, delta, ddelta, v0, p, 1)
                assert found.kernel(static, delta, ddelta, v0, p, 1) == pytest.approx(want, rel=1e-14)
    for name, found in registry.kinds("friction").items():
        p = np.array((0.0, *numbers(name)))
        for u, N, z in zip(rng.normal(0, 0.01, 30), rng.uniform(-1, 50, 30), rng.normal(0, 1e-4, 30), strict=True):
            T = found.kernel(u, N, np.array([z]), p, 1, dz)
            assert pytest.approx(found.kernel.python(u, N, np.array([z]), p, 1, dz_python), rel=1e-13) == T
            assert dz[0] == pytest.approx(dz_python[0], rel=1e-13)


@functions.compiled
def contact(stiffness, normal, friction, delta, ddelta, v0, u, p, z, dz):
    static = families.call_stiffness(stiffness[0], (delta, p, 0))
    force = families.call_normal(normal[0], (static, delta, ddelta, v0, p, 2))
    return force, families.call_friction(friction[0], (u, force, z, p, 4, dz))


def test_laws_are_called_through_their_tables_in_a_compiled_loop():
    functions.start()
    families = ("stiffness", "normal", "friction")
    names = ("power", "exact", "coulomb-smooth")
    found = [registry.kinds(family)[name] for family, name in zip(families, names, strict=True)]
    tables = [registry.table(family)[kind.tag :] for family, kind in zip(families, found, strict=True)]
    p = np.array([1e9, 1.5, *found[1].leaf.pack({"restitution": 0.5, "least_speed": 1e-3}), 0.2, 1e-3])
    N, T = contact(*tables, 1e-4, 0.1, 0.4, 0.05, p, np.zeros(1), np.zeros(1))
    assert pytest.approx(1e9 * 1e-6 * (1 + p[2] * 0.25), rel=1e-14) == N
    assert pytest.approx(0.2 * N, rel=1e-14) == T
