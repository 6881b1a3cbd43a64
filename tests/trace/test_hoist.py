"""A calculation split into what some inputs determine and the rest: same bits, nothing computed twice."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rattle.trace.graph import Graph, select
from rattle.trace.hoist import hoist

pytestmark = [pytest.mark.nojit, pytest.mark.plain]


@settings(max_examples=60)
@given(st.lists(st.tuples(st.sampled_from("+-*/<?"), st.integers(0, 99), st.integers(0, 99)), min_size=1, max_size=40))
def test_the_two_parts_do_what_the_whole_does(steps):
    graph = Graph()
    inputs = [graph.input() for _ in range(4)]
    numbers, flags = [*inputs, 2.5], [inputs[2] < inputs[3]]
    for op, i, j in steps:
        a, b = numbers[i % len(numbers)], numbers[j % len(numbers)]
        if op == "<":
            flags.append(graph.apply("less", a, b))
        else:
            name = {"+": "add", "-": "sub", "*": "mul", "/": "div"}.get(op)
            numbers.append(graph.apply(name, a, b) if name else select(flags[i % len(flags)], a, b))
    outputs = [*numbers[4:], *flags]
    x = np.random.default_rng(0).normal(size=(4, 7))
    whole = graph.evaluate(outputs, x)
    early, prepared, late, rest = hoist(graph, outputs, [one.place for one in inputs[2:]])
    parts = late.evaluate(rest, np.concatenate([x[:2], early.evaluate(prepared, x)]))
    np.testing.assert_array_equal(whole, parts)
    alone = [place for place in late.live(rest) if late.ops[place] not in ("input", "number")]
    late_inputs = set(late.inputs[:2])
    for place in alone:  # every operation that is left depends on a late input, but for what turns numbers into flags
        below, ahead = set(), [place]
        while ahead:
            k = ahead.pop()
            below.add(k)
            ahead += late.operands[k]
        assert below & late_inputs or late.ops[place] in ("equal", "not")


def test_what_early_inputs_determine_is_not_computed_again():
    graph = Graph()
    y, p = graph.input(), graph.input()
    area = p * p * 3.0
    early, prepared, late, rest = hoist(graph, [y * area + area, p], [p.place])
    assert early.count(prepared) == 2
    assert late.count(rest) == 2
    assert len(prepared) == 2  # the area, and p itself
