"""How parts are drawn: cylinders as tubes with a piston, modes with springs and joints, bands that can be seen."""

import numpy as np
import pytest
from matplotlib.patches import Polygon
from matplotlib.path import Path

import rattle as rt
from circling import circling
from rattle import registry
from rattle.drawings.forms import drawings
from rattle.drawings.played import Stage, grown, hull
from rattle.drawings.sheet import Part, Sheet
from rattle.plots.animation import scene
from rattle.plots.scene import BODIES, Scene
from rattle.plots.sketch import stage_of
from rattle.questions.accuracy.pictures import magnified, plot_accuracy

CYLINDER = """
format = 1
[ground.points]
O = [0, 0]
Q = [0.5, -0.3]
[bodies.boom]
bar = ["O", "P"]
length = 1
mass = 1
[bodies.barrel]
bar = ["Q", "E"]
length = 0.3
mass = 1
[bodies.rod]
bar = ["S", "R"]
length = 0.3
mass = 1
[joints.O]
type = "revolute"
connect = ["ground.O", "boom.O"]
[joints.Q]
type = "revolute"
connect = ["ground.Q", "barrel.Q"]
[joints.R]
type = "revolute"
connect = ["boom.P", "rod.R"]
[joints.cylinder]
type = "prismatic"
connect = ["barrel.Q", "rod.S"]
[drivers.oil]
joint = "cylinder"
position = "0.25 + 0.06*sin(t)"
[initial]
boom = { angle = "20 deg" }
barrel = { angle = "60 deg" }
"""


def test_a_cylinder_is_a_tube_that_holds_barrel_and_piston_all_the_time():
    r = rt.loads(CYLINDER).kinematics(np.linspace(0, 6, 13))
    shapes = list(stage_of(Scene(r, np.arange(len(r.t)), 1.0)).shapes())
    # barrel and rod are no bars beside each other
    assert [shape.style["body"] for shape in shapes if "body" in shape.style] == ["boom"]
    filled = {tuple(shape.style["fill"]): shape.rings[0] for shape in shapes if shape.style.get("fill")}
    tube, rod, piston = (filled[colour] for colour in (("body barrel", 0.7), ("body rod", 0.35), ("body rod", 0.25)))
    for k in range(len(r.t)):
        outline = Path(tube[k])
        for point in ("barrel.E", "barrel.Q", "rod.S"):
            assert outline.contains_point((r[f"{point}.x"][k], r[f"{point}.y"][k]))
        assert not outline.contains_point((r["rod.R.x"][k], r["rod.R.y"][k]))
        assert np.hypot(*(rod[k, 0] - rod[k, 3])) == pytest.approx(0.0, abs=0.02)  # its height
        # a centre of four corners: rounding only
        assert piston[k].mean(axis=0) == pytest.approx([r["rod.S.x"][k], r["rod.S.y"][k]], abs=1e-12)


@pytest.mark.nojit
def test_every_joint_and_every_spring_has_a_picture():
    for family in ("joint", "load"):
        for name, kind in registry.kinds(family).items():
            form = getattr(kind.leaf, "drawn_as", "")
            assert form in drawings() if form else family == "load", f"{family} '{name}' is drawn as '{form}'"


@pytest.mark.nojit
def test_a_plate_has_the_outermost_points_as_corners():
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    inside = np.array([[0.5, 0.5], [0.2, 0.7], [0.5, 0.0]])
    assert hull(np.vstack([inside, square])).tolist() == square.tolist()
    assert hull(np.array([[1.0, 2.0], [0.0, 0.0], [2.0, 4.0]])).tolist() == [[0.0, 0.0], [2.0, 4.0]]


@pytest.mark.nojit
def test_thirty_bodies_have_thirty_colours():
    assert len(set(BODIES)) == len(BODIES) == 30


@pytest.mark.nojit
def test_a_plate_is_larger_to_all_sides_and_has_round_corners():
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    outline = grown(square, 0.1)
    away = np.hypot(*(outline - np.clip(outline, 0.0, 1.0)).T)
    assert away == pytest.approx(0.1)
    assert np.ptp(grown(square[:2], 0.1), axis=0) == pytest.approx([1.2, 0.2])  # a bar
    assert np.hypot(*(grown(square[:1], 0.1).T)) == pytest.approx(0.1)  # a point


