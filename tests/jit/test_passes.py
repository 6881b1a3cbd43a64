"""The passes of the fast way: less code for Numba, and the same numbers as plain Python."""

import gc
import math

import numpy as np
import pytest

from rattle.jit import compile_path, layout
from rattle.jit import functions as jit
from rattle.jit import layout as at
from rattle.jit.functions import compiled, native


@compiled
def branches(row, n, out):
    """Loops that go on early, chained and negated comparisons, truth values of numbers, a comparison that is kept."""
    steps = 0
    for k in range(n):
        if k % 3 == 1:
            continue
        if row[k] != row[k]:
            steps += 100
            continue
        below = row[k] < 0.5
        inside = -1.0 < row[k] <= 1.0
        if not below and inside:
            out[0] += row[k]
        elif below or k == 4:
            out[1] += row[k] * (math.pi if inside else at.SIN)
        while n - k and steps < 2:
            steps += 1
        out[2] += 1.0 if below else math.sqrt(abs(row[k]))
    return steps if steps else -1


@compiled
def choice(table, n):
    """Columns by name, used twice and chosen by a condition; a variable that is assigned in one branch only."""
    first = table[n, at.COS] if n > 0 else table[n, at.SIN]
    if first > 0.0:
        second = table[n, at.COS + at.X] * first
    else:
        second = table[n, layout.SIN]
    return second - first


def test_branches_are_those_of_plain_python():
    jit.start()
    row = np.random.default_rng(5).normal(size=30)
    row[[3, 12]] = math.nan
    out, expected = np.zeros(3), np.zeros(3)
    for n in (0, 1, 5, 30):
        assert branches(row, n, out) == branches.python(row, n, expected)
        np.testing.assert_array_equal(out, expected)
    assert expected.all()


def test_columns_by_name_are_those_of_plain_python():
    jit.start()
    table = np.random.default_rng(6).normal(size=(6, 8))
    for n in range(6):
        assert choice(table, n) == choice.python(table, n)


@native("f", "m", "i")
def in_circles(table, n):
    total = 0.0
    for k in range(n):
        total += choice(table, k)
    return total


def test_compiling_leaves_nothing_to_the_garbage_collector():
    """Variables, statements and instructions refer to each other; walking them would take a tenth of the time."""
    if not jit.start() or not compile_path.chosen().fast:
        pytest.skip("the fast way only")
    gc.collect()
    before = _of_compilers()
    gc.disable()
    try:
        in_circles(np.zeros((3, 8)), 3)
        left = _of_compilers() - before
    finally:
        gc.enable()
    assert left < 10


def _of_compilers():
    """Number of statements, variables and instructions in memory."""
    from llvmlite.ir import Instruction
    from numba.core.ir import Expr, Stmt, Var

    return sum(issubclass(type(one), Instruction | Stmt | Expr | Var) for one in gc.get_objects())


def test_names_and_truth_values_are_folded():
    """What is left for Numba to find types for: no module, no truth value of a comparison, nothing unused."""
    if not jit.start():
        pytest.skip("machine code only")
    from numba.core import bytecode, interpreter, ir

    from rattle.jit.compiling import passes

    identity = bytecode.FunctionIdentity.from_function(choice.python)
    code = interpreter.Interpreter(identity).interpret(bytecode.ByteCode(identity))
    passes.fold(code)
    statements = [one for block in code.blocks.values() for one in block.body]
    assigned = {one.target.name: one.value for one in statements if isinstance(one, ir.Assign)}
    named = [one.value for one in assigned.values() if isinstance(one, ir.Global)]
    assert layout not in named
    assert bool not in named
    assert {one.value for one in assigned.values() if isinstance(one, ir.Const)} >= {at.COS, at.SIN}
    assert not {one.op for one in assigned.values() if isinstance(one, ir.Expr)} & {"getattr", "call"}
    read = [name.name for one in statements for name in one.list_vars()]  # by an assignment also what it assigns
    assert all(read.count(name) > 1 for name in assigned)
