"""Summary of the oil films of a run, joint by joint: least film, pressure, friction, leakage, heat."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from rattle.results.chosen_units import chosen
from rattle.results.contact_summary import Curves, extreme
from rattle.results.display import quantity

HEAD = (
    "oil in joint",
    "least film",
    "at t",
    "at angle",
    "peak pressure",
    "friction",
    "peak",
    "mixed",
    "leakage",
    "heats by",
)
ROUNDING = 1e-9  # [rad] by which an angle may be short of a whole turn
WIDTHS = (12, 12, 11, 14, 12, 12, 7, 15, 10)  # of the columns after the name


class FilmSummary(NamedTuple):
    """The oil film of one joint over a whole run.

    The least film is found within the steps; pressure, power and means over time are those of the outputs.
    """

    least_film: float  # [m]
    at_t: float  # when it is that thin [s]
    at_angle: float  # of the crank then, 0 to 2 pi [rad]: of the first driven joint; nan if there is none
    peak_pressure: float  # [Pa]
    mean_power: float  # lost in the film and to dry friction [W]
    peak_power: float  # [W]
    mixed: float  # share of the time in which the dry contact carries too, 0 to 1
    leakage: float  # mean flow out of both ends [m^3/s]
    heating: float  # mean power over the heat capacity of the leakage [K]: if the oil takes all of it


def films(result: Curves) -> dict[str, FilmSummary]:
    """Summary of every joint with oil; units as in `FilmSummary`."""
    joints = result.geometry.get("joints", {}).items() if len(result.t) else ()
    return {name: _summary(result, name, form) for name, form in joints if f"{name}.film_thickness" in result}


def _summary(result: Curves, name: str, form: dict[str, Any]) -> FilmSummary:
    t = result.t
    offset = result.peaks.get(f"{name}.offset")
    if offset is not None:
        least, when = float(form["clearance"]) - offset.value, offset.t
    else:
        high, when = extreme(t, result[f"{name}.eccentricity"])
        least = float(form["clearance"]) * (1.0 - high)
    power, leakage = _mean(t, result[f"{name}.friction_power"]), _mean(t, result[f"{name}.leakage"])
    oil: dict[str, float] = form["oil"]
    capacity = oil["density"] * oil["specific_heat"] * leakage
    return FilmSummary(
        least_film=least,
        at_t=when,
        at_angle=_crank(result, when),
        peak_pressure=extreme(t, result[f"{name}.film_pressure"])[0],
        mean_power=power,
        peak_power=extreme(t, result[f"{name}.friction_power"])[0],
        mixed=_mean(t, (result[f"{name}.regime"] > 0.0).astype(float)),
        leakage=leakage,
        heating=power / capacity if capacity > 0.0 else math.nan,
    )


def _mean(t: np.ndarray, values: np.ndarray) -> float:
    span = float(t[-1] - t[0])
    return float(np.trapezoid(values, t)) / span if span > 0.0 else float(values[-1])


def _crank(result: Curves, t: float) -> float:
    """Angle [rad] of the first driven joint at t [s], within one turn; nan if there is none or no output up to t."""
    for name in result.geometry["driven"]:
        if f"{name}.angle" in result:
            angle = float(np.interp(t, result.t, result[f"{name}.angle"], left=math.nan)) % (2.0 * math.pi)
            return 0.0 if angle >= 2.0 * math.pi - ROUNDING else angle
    return math.nan


def film_rows(result: Curves) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Heading and one row per joint with oil, with units."""
    rows: list[tuple[str, ...]] = []
    for name, film in films(result).items():
        angle = "-" if math.isnan(film.at_angle) else _angle(film.at_angle)
        rows.append(
            (
                name, quantity(film.least_film, "m", usual="um"), quantity(film.at_t, "s"), angle,
                quantity(film.peak_pressure, "Pa", usual="MPa"),
                quantity(film.mean_power, "W"), quantity(film.peak_power, "W"), f"{100 * film.mixed:.0f} %",
                quantity(film.leakage, "m^3/s", usual="cm^3/s"), f"{film.heating:.3g} K",
            )
        )  # fmt: skip
    return HEAD, rows


def _angle(radians: float) -> str:
    return f"{math.degrees(radians):.1f} deg" if chosen("rad") is None else quantity(radians, "rad")


def film_table(result: Curves) -> str:
    """The rows of `film_rows` as text in columns; "" if no joint has oil."""
    head, rows = film_rows(result)
    if not rows:
        return ""
    wide = max([len(HEAD[0]), *(len(row[0]) for row in rows)]) + 2
    widths = [
        max(width, *(len(row[k + 1]) + 2 for row in rows)) for k, width in enumerate(WIDTHS)
    ]  # long numbers, in units that a user asked for
    lines = [
        f"{name:{wide}s}" + "".join(f"{cell:>{width}s}" for cell, width in zip(cells, widths, strict=True))
        for name, *cells in (head, *rows)
    ]
    return "\n".join([*lines, "(least film within the steps; pressure, friction, leakage at the outputs)"])
