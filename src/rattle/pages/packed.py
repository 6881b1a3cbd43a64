"""Bytes, compressed, in letters: what `bytesFrom` of viewer/core.js reads."""

from __future__ import annotations

import base64
import gzip


def packed(content: bytes) -> str:
    """Letters of base64 for compressed bytes, the same ones on every day."""
    return base64.b64encode(gzip.compress(content, 9, mtime=0)).decode("ascii")
