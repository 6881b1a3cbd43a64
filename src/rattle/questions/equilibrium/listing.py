"""Equilibria and modes as lines of text and as records for JSON."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from rattle.cli.output import zeroed

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism
    from rattle.questions.equilibrium.position import Equilibria, Equilibrium

MOST_LINES = 20  # equilibria that are listed one by one
MOST_BODIES = 5  # whose angles stand in such a line
ZERO = 1e-12  # share of the size (1 rad for angles) below which a number is rounding


def listed(m: Mechanism, found: Equilibria) -> None:
    """Print the first equilibria, how far the search went, and where the bodies are in the first."""
    for n, one in enumerate(found[:MOST_LINES]):
        click.echo(f"{n + 1}. {one}; {_angles(one)}")
    if len(found) > MOST_LINES:
        stable = sum(one.stable and one.admissible for one in found[MOST_LINES:])
        kind = f"{stable} of them" if stable else "none of them"
        click.echo(f"and {len(found) - MOST_LINES} more, {kind} stable and admissible; --json lists all")
    if found and found.extent and not found.note:
        click.echo(f"{len(found)} equilibri{'a' if len(found) > 1 else 'um'}: {found.extent}")
    if found:
        click.echo(_position(m, found[0]))
    if found and found.rubbing:
        click.echo(_held(m, found[0]))


def _held(m: Mechanism, one: Equilibrium) -> str:
    """Between which positions friction holds it around an equilibrium, or why that is not known."""
    try:
        return f"  {m.dead_band(at=one)}"
    except ValueError as error:
        return f"  no positions that friction holds around it: {error}"


def _angles(one: Equilibrium) -> str:
    """Angles of the first bodies, by which equilibria can be told apart."""
    from rattle.results.display import scale

    bodies = list(one.table.geometry["bodies"])
    factor, unit = scale("rad", 1.0)
    shown = ", ".join(f"{body} {zeroed(one[f'{body}.angle'], ZERO) * factor:.4g}" for body in bodies[:MOST_BODIES])
    return f"at {shown}{', ...' if len(bodies) > MOST_BODIES else ''} {unit}"


def _position(m: Mechanism, one: Equilibrium) -> str:
    """Where the bodies are in the first equilibrium, and the efforts of the drivers that hold it."""
    from rattle.results.display import quantity, scale

    lines = ["equilibrium 1:"]
    floor = ZERO * m.system.size
    factor, unit = scale("m", max((abs(one[f"{body}.{key}"]) for body in m.model.bodies for key in "xy"), default=0.0))
    for body in m.model.bodies:
        x, y = (zeroed(one[f"{body}.{key}"], floor) for key in "xy")
        angle = zeroed(one[f"{body}.angle"], ZERO)
        lines.append(
            f"  {body}: x {factor * x:.6g} {unit}, y {factor * y:.6g} {unit}, angle {quantity(angle, 'rad', 6)}"
        )
    for driver in m.model.drivers:
        name = next(n for n in one.names if n.startswith(f"{driver}.") and not n.endswith(".power"))
        lines.append(f"  {name}: {quantity(one[name], one.unit(name), 6)}")
    if one.nonunique:
        lines.append(f"  reactions not unique (redundant constraints) at {', '.join(one.nonunique)}")
    return "\n".join(lines)


def entry(one: Equilibrium) -> dict[str, Any]:
    """One equilibrium as a record: every value with its unit (SI), residual [N], gap [m]."""
    values = {name: {"value": one[name], "unit": one.unit(name)} for name in one.names}
    facts = {
        "admissible": one.admissible,
        "stable": one.stable,
        "eigenvalue": one.eigenvalue,
        "residual": one.residual,
        "gap": one.gap,
    }
    return {**facts, "reactions_unique": one.reactions_unique, "nonunique": list(one.nonunique), "values": values}
