"""Names of files that begin with a tilde: a home folder where there is one, and otherwise a name like any other."""

from pathlib import Path

import pytest
from click.testing import CliRunner

import rattle as rt
from rattle.cli.main import main
from rattle.loading import examples
from rattle.user_paths import expanded

pytestmark = pytest.mark.nojit
NOBODY = "~nobody-of-this-name"


@pytest.fixture(autouse=True)
def _in_a_folder_of_its_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def call(*words):
    return CliRunner().invoke(main, words)


def test_a_tilde_is_the_home_folder_where_there_is_one(monkeypatch):
    monkeypatch.setenv("HOME", "/home/of/mine")
    monkeypatch.setenv("USERPROFILE", "/home/of/mine")
    assert expanded("~/m.toml") == Path("/home/of/mine/m.toml")
    assert expanded(f"{NOBODY}.toml") == Path(f"{NOBODY}.toml")


def test_a_file_whose_name_begins_with_a_tilde_is_read_and_written():
    model, saved = f"{NOBODY}.toml", f"{NOBODY}.npz"
    Path(model).write_text(examples()["double_pendulum"].read_text())
    assert call("check", model).exit_code == 0
    assert call("draw", model, "-o", f"{NOBODY}.svg").exit_code == 0
    assert call("run", model, "--t-end", "10 ms", "-o", saved).exit_code == 0
    assert call("export", saved, "-o", f"{NOBODY}.csv").exit_code == 0
    assert len(rt.load_result(saved).t) > 1


@pytest.mark.parametrize(
    "words", [("check", NOBODY), ("check", f"{NOBODY}.toml"), ("plot", f"{NOBODY}.npz", "x"), ("plot", ".", "x")]
)
def test_what_is_not_there_is_said_to_be_missing(words):
    answer = call(*words)
    assert answer.exit_code == 2
    assert isinstance(answer.exception, SystemExit)
    assert "o such file" in answer.output or "no file" in answer.output


def test_a_folder_that_is_not_there_is_named():
    with pytest.raises(OSError, match=f"the folder {NOBODY} does not exist"):
        rt.example("double_pendulum").simulate(0.01).save(f"{NOBODY}/r.npz")
