"""The command line as it describes itself: usage, help text, options, examples of every command."""

from __future__ import annotations

import re
from pathlib import Path

import click

from making.text import fence, paragraph, shell, table
from making.tree import module_with


def pages(folder: Path) -> dict[str, str]:
    """The reference of all commands."""
    cli = module_with("main", "COMMANDS", "HELP")
    context = click.Context(cli.main, info_name="rattle", **cli.main.context_settings)
    parts = [words(cli.main.help or ""), "## Options of every command", options(cli.main, context)]
    for name in cli.main.list_commands(context):
        command = cli.main.get_command(context, name)
        own = click.Context(command, info_name=name, parent=context)
        usage = " ".join(["rattle", name, *command.collect_usage_pieces(own)])
        parts += [f"## rattle {name}", fence(usage), words(command.help or ""), options(command, own)]
    return {"commands": "\n\n".join(part for part in parts if part) + "\n"}


def words(text: str) -> str:
    """A help text as Markdown: paragraphs, preformatted parts unchanged, examples as commands."""
    parts = []
    for part in re.split(r"\n\s*\n", text.strip()):
        lines = [line.rstrip() for line in part.splitlines()]
        kept = lines[0].strip() == "\b"
        lines = [line for line in lines if line.strip() != "\b"]
        if lines and lines[0].strip().startswith("Example"):
            parts.append(shell(re.sub(r"^\s*(Examples?:)?\s*", "", line) for line in lines))
        elif kept:
            parts.append(shell(lines) if lines[0].strip().startswith("rattle") else fence("\n".join(lines)))
        else:
            parts.append(paragraph(" ".join(lines)))
    return "\n\n".join(parts)


def options(command: click.Command, context: click.Context) -> str:
    """A table of the options of one command."""
    rows = []
    for one in command.get_params(context):
        record = one.get_help_record(context)
        if record is not None:
            rows.append((f"`{record[0]}`".replace("|", "\\|"), paragraph(record[1])))
    return table(("option", "meaning"), rows) if rows else ""
