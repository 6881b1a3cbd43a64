"""Set-valued contacts, event by event: impacts, friction, lasting contact, release; closed forms and references."""

import csv
import math
from pathlib import Path

import numpy as np
import pytest

import rattle as rt
from linkages import block_in_guide

DATA = Path(__file__).parents[1] / "data"
PIN_TIMES = [1.553954329, 3.054303658, 4.437756907]  # c/v0 after the first; independent, 9 decimals


def of_kind(r, kind, joint=None):
    return [one for one in r.events if one.kind == kind and joint in (None, one.joint)]


def by_instant(events):
    """Events that happen together: {time: [events]}."""
    found = {}
    for one in events:
        found.setdefault(round(one.t, 13), []).append(one)
    return found


def ball(e=0.5, mu=0.0, vx=0.0, omega=0.0, height=0.1, **more) -> rt.Mechanism:
    """A small block in a wide level guide falls onto the lower wall under g = 10 m/s^2."""
    options = "".join(f", {key} = {value}" for key, value in more.items())
    contact = f'{{ model = "impact", restitution = {e}, friction = {mu}{options} }}'
    return rt.loads(block_in_guide(contact, height, 0.2, 0.02, 10.0, vx=vx, omega=omega))


# ---------------------------------------------------------------- closed forms
def test_pin_bouncing_in_its_bush_follows_its_chords_and_ends_sliding():
    r = rt.example("bouncing_pin").simulate(0.02, rtol=1e-11, atol=1e-13)
    times = np.array([one.t for one in of_kind(r, "impact")]) / 1e-3
    assert times[0] == pytest.approx(0.5, abs=1e-9)
    assert times[1:4] - 0.5 == pytest.approx(PIN_TIMES, abs=1e-8)
    speeds = [one.normal_speed for one in of_kind(r, "impact")][:20]
    assert np.divide(speeds[1:], speeds[:-1]) == pytest.approx(0.8, rel=1e-9)
    (lasting,) = of_kind(r, "contact")
    assert lasting.t / 1e-3 - 0.5 == pytest.approx(11.397165651, abs=1e-6)  # end of the infinite sequence
    u = math.sin(math.radians(40))
    assert math.hypot(r["pin.vx"][-1], r["pin.vy"][-1]) == pytest.approx(u, abs=1e-9)
    assert r["O.normal"][-1] == pytest.approx(u * u / 1e-3, rel=1e-8)
    assert r["O.penetration"].max() < 1e-15
    lost = sum(one.energy_lost for one in of_kind(r, "impact"))
    assert lost == pytest.approx(0.5 * math.cos(math.radians(40)) ** 2, rel=1e-9)
    assert r.trust.energy_balance < 1e-9


def test_block_bounces_with_the_times_and_heights_of_a_falling_ball():
    e, g, height = 0.5, 10.0, 0.1
    r = ball(e, height=height).simulate(1.0)
    first = math.sqrt(2 * height / g)
    hits = sorted(by_instant(of_kind(r, "impact")))
    flights = np.diff(hits)[:8]
    assert hits[0] == pytest.approx(first, rel=1e-12)
    assert flights == pytest.approx([2 * first * e ** (n + 1) for n in range(8)], rel=1e-9)
    assert of_kind(r, "contact")[0].t == pytest.approx(first * (1 + e) / (1 - e), rel=1e-8)
    assert r["guide.normal"][-1] == pytest.approx(20.0, rel=1e-12)
    assert r["energy.dissipated"][-1] == pytest.approx(2 * g * height, rel=1e-10)


def test_sliding_block_stops_after_its_closed_form_time_and_then_sticks():
    mu, g, vx, height = 0.2, 10.0, 1.0, 1e-3
    r = ball(0.0, mu, vx, height=height).simulate(1.0)
    hit = math.sqrt(2 * height / g)
    speed = vx - mu * g * hit  # the impulse m g t of the fall slows it by mu times its own
    assert of_kind(r, "stick")[0].t == pytest.approx(hit + speed / (mu * g), rel=1e-9)
    assert abs(r["block.vx"][-1]) < 1e-15
    assert abs(r["guide.tangential"][-1]) < 1e-12
    lost = of_kind(r, "impact")
    assert r["energy.balance"] == pytest.approx(0.0, abs=1e-10)
    assert sum(one.energy_lost for one in lost) == pytest.approx(2 * g * height + (vx**2 - speed**2), rel=1e-9)


