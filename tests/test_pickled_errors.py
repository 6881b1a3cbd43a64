"""Errors come through to another process with everything they say, as parameter studies over processes need."""

import multiprocessing
import pickle

import pytest

import rattle as rt
from circling import circling
from rattle.errors import MissingPackage, WorkerError
from rattle.language.syntax import ExpressionError
from rattle.results.result import UnknownName

pytestmark = pytest.mark.nojit


def test_model_errors_keep_their_problems():
    with pytest.raises(rt.ModelError) as caught:
        rt.loads("format = 1\n[bodies.a]\nmas = 1\n")
    back = pickle.loads(pickle.dumps(caught.value))
    assert str(back) == str(caught.value)
    assert [(one.key, one.line, one.caret) for one in back.problems] == [
        (one.key, one.line, one.caret) for one in caught.value.problems
    ]


@pytest.mark.parametrize(
    "error",
    [
        rt.AssemblyError("loop open"),
        MissingPackage("save needs h5py"),
        WorkerError("a worker process ended"),
        UnknownName("no 'x'"),
        ExpressionError("expected a number", 4),
    ],
)
def test_other_errors_come_back_as_they_were(error):
    back = pickle.loads(pickle.dumps(error))
    assert type(back) is type(error)
    assert str(back) == str(error)
    assert vars(back) == vars(error)


def test_solver_errors_keep_their_result():
    back = pickle.loads(pickle.dumps(rt.SolverError("cannot go on", circling(5))))
    assert str(back) == "cannot go on"
    assert back.result["lift"].tolist() == circling(5)["lift"].tolist()


def test_a_pool_of_processes_hands_a_model_error_on():
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        answer = pool.map_async(rt.loads, ["format = 2"])
        with pytest.raises(rt.ModelError, match="expected format = 1"):
            answer.get(60)
