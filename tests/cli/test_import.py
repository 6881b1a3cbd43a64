"""`rattle import`: a model file with the words on what was taken, assumed and left out; or one line, and no file."""

import re

import pytest
from click.testing import CliRunner

import rattle as rt
from foreign_texts import fourbar, pmks_fourbar, pylinkage
from rattle.cli.main import main


@pytest.fixture
def asked(tmp_path, monkeypatch):
    """Run `rattle import` in a folder with files of other programs."""
    monkeypatch.chdir(tmp_path)
    drawing = fourbar()
    drawing.forces = ["\t\tForceTorqueGeneral", "\t\t\tName", "\t\t\t\tGust"]
    for name, text in (("f.asmt", drawing.text()), ("a.pmks", f"pmks:{pmks_fourbar()}"), ("p.json", pylinkage())):
        (tmp_path / name).write_text(text)
    return lambda *words: CliRunner().invoke(main, ["import", *words])


@pytest.mark.parametrize(("file", "told"), [
    ("f.asmt", ("Part1, Part2, Part3", "Joint4", "Gust", "is 1 m", "1 kg")),
    ("a.pmks", ("AB, BC, CD", "20 rpm counter-clockwise", "lengths are in m")),
    ("p.json", ("crank, rod, rocker", "kg/m", "25 steps", "tracker")),
])  # fmt: skip
def test_a_model_file_is_written_and_all_is_told(asked, file, told):
    done = asked(file, "-o", "m.toml")
    assert done.exit_code == 0
    assert all(word in done.stdout for word in told), done.stdout
    assert done.stdout.splitlines()[-1] == "m.toml"
    assert rt.load("m.toml").to_toml() == rt.read(file).to_toml()
    assert asked(file, "-o", "m.json").exit_code == 0
    assert rt.load("m.json").model.bodies.keys() == rt.read(file).model.bodies.keys()


def test_without_a_file_name_the_text_is_printed_and_the_words_go_to_the_other_stream(asked):
    done = asked("a.pmks")
    assert done.stdout == rt.read("a.pmks").to_toml()
    assert "assumed" in done.stderr


def test_what_the_format_leaves_open_can_be_stated(asked):
    assert asked("p.json", "-o", "m.toml", "--scale", "1cm", "--steps-per-second", "50").exit_code == 0
    assert rt.load("m.toml").to_toml() == rt.read("p.json", scale=0.01, steps_per_second=50).to_toml()


@pytest.mark.parametrize(("words", "says"), [
    (("bad.asmt",), r"bad\.asmt:\d+: "), (("none.asmt",), "cannot read"), (("p.json", "--scale", "1kg"), "scale"),
    (("p.json", "--thickness", "1mm"), "thickness"), (("p.json", "-o", "m.txt"), r"\.toml"),
    (("p.json", "-o", "p.json"), "input file"),
])  # fmt: skip
def test_what_cannot_be_read_is_refused_in_one_line_and_nothing_is_written(asked, tmp_path, words, says):
    (tmp_path / "bad.asmt").write_text(fourbar().text()[:3000])
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    done = asked(*words, *(() if "-o" in words else ("-o", "m.toml")))
    assert done.exit_code == 2
    assert re.search(says, done.stderr)
    assert done.stderr.count("\n") == 1
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_a_model_file_becomes_one_of_the_other_kind(asked, tmp_path):
    (tmp_path / "m.json").write_text(rt.example("slider_crank").to_json())
    assert asked("m.json", "-o", "m.toml").exit_code == 0
    assert rt.load("m.toml").model.bodies.keys() == rt.example("slider_crank").model.bodies.keys()
