"""Work that has a bound: what would never end without its limits is told from a busy machine by a wide margin."""

import contextlib
import time
from collections.abc import Iterator


@contextlib.contextmanager
def bounded(seconds: float = 20.0) -> Iterator[None]:
    """What is done within takes less processor time than this, which is ten times what it is meant to take."""
    began = time.process_time()
    yield
    assert time.process_time() - began < seconds
