"""Models as ES modules: the bits of the reference in node, the motion and the messages of the C program."""

import io
import json
import shutil
import subprocess

import numpy as np
import pytest
from test_graph import everything, numbers

import rattle as rt
from rattle.analyses.straight_line.code import c_program, javascript_module, program
from rattle.analyses.straight_line.starts import Starts
from rattle.trace import elementary, javascript
from rattle.trace.graph import Graph
from rattle.trace.program import Begin, Input, Program

pytestmark = [pytest.mark.nojit, pytest.mark.plain, pytest.mark.skipif(shutil.which("node") is None, reason="no node")]
SMOOTH = [
    "balanced_arm", "chain", "double_pendulum", "five_bar", "fourbar", "path_generator", "quick_return",
    "slider_crank", "squeezer", "toggle", "toggle_clamp", "windows",
]  # fmt: skip
MORE = ("chain", "double_pendulum", "path_generator", "quick_return", "slider_crank", "toggle")


def node(folder, script, *words):
    """What a script prints, as JSON; it may import ./model.mjs."""
    (folder / "script.mjs").write_text(script, encoding="utf-8")
    done = subprocess.run(
        ["node", "script.mjs", *words], cwd=folder, capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def computed(folder, name, n_out, inputs):
    """Outputs (n_out, n) of an exported function over arrays, for inputs (n_in, n)."""
    np.ascontiguousarray(inputs.T).astype("<f8").tofile(folder / "in.bin")
    script = f"""
import fs from "node:fs";
import {{ {name} }} from "./model.mjs";
const bytes = fs.readFileSync("in.bin"), all = new Float64Array(new Uint8Array(bytes).buffer);
const n = {inputs.shape[1]}, width = all.length / n, made = new Float64Array(n * {n_out});
for (let k = 0; k < n; k++)
  {name}(all.subarray(k * width, (k + 1) * width), made.subarray(k * {n_out}, (k + 1) * {n_out}));
fs.writeFileSync("out.bin", made);
console.log(n);
"""
    node(folder, script)
    return np.fromfile(folder / "out.bin", dtype="<f8").reshape(inputs.shape[1], n_out).T


def require_same_bits(got, want):
    known = ~np.isnan(want)
    np.testing.assert_array_equal(np.isnan(got), ~known)
    np.testing.assert_array_equal(got[known].view(np.int64), want[known].view(np.int64))


def module_of(made, t_end=0.02, step=1e-4):
    return javascript_module(made, "A model", t_end, step)


@pytest.mark.parametrize("size", [5, 300, 100_000])
def test_every_function_has_the_bits_of_the_reference(size, tmp_path, monkeypatch):
    """However the code is cut into functions."""
    monkeypatch.setattr(javascript, "SIZE", size)
    graph, outputs = everything()
    text = javascript.function(graph, outputs, "straight")
    pieces = -(-graph.count(outputs) // size)
    assert text.count("function ") == pieces + (pieces > 1)  # the last one calls the others
    (tmp_path / "model.mjs").write_text(javascript.BITS + "export { straight };\n" + text)
    inputs = numbers()
    require_same_bits(computed(tmp_path, "straight", len(outputs), inputs), graph.evaluate(outputs, inputs))


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.long if name in MORE else ()) for name in SMOOTH]
)
def test_an_example_has_the_bits_of_the_reference(name, tmp_path):
    """All its functions, at states and parameters near those of the start."""
    made = program(rt.example(name).recorded())
    exported = ", ".join(f"{one}Of" for one in made.functions)
    (tmp_path / "model.mjs").write_text(f"{module_of(made)}\nexport {{ {exported} }};\n", encoding="utf-8")
    inputs = at_random(made)
    for function, outputs in made.functions.items():
        got = computed(tmp_path, f"{function}Of", len(outputs), inputs)
        require_same_bits(got, made.graph.evaluate(outputs, inputs))
        assert function in ("gaps", "correct", "closeRates") or got[-1, 0] == 1.0


