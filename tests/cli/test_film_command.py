"""`rattle film`: a table of static positions, the point of a load, chart and file."""

import csv
import math

import pytest
from click.testing import CliRunner

import rattle as rt
from rattle.cli.main import main

pytestmark = [pytest.mark.nojit, pytest.mark.plain]
BEARING = ("--viscosity", "50 mPa*s", "--length", "10 mm", "--radius", "10 mm", "--clearance", "50 um")
LOAD = ("--load", "500 N", "--speed", "1000 rpm")


def run(*arguments):
    return CliRunner().invoke(main, ["film", *map(str, arguments)])


def test_the_table_and_the_point_of_a_load():
    done = run(*BEARING, *LOAD)
    assert done.exit_code == 0, done.output
    p = rt.Film("50 mPa*s", "10 mm", "10 mm", "50 um").static("500 N", "1000 rpm")
    said = {line.split("  ")[1]: line for line in done.output.splitlines() if line.startswith("  ") and line[2] != " "}
    assert f"{p.eccentricity:.5f}" in said["eccentricity"]
    assert f"{math.degrees(p.attitude):.3f} deg" in said["attitude"]
    assert f"{1e6 * p.film_thickness:.4g} um" in said["least film"]
    rows = [line.split() for line in done.output.splitlines() if line.strip().startswith("0.")]
    row = rt.Film("50 mPa*s", "10 mm", "10 mm", "50 um").table([0.5]).iloc[0]
    assert next(one for one in rows if one[0] == "0.50")[1] == f"{row['sommerfeld']:.4g}"
    assert "never" in done.output  # a thin film does not whirl


def test_chart_and_file(tmp_path):
    chart, table = tmp_path / "chart.svg", tmp_path / "table.csv"
    assert run(*BEARING, *LOAD, "-o", chart).exit_code == 0
    assert "Sommerfeld number" in chart.read_text(encoding="utf-8")
    assert run(*BEARING, "--model", "short", "-o", table).exit_code == 0
    rows = list(csv.DictReader(table.open(encoding="utf-8")))
    # tan(attitude) = pi s/(4 e)
    e = float(rows[3]["eccentricity"])
    assert float(rows[3]["attitude"]) == pytest.approx(math.atan2(math.pi * math.sqrt(1 - e * e), 4 * e), rel=1e-12)


def test_stribeck_curve_in_lines_and_as_a_chart(tmp_path):
    chart = tmp_path / "stribeck.svg"
    done = run(*BEARING, "--load", "500 N", "--boundary-film", "1 um", "-o", chart)
    assert done.exit_code == 0, done.output
    rows = [
        line.split()
        for line in done.output.partition("Stribeck")[2].splitlines()
        if line.endswith(" um") and "%" in line
    ]
    assert len(rows) > 8
    assert float(rows[0][1]) == pytest.approx(0.099, abs=1e-3)
    assert "coefficient of friction" in chart.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ((), "missing --viscosity, --length, --radius, --clearance; or take them from a model"),
        (("--of", "slider_crank_oil", "--viscosity", "1"), "the model says that already"),
        (("--joint", "B", *BEARING), "give --of FILE"),
        (("--of", "fourbar"), "this needs a joint with oil"),
        ((*BEARING, "--boundary-film", "1 um"), "needs --load"),
    ],
)
def test_a_bearing_comes_from_sizes_or_from_a_model(given, said):
    done = run(*given)
    assert done.exit_code == 2
    assert said in done.output


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (("--load", "500 N"), "needs both, --load and --speed"),
        (("--model", "long"), "no film 'long'"),
        (("--clearance", "1 mm"), "at most 0.02"),
        (("-o", "film.xlsx"), "written as .csv, or as a picture"),
    ],
)
def test_what_makes_no_sense_is_refused(more, said):
    bearing = BEARING[: BEARING.index(more[0])] if more[0] in BEARING else BEARING
    done = run(*bearing, *more)
    assert done.exit_code == 2
    assert said in done.output
