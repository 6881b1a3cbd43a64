"""Equilibria, or a quasi-static motion through them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, overload

from rattle.language.times import Seconds, times
from rattle.question import FormField, Tab, question

if TYPE_CHECKING:
    import numpy as np

    from rattle.mechanism import Mechanism
    from rattle.questions.equilibrium.position import Equilibria
    from rattle.results.result import Result


@overload
def equilibrium(m: Mechanism, t: Seconds = 0.0, *, branches: str = "near", effort: float = 1.0) -> Equilibria: ...
@overload
def equilibrium(
    m: Mechanism, t: Sequence[float] | np.ndarray, *, branches: str = "near", effort: float = 1.0
) -> Result: ...
@question(
    asks="Equilibria, or a quasi-static motion through them.",
    order=110,
    wants=(
        ("where it comes to rest, and whether that is stable", "equilibrium"),
        ("how much a clamp or press amplifies the force, position by position", "quasi-static motion"),
    ),
    examples=(
        ("rattle equilibrium F --at 0", "m.equilibrium(t=0.0)"),
        ("rattle equilibrium F --path", "m.equilibrium(t_array)"),
    ),
    tab=Tab(
        "equilibrium",
        "Equilibrium",
        20,
        (
            FormField("t", "drivers held at", "0 s", size=8),
            FormField("branches", "look in", "near", choices=("near", "all")),
        ),
    ),
)
def equilibrium(
    m: Mechanism, t: Seconds | Sequence[float] | np.ndarray = 0.0, *, branches: str = "near", effort: float = 1.0
) -> Equilibria | Result:
    """Equilibria with the drivers held where they are at time t [s]; loads are evaluated with all rates zero.

    Returns a list: admissible (no bush has to pull) and stable ones first, then by their distance from the
    initial guess.  A pin with clearance is a massless link; equilibria with the pin on the other side of its bush
    (n and -n at every pin) are in the list too.  A compliant pin sinks in by its law, an impact pin is rigid;
    friction is left out.
    A pin in oil floats where its film carries, with the dry contact beside it where it is thin: films, and they
    alone, see the speeds that the drivers have at t, as of a machine that turns steadily; the inertia of bodies
    that move then is left out, and `.note` says so.
    The search is limited: it minimises the potential first, so that stable ones are found before all others, and
    ends within about a tenth of a second for ten bodies; `.extent` of the list says how far it went, `.note` that
    it was cut short.  branches: "near" keeps the branch in which the mechanism is assembled, "all" searches the
    others too.  effort: 10 allows ten times the work; at most 10 000.

    With an array of times [s]: the quasi-static motion over them as a Result, with the drivers' efforts, the
    mechanical advantage `<load>.advantage` (force or moment held at the load per unit of effort),
    `equilibrium.stiffness` (smallest eigenvalue of the reduced Hessian [N/m]), `.stable` and `.admissible`
    (1 or 0); where N of a pin goes through zero the pin changes sides, which is an event "side".
    Raises AssemblyError, ModelError.

    Source: docs/theory.md, section 7; Nocedal, Wright, Numerical Optimization (2006), section 16.2.
    """
    import numpy as np

    from rattle.analyses import arguments

    t = times(t, "t")
    if np.ndim(t) == 0:
        from rattle.questions.equilibrium.compute import equilibria

        return equilibria(m.system, arguments.number("t", t), branches, arguments.effort(effort))
    from rattle.questions.equilibrium.quasistatic import quasistatic

    return quasistatic(m.system, np.asarray(t, dtype=float), arguments.effort(effort))
