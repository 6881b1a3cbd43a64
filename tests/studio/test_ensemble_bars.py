"""The histogram of an ensemble: one mechanism that went astray does not hide the others."""

from types import SimpleNamespace

import numpy as np
import pytest

from rattle.questions.ensemble import tab as ensemble
from rattle.questions.ensemble.first_order import FirstOrder
from rattle.questions.ensemble.statistics import Bounded

pytestmark = [pytest.mark.nojit, pytest.mark.plain]


class Forces(SimpleNamespace):
    """What the bars are made of: values [N] of one output."""

    def __getitem__(self, output):
        return self.values

    def unit(self, output):
        return "N"


def forces(*more):
    usual = 900.0 + 100.0 * np.random.default_rng(3).standard_normal(63)
    return Forces(values=np.array([*usual, *more]), nominal=np.array([900.0]))


def test_a_mechanism_far_away_is_in_the_outermost_bar_and_named():
    found = ensemble._histogram(forces(6.1e7), "max(A.force)")
    assert found["counts"].sum() == 64
    assert found["edges"][-1] < 3000.0
    assert found["counts"][-1] == 1
    assert found["samples"][-1] == 63
    assert found["counts"].max() < 32
    assert ensemble._outside(forces(6.1e7), "max(A.force)") == (
        "1 mechanism lies far outside, and in the outermost bar: number 63 with 6.1e+07 N"
    )


def test_without_one_every_value_has_its_bar_and_nothing_is_said():
    found = ensemble._histogram(forces(np.nan), "max(A.force)")
    values = forces().values
    assert found["counts"].sum() == 63
    assert found["edges"][[0, -1]] == pytest.approx([values.min(), values.max()])
    assert ensemble._outside(forces(np.nan), "max(A.force)") == ""
    assert ensemble._outside(Forces(values=np.full(5, 2.0)), "max(A.force)") == ""


def test_shares_of_the_parameters_are_a_table_with_the_largest_first():
    shares = (Bounded(0.02, 0.01, 0.03), Bounded(0.97, 0.95, 0.98))
    found = FirstOrder(("c", "r"), shares, Bounded(0.99, 0.98, 1.0), False, 3, 64)
    block = ensemble._shares(SimpleNamespace(contributions=lambda output: found), "max(A.force)")
    assert block["rows"] == [["r", "97.0 % (95.0 to 98.0)"], ["c", "2.0 % (1.0 to 3.0)"]]
    assert block["caption"].startswith("together 99.0 %")
    assert "Bounded" not in str(block)