def test_block_starts_to_slip_when_its_push_exceeds_friction():
    text = (
        ball(0.0, 0.3, height=1e-4).to_toml() + '\n[loads.push]\ntype = "force"\nat = "block.P"\nforce = ["10*t", 0]\n'
    )
    r = rt.loads(text).simulate(1.0)
    # mu m g = 10 t; before, one corner may pass its share on to the other: rigid bodies do not say who holds
    assert of_kind(r, "slip")[-1].t == pytest.approx(0.3 * 20 / 10, rel=1e-6)
    assert np.abs(r["block.vx"][(r.t > 0.01) & (r.t < 0.6)]).max() < 1e-12
    # from there on m a = 10 t - mu m g
    t = 1.0 - 0.6
    assert r["block.vx"][-1] == pytest.approx(5 * t * t / 2, rel=1e-6)


def test_tangential_restitution_turns_the_spin_of_a_rough_block_around():
    r = ball(1.0, 100.0, vx=0.5, height=0.05, tangential_restitution=1.0).simulate(0.12, rtol=1e-10)
    hits = by_instant(of_kind(r, "impact"))
    assert len(hits) == 1
    assert sum(one.energy_lost for one in next(iter(hits.values()))) == pytest.approx(0.0, abs=1e-12)


# ---------------------------------------------------------------- balances and limits
def test_impact_keeps_the_momentum_of_an_isolated_pair():
    text = """
format = 1
[bodies.ring]
points = { O = [0, 0] }
mass = 3
inertia = 0.02
[bodies.pin]
points = { P = [0, 0] }
mass = 1
inertia = 1e-3
[joints.O]
type = "revolute"
connect = ["ring.O", "pin.P"]
clearance = 0.01
contact = { model = "impact", restitution = 0.7, friction = 0.3, bush_radius = 0.05 }
[initial]
ring = { x = 0, y = 0, angle = 0, vx = 0.1, vy = 0, omega = 1 }
pin = { x = 0.002, y = 0.001, angle = 0, vx = 1, vy = 0.6, omega = -20 }
"""
    r = rt.loads(text).simulate(0.5, rtol=1e-11, atol=1e-13)
    assert len(of_kind(r, "impact")) > 5
    px = 3 * r["ring.vx"] + r["pin.vx"]
    py = 3 * r["ring.vy"] + r["pin.vy"]
    spin = (
        0.02 * r["ring.omega"] + 1e-3 * r["pin.omega"]
        + 3 * (r["ring.x"] * r["ring.vy"] - r["ring.y"] * r["ring.vx"])
        + r["pin.x"] * r["pin.vy"] - r["pin.y"] * r["pin.vx"]
    )  # fmt: skip
    for one in (px, py, spin):
        assert np.ptp(one) < 1e-10
    assert r.trust.energy_balance < 1e-8
    assert (np.diff(r["energy.dissipated"]) > -1e-12).all()


def test_elastic_impacts_run_back_in_time():
    forth = rt.example("bouncing_pin").set(e=1.0).simulate(0.01, rtol=1e-11, atol=1e-13)
    end = {key: -float(forth[f"pin.{key}"][-1]) for key in ("vx", "vy", "omega")}
    back = rt.example("bouncing_pin").set(
        {
            "e": 1.0,
            "initial.pin.x": float(forth["pin.x"][-1]),
            "initial.pin.y": float(forth["pin.y"][-1]),
            **{f"initial.pin.{key}": value for key, value in end.items()},
        }
    )
    r = back.simulate(0.01, rtol=1e-11, atol=1e-13)
    assert r["pin.x"][-1] == pytest.approx(forth["pin.x"][0], abs=1e-10)
    assert r["pin.y"][-1] == pytest.approx(forth["pin.y"][0], abs=1e-10)
    assert r["energy.dissipated"][-1] == pytest.approx(0.0, abs=1e-12)


def test_small_play_moves_like_the_ideal_mechanism():
    apart = []
    for r in (5e-3, 5e-4):
        m = rt.example("fourbar_onesided").set({"r3": r, "r4": r, "ground.points.O4": [0.8, 0]})
        play, ideal = m.simulate(0.1), m.ideal().simulate(0.1)
        apart.append(np.abs(play["coupler.angle"] - ideal["coupler.angle"]).max())
    assert apart[1] < 0.2 * apart[0]  # first order in the clearance
    assert apart[1] < 2e-3


