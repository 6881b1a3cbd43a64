"""A run as bytes: the same with and without machine code, small, and without what a page could not call."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest

import rattle as rt
from core_engine import new
from rattle.errors import InputError
from rattle.jit.workspace import ARRAYS
from rattle.pages.run_image import planned_run, run_image

IN_PYTHON = """
import json, sys, rattle as rt
from rattle.pages.run_image import planned_run, run_image
one = run_image(planned_run(rt.example("fourbar_onesided")))
open(sys.argv[1], "wb").write(one.content)
print(json.dumps(one.description))
"""


def test_arrays_come_back():
    run = new("slider_crank_oil")
    said, content = run_image(run)
    for (name, one), (*shape, at) in zip(ARRAYS.items(), said["arrays"], strict=True):
        array = getattr(run.workspace, name)
        assert list(array.shape) == shape
        if at >= 0:
            kind = np.float64 if one.kind[0] == "f" else np.int64
            assert (np.frombuffer(content, kind, array.size, at) == array.ravel()).all()
        elif name not in said["tables"]:
            assert not array.any()
    assert len(content) < 30_000  # arrays of zeros, most of a workspace, take no bytes


def test_it_is_the_same_without_machine_code(tmp_path):
    """In processes of their own: tables have room for every law that was registered."""
    said, contents = [], []
    for mode in ("native", "python"):
        done = subprocess.run(
            [sys.executable, "-c", IN_PYTHON, tmp_path / mode],
            env={**os.environ, "RATTLE_JIT": mode}, capture_output=True, check=True,
        )  # fmt: skip
        said.append(json.loads(done.stdout))
        contents.append(np.frombuffer((tmp_path / mode).read_bytes()))
    assert said[0] == said[1]
    assert np.allclose(*contents, rtol=1e-12, atol=1e-12, equal_nan=True)


def test_a_law_in_python_is_refused(laws):
    @rt.load_law("breeze", c="N")
    def breeze(t, state, p):
        return p.c, 0.0, 0.0

    m = rt.example("ellipse")
    m.load("air", "breeze", body=next(iter(m.model.bodies)), c="1 N")
    with pytest.raises(InputError, match="a law in Python cannot be computed in a page"):
        run_image(planned_run(m))
