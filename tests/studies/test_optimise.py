"""Searches find known optima, keep bounds and constraints, survive bad designs, and say what they did."""

import json
import math
import re
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.optimize import brentq

import linkages
import rattle as rt
from rattle.cli.main import main
from rattle.errors import ModelError
from rattle.questions.optimise.asked import question
from rattle.questions.optimise.designs import Designs
from rattle.questions.optimise.squares import squares
from rattle.results.evaluation import evaluate
from rattle.results.reductions import Known, read
from rattle.results.result import UnknownName

T = math.pi / 10  # of the runs of SPRING [s]
SPRING = """
format = 1
[parameters]
k = "15 N/m"
x0 = "500 mm"
[ground.points]
O = [0, 0]
[bodies.block]
points = { P = [0, 0] }
mass = 1
inertia = 1
[joints.guide]
type = "prismatic"
connect = ["ground.O", "block.P"]
[loads.s]
type = "spring"
connect = ["ground.O", "block.P"]
stiffness = "k"
free_length = 0
[initial]
block = { x = "x0", vx = 0 }
"""  # x = x0 cos(sqrt(k) t)
K = (math.acos(0.6) / T) ** 2  # x(T) = 0.3

TURNING = """
format = 1
[parameters]
a = 0.2
b = 0.3
[signals]
bowl = "(a - 1)**2 + 2*(b + 0.5)**2 + a*b"
[ground.points]
O = [0, 0]
[bodies.disc]
points = { C = [0, 0] }
mass = 1
inertia = 1
[joints.O]
type = "revolute"
connect = ["ground.O", "disc.C"]
[drivers.motor]
joint = "O"
angle = "t"
"""


def fourbar(drive='joint = "A"\nangle = "1 + 2*t"', b=4.0):
    """Crank 1, coupler b, rocker 3 on a base of 4: the crank turns all the way if 2 <= b <= 6."""
    return linkages.fourbar_text(
        drive,
        1.0,
        '"b"',
        3.0,
        4.0,
        "coupler = { angle = 0.6 }\nrocker = { angle = 1.5 }",
        joints=f"[parameters]\nb = {b}",
    )


# ---------------------------------------------------------------- known optima
def test_a_spring_puts_a_mass_where_it_is_wanted():
    o = rt.loads(SPRING).optimise("(final(block.x) - 0.3)**2", {"k": (5, 20)}, t_end=T, starts=3)
    assert o.values["k"] == pytest.approx(K, rel=1e-8)
    assert o.value < 1e-18
    assert all(one.ended["k"] == pytest.approx(K, rel=1e-6) for one in o.searches)
    assert o.mechanism.simulate(T, rtol=1e-12)["block.x"][-1] == pytest.approx(0.3, abs=1e-9)
    assert o.success
    assert "3 of 3 searches" in o.report
    assert "15 N/m -> 8.71237 N/m" in o.report


def test_the_least_of_a_bowl():
    """Gradient of the bowl: 2(a - 1) + b = 0, 4(b + 1/2) + a = 0."""
    a, b = np.linalg.solve([[2, 1], [1, 4]], [2, -2])
    m = rt.loads(TURNING)
    o = m.optimise("final(bowl)", {"a": (-3, 3), "b": (-2, 2)}, t_end=0.1, analysis="kinematics", starts=2)
    assert [o.values["a"], o.values["b"]] == pytest.approx([a, b], abs=1e-6)
    assert o.value == pytest.approx((a - 1) ** 2 + 2 * (b + 0.5) ** 2 + a * b, abs=1e-12)
    assert o.active == ()
    assert m.parameters == {"a": 0.2, "b": 0.3}  # the mechanism itself stays


