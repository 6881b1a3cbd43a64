"""How far long work has come: a bar in the terminal, or a listener that shows it elsewhere."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

Listener = Callable[[str, float, float], None]  # what is done, how much of it, how much in all

_listener: ContextVar[Listener | None] = ContextVar("listener", default=None)


@contextmanager
def told_to(listener: Listener) -> Iterator[None]:
    """Within, progress goes to this listener instead of the terminal.

    It may raise KeyboardInterrupt to end the work.
    """
    before = _listener.set(listener)
    try:
        yield
    finally:
        _listener.reset(before)


def progress_bar(total: float, what: str, *, done: float = 0, **style: Any) -> Any:
    """A bar over `total` of something, of which `done` is done: it has `n`, `update`, `set_postfix_str` and `close`.

    what: the work in a word.  style: arguments of `tqdm.tqdm`, such as unit and delay.
    """
    listener = _listener.get()
    if listener is not None:
        return _Told(listener, what, total, done)
    from tqdm import tqdm

    return tqdm(total=total, initial=done, desc=what, **style)


class _Told:
    """As a bar of tqdm, for a listener."""

    def __init__(self, listener: Listener, what: str, total: float, done: float) -> None:
        self._listener, self._what, self._total, self.n = listener, what, total, done
        listener(what, done, total)

    def update(self, n: float = 1) -> None:
        self.n += n
        self._listener(self._what, self.n, self._total)

    def set_postfix_str(self, text: str, refresh: bool = True) -> None:
        """What a terminal shows after the bar is left out."""

    def close(self) -> None:
        """The end: nothing is left to tell."""
