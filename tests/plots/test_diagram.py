"""The drawing of a model: every name in it once and readable, loads as they act, what moves freely, what stays open."""

from itertools import combinations
from xml.etree import ElementTree

import numpy as np
import pytest
from click.testing import CliRunner
from matplotlib.colors import to_hex
from matplotlib.text import Annotation

import rattle as rt
from rattle.analyses.assembly.free_coordinates import free_coordinates
from rattle.analyses.load_forces import load_forces
from rattle.cli.main import main
from rattle.drawings.forms.gear import MANY, MARKS
from rattle.plots.curves import RED, new_axes
from rattle.plots.labels import Label, drawn_points, place_labels

pytestmark = pytest.mark.nojit


def chain(n):
    m = rt.Mechanism("chain", gravity=[0, -9.81])
    m.ground(O=[0, 0])
    for k in range(n):
        m.bar(f"link{k}", "A", "B", length="0.1 m", mass=0.1)
        m.revolute(f"pin{k}", f"link{k - 1}.B" if k else "ground.O", f"link{k}.A")
        m.initial(f"link{k}", angle=f"{9 * k - 70} deg")
    return m


SCISSOR = """
format = 1
name = "Scissor lift"
[ground.points]
O = [0, 0]
[bodies.rising]
points = { L = [-0.5, 0], M = [0, 0], U = [0.5, 0] }
mass = 5
inertia = 0.4
[bodies.falling]
points = { L = [-0.5, 0], M = [0, 0], U = [0.5, 0] }
mass = 5
inertia = 0.4
[bodies.top]
points = { L = [-0.5, 0], T = [0, 0.1] }
mass = 20
inertia = 2
[joints.O]
type = "revolute"
connect = ["ground.O", "rising.L"]
[joints.roller]
type = "slot"
connect = ["ground.O", "falling.L"]
[joints.M]
type = "revolute"
connect = ["rising.M", "falling.M"]
[joints.left]
type = "revolute"
connect = ["falling.U", "top.L"]
[joints.right]
type = "slot"
connect = ["top.L", "rising.U"]
[drivers.oil]
joint = "roller"
position = "0.8"
[loads.payload]
type = "force"
at = "top.T"
force = [0, -2000]
[initial]
rising = { angle = "30 deg" }
falling = { angle = "150 deg" }
top = { angle = 0 }
"""
OPEN = SCISSOR.replace('position = "0.8"', 'position = "1.2"')  # the bars are 1 m long


def names(ax):
    return [one for one in ax.texts if isinstance(one, Annotation) and one.get_text() and one.get_zorder() == 8]


@pytest.mark.parametrize("model", [lambda: rt.example("fourbar"), lambda: chain(12), lambda: rt.loads(SCISSOR)])
def test_names_do_not_cover_each_other_and_stay_in_the_picture(model):
    ax = model().plot().axes[0]
    frame = ax.get_window_extent()
    boxes = [one.get_window_extent() for one in names(ax)]
    assert not [(a, b) for a, b in combinations(boxes, 2) if a.overlaps(b)]
    for box in boxes:
        assert frame.x0 <= box.x0 < box.x1 <= frame.x1
        assert frame.y0 <= box.y0 < box.y1 <= frame.y1


def test_everything_in_the_model_has_its_name_in_the_drawing():
    m = rt.example("balanced_arm")
    said = [one.get_text() for one in names(m.plot().axes[0])]
    model = m.model
    for word in (*model.bodies, *model.joints, *model.loads, *model.ground, "g"):
        assert [one for one in said if word in one.replace(",", " ").split()], word
    assert len(said) == len(set(said))


def test_play_of_a_joint_stands_with_its_name():
    assert "O3 (play 5 mm)" in [one.get_text() for one in names(rt.example("fourbar").plot().axes[0])]


