"""The process that computes for one session: it does one job at a time, tells how far it is, and can be stopped.

It is a process and not a thread so that a page of one user never waits for the runs of another, that stopping a run is
the Ctrl-C which every analysis knows, and that nothing is left of it when the page is closed.

To it: ("job", number, name, arguments), ("stop", number).  Nothing more to read: the studio has ended, and so does it.
From it: ("progress", number, what, share), ("done", number, value), ("failed", number, words), ("stopped", number).
"""

from __future__ import annotations

import _thread
import logging
import os
import queue
import threading
import time
import traceback
from multiprocessing.connection import Connection
from typing import Any

from rattle.errors import ANSWERS
from rattle.progress_bar import told_to
from rattle.studio.jobs import job
from rattle.studio.shelf import Shelf

TELL = 0.1  # least time between two messages on progress [s]


def work(conn: Connection) -> None:
    """Do jobs until the other end of the connection is closed."""
    logging.getLogger("rattle").addHandler(logging.NullHandler())
    logging.getLogger("rattle").propagate = False
    _Worker(conn).serve()


class _Worker:
    def __init__(self, conn: Connection) -> None:
        self.conn = conn
        self.jobs: queue.SimpleQueue[tuple[int, str, dict[str, Any]]] = queue.SimpleQueue()
        self.guard = threading.Lock()  # held where `current` changes and where it is interrupted
        self.current = 0  # number of the job that may be interrupted, 0 for none
        self.dropped: set[int] = set()  # jobs that were stopped before they began
        self.shelf = Shelf()
        self.told = 0.0

    def serve(self) -> None:
        threading.Thread(target=self._listen, daemon=True).start()
        while True:
            try:
                self._next()
            except KeyboardInterrupt:  # of a job that was done already, or for the studio as a whole
                continue

    def _listen(self) -> None:
        """Take orders; in the main thread Python itself would notice none while a job runs."""
        try:
            while True:
                kind, number, *more = self.conn.recv()
                if kind == "job":
                    self.jobs.put((number, *more))
                    continue
                with self.guard:
                    self.dropped.add(number)
                    if number == self.current:
                        _thread.interrupt_main()
        except (EOFError, OSError):
            os._exit(0)  # nobody is left to compute for

    def _next(self) -> None:
        number, name, arguments = self.jobs.get()
        with self.guard:
            self.dropped = {asked for asked in self.dropped if asked >= number}
            stopped = number in self.dropped
            self.current = 0 if stopped else number
        answer: tuple[Any, ...] = ("stopped", number)
        if not stopped:
            try:
                answer = self._do(number, name, arguments)
            except KeyboardInterrupt:
                answer = ("stopped", number)
        while not self._closed():
            answer = ("stopped", number)
        self.conn.send(answer)

    def _closed(self) -> bool:
        """After it, nobody interrupts the job any more; False if that happened just now."""
        try:
            with self.guard:
                self.current = 0
            return True
        except KeyboardInterrupt:
            return False

    def _do(self, number: int, name: str, arguments: dict[str, Any]) -> tuple[Any, ...]:
        """The answer to a job.  Raises KeyboardInterrupt if it was stopped."""
        try:
            with told_to(lambda what, done, total: self._tell(number, what, done, total)):
                return "done", number, job(name.partition(" ")[0])(self.shelf, **arguments)
        except ANSWERS as error:
            return "failed", number, str(error)
        except Exception:  # the page says so, and the session goes on
            return "failed", number, f"rattle itself failed here; please report this:\n{traceback.format_exc()}"

    def _tell(self, number: int, what: str, done: float, total: float) -> None:
        if number in self.dropped:
            raise KeyboardInterrupt
        now = time.monotonic()
        if now - self.told >= TELL:
            self.told = now
            self.conn.send(("progress", number, what, min(1.0, done / total) if total else 0.0))
