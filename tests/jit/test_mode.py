"""Machine code or plain Python: who chooses, what is said, and that a package without Numba misses nothing."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

import rattle
from rattle.cli.main import main
from rattle.jit import mode

SOURCES = str(Path(__file__).parents[2] / "src")
pytestmark = pytest.mark.nojit


def in_fresh_process(code, **environment):
    kept = {name: value for name, value in os.environ.items() if name != "RATTLE_JIT"}
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        env={**kept, "PYTHONPATH": SOURCES, **environment},
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


def test_the_environment_chooses(monkeypatch):
    monkeypatch.delenv("RATTLE_JIT", raising=False)
    assert mode.is_native()
    monkeypatch.setenv("RATTLE_JIT", "native")
    assert mode.is_native()
    monkeypatch.setenv("RATTLE_JIT", "python")
    assert not mode.is_native()
    monkeypatch.setenv("RATTLE_JIT", "plain")
    with pytest.raises(rattle.InputError, match="RATTLE_JIT is 'plain'; expected native or python, or nothing"):
        mode.is_native()


def test_the_command_tells_how_kernels_run(monkeypatch):
    monkeypatch.setenv("RATTLE_JIT", "native")
    said = CliRunner().invoke(main, ["--version"]).output
    assert f"version {rattle.__version__}" in said
    assert "kernels run as machine code" in said
    monkeypatch.setenv("RATTLE_JIT", "python")
    said = CliRunner().invoke(main, ["--version"]).output
    assert "kernels run as plain Python, some hundred times slower: RATTLE_JIT=python asks for it" in said


def test_an_unknown_mode_is_told_in_one_line():
    done = subprocess.run(
        [sys.executable, "-m", "rattle", "run", "fourbar", "--t-end", "0.001"],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": SOURCES, "RATTLE_JIT": "fast"},
        check=False,
    )
    assert done.returncode
    assert "RATTLE_JIT is 'fast'; expected native or python, or nothing" in done.stderr
    assert "Traceback" not in done.stderr


BROKEN = """
import logging
logging.getLogger("rattle").addHandler(logging.StreamHandler(__import__("sys").stdout))
{break_it}
from rattle.jit import functions, mode
from rattle.jit.functions import compiled
import numpy as np

@compiled
def twice(row, k):
    return 2.0 * row[k]

print("answer", functions.start(), functions.start(), twice(np.ones(3), 1), mode.described())
"""


@pytest.mark.parametrize(
    ("break_it", "said"),
    [
        ("import rattle.jit.machine as m; m.parsed = None", "not callable"),
        ("import rattle.jit.translation.unit as u; u._look_up = lambda table, k: 3.0", "its source is not there"),
        ("import rattle.jit.translation.unit as u; u.ABOUT = 'nonsense'", "parsing error"),
    ],
)
def test_with_an_llvm_that_does_not_do_what_is_needed_kernels_run_as_python(tmp_path, break_it, said):
    for _ in range(2):  # what has failed is not taken for tested by the next process
        words = " ".join(in_fresh_process(BROKEN.format(break_it=break_it), RATTLE_CACHE=str(tmp_path / "kept")))
        assert "answer False False 2.0" in words
        assert words.count("kernels run as plain Python, some hundred times slower: llvmlite") == 2  # log, described
        assert said in words


WITHOUT = """
import sys
class Refused:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] == "numba":
            raise ImportError("no Numba here")
sys.meta_path.insert(0, Refused())
import importlib, pkgutil
import rattle as rt
for one in pkgutil.walk_packages(rt.__path__, "rattle."):
    if not one.name.startswith(("rattle.__main__", "rattle.studio", "rattle.pages", "rattle.plots")):
        importlib.import_module(one.name)

@rt.load_law("blow", F="N")
def blow(t, state, p):
    return p.F, {}.get("fy", 0.0), 0.0

m = rt.Mechanism("block").body("block", mass=2, inertia=1, points={}).load("w", "blow", body="block", F=4)
r = m.simulate(0.5)
print(r.success, round(float(r["block.vx"][-1]), 9), rt.example("fourbar").ideal().kinematics([0.0, 1e-3]).success)
"""


@pytest.mark.machine
def test_the_package_works_without_numba():
    assert in_fresh_process(WITHOUT) == ["True", "1.0", "True"]
