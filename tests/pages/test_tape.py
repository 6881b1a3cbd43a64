"""Recorded functions on a tape: the bits of the reference in node, and what functions share stands once."""

import json
import shutil
import subprocess

import numpy as np
import pytest

import rattle as rt
from core_engine import VIEWER
from rattle.pages.page import page
from rattle.pages.tape import Tape
from rattle.trace.elementary import lower
from rattle.trace.graph import EXACT, FLAGS, Graph, Symbol, select

pytestmark = pytest.mark.skipif(shutil.which("node") is None, reason="no node")
SCRIPT = """
import fs from "node:fs";
import { openTape } from "%(viewer)s/tape.js";
const functions = await openTape(JSON.parse(fs.readFileSync("tape.json")));
const { widths, calls } = JSON.parse(fs.readFileSync("calls.json"));
const all = new Float64Array(new Uint8Array(fs.readFileSync("in.bin")).buffer), made = [];
let at = 0;
for (const [number, length] of calls) {
  const out = new Float64Array(widths[number]);
  functions[number](all.subarray(at, at + length), out);
  made.push(...out);
  at += length;
}
fs.writeFileSync("out.bin", Float64Array.from(made));
"""
ODD = (0.0, -0.0, 1.0, -1.0, np.inf, -np.inf, np.nan, 5e-324, -5e-324, 2.2e-308, 1.8e308, 3.0, -7.5, 1e-5, 1000.0)


def called(folder, tape, calls):
    """Outputs of calls in their order, of (number, width of the outputs, inputs)."""
    (folder / "tape.json").write_text(json.dumps(tape.written()))
    widths = {number: width for number, width, _ in calls}
    told = {"widths": widths, "calls": [[number, len(inputs)] for number, _, inputs in calls]}
    (folder / "calls.json").write_text(json.dumps(told))
    np.concatenate([inputs for *_, inputs in calls]).tofile(folder / "in.bin")
    (folder / "go.mjs").write_text(SCRIPT % {"viewer": VIEWER.as_uri()}, encoding="utf-8")
    done = subprocess.run(["node", "go.mjs"], cwd=folder, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr
    ends = np.cumsum([width for _, width, _ in calls])
    return np.split(np.fromfile(folder / "out.bin"), ends[:-1])


def require_same_bits(got, want):
    known = ~np.isnan(want)
    np.testing.assert_array_equal(np.isnan(got), ~known)
    np.testing.assert_array_equal(got[known].view(np.int64), want[known].view(np.int64))


def random_graph(random, inputs, operations):
    """A graph of random exact operations, each at least twice, and all its symbols as outputs."""
    graph = Graph()
    numbers = [graph.input() for _ in range(inputs)] + [Symbol(graph, graph.number(x)) for x in ODD]
    flags = [numbers[0] < numbers[1]]
    names = [*EXACT] * 2 + list(random.choice([*EXACT], operations))
    for op in random.permutation(names):
        of_flags = op in ("both", "either", "not")
        operands = [
            (flags if of_flags else numbers)[k]
            for k in random.integers(0, 1 << 30, 3) % len(flags if of_flags else numbers)
        ]
        if op == "select":
            operands[0] = flags[random.integers(len(flags))]
        place = graph.join(op, tuple(x.place for x in operands[: EXACT[op]]))
        (flags if op in FLAGS else numbers).append(Symbol(graph, place))
    return graph, [*numbers, *flags]


@pytest.mark.parametrize("seed", range(4))
def test_functions_have_the_bits_of_the_reference(seed, tmp_path):
    """Whatever numbers they are given, and in whatever order: what parameters alone decide is kept between calls."""
    random, tape, graphs = np.random.default_rng(seed), Tape(), []
    for early in (0, 2, 5):
        graph, outputs = random_graph(random, 5, 300)
        keys = [("p", f"x{k}") if k < early else ("row", k) for k in range(5)]
        graphs.append((tape.add(graph, outputs, keys), graph, outputs))
    calls, want = [], []
    values = random.choice(ODD, 5)
    for _ in range(120):
        number, graph, outputs = graphs[random.integers(len(graphs))]
        values = values.copy()
        values[random.integers(5)] = random.choice([*ODD, *random.normal(size=5)])
        calls.append((number, len(outputs), values))
        want.append(graph.evaluate(outputs, values[:, None])[:, 0])
    for mine, reference in zip(called(tmp_path, tape, calls), want, strict=True):
        require_same_bits(mine, reference)


def test_functions_of_two_graphs_share_what_is_the_same():
    """Inputs are the same where their keys are; the sides of a sum or product may be swapped."""

    def sine(swap):
        graph = Graph()
        a, b = graph.input(), graph.input()
        x = b * a if swap else a * b
        return lower(graph, [graph.apply("sin", x), x + 1.0])

    tape = Tape()
    graph, outputs = sine(False)
    tape.add(graph, outputs, [("p", "a"), ("p", "b")])
    alone = tape.operations
    assert alone == graph.count(outputs) > 20
    tape.add(*sine(True), [("p", "a"), ("p", "b")])
    assert tape.operations == alone
    tape.add(*sine(False), [("p", "a"), ("p", "c")])
    assert tape.operations == 2 * alone


def test_a_function_of_nothing_and_one_of_numbers_alone(tmp_path):
    tape = Tape()
    graph = Graph()
    x, y = graph.input(), graph.input()
    numbers = tape.add(graph, [2.5, -0.0, x], [("row", 0), ("row", 1)])
    nothing = tape.add(graph, [], [("row", 0), ("row", 1)])
    condition = tape.add(graph, [select(x < y, y, 7.0)], [("p", "x"), ("row", 1)])
    calls = [
        (numbers, 3, np.array([4.0, 5.0])),
        (nothing, 0, np.array([1.0, 2.0])),
        (condition, 1, np.array([2.0, 1.0])),
    ]
    first, second, third = called(tmp_path, tape, calls)
    require_same_bits(first, np.array([2.5, -0.0, 4.0]))
    assert (len(second), third[0]) == (0, 7.0)


MOST_BYTES = 500_000  # of a page: what a mail or a slow line carries; without sharing these have more than 800 000


@pytest.mark.parametrize("name", ["rotor_whirl", "stribeck"])
def test_pages_with_tables_of_oil_films_stay_small(name, tmp_path):
    page(rt.example(name), tmp_path / "page.html")
    assert (tmp_path / "page.html").stat().st_size < MOST_BYTES
