"""The command `rattle wear`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from rattle.cli.options import time
from rattle.cli.output import STOPPED
from rattle.cli.question_command import Asked, Shown, Written, json_option, model_command, picture_option

if TYPE_CHECKING:
    from rattle.questions.wear.worn import Worn


@model_command
@click.option("--cycles", type=float, metavar="N", help="How many cycles.  [default: as in the model]")
@click.option("--cycle", type=time, metavar="TIME", help="Duration of a cycle.  [default: one turn of the driver]")
@click.option(
    "--jump", metavar="N", help="Cycles of a jump, or auto: as many as keep its error below 1 % of the depth.",
)  # fmt: skip
@click.option("--depth", metavar="LENGTH", help='Stop where a surface is worn as deep as this, "0.1 mm".')
@click.option(
    "-o", "--output", "folder", metavar="FOLDER", help="Keep the study here after every jump; the same call goes on."
)
@picture_option("Draw profiles and history (.svg, .png, .pdf).", "--plot")
@json_option("The answer as JSON, in SI units.")
def wear(
    asked: Asked, cycles: float | None, cycle: float | None, jump: str | None, depth: str | None, folder: str | None
) -> Shown:
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
    if asked.ideal:
        raise click.UsageError("--ideal closes every clearance: nothing would wear; leave it out")
    stop = {} if depth is None else {"depth": _depth(depth)}
    worn = asked.model().wear(cycles, _jump(jump), cycle, stop, folder, progress=asked.progress)
    study = () if folder is None else (Written(folder, lambda path: None),)  # it was kept after every jump
    files = (*asked.drawn(worn.plot), *study)
    return Shown(lambda: str(worn), lambda: _record(worn), files, status=STOPPED if worn.interrupted else 0)


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


def _record(worn: Worn) -> dict[str, object]:
    sides = {
        f"{joint}.{name}": {"volume": side.volume, "depth": side.deepest, "at": side.angle[side.depth.argmax()]}
        for joint in worn.joints
        for name, side in zip(("bush", "pin"), worn.profile(joint), strict=True)
    }
    limiting = ".".join(worn.limiting)
    return {"cycles": worn.cycles, "outcome": worn.outcome, "limiting": limiting, **sides, "trust": list(worn.trust)}
