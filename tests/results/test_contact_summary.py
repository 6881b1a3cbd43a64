"""What the contacts of a run amount to, and how the trust lines say it."""

import numpy as np
import pytest

from circling import T_END, circling
from rattle.results.contact_summary import joint_table, pressing_spans
from rattle.results.event import Event
from rattle.results.result import Result
from rattle.results.trust import Trust

pytestmark = pytest.mark.nojit


def with_events(events):
    """The pin that runs round, with contacts instead of a link."""
    r = circling(401)
    form = r.geometry["joints"]["O"] | {"contact": "exact"}
    return Result(
        t=r.t, data=np.column_stack([r[name] for name in r.stored]), names=r.stored,
        units={name: r.unit(name) for name in r.stored}, geometry=r.geometry | {"joints": {"O": form}},
        trust=Trust(0.0, t_end=T_END, contacts=len(events), fewest_steps=15.0), stats={}, provenance={}, events=events,
    )  # fmt: skip


def test_share_losses_and_peak_come_from_the_located_contacts():
    events = [
        Event(0.02, "O", "contact", 0.5, 0.01, 700.0, 1.0, 0.25),
        Event(0.10, "O", "contact", 0.2, 0.03, 500.0, 1.0, 0.50),
        Event(0.12, "O", "contact", 0.2, 0.02, 100.0, 1.0, 0.05),  # overlaps: another corner of a guide
        Event(0.15, "other", "contact", 0.2, 0.02, 9e9, 1.0, 9.0),
    ]
    one = with_events(events).contacts["O"]
    assert one.share == pytest.approx((0.01 + 0.04) / T_END)
    assert (one.contacts, one.impacts) == (3, 0)
    assert one.peak == 700.0  # between outputs: the curve reaches 300 N only
    assert one.energy_lost == pytest.approx(0.8)
    assert one.power_lost == pytest.approx(0.8 / T_END)
    assert one.longest_flight == pytest.approx(0.07)
    assert pressing_spans(events[:3]) == [(0.02, 0.03), (0.10, pytest.approx(0.14))]


def test_share_without_contact_events_is_that_of_the_curve():
    one = with_events([Event(0.01, "O", "impact", 0.5, impulse=0.25, energy_lost=0.1)]).contacts["O"]
    assert one.share == pytest.approx(2 / 3, abs=0.01)  # 100 + 200 cos a > 0
    assert (one.contacts, one.impacts, one.energy_lost) == (0, 1, 0.1)


def test_rms_is_that_of_the_known_curve():
    assert circling(4001).contacts["O"].rms == pytest.approx(np.sqrt(100.0**2 + 200.0**2 / 2), rel=1e-6)


def test_table_has_no_columns_of_contacts_where_nothing_has_play():
    r = circling()
    ideal = r.geometry["joints"]["O"] | {"contact": "ideal"}
    plain = Result(
        t=r.t, data=np.column_stack([r[name] for name in r.stored]), names=r.stored,
        units={name: r.unit(name) for name in r.stored}, geometry=r.geometry | {"joints": {"O": ideal}},
        trust=Trust(0.0), stats={}, provenance={},
    )  # fmt: skip
    assert plain.contacts == {}
    assert joint_table(plain).splitlines()[0].split() == ["joint", "peak", "force", "at", "t", "RMS", "force"]


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"contacts": 52, "fewest_steps": 15.0}, "52 contacts, the shortest contact took 15 steps"),
        ({"contacts": 1, "fewest_steps": 3.0}, "1 contact, the shortest contact took 3 steps: too few for its peak"),
        ({"contacts": 0, "impacts": 7}, "7 impacts"),
        ({"contacts": 0}, "no contact in the whole run"),
    ],
)
def test_trust_counts_contacts_in_its_second_line(given, said):
    lines = str(Trust(1e-15, **given)).splitlines()
    assert len(lines) == 2
    assert lines[1].startswith(said)
    assert "massless" not in lines[1]
    assert Trust.from_dict(Trust(1e-15, **given).to_dict()) is not None


def test_trust_says_both_where_links_and_contacts_are_mixed():
    trust = Trust(1e-15, contacts=2, fewest_steps=9.0, pulled={"A": 0.0}, first_pull={"A": None})
    assert "A would never have to pull" in str(trust)
    assert "2 contacts" in str(trust)
    assert len(str(trust).splitlines()) == 2
