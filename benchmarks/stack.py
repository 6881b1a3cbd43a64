"""Stacks of blocks that come to rest, and a polygon with many corners over a line that nothing touches."""

from __future__ import annotations

import math
import time

import rattle as rt
from measure import Row, interleave
from rhs import seconds_per_rhs

BLOCKS, WIDE, HIGH, LEDGE = 10, 0.1, 0.05, 0.24  # half width and half height; length of the edge that bears [m]
GAP, TILT = 0.01, 0.01  # [m], [rad]
FEW, MANY = 3, 12


def text_of(blocks: int, gap: float, tilt: float) -> str:
    """Blocks of 1 kg over each other, `gap` apart, turned to and fro by `tilt`; all corners bear on the one below."""
    corners = {"P": (-WIDE, -HIGH), "Q": (WIDE, -HIGH), "R": (WIDE, HIGH), "S": (-WIDE, HIGH)}
    points = ", ".join(f"{name} = [{x}, {y}]" for name, (x, y) in {**corners, "T": (0.0, HIGH)}.items())
    lines = ["format = 1", "gravity = [0, -9.81]", "ground.points = { O = [0, 0] }"]
    for k in range(blocks):
        y = HIGH * (2 * k + 1) + gap * (k + 1)
        below, edge = (f"b{k - 1}.T", f", length = {LEDGE}") if k else ("ground.O", "")
        lines += [
            f"[bodies.b{k}]",
            f"points = {{ {points} }}",
            "center = [0, 0]",
            "mass = 1",
            f"inertia = {(WIDE**2 + HIGH**2) / 3!r}",
            f"[initial.b{k}]",
            f"x = 0\ny = {y!r}\nangle = {tilt * (-1) ** k!r}",
            f"[joints.s{k}]",
            f'type = "surface"\nconnect = ["{below}", "b{k}.P"]\naxis = "0 deg"{edge.replace(", ", chr(10))}',
            f"corners = {list(corners)}".replace("'", '"'),
            'contact = { model = "impact", restitution = 0, friction = 0.5 }',
        ]
    return "\n".join(lines) + "\n"


def polygon(corners: int) -> str:
    """A regular polygon that falls on a line from far above."""
    turns = [2 * math.pi * k / corners for k in range(corners)]
    points = ", ".join(f"P{k} = [{0.1 * math.cos(a)!r}, {0.1 * math.sin(a)!r}]" for k, a in enumerate(turns))
    names = [f"P{k}" for k in range(corners)]
    return f"""format = 1
gravity = [0, -9.81]
ground.points = {{ O = [0, 0] }}
bodies.p = {{ points = {{ {points} }}, center = [0, 0], mass = 1, inertia = 0.005 }}
initial.p = {{ x = 0, y = 1000, angle = 0.1, vx = 0.3, vy = 0, omega = 2 }}
[joints.floor]
type = "surface"
connect = ["ground.O", "p.P0"]
axis = "0 deg"
corners = {str(names).replace("'", '"')}
contact = {{ model = "impact", restitution = 0.3, friction = 0.4 }}
"""


def rows(repeats: int) -> list[Row]:
    """Processor time of one second of motion, and the cost of corners that touch nothing."""
    rest = rt.loads(text_of(BLOCKS, 0.0, 0.0))
    tilted = rt.loads(text_of(BLOCKS, GAP, TILT))

    def run(mechanism: rt.Mechanism, **options: object) -> float:
        start = time.process_time()
        mechanism.simulate(1.0, t_eval=[0.0, 1.0], **options)  # type: ignore[arg-type]
        return time.process_time() - start

    few, many = rt.loads(polygon(FEW)), rt.loads(polygon(MANY))
    median = interleave(
        {
            "rest": lambda: run(rest, method="event"),
            "tilted": lambda: run(tilted, method="event"),
            "moreau": lambda: run(tilted, method="moreau", step=1e-3),
            "few": lambda: seconds_per_rhs(few, 50_000),
            "many": lambda: seconds_per_rhs(many, 50_000),
        },
        repeats,
    )
    return [
        Row("stack of 10 blocks at rest, 1 s, events", median["rest"], "the aim", 2.0, "1"),
        Row("the same, dropped and tilted", median["tilted"], "the aim", 2.0, "1"),
        Row("the same by Moreau-Jean, 1 ms", median["moreau"], "the aim", 0.05, "1"),
        Row(
            f"polygon of {MANY} corners: one right-hand side, nothing touches",
            median["many"],
            f"{FEW} corners",
            median["few"],
            "2",
        ),
    ]
