"""Compliant contact: published and independent numbers, balances, limits, and contacts that are hard to find."""

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

import rattle as rt
from linkages import block_in_guide
from rattle import registry
from rattle.elements.contact_laws.normal import returned

SLIDER_CRANK = "slider_crank_play"
DATA = Path(__file__).parents[1] / "data"
A = 19419.360511  # acceleration of the ideal slider at the outer dead centre [m/s^2], independent reference


def pin_in_bush(contact, *, x=0.0, y=0.0, vx=0.5, vy=0.0, c=1e-3, g=0.0, mass=1.0):
    """A free body whose pin flies in a fixed bush."""
    return rt.loads(f"""
format = 1
gravity = [0, {-g}]
[ground.points]
O = [0, 0]
[bodies.pin]
points = {{ P = [0, 0] }}
mass = {mass}
inertia = 1e-3
[joints.O]
type = "revolute"
connect = ["ground.O", "pin.P"]
clearance = {c}
contact = {contact}
[initial]
pin = {{ x = {x}, y = {y}, angle = 0, vx = {vx}, vy = {vy}, omega = 0 }}
""")


def isolated_pair(friction, law="exact"):
    """Two free bodies, the pin of one in the bush of the other, spinning against each other."""
    return rt.loads(f"""
format = 1
[ground.points]
far = [9, 9]
[bodies.bush]
points = {{ P = [0.03, 0.01] }}
mass = 2
inertia = 0.004
[bodies.arm]
points = {{ P = [-0.02, 0] }}
mass = 0.7
inertia = 0.002
[joints.P]
type = "revolute"
connect = ["bush.P", "arm.P"]
clearance = "0.4 mm"
contact = {{ model = "{law}", restitution = 0.6, stiffness = 5e9, bush_radius = "10 mm", friction = {friction} }}
[initial]
bush = {{ x = 0, y = 0, angle = 0.3, vx = 0.1, vy = -0.2, omega = 4 }}
arm = {{ angle = -0.5, vx = -0.4, vy = 0.5, omega = -7 }}
""")


def contacts_of(result, joint):
    return [event for event in result.events if event.kind == "contact" and event.joint == joint]


# ---------------------------------------------------------------- numbers from elsewhere
def test_slider_crank_hits_its_bush_as_the_independent_reference_says():
    # parameters of the class of Flores, Ambrosio (2004); numbers: independent reference, two routes that agree
    want = [
        (2.27286032e-4, 4.3857831, 45872.27),
        (6.3705643e-4, 2.756949, 20869.93),
        (7.4970028e-4, 1.826699, 25926.15),
        (1.0859470e-3, 1.101851, 6557.87),
        (1.2058161e-3, 0.823801, 12915.66),
        (1.551486e-3, 0.270939, 1672.21),
    ]
    m = rt.example(SLIDER_CRANK)
    r = m.simulate(1.8e-3, rtol=1e-10, atol=1e-13)
    hits = contacts_of(r, "B")
    for event, (t, v0, peak) in zip(hits, want, strict=False):
        assert event.t == pytest.approx(t, rel=1e-6)  # the digits of the reference
        assert event.normal_speed == pytest.approx(v0, rel=1e-5)
        assert event.peak_force == pytest.approx(peak, rel=2e-4)
    assert hits[0].duration == pytest.approx(5.343723e-5, rel=1e-5)
    release = next(event for event in r.events if event.kind == "release")
    assert release.normal_speed == pytest.approx(3.9114926, rel=1e-6)
    assert release.t == pytest.approx(hits[0].t + hits[0].duration, rel=1e-12)
    within = m.simulate(t_eval=np.linspace(2.4e-4, 2.7e-4, 3001), rtol=1e-10, atol=1e-13)
    assert within["B.penetration"].max() == pytest.approx(7.795222e-5, rel=1e-6)
    assert r.contacts["B"].peak == pytest.approx(45872.27, rel=2e-4)


