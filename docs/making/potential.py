"""The figure of the theory of oil films: their dissipation potential, and how far the short film is from it."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

import rattle as rt
from making.tree import module_with

_pictures = module_with("CURVES", "new_figure", "tidy")
CURVES, new_figure, tidy = _pictures.CURVES, _pictures.new_figure, _pictures.tidy

BEARING = {"viscosity": 1.0, "radius": 1.0, "clearance": 1e-3}
PLACES = (0.0, 0.5, 0.8, 0.9)  # eccentricities whose level lines are drawn
LENGTHS = (0.25, 0.5, 1.0, 2.0)  # L/D
DOTS = 80  # per inch


def pages(folder: Path) -> dict[str, str]:
    """No page of its own: the picture goes into `folder`/pictures."""
    place = folder / "pictures"
    place.mkdir(exist_ok=True)
    figure = new_figure(11.0, 4.6)
    left, right = (tidy(figure.add_subplot(1, 2, k)) for k in (1, 2))
    _level_lines(left)
    _over_short(right)
    figure.savefig(place / "film-potential.png", dpi=DOTS)
    return {}


def resistance(film: rt.Film, e: float, angle: float) -> float:
    """g [-]: the force against a velocity at `angle` [rad] from the eccentricity e [of the clearance], over C |v|."""
    c, unit = film.clearance, film.viscosity * film.radius * film.length**3 / film.clearance**3
    m = (math.cos(angle), math.sin(angle))
    fx, fy, *_ = film.force(e * c, 0.0, *m)
    return -(fx * m[0] + fy * m[1]) / unit


def _level_lines(ax) -> None:
    """Velocities of the same potential at several eccentricities, for L/D = 1."""
    film = rt.Film(**BEARING, length=2.0)
    angles = np.linspace(-math.pi, math.pi, 361)
    for e, colour in zip(PLACES, CURVES, strict=False):
        size = np.array([resistance(film, e, angle) for angle in angles]) ** -0.5
        ax.plot(size * np.cos(angles), size * np.sin(angles), color=colour, label=f"$\\varepsilon$ = {e:g}")
    ax.set(aspect="equal", xlabel="v along e  [(2 Φ/C)$^{1/2}$]", ylabel="v across e  [(2 Φ/C)$^{1/2}$]")
    ax.set_title("Velocities of one potential, L/D = 1: convex, so any film resists", loc="left", fontsize=10)
    ax.legend(frameon=False, fontsize=9)


def _over_short(ax) -> None:
    """Resistance over that of the short film as the eccentricity grows, towards the bush and across."""
    e = np.linspace(0.0, 0.99, 100)
    for ratio, colour in zip(LENGTHS, CURVES, strict=False):
        finite, short = (rt.Film(**BEARING, length=2.0 * ratio, model=model) for model in ("finite", "short"))
        for angle, style in ((0.0, "-"), (0.5 * math.pi, "--")):
            shares = [resistance(finite, one, angle) / resistance(short, one, angle) for one in e]
            ax.plot(e, shares, style, color=colour, label=f"L/D = {ratio:g}" if style == "-" else None)
    ax.set(xlabel="eccentricity ε", ylabel="resistance over that of the short film", ylim=(0.0, 1.05), xlim=(0.0, 1.0))
    ax.set_title("Share of the short film: towards the bush —, across - -", loc="left", fontsize=10)
    ax.legend(frameon=False, fontsize=9)
