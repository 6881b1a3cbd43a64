"""The command `rattle`: a group of commands, each imported from its module in `rattle.cli` when it is called."""

from __future__ import annotations

import importlib
import logging
import os
import sys
from functools import partial
from keyword import iskeyword
from typing import Any

import click

from rattle.errors import ANSWERS, InputError, SolverError, shown
from rattle.question import questions
from rattle.studies.runs.ctrl_c import raised_again

STOPPED = 130  # exit status after Ctrl-C, as shells have it

# commands that are no questions: module in rattle.cli, line of `rattle --help`, place among all
OTHERS = {
    "demo": ("show", 10, "What two loose pins do to a crank-rocker: a table, a picture, a page with sliders, CSV."),
    "example": ("files", 20, "List the shipped examples, or print one as a model file."),
    "import": ("import_", 25, "Read a mechanism of FreeCAD, Ondsel, PMKS+, pylinkage, or a DXF drawing."),
    "studio": ("studio", 60, "A page on this computer in which one turns knobs, looks, analyses and writes the model."),
    "plot": ("show", 190, "Plot curves, spectra, paths of points or pin orbits of a saved result."),
    "animate": ("show", 200, "Animate a saved result (GIF or MP4)."),
    "page": ("page", 210, "One web page that computes: turn a parameter, the motion follows; no server, no internet."),
    "report": (
        "report", 260,
        "A report to hand on, as a page or PDF: model, assumptions, motion, forces, and how far to trust them.",
    ),
    "export": ("files", 270, "Write a saved result as CSV, or in the other result format."),
    "code": ("code", 280, "Write a mechanism without contacts as a C program."),
    "fit": ("named", 284, "Play of a pin in its bush by a fit of ISO 286, such as H7/g6 of 8 mm."),
    "oil": ("named", 286, "Viscosity of an oil over temperature, by its grade, such as ISO VG 46."),
    "kinds": (
        "files", 290, "Reference: every joint, driver, contact and load with its fields; units, functions, materials.",
    ),
    "schema": ("files", 300, "JSON Schema of model files, for editors."),
    "warmup": ("warmup", 310, "Compile all kernels now, so that the first run is quick."),
}  # fmt: skip
try:
    ASKED = {question.command: question for question in questions().values() if question.command}
    if taken := sorted(ASKED.keys() & OTHERS):
        raise InputError(
            f"question '{ASKED[taken[0]].name}': there is a command {taken[0]} already; give another one by command="
        )
except InputError as refused:  # a folder of one's own that is not there, or does not hold what it should
    sys.stderr.write(f"error: {refused}\n")
    raise SystemExit(2) from None
# every command in its order, with its line of `rattle --help`
HELP = {
    name: words
    for _, name, words in sorted(
        [(order, name, words) for name, (_, order, words) in OTHERS.items()]
        + [(question.order, name, question.asks) for name, question in ASKED.items()]
    )
}
COMMANDS = tuple(HELP)
# what commands are called elsewhere, or in Python
ELSEWHERE = {
    "lyapunov": "poincare FILE --lyapunov",
    "bifurcation": "poincare FILE --parameter NAME",
    "simulate": "run FILE",
    "vibrations": "modes FILE",
}


UNITS = (
    "Units of the numbers printed, drawn and written as CSV, such as mm,deg,N; si: all in SI. Others stay as they are;"
    " JSON is in SI."
)
WITH_UNITS = ("plot", "export", "report", *(name for name, question in ASKED.items() if question.shows_quantities))
QUIET = "No progress bar and no log messages, only results."
VERSION = "Show the version, and what compiles kernels."


