"""Contacts that would be inside their walls at the start, in words."""

from __future__ import annotations

import math

from rattle.description.model import Joint
from rattle.equations.compliant import locate_contacts
from rattle.equations.system import System
from rattle.jit import layout as at
from rattle.jit.workspace import Workspace


def outside(system: System, workspace: Workspace) -> str:
    """In words, which pin is outside its bush, block outside its guide or joint beyond its stop; "" if none is."""
    contact, lever = system.arrays["contact"], system.arrays["lever"]
    if not len(contact):
        return ""
    locate_contacts(workspace)
    for entry, one, gap in zip(contact, lever, workspace.contact_kinematics[:, at.GAP], strict=True):
        name = system.joints[entry[at.OWNER]]
        joint = system.model.joints[name]
        oil = joint.contact.film if joint.contact is not None and entry[at.FILM_LAW] >= 0 else None
        if oil is not None and gap > -oil.boundary:  # the dry contact begins at the boundary film
            continue
        slight = 1e-4 if entry[at.WORN] == 1 else 1e-6  # a worn surface is a polygon
        if oil is None and gap >= -slight * one[at.GAP_SCALE]:
            continue
        if entry[at.FORCE_COLUMN] == at.STOP and joint.stop is not None:
            if joint.stop.contact.rigid:
                return _beyond(joint, int(entry[at.SENSE]), float(gap))
        elif one[at.ANGULAR] > 0.0:
            continue  # teeth: a run begins behind the tooth that is there
        else:
            clearance = joint.clearance
            if joint.one_sided is not None and joint.contact is not None and not joint.contact.rigid:
                continue
            if joint.one_sided is not None:
                return (
                    f"joint '{name}' starts {-gap:.3g} m inside {joint.one_sided.wall}: give its bodies positions in"
                    " [initial] at which they are clear of each other, or none, and they touch"
                )
            if oil is not None:
                gap += oil.boundary
                if gap > -1e-9 * clearance:
                    said = f"of '{name}' in [initial] within its clearance of {clearance:.3g} m"
                    return f"joint '{name}' starts on its bush, where no oil is left: give an offset {said}"
            return (
                f"joint '{name}' starts {-gap:.3g} m outside its clearance of {clearance:.3g} m: give the bodies"
                f" positions with the pin inside, or an offset of '{name}' in [initial]"
            )
    return ""


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
