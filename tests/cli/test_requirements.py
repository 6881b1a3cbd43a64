"""`--require` and `--limit`: what a mechanism has to keep, with an exit status for scripts."""

import json

import pytest
from click.testing import CliRunner

import rattle as rt
from rattle.cli.main import main
from rattle.cli.requirements import Condition

pytestmark = pytest.mark.nojit

# the range of the slider of a slider-crank in line is twice the crank: 100 mm
STROKE = ("kinematics", "slider_crank")


def run(*words):
    return CliRunner().invoke(main, list(words))


@pytest.mark.parametrize(
    ("condition", "status"),
    [
        ("range(slider.x) <= 101 mm", 0), ("range(slider.x) <= 99 mm", 1), ("range(slider.x) > 0.099", 0),
        ("range(slider.x) == 2*crank_length", 0), ("range(slider.x) == 99 mm", 1),
        ("first(slider.x < 0.1) < 1 s", 0),
    ],
)  # fmt: skip
def test_the_exit_status_says_whether_a_motion_keeps_what_is_required(condition, status):
    done = run(*STROKE, "--require", condition)
    assert done.exit_code == status, done.output
    assert f"required {condition}: {'NOT KEPT' if status else 'kept'}" in done.output


def test_every_requirement_is_told_and_one_that_fails_is_enough():
    done = run(*STROKE, "--require", "range(slider.x) <= 101 mm", "--require", "range(slider.x) <= 99 mm", "--json")
    assert done.exit_code == 1
    kept = json.loads(done.stdout)["required"]
    assert [one["kept"] for one in kept] == [True, False]
    assert kept[0]["value"] == pytest.approx(0.1, rel=1e-6)
    assert kept[0]["unit"] == "m"


@pytest.mark.parametrize(
    ("condition", "said"),
    [
        ("range(slider.x)", "takes a comparison"), ("< 3", "takes a comparison"),
        ("range(slider.z) < 1 m", "no curve or parameter 'slider.z'"), ("range(slider.x) < 3 N", "cannot"),
    ],
)  # fmt: skip
def test_what_cannot_be_required_is_refused(condition, said):
    done = run(*STROKE, "--require", condition)
    assert done.exit_code == 2
    assert said in done.output


def test_a_share_stands_behind_the_condition():
    assert Condition.read("max(B.force) < 2 kN: 95 %") == ("max(B.force) < 2 kN", "max(B.force)", "<", "2 kN", 0.95)
    assert Condition.read("first(a.x > 0) >= 1").share == 0.9973
    assert Condition.read("first(a.x > 0) >= 1").output == "first(a.x > 0)"


SAMPLES = ("ensemble", "slider_crank", "--analysis", "kinematics", "-n", "64", "--vary", "crank_length=1 mm")


@pytest.mark.parametrize(
    ("words", "status"),
    [
        (("--require", "range(slider.x) < 102.1 mm"), 0),  # twice the crank of 50 +- 1 mm
        (("--require", "range(slider.x) < 100 mm"), 1),
        (("--require", "range(slider.x) < 100 mm: 40 %"), 0),  # half of them
        (("--require", "range(slider.x) >= 98 mm", "--require", "range(slider.x) < 100 mm: 60%"), 1),
        (("--of", "range(slider.x)", "--limit", "100 mm"), 1),
        (("--of", "range(slider.x)", "--limit", "100 mm", "--require", "40%"), 0),
        (("--of", "range(slider.x)", "--limit", "100 mm", "--require", "60%"), 1),
    ],
)
def test_enough_mechanisms_of_an_ensemble_have_to_keep_it(words, status):
    done = run(*SAMPLES, *words)
    assert done.exit_code == status, done.output
    assert ("NOT KEPT" in done.output) == (status == 1)
    seen = run(*SAMPLES, *words, "--json")
    assert seen.exit_code == status
    assert all(one["kept"] for one in json.loads(seen.stdout)["required"]) == (status == 0)


def test_a_share_of_an_ensemble_needs_the_limit_that_it_is_about():
    done = run(*SAMPLES, "--of", "range(slider.x)", "--require", "60%")
    assert done.exit_code == 2
    assert "--limit" in done.output
    assert run(*SAMPLES, "--require", "range(slider.x) < 3 N").exit_code == 2
    assert run(*SAMPLES).exit_code == 2  # nothing is asked


@pytest.mark.long
def test_a_tolerance_study_answers_for_every_output_and_fails_where_one_limit_is_not_kept():
    asked = ("tolerance", "slider_crank", "--analysis", "kinematics", "-n", "16")
    asked += ("--vary", "crank_length=0.1 mm,rod_length=0.1 mm")
    outputs = ("--of", "at(slider.x, 0)", "--of", "at(slider.x, 0.003)")
    wide, tight = (run(*asked, *outputs, "--limit", limit, "--json") for limit in ("0.5 mm", "0.05 mm"))
    assert (wide.exit_code, tight.exit_code) == (0, 1)
    assert [one["of"] for one in json.loads(wide.stdout)] == ["at(slider.x, 0)", "at(slider.x, 0.003)"]
    assert run(*asked, *outputs, "--limit", "0.05 mm", "--require", "5%").exit_code == 0


