"""Runs by the engine of pages are those of `simulate`: the same steps, events and numbers."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from llvmlite.binding import llvm_version_info

import rattle as rt
from core_engine import by_machine_code, in_node, new
from linkages import loose_parallelogram
from rattle.jit import layout as at
from rattle.pages.run_image import run_image

pytestmark = pytest.mark.skipif(shutil.which("node") is None, reason="no node")


def apart(a, b):
    """The largest difference of two (n, k) rows, as a share of the largest value of its column (of 1e-3 at least)."""
    return float((np.abs(a - b) / np.maximum(np.abs(a).max(axis=0), 1e-3)).max())


STEPPED_ALIKE = {  # difference of rows
    "bouncing_pin": 1e-12,  # impacts
    "gear_rattle": 1e-9,  # compliant flanks
    "fourbar_onesided": 1e-4,  # impacts with friction
    "slider_crank_oil": 1e-2,  # an oil film: radau
    "torque_converter": 1e-4,  # clutches
    "ratchet": 1e-7,
    "door_closer": 1e-7,  # a stop
    "drawer": 1e-12,
    "stick_slip": 1e-5,  # friction of a joint without play
    "crank_rocker_play": 1e-3,  # massless links
    "piston_engine": 1e-4,  # a table
    "three_plays": 1e-6,  # Moreau-Jean
    "excavator": 1e-4,  # switches of time
    "marble_run": 1e-6,  # surfaces: bounces that end, ends of segments, resistance to rolling, rest
    "dominoes": 1e-6,  # corners on lines and segments that move
}


@pytest.mark.parametrize("name", STEPPED_ALIKE)
def test_it_takes_the_steps_of_simulate(name, tmp_path):
    """But for the last bits of sine and power, which a C library may round otherwise on another machine."""
    said, run = in_node(tmp_path, new(name)), by_machine_code(new(name))
    assert said["success"]
    assert run["success"]
    assert said["statistics"]["steps"] == pytest.approx(run["statistics"]["steps"], rel=0.05, abs=2)
    assert [one["kind"] for one in said["events"]] == run["events"][:, 2].tolist()
    assert np.allclose([one["t"] for one in said["events"]], run["events"][:, 0], rtol=1e-4)
    assert apart(run["rows"], said["rows"]) < STEPPED_ALIKE[name]


@pytest.mark.parametrize("method", [None, "rk4", "event"])
def test_a_cord_and_bushings_move_alike(method, tmp_path):
    m = rt.Mechanism(gravity=[0, -9.81]).ground(L=[-0.3, 0], O=[0, 0.6])
    m.body("engine", mass=90, inertia=6, points={"L": [-0.3, -0.2], "C": [0, 0.05]})
    stiffness, damping = [1e5, 6e4, 200], [300, 300, 4]
    m.load("mount", "bushing", connect=["ground.L", "engine.L"], stiffness=stiffness, damping=damping)
    cord = {"stiffness": 2e4, "free_length": 0.352, "damping": 50, "tension_only": True}
    m.load("cord", "spring", connect=["ground.O", "engine.C"], **cord).initial("engine", x=0, y=0.2, vy=0.3)
    said, run = in_node(tmp_path, new(m, method, t_end=0.3)), by_machine_code(new(m, method, t_end=0.3))
    assert said["statistics"]["steps"] == run["statistics"]["steps"]
    assert set(m.simulate(0.3)["cord.slack"]) == {0.0, 1.0}
    assert apart(run["rows"], said["rows"]) < 1e-9


@pytest.mark.parametrize("share", [1.0, 0.9])
def test_output_times_are_those_of_simulate(share, tmp_path):
    """To the bit, whether they are equally far apart, which takes no bytes, or not."""
    run = new("fourbar_onesided", t_end=0.07)
    run.t_eval[1] *= share
    assert (run_image(run).description["times"][1] < 0) == (share == 1.0)
    in_node(tmp_path, run, 'fs.writeFileSync("times.bin", run.m.times.data);')
    assert np.fromfile(tmp_path / "times.bin").tolist() == run.t_eval.tolist()


def test_equal_steps_of_another_method(tmp_path):
    said, run = (by(new("squeezer", "rk4", 0.004)) for by in (lambda one: in_node(tmp_path, one), by_machine_code))
    assert said["statistics"] == run["statistics"]
    assert apart(run["rows"], said["rows"]) < 1e-9


OVER_TIME = """
format = 1
gravity = [0, "-9.81 - 3*step(t - 0.1)"]
ground.points = { O = [0, 0], A = [0.4, "0.02*sin(w*t)"] }
parameters.w = 5.0
bodies.crank = { bar = ["O", "B"], length = 0.1, mass = 1 }
bodies.rod = { bar = ["B", "C"], length = 0.35, mass = 1 }
bodies.rocker = { bar = ["C", "A"], length = 0.25, mass = 1 }
joints.O = { type = "revolute", connect = ["ground.O", "crank.O"] }
joints.B = { type = "revolute", connect = ["crank.B", "rod.B"] }
joints.C = { type = "revolute", connect = ["rod.C", "rocker.C"] }
joints.A = { type = "revolute", connect = ["ground.A", "rocker.A"], clearance = "0.2 mm", contact = CONTACT }
drivers.m = { joint = "O", speed = "w if t < 0.2 else 2*w" }
initial.crank = { angle = 0.7 }
"""


def test_speeds_and_moving_ground_under_changing_gravity(tmp_path):
    m = rt.loads(OVER_TIME.replace("CONTACT", '{ model = "impact", restitution = 0.3 }'))
    said, run = in_node(tmp_path, new(m, t_end=0.4)), by_machine_code(new(m, t_end=0.4))
    assert said["success"]
    assert said["statistics"]["steps"] == run["statistics"]["steps"]
    assert [one["kind"] for one in said["events"]] == run["events"][:, 2].tolist()
    assert apart(run["rows"], said["rows"]) < 1e-6
    assert len(run["jolts"]) == 1


LEVER = """
format = 1
[ground.points]
A = [0, 0]
[bodies.lever]
bar = ["A", "B"]
length = 0.3
mass = 1
[joints.A]
type = "revolute"
connect = ["ground.A", "lever.A"]
[drivers.motor]
joint = "A"
angle = "3*max(0, t - 0.2)"
"""


@pytest.mark.parametrize("method", [None, "rk4"])
def test_a_driver_that_jumps_makes_a_jolt(method, tmp_path):
    said = in_node(tmp_path, new(rt.loads(LEVER), method, 0.4))
    (jolt,) = said["jolts"]
    assert jolt["t"] == pytest.approx(0.2, rel=1e-12)
    assert jolt["impulse"] == pytest.approx(0.3**2 / 3 * 3.0, rel=1e-12)  # J w of the lever
    assert said["breaks"][:, 0].tolist() == [jolt["t"], jolt["t"]]
    work = said["breaks"][:, -2]
    assert work[1] - work[0] == pytest.approx(0.5 * 0.3**2 / 3 * 3.0**2, rel=1e-12)


WHEEL = """
format = 1
gravity = [0, -9.81]
[ground.points]
O = [0, 0]
[bodies.disc]
points = { C = [0, 0] }
mass = 2
inertia = 0.01
[joints.road]
type = "wheel"
connect = ["ground.O", "disc.C"]
radius = 0.1
friction = 0.2
[initial.disc]
x = 0
vx = 1
omega = 0
"""
CHAIN = """
format = 1
gravity = [0, -9.81]
[ground.points]
O = [0, 0]
[bodies.low]
points = { C = [0, 0] }
mass = 1
inertia = 1
[bodies.high]
points = { C = [0, 0] }
mass = 2
inertia = 1
[joints.floor]
type = "prismatic"
axis = "90 deg"
angle = 0
connect = ["ground.O", "low.C"]
stop.min = 0
stop.contact = { model = "impact", restitution = 0.5, restitution_law = "lzb", stiffness = 3 }
[joints.touch]
type = "prismatic"
axis = "90 deg"
angle = 0
connect = ["low.C", "high.C"]
stop.min = 0.1
stop.contact = { model = "impact", restitution = 0, restitution_law = "lzb", stiffness = 1 }
[initial]
low = { y = 0.2 }
high = { y = 0.3 }
"""


@pytest.mark.parametrize("text", [WHEEL, CHAIN], ids=["wheel that slips", "impacts of a chain"])
def test_models_without_an_example_take_the_steps_of_simulate(text, tmp_path):
    said, run = (by(new(rt.loads(text), t_end=0.5)) for by in (lambda one: in_node(tmp_path, one), by_machine_code))
    assert said["success"]
    assert len(said["events"]) > 0
    assert [one["kind"] for one in said["events"]] == run["events"][:, 2].tolist()
    assert apart(run["rows"], said["rows"]) < 1e-9


def test_jams_are_passed_at_the_same_places(tmp_path):
    said, run = (
        in_node(tmp_path, new(loose_parallelogram(1e-3, 0.3), t_end=1.0)),
        new(loose_parallelogram(1e-3, 0.3), t_end=1.0),
    )
    run.go()
    course = run.workspace.course
    assert len(said["jams"]) == course[at.JAMS] > 0
    assert said["jams"][0] == pytest.approx(course[at.FIRST_JAM], rel=1e-6)


def test_a_run_in_slices_is_that_run(tmp_path):
    whole = in_node(tmp_path, new("fourbar_onesided"))
    steps = "let n = 0; run.N.CHUNK = 3; while (!run.advance(0)) n += 1; if (n < 20) throw new Error(n);"
    assert (in_node(tmp_path, new("fourbar_onesided"), steps)["rows"] == whole["rows"]).all()


def test_a_run_that_is_stopped_holds_what_was_computed(tmp_path):
    steps = "let n = 0; run.N.CHUNK = 20; run.advance(Infinity, () => ++n >= 3);"
    said = in_node(tmp_path, new("fourbar"), steps)
    assert (said["success"], said["statistics"]["steps"]) == (False, 60)
    assert 0 < said["outputs"] < 2001


def test_steps_may_be_limited(tmp_path):
    steps = "run.mostSteps = 2500; if (!run.advance()) throw new Error('it goes on');"
    said = in_node(tmp_path, new("fourbar"), steps)
    assert (said["success"], said["statistics"]["steps"]) == (False, 2500)


def test_a_state_that_is_no_number_ends_a_run(tmp_path):
    run = new("fourbar_onesided")
    run.workspace.state[:] = np.nan
    said = in_node(tmp_path, run)
    assert (said["success"], said["statistics"]["steps"]) == (False, 0)


# ---------------------------------------------------------------- bit for bit
ALIKE = (
    *("bouncing_pin", "gear_rattle", "fourbar_onesided", "slider_crank_oil", "slider_crank_play", "double_pendulum"),
    *(
        "fourbar",
        "three_plays",
        "stick_slip",
        "dc_motor_pid",
        "torque_converter",
        "stribeck",
        "windows",
        "cam_lift_off",
    ),
)
SAME_BITS = """
import json, sys
from pathlib import Path
import core_engine
from core_engine import by_machine_code, in_node, new
core_engine.use_own_functions()
differ = {}
for name in sys.argv[2:]:
    said, run = in_node(Path(sys.argv[1]), new(name)), by_machine_code(new(name))
    events = [[one["t"], one["kind"], *one["values"]] for one in said["events"]]
    same = {
        "statistics": said["statistics"] == run["statistics"],
        "events": events == run["events"][:, [0, 2, 3, 4, 5, 6, 7]].tolist(),
        "rows": (said["rows"] == run["rows"]).all() and said["rows"].shape == run["rows"].shape,
        "breaks": said["breaks"].shape == run["breaks"].shape and (said["breaks"] == run["breaks"]).all(),
        "jolts": [[one["t"], one["impulse"]] for one in said["jolts"]] == run["jolts"],
    }
    if wrong := [what for what, alike in same.items() if not alike]:
        differ[name] = wrong
print(json.dumps(differ))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere machine code calls other functions for sine and cosine")
@pytest.mark.skipif(llvm_version_info[0] < 21, reason="older LLVM writes some powers otherwise for one of the targets")
def test_with_the_same_elementary_functions_every_bit_is_the_same(tmp_path):
    """Machine code calls those of the C library otherwise, whose last bits differ; chaotic motions show it."""
    paths = os.pathsep.join([str(Path(__file__).parents[1]), os.environ.get("PYTHONPATH", "")])
    done = subprocess.run(
        [sys.executable, "-c", SAME_BITS, tmp_path, *ALIKE],
        env={**os.environ, "PYTHONPATH": paths}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == {}
