"""Necks of plates: forces in cuts through them against bars, against plates cut in two, and closed forms."""

import math

import numpy as np
import pytest
from click.testing import CliRunner

import rattle as rt
from bars import IRON
from rattle.cli.main import main
from rattle.description.cuts import Cut, CutFault
from rattle.description.polygon import figure_of
from rattle.errors import InputError, ModelError

HELD = 'joints.O = { type = "fixed", connect = ["ground.O", "plate.A"] }'
PULLED = 'loads.F = { type = "force", at = "plate.B", force = [100, -200], frame = "body" }'
TURNED = """joints.O = { type = "revolute", connect = ["ground.O", "plate.A"] }
drivers.motor = { joint = "O", angle = "0.3*sin(9*t) + 4*t" }"""
ROOT = "{ root = [[0.05, -0.02], [0.05, 0.02]] }"
WEIGHT = 'thickness = "10 mm"\nmaterial = "iron"'


def plate(necks=ROOT, held=HELD, more=PULLED, holes="[]", weight=WEIGHT, polygon=None, gravity="[0, -9.81]"):
    """A strip of iron along x, 200 mm long, 40 mm high, 10 mm thick."""
    corners = polygon or "[[0, -0.02], [0.2, -0.02], [0.2, 0.02], [0, 0.02]]"
    return f"""
format = 1
gravity = {gravity}
ground.points = {{ O = [0, 0], Q = [0.05, 0.3] }}
{held}
{more}
[bodies.plate]
polygon = {corners}
holes = {holes}
{weight}
points = {{ A = [0, 0], B = [0.2, 0] }}
necks = {necks}
{IRON}"""


def asked(text, name="plate", t=(0.0, 0.1)):
    return rt.loads(text).strength(name, t_eval=list(t), analysis="inverse-dynamics")


# ---------------------------------------------------------------- closed forms
def test_a_strip_that_is_held_bears_what_hangs_on_it():
    s = asked(plate())
    line = 7850 * 0.04 * 0.01 * 9.81  # [N/m]
    assert s.normal[0, 0] == pytest.approx(100.0)
    assert s.shear[0, 0] == pytest.approx(200.0 + 0.15 * line)
    assert s.moment[0, 0] == pytest.approx(-200.0 * 0.15 - line * 0.15**2 / 2)
    pull, bend = 100.0 / 4e-4, abs(s.moment[0, 0]) / (0.01 * 0.04**2 / 6)
    assert s.fibres[0][0, 0] == pytest.approx(pull + bend)  # at the upper edge, the second end
    assert s.fibres[1][0, 0] == pytest.approx(pull - bend)
    assert s.peak == pytest.approx(pull + bend)
    assert s.peak_at == pytest.approx((0.0, 0.04))
    assert s.safety == pytest.approx(300e6 / s.peak)
    assert np.isnan(s.buckling).all()
    assert np.isnan(s.deflection).all()


def test_the_other_way_round_x_turns_about():
    """Along the cut from its second end, what is before is after: V changes its sign, and the fibre that is pulled."""
    s, back = asked(plate()), asked(plate("{ root = [[0.05, 0.02], [0.05, -0.02]] }"))
    assert back.normal == pytest.approx(s.normal)
    assert back.shear == pytest.approx(s.shear)
    assert back.moment == pytest.approx(-s.moment)
    assert back.peak_at[1] == pytest.approx(0.0, abs=1e-12)
    assert back.peak == pytest.approx(s.peak)


def test_a_hole_in_the_cut_leaves_two_rectangles():
    hole = "[[[0.04, -0.01], [0.06, -0.01], [0.06, 0.005], [0.04, 0.005]]]"
    s = asked(plate(holes=hole))
    assert s.section.area == pytest.approx(0.01 * 0.025)
    centre = (0.01 * -0.015 + 0.015 * 0.0125) / 0.025
    second = 0.01 * (0.01**3 / 12 + 0.01 * (centre + 0.015) ** 2 + 0.015**3 / 12 + 0.015 * (0.0125 - centre) ** 2)
    assert s.section.inertia == pytest.approx(second)
    rho = 7850 * 0.01 * 9.81
    moment = -200 * 0.15 + 100 * centre - rho * (0.04 * 0.15**2 / 2 - 0.015 * 0.01**2 / 2)  # 100 N pulls beside P
    assert s.moment[0, 0] == pytest.approx(moment)
    assert s.fibres[0][0, 0] == pytest.approx(100 / 2.5e-4 - moment * (0.02 - centre) / second)
    assert s.fibres[1][0, 0] == pytest.approx(100 / 2.5e-4 + moment * (0.02 + centre) / second)


