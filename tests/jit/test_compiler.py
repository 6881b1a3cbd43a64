"""Compiled functions: parts and wholes give what plain Python gives, and leave other users of Numba alone."""

import ast
import importlib
import inspect
import pkgutil
import textwrap

import numpy as np
import pytest

import rattle
from rattle.jit import folder
from rattle.jit import functions as jit
from rattle.jit.functions import KernelFunction, compiled


def all_compiled():
    found = {}
    for module in pkgutil.walk_packages(rattle.__path__, "rattle."):
        if module.name == "rattle.__main__" or module.name.startswith("rattle.studio."):
            continue  # nothing there is compiled, and its packages may be missing
        for one in vars(importlib.import_module(module.name)).values():
            if type(one) is KernelFunction:
                found[one.__module__, one.__name__] = one
    return found


@pytest.mark.nojit
def test_no_compiled_function_counts_from_the_end_of_an_array():
    functions = all_compiled()
    assert len(functions) > 150
    for name, one in functions.items():
        tree = ast.parse(textwrap.dedent(inspect.getsource(one.python)))
        for node in ast.walk(tree):
            parts = ast.walk(node.slice) if isinstance(node, ast.Subscript) else ()
            negative = [part for part in parts if isinstance(part, ast.UnaryOp) and isinstance(part.op, ast.USub)]
            assert not negative, (name, ast.unparse(node))


@compiled
def weighted(row, weights, power):
    total = 0.0
    for k in range(row.shape[0]):
        total += row[k] * weights[k] ** power
    return total


@compiled
def mix(table, weights, count, out):
    """Rows as arrays of their own, two indices, counters, slices, a part called with different constants."""
    for n in range(table.shape[0]):
        out[n, 0] = weighted(table[n], weights, 1)
        out[n, 1] = weighted(table[n][1:], weights[1:], 2)
        out[n, 2] = table[n, 0] - table[n, count[n]]
        count[n] += 1
    return len(table)


def test_machine_code_gives_what_plain_python_gives():
    jit.start()
    rng = np.random.default_rng(3)
    table, weights = rng.normal(size=(5, 4)), rng.normal(size=4)
    count, expected_count = np.arange(5) % 4, np.arange(5) % 4
    out, expected = np.zeros((5, 3)), np.zeros((5, 3))
    assert mix(table, weights, count, out) == mix.python(table, weights, expected_count, expected) == 5
    np.testing.assert_allclose(out, expected, rtol=1e-15)
    np.testing.assert_array_equal(count, expected_count)


def test_other_functions_of_numba_still_count_from_the_end():
    jit.start()
    numba = pytest.importorskip("numba")
    last = numba.njit(lambda a: a[-1] + a[len(a) - 2] * 2.0)
    assert last(np.array([1.0, 2.0, 4.0])) == 8.0


def test_machine_code_is_kept_while_nothing_it_depends_on_changes():
    """The cache key covers every module that compiled code imports, and no other."""
    sources = {path.stem for path in folder.compiled_sources()}
    assert {"plain", "unit", "statements", "workspace", "layout", "motion"} <= sources
    assert {"pin_in_bush", "dop853_tableau", "restitution"} <= sources
    assert not {"main", "curves", "compare", "result", "reader", "simulate"} & sources
