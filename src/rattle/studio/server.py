"""The server of the studio: it listens on this computer alone, unless asked otherwise, until it is told to end."""

from __future__ import annotations

import asyncio
import html
import logging
import os
import signal
import socket
import sys
import tempfile
import threading
import webbrowser
from collections.abc import Callable, Collection
from contextlib import nullcontext
from pathlib import Path
from typing import cast

import h11
import uvicorn
from starlette.types import ASGIApp
from uvicorn.protocols.http.h11_impl import H11Protocol

from rattle.studio.guard import LOOPBACK, Guard, Secrets

LARGEST_MESSAGE = 20_000_000  # from the page, over its web socket [bytes]; a model text has at most 8 MB
LARGEST_HEADER = 32_000  # of a request [bytes]
IDLE = 30  # a connection that asks for nothing, or never ends to ask, is closed after this time [s]
GRACE = 3  # for whatever still works when the studio is told to end [s]
REDIRECT = """<!doctype html><meta charset="utf-8"><title>rattle studio</title>
<meta name="referrer" content="no-referrer">
<meta http-equiv="refresh" content="0;url={0}"><a href="{0}">Open the studio</a>
"""


class Server:
    """A studio that is served: `new_address` is what the user opens.

    application: answers what may be asked, see `Guard`.  paths: all of its paths.
    """

    def __init__(self, application: ASGIApp, paths: Collection[str], address: str = "127.0.0.1", port: int = 0) -> None:
        self.socket = _listening(address, port)
        self.port: int = self.socket.getsockname()[1]
        self.keys = Secrets()
        self.host = f"[{address}]" if ":" in address else address
        names = {*LOOPBACK, self.host} if self.host not in ("0.0.0.0", "[::]") else {*LOOPBACK, *own_addresses()}
        guard = Guard(application, paths, self.keys, names, self.port)
        self.uvicorn = uvicorn.Server(
            uvicorn.Config(
                guard, http=Patience, ws="websockets-sansio", ws_max_size=LARGEST_MESSAGE, loop="asyncio",
                ws_per_message_deflate=False, h11_max_incomplete_event_size=LARGEST_HEADER, timeout_keep_alive=IDLE,
                timeout_graceful_shutdown=GRACE, headers=list(guard.headers().items()), server_header=False,
                proxy_headers=False, lifespan="off", log_config=None, log_level="error", access_log=False,
            )
        )  # fmt: skip

    def new_address(self) -> str:
        """What to open in a browser, with a token that is good for one use."""
        shown = "127.0.0.1" if self.host == "0.0.0.0" else "[::1]" if self.host == "[::]" else self.host
        return f"http://{shown}:{self.port}/?token={self.keys.issue()}"

    def heed(self) -> None:
        """From now on Ctrl-C and SIGTERM end `run`, also before it has begun."""
        for told in (signal.SIGINT, signal.SIGTERM):
            signal.signal(told, lambda *_: setattr(self.uvicorn, "should_exit", True))

    def run(self, open_browser: bool, at_enter: Callable[[], None]) -> None:
        """Serve until Ctrl-C or SIGTERM.

        at_enter: called whenever the user presses Enter in the terminal.
        """
        with Redirect(self.new_address()) if open_browser else nullcontext() as file:
            if file is not None:
                threading.Thread(target=webbrowser.open, args=(file.as_uri(),), daemon=True).start()
            asyncio.run(self._serve(at_enter))

    async def _serve(self, at_enter: Callable[[], None]) -> None:
        _listen_to_terminal(at_enter)
        await self.uvicorn.serve([self.socket])


class Patience(H11Protocol):
    """HTTP as uvicorn speaks it, without its endless wait for a first request and for the rest of one."""

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """A connection was opened; the loop calls this."""
        super().connection_made(cast(asyncio.Transport, transport))
        self.timeout_keep_alive_task = self.loop.call_later(self.timeout_keep_alive, self.timeout_keep_alive_handler)

    def data_received(self, data: bytes) -> None:
        """A piece of a request has come; the loop calls this."""
        waits, self.timeout_keep_alive_task = self.timeout_keep_alive_task, None
        super().data_received(data)
        if waits is None or self.timeout_keep_alive_task is not None:
            return
        if self.conn.their_state is h11.IDLE:  # not a whole request yet
            self.timeout_keep_alive_task = waits
        else:
            waits.cancel()


class Redirect:
    """A file that leads a browser to an address which must not stand on a command line, where all users may read it."""

    def __init__(self, address: str) -> None:
        self.address = address

    def __enter__(self) -> Path:
        self.folder = tempfile.TemporaryDirectory(prefix="rattle-studio-", ignore_cleanup_errors=True)
        file = Path(self.folder.name) / "open.html"
        with open(os.open(file, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="utf-8") as opened:
            opened.write(REDIRECT.format(html.escape(self.address)))
        return file

    def __exit__(self, *error: object) -> None:
        self.folder.cleanup()


def _listening(address: str, port: int) -> socket.socket:
    """A socket that is bound to an address of this computer.  Raises OSError if nothing can listen there."""
    family = socket.AF_INET6 if ":" in address else socket.AF_INET
    place = socket.getaddrinfo(address, port, family, socket.SOCK_STREAM, flags=socket.AI_PASSIVE)[0][4]
    return socket.create_server(place, family=family)


def _listen_to_terminal(call: Callable[[], None]) -> None:
    """Have a function called whenever the user presses Enter in the terminal."""
    loop, stdin = asyncio.get_running_loop(), sys.stdin

    def heard() -> None:
        if stdin.isatty() and os.getpgrp() != os.tcgetpgrp(stdin.fileno()):
            return  # in the background: what is typed is meant for another program
        if os.read(stdin.fileno(), 1000):
            call()
        else:  # closed
            loop.remove_reader(stdin)

    try:
        loop.add_reader(stdin, heard)
    except (NotImplementedError, OSError, ValueError) as error:  # Windows; no terminal, pipe or the like
        logging.getLogger("rattle").debug(f"Enter is not heard: {error}")


def own_addresses() -> set[str]:
    """Names and addresses of this computer in its network, for a studio that listens on all of them."""
    name = socket.gethostname()
    addresses = {name}
    try:
        addresses |= {str(entry[4][0]) for entry in socket.getaddrinfo(name, None, socket.AF_INET)}
    except OSError as error:
        logging.getLogger("rattle").debug(f"no addresses of {name}: {error}")
    return addresses