@pytest.mark.parametrize("e", [0.3, 0.9])
@pytest.mark.parametrize("law", sorted(set(registry.kinds("normal")) - {"kelvin-voigt", "anagnostopoulos"}))
def test_every_law_returns_its_restitution_through_the_public_interface(law, e):
    contact = f'{{ model = "{law}", restitution = {e}, stiffness = 1e9, exponent = 1.5 }}'
    r = pin_in_bush(contact).simulate(0.0035, rtol=1e-11, atol=1e-14)
    # any stiffness and mass: the root of ln((1+a)/(1-xa)) = a(1+x), checked against a table in test_normal_laws
    assert abs(r["pin.vx"][-1]) / 0.5 == pytest.approx(returned(law, e), abs=2e-8)
    (one,) = contacts_of(r, "O")
    assert one.energy_lost == pytest.approx(0.125 * (1 - returned(law, e) ** 2), abs=1e-9)
    assert one.impulse == pytest.approx(0.5 * (1 + returned(law, e)), rel=1e-8)


@pytest.mark.parametrize("e", [0.4, 0.9])
def test_kelvin_voigt_returns_its_closed_form(e):
    contact = f'{{ model = "kelvin-voigt", restitution = {e}, stiffness = 1e6, exponent = 1.0 }}'
    r = pin_in_bush(contact).simulate(0.006, rtol=1e-11, atol=1e-14)
    assert abs(r["pin.vx"][-1]) / 0.5 == pytest.approx(returned("kelvin-voigt", e), rel=1e-6)


def test_hertz_contact_has_its_closed_form_depth_time_and_peak():
    K, v = 1e9, 0.5
    (one,) = contacts_of(pin_in_bush('{ model = "hertz", stiffness = 1e9 }').simulate(0.0035, rtol=1e-11), "O")
    deep = 1.09336207394 * (v * v / K) ** 0.4
    assert one.duration == pytest.approx(2.94327518432 * deep / v, rel=1e-8)
    assert one.peak_force == pytest.approx(K * deep**1.5, rel=1e-6)
    assert one.energy_lost == pytest.approx(0.0, abs=1e-10)


# ---------------------------------------------------------------- balances
FRICTIONS = {
    "none": "0",
    "coulomb-smooth": '{ model = "coulomb-smooth", mu = 0.2, v1 = "1 cm/s" }',
    "ambrosio": '{ model = "ambrosio", mu = 0.2, v0 = "1 mm/s", v1 = "2 cm/s" }',
    "threlfall": '{ model = "threlfall", mu = 0.2, vr = "2 cm/s" }',
    "viscous": '{ model = "viscous", viscosity = 30 }',
    "stribeck": '{ model = "stribeck", mu = 0.2, mu_static = 0.3, v1 = "1 cm/s" }',
    "dahl": '{ model = "dahl", mu = 0.2, sigma = 1e4 }',
    "lugre": '{ model = "lugre", mu = 0.2, mu_static = 0.3, sigma0 = 1e4 }',
}


def test_all_friction_laws_are_here():
    assert set(FRICTIONS) == {"none", *registry.kinds("friction")}