# ---------------------------------------------------------------- against bars, and plates in two
def test_a_strip_is_a_bar_in_the_same_motion():
    """But for the inertia of its sections against turning, which a slender bar does not have: m h^2/12."""
    bar = plate(held=TURNED)
    start, end = bar.index("[bodies.plate]"), bar.index("[materials")
    bar = f"""{bar[:start]}[bodies.plate]
bar = ["A", "B"]
length = 0.2
section = {{ shape = "rectangle", width = "10 mm", height = "40 mm" }}
material = "iron"
{bar[end:]}"""
    t = np.linspace(0, 0.9, 14)
    whole = asked(bar, t=t)
    turning = -0.3 * 81 * np.sin(9 * t)
    for x in (0.05, 0.15):
        s, k = asked(plate(f"{{ n = [[{x}, -0.03], [{x}, 0.02]] }}", TURNED), t=t), int(np.argmin(np.abs(whole.x - x)))
        assert whole.x[k] == pytest.approx(x)
        assert s.normal[:, 0] == pytest.approx(whole.normal[:, k])
        assert s.shear[:, 0] == pytest.approx(whole.shear[:, k])
        beyond = 7850 * 4e-4 * (0.2 - x) * 0.04**2 / 12
        assert s.moment[:, 0] == pytest.approx(whole.moment[:, k] - beyond * turning)


@pytest.mark.parametrize("seed", range(5))
def test_a_plate_cut_in_two_and_fixed_together_again_has_the_same_force(seed):
    """The reaction of the joint is the force in the neck, and its moment that about the middle of the cut."""
    rng = np.random.default_rng(seed)
    left = [[0.0, -0.05], [0.1 + 0.01 * rng.random(), -0.04], [0.11, 0.03], [0.02, 0.06 + 0.02 * rng.random()]]
    right = [left[1], [0.2, -0.09 + 0.1 * rng.random()], [0.22, 0.05], left[2]]
    (ax, ay), (bx, by) = left[1], left[2]
    whole = [left[0], left[1], *right[1:3], left[2], left[3]]
    driven = "0.3*sin(9*t) + 4*t"
    force = f"[{rng.normal():.3f}, {rng.normal():.3f}]"

    def text(bodies, end):
        return f"""
format = 1
gravity = [0.3, -9.81]
ground.points.O = [0, 0]
drivers.motor = {{ joint = "O", angle = "{driven}" }}
loads.F = {{ type = "force", at = "{end}.B", force = {force} }}
{bodies}
"""

    one = text(
        f"""joints.O = {{ type = "revolute", connect = ["ground.O", "p.A"] }}
[bodies.p]
polygon = {whole}
thickness = 0.01
density = 7000
points = {{ A = [0.01, 0.0], B = [0.2, 0.01] }}
necks.n = [[{ax}, {ay}], [{bx}, {by}]]""",
        "p",
    )
    middle = [0.5 * (ax + bx), 0.5 * (ay + by)]
    two = text(
        f"""joints.O = {{ type = "revolute", connect = ["ground.O", "l.A"] }}
joints.W = {{ type = "fixed", connect = ["l.P", "r.P"] }}
[bodies.l]
polygon = {left}
thickness = 0.01
density = 7000
points = {{ A = [0.01, 0.0], P = {middle} }}
[bodies.r]
polygon = {right}
thickness = 0.01
density = 7000
points = {{ B = [0.2, 0.01], P = {middle} }}""",
        "r",
    )
    t = [0.0, 0.1, 0.4, 0.7]
    s = rt.loads(one).strength("p", t, analysis="inverse-dynamics")
    r = rt.loads(two).inverse_dynamics(t)
    phi = r["l.angle"]
    fx, fy = np.cos(phi) * r["W.fx"] + np.sin(phi) * r["W.fy"], np.cos(phi) * r["W.fy"] - np.sin(phi) * r["W.fx"]
    along = np.array([bx - ax, by - ay]) / math.hypot(bx - ax, by - ay)
    # on r, the right part; tension pulls it to the left
    assert s.normal[:, 0] == pytest.approx(-(fx * along[1] - fy * along[0]), abs=1e-9)
    assert s.shear[:, 0] == pytest.approx(fx * along[0] + fy * along[1], abs=1e-9)
    assert s.moment[:, 0] == pytest.approx(-r["W.moment"], abs=1e-9)
    assert np.abs(s.moment).max() > 0.01


