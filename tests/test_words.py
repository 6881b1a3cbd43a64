"""What users read has the field's words: messages, help, guides and the comments of the examples."""

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

import rattle as rt

pytestmark = [pytest.mark.nojit, pytest.mark.plain]

ROOT = Path(__file__).parents[1]
SOURCES = Path(rt.__file__).parent
PLAIN = {  # what is not to be read -> what is
    r"\bwant(s|ed)\b": "expected, or needs",
    # "finite freedom dynamics" is a title, "1 freedom without a motor" stands in the status line of a drawing
    r"(?<!\bof )(?<!\bfinite )\bfreedoms?\b(?! without a motor)": "degrees of freedom",
    r"\b(positions? of rest|resting position)": "equilibrium",
    r"\bslow motion": "quasi-static",
    r"\b(taken|takes?) for granted": "assumed",
    r"\bran away\b": "diverged",
    r"\bsnaps over\b": "snap-through",
    r"\bno way on\b": "no continuation",
    r"\bcollector of garbage\b": "garbage collection",
}
DEFINED = {"docs/glossary.md"}  # where other words are explained


def messages(path: Path) -> Iterator[tuple[int, str]]:
    """Texts in a source file that users may come to read: all but docstrings, those of commands included."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    internal = set()
    if path.parent.name != "cli" and path.name != "command.py":
        for node in ast.walk(tree):
            if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and ast.get_docstring(node) is not None:
                internal.add(id(node.body[0].value))
    for node in ast.walk(tree):
        text = node.value if isinstance(node, ast.Constant) and id(node) not in internal else None
        if isinstance(text, str) and " " in text:
            yield node.lineno, text


@cache
def texts() -> list[tuple[str, int, str]]:
    return list(_texts())


def _texts() -> Iterator[tuple[str, int, str]]:
    for path in sorted(SOURCES.rglob("*.py")):
        for line, text in messages(path):
            yield str(path.relative_to(SOURCES)), line, text
    written = (path for path in (ROOT / "docs").rglob("*.md") if "generated" not in path.parts)  # others may be old
    pages = [*written, ROOT / "README.md", *(SOURCES / "examples").glob("*.toml")]
    for path in sorted(pages):
        name = path.relative_to(ROOT if ROOT in path.parents and "src" not in path.parts else SOURCES).as_posix()
        if name not in DEFINED:
            for line, text in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
                yield name, line, text


@pytest.mark.parametrize("pattern", PLAIN)
def test_messages_help_and_guides_use_the_words_of_the_field(pattern):
    found = [f"{name}:{line}: {text.strip()[:100]}" for name, line, text in texts() if re.search(pattern, text)]
    assert not found, f"say {PLAIN[pattern]}:\n" + "\n".join(found)


def test_the_words_are_looked_for_where_users_read():
    seen = {name for name, _, _ in texts()}
    assert {
        "description/read_values.py",
        "questions/equilibrium/command.py",
        "README.md",
        "docs/contact.md",
        "examples/toggle.toml",
    } <= seen
    said = [text for name, _, text in texts() if name == "questions/equilibrium/command.py"]
    assert any("FILE is a model file" in text for text in said)  # help texts are docstrings
    assert any("a plain number" in text for name, _, text in texts() if name == "description/read_values.py")
