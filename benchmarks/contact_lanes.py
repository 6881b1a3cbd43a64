"""Samples with contacts, or joints that rub, side by side against runs alone: processor time per sample of every
example that has some."""

from __future__ import annotations

import time
from unittest import mock

import numpy as np

import rattle as rt
from measure import Row
from rattle.results.columns import geometry
from rattle.results.reductions import meetings
from rattle.trace import llvm

AIMS = {"slider_crank_play": "1.6 ms", "fourbar_onesided": "0.1"}  # with AVX-512; a tenth of a run alone
MOST = 0.5  # [s] of a run
FEW, MANY = 64, 2112  # the difference of both is what samples take, without recording and compiling
ALONE = 4  # runs
LONG, TURNS = 20_000, 0.024  # samples and duration [s] by which threads and vectors are compared
AVX2 = "znver3"  # a processor without AVX-512


def rows(repeats: int) -> list[Row]:
    """A row for each example whose samples run side by side, those that do not are named with the reason."""
    answers = []
    for name in sorted(rt.examples()):
        mechanism = rt.example(name)
        met = len(mechanism.system.arrays["contact"]) or mechanism.system.rough_joints
        if met and mechanism.model.parameters:
            answers.append(row(name, mechanism, repeats))
    return [*answers, *together()]


def together() -> list[Row]:
    """Wall time of many samples on two threads by that on one, and with four samples in a vector, as AVX2 has them."""
    m = rt.example("slider_crank_play")

    def seconds(threads: int) -> float:
        samples = {"c": m.parameters["c"] * np.linspace(0.9, 1.1, LONG)}
        m.many({"c": samples["c"][:FEW]}, ["count(B.contacts)"], TURNS, threads=threads)  # compiled
        began = time.perf_counter()
        found = m.many(samples, ["count(B.contacts)"], TURNS, threads=threads)
        assert not len(found.generic)
        return time.perf_counter() - began

    two, one = seconds(2), seconds(1)
    _, features = llvm.host()
    narrow = ",".join(f"-{x[1:]}" if x[1:].startswith("avx512") else x for x in features.split(","))
    with mock.patch.object(llvm, "host", return_value=(AVX2, narrow)):
        four = seconds(1)
    return [
        Row(f"{LONG} samples of slider_crank_play, 2 threads", two, "one thread", one, "0.55"),
        Row("sample of slider_crank_play, vectors of four", four / LONG, "of eight", one / LONG, "2.5 ms"),
    ]


def row(name: str, m: rt.Mechanism, repeats: int) -> Row:
    """Time of a sample, and of a run alone."""
    span = min(m.model.settings.t_end or MOST, MOST)
    parameter = list(m.parameters)[-1]
    value, body = m.parameters[parameter] or 1e-6, next(iter(m.model.bodies))
    outputs = [f"final({body}.x)", *(f"count({joint}.contacts)" for joint in meetings(geometry(m.model)))]
    random = np.random.default_rng(1)

    def spent(count: int) -> tuple[float, rt.Many]:
        began = time.process_time()
        found = m.many({parameter: value * random.uniform(0.99, 1.01, count)}, outputs, span, threads=1)
        return time.process_time() - began, found

    _, found = spent(8)
    if len(found.generic):
        return Row(f"samples of {name}: {found.stats['how'][:100]}", 0.0)
    times, alone = [], []
    for _ in range(repeats):
        times.append((spent(MANY)[0] - spent(FEW)[0]) / (MANY - FEW))
        began = time.process_time()
        for _ in range(ALONE):
            m.simulate(span, t_eval=[0.0, span], rtol=1e-8)
        alone.append((time.process_time() - began) / ALONE)
    return Row(f"sample of {name}", min(times), "alone", min(alone), AIMS.get(name, ""))