@pytest.mark.parametrize("name", sorted(FRICTIONS))
def test_a_pair_left_to_itself_keeps_momentum_and_accounts_for_its_energy(name):
    r = isolated_pair(FRICTIONS[name]).simulate(0.02, rtol=1e-10)
    assert r.success
    assert r.contacts["P"].contacts >= 3
    mass, inertia = {"bush": 2.0, "arm": 0.7}, {"bush": 0.004, "arm": 0.002}
    for axis in "xy":
        p = sum(m * r[f"{b}.v{axis}"] for b, m in mass.items())
        assert p == pytest.approx(np.full(len(r.t), p[0]), abs=1e-13)
    spin = sum(
        mass[b] * (r[f"{b}.x"] * r[f"{b}.vy"] - r[f"{b}.y"] * r[f"{b}.vx"]) + inertia[b] * r[f"{b}.omega"] for b in mass
    )
    assert spin == pytest.approx(np.full(len(r.t), spin[0]), abs=1e-9)  # integrated, at rtol 1e-10
    energy = r["energy.kinetic"][0]
    assert np.abs(r["energy.balance"]).max() < 1e-6 * energy
    lost = r["energy.dissipated"]
    back = float(np.diff(lost).min())
    states = registry.kinds("friction")[name].leaf.states if name != "none" else 0
    assert back >= (-1e-3 if states else -1e-9) * energy  # bristles give back what they hold, nothing else does
    assert lost[-1] == pytest.approx(r.contacts["P"].energy_lost, rel=1e-6, abs=1e-9)


def test_slider_crank_accounts_for_its_energy():
    m = rt.example(SLIDER_CRANK).set({"joints.B.contact.friction": 0.1})
    r = m.simulate(6e-3, rtol=1e-10)
    moved = r["energy.kinetic"].max()
    assert r.trust.energy_balance < 1e-6 * moved
    assert r["energy.dissipated"][-1] > 0.01 * moved


# ---------------------------------------------------------------- limits
def bouncing_times(stiffness, count=4):
    """First impacts of a pin with speed 1 m/s, restitution 0.8, 40 degrees from the normal; unit c/v0."""
    b, c = math.radians(40), 1e-3
    start = {"x": c - 0.5 * c * math.cos(b), "y": -0.5 * c * math.sin(b), "vx": math.cos(b), "vy": math.sin(b)}
    m = pin_in_bush(f'{{ model = "exact", restitution = 0.8, stiffness = {stiffness}, exponent = 1.5 }}', **start, c=c)
    r = m.simulate(6e-3, rtol=1e-11, atol=1e-14)
    return np.array([event.t for event in contacts_of(r, "O")[:count]]) / c


def test_stiffness_to_infinity_tends_to_rigid_impacts():
    rigid = np.array([0.5, 2.053954329, 3.554303658, 4.937756907])  # closed form
    soft, stiff, stiffer = (np.abs(bouncing_times(K) - rigid).max() for K in (1e11, 1e13, 1e15))
    # the time of a contact falls as K^(-2/5): 6.3 times for a hundred times the stiffness; what is left out is of the
    # next order, the depth as a share of the play: 4 % and 0.6 %
    assert soft / stiff == pytest.approx(100**0.4, rel=0.04)
    assert stiff / stiffer == pytest.approx(100**0.4, rel=0.006)
    assert stiffer < 0.02  # four contacts of 3e-6 s or so, in units of 1e-3 s


def test_less_play_tends_to_no_play():
    # no play: slider where its closed form is; the pin is never further off than the play and what it sinks in
    ideal = rt.example(SLIDER_CRANK).ideal().simulate(3e-3)
    for c in (5e-4, 5e-5, 5e-6):
        r = rt.example(SLIDER_CRANK).set({"parameters.c": c}).simulate(3e-3)
        off = np.abs(r["slider.x"] - ideal["slider.x"]).max()
        assert off < 1.2 * (c + r["B.penetration"].max())
        assert off > 0.5 * c


@pytest.mark.parametrize("c", [1e-6, 1e-7])
def test_first_contact_of_little_play_comes_when_the_acceleration_says(c):
    r = rt.example(SLIDER_CRANK).set({"parameters.c": c}).simulate(4 * math.sqrt(2 * c / A), rtol=1e-12, atol=1e-15)
    first = contacts_of(r, "B")[0]
    # to first order in c: t = sqrt(2c/a), v = sqrt(2ac); the next order is (omega t)^2
    small = (523.6 * first.t) ** 2
    assert first.t == pytest.approx(math.sqrt(2 * c / A), rel=2 * small)
    assert first.normal_speed == pytest.approx(math.sqrt(2 * A * c), rel=2 * small)


