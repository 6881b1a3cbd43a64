"""A result answers by name, says how far to trust it, and survives being written to disk."""

import csv
import os
import sys

import numpy as np
import pytest
import xarray

from circling import OMEGA, STEADY, SWING, T_END, C, circling
from rattle.atomic_file import atomic
from rattle.results.contact_summary import joint_table
from rattle.results.result import load_result
from rattle.results.trust import Trust

pytestmark = pytest.mark.nojit


# ---------------------------------------------------------------- by name
def test_named_point_is_carried_by_its_body():
    r = circling()
    dx, dy = r["arm.P.x"] - r["arm.x"], r["arm.P.y"] - r["arm.y"]
    assert np.hypot(dx, dy) == pytest.approx(np.hypot(0.1, 0.05), rel=1e-14)
    turned = np.unwrap(np.arctan2(dy, dx)) - np.arctan2(0.05, 0.1)
    assert turned == pytest.approx(r["arm.angle"], abs=1e-13)
    assert r.unit("arm.P.x") == "m"


def test_joint_force_is_the_size_of_its_vector():
    r = circling()
    assert r["O.force"] == pytest.approx(np.abs(r["O.normal"]), abs=1e-12)
    assert r.unit("O.force") == "N"


def test_every_name_answers():
    r = circling()
    assert {"arm.x", "lift", "arm.P.y", "O.force"} <= set(r.names)
    assert all(r[name].shape == r.t.shape and name in r and isinstance(r.unit(name), str) for name in r.names)


@pytest.mark.parametrize(("wrong", "meant"), [("arm.P.z", "arm.P.x"), ("O.norml", "O.normal"), ("lfit", "lift")])
def test_unknown_name_is_a_key_error_with_suggestions(wrong, meant):
    with pytest.raises(KeyError) as caught:
        circling()[wrong]
    assert meant in str(caught.value)
    assert wrong in str(caught.value)


def test_numbers_of_a_result_cannot_be_changed():
    with pytest.raises(ValueError, match="read-only"):
        circling()["arm.x"][0] = 1.0


def test_joint_table_has_peak_and_rms_of_the_known_force():
    line = joint_table(circling(4001)).splitlines()[1]
    rms = np.sqrt(STEADY**2 + SWING**2 / 2)  # of STEADY + SWING cos a over whole rounds
    assert f"{STEADY + SWING:.4g} N" in line
    assert f"{rms:.4g} N" in line
    assert line.split()[-12:-8] == ["67", "%", "0", "1"]  # presses while cos a > -1/2; no contact, one impact


# ---------------------------------------------------------------- trust
def test_trust_says_pulling_in_plain_words():
    measured = {"drift": 3e-15, "drift_joint": "O4", "energy_balance": 2e-9, "t_end": 2.0, "horizon": 0.31}
    assert str(Trust(**measured, pulled={"O4": 0.21}, first_pull={"O4": 0.0})).splitlines() == [
        "constraint error 3e-15 m (worst at O4), energy error 2e-9 J; "
        "the curves can be trusted up to t = 0.31 s (horizon), after it statistics only",
        "O4 would have to pull for 21 % of the run, first at t = 0: "
        "the pin would lift off; this model does not hold there",
    ]


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"horizon": None}, "was not computed (horizon=True"),
        ({"horizon": 2.0}, "over the whole run"),
        ({"horizon": 0.0, "t_end": 0.0}, "the curves can be trusted at t = 0 s"),  # one position
        ({"horizon": 0.0, "t_end": 0.0, "stopped": True}, "up to t = 0 s (horizon)"),
        # a sleeve that jams on two corners: how they share the load is not determined, where the sleeve is is
        (
            {"horizon": 0.1, "horizon_motion": 2.0, "horizon_curve": "J.normal"},
            "positions and rates can be trusted over the whole run, to t = 2 s, all other curves up to t = 0.1 s"
            " (J.normal deviates first)",
        ),
        ({"horizon": 0.6, "horizon_motion": 1.0, "horizon_curve": "J.normal"}, "up to t = 0.6 s (horizon), after it"),
        ({"horizon": 1.9, "horizon_motion": 1.9, "stopped": True}, "up to where the run ended, t = 2 s"),
        ({}, "constraint error 1e-12 m\n"),  # nothing to remark: no word on play where there is none
        ({"pulled": {"A": 0.0, "B": 0.0}}, "A and B would never have to pull"),
        (
            {"pulled": {"A": 0.002, "B": 0.3}, "first_pull": {"A": 1.5, "B": 0.1}},
            "B would have to pull for 30 % of the run, first at t = 0.1 s, "
            "and A for less than 1 % of the run, first at t = 1.5 s: these pins",
        ),
        ({"pulled": dict.fromkeys("ABCDE", 0.5)}, "2 more pins"),
        ({"nonunique": ("A", "B")}, "reactions not unique (redundant constraints) at A, B"),
        ({"notes": ("driver near a dead centre",)}, "driver near a dead centre"),
        ({"drift_joint": "", "notes": ("x",)}, "constraint error 1e-12 m;"),
    ],
)
def test_trust_is_two_lines_in_every_case(given, said):
    text = str(Trust(**{"drift": 1e-12, "t_end": 2.0} | given))
    assert said in text
    assert len(text.splitlines()) == 2


