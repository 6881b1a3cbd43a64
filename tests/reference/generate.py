"""Seeded random mechanisms, written twice: as a model file and for the reference code."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from reference import mechanism as ref
from reference.set_valued import Clutch, Pin

MOST_TRIES = 60


@dataclass
class Random:
    """A mechanism with its start, and where its joints stand in the reference."""

    text: str
    mechanism: ref.Mechanism
    q: np.ndarray
    v: np.ndarray
    joints: dict[str, list[int]] = field(default_factory=dict)  # rows of each joint
    pins: list[Pin] = field(default_factory=list)
    clutches: list[Clutch] = field(default_factory=list)


def drawn(seed: int, pins: int = 0, clutches: int = 0, at_rest: float = 0.0) -> Random:
    """A mechanism of 2 to 5 bodies; with some frictional pins and clutches, at rest with the given probability."""
    rng = np.random.default_rng(seed)
    for _ in range(MOST_TRIES):
        made = _Drawing(rng).made(pins, clutches, rng.random() < at_rest)
        if made is not None:
            return made
    raise AssertionError(f"seed {seed}: no mechanism that moves")


class _Drawing:
    def __init__(self, rng: np.random.Generator) -> None:
        self.rng = rng
        self.count = int(rng.integers(2, 6))
        self.q = np.concatenate([[*rng.uniform(-0.5, 0.5, 2), rng.uniform(-3, 3)] for _ in range(self.count)])
        self.bodies = [ref.Body(float(rng.uniform(0.2, 3)), float(rng.uniform(0.005, 0.1))) for _ in range(self.count)]
        self.mechanism = ref.Mechanism(self.bodies)
        self.points: list[list[tuple[float, float]]] = [[] for _ in range(self.count + 1)]  # the last: of the ground
        self.joints: dict[str, list[int]] = {}
        self.lines: list[str] = []
        self.pins: list[Pin] = []
        self.clutches: list[Clutch] = []

    def place(self, body: int, spot) -> tuple[tuple[float, float], str]:
        """A point of the plane in a body's frame, and its name in the model."""
        if body == ref.GROUND:
            own, name = (float(spot[0]), float(spot[1])), "ground"
        else:
            x, y, phi = self.q[3 * body : 3 * body + 3]
            dx, dy = spot[0] - x, spot[1] - y
            c, s = math.cos(phi), math.sin(phi)
            own = (float(c * dx + s * dy), float(-s * dx + c * dy))
            name = f"b{body}"
        self.points[body].append(own)
        return own, f"{name}.P{len(self.points[body]) - 1}"

    def join(self, a: int, b: int, kind: str, fields: str = "") -> str:
        rng, name, first = self.rng, f"j{len(self.joints)}", len(self.mechanism.rows)
        spot = rng.uniform(-0.6, 0.6, 2)
        own_a, name_a = self.place(a, spot)
        if kind == "revolute":
            own_b, name_b = self.place(b, spot)
            rows = ref.revolute(a, own_a, b, own_b)
        else:
            way, far = float(rng.uniform(-3, 3)), float(rng.uniform(0.1, 0.5))
            own_b, name_b = self.place(b, spot + far * np.array([math.cos(way), math.sin(way)]))
            phi_a = 0.0 if a == ref.GROUND else self.q[3 * a + 2]
            axis = float(way - phi_a)
            if kind == "rod":
                rows, fields = ref.rod(a, own_a, b, own_b, far), f"length = {far!r}"
            elif kind == "slot":
                rows, fields = ref.slot(a, own_a, b, own_b, axis), f"axis = {axis!r}"
            else:
                turned = float(self.q[3 * b + 2] - phi_a)
                rows = ref.prismatic(a, own_a, b, own_b, axis, turned)
                fields = f"axis = {axis!r}\nangle = {turned!r}"
        self.mechanism.rows += rows
        self.joints[name] = list(range(first, first + len(rows)))
        self.lines.append(f'[joints.{name}]\ntype = "{kind}"\nconnect = ["{name_a}", "{name_b}"]\n{fields}\n')
        return name

    def made(self, pins: int, clutches: int, rests: bool) -> Random | None:
        rng, size = self.rng, 3 * self.count
        kinds = ["revolute", "revolute", "revolute", "prismatic", "slot", "rod"] if not pins else ["revolute"]
        for b in range(self.count):
            a = int(rng.integers(-1, b))
            if pins > len(self.pins):
                self._rubbing(a, b)
            else:
                self.join(a, b, str(rng.choice(kinds)))
        for _ in range(int(rng.integers(0, 3))):
            a, b = (int(x) for x in rng.choice(np.arange(-1, self.count), 2, replace=False))
            self.join(min(a, b), max(a, b), str(rng.choice(["revolute", "rod", "slot"])))
        if rng.random() < 0.4 and not clutches:
            self._drive()
        zero = np.zeros(size)
        _, jacobian, of_time, _ = self.mechanism.constraints(self.q, zero, 0.0)
        _, s, vt = np.linalg.svd(jacobian)
        rank = int((s > 1e-6 * s[0]).sum())
        if rank >= size or (s[rank:] > 1e-11 * s[0]).any() or s[rank - 1] < 0.02 * s[0]:
            return None  # it cannot move, or is nearly singular
        fixed = -np.linalg.lstsq(jacobian, of_time, rcond=1e-9)[0]
        if np.abs(jacobian @ fixed + of_time).max(initial=0.0) > 1e-9:
            return None  # the driver is contradicted
        v = fixed + vt[rank:].T @ (np.zeros(size - rank) if rests else rng.normal(0, 2, size - rank))
        for _ in range(clutches):
            self._clutch(v)
        self._loads()
        return Random(self._text(v), self.mechanism, self.q, v, self.joints, self.pins, self.clutches)

    def _rubbing(self, a: int, b: int) -> None:
        mu, radius = float(self.rng.uniform(0.05, 0.4)), float(self.rng.uniform(0.01, 0.05))
        sticks = mu * float(self.rng.choice([1.0, 1.3]))
        table = f'friction = {{ model = "coulomb", mu = {mu!r}, mu_static = {sticks!r}, pin_radius = {radius!r} }}'
        rows = self.joints[self.join(a, b, "revolute", table)]
        self.pins.append(Pin((rows[0], rows[1]), a, b, mu, sticks, radius))

    def _drive(self) -> None:
        name = next((n for n, rows in self.joints.items() if len(rows) == 2 and "revolute" in self._of(n)), "")
        if not name:
            return
        a, b = self._bodies(name)
        speed = float(self.rng.uniform(-6, 6))
        start = float(self.q[3 * b + 2] - (0.0 if a == ref.GROUND else self.q[3 * a + 2]))
        self.joints["motor"] = [len(self.mechanism.rows)]
        self.mechanism.rows += ref.driver(a, b, start, speed)
        self.lines.append(f'[drivers.motor]\njoint = "{name}"\nangle = "{start!r} + {speed!r}*t"\n')

    def _of(self, name: str) -> str:
        return next(line for line in self.lines if line.startswith(f"[joints.{name}]"))

    def _bodies(self, name: str) -> tuple[int, int]:
        ends = self._of(name).split('connect = ["')[1].split('"]')[0].split('", "')
        a, b = (ref.GROUND if end.startswith("ground") else int(end.split(".")[0][1:]) for end in ends)
        return a, b

    def _clutch(self, v: np.ndarray) -> None:
        a, b = (int(x) for x in self.rng.choice(np.arange(-1, self.count), 2, replace=False))
        largest = float(self.rng.choice([np.inf, self.rng.uniform(0.5, 5)]))
        speed = v[3 * b + 2] * (b >= 0) - v[3 * a + 2] * (a >= 0)
        if np.isinf(largest) and speed < 1e-9:
            largest = float(self.rng.uniform(0.5, 5))  # an ideal one would begin with a blow
        name = {ref.GROUND: "ground"} | {k: f"b{k}" for k in range(self.count)}
        more = "" if np.isinf(largest) else f"max_torque = {largest!r}\n"
        self.lines.append(
            f'[joints.c{len(self.clutches)}]\ntype = "clutch"\nconnect = ["{name[a]}", "{name[b]}"]\n{more}'
        )
        self.clutches.append(Clutch(a, b, largest))

    def _loads(self) -> None:
        rng, forces = self.rng, self.mechanism.forces
        mass = self.mechanism.mass()
        weight = np.tile([0.0, -9.81, 0.0], self.count) * mass
        forces.append(lambda q, v, t: weight)
        body, torque = int(rng.integers(self.count)), float(rng.normal(0, 2))
        twist = np.zeros(3 * self.count)
        twist[3 * body + 2] = torque
        forces.append(lambda q, v, t: twist)
        self.lines.append(f'[loads.twist]\ntype = "torque"\nbody = "b{body}"\ntorque = {torque!r}\n')
        end = int(rng.integers(self.count))
        own_a, name_a = self.place(ref.GROUND, rng.uniform(-1, 1, 2))
        own_b, name_b = self.place(end, rng.uniform(-1, 1, 2))
        k, c, free = (float(x) for x in (rng.uniform(5, 200), rng.uniform(0, 3), rng.uniform(0.1, 0.8)))
        forces.append(_spring(end, own_a, own_b, k, c, free))
        self.lines.append(
            f'[loads.spring]\ntype = "spring"\nconnect = ["{name_a}", "{name_b}"]\nstiffness = {k!r}\n'
            f"damping = {c!r}\nfree_length = {free!r}\n"
        )

    def _text(self, v: np.ndarray) -> str:
        def listed(points):
            return ", ".join(f"P{k} = [{x!r}, {y!r}]" for k, (x, y) in enumerate(points))

        parts = ["format = 1\ngravity = [0, -9.81]\n", f"[ground]\npoints = {{ {listed(self.points[-1])} }}\n"]
        for k, body in enumerate(self.bodies):
            points = listed(self.points[k])
            parts.append(
                f"[bodies.b{k}]\nmass = {body.mass!r}\ninertia = {body.inertia!r}\npoints = {{ {points} }}\n"
                "center = [0, 0]\n"
            )
        parts += self.lines
        parts.append("[initial]\n")
        for k in range(self.count):
            keys = ("x", "y", "angle", "vx", "vy", "omega")
            numbers = (*self.q[3 * k : 3 * k + 3], *v[3 * k : 3 * k + 3])
            parts.append(
                f"b{k} = {{ {', '.join(f'{key} = {float(x)!r}' for key, x in zip(keys, numbers, strict=True))} }}\n"
            )
        return "\n".join(parts)


def _spring(body, place_a, place_b, stiffness, damping, free):
    """A spring with a damper between a point of the ground and one of a body."""

    def force(q, v, t):
        x, y, phi = q[3 * body : 3 * body + 3]
        arm = np.array(
            [
                math.cos(phi) * place_b[0] - math.sin(phi) * place_b[1],
                math.sin(phi) * place_b[0] + math.cos(phi) * place_b[1],
            ]
        )
        apart = np.array([x, y]) + arm - place_a
        rate = v[3 * body : 3 * body + 2] + v[3 * body + 2] * np.array([-arm[1], arm[0]])
        length = float(np.hypot(*apart))
        way = apart / length
        pull = -(stiffness * (length - free) + damping * float(rate @ way)) * way
        out = np.zeros(len(q))
        out[3 * body : 3 * body + 3] = *pull, arm[0] * pull[1] - arm[1] * pull[0]
        return out

    return force
