"""Two ways to machine code: when which is taken, that both give the same numbers, and what others see of them."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

import rattle
from rattle.cli.main import main
from rattle.jit import compile_path, folder, functions

SOURCES = str(Path(__file__).parents[2] / "src")


def in_fresh_process(code, **environment):
    kept = {name: value for name, value in os.environ.items() if name not in ("RATTLE_JIT", "NUMBA_DISABLE_JIT")}
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        env={**kept, "PYTHONPATH": SOURCES, **environment},
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


@pytest.fixture
def _no_choice(monkeypatch):
    """Nothing is chosen yet, and what the test chooses is forgotten."""
    monkeypatch.delenv("RATTLE_JIT", raising=False)
    monkeypatch.setattr(compile_path, "_failed", [])
    compile_path._by_environment.cache_clear()
    yield
    compile_path._by_environment.cache_clear()


# ---------------------------------------------------------------- which way
@pytest.mark.nojit
@pytest.mark.usefixtures("_no_choice")
def test_the_environment_chooses(monkeypatch):
    assert compile_path.chosen().fast
    monkeypatch.setenv("RATTLE_JIT", "plain")
    compile_path._by_environment.cache_clear()
    assert compile_path.chosen() == (False, "RATTLE_JIT=plain asks for it")
    compile_path._by_environment.cache_clear()
    monkeypatch.setenv("RATTLE_JIT", "quick")
    with pytest.raises(ValueError, match="expected fast or plain"):
        compile_path.chosen()


@pytest.mark.nojit
@pytest.mark.usefixtures("_no_choice")
def test_code_of_the_two_ways_is_kept_apart(monkeypatch, tmp_path):
    monkeypatch.setenv("RATTLE_CACHE", str(tmp_path / "kept"))
    monkeypatch.setattr(folder, "_code_folder", None)
    fast = folder.code_folder()
    monkeypatch.setenv("RATTLE_JIT", "plain")
    compile_path._by_environment.cache_clear()
    folder.forget_folder()
    plain = folder.code_folder()
    assert fast.lasting
    assert plain.lasting
    assert fast.path != plain.path


@pytest.mark.nojit
@pytest.mark.usefixtures("_no_choice")
def test_the_command_tells_how_kernels_are_compiled(monkeypatch):
    said = CliRunner().invoke(main, ["--version"]).output
    assert f"version {rattle.__version__}" in said
    assert "functions are compiled the fast way" in said
    monkeypatch.setenv("RATTLE_JIT", "plain")
    compile_path._by_environment.cache_clear()
    said = CliRunner().invoke(main, ["--version"]).output
    assert "functions are compiled the plain way, which takes longer: RATTLE_JIT=plain asks for it" in said


BROKEN = """
import logging
logging.getLogger("rattle").addHandler(logging.StreamHandler(__import__("sys").stdout))
logging.getLogger("rattle").setLevel(logging.INFO)
{break_it}
from rattle.jit import compile_path, functions
from rattle.jit.functions import compiled
import numpy as np

@compiled
def twice(row, k):
    return 2.0 * row[k]

functions.start()
print("answer", twice(np.ones(3), 1), compile_path.chosen().fast, compile_path.described())
"""


@pytest.mark.parametrize(
    ("break_it", "said"),
    [
        ("import rattle.jit.machine as m; m.parsed = None", "not callable"),
        ("import rattle.jit.translation.unit as u; u._look_up = lambda table, k: 3.0", "is not there"),
        ("import rattle.jit.translation.unit as u; u.ABOUT = 'nonsense'", "parsing error"),
    ],
)
def test_an_llvm_without_what_the_fast_way_needs_is_used_the_plain_way(tmp_path, break_it, said):
    for _ in range(2):  # what has failed is not taken for checked by the next process
        words = " ".join(in_fresh_process(BROKEN.format(break_it=break_it), RATTLE_CACHE=str(tmp_path / "kept")))
        assert "answer 2.0 False" in words
        assert said in words


# ---------------------------------------------------------------- the same numbers
RUNS = """
import hashlib
import numpy as np
import rattle as rt
from rattle.jit import compile_path
print(compile_path.chosen().fast)
r = rt.example("fourbar").simulate(0.05, horizon=False)
assert len(r.t) > 20
curves = [r[name] for name in r.names]
print(hashlib.sha256(b"".join(np.ascontiguousarray(one).tobytes() for one in curves)).hexdigest())
"""


@pytest.mark.long
def test_both_ways_give_the_same_bits():
    if not functions.start():
        pytest.skip("runs without machine code")
    fast, plain = in_fresh_process(RUNS, RATTLE_JIT="fast"), in_fresh_process(RUNS, RATTLE_JIT="plain")
    assert [fast[0], plain[0]] == ["True", "False"]
    assert fast[1] == plain[1]


# ---------------------------------------------------------------- what others see
SEEN = """
import gc, threading
import numba
from numba.core.typing.templates import builtin_registry
levels, seen, stopped = (numba.config.OPT, gc.get_threshold(), gc.isenabled()), set(), threading.Event()
def watch():
    while not stopped.wait(1e-3):
        seen.add((numba.config.OPT, gc.get_threshold(), gc.isenabled()))
thread = threading.Thread(target=watch)
thread.start()
import rattle as rt
rt.example("double_pendulum").simulate(1e-3, horizon=False)
stopped.set()
thread.join()
templates = [one for _, kind in builtin_registry.globals for one in getattr(kind, "templates", ())]
ours = [one for one in templates if any(part.__module__.startswith("rattle.") for part in one.__mro__)]
print(seen == {levels}, len(templates) > 100, len(ours))
"""


@pytest.mark.long
@pytest.mark.parametrize("way", ["fast", "plain"])
def test_compiling_changes_no_setting_and_no_operator_of_others(way, tmp_path):
    if not functions.start():
        pytest.skip("runs without machine code")
    unchanged, looked, entered = in_fresh_process(SEEN, RATTLE_JIT=way, RATTLE_CACHE=str(tmp_path / "kept"))
    assert (unchanged, looked, entered) == ("True", "True", "0")
