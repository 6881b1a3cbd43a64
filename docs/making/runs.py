"""Runs of the shipped examples, each made once per build."""

from __future__ import annotations

import re
import shlex
from functools import cache
from typing import Any, NamedTuple

import numpy as np

import rattle as rt

SHORTER = {"three_plays": "0.15 s"}  # 20 000 steps of Moreau-Jean take too long for a picture
POSITIONS = 181


class Header(NamedTuple):
    """The comment at the top of an example."""

    intro: str
    look: str
    commands: tuple[str, ...]
    source: str

    def words_of(self, command: str) -> list[str]:
        """Arguments after `rattle command` in the first line with that command; empty if there is none."""
        for line in self.commands:
            words = shlex.split(re.split(r"\s{2,}", line)[0])
            if words[:2] == ["rattle", command]:
                return words[2:]
        return []


@cache
def header(name: str) -> Header:
    """The parts of the comment at the top of an example."""
    text = rt.examples()[name].read_text(encoding="utf-8")
    lines = [line[2:] for line in text[: text.index("format = 1")].splitlines() if line.startswith("#")]
    parts: dict[str, list[str]] = {"intro": []}
    at = "intro"
    for line in lines:
        label = re.match(r"(Look at|Try|Source) +(.*)", line)
        if label:
            at = label[1]
            parts[at] = [label[2]]
        elif at != "intro" or (line.strip() and "drawing" not in parts):
            parts[at].append(line.strip())
        elif not line.strip():
            parts["drawing"] = []  # what follows the first empty line is a drawing
    commands = tuple(line for line in parts["Try"] if line.startswith("rattle "))
    return Header(" ".join(parts["intro"]), " ".join(parts["Look at"]), commands, " ".join(parts["Source"]))


class Run(NamedTuple):
    """The first analysis that the header of an example proposes, and its result."""

    command: str  # run | equilibrium | accuracy
    result: Any
    accuracy: Any = None


@cache
def run(name: str) -> Run:
    """The first analysis that the header of an example proposes."""
    mechanism, first = rt.example(name), next(line for line in header(name).commands if "rattle example" not in line)
    times = np.linspace(0.0, mechanism.model.settings.t_end, POSITIONS)
    if first.startswith("rattle accuracy"):
        words = header(name).words_of("accuracy")
        found = mechanism.accuracy(words[words.index("--of") + 1], times)
        return Run("accuracy", mechanism.ideal().kinematics(times), found)
    if first.startswith("rattle equilibrium"):
        slow = "--path" in first
        return Run("equilibrium", mechanism.equilibrium(times) if slow else mechanism.equilibrium()[0].result)
    return Run("run", mechanism.simulate(SHORTER.get(name)))
