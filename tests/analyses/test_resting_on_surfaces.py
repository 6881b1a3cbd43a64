"""Bodies at rest on surfaces: equilibria, what pushes them away and how, small motions, corners past an end."""

import math

import numpy as np
import pytest

import rattle as rt
from rattle.errors import InputError
from rattle.language.materials import contact_modulus
from surfaces import G, block, body, impact, surface, world

SMOOTH, ROUGH = impact(), impact(mu=0.5)
ELASTIC = '{ model = "hertz", stiffness = 1e6, exponent = 1 }'
PUSH = 'loads.push = { type = "force", at = "%s", force = ["p", 0] }\nparameters.p = "1 N"\n'


def pushed_block(mu, half=0.1, high=0.2):
    """A block of 3 kg that is pushed at its upper left corner."""
    return block(half, high, impact(0, mu), more=PUSH % "block.T")


def test_a_block_slips_or_tips_whichever_needs_the_smaller_push():
    """mu m g against m g b/h, b half its width, h its height: at its top it tips from mu = b/h on."""
    weight = 3.0 * G
    slips, tips = pushed_block(0.2).holds("push"), pushed_block(0.3).holds("push")
    assert (slips.low, slips.high) == pytest.approx((-0.2 * weight, 0.2 * weight), rel=1e-8)
    assert (tips.low, tips.high) == pytest.approx((-0.25 * weight, 0.25 * weight), rel=1e-8)
    assert any("above that it slips" in note for note in slips.notes)
    assert any("above that it tips: floor at P lifts off" in note for note in tips.notes)
    assert any("below that it tips: floor at Q lifts off" in note for note in tips.notes)


@pytest.mark.parametrize("mu", [0.2, 0.3])
def test_a_block_moves_just_beyond_the_push_that_it_holds(mu):
    held = pushed_block(mu).holds("push").high
    for share, moves in ((0.999, False), (1.001, True)):
        r = pushed_block(mu).set(p=share * held).simulate(0.5, t_eval=[0.0, 0.5])
        assert (abs(r["block.x"][1]) + abs(r["block.angle"][1]) > 1e-5) == moves


def test_a_ladder_at_a_smooth_wall_needs_friction_or_a_push_at_its_foot():
    """N at the wall is m g/(2 tan a), and friction at the foot takes mu m g of it."""
    steep, mu, m = math.radians(55.0), 0.2, 5.0
    start = (math.cos(steep), math.sin(steep), -steep, 0.0, 0.0, 0.0)
    wall = surface("wall", "ground.O", "ladder.B", impact(), "-90 deg")
    floor = surface("floor", "ground.O", "ladder.A", impact(0, mu))
    ladder = world(body("ladder", {"A": (1, 0), "B": (-1, 0)}, m, 5 / 3, start), floor, wall, PUSH % "ladder.A")
    held = ladder.holds("push")
    pressed, rubbed = m * G / (2 * math.tan(steep)), mu * m * G
    assert (-held.high, -held.low) == pytest.approx((pressed - rubbed, pressed + rubbed), rel=1e-8)
    assert held.free == pytest.approx(-pressed, rel=1e-8)
    assert not held.rests


def test_a_disc_rolls_away_from_the_push_of_its_arm_over_its_radius():
    floor = surface("floor", "ground.O", "disc.C", impact(0, 0.5, ", rolling = 2e-3"), more=", roller = 0.1")
    rolls = world(body("disc", {"C": (0, 0)}, 2.0, 0.01, (0, 0.1, 0, 0, 0, 0)), floor, PUSH % "disc.C")
    held = rolls.holds("push")
    assert (held.low, held.high) == pytest.approx((-2 * G * 0.02, 2 * G * 0.02), rel=1e-8)


def test_a_body_that_one_point_cannot_hold_has_no_such_push():
    leaning = block(0.1, 0.2, impact(0, 0.5), start=(0.0, 0.0, 0.0, 0, 0, 0), more=PUSH % "block.T")
    lifted = leaning.set({"initial.block.y": math.hypot(0.1, 0.2) + 0.1})
    with pytest.raises(InputError, match="at rest"):
        lifted.holds("push")


def test_an_elastic_cup_holds_a_disc_at_its_bottom_as_deep_as_its_weight_says():
    k = 1e6
    start = (0.4 * math.sin(0.3), -0.4 * math.cos(0.3), 0.0, 0.0, 0.0, 0.0)
    elastic = f'{{ model = "hertz", stiffness = {k}, exponent = 1 }}'
    hollow = surface("cup", "ground.O", "disc.C", elastic, None, ", radius = 0.5, hollow = true, roller = 0.1")
    rest = world(body("disc", {"C": (0, 0)}, 2.0, 0.01, start), hollow).equilibrium()[0]
    assert [rest["disc.x"], rest["disc.y"]] == pytest.approx([0.0, -0.4 - 2 * G / k], abs=1e-9)
    assert rest["cup.normal"] == pytest.approx(2 * G, rel=1e-6)


