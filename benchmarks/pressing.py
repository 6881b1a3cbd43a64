"""Hanging chains whose pins all press in their bushes: how the cost of the contact problem grows with their number.

    python benchmarks/run.py pressing

Event mode; the yardstick is Moreau-Jean with steps of 0.1 ms on the same chain.  Both
are compiled run times for 0.1 s of motion at the default tolerance, in which no pin leaves its bush.
"""

from __future__ import annotations

import math

import rattle as rt
from measure import Row, Sampler, interleave

END = 0.1  # [s]
PINS = (5, 10, 20, 40, 80, 200)
ARM, PLAY = 0.1, 1e-3  # [m]


def hanging_chain(pins: int, friction: float) -> rt.Mechanism:
    """Links of 0.2 m and 0.5 kg below each other, a little bent, each pin at the bottom of its bush."""
    contact = f'{{ model = "impact", restitution = 0.3, friction = {friction}, bush_radius = 0.01 }}'
    lines, joints, start, x, y = (
        ["format = 1", "gravity = [0, -9.81]", "[ground.points]", "G = [0, 0]"],
        [],
        ["[initial]"],
        0.0,
        0.0,
    )
    for k in range(pins):
        lines += [f"[bodies.b{k}]", "mass = 0.5", f"inertia = {0.5 * 0.04 / 12}"]
        lines += [f"points = {{ T = [{-ARM}, 0], B = [{ARM}, 0] }}"]
        above = f"b{k - 1}.B" if k else "ground.G"
        joints += [f"[joints.p{k}]", 'type = "revolute"', f'connect = ["{above}", "b{k}.T"]', f"clearance = {PLAY}"]
        joints += [f"contact = {contact}"]
        angle = 0.4 * math.cos(1.3 * k) - math.pi / 2
        x, y = x + ARM * math.cos(angle), y - PLAY + ARM * math.sin(angle)
        start += [f"b{k} = {{ x = {x!r}, y = {y!r}, angle = {angle!r}, vx = 0, vy = 0, omega = 0 }}"]
        x, y = x + ARM * math.cos(angle), y + ARM * math.sin(angle)
    return rt.loads("\n".join([*lines, *joints, *start]))


def sampler(mechanism: rt.Mechanism, method: str) -> Sampler:
    """Compiled run time [s] of the chain by one method."""
    step = {"step": 1e-4} if method == "moreau" else {}

    def sample() -> float:
        r = mechanism.simulate(END, t_eval=[0.0, END], method=method, **step)
        if not r.success:
            raise SystemExit(r.message)
        return float(r.stats["wall_time"])

    return sample


def rows(repeats: int) -> list[Row]:
    """Times of chains of several lengths, without and with friction."""
    found = []
    for friction in (0.0, 0.1):
        for pins in PINS:
            chain = hanging_chain(pins, friction)
            took = interleave({method: sampler(chain, method) for method in ("event", "moreau")}, min(repeats, 3))
            aim = {40: "0.1 s", 200: "1 s"}.get(pins, "")
            title = f"{pins} pins pressing, friction {friction}, {END} s"
            found.append(Row(title, took["event"], "Moreau-Jean 0.1 ms", took["moreau"], aim))
    return found
