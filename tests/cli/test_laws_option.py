"""`--laws FILE.py`: laws of the user's own on the command line, and what is said of files that cannot be used."""

import pytest
from click.testing import CliRunner

import rattle as rt
from rattle.cli.main import main
from rattle.elements.custom.law_file import run_law_file

pytestmark = [pytest.mark.nojit, pytest.mark.plain, pytest.mark.usefixtures("laws")]
LAWS = """
import math
import rattle as rt
from spring_data import STIFFNESS

@rt.load_law("gas spring", between="points", compiled=False, F0="N", rest="m")
def gas_spring(t, length, rate, p):
    return p.F0 + STIFFNESS * (p.rest - length)

@rt.friction_law("plateau", mu="")
def plateau(u, N, p):
    return p.mu * N
"""
LID = """
format = 1
gravity = [0, -9.81]
[ground.points]
O = [0, 0]
F = [0, -0.4]
[bodies.lid]
bar = ["O", "E"]
length = 1
mass = 2
[joints.hinge]
type = "revolute"
connect = ["ground.O", "lid.O"]
[loads.lift]
type = "gas spring"
connect = ["ground.F", "lid.E"]
F0 = "20 N"
rest = "0.5 m"
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my_laws.py").write_text(LAWS)
    (tmp_path / "spring_data.py").write_text("STIFFNESS = 30.0\n")  # modules beside the file can be imported
    (tmp_path / "lid.toml").write_text(LID)
    return tmp_path


def run(*words):
    return CliRunner().invoke(main, list(words))


@pytest.mark.parametrize("command", [("check",), ("equilibrium",), ("run", "--t-end", "1ms", "--no-horizon")])
def test_a_command_runs_the_laws_it_is_given_and_says_so(folder, command):
    done = run(*command, "lid.toml", "--laws", "my_laws.py")
    assert done.exit_code == 0, done.output
    assert "my_laws.py: its Python code was run; laws: load 'gas spring', friction law 'plateau'" in done.stderr


def test_without_its_laws_a_model_is_refused_and_no_code_is_run(folder):
    (folder / "my_laws.py").write_text("raise SystemExit('this must not run')")
    done = run("check", "lid.toml")
    assert done.exit_code == 2
    assert "unknown load 'gas spring'" in done.stderr


def test_law_of_a_file_has_the_force_that_it_says(folder):
    run_law_file(folder / "my_laws.py")
    m = rt.load(folder / "lid.toml").initial("lid", angle=0.0, omega=0)
    r = m.simulate(1e-3, t_eval=[0.0])
    length = (1 + 0.4**2) ** 0.5
    moment = (20 + 30 * (0.5 - length)) * 0.4 / length - 2 * 9.81 * 0.5
    assert r["lid.alpha"][0] == pytest.approx(moment / (2 / 3), rel=1e-9)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (None, "no file 'my_laws.py' with laws; expected a Python file"),
        ("x = 1\ny = 1/0\n", "my_laws.py, line 2: ZeroDivisionError: division by zero"),
        ("x = 1\ny = (\n", "my_laws.py, line 2: SyntaxError: '(' was never closed"),
        ("import sys\nsys.exit(3)\n", "my_laws.py, line 2: SystemExit: 3"),
        ("x = 1\n", "my_laws.py defines no law; write @rt.load_law(...)"),
        ("import rattle as rt\nrt.load_law('spring')(lambda t, s, p: 0)\n", "a built-in load has this name"),
    ],
)
def test_files_without_usable_laws_are_refused(folder, text, said):
    (folder / "my_laws.py").unlink()
    if text is not None:
        (folder / "my_laws.py").write_text(text)
    done = run("check", "lid.toml", "--laws", "my_laws.py")
    assert done.exit_code == 2
    assert said in done.stderr
    assert "Traceback" not in done.output