# ---------------------------------------------------------------- the paper's four-bar, one-sided
def test_one_sided_pin_follows_its_wall_while_the_link_would_press_and_lets_go_where_it_would_pull():
    one_sided = rt.example("fourbar_onesided")
    link = one_sided.set({"joints.O3.contact": "massless-link", "joints.O4.contact": "massless-link"})
    r, two_sided = one_sided.simulate(0.5), link.simulate(0.01, t_eval=[0.0])
    assert r["O3.normal"].min() >= 0.0
    assert r["O4.normal"].min() >= 0.0
    for joint in ("O3", "O4"):
        begins = two_sided[f"{joint}.normal"][0] > 0.0
        events = [one for one in r.events if one.joint == joint]
        assert (events[0].kind == "contact" and events[0].t == 0.0) == begins
    assert r.trust.energy_balance < 1e-7
    for joint in ("O3", "O4"):
        inside = np.hypot(r[f"{joint}.ex"], r[f"{joint}.ey"])
        assert inside.max() < 0.005 + 1e-12
        flying = inside < 0.005 - 1e-9
        assert np.abs(r[f"{joint}.normal"][flying]).max() == 0.0
        assert np.abs(r[f"{joint}.fx"][flying]).max() == 0.0
        assert len(of_kind(r, "release", joint)) > 3


def test_one_sided_and_massless_link_agree_until_the_first_pull():
    one_sided = rt.example("fourbar_onesided").set(M=-40.0, gravity=[0, -9.81])
    link = one_sided.set({"joints.O3.contact": "massless-link", "joints.O4.contact": "massless-link"})
    times = np.linspace(0.0, 0.02, 201)
    two = link.simulate(t_eval=times, rtol=1e-11)
    pulls = [one for one in two.trust.first_pull.values() if one is not None]
    one = one_sided.simulate(t_eval=times, rtol=1e-11)
    before = times < min([*pulls, times[-1]])
    assert before.sum() > 1  # both pins press at the start
    assert one["O3.normal"][0] > 0.0
    assert one["coupler.angle"][before] == pytest.approx(two["coupler.angle"][before], abs=1e-10)
    assert one["O3.normal"][before] == pytest.approx(two["O3.normal"][before], rel=1e-6)


# ---------------------------------------------------------------- guide with play
@pytest.fixture(scope="module")
def guide():
    return rt.example("guide_play").simulate(0.2, t_eval=[0.0, 0.01, 0.05, 0.1, 0.2], rtol=1e-10, atol=1e-12)


def test_guide_hits_when_and_as_hard_as_the_reference_says(guide):
    lines = [one for one in (DATA / "guide_play_events.csv").read_text().splitlines() if not one.startswith("#")]
    rows = list(csv.reader(lines))
    instants = by_instant(of_kind(guide, "impact"))
    times = np.array(sorted(instants))
    compared = 0
    for row in rows:
        if not row[0].isdigit() or abs(float(row[3])) < 1e-5:  # slower bounces are closed
            continue
        t = times[np.argmin(np.abs(times - float(row[1])))]
        hits = instants[t]
        assert len(hits) == 2  # two corners at once
        assert t == pytest.approx(float(row[1]), abs=1e-7)
        assert hits[0].normal_speed == pytest.approx(abs(float(row[3])), abs=1e-7)
        assert sum(one.impulse for one in hits) == pytest.approx(float(row[4]), abs=1e-8)
        compared += 1
    assert compared > 90
    for name, kind in (("release", "release"), ("xreverse", "slip"), ("stick", "contact")):
        wanted = [float(row[1]) for row in rows if row[0] == name]
        found = np.array([one.t for one in of_kind(guide, kind)])
        for t in wanted:
            assert np.abs(found - t).min() < 1e-7


def test_guide_turns_and_loses_energy_as_the_reference_says(guide):
    turns = guide["crank.angle"][1:] / (2 * math.pi)
    assert turns == pytest.approx([0.1508727302, 0.7629178618, 1.4324963219, 2.8781068468], abs=1e-8)
    lost = sum(one.energy_lost for one in of_kind(guide, "impact"))
    # what the bounces that are closed would rub away counts as friction here: some 1e-7 J
    assert lost == pytest.approx(0.4823502, abs=3e-7)
    assert guide["energy.dissipated"][-1] - lost == pytest.approx(0.0178153, abs=3e-7)
    assert guide["energy.dissipated"][-1] == pytest.approx(0.5001655, abs=1e-7)
    assert guide["energy.kinetic"][0] + guide["energy.potential"][0] == pytest.approx(7.49554875, abs=1e-8)
    assert guide.trust.energy_balance < 1e-7


