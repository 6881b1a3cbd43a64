"""The studio's end of the process that computes for one session, see `worker`."""

from __future__ import annotations

import logging
import multiprocessing
import sys
import threading
import time
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

PATIENCE = 3.0  # after which a job that the user has stopped, and that does not listen, is ended with its process [s]
SPAWN = "forkserver" if sys.platform.startswith("linux") else "spawn"


class Outcome(NamedTuple):
    """What became of a job: `kind` is "progress", "done", "failed", "stopped"."""

    number: int
    kind: str
    value: Any = None  # of "done"; words of "failed"; (what, share of the work) of "progress"


@cache
def _context() -> Any:
    """What processes are made with: copies of one that has everything loaded, where the system can copy processes."""
    context: Any = multiprocessing.get_context(SPAWN)
    if SPAWN == "forkserver":
        context.set_forkserver_preload(["rattle.studio.warm"])
    return context


def prepare() -> None:
    """Start what processes are made from, so that the first page does not wait for it."""
    process = Process(lambda outcome: None)
    process.wait()
    process.end()


class Process:
    """A process that does jobs; `tell` is called in another thread with every outcome.

    It is started in that thread, because the first one may take seconds; orders wait until then.
    """

    def __init__(self, tell: Callable[[Outcome], None]) -> None:
        self._tell = tell
        self._conn, self._theirs = _context().Pipe()
        self._lock = threading.Lock()
        self._process: Any = None
        self._waiting: list[tuple[Any, ...]] | None = []  # orders for a process that has not started yet
        self._given_up = False
        self._thread = threading.Thread(target=self._live, daemon=True)
        self._thread.start()

    def send(self, *order: Any) -> None:
        """Give an order, see `worker`; a process that has ended takes none."""
        with self._lock:
            if self._waiting is not None:
                self._waiting.append(order)
                return
            try:
                self._conn.send(order)
            except (OSError, ValueError) as error:
                logging.getLogger("rattle").debug(f"the process of a session has ended: {error}")

    def end(self) -> None:
        """End it, whatever it does."""
        with self._lock:
            self._given_up = True
            process = self._process
        if process is not None:
            process.kill()
            process.join()
            self._thread.join(PATIENCE)
            self._conn.close()
            process.close()

    def wait(self) -> None:
        """Wait until it has started."""
        while self._thread.is_alive() and self._process is None:
            time.sleep(0.01)

    def _live(self) -> None:
        from rattle.studio.worker import work

        process = _context().Process(target=work, args=(self._theirs,), daemon=True, name="rattle studio")
        try:
            process.start()
            self._theirs.close()
            with self._lock:
                if self._given_up:
                    process.kill()
                    process.join()
                    return
                self._process = process
                for order in self._waiting or ():
                    self._conn.send(order)
                self._waiting = None
            while True:
                kind, number, *more = self._conn.recv()
                self._tell(Outcome(number, kind, more[0] if len(more) == 1 else tuple(more)))
        except (EOFError, OSError):
            self._tell(Outcome(0, "ended"))


class Job(NamedTuple):
    """A job that was asked for."""

    number: int
    name: str
    arguments: dict[str, Any]


def _urgency(name: str) -> int:
    """Jobs with lower numbers are done first."""
    return 0 if name == "motion" else 2 if name.startswith("thumbnail") else 1


class Bench:
    """Jobs of one session, one at a time; a new job of a name replaces the one of that name that waits or runs.

    tell(name, outcome): called with every outcome of a job that still matters, by `post`, which brings a call into the
    thread of the page.
    """

    def __init__(self, tell: Callable[[str, Outcome], None], post: Callable[[Callable[[], None]], None]) -> None:
        self._tell, self._post = tell, post
        self._process: Process | None = None
        self._waiting: dict[str, Job] = {}
        self._running: Job | None = None
        self._count = 0
        self._dropped = 0  # number of the last job whose answer no longer matters
        self._timer: threading.Timer | None = None
        self.ended = False

    @property
    def busy(self) -> str:
        """Name of the job that runs; "" if none does."""
        return self._running.name if self._running is not None else ""

    @property
    def waiting(self) -> list[str]:
        """Names of the jobs that wait."""
        return list(self._waiting)

    def ask(self, name: str, **arguments: Any) -> int:
        """Have a job done as soon as may be; returns its number.  Of several requests of a name the last counts."""
        self._count += 1
        self._waiting.pop(name, None)
        self._waiting[name] = Job(self._count, name, arguments)
        if self._running is not None and self._running.name == name:
            self._send("stop", self._running.number)
        self._go_on()
        return self._count

    def stop(self, name: str) -> None:
        """Stop a job at the user's wish: at once as by Ctrl-C, after three seconds with its process."""
        if (job := self._waiting.pop(name, None)) is not None:
            self._tell(name, Outcome(job.number, "stopped"))
        running = self._running
        if running is None or running.name != name:
            return
        self._send("stop", running.number)
        self._cancel_timer()
        self._timer = threading.Timer(PATIENCE, lambda: self._post(lambda: self._lose_patience(running.number)))
        self._timer.daemon = True
        self._timer.start()

    def drop(self, *names: str) -> None:
        """Forget jobs whose answers no longer matter; one that runs is stopped."""
        for name in names:
            self._waiting.pop(name, None)
            if self._running is not None and self._running.name == name:
                self._dropped = self._running.number  # it may have ended already, with an answer on its way
                self._send("stop", self._running.number)

    def end(self) -> None:
        """End the process and all that waits."""
        self.ended = True
        self._cancel_timer()
        self._waiting.clear()
        self._running = None
        process, self._process = self._process, None
        if process is not None:
            process.end()

    # ------------------------------------------------------------ one job at a time
    def _send(self, *order: Any) -> None:
        if self._process is not None:
            self._process.send(*order)

    def _go_on(self) -> None:
        if self._running is not None or self.ended or not self._waiting:
            return
        if self._process is None:
            self._renew()
        self._running = self._waiting.pop(min(self._waiting, key=_urgency))
        self._send("job", *self._running)

    def _renew(self) -> None:
        if self._process is not None:
            self._process.end()
        started: list[Process] = []
        self._process = Process(lambda outcome: self._post(lambda: self._hear(started[0], outcome)))
        started.append(self._process)

    def _hear(self, process: Process, outcome: Outcome) -> None:
        if process is not self._process or self.ended:
            return  # of a process that was given up
        if outcome.kind == "ended":  # killed from outside, or out of memory
            self._process = None
            process.end()
        running = self._running
        if running is None or outcome.number not in (running.number, 0):
            return
        if outcome.kind == "progress":
            if running.name not in self._waiting and running.number != self._dropped:
                self._tell(running.name, outcome)
            return
        self._cancel_timer()
        self._running = None
        if outcome.kind == "ended":
            outcome = Outcome(running.number, "failed", "the process that computes was ended from outside")
        elif running.number == self._dropped:
            outcome = Outcome(running.number, "stopped")
        if running.name not in self._waiting:  # otherwise a newer request is waiting
            self._tell(running.name, outcome)
        self._go_on()

    def _lose_patience(self, number: int) -> None:
        running = self._running
        if running is None or running.number != number or self.ended:
            return
        self._running = None
        self._renew()
        self._tell(running.name, Outcome(number, "stopped"))
        self._go_on()

    def _cancel_timer(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
