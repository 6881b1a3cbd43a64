"""The command of a question, made from its signature and what is declared of its arguments."""

from __future__ import annotations

import inspect
import textwrap
from typing import TYPE_CHECKING, Any

import click

from rattle.answers.answer import Answer
from rattle.answers.arguments import read, takes_several, types_of
from rattle.cli.question_command import Asked, Shown, json_option, model_command, picture_option, result_command
from rattle.errors import InputError
from rattle.question import Argument, Question

if TYPE_CHECKING:
    _ParamType = click.ParamType[Any]
else:
    _ParamType = click.ParamType  # takes no type before click 8.3


OWN = "_of_question"  # after the names of arguments, which may be those of `Asked` too


def command_of(question: Question) -> click.Command:
    """The command: FILE, an option per argument, --json and -o for a picture."""
    progress = "progress" in inspect.signature(question.answer).parameters

    def ask(asked: Asked, **options: Any) -> Shown:
        subject = asked.result() if question.of == "result" else asked.model()
        chosen = {name.removesuffix(OWN): value for name, value in options.items() if value is not None}
        if progress:
            chosen["progress"] = asked.progress
        answer = question.answer(subject, **chosen)
        if not isinstance(answer, Answer):
            raise InputError(
                f"question '{question.name}' returned {answer!r:.60}; a command needs an Answer, or a part"
            )
        return Shown(lambda: str(answer), answer.record, asked.drawn(answer.plot))

    decorate = result_command if question.of == "result" else model_command
    shown = picture_option("Draw the answer (.svg, .png, .pdf).")(json_option("The answer as JSON, in SI units.")(ask))
    command = decorate(shown, name=question.command, help=_help(question), short_help=question.asks)
    command.params[-2:-2] = [_option(question, name, kind) for name, kind in types_of(question).items()]
    return command


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
    target = name + OWN
    if annotation == "bool":
        return click.Option([f"{flag}/--no-{flag[2:]}" if usual else flag, target], default=usual, help=told.means)
    if takes_several(annotation):
        listed = f"{told.means}  Several with commas between them."
        return click.Option(
            [flag, target], type=_Written(question, name), metavar="LIST", help=listed, required=required
        )
    shown: dict[str, Any] = {"help": told.means, "required": required, "show_default": usual is not None}
    shown["metavar"] = f"[{'|'.join(told.choices)}]" if told.choices else "VALUE"
    if not required:  # click takes a default, None too, for a value that was given
        shown["default"] = usual
    return click.Option([flag, target], type=_Written(question, name), **shown)


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
