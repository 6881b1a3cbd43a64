"""`rattle fit` and `rattle oil`: the figures of the functions behind them, and refusals in one sentence."""

import json

import pytest
from click.testing import CliRunner

import rattle as rt
from rattle.cli.main import main

pytestmark = pytest.mark.nojit


def run(*words):
    return CliRunner().invoke(main, list(words))


def test_a_fit_is_printed_with_its_limits_and_its_play():
    done = run("fit", "H7/g6", "8 mm")
    assert done.exit_code == 0
    figures = done.output.splitlines()[2].split()
    assert figures == ["8", "mm", "0", "15", "-14", "-5", "5", "29", "8.5", "6"]
    assert "radial play 2.5 to 14.5 um" in done.output


def test_several_sizes_have_a_line_each():
    done = run("fit", "H8/f7", "6mm", "10 mm", "0.025")
    assert [line.split()[0] for line in done.output.splitlines()[2:5]] == ["6", "10", "25"]


def test_a_fit_as_json_is_in_si():
    record = json.loads(run("fit", "H7/g6", "8 mm", "--json").output)
    (size,) = record["sizes"]
    fit = rt.fit("H7/g6", "8 mm")
    assert record["fit"] == "H7/g6"
    assert (size["radial"], size["tol"], tuple(size["hole"])) == (fit.radial, fit.tol, fit.hole)


def test_an_oil_is_printed_over_temperature():
    done = run("oil", "ISO VG 46", "40 degC", "-10 degC")
    assert done.exit_code == 0
    rows = [line.split() for line in done.output.splitlines()[2:4]]
    assert [row[0] for row in rows] == ["40", "-10"]
    assert rows[0][3] == "46"
    assert "assumed: viscosity index 95" in done.output


def test_an_oil_as_json_is_in_si_and_takes_what_is_known_of_it():
    words = ("--vi", "140", "--density", "860 kg/m^3", "--json", "333.15")
    record = json.loads(run("oil", "ISO VG 100", *words).output)
    oil = rt.oil({"vg": 100, "vi": 140, "density": 860})
    assert record["assumed"] == []
    assert record["temperatures"][0]["viscosity"] == oil.viscosity("60 degC")


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (("fit", "H7/p6", "8 mm"), "H7/p6"),
        (("fit", "H7/g6", "8 kg"), "is a mass"),
        (("fit", "H7/g6", "8 mm", "600 mm"), "outside"),
        (("fit", "H7/g6"), "DIAMETER"),
        (("oil", "ISO VG 47"), "did you mean ISO VG 46"),
        (("oil", "ISO VG 46", "60"), "write '60 degC'"),
        (("oil", "ISO VG 46", "--jsn"), "--jsn"),
    ],
)
def test_what_cannot_be_looked_up_ends_with_a_sentence(words, reason):
    done = run(*words)
    assert done.exit_code == 2
    assert reason in done.output
    assert "Traceback" not in done.output
