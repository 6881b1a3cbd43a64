"""Commands that show: demo, draw, plot, animate."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rattle.answers.arguments import listed
from rattle.cli.command import Command
from rattle.cli.measured import measured_option, say_residual
from rattle.cli.options import page_options, read_result, settings_option
from rattle.cli.output import check_files, check_pictures, say_written

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from rattle.exchange.residuals import Residual
    from rattle.results.result import Result


@click.command(cls=Command)
@click.option(
    "-o", "--output", metavar="FOLDER", default="rattle-demo", show_default=True, help="Folder for the files."
)
@click.option("--paper", is_flag=True, help="Instead the four-bar of the paper: its Figures 3 to 12, orbits, CSV, GIF.")
@click.option("--why", "-v", is_flag=True, help="Say why the result can be trusted so far.")
def demo(output: str, paper: bool, why: bool) -> None:
    """What two loose pins do to a crank-rocker: a short table, a picture, a page with sliders, CSV.

    \b
    Examples: rattle demo
              rattle demo --paper -o pictures
    """
    if paper:
        from rattle.plots.paper_page import run_demo
    else:
        from rattle.plots.demo_page import run_demo

    paths, text = run_demo(output, why=why)
    click.echo(text)
    for path in paths:
        click.echo(f"  {path}")


@click.command(cls=Command)
@click.argument("result")
@click.argument("names", nargs=-1)
@click.option(
    "--orbit", multiple=True, metavar="JOINT", help="Draw the path of the pin of this joint in its clearance circle."
)
@click.option(
    "--xy", multiple=True, metavar="POINT", help="Draw the path of a point, or of a body's mass centre, e.g. coupler.P."
)
@click.option("--over", metavar="NAME", help="Put this curve on the horizontal axis, e.g. crank.angle; default: time.")
@click.option("--spectrum", is_flag=True, help="Draw the amplitude spectra of the curves instead.")
@click.option("--compare", multiple=True, metavar="[LABEL=]FILE", help="Another saved result, whose curves are dashed.")
@measured_option
@settings_option
@click.option(
    "--robust", is_flag=True, help="Leave rare spikes out of the range of the axis; a note says how far they reach."
)
@click.option(
    "-o",
    "--output",
    metavar="FILE",
    default=None,
    help="Picture to write (.png, .svg, .pdf); default: RESULT.png, and RESULT-JOINT.png, RESULT-path.png or "
    "RESULT-spectrum.png for orbits, paths and spectra.",
)
def plot(
    result: str, names: tuple[str, ...], orbit: tuple[str, ...], xy: tuple[str, ...], over: str | None,
    spectrum: bool, compare: tuple[str, ...], measured: tuple[str, ...], settings: tuple[str, ...], robust: bool,
    output: str | None,
) -> None:  # fmt: skip
    """Plot curves, their spectra, paths of points or pin orbits of a saved result; without NAMES lists all names.

    \b
    Example:  rattle plot out.nc O3.normal O4.normal -o forces.svg
              rattle plot out.nc motor.torque --over crank.angle
              rattle plot out.nc rocker.angle --compare "no play=ideal.nc"
              rattle plot out.nc rocker.angle --with measured.csv:theta@5ms
              rattle plot out.nc O3.fx O3.fy --spectrum
              rattle plot out.nc --xy coupler.O3
              rattle plot out.nc --orbit O3
    """
    from rattle.plots.curves import save_figure

    read = Path(result)
    target = Path(output) if output else read.with_suffix(".png") if read.name else Path("result.png")
    drawn = bool(names or orbit or xy or measured)
    _require_names(result, {"--orbit": orbit, "--xy": xy, "--over": (over or "",)})
    if output and not drawn:
        raise click.UsageError(f"name what to draw; `rattle plot {result}` lists all names")
    _require_curves(names, measured, over, spectrum, bool(compare), robust)
    if not drawn:
        _list_names(read_result(result, settings))
        return
    check_pictures(result, target)
    loaded = read_result(result, settings)
    beside = loaded.residuals(measured, names)
    drawing = _curves(loaded, names, over, spectrum, compare, beside, robust) if names or measured else None
    figures = [*_figures(loaded, target, drawing, "spectrum" * spectrum, orbit, xy, output is not None)]
    for part in beside:
        say_residual(loaded, part)
    for figure, path in figures:  # nothing is written if one of them cannot be drawn
        save_figure(figure, path)
        say_written(path)


def _curves(
    loaded: Result, names: tuple[str, ...], over: str | None, spectrum: bool, compare: tuple[str, ...],
    beside: Sequence[Residual], robust: bool,
) -> Callable[[], Figure]:  # fmt: skip
    """What draws curves or their spectra, with those of other results; beside: measured ones."""
    others = [(label, read_result(file)) for label, file in map(_labelled, compare)]
    if spectrum:
        return partial(loaded.plot_spectrum, *names, compare=others)
    return partial(loaded.plot, *names, over=over, compare=others, robust=robust, measured=beside)


def _list_names(loaded: Result) -> None:
    """Print the names of all curves with their units."""
    for name in loaded.names:
        click.echo(f"{name}  [{loaded.unit(name) or '-'}]")


def _figures(
    loaded: Result, target: Path, curves: Callable[[], Figure] | None, word: str, orbit: tuple[str, ...],
    xy: tuple[str, ...], to_file: bool,
) -> Iterator[tuple[Figure, Path]]:  # fmt: skip
    """Figures and where they go: what is drawn alone into a file that is named goes there, others beside it.

    curves: draws curves, whose file has `word` behind its name.
    """
    alone = to_file and (curves is not None) + bool(xy) + len(orbit) == 1

    def beside(word: str) -> Path:
        return target if alone or not word else target.with_stem(f"{target.stem}-{word}")

    if curves is not None:
        yield curves(), beside(word)
    if xy:
        yield loaded.plot_path(*xy), beside("path")
    for joint in orbit:
        yield loaded.plot_orbit(joint), beside(joint)


def _require_names(result: str, chosen: dict[str, tuple[str, ...]]) -> None:
    """Raise click.UsageError for an option that has swallowed another one in place of a name."""
    for option, names in chosen.items():
        if any(name.startswith("-") for name in names):
            raise click.UsageError(f"{option} needs a name; `rattle plot {result}` lists all names")


def _require_curves(
    names: tuple[str, ...], measured: tuple[str, ...], over: str | None, spectrum: bool, compare: bool, robust: bool
) -> None:
    """Raise click.UsageError for options of curves without curves, and for those that do not go together."""
    options = {"--over": over is not None, "--spectrum": spectrum, "--compare": compare, "--robust": robust}
    for option, used in options.items():
        if used and not (names or measured):
            raise click.UsageError(f"{option} needs curves to draw: rattle plot RESULT NAME... {option}")
    if spectrum and (over is not None or robust):
        raise click.UsageError("--spectrum has the frequency on its horizontal axis; leave --over and --robust out")
    if spectrum and measured:
        raise click.UsageError("--spectrum has the frequency on its horizontal axis; leave --with out")


def _labelled(text: str) -> tuple[str, str]:
    """Label and file of LABEL=FILE; the name of the file without its suffix if there is no label."""
    label, equals, file = text.partition("=")
    return (label.strip(), file.strip()) if equals and not Path(text).exists() else (Path(text).stem, text)


@click.command(cls=Command)
@click.argument("result")
@click.option(
    "-o",
    "--output",
    metavar="FILE",
    required=True,
    help="Page (.html) or animation to write (.gif; .mp4 if ffmpeg is installed).",
)
@click.option(
    "--frames", default=120, show_default=True,
    help="Largest number of frames, evenly spaced in time and shown at 20 per second.",
)  # fmt: skip
@click.option(
    "--speed",
    type=float,
    help="Speed of the animation relative to the motion: 0.1 is ten times slower. Sets the number of frames in "
    "place of --frames.",
)
@click.option(
    "--trace",
    multiple=True,
    metavar="POINT",
    help="Point whose path is drawn, e.g. coupler.P; may be given more than once.",
)
@settings_option
@page_options
@click.option("--names", is_flag=True, help="Label the bodies with their names.")
@click.option("--power", is_flag=True, help="Arrows through joints, drivers and loads, as wide as their power.")
@click.option("--stress", is_flag=True, help="Bars with section and material in the colour of their stress.")
def animate(
    result: str,
    output: str,
    frames: int,
    speed: float | None,
    trace: tuple[str, ...],
    settings: tuple[str, ...],
    names: bool,
    power: bool,
    stress: bool,
    title: str,
    curves: tuple[str, ...],
    language: str,
) -> None:
    """Animate a saved result, with the pin in its bush magnified beside it.

    A page (.html) is one file that needs no network: play, stop, go back, choose curves and forces, in any browser and
    on a phone.  --title, --curves and --language are for pages, --frames, --power and --stress
    for .gif and .mp4.

    \b
    Example:  rattle animate out.nc -o out.html
              rattle animate out.nc --trace coupler.O3 --frames 40 -o out.gif
    """
    from rattle.plots.movie_file import require_film

    if Path(output).suffix.lower() != ".html":
        require_film(output)
    check_files(result, output)
    read_result(result, settings).animate(
        output, frames=frames, trace=trace, speed=speed, names=names, power=power, stress=stress,
        title=title,
        curves=listed(*curves), language=language,
    )  # fmt: skip
    say_written(output)
