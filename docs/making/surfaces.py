"""The figures of surfaces: what touches what, and a block that rocks."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import rattle as rt
from making.gallery import mechanism_to_scale
from making.tree import module_with

_pictures = module_with("CURVES", "new_figure", "tidy")
CURVES, new_figure, tidy = _pictures.CURVES, _pictures.new_figure, _pictures.tidy

DOTS = 80  # per inch
RIGID = 'contact = { model = "impact", friction = 0.4 }'
BOX = "polygon = [[-0.1, -0.06], [0.1, -0.06], [0.1, 0.06], [-0.1, 0.06]], mass = 1, points = { C = [0.1, 0.06] }"
BALL = "points = { C = [0, 0] }, mass = 1, inertia = 0.002"
ARM = "points = { C = [0, 0], P = [-0.12, -0.08], Q = [0.14, 0.02] }, center = [0, 0], mass = 1, inertia = 0.01"
PAIRS = (  # what it is called, keys, what B is, where it is
    ("corners on a line", 'axis = "-15 deg", corners = ["P", "Q"]', ARM, ("0.02", "0.1*tan(15 deg) + 0.08", "0")),
    ("roller on a line", 'axis = "-15 deg", roller = 0.07', BALL, ("0.07*sin(15 deg)", "0.07*cos(15 deg)", "0")),
    (
        "roller on a segment",
        "axis = 0, length = 0.3, roller = 0.07",
        BALL,
        ("0.15 + 0.07*sin(0.5)", "0.07*cos(0.5)", "0"),
    ),
    (
        "outline on a segment",
        "axis = 0, length = 0.3, outline = true",
        BOX,
        ("0.15 - 0.02*cos(0.2) + 0.06*sin(0.2)", "0.02*sin(0.2) + 0.06*cos(0.2)", "-0.2"),
    ),
    ("outline on a disc", "radius = 0.13, outline = true", BOX, ("-0.19*sin(0.25)", "0.19*cos(0.25)", "0.25")),
    ("roller on a disc", "radius = 0.13, roller = 0.07", BALL, ("0.2*sin(0.5)", "0.2*cos(0.5)", "0")),
    (
        "roller in a hollow",
        "radius = 0.2, hollow = true, roller = 0.07",
        BALL,
        ("0.13*sin(0.5)", "-0.13*cos(0.5)", "0"),
    ),
    ("corners in a hollow", 'radius = 0.2, hollow = true, corners = ["P", "Q"]', ARM, ("0", "-0.08", "0")),
)
ROCKER = """
format = 1
gravity = [0, -9.81]
ground.points = { O = [0, 0] }
parameters = { b = 0.1, h = 0.4, lean = "atan(b/h)/2" }

[bodies.block]
polygon = [["-b", "-h"], ["b", "-h"], ["b", "h"], ["-b", "h"]]
mass = 10
points = { P = ["-b", "-h"], Q = ["b", "-h"] }

[joints.floor]
type = "surface"
connect = ["ground.O", "block.P"]
axis = 0
corners = ["P", "Q"]
contact = { model = "impact", restitution = 0, friction = 1 }

[initial]
block = { x = "b - hypot(b, h)*sin(lean)", y = "hypot(b, h)*cos(lean)", angle = "-lean" }
"""


def pages(folder: Path) -> dict[str, str]:
    """No pages of their own: the pictures go into `folder`/pictures."""
    place = folder / "pictures"
    place.mkdir(exist_ok=True)
    figure = new_figure(11.0, 5.0)
    for k, (words, keys, body, start) in enumerate(PAIRS):
        ax = figure.add_subplot(2, 4, k + 1)
        mechanism_to_scale(ax, _pair(keys, body, start), 0.0)
        ax.set(xlabel="", xticks=[], yticks=[])
        ax.set_title(words, fontsize=10)
        for side in ax.spines.values():
            side.set_visible(False)
    figure.savefig(place / "surface-pairs.png", dpi=DOTS)
    figure = new_figure(11.0, 3.4)
    _rocking(figure)
    figure.savefig(place / "surface-rocking.png", dpi=DOTS)
    return {}


def _pair(keys: str, body: str, start: tuple[str, str, str]) -> Any:
    """A short run from where both touch, or nearly: 1e-9 m of a start do not matter."""
    x, y, angle = start
    return rt.loads(f"""
format = 1
ground.points = {{ O = [0, 0] }}
bodies.b = {{ {body} }}
joints.s = {{ type = "surface", connect = ["ground.O", "b.C"], {keys}, {RIGID} }}
initial.b = {{ x = "{x}", y = "{y}", angle = "{angle}" }}
""").simulate(1e-3)


def _rocking(figure: Any) -> None:
    """The block at its start, and its angle and the forces at its corners over time."""
    r = rt.loads(ROCKER).simulate(3.0, t_eval=np.linspace(0.0, 3.0, 1501))
    left, upper, lower = (figure.add_subplot(*place) for place in ((1, 3, 1), (2, 3, (2, 3)), (2, 3, (5, 6))))
    mechanism_to_scale(left, r, 0.0)
    tidy(upper).plot(r.t, np.degrees(r["block.angle"]), color=CURVES[0])
    upper.set(ylabel="angle [deg]", xlim=(0.0, 3.0), xticklabels=[])
    for corner, colour in zip("PQ", CURVES[1:], strict=False):
        tidy(lower).plot(r.t, r[f"floor.{corner}.normal"], color=colour, label=f"floor.{corner}.normal")
    lower.set(ylabel="force [N]", xlabel="t [s]", xlim=(0.0, 3.0))
    lower.legend(frameon=False, ncols=2, loc="center right")
