"""Every loop gives the numbers of plain Python, however it is compiled.

The gate runs this file with every index checked as well: RATTLE_BOUNDSCHECK=1.
"""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import every_loop
from rattle.jit import functions

TESTS = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def in_python():
    """The numbers of every loop from a process without machine code."""
    if not functions.start():
        pytest.skip("there is nothing but plain Python to compare with")
    done = subprocess.run(
        [sys.executable, "-c", "import every_loop, json; print(json.dumps(every_loop.numbers()))"],
        capture_output=True,
        text=True,
        env={**os.environ, "RATTLE_JIT": "python", "PYTHONPATH": f"{TESTS.parent / 'src'}{os.pathsep}{TESTS}"},
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.mark.parametrize("loop", every_loop.LOOPS, ids=lambda one: one.__name__)
def test_machine_code_gives_the_numbers_of_plain_python(in_python, loop):
    expected = in_python[loop.__name__]
    assert len(expected) > 4
    assert loop() == pytest.approx(expected, rel=1e-7, abs=1e-10)  # rounding, as far as impacts have let it grow
