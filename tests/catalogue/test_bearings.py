"""Play of rolling bearings against makers' tables, and what is refused."""

import math

import pytest

import rattle as rt
from rattle.catalogue.bearings import BALL, GROUPS, KINDS, ROLLER, bearing
from rattle.catalogue.tables import rows

pytestmark = [pytest.mark.nojit, pytest.mark.plain]


@pytest.mark.parametrize(
    ("written", "bore", "radial", "tol"),
    [
        ("6208 C3", 40, 12.0, 4.5), ("6208", 40, 6.5, 3.5), ("6203 CN", 17, 5.25, 3.75), ("608", 8, 3.75, 2.75),
        ("6004-2RS C3", 20, 10.25, 3.75), ("6208-2Z/C3", 40, 12.0, 4.5), ("6208ZZ", 40, 6.5, 3.5),
        ("6208-2RS1/C3", 40, 12.0, 4.5), ("6208c3", 40, 12.0, 4.5), ("6220", 100, 12.0, 6.0), ("624", 4, 3.75, 2.75),
        ("6200", 10, 3.75, 2.75), ("6201", 12, 5.25, 3.75), ("6302 C2", 15, 2.25, 2.25), ("61804", 20, 6.25, 3.75),
        ("16005", 25, 6.25, 3.75), ("6405 C4", 25, 16.0, 4.5), ("61912 C5", 60, 36.25, 8.75),
        ({"bore": "40 mm", "group": "C3"}, 40, 12.0, 4.5), ({"bore": "40.01 mm", "group": "C4"}, 40.01, 20.25, 5.25),
        ({"bore": 0.04}, 40, 6.5, 3.5), ({"bore": "40 mm", "kind": "ball"}, 40, 6.5, 3.5),
        ({"bore": "40 mm", "kind": "roller"}, 40, 18.75, 6.25),
        ({"bore": "500 mm", "group": "C5", "kind": "roller"}, 500, 340.0, 27.5),
    ],
)  # fmt: skip
def test_the_play_is_half_of_the_radial_movement(written, bore, radial, tol):
    play = bearing(written)
    assert play.bore * 1e3 == pytest.approx(bore)
    assert (play.radial * 1e6, play.tol * 1e6) == pytest.approx((radial, tol))
    assert (play.least + play.largest) / 4 == pytest.approx(play.radial)
    assert play.title
    assert play.source


@pytest.mark.parametrize("kind", [BALL, ROLLER])
def test_ranges_of_bores_join_and_groups_follow_each_other(kind):
    table = rows(KINDS[kind])
    assert [row["to_mm"] for row in table[:-1]] == [row["over_mm"] for row in table[1:]]
    for row in table:
        upper = [bearing({"bore": f"{row['to_mm']} mm", "group": group, "kind": kind}) for group in GROUPS]
        assert [play.least for play in upper] == sorted(play.least for play in upper)
        assert [play.largest for play in upper] == sorted(play.largest for play in upper)
        assert all(0 <= play.least < play.largest for play in upper)


@pytest.mark.parametrize(
    ("written", "words"),
    [
        ("6208 C9", "unknown group of play 'C9'"),
        ("6208 C3 C4", "C4 is a second group"),
        ("6208 P63", "P63 is nothing that is known"),
        ("N208 C3", "no number of a deep-groove ball bearing"),
        ("7208", "no number"),
        ("22208", "no number"),
        ("600", "no number"),
        ("62", "no number"),
        ("C3", "no number"),
        ("", "empty"),
        ("6221", "no checked table above 100 mm"),
        ("602", "starts above 2.5 mm"),
        ({"bore": "40 mm", "group": "C7"}, "unknown group"),
        ({"bore": "40 mm", "group": ["C3"]}, "unknown group"),
        ({"bore": "1 mm", "group": "C3"}, "starts above 2.5 mm"),
        ({"bore": "100.1 mm"}, "no checked table above 100 mm"),
        ({"bore": "501 mm", "kind": "roller"}, "no checked table above 500 mm"),
        ({"bore": "-1 mm"}, "must be positive"),
        ({"bore": "40 kg"}, "is a mass"),
        ({"bore": True}, "is a length"),
        ({"bore": None}, "is a length"),
        ({"bor": "40 mm"}, "did you mean 'bore'"),
        ({"group": "C3"}, "bore is missing"),
        ({"bore": "40 mm", "kind": "rollers"}, "expected 'ball' or 'roller'"),
        (6208, "expected the number"),
    ],
)
def test_what_is_no_bearing_with_a_table_is_refused_with_the_reason(written, words):
    with pytest.raises(rt.InputError, match=words):
        bearing(written)


def test_turns_that_nine_of_ten_survive_are_those_of_iso_281():
    """C/P = 3.07 gives 28.9 million turns: 482 h at 1000 rpm."""
    ball = bearing({"number": "6208 C3", "capacity": "30.7 kN"})
    assert (ball.radial, ball.capacity) == (bearing("6208 C3").radial, 30.7e3)
    assert ball.turns(10e3) == pytest.approx(1e6 * 3.07**3)
    assert ball.turns(10e3) / 1000 / 60 == pytest.approx(482.2, abs=0.1)
    roller = bearing({"bore": "40 mm", "kind": "roller", "capacity": 50e3})
    assert roller.turns(25e3) == pytest.approx(1e6 * 2 ** (10 / 3))
    assert bearing("6208").turns(1.0) != bearing("6208").turns(1.0)  # nan: no capacity is known
    assert ball.turns(0.0) == math.inf


@pytest.mark.parametrize(
    ("written", "words"),
    [
        ({"number": "6208", "bore": "40 mm"}, "number says the bore"),
        ({"number": "6208", "capacity": "30 kg"}, "30 kg"),
        ({"number": "6208", "capacity": -1}, "must be positive"),
        ({"capacity": "30 kN"}, "the bore is missing"),
    ],
)
def test_capacities_that_are_none_are_refused(written, words):
    with pytest.raises(rt.InputError, match=words):
        bearing(written)
