"""Ctrl-C that is never lost.

Python raises KeyboardInterrupt wherever the main thread happens to be.  In a finaliser, as of a future that has been
dropped, it is printed and forgotten, and the run would go on.  While other threads or processes work, Ctrl-C is
therefore `noticed` between two looks; in all other work of the program one that was lost is `raised_again`.
"""

from __future__ import annotations

import _thread
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sys import UnraisableHookArgs

SOON = 0.01  # after which a lost Ctrl-C comes again [s]: most finalisers have ended then


@contextmanager
def noticed() -> Iterator[Callable[[], bool]]:
    """Within, the first Ctrl-C only makes the function that it gives return True; the second is raised as usual.

    Where Python's own handler is not in charge, or in another thread, nothing is changed.
    """
    if threading.current_thread() is not threading.main_thread() or (
        signal.getsignal(signal.SIGINT) is not signal.default_int_handler
    ):
        yield lambda: False
        return
    pressed = threading.Event()

    def note(number: int, frame: FrameType | None) -> None:
        if pressed.is_set():
            signal.default_int_handler(number, frame)
        pressed.set()

    signal.signal(signal.SIGINT, note)
    try:
        yield pressed.is_set
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)


@contextmanager
def raised_again() -> Iterator[None]:
    """Within, a Ctrl-C that Python could not raise, as in a finaliser, comes again until it is raised."""
    before, over = sys.unraisablehook, threading.Event()

    def again() -> None:
        if not over.wait(SOON):
            _thread.interrupt_main()

    def look(lost: UnraisableHookArgs) -> None:
        if issubclass(lost.exc_type, KeyboardInterrupt):
            threading.Thread(target=again, daemon=True).start()
        else:
            before(lost)

    sys.unraisablehook = look
    try:
        yield
    finally:
        over.set()  # nothing is left to be ended
        sys.unraisablehook = before
