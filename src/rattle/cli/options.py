"""What several commands share: reading a model with --set and --ideal."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

import click

from rattle.pages.words import ENGLISH, LANGUAGES

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism
    from rattle.results.result import Result


def time(value: str | float) -> float:
    """A time on the command line [s]: a number in s, or a quantity such as 20ms or "20 ms".

    Raises click.BadParameter.
    """
    from rattle.language.times import seconds

    try:
        return seconds(value, "time")
    except ValueError as error:
        raise click.BadParameter(str(error).removeprefix("time: ")) from None


def value(text: str) -> float | str:
    """A number in SI, or a text with a unit."""
    try:
        return float(text)
    except ValueError:
        return text.strip()


def given(ctx: click.Context, name: str) -> bool:
    """True if the option was written on the command line, also with its default value."""
    return ctx.get_parameter_source(name) == click.core.ParameterSource.COMMANDLINE


def shows_progress(ctx: click.Context) -> bool:
    """True where somebody sees how far the work has come: at a terminal, and not with -q."""
    return not ctx.obj["quiet"] and sys.stderr is not None and sys.stderr.isatty()


class LateOption(click.Option):
    """An option whose help text is made when it is shown, so that the modules it needs are not imported before."""

    def __init__(self, *args: Any, words: Callable[[], str], **more: Any) -> None:
        super().__init__(*args, **more)
        self.words = words

    def get_help_record(self, ctx: click.Context) -> tuple[str, str] | None:
        """The option as it is written, and its help."""
        self.help = self.words()
        return super().get_help_record(ctx)


def _leave_out(ctx: click.Context, param: click.Parameter, paths: tuple[str, ...]) -> None:
    ctx.meta["rattle.without"] = paths


def _note_laws(ctx: click.Context, param: click.Parameter, files: tuple[str, ...]) -> None:
    ctx.meta["rattle.laws"] = files


def run_laws(files: Iterable[str]) -> None:
    """Run the files of --laws, and say so."""
    for file in files:
        import logging

        from rattle.elements.custom.law_file import run_law_file

        laws = run_law_file(file)
        logging.getLogger("rattle").info(f"{file}: its Python code was run; laws: {', '.join(laws)}")


contact_option = click.option(
    "--contact", metavar="NAME", help="Contact model of every joint with clearance, e.g. impact or exact."
)
settings_option = click.option(
    "--set", "settings", multiple=True, metavar="NAME=VALUE",
    help="Where a model is given in place of a result: change a parameter or any entry of it; may be given more than"
    " once.",
)  # fmt: skip


def page_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options --title, --curves and --language to a command that writes a page."""
    function = click.option(
        "--language", type=click.Choice(LANGUAGES), default=ENGLISH, show_default=True,
        help="Language of the labels of the page; sentences about trust, notes and errors stay English.",
    )(function)  # fmt: skip
    function = click.option(
        "--curves", multiple=True, metavar="NAME,NAME",
        help="Curves that the page shows at first; several with commas, or give the option again.",
    )(function)  # fmt: skip
    return click.option("--title", default="", help="What stands above the page; default: the name of the model.")(
        function
    )


def model_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """Add the argument FILE and the options --set, --without, --ideal and --laws to a command."""
    function = click.option(
        "--laws", multiple=True, metavar="FILE.py", expose_value=False, callback=_note_laws,
        help="Run this Python file, which defines loads or contact laws of your own (@rt.load_law); may be given more"
        " than once.",
    )(function)  # fmt: skip
    function = click.option(
        "--without", multiple=True, metavar="PATH", expose_value=False, callback=_leave_out,
        help="Leave out one entry of the model, e.g. loads.M or drivers.motor, with the path or its name alone; may be"
        " given more than once.",
    )(function)  # fmt: skip
    function = click.option("--ideal", is_flag=True, help="No play: every clearance is set to zero.")(function)
    function = click.option(
        "--set", "settings", multiple=True, metavar="NAME=VALUE",
        help='Change a parameter (--set r3="2 mm") or any entry (--set joints.O3.contact=ideal); '
        "may be given more than once.",
    )(function)  # fmt: skip
    return click.argument("file", metavar="FILE")(function)


