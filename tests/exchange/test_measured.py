"""Measured curves beside a run: which curve a column belongs to, offsets, and what they differ by."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import rattle as rt
from rattle.errors import InputError
from rattle.exchange.measured import measured_curves, read_wanted, without_folder
from rattle.results.event import Breaks
from rattle.results.result import Result
from rattle.results.trust import Trust

pytestmark = pytest.mark.nojit
UNITS = {"rocker.angle": "rad", "rocker.omega": "rad/s", "O3.fx": "N", "O3.fy": "N", "M": "N*m", "E": "J", "ratio": ""}


@pytest.fixture
def bench(tmp_path: Path) -> str:
    text = "t [ms];theta [deg];force [kN];M [N*m];ratio;n [rpm]\n0;180;1;7;2;60\n100;90;2;8;3;0\n"
    (tmp_path / "bench.csv").write_text(text, encoding="utf-8")
    return str(tmp_path / "bench.csv")


def test_a_column_is_in_the_si_unit_of_its_curve_and_on_the_time_of_the_run(bench: str) -> None:
    (curve,) = measured_curves(f"{bench}:theta=rocker.angle@-20 ms", UNITS)
    assert curve.t.tolist() == pytest.approx([-0.02, 0.08], rel=1e-15)
    assert curve.values.tolist() == pytest.approx([np.pi, np.pi / 2], rel=1e-15)
    assert curve.label == "theta (bench.csv)"


@pytest.mark.parametrize(
    ("shown", "belong"),
    [
        (("rocker.angle",), {"theta": "rocker.angle"}),  # the only one of its unit
        (("rocker.omega", "O3.fx"), {"n": "rocker.omega", "force": "O3.fx"}),
        (("E", "M"), {"M": "M"}),  # its own name; what is in joules is no moment
        ((), {"M": "M", "ratio": "ratio"}),  # nothing is shown: those of the same name
        (("O3.fx", "O3.fy", "M"), {"M": "M"}),  # two forces: neither
    ],
)
def test_columns_belong_to_the_curve_of_their_name_or_the_only_one_of_their_unit(
    bench: str, shown: tuple[str, ...], belong: dict[str, str]
) -> None:
    assert {curve.column: curve.curve for curve in measured_curves(bench, UNITS, shown)} == belong


def test_a_column_without_a_unit_is_in_that_of_its_curve(tmp_path: Path) -> None:
    (tmp_path / "m.csv").write_text("t,a\n0,1\n")
    (curve,) = measured_curves(f"{tmp_path / 'm.csv'}:a=rocker.angle", UNITS)
    assert (curve.values.tolist(), curve.unitless) == ([1.0], True)


@pytest.mark.parametrize("unit", ["1/min", "Hz", "1/s"])
def test_a_frequency_is_not_taken_for_an_angular_velocity(tmp_path: Path, unit: str) -> None:
    """3000 1/min may be 3000 turns or 3000 radians per minute."""
    (tmp_path / "m.csv").write_text(f"t,n [{unit}]\n0,3000\n")
    with pytest.raises(InputError, match="leaves open whether turns or radians are meant"):
        measured_curves(f"{tmp_path / 'm.csv'}:n=rocker.omega", UNITS)


@pytest.mark.parametrize(("unit", "value"), [("rpm", np.pi / 30), ("rev/s", 2 * np.pi), ("°/s", np.pi / 180)])
def test_angular_velocities_have_units_of_turning(tmp_path: Path, unit: str, value: float) -> None:
    (tmp_path / "m.csv").write_text(f"t,n [{unit}]\n0,1\n", encoding="utf-8")
    (curve,) = measured_curves(str(tmp_path / "m.csv"), UNITS, ["rocker.omega"])
    assert curve.values[0] == pytest.approx(value, rel=1e-15)


def test_a_unit_in_round_brackets_is_refused_under_the_name_before_it(tmp_path: Path) -> None:
    (tmp_path / "m.csv").write_text("t,force (kN)\n0,1\n")
    with pytest.raises(InputError, match=r"write the unit in square brackets, 'force \[kN\]'"):
        measured_curves(f"{tmp_path / 'm.csv'}:force=O3.fx", UNITS)


def test_words_and_counters_beside_a_column_with_the_unit_are_not_taken_for_the_curve(tmp_path: Path) -> None:
    (tmp_path / "m.csv").write_text("t;count;note;a [deg]\n0;1;x;180\n")
    (curve,) = measured_curves(str(tmp_path / "m.csv"), UNITS, ["rocker.angle"])
    assert (curve.column, curve.values.tolist()) == ("a", [np.pi])


def test_columns_that_could_both_be_meant_are_refused(tmp_path: Path) -> None:
    (tmp_path / "m.csv").write_text("t,a [deg],b [deg]\n0,1,2\n")
    with pytest.raises(
        InputError, match=r"a \[deg\] and b \[deg\] may both be rocker.angle; say which, such as m.csv:b="
    ):
        measured_curves(str(tmp_path / "m.csv"), UNITS, ["rocker.angle"])


@pytest.mark.parametrize(
    ("behind", "words"),
    [
        (":theta", "belongs to no curve; say which, such as bench.csv:theta="),
        (":thta=rocker.angle", "no column 'thta'; did you mean 'theta'"),
        (":theta=rocker.agle", "has no curve 'rocker.agle'; did you mean 'rocker.angle'"),
        (":theta=O3.fx", "'theta .deg.' is a plain number or angle; O3.fx is in N"),
        (":force=ratio", "'force .kN.' is a force; ratio is in no unit"),
        (":", "a name of a column is missing"),
        (":theta=", "the name of a curve is missing"),
        ("@3 kg", "is a mass; expected a time"),
        ("", "no column belongs to a curve that is shown"),
    ],
)
def test_what_does_not_fit_is_refused(bench: str, behind: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        measured_curves(bench + behind, UNITS, ["O3.fx", "O3.fy"])


def test_signs_in_names_of_files_and_columns_are_told_from_those_of_the_text(tmp_path: Path) -> None:
    name = tmp_path / "a:b@1s=c.csv"
    name.write_text("t [s],x=y@z:1 [m],q [m]\n0,1,2\n")
    assert read_wanted(str(name)).column == ""
    (curve,) = measured_curves(f"{name}:x=y@z:1=p@0.5", {"p": "m"})
    assert (curve.column, curve.curve, curve.t.tolist()) == ("x=y@z:1", "p", [0.5])
    assert read_wanted(f"{name}@2s").offset == 2.0
    assert without_folder(f"{tmp_path}/./{name.name}:x=y@z:1=p@0.5") == f"{name.name}:x=y@z:1=p@0.5"
    with pytest.raises(InputError, match=r"there is no file 'none\.csv'"):
        read_wanted("none.csv:x=y@2s")


def a_result(breaks: Breaks | None = None) -> Result:
    t = np.linspace(0.0, 1.0, 11)
    return Result(
        t=t, data=np.column_stack([t**3]), names=["x"], units={"x": "m"}, trust=Trust(drift=0.0), stats={},
        provenance={}, geometry={"bodies": {}, "ground": {"points": {}}, "joints": {}, "loads": {}, "driven": []},
        breaks=breaks,
    )  # fmt: skip


def test_a_curve_measured_without_error_differs_by_nothing_at_any_sampling(tmp_path: Path) -> None:
    """Outputs lie 0.1 s apart: straight lines between them would be off by up to 7e-3."""
    t = np.random.default_rng(3).uniform(0.0, 1.0, 100)
    t.sort()
    np.savetxt(tmp_path / "m.csv", np.column_stack([1e3 * t, 1e3 * t**3]), delimiter=",", header="t [ms],x [mm]")
    (part,) = a_result().residuals(tmp_path / "m.csv")
    assert (len(part.t), part.count) == (100, 100)
    assert part.rms < 1e-12


def test_the_residual_is_measured_minus_computed_within_the_run_only(tmp_path: Path) -> None:
    (tmp_path / "m.csv").write_text("t [s],x [m]\n-0.5,9\n0.5,0.225\n1,0.8\n1.0001,9\n")
    (part,) = a_result().residuals(str(tmp_path / "m.csv"))
    assert part.t.tolist() == [0.5, 1.0]
    assert part.residual == pytest.approx([0.1, -0.2], abs=1e-14)
    assert part.rms == pytest.approx(np.sqrt((0.1**2 + 0.2**2) / 2), rel=1e-12)
    assert part.largest == pytest.approx(0.2, rel=1e-12)
    assert part.told() == ["rms of the difference 0.158 m", "2 of 4 values within the run"]
    (later,) = a_result().residuals(f"{tmp_path / 'm.csv'}@0.5s")
    assert later.t.tolist() == [0.0, 1.0]
    with pytest.raises(InputError, match=r"none of the times of x, 1\.5 to 3\.0001 s, is within the run, 0 to 1 s"):
        a_result().residuals(f"{tmp_path / 'm.csv'}@2s")


def test_an_impact_between_two_outputs_is_no_difference(tmp_path: Path) -> None:
    """Beside a jump the run has its values just before and just after."""
    t = np.linspace(0.0, 1.0, 11)
    jump = Breaks(np.array([0.45, 0.45]), np.array([[0.45], [-1.0]]))
    r = Result(
        t=t, data=np.where(t < 0.45, t, -1.0)[:, None], names=["x"], units={"x": "m"}, trust=Trust(drift=0.0), stats={},
        provenance={}, geometry=a_result().geometry, breaks=jump,
    )  # fmt: skip
    (tmp_path / "m.csv").write_text("t [s],x [m]\n0.44,0.44\n0.46,-1\n")
    assert r.residuals(str(tmp_path / "m.csv"))[0].largest < 1e-12


def test_pictures_show_measured_values_as_dots_and_what_they_differ_by(tmp_path: Path) -> None:
    (tmp_path / "m.csv").write_text("t [s],u [mm]\n0.5,225\n1,800\n2,0\n")
    figure = a_result().plot("x", measured=f"{tmp_path / 'm.csv'}:u")
    above, below = figure.axes
    dots = next(line for line in above.lines if line.get_label() == "u (m.csv)")
    assert np.asarray(dots.get_xydata()) == pytest.approx(np.array([[0.5, 0.225], [1.0, 0.8]]))
    assert np.asarray(below.lines[0].get_ydata()) == pytest.approx([100.0, -200.0])  # short lengths are in mm
    words = below.get_legend().get_texts()[0].get_text()
    assert "rms of the difference 158 mm" in words
    assert "2 of 3 values within the run" in words
    assert a_result().plot(measured=f"{tmp_path / 'm.csv'}:u=x").axes[0].get_ylabel() == above.get_ylabel()


def test_a_csv_that_rattle_wrote_is_a_measured_curve(tmp_path: Path) -> None:
    r = rt.example("double_pendulum").simulate("20 ms")
    r.to_csv(tmp_path / "r.csv", units="deg,ms", names=["upper.angle", "lower.x"])
    parts = r.residuals(tmp_path / "r.csv", ["upper.angle"])
    assert [part.curve for part in parts] == ["upper.angle"]
    assert parts[0].largest < 1e-14
    assert parts[0].count == len(r.t)