def test_at_an_active_constraint_the_gradients_are_parallel():
    """x0 w <= 1 with w = sqrt(k):  x(T) = cos(wT)/w is least where wT tan(wT) = -1, and falls by -x(T) per unit."""
    o = rt.loads(SPRING).optimise(
        "final(block.x)", {"k": (5, 100), "x0": (0.05, 0.5)}, ["max(abs(block.vx)) <= 1"], t_end=T, starts=1
    )
    w = brentq(lambda x: x * math.sin(x) + math.cos(x), 2.0, 3.0) / T
    assert [o.values["k"], o.values["x0"]] == pytest.approx([w * w, 1 / w], rel=1e-4)
    assert o.value == pytest.approx(math.cos(w * T) / w, rel=1e-7)
    assert o.active == ("max(abs(block.vx)) <= 1",)
    k, x0, s = o.values["k"], o.values["x0"], math.sqrt(o.values["k"])
    objective = np.array([-x0 * math.sin(s * T) * T / (2 * s), math.cos(s * T)])
    speed = np.array([x0 / (2 * s), s])
    assert s * x0 == pytest.approx(1.0, abs=1e-6)
    assert objective + o.held.constraints[0] * speed == pytest.approx([0, 0], abs=1e-4 * np.linalg.norm(objective))
    assert o.held.constraints[0] == pytest.approx(-o.value, rel=1e-4)
    assert k < 100


@pytest.mark.parametrize(
    ("objective", "conditions"), [("(final(block.x) - 0.3)**2", ()), ("-final(block.x)", ("max(block.x) <= 1",))]
)
def test_a_bound_that_holds_the_optimum_is_met_exactly(objective, conditions):
    """Both wish for a softer spring; sums of squares and all else are searched in different ways."""
    o = rt.loads(SPRING).optimise(objective, {"k": ("12 N/m", "20 N/m")}, conditions, t_end=T, starts=2)
    assert o.values["k"] == 12.0
    assert o.active == ("k >= 12 N/m",)
    assert o.success


def test_no_design_meets_the_constraints():
    o = rt.loads(SPRING).optimise("final(block.x)", {"k": (5, 20)}, ["min(block.x) >= 0.6"], t_end=T, starts=1)
    assert not o.feasible
    assert not o.success
    assert "NO DESIGN MEETS ALL CONSTRAINTS" in o.report
    assert re.search("min.block.x. >= 0.6: missed by .* m", o.report)
    assert "min(block.x) >= 0.6" not in o.active
    assert "loosened" not in o.report


@pytest.mark.parametrize("objective", ["(final(block.x) - 0.3)**2", "rms(block.x - ref)"])
def test_a_search_from_a_perfect_design_confirms_it(objective):
    """What is left is rounding, of which no share can agree; k = 9 has the reference as its motion."""
    m = rt.loads(SPRING.replace("[ground.points]", '[signals]\nref = "0.5*cos(3*t)"\n[ground.points]'))
    perfect = m.set(k=K if "final" in objective else 9.0)
    again = perfect.optimise(objective, {"k": (5, 20)}, t_end=T, starts=1)
    assert again.success, again.report
    assert again.values["k"] == pytest.approx(perfect.parameters["k"], rel=1e-8)


def test_a_finer_run_that_misses_by_more_than_errors_confirms_nothing():
    """From a perfect design, whose objective has no size of its own: a miss of 10 nm is no error of a run."""
    perfect = rt.loads(SPRING).set(k=K)
    o = perfect.optimise("(final(block.x) - 0.3)**2", {"k": (5, 20)}, t_end=T, starts=1)
    assert o.confirmed
    assert not replace(o, check=replace(o.check, numbers=np.array([1e-16]))).confirmed


def test_the_same_seed_gives_the_same_answer():
    def run(seed):
        return rt.loads(SPRING).optimise("(final(block.x) - 0.3)**2", {"k": (5, 20)}, t_end=T, starts=2, seed=seed)

    one, same, other = run(4), run(4), run(5)
    assert one.searches == same.searches
    assert one.report == same.report
    assert one.searches[1].begun != other.searches[1].begun
    assert one.searches[0] == other.searches[0]


