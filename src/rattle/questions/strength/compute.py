"""How much bars and the necks of plates bear in a motion.

Source: docs/theory.md, section 12.
"""

from __future__ import annotations

from collections.abc import Iterable

from rattle.description.model import Body, Model
from rattle.errors import InputError, suggest
from rattle.questions.strength.answer import Strength
from rattle.questions.strength.bar import Bar
from rattle.questions.strength.known_motion import KnownMotion, known_motion
from rattle.questions.strength.neck import Neck
from rattle.results.result import Result


def strength(r: Result, body: str) -> Strength:
    """How much a bar or a neck of a plate bears in the motion of a result; see `Result.strength`."""
    return next(iter(strengths(r, (body,)).values()))


def strengths(r: Result, names: Iterable[str] | None = None) -> dict[str, Strength]:
    """The same of several, by default of all bars with section and material, and of all necks."""
    motion = known_motion(r, "strength")
    model = motion.system.model
    chosen = stressed_of(model) if names is None else [require_stressed(model, name) for name in names]
    return {name: _of(motion, name) for name in chosen}


def _of(motion: KnownMotion, name: str) -> Strength:
    body, _, neck = name.partition(".")
    return Neck(motion, body, neck) if neck else Bar(motion, body)


def stressed_of(model: Model) -> tuple[str, ...]:
    """What the strength of can be asked for: bars by name, and necks as plate.neck."""
    return tuple(name for body in model.bodies.values() for name in _stressed(body))


def _stressed(body: Body) -> Iterable[str]:
    beam = body.beam
    if beam is not None and beam.section and beam.material:
        yield body.name
    if body.sheet is not None:
        yield from (f"{body.name}.{neck}" for neck in body.sheet.necks)


def require_stressed(model: Model, name: str) -> str:
    """The name of a bar with section and material, or of a neck, of the only one for a plate.  Raises InputError."""
    able = stressed_of(model)
    if name in able:
        return name
    body = model.bodies.get(name.partition(".")[0])
    if body is None:
        raise InputError(f"strength: no body '{name.partition('.')[0]}'{suggest(name, able or model.bodies)}")
    if body.sheet is not None:
        return _the_neck(body, name)
    beam = body.beam
    if beam is None:
        raise InputError(
            f'strength: body \'{name}\' is no bar; it needs bar = ["A", "B"], length, section, material,'
            " or as a plate necks"
        )
    if "." in name:
        raise InputError(f"strength: '{name}': '{body.name}' is a bar, which is asked for whole: '{body.name}'")
    missing = [key for key, part in (("section", beam.section), ("material", beam.material)) if part is None]
    raise InputError(f"strength: the bar '{name}' needs {' and '.join(missing)} in the model")


def _the_neck(body: Body, name: str) -> str:
    """The only neck of a plate.  Raises InputError."""
    necks = list(_stressed(body))
    if len(necks) == 1 and name == body.name:
        return necks[0]
    if not necks:
        raise InputError(
            f"strength: the plate '{body.name}' needs necks in the model, cuts from edge to edge:"
            " necks = { root = [[x, y], [x, y]] }"
        )
    if name == body.name:
        raise InputError(f"strength: the plate '{name}' has several necks; ask for one: {', '.join(necks)}")
    raise InputError(f"strength: no neck '{name}'{suggest(name, necks)}")
