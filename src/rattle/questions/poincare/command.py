"""The command `rattle poincare`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from rattle.cli.command import Command
from rattle.cli.options import model_options, read_model, shows_progress
from rattle.cli.output import STOPPED, beside, check_pictures, say_written

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism


@click.command(cls=Command)
@model_options
@click.option("--contact", metavar="NAME", help="Contact model of every joint with clearance, e.g. impact or exact.")
@click.option(
    "--of",
    "names",
    multiple=True,
    metavar="NAME",
    help="Curve to sample, such as B.ex. Give the option twice for a section, once with --parameter.",
)
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
    "--period",
    metavar="TIME",
    help="Time between two points, in s, as '20 ms' or over parameters as '2*pi/w'; default: one turn of the driver.",
)
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
@click.option(
    "-o",
    "--output",
    "picture",
    metavar="FILE",
    default="poincare.png",
    show_default=True,
    help="Picture (.png, .svg, .pdf).",
)
@click.pass_context
def poincare(
    ctx: click.Context, file: str, settings: tuple[str, ...], ideal: bool, contact: str | None, names: tuple[str, ...],
    parameter: str | None, first: str | None, last: str | None, count: int, period: str | None,
    crossing: str | None, skip: int, points: int, lyapunov: bool, picture: str,
) -> None:  # fmt: skip
    """Poincare section of two curves, or bifurcation diagram of one curve over a parameter.

    FILE is a model file or the name of a shipped example.  Default of --of: ex and ey of the first joint with
    clearance, the position of its pin in its bush.

    \b
    Examples: rattle poincare slider_crank_play --skip 20 --points 60 --lyapunov
              rattle poincare slider_crank_play --of B.ex --parameter c --from "0.2 mm" --to 6e-4 --values 9 --points 20
    """
    import numpy as np

    from rattle.plots.curves import save_figure

    check_pictures(file, picture)
    m = read_model(file, settings, ideal)
    if contact is not None:
        m = m.with_contact(contact)
    curves = _curves(m, names, parameter is None)
    interrupted = early = False
    if parameter is not None:
        if first is None or last is None:
            raise click.UsageError("--parameter needs --from and --to")
        low, high = (_amount(m, parameter, text, at) for text, at in ((first, "--from"), (last, "--to")))
        diagram = m.bifurcation(
            parameter, np.linspace(low, high, count), curves[0], period=period, skip=skip, points=points,
            progress=shows_progress(ctx),
        )  # fmt: skip
        figure, interrupted = diagram.plot(), diagram.interrupted
        click.echo(diagram.rule)
    else:
        if len(curves) < 2:
            raise click.UsageError("a section needs two curves, --of NAME --of NAME; a bifurcation needs --parameter")
        section = m.poincare(*curves, period=period, crossing=crossing, skip=skip, points=points)
        interrupted = section.interrupted
        click.echo(f"{len(section.t)} points, {section.rule}")
        if not len(section.t):
            ctx.exit(STOPPED)
        figure, early = section.plot(curves[0], curves[1]), bool(section.message)
    if interrupted:
        picture = beside(picture)
    elif lyapunov and not early:
        click.echo(str(m.lyapunov()))
    save_figure(figure, picture)
    say_written(picture)
    if interrupted or early:
        ctx.exit(STOPPED if interrupted else 1)


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
