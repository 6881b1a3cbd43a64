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
