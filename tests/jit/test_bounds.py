"""No index of the compiled layer leaves its array: part of the kernels again, with every index checked."""

import os
import subprocess
import sys

import pytest

from rattle.jit import functions

CODE = """
import numpy as np
from rattle.jit import functions

functions.start()
@functions.compiled
def beyond(values, k):
    return values[k]

assert beyond(np.ones(3), 2) == 1.0
try:
    beyond(np.ones(3), 3)
except IndexError:
    print("checked")

import rattle as rt
r = rt.example("slider_crank").kinematics(np.linspace(0.0, 0.02, 41))
assert r.success
print(len(r.t))
"""


def test_kernels_of_the_position_sweep_stay_within_their_arrays(tmp_path):
    if not functions.start():
        pytest.skip("runs without machine code; NumPy checks indices there")
    environment = os.environ | {"RATTLE_BOUNDSCHECK": "1"}
    (tmp_path / "sweep.py").write_text(CODE)
    run = subprocess.run([sys.executable, tmp_path / "sweep.py"], env=environment, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    assert run.stdout.split() == ["checked", "41"]
