"""The search for positions of rest: complete along one freedom, each position once, bounded in work, with a word."""

import math

import numpy as np
import pytest

import rattle as rt
from rattle import statics
from rattle.resting import Rest
from rattle.steppers import dense

nojit = pytest.mark.nojit


def tree(seed: int, bodies: int, clearance: str = "") -> str:
    """Bars hung from each other at random, with springs to the ground, and a rod that closes a loop."""
    random = np.random.default_rng(seed)
    text = "format = 1\ngravity = [0, -9.81]\n[ground.points]\n"
    ground = random.uniform(-0.6, 0.6, (3, 2))
    text += "".join(f"G{k} = [{x}, {y}]\n" for k, (x, y) in enumerate(ground))
    length, angle = random.uniform(0.2, 0.6, bodies), random.uniform(-3, 3, bodies)
    ends = [ground[0]]
    initial = "[initial]\n"
    for b in range(bodies):
        parent = int(random.integers(max(0, b - 2), b)) if b else -1
        text += f'[bodies.b{b}]\nbar = ["P", "Q"]\nlength = {length[b]}\nmass = {random.uniform(0.2, 3)}\n'
        base = f"b{parent}.Q" if b else "ground.G0"
        text += f'[joints.j{b}]\ntype = "revolute"\nconnect = ["{base}", "b{b}.P"]\n'
        text += clearance if b in (1, 2) else ""
        ends.append(ends[parent + 1] + length[b] * np.array([math.cos(angle[b]), math.sin(angle[b])]))
        initial += f"b{b} = {{ angle = {angle[b]} }}\n"
    for s, b in enumerate((bodies - 1, bodies // 2)):
        text += f'[loads.s{s}]\ntype = "spring"\nconnect = ["ground.G1", "b{b}.Q"]\nstiffness = {90 * (s + 1)}\n'
        text += f"free_length = {random.uniform(0.1, 0.5)}\n"
    rod = float(np.hypot(*(ends[-1] - ground[2])))
    text += f'[joints.rod]\ntype = "rod"\nconnect = ["ground.G2", "b{bodies - 1}.Q"]\nlength = {rod}\n'
    return text + initial


PINS = 'clearance = 0.001\ncontact = "massless-link"\n'


# ---------------------------------------------------------------- bounded, with a word
@pytest.mark.parametrize(("seed", "bodies"), [(1, 4), (2, 6), (3, 8)])
def test_the_search_ends_whatever_the_mechanism(seed, bodies, monkeypatch):
    used = []
    settle = Rest.settle

    def counted(self, *arguments, **named):
        before = self.trials
        found = settle(self, *arguments, **named)
        used.append(self.trials - before)
        return found

    monkeypatch.setattr(Rest, "settle", counted)
    found = rt.loads(tree(seed, bodies, PINS)).equilibrium()
    assert found
    assert found.starts == len(used)
    assert max(used) <= statics.TRIALS_EACH + 1
    assert sum(used) <= 2 * (statics.MOST_TRIALS + statics.TRIALS_EACH)  # of the ideal mechanism, and with play
    for one in found:
        scale = max(abs(one[name]) for name in one.names if name.endswith((".fx", ".fy")))
        assert one.residual < 1e-7 * scale  # each is a position of rest


@nojit
def test_a_search_given_up_says_so(monkeypatch):
    m = rt.example("double_pendulum")
    whole = m.equilibrium()
    assert (whole.stopped, whole.note) == (False, "")
    monkeypatch.setattr(statics, "MOST_STARTS", 3)
    part = m.equilibrium()
    assert part.stopped
    assert part.note == "search stopped after 3 starts; there may be more positions of rest"
    assert 0 < len(part) <= len(whole)
    assert part.note in str(m.modes())
    assert part.note in m.equilibrium([0.0, 0.1]).trust.notes


# ---------------------------------------------------------------- complete and without doubles
def test_no_position_is_listed_twice():
    found = rt.loads(tree(5, 4, PINS)).equilibrium()
    assert len(found) > 4
    for k, one in enumerate(found):
        for other in found[:k]:
            apart = one.q - other.q
            apart[2::3] = (apart[2::3] + math.pi) % (2 * math.pi) - math.pi
            assert np.abs(apart).max() > 1e-6  # a thousandth of the play


@nojit
def test_a_walk_around_one_freedom_finds_every_change_of_sign():
    # torque of the weight against a spring over the angle: closed form, roots counted on a fine grid
    k, length, h = 60.0, 0.25, 0.8
    text = f"""
format = 1
gravity = [0, -9.81]
[ground.points]
O = [0, 0]
S = [0.3, {h}]
[bodies.rod]
bar = ["T", "B"]
length = 1
mass = 1
[joints.O]
type = "revolute"
connect = ["ground.O", "rod.T"]
[loads.spring]
type = "spring"
connect = ["ground.S", "rod.B"]
stiffness = {k}
free_length = {length}
[initial]
rod = {{ angle = 2.9 }}
"""
    phi = np.linspace(-math.pi, math.pi, 200001)
    d = np.hypot(np.cos(phi) - 0.3, np.sin(phi) - h)
    energy = 9.81 * 0.5 * np.sin(phi) + 0.5 * k * (d - length) ** 2
    slope = np.diff(energy)
    roots = phi[1:-1][slope[:-1] * slope[1:] < 0]
    found = sorted((one["rod.angle"] + math.pi) % (2 * math.pi) - math.pi for one in rt.loads(text).equilibrium())
    assert len(roots) == 4
    np.testing.assert_allclose(found, roots, atol=1e-4)  # the grid's own spacing is 3e-5 rad


@nojit
def test_where_the_stiffness_vanishes_is_no_rest():
    found = rt.example("guide_play").equilibrium()  # starts where weight and geometry make H exactly zero
    assert all(one.residual < 1e-6 for one in found)


# ---------------------------------------------------------------- linear algebra
@nojit
@pytest.mark.parametrize(("rows", "n", "rank"), [(4, 7, 4), (6, 7, 3), (7, 5, 5), (1, 3, 1), (0, 3, 0)])
def test_rank_null_space_and_least_squares_are_those_of_numpy(rows, n, rank):
    random = np.random.default_rng(rows)
    a = random.normal(size=(rows, rank)) @ random.normal(size=(rank, n))
    wide, order, pivot = a.copy(), np.zeros(rows, np.int64), np.zeros((2, rows))
    assert dense.triangulate(wide, rows, order, pivot, 1e-9) == rank
    basis = np.eye(n)
    for line in basis:
        dense.out_of_basis(wide, pivot, rank, line)
    np.testing.assert_allclose(basis @ basis.T, np.eye(n), atol=1e-14)
    np.testing.assert_allclose(a @ basis[rank:].T, np.zeros((rows, n - rank)), atol=1e-13)
    if rank == rows:  # the multipliers of a force, by least squares
        force = random.normal(size=n)
        work = force.copy()
        dense.into_basis(wide, pivot, rank, work)
        dense.solve_upper(wide, pivot, rank, work)
        wanted = np.linalg.lstsq(a.T, force, rcond=None)[0] if rows else np.zeros(0)
        np.testing.assert_allclose(work[:rank], wanted[order], atol=1e-13)


@nojit
def test_the_absolute_value_of_a_symmetric_matrix_is_inverted():
    random = np.random.default_rng(4)
    basis = np.linalg.qr(random.normal(size=(5, 5)))[0]
    values = np.array([3.0, -2.0, 2.0, -1e-3, 0.4])  # the pair of equal size is the hard case
    small, right, x = np.zeros((10, 5)), random.normal(size=5), np.zeros(5)
    small[:5] = basis @ np.diag(values) @ basis.T
    dense.rotate_columns(small, 5)
    dense.solve_downhill(small, 5, right, 1e-9, x)
    np.testing.assert_allclose(x, basis @ ((basis.T @ right) / np.abs(values)), rtol=1e-11)


@nojit
def test_a_square_system_leaves_out_what_depends_on_the_rest():
    h = np.array([[2.0, 1.0, 3.0], [1.0, 4.0, 5.0], [0.5, 1.0, 1.5]])  # last column: sum of the others
    small, right = np.zeros((6, 6)), h @ np.array([0.3, -0.2, 0.1])
    small[:3, :3] = h.T
    order, pivot, work, x = np.zeros(6, np.int64), np.zeros((2, 6)), np.zeros(6), np.zeros(6)
    dense.solve_square(small, 3, order, pivot, right, 1e-13, work, x)
    np.testing.assert_allclose(h @ x[:3], right, atol=1e-14)
    assert (x[:3] == 0.0).sum() == 1
