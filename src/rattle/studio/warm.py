"""Imported by the process from which those of all sessions are made: they begin with machine code that is loaded."""

from __future__ import annotations

import logging

from rattle.loading import loads
from rattle.studio import worker  # noqa: F401  # what the processes import

PENDULUM = """format = 1
gravity = [0, -9.81]
[ground.points]
O = [0, 0]
[bodies.rod]
bar = ["A", "B"]
length = 1
mass = 1
[joints.O]
type = "revolute"
connect = ["ground.O", "rod.A"]
"""


def warm() -> None:
    """Run a small model once."""
    try:
        loads(PENDULUM).simulate(0.01)
    except Exception as error:  # a session will say what is wrong
        logging.getLogger("rattle").debug(f"nothing could be run: {error}")


warm()
