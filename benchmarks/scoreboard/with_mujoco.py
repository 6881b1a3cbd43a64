"""The models in MuJoCo: minimal coordinates, loops closed by soft constraints, one call for all steps."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from scoreboard.bodies import GROUND, Bodies, G, tree, turned
from scoreboard.curves import Way

NAME = "MuJoCo"
STEPS = tuple(10 * 4**k for k in range(1, 8))


def package() -> Any:
    """MuJoCo, or ImportError."""
    import mujoco

    mujoco.set_mju_user_warning(lambda _: None)  # it would write them into a file
    return mujoco


def xml_of(model: Bodies, option: str, loop: str) -> str:
    """The tree of bodies as it stands at the start, and the pins that close its loops."""
    holds, rest = tree(model)

    def body(k: int, parent: int) -> str:
        one = model.bodies[k]
        x, y, angle = one.x, one.y, one.angle
        if parent != GROUND:
            above = model.bodies[parent]
            x, y = turned(-above.angle, (x - above.x, y - above.y))
            angle -= above.angle
        joint = (
            '<joint type="slide" axis="1 0 0"/>'
            if k in model.sliders
            else f'<joint type="hinge" axis="0 0 1" pos="{holds[k].at_b[0]!r} {holds[k].at_b[1]!r} 0"/>'
        )
        small = one.inertia  # about the axes that it never turns about
        inside = "".join(body(n, k) for n, pin in holds.items() if pin.a == k)
        return (
            f'<body name="b{k}" pos="{x!r} {y!r} 0" euler="0 0 {angle!r}">{joint}<inertial pos="0 0 0" '
            f'mass="{one.mass!r}" diaginertia="{small!r} {small!r} {one.inertia!r}"/>{inside}</body>'
        )

    roots = [n for n, pin in holds.items() if pin.a == GROUND] + list(model.sliders)
    closings = "".join(
        f'<connect body1="b{pin.b}" body2="b{pin.a}" anchor="{pin.at_b[0]!r} {pin.at_b[1]!r} 0" {loop}/>'
        for pin in rest
    )
    return (
        f'<mujoco><compiler angle="radian" autolimits="true"/><option gravity="0 {-G} 0" {option}>'
        f'<flag autoreset="disable"/></option>'
        f"<worldbody>{''.join(body(k, GROUND) for k in roots)}</worldbody>"
        + (f"<equality>{closings}</equality>" if rest else "")
        + "</mujoco>"
    )


def solver(xml: str, steps: int, start: Callable[[Any, Any], None], read: Callable[[Any], np.ndarray]) -> Any:
    """All steps in one call."""
    mujoco = package()
    model = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(model)

    def solve() -> np.ndarray:
        mujoco.mj_resetData(model, data)
        start(model, data)
        mujoco.mj_step(model, data, steps)
        mujoco.mj_kinematics(model, data)
        return read(data)

    return solve


def smooth(model: Bodies, end: float) -> list[Way]:
    """Bodies with pins."""
    holds, rest = tree(model)

    def start(compiled: Any, data: Any) -> None:
        for k, one in enumerate(model.bodies):
            at = compiled.body(f"b{k}").dofadr[0]
            if k in model.sliders:
                data.qvel[at] = one.vx
            else:
                above = holds[k].a
                data.qvel[at] = one.omega - (model.bodies[above].omega if above != GROUND else 0.0)

    def read(data: Any) -> np.ndarray:
        return np.array(data.xpos[1:, :2]).ravel()[order]

    mujoco = package()
    names = mujoco.MjModel.from_xml_string(xml_of(model, "", ""))
    rows = [names.body(f"b{k}").id - 1 for k in range(len(model.bodies))]
    order = np.ravel([(2 * row, 2 * row + 1) for row in rows])

    def way(integrator: str) -> Way:
        def make(steps: int) -> Callable[[], np.ndarray]:
            step = end / steps
            loop = f'solref="{2 * step!r} 1" solimp="0.9999 0.9999 0.001"' if rest else ""
            option = f'integrator="{integrator}" timestep="{step!r}" tolerance="1e-12"'
            return solver(xml_of(model, option, loop), steps, start, read)

        return Way(NAME, integrator, [(f"{steps} steps", lambda steps=steps: make(steps)) for steps in STEPS])

    return [way("RK4"), way("implicitfast")]


def with_contact(
    name: str, end: float, grades: Sequence[tuple[str, int, str]], start: Callable[[Any, Any], None],
    read: Callable[[Any], np.ndarray],
) -> Way:  # fmt: skip
    """A model in XML with @OPTION@ in its option, for each grade: what is told, steps, XML."""
    settings = []
    for told, steps, xml in grades:
        whole = xml.replace("@STEP@", repr(end / steps))
        settings.append((told, lambda whole=whole, steps=steps: solver(whole, steps, start, read)))
    return Way(NAME, name, settings)
