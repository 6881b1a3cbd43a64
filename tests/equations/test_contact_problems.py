"""Contact problems of any size: their conditions, checked with a matrix made elsewhere, and chains that go on."""

import math

import numpy as np
import pytest

import rattle as rt
from rattle.equations import complementarity, lemke, motion, unilateral
from rattle.equations.complementarity import BACKWARD, FORWARD, IMPOSSIBLE, JAMMED, SOLVED, STICK, A, B, F
from rattle.jit import functions
from rattle.jit import layout as at
from rattle.solvers.nonsmooth import uniqueness
from rattle.solvers.nonsmooth.contact_arrays import contact_arrays

MASS, INERTIA, ARM, PLAY, BORE = 0.5, 0.5 * 0.2**2 / 12, 0.1, 1e-3, 0.01


def chain(pins, friction=0.1, restitution=0.3, hanging=False, bend=0.4):
    """Links of 0.2 m below each other; each pin in the middle of its bush, or at its bottom if hanging."""
    contact = f'{{ model = "impact", restitution = {restitution}, friction = {friction}, bush_radius = {BORE} }}'
    bodies, joints, start = [], [], ["[initial]"]
    x, y = 0.0, 0.0
    for k in range(pins):
        bodies += [f"[bodies.b{k}]", f"mass = {MASS}", f"inertia = {INERTIA}"]
        bodies += [f"points = {{ T = [{-ARM}, 0], B = [{ARM}, 0] }}"]
        above = f"b{k - 1}.B" if k else "ground.G"
        joints += [f"[joints.p{k}]", 'type = "revolute"', f'connect = ["{above}", "b{k}.T"]', f"clearance = {PLAY}"]
        joints += [f"contact = {contact}"]
        angle = bend * math.cos(1.3 * k) - math.pi / 2
        y -= PLAY if hanging else 0.0
        x, y = x + ARM * math.cos(angle), y + ARM * math.sin(angle)
        start += [f"b{k} = {{ x = {x!r}, y = {y!r}, angle = {angle!r}, vx = 0, vy = 0, omega = 0 }}"]
        x, y = x + ARM * math.cos(angle), y + ARM * math.sin(angle)
    head = ["format = 1", "gravity = [0, -9.81]", "[ground.points]", "G = [0, 0]"]
    return rt.loads("\n".join([*head, *bodies, *joints, *start]))


def problem(pins, friction, rng, known_slip=False):
    """A problem with all pins of a chain closed and any right side; its workspace and G, without the joints' code."""
    functions.start()
    system = chain(pins, friction, hanging=True).system
    workspace = system.workspace(**contact_arrays(system), course=np.zeros(at.width("course")))
    q = np.concatenate([[0.3 * k, -0.2 * k, rng.uniform(-3, 3)] for k in range(pins)])
    motion.free_motion(workspace, 0.0, q, rng.normal(size=3 * pins))
    workspace.active[:] = np.arange(pins)
    workspace.slide[:] = rng.choice([-1, 1], pins) if known_slip else 0
    workspace.candidate[:] = np.where(workspace.slide < 0, BACKWARD, FORWARD)
    complementarity.rows_kernel(workspace, pins)
    workspace.side[B] = rng.normal(size=2 * pins) * 10.0 ** rng.uniform(-4, 0, 2 * pins)
    lines = np.zeros((2 * pins, 3 * pins))
    for k, contact in enumerate(system.arrays["contact"]):
        for column, body in ((0, contact[at.A_BODY]), (3, contact[at.B_BODY])):
            if body:
                lines[2 * k : 2 * k + 2, 3 * body - 3 : 3 * body] = workspace.contact_jacobian[
                    2 * k : 2 * k + 2, column : column + 3
                ]
    return workspace, lines @ np.diag(1.0 / np.tile([MASS, MASS, INERTIA], pins)) @ lines.T


def breach(workspace, matrix, friction):
    """Largest violation of the conditions, as a share of the largest force and of the largest term of a."""
    b, f = workspace.side[B].copy(), workspace.side[F]
    a, slide, known = matrix @ f + b, workspace.slide, slice(None, None, 1 if friction > 0.0 else 2)
    normal, held, opening, rate = f[0::2], f[1::2], a[0::2], a[1::2]
    unit = max(np.abs(b).max(), np.abs(matrix * f).max())
    force = np.abs(f).max() + 1e-300
    slipping = np.where(slide != 0, slide, np.where(np.abs(rate) > 1e-9 * unit, -np.sign(rate), 0))
    return max(
        -normal.min() / force,
        -opening.min() / unit,
        (np.minimum(normal / force, opening / unit)).max(),
        (np.abs(held) - friction * normal).max() / force,
        np.abs(np.where(slipping != 0, held - friction * normal * slipping, 0.0)).max() / force,
        np.abs(a - workspace.side[A])[known].max() / unit,
    )


