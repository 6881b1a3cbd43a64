"""Rainflow cycles against slow, obvious ways; Goodman, Haibach and Miner by hand."""

import itertools
import math

import numpy as np
import pytest

import rattle as rt
from bars import IRON, beam
from rattle.errors import InputError
from rattle.questions.strength.fatigue import Endurance, damage

EXAMPLE = [-2, 1, -3, 5, -1, 3, -4, 4, -2]  # of ASTM E1049-85
IRONLIKE = Endurance(500e6, 80e6, 1e6, 5.0)


def summed(cycles):
    """Equal cycles put together."""
    total = {}
    for size, mean, count in cycles:
        key = (round(float(size), 9), round(float(mean), 9))
        total[key] = total.get(key, 0.0) + count
    return sorted((*key, count) for key, count in total.items())


# ---------------------------------------------------------------- counting
def test_the_example_of_the_standard_is_counted_as_it_stands_there():
    assert summed(rt.rainflow(EXAMPLE)) == [
        (3, -0.5, 0.5), (4, -1, 0.5), (4, 1, 1), (6, 1, 0.5), (8, 0, 0.5), (8, 1, 0.5), (9, 0.5, 0.5),
    ]  # fmt: skip


def test_every_cycle_of_a_history_that_repeats_closes():
    cycles = rt.rainflow(EXAMPLE, repeat=True)
    assert summed(cycles) == [(3, -0.5, 1), (4, 1, 1), (7, 0.5, 1), (9, 0.5, 1)]
    assert all(cycle.count == 1.0 for cycle in cycles)


def test_points_between_turns_and_repeated_values_change_nothing():
    fine = np.repeat(np.interp(np.linspace(0, 8, 161), range(9), EXAMPLE), 2)
    assert summed(rt.rainflow(fine)) == summed(rt.rainflow(EXAMPLE))


def test_where_a_repeated_history_begins_does_not_matter():
    history = np.random.default_rng(0).normal(size=40)
    wanted = summed(rt.rainflow(history, repeat=True))
    assert all(summed(rt.rainflow(np.roll(history, n), repeat=True)) == wanted for n in range(40))


@pytest.mark.parametrize("history", [[], [3.0], [3.0, 3.0, 3.0]])
def test_what_does_not_change_has_no_cycle(history):
    assert rt.rainflow(history) == rt.rainflow(history, repeat=True) == []


@pytest.mark.parametrize("history", [[1.0, math.nan], [[1.0, 2.0]]])
def test_what_is_no_history_is_refused(history):
    with pytest.raises(rt.InputError, match="history"):
        rt.rainflow(history)


def closed_slowly(history):
    """Take the smallest range between neighbours of a ring out of it, until two turns are left."""
    ring, cycles = _turns_of_ring(list(history)), []
    while len(ring) > 2:
        n = min(range(len(ring)), key=lambda k: abs(ring[k] - ring[(k + 1) % len(ring)]))
        first, second = ring[n], ring[(n + 1) % len(ring)]
        cycles.append((abs(first - second), (first + second) / 2, 1.0))
        ring = [value for k, value in enumerate(ring) if k not in (n, (n + 1) % len(ring))]
    return [*cycles, (abs(ring[0] - ring[1]), (ring[0] + ring[1]) / 2, 1.0)]


def _turns_of_ring(ring):
    return [value for k, value in enumerate(ring) if (value - ring[k - 1]) * (ring[(k + 1) % len(ring)] - value) < 0.0]


def open_slowly(history):
    """Take inner ranges out that both neighbours cover, until none is left; halves of what stays."""
    inner = (b for (a, b), (_, c) in itertools.pairwise(itertools.pairwise(history)) if (b - a) * (c - b) < 0.0)
    turns = [history[0], *inner, history[-1]]
    cycles, k = [], 0
    while k + 3 < len(turns):
        before, size, after = (abs(turns[k + n + 1] - turns[k + n]) for n in range(3))
        if size <= min(before, after):
            cycles.append((size, (turns[k + 1] + turns[k + 2]) / 2, 1.0))
            del turns[k + 1 : k + 3]
            k = 0
        else:
            k += 1
    return cycles + [(abs(b - a), (a + b) / 2, 0.5) for a, b in itertools.pairwise(turns)]


@pytest.mark.parametrize("seed", range(20))
def test_random_histories_are_counted_as_by_slow_ways(seed):
    rng = np.random.default_rng(seed)
    history = rng.normal(size=int(rng.integers(5, 80)))
    if seed % 2:
        history = np.cumsum(history)
    for counted, slowly in (
        (rt.rainflow(history), open_slowly(history.tolist())),
        (rt.rainflow(history, repeat=True), closed_slowly(history)),
    ):
        assert np.array(summed(counted)) == pytest.approx(np.array(summed(slowly)), abs=1e-8)  # rounded to 1e-9


