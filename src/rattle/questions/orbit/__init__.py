"""Path of a pin in its oil film under the forces of the ideal mechanism: least film, pressure, friction."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rattle.language.times import Seconds, seconds_or_none, times
from rattle.question import question

if TYPE_CHECKING:
    import numpy as np

    from rattle.mechanism import Mechanism
    from rattle.results.result import Result


@question(
    asks="Path of a pin in its oil film under the forces of the ideal mechanism: least film, pressure, friction.",
    order=240,
    wants=(
        ("how thin the oil in a joint gets, without a run", "[orbit of the pin](oil.md#the-orbit-without-the-run)"),
    ),
    examples=(("rattle orbit F --joint pin", 'm.orbit("pin", t)'),),
)
def orbit(
    m: Mechanism, joint: str, t_eval: Sequence[Seconds] | np.ndarray | None = None, *, t_end: Seconds | None = None,
    rtol: float | None = None, strict: bool = False,
) -> Result:  # fmt: skip
    """Orbit of the pin of a joint with oil under the forces of the mechanism without play (mobility method).

    Quicker than `simulate`, and close to it while the film carries: what the pin's own motion in the clearance
    changes in the forces is left out, so while it is hardly loaded its path differs.
    joint: name of a lubricated joint.  The mechanism with all clearances closed has to be fully driven; its motion
    and forces are those of `ideal().inverse_dynamics`, without stops.
    The pin starts where the mechanism with play starts: in the middle of its bush, or at its `offset` in [initial];
    it takes a turn or two of the driver to get onto its closed orbit.
    t_eval: output instants [s], from 0 on; t_end [s]: end, with the outputs of a run (default: as in the model).
    rtol: error of a step as a share of the film's thickness (default 1e-8).

    The result has the names of a run; of this joint e, film, friction and leakage, of all else what holds without
    play.  Where the film is thinner than its boundary film, the dry contact carries by its elastic force and rubs
    by the turning of the pin.
    A mechanism that gets to a dead centre ends the result there, with success = False (strict=True raises
    SolverError).
    Raises UnknownName for a joint that is not there, ModelError for one without oil or if a degree of freedom is
    not driven, AssemblyError.

    Source: Booth (1965), J. Basic Eng. 87, 187-198; docs/theory.md, section 11.
    """
    from rattle.questions.orbit import compute as orbit

    return orbit.orbit(
        m.system, m.start, joint, times(t_eval, "t_eval"), t_end=seconds_or_none(t_end, "t_end"), rtol=rtol,
        strict=strict,
    )  # fmt: skip
