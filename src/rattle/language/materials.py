"""Constants of common engineering materials: elastic ones, and for some what else a drawing needs."""

from __future__ import annotations

import difflib
import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from rattle.errors import InputError

SHIGLEY = "Shigley's Mechanical Engineering Design, table A-5"
TYPICAL = "typical data-sheet value; differs by grade"
POLYMER = "typical data-sheet value at 23 C, dry; differs by grade, falls with temperature"
HANDBOOK = "handbook, typical"  # density, expansion, conductivity: some per cent for metals, 30 % for plastics
OF_MODEL = "of the model"  # defined there by its user
NO_NUMBER = math.nan


class Material(NamedTuple):
    """Young's modulus E [Pa] and Poisson's ratio nu [-] of one material, with where they come from; and nan or

    what else is known: density [kg/m^3], thermal expansion [1/K], conductivity [W/(m*K)].  Strengths belong to a grade
    and a part, and are never known by the name of a family: yield and ultimate strength [Pa], the amplitude at R = -1
    that the part endures for so many cycles [Pa], exponent k of its S-N line N = N_e (S_e / s)^k.
    """

    E: float
    nu: float
    source: str = "given"
    density: float = NO_NUMBER
    expansion: float = NO_NUMBER
    conductivity: float = NO_NUMBER
    yield_strength: float = NO_NUMBER
    ultimate: float = NO_NUMBER
    endurance: float = NO_NUMBER
    endurance_cycles: float = 1e6
    exponent: float = NO_NUMBER
    name: str = ""


Given = str | Mapping[str, Any] | Material  # a material as written: its name or { E, nu }

ELASTIC: Mapping[str, Material] = {
    "steel": Material(207e9, 0.30, "common value for carbon and low-alloy steel; Shigley: 207 GPa, 0.292"),
    "stainless steel": Material(190e9, 0.305, SHIGLEY),
    "cast iron": Material(100e9, 0.211, SHIGLEY + " (gray)"),
    "aluminium": Material(71.7e9, 0.333, SHIGLEY),
    "magnesium": Material(44.8e9, 0.350, SHIGLEY),
    "titanium": Material(114e9, 0.340, SHIGLEY),
    "copper": Material(119e9, 0.326, SHIGLEY),
    "brass": Material(106e9, 0.324, SHIGLEY),
    "bronze": Material(111e9, 0.349, SHIGLEY + " (phosphor bronze)"),
    "beryllium copper": Material(124e9, 0.285, SHIGLEY),
    "glass": Material(46.2e9, 0.245, SHIGLEY),
    "tungsten carbide": Material(630e9, 0.22, TYPICAL),
    "silicon nitride": Material(310e9, 0.27, TYPICAL),
    "alumina": Material(370e9, 0.22, TYPICAL),
    "ptfe": Material(0.5e9, 0.46, POLYMER),
    "nylon": Material(2.8e9, 0.39, POLYMER + " (PA 66)"),
    "acetal": Material(2.9e9, 0.37, POLYMER + " (POM)"),
    "peek": Material(3.7e9, 0.40, POLYMER),
    "uhmwpe": Material(0.8e9, 0.46, POLYMER),
}
TYPICAL_OF = {  # density [kg/m^3], expansion [1/K], conductivity [W/(m*K)] of a common grade, by handbooks
    "steel": (7850.0, 11.5e-6, 42.0),
    "stainless steel": (7900.0, 16.0e-6, 15.0),
    "cast iron": (7200.0, 11.0e-6, 48.0),
    "aluminium": (2700.0, 23.6e-6, 167.0),
    "titanium": (4430.0, 8.6e-6, 6.7),
    "brass": (8470.0, 20.9e-6, 123.0),
    "bronze": (8800.0, 18.2e-6, 67.0),
    "ptfe": (2170.0, 135e-6, 0.25),
    "nylon": (1140.0, 80e-6, 0.25),
    "acetal": (1410.0, 110e-6, 0.31),
    "peek": (1300.0, 47e-6, 0.25),
    "uhmwpe": (935.0, 180e-6, 0.41),
}
MATERIALS: Mapping[str, Material] = {
    name: Material(*elastic[:3], *TYPICAL_OF.get(name, (NO_NUMBER,) * 3), name=name)
    for name, elastic in ELASTIC.items()
}
ALIASES = {
    "pom": "acetal",
    "polyamide": "nylon",
    "teflon": "ptfe",
    "aluminum": "aluminium",
    "phosphor bronze": "bronze",
}


def material(written: Given) -> Material:
    """Material given by a name in `MATERIALS` (upper or lower case, hyphen or space), or by {E [Pa], nu [-]}.

    Raises InputError for an unknown name (with a suggestion), for a missing or unknown key, and unless
    E > 0 and -1 < nu <= 0.5.
    """
    if isinstance(written, Material):
        return written
    if isinstance(written, str):
        name = " ".join(written.lower().replace("-", " ").replace("_", " ").split())
        name = ALIASES.get(name, name)
        if name not in MATERIALS:
            near = difflib.get_close_matches(name, [*MATERIALS, *ALIASES], 1)
            hint = f"did you mean '{near[0]}'?" if near else f"known: {', '.join(MATERIALS)}; or give {{ E, nu }}"
            raise InputError(f"unknown material '{written}'; {hint}")
        return MATERIALS[name]
    if set(written) != {"E", "nu"}:
        raise InputError(f"a material is a name or {{ E, nu }}, not {{ {', '.join(map(str, written))} }}")
    modulus, nu = float(written["E"]), float(written["nu"])
    if not (modulus > 0.0 and math.isfinite(modulus)):
        raise InputError(f"Young's modulus must be positive, not {modulus:g} Pa")
    if not -1.0 < nu <= 0.5:
        raise InputError(f"Poisson's ratio must lie within -1 ... 0.5, not {nu:g}")
    return Material(modulus, nu)


def contact_modulus(material_a: Given, material_b: Given) -> float:
    """Contact modulus E* = 1/(s_A + s_B) [Pa], s = (1 - nu^2)/E."""
    a, b = material(material_a), material(material_b)
    return 1.0 / ((1.0 - a.nu**2) / a.E + (1.0 - b.nu**2) / b.E)
