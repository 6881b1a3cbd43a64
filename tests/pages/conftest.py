"""What tests of pages need: node for the pure parts of the viewer."""

import json
import shutil
import subprocess

import pytest

from rattle.pages.viewer_text import viewer_text


@pytest.fixture
def viewer_in_node(tmp_path):
    """A function that runs a script which may import ./viewer.mjs, and gives back what it prints as JSON."""
    if shutil.which("node") is None:
        pytest.skip("node is not installed")
    (tmp_path / "viewer.mjs").write_text(viewer_text(), encoding="utf-8")

    def run(script, data=None):
        (tmp_path / "data.json").write_text(json.dumps(data), encoding="utf-8")
        head = 'import fs from "node:fs";\nconst data = JSON.parse(fs.readFileSync("data.json", "utf8"));\n'
        (tmp_path / "script.mjs").write_text(head + script, encoding="utf-8")
        done = subprocess.run(
            ["node", "script.mjs"], cwd=tmp_path, capture_output=True, text=True, timeout=60, check=False
        )
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    return run
