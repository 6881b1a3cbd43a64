"""What a page says of rare runs is what Python says: jams, locks, forces that are not unique, jolts, oil, ends."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from llvmlite.binding import llvm_version_info

import rattle as rt
from browsing import shows
from rattle.pages.page import page

NUMBER = re.compile(r"[-+]?\d[\d.]*(e[-+]?\d+)?")
ROD = """
gravity = [0, -10]
ground.points = { O = [0, 0] }
bodies.rod = { points = { P = [0.6, -0.8] }, mass = 1, inertia = 0.01 }
initial.rod = { x = 0, y = -0.1999, angle = 0, vx = -3, vy = 0, omega = 0 }
[joints.tip]
type = "prismatic"
connect = ["ground.O", "rod.P"]
axis = 0
angle = 0
clearance = 1
block = { length = 1e-4, height = 1e-4 }
contact = { model = "impact", restitution = 0, friction = 3, jam = "impact" }
"""
PIN = """
ground.points = { O = [0, 0] }
bodies.pin = { points = { P = [0, 0] }, mass = 20.0, inertia = 1e-3 }
drivers.spin = { body = "pin", coordinate = "angle", angle = "3000.0*t" }
initial = { pin = { angle = 0, vx = 0.0, vy = 0.0 }, O = { offset = [4e-05, 0.0] } }
[joints.O]
type = "revolute"
connect = ["ground.O", "pin.P"]
clearance = 5e-05
[joints.O.contact]
model = "lubricated"
film = "finite"
viscosity = 0.0001
length = 0.01
bush_radius = 0.01
boundary_film = 2e-5
"""
HANGING = """
gravity = [0, -9.81]
ground.points = { O = [0, 0] }
bodies.crank = { bar = ["O", "A"], length = 0.3, mass = 1.0 }
bodies.rod = { bar = ["A", "B"], length = 0.4, mass = 2.0 }
joints.O = { type = "revolute", connect = ["ground.O", "crank.O"] }
joints.A = { type = "revolute", connect = ["crank.A", "rod.A"], clearance = 0.001, contact = "impact" }
drivers.motor = { joint = "O", angle = "3.0*max(0, t - 0.2)" }
[initial]
rod = { angle = -1.5707963267948966, omega = 0.0 }
A = { offset = [0.0, -0.001] }
"""
BLOCK = """
gravity = [0, -9.81]
ground.points = { O = [0, 0] }
bodies.block = { points = { C = [0, 0] }, mass = 1, inertia = 1 }
joints.guide = { type = "prismatic", connect = ["ground.O", "block.C"], angle = 0, friction = 0.3 }
joints.other = { type = "prismatic", connect = ["ground.O", "block.C"], angle = 0 }
initial.block = { x = 0, vx = 1 }
"""
DISC = """
gravity = [0, -9.81]
ground.points = { C = [0, 0] }
bodies.disc = { points = { C = [0, 0] }, mass = 2, inertia = 0.1 }
loads.wind = { type = "torque", body = "disc", torque = "-0.1 + 0.7*step(t - 2)" }
initial.disc = { angle = 0.1, omega = -1 }
[joints.pin]
type = "revolute"
connect = ["ground.C", "disc.C"]
friction = { mu = 0.3, pin_radius = "50 mm" }
stop = { min = 0 }
"""
POLE = """
gravity = [0, -9.81]
ground.points = { O = [0, 0] }
bodies.rod = { points = { P = [0.5735764363510462, -0.8191520442889918] }, mass = 1, inertia = 0.3333333333333333 }
initial.rod = { x = 0, y = -1.180847955711008, angle = 0, vx = 1.0, vy = 0, omega = 0 }
[joints.tip]
type = "prismatic"
connect = ["ground.O", "rod.P"]
axis = 0
angle = 0
clearance = 2
block = { length = 1e-4, height = 1e-4 }
contact = { model = "impact", friction = 1.6 }
"""
LIGHT = """
ground.points = { O = [0, 0], Q = [0.4, 0] }
bodies.crank = { bar = ["A", "B"], length = 0.1, mass = 1 }
bodies.coupler = { bar = ["B", "C"], length = 0.35, mass = 1e-9 }
bodies.rocker = { bar = ["C", "D"], length = 0.25, mass = 1 }
joints.O = { type = "revolute", connect = ["ground.O", "crank.A"] }
joints.B = { type = "revolute", connect = ["crank.B", "coupler.B"] }
joints.C = { type = "revolute", connect = ["coupler.C", "rocker.C"] }
joints.Q = { type = "revolute", connect = ["rocker.D", "ground.Q"] }
initial.crank = { angle = "60 deg", omega = 10 }
"""
BELT = (Path(rt.__file__).parent / "examples" / "belt_drive.toml").read_text().replace("toothed = true", "")
LINK = HANGING.replace('"impact"', '"massless-link"').replace("3.0*max", "0.1*t + 3.0*max")
RARE = {  # model, end [s], and what must be among the words
    "jams": (ROD, 0.5, "friction locked contacts (Painleve), passed by"),
    "lock": (ROD.replace(', jam = "impact"', ""), 0.5, "friction locks 'tip'"),
    "nearly": (ROD, 0.5, "where friction nearly locks tip"),
    "oil": (PIN, 1e-5, "the film is not laminar"),
    "thin": (PIN, 1e-5, "thinner than its boundary film"),
    "jolt": (HANGING, 0.25, "driver 'motor' jumps in speed by"),
    "swift": (LINK, 0.21, "this is not credible"),
    "not unique": (BLOCK, 0.01, "friction by a reaction that is not unique"),
    "shared": (DISC, 3.0, "can share a force at joint 'pin'"),
    "slips": (BELT.replace("format = 1", ""), 1.5, "would slip, first at"),
    "light": (LIGHT, 0.05, "masses of bodies differ by too many orders of magnitude"),
    "no solution": (POLE, 0.001, "has no solution"),
}
COMPARED = """
import json, sys
from pathlib import Path
import core_engine
from core_engine import in_node, new, with_result
import rattle as rt
from browsing import shows
from rattle.pages.page import page
from rattle.analyses.dynamics import soundness
from rattle.analyses.dynamics.horizon import Reach
from rattle.analyses.dynamics.methods import note_choice
from rattle.analyses.dynamics.report import report
from rattle.jit import layout as at
from rattle.results.contact_summary import contact_lines
core_engine.use_own_functions()
soundness.SWIFT = 0.01  # whatever moves turns incredibly fast
STEPS = '''run.advance();
  const { resultOf } = await import("%s/core_result.js"), { trusted } = await import("%s/trust_words.js");
  %s
  const { trust, message } = resultOf(run, data, functions);
  const reach = { horizon: trust.t_end, horizon_motion: trust.t_end, pending: false };
  const words = trusted({ ...trust, ...reach }, data.told.sentences.trust);
  fs.writeFileSync("words.json", JSON.stringify({ ...words, message }));
''' % (core_engine.VIEWER.as_uri(), core_engine.VIEWER.as_uri(), core_engine.RESULT)
folder, told = Path(sys.argv[1]), {}
for name, (text, end, _) in json.loads(sys.stdin.read()).items():
    m = rt.loads("format = 1\\n" + text)
    with_result(folder, m, end)
    run, words = new(m, t_end=end), in_node(folder, new(m, t_end=end), STEPS)
    run.notes = note_choice(run.system, None, run.stepper)
    run.go()
    reached = float(run.clock[at.T])
    want = report(run, Reach(reached, "", reached))
    page = words if "error" in words else json.loads((folder / "words.json").read_text())
    lines = [*page["text"], page["word"], *page["contacts"], page["message"]] if "text" in page else [page["error"]]
    told[name] = lines, [*str(want.trust).splitlines(), want.trust.word, *contact_lines(want), want.message]