# ---------------------------------------------------------------- on disk
@pytest.mark.parametrize("suffix", ["nc", "npz"])
@pytest.mark.parametrize("n", [401, 1])
def test_saved_result_comes_back_bit_by_bit(tmp_path, suffix, n):
    r = circling(n)
    assert r.save(tmp_path / f"r.{suffix}") == tmp_path / f"r.{suffix}"
    back = load_result(tmp_path / f"r.{suffix}")
    assert back.names == r.names
    assert all(np.array_equal(back[name], r[name]) and back.unit(name) == r.unit(name) for name in r.names)
    assert np.array_equal(back.t, r.t)
    assert (back.geometry, back.events, back.stats, back.provenance) == (r.geometry, r.events, r.stats, r.provenance)
    assert (back.success, back.message, str(back.trust)) == (r.success, r.message, str(r.trust))
    assert np.array_equal(back.trust.intervals["O"], r.trust.intervals["O"])


def test_saved_result_is_plain_netcdf_with_units(tmp_path):
    circling().save(tmp_path / "r.nc")
    with xarray.open_dataset(tmp_path / "r.nc") as plain:
        assert plain["O.normal"].attrs["units"] == "N"
        assert plain["O.normal"].dims == ("t",)
        assert plain["t"].values[-1] == T_END


def test_csv_has_units_in_its_header_and_full_precision(tmp_path):
    r = circling(11)
    r.to_csv(tmp_path / "r.csv")
    header, *rows = csv.reader((tmp_path / "r.csv").open(encoding="utf-8"))
    assert header[:3] == ["t [s]", "arm.x [m]", "arm.y [m]"]
    assert "lift" in header  # a bare number has no unit
    values = np.array(rows, float).T
    assert np.array_equal(values[0], r.t)
    assert all(np.array_equal(values[k + 1], r[name]) for k, name in enumerate(r.names))


def test_frames_carry_names_and_units():
    r = circling()
    frame, dataset = r.to_dataframe(), r.to_xarray()
    assert frame["O.normal"].loc[T_END] == pytest.approx(STEADY + SWING)
    assert frame.attrs["units"]["O.normal"] == dataset["O.normal"].attrs["units"] == "N"
    late = dataset["arm.y"].sel(t=T_END / 8, method="nearest")
    assert float(late) == pytest.approx(C * np.sin(OMEGA * T_END / 8), abs=1e-15)


def test_a_write_that_fails_leaves_the_older_file_and_nothing_else(tmp_path):
    target = tmp_path / "out.csv"
    target.write_text("old")

    def interrupted():
        with atomic(target) as file:
            file.write_text("half of the n")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert target.read_text() == "old"
    assert list(tmp_path.iterdir()) == [target]


def test_errors_of_the_disk_name_the_file(tmp_path):
    target = tmp_path / "out.csv"

    def full():
        with atomic(target):
            raise OSError(28, "No space left on device")

    with pytest.raises(OSError, match=r"cannot write .*out\.csv: No space left on device"):
        full()


def test_places_that_cannot_be_written_say_why(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    r = circling(3)
    with pytest.raises(FileNotFoundError, match=r"folder .*nowhere does not exist"):
        r.to_csv(tmp_path / "nowhere" / "r.csv")
    with pytest.raises(NotADirectoryError, match="is not a folder"):
        r.to_csv(tmp_path / "file" / "r.csv")
    with pytest.raises(IsADirectoryError, match="give a file name"):
        r.save(tmp_path.rename(tmp_path.with_suffix(".nc")))
    monkeypatch.setattr(os, "access", lambda *_: False)
    with pytest.raises(PermissionError, match="no permission"):
        r.to_csv(tmp_path.with_suffix(".nc") / "r.csv")


def test_files_that_are_no_result_are_refused(tmp_path):
    text, other = tmp_path / "text.nc", tmp_path / "other.nc"
    text.write_text("t,x\n0,1\n")
    xarray.Dataset({"x": ("t", [1.0])}).to_netcdf(other, engine="h5netcdf")
    for file in (text, other):
        with pytest.raises(ValueError, match="not a result of rattle"):
            load_result(file)
    with pytest.raises(FileNotFoundError, match="no such file"):
        load_result(tmp_path / "none.nc")
    with pytest.raises(ValueError, match=r"saved as \.nc \(netCDF\) or \.npz"):
        circling(3).save(tmp_path / "r.csv")
    for name in ("r.xlsx", "r.nc", "r.npz"):
        with pytest.raises(ValueError, match=r"give a name ending in \.csv"):
            circling(3).to_csv(tmp_path / name)


@pytest.mark.parametrize(("module", "use"), [("h5py", "save"), ("h5netcdf", "save"), ("pandas", "to_dataframe")])
def test_a_missing_extra_says_what_to_install(tmp_path, monkeypatch, module, use):
    monkeypatch.setitem(sys.modules, module, None)
    r = circling(3)
    with pytest.raises(ImportError, match="pip install h5netcdf h5py xarray pandas"):
        r.save(tmp_path / "r.nc") if use == "save" else r.to_dataframe()
    assert list(tmp_path.iterdir()) == []
