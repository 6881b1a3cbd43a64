"""Random mechanisms with friction in their joints, clutches and stops: model files from a seed.

Two to four bodies hang on the ground and on each other by pins, guides and slots; rods and slots close loops and may
leave frames that cannot move in themselves.  What is set-valued lies anywhere: across joints that cannot turn, side by
side, in redundant joints, on driven ones.
"""

from __future__ import annotations

import math

import numpy as np

FAMILIES = ("friction", "clutches", "stops", "mixed")


def turned(angle: float, point: np.ndarray) -> np.ndarray:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([c * point[0] - s * point[1], s * point[0] + c * point[1]])


class Drawn:
    """A mechanism as it is drawn: bodies with places and angles, points on them, and the text of what acts."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.rng = rng
        self.places: list[tuple[np.ndarray, float]] = [(np.zeros(2), 0.0)]
        self.masses: list[tuple[float, float]] = [(0.0, 0.0)]
        self.points: list[list[str]] = [[]]
        self.text: list[str] = []
        self.pins: list[str] = []  # joints whose angle may be driven or stopped

    def body(self) -> int:
        place = self.rng.uniform(-0.6, 0.6, 2)
        self.places.append((place, float(self.rng.uniform(-math.pi, math.pi))))
        self.masses.append((float(self.rng.uniform(0.5, 3.0)), float(self.rng.uniform(0.02, 0.1))))
        self.points.append([])
        return len(self.places) - 1

    def point(self, body: int, at: np.ndarray) -> str:
        place, angle = self.places[body]
        x, y = turned(-angle, at - place)
        self.points[body].append(f"P{len(self.points[body])} = [{float(x)!r}, {float(y)!r}]")
        return f"{self.name(body)}.P{len(self.points[body]) - 1}"

    @staticmethod
    def name(body: int) -> str:
        return f"b{body}" if body else "ground"

    def near(self, a: int, b: int) -> np.ndarray:
        """A place somewhere between two bodies."""
        share = self.rng.uniform(0.2, 0.8)
        return self.places[a][0] * share + self.places[b][0] * (1 - share) + self.rng.normal(0.0, 0.15, 2)

    def joint(self, name: str, kind: str, a: int, b: int, more: str = "") -> None:
        at = self.near(a, b)
        other = at
        if kind == "slot":
            more += f"\naxis = {self.rng.uniform(-math.pi, math.pi)!r}"
            direction = float(more.rsplit("= ", 1)[1]) + self.places[a][1]
            other = at + self.rng.uniform(-0.2, 0.2) * np.array([math.cos(direction), math.sin(direction)])
        if kind == "prismatic":
            axis = float(self.rng.uniform(-math.pi, math.pi))
            more += f"\naxis = {axis!r}\nangle = {self.places[b][1] - self.places[a][1]!r}"
            direction = axis + self.places[a][1]
            other = at + self.rng.uniform(-0.2, 0.2) * np.array([math.cos(direction), math.sin(direction)])
        if kind == "rod":
            other = self.near(b, b)
            more += f"\nlength = {float(np.hypot(*(other - at)))!r}"
        ends = f'["{self.point(a, at)}", "{self.point(b, other)}"]'
        self.text.append(f'[joints.{name}]\ntype = "{kind}"\nconnect = {ends}\n{more.strip()}')

    def written(self, gravity: float, rates: bool) -> str:
        lines = [f"format = 1\ngravity = [0, {-gravity!r}]", "[ground.points]", *(self.points[0] or ["O = [0, 0]"])]
        for body in range(1, len(self.places)):
            mass, inertia = self.masses[body]
            points = ", ".join(self.points[body]) or "C = [0, 0]"
            lines.append(f"[bodies.b{body}]\nmass = {mass!r}\ninertia = {inertia!r}\npoints = {{ {points} }}")
        lines += self.text
        lines.append("[initial]")
        for body in range(1, len(self.places)):
            (x, y), angle = self.places[body]
            moving = f", omega = {self.rng.normal(0.0, 2.0)!r}" if rates else ""
            lines.append(f"b{body} = {{ x = {float(x)!r}, y = {float(y)!r}, angle = {angle!r}{moving} }}")
        return "\n".join(lines) + "\n"


def mechanism(seed: int, family: str) -> str:
    """The model file of one random mechanism of a family of FAMILIES."""
    rng = np.random.default_rng([seed, FAMILIES.index(family)])
    drawn = Drawn(rng)
    bodies = int(rng.integers(2, 5))
    rubs = {"friction": 0.7, "mixed": 0.4}.get(family, 0.0)
    stops = {"stops": 0.7, "mixed": 0.3}.get(family, 0.0)
    clutches = {"clutches": 2, "stops": 1, "mixed": 1}.get(family, 0)
    pins = []
    for k in range(bodies):
        a = int(rng.integers(0, k + 1)) if k and rng.random() < 0.8 else 0
        b = drawn.body()
        kind = str(rng.choice(["revolute", "prismatic", "slot"], p=[0.6, 0.2, 0.2]))
        more = ""
        if kind != "slot" and rng.random() < rubs:
            more += friction(rng, kind)
        if kind == "revolute" and rng.random() < stops:
            angle = drawn.places[b][1] - drawn.places[a][1]
            law = rng.choice(["newton", "newton", "poisson", "energetic"]) if family == "stops" else "newton"
            drawn_law = f', restitution_law = "{law}"' if seed % 4 == 0 else ""
            bounce = f'contact = {{ model = "impact", restitution = {rng.uniform(0, 0.7)!r}{drawn_law} }}'
            low, high = angle - rng.uniform(0.05, 0.4), angle + rng.uniform(0.05, 0.4)
            more += f"\nstop = {{ min = {float(low)!r}, max = {float(high)!r}, {bounce} }}"
        drawn.joint(f"j{k}", kind, a, b, more)
        if kind == "revolute":
            pins.append((f"j{k}", drawn.places[b][1] - drawn.places[a][1]))
    for k in range(int(rng.integers(0, bodies + 1))):
        a, b = (int(n) for n in rng.choice(bodies + 1, 2, replace=False))
        drawn.joint(f"e{k}", str(rng.choice(["rod", "slot"])), a, b)
    for k in range(clutches):
        a, b = (int(n) for n in rng.choice(bodies + 1, 2, replace=False))
        torque = f"max_torque = {rng.uniform(0.3, 4.0)!r}\n" if rng.random() < 0.5 else ""
        ends = f'["{drawn.name(a)}", "{drawn.name(b)}"]'
        drawn.text.append(f'[joints.c{k}]\ntype = "clutch"\nconnect = {ends}\n{torque}sense = {rng.choice([1, -1])}')
    if pins and rng.random() < 0.35:
        name, angle = pins[int(rng.integers(len(pins)))]
        turn = f"{angle!r} + {rng.uniform(-0.2, 0.2)!r}*sin({rng.uniform(2, 6)!r}*t) + {rng.uniform(-0.5, 0.5)!r}*t"
        drawn.text.append(f'[drivers.drv]\njoint = "{name}"\nangle = "{turn}"')
    body = int(rng.integers(1, bodies + 1))
    push = f'["{rng.normal(0, 6)!r}*cos({rng.uniform(3, 9)!r}*t)", {rng.normal(0, 5)!r}]'
    hand = drawn.point(body, drawn.near(body, body))
    drawn.text.append(f'[loads.hand]\ntype = "force"\nat = "{hand}"\nforce = {push}')
    spring = (
        f"stiffness = {rng.uniform(1, 4)!r}\nfree_angle = {rng.uniform(-1, 1)!r}\ndamping = {rng.uniform(0, 0.1)!r}"
    )
    drawn.text.append(f'[loads.spring]\ntype = "torsion-spring"\nconnect = ["ground", "b1"]\n{spring}')
    return drawn.written(float(rng.choice([0.0, 9.81])), bool(rng.random() < 0.6))


def friction(rng: np.random.Generator, kind: str) -> str:
    mu = float(rng.uniform(0.1, 0.4))
    static = f", mu_static = {1.2 * mu!r}" if rng.random() < 0.4 else ""
    if kind == "revolute":
        return f'\nfriction = {{ model = "coulomb", mu = {mu!r}{static}, pin_radius = {rng.uniform(0.01, 0.04)!r} }}'
    block = "\nblock = { length = 0.3, height = 0.05 }" if rng.random() < 0.5 else ""
    return f'\nfriction = {{ model = "coulomb", mu = {mu!r}{static} }}{block}'
