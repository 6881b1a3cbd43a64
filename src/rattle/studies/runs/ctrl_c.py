"""Ctrl-C while other threads or processes work: noticed between two looks, never lost.

Python raises KeyboardInterrupt wherever the main thread happens to be.  In a finaliser, as of a future that has been
dropped, it is printed and forgotten, and the run would go on.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType


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
