"""The page of the studio, and the web socket of every page that is open: messages as JSON in both directions."""

from __future__ import annotations

import asyncio
import base64
import json
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from importlib import resources
from typing import Any

import numpy as np
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect

from rattle.pages.scene import plain
from rattle.pages.viewer_text import viewer_text
from rattle.studio.desk import Desk, Message
from rattle.studio.tabs import forms


def _declared() -> str:
    head = "// The tabs that are computed, and what can be asked of each.\n"
    return f"{head}export const DECLARED = {json.dumps(forms())};\n"


FOLDER = resources.files("rattle.studio") / "page"
FIRST = "studio.html"
MADE: dict[str, Callable[[], str]] = {"viewer.js": viewer_text, "declared.js": _declared}
TYPES = {"html": "text/html", "js": "text/javascript", "css": "text/css", "svg": "image/svg+xml"}
FILES = {file.name for file in FOLDER.iterdir() if file.name.rpartition(".")[2] in TYPES} | {*MADE}
PATHS = frozenset({"/", "/ws"} | {f"/{name}" for name in FILES - {FIRST}})
aside = ThreadPoolExecutor(8, "studio")  # reads texts and files for all sessions: no page waits for another


def application(make_desk: Callable[..., Desk]) -> Starlette:
    """What answers at `PATHS`.  make_desk: makes the desk of one session, see `Desk`."""

    async def socket(connection: WebSocket) -> None:
        await Session(connection, make_desk).serve()

    return Starlette(routes=[WebSocketRoute("/ws", socket), Route("/", _file), Route("/{name}", _file)])


async def _file(request: Request) -> Response:
    name = request.path_params.get("name", FIRST)
    return Response(_text_of(name), media_type=TYPES[name.rpartition(".")[2]])


@cache
def _text_of(name: str) -> str:
    return MADE[name]() if name in MADE else (FOLDER / name).read_text(encoding="utf-8")


class Session:
    """One page that is open: its desk, and the messages to it in their order."""

    def __init__(self, connection: WebSocket, make_desk: Callable[..., Desk]) -> None:
        self.connection = connection
        self.loop = asyncio.get_running_loop()
        self.outbox: asyncio.Queue[Message] = asyncio.Queue()
        self.desk = make_desk(send=self.outbox.put_nowait, later=self._later, post=self._post)

    async def serve(self) -> None:
        """Hear and answer until the page is closed."""
        await self.connection.accept()
        try:
            async with asyncio.TaskGroup() as tasks:
                sending = tasks.create_task(self._send_all())
                await self._hear_all()
                sending.cancel()
        except* WebSocketDisconnect:  # while something was sent
            pass
        finally:
            self.desk.end()

    async def _hear_all(self) -> None:
        while (message := await self.connection.receive())["type"] == "websocket.receive":
            self.desk.hear(_parsed(message.get("text") or ""))

    async def _send_all(self) -> None:
        while True:
            await self.connection.send_text(as_json(await self.outbox.get()))

    # ------------------------------------------------------------ threads
    def _post(self, call: Callable[[], None]) -> None:
        """Have a function called in the thread of the page; callable from any thread."""
        if not self.desk.bench.ended and not self.loop.is_closed():
            self.loop.call_soon_threadsafe(call)

    def _later(self, function: Callable[[], Any], then: Callable[[Any], None]) -> None:
        """Have a function called aside, and then the other with what it returned."""
        aside.submit(function).add_done_callback(lambda done: self._post(lambda: then(done.result())))


def as_json(message: Message) -> str:
    """A message to the page; arrays are packed, numbers that are not finite are null elsewhere.

    In ASCII: a text from the editor may hold half a character, which UTF-8 cannot.
    """
    return json.dumps(plain(message), separators=(",", ":"), allow_nan=False, default=_packed)


def _packed(array: np.ndarray) -> dict[str, str]:
    return {"f8": base64.b64encode(array.astype("<f8").tobytes()).decode()}


def _parsed(text: str) -> Any:
    """What a message of the page says; None if it is no JSON, which the desk answers."""
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        return None
