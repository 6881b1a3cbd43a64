"""Imported by the process from which those of all sessions are made: they begin with machine code that is loaded."""

from __future__ import annotations

import logging

from rattle.loading import loads
from rattle.studio import worker  # noqa: F401  # what the processes import
from rattle.studio.draft import EMPTY


def warm() -> None:
    """Run a small model once."""
    try:
        loads(EMPTY).simulate(0.01)
    except Exception as error:  # a session will say what is wrong
        logging.getLogger("rattle").debug(f"nothing could be run: {error}")


warm()
