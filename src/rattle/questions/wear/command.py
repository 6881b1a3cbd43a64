"""The command `rattle wear`."""

from __future__ import annotations

from typing import Any

import click

from rattle.cli.command import Command
from rattle.cli.options import model_options, read_model, shows_progress, time
from rattle.cli.output import STOPPED, as_json, check_pictures, say_written


@click.command(cls=Command)
@model_options
@click.option("--cycles", type=float, metavar="N", help="How many cycles.  [default: as in the model]")
@click.option("--cycle", type=time, metavar="TIME", help="Duration of a cycle.  [default: one turn of the driver]")
@click.option(
    "--jump", metavar="N", help="Cycles of a jump, or auto: as many as keep its error below 1 % of the depth.",
)  # fmt: skip
@click.option("--depth", metavar="LENGTH", help='Stop where a surface is worn as deep as this, "0.1 mm".')
@click.option("-o", "--output", metavar="FOLDER", help="Keep the study here after every jump; the same call goes on.")
@click.option("--plot", "picture", metavar="FILE", help="Draw profiles and history (.svg, .png, .pdf).")
@click.option("--json", "json_too", is_flag=True, help="The answer as JSON, in SI units.")
@click.pass_context
def wear(
    ctx: click.Context, file: str, settings: tuple[str, ...], ideal: bool, cycles: float | None, cycle: float | None,
    jump: str | None, depth: str | None, output: str | None, picture: str | None, json_too: bool,
) -> None:  # fmt: skip
    """Where pins and bushes wear over many cycles, how deep, and how long they last.

    FILE is a model file or the name of a shipped example.  Joints wear that say how fast:
    wear = { bush = "1e-6 mm^3/(N*m)", pin = 0 }, or { coefficient = 1e-4, hardness = "2 GPa" } in place of the number.

    A cycle is simulated, what it wears is carried over a jump of many cycles, and so on.  With -o the study is kept in
    a folder after every jump: profiles as CSV, the history, and at the end the worn mechanism, worn.toml, which every
    other command reads.  If it is interrupted the same call goes on, to the same numbers.

    \b
    Examples: rattle wear slider_crank_worn --cycles 10 --jump 5
              rattle wear slider_crank_worn --cycles 6 --jump 2 -o worn --plot worn.svg

    A million turns of this example, --cycles 1e6, take some ten seconds.
    """
    check_pictures(file, picture)
    if ideal:
        raise click.UsageError("--ideal closes every clearance: nothing would wear; leave it out")
    m = read_model(file, settings, ideal)
    worn = m.wear(
        cycles, _jump(jump), cycle, {} if depth is None else {"depth": _depth(depth)}, output,
        progress=shows_progress(ctx),
    )  # fmt: skip
    click.echo(as_json(_record(worn)) if json_too else str(worn))
    if picture is not None:
        from rattle.plots.curves import save_figure

        save_figure(worn.plot(), picture)
        say_written(picture)
    if output is not None:
        say_written(output)
    if worn.interrupted:
        ctx.exit(STOPPED)


def _jump(text: str | None) -> float | str | None:
    if text is None or text == "auto":
        return text
    try:
        return float(text)
    except ValueError:
        raise click.BadParameter(f"expected a number of cycles or auto, got '{text}'") from None


def _depth(text: str) -> float:
    from rattle.language.quantities import in_si

    return in_si("--depth", text, "m", '1e-4 or "0.1 mm"')


def _record(worn: Any) -> dict[str, Any]:
    sides = {
        f"{joint}.{name}": {"volume": side.volume, "depth": side.deepest, "at": side.angle[side.depth.argmax()]}
        for joint in worn.joints
        for name, side in zip(("bush", "pin"), worn.profile(joint), strict=True)
    }
    limiting = ".".join(worn.limiting)
    return {"cycles": worn.cycles, "outcome": worn.outcome, "limiting": limiting, **sides, "trust": list(worn.trust)}
