"""Worker processes on this machine: a Dask scheduler inside this process, and workers that it starts."""

from __future__ import annotations

import logging
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import Any

from rattle.errors import WorkerError
from rattle.results.archive import package

START = 60.0  # seconds in which the workers must be there
END = 3.0  # seconds that a worker has to end by itself
LOOPBACK = "127.0.0.1"


@contextmanager
def local_workers(count: int) -> Iterator[tuple[str, Callable[[], None]]]:
    """The address of a scheduler with so many workers of one thread each; nothing but this machine can reach it.

    With it comes a function that raises WorkerError when no worker is left.  Workers are programs of their own, not
    children that import the script of the user again.  A worker that dies is started again; all of them end with this
    process, however it ends.  Raises WorkerError, MissingPackage.
    """
    distributed = package("distributed", "running on several processes")
    with (
        tempfile.TemporaryDirectory(prefix="rattle-", ignore_cleanup_errors=True) as folder,
        distributed.LocalCluster(
            n_workers=0,
            host=LOOPBACK,
            dashboard_address=None,
            silence_logs=logging.CRITICAL,
            scheduler_kwargs={"dashboard_address": f"{LOOPBACK}:0"},
        ) as cluster,
    ):
        address = str(cluster.scheduler_address)
        started: list[subprocess.Popen[bytes]] = []
        try:
            for n in range(count):
                started.append(_start(address, Path(folder), n))
            _wait(cluster, started, count, Path(folder))
            yield address, partial(_require_one, started, Path(folder))
        finally:
            _end(started)


def _start(address: str, folder: Path, n: int) -> subprocess.Popen[bytes]:
    """Start a worker; what it says is in the folder."""
    source = str(Path(__file__).parents[3])
    path = os.pathsep.join(path for path in (source, os.environ.get("PYTHONPATH", "")) if path)
    words = [
        sys.executable, "-m", "distributed.cli.dask_worker", address, "--host", LOOPBACK, "--nthreads", "1",
        "--no-dashboard", "--memory-limit", "0", "--death-timeout", "30", "--local-directory", str(folder),
    ]  # fmt: skip
    with (folder / f"worker-{n}.log").open("wb") as out:  # a session of its own: Ctrl-C is for this process alone
        return subprocess.Popen(
            words, stdin=subprocess.DEVNULL, stdout=out, stderr=subprocess.STDOUT, start_new_session=True,
            env={**os.environ, "PYTHONPATH": path},
        )  # fmt: skip


def _last_words(folder: Path, n: int) -> str:
    """What worker n has said last, but that it goes on as it should."""
    words = (folder / f"worker-{n}.log").read_text(errors="replace").strip().splitlines()
    return next((line for line in reversed(words) if " - INFO - " not in line), "it said nothing")


def _require_one(started: list[subprocess.Popen[bytes]], folder: Path) -> None:
    """Raises WorkerError if all have ended."""
    if all(worker.poll() is not None for worker in started):
        raise WorkerError(f"all worker processes have ended; the first of them said: {_last_words(folder, 0)}")


def _wait(cluster: Any, started: list[subprocess.Popen[bytes]], count: int, folder: Path) -> None:
    """Wait until all workers are there.  Raises WorkerError."""
    end = time.monotonic() + START
    while len(cluster.scheduler_info["workers"]) < count:
        ended = [n for n, worker in enumerate(started) if worker.poll() is not None]
        if ended or time.monotonic() > end:
            why = f"did not start: {_last_words(folder, ended[0])}" if ended else "is not there"
            raise WorkerError(f"a worker process {why} (waited up to {START:g} s)")
        time.sleep(0.05)


def _end(started: list[subprocess.Popen[bytes]]) -> None:
    """End all workers with the processes that they have started."""
    for worker in started:
        with suppress(ProcessLookupError):
            worker.terminate()
    end = time.monotonic() + END
    for worker in started:
        with suppress(subprocess.TimeoutExpired):
            worker.wait(max(0.0, end - time.monotonic()))
    for worker in started:
        with suppress(ProcessLookupError, PermissionError):
            if sys.platform == "win32":
                worker.kill()
            else:
                os.killpg(worker.pid, signal.SIGKILL)
        worker.wait()
