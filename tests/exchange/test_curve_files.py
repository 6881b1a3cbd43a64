"""Results as workbooks and MATLAB files: every number, name and unit is there, and a reader of its own finds it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.io import loadmat

import rattle as rt
from rattle.errors import InputError
from rattle.exchange import result_workbook, workbook
from rattle.results.event import Event, Peak
from rattle.results.result import Result, UnknownName
from rattle.results.trust import Trust
from workbooks import read_workbook

pytestmark = pytest.mark.nojit
T = np.array([0.0, 0.1, 0.2])
JOINTS = ("pin", "curves", "x" * 40 + "1", "x" * 40 + "2")


def a_result(t: np.ndarray = T, **more: object) -> Result:
    names = ["bar.angle", "ratio", *(f"{joint}.moment" for joint in JOINTS)]
    data = np.arange(1.0, 1 + len(t) * len(names)).reshape(len(t), len(names)) / 3
    if len(t) == 3:
        data[1, 0], data[2, 1] = np.nan, np.inf
    joints = {joint: {"type": "revolute"} for joint in JOINTS}
    document = {"parameters": {"l": "300 mm", "n": {"value": 2, "description": "teeth"}}}
    record = {
        "t": t, "data": data, "names": names, "units": dict.fromkeys(names, "N*m") | {"bar.angle": "rad", "ratio": ""},
        "geometry": {"bodies": {}, "ground": {"points": {}}, "joints": joints, "loads": {}, "driven": []},
        "trust": Trust(drift=1e-15, t_end=0.2), "stats": {},
        "provenance": {"model": "test", "parameters": {"l": 0.3, "n": 2.0}, "document": json.dumps(document)},
        "events": [Event(0.05, "pin", "impact", 0.5, impulse=2.0)], "peaks": {"pin.moment": Peak(9.0, 0.15, 4.0)},
    }  # fmt: skip
    return Result(**{**record, **more})  # type: ignore[arg-type]


def sheets(result: Result, folder: Path, **options: object) -> dict[str, list[list[object]]]:
    result.to_excel(folder / "r.xlsx", **options)  # type: ignore[arg-type]
    return read_workbook((folder / "r.xlsx").read_bytes())


def test_each_joint_has_a_sheet_with_its_curves_over_time(tmp_path: Path) -> None:
    r = a_result()
    tables = sheets(r, tmp_path)
    assert tables["curves"][0] == ["t [s]", "bar.angle [rad]", "ratio"]
    assert tables["pin"] == [["t [s]", "pin.moment [N*m]"], *([t, y] for t, y in zip(T, r["pin.moment"], strict=True))]
    assert tables["curves (joint)"][0] == ["t [s]", "curves.moment [N*m]"]
    assert sum(name.startswith("xxx") for name in tables) == 2  # both names are too long, and alike where they are cut
    assert tables["curves"][2][1] is None  # nan
    assert tables["curves"][3][2] == "inf"


def test_parameters_trust_events_and_peaks_have_sheets(tmp_path: Path) -> None:
    tables = sheets(a_result(), tmp_path)
    assert tables["parameters"][1:] == [["l", 0.3, "m", "300 mm", None], ["n", 2.0, None, "2", "teeth"]]
    assert tables["trust"][1][:2] == ["trust", a_result().trust.word.partition(" (")[0]]
    assert tables["events"][1][:4] == [0.05, "pin", "impact", 0.5]
    assert tables["peaks"][1] == ["pin.moment", 9.0, "N*m", 0.15, 4.0]


def test_units_that_are_asked_for_stand_in_the_head(tmp_path: Path) -> None:
    r = a_result()
    tables = sheets(r, tmp_path, units="deg,ms,kN*m,mm", names=["bar.angle", "pin.moment"])
    assert tables["curves"][0] == ["t [ms]", "bar.angle [deg]"]
    assert tables["curves"][1][1] == pytest.approx(np.rad2deg(r["bar.angle"][0]), rel=1e-15)
    assert tables["pin"][3] == pytest.approx([200.0, r["pin.moment"][2] / 1000], rel=1e-15)
    assert tables["parameters"][1][:3] == ["l", pytest.approx(300.0), "mm"]
    assert [*tables] == ["curves", "pin", "peaks", "events", "parameters", "trust"]


def test_curves_that_no_sheet_holds_go_on_in_another(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(result_workbook, "MOST_COLUMNS", 2)
    tables = sheets(a_result(), tmp_path)
    assert tables["curves"][0] == ["t [s]", "bar.angle [rad]"]
    assert tables["curves 2"][0] == ["t [s]", "ratio"]


def test_more_instants_than_a_sheet_holds_are_refused_and_nothing_is_written(tmp_path: Path) -> None:
    r = a_result(np.linspace(0.0, 1.0, workbook.MOST_ROWS))
    with pytest.raises(InputError, match=r"1048576 instants of .* write \.csv or \.mat"):
        r.to_excel(tmp_path / "r.xlsx")
    assert not [*tmp_path.iterdir()]


def test_mat_files_hold_a_struct_with_every_curve_bit_by_bit(tmp_path: Path) -> None:
    r = a_result()
    r.to_mat(tmp_path / "r.mat")
    held = loadmat(tmp_path / "r.mat", squeeze_me=True, struct_as_record=False)["r"]
    assert held.names.tolist() == list(r.names)
    assert [unit if isinstance(unit, str) else "" for unit in held.units] == [r.unit(name) for name in r.names]
    assert np.array_equal(held.t, T)
    assert np.array_equal(held.values, np.column_stack([r[name] for name in r.names]), equal_nan=True)
    assert held.events.kind == "impact"
    assert held.parameters.values.tolist() == [0.3, 2.0]
    assert loadmat(tmp_path / "r.mat")["r"]["t"][0, 0].shape == (3, 1)
    assert loadmat(tmp_path / "r.mat")["r"]["names"][0, 0].dtype == object  # a cell, no matrix of characters


@pytest.mark.parametrize("instants", [0, 1])
@pytest.mark.parametrize("suffix", [".xlsx", ".mat"])
def test_results_with_no_or_one_instant_are_written(tmp_path: Path, instants: int, suffix: str) -> None:
    r = a_result(T[:instants], events=(), peaks={}, provenance={})
    path = tmp_path / f"r{suffix}"
    (r.to_excel if suffix == ".xlsx" else r.to_mat)(path)
    if suffix == ".mat":
        assert loadmat(path)["r"]["values"][0, 0].shape == (instants, len(r.names))
    else:
        assert len(read_workbook(path.read_bytes())["pin"]) == 1 + instants


@pytest.mark.parametrize("name", ["r.xlsx", "r.mat"])
def test_the_same_result_gives_the_same_file(tmp_path: Path, name: str) -> None:
    files = [tmp_path / folder / name for folder in ("a", "b")]
    for file in files:
        file.parent.mkdir()
        (a_result().to_excel if name == "r.xlsx" else a_result().to_mat)(file)
    assert files[0].read_bytes() == files[1].read_bytes()
    assert b"Created on" not in files[0].read_bytes()


@pytest.mark.parametrize(("write", "suffix"), [(Result.to_excel, "xlsx"), (Result.to_mat, "mat")])
def test_wrong_names_are_refused_and_nothing_is_written(tmp_path: Path, write: object, suffix: str) -> None:
    with pytest.raises(InputError, match=f"needs a name ending in .{suffix}"):
        write(a_result(), tmp_path / "r.xls")  # type: ignore[operator]
    with pytest.raises(UnknownName, match=r"did you mean 'pin\.moment'"):
        write(a_result(), tmp_path / f"r.{suffix}", names=["pin.momnet"])  # type: ignore[operator]
    assert not [*tmp_path.iterdir()]


def test_a_run_writes_what_other_programs_read(tmp_path: Path) -> None:
    r = rt.example("slider_crank").simulate("5 ms")
    tables = sheets(r, tmp_path)
    column = tables["curves"][0].index("rod.angle [rad]")
    assert [row[column] for row in tables["curves"][1:]] == r["rod.angle"].tolist()
    assert {"O", "A", "B"} <= {*tables}
