"""The command `rattle bearing-moments`."""

from __future__ import annotations

import click

from rattle.cli.question_command import Asked, Shown, json_option, model_command
from rattle.questions.strength.moved import by_suffix, motion_options, moved


@model_command
@click.option("--of", "joint", metavar="JOINT", required=True, help="The bearing: a pin, a guide, a slot or fixed.")
@motion_options
@click.option("-o", "--output", metavar="FILE", help="Picture (.svg, .png, .pdf) or table (.csv, SI units) over time.")
@json_option("All curves as JSON, in SI units.")
def bearing_moments(asked: Asked, joint: str, analysis: str, t_end: float | None, points: int) -> Shown:
    """How a bearing is tilted, because bodies move in planes beside each other.

    FILE is a model file or the name of a shipped example. Offsets of the planes of bodies, and of the middles of
    joints, are their z; the ground is at 0, and a joint without z half way between its bodies. With the length of the
    bearing the load of its edge is known: F/2 + M/length at most.

    \b
    [bodies.crank]
    z = "12 mm"
    [joints.O]
    z = 0
    length = "20 mm"

    \b
    Example:  rattle bearing-moments piston_engine --of A -o moments.svg

    In a closed loop bearings share the moments by their stiffness, taken as equal; then it says so.
    """
    from rattle.results.display import in_columns

    asked = by_suffix(asked, "moments are")
    m = asked.model()
    result = moved(asked, m, analysis, t_end, points)
    b = result.bearing_moments(joint)

    def record() -> dict[str, object]:
        curves = {name: getattr(b, name) for name in ("t", "fx", "fy", "mx", "my", "edge_load")}
        return {"joint": joint, "determinate": b.determinate, "tilt": b.tilt, **curves, "remarks": list(b.remarks)}

    return Shown(
        lambda: "\n".join([f"{joint}, {len(b.t)} instants", *in_columns(b.told()), *b.remarks]), record,
        (*asked.tabled(lambda: b.table), *asked.drawn(b.plot)), result=result,
    )  # fmt: skip
