"""Equilibria and modes as lines of text and as records for JSON."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism
    from rattle.questions.equilibrium.position import Equilibria, Equilibrium

MOST_LINES = 20  # equilibria that are listed one by one
MOST_BODIES = 5  # whose angles stand in such a line
ZERO = 1e-12  # share of the size (1 rad for angles) below which a number is rounding


def listed(m: Mechanism, equilibria: Equilibria) -> str:
    """The first equilibria, how far the search went, and where the bodies are in the first."""
    lines = [f"{n + 1}. {rest}; {_angles(rest)}" for n, rest in enumerate(equilibria[:MOST_LINES])]
    if len(equilibria) > MOST_LINES:
        stable = sum(rest.stable and rest.admissible for rest in equilibria[MOST_LINES:])
        kind = f"{stable} of them" if stable else "none of them"
        lines.append(f"and {len(equilibria) - MOST_LINES} more, {kind} stable and admissible; --json lists all")
    if equilibria.extent and not equilibria.note:
        lines.append(f"{len(equilibria)} equilibri{'a' if len(equilibria) > 1 else 'um'}: {equilibria.extent}")
    lines.append(_position(m, equilibria[0]))
    if equilibria.rubbing:
        lines.append(_held(m, equilibria[0]))
    return "\n".join(lines)


def _held(m: Mechanism, rest: Equilibrium) -> str:
    """Between which positions friction holds it around an equilibrium, or why that is not known."""
    try:
        return f"  {m.dead_band(at=rest)}"
    except ValueError as error:
        return f"  no positions that friction holds around it: {error}"


def _angles(rest: Equilibrium) -> str:
    """Angles of the first bodies, by which equilibria can be told apart."""
    from rattle.results.display import scale, zeroed

    bodies = rest.table.bodies
    factor, unit = scale("rad", 1.0)
    shown = ", ".join(f"{body} {zeroed(rest[f'{body}.angle'], ZERO) * factor:.4g}" for body in bodies[:MOST_BODIES])
    return f"at {shown}{', ...' if len(bodies) > MOST_BODIES else ''} {unit}"


def _position(m: Mechanism, rest: Equilibrium) -> str:
    """Where the bodies are in the first equilibrium, and the efforts of the drivers that hold it."""
    from rattle.results.display import quantity, scale, zeroed

    lines = ["equilibrium 1:"]
    floor = ZERO * m.system.size
    factor, unit = scale(
        "m", max((abs(rest[f"{body}.{key}"]) for body in m.model.moving_bodies for key in "xy"), default=0.0)
    )
    for body in m.model.moving_bodies:
        x, y = (zeroed(rest[f"{body}.{key}"], floor) for key in "xy")
        angle = zeroed(rest[f"{body}.angle"], ZERO)
        lines.append(
            f"  {body}: x {factor * x:.6g} {unit}, y {factor * y:.6g} {unit}, angle {quantity(angle, 'rad', 6)}"
        )
    for driver in m.model.motors:
        name = next(n for n in rest.names if n.startswith(f"{driver}.") and not n.endswith(".power"))
        lines.append(f"  {name}: {quantity(rest[name], rest.unit(name), 6)}")
    if rest.nonunique:
        lines.append(f"  reactions not unique (redundant constraints) at {', '.join(rest.nonunique)}")
    return "\n".join(lines)


def entry(rest: Equilibrium) -> dict[str, Any]:
    """One equilibrium as a record: every value with its unit (SI), residual [N], gap [m]."""
    values = {name: {"value": rest[name], "unit": rest.unit(name)} for name in rest.names}
    facts = {
        "admissible": rest.admissible,
        "stable": rest.stable,
        "eigenvalue": rest.eigenvalue,
        "residual": rest.residual,
        "gap": rest.gap,
    }
    return {**facts, "reactions_unique": rest.reactions_unique, "nonunique": list(rest.nonunique), "values": values}
