"""Pages as PDF by a browser that is installed: Chromium, Chrome or Edge print without showing a window."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from rattle.atomic_file import atomic
from rattle.errors import MissingProgram

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "msedge", "microsoft-edge")
PLACES = (
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
    "/Applications/Microsoft Edge.app/Contents/MacOS/Microsoft Edge",
    "C:/Program Files/Google/Chrome/Application/chrome.exe",
    "C:/Program Files (x86)/Microsoft/Edge/Application/msedge.exe",
)
TIME = 120.0  # that a browser gets [s]


def browser() -> str | None:
    """A browser that prints: Chromium, Chrome or Edge; None if there is none."""
    program = next(filter(None, map(shutil.which, NAMES)), None)
    return program or next((place for place in PLACES if Path(place).is_file()), None)


def require_browser(path: Path) -> str:
    """The browser that prints.  Raises MissingProgram."""
    program = browser()
    if program is None:
        raise MissingProgram(
            f"{path}: a PDF is printed by a browser (Chromium, Chrome or Edge), and none was found; write"
            f" {path.with_suffix('.html').name} instead, open it in any browser and print it to a PDF"
        )
    return program


def print_pdf(page: str, path: Path, paper: str = "A4") -> None:
    """Print an HTML page (its text) to a PDF.  Raises MissingProgram, OSError with what the browser said."""
    program = require_browser(path)
    with tempfile.TemporaryDirectory() as folder:
        source, printed = Path(folder) / "page.html", Path(folder) / "page.pdf"
        source.write_text(page.replace("</style>", f"@page{{size:{paper}}}</style>", 1), encoding="utf-8")
        options = [
            "--headless", "--disable-gpu", "--disable-background-networking", "--no-first-run",
            "--no-pdf-header-footer", f"--user-data-dir={folder}/profile", f"--print-to-pdf={printed}",
        ]  # fmt: skip
        if sys.platform != "win32" and os.geteuid() == 0:
            options.append("--no-sandbox")  # Chromium refuses to run as root with it
        try:
            done = subprocess.run(
                [program, *options, source.as_uri()], capture_output=True, text=True, timeout=TIME, check=False
            )
            told = done.stderr.strip().splitlines()[-1:]
        except subprocess.TimeoutExpired:
            told = [f"no answer within {TIME:g} s"]
        if not printed.is_file():
            raise OSError(f"{path}: {Path(program).name} did not print it: {' '.join(told) or 'it gave no reason'}")
        with atomic(path) as file:
            file.write_bytes(printed.read_bytes())