def test_a_sum_of_squares_that_cannot_vanish_is_least_where_its_gradient_is_zero():
    """Two wishes for one spring: x(T) = 0.3 and x(T/2) = 0.45; by the closed form of the motion."""
    o = rt.loads(SPRING).optimise(
        f"(final(block.x) - 0.3)**2 + 2*(at(block.x, {T / 2}) - 0.45)**2", {"k": (5, 20)}, t_end=T, starts=1
    )

    def gradient(k):
        s = math.sqrt(k)
        late, early = 0.5 * math.cos(s * T) - 0.3, 0.5 * math.cos(s * T / 2) - 0.45
        return late * math.sin(s * T) + early * math.sin(s * T / 2)

    assert o.values["k"] == pytest.approx(brentq(gradient, 5, 20, xtol=1e-12), rel=1e-6)


@pytest.mark.parametrize(
    ("objective", "conditions"), [("(final(block.x) - 0.3)**2", ()), ("final(block.x)", ("max(abs(block.vx)) <= 1.5",))]
)
def test_parameters_without_effect_are_told(objective, conditions):
    m = rt.loads(SPRING.replace('k = "15 N/m"', 'k = "15 N/m"\nlost = 2'))
    o = m.optimise(objective, {"lost": (1, 3), "k": (5, 20)}, conditions, t_end=T, starts=1)
    assert "without effect on what is asked, near this design at least: lost\n" in o.report
    assert "without effect" not in rt.loads(SPRING).optimise(objective, {"k": (5, 20)}, t_end=T, starts=1).report


def test_searches_that_ended_elsewhere_are_told_in_the_unit_of_the_objective():
    """0.5 - a**2 falls to both ends of the range: to 0.25 rad and, from the other side, to 0.46 rad."""
    m = rt.loads(TURNING.replace("a = 0.2", "a = 0.01").replace('angle = "t"', 'angle = "t - a**2"'))
    o = m.optimise("final(disc.angle)", {"a": (-0.2, 0.5)}, t_end=0.5, analysis="kinematics", starts=6)
    assert o.values["a"] == 0.5
    assert "the others at 26.36 deg" in o.report  # 0.5 - 0.2**2 rad


# ---------------------------------------------------------------- derivatives
@pytest.mark.parametrize(
    ("text", "analysis", "outputs"),
    [
        (fourbar(), "kinematics",
         ["rms(rocker.angle)", "max(coupler.C.y)", "at(rocker.omega, b/4)", "b*sd(coupler.x)"]),
        (fourbar(), "inverse-dynamics", ["max(C.force)", "integral(motor.torque**2)", "min(D.fx)"]),
        (SPRING, "simulate",
         ["min(block.x)", "quantile(block.vx, 0.3)", "rms(energy.potential)", "share(block.x > 0.2)"]),
    ],
)  # fmt: skip
def test_slopes_by_exact_derivatives_are_those_of_whole_runs(text, analysis, outputs):
    vary = {"b": (3, 5)} if analysis != "simulate" else {"k": (5, 20), "x0": (0.1, 1)}
    check_slopes(rt.loads(text), vary, {"b": 3.7, "k": 11.0, "x0": 0.4}, outputs, analysis)


def test_slopes_follow_parameters_that_are_expressions_over_those_that_vary():
    m = rt.loads(fourbar().replace("b = 4.0", 'b = 4.0\nhalf = "b/8"\ntwice = "2*b"'))
    outputs = [
        "final(rocker.angle) - twice",
        "max(twice*coupler.C.y)",
        "at(rocker.omega, half)",
        "rms(coupler.x - half)",
    ]
    check_slopes(m, {"b": (3, 5)}, {"b": 3.7}, outputs, "kinematics")


def test_slopes_at_instants_that_vary_need_their_surroundings_alone():
    """Beside other instants, beside each other, and beside both ends of the run."""
    m = rt.loads(fourbar().replace("b = 4.0", "b = 4.0\nearly = 0.001\nlate = 0.5\nlast = 0.999"))
    outputs = [
        "at(rocker.omega, late)",
        "at(coupler.C.y*b, early)",
        "at(rocker.angle, last)",
        "at(coupler.x, late + 0.001)",
    ]
    vary = {"b": (3, 5), "early": (0, 1), "late": (0, 1), "last": (0, 1)}
    asked, _ = question(m, outputs[0], vary, [f"{one} >= 0" for one in outputs[1:]], 1.0, "kinematics")
    assert len(asked.needed_times(m)) < 40 < len(asked.times(m))
    check_slopes(m, vary, {"b": 3.7, "early": 0.001, "late": 0.5, "last": 0.999}, outputs, "kinematics")