def at_random(made, count=5):
    """Inputs t, y, p, E_0 (n, count), the first of them the start of the model."""
    random = np.random.default_rng(7)
    spread = np.append(np.zeros((1, 1)), random.normal(size=(1, count - 1)), 1)
    y = np.array(made.start)[:, None] + 0.02 * spread * random.normal(size=(len(made.start), 1))
    p = np.array([one.value for one in made.parameters])[:, None] * (1.0 + 1e-3 * spread)
    return np.vstack([np.linspace(0.0, 0.3, count), y, p, 0.1 * spread])


CHANGES = {
    "double_pendulum": {"upper_length": 0.38, "start": 1.1},
    "balanced_arm": {},  # no change: the start is that of the model
    "five_bar": {"a": 0.205, "f": 0.31, "size": 0.005},
    "fourbar": {"r3": 0.003, "l1": 0.18, "alpha": 1.1, "M": -20.0},
    "slider_crank": {"crank_length": 0.045, "rod_length": 0.13, "speed": 200.0},
    "windows": {"l": 0.9, "speed": 3.0},
}


def started(folder, name, change):
    """y at t = 0 of the module of an example at changed parameters, and the starts of the recorded model there."""
    model = rt.example(name)
    made = program(model.recorded())
    p = {one.name: one.value for one in made.parameters} | change

    def evaluated(graph, outputs):
        return lambda x, out: np.copyto(out, graph.evaluate(outputs, x))

    starts = Starts(model.recorded(list(p), lanes=False), evaluated)
    (folder / "model.mjs").write_text(module_of(made), encoding="utf-8")
    script = f'import {{ start }} from "./model.mjs"; console.log(JSON.stringify([...start({json.dumps(p)})]));'
    return np.array(node(folder, script)), starts, starts.begin(np.array(list(p.values()))[:, None])


@pytest.mark.parametrize("name", CHANGES)
def test_the_start_has_the_bits_of_the_reference(name, tmp_path):
    got, starts, begun = started(tmp_path, name, CHANGES[name])
    assert not begun.assembled.any()
    if CHANGES[name]:
        np.testing.assert_array_equal(got, begun.y[:, 0])
    else:  # the start of the model itself is that of the assembly
        np.testing.assert_array_equal(got, starts.model.start_state)


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("double_pendulum", {"upper_length": 0.5, "start": -1.5}),
        ("slider_crank", {"crank_length": 0.06, "rod_length": 0.17, "speed": 200.0}),
    ],
)
def test_a_start_far_from_the_model_is_that_of_the_assembly(name, change, tmp_path):
    """Where one run of Newton's method would go too far: the parameters change in pieces."""
    got, _, begun = started(tmp_path, name, change)
    assert begun.assembled.all()
    np.testing.assert_allclose(got, begun.y[:, 0], rtol=0.0, atol=2e-13 * np.abs(begun.y).max())


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
@pytest.mark.parametrize(
    ("name", "t_end", "step"),
    [
        ("fourbar", 0.02, 1e-5),
        ("windows", 0.05, 1e-4),
        pytest.param("double_pendulum", 0.5, 1e-4, marks=pytest.mark.long),
        pytest.param("path_generator", 0.05, 1e-4, marks=pytest.mark.long),
    ],
)
def test_a_run_has_the_bits_of_the_c_program(name, t_end, step, tmp_path):
    made = program(rt.example(name).recorded())
    (tmp_path / "model.mjs").write_text(module_of(made, t_end, step), encoding="utf-8")
    change = CHANGES.get(name, {})
    done = in_c(tmp_path, c_program(made, name, t_end, step), *(f"{key}={x!r}" for key, x in change.items()))
    p = json.dumps(change)
    script = f"""
import {{ run, names }} from "./model.mjs";
console.log(JSON.stringify([names, run(undefined, undefined, {p})]));
"""
    names, rows = node(tmp_path, script)
    want = np.genfromtxt(io.StringIO(done.stdout), delimiter=",")[1:]
    assert done.stdout.split("\n")[0].split(",") == names
    assert 500 <= len(want) <= 1001
    np.testing.assert_array_equal(np.array(rows), want)


