"""Loose pins whose slips stop and reverse: runs go on, or end where all modes of their contacts tell that they must."""

import dataclasses

import pytest

import rattle as rt
from rattle.analyses.dynamics.event_driven_run import EventDrivenRun
from rattle.jit import layout as at
from rough_pins import FRICTIONS, RoughPins, all_solutions, least_share

END = 0.05
LOCKED = 1e-6  # share of its determinant that friction leaves, below which a solution locks
STRAY = 1e-4  # share by which friction is varied where a run ends as a contact leaves sticking


@pytest.fixture
def ends(monkeypatch):
    """Times [s] and states at the ends of runs that stopped: at the start of their last step, and at its event."""
    seen, explain = [], EventDrivenRun.explain

    def keep(run, status):
        m = run.workspace
        seen.append((float(run.clock[at.T]), m.state.copy(), m.state_new.copy()))
        return explain(run, status)

    monkeypatch.setattr(EventDrivenRun, "explain", keep)
    return seen


def problems(pins, end):
    """The problems at the end of a run, the last first, without rebound, and with a little more and less friction."""
    t, before, last = end
    size = 3 * len(pins.mass)
    cases = [pins.problem(t, y[:size], y[size : 2 * size], rebound) for rebound in (1.0, 0.0) for y in (last, before)]
    return cases + [dataclasses.replace(cases[0], mu=cases[0].mu * share) for share in (1.0 - STRAY, 1.0 + STRAY)]


def confirmed(message, cases):
    """Solutions next to a lock do not count: their forces grow without bound as it comes nearer."""
    cases = [case for case in cases if len(case.mu)]
    if "several solutions" in message:
        return any(len(all_solutions(case)) > 1 for case in cases)
    if "has no solution" in message:
        return not any(solution.lasts and solution.share > LOCKED for solution in all_solutions(cases[0]))
    locked = min((solution.share for solution in all_solutions(cases[0])), default=1.0) < LOCKED
    return "friction locks" in message and (locked or least_share(cases[0]) < LOCKED)


@pytest.mark.parametrize("first", [0, 50, *(pytest.param(x, marks=pytest.mark.long) for x in (100, 150, 200))])
def test_a_run_ends_only_where_all_modes_tried_have_no_solution_or_several_or_friction_locks(ends, first):
    turns = 0
    for seed in range(first, first + 50):
        pins = RoughPins(seed)
        run = rt.loads(pins.text()).simulate(END, rtol=10.0 ** -(6 + seed % 5), t_eval=[0.0, END])
        turns += sum(event.kind in ("stick", "slip") for event in run.events)
        assert run.success or confirmed(run.message, problems(pins, ends[-1])), f"{seed}: {run.message}"
    assert turns > 500


HARD = (0.3, 0.8, 1.5, 2.5)
LATE = [(seed, 3, FRICTIONS) for seed in (276, 470, 598, 916, 1466, 1589, 1839, 1874)]


@pytest.mark.parametrize(("seed", "most", "frictions"), [*LATE, (2087, 4, HARD)])
def test_a_run_that_ends_has_no_way_on(ends, seed, most, frictions):
    """Impacts without rebound that have two solutions; forces that grow without bound, also beside redundant ones."""
    pins = RoughPins(seed, most, frictions)
    run = rt.loads(pins.text()).simulate(0.1, rtol=10.0 ** -(6 + seed % 5), t_eval=[0.0, 0.1])
    assert run.success or confirmed(run.message, problems(pins, ends[-1])), run.message


@pytest.mark.parametrize(("seed", "most"), [(275, 3), (537, 3), (691, 3), (103, 5)])
def test_bodies_at_rest_on_several_rough_pins_begin_to_slide(seed, most):
    """Two contacts reach the limits of friction together, or one of many sets of forces that hold a body ends."""
    run = rt.loads(RoughPins(seed, most).text()).simulate(0.08, rtol=10.0 ** -(6 + seed % 5), t_eval=[0.0, 0.08])
    assert run.success, run.message
    assert run.trust.energy_balance < 1e-5


@pytest.mark.parametrize("seed", [104, 166, 171, 334])
def test_pins_that_rub_hard_expand_by_poissons_law(seed):
    # modes of expansion that relaxation does not reach
    run = rt.loads(RoughPins(seed).text()).simulate(0.1, rtol=10.0 ** -(6 + seed % 5), t_eval=[0.0, 0.1])
    assert run.success, run.message


@pytest.mark.parametrize("seed", [64, 213, 263])
def test_a_jam_in_which_a_run_starts_is_passed_like_one_on_its_way(ends, seed):
    pins, rtol = RoughPins(seed), 10.0 ** -(6 + seed % 5)
    assert "has no solution" in rt.loads(pins.text()).simulate(0.1, rtol=rtol, t_eval=[0.0, 0.1]).message
    jammed, _, y = ends[-1]
    size = pins.place[1:].size
    pins.place[1:], pins.rate[1:] = y[:size].reshape(-1, 3), y[size : 2 * size].reshape(-1, 3)
    text = pins.text().replace("restitution_law =", 'jam = "impact", restitution_law =')
    run = rt.loads(text.replace('*t)"', f'*(t + {jammed!r}))"')).simulate(1e-3, rtol=rtol, t_eval=[0.0, 1e-3])
    assert run.success, run.message
    assert any("without collision, the first at t = 0 s" in note for note in run.trust.notes)
