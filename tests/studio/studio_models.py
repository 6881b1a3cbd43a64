"""A model that tests of the studio share, and a studio that is served."""

import http.client
import os
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

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


class Served(NamedTuple):
    """A running studio."""

    process: subprocess.Popen
    address: str
    port: int
    token: str
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

    def cookie(self) -> str:
        """The cookie that the token is exchanged for."""
        return self.ask(f"/?token={self.token}").headers["Set-Cookie"].partition(";")[0]


def start_studio(folder: Path, *arguments: str) -> Served:
    """Start a studio in a folder, and wait for its address."""
    process = subprocess.Popen(
        [sys.executable, "-m", "rattle", "studio", *arguments, "--no-browser"], cwd=folder, stdout=subprocess.PIPE,
        text=True, env={**os.environ, "PYTHONUNBUFFERED": ""},
    )  # fmt: skip
    address = process.stdout.readline().split()[-1]
    port = int(address.partition("://127.0.0.1:")[2].partition("/")[0])
    return Served(process, address, port, address.partition("token=")[2], folder)
