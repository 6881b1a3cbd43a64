"""Why a mechanism does not follow the mouse, in words."""

from __future__ import annotations

from rattle.jit import layout as at
from rattle.results.display import scale
from rattle.sketch.descent import End
from rattle.sketch.movable import Movable

STANDS = 1e-3  # share in the motion of all bodies below which a point stands still


def why_not(movable: Movable, end: End, far: float) -> str:
    """Why the point is `far` [m] from the mouse, in words."""
    factor, unit = scale("m", far)
    away = f"{factor * far:.3g} {unit} from the mouse"
    if end.freedom == 0:
        return f"nothing can move: joints hold every body; {away}"
    if held := held_by(movable, end):
        return f"{held}; {away}"
    if end.most < STANDS:
        return f"no motion of the mechanism moves this point: take another one; {away}"
    if end.reach < STANDS:
        return f"dead centre: nothing moves this point here; {away}"
    return f"as near as the joints allow: {away}"


def held_by(movable: Movable, end: End) -> str:
    """What presses and so holds it, in words: stops, and what touches a surface; "" if nothing does."""
    system, words = movable.system, []
    for n in end.pressing:
        entry = system.arrays["contact"][n]
        joint = system.model.joints[system.joints[entry[at.OWNER]]]
        if entry[at.FORCE_COLUMN] == at.STOP:
            what = "its stop" if movable.own_stop(joint.name) else "an end"
            words.append(f"'{joint.name}' is at {what} ({'min' if entry[at.CORNER] == 0 else 'max'})")
        elif joint.leaf.touches:
            words.append(f"'{joint.b.body}' touches '{joint.name}'")
    return ", ".join(dict.fromkeys(words))
