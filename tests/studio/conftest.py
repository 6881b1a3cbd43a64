"""A studio that is served in a folder of its own, for tests that ask it over the network."""

import http.client
import os
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import pytest
from studio_models import PENDULUM


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


@pytest.fixture(scope="session")
def studio(tmp_path_factory):
    """A studio with the model of a pendulum, and a file outside of its folder with a link to it."""
    pytest.importorskip("panel")
    outside = tmp_path_factory.mktemp("outside")
    (outside / "secret.toml").write_text(PENDULUM.replace("a pendulum", "a secret"))
    folder = tmp_path_factory.mktemp("studio")
    (folder / "m.toml").write_text(PENDULUM)
    (folder / "link.toml").symlink_to(outside / "secret.toml")
    served = start_studio(folder, "m.toml")
    yield served
    served.process.terminate()
    assert served.process.wait(10) == 0