def strokes(**fields):
    """Lines of a spring of 2 m that points upwards, in a mechanism of 1 m, each as long as all."""
    form = {"type": "spring", "bodies": ["ground", "ground"], "points": [[0.0, 0.0], [0.0, 2.0]], "fields": fields}
    geometry = {"bodies": {}, "ground": {"points": {}}, "joints": {}, "loads": {"s": form}, "driven": []}
    sheet = Sheet(geometry)
    drawings()["spring"].draw(sheet, Part(sheet, "s", "load", form, False))
    stage = Stage(sheet.written(), geometry, Scene(circling(3), np.array([0]), 1.0), 1.0)
    return [shape.rings[0][0] for shape in stage.shapes() if shape.style["draw"] == "path"]


@pytest.mark.nojit
def test_a_spring_is_coiled_a_damper_a_pot_and_both_are_side_by_side():
    back, front, _, ends = strokes(stiffness=1.0, damping=0.0)
    (damper,) = strokes(stiffness=0.0, damping=1.0)
    for coils, sense in ((back, -1.0), (front, 1.0)):  # half turns to one side before, to the other behind
        starts, tips = coils[::3], coils[1::3]
        assert len(starts) == 9
        assert (np.sign(starts[:, 0]) == sense * np.sign(starts[0, 0]) * sense).all()
        assert (np.sign(tips[:, 0]) == -np.sign(starts[:, 0])).all()
    assert np.isnan(damper).any(axis=1).sum() == 3  # pot, plunger and both rods are apart
    both = np.vstack(strokes(stiffness=1.0, damping=1.0))
    left, right = both[both[:, 0] < -1e-9], both[both[:, 0] > 1e-9]
    assert min(len(left), len(right)) >= 6
    for line in (ends, damper):
        assert line[0] == pytest.approx([0.0, 0.0], abs=1e-15)
        assert line[-1] == pytest.approx([0.0, 2.0])


def test_a_mode_is_drawn_with_its_springs_and_joints():
    modes = rt.example("balanced_arm").modes()
    ax = modes.plot().axes[0]
    rest = modes.equilibrium.result
    coils = [line for line in ax.lines if len(line.get_xdata()) == 27]  # nine in front, nine behind
    assert len(coils) == 2 * sum(form["type"] == "spring" for form in rest.geometry["loads"].values()) == 2
    assert any(isinstance(patch, Polygon) for patch in ax.patches)  # the pivot on the ground
    names = [text.get_text() for text in ax.get_legend().get_texts()]
    assert names == ["equilibrium", "one end of the swing", "the other"]


@pytest.mark.parametrize(
    ("span", "band", "times"), [(0.04, 1e-4, 100), (0.04, 8e-4, 10), (40.0, 1.5, 1), (0.0, 1.0, 1)]
)
def test_a_band_is_magnified_by_a_round_number_until_it_can_be_seen(span, band, times):
    assert magnified(span, band) == times


def test_a_magnified_band_says_so():
    found = rt.example("path_generator").accuracy("coupler.P.y", np.linspace(0, 1, 13), extremes=False)
    figure = plot_accuracy(found)
    top = figure.axes[0]
    assert [text.get_text() for text in top.get_legend().get_texts()] == [
        "worst case,\nmagnified 10 times",
        "without play",
    ]
    (band,) = top.collections
    height = np.ptp(band.get_paths()[0].vertices[:, 1])
    wide = 10 * found.worst
    assert height == pytest.approx(np.ptp([*(found.nominal - wide), *(found.nominal + wide)]))


def test_joints_that_matter_as_much_are_both_named():
    found = rt.example("fourbar").accuracy("rocker.angle", [0.0, 0.1], extremes=False)
    assert plot_accuracy(found).axes[2].get_title(loc="left") in ("tighten O3 or O4 first", "tighten O4 or O3 first")


def test_few_frames_show_the_whole_path_of_a_point():
    r = rt.loads(CYLINDER).kinematics(np.linspace(0, 2 * np.pi, 101))
    ax = scene(r, 3, ["boom.P"])[0].axes[0]
    for axis, limits in (("x", ax.get_xlim()), ("y", ax.get_ylim())):
        assert limits[0] < r[f"boom.P.{axis}"].min()
        assert r[f"boom.P.{axis}"].max() < limits[1]


