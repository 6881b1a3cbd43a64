"""Numbers and curves that others wrote are met within tolerances that follow from their digits and steps."""

import dataclasses
from collections import Counter

import numpy as np
import pytest

import foreign_cases
from foreign_cases import CASES, FOLDER

SHOWN = 0.02  # m, the shift of a curve that has to be noticed


@pytest.mark.parametrize("case", CASES, ids=str)
def test_what_others_have_computed_is_computed_here(case):
    off = [f"{each.curve.name}: {each.largest:.3g} off" for each in case.compared if not each.as_claimed]
    assert not off


@pytest.mark.nojit
def test_every_number_says_where_it_comes_from_and_why_its_tolerance_is_what_it_is():
    for case in CASES:
        assert case.source.commit, case
        assert case.source.licence, case
        assert case.title, case
        assert case.file, case
        assert case.says, case
        assert all(curve.why and curve.tolerance > 0 for curve in case.curves), case
        assert all(bool(curve.wrong) == bool(curve.right) == bool(curve.right_by) for curve in case.curves), case


@pytest.mark.nojit
def test_every_file_is_of_a_listed_source_and_no_title_stands_twice():
    folders = {path.name for path in (FOLDER / "data").iterdir()}
    assert folders == set(foreign_cases.sources())
    assert len(CASES) == len(list((FOLDER / "data").rglob("*.toml")))
    assert max(Counter((case.source.key, case.title) for case in CASES).values()) == 1


@pytest.mark.nojit
def test_a_tolerance_is_small_against_the_curve_that_it_is_for():
    for case in CASES:
        for curve in case.curves:
            size = max(np.abs(curve.values).max(), np.ptp(curve.values))
            assert size == 0 or curve.tolerance < 0.2 * size, f"{case}: {curve.name}"


def test_a_curve_that_is_not_theirs_is_noticed():
    case = next(case for case in CASES if str(case) == "chrono/revolute_1")
    right = case.curves[0]
    moved = dataclasses.replace(right, values=right.values + SHOWN)
    numbers = ((float(right.t[-1]), float(right.values[-1]), right.tolerance),)
    wrong = dataclasses.replace(right, wrong="a claim that is not true", right=numbers)
    shown = dataclasses.replace(wrong, values=moved.values)
    unknown, other = (dataclasses.replace(shown, right=these) for these in ((), ((numbers[0][0], 9.0, 0.1),)))
    compared = dataclasses.replace(case, curves=(right, moved, wrong, shown, unknown, other)).compared
    assert [each.as_claimed for each in compared] == [True, False, False, True, False, False]


@pytest.mark.nojit
@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("values = [1, 2]\nt = [1]", "1 instants, 2 values"),
        ("values = []\nt = []", "0 instants"),
        ("values = [1]\nt = [1]\nunits = 'm'", "unknown keys"),
    ],
)
def test_a_file_of_another_form_is_refused(tmp_path, text, problem):
    path = tmp_path / "case.toml"
    path.write_text(f"title = ''\n[[curves]]\nname = 'a.x'\n{text}")
    with pytest.raises(ValueError, match=problem):
        foreign_cases.read_case(path, None)
