"""Driven motion with all reactions, torque and power of the drivers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from rattle.language.times import Seconds, times
from rattle.question import question

if TYPE_CHECKING:
    import numpy as np

    from rattle.mechanism import Mechanism
    from rattle.results.result import Result


@question(
    asks="Driven motion with all reactions, torque and power of the drivers.",
    order=100,
    title="Inverse dynamics",
    wants=(
        ("the torque the motor must give, the forces in the joints", "inverse dynamics"),
        ("the torque at O when the motion is prescribed at the slider", "inverse dynamics"),
    ),
    examples=(
        ("rattle inverse-dynamics F", "m.inverse_dynamics(t)"),
        ("rattle inverse-dynamics F --effort-at O", 'm.inverse_dynamics(t, effort_at="O")'),
    ),
)
def inverse_dynamics(
    m: Mechanism,
    t_eval: Seconds | Sequence[Seconds] | np.ndarray,
    *,
    effort_at: str | Mapping[str, str] | None = None,
    strict: bool = False,
) -> Result:
    """Kinematics with all reactions [N, N*m] and the effort [N or N*m] and power [W] of the drivers.

    effort_at: a joint with a motor that does the work of the driver, which then only prescribes the motion: its
    torque is `<joint>.torque` [N*m] (`<joint>.thrust` [N] on a prismatic joint), its power `<joint>.power` [W];
    all reactions are those with this motor.  With several drivers: {driver: joint}.
    Joints whose reactions are not unique (redundant constraints) are named in `trust.nonunique`.
    Raises what `kinematics` raises.
    """
    from rattle.questions.kinematics import compute as kinematics

    result = kinematics.analyse(
        m.system, m._start_or_none(), times(t_eval, "t_eval"), forces=True, effort_at=effort_at, strict=strict
    )
    if m._told:
        result.provenance["document"] = m.to_json()
        if effort_at is not None:
            result.provenance["effort_at"] = effort_at if isinstance(effort_at, str) else dict(effort_at)
    return result
