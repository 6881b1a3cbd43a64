"""Models as programs: what `rattle code` writes compiles without a warning and moves as `simulate` does."""

import io
import json
import os
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import rattle as rt
from rattle.cli.main import main

needs_node = pytest.mark.skipif(shutil.which("node") is None, reason="no node")
needs_cc = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
STRICT = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-O1"]


def written(tmp_path, *words, name="model.c"):
    return CliRunner().invoke(main, ["code", *words, "-o", str(tmp_path / name)])


def compiled(folder):
    subprocess.run(["cc", *STRICT, "model.c", "-o", "model", "-lm"], cwd=folder, check=True, timeout=300)


def motion(tmp_path, *times):
    """The compiled program's CSV: names and rows."""
    done = subprocess.run([tmp_path / "model", *times], capture_output=True, text=True, check=True, timeout=60)
    return done.stdout.split("\n")[0].split(","), np.genfromtxt(io.StringIO(done.stdout), delimiter=",")[1:]


def require_motion(m, names, rows, step):
    """Rows of a program are those of the package; what is left is rounding, and how the motion amplifies it."""
    run = m.simulate(t_eval=rows[:, 0], method="rk4", step=step)
    assert set(names) <= set(run.names)
    largest: dict[str, float] = {}  # of all curves of one unit: what rounding of a small one is measured by
    for name in names:
        largest[run.unit(name)] = max(largest.get(run.unit(name), 0.0), float(np.abs(run[name]).max()))
    for k, name in enumerate(names, 1):
        scale = largest[run.unit(name)]
        assert np.abs(rows[:, k] - run[name]).max() <= 1e-10 * scale, name


SAME_METHOD = [
    ("fourbar", 0.02, 1e-5, {"r3": 0.003, "l1": 0.18, "alpha": 1.1, "M": -20.0}),
    ("slider_crank", 0.02, 1e-5, {"crank_length": 0.06, "rod_length": 0.17, "speed": 200.0}),  # in pieces
    pytest.param("five_bar", 0.05, 1e-4, {"a": 0.205, "f": 0.31, "size": 0.005}, marks=pytest.mark.long),
    pytest.param("double_pendulum", 0.5, 1e-4, {"lower_length": 0.32, "start": 0.9}, marks=pytest.mark.long),
    ("windows", 0.1, 1e-4, {"l": 0.9, "speed": 3.0}),
]


@needs_cc
@pytest.mark.parametrize(("example", "span", "step", "change"), SAME_METHOD)
def test_the_program_moves_as_the_same_method_in_the_package(example, span, step, change, tmp_path):
    """With the parameters of the model and with others: same steps, same method."""
    done = written(tmp_path, example)
    assert done.exit_code == 0, done.output
    compiled(tmp_path)
    for p in ({}, change):
        names, rows = motion(tmp_path, str(span), str(step), *(f"{name}={x!r}" for name, x in p.items()))
        assert names[0] == "t"
        assert rows[-1, 0] == pytest.approx(span, rel=1e-15)
        m = rt.example(example)
        require_motion(m.set(p), names[1:], rows, step)


