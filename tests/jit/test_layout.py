"""Columns of the arrays of a run: what the declaration says is what code uses."""

import json
import pickle

import pytest

import rattle as rt
from rattle.jit import layout as at
from rattle.jit.workspace import ARRAYS

pytestmark = pytest.mark.nojit


@pytest.mark.parametrize("array", at.COLUMNS)
def test_columns_that_arrays_share_have_one_number_in_all_of_them(array):
    assert [getattr(at, name) for name in at.COLUMNS[array]] == list(range(at.width(array)))
    assert all(column.meaning for column in at.COLUMNS[array].values())


@pytest.mark.parametrize("array", at.COLUMNS)
def test_an_array_is_as_wide_as_its_columns(array):
    assert ARRAYS[array].shape.rpartition(", ")[2] == str(at.width(array))


def test_a_column_has_one_meaning():
    # the same in several arrays
    shared = {"KERNEL", "END_A", "END_B", "FIRST_P", "FIRST_CODE", "END_CODE", "OWN_CODE", "TARGET"}
    names = [name for columns in at.COLUMNS.values() for name in columns if name not in shared]
    assert len(names) == len(set(names))


def test_a_column_that_leaves_the_process_is_a_number():
    assert type(pickle.loads(pickle.dumps(at.COS))) is int
    assert json.dumps({"column": at.COS}) == f'{{"column": {int(at.COS)}}}'


def test_arrays_of_a_mechanism_have_the_width_that_is_declared():
    workspace = rt.example("slider_crank_play").system.workspace()
    for array in ("body", "rows", "energy", "power", "joint", "load", "contact", "lever", "contact_memory"):
        assert getattr(workspace, array).shape[-1] == at.width(array), array
