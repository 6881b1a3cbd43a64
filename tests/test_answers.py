"""Refusals are told from faults by their class: what this program refuses is an `InputError`, wherever that is."""

import ast
import pickle
from pathlib import Path

import pytest

import rattle as rt
from rattle.errors import ANSWERS, InputError, WrongType
from rattle.language.tokens import ExpressionError
from rattle.language.units import QuantityError
from rattle.questions.ensemble.runs import UnknownSample
from rattle.results.result import UnknownName

pytestmark = pytest.mark.nojit

SOURCES = Path(rt.__file__).parent
# the compiled layer checks its own callers; a damaged file of machine code is compiled again; an unknown attribute
OWN = {"jit", "trace/llvm.py", "__init__.py", "results/archive.py", "wrong_arguments.py"}


def test_no_refusal_is_a_bare_error_of_python():
    bare = []
    for file in sorted(SOURCES.rglob("*.py")):
        name = file.relative_to(SOURCES).as_posix()
        if name in OWN or name.split("/")[0] in OWN:
            continue
        for node in ast.walk(ast.parse(file.read_text())):
            call = node.exc if isinstance(node, ast.Raise) else None
            called = call.func if isinstance(call, ast.Call) else None
            if isinstance(called, ast.Name) and called.id in ("ValueError", "TypeError", "KeyError", "IndexError"):
                bare.append(f"{name}:{node.lineno}: raise {called.id}; it is InputError, or WrongType")
    assert not bare, "\n".join(bare)


@pytest.mark.parametrize(
    ("kind", "too"),
    [
        (WrongType, TypeError),
        (rt.ModelError, ValueError),
        (rt.AssemblyError, RuntimeError),
        (ExpressionError, ValueError),
        (QuantityError, ValueError),
        (UnknownName, KeyError),
        (UnknownSample, IndexError),
    ],
)
def test_every_refusal_is_an_input_error_and_what_it_was_before(kind, too):
    assert issubclass(kind, InputError)
    assert issubclass(kind, ValueError)
    assert issubclass(kind, too)
    assert issubclass(kind, ANSWERS)


def test_refusals_come_through_to_another_process():
    for error in (InputError("no"), WrongType("a name, not 5"), UnknownSample("sample 7")):
        back = pickle.loads(pickle.dumps(error))
        assert type(back) is type(error)
        assert str(back) == str(error)
