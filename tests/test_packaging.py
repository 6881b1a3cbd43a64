"""The package as a product: what an import costs, what is public, and that the README tells the truth."""

import inspect
import os
import re
import subprocess
import sys
from importlib import metadata, resources
from pathlib import Path

import click
import pytest

import rattle as rt
from rattle.cli.main import main
from rattle.pages import compiled_unit
from rattle.trace import fmu

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
HEAVY = {"numba", "scipy", "matplotlib", "tomlkit", "pandas", "xarray", "h5py", "tqdm"}

pytestmark = pytest.mark.nojit


def blocks(language: str) -> list[str]:
    """Fenced blocks of the README in one language."""
    return re.findall(rf"^```{language}\n(.*?)^```", README, re.DOTALL | re.MULTILINE)


def commands(program: str) -> list[list[str]]:
    """The README's shell lines that call `program`, as lists of words after it."""
    lines = "\n".join(blocks("sh")).splitlines()
    words = [line.split("#")[0].split() for line in lines]
    return [line[1:] for line in words if line[:1] == [program]]


def shell_commands() -> dict[str, click.Command]:
    """Every command of `rattle`; they are imported when asked for."""
    context = click.Context(main)
    found = {name: main.get_command(context, name) for name in main.list_commands(context)}
    return {name: command for name, command in found.items() if command is not None}


def modules_after(code: str) -> set[str]:
    """Names of all modules loaded once `code` has run in a fresh interpreter."""
    code += "\nimport sys\nprint(*sys.modules, file=sys.stderr)"
    run = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    return set(run.stderr.splitlines()[-1].split())


def test_importing_the_package_loads_nothing_heavy():
    assert not HEAVY & modules_after("import rattle")


def test_help_loads_nothing_heavy_and_not_even_numpy():
    code = "from rattle.cli.main import main\nmain(['--help'], standalone_mode=False)"
    assert not (HEAVY | {"numpy"}) & modules_after(code)


def test_version_is_the_installed_one():
    assert rt.__version__ == metadata.version("rattle")


def test_command_line_is_installed_as_rattle():
    (script,) = metadata.entry_points(group="console_scripts", name="rattle")
    assert script.load() is main


def test_package_runs_as_the_command():
    run = subprocess.run([sys.executable, "-m", "rattle", "--version"], check=True, capture_output=True, text=True)
    assert run.stdout.splitlines()[0].endswith(rt.__version__)


def test_types_are_shipped():
    assert (resources.files("rattle") / "py.typed").is_file()


def test_every_public_name_is_documented():
    assert len(set(rt.__all__)) == len(rt.__all__)
    missing = []
    for name in rt.__all__:
        thing = getattr(rt, name)
        if inspect.isclass(thing) or inspect.isroutine(thing):
            missing += [] if thing.__doc__ else [name]
        if inspect.isclass(thing):
            own = {key: value for key, value in vars(thing).items() if not key.startswith("_")}
            missing += [
                f"{name}.{key}"
                for key, value in own.items()
                if (inspect.isfunction(value) or isinstance(value, property)) and not value.__doc__
            ]
    assert not missing


def test_every_command_has_a_help_text_with_an_example():
    poor = [name for name, command in shell_commands().items() if f"rattle {name}" not in (command.help or "")]
    assert not poor


def test_readme_commands_exist():
    targets = set(re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
    asked = commands("make")
    assert asked
    assert {words[0] for words in asked} <= targets
    for name, *words in commands("rattle"):
        options = {option for parameter in shell_commands()[name].params for option in parameter.opts}
        assert {word for word in words if word.startswith("-")} <= options


def test_readme_points_at_files_that_exist():
    linked = re.findall(r"\]\(([^)#:]+)\)", README)
    assert linked
    assert not [path for path in linked if not (ROOT / path).exists()]


def test_readme_python_runs(tmp_path):
    code = "\n".join(blocks("python"))
    environment = os.environ | {"RATTLE_JIT": "native"}  # minutes without machine code
    run = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr


def test_the_sources_of_fmus_are_in_the_package():
    folder = resources.files("rattle") / "trace" / "fmu_sources"
    assert {*fmu.WRITTEN, *compiled_unit.WRITTEN} == {one.name for one in folder.iterdir()}