def test_elastic_motion_runs_backwards_as_it_came():
    forth = pin_in_bush('{ model = "hertz", stiffness = 1e9 }', y=3e-4, vy=0.3, g=9.81).simulate(0.0243, rtol=1e-12)
    assert len(contacts_of(forth, "O")) >= 6
    assert forth["O.normal"][-1] == 0.0  # in flight
    end = {what: float(forth[f"pin.{what}"][-1]) for what in ("x", "y", "vx", "vy")}
    turned = {**end, "vx": -end["vx"], "vy": -end["vy"]}
    back = pin_in_bush('{ model = "hertz", stiffness = 1e9 }', **turned, g=9.81).simulate(0.0243, rtol=1e-12)
    start = np.array([0.0, 3e-4, 0.5, 0.3])
    found = [back[f"pin.{what}"][-1] * sign for what, sign in (("x", 1), ("y", 1), ("vx", -1), ("vy", -1))]
    # bounces in a circle spread errors tenfold each: 1e-12 becomes 1e-6 or so
    assert np.array(found) == pytest.approx(start, abs=1e-4)


# ---------------------------------------------------------------- contacts that are hard to find
@pytest.mark.parametrize("deep", [1e-9, 1e-12])
@pytest.mark.parametrize("rtol", [1e-5, 1e-9])
def test_a_pin_that_only_grazes_is_noticed(deep, rtol):
    # thrown up so that the top of its path is `deep` inside the top of the wall, in flight far longer than in contact
    c, g, vx, rise = 1e-3, 9.81, 0.03, 5e-3
    m = pin_in_bush(
        '{ model = "hertz", stiffness = 1e9 }',
        x=-vx * rise, y=c + deep - 0.5 * g * rise**2, vx=vx, vy=g * rise, c=c, g=g,
    )  # fmt: skip
    r = m.simulate(2 * rise, t_eval=[0.0, 2 * rise], rtol=rtol)
    (one,) = contacts_of(r, "O")
    half = math.sqrt(deep / (0.5 * g - 0.5 * vx**2 / c))  # the wall falls away below the path: |e| - c along it
    assert one.t == pytest.approx(rise - half, abs=0.02 * half + 1e-11)
    assert one.duration == pytest.approx(2 * half, rel=0.05)


def test_a_pin_that_just_misses_is_left_alone():
    c, g, vx, rise = 1e-3, 9.81, 0.03, 5e-3
    y = c - 1e-9 - 0.5 * g * rise**2
    m = pin_in_bush('{ model = "hertz", stiffness = 1e9 }', x=-vx * rise, y=y, vx=vx, vy=g * rise, c=c, g=g)
    assert m.simulate(2 * rise).events == ()


@pytest.mark.parametrize("stiffness", [1e9, 1e13, 1e17])
def test_no_contact_is_missed_however_short(stiffness):
    # to and fro along a diameter without loss: the number of contacts is known
    m = pin_in_bush(f'{{ model = "hertz", stiffness = {stiffness} }}', vx=0.5)
    r = m.simulate(0.1, t_eval=[0.0, 0.1], rtol=1e-6)
    deep = 1.09336207394 * (0.25 / stiffness) ** 0.4
    lasts = 2.94327518432 * deep / 0.5
    period = 2e-3 / 0.5 + lasts
    assert len(contacts_of(r, "O")) == math.floor((0.1 - 2e-3) / period) + 1
    assert abs(r["pin.vx"][-1]) == pytest.approx(0.5, rel=1e-3)  # 25 contacts at rtol 1e-6


