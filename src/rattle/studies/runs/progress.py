"""Progress over samples."""

from __future__ import annotations

from rattle.progress_bar import progress_bar


class Bar:
    """A progress bar over samples with their rate and the time left, called with those done and all."""

    def __init__(self, total: int, what: str, done: int = 0) -> None:
        """what: the study; done: samples that were run before."""
        self._bar = progress_bar(total, what, done=done, unit=" samples", delay=1.0)

    def __call__(self, done: int, total: int) -> None:
        self._bar.update(done - self._bar.n)

    def close(self) -> None:
        """The end."""
        self._bar.close()