print(json.dumps(told))
"""
pytestmark = [
    pytest.mark.skipif(shutil.which("node") is None, reason="no node"),
    pytest.mark.skipif(sys.platform != "linux", reason="elsewhere machine code calls other functions for sine"),
    pytest.mark.skipif(llvm_version_info[0] < 21, reason="older LLVM writes some powers otherwise"),
]


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    """Lines of the page and of Python, by run."""
    paths = os.pathsep.join([str(Path(__file__).parents[1]), os.environ.get("PYTHONPATH", "")])
    done = subprocess.run(
        [sys.executable, "-c", COMPARED, tmp_path_factory.mktemp("rare")], input=json.dumps(RARE), text=True,
        env={**os.environ, "PYTHONPATH": paths}, capture_output=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.mark.parametrize("name", RARE)
def test_a_page_says_of_a_rare_run_what_python_says(name, told):
    page, python = ([NUMBER.sub("#", line) for line in lines] for lines in told[name])
    assert page == python
    assert any(RARE[name][2] in line for line in told[name][0])


def test_a_page_doubts_forces_of_rigid_contacts_that_tower(open_page, tmp_path):
    """Their contacts have impulses: a largest force would be the number of a step."""
    assert page(rt.example("three_plays"), tmp_path / "page.html") == ""
    tab = open_page((tmp_path / "page.html").as_uri())
    shows(tab.locator(".trust .lines p", has_text="not the largest forces of B, C, D"))
    assert tab.locator(".trust .badge").text_content() == "With limits"
    assert tab.evaluate("rattle.trust.unread") == ["B", "C", "D"]
    assert {event["peak_force"] for event in tab.evaluate("rattle.events") if event["kind"] == "contact"} == {None}
