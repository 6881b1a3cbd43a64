"""Paths as users write them."""

from __future__ import annotations

import os
from pathlib import Path


def expanded(path: str | os.PathLike[str]) -> Path:
    """The path with `~` and `~user` replaced by a home folder; as shells have it, unchanged where there is none.

    So a file whose own name begins with a tilde can be read and written, and what is not there is said to be missing.
    """
    return Path(os.path.expanduser(path))
