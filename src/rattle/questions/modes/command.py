"""The command `rattle modes`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import click

from rattle.cli.command import Command
from rattle.cli.instants import at_option, effort_option
from rattle.cli.options import model_options, read_model
from rattle.cli.output import as_json as to_json
from rattle.cli.output import check_pictures, say_written
from rattle.cli.requirements import (
    check_required,
    finish_required,
    judge,
    require_option,
)
from rattle.questions.equilibrium.listing import entry

if TYPE_CHECKING:
    from rattle.cli.requirements import Verdict
    from rattle.mechanism import Mechanism
    from rattle.questions.modes.compute import Modes


@click.command(cls=Command)
@model_options
@at_option
@effort_option
@require_option
@click.option(
    "--mode", type=click.IntRange(1), default=1, show_default=True,
    help="Which mode -o draws; 1 has the lowest frequency.",
)  # fmt: skip
@click.option(
    "-o", "--output", metavar="FILE", help="Draw the mode: .svg, .png or .pdf; .gif or .mp4 for an animation."
)
@click.option("--json", "as_json", is_flag=True, help="Everything as JSON.")
@click.pass_context
def modes(
    ctx: click.Context, file: str, settings: tuple[str, ...], ideal: bool, t: float, effort: float,
    required: tuple[str, ...], mode: int, output: str | None, as_json: bool,
) -> None:  # fmt: skip
    """Natural frequencies about the first equilibrium.

    FILE is a model file or the name of a shipped example.  A mode that an oil film makes grow is named as oil whirl,
    with its frequency over the turning speed.  --require asks for mode1.frequency, mode1.damping or mode1.growth.

    \b
    Examples: rattle modes balanced_arm -o mode.svg
              rattle modes balanced_arm --require "final(mode1.frequency) >= 0.2 Hz"
    """
    from rattle.plots.curves import SUFFIXES, save_figure

    check_pictures(file, output, moving=True)
    m = read_model(file, settings, ideal)
    check_required(m, required, "modes", t or None)
    answer = m.modes(t, effort=effort)
    if len(answer) < mode and (output is not None or mode > 1):
        raise click.UsageError(f"--mode {mode}: the modes are numbered from 1 to {len(answer)}")
    verdicts = _judge_modes(m, t, answer, required) if required else []
    if as_json:
        asked = {"required": [verdict.record for verdict in verdicts]} if verdicts else {}
        click.echo(to_json(modes_record(answer) | asked))
    else:
        click.echo(f"about: {answer.about}")
        click.echo(str(answer))
    if output is not None:
        if output.lower().endswith(SUFFIXES):
            save_figure(answer.plot(mode - 1), output)
        else:
            answer.animate(mode - 1, output)
        if not as_json:
            say_written(output)
    finish_required(ctx, verdicts, None if as_json else click.echo)


def _judge_modes(m: Mechanism, t: float, answer: Modes, required: Sequence[str]) -> list[Verdict]:
    """Whether the modes keep what is required."""
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
