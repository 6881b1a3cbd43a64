"""Laws in Python: what was loaded runs, with what it uses from outside as it is when a run begins."""

import functools
import importlib
import linecache
import logging
import sys

import numpy as np
import pytest

import rattle as rt
from rattle import registry
from rattle.jit.translation.unit import translated
from rattle.jit.translation.values import TranslationError

K, TABLE = 1.0, np.array([1.0, 2.0])


@pytest.fixture(autouse=True)
def laws():
    """The laws of this file stay in this file."""
    before = dict(registry.kinds("load"))
    for law in (of_a_number_outside, of_a_table_outside, without_a_value):
        rt.load_law(law.__name__, between="points")(law)
    yield
    for name in registry.kinds("load").keys() - before.keys():
        registry._families["load"].pop(name)


def pushed(law):
    """Acceleration [m/s^2] of 1 kg at 0.5 m from the ground, under a load law."""
    m = rt.Mechanism("m", gravity=[0, 0]).ground(O=[0, 0]).body("b", mass=1, inertia=1, points={"P": [0, 0]})
    m = m.prismatic("g", "ground.O", "b.P").load("l", law, connect=["ground.O", "b.P"]).initial("b", x=0.5)
    return float(m.simulate(1e-6, t_eval=[0.0])["b.ax"][0])


def scaled(x):
    return K * x


def of_a_number_outside(t, length, rate, p):
    return -scaled(length)


def of_a_table_outside(t, length, rate, p):
    return -TABLE[0] * length


def test_a_number_outside_of_a_law_may_change_between_runs():
    global K
    for K in (1.0, 5.0, 2.0):
        assert pushed("of_a_number_outside") == pytest.approx(-0.5 * K)
    K = 1.0


def test_an_array_outside_of_a_law_may_change_between_runs():
    assert pushed("of_a_table_outside") == pytest.approx(-0.5)
    TABLE[0] = 10.0
    assert pushed("of_a_table_outside") == pytest.approx(-5.0)
    TABLE[0] = 1.0


FILE = """import rattle as rt


def helper(x):
    return {0} * x


@rt.load_law("reloaded", between="points")
def law(t, length, rate, p):
    return -helper(length)
"""


def test_a_law_that_was_edited_runs_as_it_was_loaded(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    (tmp_path / "edited_law.py").write_text(FILE.format("100.0"))
    module = importlib.import_module("edited_law")
    (tmp_path / "edited_law.py").write_text("# a line more\n" + FILE.format("7000.0"))
    assert pushed("reloaded") == pytest.approx(-50.0)  # as it is in memory
    importlib.reload(module)
    assert pushed("reloaded") == pytest.approx(-3500.0)


def ends_without_a_value(x):
    if x > 0.0:
        return x


def calls_one_that_does(x):
    return ends_without_a_value(x) + 1.0


def second_name_in_a_loop(x):
    total, before = 0.0, np.zeros(2)
    for n in range(3):
        step = np.array([x * n + 1.0, x])
        total += step[0] - 10.0 * before[0]
        before: np.ndarray = step
    return total


def largest_along_an_axis(x):
    return np.max(x, 0)


@pytest.mark.parametrize(
    "law", [ends_without_a_value, calls_one_that_does, second_name_in_a_loop, largest_along_an_axis]
)
def test_what_would_not_be_what_python_computes_is_not_translated(law):
    def around(x):
        return law(x)

    with pytest.raises(TranslationError):
        translated(around, "test.around", ("f", "f"))


def without_a_value(t, length, rate, p):
    if length < 0.3:
        return 100.0 * (0.3 - length)


def test_a_law_that_returns_nothing_ends_the_run_with_its_error(caplog):
    m = rt.Mechanism("m", gravity=[0, 0]).ground(O=[0, 0]).body("b", mass=1, inertia=1, points={"P": [0, 0]})
    m = m.prismatic("g", "ground.O", "b.P").load("l", "without_a_value", connect=["ground.O", "b.P"])
    with caplog.at_level(logging.INFO):
        r = m.initial("b", x=0.5).simulate(0.1)
    assert not r.success
    assert "TypeError" in r.message


def test_integers_beyond_64_bits_are_not_translated():
    def around(x):
        return -(10**20) * x + 100000000000000000000

    with pytest.raises(TranslationError, match="64 bits"):
        translated(around, "test.around", ("f", "f"))


def test_fields_of_laws_are_known_after_the_sources_were_forgotten():
    linecache.clearcache()

    @rt.load_law("late", between="points", k="N/m")
    def late(t, length, rate, p):
        return -p.k * length

    m = rt.Mechanism("m", gravity=[0, 0]).ground(O=[0, 0]).body("b", mass=1, inertia=1, points={"P": [0, 0]})
    m = m.prismatic("g", "ground.O", "b.P").load("l", "late", connect=["ground.O", "b.P"], k=3)
    assert float(m.initial("b", x=0.5).simulate(1e-6, t_eval=[0.0])["b.ax"][0]) == pytest.approx(-1.5)


def test_an_object_that_is_no_function_is_refused_in_words():
    with pytest.raises(rt.InputError, match="load law 'part': a function is expected"):
        rt.load_law("part", between="points")(functools.partial(scaled, 1.0))