def check_slopes(m, vary, values, outputs, analysis):
    """Derivatives of outputs against differences of whole runs."""
    asked, _ = question(m, outputs[0], vary, [f"{one} >= 0" for one in outputs[1:]], 1.0, analysis)
    designs = Designs(asked)
    design = designs.at(asked.places(values))
    exact = designs.slopes(design)
    assert not designs.differenced
    whole = designs._difference_slopes(design, designs._numbers)
    assert exact == pytest.approx(whole, rel=2e-5, abs=1e-6 * np.abs(whole).max())


def test_slopes_follow_the_mechanism_without_play_too():
    m = rt.example("fourbar")
    asked, _ = question(m, "rms(rocker.angle - ideal.rocker.angle)", {"r3": (0.003, 0.008)}, (), 0.02, "simulate")
    designs = Designs(asked)
    design = designs.at(asked.places({"r3": 0.005}))
    exact = designs.slopes(design)
    assert not designs.differenced
    assert exact == pytest.approx(designs._difference_slopes(design, designs._numbers), rel=1e-4)


def test_where_there_are_no_derivatives_runs_are_differenced_and_it_is_said():
    switched = fourbar('joint = "A"\nangle = "1 + 2*t if t < 5 else 11"')
    found = [
        rt.loads(text).optimise(
            "(final(rocker.angle) - 2)**2", {"b": (3, 5)}, t_end=0.5, analysis="kinematics", starts=1
        )
        for text in (fourbar(), switched)
    ]
    assert "differences of whole runs" not in found[0].report
    assert "differences of whole runs, because: " in found[1].report
    assert "switches" in found[1].report
    assert found[0].values["b"] == pytest.approx(found[1].values["b"], rel=1e-6)


# ---------------------------------------------------------------- designs that cannot be
@pytest.mark.long
def test_a_search_survives_designs_that_cannot_be_put_together():
    """A shorter coupler is better until, below 2, the crank cannot turn: the search comes to the edge.

    A gap that is shorter than the output interval (its half width is sqrt((2 - b)/0.4) rad) only the check may see.
    """
    m = rt.loads(fourbar().replace("[parameters]", '[signals]\nsize = "b + 0*t"\n[parameters]'))
    o = m.optimise("final(size)", {"b": (0.5, 5)}, t_end=math.pi, analysis="kinematics", starts=1)
    assert 2.0 - 1e-5 < o.values["b"] < 2.01
    assert o.values["b"] >= 2.0 or not o.confirmed
    assert sum(o.failures.values()) > 0
    assert "could not be evaluated" in o.report


@pytest.mark.long
def test_a_search_survives_instants_outside_of_the_run_and_may_end_at_its_end():
    """x falls until t = k/50; beyond k = 16.5 that is after the end at 0.33 s."""
    o = rt.loads(SPRING).optimise("at(block.x, k/50)", {"k": (5, 20)}, t_end=0.33, starts=5)
    assert o.values["k"] == pytest.approx(16.5, rel=1e-3)
    assert "x the instant ... s is not between ... and t_end" in o.report
    last = rt.loads(SPRING.replace('k = "15 N/m"', 'k = "15 N/m"\nlast = "0.2 s"'))
    o = last.optimise("at(block.x, last)", {"last": (0, 0.33)}, t_end=0.33, starts=1)
    assert o.values["last"] == 0.33
    assert o.success
    assert not o.differenced


