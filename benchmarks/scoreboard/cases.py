"""What is compared, and how the ways differ."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from types import ModuleType
from typing import Any

import numpy as np

from scoreboard import bodies, with_exudyn, with_mujoco, with_rattle
from scoreboard.bodies import Bodies, G
from scoreboard.curves import Case, Way

ERRORS = (1e-2, 1e-4, 1e-6, 1e-8, 1e-10)  # [m] at which times are compared


def peers() -> dict[str, ModuleType]:
    """The programs that are installed beside rattle."""
    found = {}
    for module in (with_exudyn, with_mujoco):
        try:
            module.package()
        except ImportError:
            continue
        found[module.NAME] = module
    return found


def all_cases(only: Sequence[str] = ()) -> list[Case]:
    """Every case, or those asked for."""
    makers = {
        "double_pendulum": double_pendulum,
        "four_bar": four_bar,
        "slider_crank": slider_crank,
        "windows_2": lambda: windows(2),
        "windows_20": lambda: windows(20),
        "ball": ball,
        "rolling": rolling,
        "box": box,
        "stack": stack,
    }
    return [make() for key, make in makers.items() if not only or key in only]


# ---------------------------------------------------------------- pins
LOOPS = (
    "Exudyn closes loops by constraints in absolute coordinates, MuJoCo by soft ones (time constant of two steps, "
    "impedance 0.9999), whose error falls with the step."
)


def _smooth(key: str, title: str, about: str, model: Bodies, end: float, truth: np.ndarray | None = None) -> Case:
    ways = with_rattle.smooth(model, end)
    here = peers()
    if with_exudyn.NAME in here:
        ways += with_exudyn.smooth(model, end)
        if key == "double_pendulum":
            ways += with_exudyn.pendulum_tree(model, end)
    if with_mujoco.NAME in here:
        ways += with_mujoco.smooth(model, end)
    return Case(key, title, about, "m", bodies.positions_at(model, end) if truth is None else truth, ways)


def double_pendulum() -> Case:
    """No loop: minimal coordinates are at home here."""
    about = (
        "Two bars of 1 m and 1 kg fall for 2 s. Exudyn in absolute coordinates with constraints, and in minimal ones "
        "with its explicit solvers; MuJoCo in minimal coordinates."
    )
    return _smooth("double_pendulum", "Double pendulum", about, bodies.double_pendulum(), 2.0)


def four_bar() -> Case:
    """One loop."""
    about = f"Crank, coupler and rocker move freely under their weight for 3 s. {LOOPS}"
    return _smooth("four_bar", "Four-bar", about, bodies.four_bar(), 3.0)


def slider_crank() -> Case:
    """One loop with a slider."""
    about = f"Crank, rod and slider, started with 10 rad/s, for 1 s. {LOOPS}"
    return _smooth("slider_crank", "Slider-crank", about, bodies.slider_crank(), 1.0)


def windows(count: int) -> Case:
    """Many links; they pass positions in which the joints lose their independence."""
    end = 10.0 if count < 10 else 2.0
    about = (
        f"{count} parallelogram four-bars side by side, {2 * count + 1} bars, for {end:g} s (IFToMM library, A02). "
        f"They pass positions in which all bars lie in one line. {LOOPS}"
    )
    truth = bodies.windows_at(count, end)
    return _smooth(f"windows_{count}", f"{count} windows", about, bodies.windows(count), end, truth)


# ---------------------------------------------------------------- contacts
IMPACT = '{{ model = "impact", restitution = {e}, friction = {mu} }}'
SOFT = "What is compared is the rigid law in closed form: rattle's contact is rigid, those of the others are elastic. "


def _flat(name: str, mass: float, inertia: float, points: dict[str, tuple[float, float]], start: str) -> str:
    text = ", ".join(f"{key} = [{x!r}, {y!r}]" for key, (x, y) in points.items())
    return (
        f"[bodies.{name}]\npoints = {{ {text} }}\ncenter = [0, 0]\nmass = {mass!r}\ninertia = {inertia!r}\n"
        f"[initial]\n{name} = {{ {start} }}\n"
    )


def _floor(first: str, touching: str, e: float, mu: float) -> str:
    contact = IMPACT.format(e=e, mu=mu)
    return (
        f'[joints.floor]\ntype = "surface"\nconnect = ["ground.O", "{first}"]\naxis = "0 deg"\n{touching}\n'
        f"contact = {contact}\n"
    )


HEAD = "format = 1\ngravity = [0, -9.81]\nground.points = { O = [0, 0] }\n"


def _world(option: str, inside: str, geom: str) -> str:
    """A plane and bodies over it, in MuJoCo: z is up."""
    return (
        f'<mujoco><compiler angle="radian"/><option gravity="0 0 {-G}" timestep="@STEP@" {option}>'
        f'<flag autoreset="disable"/></option><default><geom {geom}/></default><worldbody>'
        f'<geom type="plane" size="0 0 1"/>{inside}</worldbody></mujoco>'
    )


PLANAR = '<joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/><joint type="hinge" axis="0 -1 0"/>'


def ball() -> Case:
    """Restitution."""
    e, end = 0.8, 2.0
    t = math.sqrt(2.0 / G)
    v = G * t * e
    while t + 2 * v / G <= end:
        t, v = t + 2 * v / G, v * e
    truth = np.array([v * (end - t) - G / 2 * (end - t) ** 2])
    text = (
        HEAD
        + _flat("b", 1.0, 0.005, {"C": (0.0, 0.0)}, "x = 0, y = 1.1, angle = 0")
        + _floor("b.C", "roller = 0.1", e, 0.0)
    )
    ways = _after(with_rattle.with_contact(text, end, ["b.y"], [1e-2, 1e-3, 1e-4, 1e-5]), lambda y: y - 0.1)
    here = peers()
    if with_exudyn.NAME in here:
        ways += with_exudyn.ball(end, e)
    if with_mujoco.NAME in here:
        share = _damping_for(e)
        for k in (1e4, 1e6, 1e8):
            law = f'solref="{-k!r} {-2 * share * math.sqrt(k)!r}" solimp="0.9999 0.9999 0.001"'
            for integrator in ("RK4", "implicitfast"):
                xml = _world(
                    f'integrator="{integrator}"',
                    '<body pos="0 0 1.1"><joint type="slide" axis="0 0 1"/><geom type="sphere" size="0.1" mass="1"/>'
                    "</body>",
                    law,
                )
                grades = [(f"{n} steps", n, xml) for n in (1000, 5000, 25000, 125000)]
                ways.append(
                    with_mujoco.with_contact(
                        f"stiffness {k:.0e} N/m, {integrator}", end, grades, _at_rest, lambda d: d.xpos[1, 2:3] - 0.1
                    )
                )
    about = (
        f"A disc falls from 1 m and bounces with restitution {e}; its height after {end:g} s. {SOFT}"
        "Exudyn: its contact with restitution (impact model 2); MuJoCo: spring and damper; stiffness and "
        "step are varied."
    )
    return Case("ball", "Bouncing disc", about, "m", truth, ways)


def _at_rest(_: Any, __: Any) -> None:
    """Nothing moves at the start."""


def _after(ways: list[Way], change: Callable[[np.ndarray], np.ndarray]) -> list[Way]:
    """The same ways with a change of what they return."""

    def changed(make: Callable[[], Callable[[], np.ndarray]]) -> Callable[[], Callable[[], np.ndarray]]:
        def made() -> Callable[[], np.ndarray]:
            solve = make()
            return lambda: change(solve())

        return made

    return [way._replace(settings=[(name, changed(make)) for name, make in way.settings]) for way in ways]


def _damping_for(e: float) -> float:
    """Share of critical damping at which a spring and damper that cannot pull has the restitution e."""
    from scipy.optimize import brentq

    def misses(z: float) -> float:
        s = math.sqrt(1 - z * z)
        return math.exp(-z / s * (math.pi - math.atan2(2 * z * s, 1 - 2 * z * z))) - e

    return float(brentq(misses, 1e-6, 0.9))


def rolling() -> Case:
    """Slip, then rolling."""
    r, mass, mu, v0, end = 0.1, 2.0, 0.2, 3.0, 1.0
    inertia, te = 0.5 * mass * r * r, v0 / (3 * mu * G)
    turned = -2 * mu * G / r * (te**2 / 2 + te * (end - te))
    truth = np.array([v0 * te - mu * G * te**2 / 2 + 2 / 3 * v0 * (end - te), turned * r])
    text = (
        HEAD
        + _flat("b", mass, inertia, {"C": (0.0, 0.0)}, f"x = 0, y = {r}, angle = 0, vx = {v0}")
        + _floor("b.C", f"roller = {r}", 0.0, mu)
    )
    ways = _after(
        with_rattle.with_contact(text, end, ["b.x", "b.angle"], [1e-2, 1e-3, 1e-4, 1e-5]), lambda q: q * [1, r]
    )
    here = peers()
    if with_exudyn.NAME in here:
        # slip v + r w: the second coordinate is r times the angle, with the mass I/r^2
        ways += with_exudyn.sliding(end, ((mass, 0.0, v0), (inertia / r**2, 0.0, 0.0)), (-1.0, 1.0), mu * mass * G)
    if with_mujoco.NAME in here:
        inside = (
            f'<body pos="0 0 {r}">{PLANAR}<inertial pos="0 0 0" mass="{mass}" '
            f'diaginertia="{inertia} {inertia} {inertia}"/><geom type="sphere" size="{r}"/></body>'
        )
        ways += _sliding_in_mujoco(inside, end, mu, v0, lambda d: np.array([d.qpos[0], d.qpos[2] * r]))
    about = (
        f"A disc thrown along a plane with {v0:g} m/s slips, then rolls; place and turn after {end:g} s. {SOFT}"
        "Exudyn: two coordinates (place, turn) and friction that grows linearly in a zone of slip, varied; the normal "
        "force is given; MuJoCo: elliptic friction cones, varied step and stiffness."
    )
    return Case("rolling", "Disc slips, then rolls", about, "m", truth, ways)


def _sliding_in_mujoco(inside: str, end: float, mu: float, v0: float, read: Callable[[Any], np.ndarray]) -> list[Way]:
    ways = []
    for ratio in (1, 100):
        for integrator in ("RK4", "implicitfast"):
            grades = []
            for n in (50, 200, 800, 3200, 12800):
                law = f'friction="{mu} 0 0" condim="3" solref="{2 * end / n!r} 1" solimp="0.9999 0.9999 0.001"'
                option = f'integrator="{integrator}" cone="elliptic" impratio="{ratio}" tolerance="1e-12"'
                grades.append((f"{n} steps", n, _world(option, inside, law)))
            ways.append(
                with_mujoco.with_contact(
                    f"impratio {ratio}, {integrator}", end, grades, lambda _, d: _push(d, v0), read
                )
            )
    return ways


def _push(data: Any, speed: float) -> None:
    data.qvel[0] = speed


def box() -> Case:
    """Friction until rest."""
    half, high, mass, mu, v0, end = 0.3, 0.05, 3.0, 0.3, 3.0, 1.5
    truth = np.array([v0**2 / (2 * mu * G)])
    text = (
        HEAD
        + _flat(
            "b", mass, mass * (half**2 + high**2) / 3, {"P": (-half, -high), "Q": (half, -high)},
            f"x = 0, y = {high}, angle = 0, vx = {v0}",
        )
        + _floor("b.P", 'corners = ["P", "Q"]', 0.0, mu)
    )  # fmt: skip
    ways = with_rattle.with_contact(text, end, ["b.x"], [1e-2, 1e-3, 1e-4, 1e-5])
    here = peers()
    if with_exudyn.NAME in here:
        ways += with_exudyn.sliding(end, ((mass, 0.0, v0),), (1.0, 1.0), mu * mass * G)
    if with_mujoco.NAME in here:
        inside = f'<body pos="0 0 {high}">{PLANAR}<geom type="box" size="{half} 0.1 {high}" mass="{mass}"/></body>'
        ways += _sliding_in_mujoco(inside, end, mu, v0, lambda d: np.array(d.qpos[:1]))
    about = (
        f"A box slides with {v0:g} m/s on a plane until friction stops it; its place after {end:g} s. {SOFT}"
        "Exudyn: one coordinate, friction that grows linearly in a zone of slip, varied; the normal force is "
        "given; MuJoCo: four contact points in space."
    )
    return Case("box", "Sliding box", about, "m", truth, ways)


def stack() -> Case:
    """Ten blocks."""
    from stack import GAP, HIGH, text_of

    count, end = 10, 1.0
    truth = np.array([value for k in range(count) for value in (0.0, (2 * k + 1) * HIGH)])
    columns = [f"b{k}.{axis}" for k in range(count) for axis in "xy"]
    ways = with_rattle.with_contact(text_of(count, GAP, 0.0), end, columns, [5e-3, 2e-3, 1e-3, 5e-4])
    ways = [way if way.name == "Moreau-Jean" else way._replace(settings=way.settings[2:11:3]) for way in ways]
    if with_mujoco.NAME in peers():
        for integrator in ("Euler", "implicitfast"):
            grades = []
            for n in (200, 500, 1000, 2000, 5000):
                law = f'friction="0.5 0 0" condim="3" solref="{2 * end / n!r} 1" solimp="0.9999 0.9999 0.001"'
                inside = "".join(
                    f'<body name="b{k}" pos="0 0 {(2 * k + 1) * HIGH + (k + 1) * GAP!r}">{PLANAR}'
                    f'<geom type="box" size="0.1 0.1 {HIGH}" mass="1"/></body>'
                    for k in range(count)
                )
                option = f'integrator="{integrator}" cone="elliptic"'
                grades.append((f"{n} steps", n, _world(option, inside, law)))
            ways.append(
                with_mujoco.with_contact(
                    integrator, end, grades, _at_rest, lambda d: np.array(d.xpos[1:][:, [0, 2]]).ravel()
                )
            )
    about = (
        f"Ten blocks, {GAP * 1e3:g} mm apart, fall on each other without bouncing and come to rest; all places after "
        f"1 s. {SOFT}MuJoCo: soft contacts of boxes in space, 40 points. Exudyn is left out: its contacts between "
        "blocks are meshes of triangles, which we have not tried."
    )
    return Case("stack", "Stack of ten blocks", about, "m", truth, ways)
