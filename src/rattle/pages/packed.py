"""Bytes, compressed, in letters: what `bytesFrom` of viewer/core.js reads."""

from __future__ import annotations

import base64
import gzip

SAFE = str.maketrans("<>&`", "[]:,")  # letters of base85 that mean something in HTML or JavaScript


def packed(content: bytes) -> str:
    """Letters of base64 for compressed bytes, the same ones on every day."""
    return base64.b64encode(gzip.compress(content, 9, mtime=0)).decode("ascii")


def unpacked(letters: str) -> bytes:
    """The bytes that are `packed`."""
    return gzip.decompress(base64.b64decode(letters))


def lettered(text: str) -> str:
    """A text, compressed, in letters that stand as they are in HTML, JSON and JavaScript; for viewer/unpack.js.

    Five letters are four bytes, as in base85: a fifteenth shorter than base64.
    """
    return base64.b85encode(gzip.compress(text.encode(), 9, mtime=0)).decode("ascii").translate(SAFE)