def in_c(folder, text, *words):
    (folder / "model.c").write_text(text, encoding="utf-8")
    strict = ["-std=c99", "-O1", "model.c", "-o", "model", "-lm"]
    subprocess.run(["cc", *strict], cwd=folder, check=True, timeout=300)
    return subprocess.run([folder / "model", *words], capture_output=True, text=True, timeout=60, check=False)


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


@pytest.mark.parametrize(
    ("load", "times", "why"),
    [
        ('type = "torque"\nbody = "a"\ntorque = "sqrt(0.1 - t)"', ["0.2", "0.002"], "t = 0.101 s: no finite value"),
        ('type = "spring"\nconnect = ["ground.O", "a.P"]\nstiffness = 5e5', ["0.2", "0.002"], "energy error"),
        (None, ["20", "1"], "s: "),  # a step of a second tears the pendulum's joints apart
    ],
)
def test_a_run_stops_with_the_message_of_the_c_program(load, times, why, tmp_path):
    m = rt.example("double_pendulum") if load is None else rt.loads(FREE + load)
    made = program(m.recorded())
    (tmp_path / "model.mjs").write_text(module_of(made), encoding="utf-8")
    script = f"""
import {{ run }} from "./model.mjs";
try {{ run({", ".join(times)}); console.log('""'); }} catch (error) {{ console.log(JSON.stringify(error.message)); }}
"""
    said = node(tmp_path, script)
    assert why in said
    if shutil.which("cc") is not None:
        assert in_c(tmp_path, c_program(made, "A model", 1.0, 1.0), *times).stderr == said + "\n"


# ---------------------------------------------------------------- parameters
def oscillator(**changed):
    """x'' = -k x for mass 1, started at rest from x = 1/k, for k from 0 to 1e4."""
    graph = Graph()
    _, x, v, k, energy = (graph.input() for _ in range(5))
    energies = [0.5 * v * v, 0.5 * k * x * x, 0.0, 0.0, 0.5 * v * v + 0.5 * k * x * x - energy]
    start = Begin(
        k > 0.0, [1.0 / k, 0.0 * k, k < 1e6], [0.0 * k, 0.0 * k, True], [("x is off by", abs(x - 1.0 / k), "m")], [1.0],
        1e-11, 1e-8, 0.5, 30, 1e-14,
    )  # fmt: skip
    made = Program(
        graph, [v, -k * x, True], [x, v, True], [x, *energies, k > 0.0],
        ["x", *(f"energy.{name}" for name in ("kinetic", "potential", "work", "dissipated", "balance"))],
        ["m", *["J"] * 5], [Input("k", 4.0, "N/m", 0.0, 1e4)], [0.25, 0.0], start,
    )._replace(**changed)  # fmt: skip
    return made


