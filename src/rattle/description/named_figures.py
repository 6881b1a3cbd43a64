"""What names in a model stand for: figures of fits, bearings, oils and materials, each with its source."""

from __future__ import annotations

import math
from collections.abc import Iterator

from rattle.description.model import Model
from rattle.language.materials import HANDBOOK, OF_MODEL, Material
from rattle.language.units import FREEZING


def named_figures(model: Model) -> list[str]:
    """A line for everything that was written by a name: where, figures, source."""
    return [*_plays(model), *_oils(model), *_materials(model)]


def _plays(model: Model) -> Iterator[str]:
    for name, joint in model.joints.items():
        if joint.named is not None:
            yield f"{name}, {joint.named.words} ({joint.named.source})"


def _oils(model: Model) -> Iterator[str]:
    for name, joint in model.joints.items():
        film = joint.contact.film if joint.contact is not None else None
        if film is not None and film.oil is not None:
            oil, warm = film.oil.oil, film.oil.temperature - FREEZING
            figures = f"{1e3 * film.oil.viscosity:.4g} mPa*s, {film.oil.density:.4g} kg/m^3"
            assumed = f"; assumed: {'; '.join(oil.assumed)}" if oil.assumed else ""
            yield f"{name}, {oil.title} at {warm:.4g} degC: {figures} (ISO 3448, ASTM D341, D2270{assumed})"


def _materials(model: Model) -> Iterator[str]:
    places: dict[str, list[str]] = {}
    for place, material in model.named_materials.items():
        figures = f"{material.name}: {_constants(material)} ({_source(material)})"
        places.setdefault(figures, []).append(place.removesuffix(".material"))
    for figures, names in places.items():
        yield f"{', '.join(names)}, {figures}"


def _constants(material: Material) -> str:
    figures = [f"E {material.E / 1e9:.4g} GPa", f"nu {material.nu:.4g}"]
    figures += [f"density {material.density:.4g} kg/m^3"] if not math.isnan(material.density) else []
    figures += [f"expansion {1e6 * material.expansion:.4g}e-6/K"] if not math.isnan(material.expansion) else []
    figures += [f"yield {material.yield_strength / 1e6:.4g} MPa"] if not math.isnan(material.yield_strength) else []
    return ", ".join(figures)


def _source(material: Material) -> str:
    thermal = "" if math.isnan(material.density) or material.source == OF_MODEL else f"; density, expansion: {HANDBOOK}"
    return material.source + thermal
