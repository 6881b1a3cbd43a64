"""What joints and links bear and how long they last, over all duty cases.

1/life = sum_i s_i r_i      s_i share of the time, r_i share of the life that case i takes per time
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from rattle.analyses.driver_period import part_of_turn
from rattle.mechanism import Mechanism
from rattle.questions.durability.bands import FATIGUE, MEDIAN, ROLLING, WEAR
from rattle.questions.durability.cases import cases_of
from rattle.questions.durability.joints import Bearing, bearings
from rattle.questions.durability.links import Link, links

HOUR = 3600.0  # [s]
WORN, TIRED = "wear", "fatigue"
NAN = math.nan


class Row(NamedTuple):
    """A joint or a link; what is not known, and what it has not, is nan."""

    name: str
    load: float  # largest of all cases [N]
    pressure: float = NAN  # then [Pa]
    shear: float = NAN  # of its pin then, one plane of it cut [Pa]
    pv: float = NAN  # of the worst case [Pa m/s]
    film: float = NAN  # least of all cases, thickness over roughness
    wear_life: float = NAN  # [h]
    fatigue_life: float = NAN  # [h]
    safety: float = NAN  # least of all cases
    notes: tuple[str, ...] = ()  # why something is nan, and how a life was found
    wear_band: tuple[float, float] = WEAR  # factors that 10 and 90 % reach
    assumed: bool = True  # the model does not say this band
    fatigue_band: tuple[float, float] = FATIGUE

    @property
    def figures(self) -> tuple[float, ...]:
        """Load, pressure, shear, PV, film, wear life, fatigue life and safety."""
        return (
            self.load, self.pressure, self.shear, self.pv, self.film, self.wear_life, self.fatigue_life, self.safety,
        )  # fmt: skip

    @property
    def lives(self) -> tuple[tuple[str, float, tuple[float, float]], ...]:
        """What it fails by, after how many hours, and the factors of its band; without what is nan."""
        every = ((WORN, self.wear_life, self.wear_band), (TIRED, self.fatigue_life, self.fatigue_band))
        return tuple(life for life in every if not math.isnan(life[1]))


class Rows(NamedTuple):
    """All joints, then all bars with section and material; and what is to be said of the runs."""

    rows: tuple[Row, ...]
    notes: tuple[str, ...]


def rows_of(m: Mechanism) -> Rows:
    """What everything bears, and how long it lasts.  Raises SolverError for a run that fails."""
    shares, of_joints, of_links, notes = [], [], [], []
    for case in cases_of(m):
        shares.append(case.share)
        notes.append(part_of_turn(case.mechanism.system, case.duration))
        of_joints.append(bearings(case))
        of_links.append(links(case))
    joints = [_joint(m, name, shares, [case[name] for case in of_joints]) for name in m.model.joints]
    bars = [_link(name, shares, [case[name] for case in of_links]) for name in of_links[0]]
    return Rows((*joints, *bars), tuple(dict.fromkeys(filter(None, notes))))


def _joint(m: Mechanism, name: str, shares: Sequence[float], cases: Sequence[Bearing]) -> Row:
    limit = m.model.joints[name].wears
    band = limit.band if limit is not None else None
    fatigue = _life(shares, [case.tired for case in cases])
    basic = () if math.isnan(fatigue) else (f"rolling bearing: 90 % reach L10 = {fatigue / MEDIAN:.4g} h, ISO 281",)
    return Row(
        name, _most(case.load for case in cases), _most(case.pressure for case in cases),
        _most(case.shear for case in cases), _most(case.pv for case in cases), -_most(-case.film for case in cases),
        _life(shares, [case.wear for case in cases]), fatigue, notes=(*_together(cases), *basic),
        wear_band=band or WEAR, assumed=band is None, fatigue_band=ROLLING,
    )  # fmt: skip


def _link(name: str, shares: Sequence[float], cases: Sequence[Link]) -> Row:
    return Row(
        name, _most(case.load for case in cases), fatigue_life=_life(shares, [case.fatigue for case in cases]),
        safety=-_most(-case.safety for case in cases), notes=_together(cases),
    )  # fmt: skip


def _most(values: Iterable[float]) -> float:
    """The largest of some numbers; nan if one of them is."""
    return float(np.max(list(values)))


def _life(shares: Sequence[float], rates: Sequence[float]) -> float:
    """Hours until the shares of the life that cases take [1/s] are 1; nan if one of them is not known."""
    rate = sum(share * rate for share, rate in zip(shares, rates, strict=True))
    return NAN if math.isnan(rate) else math.inf if rate == 0.0 else 1.0 / rate / HOUR


def _together(cases: Iterable[Bearing | Link]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(note for case in cases for note in case.notes))
