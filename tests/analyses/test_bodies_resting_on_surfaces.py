"""Bodies at rest on surfaces: what presses where, what pushes them away, and how: numbers of textbooks of statics."""

import math

import pytest

import rattle as rt
from rattle.errors import InputError
from surfaces import G, block, body, impact, surface, world

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


def test_the_cord_of_a_step_ladder_bears_what_two_bars_say():
    """S = (m g + W s/l)/2 l tan(q)/(l - r)."""
    rest = rt.example("step_ladder").equilibrium()[0]
    lean = math.asin(0.4 / 1.4)
    assert rest["cord.force"] == pytest.approx((6 * G + 700 * 0.6) * math.tan(lean) / 1.4, rel=1e-9)
    assert rest["floor_right.normal"] == pytest.approx(6 * G + 700 * 0.3, rel=1e-9)
