"""A page draws other dimensions by itself: the list of one model, played for another, is that of the other."""

import numpy as np
import pytest

import rattle as rt
from rattle.pages.scene import plain, scene_of
from rattle.plots.scene import Scene
from rattle.plots.sketch import extent, stage_of

PLAYED = """
import { Motion, placed, Stage } from "./viewer.mjs";
const { scene, across } = data, run = scene.runs[1], motion = new Motion(run, scene);
const stage = new Stage(motion, scene), { low, high } = stage;
stage.values.set(motion.pose(motion.end), motion.end, stage.size / across);
const shown = stage.drawing.drawn.filter(({ when }) => when === undefined || stage.values.get(when) > 0);
const paths = shown.map(({ frame, rings, path }) =>
  (rings ?? [path]).map((ring) => placed(stage.values, frame, ring)()));
console.log(JSON.stringify({ own: Boolean(run.drawing), low, high, paths }));
"""


@pytest.mark.parametrize(
    ("name", "turned", "t_end"),
    [
        ("belt_drive", {"R_1": 0.08}, 0.1), ("excavator", {"r": 0.35}, 0.2), ("gear_rattle", {"R_2": 0.06}, 0.02),
        ("planetary", {"module": 0.003}, 0.05), ("ratchet", {"R": 0.05}, 0.1), ("rolling_cart", {"R": 0.13}, 0.2),
        ("scotch_yoke", {"r": 0.04}, 0.1), ("toggle", {"l": 0.12}, 0.005), ("cam_lift_off", {"h": 0.006}, 0.01),
    ],
)  # fmt: skip
def test_a_turned_dimension_is_drawn_by_the_list_of_the_written_one(viewer_in_node, name, turned, t_end):
    m = rt.example(name)
    before, after = m.simulate(t_end), m.set(turned).simulate(t_end)
    there = viewer_in_node(PLAYED, {"scene": plain(scene_of([("", before), ("", after)])), "across": 420.0})
    assert not there["own"]  # it has no list of its own
    scene = Scene(after, np.arange(len(after.t)), 1.0)
    low, high = extent(scene)
    # numbers of a page are in single precision
    close = 1e-5 * float(max(high - low))
    assert there["low"] == pytest.approx(low, abs=close)
    assert there["high"] == pytest.approx(high, abs=close)
    shapes = list(stage_of(scene._replace(size=float(max(high - low)))).shapes())
    assert len(there["paths"]) == len(shapes)
    for shape, rings in zip(shapes, there["paths"], strict=True):
        for here, ring in zip(shape.rings, rings, strict=False):  # of a wall also its hatches
            points = np.array([point or (np.nan, np.nan) for point in ring], float)
            np.testing.assert_allclose(points, here[-1], atol=20 * close, err_msg=str(shape.style))
