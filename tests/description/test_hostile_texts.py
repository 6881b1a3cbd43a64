"""No text can bring the reader or the assembly down: what is wrong is refused in words, at its place."""

from __future__ import annotations

import json
import os
import random
import subprocess
import sys
from pathlib import Path

import pytest

import mutants
import rattle as rt

FEW, MANY = 200, 3000
SEED = 20261123
MEMORY = 6 << 30  # bytes of address space of a child: several times what the largest example takes
PATIENCE = 1500.0  # [s] of a child, a hundred times what it takes

PENDULUM = """format = 1
gravity = [0, -9.81]
[parameters]
a = "0.2 m"
b = %s
[ground.points]
O = [%s, 0]
[bodies.rod]
bar = ["A", "B"]
length = "2*a"
mass = %s
[joints.O]
type = "revolute"
connect = ["ground.O", "rod.A"]
"""
RATCHET = rt.example("ratchet").to_toml()
CAM = rt.example("cam_lift_off").to_toml()


def pendulum(b="1", x="0", mass="1"):
    return PENDULUM % (b, x, mass)


def with_line(text, begin, new):
    """The text in which the line that begins so is another."""
    lines = text.split("\n")
    k = next(k for k, line in enumerate(lines) if line.replace(" ", "").startswith(begin))
    lines[k] = new
    return "\n".join(lines)


# ---------------------------------------------------------------- texts that once were not refused in words
@pytest.mark.parametrize(
    ("text", "key", "words"),
    [
        (with_line(RATCHET, "teeth=", 'teeth = "nosuch"'), "teeth", "nosuch"),
        (with_line(CAM, "R=", 'R = "15 parsec"'), "parameters.R", "parsec"),
        (pendulum(b='{ value = "2*a", min = "1 mi" }'), "parameters.b.min", "mi"),
        (pendulum(b='{ value = "2*a", min = "nan mm" }'), "parameters.b.min", "finite"),
        (pendulum(b='{ value = "2*a", max = "1e400" }'), "parameters.b.max", ""),
        (pendulum(b='{ value = "2*a", tol = "-inf" }'), "parameters.b.tol", ""),
        (pendulum(mass="5e-324"), "bodies.rod.mass", "numbers that can be computed with"),
        (pendulum(mass="1e300"), "bodies.rod.mass", "numbers that can be computed with"),
        (pendulum(x="1e155"), "ground.points.O[0]", "numbers that can be computed with"),
        (pendulum(x='"-1e308 m"'), "ground.points.O[0]", "numbers that can be computed with"),
    ],
)  # fmt: skip
def test_the_place_and_the_reason_are_named(text, key, words, tmp_path):
    file = tmp_path / "m.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(rt.ModelError) as caught:
        rt.load(file)
    named = [one for one in caught.value.problems if one.key.endswith(key)]
    assert named, str(caught.value)
    assert words in named[0].message
    assert named[0].line
    assert f"{file}:{named[0].line}: " in str(caught.value)


def test_a_field_of_a_kind_is_looked_at_only_if_all_fields_are_sound():
    """A parameter that is missing is all that is said, not what follows from it."""
    text = "\n".join(line for line in RATCHET.split("\n") if not line.replace(" ", "").startswith("teeth="))
    with pytest.raises(rt.ModelError) as caught:
        rt.loads(text)
    assert all("nan" not in one.message for one in caught.value.problems)


@pytest.mark.parametrize("x", ["1e20", "1e50"])
def test_a_mechanism_farther_away_than_its_digits_reach_is_not_called_assembled(x):
    with pytest.raises(rt.AssemblyError, match="no digits left for its lengths of"):
        rt.loads(pendulum(x=x)).check()


def test_a_mechanism_a_million_kilometres_away_is_assembled():
    assert rt.loads(pendulum(x="1e9")).check().residual < 1e-6


@pytest.mark.parametrize(
    "name", ["slider_crank_oil", "stribeck", "squeezer", "three_plays", "journal_falls", "fourbar"]
)
@pytest.mark.parametrize("number", ["1e-59", "1e59"])
def test_numbers_of_the_largest_and_least_size_bring_no_exception_and_no_line_of_lapack(name, number, capfd):
    """Every mass, length and clearance in turn is as large or small as one may be."""
    text = rt.example(name).to_toml()
    lines = text.split("\n")
    places = [k for k, line in enumerate(lines) if line.partition("=")[0].strip() in ("mass", "inertia", "clearance")]
    assert places
    for k in random.Random(SEED).sample(places, min(4, len(places))):
        key = lines[k].partition("=")[0]
        mutants.answer("\n".join([*lines[:k], f"{key}= {number}", *lines[k + 1 :]]))
    shown = capfd.readouterr()
    assert "On entry to" not in shown.out + shown.err


# ---------------------------------------------------------------- mutants of all examples
def run_of_mutants(count: int, seed: int) -> list[dict[str, str]]:
    """What a child process found among mutants: those that were answered by no answer of ours."""
    here = Path(__file__).parent.parent
    words = [sys.executable, str(here / "mutants.py"), str(count), str(seed), str(MEMORY)]
    paths = os.pathsep.join([str(Path(rt.__file__).parents[1]), os.environ.get("PYTHONPATH", "")])
    child = subprocess.run(
        words, capture_output=True, text=True, timeout=PATIENCE, check=False, env={**os.environ, "PYTHONPATH": paths}
    )
    assert child.returncode == 0, child.stderr[-2000:]
    assert "On entry to" not in child.stdout + child.stderr
    report = json.loads(child.stdout.splitlines()[-1])
    assert report["refused"] > count // 4
    assert report["sound"] > count // 10
    found: list[dict[str, str]] = report["escapes"]
    return found


def told(escapes: list[dict[str, str]]) -> str:
    return "\n".join(f"{one['example']} {one['number']}: {one['error']}" for one in escapes)


def test_hundreds_of_mutants_of_all_examples_are_answered():
    escapes = run_of_mutants(FEW, SEED)
    assert not escapes, told(escapes)


@pytest.mark.long
def test_thousands_of_mutants_of_all_examples_are_answered():
    escapes = run_of_mutants(MANY, SEED + 1)
    assert not escapes, told(escapes)