# ---------------------------------------------------------------- how much hurts
def test_one_level_breaks_after_the_cycles_of_its_line():
    history = 1e6 * np.array([-20.0, 220.0, -20.0])  # 120 MPa about 100 MPa: 150 MPa at R = -1
    assert 1.0 / damage(history, IRONLIKE) == pytest.approx(1e6 * (80 / 150) ** 5)


def test_what_the_material_endures_hurts_only_beside_what_it_does_not():
    small, large = np.array([70e6, -70e6]), np.array([120e6, -120e6])
    assert damage(small, IRONLIKE) == 0.0
    alone, together = damage(large, IRONLIKE), damage(np.concatenate([large, small]), IRONLIKE)
    # 120 -120 70 -70 and on: the small turns lie within the large ones, one cycle of each
    assert together - alone == pytest.approx(1e-6 * (70 / 80) ** 9)  # Haibach: 2 k - 1


def test_a_mean_that_presses_gives_no_credit():
    about = [damage(1e6 * (np.array([110.0, -110.0]) + mean), IRONLIKE) for mean in (-50.0, 0.0, 50.0)]
    assert about[0] == about[1] < about[2]


@pytest.mark.parametrize("history", [[700e6, -700e6], [600e6, 500e6], [520e6, 100e6], [600e6, 600e6], [600e6]])
def test_a_cycle_that_reaches_the_ultimate_strength_breaks_at_once(history):
    assert damage(np.array(history), IRONLIKE) == math.inf


def test_ranges_of_rounding_are_no_cycles():
    history = np.tile([120e6, -120e6], 2)
    noisy = np.concatenate([history, 120e6 + 1e-4 * np.random.default_rng(1).normal(size=50)])
    assert damage(noisy, IRONLIKE) == pytest.approx(damage(history, IRONLIKE))


# ---------------------------------------------------------------- of a bar
def drawn(values, newton, iron=IRON, across=0.0, held="clamped"):
    count = len(values)
    force = f'["{newton}*history(t)", 0]' if not across else f'[{newton}, "{across}*history(t)"]'
    more = f"""loads.f = {{ type = "force", at = "bar.B", force = {force} }}
tables.history = {{ x = {list(range(count))}, y = {values}, kind = "linear" }}"""
    m = rt.loads(beam(more, held, body="mass = 1e-9", material=iron))
    return m.strength("bar", list(range(count)), analysis="inverse-dynamics")


@pytest.mark.parametrize(("endurance", "wanted"), [(80, 1277.658), (150, 29842.52)])
def test_a_bar_drawn_by_the_example_lives_as_long_as_miner_says(endurance, wanted):
    s = drawn(EXAMPLE, 6000, IRON.replace("80 MPa", f"{endurance} MPa"))
    assert s.life == pytest.approx(wanted, rel=1e-6)


def test_each_fibre_has_its_own_history():
    """A steady pull of 60 MPa and bending of 108 MPa at the root: the fibres are never at 168 and -168 MPa in one."""
    s = drawn([0, 1, -1, 0], 6000, across=60)
    assert s.life == pytest.approx(1e6 * (80 / (108 / (1 - 60 / 500))) ** 5, rel=1e-6)
    assert s.life == pytest.approx(117691.3, rel=1e-6)


def test_a_bar_lives_for_ever_below_its_endurance_and_not_at_all_above_its_strength():
    assert drawn([-20, 220, -20], 100, IRON.replace("80 MPa", "160 MPa")).life == math.inf
    s = drawn([0, 600, 0], 100)
    assert s.life == 0.0
    assert any("ultimate" in remark for remark in s.remarks)


@pytest.mark.parametrize("key", ["ultimate", "endurance", "exponent"])
def test_a_life_that_the_material_does_not_tell_is_not_a_number(key):
    iron = "\n".join(line for line in IRON.splitlines() if not line.startswith(f"{key} ="))
    s = drawn(EXAMPLE, 6000, iron)
    assert math.isnan(s.life)
    assert any("no life" in remark and key in remark for remark in s.remarks)


def test_steel_alone_has_neither_safety_nor_life():
    s = rt.loads(beam(gravity=10.0).replace('"iron"', '"steel"')).strength("bar", [0, 1], analysis="inverse-dynamics")
    assert math.isnan(s.safety)
    assert math.isnan(s.life)
    assert s.peak > 0.0


@pytest.mark.parametrize("series", ["abc", [1, "2 MPa"], {"a": 1}, iter([1, 2, 1]), np.array([1 + 2j, 2]), [1, np.nan]])
def test_what_is_no_history_is_refused_in_words(series):
    with pytest.raises(InputError, match="list of finite numbers"):
        rt.rainflow(series)
