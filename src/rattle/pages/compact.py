"""JavaScript without what only people need: comments and spaces; every line stays a line.

Texts, templates and regular expressions are copied as they are.  Line ends stay, so that no statement ends elsewhere.
"""

from __future__ import annotations

import re

TOKEN = re.compile(
    r"""(?P<comment>//[^\n]*|/\*.*?\*/)|(?P<text>"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*')|(?P<template>`)|(?P<space>\s+)"""
    r"""|(?P<word>[\w$]+)|(?P<other>.)""",
    re.DOTALL,
)
PATTERN = re.compile(r"/(?:\\.|\[(?:\\.|[^\]\\\n])*\]|[^/\\\[\n])+/[a-z]*")
BEFORE_PATTERN = set("(,=:[!&|?{};+-*%~^<>") | {"return", "typeof", "case", ""}


def compact(text: str) -> str:
    """The same program in fewer characters."""
    pieces: list[str] = []
    at, last = 0, ""  # last: the piece before, without spaces
    gap = ""  # what stands between it and the next
    while at < len(text):
        match = TOKEN.match(text, at)
        if match is None:  # never: the last case takes any character
            break
        kind, piece = match.lastgroup, match.group()
        if kind == "template":
            piece = text[at : _end_of_template(text, at)]
        elif piece == "/" and last in BEFORE_PATTERN and (pattern := PATTERN.match(text, at)):
            piece = pattern.group()
        at += len(piece)
        if kind in ("comment", "space"):
            gap = "\n" if "\n" in gap + piece else " "
            continue
        if pieces and gap and (gap == "\n" or _apart(pieces[-1], piece)):
            pieces.append(gap)
        pieces.append(piece)
        last, gap = piece, ""
    return "".join(pieces) + "\n"


def _apart(piece: str, other: str) -> bool:
    """True if two pieces would become another one without a space."""
    word = re.compile(r"[\w$]")
    return bool(word.match(piece[-1]) and word.match(other[0])) or (piece[-1] == other[0] and piece[-1] in "+-/")


def _end_of_template(text: str, start: int) -> int:
    """Where a template ends that starts there; texts and templates in its expressions too."""
    at, depth = start + 1, 0
    while True:
        if text[at] == "\\":
            at += 2
        elif depth == 0 and text[at] == "`":
            return at + 1
        elif depth == 0 and text.startswith("${", at):
            depth, at = 1, at + 2
        elif depth and text[at] == "`":
            at = _end_of_template(text, at)
        elif depth and text[at] in "\"'":
            token = TOKEN.match(text, at)
            at = token.end() if token else at + 1
        else:
            depth += (text[at] == "{") - (text[at] == "}") if depth else 0
            at += 1
