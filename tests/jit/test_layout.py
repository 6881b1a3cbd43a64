"""Columns of the arrays of a run: what the declaration says is what code uses."""

import ast
import importlib
import inspect
import json
import pickle

import pytest

import rattle as rt
from rattle.jit import layout as at
from rattle.jit.folder import compiled_modules
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


def test_kernels_ask_an_array_for_its_own_columns():
    """`body[i, at.X]`, `m.body[i, at.X + k]`: X is declared for `body`, in all modules with kernels."""
    asked = set()
    for module in compiled_modules():
        for node in ast.walk(ast.parse(inspect.getsource(importlib.import_module(module)))):
            if isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Tuple):
                array = getattr(node.value, "attr", getattr(node.value, "id", ""))
                names = [ast.unparse(part).partition(" + ")[0] for part in node.slice.elts]
                asked |= {(array, name[3:]) for name in names if name.startswith("at.") and array in at.COLUMNS}
    assert ("body", "X") in asked
    assert not [f"{array}[..., at.{name}]" for array, name in sorted(asked) if name not in at.COLUMNS[array]]


def test_a_column_that_leaves_the_process_is_a_number():
    assert type(pickle.loads(pickle.dumps(at.COS))) is int
    assert json.dumps({"column": at.COS}) == f'{{"column": {int(at.COS)}}}'


def test_arrays_of_a_mechanism_have_the_width_that_is_declared():
    workspace = rt.example("slider_crank_play").system.workspace()
    for array in ("body", "rows", "energy", "power", "joint", "load", "contact", "lever", "contact_memory"):
        assert getattr(workspace, array).shape[-1] == at.width(array), array