@pytest.mark.parametrize(
    ("pins", "friction"), [(3, 0.1), (4, 1.0), (7, 0.3), (12, 0.1), (12, 1.0), (40, 0.1), (40, 0.0)]
)
def test_every_impact_with_friction_is_solved_whatever_its_size(pins, friction):
    rng = np.random.default_rng(5)
    for _ in range(20):
        workspace, matrix = problem(pins, friction, rng)
        assert complementarity.search_kernel(workspace, pins) == SOLVED
        assert breach(workspace, matrix, friction) < 1e-9  # rounding, times the condition of a long chain


@pytest.mark.parametrize("pins", [3, 12, 40])
def test_the_path_alone_ends_in_a_solution_of_every_impact(pins):
    rng = np.random.default_rng(6)
    for friction in (0.0, 0.1, 1.0, 3.0):
        workspace, matrix = problem(pins, friction, rng)
        b = workspace.side[B].copy()
        assert lemke.follow_kernel(workspace, pins) == SOLVED
        assert (workspace.side[B] == b).all()
        complementarity.modes_kernel(workspace, 4 * pins + 1)
        assert breach(workspace, matrix, friction) < 1e-9


def test_path_that_runs_off_is_seldom_wrong_and_all_modes_tell(monkeypatch):
    rng = np.random.default_rng(7)
    jammed = 0
    for _ in range(150):
        workspace, matrix = problem(3, 2.0, rng, known_slip=True)
        along_path = lemke.follow_kernel(workspace, 3)
        outcome = complementarity.search_kernel(workspace, 3)
        assert outcome == (SOLVED if uniqueness.count_kernel(workspace, 3) else IMPOSSIBLE)
        if outcome == IMPOSSIBLE:
            assert along_path == JAMMED
            jammed += 1
        else:
            assert breach(workspace, matrix, 2.0) < 1e-9
    assert jammed > 20  # this friction does jam


def test_many_contacts_that_friction_jams_are_not_called_solved():
    rng = np.random.default_rng(8)
    outcomes = []
    for _ in range(40):
        workspace, matrix = problem(9, 2.0, rng, known_slip=True)
        outcomes.append(complementarity.search_kernel(workspace, 9))
        assert outcomes[-1] == JAMMED or breach(workspace, matrix, 2.0) < 1e-9
    assert {SOLVED, JAMMED} == set(outcomes)


def solvable(matrix, b, slide, friction):
    """True when some contacts press, the others being open: all 2^n are tried, the sense of every slip being known."""
    count = len(slide)
    driven = matrix[0::2, 0::2] + matrix[0::2, 1::2] * (friction * slide)
    for code in range(2**count):
        on = np.array([code >> k & 1 for k in range(count)], bool)
        pressed = np.zeros(count)
        pressed[on] = np.linalg.solve(driven[np.ix_(on, on)], -b[0::2][on])
        if (pressed >= 0.0).all() and (driven @ pressed + b[0::2] >= -1e-9 * np.abs(b).max()).all():
            return True
    return False


def test_many_contacts_are_said_to_have_no_solution_only_where_no_modes_of_theirs_are_one():
    rng = np.random.default_rng(10)
    ends = []
    for _ in range(25):
        workspace, matrix = problem(8, 2.0, rng, known_slip=True)
        b, slide = workspace.side[B].copy(), workspace.slide.copy()
        found = complementarity.search_kernel(workspace, 8) == SOLVED or bool(unilateral.solve_by_trying(workspace, 8))
        assert found == solvable(matrix, b, slide, 2.0)
        assert not found or breach(workspace, matrix, 2.0) < 1e-9
        ends.append(int(workspace.held[at.OUTCOME]))
    assert set(ends) == {SOLVED, IMPOSSIBLE}


def rough_chain(seed, pins, play):
    """A chain hanging askew whose pins rub with mu = 1, as drawn by chance."""
    rng = np.random.default_rng(seed)
    text = ["format = 1", "gravity = [0, -9.81]", "[ground.points]", "G = [0, 0]"]
    contact = '{ model = "impact", restitution = 0.3, friction = 1.0, bush_radius = 0.01 }'
    for k, mass in enumerate(rng.uniform(0.2, 1.0, pins)):
        above = f"b{k - 1}.B" if k else "ground.G"
        text += [f"[bodies.b{k}]", 'bar = ["T", "B"]', "length = 0.2", f"mass = {mass}", f"[joints.p{k}]"]
        text += ['type = "revolute"', f'connect = ["{above}", "b{k}.T"]', f"clearance = {play}", f"contact = {contact}"]
    text += ["[initial]", *(f"b{k} = {{ angle = {-1.57 + rng.normal() * 0.4}, omega = 0 }}" for k in range(pins))]
    return rt.loads("\n".join(text))


@pytest.mark.parametrize("rtol", [1e-7, 1e-9])
def test_slips_that_an_impact_leaves_far_along_a_chain_do_not_jam_it(rtol):
    """Percussions fall off by orders from pin to pin: slips of 1e-12 m/s have no sense that friction could oppose.

    With that sense the problem at 75 ms would have no solution; longer chains in motion are chaotic and may lock.
    """
    run = rough_chain(11, 16, 2e-4).simulate(0.08, rtol=rtol)
    assert run.success, run.message
    assert run.trust.energy_balance < 1e-6  # of 10 J; the tolerance leaves 1e-7 J without contacts


