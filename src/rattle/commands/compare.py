"""Commands that look at play as such: compare, poincare."""

from __future__ import annotations

import click

from rattle.commands.options import model_options, read_model, time
from rattle.commands.output import STOPPED, beside, check_pictures, say_written


@click.command()
@model_options
@click.option("--joint", help="The joint to show; default: the first with clearance.")
@click.option("--curve", help="The motion to show, such as rocker.angle; default: that of the last body.")
@click.option("--law", help="Law of the compliant run; default: the joint's own, else exact.")
@click.option("--t-end", type=time, help="Duration, in s or as '20 ms'; default: one turn of the driver.")
@click.option("-o", "--output", default="compare.png", show_default=True, help="Picture (.png, .svg, .pdf).")
@click.pass_context
def compare(
    ctx: click.Context, file: str, settings: tuple[str, ...], ideal: bool, joint: str | None, curve: str | None,
    law: str | None, t_end: float | None, output: str,
) -> None:  # fmt: skip
    """Ideal, massless link, one-sided impact and compliant play on one page: motion, force, orbit, events, energy.

    FILE is a model file or the name of a shipped example.  What a compliant contact needs and the file does not say
    is taken for granted and stated on the page.

    \b
    Example:  rattle compare fourbar -o play.png
    """
    from rattle.plot import save_figure

    check_pictures(file, output)
    found = read_model(file, settings, ideal).compare(
        joint=joint, curve=curve, t_end=t_end, law=law, progress=not ctx.obj["quiet"]
    )
    click.echo(str(found))
    if any(r.interrupted or r.stats.get("horizon_interrupted") for r in found.results.values()):
        ctx.exit(STOPPED)
    save_figure(found.figure(), output)
    say_written(output)
    if not all(r.success for r in found.results.values()):
        ctx.exit(1)


@click.command()
@model_options
@click.option("--contact", metavar="NAME", help="Contact model of every joint with clearance.")
@click.option("--of", "names", multiple=True, metavar="NAME", help="Curve to look at; two of them: a section.")
@click.option("--parameter", help="Parameter to go over; then a bifurcation diagram.")
@click.option("--from", "first", type=float, help="First value of the parameter [SI].")
@click.option("--to", "last", type=float, help="Last value [SI].")
@click.option("--values", "count", default=100, show_default=True, help="Values of the parameter from --from to --to.")
@click.option(
    "--period", type=time, help="Time between two points, in s or as '20 ms'; default: one turn of the driver."
)
@click.option("--crossing", help="Instead: points where this curve rises through zero.")
@click.option("--skip", default=50, show_default=True, help="Points left out at the start.")
@click.option("--points", default=200, show_default=True, help="Points taken per run.")
@click.option("--lyapunov", is_flag=True, help="Also the largest Lyapunov exponent, with its uncertainty.")
@click.option(
    "-o", "--output", "picture", default="poincare.png", show_default=True, help="Picture (.png, .svg, .pdf)."
)
@click.pass_context
def poincare(
    ctx: click.Context, file: str, settings: tuple[str, ...], ideal: bool, contact: str | None, names: tuple[str, ...],
    parameter: str | None, first: float | None, last: float | None, count: int, period: float | None,
    crossing: str | None, skip: int, points: int, lyapunov: bool, picture: str,
) -> None:  # fmt: skip
    """Poincare section of two curves, or bifurcation diagram of one over a parameter.

    FILE is a model file or the name of a shipped example.  Without --of it is the pin of the first joint with
    clearance, ex against ey.

    \b
    Examples: rattle poincare slider_crank_play --skip 20 --points 60 --lyapunov
              rattle poincare slider_crank_play --of B.ex --parameter c --from 2e-4 --to 6e-4 --values 9 --points 20
    """
    import numpy as np

    from rattle.plot import save_figure

    check_pictures(file, picture)
    m = read_model(file, settings, ideal)
    if contact is not None:
        m = m.with_contact(contact)
    loose = [name for name, one in m.model.joints.items() if one.clearance > 0.0]
    curves = names or tuple(f"{loose[0]}.{what}" for what in ("ex", "ey")) if loose or names else ()
    if not curves:
        raise click.UsageError("name the curves to look at: --of NAME --of NAME")
    interrupted = False
    if parameter is not None:
        if first is None or last is None:
            raise click.UsageError("--parameter wants --from and --to")
        found = m.bifurcation(
            parameter, np.linspace(first, last, count), curves[0], period=period, skip=skip, points=points,
            progress=not ctx.obj["quiet"],
        )  # fmt: skip
        figure, interrupted = found.plot(), found.interrupted
        click.echo(found.rule)
    else:
        if len(curves) < 2:
            raise click.UsageError("a section wants two curves: --of NAME --of NAME, or --parameter")
        section = m.poincare(*curves[:2], period=period, crossing=crossing, skip=skip, points=points)
        figure = section.plot(curves[0], curves[1])
        interrupted = section.interrupted
        click.echo(f"{len(section.t)} points, {section.rule}")
    if interrupted:
        picture = beside(picture)
    elif lyapunov:
        click.echo(str(m.lyapunov()))
    save_figure(figure, picture)
    say_written(picture)
    if interrupted:
        ctx.exit(STOPPED)