def test_the_report_says_why_designs_have_no_numbers_and_leaves_out_where_the_file_is(tmp_path):
    """Beyond k = 12 the parameter k2 has no value; the search wants k = 8.7 and others begin anywhere."""
    source = tmp_path / "m.toml"
    source.write_text(SPRING.replace('k = "15 N/m"', 'k = "10 N/m"\nk2 = "sqrt(12 - k)"'))
    o = rt.load(source).optimise("(final(block.x) - 0.3)**2", {"k": (5, 200)}, t_end=T, starts=2)
    assert o.values["k"] == pytest.approx(K, rel=1e-6)
    assert "x parameters.k2: the result is not a finite number" in o.report
    assert str(tmp_path) not in o.report


# ---------------------------------------------------------------- sums of squares
RUN = ("(final(block.x) - 0.3)**2", "2*(max(block.x) - k)**2/3 + (mean(block.vx))**2", "rms(block.x - 0.1)**2",
       "mean((block.x - 0.1)**2 + 3*block.y**2)", "integral(block.vx**2)", "at(block.x**2 + 2*block.y**2, 0.1)",
       "min((block.x - 0.1)**2 + (block.y - 0.2)**2) + 4*min((block.x - 0.2)**2)")  # fmt: skip


@pytest.mark.parametrize("text", [*RUN, "rms(block.x - 0.1)"])
def test_the_parts_of_a_sum_of_squares_add_up_to_it(text):
    m = rt.loads(SPRING)
    r = m.simulate(T)
    output = read(text, Known.of(r))
    parts = squares(output)
    total = sum(float((one.residual(one.raw(r, m.parameters, None)) ** 2).sum()) for one in parts)
    value = evaluate(output, r, m.parameters)
    assert total == pytest.approx(value**2 if text.startswith("rms") and not text.endswith("2") else value, rel=1e-12)


@pytest.mark.parametrize(
    "text",
    ["final(block.x)", "(final(block.x))**2 - (max(block.x))**2", "max(block.x**2)", "(final(block.x))**3",
     "sd(block.x)", "min(block.x**2 - 1)", "k*(final(block.x))**2", "mean(block.x**2 - 1)"],
)  # fmt: skip
def test_what_is_no_sum_of_squares_is_not_taken_for_one(text):
    assert squares(read(text, Known.of(rt.loads(SPRING).simulate(T)))) is None


# ---------------------------------------------------------------- bad questions
@pytest.mark.parametrize(
    ("change", "error", "words"),
    [
        ({"vary": {"k": (20, 5)}}, ValueError, "the lower bound comes first"),
        ({"vary": {"k": (5, 5)}}, ValueError, "nothing to choose"),
        ({"vary": {"k": (16, 20)}}, ValueError, r"present value 15 .* outside its bounds"),
        ({"vary": {"k": 7}}, ValueError, "a lower and an upper bound"),
        ({"vary": {"k": ("5 mm", "20 mm")}}, ValueError, "is a length"),
        ({"vary": {"k": ("soft", 20)}}, ValueError, "is not a value"),
        ({"vary": {"k": (math.nan, 20)}}, ValueError, "finite"),
        ({"vary": {3: (5, 20)}}, TypeError, "names of parameters, got 3"),
        ({"vary": {}}, ValueError, "parameters with their bounds"),
        ({"vary": {"kk": (5, 20)}}, UnknownName, "no parameter 'kk'.*'k'"),
        ({"minimise": "final(blok.x)"}, ModelError, "did you mean 'block.x'"),
        ({"minimise": "block.x"}, ModelError, "changes during the run"),
        ({"minimise": 3.0}, TypeError, "expected a text"),
        ({"minimise": "final(sqrt(-block.x))"}, ValueError, "cannot be evaluated for the present design"),
        ({"minimise": "at(block.x, 9)"}, ValueError, "instant 9 s is not between"),
        ({"subject_to": ["max(block.x)"]}, ModelError, "compares two outputs"),
        ({"subject_to": "max(block.x) <= y"}, ModelError, "'y'"),
        ({"analysis": "sumilate"}, ValueError, "did you mean 'simulate'"),
        ({"analysis": "kinematics"}, ModelError, "drivers that determine every position"),
        ({"starts": 0}, ValueError, "starts"),
        ({"t_end": -1}, ValueError, "t_end"),
    ],
)
def test_a_bad_question_is_refused_with_what_to_do(change, error, words):
    asked = {"minimise": "final(block.x)", "vary": {"k": (5, 20)}, "t_end": T, "starts": 1} | change
    with pytest.raises(error, match=words):
        rt.loads(SPRING).optimise(**asked)


