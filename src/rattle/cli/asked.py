"""The command of a question, made from its signature and what is declared of its arguments."""

from __future__ import annotations

import inspect
import textwrap
from typing import Any, TypeVar

import click

from rattle.cli.command import Command
from rattle.cli.options import model_options, read_model, read_result, settings_option, shows_progress, time
from rattle.cli.output import as_json, check_pictures, say_written
from rattle.errors import InputError
from rattle.question import Argument, Question

T = TypeVar("T")
PLAIN = {"float": float, "int": int, "str": str}
OF_COMMANDS = {"progress"}  # arguments that a command gives by itself


def command_of(question: Question) -> click.Command:
    """The command: FILE, an option per argument, --json and -o for a picture."""
    takes = list(inspect.signature(question.answer).parameters.values())[1:]
    options = [_option(question, one) for one in takes if one.name not in OF_COMMANDS]
    progress = any(one.name == "progress" for one in takes)

    def ask(file: str, settings: tuple[str, ...], as_json_too: bool, picture: str | None, **given: Any) -> None:
        check_pictures(file, picture)
        ideal = given.pop("ideal", False)
        on_result = question.of == "result"
        subject = read_result(file, settings) if on_result else read_model(file, settings, ideal)
        if progress:
            given["progress"] = shows_progress(click.get_current_context())
        answer = question.answer(subject, **{name: value for name, value in given.items() if value != ()})
        click.echo(as_json(answer.record()) if as_json_too else str(answer))
        if picture is not None:
            from rattle.plots.curves import save_figure

            save_figure(answer.plot(), picture)
            say_written(picture)

    shared = [
        click.Option(["-o", "--output", "picture"], metavar="FILE", help="Draw the answer (.svg, .png, .pdf)."),
        click.Option(["--json", "as_json_too"], is_flag=True, help="The answer as JSON, in SI units."),
    ]
    made = click.command(question.command, cls=Command, help=_help(question), short_help=question.asks)(
        (_result_options if question.of == "result" else model_options)(ask)
    )
    made.params += [*options, *shared]
    return made


def _result_options(function: Any) -> Any:
    return click.argument("file", metavar="RESULT")(settings_option(function))


def _help(question: Question) -> str:
    """The docstring as a help text, with an example."""
    text = textwrap.dedent(inspect.getdoc(question.answer) or question.asks).strip()
    where = "a saved result" if question.of == "result" else "a model file or the name of a shipped example"
    name = "RESULT" if question.of == "result" else "FILE"
    example = question.examples[0][0] if question.examples and question.examples[0][0] else ""
    example = example or f"rattle {question.command} {'out.nc' if question.of == 'result' else 'slider_crank'}"
    head, _, rest = text.partition("\n\n")
    return "\n\n".join(filter(None, (head, f"{name} is {where}.", rest, f"\b\nExample:  {example}")))


def _option(question: Question, parameter: inspect.Parameter) -> click.Option:
    """The option of an argument: its type follows from annotation and unit."""
    told = question.arguments.get(parameter.name, Argument(parameter.name.replace("_", " ").capitalize() + "."))
    names = [f"--{parameter.name.replace('_', '-')}", parameter.name]
    kind = str(parameter.annotation).replace(" ", "")
    required = parameter.default is inspect.Parameter.empty
    default = None if required else parameter.default
    usual: dict[str, Any] = {"help": told.means, "default": default, "required": required}
    if kind == "bool":
        return click.Option([f"{names[0]}/--no-{names[0][2:]}" if default else names[0], names[1]], **usual)
    shown = usual | {"show_default": default is not None}
    base = kind.removesuffix("|None")
    if base.startswith(("Sequence[", "tuple[", "list[")):
        return click.Option(names, multiple=True, metavar="VALUE", help=told.means, required=required)
    if told.choices:
        return click.Option(names, type=click.Choice(told.choices), **shown)
    if "Seconds" in base:
        return click.Option(names, type=time, metavar="TIME", **shown)
    if told.unit:
        return click.Option(names, type=_Quantity(told), metavar="VALUE", **shown)
    return click.Option(names, type=_Bounded(PLAIN.get(base, str), told), **shown)


class _Quantity(click.ParamType[float]):
    """A number in SI, or a text with a unit of the same kind."""

    name = "quantity"

    def __init__(self, told: Argument) -> None:
        self.told = told

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """The value [SI]."""
        from rattle.language.quantities import in_si

        try:
            return _bounded(in_si(_name(param), value, self.told.unit, f"a number in {self.told.unit}"), self.told)
        except InputError as error:
            self.fail(str(error), param, ctx)


class _Bounded(click.ParamType[Any]):
    """A number or text, not below what is declared."""

    def __init__(self, kind: type, told: Argument) -> None:
        self.kind, self.told = kind, told
        self.name = {float: "number", int: "integer"}.get(kind, "text")

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The value as the type that is declared."""
        try:
            return _bounded(self.kind(value), self.told)
        except InputError as error:
            self.fail(str(error), param, ctx)
        except ValueError:
            self.fail(f"{value!r} is not a{'n' if self.name == 'integer' else ''} {self.name}", param, ctx)


def _bounded(value: T, told: Argument) -> T:
    if told.at_least is not None and isinstance(value, int | float) and value < told.at_least:
        raise InputError(f"{value:g} is below {told.at_least:g}")
    return value


def _name(param: click.Parameter | None) -> str:
    return param.opts[0] if param is not None else "value"