def test_a_load_that_moves_over_the_cut_acts_on_the_other_part_then():
    more = """joints.rail = { type = "prismatic", connect = ["plate.A", "block.P"], axis = 0 }
drivers.feed = { joint = "rail", position = "0.02 + 0.1*t" }
bodies.block = { points = { P = [0, 0] }, mass = 2, inertia = 0 }"""
    s = asked(plate(more=more), t=(0.0, 0.2, 0.5, 1.0))
    line, x = 7850 * 0.04 * 0.01 * 9.81, 0.02 + 0.1 * s.t
    beyond = x > 0.05
    assert s.shear[:, 0] == pytest.approx(line * 0.15 + beyond * 2 * 9.81)
    assert s.moment[:, 0] == pytest.approx(-line * 0.15**2 / 2 - beyond * 2 * 9.81 * (x - 0.05))


def test_a_pin_in_a_hole_that_is_cut_presses_on_the_part_before_it():
    """An eye: its hole is cut, and the pin pulls at the far half."""
    eye = "[[[0.19, -0.01], [0.21, -0.01], [0.21, 0.01], [0.19, 0.01]]]"
    strip = "[[0, -0.02], [0.23, -0.02], [0.23, 0.02], [0, 0.02]]"
    cut = "{ eye = [[0.2, -0.02], [0.2, 0.02]] }"

    def pulled(force):
        load = f'loads.F = {{ type = "force", at = "plate.B", force = [{force}, 0] }}'
        return asked(plate(cut, holes=eye, polygon=strip, more=load, gravity="[0, 0]")).normal[0, 0]

    assert pulled(100) == pytest.approx(100.0)
    assert pulled(-100) == pytest.approx(0.0, abs=1e-12)


# ---------------------------------------------------------------- what is said
def test_where_the_mass_lies_is_not_known_is_said_with_how_much_it_matters():
    own = 'mass = 0.5\ncenter = [0.12, 0]\ninertia = 2e-3\nthickness = "10 mm"'
    s = asked(plate(weight=own))
    (said,) = (remark for remark in s.remarks if "where its mass lies is not" in remark)
    assert "between its sides" in said
    even = asked(plate(weight='mass = 0.5\nthickness = "10 mm"'))
    assert not any("where its mass lies" in remark for remark in even.remarks)
    assert s.moment[0, 0] == pytest.approx(even.moment[0, 0], rel=0.02)


def test_without_a_material_there_are_stresses_and_no_safety():
    s = asked(plate(weight="thickness = 0.01\ndensity = 7850"))
    assert s.peak == pytest.approx(asked(plate()).peak)
    assert math.isnan(s.safety)
    assert math.isnan(s.life)
    assert "does not say its material" in " ".join(s.remarks)


def test_life_counts_at_both_edges():
    load = 'loads.F = { type = "force", at = "plate.B", force = [0, "900*sin(20*t)"] }'
    s = asked(plate(more=load, gravity="[0, 0]"), t=np.linspace(0, math.pi / 10, 41))
    amplitude = 900 * 0.15 / (0.01 * 0.04**2 / 6)
    assert s.peak == pytest.approx(amplitude)
    assert amplitude < 80e6
    assert math.isinf(s.life)
    again = asked(plate(more=load.replace("900", "3000"), gravity="[0, 0]"), t=np.linspace(0, math.pi / 10, 41))
    assert again.life == pytest.approx(1e6 * (80e6 / (amplitude / 0.3)) ** 5, rel=1e-6)


