"""A function is added to expressions by one record, a formula or rules of its own, and is then found everywhere."""

import io
import math
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import rattle as rt
from rattle.cli.main import main
from rattle.description.reference import topics
from rattle.jit import functions as compiled_functions
from rattle.language import arrays, syntax
from rattle.language.composed import COMPOSED, Composed
from rattle.language.expression import compile_program, concatenate, dimension, parse, value
from rattle.language.intervals import enclose
from rattle.language.jets import evaluate_jet
from rattle.language.syntax import ExpressionError
from rattle.language.units import DIMENSIONLESS

SPRING = """
format = 1
[parameters]
F = { value = "3 N", min = "1 N", max = "5 N" }
L = "0.2 m"
[ground.points]
O = [0, 0]
[bodies.block]
points = { P = [0, 0] }
mass = "1 kg"
inertia = "1 kg*m^2"
[joints.guide]
type = "prismatic"
connect = ["ground.O", "block.P"]
[loads.s]
type = "force"
at = "block.P"
force = ["-F*sinh(block.x/L)", 0]
[initial]
block = { x = "0.3 m", vx = 0 }
[simulate]
t_end = "0.5 s"
"""


@pytest.fixture
def sinh(monkeypatch):
    record = Composed("(exp(x) - exp(-x))/2", meaning="hyperbolic sine")
    monkeypatch.setitem(COMPOSED, "sinh", record)
    yield
    syntax._of_model.cache_clear()  # where texts that call it were read


def of_time(text):
    """An expression of time as a program: code, constants, number of rows, depth of its stack."""
    code, const, first, depth = concatenate([compile_program(parse(text), {}, {}, {})])
    return code, const, int(first[1]), depth


def test_without_its_record_it_is_not_there():
    with pytest.raises(ExpressionError, match="there is no function 'sinh'"):
        parse("sinh(1)")


@pytest.mark.parametrize("machine", [False, True])
def test_its_value_and_rates_are_those_of_the_function(sinh, machine, monkeypatch):
    if not machine:
        monkeypatch.setattr(compiled_functions, "_jit", False)
    elif not compiled_functions.start():
        pytest.skip("machine code is switched off")
    code, const, rows, depth = of_time("sinh(2*t)")
    for t in (-1.3, 0.0, 0.4, 2.0):
        out = np.empty(3)
        evaluate_jet(code, const, 0, rows, t, np.zeros((0, 3)), np.empty(3 * depth), out)
        rates = [math.sinh(2 * t), 2 * math.cosh(2 * t), 4 * math.sinh(2 * t)]
        np.testing.assert_allclose(out, rates, rtol=1e-14, atol=1e-15)
        h = 1e-4  # the fourth-order quotient is wrong by h^4, rounding by 1e-16/h
        f = [value(parse(f"sinh(2*({t + n * h!r}))"), {}) for n in (-2, -1, 1, 2)]
        assert out[1] == pytest.approx((f[0] - 8 * f[1] + 8 * f[2] - f[3]) / (12 * h), rel=1e-10)


def test_its_bounds_hold_its_values(sinh):
    code, const, rows, depth = of_time("sinh(t)")
    stack = np.zeros((depth, 4))
    enclose(code, const, 0, rows, -0.5, 0.7, np.zeros((0, 5)), stack)
    low, high, slow, fast = stack[0]
    assert (low, high) == pytest.approx((math.sinh(-0.5), math.sinh(0.7)), rel=1e-14)  # it rises: bounds are sharp
    assert slow <= 1.0  # at 0
    assert fast >= math.cosh(0.7)


def test_its_argument_is_a_plain_number(sinh):
    assert dimension(parse("sinh(2*t/t)"), {}.get) == DIMENSIONLESS
    with pytest.raises(ExpressionError, match="cannot take sinh of m; expected a plain number or angle"):
        dimension(parse("sinh(2 m)"), {}.get)
    with pytest.raises(rt.ModelError, match="cannot take sinh of m"):
        rt.loads(SPRING.replace("block.x/L", "L"))
    rt.loads(
        SPRING.replace("-F*sinh(block.x/L)", "2*sinh(block.x) - block.x")
    )  # plain numbers in SI units, as with sin
    with pytest.raises(ExpressionError, match="sinh takes 1 argument, not 2"):
        parse("sinh(1, 2)")


def test_it_is_found_in_arrays_and_in_the_reference(sinh):
    x = np.linspace(-2.0, 2.0, 9)
    np.testing.assert_allclose(arrays.evaluate(parse("sinh(x)"), {"x": x}.__getitem__), np.sinh(x), atol=1e-15)
    assert "sinh(x): hyperbolic sine" in topics()["functions"].lines


def test_a_force_by_it_does_the_work_of_its_potential(sinh):
    r = rt.loads(SPRING).simulate(rtol=1e-10)
    energy = 0.5 * r["block.vx"] ** 2 + 3.0 * 0.2 * np.cosh(r["block.x"] / 0.2)
    np.testing.assert_allclose(energy, energy[0], rtol=1e-8)
    assert np.ptp(r["block.x"]) > 0.4  # it swings