def test_a_block_with_a_weight_beside_its_middle_presses_its_corners_by_the_lever():
    """20 N over its left corner: that one bears them all, beside half of the weight."""
    load = 'loads.weight = { type = "force", at = "block.T", force = [0, -20] }\n'
    rest = block(0.1, 0.2, impact(0, 0.5), more=load).equilibrium()[0]
    assert rest.admissible
    assert [rest["block.y"], rest["block.angle"]] == pytest.approx([0.2, 0.0], abs=1e-12)
    assert [rest["floor.P.normal"], rest["floor.Q.normal"]] == pytest.approx([1.5 * G + 20, 1.5 * G], rel=1e-9)


@pytest.mark.parametrize("contact", [impact(mu=0.2), ELASTIC])
def test_a_shelf_above_a_block_neither_holds_nor_lifts_it(contact):
    """A segment bears on one side: corners below it do not touch it, at rest either."""
    shelf = surface("shelf", "ground.S", "block.P", contact, more=', length = 1, corners = ["P", "Q", "T"]')
    both = "O = [0, 0], S = [0, 1]"
    free, under = (block(0.1, 0.2, contact, more=PUSH % "block.T" + more, points=both) for more in ("", shelf))
    (said,) = (line for line in str(under.check()).splitlines() if "shelf" in line)
    assert "touching" not in said
    rests = under.set(p=0).equilibrium()
    assert [rests[0]["block.x"], rests[0]["block.y"]] == pytest.approx([0.0, 0.2], abs=1e-4)
    assert all(rest["shelf.normal"] == 0.0 for rest in rests if rest["block.y"] < 0.7)
    if contact == ELASTIC:
        assert np.all(under.simulate(0.05)["shelf.normal"] == 0.0)
    else:
        assert (under.holds("push").low, under.holds("push").high) == (free.holds("push").low, free.holds("push").high)


def test_a_rigid_floor_bears_the_moment_that_its_corners_do():
    """About the point P of the block: N of Q, 0.2 m beside it, wherever it stands."""
    rests = block(0.1, 0.2, impact(0, 0.5)).equilibrium()
    assert [rests[0]["floor.P.normal"], rests[0]["floor.Q.normal"]] == pytest.approx([1.5 * G, 1.5 * G])
    assert rests[0]["floor.moment"] == pytest.approx(0.2 * 1.5 * G, rel=1e-9)
    for rest in rests[1:]:
        c, s = math.cos(rest["block.angle"]), math.sin(rest["block.angle"])
        on_q, on_t = (0.2 * c) * rest["floor.Q.normal"], (-0.4 * s) * rest["floor.T.normal"]
        assert rest["floor.moment"] == pytest.approx(on_q + on_t, abs=1e-9)


def test_gravity_that_grows_presses_with_what_it_is_then():
    """1000 kg on a line, at t = 0 without weight."""
    heavy = block(0.1, 0.2, impact(), mass=1000.0).to_toml()
    grows = heavy.replace("gravity = [0, -9.81]", 'gravity = [0, "-9.81*min(t/(1 s), 1)"]')
    assert grows != heavy
    then, always = (rt.loads(text).equilibrium(t=1.0) for text in (grows, heavy))
    assert [rest["floor.normal"] for rest in then] == pytest.approx([1000 * G] * len(always), rel=1e-9)


def test_the_cord_of_a_step_ladder_bears_what_two_bars_say():
    """S = (m g + W s/l)/2 l tan(q)/(l - r)."""
    rest = rt.example("step_ladder").equilibrium()[0]
    lean = math.asin(0.4 / 1.4)
    assert rest["cord.force"] == pytest.approx((6 * G + 700 * 0.6) * math.tan(lean) / 1.4, rel=1e-9)
    assert rest["floor_right.normal"] == pytest.approx(6 * G + 700 * 0.3, rel=1e-9)


def cup(contact):
    hollow = surface("cup", "ground.O", "disc.C", contact, None, ", radius = 0.5, hollow = true, roller = 0.1")
    return world(body("disc", {"C": (0, 0)}, 2.0, 0.01, (0.1, -0.38, 0, 0, 0, 0)), hollow)


def plank(contact):
    polygon = "polygon = [[-0.5, -0.05], [0.5, -0.05], [0.5, 0.05], [-0.5, 0.05]]"
    text = (
        f"bodies.plank = {{ {polygon}, mass = 2, points = {{ A = [0, 0] }} }}\ninitial.plank = {{ x = 0, y = 0.36 }}\n"
    )
    return world(text, surface("drum", "ground.O", "plank.A", contact, None, ", radius = 0.3, outline = true"))


