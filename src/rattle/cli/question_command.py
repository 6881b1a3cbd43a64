"""What the commands of questions share.

A command is given as `Asked` what every command is told: about what it asks, and where to its answer goes.  It returns
as `Shown` what it has to say; printing, JSON, files and the exit status follow from that.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial, wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from rattle.cli.command import Command, Options
from rattle.cli.options import model_options, read_model, read_result, settings_option, shows_progress
from rattle.cli.output import as_json, check_pictures, check_results, finish, keep, say_written
from rattle.cli.requirements import Verdict, finish_required, judge, required_record

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame

    from rattle.mechanism import Mechanism
    from rattle.results.result import Result


def json_option(words: str) -> Options:
    """Add the option --json to a command."""
    return click.option("--json", "as_json", is_flag=True, help=words)


def picture_option(words: str, *flags: str, usual: str | None = None) -> Options:
    """Add an option for the name of a picture to a command, -o unless there are other flags; usual: its default."""
    flags = flags or ("-o", "--output")
    return click.option(*flags, "picture", metavar="FILE", default=usual, show_default=usual is not None, help=words)


class Asked(NamedTuple):
    """What a command is told by options that many have."""

    file: str = ""  # a model, or a result
    settings: tuple[str, ...] = ()
    ideal: bool = False
    output: str | None = None  # where a result is saved
    csv: str | None = None
    fallback: str | None = None
    picture: str | None = None
    required: tuple[str, ...] = ()
    as_json: bool = False

    def model(self, moving: bool = False) -> Mechanism:
        """The model; before it is read, the names of files are refused that cannot be written.

        moving: the picture may be an animation.  Raises click.UsageError, InputError, ModelError, OSError.
        """
        self.check(moving)
        return read_model(self.file, self.settings, self.ideal)

    def result(self) -> Result:
        """The result, as `model`."""
        self.check()
        return read_result(self.file, self.settings)

    def check(self, moving: bool = False) -> None:
        """Refuse the names of files that cannot be written.  Raises as `model`."""
        check_results(self.file, self.output, self.csv, self.fallback)
        if self.picture is not None:
            check_pictures(self.file, self.picture, moving=moving)

    def by_suffix(self, tables: bool = True) -> Asked:
        """-o taken for a picture or, with `tables`, for a table if its name says so."""
        from rattle.plots.curves import SUFFIXES

        suffix = Path(self.output or "").suffix.lower()
        if suffix in SUFFIXES:
            return self._replace(output=None, picture=self.output)
        return self._replace(output=None, csv=self.output) if tables and suffix == ".csv" else self

    @property
    def progress(self) -> bool:
        """True where somebody sees how far the work has come."""
        return shows_progress(click.get_current_context())

    def drawn(self, *drawings: Callable[[], Figure], named: Sequence[object] = ()) -> tuple[Written, ...]:
        """The picture, if there is to be one; named: what sets the names of several pictures apart."""
        if self.picture is None:
            return ()
        path = Path(self.picture)
        several: list[str | Path] = [path.with_stem(f"{path.stem}-{name}") for name in named]
        targets = several if len(drawings) > 1 else [self.picture]
        return tuple(Written(target, partial(_draw, draw)) for target, draw in zip(targets, drawings, strict=True))

    def tabled(self, table: Callable[[], DataFrame]) -> tuple[Written, ...]:
        """The table of --csv, if there is to be one."""
        return () if self.csv is None else (Written(self.csv, partial(_tabulate, table)),)

    def shown(
        self, result: Result, words: Callable[[], str], record: Callable[[], Mapping[str, object]],
        files: tuple[Written, ...] = (),
    ) -> Shown:  # fmt: skip
        """What is shown of curves over time: they are saved before all else, then judged by what is required."""
        kept = keep(result, self.output, self.csv, self.fallback)
        verdicts = judge(result, self.required)
        return Shown(
            words if len(result.t) else str, lambda: {**record(), **required_record(verdicts)},
            files if len(result.t) else (), verdicts, result=result, kept=kept,
        )  # fmt: skip


class Written(NamedTuple):
    """A file that is written after the answer is printed."""

    path: str | Path
    write: Callable[[Any], object]  # to that path


def _draw(draw: Callable[[], Figure], path: str | Path) -> None:
    from rattle.plots.curves import save_figure

    save_figure(draw(), path)


def _tabulate(table: Callable[[], DataFrame], path: str) -> None:
    from rattle.atomic_file import atomic

    with atomic(path) as file:
        table().to_csv(file, index=False, lineterminator="\n")


class Shown(NamedTuple):
    """What a command says and writes, in this order, and how it ends."""

    words: Callable[[], str] = str  # "" for nothing
    record: Callable[[], object] = dict  # of --json, in SI
    files: Sequence[Written] = ()
    verdicts: Sequence[Verdict] = ()  # the exit status is 1 if one of them is not kept
    status: int = 0  # exit status apart from that
    remarks: Sequence[str] = ()  # on stderr, at the end
    result: Result | None = None  # that decides on the exit status first
    kept: bool = True  # False: the result could not be saved


def alone_or_all(records: Sequence[object]) -> object:
    """What JSON holds of one answer, or of several."""
    return records[0] if len(records) == 1 else records


def model_command(function: Callable[..., Shown], **words: str) -> click.Command:
    """Decorator: a command about a model, of a function of `Asked` and the options that are its own.

    words: of the command, as click has them.
    """
    return plain_command(model_options(function), **words)


def result_command(function: Callable[..., Shown], **words: str) -> click.Command:
    """Decorator: the same about a saved result."""
    return plain_command(click.argument("file", metavar="RESULT")(settings_option(function)), **words)


def plain_command(function: Callable[..., Shown], **words: str) -> click.Command:
    """Decorator: the same about neither."""

    @wraps(function)
    def command(**options: Any) -> None:
        asked = Asked(**{name: options.pop(name) for name in Asked._fields if name in options})
        _show(asked, function(asked, **options))

    return click.command(cls=Command, **words)(command)


def _show(asked: Asked, shown: Shown) -> None:
    """Print an answer, write its files, end with its exit status; with --json nothing else is on stdout."""
    context = click.get_current_context()
    if asked.as_json:
        click.echo(as_json(shown.record()))
    elif words := shown.words():
        click.echo(words)
    for path, write in shown.files:
        write(path)
        if not asked.as_json:
            say_written(path)
    for remark in shown.remarks:
        click.echo(remark, err=True)
    if shown.result is not None:
        finish(context, shown.result, shown.kept)
    if shown.status:
        context.exit(shown.status)
    finish_required(context, shown.verdicts, None if asked.as_json else click.echo)
