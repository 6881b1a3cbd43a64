"""The first use in a process: from several threads at once, and whether the compiler runs for short work too."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parents[1]

TOGETHER = """
import sys, threading
import numpy as np
import rattle as rt
order = sys.argv[1]
failed = []
analyses = {
    "e": lambda: [rt.example("balanced_arm").equilibrium() for _ in range(3)],
    "s": lambda: rt.example("fourbar").simulate(0.001),
    "k": lambda: [rt.example("slider_crank").kinematics(np.linspace(0, 0.01, 3)) for _ in range(5)],
    "i": lambda: [rt.example("slider_crank").inverse_dynamics(np.linspace(0, 0.01, 3)) for _ in range(5)],
    "c": lambda: [rt.example("fourbar").check() for _ in range(5)],
}
gate = threading.Barrier(len(order))
def work(one):
    gate.wait()
    try:
        analyses[one]()
    except BaseException as error:
        failed.append(f"{one}: {type(error).__name__}: {error}")
threads = [threading.Thread(target=work, args=(one,)) for one in order]
[one.start() for one in threads]
[one.join() for one in threads]
print(failed)
"""


def in_fresh_process(code: str, *arguments: str) -> str:
    environment = {**os.environ, "PYTHONPATH": str(HERE.parent / "src")}
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments], capture_output=True, text=True, env=environment, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


@pytest.mark.parametrize("order", ["es", "cscs", "ekice"])
def test_first_use_from_several_threads_at_once(order):
    assert in_fresh_process(TOGETHER, order) == "[]"


def test_the_registry_is_whole_for_every_thread_that_asks_first():
    code = """
import threading
from rattle import registry
gate, seen = threading.Barrier(8), []
def ask():
    gate.wait()
    seen.append((len(registry.kinds("joint")), len(registry.kinds("friction"))))
threads = [threading.Thread(target=ask) for _ in range(8)]
[one.start() for one in threads]
[one.join() for one in threads]
print(len(set(seen)), len(seen))
"""
    assert in_fresh_process(code) == "1 8"


@pytest.mark.parametrize("call", ["equilibrium()", "ideal().kinematics([0.0, 1e-3])"])
def test_short_work_runs_as_machine_code_too(call):
    done = f"import rattle as rt; rt.example('fourbar').{call}"
    code = f"{done}; from rattle.jit.functions import jit_runs; print(jit_runs())"
    assert in_fresh_process(code) == "True"
