"""Straight-line machine code: cost of one right-hand side and sample, and of recording and compiling a model.

Times are processor times of one thread, so that other programs disturb them less.
"""

from __future__ import annotations

import ctypes
import os
import tempfile
import time
from collections.abc import Callable
from functools import partial

import numpy as np

import rattle as rt
from measure import Row, interleave
from rattle.analyses.straight_line import StraightLine, straight_line
from rattle.trace import llvm
from rhs import chain

LOOP = """define void @many(ptr %in, ptr %out, i64 %n) {
entry:
br label %again
again:
%i = phi i64 [0, %entry], [%j, %again]
call void @derivative(ptr %in, ptr %out)
%j = add i64 %i, 1
%more = icmp slt i64 %j, %n
br i1 %more, label %again, label %done
done:
ret void
}
"""
OPERATIONS = 5e7  # per timing


def functions(made: StraightLine) -> dict[str, list[object]]:
    """What a run needs, by name."""
    return {"derivative": made.derivative, "project": made.projection, "outputs": made.outputs}


def lane_sampler(made: StraightLine, width: int) -> Callable[[], float]:
    """Time of one right-hand side and sample [s]."""
    text = llvm.functions_text(made.graph, {"derivative": made.derivative}, width) + LOOP
    many = llvm.compile(text, ["many"]).function("many", ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int64)
    y = np.repeat(np.concatenate([[0.0], made.start]), width)
    dy = np.empty(len(made.derivative) * width)
    calls = int(OPERATIONS / width / made.graph.count(made.derivative)) + 1

    def sample() -> float:
        began = time.thread_time()
        many(y.ctypes.data, dy.ctypes.data, calls)
        return (time.thread_time() - began) / calls / width

    return sample


def trace_seconds(mechanism: rt.Mechanism) -> float:
    """Time to record the functions of a model [s]."""
    began = time.thread_time()
    straight_line(mechanism.system, mechanism.start)
    return time.thread_time() - began


def compile_seconds(made: StraightLine, width: int) -> float:
    """Time to write and compile its functions [s], in a new cache folder."""
    with tempfile.TemporaryDirectory() as folder:
        before = os.environ.get("RATTLE_CACHE")
        os.environ["RATTLE_CACHE"] = folder
        began = time.thread_time()
        llvm.compile(llvm.functions_text(made.graph, functions(made), width), list(functions(made)))
        seconds = time.thread_time() - began
        os.environ.pop("RATTLE_CACHE")
        if before is not None:
            os.environ["RATTLE_CACHE"] = before
    return seconds


def rows(repeats: int) -> list[Row]:
    """The paper's four-bar, the squeezer, and a chain of 20 links."""
    models = {"four-bar": rt.example("fourbar"), "squeezer": rt.example("squeezer"), "chain of 20": rt.loads(chain(20))}
    samplers: dict[str, Callable[[], float]] = {}
    for name, mechanism in models.items():
        made = straight_line(mechanism.system, mechanism.start)
        for width in (1, 4, 8):
            samplers[f"{name}: right-hand side, {width} side by side, per sample"] = lane_sampler(made, width)
            samplers[f"{name}: compile all for {width} side by side"] = partial(compile_seconds, made, width)
        samplers[f"{name}: record all"] = partial(trace_seconds, mechanism)
    median = interleave(samplers, repeats)
    return [Row(name, median[name]) for name in sorted(samplers)]
