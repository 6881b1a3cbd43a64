"""Random bodies on rough loose pins: model files from a seed, and all modes of their contacts, tried one by one.

The contact problem is built here from masses, points and pins alone, in plain NumPy:

    a_n = g'' = G_n f + b_n >= 0 <= N,  a_n N = 0,      T in -mu N Sgn(u), for u = 0 of u' = G_t f + b_t

for the gap g = c - |e| of a pin whose centre is at e from that of its bush, and its slip u.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np

RADIUS = 0.01  # of the bushes [m]
NEAR = 1e-9  # gap of a closed contact, as a share of its clearance; what errors of events leave
STILL = 1e-8  # slip or approach [m/s] that is rounding or the error of a located reversal
SLACK = 1e-9  # share of the terms of a condition by which it may be broken
EDGE = 1e-5  # share of a limit within which a solution ends soon
FRICTIONS = (0.1, 0.3, 0.6, 1.0, 1.5)
OFF, STICK, FORWARD, BACKWARD = range(4)


def turned(angle: float, at: np.ndarray) -> np.ndarray:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([c * at[0] - s * at[1], s * at[0] + c * at[1]])


def across(at: np.ndarray) -> np.ndarray:
    return np.array([-at[1], at[0]])


@dataclass
class Pin:
    a: int  # body with the bush, 0: ground
    b: int
    at_a: np.ndarray
    at_b: np.ndarray
    clearance: float
    mu: float
    restitution: float


@dataclass
class Problem:
    """G [1/kg] and b of contacts, rows (n, t) of each in turn; their slips [m/s] and coefficients of friction."""

    g: np.ndarray
    b: np.ndarray
    slips: np.ndarray
    mu: np.ndarray


class RoughPins:
    """One to three bodies hanging on one to `most` loose pins with friction, shaken by a torque and a force."""

    def __init__(self, seed: int, most: int = 3, frictions: tuple[float, ...] = FRICTIONS) -> None:
        rng = np.random.default_rng(seed)
        self.frictions = frictions
        count = int(rng.integers(1, 4))
        self.mass = rng.uniform(0.3, 3.0, count)
        self.inertia = self.mass * rng.uniform(0.02, 0.15, count) ** 2
        self.place = np.zeros((count + 1, 3))
        self.rate = np.zeros((count + 1, 3))
        self.gravity = rng.normal(0.0, 8.0, 2)
        self.pins: list[Pin] = []
        for k in range(1, count + 1):
            self.place[k] = [*rng.uniform(-0.3, 0.3, 2), rng.uniform(-math.pi, math.pi)]
            self._pin(rng, int(rng.integers(0, k)), k)
        while len(self.pins) < most and rng.random() < 0.5:
            a, b = sorted(int(n) for n in rng.choice(count + 1, 2, replace=False))
            self._pin(rng, a, b)
        self.rate[1:] = rng.normal(0.0, 1.0, (count, 3)) * [0.01, 0.01, 1.0]
        self.torque = (rng.uniform(0.05, 3.0), rng.uniform(20.0, 300.0))  # [N m], [rad/s], on the last body
        self.restitution_law = str(rng.choice(["newton", "poisson", "energetic"]))

    def _pin(self, rng: np.random.Generator, a: int, b: int) -> None:
        clearance = float(10.0 ** rng.uniform(-5, -3))
        middle = 0.5 * (self.place[a, :2] + self.place[b, :2]) + rng.normal(0.0, 0.08, 2)
        away = clearance * rng.uniform(0.0, 0.9) * turned(rng.uniform(0, 6.28), np.array([1.0, 0.0]))
        ends = [turned(-self.place[n, 2], where - self.place[n, :2]) for n, where in ((a, middle), (b, middle + away))]
        mu = float(rng.choice(self.frictions))
        self.pins.append(Pin(a, b, ends[0], ends[1], clearance, mu, float(rng.choice([0.0, 0.3, 0.7]))))

    def text(self) -> str:
        """The model file."""
        points: list[list[str]] = [[] for _ in self.place]
        joints = []
        for n, pin in enumerate(self.pins):
            for body, at in ((pin.a, pin.at_a), (pin.b, pin.at_b)):
                points[body].append(f"P{n} = [{float(at[0])!r}, {float(at[1])!r}]")
            ends = [f'"{f"b{body}" if body else "ground"}.P{n}"' for body in (pin.a, pin.b)]
            joints.append(
                f'[joints.p{n}]\ntype = "revolute"\nconnect = [{", ".join(ends)}]\nclearance = {pin.clearance!r}\n'
                f'contact = {{ model = "impact", restitution = {pin.restitution}, friction = {pin.mu}, bush_radius ='
                f' {RADIUS}, restitution_law = "{self.restitution_law}" }}'
            )
        lines = [f"format = 1\ngravity = {self.gravity.tolist()}", "[ground.points]", *(points[0] or ["O = [0, 0]"])]
        for k in range(1, len(self.place)):
            lines.append(f"[bodies.b{k}]\nmass = {self.mass[k - 1]:.17g}\ninertia = {self.inertia[k - 1]:.17g}")
            lines.append(f"points = {{ {', '.join(points[k])} }}")
        size, rate = self.torque
        lines += [*joints, f'[loads.shake]\ntype = "torque"\nbody = "b{len(self.mass)}"']
        lines += [f'torque = "{size!r}*cos({rate!r}*t)"', "[initial]"]
        for k in range(1, len(self.place)):
            (x, y, angle), (vx, vy, w) = self.place[k].tolist(), self.rate[k].tolist()
            lines.append(f"b{k} = {{ x = {x}, y = {y}, angle = {angle}, vx = {vx}, vy = {vy}, omega = {w} }}")
        return "\n".join(lines) + "\n"

    def problem(self, t: float, q: np.ndarray, v: np.ndarray, rebound: float = 1.0) -> Problem:
        """The problem at a state [SI]: for the forces of closed contacts, or for the impulses if one approaches.

        Impulses are those of Newton's law, with a share `rebound` of it, or of compression by the other two.
        """
        q, v = np.vstack([np.zeros(3), q.reshape(-1, 3)]), np.vstack([np.zeros(3), v.reshape(-1, 3)])
        weight = np.concatenate([np.zeros(3), np.repeat(1.0 / self.mass, 3)])
        weight[5::3] = 1.0 / self.inertia
        force = np.tile([*self.gravity, 0.0], len(q)) * (weight > 0.0)
        force[-1] = self.torque[0] * math.cos(self.torque[1] * t) / self.inertia[-1]
        closed = [self._rows(pin, q, v) for pin in self.pins]
        pins = [pin for pin, rows in zip(self.pins, closed, strict=True) if rows is not None]
        lines = np.array([row for rows in closed if rows is not None for row in rows[0]]).reshape(2 * len(pins), v.size)
        turning = np.array([term for rows in closed if rows is not None for term in rows[1]])
        rates, mu = lines @ v.ravel(), np.array([pin.mu for pin in pins])
        g = (lines * weight) @ lines.T
        if (rates[0::2] < -STILL).any():
            b, newton = rates.copy(), self.restitution_law == "newton"
            b[0::2] *= [1.0 + (rebound * pin.restitution if newton else 0.0) for pin in pins]
            return Problem(g, b, np.zeros(len(pins)), mu)
        stay = np.flatnonzero(rates[0::2] <= STILL)
        both = np.sort(np.concatenate([2 * stay, 2 * stay + 1]))
        return Problem(g[np.ix_(both, both)], (lines @ force + turning)[both], rates[1::2][stay], mu[stay])

    @staticmethod
    def _rows(pin: Pin, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, tuple[float, float]] | None:
        """Rows of the rates of gap and slip, and what turning adds to their derivatives; None if it is open."""
        arms = [turned(q[n, 2], at) for n, at in ((pin.a, pin.at_a), (pin.b, pin.at_b))]
        apart = q[pin.b, :2] + arms[1] - q[pin.a, :2] - arms[0]
        if np.hypot(*apart) < pin.clearance * (1.0 - NEAR):
            return None
        normal = apart / np.hypot(*apart)
        tangent = across(normal)
        lines, moving, bending = np.zeros((2, len(q), 3)), np.zeros(2), np.zeros(2)
        for sense, n, arm in ((-1.0, pin.a, arms[0]), (1.0, pin.b, arms[1])):
            moving += sense * (v[n, :2] + v[n, 2] * across(arm))
            bending -= sense * v[n, 2] ** 2 * arm
            lines[0, n] -= sense * np.array([*normal, normal @ across(arm)])
            lines[1, n] += sense * np.array([*tangent, tangent @ across(arm)])
        lines[1, pin.b, 2] += RADIUS - pin.clearance
        lines[1, pin.a, 2] -= RADIUS
        about = (tangent @ moving) ** 2 / pin.clearance
        return lines.reshape(2, -1), (-normal @ bending - about, tangent @ bending)


@dataclass
class Solution:
    modes: tuple[int, ...]
    force: np.ndarray
    rate: np.ndarray
    lasts: bool  # False if a force is about to pass its limit
    share: float  # of the determinant without friction of sliding; it is 0 at a lock


def all_solutions(problem: Problem) -> list[Solution]:
    """Solutions with different accelerations among all combinations of modes.  The rest of slip is tried either way."""
    b, slips = problem.b, problem.slips
    found: list[Solution] = []
    ways = [
        (OFF, STICK, FORWARD, BACKWARD) if abs(u) <= STILL else (OFF, FORWARD if u > 0.0 else BACKWARD) for u in slips
    ]
    for modes in itertools.product(*ways):
        solution = solve(problem, modes)
        if solution is None:
            continue
        size = 1e-5 * (np.abs(b).max() + np.abs(solution.rate).max())
        if not any(np.abs(solution.rate - other.rate).max() <= size for other in found):
            found.append(solution)
    return found


def solve(problem: Problem, modes: tuple[int, ...]) -> Solution | None:
    """Forces for given modes, or None if these modes are no solution."""
    g, b, slips, mu = problem.g, problem.b, problem.slips, problem.mu
    count = len(modes)
    basis = []  # forces (2 count,) per unknown, and the rows that are zero
    rows = []
    for k, mode in enumerate(modes):
        if mode == OFF:
            continue
        push = np.zeros(2 * count)
        push[2 * k] = 1.0
        if mode != STICK:
            push[2 * k + 1] = -mu[k] if mode == FORWARD else mu[k]
        basis.append(push)
        rows.append(2 * k)
        if mode == STICK:
            along = np.zeros(2 * count)
            along[2 * k + 1] = 1.0
            basis.append(along)
            rows.append(2 * k + 1)
    force = np.zeros(2 * count)
    if rows:
        matrix = np.array([[g[r] @ push for push in basis] for r in rows])
        force = np.array(basis).T @ np.linalg.lstsq(matrix, -b[rows], rcond=1e-13)[0]
    rate = g @ force + b
    size = np.abs(g) @ np.abs(force) + np.abs(b)
    push_size = np.abs(force).max(initial=0.0) + 1e-300
    lasts = True
    if rows and np.abs(rate[rows]).max() > SLACK * size.max():
        return None
    for k, mode in enumerate(modes):
        pressed, held, turns = force[2 * k], force[2 * k + 1], rate[2 * k + 1]
        if mode == OFF:
            if rate[2 * k] < -SLACK * size.max():
                return None
            continue
        if pressed < -SLACK * push_size:
            return None
        if mode == STICK:
            if abs(held) > mu[k] * pressed + SLACK * push_size:
                return None
            lasts &= abs(held) < mu[k] * pressed * (1.0 - EDGE)
        undecided = abs(slips[k]) <= STILL
        if undecided and mode != STICK and (turns if mode == FORWARD else -turns) < -SLACK * size.max():
            return None
    return Solution(modes, force, rate, lasts, share_of(problem, modes))


def share_of(problem: Problem, modes: tuple[int, ...]) -> float:
    """Ratio of the determinants with and without friction of sliding, in given modes; 1 where contacts depend."""
    g, mu = problem.g, problem.mu
    rows, rough, smooth = [], [], []
    for k, mode in enumerate(modes):
        if mode == OFF:
            continue
        drag = 0.0 if mode == STICK else (-mu[k] if mode == FORWARD else mu[k])
        rows.append(2 * k)
        rough.append(g[:, 2 * k] + drag * g[:, 2 * k + 1])
        smooth.append(g[:, 2 * k])
        if mode == STICK:
            rows.append(2 * k + 1)
            rough.append(g[:, 2 * k + 1])
            smooth.append(g[:, 2 * k + 1])
    plain = np.linalg.det(np.array(smooth).T[rows]) if rows else 1.0
    return float(np.linalg.det(np.array(rough).T[rows]) / plain) if rows and plain > 0.0 else 1.0


def least_share(problem: Problem) -> float:
    """Smallest share of a determinant, see `share_of`, of any modes."""
    return min(share_of(problem, modes) for modes in itertools.product(range(4), repeat=len(problem.mu)))
