"""What a joint bears in a run, and how fast it wears.

    p = F/(2 R L)      v = R |w|      depth lost per time = k p v, of its mean over time
    tau = F/(pi r^2), one plane of the pin of radius r cut

Source: Archard, J. Appl. Phys. 24 (1953) 981-988; ISO 281 for rolling bearings.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from rattle import registry
from rattle.analyses.driver_period import driver_period
from rattle.catalogue.bearings import MILLION, BearingPlay
from rattle.description.model import Joint
from rattle.description.read_wear import kind_wears
from rattle.errors import InputError
from rattle.language.recorded import bare
from rattle.questions.durability.bands import MEDIAN
from rattle.questions.durability.cases import Case
from rattle.results.contact_summary import readable

NO_SIZE = "no pressure: length, and the radius of its bush or pin, are needed"
NO_LIMIT = "no wear life: wear.limit, the depth that is allowed, is missing"
FOREVER = 1e15  # cycles, more than a machine makes: the map of wear ends at its limit, not there


class Bearing(NamedTuple):
    """What one joint bears in one run; nan where it is not known."""

    load: float  # largest force [N]
    pressure: float  # at that force [Pa]
    shear: float  # of the pin then, where one plane of it is cut [Pa]
    pv: float  # time mean of p |v| [Pa m/s]
    film: float  # least film thickness over roughness
    wear: float  # depth lost per time over the depth that is allowed [1/s]
    tired: float  # turns of a rolling bearing per time over those that half of them survive [1/s]
    notes: tuple[str, ...]


def bearings(case: Case) -> dict[str, Bearing]:
    """What every joint bears in the run of a case."""
    mapped, notes = _by_map(case)
    return {name: _bearing(case, name, mapped, notes) for name in case.mechanism.model.joints}


def _bearing(case: Case, name: str, mapped: Mapping[str, float], mapping: str) -> Bearing:
    joint, notes = case.mechanism.model.joints[name], list[str]()
    radius, length = bare(joint.radius), bare(joint.length)
    rolls = isinstance(joint.named, BearingPlay)
    if _has_pin(joint) and not rolls and math.isnan(radius * length):
        notes.append(NO_SIZE)
    load = _load(case, name, notes)
    pressed = _mean_slide(case, name) / (2.0 * length)
    wear = _wear(joint, pressed, mapped.get(name, math.nan), mapping, notes)
    tired = _tired(case, name, notes) if rolls else math.nan
    shear = load / (math.pi * (radius - bare(joint.clearance)) ** 2)
    film = _film(case, name)
    return Bearing(load, load / (2.0 * radius * length), shear, pressed, film, wear, tired, tuple(notes))


def _has_pin(joint: Joint) -> bool:
    return kind_wears(registry.kinds("joint")[joint.kind])


def _load(case: Case, name: str, notes: list[str]) -> float:
    """Largest force of a joint [N]; nan where it has none that can be read."""
    if f"{name}.force" not in case.run:
        return math.nan
    if not readable(case.run, f"{name}.force"):
        notes.append("no load: forces of rigid contacts tower where no real one would")
        return math.nan
    return float(case.run.peak(f"{name}.force")[0])


def _mean_slide(case: Case, name: str) -> float:
    """Mean over time of force times rate [N/s]; nan of a joint without them."""
    run = case.run
    if f"{name}.rate" not in run or f"{name}.force" not in run:
        return math.nan
    return float(case.mean(np.abs(run[f"{name}.force"] * run[f"{name}.rate"])))


def _film(case: Case, name: str) -> float:
    """Least thickness of the oil over the roughness of both surfaces; nan without oil."""
    summary, contact = case.run.films.get(name), case.mechanism.model.joints[name].contact
    if summary is None or contact is None or contact.film is None:
        return math.nan
    return float(summary.least_film / bare(contact.film.roughness))


def _wear(joint: Joint, pressed: float, by_map: float, mapping: str, notes: list[str]) -> float:
    """Depth lost per time over the depth that is allowed [1/s]; nan where it is not known.

    pressed: mean of p |v| [Pa m/s].  by_map: the same by the map of wear; mapping: why there is none, in words.
    """
    if joint.wear is not None:
        notes.append(mapping if math.isnan(by_map) else "wear life by the map of its wear, not by k p v")
        return by_map
    if joint.wears is not None:
        notes += [NO_LIMIT] if math.isnan(bare(joint.wears.limit)) else []
        return float(bare(joint.wears.rate) * pressed / bare(joint.wears.limit))
    if _has_pin(joint) and not isinstance(joint.named, BearingPlay):
        notes.append("no wear life: it does not say how it wears, wear = { bush, limit }")
    return math.nan


def _tired(case: Case, name: str, notes: list[str]) -> float:
    """Share of its life that a rolling bearing takes per time [1/s], by its median; nan where it is not known.

    1/L10 = mean of |w| F^p over 2 pi 1e6 C^p: ISO 281 for load and speed that change.
    """
    rolling, run = case.mechanism.model.joints[name].named, case.run
    assert isinstance(rolling, BearingPlay), "asked of rolling bearings"
    if math.isnan(rolling.capacity):
        notes.append("no fatigue life: its capacity is missing, bearing = { number, capacity }")
        return math.nan
    if f"{name}.rate" not in run or not readable(run, f"{name}.force"):
        return math.nan
    turns = np.abs(run[f"{name}.rate"]) / (2.0 * math.pi)
    share = run[f"{name}.force"] ** rolling.exponent * turns
    return float(case.mean(share) / (MILLION * rolling.capacity**rolling.exponent) / MEDIAN)


def _by_map(case: Case) -> tuple[dict[str, float], str]:
    """Depth lost per time over the depth that is allowed [1/s] of joints with play that wear, by the map of `wear`.

    And in words why there is none of a joint that is missing.
    """
    m = case.mechanism
    worn = {name: joint for name, joint in m.model.joints.items() if joint.wear is not None}
    limits = {name: bare(joint.wears.limit) for name, joint in worn.items() if joint.wears is not None}
    limits = {name: limit for name, limit in limits.items() if not math.isnan(limit)}
    if not limits:
        return {}, NO_LIMIT
    written = [joint.wear.cycle for joint in worn.values() if joint.wear is not None]
    cycle = next((period for period in written if not math.isnan(period)), None) or driver_period(m.system)
    if cycle is None:
        return {}, "no wear life: no driver turns at constant rate; give wear.cycle"
    try:
        study = m.wear(cycles=FOREVER, cycle=cycle, stop={"depth": min(limits.values())})
    except InputError as error:
        return {}, f"no wear life: {error}"
    if study.interrupted:
        raise KeyboardInterrupt
    rates = {}
    for name, limit in limits.items():
        depth = sum(side.deepest for side in study.profile(name))
        rates[name] = depth / limit / (study.cycles * cycle)
    return rates, NO_LIMIT