def test_parameters_are_named_listed_or_left_as_they_are(tmp_path):
    (tmp_path / "model.mjs").write_text(javascript.module(["An oscillator"], oscillator(), 1.0, 1e-3))
    script = """
import * as m from "./model.mjs";
const said = (f) => { try { return f(); } catch (error) { return error.message; } };
const y = m.start([9]), dy = new Float64Array(2), out = new Float64Array(7), nowhere = new Float64Array(7);
m.derivative(0, y, dy, { k: 9 });
m.project(0, y, [9]);
m.outputs(0, y, out, Float64Array.of(9));
m.outputs(0, y, nowhere, { k: 2e6 });
console.log(JSON.stringify({
  exported: Object.keys(m).sort(), parameters: m.parameters, sliders: m.sliders, units: m.units,
  y: [...y], dy: [...dy], out: [...out], nowhere: Number.isNaN(nowhere[6]),
  ends: [m.run(), m.run(1, 1e-3, { k: 9 }), m.run(1, 1e-3, [9])].map((r) => r.at(-1)),
  counts: [m.run().length, m.run(2.5, 1e-3).length], same: m.run(0.1, 0.01, m.parameters).every((r, i) =>
    r.every((x, j) => x === m.run(0.1, 0.01)[i][j])),
  errors: [() => m.start({ k: -1 }), () => m.start({ c: 1 }), () => m.start([1, 2]), () => m.run(-1), () => m.run(1, 0),
    () => m.outputs(0, y, out, [-1]), () => m.run(1, 1e-3, { k: NaN }), () => m.start({ k: 2e6 })].map(said),
}));
"""
    got = node(tmp_path, script)
    names = ["names", "units", "parameters", "start", "derivative", "project", "outputs", "run", "sliders"]
    assert got["exported"] == sorted(names)
    assert got["parameters"] == {"k": 4.0}
    assert got["sliders"] == [{"name": "k", "value": 4.0, "unit": "N/m", "min": 0.0, "max": 1e4}]
    assert got["units"] == ["s", "m", *["J"] * 5]
    assert got["y"] == [1.0 / 9.0, 0.0]
    assert got["dy"] == [0.0, -1.0]
    assert got["out"][:4] == pytest.approx([0.0, 1.0 / 9.0, 0.0, 1.0 / 18.0], rel=1e-15)
    assert abs(got["out"][6]) < 1e-16  # counted from the start that belongs to k
    assert got["nowhere"]
    for row, k in zip(got["ends"], (4.0, 9.0, 9.0), strict=True):
        w = np.sqrt(k)  # the method's error over one radian at w h = 0.003: below (w h)^4/120
        assert row[:2] == pytest.approx([1.0, np.cos(w) / k], abs=w * (w * 1e-3) ** 4 / 120.0)
    assert got["same"]
    assert got["counts"] == [1001, 2500 // 3 + 2]  # never more than about a thousand rows
    texts = [
        "k = -1 is outside of its limits, 0 to 10000 N/m", "no parameter 'c' (there are: k)", "1 numbers expected",
        "both in s and positive", "both in s and positive", "near a singular position", "k: expected a finite number",
        "cannot be put together with these parameters: its position is singular",
    ]  # fmt: skip
    for said, text in zip(got["errors"], texts, strict=True):
        assert text in said


def test_names_stay_text_in_a_page(tmp_path):
    odd = ["</script><b>", "*/ x <!-- ", '"]; throw 1; ["', "\u2028'`${1}", "__proto__", "6"]
    made = oscillator(names=odd, parameters=[Input("__proto__", 4.0, "</script>")])
    text = javascript.module(["*/ throw 1 </script>"], made, 1.0, 1e-3)
    assert "</script" not in text
    assert "<!" not in text
    (tmp_path / "model.mjs").write_text(text, encoding="utf-8")
    script = """
import { names, parameters, sliders, start } from "./model.mjs";
console.log(JSON.stringify([names, Object.entries(parameters), sliders.map((one) => one.unit), [...start()]]));
"""
    assert node(tmp_path, script) == [["t", *odd], [["__proto__", 4.0]], ["</script>"], [0.25, 0.0]]


def test_a_lowered_function_of_a_known_sign_keeps_its_zero(tmp_path):
    """-0 is not 0: 1/x tells them apart."""
    graph = Graph()
    x = graph.input()
    lowered, made = elementary.lower(graph, [graph.apply("atan2", x, -1.0), -x, graph.apply("copysign", 0.0, x)])
    text = javascript.BITS + "export { straight };\n" + javascript.function(lowered, made, "straight")
    (tmp_path / "model.mjs").write_text(text)
    inputs = np.array([[0.0, -0.0, 3.0, -np.inf, np.nan]])
    require_same_bits(computed(tmp_path, "straight", 3, inputs), lowered.evaluate(made, inputs))
