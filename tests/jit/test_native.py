"""Native functions: compiled when they are first called, called by others without a copy, kept on disk."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import rattle as rt
from rattle import registry
from rattle.equations import motion
from rattle.jit import folder, functions
from rattle.jit import layout as at
from rattle.jit.functions import native

SOURCES = str(Path(__file__).parents[2] / "src")


@native("ff", "v", "f")
def split(row, limit):
    """Sums of the numbers below a limit and of the others."""
    low, high = 0.0, 0.0
    for k in range(row.shape[0]):
        if row[k] < limit:
            low += row[k]
        else:
            high += row[k]
    return low, high


@native("void", "m", "n", "v", "i")
def choose(table, rows, out, wanted):
    """For every pair of row and column: the sum of the row below the number there, or of the rest."""
    for n in range(rows.shape[0]):
        low, high = split(table[rows[n, 0]], table[rows[n, 0], rows[n, 1]])
        out[n] = low if wanted == 0 else high


def test_native_functions_give_what_plain_python_gives():
    functions.start()
    rng = np.random.default_rng(5)
    table, rows = rng.normal(size=(4, 6)), np.array([[0, 1], [3, 5], [2, 2]])
    for wanted in (0, 1):
        out, expected = np.zeros(3), np.zeros(3)
        assert choose(table, rows, out, wanted) is None
        choose.python(table, rows, expected, wanted)
        np.testing.assert_array_equal(out, expected)
    assert split(table[0], 0.5) == split.python(table[0], 0.5)


@pytest.mark.parametrize("row", [np.arange(8.0)[::2], np.arange(4), np.zeros((2, 2))], ids=["gaps", "whole", "rows"])
def test_an_array_that_machine_code_would_misread_is_refused(row):
    functions.start()
    with pytest.raises(TypeError, match="split takes a contiguous array"):
        split(row, 1.0)


def test_a_function_is_compiled_when_it_is_first_called():
    @native("f", "f")
    def rare(x):
        return 2.0 * x

    @native("f", "f")
    def usual(x):
        return x if x < 0.0 else rare(x)

    functions.start()
    assert usual(-1.0) == -1.0
    assert not rare._address
    assert usual(3.0) == 6.0
    assert rare._address


@pytest.mark.parametrize("error", [KeyboardInterrupt, MemoryError])
def test_what_stops_the_compiler_on_the_way_stops_the_call_and_nothing_else(monkeypatch, error):
    @native("f", "f")
    def needed(x):
        return x + 1.0

    @native("f", "f")
    def middle(x):
        return 10.0 * needed(x)

    @native("f", "f")
    def first(x):
        return middle(x) + 0.5

    def stopped(self):
        raise error

    functions.start()
    with monkeypatch.context() as patch:
        patch.setattr(type(needed), "_made", stopped)
        with pytest.raises(error):
            _ = needed.address
    _ = first.address, middle.address
    with monkeypatch.context() as patch:
        patch.setattr(type(needed), "_made", stopped)
        with pytest.raises(error):
            first(2.0)
    assert first(2.0) == 30.5


def in_fresh_process(code, **environment):
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": SOURCES, **environment},
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


RUN = """
import sys
import rattle as rt
r = rt.example("fourbar").simulate(0.01)
print(repr(float(r["O3.normal"][1:].sum())), "numba" in sys.modules, "scipy" in sys.modules)
"""


def test_a_run_whose_code_is_kept_does_without_numba():
    before = in_fresh_process(RUN)
    assert in_fresh_process(RUN) == [before[0], "False", "False"]


LATER = """
import rattle as rt
rt.example("squeezer").simulate(1e-3), rt.example("quick_return").simulate(1e-3)
print(len(rt.example("balanced_arm").equilibrium()))
"""


def test_functions_that_are_imported_after_a_run_are_found_by_what_calls_them():
    # the run has called all native functions that put a mechanism together; those of statics come after it
    alone = in_fresh_process("import rattle as rt; print(len(rt.example('balanced_arm').equilibrium()))")
    assert in_fresh_process(LATER) == in_fresh_process(LATER) == alone


def test_code_that_needs_what_is_not_there_is_made_anew(tmp_path, monkeypatch):
    from rattle.jit import machine
    from rattle.jit.cache import Folder, KeptFile

    @native("f", "f")
    def third(x):
        return x / 3.0

    third.__module__ = "rattle.somewhere"
    monkeypatch.setattr(folder, "_code_folder", Folder(tmp_path, True))
    functions.start()
    assert third(6.0) == 2.0
    (file,) = tmp_path.iterdir()
    kept = KeptFile(tmp_path, third.symbol, (third.letters, machine.processor()))
    assert kept.file == file
    code = machine.Code(*kept.read())
    with pytest.raises(LookupError, match="needs nowhere"):
        machine.load(code._replace(needs=("nowhere",)))


CHECKED = """
import numpy as np
from rattle.jit import functions
from rattle.jit.functions import native
@native("f", "v", "i")
def at(row, n):
    return row[n]
@native("f", "v", "i")
def next_to(row, n):
    return at(row, n + 1)
functions.start()
try:
    next_to(np.zeros(3), 2)
except IndexError as error:
    assert "index is out of bounds: <run_path>.at, line 7" in str(error)
    print("IndexError")
"""


def test_a_wrong_index_is_told_through_all_callers(tmp_path):
    (tmp_path / "checked.py").write_text(CHECKED)
    code = f"import runpy; runpy.run_path({str(tmp_path / 'checked.py')!r})"
    assert in_fresh_process(code, RATTLE_BOUNDSCHECK="1") == ["IndexError"]


@pytest.mark.parametrize("family", ["joint", "load"])
def test_a_kernel_that_is_not_in_the_table_is_told_and_does_not_end_the_process(family):
    if not functions.start():
        pytest.skip("runs without machine code; Python raises by itself")
    system = rt.example("squeezer").system
    workspace = system.workspace()
    table = getattr(workspace, f"{family}_table")
    assert table.all()
    kernels = [one.kernel for one in registry.kinds(family).values() if one.kernel]
    table[: len(kernels)] = [one.trap for one in kernels]
    used = system.arrays[family][0, at.KERNEL]
    said = f"family '{family}' was called, but .*: {kernels[used].__module__}"
    with pytest.raises(RuntimeError, match=said):
        motion.free_motion(workspace, 0.0, np.zeros(3 * system.body_count), np.zeros(3 * system.body_count))