def test_a_disc_in_a_smooth_cup_swings_as_a_pendulum_and_a_rough_one_rolls():
    smooth, rough = cup(SMOOTH).modes(), cup(ROUGH).modes()
    assert smooth.omega[-1] == pytest.approx(math.sqrt(G / 0.4), rel=1e-9)
    assert rough.omega == pytest.approx([math.sqrt(2 * G / (3 * 0.4))], rel=1e-9)


def test_a_plank_rocks_on_a_rough_drum_and_slides_off_a_smooth_one():
    """w^2 = m g (R - h)/(I + m h^2)."""
    rough, smooth = plank(ROUGH).modes(), plank(SMOOTH).equilibrium()[0]
    inertia = 2 * (1 + 4 * 0.05**2) / 12
    assert rough.omega == pytest.approx([math.sqrt(2 * G * 0.25 / (inertia + 2 * 0.05**2))], rel=1e-8)
    assert not smooth.stable
    assert smooth["drum.normal"] == pytest.approx(2 * G, rel=1e-9)


def test_a_disc_in_a_groove_presses_on_both_of_its_sides():
    left = surface("left", "ground.O", "disc.C", SMOOTH, "-40 deg", ", roller = 0.05")
    right = surface("right", "ground.O", "disc.C", SMOOTH, "25 deg", ", roller = 0.05")
    rest = world(body("disc", {"C": (0, 0)}, 1.0, 0.01, (0.02, 0.2, 0, 0, 0, 0)), left, right).equilibrium()[0]
    steep, gentle = math.radians(40), math.radians(25)
    normals = np.linalg.solve([[math.sin(steep), -math.sin(gentle)], [math.cos(steep), math.cos(gentle)]], [0, G])
    assert [rest["left.normal"], rest["right.normal"]] == pytest.approx(normals, rel=1e-9)


@pytest.mark.parametrize("seed", range(8))
def test_a_polygon_stands_on_those_of_its_edges_over_which_its_mass_centre_is(seed):
    rng = np.random.default_rng(seed)
    turns = np.sort(rng.uniform(0, 0.9, 5)) + 2 * math.pi / 5 * np.arange(5)
    corners = {f"C{k}": (0.1 * math.cos(turn), 0.1 * math.sin(turn)) for k, turn in enumerate(turns)}
    shift = rng.uniform(-0.03, 0.03, 2)
    corners = {key: (float(x - shift[0]), float(y - shift[1])) for key, (x, y) in corners.items()}
    places = np.array(list(corners.values()))
    stands = []
    for k in range(5):
        first, edge = places[k], places[(k + 1) % 5] - places[k]
        if 0 < -first @ edge < edge @ edge:
            stands.append(-math.atan2(edge[1], edge[0]) % (2 * math.pi))
    names = ", ".join(f'"{key}"' for key in corners)
    text = body("b", corners, 1.0, 0.005, (0, 0.2, float(rng.uniform(0, 6)), 0, 0, 0))
    m = world(text, surface("floor", "ground.O", "b.C0", SMOOTH, more=f", corners = [{names}]"))
    found = [rest["b.angle"] % (2 * math.pi) for rest in m.equilibrium(effort=4) if not rest.falling]
    assert all(min(abs(math.remainder(angle - one, 2 * math.pi)) for one in stands) < 1e-6 for angle in found)
    assert len({round(angle, 6) for angle in found}) == len(stands)


def test_a_disc_of_steel_is_as_stiff_as_two_spheres_of_its_radii():
    steel = '{ model = "hertz", bush_material = "steel", pin_material = "steel" }'
    disc = body("disc", {"C": (0, 0)}, 1.0, 0.01, (0, 0.2, 0, 0, 0, 0))
    for axis, more, curvature in (
        ("0 deg", "", 10.0),
        (None, ", radius = 0.4", 12.5),
        (None, ", radius = 0.4, hollow = true", 7.5),
    ):
        on = surface("on", "ground.O", "disc.C", steel, axis, f"{more}, roller = 0.1")
        joint = world(disc, on).model.joints["on"]
        stiffness = joint.contact.static.values["stiffness"]
        assert stiffness == pytest.approx(4 / 3 * contact_modulus("steel", "steel") / math.sqrt(curvature), rel=1e-12)
    with pytest.raises(rt.ModelError, match="touches in a point"):
        world(disc, surface("on", "ground.O", "disc.C", steel[:-1] + ', geometry = "johnson" }', more=", roller = 0.1"))


def test_a_run_says_where_a_corner_has_left_the_end_of_its_segment():
    slab = body("block", {"P": (-0.1, -0.05), "Q": (0.1, -0.05)}, 1.0, 0.01, (0.1, 0.06, 0, 0, 0, 0))
    table = surface("table", "ground.O", "block.P", SMOOTH, more=', length = "0.25 m", corners = ["P", "Q"]')
    said = str(world(slab, table).simulate(0.2, method="event").trust)
    assert "table: a corner has left the end of its segment" in said
