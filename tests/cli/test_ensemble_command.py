"""`rattle ensemble` and `rattle sweep`: their tables, files and refusals."""

import csv
import json
from importlib.util import find_spec

import numpy as np
import pytest
from click.testing import CliRunner

import rattle as rt
from rattle.cli.main import main
from rattle.questions.ensemble import engines
from workbooks import read_workbook

pytestmark = pytest.mark.nojit
OF = "at(rocker.angle, 0.01)"
SHORT = ("fourbar", "--of", OF, "--t-end", "10ms")


def run(command, *words):
    return CliRunner().invoke(main, ["-q", command, *words])


@pytest.mark.machine
def test_an_ensemble_says_what_the_python_interface_says():
    seen = run("ensemble", *SHORT, "-n", "64", "--vary", "r3,r4", "--vary", "l2=0.2 mm:normal", "--seed", "3", "--json")
    assert seen.exit_code == 0, seen.output
    record = json.loads(seen.stdout)
    vary = {"r3": {}, "r4": {}, "l2": {"tol": "0.2 mm", "dist": "normal"}}
    e = rt.example("fourbar").ensemble(64, [OF], vary, seed=3, t_end=0.01)
    assert record["parameters"] == ["r3", "r4", "l2"]
    assert record["counts"] == {"ok": 64, "failed": 0, "not finite": 0, "not run": 0}
    assert record["outputs"][OF]["mean"] == e.summary().loc[OF, "mean"]
    assert record["outputs"][OF]["unit"] == "rad"


def test_a_limit_gives_the_share_of_the_mechanisms_that_keep_it():
    words = (*SHORT, "-n", "64", "--vary", "r3=0.5 mm")
    e = rt.example("fourbar").ensemble(64, [OF], {"r3": "0.5 mm"}, t_end=0.01)
    middle = float(np.rad2deg(np.median(e[OF])))
    seen = run("ensemble", *words, "--limit", f"{middle} deg")
    assert "50 % of the mechanisms stay at or below" in seen.stdout
    seen = run("ensemble", *words, "--of", "final(rocker.omega)", "--limit", "1")
    assert seen.exit_code == 2
    assert "--limit is for one --of" in seen.output


def test_tables_pictures_and_a_folder_that_goes_on(tmp_path):
    words = (*SHORT, "--vary", "r3=0.5 mm", "-o", str(tmp_path / "runs"))
    table, picture = tmp_path / "e.csv", tmp_path / "e.svg"
    assert run("ensemble", *words, "-n", "16").exit_code == 0
    seen = run("ensemble", *words, "-n", "32", "--csv", str(table), "--plot", str(picture))
    assert seen.exit_code == 0, seen.output
    assert f"kept in {tmp_path / 'runs'}" in seen.stdout
    assert len(table.read_text().splitlines()) == 33
    assert "rocker.angle" in picture.read_text()
    assert run("ensemble", *words, "-n", "32", "--csv", str(table.with_suffix(".xlsx"))).exit_code == 0
    head, *rows = read_workbook(table.with_suffix(".xlsx").read_bytes())["samples"]
    with table.open(newline="") as file:
        text = list(csv.reader(file))
    assert head == text[0]
    assert [row[1:3] for row in rows] == [[float(cell) for cell in line[1:3]] for line in text[1:]]
    seen = run("ensemble", *words, "-n", "32", "--seed", "1")
    assert seen.exit_code == 2
    assert "holds another run" in seen.output


@pytest.mark.machine
def test_curves_are_kept_in_the_folder(tmp_path):
    words = ("ensemble", *SHORT, "--vary", "r3=0.5 mm", "-n", "3", "--history", "rocker.angle")
    seen = run(*words)
    assert seen.exit_code == 2
    assert "give one with -o" in seen.output
    assert run(*words, "-o", str(tmp_path / "runs")).exit_code == 0
    e = rt.example("fourbar").ensemble(
        3, [OF], {"r3": "0.5 mm"}, t_end=0.01, folder=tmp_path / "runs", histories=["rocker.angle"]
    )
    t, curves = e.histories("rocker.angle")
    assert (t[-1], curves.shape) == (0.01, (3, 201))
    np.testing.assert_allclose(curves[:, -1], e[OF], rtol=1e-9)


def test_a_sweep_takes_ranges_and_lists_with_units(tmp_path):
    words = ("sweep", *SHORT, "--over", "r3=4 mm:6 mm:3", "--over", "r4=0.004,5 mm")
    record = json.loads(run(*words, "--json").stdout)["outputs"][OF]
    assert record["axes"] == {"r3": pytest.approx([0.004, 0.005, 0.006]), "r4": [0.004, 0.005]}
    w = rt.example("fourbar").sweep({"r3": [0.004, 0.005, 0.006], "r4": [0.004, 0.005]}, [OF], t_end=0.01)
    np.testing.assert_allclose(record["values"], w.grid(OF), rtol=1e-12)
    picture = tmp_path / "map.svg"
    assert run(*words, "--plot", str(picture)).exit_code == 0
    assert picture.stat().st_size > 1000


