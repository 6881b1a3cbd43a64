"""Expressions on arrays have the values of the stack programs that a run uses."""

import math

import numpy as np
import pytest

from rattle.jit import functions as compiled_functions
from rattle.language import arrays, bytecode
from rattle.language.expression import compile_program, concatenate, parse
from rattle.language.syntax import FUNCTIONS

pytestmark = pytest.mark.nojit

VALUES = [-math.inf, -2.5, -1.0, -0.3, -0.0, 0.0, 0.3, 1.0, 2.0, 800.0, math.inf, math.nan]
TEXTS = [
    *(f"{name}(a)" for name, size in FUNCTIONS.items() if size == 1),
    *(f"{name}(a, b)" for name, size in FUNCTIONS.items() if size != 1),
    *(f"a {operator} b" for operator in ("+", "-", "*", "/", "**")),
    *(f"1 if a {test} b else 2" for test in ("<", "<=", ">", ">=")),
    *(f"1 if {test} else 2" for test in ("a < b and b <= c", "a > b or not c >= b", "not (a < b and a > c)")),
    "-a + 2*pi*b**2 - c",
    "max(a, b, c)",
]


@pytest.mark.parametrize("text", TEXTS)
def test_values_are_those_of_a_run(text, monkeypatch):
    monkeypatch.setattr(compiled_functions, "_jit", False)
    a, b = (x.ravel() for x in np.meshgrid(VALUES, VALUES))
    node = parse(text)
    code, const, first, depth = concatenate([compile_program(node, {"c": 0.7}, {}, {"a": 0, "b": 1})])
    expected = [
        bytecode.evaluate(
            code, const, int(first[0]), int(first[1]), 0.0, np.zeros((1, 8)), np.array([x, y]), np.empty(depth)
        )
        for x, y in zip(a, b, strict=True)
    ]
    given = {"a": a, "b": b, "c": 0.7}
    # two libraries of elementary functions differ in the last places
    np.testing.assert_allclose(arrays.evaluate(node, given.__getitem__), expected, rtol=2e-15, atol=0)


def test_an_unknown_name_is_what_the_lookup_says():
    with pytest.raises(KeyError, match="b"):
        arrays.evaluate(parse("a + b"), {"a": 1.0}.__getitem__)
