"""The guide about the torque converter prints what it shows; its example turns as an independent integration says."""

import math
import subprocess
import sys

import numpy as np
import pytest

import rattle as rt
from test_pages import BLOCK, DOCS, shows

BLOCKS = BLOCK.findall(DOCS["torque-converter.md"])


@pytest.mark.long
def test_the_guide_prints_what_it_shows(tmp_path):
    code = "\n".join(text for language, text in BLOCKS if language == "python")
    done = subprocess.run(
        [sys.executable, "-c", code], check=True, cwd=tmp_path, timeout=600, text=True, stdout=subprocess.PIPE
    )
    lines = [line for language, text in BLOCKS if language == "text" for line in text.splitlines()]
    assert len(lines) == 8
    for line in lines:
        assert shows(done.stdout, line, 1e-3), f"{line}\n{done.stdout}"
    assert (tmp_path / "torque-converter.png").stat().st_size > 10_000


def test_the_example_is_in_its_tenth_turn_where_minimal_coordinates_are():
    """DOP853 with located events in the angles of arm and rotor, 1e-12; the same from time stepping."""
    end = 0.2 * math.pi
    r = rt.example("torque_converter").simulate(end, t_eval=np.array([0.0, end]), rtol=1e-11)
    assert r["rotor.omega"][-1] == pytest.approx(25.212481005, abs=1e-8)
    assert r["arm.angle"][-1] == pytest.approx(0.042132169641, abs=1e-8)
    assert r["rotor.angle"][-1] == pytest.approx(15.825219102, abs=1e-8)


MASSLESS = {
    "bodies.planet.mass": 0, "bodies.planet.inertia": 0, "bodies.sun.inertia": 0.01, "bodies.ring.inertia": 8e-4,
}  # fmt: skip


@pytest.mark.parametrize(("speed", "planet"), [(10.0, {}), (20.0, {}), (20.0, MASSLESS)])
def test_torque_of_the_epicyclic_converter_falls_on_a_straight_line_with_the_speed(speed, planet):
    """The closed form for massless planets, which these inertias are equivalent to; impulses of the third swing."""
    held = {"loads.brake": None, "W": speed, "drivers.shaft": {"joint": "rotor_axis", "angle": f"{speed}*t"}, **planet}
    turn = 2 * math.pi / 100
    r = rt.example("torque_converter_epicyclic").set(held).simulate(3 * turn, rtol=1e-10)
    impulse = sum(event.impulse for event in r.events if event.kind == "lock" and event.t > 2 * turn)
    inertia = 0.001 + 4 * 0.01
    line = 2 / math.pi * 100 * inertia * (6 * 0.01 / inertia * 0.25 * 100 - speed)
    assert impulse / turn == pytest.approx(line, rel=1e-7)
