"""Compiled functions: parts and wholes give what plain Python gives; on which files machine code depends."""

import ast
import importlib
import inspect
import pkgutil
import re
import textwrap
from pathlib import Path

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


@pytest.mark.machine
@pytest.mark.nojit
def test_no_compiled_function_counts_from_the_end_of_an_array():
    functions = all_compiled()
    assert len(functions) > 150
    for name, one in functions.items():
        if one.python.__name__ == "<lambda>" or one.__name__ != one.python.__name__:
            continue  # a rule of an operation of expressions, which has no arrays
        tree = ast.parse("".join(getattr(one.python, "source", "")) or textwrap.dedent(inspect.getsource(one.python)))
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


@pytest.mark.nojit
def test_machine_code_is_kept_while_nothing_it_depends_on_changes():
    """The cache key covers every module with compiled functions, all numbers that these can import, and few others."""
    sources = set(folder.compiled_sources())
    here = Path(rattle.__file__).parent
    assert {here / "jit" / "translation" / "unit.py", here / "registry.py"} <= sources
    modules = {name for name, _ in all_compiled()}
    assert modules == set(folder.compiled_modules())
    ahead, seen = sorted(modules), set()
    while ahead:
        path = here.joinpath(*ahead.pop().split(".")[1:])
        for module, names in re.findall(
            r"^from (rattle[\w.]*) import (\([^)]*\)|.*)$", path.with_suffix(".py").read_text(encoding="utf-8"), re.M
        ):
            for one in (module, *(f"{module}.{name}" for name in re.findall(r"\w+", names))):
                file = here.joinpath(*one.split(".")[1:]).with_suffix(".py")
                if file.exists() and file not in seen:
                    seen.add(file)
                    ahead.append(one)
    types_only = {"errors.py", "description/model.py", "value_types.py"}
    types_only |= {f"catalogue/{name}.py" for name in ("bearings", "fits", "oils", "tables")}  # which the model names
    assert {str(one.relative_to(here)) for one in seen - sources} <= types_only
    assert not {"main", "curves", "compare", "result", "reader", "simulate"} & {path.stem for path in sources}
