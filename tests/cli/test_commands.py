"""What the commands that need no analysis of their own write: contents, units and exit status, on small results."""

import csv
import json
import os
import re
import shutil
import subprocess
import sys
import tomllib
import xml.etree.ElementTree as ET
from contextlib import suppress

import jsonschema
import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image

import rattle as rt
from circling import circling
from rattle import registry
from rattle.cli.main import main
from rattle.jit import folder, functions
from rattle.language.materials import MATERIALS
from rattle.language.units import parse_quantity

nojit = pytest.mark.nojit


def run(*words):
    return CliRunner().invoke(main, [str(word) for word in words])


def refused(*words, saying):
    """The command ends with status 2, a reason on stderr and no traceback."""
    done = run(*words)
    assert done.exit_code == 2, done.output
    assert saying in done.stderr
    assert "Traceback" not in done.output


@pytest.fixture
def saved(tmp_path):
    """A result of 61 outputs: a pin that circles in its bush."""
    result = circling(61)
    result.save(tmp_path / "out.nc")
    return tmp_path / "out.nc", result


# ---------------------------------------------------------------- example, kinds, schema
@nojit
def test_example_lists_every_shipped_model_with_its_title():
    done = run("example")
    assert done.exit_code == 0
    listed = dict(line.split(maxsplit=1) for line in done.stdout.splitlines())
    assert listed == {name: rt.example(name).name for name in rt.examples()}


@nojit
@pytest.mark.parametrize("name", sorted(rt.examples()))
def test_example_prints_the_file_as_it_is(name):
    done = run("example", name)
    assert done.exit_code == 0
    text = rt.examples()[name].read_text(encoding="utf-8")
    assert (done.stdout == text) == ("file = " not in text)
    assert rt.loads(done.stdout).name == rt.example(name).name  # complete, wherever it is


@nojit
@pytest.mark.plain
def test_example_writes_a_model_file_with_its_tables_beside_it(tmp_path):
    done = run("example", "piston_engine", "-o", tmp_path / "engine.toml")
    assert done.exit_code == 0
    assert done.stdout.split() == [str(tmp_path / "engine.toml"), str(tmp_path / "indicator.csv")]
    shipped = rt.examples()["piston_engine"]
    assert (tmp_path / "engine.toml").read_text(encoding="utf-8") == shipped.read_text(encoding="utf-8")
    assert rt.load(tmp_path / "engine.toml").to_toml() == rt.example("piston_engine").to_toml()
    refused("example", "-o", tmp_path / "all.toml", saying="-o needs the name of an example")
    refused("example", "piston_engine", "-o", tmp_path / "no" / "a.toml", saying="create it first")


@nojit
def test_example_without_such_a_model_suggests_one():
    refused("example", "forbar", saying="no example 'forbar'; did you mean 'fourbar'")


@nojit
def test_kinds_lists_every_kind_of_every_family_with_its_summary():
    done = run("kinds")
    assert done.exit_code == 0
    for family in registry.families():
        for name, one in registry.kinds(family).items():
            assert f"  {name}: {one.summary}" in done.stdout.splitlines()
    for topic in ("units", "functions", "materials"):
        assert re.search(rf"^{topic}: ", done.stdout, re.MULTILINE)


@nojit
def test_kinds_of_one_name_gives_fields_with_units_defaults_and_source():
    done = run("kinds", "spring")
    assert done.exit_code == 0
    fields = registry.kinds("load")["spring"].fields
    for key, one in fields.items():
        (line,) = [line for line in done.stdout.splitlines() if line.split()[:1] == [key]]
        assert one.meaning in line
        assert f"[{one.unit}]" in line or one.shape != "number"
    assert "source: " in done.stdout
    family = run("kinds", "friction")
    assert [line[2:].partition(":")[0] for line in family.stdout.splitlines() if re.match(r"  \S", line)] == [
        *registry.kinds("friction")
    ]
    refused("kinds", "sprung", saying="no kind 'sprung'; did you mean 'spring'?")


