"""Mixed lubrication: an oil film and a dry contact in parallel.

h = c - |e|       film thickness; h_b: that of the boundary film, in which the highest asperities touch
force = film(e, v), its coefficients those of max(h, h_b)   +   dry law of the penetration delta = h_b - h > 0

Both are continuous at h = h_b, and neither gives energy: no weight multiplies a potential.  Stribeck's curve, the
friction of a joint over its speed, follows.
"""

from __future__ import annotations

from collections.abc import Mapping

from rattle.interfaces.contacts import ContactKind
from rattle.language.recorded import as_number
from rattle.registry import Field, kind

SIGMAS = 3.0  # boundary film over the roughness of both surfaces
THIN = 1e-3  # boundary film over the clearance if no roughness is known


@kind("contact", "lubricated")
class Lubricated(ContactKind):
    """An oil film in the clearance, and a compliant contact beside it where the film is thin.

    Besides: the fields of its film (`film`: finite, short, pinkus-sternlicht), `dry`: the table of a compliant contact,
    `roughness`: root mean square [m], a number or [bush, pin].

    Source: this package; Hamrock, Schmid, Jacobson, Fundamentals of Fluid Film Lubrication (2004) (film parameter and
    regimes).
    """

    contacts = True
    oiled = True
    assumes = (
        "Oil fills the clearance, with one viscosity for the whole film and ends that are always supplied: heating,"
        " starvation, misalignment and bending of the bush are left out.  Where the film is thinner than its boundary"
        " film, a dry contact carries beside it."
    )
    boundary_film = Field(
        "m",
        "thickness of the film at which the dry contact begins; default: 3 times the roughness, or 1e-3 clearances",
        lambda read: boundary_film(read),
        least="positive",
    )
    density = Field("kg/m^3", "of the oil", 870.0, least="positive")
    specific_heat = Field("J/(kg*K)", "of the oil", 2000.0, least="positive")


def boundary_film(read: Mapping[str, float]) -> float:
    """Thickness [m] of the boundary film from `roughness`, of both surfaces together [m], and `clearance` [m]."""
    roughness: float = read.get("roughness", 0.0)
    return SIGMAS * roughness if roughness > 0.0 else THIN * as_number(read.get("clearance", 0.0))
