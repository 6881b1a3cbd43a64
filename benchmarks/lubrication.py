"""Oil films: one film law, and a lubricated slider-crank against SciPy's Radau with the same formulas at equal error.

The slider-crank turns three times at 5000 rpm; oil of 0.4 Pa s in a bush of 20 x 20 mm on the rod, clearance 0.2 mm.
SciPy integrates its two degrees of freedom in minimal coordinates, written by hand: fewer operations than rattle does
for a general mechanism.  Both take the largest tolerance from which on the eccentricity is right to 1e-6 of the
clearance; what is right follows from an explicit method at a tight tolerance.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np
from scipy.integrate import solve_ivp

import rattle as rt
from measure import Row, interleave, timed
from rattle.jit import functions
from rattle.jit.families import call_film
from rattle.jit.functions import KernelFunction
from rattle.registry import kinds

CRANK, ROD, RADIUS, LENGTH, C, MU = 0.05, 0.12, 0.01, 0.02, 2e-4, 0.4  # [m], [Pa s]
ROD_MASS, ROD_INERTIA, SLIDER_MASS = 0.21, 2.5e-4, 0.14
SPEED = 5000 * math.pi / 30
END = 6 * math.pi / SPEED
TIMES = np.linspace(0.0, END, 361)
THINNEST = 1e-3  # film, of the clearance: the boundary film of rattle
ALLOWED = 1e-6  # error of the eccentricity
FORCE, SHEAR = MU * RADIUS * LENGTH**3 / C**3, MU * RADIUS**3 * LENGTH / C

MODEL = f"""
format = 1
[ground.points]
O = [0, 0]
[bodies]
crank = {{ points = {{ O = [0, 0], A = [{CRANK}, 0] }}, center = [0, 0], mass = 0.3, inertia = 1e-4 }}
rod = {{ bar = ["A", "B"], length = {ROD}, mass = {ROD_MASS}, inertia = {ROD_INERTIA} }}
slider = {{ points = {{ B = [0, 0] }}, mass = {SLIDER_MASS}, inertia = 1e-4 }}
[joints]
O = {{ type = "revolute", connect = ["ground.O", "crank.O"] }}
A = {{ type = "revolute", connect = ["crank.A", "rod.A"] }}
guide = {{ type = "prismatic", connect = ["ground.O", "slider.B"], axis = 0 }}
[joints.B]
type = "revolute"
connect = ["rod.B", "slider.B"]
clearance = {C}
contact = {{ model = "lubricated", film = "short", viscosity = {MU}, length = {LENGTH}, bush_radius = {RADIUS} }}
[drivers]
motor = {{ joint = "O", angle = "{SPEED}*t" }}
[initial]
rod = {{ angle = 0 }}
slider = {{ angle = 0 }}
B = {{ offset = [0, 0] }}
"""


def integrals(a: float, b: float, s: float) -> tuple[float, float]:
    """I1 and I2 of the short film; s = sqrt(1 - a^2 - b^2)."""
    if a < 0.0 and s < -0.3 * a:
        u2 = (s / a) ** 2
        first = sum((-1) ** k * (4 * k - 4) / ((2 * k + 1) * (2 * k - 1)) * u2 ** (k - 2) for k in range(2, 18))
        second = sum((-1) ** j * (1 - 3 / (2 * j + 5)) * u2**j for j in range(16))
        return first / (-a) ** 3, b * second / a**4
    q, s5 = math.atan2(s, -a), s**5
    return (3 * a * s + q * (s * s + 3 * a * a)) / s5, b * (3 * s - s**3 / (1 - b * b) + 3 * q * a) / s5


def by_hand(t: float, y: list[float]) -> list[float]:
    """Derivative of the angle of the rod, the position of the slider, and their rates."""
    angle, x, w, v = y
    phi = SPEED * t
    ax, ay, cos, sin = CRANK * math.cos(phi), CRANK * math.sin(phi), math.cos(angle), math.sin(angle)
    ex, ey = x - ax - ROD * cos, -ay - ROD * sin
    ux = v + SPEED * ay + ROD * w * sin + 0.5 * w * ey
    uy = -SPEED * ax - ROD * w * cos - 0.5 * w * ex
    size, speed = math.hypot(ex, ey), math.hypot(ux, uy)
    gap = max(1.0 - size / C, THINNEST)  # stages of a step that is repeated may be beyond
    scale = 1.0 / C if gap > THINNEST else (1.0 - THINNEST) / size
    px, py, s = scale * ex, scale * ey, math.sqrt(gap * (2.0 - gap))
    fx, fy = 0.0, 0.0
    if speed > 0.0:
        mx, my = ux / speed, uy / speed
        first, second = integrals(px * mx + py * my, py * mx - px * my, s)
        fx, fy = -FORCE * speed * (first * mx - second * my), -FORCE * speed * (first * my + second * mx)
    moment = -SHEAR * w * 2 * math.pi / s - 0.5 * (ex * fy - ey * fx)  # on the rod, about its bush
    pull = -SPEED * SPEED * (-ax * sin + ay * cos)  # acceleration of A across the rod
    inertia = ROD_INERTIA + ROD_MASS * (0.5 * ROD) ** 2
    turn = (moment - ROD * (-fx * sin + fy * cos) - 0.5 * ROD_MASS * ROD * pull) / inertia
    return [w, v, turn, fx / SLIDER_MASS]


def scipy_place(rtol: float) -> np.ndarray:
    """e/c (2, n) by SciPy's Radau."""
    start = [0.0, CRANK + ROD, -CRANK * SPEED / ROD, 0.0]
    angle, x = solve_ivp(by_hand, (0.0, END), start, "Radau", TIMES, rtol=rtol, atol=0.01 * rtol).y[:2]
    phi = SPEED * TIMES
    ex, ey = x - CRANK * np.cos(phi) - ROD * np.cos(angle), -CRANK * np.sin(phi) - ROD * np.sin(angle)
    return np.array([ex, ey]) / C


