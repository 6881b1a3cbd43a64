"""The command `rattle modes`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import click

from rattle.cli.instants import at_option, effort_option
from rattle.cli.question_command import Asked, Shown, Written, json_option, model_command, picture_option
from rattle.cli.requirements import check_required, judge, require_option, required_record
from rattle.questions.equilibrium.listing import entry

if TYPE_CHECKING:
    from rattle.cli.requirements import Verdict
    from rattle.mechanism import Mechanism
    from rattle.questions.modes.compute import Modes


@model_command
@at_option
@effort_option
@require_option
@click.option(
    "--mode", type=click.IntRange(1), default=1, show_default=True,
    help="Which mode -o draws; 1 has the lowest frequency.",
)  # fmt: skip
@picture_option("Draw the mode: .svg, .png or .pdf; .gif or .mp4 for an animation.")
@json_option("Everything as JSON.")
def modes(asked: Asked, t: float, effort: float, mode: int) -> Shown:
    """Natural frequencies about the first equilibrium.

    FILE is a model file or the name of a shipped example.  A mode that an oil film makes grow is named as oil whirl,
    with its frequency over the turning speed.  --require asks for mode1.frequency, mode1.damping or mode1.growth.

    \b
    Examples: rattle modes balanced_arm -o mode.svg
              rattle modes balanced_arm --require "final(mode1.frequency) >= 0.2 Hz"
    """
    from rattle.plots.curves import SUFFIXES

    m = asked.model(moving=True)
    check_required(m, asked.required, "modes", t or None)
    answer = m.modes(t, effort=effort)
    if len(answer) < mode and (asked.picture is not None or mode > 1):
        raise click.UsageError(f"--mode {mode}: the modes are numbered from 1 to {len(answer)}")
    verdicts = _judge_modes(m, t, answer, asked.required)
    files = asked.drawn(lambda: answer.plot(mode - 1))
    if asked.picture is not None and not asked.picture.lower().endswith(SUFFIXES):
        files = (Written(asked.picture, lambda path: answer.animate(mode - 1, path)),)
    return Shown(
        lambda: f"about: {answer.about}\n{answer}", lambda: modes_record(answer) | required_record(verdicts), files,
        verdicts,
    )  # fmt: skip


def _judge_modes(m: Mechanism, t: float, answer: Modes, required: Sequence[str]) -> list[Verdict]:
    """Whether the modes keep what is required."""
    if not required:
        return []
    import numpy as np

    from rattle.questions.modes.samples import modes_table

    return judge(modes_table(m, np.array([t]), [answer]), required)


def modes_record(answer: Modes) -> dict[str, Any]:
    """Every mode with its frequencies [Hz], omega [rad/s], growth [1/s], damping ratio, the film whose oil whirl it is,
    roots (real and imaginary parts [1/s]) and shape (x, y [m], angle [rad] of every body, scaled; a quarter of a cycle
    later: minus the imaginary part), the equilibrium, whether any mode grows, and how the matrices were found."""
    bodies = list(answer.equilibrium.result.geometry["bodies"])
    listed = [
        {
            "frequency": answer.frequency[k],
            "damped_frequency": answer.damped_frequency[k],
            "omega": answer.omega[k],
            "growth": answer.growth[k],
            "damping": answer.damping[k],
            "whirl": None if whirl is None else whirl._asdict(),
            "time_constants": answer.time_constants[k].tolist(),
            "roots": [[root.real, root.imag] for root in answer.roots[k]],
            "shape": dict(zip(bodies, answer.shapes[k].reshape(-1, 3).tolist(), strict=True)),
            "imaginary": dict(zip(bodies, answer.vectors[k, 0].imag.reshape(-1, 3).tolist(), strict=True)),
        }
        for k, whirl in enumerate(answer.whirl or (None,) * len(answer))
    ]
    facts = {"grows": bool(answer.growth.any()), "note": answer.note, "how": answer.how}
    return {"modes": listed, "about": answer.about, "equilibrium": entry(answer.equilibrium), **facts}