# ---------------------------------------------------------------- at rest
def test_a_block_settles_level_in_its_guide():
    contact = '{ model = "exact", restitution = 0.3, stiffness = 1e8, exponent = 1.5, friction = 0.2 }'
    m = rt.loads(block_in_guide(contact, 2e-4, 0.08, 0.04, 9.81, angle=0.001, vx=0.1))
    r = m.simulate(1.0)
    assert r.success
    assert r["block.angle"][-1] == pytest.approx(0.0, abs=1e-7)
    sunk = (0.5 * 2 * 9.81 / 1e8) ** (2 / 3)  # two corners share the weight
    assert r["block.y"][-1] == pytest.approx(-2e-4 - sunk, rel=1e-4)
    assert r["guide.normal"][-1] == pytest.approx(2 * 9.81, rel=1e-4)
    assert r["block.vx"][-1] == pytest.approx(0.0, abs=1e-4)  # friction has stopped it: 0.1 m/s over 0.2 g takes 51 ms


def test_bristles_hold_the_hatch_at_rest():
    r = rt.example("door_hinge").simulate(6.0)
    assert r.success
    late = r["hatch.angle"][r.t > 4.0]
    assert float(np.ptp(late)) < 2e-6
    # contact below the mass centre: T/N = tan(psi), sin(psi) = off/R
    assert r["O.tangential"][-1] / r["O.normal"][-1] == pytest.approx(math.tan(math.asin(2 / 9.05)), rel=2e-3)
    assert np.hypot(r["O.tangential"][-1], r["O.normal"][-1]) == pytest.approx(20 * 9.81, rel=1e-3)


def test_smooth_friction_creeps_as_its_docstring_says():
    r = rt.example("door_hinge").set({"joints.O.contact.friction": 0.3}).simulate(5.0)
    slip = 9.05e-3 * abs(r["hatch.omega"][-1])
    share = r["O.tangential"][-1] / (0.3 * r["O.normal"][-1])
    assert slip == pytest.approx(1e-3 * math.atanh(share), rel=0.02)  # v1 artanh(F/(mu N))
    assert slip > 1e-4


def test_a_hatch_outside_its_friction_circle_falls():
    r = rt.example("door_hinge").set(mu=0.1).simulate(5.0)
    assert r["hatch.angle"][-1] < -0.1


# ---------------------------------------------------------------- what the run says
def test_a_run_says_how_well_its_contacts_are_resolved():
    r = rt.example(SLIDER_CRANK).simulate(2e-3)
    _, second = str(r.trust).splitlines()
    assert second.startswith(f"{r.trust.contacts} contacts, the shortest contact took")
    assert r.trust.fewest_steps >= 6
    assert r.stats["contacts"] == r.trust.contacts


def test_a_law_outside_its_range_is_noted():
    r = rt.example(SLIDER_CRANK).set({"joints.B.contact.restitution": 0.3}).simulate(1e-3)
    assert any("0.684" in note for note in r.trust.notes)


def test_orbit_shows_impacts():
    r = rt.example(SLIDER_CRANK).simulate(2e-3)
    ax = r.plot_orbit("B").axes[0]
    hits = len(contacts_of(r, "B"))
    (dots,) = (one for one in ax.collections if one.get_offsets().shape == (hits, 2))
    assert np.hypot(*np.asarray(dots.get_offsets()).T) == pytest.approx(
        np.full(hits, 0.5), rel=1e-9
    )  # on the circle [mm]
    assert f"{hits} contacts" in dots.get_label()


# ---------------------------------------------------------------- bad input
BASE = 'model = "exact", restitution = 0.5, stiffness = 1e9'


