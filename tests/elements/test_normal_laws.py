"""Normal laws: restitution, peak, duration, and what they never do."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from rattle import registry
from rattle.elements.contact_laws.normal import damping_factor, returned
from rattle.elements.contact_laws.restitution import factor_returning, restitution_returned

pytestmark = pytest.mark.nojit
LAWS = registry.kinds("normal")
STATIC = registry.kinds("stiffness")
POWER = ("power", {"stiffness": 1.0, "exponent": 1.5})
PIN = {"bush_radius": 0.01, "clearance": 5e-4, "length": 0.015, "bush_material": "steel", "pin_material": "brass"}
PIN |= {"elements": 9.0, "element_stiffness": 8e9, "exponent": 1.5}  # of a rolling bearing
PIN["foundation"] = 1e14  # [Pa/m]

# restitution a free impact returns, for 0.3 and 0.9 asked for: independent reference
TABLE = {
    "hunt-crossley": (0.58128804, 0.90901574),
    "lankarani-nikravesh": (0.68422461, 0.91317668),
    "herbert-mcwhannell": (0.51996655, 0.90089299),
    "lee-wang": (0.73899532, 0.95237015),
    "gonthier": (0.30422486, 0.87643542),
    "zhiying-qishao": (0.32669740, 0.89591819),
    "flores": (0.25620791, 0.89392069),
    "hu-guo": (0.27065846, 0.89989994),
    "gonthier-exact": (0.3, 0.9),
    "exact": (0.3, 0.9),
    "hertz": (1.0, 1.0),
}


def impact(law, restitution, static=POWER, mass=1.0, speed=1.0):
    """Free impact of one mass on a wall: speed it leaves with over `speed`, deepest penetration, duration."""
    normal, stiff = LAWS[law], STATIC[static[0]]
    p = np.array(stiff.leaf.pack(static[1]))
    values = {"restitution": restitution, "least_speed": 1e-6, "effective_mass": mass}
    p_normal = np.array(normal.leaf.pack(values))

    def rate(_, y):
        force = stiff.kernel.python(y[0], p, 0)
        return [y[1], -normal.kernel.python(force, y[0], y[1], speed, p_normal, 0) / mass]

    def leaves(_, y):
        return y[0]

    def deepest(_, y):
        return y[1]

    leaves.terminal, leaves.direction = True, -1
    # length: where the static force has taken up the energy, about F(scale) scale/2; time: that over the speed
    scale = 1e-12
    while stiff.kernel.python(scale, p, 0) * scale < mass * speed**2:
        scale *= 1.3
    span, start, atol = (0.0, 400.0 * scale / speed), [1e-14 * scale, speed], [1e-13 * scale, 1e-13 * speed]
    found = solve_ivp(rate, span, start, "DOP853", rtol=1e-11, atol=atol, events=(leaves, deepest))
    assert found.t_events[0].size == 1
    return -found.y_events[0][0][1] / speed, found.y_events[1][0][0], found.t_events[0][0]


@pytest.mark.parametrize("law", TABLE)
def test_free_impact_returns_the_tabled_restitution(law):
    for asked, want in zip((0.3, 0.9), TABLE[law], strict=True):
        assert returned(law, asked) == pytest.approx(want, abs=6e-9)  # the table has eight digits
        assert impact(law, asked)[0] == pytest.approx(want, abs=1e-8)  # error of the integration


@pytest.mark.parametrize("exponent", [1.0, 1.1, 1.5, 3.0])
def test_restitution_does_not_depend_on_the_exponent_mass_or_speed(exponent):
    static = ("power", {"stiffness": 3e7, "exponent": exponent})
    assert impact("exact", 0.55, static, mass=0.2, speed=0.7)[0] == pytest.approx(0.55, abs=1e-8)


@pytest.mark.parametrize("geometry", [name for name in STATIC if name != "power"])
def test_restitution_does_not_depend_on_the_static_law(geometry):
    back = impact("lankarani-nikravesh", 0.3, (geometry, PIN), mass=0.2, speed=2.0)[0]
    assert back == pytest.approx(0.68422461, abs=1e-7)


def test_hertz_reaches_its_closed_form_depth_and_duration():
    m, v, K = 0.3, 2.0, 6.6e10
    back, depth, time = impact("hertz", 1.0, ("power", {"stiffness": K, "exponent": 1.5}), m, v)
    assert back == pytest.approx(1.0, abs=1e-9)
    assert depth == pytest.approx(1.09336207394 * (m * v**2 / K) ** 0.4, rel=1e-9)
    assert time == pytest.approx(2.94327518432 * depth / v, rel=1e-9)


@pytest.mark.parametrize("asked", [0.02, 0.3, 0.9, 0.999])
def test_kelvin_voigt_without_pull_returns_its_closed_form(asked):
    static = ("power", {"stiffness": 4e6, "exponent": 1.0})
    back = impact("kelvin-voigt", asked, static, mass=0.2, speed=0.7)[0]
    assert back == pytest.approx(returned("kelvin-voigt", asked), abs=1e-6)  # corner where the pull is cut off


def test_kelvin_voigt_whole_half_wave_would_return_what_is_asked():
    zeta = damping_factor("kelvin-voigt", 0.3)
    assert math.exp(-math.pi * zeta / math.sqrt(1 - zeta**2)) == pytest.approx(0.3, rel=1e-14)
    assert damping_factor("kelvin-voigt", 0.0) == 1.0
    assert damping_factor("anagnostopoulos", 0.3) == zeta


@given(st.floats(1e-3, 1.0))
def test_factor_and_restitution_are_each_others_inverse(x):
    a = factor_returning(x)
    back = restitution_returned(a)
    assert back == pytest.approx(x, rel=1e-13)
    assert 1 - back == pytest.approx(1 - x, rel=1e-9, abs=2e-16)  # also next to 1, where 1 - x is what counts
    if 0.01 < a < 20:  # away from the limits the equation itself can be evaluated
        assert math.log((1 + a) / (1 - x * a)) == pytest.approx(a * (1 + x), rel=1e-8)


def test_factor_has_the_right_limits():
    assert factor_returning(1.0) == 0.0
    assert factor_returning(1 - 1e-9) == pytest.approx(1.5e-9, rel=1e-6)  # a -> 3(1-x)/2
    assert factor_returning(0.01) == pytest.approx(100.0, rel=1e-12)  # a -> 1/x
    assert factor_returning(0.0) == factor_returning(1e-3) == pytest.approx(1000.0)
    assert restitution_returned(0.0) == 1.0
    assert restitution_returned(math.inf) == 0.0


@given(
    st.sampled_from(sorted(LAWS)),
    st.floats(0, 1),
    st.floats(0, 1e5),
    st.floats(-1e-3, 1e-3),
    st.floats(-10, 10),
    st.floats(0, 10),
)
def test_contact_never_pulls_and_is_nothing_out_of_contact(law, e, static, delta, ddelta, v0):
    found = LAWS[law]
    p = np.array((0.0, *found.leaf.pack({"restitution": e, "least_speed": 1e-3, "effective_mass": 1.0})))
    force = found.kernel.python(static, delta, ddelta, v0, p, 1)
    assert math.isfinite(force)
    assert force >= 0.0
    assert force == 0.0 or delta > 0.0
    if delta > 0.0 and ddelta >= 0.0:
        assert force >= static  # damping resists the approach


def test_approach_from_rest_is_finite_and_damped_like_the_least_speed():
    kernel = LAWS["exact"].kernel.python
    p = np.array(LAWS["exact"].leaf.pack({"restitution": 0.5, "least_speed": 1e-3}))
    assert kernel(100.0, 1e-6, 1e-3, 0.0, p, 0) == kernel(100.0, 1e-6, 1e-3, 1e-3, p, 0) > 100.0


def test_notes_say_where_another_restitution_is_returned():
    values = {"restitution": 0.3, "least_speed": 1e-3}
    (note,) = LAWS["lankarani-nikravesh"].leaf.notes(values)
    assert "0.684" in note
    assert "0.3" in note
    assert LAWS["exact"].leaf.notes(values) == []
    assert LAWS["lankarani-nikravesh"].leaf.notes({**values, "restitution": 0.95}) == []


def test_bad_input_is_refused():
    with pytest.raises(ValueError, match="outside 0"):
        damping_factor("exact", 1.2)
    with pytest.raises(ValueError, match="outside 0"):
        damping_factor("exact", math.nan)
    with pytest.raises(ValueError, match="did you mean 'hunt-crossley'"):
        damping_factor("hunt-crosley", 0.5)
    with pytest.raises(ValueError, match="add energy"):
        restitution_returned(-0.1)
    with pytest.raises(ValueError, match="effective mass"):
        LAWS["kelvin-voigt"].leaf.pack({"restitution": 0.5, "effective_mass": 0.0})


def test_every_law_names_its_source_and_explains_its_fields():
    for family in ("normal", "stiffness", "friction"):
        for found in registry.kinds(family).values():
            assert found.source
            assert found.kernel.family == family
            assert all(entry.meaning for entry in found.fields.values())