def test_axes_are_to_scale_and_small_mechanisms_are_measured_in_millimetres():
    for example, unit in (("squeezer", "mm"), ("fourbar", "m")):
        ax = rt.example(example).plot().axes[0]
        assert ax.get_aspect() == 1.0
        assert ax.get_xlabel() == f"x [{unit}]"
        assert ax.get_title(loc="left") == rt.example(example).name


def test_a_drawing_goes_into_axes_of_the_user():
    ax = new_axes(6.0, 4.0)[0]
    assert rt.loads(SCISSOR).plot(ax=ax) is ax
    assert len(names(ax)) > 5


def test_a_force_is_an_arrow_in_its_direction():
    ax = rt.loads(SCISSOR).plot().axes[0]
    (head,) = [patch for patch in ax.patches if to_hex(patch.get_facecolor()) == RED.lower()]
    tip, left, right = head.get_xy()[:3]
    assert tip[0] == pytest.approx((left[0] + right[0]) / 2)
    assert tip[1] < min(left[1], right[1])


def test_what_a_load_exerts_is_that_load_alone():
    m = rt.example("balanced_arm")
    exerted = load_forces(m.system, 0.0, m.start.q, m.start.v)["spring"]
    spring, rate = m.model.loads["spring"], m.start.v
    assert not rate.any()
    stiffness, free = spring.values[4:6]
    x, y, angle = m.start.q[:3]
    cos, sin = np.cos(angle), np.sin(angle)
    end = np.array([x + cos * spring.b.at[0] - sin * spring.b.at[1], y + sin * spring.b.at[0] + cos * spring.b.at[1]])
    way = end - np.array(spring.a.at)
    length = np.hypot(*way)
    pull = stiffness * (length - free) * way / length
    np.testing.assert_allclose(exerted[0, :2], pull, rtol=1e-12)  # of B on A, the ground
    np.testing.assert_allclose(exerted[1, :2], -pull, rtol=1e-12)
    assert not exerted[2].any()  # neither gravity nor another load


def test_free_coordinates_determine_the_mechanism():
    free = free_coordinates(chain(3).system, 0.0, chain(3).start.q)
    assert free == ("pin0.angle", "pin1.angle", "pin2.angle")
    m = rt.example("fourbar").set({"drivers.motor": None})
    found = free_coordinates(m.system, 0.0, m.start.q)
    assert len(found) == m.check().mobility
    assert m.check().freedoms == found
    undriven = rt.loads(SCISSOR).set({"drivers.oil": None})
    (name,) = free_coordinates(undriven.system, 0.0, undriven.start.q)
    joint, coordinate = name.split(".")
    undriven.driver("held", joint=joint, **{coordinate: "30 deg" if coordinate == "angle" else "0.8 m"})
    assert undriven.check().mobility == 0


def test_a_free_body_has_its_own_coordinates():
    m = rt.Mechanism("stone")
    m.body("stone", mass=1, inertia=1, points={"P": [0.1, 0.0]})
    assert free_coordinates(m.system, 0.0, m.start.q) == ("stone.x", "stone.y", "stone.angle")
    assert "3 degrees of freedom" in " ".join(text.get_text() for text in m.plot().axes[0].texts)


def test_a_mechanism_that_does_not_close_is_drawn_with_its_open_joint_and_the_reason():
    ax = rt.loads(OPEN).plot().axes[0]
    said = [text.get_text() for text in ax.texts]
    assert [one for one in said if "open by" in one]
    assert [one for one in said if "cannot be assembled" in one.replace("\n", " ")]
    assert [line for line in ax.lines if line.get_color() == RED and line.get_marker() == "x"]


def test_names_are_text_in_the_file_that_is_drawn(tmp_path):
    path = tmp_path / "lift.svg"
    (tmp_path / "lift.toml").write_text(SCISSOR)
    done = CliRunner().invoke(main, ["draw", str(tmp_path / "lift.toml"), "-o", str(path)])
    assert done.exit_code == 0, done.output
    text = path.read_text()
    for name in ("rising", "payload", "oil", "roller"):
        assert f">{name}" in text
    again = tmp_path / "again.svg"
    CliRunner().invoke(main, ["draw", str(tmp_path / "lift.toml"), "-o", str(again)])
    assert again.read_bytes() == path.read_bytes()


