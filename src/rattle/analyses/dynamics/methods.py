"""Choice of the stepper for a mechanism, and of the kind of run."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from rattle import registry
from rattle.analyses.assembly.assembly import Assembled
from rattle.analyses.dynamics.event_driven_run import EventDrivenRun
from rattle.analyses.dynamics.moreau_jean_run import MoreauJeanRun
from rattle.analyses.dynamics.run import How, Run
from rattle.analyses.dynamics.smooth_run import SmoothRun
from rattle.equations.contact_table import contact_groups
from rattle.equations.system import System
from rattle.errors import InputError, ModelError, Problem
from rattle.interfaces.steppers import StepperKind
from rattle.jit import layout as at
from rattle.registry import Kind
from rattle.solvers.stepper import (
    COMPLIANT,
    EVENT_DRIVEN,
    FREE,
    OILED,
    SET_VALUED,
    SMOOTH,
    TIME_STEPPING,
    usual_stepper,
)  # fmt: skip

LOOPS: Mapping[str, type[Run]] = {
    SMOOTH: SmoothRun,
    EVENT_DRIVEN: EventDrivenRun,
    TIME_STEPPING: MoreauJeanRun,
}


def new_run(system: System, start: Assembled, t_eval: np.ndarray, t_end: float, how: How) -> Run:
    """A run of the kind that its stepper needs; t_eval: (n,) output times [s] up to t_end [s]."""
    return LOOPS[how.stepper.leaf.loop](system, start, t_eval, t_end, how)


def contacts_of(system: System) -> str:
    """The contacts of the mechanism: FREE (none), COMPLIANT, OILED or SET_VALUED (at least one)."""
    contacts = system.arrays["contact"]
    if (contacts[:, at.IMPACT] == 1).any():
        return SET_VALUED
    return OILED if (contacts[:, at.FILM_LAW] >= 0).any() else COMPLIANT if len(contacts) else FREE


def choose_stepper(
    system: System, asked: str | None, step: float | None, span: float
) -> tuple[Kind[StepperKind], float | None]:
    """The stepper for a request, and its step [s], over a time `span` [s].

    The usual one is taken if none is requested (None), or one that does not work with the contacts.  Raises InputError
    if that refuses to be replaced, and ModelError for set-valued contacts that no stepper can treat.
    """
    steppers, contacts = registry.kinds("stepper"), contacts_of(system)
    stepper = steppers[usual_stepper(contacts) if asked is None else asked]
    if contacts in stepper.leaf.refuses:
        raise InputError(f"{stepper.name} {stepper.leaf.unfit[contacts]}; use method {usual_stepper(contacts)}")
    if contacts not in stepper.leaf.works_with:
        stepper = steppers[usual_stepper(contacts)]
    if contacts == SET_VALUED:
        require_round(system, stepper)
        require_friction_known(system, stepper)
        require_implicit(system, stepper)
        require_one_law(system, stepper.leaf)
        require_frictionless_chain(system)
    settings = system.model.settings
    stated = stepper.leaf if settings.method is None else steppers[settings.method].leaf
    if (
        stepper.leaf.adaptive
        and not stated.adaptive
        and stated.loop != stepper.leaf.loop
        and contacts in stated.works_with
    ):
        step = None if step == settings.step else step  # the model's step is for the other stepper
    if step is None and not stepper.leaf.adaptive:
        step = stepper.leaf.step.default(span)
    return stepper, step


def note_choice(system: System, asked: str | None, ran: Kind[StepperKind]) -> tuple[str, ...]:
    """Note on a run by another stepper than the one requested, or by one that is not the usual one of most models."""
    if asked is None:
        return (f"method {ran.name} was chosen, as {ran.leaf.usual_since}",) if ran.leaf.usual_since else ()
    if asked == ran.name:
        return ()
    why = registry.kinds("stepper")[asked].leaf.unfit[contacts_of(system)]
    return (f"method {asked} {why}: {ran.name} was used",)


def require_round(system: System, stepper: Kind[StepperKind]) -> None:
    """Raise ModelError for worn surfaces if the stepper does not know them."""
    worn = system.arrays["contact"][system.arrays["contact"][:, at.WORN] == 1, at.OWNER].tolist()
    if stepper.leaf.loop == TIME_STEPPING and worn:
        words = f"method {stepper.name} knows round surfaces only; use method {usual_stepper(SET_VALUED)}"
        raise ModelError([Problem(("joints", system.joints[n], "wear"), words) for n in worn])


def require_friction_known(system: System, stepper: Kind[StepperKind]) -> None:
    """Raise ModelError for friction in joints without play if the stepper does not know it."""
    if stepper.leaf.loop == TIME_STEPPING and system.dry_joints:
        joints = [system.model.joints[name] for name in system.rough_joints]
        words = (
            f"method {stepper.name} knows no {{}}, only friction in contacts; use method {usual_stepper(SET_VALUED)}"
        )
        raise ModelError([Problem(joint.friction_path, words.format(joint.friction_named)) for joint in joints])


def require_implicit(system: System, stepper: Kind[StepperKind]) -> None:
    """Raise ModelError for what time stepping cannot take implicitly: elastic clutches, friction with states."""
    if stepper.leaf.loop != TIME_STEPPING:
        return
    problems, other = [], usual_stepper(SET_VALUED)
    for joint in system.model.joints.values():
        own = joint.leaf.own_contact(joint.fields)
        if own is not None and not own.rigid:
            words = f"method {stepper.name} knows no viscous or compliant clutches; use method {other}"
            problems.append(Problem(("joints", joint.name, "model"), words))
        for group in contact_groups(joint):
            friction = group.contact.friction
            if friction is not None and registry.kinds("friction")[friction.kind].leaf.states:
                words = f"method {stepper.name} knows no friction with states ({friction.kind}); use method {other}"
                problems.append(Problem((*group.path, "friction"), words))
    if problems:
        raise ModelError(problems)


def require_one_law(system: System, stepper: type[StepperKind]) -> None:
    """Raise ModelError if joints differ in their restitution law, or if the stepper does not have that law.

    An impact at several joints is one problem, with one law.
    """
    joints = system.model.joints.values()
    groups = [group for joint in joints for group in contact_groups(joint) if group.contact.rigid]
    laws = {group.path: group.contact.restitution_law for group in groups}
    if not laws:
        return
    first = next(iter(laws))
    for path, law in laws.items():
        if law != laws[first]:
            listed = ", ".join(f"{_named(path)}: {which}" for path, which in laws.items())
            words = f"impacts at several joints are one problem, which needs one law for all joints (now {listed})"
            raise ModelError([Problem((*path, "restitution_law"), words)])
    if stepper.restitution_laws and laws[first] not in stepper.restitution_laws:
        has = " or ".join(f'"{law}"' for law in stepper.restitution_laws)
        words = f'"{laws[first]}" works with method "{usual_stepper(SET_VALUED)}" only; {stepper.title} has {has}'
        raise ModelError([Problem((*first, "restitution_law"), words)])


def require_frictionless_chain(system: System) -> None:
    """Raise ModelError for what the distributing law does not know: friction of joints, one-way clutches."""
    joints = system.model.joints.values()
    groups = [group for joint in joints for group in contact_groups(joint) if group.contact.rigid]
    chains = [group for group in groups if group.contact.shares_by_stiffness]
    if not chains:
        return
    which, problems = f'restitution_law = "{chains[0].contact.restitution_law}" ({_named(chains[0].path)})', []
    for joint in joints:
        own = joint.leaf.own_contact(joint.fields)
        if own is not None and own.rigid:
            words = f"a rigid {joint.kind} has no stiffness by which {which} shares impulses; use another law"
            problems.append(Problem(("joints", joint.name), words))
        if joint.friction is not None and joint.friction.law is None:
            words = f"{which} knows no {joint.friction_named} in impacts; use another law of either"
            problems.append(Problem(joint.friction_path, words))
    if problems:
        raise ModelError(problems)


def _named(path: tuple[str, ...]) -> str:
    """The joint of a contact model, and whether it is that of its stop."""
    return path[1] + (" (stop)" if "stop" in path[2:] else "")