def _value(text: str, setting: str) -> Any:
    """A value as in a model file: a number, true or false, a table or list, a text also without quotes."""
    import tomllib

    if text.startswith(("{", "[", '"', "'")) or text in ("true", "false"):
        try:
            return tomllib.loads(f"value = {text}")["value"]
        except tomllib.TOMLDecodeError as error:
            what = "text in quotes" if text[0] in "\"'" else "table or list"
            raise click.UsageError(f"--set {setting}: {error}; expected a {what} as in a model file") from None
    try:
        return float(text)
    except ValueError:
        return text


def read_model(file: str, settings: tuple[str, ...], ideal: bool) -> Mechanism:
    """The model in a file, or the shipped example of that name if there is no such file, with the changes asked for.

    Raises click.UsageError, ModelError.
    """
    run_laws(click.get_current_context().meta.get("rattle.laws", ()))
    m = _model(file)
    changes = _changes(settings) | dict.fromkeys(click.get_current_context().meta.get("rattle.without", ()))
    if changes:
        m = m.set(changes)
    return m.ideal() if ideal else m


def _changes(settings: tuple[str, ...]) -> dict[str, Any]:
    """What --set changes, and to which values.  Raises click.UsageError."""
    changes: dict[str, Any] = {}
    for setting in settings:
        name, equals, value = setting.partition("=")
        if not equals:
            raise click.UsageError(f"--set needs NAME=VALUE, got '{setting}'")
        changes[name.strip()] = _value(value.strip(), setting)
    return changes


def _model(file: str) -> Mechanism:
    """The model in a file, or the shipped example of that name if there is no such file.

    Raises click.UsageError, ModelError.
    """
    from pathlib import Path

    from rattle.loading import example, examples, load
    from rattle.user_paths import expanded

    shipped = examples()
    if file not in shipped and not expanded(file).exists() and Path(file).suffix == "":
        from rattle.errors import suggest

        raise click.UsageError(f"there is no file {file!r} and no example of that name{suggest(file, shipped)}")
    return example(file) if file in shipped and not Path(file).exists() else load(file)


def read_result(file: str, settings: tuple[str, ...] = ()) -> Result:
    """A saved result; of a model file or the name of a shipped example, the motion that `rattle run` computes.

    settings: changes of the model, as --set has them.

    Raises click.UsageError, ModelError, InputError.
    """
    import logging
    from pathlib import Path

    from rattle.results.result import load_result

    if Path(file).suffix.lower() not in ("", ".toml", ".json") or (Path(file).suffix == "" and Path(file).exists()):
        if settings:
            raise click.UsageError(f"--set changes a model, and {file} is a saved result; run its model with --set")
        return load_result(file)
    m = read_model(file, settings, False)
    log = logging.getLogger("rattle")
    words = shlex.join(
        ["rattle", "run", file, *(word for text in settings for word in ("--set", text)), "-o", "out.nc"]
    )
    log.info(f"{file}: a model, which is run now; `{words}` keeps its motion")
    result = m.simulate(progress=shows_progress(click.get_current_context()))
    if not result.success:
        log.warning(f"stopped: {result.message}")
    return result


def only_oiled(m: Mechanism) -> str:
    """The joint with oil.  Raises click.UsageError if there is none, or more than one."""
    oiled = [
        name for name, joint in m.model.joints.items() if joint.contact is not None and joint.contact.film is not None
    ]
    if len(oiled) == 1:
        return oiled[0]
    if oiled:
        raise click.UsageError(f"--joint says which of the joints with oil: {', '.join(oiled)}")
    words = 'this needs a joint with oil: contact = { model = "lubricated", viscosity, length, bush_radius }'
    raise click.UsageError(words)