class Lazy(click.Group):
    """A group that imports a command's module only when the command is called or asked for help."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        if name not in COMMANDS:
            return None
        command = _command(name)
        if not any("--quiet" in option.opts for option in command.params):
            quiet = click.Option(["-q", "--quiet"], is_flag=True, expose_value=False, callback=_quieten, help=QUIET)
            command.params.append(quiet)
            if name in WITH_UNITS:
                units = click.Option(["--units"], metavar="UNITS", expose_value=False, callback=_set_units, help=UNITS)
                command.params.append(units)
        return command

    def resolve_command(self, ctx: click.Context, args: list[str]) -> Any:
        if args and args[0] not in COMMANDS and not args[0].startswith("-"):
            from rattle.errors import suggest

            hint = f"; it is `rattle {ELSEWHERE[args[0]]}`" if args[0] in ELSEWHERE else suggest(args[0], COMMANDS)
            raise click.UsageError(f"no command '{args[0]}'{hint}", ctx)
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl([(name, HELP[name]) for name in COMMANDS])

    def make_context(self, *args: Any, **options: Any) -> click.Context:
        """As in click, but Ctrl-C while it parses gives the exit status that shells use."""
        try:
            return super().make_context(*args, **options)
        except (KeyboardInterrupt, click.Abort) as stop:
            if not _by_ctrl_c(stop):
                raise
            click.echo("stopped", err=True)
            raise click.exceptions.Exit(STOPPED) from None

    def invoke(self, ctx: click.Context) -> Any:
        try:
            return super().invoke(ctx)
        except (click.ClickException, click.exceptions.Exit):
            raise
        except (KeyboardInterrupt, click.Abort) as stop:
            if not _by_ctrl_c(stop):
                raise
            click.echo("stopped", err=True)
            ctx.exit(STOPPED)
        except Exception as error:
            if isinstance(error, BrokenPipeError) or not isinstance(error, ANSWERS):
                raise
            click.secho("error: ", fg="red", nl=False, err=True)
            click.echo(shown(str(error)), err=True)
            ctx.exit(1 if isinstance(error, SolverError) else 2)

    def main(self, *args: Any, **options: Any) -> Any:
        """As in click, but Ctrl-C is never lost and gives the exit status that shells use; streams may be closed."""
        _open_streams()
        try:
            with raised_again():
                return super().main(*args, **options)
        except click.Abort as stopped:  # only where click is asked to leave the exit to its caller
            if isinstance(stopped.__cause__, KeyboardInterrupt):
                raise KeyboardInterrupt from None
            raise
        except SystemExit as end:
            context = end.__context__
            if isinstance(context, click.Abort) and isinstance(context.__cause__, KeyboardInterrupt):
                raise SystemExit(STOPPED) from None
            raise


def _command(name: str) -> click.Command:
    """A command; that of a question is the one of its folder, or made from its signature."""
    if name in OTHERS:
        module = importlib.import_module(f"rattle.cli.{OTHERS[name][0]}")
    elif (own := ASKED[name].part("command")) is not None:
        module = own
    else:
        from rattle.cli.asked import command_of

        return command_of(ASKED[name])
    word = name.replace("-", "_")
    command: click.Command = getattr(module, f"{word}_" if iskeyword(word) else word)
    return command


def _by_ctrl_c(stop: BaseException) -> bool:
    """True unless a question was left otherwise: click answers Ctrl-C at one with an Abort that hides it."""
    return isinstance(stop, KeyboardInterrupt) or isinstance(stop.__context__, KeyboardInterrupt)


def _open_streams() -> None:
    """Open a closed stream (`2>&-`) on the null device, before a file that is opened takes its number."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115  # as long as the program


def _quieten(ctx: click.Context, param: click.Parameter, quiet: bool) -> None:
    """Switch off log messages; -q may stand before or after the command."""
    if quiet:
        ctx.ensure_object(dict)["quiet"] = True
        for handler in logging.getLogger("rattle").handlers:
            handler.setLevel(logging.ERROR)


def _set_units(ctx: click.Context, param: click.Parameter, units: str | None) -> None:
    """Units for all that this command writes."""
    if units is None:
        return
    from rattle.results.chosen_units import choose, read_units

    before = choose(read_units(units))
    ctx.meta["rattle.units"] = units
    ctx.call_on_close(partial(choose, before))


def _show_version(ctx: click.Context, param: click.Parameter, wanted: bool) -> None:
    if not wanted:
        return
    from rattle.jit import mode
    from rattle.version import __version__

    click.echo(f"rattle, version {__version__}")
    click.echo(mode.described())
    ctx.exit()


class _Colours(logging.Formatter):
    def format(self, record: logging.LogRecord) -> str:
        text = super().format(record)
        return click.style(text, fg="yellow") if record.levelno >= logging.WARNING else text


@click.group(cls=Lazy, context_settings={"help_option_names": ["-h", "--help"]})
@click.option("--version", is_flag=True, is_eager=True, expose_value=False, callback=_show_version, help=VERSION)
@click.option("-q", "--quiet", is_flag=True, help=QUIET)
@click.pass_context
def main(ctx: click.Context, quiet: bool) -> None:
    """Planar mechanisms whose joints have play.

    \b
    rattle demo                      what two loose pins do, into ./rattle-demo
    rattle example fourbar > f.toml  start from a shipped model file
    rattle check f.toml              is it assembled as meant?
    rattle draw f.toml               a picture of it, everything by name
    rattle run f.toml -o out.nc      motion, forces, how far to trust them
    rattle plot out.nc O3.normal     draw a curve

    Results go to stdout, log and progress to stderr.
    Exit status: 0 ok, 1 the analysis failed, 2 bad input, 130 interrupted by Ctrl-C.
    """
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(_Colours("%(message)s") if sys.stderr.isatty() else logging.Formatter("%(message)s"))
    log = logging.getLogger("rattle")
    log.handlers[:] = [handler]
    log.setLevel(logging.INFO)
    handler.setLevel(logging.ERROR if quiet else logging.INFO)
    ctx.obj = {"quiet": quiet}
