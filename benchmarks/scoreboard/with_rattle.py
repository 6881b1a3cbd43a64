"""The models in rattle."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

import rattle as rt
from scoreboard.bodies import GROUND, Bodies
from scoreboard.curves import Way

TOLERANCES = tuple(10.0**-k for k in range(2, 14))
NAME = "rattle"


def text_of(model: Bodies) -> str:
    """The model file."""
    points: dict[int, dict[str, tuple[float, float]]] = {body: {} for body in range(GROUND, len(model.bodies))}
    joints = []
    for k, pin in enumerate(model.pins):
        points[pin.a][f"J{k}"], points[pin.b][f"J{k}"] = pin.at_a, pin.at_b
        first = "ground" if pin.a == GROUND else f"b{pin.a}"
        joints.append(f'J{k} = {{ type = "revolute", connect = ["{first}.J{k}", "b{pin.b}.J{k}"] }}')
    for body in model.sliders:
        points[GROUND]["S"], points[body]["S"] = (0.0, 0.0), (0.0, 0.0)
        joints.append(f'S{body} = {{ type = "prismatic", connect = ["ground.S", "b{body}.S"], axis = "0 deg" }}')
    lines = ["format = 1", "gravity = [0, -9.81]", f"ground.points = {{ {_points(points[GROUND])} }}", "[bodies]"]
    for k, one in enumerate(model.bodies):
        lines.append(
            f"b{k} = {{ points = {{ {_points(points[k])} }}, center = [0, 0], mass = {one.mass}, "
            f"inertia = {one.inertia!r} }}"
        )
    lines += ["[joints]", *joints, "[initial]"]
    for k, one in enumerate(model.bodies):
        keys = ("x", "y", "angle", "vx", "vy", "omega")
        lines.append(f"b{k} = {{ " + ", ".join(f"{key} = {float(getattr(one, key))!r}" for key in keys) + " }")
    return "\n".join(lines) + "\n"


def _points(points: dict[str, tuple[float, float]]) -> str:
    return ", ".join(f"{name} = [{x!r}, {y!r}]" for name, (x, y) in points.items())


def solver(text: str, end: float, columns: Sequence[str], **options: object) -> Callable[[], np.ndarray]:
    """The whole call of `simulate`, and the columns at the end."""
    mechanism = rt.loads(text)

    def solve() -> np.ndarray:
        r = mechanism.simulate(end, t_eval=[0.0, end], **options)  # type: ignore[arg-type]
        if not r.success:
            raise ValueError(r.message)
        return np.array([r[name][-1] for name in columns])

    return solve


def adaptive(text: str, end: float, columns: Sequence[str], **options: object) -> Way:
    """The adaptive stepper at all tolerances."""
    name = str(options.get("method", "adaptive"))
    settings = [
        (f"rtol {rtol:.0e}", lambda rtol=rtol: solver(text, end, columns, rtol=rtol, atol=rtol * 1e-2, **options))
        for rtol in TOLERANCES
    ]
    return Way(NAME, "events" if name == "event" else name, settings)


def smooth(model: Bodies, end: float) -> list[Way]:
    """Bodies with pins."""
    columns = [f"b{k}.{axis}" for k in range(len(model.bodies)) for axis in "xy"]
    return [adaptive(text_of(model), end, columns)]


def with_contact(text: str, end: float, columns: Sequence[str], steps: Sequence[float]) -> list[Way]:
    """Event-driven, and Moreau-Jean with fixed steps."""
    fixed = [
        (f"step {step:.0e}", lambda step=step: solver(text, end, columns, method="moreau", step=step)) for step in steps
    ]
    return [adaptive(text, end, columns, method="event"), Way(NAME, "Moreau-Jean", fixed)]