@needs_cc
@pytest.mark.nojit
def test_options_of_the_compiler_do_not_change_a_bit(tmp_path):
    """Not even where the machine has fused operations and the compiler may use them; -ffast-math is refused."""
    assert written(tmp_path, "fourbar").exit_code == 0
    said = set()
    for options in (["-std=c99", "-O1"], ["-std=gnu17", "-O3"], ["-std=gnu17", "-O3", "-march=native"]):
        done = subprocess.run(["cc", *options, "model.c", "-o", "model", "-lm"], cwd=tmp_path, timeout=300, check=False)
        if done.returncode == 0:  # a compiler need not know -march
            run = subprocess.run([tmp_path / "model", "0.05", "1e-4"], capture_output=True, check=True, timeout=60)
            said.add(run.stdout)
    assert len(said) == 1
    done = subprocess.run(["cc", "-ffast-math", "model.c", "-lm"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode != 0
    assert "compile without -ffast-math" in done.stderr


@needs_node
@pytest.mark.parametrize(("example", "span", "step", "change"), SAME_METHOD[:2])
def test_the_module_moves_as_the_same_method_in_the_package(example, span, step, change, tmp_path):
    assert written(tmp_path, example, name="model.mjs").exit_code == 0
    names, rows = in_node(tmp_path, f"m.names, m.run({span}, {step}, {{ ...m.parameters, ...{json.dumps(change)} }})")
    require_motion(rt.example(example).set(change), names[1:], np.array(rows), step)


def in_node(folder, values):
    """Values of a JavaScript expression list with the module model.mjs as m; an Error is its message."""
    script = f"""
import * as m from "./model.mjs";
const said = (f) => {{ try {{ return f(); }} catch (error) {{ return error.message; }} }};
console.log(JSON.stringify([{values}]));
"""
    (folder / "script.mjs").write_text(script, encoding="utf-8")
    done = subprocess.run(["node", "script.mjs"], cwd=folder, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@needs_node
@pytest.mark.nojit
def test_what_is_no_number_is_no_parameter(tmp_path):
    """Where JavaScript makes a zero of it, or does not look at it, the motion would be that of other parameters."""
    assert written(tmp_path, "fourbar", name="model.mjs").exit_code == 0
    given = ["{ M: '' }", "{ M: ' ' }", "{ M: null }", "{ M: true }", "{ M: [3] }", "{ M: undefined }", "{ M: 'x' }"]
    said = in_node(tmp_path, ", ".join(f"said(() => m.start({one}))" for one in given))
    assert said == ["M: expected a finite number, not NaN"] * len(given)
    given = ["new Map([['M', 3]])", "5", "'M'", "true"]
    said = in_node(tmp_path, ", ".join(f"said(() => m.start({one}))" for one in given))
    assert said == ["p: an object of parameters, an array of all of them, or nothing expected"] * len(given)
    text, number = in_node(tmp_path, "[...m.start({ r3: '0.003' })], [...m.start({ r3: 0.003 })]")
    assert text == number


NO_START = [
    ({"r3": 0.02}, "r3 = 0.02 is outside of its limits, 0.0005 to 0.01 m"),
    ({"l1": -0.1}, "l1 = -0.1 is outside of its limits, 0.1 to 0.25 m"),
]


@needs_cc
@needs_node
@pytest.mark.nojit
def test_parameters_without_a_start_are_refused_in_the_same_words(tmp_path):
    assert written(tmp_path, "fourbar").exit_code == 0
    assert written(tmp_path, "fourbar", name="model.mjs").exit_code == 0
    compiled(tmp_path)
    said = in_node(tmp_path, ", ".join(f"said(() => m.start({json.dumps(change)}))" for change, _ in NO_START))
    for (change, why), text in zip(NO_START, said, strict=True):
        assert why in text
        words = [f"{name}={x!r}" for name, x in change.items()]
        done = subprocess.run([tmp_path / "model", *words], capture_output=True, text=True, timeout=60)
        assert (done.returncode, done.stdout, done.stderr) == (1, "", f"{text}\n")
    for word in ("l9=1", "l1=", "l1=2 m", "=1", "l1=nan"):
        done = subprocess.run([tmp_path / "model", word], capture_output=True, text=True, timeout=60)
        assert done.returncode == 2
        assert f"{word}: expected a parameter and its value in SI units" in done.stderr
        assert "  r3=0.005 m\n" in done.stderr


LINKAGE = """
format = 1
[parameters]
double = "0.2 m"
new = { value = "0.5 m", min = "in_least" }
in_least = "0.1 m"
function = "1.2*double + 0.3*NAN"
NAN = "0.4 m"
__proto__ = "40 deg"
if_ = 3
[ground.points]
O = [0, 0]
C = ["double + new", "0.7*double"]
[bodies.int]
bar = ["O", "A"]
length = "double"
mass = 1
[bodies.var]
bar = ["A", "B"]
length = "new"
mass = 2
[bodies.switch]
bar = ["B", "C"]
length = "function"
mass = 1
[joints.O]
type = "revolute"
connect = ["ground.O", "int.O"]
[joints.A]
type = "revolute"
connect = ["int.A", "var.A"]
[joints.B]
type = "revolute"
connect = ["var.B", "switch.B"]
[joints.C]
type = "revolute"
connect = ["switch.C", "ground.C"]
[loads.long]
type = "torque"
body = "int"
torque = "if_*sin(20*t)"
[initial]
int = { angle = "__proto__", omega = 2 }
"""


@needs_cc
@needs_node
@pytest.mark.nojit
def test_words_of_c_and_javascript_are_names_like_others(tmp_path):
    (tmp_path / "linkage.toml").write_text(LINKAGE)
    m = rt.load(tmp_path / "linkage.toml")
    assert written(tmp_path, str(tmp_path / "linkage.toml")).exit_code == 0
    assert written(tmp_path, str(tmp_path / "linkage.toml"), name="model.mjs").exit_code == 0
    change = {"double": 0.21, "NAN": 0.42, "if_": 4.0}
    compiled(tmp_path)
    names, rows = motion(tmp_path, "0.1", "1e-3", *(f"{name}={x!r}" for name, x in change.items()))
    got = in_node(tmp_path, f"m.names, m.run(0.1, 1e-3, {json.dumps(change)}), Object.keys(m.parameters)")
    assert got[0] == names
    np.testing.assert_array_equal(np.array(got[1]), rows)
    assert got[2] == ["double", "new", "in_least", "NAN", "__proto__", "if_"]  # `function` follows from others
    other = m.set(change)
    start = dict(zip(names, rows[0], strict=True))
    for k, body in enumerate(("int", "var", "switch")):
        assert start[f"{body}.angle"] == pytest.approx(other.start.q[3 * k + 2], abs=1e-13)
        assert start[f"{body}.omega"] == pytest.approx(other.start.v[3 * k + 2], abs=1e-12)


@needs_node
@pytest.mark.nojit
def test_the_head_of_the_file_says_which_parameters_are_fixed_and_why(tmp_path):
    (tmp_path / "linkage.toml").write_text(LINKAGE)
    assert written(tmp_path, str(tmp_path / "linkage.toml"), name="model.mjs").exit_code == 0
    assert "Fixed parameters: function (it follows from NAN, double)" in (tmp_path / "model.mjs").read_text()
    limits, said = in_node(tmp_path, "m.sliders[1], said(() => m.start({ function: 1 }))")
    assert limits == {"name": "new", "value": 0.5, "unit": "m", "min": 0.1, "max": None}
    assert "no parameter 'function'" in said
    assert written(tmp_path, "fourbar", name="model.mjs").exit_code == 0
    start = in_node(tmp_path, "...m.start({ l2: 0.61 })")
    curves = rt.example("fourbar").set(l2=0.61).simulate(1e-9)
    wanted = [
        float(curves[f"{body}.{key}"][0]) for body in ("crank", "coupler", "rocker") for key in ("x", "y", "angle")
    ]
    assert start[:9] == pytest.approx(wanted, abs=1e-12)  # one length alone: put together as the package does
    done = written(tmp_path, "path_generator", name="model.mjs")
    assert done.exit_code == 0
    assert "note: omega stays fixed: the start does not follow from given values alone" in done.stderr
    text = (tmp_path / "model.mjs").read_text()
    assert "Fixed parameters: a, c, c_q, omega (the start does not follow from given values alone" in text
    assert in_node(tmp_path, "m.parameters") == [{}]


@needs_cc
def test_the_program_says_what_it_takes_and_where_it_cannot_go_on(tmp_path):
    assert written(tmp_path, "double_pendulum").exit_code == 0
    compiled(tmp_path)
    motion(tmp_path, "0.1")
    for words in (["-1"], ["0.1", "0"], ["x"], ["20ms"], ["inf", "inf"], ["0.1", "1e-4", "3"]):
        done = subprocess.run([tmp_path / "model", *words], capture_output=True, text=True, timeout=60)
        assert done.returncode == 2
        assert "t_end" in done.stderr
    # a step of a second tears the pendulum's joints apart
    done = subprocess.run([tmp_path / "model", "20", "1"], capture_output=True, text=True, timeout=60)
    assert done.returncode == 1
    assert "choose a shorter one" in done.stderr or "singular position" in done.stderr


@needs_cc
@pytest.mark.nojit
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is full")
def test_a_motion_that_cannot_be_written_is_a_failure(tmp_path):
    assert written(tmp_path, "double_pendulum").exit_code == 0
    compiled(tmp_path)
    with open("/dev/full", "w") as full:
        done = subprocess.run([tmp_path / "model", "0.1"], stdout=full, stderr=subprocess.PIPE, text=True, timeout=60)
    assert (done.returncode, done.stderr) == (1, "the motion could not be written completely\n")


@pytest.mark.nojit
def test_what_has_no_straight_line_is_refused_with_the_reason(tmp_path):
    done = written(tmp_path, "woodpecker")
    assert done.exit_code == 2
    assert "contacts begin and end" in done.stderr
    assert "joints lower, upper, beak" in done.stderr
    done = written(tmp_path, "fourbar", "--set", "drivers.motor.angle=abs(t - 0.01)")
    assert done.exit_code == 2
    assert "drivers.motor" in done.stderr
    assert "smooth function" in done.stderr
    assert not list(tmp_path.iterdir())


@pytest.mark.nojit
def test_a_name_that_cannot_be_written_is_refused_before_anything_else(tmp_path):
    for name in ("model.py", "model", "model.C"):
        done = written(tmp_path, "fourbar", name=name)
        assert done.exit_code == 2
        assert "expected a name that ends in .c (C99 program), .js (ES module)" in done.stderr
    done = written(tmp_path, "fourbar", name="none/model.js")
    assert done.exit_code == 2
    assert "create it first" in done.stderr
    (tmp_path / "shut").mkdir(mode=0o500)
    if not os.access(tmp_path / "shut", os.W_OK):  # for the superuser every folder is open
        done = written(tmp_path, "fourbar", name="shut/model.js")
        assert done.exit_code == 2
        assert "no permission to write in the folder" in done.stderr


@pytest.mark.nojit
@pytest.mark.parametrize("example", ["scotch_yoke", "guide_play", "slider_crank_play", "bouncing_pin", "three_plays"])
def test_with_its_play_closed_a_mechanism_with_contacts_is_written(example, tmp_path):
    done = written(tmp_path, example, "--ideal")
    assert done.exit_code == 0, done.output
    assert (tmp_path / "model.c").stat().st_size > 5_000


@pytest.mark.nojit
def test_the_head_of_the_file_names_every_column_with_its_unit(tmp_path):
    assert written(tmp_path, "slider_crank").exit_code == 0
    text = (tmp_path / "model.c").read_text()
    for name in ("crank.omega [rad/s]", "O.fx [N]", "energy.kinetic [J]", "motor.torque [N*m]"):
        assert f"     {name}\n" in text


FREE = """
format = 1
[bodies.a]
points = { P = [0.2, 0] }
mass = 1
inertia = 0.1
[initial]
a = { vx = 1, omega = 2 }
[ground.points]
O = [0, 0]
[loads.m]
"""


@needs_cc
@pytest.mark.parametrize(
    ("load", "times", "why"),
    [
        ('type = "torque"\nbody = "a"\ntorque = "sqrt(0.1 - t)"', ["0.2", "0.002"], "no finite value"),
        ('type = "spring"\nconnect = ["ground.O", "a.P"]\nstiffness = 5e5', ["0.2", "0.002"], "energy error"),
    ],
)
def test_the_program_stops_where_a_run_does(load, times, why, tmp_path):
    (tmp_path / "free.toml").write_text(FREE + load)
    assert written(tmp_path, str(tmp_path / "free.toml")).exit_code == 0
    compiled(tmp_path)
    motion(tmp_path, "0.0001", "0.00001")
    done = subprocess.run([tmp_path / "model", *times], capture_output=True, text=True, timeout=60)
    assert done.returncode == 1
    assert why in done.stderr
    assert "nan" not in done.stdout


# ---------------------------------------------------------------- the page of the guide
GUIDE = (Path(__file__).parents[2] / "docs" / "programs.md").read_text(encoding="utf-8")
BROWSER = """
const elements = {}, drawn = [], listeners = {};
let frame = null;
const point = (kind) => (...at) => drawn.push([kind, ...at]);
const context = { clearRect: () => drawn.splice(0), beginPath() {}, stroke() {}, moveTo: point("from"),
  lineTo: point("to"), fillText: (text) => (elements.text = text) };
globalThis.document = { getElementById: (id) =>
  (elements[id] ??= { getContext: () => context, addEventListener: (name, call) => (listeners[name] = call) }) };
globalThis.requestAnimationFrame = (call) => (frame = call);
await import("./page.mjs");
const show = (later) => (frame(performance.now() + later), drawn.map((one) => [...one]));
const shown = [show(0), show(1000)];
elements.play.value = "0.002";
listeners.change();
shown.push(show(1000));
elements.play.value = "0.02";
listeners.change();
console.log(JSON.stringify({ shown, said: elements.said.textContent, min: elements.play.min }));
"""


@needs_node
@pytest.mark.nojit
def test_the_page_of_the_guide_draws_the_mechanism_and_follows_its_slider(tmp_path):
    (page,) = re.findall(r"```html\n(.*?)```", GUIDE, re.DOTALL)
    (script,) = re.findall(r'<script type="module">\n(.*?)</script>', page, re.DOTALL)
    assert written(tmp_path, "fourbar", name="fourbar.js").exit_code == 0
    (tmp_path / "package.json").write_text('{"type": "module"}')
    (tmp_path / "page.mjs").write_text(script, encoding="utf-8")
    (tmp_path / "browser.mjs").write_text(BROWSER, encoding="utf-8")
    done = subprocess.run(["node", "browser.mjs"], cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    got = json.loads(done.stdout)
    assert got["min"] == 0.0005
    assert "r3 = 0.02 is outside of its limits" in got["said"]
    for picture, play in zip(got["shown"], (5e-3, 5e-3, 2e-3), strict=True):
        ends = np.array([one[1:] for one in picture]).reshape(3, 2, 2) / 560.0  # [m]
        assert np.hypot(*(ends[:, 1] - ends[:, 0]).T) == pytest.approx([0.2, 0.6, 0.6], abs=1e-9)
        assert np.hypot(*(ends[2, 0] - ends[1, 1])) == pytest.approx(play, abs=1e-9)
    first, second, _ = (np.array([one[1:] for one in picture]) for picture in got["shown"])
    assert np.abs(second - first).max() > 50.0  # pixels


@needs_cc
@pytest.mark.nojit
def test_the_c_program_of_the_guide_calls_the_functions_of_the_file(tmp_path):
    """The driven crank turns as its driver says, whatever the steps."""
    (text,) = re.findall(r"```c\n(.*?)```", GUIDE, re.DOTALL)
    (tmp_path / "own.c").write_text(text, encoding="utf-8")
    assert written(tmp_path, "fourbar", name="fourbar.c").exit_code == 0
    subprocess.run(["cc", *STRICT, "own.c", "-o", "own", "-lm"], cwd=tmp_path, check=True, timeout=300)
    done = subprocess.run([tmp_path / "own"], capture_output=True, text=True, check=True, timeout=60)
    y = [float(line) for line in done.stdout.split()]
    assert len(y) == 6 * 3 + 2
    assert y[2] == pytest.approx(10.0 * 0.1, abs=1e-9)


needs_node = pytest.mark.skipif(shutil.which("node") is None, reason="no node")
ASK = """
import { run, names, units } from "./model.mjs";
const said = run(%s);
console.log(JSON.stringify({ ...said, names, units }));
"""


def asked(folder, end):
    (folder / "ask.mjs").write_text(ASK % end)
    done = subprocess.run(["node", "ask.mjs"], cwd=folder, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@needs_node
@pytest.mark.parametrize(("name", "end"), [("woodpecker", 0.1), ("fourbar_onesided", 0.02), ("gear_rattle", 0.02)])
def test_a_module_with_contacts_takes_the_steps_and_events_of_a_run(tmp_path, name, end):
    done = written(tmp_path, name, "--t-end", f"{end} s", name="model.mjs")
    assert done.exit_code == 0, done.stderr
    assert "the file holds compiled kernels" in done.stderr
    said, r = asked(tmp_path, end), rt.example(name).simulate(end)
    assert (said["success"], said["message"]) == (True, "")
    events = r.events
    assert [(one["joint"], one["kind"]) for one in said["events"]] == [(one.joint, one.kind) for one in events]
    assert [one["t"] for one in said["events"]] == pytest.approx([one.t for one in events], abs=1e-9)
    assert [one["impulse"] for one in said["events"]] == pytest.approx([one.impulse for one in events], rel=1e-5)
    table = np.array(said["rows"])
    assert said["names"] == ["t", *r.names]
    for name, unit, values in zip(said["names"][1:], said["units"][1:], table.T[1:], strict=True):
        assert unit == r.unit(name)
        assert values == pytest.approx(r[name], rel=1e-4, abs=1e-4 * max(np.abs(r[name]).max(), 1e-3)), name


@needs_node
def test_a_module_with_contacts_prints_its_motion_and_refuses_what_is_no_end(tmp_path):
    assert written(tmp_path, "bouncing_pin", "--t-end", "10 ms", name="model.mjs").exit_code == 0
    done = subprocess.run(["node", "model.mjs", "0.005"], cwd=tmp_path, capture_output=True, text=True, timeout=60)
    head, *rows = done.stdout.splitlines()
    assert head.startswith("t,")
    assert float(rows[-1].split(",")[0]) == pytest.approx(0.005)
    done = subprocess.run(["node", "model.mjs", "soon"], cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.startswith("tEnd = NaN: a time above 0 is expected")


@needs_node
def test_a_module_names_events_as_a_run_does_and_runs_again_alike(tmp_path):
    assert written(tmp_path, "torque_converter", name="model.mjs").exit_code == 0
    ask = 'import { run } from "./model.mjs";\nconsole.log(JSON.stringify([run(0.05), run(0.05), run()]));\n'
    (tmp_path / "my_model.mjs").write_text(ask)
    done = subprocess.run(["node", "my_model.mjs"], cwd=tmp_path, capture_output=True, text=True, timeout=60)
    short, again, whole = json.loads(done.stdout)  # importing prints nothing
    assert short == again
    assert 0.049 < short["rows"][-1][0] <= 0.05
    assert all(one["t"] + one["duration"] <= 0.05 * (1.0 + 1e-12) for one in short["events"])
    r = rt.example("torque_converter").simulate()
    assert [(one["joint"], one["kind"]) for one in whole["events"]] == [(one.joint, one.kind) for one in r.events]
    assert {"lock", "free"} <= {one["kind"] for one in whole["events"]}


@needs_node
def test_a_module_whose_motion_cannot_go_on_says_why(tmp_path):
    (tmp_path / "m.toml").write_text(PULSE)
    done = written(tmp_path, str(tmp_path / "m.toml"), name="model.mjs")
    assert done.exit_code == 0, done.stderr
    said = asked(tmp_path, 1)
    assert not said["success"]
    assert "cannot go on at t = " in said["message"]
    assert said["rows"]


PULSE = """
format = 1
gravity = [0, 0]
[ground.points]
O = [0, 0]
[bodies.b]
points = { P = [0, 0] }
mass = 1
inertia = 1
[joints.O]
type = "revolute"
connect = ["ground.O", "b.P"]
clearance = "1 mm"
contact = "impact"
[loads.f]
type = "force"
at = "b.P"
force = ["sqrt(0.5 - t)", 0]
[simulate]
t_end = 1
"""
