"""Models as C programs: what `rattle code` writes compiles without a warning and moves as `simulate` does."""

import io
import shutil
import subprocess

import numpy as np
import pytest
from click.testing import CliRunner

import rattle as rt
from rattle.cli.main import main

needs_cc = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
STRICT = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-O1"]


def written(tmp_path, *words):
    return CliRunner().invoke(main, ["code", *words, "-o", str(tmp_path / "model.c")])


def motion(tmp_path, *times):
    """The program's CSV: names and rows."""
    subprocess.run(["cc", *STRICT, tmp_path / "model.c", "-o", tmp_path / "model", "-lm"], check=True, timeout=300)
    done = subprocess.run([tmp_path / "model", *times], capture_output=True, text=True, check=True, timeout=60)
    return done.stdout.split("\n")[0].split(","), np.genfromtxt(io.StringIO(done.stdout), delimiter=",")[1:]


@needs_cc
@pytest.mark.parametrize(
    ("example", "span", "step"),
    [("fourbar", 0.02, 1e-5), ("five_bar", 0.05, 1e-4), ("double_pendulum", 0.5, 1e-4), ("windows", 0.1, 1e-4)],
)
def test_the_program_moves_as_the_same_method_in_the_package(example, span, step, tmp_path):
    """Same steps, same method; what is left is rounding, and the amount by which a motion amplifies it."""
    done = written(tmp_path, example)
    assert done.exit_code == 0, done.output
    names, rows = motion(tmp_path, str(span), str(step))
    assert rows[-1, 0] == pytest.approx(span, rel=1e-15)
    m = rt.example(example)
    run = m.simulate(t_eval=rows[:, 0], method="rk4", step=step)
    assert names[0] == "t"
    assert set(names[1:]) <= set(run.names)
    largest: dict[str, float] = {}  # of all curves of one unit: what rounding of a small one is measured by
    for name in names[1:]:
        largest[run.unit(name)] = max(largest.get(run.unit(name), 0.0), float(np.abs(run[name]).max()))
    for k, name in enumerate(names[1:], 1):
        scale = largest[run.unit(name)]
        assert np.abs(rows[:, k] - run[name]).max() <= 1e-10 * scale, name


@needs_cc
def test_the_program_says_what_it_takes_and_where_it_cannot_go_on(tmp_path):
    assert written(tmp_path, "double_pendulum").exit_code == 0
    motion(tmp_path, "0.1")
    for words in (["-1"], ["0.1", "0"], ["x"], ["20ms"], ["inf", "inf"], ["0.1", "1e-4", "3"]):
        done = subprocess.run([tmp_path / "model", *words], capture_output=True, text=True, timeout=60)
        assert done.returncode == 2
        assert "t_end" in done.stderr
    # a step of a second tears the pendulum's joints apart
    done = subprocess.run([tmp_path / "model", "20", "1"], capture_output=True, text=True, timeout=60)
    assert done.returncode == 1
    assert "choose a shorter one" in done.stderr or "singular position" in done.stderr


@pytest.mark.nojit
def test_what_has_no_straight_line_is_refused_with_the_reason(tmp_path):
    done = written(tmp_path, "woodpecker")
    assert done.exit_code == 2
    assert "contacts begin and end" in done.stderr
    assert "joints lower, upper, beak" in done.stderr
    done = written(tmp_path, "fourbar", "--set", "drivers.motor.angle=abs(t - 0.01)")
    assert done.exit_code == 2
    assert "drivers.motor" in done.stderr
    assert "smooth function" in done.stderr
    done = CliRunner().invoke(main, ["code", "fourbar", "-o", str(tmp_path / "model.js")])
    assert done.exit_code == 2
    assert "expected a name that ends in .c" in done.stderr
    assert not (tmp_path / "model.c").exists()


@pytest.mark.nojit
@pytest.mark.parametrize("example", ["scotch_yoke", "guide_play", "slider_crank_play", "bouncing_pin", "three_plays"])
def test_with_its_play_closed_a_mechanism_with_contacts_is_written(example, tmp_path):
    done = written(tmp_path, example, "--ideal")
    assert done.exit_code == 0, done.output
    assert (tmp_path / "model.c").stat().st_size > 5_000


@pytest.mark.nojit
def test_the_head_of_the_file_names_every_column_with_its_unit(tmp_path):
    assert written(tmp_path, "slider_crank").exit_code == 0
    text = (tmp_path / "model.c").read_text()
    for name in ("crank.omega [rad/s]", "O.fx [N]", "energy.kinetic [J]", "motor.torque [N*m]"):
        assert f"     {name}\n" in text


FREE = """
format = 1
[bodies.a]
points = { P = [0.2, 0] }
mass = 1
inertia = 0.1
[initial]
a = { vx = 1, omega = 2 }
[ground.points]
O = [0, 0]
[loads.m]
"""


@needs_cc
@pytest.mark.parametrize(
    ("load", "times", "why"),
    [
        ('type = "torque"\nbody = "a"\ntorque = "sqrt(0.1 - t)"', ["0.2", "0.002"], "no finite value"),
        ('type = "spring"\nconnect = ["ground.O", "a.P"]\nstiffness = 5e5', ["0.2", "0.002"], "energy error"),
    ],
)
def test_the_program_stops_where_a_run_does(load, times, why, tmp_path):
    (tmp_path / "free.toml").write_text(FREE + load)
    assert written(tmp_path, str(tmp_path / "free.toml")).exit_code == 0
    motion(tmp_path, "0.0001", "0.00001")
    done = subprocess.run([tmp_path / "model", *times], capture_output=True, text=True, timeout=60)
    assert done.returncode == 1
    assert why in done.stderr
    assert "nan" not in done.stdout