@pytest.mark.nojit
@pytest.mark.parametrize(
    ("contact", "said"),
    [
        ('{ model = "exact", restitution = 1.2, stiffness = 1e9 }', r"restitution: 1.2 is outside \[0, 1\]"),
        ('{ model = "exact", restitution = -0.1, stiffness = 1e9 }', "restitution: .* must not be negative"),
        ('{ model = "impact", restitution = 1.5 }', r"restitution: 1.5 is outside \[0, 1\]"),
        (f"{{ {BASE}, friction = -0.1 }}", "friction: .* must not be negative"),
        (f'{{ {BASE}, bush_radius = 0.01, friction = {{ model = "lugre", mu = -1 }} }}', "mu: .* must not be negative"),
        (f"{{ {BASE}, friction = 0.1 }}", "needs bush_radius in m: friction depends on it"),
        ('{ model = "impact", friction = 0.1 }', "needs bush_radius in m: friction depends on it"),
        ('{ model = "exact", restitution = 0.5, geometry = "sphere", bush_material = "steel", pin_material = "steel" }',
         "needs bush_radius in m: the stiffness depends on it"),
        (f"{{ {BASE}, bush_radius = 0.0005 }}", "must be larger than the clearance of 0.001 m"),
        (f'{{ {BASE}, bush_material = "steel" }}', "either a stiffness or materials and geometry, not both"),
        ('{ model = "exact", restitution = 0.5, bush_radius = 0.01, bush_material = "stel", pin_material = "steel" }',
         "unknown material 'stel'; did you mean 'steel'"),
        ('{ model = "exact", restitution = 0.5 }', "needs a stiffness"),
        ('{ model = "exakt", restitution = 0.5, stiffness = 1e9 }', "unknown contact 'exakt'; did you mean 'exact'"),
        (f'{{ {BASE}, friction = {{ model = "lugree", mu = 0.1 }} }}', "unknown friction 'lugree'; did you mean"),
        ('{ model = "exact", stiffness = 1e9 }', "needs restitution"),
        ('{ model = "exact", restitution = 0.5, stiffness = -1 }', "stiffness: .*must be positive"),
        ('{ model = "exact", restitution = 0.5, stiffness = 1e9, exponent = 0 }', "exponent: .*must be positive"),
    ],
)  # fmt: skip
def test_a_contact_that_cannot_be_is_refused_with_a_reason(contact, said):
    with pytest.raises(rt.ModelError, match=said):
        pin_in_bush(contact)


@pytest.mark.nojit
def test_a_pin_that_is_given_outside_its_bush_starts_inside_and_check_says_so():
    m = pin_in_bush(f"{{ {BASE} }}", x=2e-3)
    r = m.simulate(1e-6)
    assert np.hypot(r["O.ex"][0], r["O.ey"][0]) <= m.model.joints["O"].clearance
    assert ".x" in str(m.check())


@pytest.mark.parametrize("kind", ["fixed", "rod"])
@pytest.mark.nojit
def test_compliance_is_refused_where_there_is_no_contact(kind):
    more = "length = 0.1" if kind == "rod" else ""
    text = f"""
format = 1
[ground.points]
O = [0, 0]
[bodies.b]
points = {{ P = [0, 0] }}
mass = 1
inertia = 1
[joints.J]
type = "{kind}"
connect = ["ground.O", "b.P"]
clearance = 0.001
contact = {{ {BASE} }}
{more}
"""
    with pytest.raises(rt.ModelError, match=f"a {kind} joint cannot have clearance; leave it out"):
        rt.loads(text)


def test_a_stiffness_that_no_step_can_resolve_is_refused_by_name():
    m = pin_in_bush('{ model = "exact", restitution = 0.5, stiffness = 1e30 }')
    with pytest.raises(rt.ModelError, match=r"joints.O.contact: so stiff that a contact at 1 m/s would last .* s"):
        m.simulate(0.01)
    assert pin_in_bush('{ model = "exact", restitution = 0.5, stiffness = 1e18 }').simulate(0.01).success


# ---------------------------------------------------------------- starts near a wall, and peaks
def flight_to_wall(e, v, c):
    """Time [s] at which a pin that flies freely from the offset e [m] at v [m/s] is at the wall of its clearance c."""
    a, b = v @ v, e @ v
    gap = c - math.hypot(*e)
    d = gap * (c + math.hypot(*e))
    return d / (b + math.sqrt(b * b + a * d))  # without cancellation, however small the gap