def test_lanes_and_sensitivities_know_it(sinh):
    m = rt.loads(SPRING)
    output, force = "at(block.x, 0.4)", np.array([2.0, 3.0, 4.0])
    lanes = m.many({"F": force}, [output], 0.5, rtol=1e-10)
    assert not len(lanes.generic)  # straight-line code, side by side
    runs = [rt.loads(SPRING).set({"F": F}).simulate(t_eval=[0.0, 0.4], rtol=1e-10)["block.x"][-1] for F in force]
    np.testing.assert_allclose(lanes[output], runs, atol=1e-7)
    found = m.sensitivity(["block.x"], ["F"], [0.0, 0.4])["d(block.x)/d(F)"][-1]
    h = 1e-3
    low, high = (m.set({"F": 3.0 + d}).simulate(t_eval=[0.0, 0.4], rtol=1e-12)["block.x"][-1] for d in (-h, h))
    assert found == pytest.approx((high - low) / (2 * h), rel=1e-5)


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
def test_a_program_in_c_knows_it(sinh, tmp_path):
    (tmp_path / "spring.toml").write_text(SPRING)
    words = ["code", str(tmp_path / "spring.toml"), "-o", str(tmp_path / "model.c")]
    written = CliRunner().invoke(main, words)
    assert written.exit_code == 0, written.output
    subprocess.run(["cc", "-std=c99", "-O1", "model.c", "-o", "model", "-lm"], cwd=tmp_path, check=True, timeout=300)
    text = subprocess.run([tmp_path / "model", "0.4", "0.001"], capture_output=True, text=True, check=True).stdout
    rows = np.genfromtxt(io.StringIO(text), delimiter=",", names=True, deletechars="")
    run = rt.loads(SPRING).simulate(t_eval=[0.0, rows["t"][-1]], rtol=1e-10)
    assert rows["block.x"][-1] == pytest.approx(run["block.x"][-1], abs=1e-6)


OWN_RULES = """
from rattle.language import functions_of_one as one
from rattle.language.functions_of_one import exp
from rattle.language.operation import Units, operation
from rattle.language.span import chain, most
from rattle.jit.functions import compiled

@compiled
def sinh(x):
    return 0.5 * (exp(x) - exp(-x))

@compiled
def cosh(x):
    return 0.5 * (exp(x) + exp(-x))

@compiled
def sinh_span(x):
    least = 1.0 if x.low <= 0.0 and x.high >= 0.0 else min(cosh(x.low), cosh(x.high))
    return chain(sinh(x.low), sinh(x.high), least, most(cosh(x.low), cosh(x.high)), x)

one.OPERATIONS += (
    operation(
        "sinh", Units.PLAIN, value=sinh, slope=lambda x, f: cosh(x), bend=lambda x, f, f1: f,
        span=sinh_span, array=__import__("numpy").sinh,
    ),
)  # before any interpreter takes its tables

import math
import numpy as np
import rattle as rt
from rattle.jit.functions import start
from rattle.language.intervals import enclose
from rattle.language.jets import evaluate_jet
from rattle.language.expression import compile_program, concatenate, dimension, parse, value
from rattle.language.syntax import ExpressionError, FUNCTIONS

start()
assert FUNCTIONS["sinh"] == 1
program = compile_program(parse("sinh(2*t)"), {}, {}, {})
code, const, first, depth = concatenate([program])
assert len(code) == 4  # one operation of its own, not a formula
out, stack = np.empty(3), np.zeros((depth, 4))
evaluate_jet(code, const, 0, int(first[1]), 0.4, np.zeros((0, 3)), np.empty(3 * depth), out)
np.testing.assert_allclose(out, [math.sinh(0.8), 2*math.cosh(0.8), 4*math.sinh(0.8)], rtol=1e-14)
enclose(code, const, 0, int(first[1]), -0.2, 0.1, np.zeros((0, 5)), stack)
np.testing.assert_allclose(stack[0], [math.sinh(-0.4), math.sinh(0.2), 2.0, 2*math.cosh(0.4)], rtol=1e-14)
try:
    dimension(parse("sinh(2 m)"), {}.get)
except ExpressionError as error:
    assert "cannot take sinh of m" in str(error)
else:
    raise AssertionError("sinh of a length was not refused")

from rattle.trace.derivative import tangent
from rattle.trace.elementary import lower
from rattle.trace.graph import Graph
from rattle.trace.recording import operation as recorded

graph = Graph()
x = graph.input()
y = recorded("sinh", x)
exact, outputs = lower(graph, [y, *tangent(graph, [y], {x.place: 1.0})])
found = exact.evaluate(outputs, np.array([[0.7]]))[:, 0]
np.testing.assert_allclose(found, [math.sinh(0.7), math.cosh(0.7)], rtol=1e-14)
"""


@pytest.mark.parametrize("mode", ["python", "native"])
def test_a_record_with_its_own_rules_is_an_operation_of_programs(mode, tmp_path):
    """Interpreters take their tables when they are imported, so a process of its own with machine code of its own."""
    (tmp_path / "own.py").write_text(OWN_RULES)
    environment = {"RATTLE_JIT": mode, "RATTLE_CACHE": str(tmp_path / "cache"), "PYTHONPATH": _sources()}
    done = subprocess.run(
        [sys.executable, "own.py"], cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr


def _sources():
    return str(Path(rt.__file__).parent.parent)
