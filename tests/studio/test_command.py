"""The command `rattle studio`: what it says before it serves."""

import subprocess
import sys

import pytest
from click.testing import CliRunner

from rattle.cli.main import main

pytestmark = [pytest.mark.nojit, pytest.mark.plain]


def test_beyond_this_computer_it_warns_and_asks(monkeypatch):
    pytest.importorskip("uvicorn")
    served = []
    monkeypatch.setitem(sys.modules, "rattle.studio.serve", type("Serve", (), {"serve": lambda *a: served.append(a)}))
    done = CliRunner().invoke(main, ["studio", "--address", "0.0.0.0"], input="n\n")
    assert done.exit_code != 0
    assert "other computers can reach it" in done.output
    assert served == []
    done = CliRunner().invoke(main, ["studio", "--address", "0.0.0.0", "--no-browser"], input="y\n")
    assert (done.exit_code, served) == (0, [(None, "0.0.0.0", 0, False)])
    served.clear()
    done = CliRunner().invoke(main, ["studio", "fourbar", "--port", "8123"])
    assert (done.output, served) == ("", [("fourbar", "127.0.0.1", 8123, True)])  # here nothing is asked


@pytest.mark.parametrize("missing", ["uvicorn", "starlette", "websockets"])
def test_without_its_packages_it_says_how_to_install_them(monkeypatch, missing):
    pytest.importorskip("uvicorn")  # which comes first, and would be missing too
    monkeypatch.setitem(sys.modules, missing, None)
    done = CliRunner().invoke(main, ["studio"])
    assert done.exit_code == 2
    assert f"rattle studio needs {missing}; install it with: pip install uvicorn starlette websockets" in done.output


def test_a_file_that_is_not_there_or_no_model_is_named(tmp_path, monkeypatch):
    pytest.importorskip("uvicorn")
    monkeypatch.chdir(tmp_path)
    for name in ("nowhere.toml", "notes.txt"):
        done = CliRunner().invoke(main, ["studio", name, "--no-browser"])
        assert done.exit_code == 2
        assert name.partition(".")[0] in done.output


def test_opening_the_studio_loads_nothing_that_takes_long():
    """It is there in half a second; packages that compute and draw are loaded by the processes of its pages."""
    pytest.importorskip("uvicorn")
    program = "import rattle.cli.main, rattle.studio.serve, sys; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert not {"llvmlite", "matplotlib", "numba", "pandas", "scipy", "xarray"} & set(done.stdout.split())