@nojit
def test_kinds_gives_one_material_with_its_modulus_in_gigapascals():
    done = run("kinds", "bronze")
    assert done.exit_code == 0
    value = re.search(r"E = ([\d.]+) GPa", done.stdout)
    assert value, done.stdout
    assert parse_quantity(f"{value[1]} GPa")[0] == pytest.approx(MATERIALS["bronze"].E)
    assert str(MATERIALS["bronze"].nu) in done.stdout


@nojit
@pytest.mark.plain
def test_schema_is_a_schema_that_takes_examples_and_refuses_a_slip():
    done = run("schema")
    assert done.exit_code == 0
    made = json.loads(done.stdout)
    jsonschema.Draft202012Validator.check_schema(made)
    validator = jsonschema.Draft202012Validator(made)
    for name in ("fourbar_oil", "piston_engine", "dc_motor_pid", "marble_run"):
        validator.validate(tomllib.loads(rt.examples()[name].read_text(encoding="utf-8")))
    wrong = tomllib.loads(rt.examples()["fourbar"].read_text(encoding="utf-8"))
    wrong["joints"]["O3"]["clearence"] = "1 mm"
    assert any("clearence" in one.message for one in validator.iter_errors(wrong))


# ---------------------------------------------------------------- check
@nojit
def test_check_counts_degrees_of_freedom_and_says_what_the_four_bar_is():
    done = run("check", "fourbar")
    assert done.exit_code == 0
    assert "3 bodies, 4 joints, mobility 2" in done.stdout  # 3 x 3 - 2 x 2 pins - 2 links of length c - the driver
    assert "play: O3 5 mm, massless-link" in done.stdout
    record = json.loads(run("check", "fourbar", "--ideal", "--json").stdout)
    assert record["mobility"] == 0  # 3 x 3 - 4 x 2 - 1
    assert record["residual"] < 1e-12
    driven = run("check", "fourbar", "--ideal").stdout
    assert "driver: motor can turn fully" in driven  # Grashof: 0.2 + 0.81 < 0.6 + 0.6
    assert "clearance" not in driven


@nojit
def test_check_refuses_a_model_with_every_fault_its_line_and_a_caret(tmp_path):
    file = tmp_path / "bad.toml"
    text = rt.examples()["fourbar"].read_text(encoding="utf-8")
    file.write_text(text.replace('clearance = "r3"', 'clearance = "5 kg"').replace('length = "l2"', 'lenght = "l2"'))
    done = run("check", file)
    assert done.exit_code == 2
    lines = file.read_text().splitlines()
    for word, said in (('"5 kg"', "is a mass; expected a length in m"), ("lenght", "did you mean")):
        number = next(n for n, line in enumerate(lines, 1) if word in line)
        assert re.search(rf"bad\.toml:{number}: .*{said}", done.stderr), done.stderr
    assert done.stderr.count("^") >= 2
    refused("check", tmp_path / "none.toml", saying="none.toml")


# ---------------------------------------------------------------- plot, animate, export
@nojit
def test_plot_without_names_lists_all_with_units(saved):
    path, result = saved
    done = run("plot", path)
    assert done.exit_code == 0
    listed = dict(re.fullmatch(r"(\S+)  \[(.*)\]", line).groups() for line in done.stdout.splitlines())
    assert listed == {name: result.unit(name) or "-" for name in result.names}