def test_bounds_beyond_those_of_the_model_are_refused():
    text = SPRING.replace('"15 N/m"', "{ value = 15, min = 10, max = 20 }")
    with pytest.raises(ValueError, match="the model allows 'k' from 10 to 20"):
        rt.loads(text).optimise("final(block.x)", {"k": (5, 20)}, t_end=T)


def test_kinematics_has_no_forces_and_says_who_has():
    with pytest.raises(ModelError, match="inverse-dynamics"):
        rt.loads(fourbar()).optimise("max(C.force)", {"b": (3, 5)}, analysis="kinematics")


# ---------------------------------------------------------------- the command
def test_the_command_writes_the_best_design_in_the_units_of_the_file(tmp_path):
    source, target = tmp_path / "m.toml", tmp_path / "best.toml"
    source.write_text(SPRING)
    words = ["optimise", str(source), "--minimise", "(final(block.x) - 0.3)**2", "--vary", "x0=100 mm:900 mm"]
    done = CliRunner().invoke(main, ["-q", *words, "--t-end", f"{T}", "--starts", "2", "-o", str(target)])
    assert done.exit_code == 0, done.output
    best = 0.3 / math.cos(math.sqrt(15) * T)
    assert rt.load(target).parameters["x0"] == pytest.approx(best, rel=1e-8)
    assert f"500 mm -> {1e3 * best:.6g} mm  (from 100 mm to 900 mm)" in done.output
    assert ' mm"' in target.read_text()


def test_the_command_writes_json_under_such_a_name_and_refuses_others_before_it_searches(tmp_path, monkeypatch):
    source = tmp_path / "m.toml"
    source.write_text(SPRING)
    words = ["-q", "optimise", str(source), "--minimise", "(final(block.x) - 0.3)**2", "--vary", "k=5:20"]
    target = tmp_path / "best.json"
    done = CliRunner().invoke(main, [*words, "--t-end", f"{T}", "--starts", "1", "-o", str(target)])
    assert done.exit_code == 0, done.output
    assert json.loads(target.read_text())["parameters"]["x0"] == "500 mm"
    assert rt.load(target).parameters["k"] != rt.load(source).parameters["k"]

    def search(*_, **__):
        raise AssertionError("the name should have been refused before")

    monkeypatch.setattr(rt.Mechanism, "optimise", search)
    done = CliRunner().invoke(main, [*words, "-o", str(tmp_path / "best.csv")])
    assert done.exit_code == 2
    assert "best.csv: a model is saved as TOML or JSON; give a name ending in .toml or .json" in done.output


@pytest.mark.parametrize("vary", ["k", "k=5", "k=5:6:7", "=1:2"])
def test_the_command_says_how_bounds_are_written(vary, tmp_path):
    (tmp_path / "m.toml").write_text(SPRING)
    done = CliRunner().invoke(
        main, ["optimise", str(tmp_path / "m.toml"), "--minimise", "final(block.x)", "--vary", vary]
    )
    assert done.exit_code == 2
    assert "NAME=LOW:HIGH" in done.output


@pytest.mark.nojit
def test_an_end_that_would_differ_from_design_to_design_must_be_given():
    text = SPRING.replace("[parameters]", '[parameters]\nT = "0.2 s"\nT2 = "2*T"') + '[simulate]\nt_end = "T2"\n'
    with pytest.raises(ValueError, match="t_end follows from T2 and would differ from design to design; give t_end"):
        rt.loads(text).optimise("final(block.x)", {"T": (0.1, 0.3)})
