"""Ordinary slips on the command line: what is said names the slip and what to do."""

import pytest
from click.testing import CliRunner

import rattle as rt
from circling import circling
from rattle.cli.main import main


def said(*words):
    done = CliRunner().invoke(main, list(words))
    return done.exit_code, done.output


@pytest.fixture
def saved(tmp_path):
    return str(circling(51).save(tmp_path / "out.npz"))


@pytest.mark.nojit
@pytest.mark.parametrize("slip", [["-o", "x.png"], ["--orbit", "-o", "x.png"], ["--xy", "-o"], ["a.x", "--over", "-o"]])
def test_a_picture_without_a_name_is_not_passed_over(saved, slip):
    code, text = said("plot", saved, *slip)
    assert code == 2
    assert "lists all names" in text


@pytest.mark.nojit
@pytest.mark.parametrize("words", [["plot", "--xy", "arm.Q"], ["animate", "-o", "a.gif", "--trace", "arm.Q"]])
def test_a_point_that_is_not_there_is_named_as_it_was_written(saved, tmp_path, monkeypatch, words):
    monkeypatch.chdir(tmp_path)
    code, text = said(words[0], saved, *words[1:])
    assert code == 2
    assert "no point or body 'arm.Q'" in text
    assert "arm.Q.x" not in text


@pytest.mark.machine
@pytest.mark.nojit
def test_model_files_and_results_are_told_apart(saved, tmp_path):
    model = tmp_path / "fourbar.toml"
    model.write_text(rt.examples()["fourbar"].read_text(encoding="utf-8"), encoding="utf-8")
    code, text = said("plot", str(model), "rocker.angle", "-o", str(tmp_path / "angle.png"))
    assert code == 0  # a model is run first, which is said
    assert "rattle run" in text
    code, text = said("check", saved)
    assert code == 2
    assert "this is a result" in text


@pytest.mark.nojit
def test_limits_of_a_parameter_have_units():
    words = ["poincare", "slider_crank_play", "--of", "B.ex", "--parameter", "c", "--to", "0.6 mm"]
    code, text = said(*words, "--from", "1 kg")
    assert code == 2
    assert "'1 kg' is a mass" in text
    assert "a length" in text
    assert "not a value" in said(*words, "--from", "c/2")[1]


def test_values_of_a_parameter_in_units_are_those_in_si(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    seen = []
    monkeypatch.setattr(
        rt.Mechanism, "bifurcation", lambda m, parameter, values, *rest, **more: seen.append(list(values)) or 1 / 0
    )
    for low, high in (("0.2 mm", "0.6 mm"), ("2e-4", "6e-4")):
        said(
            "-q", "poincare", "slider_crank_play", "--of", "B.ex", "--parameter", "c", "--from", low, "--to", high,
            "--values", "3",
        )  # fmt: skip
    assert seen[0] == pytest.approx([2e-4, 4e-4, 6e-4], rel=1e-14)
    assert seen[0] == pytest.approx(seen[1], rel=1e-14)


@pytest.mark.nojit
def test_accuracy_without_any_play_is_refused():
    code, text = said("accuracy", "path_generator", "--of", "coupler.P.y", "--ideal")
    assert code == 2
    assert "leave --ideal out" in text