STOPS = """
format = 1
[ground.points]
O = [0, 0]
R = [0, 0.6]
Z = [0.2, 0]
[bodies.hatch]
bar = ["O", "P"]
length = 1
mass = 5
[bodies.block]
points = { C = [0, 0] }
mass = 1
inertia = 0.01
[joints.O]
type = "revolute"
connect = ["ground.O", "hatch.O"]
stop = { min = "30 deg", max = "90 deg" }
[joints.rail]
type = "prismatic"
connect = ["ground.R", "block.C"]
stop = { min = "-0.1 m", max = "0.5 m" }
[loads.lifter]
type = "actuator"
connect = ["ground.Z", "hatch.P"]
force = 300
[initial]
hatch = { angle = "60 deg" }
block = { x = 0.2 }
"""


@pytest.mark.nojit
def test_stops_are_marked_where_the_body_is_held():
    ax = rt.loads(STOPS).plot().axes[0]
    thick = [np.array(line.get_data()).T for line in ax.lines if line.get_zorder() == 3.6]
    walls = sorted(float(one[0, 0]) for one in thick if np.ptp(one[:, 0]) < 1e-12 and one[:, 1].max() > 0.6)
    boxes = [patch.get_xy() for patch in ax.patches if isinstance(patch, Polygon) and patch.get_zorder() == 2.4]
    (block,) = [box for box in boxes if box[:, 1].mean() == pytest.approx(0.6, abs=0.02)]
    half = np.ptp(block[:, 0]) / 2
    assert walls == pytest.approx([-0.1 - half, 0.5 + half])  # the block touches them with its ends
    marks = [one for one in thick if one[:, 1].max() < 0.3]
    angles = sorted(np.degrees(np.arctan2(one[1, 1], one[1, 0])) for one in marks)
    assert angles == pytest.approx([30.0, 90.0])


@pytest.mark.nojit
def test_an_actuator_reaches_from_point_to_point():
    m = rt.loads(STOPS)
    ax = m.plot().axes[0]
    (barrel,) = [np.array(line.get_data()).T for line in ax.lines if line.get_zorder() == 3.4]
    foot, end = barrel[[0, 3]].mean(axis=0), barrel[[1, 2]].mean(axis=0)
    tip = np.array([0.5, np.sqrt(0.75)])
    assert foot == pytest.approx([0.2, 0.0])
    share = np.hypot(*(end - foot)) / np.hypot(*(tip - foot))
    assert 0.0 < share < 1.0
    assert end - foot == pytest.approx(share * (tip - foot))


@pytest.mark.nojit
def test_a_slot_that_is_a_curve_is_drawn_as_this_curve():
    """A parabola: the drawn walls are as far from it everywhere as the pin is thick, and the picture holds its ends."""
    x = np.linspace(-1.0, 1.0, 101)
    middle = np.column_stack([x, x**2])
    form = {
        "type": "slot", "bodies": ["ground", "arm"], "points": [[0.0, 0.5], [0.0, 0.0]], "clearance": 0.0,
        "contact": "", "axis": 0.0, "bush_radius": 0.05, "outline": middle.tolist(), "fields": {},
    }  # fmt: skip
    geometry = {
        "bodies": {"arm": {"points": {}}}, "ground": {"points": {}}, "joints": {"s": form}, "loads": {}, "driven": [],
    }  # fmt: skip
    sheet = Sheet(geometry)
    drawings()["slot"].draw(sheet, Part(sheet, "s", "joint", form, False))
    stage = Stage(sheet.written(), geometry, Scene(circling(3), np.array([0]), 1.0), 1.0)
    (wall,) = [shape.rings[0][0] for shape in stage.shapes() if shape.style["z"] == 4.0]
    away = np.hypot(*(wall[:, None] - np.array([0.0, 0.5]) - middle[None]).transpose(2, 0, 1)).min(axis=1)
    assert away == pytest.approx(0.05, rel=0.02)  # a polygon
    held = np.vstack([path[0] for path in stage.held()])
    assert held[:, 1].max() > 1.5
