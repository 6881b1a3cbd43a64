"""`rattle sensitivity`: its table in the units of the user, its files, its refusals."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

import rattle as rt
from rattle.cli.main import main

pytestmark = pytest.mark.nojit


def run(*words):
    return CliRunner().invoke(main, ["-q", "sensitivity", *words])


def test_the_table_compares_changes_of_all_parameters_in_the_unit_of_the_curve(tmp_path):
    file = tmp_path / "s.npz"
    words = ("fourbar", "--of", "rocker.angle", "--to", "M,r3", "--t-end", "10ms", "--points", "11")
    seen = run(*words, "-o", str(file))
    assert seen.exit_code == 0, seen.output
    head, first, second, *rest = seen.stdout.splitlines()
    assert head.split() == ["by", "largest", "derivative", "at", "t", "a", "change", "by", "moves", "it", "by"]
    s = rt.load_result(file)
    by_r3, by_M = s["d(rocker.angle)/d(r3)"], s["d(rocker.angle)/d(M)"]
    assert first.split()[:2] == ["d(rocker.angle)", "r3"]  # the larger effect stands first
    assert second.split()[0] == "M"
    k = np.argmax(np.abs(by_r3))
    degrees = np.rad2deg(by_r3[k]) / 1000
    assert f"{degrees:.4g} deg/mm" in first
    assert "0.5 mm (tolerance)" in first
    assert f"{0.5 * degrees:.3g} deg" in first
    k = np.argmax(np.abs(by_M))
    assert f"{np.rad2deg(by_M[k]):.4g} deg/(N*m)" in second
    assert "0.4 N*m (1 %)" in second
    assert "trusted over the whole run" in "\n".join(rest)
    record = json.loads(run(*words, "--json").stdout)
    entry = next(one for one in record["sensitivities"] if one["to"] == "r3")
    assert entry["largest"] == by_r3[np.argmax(np.abs(by_r3))]
    assert entry["effect"] == entry["largest"] * 0.0005


def test_files_hold_the_curves_or_a_drawing_of_the_effects(tmp_path):
    words = ("slider_crank", "--ideal", "--analysis", "kinematics", "--of", "slider.x,rod.B.y", "--points", "5")
    table, picture = tmp_path / "s.csv", tmp_path / "s.svg"
    assert run(*words, "-o", str(table)).exit_code == 0
    header = table.read_text().splitlines()[0].split(",")
    assert header[:3] == ["t [s]", "slider.x [m]", "rod.B.y [m]"]
    assert "d(slider.x)/d(rod_length) [m/m]" in header
    seen = run(*words, "--to", "rod_length", "-o", str(picture))
    assert seen.exit_code == 0
    drawn = picture.read_text()
    assert "change of slider.x" in drawn
    assert "rod_length by 0.02 mm (tolerance)" in drawn
    assert str(picture) in seen.stdout


def test_an_equilibrium_is_one_instant_or_a_path():
    words = ("balanced_arm", "--analysis", "equilibrium", "--of", "arm.angle", "--to", "angle")
    seen = run(*words)
    assert seen.exit_code == 0
    assert "the equilibrium is stable" in seen.stdout
    line = seen.stdout.splitlines()[1]
    assert " 57.3 deg " in line  # the spring is made for the angle: 1 rad more of one is 1 rad more of the other
    assert run(*words, "--t-end", "1", "--points", "3").exit_code == 0


def test_a_result_that_cannot_be_saved_goes_to_the_fallback_folder(tmp_path, monkeypatch):
    from rattle.results import result

    def full(path, *given):
        if path.parent == tmp_path:
            raise OSError(28, "No space left on device")
        path.write_bytes(b"")

    monkeypatch.setattr(result.archive, "write", full)
    (tmp_path / "other").mkdir()
    words = ("slider_crank", "--ideal", "--analysis", "kinematics", "--of", "slider.x", "--points", "5")
    seen = run(*words, "-o", str(tmp_path / "s.npz"))
    assert seen.exit_code == 2
    assert "--fallback FOLDER names another place" in seen.output  # an option of this command:
    seen = run(*words, "-o", str(tmp_path / "s.npz"), "--fallback", str(tmp_path / "other"))
    assert seen.exit_code == 0
    assert (tmp_path / "other" / "s.npz").exists()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("slider_crank_oil --of slider.x --to c", "contacts with oil"),
        ("fourbar --of rocker.angel --to r3", "did you mean 'rocker.angle'"),
        ("fourbar --of rocker.angle --to r33", "no parameter 'r33'; did you mean 'r3'"),
        ("fourbar --of rocker.angle --to r3 --t-end 0", "--t-end must be positive"),
        (
            "fourbar --of rocker.angle --to r3 -o s.gif",
            "s.gif: curves and derivatives are saved as .nc, .npz or .csv, a drawing as .svg, .png, .pdf",
        ),
        ("fourbar --of rocker.angle --to r3 -o s.npz --fallback nowhere", "--fallback needs a folder"),
        ("fourbar --of rocker.angle --to r3 --at 0.1", "--at is of one equilibrium"),
        ("balanced_arm --analysis equilibrium --of arm.angle --to angle --at 0 --t-end 1", "and no --t-end"),
        ("balanced_arm --analysis equilibrium --of arm.angle --to angle --points 5", "--points is of a path"),
        ("fourbar --of rocker.angle --to r3 --analysis kinematics", "close it with ideal"),
    ],
)
def test_bad_input_is_refused_with_the_reason(words, said):
    seen = run(*words.split())
    assert seen.exit_code == 2
    assert said in seen.output
