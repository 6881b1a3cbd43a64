"""Rates that are rounding after an impact are zero: contacts that stay closed do so at once."""

import math
from collections import defaultdict

import numpy as np
import pytest

import rattle as rt

LAST_DIGITS = [1.0 + 3e-16 * k for k in (-4, -2, 0, 1, 3)]


def row_of_blocks(seed, most=4):
    """Blocks on a line, each guided on the one before with a stop; some rest on each other, the last one comes flying.

    No block bounces, and gravity presses all of them together.  Returns the mechanism and the time to watch it.
    """
    rng = np.random.default_rng(seed)
    count, size, at = int(rng.integers(2, most + 1)), 10 ** rng.uniform(-3, 0), 0.0
    m = rt.Mechanism("row", gravity=[-(10 ** rng.uniform(-1, 2)), 0])
    m.parameter("v", float(10 ** rng.uniform(-1, 2)))
    m.ground(O=[0, 0])
    for k in range(count):
        m.body(f"b{k}", mass=float(rng.uniform(0.1, 3)), inertia=1e-6, points={"C": [0, 0]})
        stop = {"min": 0, "max": float(size * rng.uniform(0.5, 3)), "contact": {"model": "impact", "restitution": 0}}
        m.prismatic(f"g{k}", f"b{k - 1}.C" if k else "ground.O", f"b{k}.C", stop=stop)
        last = k == count - 1
        at += float(size * rng.uniform(0.1, 0.4)) if last or rng.random() < 0.4 else 0.0
        share = 1.0 if last else rng.choice([0.0, 0.0, rng.uniform(0.3, 1.0)])
        m.initial(f"b{k}", x=at, vx=f"-v*{float(share)!r}")
    return m, 5 * math.sqrt(size) + 0.1


def events(r):
    """Times of events [s] by joint and kind."""
    times = defaultdict(list)
    for event in r.events:
        times[event.joint, event.kind].append(event.t)
    return times


def assert_same_events(m, name, t_end, tolerance):
    """Runs whose parameter `name` differs by rounding have the same events, to `tolerance` [s]."""
    value = m.parameters[name]
    runs = [events(m.set({f"parameters.{name}": value * share}).simulate(t_end)) for share in LAST_DIGITS]
    for run in runs[1:]:
        assert set(run) == set(runs[0])
        for key, times in run.items():
            assert times == pytest.approx(runs[0][key], rel=0, abs=tolerance), key


@pytest.mark.parametrize("most", [4, 9])
def test_events_in_a_row_of_blocks_do_not_depend_on_the_last_digit_of_a_speed(most):
    """Blocks at rest between others get impulses from both sides, which leave rounding beside rates of zero."""
    for seed in range(10):
        m, t_end = row_of_blocks(seed, most)
        assert_same_events(m, "v", t_end, 1e-7 * t_end)  # times of later impacts have the tolerance of the run


def test_blocks_that_do_not_bounce_are_in_contact_from_an_impact_on():
    for seed in range(25, 50):
        m, t_end = row_of_blocks(seed)
        r = m.simulate(t_end)
        begins = np.array([0.0, *(event.t for event in r.events if event.kind == "impact")])
        contacts = [event for event in r.events if event.kind == "contact"]
        assert any(event.t > 0.0 for event in contacts), seed
        for event in contacts:
            assert np.abs(begins - event.t).min() <= 1e-11 * t_end, (seed, event)


@pytest.mark.parametrize(("name", "parameter", "share"), [("ratchet", "A", 1.004), ("woodpecker", "mu", 1.0)])
def test_events_of_machines_do_not_depend_on_the_last_digit_of_a_parameter(name, parameter, share):
    """A pawl that catches its tooth, and a sleeve that jams on its pole, are in contact from that impact on."""
    m = rt.example(name)
    m = m.set({f"parameters.{parameter}": m.parameters[parameter] * share})
    assert_same_events(m, parameter, None, 1e-9)
