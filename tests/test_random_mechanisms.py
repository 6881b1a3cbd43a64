"""Random mechanisms against an independent code (tests/reference): accelerations, reactions, motion, modes of friction.

The seeds stand in the names of the tests.  A run that ends where the reference has an answer is a failure.
"""

import numpy as np
import pytest

import rattle as rt
from reference.generate import drawn
from reference.set_valued import answers

BATCH, FEW = 10, 2
BATCHES = [pytest.param(first, marks=pytest.mark.long if first >= FEW else ()) for first in range(0, 200, FEW)]


def accelerations(result, count):
    return np.array([float(result[f"b{k}.{key}"][0]) for k in range(count) for key in ("ax", "ay", "alpha")])


@pytest.mark.parametrize("first", BATCHES)
def test_accelerations_reactions_and_motion_are_those_of_the_reference(first):
    for seed in range(first, first + FEW):
        given = drawn(seed)
        r = rt.loads(given.text).simulate(0.1, t_eval=[0.0, 0.1], rtol=1e-11, atol=1e-13)
        count = len(given.mechanism.bodies)
        acceleration, multiplier, unique = given.mechanism.accelerations(given.q, given.v, 0.0)
        size = 1.0 + np.abs(acceleration).max()
        assert accelerations(r, count) == pytest.approx(acceleration, abs=1e-8 * size), seed
        for name, rows in given.joints.items():
            if len(rows) < 2 or not unique[rows].all() or f"{name}.fx" not in r:
                continue
            if given.text.split(f"[joints.{name}]")[1].lstrip().startswith('type = "revolute"'):
                force = [float(r[f"{name}.{key}"][0]) for key in ("fx", "fy")]
                assert force == pytest.approx(-multiplier[rows], abs=1e-7 * size), (seed, name)
        named = set(r.trust.nonunique)
        assert named == {name for name, rows in given.joints.items() if not unique[rows].all()}, seed
        if r.success:
            state = given.mechanism.run(given.q, given.v, 0.1)
            end = [float(r[f"b{k}.{key}"][-1]) for k in range(count) for key in ("x", "y", "angle")]
            assert end == pytest.approx(state[: 3 * count], abs=1e-6), seed


@pytest.mark.parametrize(("pins", "clutches"), [(1, 0), (2, 0), (3, 0), (0, 1), (0, 2), (1, 1), (2, 2)])
@pytest.mark.parametrize(
    "first", [pytest.param(first, marks=pytest.mark.long if first > BATCH else ()) for first in range(0, 60, BATCH)]
)
def test_friction_and_clutches_are_in_modes_that_trying_all_of_them_gives(pins, clutches, first):
    for seed in range(first, first + BATCH):
        given = drawn(1000 * pins + 100 * clutches + seed, pins, clutches, at_rest=0.5)
        possible = answers(given.mechanism, given.q, given.v, 0.0, given.pins, given.clutches)
        if not possible:
            continue  # the reference decides nothing either
        r = rt.loads(given.text).simulate(1e-9, t_eval=[0.0, 1e-9])
        assert r.success, (seed, r.message, [one.modes for one in possible])
        seen = accelerations(r, len(given.mechanism.bodies))
        size = 1.0 + max(np.abs(one.acceleration).max() for one in possible)
        nearest = min(np.abs(seen - one.acceleration).max() for one in possible)
        assert nearest <= 1e-6 * size, (seed, [one.modes for one in possible])


@pytest.mark.nojit
@pytest.mark.parametrize("seed", [235, 243])
def test_clutches_that_slip_together_are_in_their_modes_from_the_first_instant(seed):
    """Once the first slips the other is overrun: it neither slips nor needs an event right after the start."""
    given = drawn(seed, 0, 2, at_rest=0.5)
    (only,) = answers(given.mechanism, given.q, given.v, 0.0, given.pins, given.clutches)
    r = rt.loads(given.text).simulate(1e-9, t_eval=[0.0, 1e-9])
    size = 1.0 + np.abs(only.acceleration).max()
    assert accelerations(r, len(given.mechanism.bodies)) == pytest.approx(only.acceleration, abs=1e-8 * size)
    assert all(event.t == 0.0 for event in r.events)
