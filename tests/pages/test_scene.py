"""Scenes: the numbers of a result arrive in the viewer, and everything that is drawn there lies where it should."""

import base64
import itertools
import json

import numpy as np
import pytest

import rattle as rt
from any_motion import any_motion
from circling import circling
from rattle.drawings import numbers
from rattle.pages.replay import page_text
from rattle.pages.scene import MOST_ROWS, plain, scene_json, scene_of
from rattle.plots.scene import Scene
from rattle.plots.sketch import stage_of
from rattle.results.result import Result
from rattle.results.trust import Trust

pytestmark = [pytest.mark.nojit, pytest.mark.plain]
EXAMPLES = sorted(rt.examples())


def test_numbers_are_those_of_the_result():
    r = circling()
    scene = json.loads(scene_json(scene_of([("", r)])))
    (run,) = scene["runs"]
    t = np.frombuffer(base64.b64decode(run["t"]), "<f8")
    data = np.frombuffer(base64.b64decode(run["data"]), "<f4").reshape(len(run["names"]), run["n"])
    np.testing.assert_array_equal(t, r.t)
    for name, column in zip(run["names"], data, strict=True):
        np.testing.assert_array_equal(column, r[name].astype(np.float32))
    assert run["units"] == [r.unit(name) for name in run["names"]]
    assert run["trust"]["text"] == str(r.trust).splitlines()
    assert run["events"] == [[0.01, "O", "impact", 0.5, 0.0, 0.0, 0.25, 0.0, ""]]


def test_a_long_result_is_thinned_and_it_is_said():
    r = circling(n=7002)
    scene = scene_of([("", r)])
    t = np.frombuffer(base64.b64decode(scene["runs"][0]["t"]), "<f8")
    assert len(t) <= MOST_ROWS + 2 * len(r.names)
    assert (t[0], t[-1]) == (r.t[0], r.t[-1])
    assert np.diff(t).max() <= (r.t[-1] - r.t[0]) / (MOST_ROWS - 1) * 1.5
    assert f"shown are {len(t)} of the 7002 instants" in scene["notes"][0]


def test_numbers_that_are_not_finite_become_null():
    assert plain({"a": np.float64("nan"), "b": [np.inf, 1], "c": np.int64(3)}) == {"a": None, "b": [None, 1], "c": 3}


def test_text_of_a_model_cannot_end_the_script_it_stands_in():
    r = circling()
    page = page_text(scene_of([("", r)], title="</script><script>alert(1)</script>"))
    assert "<script>alert" not in page
    assert page.count("</script>") == 3  # a name that is kept free, the scene, the viewer


def test_a_result_without_motion_is_refused(tmp_path):
    r = circling()
    nothing = {"bodies": {}, "ground": {"points": {}}, "joints": {}, "loads": {}, "driven": []}
    curves = Result(
        t=r.t, data=r["lift"][:, None], names=["lift"], units={"lift": ""}, geometry=nothing, trust=Trust(drift=0.0),
        stats={}, provenance={},
    )  # fmt: skip
    with pytest.raises(ValueError, match="curves only, no motion"):
        curves.animate(tmp_path / "x.html")
    assert list(tmp_path.iterdir()) == []


LINES = """
import { Motion } from "./viewer.mjs";
const motion = new Motion(data.runs[0], data);
const plain = ({ t, y }) => ({ t: Array.from(t), y: Array.from(y) });
console.log(JSON.stringify(Object.fromEntries(motion.names.map((name) => [name, plain(motion.line(name))]))));
"""


def beating(n, per_instant):
    """A result of n instants whose force beats so many times per instant, at seeded phases."""
    r = circling(n=n)
    random = np.random.default_rng(7)
    phase = np.cumsum(2 * np.pi * per_instant * random.uniform(0.8, 1.2, n))
    data = np.array(r._data)
    data[:, r.stored.index("O.normal")] = np.sin(phase) * np.exp(3 * np.sin(9 * r.t))
    return Result(
        t=r.t, data=data, names=r.stored, units=r._units, geometry=r.geometry, trust=r.trust, stats={}, provenance={}
    )


@pytest.mark.parametrize("per_instant", [0.002, 0.03, 0.3])
def test_no_interval_of_a_thinned_curve_loses_its_largest_or_least_value(per_instant, viewer_in_node):
    r = beating(9001, per_instant)
    lines = viewer_in_node(LINES, plain(scene_of([("", r)])))
    edges = np.linspace(r.t[0], r.t[-1], 300)
    for name in ("O.normal", "arm.P.x", "O.force"):
        t, y = np.array(lines[name]["t"]), np.array(lines[name]["y"])
        assert (np.diff(t) >= 0).all()
        slack = 1e-6 * np.abs(r[name]).max()  # single precision
        for low, high in itertools.pairwise(edges):
            all_of_it, kept = r[name][(r.t >= low) & (r.t <= high)], y[(t >= low) & (t <= high)]
            # kept lines begin and end up to one shared instant beside the edges, where nothing turns
            inside = r[name][(r.t >= low + 2e-4) & (r.t <= high - 2e-4)]
            assert kept.max() <= all_of_it.max() + slack
            assert kept.min() >= all_of_it.min() - slack
            turned = inside.argmax(), inside.argmin()
            if 0 < turned[0] < len(inside) - 1:
                assert kept.max() >= inside.max() - slack
            if 0 < turned[1] < len(inside) - 1:
                assert kept.min() <= inside.min() + slack


