"""Serve a studio for one folder until it is told to end."""

from __future__ import annotations

import sys
import threading
from pathlib import Path
from weakref import WeakSet

import click

from rattle.loading import examples
from rattle.studio.bench import prepare
from rattle.studio.desk import Desk, example_text
from rattle.studio.folder import Folder
from rattle.studio.page import PATHS, application, aside
from rattle.studio.server import Server
from rattle.user_paths import expanded
from rattle.value_types import Plain

SWITCH = (
    5e-4  # how soon a thread that reads a long text lets the server answer other pages [s]; Python's is ten times that
)
FIRST = "crank_rocker_play"  # example that a studio without a file begins with


def serve(file: str | None, address: str, port: int, open_browser: bool) -> None:
    """Serve the studio with a model file, or the example of that name; prints its address.

    The folder of the studio is where it was started; that of the file if the file is elsewhere.
    Raises ModelError if the file cannot be read, Refused if it is no model file, OSError if nothing can listen there.
    """
    root = Path.cwd().resolve()
    text, name = "", ""
    if file is None or (file in examples() and not Path(file).exists()):
        text = example_text(examples()[file or FIRST])
    else:
        place = expanded(file).resolve()
        root = root if place.is_relative_to(root) else place.parent
        name = place.relative_to(root).as_posix()
        text = Folder(root).read(name)
    folder = Folder(root)
    desks: WeakSet[Desk] = WeakSet()  # of pages that are open

    def make_desk(**wires: Plain) -> Desk:
        desk = Desk(folder, **wires)
        desk.draft.begin(folder.read(name) if name else text, name)
        desks.add(desk)
        return desk

    def tell_address() -> None:
        click.echo(f"rattle studio: {server.new_address()}")

    server = Server(application(make_desk), PATHS, address, port)
    server.heed()
    threading.Thread(target=prepare, daemon=True).start()
    tell_address()
    sys.setswitchinterval(SWITCH)
    try:
        server.run(open_browser, tell_address)
    finally:
        for desk in list(desks):
            desk.end()
        aside.shutdown(wait=False, cancel_futures=True)
