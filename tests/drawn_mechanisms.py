"""Mechanisms with all forms of joints and loads, drawn at three instants, and where the ink of a picture is."""

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

import rattle as rt
from rattle.drawings.forms import display_list
from rattle.drawings.played import Stage
from rattle.plots.scene import Scene
from rattle.plots.sketch import draw_layers, draw_shapes, extent, stage_of

EXAMPLES = {  # time [s] up to which each runs: all forms of joints and loads are among them
    "belt_drive": 0.5, "cam_lift_off": 0.02, "crank_rocker_play": 0.1, "door_closer": 1.0, "double_wishbone": 0.05,
    "excavator": 1.0, "gear_rattle": 0.02, "geneva": 0.4, "guide_play": 0.05, "jansen_leg": 0.4, "planetary": 0.2,
    "dominoes": 0.3, "ratchet": 0.3, "rimless_wheel": 0.5,
    "rolling_cart": 0.5, "scissor_lift": 1.0, "scotch_yoke": 0.2, "slider_crank_play": 0.005,
    "stick_slip": 0.5, "toggle": 0.01, "torque_converter": 0.1, "woodpecker": 0.05,
}  # fmt: skip
OWN = """
format = 1
[ground.points]
O = [0, 0]
Q = [0.1, 0]
W = [-0.02, 0.06]
[bodies.disc]
points = { C = [0, 0] }
mass = 1
inertia = 1
[bodies.arm]
bar = ["C", "P"]
length = 0.09
mass = 1
[bodies.post]
points = { F = [0, 0], T = [0.03, 0.02] }
mass = 1
inertia = 1
[bodies.plate]
polygon = [[0, 0], [0.05, 0], [0.05, 0.03], [0, 0.03]]
holes = [[[0.03, 0.01], [0.04, 0.01], [0.04, 0.02]]]
thickness = 0.005
density = 2700
points = { C = [0.01, 0.01] }
[joints]
disc_pin = { type = "revolute", connect = ["ground.O", "disc.C"] }
arm_pin = { type = "revolute", connect = ["ground.Q", "arm.C"] }
plate_pin = { type = "revolute", connect = ["ground.Q", "plate.C"], stop = { min = "-20 deg", max = "70 deg" } }
cam = { type = "cam", connect = ["disc.C", "arm.P"], radius = "0.04 + 0.01*cos(2*a)", roller = 0.008 }
weld = { type = "fixed", connect = ["ground.W", "post.F"] }
[loads.damper]
type = "spring"
connect = ["post.T", "arm.P"]
stiffness = 0
damping = 10
[drivers.motor]
joint = "disc_pin"
angle = "3*t"
[initial]
arm = { angle = "150 deg" }
plate = { angle = "10 deg" }
"""
WIDE, HIGH = 18, 12  # cells
PIXELS = 450, 300  # of a picture


def motion(name):
    """The motion of an example, or of the mechanism with what none of them has."""
    return rt.loads(OWN).simulate(0.5) if name == "own" else rt.example(name).simulate(EXAMPLES[name])


def instants(r):
    """Rows of the three instants that are drawn: where it begins, halfway and where it ends."""
    return np.array([0, len(r.t) // 2, len(r.t) - 1])


def pictures(r, layer="drawn"):
    """Three figures of a motion."""
    stage = Scene(r, instants(r), 1.0)
    low, high = extent(stage)
    stage = stage._replace(size=float(max(high - low)))
    # the limits are fixed before anything is drawn: equal scales, the box in the middle
    middle, half = 0.5 * (low + high), 0.55 * max(high[0] - low[0], 1.5 * (high[1] - low[1]))
    for k in range(3):
        figure, ax = _empty(middle, half)
        for move in draw_layers(ax, stage, stage_of(stage), [layer]):
            move(k)
        yield figure


def magnified(r, lines=None):
    """Three figures of the first joint with play; lines: only primitives whose lines have this colour."""
    written, scene = display_list(r.geometry), Scene(r, instants(r), 1.0)
    stage = Stage(written, r.geometry, scene, 1.0, float(PIXELS[1]))
    drawn = [one for one in written["magnified"][0]["drawn"] if lines in (None, (one["line"] or [None])[0])]
    for k in range(3):
        figure, ax = _empty(np.zeros(2), 0.75)
        for move in draw_shapes(ax, scene, stage.shapes_of(drawn)):
            move(k)
        yield figure


def _empty(middle, half):
    """A figure and its axes, about a point and so far to either side."""
    figure = Figure(figsize=(4.5, 3.0), dpi=100)
    FigureCanvasAgg(figure)
    ax = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    ax.axis("off")
    ax.set(xlim=middle[0] + half * np.array([-1, 1]), ylim=middle[1] + half / 1.5 * np.array([-1, 1]))
    return figure, ax


def cells(figure):
    """(HIGH, WIDE) darkness of the cells of a figure, 0 to 255."""
    figure.canvas.draw()
    return cells_of(np.asarray(figure.canvas.buffer_rgba()))


def cells_of(pixels):
    """The same of pixels (high, wide, 3 or 4)."""
    dark = 255.0 - pixels[..., :3].mean(axis=2)
    mean = dark.reshape(HIGH, dark.shape[0] // HIGH, WIDE, dark.shape[1] // WIDE).mean(axis=(1, 3))
    return np.rint(mean).astype(int)
