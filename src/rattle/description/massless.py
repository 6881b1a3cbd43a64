"""Bodies without mass or inertia: where they cannot be used."""

from __future__ import annotations

from collections.abc import Mapping

from rattle.description.model import Body, Joint, is_ground
from rattle.description.read_values import Values

MOST = 50  # bodies without mass or inertia


def require_mass_at_contacts(values: Values, bodies: Mapping[str, Body], joints: Mapping[str, Joint]) -> None:
    """Refuse bodies without mass or inertia on which contacts with force laws act: these need the masses they move."""
    bodies = {name: body for name, body in bodies.items() if not is_ground(name)}  # drivers hold those, in all
    without = [name for name, body in bodies.items() if body.mass == 0.0 or body.inertia == 0.0]
    if not without or values.problems:  # fields of joints with problems have no values
        return
    if len(without) > MOST:
        values.wrong(("bodies", without[MOST]), f"at most {MOST} bodies may have no mass or no inertia; give it one")
    for name, joint in joints.items():
        if not (what := _with_law(name, joint)):
            continue
        for end in (joint.a.body, joint.b.body):
            body = bodies.get(end)
            for key, number in (("mass", body.mass), ("inertia", body.inertia)) if body is not None else ():
                if number == 0.0:
                    fault = f"{what}: '{end}' needs {'a mass' if key == 'mass' else 'an inertia'} there, got 0"
                    values.wrong(("bodies", end, key), fault)
                    break


def _with_law(name: str, joint: Joint) -> str:
    """What of a joint has a force law, in words; "" if nothing has."""
    own = joint.leaf.own_contact(joint.fields)
    if joint.is_loose and joint.contact is not None and not joint.contact.rigid:
        return f"joint '{name}' has play with a force law"
    if joint.stop is not None and not joint.stop.contact.rigid:
        return f"joint '{name}' has a stop with a force law"
    return f"the {joint.kind} '{name}' has a force law" if own is not None and not own.rigid else ""
