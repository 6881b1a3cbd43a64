"""The command `rattle poincare`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from rattle.cli.options import contact_option
from rattle.cli.output import STOPPED, beside
from rattle.cli.question_command import Asked, Shown, json_option, model_command, picture_option

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism

SECTION = ("rule", "t", "values", "units", "interrupted", "message")  # what JSON holds of a section
DIAGRAM = (
    "rule",
    "parameter",
    "parameter_unit",
    "values",
    "of",
    "of_unit",
    "points",
    "interrupted",
    "how",
)  # of a diagram


@model_command
@contact_option
@click.option(
    "--of", "names", multiple=True, metavar="NAME",
    help="Curve to sample, such as B.ex. Give the option twice for a section, once with --parameter.",
)  # fmt: skip
@click.option(
    "--parameter", metavar="NAME",
    help="Draw a bifurcation diagram over this parameter, such as c, or over a path such as joints.B.clearance.",
)  # fmt: skip
@click.option("--from", "first", metavar="VALUE", help='First value of the parameter, in SI or as "0.2 mm".')
@click.option("--to", "last", metavar="VALUE", help='Last value of the parameter, in SI or as "0.6 mm".')
@click.option(
    "--values", "count", default=100, show_default=True, help="Number of values, evenly spaced from --from to --to."
)
@click.option(
    "--period", metavar="TIME",
    help="Time between two points, in s, as '20 ms' or over parameters as '2*pi/w'; default: one turn of the driver.",
)  # fmt: skip
@click.option(
    "--crossing", metavar="NAME", help="Take a point whenever this curve rises through zero, not once per --period."
)
@click.option(
    "--skip", default=50, show_default=True, help="Number of points left out at the start, while transients decay."
)
@click.option(
    "--points", default=200, show_default=True, help="Number of points kept; with --parameter, at every value."
)
@click.option("--lyapunov", is_flag=True, help="Also print the largest Lyapunov exponent [1/s], with its uncertainty.")
@picture_option("Picture (.png, .svg, .pdf).", usual="poincare.png")
@json_option("All points as JSON, in SI units.")
def poincare(
    asked: Asked, contact: str | None, names: tuple[str, ...], parameter: str | None, first: str | None,
    last: str | None, count: int, crossing: str | None, lyapunov: bool, **points: Any,
) -> Shown:  # fmt: skip
    """Poincare section of two curves, or bifurcation diagram of one curve over a parameter.

    FILE is a model file or the name of a shipped example.  Default of --of: ex and ey of the first joint with
    clearance, the position of its pin in its bush.

    \b
    Examples: rattle poincare slider_crank_play --skip 20 --points 60 --lyapunov
              rattle poincare slider_crank_play --of B.ex --parameter c --from "0.2 mm" --to 6e-4 --values 9 --points 20
    """
    import numpy as np

    m = asked.model()
    if contact is not None:
        m = m.with_contact(contact)
    curves = _curves(m, names, parameter is None)
    record: dict[str, object]
    if parameter is not None:
        if first is None or last is None:
            raise click.UsageError("--parameter needs --from and --to")
        low, high = (_amount(m, parameter, text, at) for text, at in ((first, "--from"), (last, "--to")))
        diagram = m.bifurcation(parameter, np.linspace(low, high, count), curves[0], progress=asked.progress, **points)
        words, draw, interrupted, early = diagram.rule, lambda: diagram.plot(), diagram.interrupted, False
        record = {name: getattr(diagram, name) for name in DIAGRAM}
    else:
        if len(curves) < 2:
            raise click.UsageError("a section needs two curves, --of NAME --of NAME; a bifurcation needs --parameter")
        section = m.poincare(*curves, crossing=crossing, **points)
        words = f"{len(section.t)} points, {section.rule}"
        draw, interrupted, early = (
            lambda: section.plot(curves[0], curves[1]),
            section.interrupted,
            bool(section.message),
        )
        record = {name: getattr(section, name) for name in SECTION}
        if not len(section.t):
            return Shown(lambda: words, lambda: record, status=STOPPED)
    if interrupted:
        asked = asked._replace(picture=beside(str(asked.picture)))
    elif lyapunov and not early:
        exponent = m.lyapunov()
        words, record = f"{words}\n{exponent}", record | {"lyapunov": exponent._asdict()}
    status = STOPPED if interrupted else int(early)
    return Shown(lambda: words, lambda: record, asked.drawn(draw), status=status)


def _curves(m: Mechanism, names: tuple[str, ...], section: bool) -> tuple[str, ...]:
    """The curves to sample: those named, or where the first pin with clearance is.  Raises click.UsageError."""
    if len(names) > (2 if section else 1):
        drawn = "a section takes two curves" if section else "a diagram over --parameter takes one curve"
        raise click.UsageError(f"--of is given {len(names)} times; {drawn}")
    loose = [name for name, joint in m.model.joints.items() if joint.clearance > 0.0]
    if not names and not loose:
        raise click.UsageError("name the curves to sample: --of NAME --of NAME")
    return names or (f"{loose[0]}.ex", f"{loose[0]}.ey")


def _amount(m: Mechanism, parameter: str, text: str, option: str) -> float:
    """A value of a parameter in SI units, from a number or a quantity of the parameter's dimension."""
    from rattle.language.units import QuantityError, describe, dimension_of, parse_quantity

    try:
        amount = parse_quantity(text)
    except QuantityError as error:
        raise click.UsageError(f"{option}: {error}") from None
    if amount is None:
        raise click.UsageError(
            f'{option}: {text!r} is not a value; expected a number in SI or a quantity such as "0.2 mm"'
        )
    declared = m.model.parameters.get(parameter)
    if declared is not None and amount[1] is not None and amount[1] != dimension_of(declared.unit):
        wanted = describe(dimension_of(declared.unit))
        raise click.UsageError(f"{option}: '{text}' is {describe(amount[1])}; '{parameter}' is {wanted}")
    return amount[0]