def test_accuracy_answers_for_every_output(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    words = ("accuracy", "slider_crank_play", "--points", "5", "--of", "slider.x", "--of", "rod.angle")
    answers = json.loads(run(*words, "--json").stdout)
    assert [one["of"] for one in answers] == ["slider.x", "rod.angle"]
    alone = json.loads(run(*words[:4], "--of", "rod.angle", "--json").stdout)
    assert answers[1] == alone
    done = run(*words, "-o", "band.svg")
    assert done.exit_code == 0, done.output
    assert {path.name for path in tmp_path.glob("*.svg")} == {"band-slider.x.svg", "band-rod.angle.svg"}


@pytest.mark.parametrize("words", [("plot", "slider_crank", "slider.x"), ("power", "slider_crank"),
                                   ("export", "slider_crank", "-o", "x.csv"),
                                   ("animate", "slider_crank", "-o", "x.html")])  # fmt: skip
def test_commands_of_results_take_a_model_or_the_name_of_an_example(tmp_path, monkeypatch, words):
    monkeypatch.chdir(tmp_path)
    done = run(*words)
    assert done.exit_code == 0, done.output
    assert "a model, which is run now" in done.output
    missing = run(words[0], "slider_crnk", *words[2:])
    assert missing.exit_code == 2
    assert "did you mean 'slider_crank'" in missing.output


def test_the_example_of_these_tests_has_the_stroke_they_say():
    assert rt.example("slider_crank").parameters["crank_length"] == 0.05


# a mass of 1 kg that hangs from a spring of 100 N/m: sqrt(100)/2 pi = 1.59 Hz, and g/100 below its free length of 0.5 m
HANGING = """
format = 1
gravity = [0, -9.81]
[parameters]
k = "100 N/m"
[ground.points]
O = [0, 0]
[bodies.weight]
points = { P = [0, 0] }
mass = "1 kg"
inertia = "1 kg*m^2"
[joints.guide]
type = "prismatic"
connect = ["ground.O", "weight.P"]
axis = "90 deg"
[loads.spring]
type = "spring"
connect = ["ground.O", "weight.P"]
stiffness = "k"
free_length = "0.5 m"
[initial]
weight = { y = "-0.6 m" }
"""


@pytest.fixture(scope="module")
def hanging(tmp_path_factory):
    file = tmp_path_factory.mktemp("hanging") / "hanging.toml"
    file.write_text(HANGING)
    return str(file)


@pytest.mark.parametrize(
    ("command", "condition", "status"),
    [
        ("modes", "final(mode1.frequency) > 1.59 Hz", 0), ("modes", "final(mode1.frequency) > 1.6 Hz", 1),
        ("equilibrium", "final(weight.y) > -599 mm", 0), ("equilibrium", "final(weight.y) < -599 mm", 1),
        ("modes", "final(mode1.frequency) > 1 mm", 2), ("equilibrium", "final(weight.z) > 1", 2),
    ],
)  # fmt: skip
def test_positions_at_rest_and_their_modes_keep_what_is_required(hanging, command, condition, status):
    done = run(command, hanging, "--require", condition)
    assert done.exit_code == status, done.output
    assert ("NOT KEPT" in done.output) == (status == 1)
    if status < 2:
        seen = json.loads(run(command, hanging, "--require", condition, "--json").stdout)
        assert (seen if command == "modes" else seen[0])["required"][0]["kept"] == (status == 0)


def test_a_quasi_static_motion_keeps_what_is_required():
    words = ("equilibrium", "toggle_clamp", "--path", "--points", "3")
    name = next(one for one in json.loads(run(*words, "--json").stdout)["curves"] if one.endswith(".angle"))
    assert run(*words, "--require", f"range({name}) < 1e3 rad").exit_code == 0
    assert run(*words, "--require", f"range({name}) < 0 rad").exit_code == 1


def test_every_combination_of_a_sweep_keeps_what_is_required_or_the_first_that_does_not_is_told(hanging):
    words = ("sweep", hanging, "--analysis", "modes", "--over", "k=100,200,300 N/m")
    done = run(*words, "--require", "final(mode1.frequency) > 1.5 Hz")
    assert done.exit_code == 0, done.output
    assert "required final(mode1.frequency) > 1.5 Hz: kept in every combination" in done.output
    done = run(*words, "--require", "final(mode1.frequency) < 2 Hz", "--json")  # sqrt(200)/2 pi = 2.25 Hz
    assert done.exit_code == 1
    assert json.loads(done.stdout)["required"][0]["not_kept"] == [1, 2]
    told = run(*words, "--require", "final(mode1.frequency) < 2 Hz").output
    assert "NOT KEPT in 2 of 3, first at k = 200" in told
    for wrong in ("final(mode1.frequency) < 2 m", "final(mode1.frequency) < 2 Hz: 95 %", "final(mode1.frequency) == 2"):
        assert run(*words, "--require", wrong).exit_code == 2


def test_a_deviation_by_play_beyond_its_limit_is_exit_status_1():
    words = ("accuracy", "path_generator", "--of", "coupler.P.y", "--points", "9")
    record = json.loads(run(*words, "--json").stdout)
    largest = max(high - middle for high, middle in zip(record["high"], record["nominal"], strict=True))
    least = max(middle - low for low, middle in zip(record["low"], record["nominal"], strict=True))
    deviation = max(largest, least)
    assert run(*words, "--limit", f"{1.01 * deviation} m").exit_code == 0
    done = run(*words, "--limit", f"{0.99 * deviation} m")
    assert done.exit_code == 1
    assert "EXCEEDED, coupler.P.y deviates by" in done.output
    assert run(*words, "--of", "coupler.angle", "--limit", "1 mm").exit_code == 2  # no angle
    assert run(*words, "--limit=-1 mm").exit_code == 2


def test_a_limit_beside_several_outputs_names_the_way_to_say_it():
    done = run("ensemble", "fourbar", "--of", "final(rocker.angle)", "--of", "final(rocker.omega)", "--limit", "1")
    assert '--require "final(rocker.angle) <= 1"' in done.output
