"""The class of all commands: an option that takes one value is refused where it is given twice."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from typing import Any

import click

Options = Callable[[Callable[..., Any]], Callable[..., Any]]  # adds options to a command
TIMES = {2: "twice"}


class Command(click.Command):
    """A command that uses every value it is given: click alone takes the last one and drops the others."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """As in click.  Raises click.UsageError for options that are given more often than they take values."""
        if not ctx.resilient_parsing:
            _, _, in_order = self.make_parser(ctx).parse_args(args=list(args))
            for param, count in Counter(in_order).items():
                if count > 1 and isinstance(param, click.Option) and _takes_one(param):
                    raise click.UsageError(_too_often(param, count), ctx)
        return super().parse_args(ctx, args)


def _takes_one(option: click.Option) -> bool:
    """False where saying it again adds a value, or changes nothing."""
    return not (option.multiple or option.count or (option.is_flag and not option.secondary_opts))


def _too_often(option: click.Option, count: int) -> str:
    """What is wrong with an option that is given more than once, in words."""
    name = max(option.opts, key=len)
    if option.is_flag:
        name = f"{name}/{max(option.secondary_opts, key=len)}"
    times = TIMES.get(count, f"{count} times")
    takes = "say it once" if option.is_flag else f"it takes one {option.metavar or 'value'}"
    return f"{name} is given {times}; {takes}"
