"""Mechanisms from model files, texts and the shipped examples."""

from __future__ import annotations

import os
from pathlib import Path

from rattle.description import file as model_file
from rattle.errors import InputError, suggest
from rattle.mechanism import Mechanism
from rattle.wrong_arguments import answer_in_words


def load(path: str | os.PathLike[str]) -> Mechanism:
    """Read a model file (TOML or JSON). Raises ModelError with every problem, its line and a caret."""
    text, file = model_file.read_file(path)
    return Mechanism.from_text(text, file)


def loads(text: str) -> Mechanism:
    """Read model text (TOML or JSON). Raises ModelError."""
    return Mechanism.from_text(text)


def examples() -> dict[str, Path]:
    """Shipped model files by name."""
    return {path.stem: path for path in sorted((Path(__file__).parent / "examples").glob("*.toml"))}


@answer_in_words
def example(name: str) -> Mechanism:
    """A shipped example. Raises InputError for an unknown name."""
    shipped = examples()
    if name not in shipped:
        raise InputError(f"no example '{name}'{suggest(str(name), shipped)}")
    return load(shipped[name])