def test_every_turn_of_a_curve_is_kept_where_a_page_can_hold_them(viewer_in_node):
    """A wave of 20 instants keeps all its maxima, though only every fourth instant is kept: no false wave."""
    r = beating(9001, 0.02)
    y = r["O.normal"]
    line = viewer_in_node(LINES, plain(scene_of([("", r)])))["O.normal"]
    tops = np.flatnonzero((y[1:-1] > y[:-2]) & (y[1:-1] > y[2:])) + 1
    kept = np.array(line["y"])
    shown = np.count_nonzero((kept[1:-1] > kept[:-2]) & (kept[1:-1] > kept[2:]))
    assert shown == len(tops)


def test_a_curve_too_fast_for_a_page_is_named():
    notes = scene_of([("", beating(60_001, 0.3))])["notes"]
    assert "Too fast to be held as they are: O.normal" in notes[0]


CURVES = """
import { Motion } from "./viewer.mjs";
const found = data.map((scene) => {
  const motion = new Motion(scene.runs[0], scene);
  return Object.fromEntries(motion.names.map((name) => [name, [motion.unit(name), Array.from(motion.curve(name))]]));
});
console.log(JSON.stringify(found));
"""


def test_derived_curves_are_those_of_python_in_every_example(viewer_in_node):
    results = [any_motion(name) for name in EXAMPLES]
    found = viewer_in_node(CURVES, [plain(scene_of([("", r)])) for r in results])
    for r, curves in zip(results, found, strict=True):
        assert sorted(curves) == sorted(r.names)
        for name, (unit, y) in curves.items():
            assert unit == r.unit(name)
            # float32 of numbers of the size of 1, multiplied by at most a few more such
            scale = 1.0 + np.abs(r[name]).max()
            np.testing.assert_allclose(np.array(y, float), r[name], atol=2e-5 * scale, err_msg=name)


PLACES = """
import { Motion, Stage, pointAt } from "./viewer.mjs";
const found = data.map((scene) => {
  const motion = new Motion(scene.runs[0], scene), stage = new Stage(motion, scene), places = {};
  for (const [body, form] of Object.entries(motion.geometry.bodies)) {
    for (const [point, at] of Object.entries(form.points)) {
      places[`${body}.${point}`] = Array.from(motion.t, (t) => pointAt(motion.pose(t), body, at));
    }
  }
  return { places, parts: stage.parts().length, low: stage.low, high: stage.high };
});
console.log(JSON.stringify(found));
"""


def test_points_are_drawn_where_they_are_in_every_example(viewer_in_node):
    results = [any_motion(name) for name in EXAMPLES]
    scenes = [plain(scene_of([("", r)])) for r in results]
    for r, scene, found in zip(results, scenes, viewer_in_node(PLACES, scenes), strict=True):
        assert found["parts"] == len(scene["kinds"]["joints"]) + len(scene["kinds"]["loads"])
        for point, path in found["places"].items():
            there = np.column_stack([r[f"{point}.x"], r[f"{point}.y"]])
            np.testing.assert_allclose(np.array(path), there, atol=1e-6 * (1 + np.abs(there).max()))
            assert (there >= np.array(found["low"]) - 1e-5).all()
            assert (there <= np.array(found["high"]) + 1e-5).all()


CRANK = """
import { crankOf, Motion } from "./viewer.mjs";
const found = data.map((scene) => crankOf(new Motion(scene.runs[0], scene)));
console.log(JSON.stringify(found.map((one) => one && [one.name, one.last])));
"""


def test_last_turn_of_the_crank_is_found(viewer_in_node):
    """Two turns and a half in either sense: the last begins after one and a half; who swings has none."""
    n = 501
    turning = [5 * np.pi * np.linspace(0, 1, n), -5 * np.pi * np.linspace(0, 1, n), np.sin(np.linspace(0, 9, n))]
    geometry = {
        "bodies": {"crank": {"points": {"O": [0.0, 0.0]}}},
        "ground": {"points": {"O": [0.0, 0.0]}},
        "joints": {
            "O": {
                "type": "revolute", "bodies": ["ground", "crank"], "points": [[0.0, 0.0], [0.0, 0.0]],
                "clearance": 0.0, "contact": "", "coordinate": "angle", "fields": {},
            }
        },
        "loads": {},
        "driven": ["O"],
    }  # fmt: skip
    units = {"crank.x": "m", "crank.y": "m", "crank.angle": "rad"}
    scenes = [
        scene_of([("", Result(
            t=np.linspace(0, 1, n), data=np.column_stack([0 * angle, 0 * angle, angle]), names=units, units=units,
            geometry=geometry, trust=Trust(drift=0.0), stats={}, provenance={},
        ))])
        for angle in turning
    ]  # fmt: skip
    assert viewer_in_node(CRANK, scenes) == [["O", 300], ["O", 300], None]