@pytest.mark.parametrize(
    ("necks", "words"),
    [
        ("{ root = [[0.05, -0.01], [0.05, 0.02]] }", "one of its ends is in the material"),
        ("{ root = [[0.5, -0.01], [0.5, 0.02]] }", "does not meet the plate"),
        ("{ root = [[0, -0.02], [0, 0.02]] }", "with material on both sides"),
        ("{ root = [[0.05, -0.02], [0.05, -0.02]] }", "both ends are at one place"),
        ("{ root = [0.05, -0.02] }", "expected .x, y. in m, got 0.05"),
        ("{ root = [[0.05, -0.02]] }", "expected two points"),
        ('{ "1" = [[0.05, -0.02], [0.05, 0.02]] }', "is not a name"),
        ('{ root = [[0.05, "1 kg"], [0.05, 0.02]] }', "expected a length"),
    ],
)
def test_cuts_that_are_none_are_refused_where_they_are(necks, words):
    with pytest.raises(ModelError, match=words) as caught:
        rt.loads(plate(necks)).model  # noqa: B018
    assert "bodies.plate.necks" in str(caught.value)


def test_a_cut_that_meets_four_edges_is_refused():
    comb = "[[0, -0.02], [0.2, -0.02], [0.2, 0.02], [0.15, 0.02], [0.15, 0], [0.05, 0], [0.05, 0.02], [0, 0.02]]"
    with pytest.raises(ModelError, match="goes through the plate 2 times, expected once"):
        rt.loads(plate("{ n = [[-0.01, 0.01], [0.3, 0.01]] }", polygon=comb)).model  # noqa: B018
    s = asked(plate("{ n = [[-0.01, 0.01], [0.1, 0.01]] }", polygon=comb))
    assert s.section.edges == pytest.approx((0.01, 0.06))


STEPPED = [[0, -0.05], [0.1, -0.05], [0.1, -0.02], [0.3, -0.02], [0.3, 0.02], [0.1, 0.02], [0.1, 0.05], [0, 0.05]]
NOTCHED = [[0, -0.02], [0.2, -0.02], [0.2, 0.02], [0.13, 0.02], [0.1, 0], [0.11, 0.02], [0, 0.02]]
FORK = [[0, 0], [0.1, 0], [0.1, 0.1], [0.08, 0.1], [0.08, 0.02], [0.02, 0.02], [0.02, 0.1], [0, 0.1]]
BORED = [[0.05, -0.01], [0.07, -0.01], [0.07, 0.01], [0.05, 0.01]]


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize(
    ("rings", "ends", "widths", "area"),
    [
        ([STEPPED], [[0.1, -0.05], [0.1, 0.05]], [0.04], 0.01),
        ([STEPPED], [[0.1, -0.02], [0.1, 0.02]], [0.04], 0.01),
        ([STEPPED], [[0.1, -0.02], [0.1, 0.05]], [0.04], 0.01),
        ([STEPPED[::-1]], [[0.1, -0.1], [0.1, 0.1]], [0.04], 0.01),
        ([NOTCHED], [[0.1, 0], [0.1, -0.02]], [0.02], 0.0041),
        ([NOTCHED], [[0.1, 0.005], [0.1, -0.03]], [0.02], 0.0041),
        ([STEPPED, BORED], [[0.05, -0.05], [0.05, 0.05]], [0.04, 0.04], 0.005),
        ([STEPPED, BORED], [[0.07, -0.05], [0.07, 0.05]], [0.04, 0.04], 0.0066),
        ([STEPPED, BORED], [[0.06, -0.05], [0.06, 0.05]], [0.04, 0.04], 0.0058),
        ([FORK], [[0.05, 0.0], [0.05, 0.02]], [0.02], 0.0026),
    ],
)
def test_a_cut_is_where_there_is_material_on_both_sides(rings, ends, widths, area, turned):
    """Also along an edge of a shoulder or of a hole, and to the root of a notch; whichever end comes first."""
    cut = Cut(rings, tuple(map(tuple, ends[::-1] if turned else ends)))
    assert [b - a for a, b in cut.pieces] == pytest.approx(widths)
    first = min((cut.left, cut.right), key=lambda part: part.centre[0])
    assert first.area == pytest.approx(area)
    whole = figure_of(rings[0], rings[1:])
    assert cut.left.area + cut.right.area == pytest.approx(whole.area)


@pytest.mark.parametrize("ends", [((0.02, 0.06), (0.08, 0.06)), ((0.03, 0.06), (0.07, 0.06))])
def test_a_cut_through_air_is_none(ends):
    with pytest.raises(CutFault, match="does not meet the plate"):
        Cut([FORK], ends)


