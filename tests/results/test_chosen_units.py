"""Units that a user asks for: numbers and names of units change together, nothing else does."""

import csv
import math

import numpy as np
import pytest
from click.testing import CliRunner

import rattle as rt
from rattle.cli.main import main
from rattle.errors import InputError
from rattle.language.units import dimension_of, unit_of_quantity
from rattle.results.chosen_units import choose, chosen, read_units

UNITS = "mm,deg,N"


@pytest.fixture(scope="module")
def motion():
    """Positions of the slider-crank over 6 ms."""
    return rt.example("slider_crank").kinematics(np.linspace(0.0, 6e-3, 7))


def run(*arguments):
    return CliRunner().invoke(main, [*map(str, arguments)])


def columns(path):
    head, *rows = csv.reader(path.open(encoding="utf-8"))
    return dict(zip(head, np.array(rows, dtype=float).T, strict=True))


@pytest.mark.nojit
@pytest.mark.parametrize(
    ("asked", "unit", "factor", "name"),
    [
        ("mm", "m", 1e3, "mm"),
        ("mm", "m/s^2", 1e3, "mm/s^2"),
        ("mm", "m^3", 1e9, "mm^3"),
        ("cm,ms", "m/s", 100.0, "cm/s"),
        ("deg", "rad/s", 180.0 / math.pi, "deg/s"),
        ("deg,rpm", "rad/s", 30.0 / math.pi, "rpm"),
        ("deg/s", "rad/s", 180.0 / math.pi, "deg/s"),
        ("mm,deg", "rad/m", 0.18 / math.pi, "deg/mm"),
        ("mJ", "J", 1e3, "mJ"),
        ("Nmm", "N*m", 1e3, "Nmm"),
        ("kN,mm", "N/m", 1e-6, "kN/mm"),
    ],
)
def test_a_unit_stands_for_its_kind_and_for_what_is_derived_from_it(asked, unit, factor, name):
    shown = read_units(asked).unit_for(unit)
    assert shown.unit == name
    assert shown.factor == pytest.approx(factor, rel=1e-12)


@pytest.mark.nojit
@pytest.mark.parametrize(
    ("asked", "unit"), [("mm,deg,N", "N*m"), ("N*mm", "J"), ("J", "N*m"), ("mm", "rad"), ("ms", "1/s")]
)
def test_other_kinds_are_left_alone(asked, unit):
    assert read_units(asked).unit_for(unit) is None


@pytest.mark.nojit
@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ("mm,cm", "mm and cm are units of the same kind"),
        ("deg,mrad", "same kind"),
        ("furlong", "unknown unit 'furlong'"),
        ("mm,,N", "a name is missing"),
        ("si,mm", "si stands alone"),
        ("1", "plain number"),
    ],
)
def test_units_that_mean_nothing_are_refused(asked, words):
    with pytest.raises(InputError, match=words):
        read_units(asked)


@pytest.mark.nojit
def test_names_of_derived_units_are_units_of_the_same_size():
    choice = read_units("mm,kN,ms")
    for unit in ("m", "N", "s", "m/s", "m/s^2", "m^2", "N/m", "N/m^1.5", "m^3/s"):
        shown = choice.unit_for(unit)
        assert dimension_of(shown.unit) == dimension_of(unit)
        assert unit_of_quantity(f"1 {shown.unit}")[0] * shown.factor == pytest.approx(1.0)


def test_a_file_and_a_data_frame_are_in_si_unless_asked(motion, tmp_path):
    plain, asked = columns(motion.to_csv(tmp_path / "a.csv")), columns(motion.to_csv(tmp_path / "b.csv", units=UNITS))
    assert np.array_equal(plain["rod.x [m]"], motion["rod.x"])
    np.testing.assert_allclose(asked["rod.x [mm]"], 1e3 * motion["rod.x"], rtol=1e-14)
    np.testing.assert_allclose(asked["rod.angle [deg]"], np.degrees(motion["rod.angle"]), rtol=1e-14)
    np.testing.assert_allclose(asked["rod.vx [mm/s]"], 1e3 * motion["rod.vx"], rtol=1e-14)
    assert np.array_equal(asked["t [s]"], motion.t)
    assert np.array_equal(motion.to_dataframe()["rod.x"], motion["rod.x"])
    frame = motion.to_dataframe(units=UNITS)
    np.testing.assert_allclose(frame["rod.x"], 1e3 * motion["rod.x"], rtol=1e-14)
    assert frame.attrs["units"]["rod.x"] == "mm"


def test_a_command_shows_and_writes_the_units_asked_for_and_forgets_them(tmp_path):
    span = ("--t-end", "6 ms", "--points", "7")
    done = run("kinematics", "slider_crank", *span, "--units", "cm,rad", "--csv", tmp_path / "k.csv")
    assert done.exit_code == 0, done.output
    slider = next(line for line in done.output.splitlines() if line.startswith("slider.x"))
    assert slider.split()[1:3] == ["7", "cm"]
    assert "deg" not in done.output
    assert columns(tmp_path / "k.csv")["slider.x [cm]"][0] == pytest.approx(17.0)
    assert chosen("m") is None
    assert "70 mm" in run("kinematics", "slider_crank", *span).output


def test_json_is_in_si_whatever_is_asked():
    span = ("--t-end", "6 ms", "--points", "7", "--json")
    assert (
        run("kinematics", "slider_crank", *span, "--units", UNITS).output
        == run("kinematics", "slider_crank", *span).output
    )


def test_si_shows_si():
    output = run("accuracy", "crank_rocker_play", "--of", "rocker.angle", "--t-end", "50 ms", "--units", "si").output
    assert "rad" in output
    assert "0.0005 m" in output
    assert "deg" not in output


def test_an_unknown_unit_is_refused_before_the_run():
    done = run("run", "slider_crank", "--units", "parsec")
    assert done.exit_code == 2
    assert "unknown unit 'parsec'" in done.output


def test_a_joint_that_bears_nothing_but_rounding_shows_no_force():
    row = next(line for line in run("run", "ratchet", "--no-horizon").output.splitlines() if line.startswith("guide "))
    assert row.split() == ["guide", "0", "N", "-", "0", "N"]


@pytest.mark.parametrize("word", ["1 kN", "1kN", "1*kN", "1 mm"])
def test_a_quantity_is_no_unit(word):
    with pytest.raises(InputError, match="not a unit"):
        read_units(word)


@pytest.mark.parametrize(("word", "factor"), [("1/ms", 1e-3), ("N / mm", 1e-3), ("µm", 1e6), ("kN*m", 1e-3)])
def test_a_formula_of_units_is_one(word, factor):
    (shown,) = read_units(word).units.values()
    assert shown.factor == pytest.approx(factor)


def test_the_force_on_an_orbit_is_in_the_unit_that_is_asked_for():
    result = rt.example("fourbar").simulate(t_end=5e-3)
    before = choose(read_units("kN,um"))
    try:
        figure = result.plot_orbit("O3")
        words = str(rt.example("fourbar").check())
    finally:
        choose(before)
    bar = next(ax for ax in figure.axes if "normal force" in ax.get_ylabel())
    assert "[kN]" in bar.get_ylabel()
    assert bar.get_ylim()[1] < 0.01 * np.abs(result["O3.normal"]).max()
    assert any(ax.get_xlabel().endswith("[µm]") for ax in figure.axes)
    assert "O3 5000 um" in words
