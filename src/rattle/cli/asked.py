"""The command of a question, made from its signature and what is declared of its arguments."""

from __future__ import annotations

import inspect
import textwrap
from typing import TYPE_CHECKING, Any

import click

from rattle.answers.answer import Answer
from rattle.answers.arguments import read, takes_several, types_of
from rattle.cli.command import Command
from rattle.cli.options import model_options, read_model, read_result, settings_option, shows_progress
from rattle.cli.output import as_json, check_pictures, say_written
from rattle.errors import InputError
from rattle.question import Argument, Question

if TYPE_CHECKING:
    _ParamType = click.ParamType[Any]
else:
    _ParamType = click.ParamType  # takes no type before click 8.3


def command_of(question: Question) -> click.Command:
    """The command: FILE, an option per argument, --json and -o for a picture."""
    options = [_option(question, name, kind) for name, kind in types_of(question).items()]
    progress = "progress" in inspect.signature(question.answer).parameters

    def ask(file: str, settings: tuple[str, ...], as_json_too: bool, picture: str | None, **chosen: Any) -> None:
        check_pictures(file, picture)
        ideal = chosen.pop("ideal", False)
        on_result = question.of == "result"
        subject = read_result(file, settings) if on_result else read_model(file, settings, ideal)
        if progress:
            chosen["progress"] = shows_progress(click.get_current_context())
        answer = question.answer(subject, **{name: value for name, value in chosen.items() if value is not None})
        if not isinstance(answer, Answer):
            raise InputError(
                f"question '{question.name}' returned {answer!r:.60}; a command needs an Answer, or a part"
            )
        click.echo(as_json(answer.record()) if as_json_too else str(answer))
        if picture is not None:
            from rattle.plots.curves import save_figure

            save_figure(answer.plot(), picture)
            say_written(picture)

    shared = [
        click.Option(["-o", "--output", "picture"], metavar="FILE", help="Draw the answer (.svg, .png, .pdf)."),
        click.Option(["--json", "as_json_too"], is_flag=True, help="The answer as JSON, in SI units."),
    ]
    command = click.command(question.command, cls=Command, help=_help(question), short_help=question.asks)(
        (_result_options if question.of == "result" else model_options)(ask)
    )
    command.params += [*options, *shared]
    return command


def _result_options(function: Any) -> Any:
    return click.argument("file", metavar="RESULT")(settings_option(function))


def _help(question: Question) -> str:
    """The docstring as a help text, with an example."""
    text = textwrap.dedent(inspect.getdoc(question.answer) or question.asks).strip()
    where = "a saved result" if question.of == "result" else "a model file or the name of a shipped example"
    name = "RESULT" if question.of == "result" else "FILE"
    example = question.examples[0][0] if question.examples and question.examples[0][0] else ""
    example = example or f"rattle {question.command} {'out.nc' if question.of == 'result' else 'slider_crank'}"
    head, *rest = text.split("\n\n")
    more = [part for part in rest if not part.startswith(tuple(f"{argument}:" for argument in question.takes))]
    return "\n\n".join([head, f"{name} is {where}.", *more, f"\b\nExample:  {example}"])


def _option(question: Question, name: str, annotation: str) -> click.Option:
    """The option of an argument: its type follows from annotation and unit."""
    told = question.arguments.get(name, Argument(f"{name.replace('_', ' ').capitalize()}."))
    flag, required, usual = f"--{name.replace('_', '-')}", name in question.needed, question.usual.get(name)
    if annotation == "bool":
        return click.Option([f"{flag}/--no-{flag[2:]}" if usual else flag, name], default=usual, help=told.means)
    if takes_several(annotation):
        listed = f"{told.means}  Several with commas between them."
        return click.Option([flag, name], type=_Written(question, name), metavar="LIST", help=listed, required=required)
    shown: dict[str, Any] = {"help": told.means, "required": required, "show_default": usual is not None}
    shown["metavar"] = f"[{'|'.join(told.choices)}]" if told.choices else "VALUE"
    if not required:  # click takes a default, None too, for a value that was given
        shown["default"] = usual
    return click.Option([flag, name], type=_Written(question, name), **shown)


class _Written(_ParamType):
    """The value of an argument as it is written."""

    name = "value"

    def __init__(self, question: Question, argument: str) -> None:
        self.question, self.argument = question, argument

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The value, in SI."""
        try:
            return read(self.question, self.argument, value) if isinstance(value, str) else value
        except InputError as error:
            self.fail(str(error).removeprefix(f"{self.argument}: "), param, ctx)