def rattle_place(mechanism: rt.Mechanism, rtol: float, method: str | None = None) -> np.ndarray:
    """The same by rattle."""
    r = mechanism.simulate(END, t_eval=TIMES, rtol=rtol, method=method)
    return np.array([r["B.ex"], r["B.ey"]]) / C


def coarsest(place: Callable[[float], np.ndarray], truth: np.ndarray) -> tuple[float, float]:
    """The largest tolerance that meets the error, and that error."""
    for rtol in 10.0 ** -np.arange(6, 12.5, 0.5):
        error = float(np.abs(place(float(rtol)) - truth).max())
        if error <= ALLOWED:
            return float(rtol), error
    raise SystemExit(f"an error of {ALLOWED} is met at no tolerance")


def crank_rows(repeats: int) -> list[Row]:
    """Three turns of the slider-crank."""
    mechanism = rt.loads(MODEL)
    truth = rattle_place(mechanism, 1e-12, "dop853")
    ours, our_error = coarsest(partial(rattle_place, mechanism), truth)
    theirs, their_error = coarsest(scipy_place, truth)

    def compiled() -> float:
        return float(mechanism.simulate(END, t_eval=TIMES, rtol=ours).stats["wall_time"])

    median = interleave({"run": compiled, "call": timed(partial(rattle_place, mechanism, ours))}, repeats)
    slow = interleave({"SciPy": timed(partial(scipy_place, theirs))}, 1)["SciPy"]
    said = f"Radau of SciPy (error {their_error:.1e}, rattle {our_error:.1e} of c)"
    return [
        Row("slider-crank in oil, 3 turns, compiled run", median["run"], said, slow, "150 ms, 0.033"),
        Row("the same, whole call", median["call"]),
    ]


def _many(entries, states, p, table, out, n):  # type: ignore[no-untyped-def]
    total = 0.0
    for _ in range(n):
        for k in range(states.shape[0]):
            ex, ey, vx, vy = states[k, 0], states[k, 1], states[k, 2], states[k, 3]
            call_film(entries[0], (ex, ey, vx, vy, states[k, 4], states[k, 5], p, 0, table, out))
            total += out[0]
    return total


many = KernelFunction(_many)


def seconds_per_film(name: str, rounds: int) -> float:
    """Time of one call of a film law [s] in a compiled loop over random places and velocities."""
    functions.start()
    rng, law = np.random.default_rng(0), kinds("film")[name]
    assert law.kernel is not None
    values = {"viscosity": MU, "length": LENGTH, "bush_radius": RADIUS, "cavitation": "reynolds", "shear": "whole"}
    p, table = np.array(law.leaf.pack(values, C, 1e-6 * C), dtype=float), np.array(law.leaf.table(values))
    e, angle = C * rng.uniform(0.05, 0.98, 1000), rng.uniform(0.0, 2 * math.pi, 1000)
    motion = np.array([0.1, 0.1, 300.0, 300.0]) * rng.normal(size=(1000, 4))
    states, out = np.column_stack([e * np.cos(angle), e * np.sin(angle), motion]), np.zeros(5)
    call = partial(many, np.array([law.kernel.address]), states, p, table, out)
    call(1)
    return timed(partial(call, rounds))() / rounds / len(states)


def rows(repeats: int) -> list[Row]:
    """Times of films."""
    aims = {"short": "60 ns", "finite": "250 ns"}
    median = interleave({name: partial(seconds_per_film, name, 200) for name in aims}, repeats)
    return [*(Row(f"one film, {name}", median[name], aim=aim) for name, aim in aims.items()), *crank_rows(repeats)]