def test_offsets_of_a_guide_are_play_not_travel_whatever_holds_it(guide):
    ideal = rt.example("guide_play").ideal().simulate(0.05, t_eval=[0.0, 0.01, 0.05])
    assert np.ptp(ideal["slider.x"]) > 0.01  # it travels
    for r, play in ((ideal, 0.0), (guide, 0.001)):
        assert np.abs(r["guide.ex"]).max() < 1e-12  # along the axis nothing is free to be offset
        assert np.abs(r["guide.ey"]).max() <= play + 1e-12
    assert np.abs(guide["guide.ey"]).max() > 1e-5


def test_impacts_of_one_mechanism_have_one_law():
    m = rt.example("fourbar_onesided").set({"joints.O3.contact.restitution_law": "poisson"})
    with pytest.raises(rt.ModelError, match=r"one law for all joints \(now O3: poisson, O4: newton\)"):
        m.simulate(0.01)


# ---------------------------------------------------------------- toys and limits of the model
def test_the_woodpecker_beats_as_published():
    m = rt.example("woodpecker")
    r = m.simulate(2.0)
    assert r.success, r.message
    knocks = np.array(sorted(by_instant(of_kind(r, "impact", "beak"))))
    assert len(knocks) >= 12
    assert np.diff(knocks)[2:] == pytest.approx(0.1460, abs=2e-4)  # what is left is the size of the angles, 1/k
    down = np.diff(np.interp(knocks, r.t, r["sleeve.y"]))[6:]  # once settled
    assert down == pytest.approx(-0.0194, abs=1e-4)
    assert r.trust.energy_balance < 1e-8
    # the published fixed point: the sleeve jammed and sliding, the bird on its way down
    swing = r["swing"]
    k = np.flatnonzero((swing[:-1] > -0.2788) & (swing[1:] <= -0.2788) & (r.t[:-1] > 1.0))
    assert len(k) >= 6
    share = (swing[k] + 0.2788) / (swing[k] - swing[k + 1])
    for name, value in (("tilt", -0.1036), ("sleeve.vy", -0.3411), ("bird.omega", -7.458 / m.parameters["k"])):
        passed = r[name][k] + share * (r[name][k + 1] - r[name][k])
        assert passed == pytest.approx(value, rel=1e-2)  # the published tilt is 1 um inside the pole, ours is not


def test_the_woodpecker_of_true_size_beats_faster():
    r = rt.example("woodpecker").set(k=1).simulate(1.0)
    assert r.success, r.message
    knocks = np.array(sorted(by_instant(of_kind(r, "impact", "beak"))))
    assert np.diff(knocks)[2:] == pytest.approx(0.1308, abs=5e-4)  # as its header says
    rests = np.abs(r["sleeve.vy"]) < 1e-6
    assert rests.mean() > 0.1  # it truly sticks between the slips


def test_smooth_woodpecker_just_falls():
    r = rt.example("woodpecker").set(mu=0.0).simulate(0.1)
    centre = (0.3 * r["sleeve.y"] + 4.5 * r["bird.y"]) / 4.8
    rate = (0.3 * r["sleeve.vy"] + 4.5 * r["bird.vy"]) / 4.8
    free = centre[0] + rate[0] * r.t - 0.5 * 9.81 * r.t**2
    assert centre == pytest.approx(free, abs=1e-9)  # smooth walls push sideways only


def test_rod_pushed_into_rough_ground_is_reported_as_painleve_with_joint_and_time():
    # a slender rod slides with its tip ahead: from some tilt on, friction turns it into the ground
    text = """
format = 1
gravity = [0, -10]
[ground.points]
O = [0, 0]
[bodies.rod]
points = { P = [0.6, -0.8] }
mass = 1
inertia = 0.01
[joints.tip]
type = "prismatic"
connect = ["ground.O", "rod.P"]
axis = 0
angle = 0
clearance = 1
block = { length = 1e-4, height = 1e-4 }
contact = { model = "impact", restitution = 0, friction = 3 }
[initial]
rod = { x = 0, y = -0.1999, angle = 0, vx = -3, vy = 0, omega = 0 }
"""
    r = rt.loads(text).simulate(0.5)
    assert not r.success
    assert "Painleve" in r.message
    assert "'tip'" in r.message
    assert "t = 0.474" in r.message
    moreau = rt.loads(text).simulate(0.5, method="moreau", step=1e-5)
    assert moreau.success  # an impact without collision: it sticks at that instant
    (stick,) = of_kind(moreau, "stick")
    assert stick.t == pytest.approx(0.4743, abs=1e-3)