def test_one_word_names_parameters_with_and_without_a_tolerance():
    seen = run("ensemble", *SHORT, "-n", "8", "--vary", "r4, r3=min(1, 2)*0.1e-3:normal ,l2=0.2 mm", "--json")
    e = rt.example("fourbar").ensemble(
        8, [OF], {"r4": {}, "r3": {"tol": 1e-4, "dist": "normal"}, "l2": "0.2 mm"}, t_end=0.01
    )
    assert json.loads(seen.stdout)["outputs"][OF]["mean"] == e.summary().loc[OF, "mean"]


def test_a_range_may_begin_at_a_plain_zero():
    words = ("sweep", "path_generator", "--ideal", "--analysis", "kinematics", "--of", "final(coupler.P.y)")
    seen = run(*words, "--over", "a=0:60 mm:3", "--json")
    axes = json.loads(seen.stdout)["outputs"]["final(coupler.P.y)"]["axes"]
    assert axes["a"] == pytest.approx([0.0, 0.03, 0.06])


def test_a_limit_of_another_unit_is_refused_before_anything_runs(monkeypatch):
    def never(*words, **more):
        raise AssertionError("samples were run")

    monkeypatch.setattr(rt.Mechanism, "ensemble", never)
    seen = run("ensemble", *SHORT, "--vary", "r3=1 mm", "--limit", "5 kN")
    assert seen.exit_code == 2, seen.output
    assert "5 kN is a force" in seen.output


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("sweep", *SHORT, "--over", "r3"), "NAME=FIRST:LAST:COUNT"),
        (("sweep", *SHORT, "--over", "r3=1 mm:2 mm:0"), "from 1 to"),
        (("sweep", *SHORT, "--over", "r3=1 mm:2 mm:2000000000"), "from 1 to"),  # not made first, then counted
        (("sweep", *SHORT, "--over", "r3=1 mm:2 mm:2.5"), "a whole number"),
        (("sweep", *SHORT, "--over", "r3=1:5 mm:3"), "same kind of unit"),  # 1 m?
        (("sweep", *SHORT, "--over", "r3=1 mm:2 s:3"), "same kind of unit"),
        (("sweep", *SHORT, "--over", "r3=1 deg:2 deg:3"), "plain number or angle; expected a length"),
        (("sweep", *SHORT, "--over", "r3=1 mm:many:3"), "many"),
        (("sweep", *SHORT, "--over", "r3=0.001", "--over", "r3=0.002"), "given twice"),
        (("ensemble", *SHORT, "-n", "0"), "n must be from 1"),
        (("ensemble", *SHORT, "--vary", "r9"), "no parameter 'r9'"),
        (("ensemble", *SHORT, "--vary", ""), "--vary needs"),  # a variable of the shell that is not set
        (("ensemble", *SHORT, "--vary", "r3="), "--vary needs"),
        (("ensemble", *SHORT, "--vary", "r3", "--vary", "r3=1 mm"), "'r3' is given twice"),
        (("ensemble", "fourbar", "--vary", "r3=1 mm", "--of", "share(O3.normal > 0)", "--limit", "5 kN"), "force"),
        (("ensemble", *SHORT, "--vary", "r3=1 kg"), "mass"),
        (("ensemble", "fourbar", "--of", "biggest(x)"), "biggest"),
        (("ensemble", *SHORT, "--csv", "e.xls"), ".csv"),
        (("ensemble", *SHORT, "--plot", "e.doc"), "picture"),
        pytest.param(
            ("ensemble", *SHORT, "--scheduler", "tcp://127.0.0.1:1", "-n", "4"),
            "127.0.0.1:1",
            marks=pytest.mark.skipif(find_spec("distributed") is None, reason="distributed is not installed"),
        ),
    ],
)
def test_bad_words_are_refused_with_a_hint(words, message, monkeypatch):
    monkeypatch.setattr(engines, "CONNECTION", 1.0)
    seen = run(*words)
    assert seen.exit_code == 2, seen.output
    assert message in seen.output
    assert "Traceback" not in seen.output


def test_sweep_goes_over_a_number_of_the_model_by_its_path():
    words = ("slider_crank", "--of", "max(slider.x)", "--analysis", "kinematics", "--json")
    at = "bodies.rod.length"
    seen = run("sweep", *words, "--over", f"{at}=0.2 m,0.25 m")
    assert seen.exit_code == 0, seen.output
    record = json.loads(seen.stdout)
    for length, reach in zip((0.2, 0.25), record["outputs"]["max(slider.x)"]["values"], strict=True):
        m = rt.example("slider_crank").set({at: length})
        alone = m.kinematics(np.linspace(0.0, m.model.settings.t_end, 2001))["slider.x"].max()
        assert reach == pytest.approx(alone, rel=1e-6)
    assert run("sweep", *words, "--over", "bodies.rood.length=0.2 m,0.25 m").exit_code == 2