def test_a_cut_through_both_arms_of_a_fork_is_none():
    with pytest.raises(CutFault, match="2 times"):
        Cut([FORK], ((-0.1, 0.06), (0.2, 0.06)))


def test_thickness_is_asked_for_where_it_is_needed():
    with pytest.raises(ModelError, match="need the thickness of the plate"):
        rt.loads(plate(weight="mass = 1")).model  # noqa: B018
    with pytest.raises(ModelError, match="needs a density"):
        rt.loads(plate("{}", weight="thickness = 1")).model  # noqa: B018


@pytest.mark.parametrize(
    ("necks", "name", "words"),
    [
        ("{}", "plate", "needs necks in the model"),
        (f"{ROOT[:-2]}, b = [[0.1, -0.02], [0.1, 0.02]] }}", "plate", "ask for one: plate.root, plate.b"),
        (ROOT, "plate.rot", "did you mean 'plate.root'"),
        (ROOT, "plat", "no body 'plat'"),
    ],
)  # fmt: skip
def test_which_neck_is_said(necks, name, words):
    with pytest.raises(InputError, match=words):
        asked(plate(necks), name)


def test_commands_pictures_and_films_know_necks(tmp_path):
    path = tmp_path / "plate.toml"
    path.write_text(plate(held=TURNED, more=""), encoding="utf-8")
    for picture, more in (("all.svg", ()), ("one.svg", ("--of", "plate")), ("one.csv", ("--of", "plate.root"))):
        result = CliRunner().invoke(
            main, ["strength", str(path), "--t-end", "0.1", "--points", "5", *more, "-o", str(tmp_path / picture)]
        )
        assert result.exit_code == 0, result.output
        assert "plate.root" in result.output
        assert (tmp_path / picture).stat().st_size > 100
    r = rt.load(path).simulate(0.1, t_eval=np.linspace(0, 0.1, 3))
    r.animate(tmp_path / "film.gif", stress=True, frames=3)
    assert (tmp_path / "film.gif").stat().st_size > 1000
    report = rt.load(path).report(tmp_path / "report.html", t_end=0.1).read_text(encoding="utf-8")
    assert "plate.root" in report


def test_the_life_of_a_neck_is_in_the_table_and_a_thicker_plate_is_advised():
    load = 'loads.F = { type = "force", at = "plate.B", force = [0, "3000*sin(20*t)"] }\nsimulate.t_end = 0.314159265'
    d = rt.loads(plate(more=load, gravity="[0, 0]")).durability()
    assert d.first[0] == "plate.root"
    assert "a thickness of 12 instead of 10 mm" in " ".join(map(str, d.remarks)) + str(d.advice)


def test_stress_is_asked_for_from_the_edge_and_wrong_types_are_said():
    s = asked(plate("{ root = [[0.05, -0.03], [0.05, 0.05]] }"))  # both ends beyond the edge
    assert s.at(s.peak_at[1])[0] == pytest.approx(s.peak)
    assert s.at(0.0)[0] == pytest.approx(s.fibres[1][0, 0])
    with pytest.raises(TypeError, match="y"):
        s.at("2 mm")


def test_necks_may_be_arrays():
    ends = np.array([[0.05, -0.02], [0.05, 0.02]])
    corners = np.array([[0, -0.02], [0.2, -0.02], [0.2, 0.02], [0, 0.02]])
    m = rt.Mechanism("strip").plate("p", corners, thickness=0.01, material="steel", necks={"root": ends})
    assert m.model.bodies["p"].sheet.necks["root"][1] == pytest.approx((-0.05, 0.02))


def test_a_sample_whose_cut_leaves_the_plate_fails_as_the_model_does():
    text = plate('{ root = [["x", -0.02], ["x", 0.02]] }', held=TURNED, more="parameters.x = 0.05")
    m = rt.loads(text)
    found = m.many({"x": [0.05, 0.1, 0.3]}, ["max(O.force)"], 0.05)
    assert list(found.failed) == [2]
    assert "does not meet the plate" in found.message(2)
    assert found["max(O.force)"][0] == pytest.approx(found["max(O.force)"][1])
