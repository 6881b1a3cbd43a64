"""Bytes, compressed, in letters: what `bytesFrom` of viewer/core.js reads."""

from __future__ import annotations

import base64
import gzip
import json
from typing import Any

SAFE = str.maketrans("<>&`", "[]:,")  # letters of base85 that mean something in HTML or JavaScript


def packed(content: bytes) -> str:
    """Letters of base64 for compressed bytes, the same ones on every day."""
    return base64.b64encode(gzip.compress(content, 9, mtime=0)).decode("ascii")


def as_json(data: Any) -> str:
    """JSON in which bytes are `packed`."""
    return json.dumps(data, separators=(",", ":"), allow_nan=False, default=packed)


def lettered(text: str) -> str:
    """A text, compressed, in letters that stand as they are in HTML, JSON and JavaScript; for viewer/unpack.js.

    Five letters are four bytes, as in base85: a fifteenth shorter than base64.
    """
    return base64.b85encode(gzip.compress(text.encode(), 9, mtime=0)).decode("ascii").translate(SAFE)