@nojit
def test_plot_draws_the_curve_that_the_result_holds(saved, tmp_path):
    path, _ = saved
    done = run("plot", path, "arm.x", "arm.y", "-o", tmp_path / "curve.svg")
    assert done.exit_code == 0, done.output
    assert done.stdout.strip() == str(tmp_path / "curve.svg")
    drawn = (tmp_path / "curve.svg").read_text(encoding="utf-8")
    ET.fromstring(drawn)
    for word in ("arm.x", "arm.y", "time [s]", "length [m]", "after the horizon"):
        assert word in drawn, word
    orbit = run("plot", path, "--orbit", "O", "-o", tmp_path / "orbit.png")
    assert orbit.exit_code == 0, orbit.output
    with Image.open(tmp_path / "orbit.png") as picture:
        grey = np.asarray(picture.convert("L"))
    assert 0.002 < (grey < 200).mean() < 0.5  # lines on white, neither empty nor black
    refused("plot", path, "nosuch", "-o", tmp_path / "x.svg", saying="the result has no 'nosuch'")
    refused("plot", path, "arm.x", "-o", tmp_path / "x.xyz", saying=".svg")
    assert not (tmp_path / "x.svg").exists()


@nojit
def test_animate_writes_as_many_different_frames_as_asked(saved, tmp_path):
    path, _ = saved
    film = tmp_path / "film.gif"
    done = run("animate", path, "-o", film, "--frames", "5", "--trace", "arm.P")
    assert done.exit_code == 0, done.output
    assert done.stdout.strip() == str(film)
    with Image.open(film) as frames:
        assert frames.n_frames == 5
        seen = set()
        for n in range(5):
            frames.seek(n)
            seen.add(frames.convert("RGB").tobytes())
    assert len(seen) == 5  # the pin goes round once: no two positions are alike
    refused("animate", path, "-o", tmp_path / "film.avi", saying=".gif")
    refused("animate", path, "-o", film, "--trace", "nosuch.P", saying="nosuch")


@nojit
def test_export_writes_every_number_with_its_unit_and_all_digits(saved, tmp_path):
    path, result = saved
    done = run("export", path, "-o", tmp_path / "out.csv")
    assert done.exit_code == 0, done.output
    head, *rows = csv.reader((tmp_path / "out.csv").read_text(encoding="utf-8").splitlines())
    units = dict(re.fullmatch(r"(\S+)(?: \[(.*)\])?", one).groups() for one in head)
    assert units["t"] == "s"
    columns = np.array(rows, dtype=float).T
    for name, column in zip(units, columns, strict=True):
        expected = result.t if name == "t" else result[name]
        np.testing.assert_array_equal(column, expected)  # written with 17 digits
        assert name == "t" or units[name] == (result.unit(name) or None)
    for suffix in (".npz", ".nc"):
        assert run("export", path, "-o", tmp_path / f"copy{suffix}").exit_code == 0
        again = rt.load_result(tmp_path / f"copy{suffix}")
        assert again.names == result.names
        np.testing.assert_array_equal(again["arm.x"], result["arm.x"])
    refused("export", tmp_path / "none.nc", "-o", tmp_path / "out.csv", saying="none.nc")


# ---------------------------------------------------------------- demo, warmup
@pytest.mark.long
def test_demo_shows_what_play_does_to_the_forces_of_the_paper(tmp_path):
    done = run("-q", "demo", "--paper", "-o", tmp_path / "pictures")
    assert done.exit_code == 0, done.output
    made = {path.name for path in (tmp_path / "pictures").iterdir()}
    assert made == {"fourbar-figures.png", "orbit-O3.png", "orbit-O4.png", "fourbar.csv", "fourbar.gif"}
    assert all(str(tmp_path / "pictures" / name) in done.stdout for name in made)
    with_play, without = done.stdout.split("without play")
    peak = {
        part: {
            line.split()[0]: float(line.split()[1]) for line in text.splitlines() if re.match(r"O\d +[\d.]+ N", line)
        }
        for part, text in (("play", with_play), ("ideal", without))
    }
    assert set(peak["play"]) == set(peak["ideal"]) == {"O1", "O2", "O3", "O4"}
    assert all(peak["play"][joint] > 10 * peak["ideal"][joint] for joint in peak["play"])  # the paper's finding
    table = np.genfromtxt(tmp_path / "pictures" / "fourbar.csv", delimiter=",", names=True, deletechars="")
    names = [name for name in table.dtype.names if name.startswith("O3.e")]
    offset = np.hypot(*(table[name] for name in names))
    np.testing.assert_allclose(offset, 0.005, atol=1e-12)  # [m]: a massless link keeps the pin on the wall