def test_contacts_of_a_chain_change_one_at_a_time_however_hard_they_pressed_before():
    """Near a lock a pin has pressed with 1e8 N; at 1 N it has not let go when its neighbour does."""
    for seed, pins in ((0, 16), (2, 12), (3, 12)):
        run = rough_chain(seed, pins, 2e-4).simulate(0.14, rtol=1e-7)
        assert "change without end" not in run.message  # a lock may come: such a chain is chaotic
        assert run.t[-1] > 0.1
        assert run.trust.energy_balance < 1e-6  # of 10 J; the tolerance leaves 1e-7 J without contacts


def test_uniqueness_is_given_by_weak_friction_and_counted_where_it_is_strong():
    rng = np.random.default_rng(9)
    found = {}
    for friction in (0.05, 2.0):
        for _ in range(40):
            workspace, _ = problem(3, friction, rng, known_slip=True)
            workspace.slide[::2] = 0
            weak = uniqueness.surely_one(workspace, 3)
            complementarity.search_kernel(workspace, 3)
            solutions = uniqueness.try_kernel(workspace, 2 * 3 + 1)
            assert not weak or solutions == 1
            found.setdefault(friction, set()).add((weak, solutions))
    assert found[0.05] == {(True, 1)}
    assert (False, 2) in found[2.0]


def test_contacts_that_neither_press_nor_part_do_not_make_a_second_solution():
    rng = np.random.default_rng(11)
    for _ in range(30):
        workspace, _ = problem(11, 0.3, rng)
        workspace.side[B] *= 1e-17  # what rounding leaves of contacts at rest
        workspace.side[B, -2] = -2e-6  # one of them hits
        workspace.candidate[:] = STICK
        assert complementarity.search_kernel(workspace, 11) == SOLVED
        before = workspace.candidate.copy(), workspace.side[F].copy()
        assert uniqueness.count_kernel(workspace, 11) == 1
        assert (workspace.candidate == before[0]).all()
        assert workspace.side[F] == pytest.approx(before[1], abs=1e-12 * np.abs(before[1]).max())


@pytest.mark.parametrize("pins", [3, 9, 40])
def test_sparse_solution_is_that_of_the_full_matrix(pins):
    rng = np.random.default_rng(10)
    workspace, matrix = problem(pins, 0.3, rng)
    modes = rng.integers(0, 4, pins)
    workspace.candidate[:] = modes
    complementarity.modes_kernel(workspace, 4 * pins + 1)
    lines = [r for k in range(pins) for r in (2 * k, 2 * k + 1) if modes[k] == 1 or (modes[k] > 1 and r % 2 == 0)]
    pull = np.eye(2 * pins)
    for k in range(pins):
        pull[2 * k + 1, 2 * k] = {2: 0.3, 3: -0.3}.get(int(modes[k]), 0.0)
    f = np.zeros(2 * pins)
    f[lines] = np.linalg.solve((matrix @ pull)[np.ix_(lines, lines)], -workspace.side[B][lines])
    f = pull @ f
    assert workspace.side[F] == pytest.approx(f, abs=1e-11 * np.abs(f).max())
    assert (workspace.held[at.SPARSE] == 1.0) == (pins > complementarity.FEW)


# ---------------------------------------------------------------- runs
@pytest.mark.parametrize(("pins", "friction", "restitution", "t_end"), [(12, 0.1, 0.3, 0.45), (7, 0.1, 0.8, 0.12)])
def test_chain_of_loose_pins_goes_on_through_its_impacts(pins, friction, restitution, t_end):
    r = chain(pins, friction, restitution).simulate(t_end, rtol=1e-6)
    assert r.success
    assert r.t[-1] == t_end
    assert r.trust.energy_balance < 1e-4  # tolerance of the run, after thousands of impacts
    assert max(r[f"p{k}.penetration"].max() for k in range(pins)) < 1e-9  # of a play of 1e-3


def test_words_about_an_unsolved_problem_name_painleve_only_where_friction_is_shown_to_jam():
    from rattle.analyses.dynamics.event_driven_run import EventDrivenRun

    run = EventDrivenRun.__new__(EventDrivenRun)
    said = {}
    for outcome in (IMPOSSIBLE, JAMMED, complementarity.UNDECIDED):
        workspace, _ = problem(3, 0.1, np.random.default_rng(1))
        workspace.held[at.OUTCOME] = outcome
        run.system, run.workspace, run.clock = chain(3).system, workspace, np.zeros(9)
        said[outcome] = EventDrivenRun.explain(run, unilateral.ending(workspace))  # without the state of a run
    assert "has no solution" in said[IMPOSSIBLE]
    assert "Painleve" in said[IMPOSSIBLE]
    assert "has no solution" not in said[JAMMED]
    assert "Painleve" not in said[JAMMED]
    assert "too many to try all" in said[JAMMED]
    assert "does not mean" in said[complementarity.UNDECIDED]
    assert "Painleve" not in said[complementarity.UNDECIDED]
