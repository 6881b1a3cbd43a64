"""A model that tests of the studio share, and a studio that is served."""

import http.client
import os
import subprocess
import sys
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

PENDULUM = """# a pendulum; this comment stays
format = 1
name = "a pendulum"
gravity = [0, -9.81]

[parameters]
l = { value = "1 m", min = "0.2 m", max = "2 m" }    # length

[ground.points]
O = [0, 0]

[bodies.rod]
bar = ["A", "B"]
length = "l"
mass = 1

[joints.O]
type = "revolute"
connect = ["ground.O", "rod.A"]

[simulate]
t_end = "1 s"
"""


@dataclass
class Served:
    """A running studio: the address that it printed first, which works once."""

    process: subprocess.Popen
    address: str
    port: int
    folder: Path

    def ask(self, path: str, method: str = "GET", **headers: str) -> http.client.HTTPResponse:
        """The answer to one request; headers are written with _ for -, Host is ours unless given."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=10)
        try:
            connection.putrequest(method, path, skip_host=True)
            given = {"Host": f"127.0.0.1:{self.port}", **{k.replace("_", "-"): v for k, v in headers.items()}}
            for name, value in given.items():
                connection.putheader(name, value)
            connection.endheaders()
            answer = connection.getresponse()
            answer.text = answer.read().decode(errors="replace")
            return answer
        finally:
            connection.close()

    def new_address(self) -> str:
        """Another address, as Enter in the terminal gives it."""
        self.process.stdin.write("\n")
        self.process.stdin.flush()
        return next_address(self.process)

    def new_token(self) -> str:
        return self.new_address().partition("token=")[2]

    @cached_property
    def entered(self) -> tuple[str, str]:
        """The place of the page and the cookie, which a token is exchanged for."""
        answer = self.ask(f"/?token={self.new_token()}")
        return answer.headers["Location"].rstrip("/"), answer.headers["Set-Cookie"].partition(";")[0]

    @property
    def place(self) -> str:
        return self.entered[0]

    @property
    def cookie(self) -> str:
        return self.entered[1]


def next_address(process: subprocess.Popen) -> str:
    """The next address that a studio prints; between two of them it may say that a page was closed, or the like."""
    return next(line.split()[-1] for line in process.stdout if line.startswith("rattle studio: http"))


def start_studio(folder: Path, *arguments: str, **environment: str) -> Served:
    """Start a studio in a folder, and wait for its address."""
    process = subprocess.Popen(
        [sys.executable, "-m", "rattle", "studio", *arguments], cwd=folder, stdin=subprocess.PIPE,
        stdout=subprocess.PIPE, text=True, env={**os.environ, "PYTHONUNBUFFERED": "", **environment},
    )  # fmt: skip
    address = next_address(process)
    port = int(address.partition("://127.0.0.1:")[2].partition("/")[0])
    return Served(process, address, port, folder)
