"""Expressions on record, as traces have them: values and derivatives are those of the stack programs."""

from __future__ import annotations

import numpy as np
import pytest

from rattle.jit import functions as compiled_functions
from rattle.language import bytecode, jets
from rattle.language.expression import compile_program, concatenate, parse
from rattle.trace.elementary import lower
from rattle.trace.graph import Graph
from rattle.trace.recording import Recorder

pytestmark = [pytest.mark.nojit, pytest.mark.plain]

TEXTS = [
    "floor(3*a) + floor(b)",
    "mod(3*a, b)",
    "ln(a*a + 1)",
    "a if a < b and b <= 0.7 else 2*b",
    "a*b if a > b or not b >= 0.7 else 2",
    "a if not (a < b and a > 0.2) and 1 < 2 else b*b",
    "a if a < b else b",
]


@pytest.mark.parametrize("text", TEXTS)
def test_values_and_derivatives_on_record_are_those_of_programs(text, monkeypatch):
    monkeypatch.setattr(compiled_functions, "_jit", False)
    code, const, first, depth = concatenate([compile_program(parse(text), {}, {}, {"a": 0, "b": 1})])
    graph = Graph()
    inputs = [graph.input() for _ in range(6)]  # a, b, each with two derivatives
    recorder = Recorder(graph)
    stack, made = np.zeros(3 * depth, dtype=object), np.zeros(3, dtype=object)
    given = np.array(inputs, dtype=object).reshape(2, 3)
    recorder.recorded(jets.evaluate_jet.python)(code, const, 0, int(first[1]), 0.0, given, stack, made)
    value = recorder.recorded(bytecode.evaluate.python)(
        code, const, 0, int(first[1]), 0.0, np.zeros((1, 8)), given[:, 0], np.zeros(depth, dtype=object)
    )
    states = np.random.default_rng(0).uniform(-1.0, 2.0, (6, 40))
    found = graph_values(graph, [value, *made], states)
    for k, state in enumerate(states.T):
        out = np.empty(3)
        jets.evaluate_jet(code, const, 0, int(first[1]), 0.0, state.reshape(2, 3), np.empty(3 * depth), out)
        np.testing.assert_allclose(found[1:, k], out, rtol=1e-13, atol=1e-13)
        assert found[0, k] == pytest.approx(out[0], rel=1e-13, abs=1e-13)


def graph_values(graph, outputs, inputs):
    exact, symbols = lower(graph, outputs)
    return exact.evaluate(symbols, inputs)