def test_demo_shows_how_far_two_loose_pins_put_a_point_off_its_path(tmp_path):
    done = run("-q", "demo", "-o", tmp_path / "demo")
    assert done.exit_code == 0, done.output
    made = {path.name for path in (tmp_path / "demo").iterdir()}
    assert made == {"crank-rocker.png", "crank-rocker.html", "crank-rocker.csv"}
    m = rt.example("crank_rocker_play")
    r, ideal = m.simulate(), m.ideal().simulate()
    off = 1e3 * np.hypot(*(r[f"coupler.P.{axis}"] - ideal[f"coupler.P.{axis}"] for axis in "xy"))
    assert f"P is {off.min():.2f} to {off.max():.2f} mm off its path" in done.stdout
    assert "\ntrusted over the whole run\n" in done.stdout
    assert "constraint error" not in done.stdout
    told = run("-q", "demo", "--why", "-o", tmp_path / "demo")
    assert "constraint error" in told.stdout
    assert r.trust.pulled == {"A": 0.0, "B": 0.0}  # a mechanism of which every word holds


@nojit
def test_warmup_says_where_nothing_is_to_be_compiled():
    environment = {**os.environ, "RATTLE_JIT": "python"}
    done = subprocess.run(
        [sys.executable, "-m", "rattle", "warmup"], capture_output=True, text=True, env=environment, timeout=120
    )
    assert done.returncode == 0
    assert (
        "kernels run as plain Python, some hundred times slower: RATTLE_JIT=python asks for it; there is nothing to"
        in done.stdout
    )


@pytest.mark.skipif(os.name != "posix", reason="access rights of POSIX")
def test_warmup_fails_where_nothing_would_be_kept(tmp_path):
    tmp_path.chmod(0o777)
    environment = {**os.environ, "RATTLE_CACHE": str(tmp_path)}
    done = subprocess.run(
        [sys.executable, "-m", "rattle", "warmup"], capture_output=True, text=True, env=environment, timeout=120
    )
    assert done.returncode == 1
    assert "kernels are ready" not in done.stdout
    assert "RATTLE_CACHE" in done.stderr


def test_after_warmup_a_run_compiles_nothing(tmp_path):
    if not functions.start():
        pytest.skip("runs without machine code")
    done = run("warmup")
    assert done.exit_code == 0, done.output
    place = re.search(r"kernels are ready in (.*) \(([\d.]+) s\)", done.stdout)
    assert place, done.stdout
    warm = folder.cache_folder()
    assert str(warm) == place[1]
    mine = tmp_path / "cache" / warm.name  # other tests compile meanwhile
    mine.mkdir(mode=0o700, parents=True)
    for path in warm.iterdir():
        with suppress(FileNotFoundError):
            shutil.copy2(path, mine)
    kept = {path.name: path.stat().st_mtime_ns for path in mine.iterdir()}
    assert len(kept) > 20
    script = (
        "import rattle as rt; rt.example('fourbar').simulate(1e-3); rt.example('balanced_arm').modes();"
        "[rt.example(name).simulate(1e-4) for name in ('guide_play', 'slider_crank_play', 'toggle', 'woodpecker')];"
        "rt.example('slider_crank_play').lyapunov(1e-2);"
        "rt.example('path_generator').ideal().inverse_dynamics([0.0, 0.1])"
    )
    environment = {**os.environ, "RATTLE_CACHE": str(mine.parent)}
    subprocess.run([sys.executable, "-c", script], check=True, timeout=300, cwd=tmp_path, env=environment)
    assert {path.name: path.stat().st_mtime_ns for path in mine.iterdir()} == kept