def test_run_says_that_infinite_series_of_bounces_were_closed():
    notes = " ".join(rt.example("bouncing_pin").simulate().trust.notes)
    assert "an infinite series of bounces was closed" in notes
    elastic = rt.example("bouncing_pin").set(e=1.0).simulate()
    assert not elastic.trust.notes


@pytest.mark.parametrize(("method", "step"), [("event", None), ("moreau", 2e-5)])
def test_massless_link_beside_an_impact_pin_reports_when_it_would_pull(method, step):
    m = rt.example("fourbar").set({"joints.O3.contact": "impact"})
    run = m.simulate(0.1, t_eval=np.linspace(0, 0.1, 20001), method=method, step=step)
    pulls = run["O4.normal"] < 0.0
    assert 0.0 < pulls.mean() < 0.5
    assert run.trust.pulled["O4"] == pytest.approx(pulls.mean(), abs=1e-3)
    assert run.trust.first_pull["O4"] == pytest.approx(run.t[np.argmax(pulls)], abs=1e-4)


def test_impacts_that_give_energy_are_named():
    # Newton's restitution with friction may: two free bodies, the second impact
    pair = rt.loads("""
format = 1
gravity = [0, 0]
[bodies.a]
points = { P = ["30 mm", "10 mm"] }
mass = 2
inertia = 3e-3
[bodies.b]
points = { P = ["-20 mm", 0] }
mass = 0.5
inertia = 1e-4
[joints.J]
type = "revolute"
connect = ["a.P", "b.P"]
clearance = "1 mm"
contact = { model = "impact", restitution = 1, friction = 0.1, bush_radius = "10 mm" }
[initial]
a = { x = 0, y = 0, angle = 0, vx = 0.3, vy = 0.1, omega = 2 }
b = { x = "50.3 mm", y = "10.2 mm", angle = 0, vx = -0.4, vy = 0.2, omega = -15 }
""")
    run = pair.simulate(0.003, rtol=1e-9)
    assert min(event.energy_lost for event in run.events) < -0.01
    assert "1 impact created energy" in " ".join(run.trust.notes)
    smooth = pair.set({"joints.J.contact.friction": 0.0}).simulate(0.003, rtol=1e-9)
    assert "created energy" not in " ".join(smooth.trust.notes)


def test_step_that_tears_the_joints_open_is_said_to_be_too_long():
    run = rt.example("guide_play").simulate(0.05, method="moreau", step=1.0)
    assert not run.success
    assert "far too long" in run.message
    assert len(run.t) == 1  # what was good before it is kept: the start


@pytest.mark.parametrize("law", ["newton", "poisson", "energetic"])
def test_corners_of_a_block_that_nearly_coincide_share_impacts_without_a_false_loss(law):
    """Blocks of 1e-8 m to 1 mm in a wide guide: two contacts on almost one line, which hit almost together."""
    rng = np.random.default_rng(25)
    for length, friction in zip(10.0 ** rng.uniform(-8, -3, 12), [0.0, 0.1, 0.3] * 4, strict=True):
        rubs = {"friction": friction} if friction else {}
        contact = {"model": "impact", "restitution": 0.3, "restitution_law": law, **rubs}
        m = (
            rt.Mechanism("block", gravity=[0, -9.81])
            .ground(O=[0, 0])
            .body("b", mass=1, inertia=1e-3, points={"O": [0, 0]})
        )
        block = {"length": float(length), "height": 0.02}
        m.prismatic("g", "ground.O", "b.O", axis=0, clearance=3e-4, block=block, contact=contact)
        m.initial("b", vx=0.3, vy=-0.2, omega=float(rng.normal(0.0, 1.0)))
        run = m.simulate(0.03, t_eval=[0.0, 0.03], rtol=1e-8)
        assert run.success, run.message
        lost = sum(event.energy_lost for event in run.events if event.kind == "impact")
        assert 0.0 < lost < 0.5 * (0.3**2 + 0.2**2) + 1e-3 * 0.5 * 25 + 9.81 * 6e-4
        assert run.trust.energy_balance < 1e-7
