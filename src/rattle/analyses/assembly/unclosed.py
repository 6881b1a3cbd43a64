"""Why a mechanism cannot be assembled, in words: which loop stays open, or which joints and drivers disagree."""

from __future__ import annotations

import math

from rattle.analyses.assembly.loops import describe_loop, tree_path
from rattle.analyses.assembly.rank import unlike_masses
from rattle.analyses.undefined import driver_left_a_table
from rattle.equations.system import System
from rattle.jit import layout as at
from rattle.jit.workspace import Workspace

TAKES_PART = 0.05  # share of the widest gap above which a joint is named
MOST_NAMED = 6


def why_open(system: System, workspace: Workspace, t: float) -> str:
    """What stays open at the state in the workspace at time t [s], in words; the residual must be at its minimum."""
    model = system.model
    nothing = without_value(system, workspace, t)
    if nothing:
        return nothing
    gaps = dict.fromkeys(model.joints, 0.0)
    for row, value in zip(system.rows, workspace.rows[:, at.RES], strict=True):
        name = (model.drivers[row.owner].joint or row.owner) if row.driver else row.owner
        gaps[name] = math.hypot(gaps.get(name, 0.0), float(value))
    worst = max(gaps, key=lambda name: gaps[name])
    joint = model.joints.get(worst)
    unit = "m"
    path = tree_path(model, joint.a.body, joint.b.body, without=worst) if joint else None
    if joint is None or path is None:
        gap = gaps[worst]
        unit = next((row.unit for row in system.rows if row.owner == worst), "m")
        taking = sorted((name for name in gaps if gaps[name] > TAKES_PART * gap), key=lambda name: -gaps[name])
        what = _at_odds(system, taking)
    else:
        gap, taking = gaps[worst] + sum(gaps[name] for name in path), [worst, *path]
        what = f"the loop {describe_loop(model, joint, path)}"
    words = f"the mechanism cannot be assembled: {what} stays open by {gap:.3g} {unit}{_at(system, workspace, t)}"
    unlike = unlike_masses(system)
    if unlike:
        return f"{words}: {unlike}"
    words += ". Check the lengths, or give better angles in [initial] (or another driver position)."
    return words + _closed_play(system, taking, gap, unit)


def _at_odds(system: System, taking: list[str]) -> str:
    """ "driver 'axis' and joints 'lower', 'upper' contradict each other; driver 'axis'", or only the last part."""
    worst = f"{'joint' if taking[0] in system.model.joints else 'driver'} '{taking[0]}'"
    groups = []
    for word, members in (("driver", system.model.drivers), ("joint", system.model.joints)):
        names = [f"'{name}'" for name in taking if name in members]
        if names:
            more = f" and {len(names) - MOST_NAMED} more" if len(names) > MOST_NAMED else ""
            groups.append(f"{word}{'s' if len(names) > 1 else ''} {', '.join(names[:MOST_NAMED])}{more}")
    return worst if len(taking) < 2 else f"{' and '.join(groups)} contradict each other; {worst}"


def _closed_play(system: System, taking: list[str], gap: float, unit: str) -> str:
    """Hint at joints whose clearance is closed, if it is wide enough to be the reason; "" otherwise."""
    closed = {
        name: joint.clearance
        for name, joint in system.model.joints.items()
        if name in taking and joint.contact is not None and joint.contact.closed and joint.clearance > 0.0
    }
    if unit != "m" or sum(closed.values()) < gap:
        return ""
    listed = ", ".join(f"'{name}'" for name in list(closed)[:MOST_NAMED])
    return (
        f" The clearance of {listed}, up to {max(closed.values()):.3g} m, is closed here; a part that is meant to touch"
        " on one side only does not fit in the middle. With its clearance the mechanism may close."
    )


def _at(system: System, workspace: Workspace, t: float) -> str:
    """The instant, and the values of the drivers at it, in words."""
    functions = []
    for name in system.model.drivers:
        value = workspace.values[system.driver_slot(name)]
        unit = system.rows[system.first_row(name)].unit
        functions.append(
            f"{name} = {math.degrees(value) + 0.0:.4g} deg" if unit == "rad" else f"{name} = {value:.4g} m"
        )
    return f" at t = {t:.6g} s" + (f" ({', '.join(functions)})" if functions else "")


def without_value(system: System, workspace: Workspace, t: float) -> str:
    """In words, which driver has no finite value at the time t [s] of the workspace; "" if all have."""
    for name in system.model.drivers:
        value = workspace.values[system.driver_slot(name)]
        if not math.isfinite(value):
            if left := driver_left_a_table(system, workspace, name, t):
                return left
            domain = "check its domain (square root, logarithm, division by zero)"
            return f"the function of driver '{name}' has no finite value at t = {t:.6g} s ({value:g}); {domain}"
    return ""
