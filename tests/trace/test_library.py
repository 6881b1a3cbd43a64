"""Elementary functions that an engine calls: the bits of the exact operations, and remainders without rounding."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core_engine import TWO, own_function
from rattle.trace.elementary import lower
from rattle.trace.graph import Graph
from rattle.trace.library import NAMES

KNOWN = [name for name in NAMES if name not in ("expm1", "log1p")]
SPECIAL = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    math.inf,
    -math.inf,
    math.nan,
    5e-324,
    1e-308,
    1e308,
    1e5,
    math.pi,
    -0.75 * math.pi,
]


def bits(values):
    """Numbers as whole numbers; all nan are one."""
    found = np.asarray(values, float)
    return np.where(np.isnan(found), -1, found.view(np.int64))


def evaluated(name, *given):
    """The same function by the operations of a trace."""
    graph = Graph()
    result = graph.apply(name, *[graph.input() for _ in given])
    return lower(graph, [result])[0].evaluate(lower(graph, [result])[1], np.array(given))[0]


@pytest.mark.parametrize("name", KNOWN)
def test_functions_have_the_bits_of_a_trace(name):
    random = np.random.default_rng(3)
    x = np.concatenate(
        [SPECIAL, random.normal(size=300), 10.0 ** random.uniform(-300, 300, 300), random.uniform(-30, 30, 300)]
    )
    given = [x, random.permutation(x)] if name in TWO else [x]
    found = [own_function(name)(*one) for one in zip(*(one.tolist() for one in given), strict=True)]
    assert (bits(found) == bits(evaluated(name, *given))).all()


@pytest.mark.parametrize("name", ["expm1", "log1p"])
def test_the_two_beside_one_are_those_of_the_c_library_to_rounding(name):
    for x in [*np.geomspace(1e-300, 0.9, 200), *-np.geomspace(1e-300, 0.9, 200), 3.0, 300.0, 0.0]:
        true = getattr(math, name)(x)
        assert abs(own_function(name)(x) - true) <= 4.0 * math.ulp(true)


FINITE = st.floats(allow_nan=False, allow_infinity=False)


@given(FINITE, FINITE.filter(bool))
def test_remainders_are_exact(x, y):
    assert bits(own_function("fmod")(x, y)) == bits(math.fmod(x, y))


def test_remainders_that_are_none():
    assert all(math.isnan(own_function("fmod")(*one)) for one in [(1.0, 0.0), (math.inf, 1.0), (math.nan, 1.0)])
    assert own_function("fmod")(1.5, math.inf) == 1.5
