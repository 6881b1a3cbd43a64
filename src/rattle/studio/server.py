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
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from bokeh.server.server import BaseServer
from bokeh.server.tornado import BokehTornado
from panel.io.application import build_applications
from tornado.httpserver import HTTPServer
from tornado.httputil import HTTPHeaders, HTTPServerRequest
from tornado.ioloop import IOLoop
from tornado.netutil import bind_sockets
from tornado.web import OutputTransform

from rattle.studio.guard import LOOPBACK, Guard, Secrets

LARGEST_MESSAGE = 20_000_000  # from the page, over its web socket [bytes]; a model text has at most 8 MB
LARGEST_BODY = 100_000  # of a request; none has a body [bytes]
IDLE = 30.0  # a connection that asks for nothing, or never ends to ask, is closed after this time [s]
LIFETIME = 4000  # a session without a page ends after this time [ms]
LOOK = 1000  # how often sessions without a page are looked for [ms]
REDIRECT = """<!doctype html><meta charset="utf-8"><title>rattle studio</title>
<meta name="referrer" content="no-referrer">
<meta http-equiv="refresh" content="0;url={0}"><a href="{0}">Open the studio</a>
"""
GRACE = 3.0  # for whatever still works when the studio is told to end [s]


class Server:
    """A studio that is served: `new_address` is what the user opens.

    make_page: makes the page of one session, a Panel object; called once for every page that is opened.
    """

    def __init__(self, make_page: Callable[[], Any], address: str = "127.0.0.1", port: int = 0) -> None:
        sockets = bind_sockets(port, address, family=socket.AF_INET if ":" not in address else socket.AF_INET6)
        self.port: int = sockets[0].getsockname()[1]
        self.keys = Secrets()
        self.host = f"[{address}]" if ":" in address else address
        names = {*LOOPBACK, self.host} if self.host not in ("0.0.0.0", "[::]") else {*LOOPBACK, *own_addresses()}
        here = sorted(f"{name}:{self.port}" for name in names)
        self.application = BokehTornado(
            build_applications({"/": make_page}, title={"/": "rattle studio"}, location=False),
            extra_websocket_origins=here, use_index=False, redirect_root=False,
            websocket_max_message_size_bytes=LARGEST_MESSAGE, unused_session_lifetime_milliseconds=LIFETIME,
            check_unused_sessions_milliseconds=LOOK, include_headers=[], include_cookies=[], prefix=self.keys.place,
        )  # fmt: skip
        guard = Guard(self.application, self.keys, names, self.port)
        self.application.add_transform(partial(_WithHeaders, guard.headers()))
        self.http = HTTPServer(guard, max_body_size=LARGEST_BODY, max_header_size=32_000, idle_connection_timeout=IDLE)
        self.http.add_sockets(sockets)
        self.loop = IOLoop.current()
        self.bokeh = BaseServer(self.loop, self.application, self.http)
        self.bokeh.start()

    def new_address(self) -> str:
        """What to open in a browser, with a token that is good for one use."""
        shown = "127.0.0.1" if self.host == "0.0.0.0" else "[::1]" if self.host == "[::]" else self.host
        return f"http://{shown}:{self.port}/?token={self.keys.issue()}"

    def heed(self) -> None:
        """From now on Ctrl-C and SIGTERM end `run`, also before it has begun."""
        loop = asyncio.get_event_loop()
        for one in (signal.SIGINT, signal.SIGTERM):
            try:
                loop.add_signal_handler(one, self.loop.stop)
            except NotImplementedError:  # Windows
                signal.signal(one, lambda *_: self.loop.add_callback_from_signal(self.loop.stop))

    def at_enter(self, call: Callable[[], None]) -> None:
        """Have a function called whenever the user presses Enter in the terminal."""
        loop, stdin = asyncio.get_event_loop(), sys.stdin

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

    def run(self, open_browser: bool) -> None:
        """Serve until Ctrl-C or SIGTERM."""
        if not open_browser:
            self.loop.start()
            return
        with Redirect(self.new_address()) as file:
            threading.Thread(target=webbrowser.open, args=(file.as_uri(),), daemon=True).start()
            self.loop.start()

    def close(self) -> None:
        """Stop listening, and close what is open."""
        self.bokeh.stop(wait=False)
        self.loop.run_sync(self.http.close_all_connections, timeout=GRACE)


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


class _WithHeaders(OutputTransform):
    """Adds the headers of the guard to every answer of the application."""

    def __init__(self, added: dict[str, str], request: HTTPServerRequest) -> None:
        self.added = added

    def transform_first_chunk(
        self, status_code: int, headers: HTTPHeaders, chunk: bytes, finishing: bool
    ) -> tuple[int, HTTPHeaders, bytes]:
        """Tornado calls this before it sends the first part of an answer."""
        for name, value in self.added.items():
            headers[name] = value
        if headers.get("Content-Type", "").startswith("text/html"):
            headers["Cache-Control"] = "no-store"
        return status_code, headers, chunk


def own_addresses() -> set[str]:
    """Names and addresses of this computer in its network, for a studio that listens on all of them."""
    name = socket.gethostname()
    found = {name}
    try:
        found |= {str(one[4][0]) for one in socket.getaddrinfo(name, None, socket.AF_INET)}
    except OSError as error:
        logging.getLogger("rattle").debug(f"no addresses of {name}: {error}")
    return found
