"""What the oil films of a run leave out, where that matters: notes for `Trust`."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from rattle import registry
from rattle.description.model import Joint, OilFilm
from rattle.equations.system import System

INERTIA = 1.0  # rho w c^2/mu, w the mean of both rates, from which the inertia of the oil is not small
VORTICES = 41.1  # rho w R c/mu over sqrt(R/c) from which vortices form (Taylor 1923, Phil. Trans. R. Soc. A 223, 289)
HARD = 100e6  # pressure [Pa] from which a steel bush gives way by a part of the film
SENTENCES = {  # of notes, also in pages
    "thin": "{joint}: thinner than its boundary film of {boundary:.3g} um at {percent:.2g} % of the outputs, where the"
    " dry contact carries too",
    "hard": "{joint}: up to {pressure:.3g} MPa in the film; from about 100 MPa on bushes give way, which is left out",
    "vortices": "{joint}: at {rate:.3g} rad/s the film is not laminar (Re = {reynolds:.3g}), which is left out",
    "inertia": "{joint}: at {rate:.3g} rad/s the inertia of the oil (Re c/R = {reduced:.3g}) counts, but is left out",
}


def oil_notes(system: System, data: np.ndarray, names: Sequence[str]) -> tuple[str, ...]:
    """Notes on the films of all joints; data (n, k): the curves of the run [SI] with their names."""
    notes: list[str] = []
    for name, joint in system.model.joints.items():
        film = joint.contact.film if joint.contact is not None else None
        if film is None or not joint.is_loose or f"{name}.film_thickness" not in names:
            continue
        notes += notes_of_film(name, film)
        if len(data):
            curve = {key: data[:, names.index(f"{name}.{key}")] for key in ("film_thickness", "film_pressure")}
            notes += _in_the_run(name, film, curve["film_thickness"], curve["film_pressure"])
            notes += _at_speed(name, film, joint, *_speeds(joint, data, names))
    return tuple(notes)


def notes_of_film(name: str, film: OilFilm) -> list[str]:
    """Notes on the law of a film, and on the dry contact that is assumed; name: of its joint."""
    law = registry.kinds("film")[film.law.kind].leaf
    notes = [f"{name}, {film.law.kind}: {note}" for note in law.notes(film.law.values)]
    if film.assumed:
        notes.append(f"{name}: no dry contact given, so beyond the boundary film it is {film.assumed}")
    return notes


def _in_the_run(name: str, film: OilFilm, thickness: np.ndarray, pressure: np.ndarray) -> list[str]:
    notes = []
    thin = float(np.mean(thickness < film.boundary))
    if thin > 0.0:
        notes.append(SENTENCES["thin"].format(joint=name, boundary=1e6 * film.boundary, percent=100 * thin))
    if (peak := float(pressure.max())) > HARD:
        notes.append(SENTENCES["hard"].format(joint=name, pressure=1e-6 * peak))
    return notes


def _at_speed(name: str, film: OilFilm, joint: Joint, mean: float, relative: float) -> list[str]:
    """Notes for the largest mean and difference [rad/s] of the rates of bush and pin."""
    c, radius = joint.clearance, float(film.law.number("bush_radius"))
    over = film.density * c / float(film.law.number("viscosity"))
    reynolds, reduced = over * relative * radius, over * mean * c
    if reynolds > VORTICES * math.sqrt(radius / c):
        return [SENTENCES["vortices"].format(joint=name, rate=relative, reynolds=reynolds)]
    if reduced > INERTIA:
        return [SENTENCES["inertia"].format(joint=name, rate=mean, reduced=reduced)]
    return []


def _speeds(joint: Joint, data: np.ndarray, names: Sequence[str]) -> tuple[float, float]:
    """Largest magnitude of mean and difference [rad/s] of the rates of both bodies."""
    ends = (joint.a.body, joint.b.body)
    a, b = (0.0 * data[:, 0] if end == "ground" else data[:, names.index(f"{end}.omega")] for end in ends)
    return 0.5 * float(np.abs(a + b).max()), float(np.abs(b - a).max())
