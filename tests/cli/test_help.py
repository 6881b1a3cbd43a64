"""Every example that a help text or the README gives is run as it stands, in one empty folder after the other."""

import re
import shlex
import shutil
from pathlib import Path

import click
import pytest
from click.testing import CliRunner

import foreign_texts
import rattle as rt
from rattle.cli.main import COMMANDS, main

ROOT = Path(__file__).parents[2]


def examples_of(command):
    """Lines of the help text that start with `rattle`, from "Example:" on."""
    text = main.get_command(click.Context(main), command).help or ""
    lines = text[text.index("Example") :].splitlines() if "Example" in text else []
    return [line.split("rattle ", 1)[1] for line in lines if "rattle " in line]


LONG = ("demo", "warmup", "studio")  # run, and their output looked at, in test_commands; studio: in tests/studio
SLOW = ("compare", "optimise", "poincare")  # of which other tests run shorter ones
LINES = [
    pytest.param(command, line, marks=[pytest.mark.long] if command in SLOW or k > 1 else [])
    for command in COMMANDS
    if command not in LONG
    for k, line in enumerate(examples_of(command))
]


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """A folder with what the examples work on: model files, files of other programs, results of the four-bar."""
    folder = tmp_path_factory.mktemp("help")
    (folder / "bars.asmt").write_text(foreign_texts.fourbar().text())
    (folder / "walker.json").write_text(foreign_texts.pylinkage())
    for name, path in rt.examples().items():
        shutil.copy(path, folder / f"{name}.toml")
    rt.example("fourbar").simulate("50 ms").save(folder / "out.nc")
    rt.example("fourbar").ideal().simulate("50 ms").save(folder / "ideal.nc")
    (folder / "measured.csv").write_text("t [ms];theta [deg]\n0;-60,1\n20;-64,4\n40;-66\n", encoding="utf-8")
    return folder


@pytest.mark.nojit
@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_gives_an_example_and_says_what_each_option_is_for(command):
    one = main.get_command(click.Context(main), command)
    assert examples_of(command), f"rattle {command} -h has no example"
    context = click.Context(one)
    records = [option.get_help_record(context) for option in one.params if isinstance(option, click.Option)]
    assert all(record[1] for record in records if record is not None)  # None: not shown


@pytest.mark.parametrize(("command", "line"), LINES)
def test_the_examples_of_the_help_run(command, line, results, monkeypatch):
    monkeypatch.chdir(results)
    line, _, target = line.partition(" > ")
    words = shlex.split(line)
    assert words[0] == command
    done = CliRunner().invoke(main, ["-q", *words])
    assert done.exit_code == 0, done.output
    if target:
        assert len(done.output) > 100
    for flag in ("-o", "--output"):
        if flag in words:
            made = results / words[words.index(flag) + 1]
            assert made.exists(), made


def test_the_commands_of_the_readme_run_one_after_the_other(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(
        r"^```sh\n(.*?)^```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE
    )
    lines = [line.partition("#")[0] for block in blocks for line in block.splitlines() if line.startswith("rattle ")]
    assert len(lines) >= 3
    for line in lines:
        done = CliRunner().invoke(main, ["-q", *shlex.split(line)[1:]])
        assert done.exit_code == 0, f"{line}\n{done.output}"
