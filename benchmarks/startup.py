"""What a user waits for before anything is computed: imports, commands, the first compilation."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from functools import partial
from pathlib import Path

from measure import Row, interleave, timed

PYTHON = sys.executable
RATTLE = str(Path(PYTHON).with_name("rattle"))
BARE = "python -c pass"


def rows(repeats: int) -> list[Row]:
    """Start-up times, each against a Python that does nothing."""
    with tempfile.TemporaryDirectory() as folder:
        environment = os.environ | {"RATTLE_CACHE": str(Path(folder) / "cache")}
        run = partial(subprocess.run, check=True, cwd=folder, env=environment, stdin=subprocess.DEVNULL)
        quiet = partial(run, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        model = run([RATTLE, "example", "fourbar"], stdout=subprocess.PIPE, text=True).stdout
        (Path(folder) / "fourbar.toml").write_text(model, encoding="utf-8")

        cold = timed(partial(quiet, [RATTLE, "warmup"]))()
        commands = {
            BARE: [PYTHON, "-c", "pass"],
            'python -c "import rattle"': [PYTHON, "-c", "import rattle"],
            "rattle --help": [RATTLE, "--help"],
            "rattle check fourbar.toml": [RATTLE, "check", "fourbar.toml"],
            "rattle run fourbar.toml": [RATTLE, "run", "fourbar.toml"],
        }
        aims = ["0.15 s", "0.1 s", "0.3 s", "1.5 s"]
        median = interleave({name: timed(partial(quiet, words)) for name, words in commands.items()}, repeats)
    bare = median.pop(BARE)
    table = [Row(name, time, BARE, bare, aim) for (name, time), aim in zip(median.items(), aims, strict=True)]
    return [*table, Row("rattle warmup, nothing compiled yet", cold, BARE, bare, "25 s")]