TEETH = """
import { Motion, Stage } from "./viewer.mjs";
const motion = new Motion(data.runs[0], data), stage = new Stage(motion, data);
const frames = stage.drawing.arrows.map(({ frame }) => frame);
console.log(JSON.stringify(frames.map(([x, y]) => Array.from(motion.t, (t) => {
  stage.values.set(motion.pose(t), t, 0);
  return [stage.values.get(x), stage.values.get(y)];
}))));
"""


def test_force_of_a_gear_acts_where_its_pitch_circles_touch(viewer_in_node):
    r = any_motion("gear_rattle")
    centre = np.column_stack([r["driver.C.x"], r["driver.C.y"]])
    every = np.array(viewer_in_node(TEETH, plain(scene_of([("", r)]))))
    off = np.abs(np.hypot(*np.moveaxis(every - centre, 2, 0)) - 0.03).max(axis=1)  # of the arrows of each force
    at = every[np.argmin(off)]
    assert off.min() < 1e-6
    between = np.column_stack([r["idle.C.x"] - r["driver.C.x"], r["idle.C.y"] - r["driver.C.y"]])
    out = at - np.column_stack([r["driver.C.x"], r["driver.C.y"]])
    np.testing.assert_allclose(between[:, 0] * out[:, 1] - between[:, 1] * out[:, 0], 0.0, atol=1e-6)


SCISSOR = """
format = 1
ground.points = { F = [0, 0] }
bodies.right = { bar = ["F", "T2"], length = 1.2, mass = 1, points = { M = [0, 0] } }
bodies.left = { bar = ["G", "T1"], length = 1.2, mass = 1, points = { M = [0, 0] } }
bodies.table = { points = { T1 = [0, 0], T2 = [0, 0], P = [0.5, 0.1] }, mass = 1, inertia = 1 }
initial = { right = { angle = "20 deg" }, left = { angle = "160 deg" } }
joints.F = { type = "revolute", connect = ["ground.F", "right.F"] }
joints.M = { type = "revolute", connect = ["right.M", "left.M"] }
joints.G = { type = "slot", connect = ["ground.F", "left.G"], axis = 0 }
joints.T1 = { type = "revolute", connect = ["table.T1", "left.T1"] }
joints.T2 = { type = "slot", connect = ["table.T2", "right.T2"], axis = 0 }
simulate = { t_end = 0.1 }
"""
SHAPE = """
import { Motion, placed, Stage } from "./viewer.mjs";
const stage = new Stage(new Motion(data.runs[0], data), data);
stage.values.set({ table: { x: 0, y: 0, angle: 0, cos: 1, sin: 0 } }, 0, 0);
const { frame, rings } = stage.drawing.drawn.find((primitive) => primitive.body === "table");
console.log(JSON.stringify(placed(stage.values, frame, rings[0])()));
"""


def test_a_body_is_drawn_up_to_the_pin_in_its_slot(viewer_in_node):
    """The slot of the table begins at its left pin and is used at its right end, where the bar carries it."""
    r = rt.loads(SCISSOR).simulate()
    shape = np.array(viewer_in_node(SHAPE, plain(scene_of([("", r)]))))
    pin = r["right.T2.x"] - r["table.T1.x"]  # the table keeps its angle
    assert shape[:, 0].max() > pin.max()
    stage = stage_of(Scene(r, np.arange(len(r.t)), 1.2))
    table = next(shape for shape in stage.shapes() if shape.style.get("body") == "table")
    drawn = table.rings[0][0, :, 0] - r["table.x"][0]
    assert drawn.max() > pin.max()


NUMBERS = """
import { Values } from "./viewer.mjs";
const values = new Values(data, {});
console.log(JSON.stringify(data.map((_, place) => values.get(place))));
"""


def test_usual_sizes_and_round_steps_are_those_of_python(viewer_in_node):
    """Of a force that is seldom there the largest is usual: its arrow can be seen."""
    sizes = [0.0, 0.0, -3.0, 0.0, 0.0, 0.0, 7.0, 0.0, 0.0, 0.0]
    nodes = [0.7, 0.8, 0.96, *sizes, *(["usual", share, *range(3, 13)] for share in range(3))]
    nodes += [30.1, 0.0019, 5.0, *(["nice", place] for place in (3, 16, 17, 18))]
    here = numbers.Values(nodes, {}, None, 1.0)
    told = viewer_in_node(NUMBERS, nodes)
    assert told == pytest.approx([float(here[place]) for place in range(len(nodes))])
    assert told[13:16] == [7.0, 3.0, 7.0]
    assert told[-4:] == pytest.approx([1.0, 50.0, 0.002, 5.0])
