"""Multipliers from the sparse factor against dense linear algebra, on random mechanisms and on long chains."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rattle.equations import schur
from rattle.jit import functions
from rattle.jit import layout as at
from rattle.jit.workspace import Workspace

pytestmark = pytest.mark.nojit


@pytest.fixture(params=["python", "machine"])
def mode(request, monkeypatch):
    if request.param == "python":
        monkeypatch.setattr(functions, "_jit", False)
    elif not functions.start():
        pytest.skip("machine code is switched off")


def system(joints, rows, weight):
    """Workspace with what the factor reads, and the dense Jacobian. joints: (A, B, number of rows)."""
    row_body = [(a, b) for a, b, count in joints for _ in range(count)]
    ends = np.cumsum([0, *(count for _, _, count in joints)])
    blocks = [range(first, last) for first, last in pairwise(ends)]
    pattern = schur.analyse(row_body, blocks)
    nr, nb = len(row_body), len(weight)
    dense = np.zeros((nr, 3 * nb))
    for r, (a, b) in enumerate(row_body):
        dense[r, 3 * a : 3 * a + 3] += rows[r, at.AX : at.AX + 3]
        dense[r, 3 * b : 3 * b + 3] += rows[r, at.BX : at.BX + 3]
    arrays = {
        "weight": weight,
        "rows": rows,
        "row_body": np.array(row_body, np.int64).reshape(-1, 2),
        **pattern._asdict(),
        "schur": np.zeros(nr + len(pattern.below)),
        "inverse": np.zeros(nr),
        "redundant": np.zeros(nr, np.int64),
        "pivots_of_row": np.zeros((nr, at.width("pivots_of_row"))),
        "solution": np.zeros(nr),
        "power": np.ones(at.width("power")),
    }
    return Workspace(arrays), dense[:, 3:], pattern


def random_system(seed, bodies, joints):
    rng = np.random.default_rng(seed)
    pairs = []
    for _ in range(joints):
        a, b = rng.choice(bodies + 1, 2, replace=False)
        pairs.append((int(a), int(b), int(rng.integers(1, 4))))
    rows = rng.normal(size=(sum(count for _, _, count in pairs), 9))
    weight = np.vstack([np.zeros(3), rng.uniform(0.1, 10, (bodies, 3))])
    return (*system(pairs, rows, weight), weight[1:].ravel(), rng)


def solve(m, pattern, right):
    m.solution[pattern.place] = right
    schur.solve(m)
    return m.solution[pattern.place]


@pytest.mark.usefixtures("mode")
@pytest.mark.parametrize("seed", range(20))
def test_multipliers_are_those_of_dense_algebra(seed):
    bodies = 2 + seed
    m, jacobian, pattern, weight, rng = random_system(seed, bodies, int(0.9 * bodies))
    full = (jacobian * weight) @ jacobian.T
    right = rng.normal(size=len(jacobian))
    lost = schur.factorise(m)
    if np.linalg.cond(full) > 1e8:
        pytest.skip("too close to singular to compare digits")
    assert lost == 0
    np.testing.assert_allclose(solve(m, pattern, right), np.linalg.solve(full, right), rtol=1e-6, atol=1e-9)


@pytest.mark.usefixtures("mode")
@pytest.mark.parametrize("seed", range(10))
def test_redundant_rows_are_counted_and_change_nothing(seed):
    """A joint entered twice: its second copy takes no force, the accelerations stay those of the first alone."""
    rng = np.random.default_rng(seed)
    single = [(0, 1, 2), (1, 2, 2), (2, 3, 1), (0, 3, 1)]
    rows = rng.normal(size=(6, 9))
    weight = np.vstack([np.zeros(3), rng.uniform(0.5, 2, (3, 3))])
    right = rng.normal(size=6)
    m, jacobian, pattern = system(single, rows, weight)
    assert schur.factorise(m) == 0
    motion = jacobian.T @ solve(m, pattern, right)
    copy = rng.permutation(6)[:3]
    doubled = [*single, *[(*next(pair[:2] for pair, row in owners(single) if row == r), 1) for r in copy]]
    m2, jacobian2, pattern2 = system(doubled, np.vstack([rows, rows[copy]]), weight)
    assert schur.factorise(m2) == 3
    multipliers = solve(m2, pattern2, np.concatenate([right, right[copy]]))
    np.testing.assert_allclose(jacobian2.T @ multipliers, motion, rtol=1e-6, atol=1e-8)
    assert (multipliers[m2.redundant[pattern2.place] == 1] == 0.0).all()


def owners(joints):
    row = 0
    for joint in joints:
        for _ in range(joint[2]):
            yield joint, row
            row += 1


@given(st.integers(0, 10_000), st.integers(1, 8), st.integers(1, 12))
def test_any_graph_of_joints_gives_consistent_motion(seed, bodies, joints):
    """However many rows are redundant: for a right side in the range of S the equations are satisfied."""
    m, jacobian, pattern, weight, rng = random_system(seed, bodies, joints)
    full = (jacobian * weight) @ jacobian.T
    right = full @ rng.normal(size=len(jacobian))
    schur.factorise(m)
    found = solve(m, pattern, right)
    scale = np.abs(right).max() + 1.0
    np.testing.assert_allclose(full @ found, right, atol=1e-6 * scale)


def chain(links, rng=None):
    rng = rng or np.random.default_rng(0)
    joints = [(n, n + 1, 2) for n in range(links)]
    return system(joints, rng.normal(size=(2 * links, 9)), np.vstack([np.zeros(3), np.ones((links, 3))]))


def test_fill_of_a_chain_grows_linearly():
    sizes = [len(chain(links)[2].below) for links in (100, 200, 400)]
    assert sizes[0] <= 10 * 100  # 2 x 2 blocks beside the diagonal, little more
    assert sizes[2] - sizes[1] == 2 * (sizes[1] - sizes[0])  # every further link adds as much: the ends alone differ
    updates = [len(chain(links)[2].target) for links in (100, 200, 400)]
    assert updates[2] - updates[1] == 2 * (updates[1] - updates[0])


def test_fill_of_a_closed_ring_and_a_star_stays_small():
    rng = np.random.default_rng(1)
    n = 200
    ring = [(k, k % n + 1, 2) for k in range(1, n + 1)]
    weight = np.vstack([np.zeros(3), np.ones((n, 3))])
    _, _, pattern = system(ring, rng.normal(size=(2 * n, 9)), weight)
    assert len(pattern.below) < 20 * n
    pairs = [(k, k + 1, 2) for k in range(1, n, 2)]  # many small mechanisms side by side
    _, _, pattern = system(pairs, rng.normal(size=(n, 9)), weight)
    assert len(pattern.below) == n // 2  # one entry within every joint, none between joints


def test_long_chain_is_solved_as_exactly_as_a_short_one():
    m, jacobian, pattern = chain(300)
    right = np.random.default_rng(2).normal(size=600)
    assert schur.factorise(m) == 0
    found = solve(m, pattern, right)
    full = jacobian @ jacobian.T
    assert np.abs(full @ found - right).max() < 1e-9 * np.abs(found).max()


def test_rows_of_one_joint_stay_together():
    _, _, pattern = chain(50)
    place = pattern.place.reshape(-1, 2)
    assert (np.abs(place[:, 0] - place[:, 1]) == 1).all()
    assert sorted(pattern.place) == list(range(100))