def test_shapes_of_bodies_are_groups_with_their_names(tmp_path):
    """So that a program for drawing finds them; every name is there once."""
    rt.example("windows").plot().savefig(tmp_path / "own.svg")
    names = [group.get("id") for group in ElementTree.parse(tmp_path / "own.svg").iter("{http://www.w3.org/2000/svg}g")]
    for body in rt.example("windows").model.moving_bodies:
        assert names.count(body) == names.count(f"{body}-outline") == 1


def test_a_figure_that_the_user_saves_keeps_its_text(tmp_path):
    rt.loads(SCISSOR).plot().savefig(tmp_path / "own.svg")
    assert ">payload" in (tmp_path / "own.svg").read_text()


def test_the_command_says_what_does_not_close(tmp_path):
    (tmp_path / "open.toml").write_text(OPEN)
    path = tmp_path / "open.png"
    done = CliRunner().invoke(main, ["draw", str(tmp_path / "open.toml"), "-o", str(path)])
    assert done.exit_code == 1
    assert "cannot be assembled" in done.output
    assert path.exists()
    wrong = CliRunner().invoke(main, ["draw", str(tmp_path / "open.toml"), "-o", str(tmp_path / "open.bmp")])
    assert wrong.exit_code == 2


def test_a_name_far_from_its_point_gets_a_line_to_it():
    ax = new_axes(3.0, 3.0)[0]
    ax.set(xlim=(0, 1), ylim=(0, 1))
    few = place_labels(ax, [Label("one", (0.5, 0.5)), Label("two", (0.2, 0.2))])
    lines = [one for one in ax.texts if one not in few]
    assert not lines
    place_labels(ax, [Label(f"name {k}", (0.7, 0.7)) for k in range(14)])
    assert [one for one in ax.texts if one.arrow_patch is not None]


@pytest.mark.parametrize("far", [1e6, 1e12, 1e200])
def test_of_lines_that_go_far_out_of_the_picture_names_avoid_what_is_in_it(far):
    ax = new_axes(6.0, 4.0)[0]
    ax.set(xlim=(-1.0, 1.0), ylim=(-1.0, 1.0))
    ax.plot([-0.5, far], [0.0, 0.0])
    x, y = ax.transData.inverted().transform(drawn_points(ax, 4.0)).T
    within = x < 1.0
    assert len(x) < 1000
    assert np.abs(y[:-1]).max() < 1e-9
    if far < 1e20:
        assert x[within].min() == pytest.approx(-0.5)
        assert np.diff(np.sort(x[within])).max() < 0.05  # no gap on the way
        assert x[within].max() > 0.95


def test_a_wheel_beside_a_tiny_one_is_drawn_with_few_marks():
    """A million times larger, it would have millions of them, closer than lines are wide."""
    for ratio, most in ((2.0**0.5, round(2.0**0.5 * MARKS)), (1e6, MANY)):
        text = "format = 1\nground.points = { O = [0, 0], Q = [1, 0] }\n"
        for name, at in (("small", "O"), ("large", "Q")):
            text += f"bodies.{name} = {{ points = {{ C = [0, 0] }}, mass = 1, inertia = 1 }}\n"
            text += f'joints.{name}_pin = {{ type = "revolute", connect = ["ground.{at}", "{name}.C"] }}\n'
        radii = 1.0 / (1.0 + ratio), ratio / (1.0 + ratio)
        text += (
            f'joints.mesh = {{ type = "gear", connect = ["small.C", "large.C"], radii = [{radii[0]}, {radii[1]}] }}\n'
        )
        ax = rt.loads(text).plot().axes[0]
        marks = [line.get_xdata() for line in ax.lines if line.get_zorder() == 2.0]
        assert max(np.isnan(x).sum() for x in marks) == most  # a gap after each