def hertz_peak_of_flight(e, v, c, stiffness):
    """Largest force [N] on a pin of 1 kg: its angular momentum about the bush and its energy do not change."""
    turn = e[0] * v[1] - e[1] * v[0]
    start = 0.5 * v @ v
    most = lambda d: 0.5 * (turn / (c + d)) ** 2 + 0.4 * stiffness * d**2.5 - start  # noqa: E731
    deepest = brentq(most, 0.0, (2.5 * start / stiffness) ** 0.4 * 1.001, xtol=1e-300, rtol=1e-14)
    return stiffness * deepest**1.5


def test_pins_that_start_near_their_walls_have_the_first_contact_of_closed_form():
    rng = np.random.default_rng(7)
    for case in range(150):
        c, speed = 10.0 ** rng.uniform(-5, -3), 10.0 ** rng.uniform(-3, 2.5)
        gap = c * 10.0 ** rng.uniform(-12, -2)
        around, aside = rng.uniform(-math.pi, math.pi), math.pi / 2 * rng.uniform(-1, 1)
        e = (c - gap) * np.array([math.cos(around), math.sin(around)])
        v = speed * np.array([math.cos(around + aside), math.sin(around + aside)])
        law = ("hertz", "exact", "kelvin-voigt")[case % 3]
        e_n = 1.0 if law == "hertz" else 0.7
        contact = f'{{ model = "{law}", restitution = {e_n}, stiffness = 1e9, bush_radius = 0.01 }}'
        m = pin_in_bush(contact, x=float(e[0]), y=float(e[1]), vx=float(v[0]), vy=float(v[1]), c=c)
        wall = flight_to_wall(e, v, c)
        end = wall + 2e-3 * speed**-0.2
        r = m.simulate(end, rtol=1e-9)
        assert r.success, (case, r.message)
        hit = contacts_of(r, "O")[0]
        # coordinates are rounded, times to 1e-15 of a step
        approach = math.sqrt(max(speed**2 - ((e[0] * v[1] - e[1] * v[0]) / c) ** 2, 0.0))
        rounding = 1e-15 * end + 1e-14 * c * (1.0 + speed / approach) / approach
        assert hit.t == pytest.approx(wall, rel=1e-9, abs=rounding), case
        if law == "hertz":
            assert hit.peak_force == pytest.approx(hertz_peak_of_flight(e, v, c, 1e9), rel=1e-6), case


@pytest.mark.parametrize("law", ["hertz", "exact", "kelvin-voigt"])
def test_largest_force_of_a_contact_converges_with_the_tolerance(law):
    # it lies anywhere in a step, beside its ends as well
    rng = np.random.default_rng(1)
    for _ in range(12):
        v, phi = 10.0 ** rng.uniform(-2, 1.5), rng.uniform(-1.2, 1.2)
        e = 1.0 if law == "hertz" else 0.6
        contact = f'{{ model = "{law}", restitution = {e}, stiffness = 1e9, bush_radius = 0.01 }}'
        m = pin_in_bush(contact, vx=v * math.cos(phi), vy=v * math.sin(phi), c=1e-4)
        peaks = []
        for rtol in (1e-8, 1e-10, 1e-12, 1e-13):
            r = m.simulate(2e-4 / (v * math.cos(phi)) + 1e-3 * v**-0.2, rtol=rtol, atol=1e-3 * rtol)
            peaks.append(contacts_of(r, "O")[0].peak_force)
        assert peaks[:3] == [pytest.approx(peaks[3], rel=100.0 * rtol) for rtol in (1e-8, 1e-10, 1e-12)]


