"""Contacts that would be inside their walls at the start, in words."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from rattle.description.model import Joint, is_ground
from rattle.equations.contact_table import contact_labels
from rattle.equations.start import first_outside
from rattle.equations.system import System
from rattle.jit import layout as at
from rattle.jit.workspace import Workspace
from rattle.language.recorded import bare

ON_BUSH = 1e-9  # clearances of oil left beside the boundary film that count as none
INSIDE = 1e-6  # penetration at the start that is taken for rounding of given numbers, in gaps of the contact
INSIDE_SURFACE = 1e-9  # the same of a surface, outside of which bodies are placed by coordinates
AT_ONE_PLACE = 1e-9  # share of its least distance below which a distance has no direction
INSIDE_WORN = 1e-4  # the same of a worn surface, which is a polygon


def outside(system: System, workspace: Workspace) -> str:
    """In words, which pin is outside its bush, block outside its guide or joint beyond its stop; "" if none is."""
    if not len(system.arrays["contact"]):
        return ""
    n = first_outside(workspace, np.array([math.nextafter(*least) for least in least_gaps(system)]))
    if coincident := _coincident(system, workspace):
        return coincident
    if n < 0:
        return ""
    entry, gap = system.arrays["contact"][n], float(workspace.contact_kinematics[n, at.GAP])
    name = system.joints[entry[at.OWNER]]
    joint = system.model.joints[name]
    oil, clearance = _film(joint, entry), joint.clearance
    if entry[at.FORCE_COLUMN] == at.STOP and joint.stop is not None:
        return _beyond(joint, int(entry[at.SENSE]), gap)
    if joint.leaf.touches:
        return _inside_surface(system, workspace, n)
    if joint.one_sided is not None:
        return (
            f"joint '{name}' starts {-gap:.3g} m inside {joint.one_sided.wall}: give its bodies positions in"
            " [initial] at which they are clear of each other, or none, and they touch"
        )
    if oil is not None:
        gap += oil.boundary
        if gap > -ON_BUSH * clearance:
            where = f"of '{name}' in [initial] within its clearance of {clearance:.3g} m"
            return f"joint '{name}' starts on its bush, where no oil is left: give an offset {where}"
    return (
        f"joint '{name}' starts {-gap:.3g} m outside its clearance of {clearance:.3g} m: give the bodies"
        f" positions with the pin inside, or an offset of '{name}' in [initial]"
    )


def _inside_surface(system: System, workspace: Workspace, n: int) -> str:
    """In words, that contact n of a surface starts inside it, how deep, and which way is out."""
    name, corner = contact_labels(system.model)[n]
    joint, row = system.model.joints[name], workspace.contact_kinematics[n]
    depth, x, y = -float(row[at.GAP]), -float(row[at.NX]), -float(row[at.NY])
    moved, sign = (joint.b.body, 1.0) if not is_ground(joint.b.body) else (joint.a.body, -1.0)
    with_corner = f" with corner '{corner}'" if corner else ""
    return (
        f"joint '{name}' starts {1e3 * depth:.4g} mm inside the surface{with_corner}: move '{moved}' by"
        f" ({1e3 * sign * depth * x + 0.0:.4g}, {1e3 * sign * depth * y + 0.0:.4g}) mm or more in [initial]"
    )


def least_gaps(system: System) -> list[tuple[Any, float]]:
    """The gap [m or rad] that every contact may have at the start, at least; inf beside it: it has to be larger."""
    gaps: list[tuple[Any, float]] = []
    for entry, bounds in zip(system.arrays["contact"], system.arrays["lever"], strict=True):
        joint = system.model.joints[system.joints[entry[at.OWNER]]]
        oil = _film(joint, entry)
        inside = INSIDE_WORN if entry[at.WORN] == 1 else INSIDE_SURFACE if joint.leaf.touches else INSIDE
        least = -inside * bounds[at.GAP_SCALE]
        if entry[at.FORCE_COLUMN] == at.STOP and joint.stop is not None:
            free = not joint.stop.contact.rigid
        else:  # teeth: a run begins behind the tooth that is there
            compliant = joint.contact is not None and not joint.contact.rigid
            free = bare(bounds[at.ANGULAR]) > 0.0 or (joint.one_sided is not None and compliant)
        if free:
            gaps.append((-math.inf, -math.inf))
        elif oil is not None:  # the dry contact begins at the boundary film
            gaps.append((-oil.boundary, math.inf))
        else:
            gaps.append((least, least))
    return gaps


def _coincident(system: System, workspace: Workspace) -> str:
    """In words, which two points keep a distance from each other but are at one place; "" if none are."""
    for entry, kinematics in zip(system.arrays["contact"], workspace.contact_kinematics, strict=True):
        joint = system.model.joints[system.joints[entry[at.OWNER]]]
        if joint.stop is None or not joint.held_by_stops or entry[at.SENSE] < 0:
            continue
        least = joint.stop.minimum
        if kinematics[at.GAP] + least <= AT_ONE_PLACE * least:
            return (
                f"both points of '{joint.name}' start at one place, so that nothing says which way min = {least:g} m of"
                " its stop pushes them apart: give its bodies other values in [initial]"
            )
    return ""


def _film(joint: Joint, entry: np.ndarray) -> Any:
    """The oil film of a contact; None if it has none."""
    return joint.contact.film if joint.contact is not None and entry[at.FILM_LAW] >= 0 else None


def _beyond(joint: Joint, sense: int, gap: float) -> str:
    """In words, that a joint starts beyond a rigid stop; gap [m or rad]."""
    assert joint.stop is not None, "called for a contact of the stop"
    end, words = (joint.stop.minimum, "min") if sense > 0 else (joint.stop.maximum, "max")
    value, deg = end + sense * gap, 180.0 / math.pi
    if not joint.stops_angle:
        where = f"at {value:.6g} m, beyond {words} = {end:.6g} m"
    else:
        where = f"at {deg * value:.6g} deg, beyond {words} = {deg * end:.6g} deg"
    turns = round(-gap / (2.0 * math.pi)) if joint.stops_angle else 0
    also = f"; angles are continuous: start {turns} turn{'s' if turns > 1 else ''} away" if turns else ""
    return f"joint '{joint.name}' starts {where} of its stop: give its bodies other values in [initial]{also}"
