"""`--with` of commands that show curves: measured ones beside them."""

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import rattle as rt
from rattle.cli.main import main

pytestmark = pytest.mark.nojit


def call(*words):
    return CliRunner().invoke(main, [str(word) for word in words])


@pytest.fixture(scope="module")
def bench(tmp_path_factory) -> Path:
    """A folder with a result, and with what was measured: 1 deg more, 20 ms later, decimal commas."""
    folder = tmp_path_factory.mktemp("bench")
    r = rt.example("double_pendulum").simulate("0.1 s")
    r.save(folder / "r.npz")
    rows = zip(1e3 * (r.t[::7] - 0.02), np.rad2deg(r["upper.angle"][::7]) + 1.0, strict=True)
    text = "t [ms];theta [deg]\r\n" + "".join(f"{t!r};{y!r}\r\n" for t, y in ((float(t), float(y)) for t, y in rows))
    (folder / "m.csv").write_text(text.replace(".", ","), encoding="utf-8", newline="")
    return folder


def test_a_measured_curve_stands_in_the_picture_and_its_difference_is_told(bench):
    done = call(
        "plot", bench / "r.npz", "upper.angle", "--with", f"{bench / 'm.csv'}:theta@20ms", "-o", bench / "p.svg"
    )
    assert done.exit_code == 0, done.output
    assert "theta (m.csv) beside upper.angle: rms of the difference 1 deg" in done.stderr
    picture = (bench / "p.svg").read_text(encoding="utf-8")
    assert ">theta (m.csv)<" in picture
    assert ">rms of the difference 1 deg<" in picture


def test_the_curve_that_it_belongs_to_need_not_be_named_twice(bench):
    words = ("plot", bench / "r.npz", "--with", f"{bench / 'm.csv'}:theta=upper.angle@20ms", "-o", bench / "q.svg")
    assert call(*words).exit_code == 0
    assert ">upper.angle<" in (bench / "q.svg").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("with_", "more", "words"),
    [
        ("m.csv:theta", ("upper.angle", "lower.angle"), "'theta [deg]' belongs to no curve; say which"),
        ("m.csv:theta=upper.x", (), "'theta [deg]' is a plain number or angle; upper.x is in m"),
        ("m.csv", ("upper.angle", "--spectrum"), "leave --with out"),
        ("m.csv@1h", ("upper.angle",), "an offset such as @0.2s moves them"),
        ("none.csv", ("upper.angle",), "there is no file 'none.csv'"),
    ],
)
def test_what_does_not_fit_is_refused_and_nothing_is_drawn(bench, monkeypatch, with_, more, words):
    monkeypatch.chdir(bench)
    done = call("plot", "r.npz", *more, "--with", with_, "-o", "never.svg")
    assert done.exit_code == 2
    assert words in done.output
    assert not (bench / "never.svg").exists()


@pytest.mark.machine
def test_a_report_names_the_measured_file_without_its_folder(tmp_path):
    (tmp_path / "m.csv").write_text("t [ms];phi [deg]\n0;0,5\n4;-20,5\n", encoding="utf-8")
    words = ("slider_crank", "--t-end", "5ms", "--with", f"{tmp_path}/./m.csv:phi=rod.angle")
    done = call("-q", "report", *words, "-o", tmp_path / "r.html")
    assert done.exit_code == 0, done.output
    text = (tmp_path / "r.html").read_text(encoding="utf-8")
    assert "--with m.csv:phi=rod.angle" in text
    assert str(tmp_path) not in text