# ---------------------------------------------------------------- friction where damping brings the force to zero
@pytest.mark.parametrize("law", ["viscous", "stribeck", "dahl", "lugre"])
def test_clipped_forces_and_their_friction_do_not_stall_a_run(law):
    # strong damping: as pins part their normal force is zero while they still touch
    rng = np.random.default_rng(3)
    extra = {
        "viscous": "viscosity = 30",
        "stribeck": "mu = 0.1, v1 = 0.02, viscosity = 30",
        "dahl": "mu = 0.2",
        "lugre": "mu = 0.2",
    }
    friction = f'{{ model = "{law}", {extra[law]} }}'
    for normal in ("kelvin-voigt", "hunt-crossley"):
        for _ in range(4):
            turn, vx, vy = rng.uniform(-300, 300), rng.uniform(-1, 1), rng.uniform(0.2, 1)
            m = isolated_pair(friction, normal).set({"joints.P.contact.restitution": 0.05})
            m = m.set({"initial.arm.omega": turn, "initial.arm.vx": vx, "initial.bush.vy": vy})
            r = m.simulate(0.02, rtol=1e-8, most_steps=20000)
            assert r.success, r.message
            contacts = len(contacts_of(r, "P"))
            assert r.stats["steps"] < 1000 + 500 * contacts
            assert r.trust.energy_share < 1e-5


@pytest.mark.parametrize("restitution", [0.05, 0.3, 0.7])
def test_a_clipped_force_converges_with_the_tolerance_and_the_order_is_kept(restitution):
    """The force of a damped spring meets zero before the pin leaves: closed form of its peak and of the rebound."""
    mass, stiffness, speed = 1.0, 1e7, 0.2
    zeta = -math.log(restitution) / math.hypot(math.pi, math.log(restitution))
    omega = math.sqrt(stiffness / mass)
    damped = math.sqrt(1.0 - zeta**2)
    t = np.linspace(0.0, 2.0 * math.acos(zeta) / damped, 1_000_001)  # times omega
    wave = np.exp(-zeta * t) * ((1.0 - 2.0 * zeta**2) * np.sin(damped * t) / damped + 2.0 * zeta * np.cos(damped * t))
    peak, rebound = mass * omega * speed * wave.max(), speed * math.exp(-2.0 * zeta * math.acos(zeta) / damped)
    assert abs(wave[-1]) < 1e-12
    m = rt.Mechanism("pin", gravity=[0, 0]).ground(O=[0, 0]).body("b", mass=mass, inertia=1e-3, points={"O": [0, 0]})
    contact = {"model": "kelvin-voigt", "stiffness": stiffness, "exponent": 1, "restitution": restitution}
    m.revolute("O", "ground.O", "b.O", clearance=1e-3, contact=contact).initial("b", x=0.9e-3, vx=speed)
    steps = []
    for rtol in (1e-5, 1e-7, 1e-9, 1e-11):
        run = m.simulate(3e-3, rtol=rtol, t_eval=[0.0, 3e-3])
        assert run["b.vx"][-1] == pytest.approx(-rebound, rel=200 * rtol)
        assert contacts_of(run, "O")[0].peak_force == pytest.approx(peak, rel=max(100 * rtol, 1e-11))
        steps.append(run.stats["steps"])
    assert steps[-1] < 1.5 * 10.0 ** (6 / 8) * steps[0] + 10  # errors as h^8


@pytest.mark.parametrize("rtol", [1e-6, 1e-8, 1e-10])
def test_a_damped_pin_with_viscous_friction_beside_rigid_ones_takes_steps_like_other_pins(rtol):
    m = rt.load(DATA / "rigid_and_damped_pins.toml")
    steps = {}
    for viscosity in (0.0, 1.0, 3.0):
        r = m.set({"joints.p3.contact.friction.viscosity": viscosity}).simulate(0.03, rtol=rtol, most_steps=5000)
        assert r.success, r.message
        steps[viscosity] = r.stats["steps"]
    assert max(steps[1.0], steps[3.0]) < 3 * steps[0.0]
