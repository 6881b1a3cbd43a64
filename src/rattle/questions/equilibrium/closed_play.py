"""The mechanisms that stand for one with play in an equilibrium: guides closed, pins on massless links."""

from __future__ import annotations

from dataclasses import replace

from rattle.description.model import Contact, Joint
from rattle.description.passing import require_none_passing
from rattle.equations.system import System, compile_system, is_link


def without_guide_play(system: System) -> System:
    """The mechanism with every guide closed, and one-sided joints that nothing can penetrate.

    Raises ModelError if it has joints that bodies come to and leave.
    """
    require_none_passing(system.model, "an equilibrium", surfaces=True)
    joints = dict(system.model.joints)
    for name, joint in joints.items():
        if joint.leaf.touches:
            continue
        if not joint.leaf.massless and joint.is_loose and (joint.clearance > 0.0 or _is_rigid(joint)):
            joints[name] = replace(joint, contact=Contact("ideal", pushes=joint.one_sided is not None))
        elif joint.constants and (constants := joint.leaf.resting(joint.constants)) != joint.constants:
            joints[name] = replace(joint, constants=constants)
    changed = any(joints[name] is not joint for name, joint in system.model.joints.items())
    return compile_system(replace(system.model, joints=joints)) if changed else system


def without_oil(system: System) -> System:
    """The mechanism without play in the joints with oil; the system itself if there are none."""
    joints = dict(system.model.joints)
    oiled = [name for name, joint in joints.items() if joint.is_loose and _has_oil(joint)]
    if not oiled:
        return system
    joints |= {name: replace(joints[name], contact=Contact("ideal")) for name in oiled}
    return compile_system(replace(system.model, joints=joints))


def rigid_model(system: System, floating: bool = False) -> System | None:
    """The mechanism with every pin with clearance on a massless link; None if no joint has clearance.

    floating: pins in oil stay in it.
    """
    joints = dict(system.model.joints)
    for name, joint in joints.items():
        if joint.leaf.massless and (joint.is_loose or is_link(joint)) and not (floating and _has_oil(joint)):
            joints[name] = replace(joint, contact=Contact("massless-link"))
    model = replace(system.model, joints=joints)
    return compile_system(model) if any(is_link(joint) for joint in joints.values()) else None


def with_rigid_pins(system: System) -> System:
    """The mechanism with the pins that nothing can penetrate on massless links; compliant ones stay as they are."""
    joints = dict(system.model.joints)
    for name, joint in joints.items():
        if joint.leaf.massless and joint.is_loose and _is_rigid(joint):
            joints[name] = replace(joint, contact=Contact("massless-link"))
    changed = any(joints[name] is not joint for name, joint in system.model.joints.items())
    return compile_system(replace(system.model, joints=joints)) if changed else system


def _has_oil(joint: Joint) -> bool:
    return joint.contact is not None and joint.contact.film is not None


def _is_rigid(joint: Joint) -> bool:
    """True of contacts that nothing can penetrate, which hold in equilibrium; elastic ones give way."""
    return joint.contact is not None and joint.contact.rigid
