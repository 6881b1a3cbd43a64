"""The engine in a browser: the same numbers as in node, in slices that leave the page alive, and an error in words."""

import base64
import json

import numpy as np
import pytest

from core_engine import by_machine_code, in_node, new
from rattle.pages.engine import engine_of_pages
from rattle.pages.replay import POLICY
from rattle.pages.run_image import run_image
from rattle.pages.viewer_text import joined, viewer_files

PAGE = """<!DOCTYPE html><meta charset="utf-8"><meta http-equiv="Content-Security-Policy" content="{policy}">
<link rel="icon" href="data:,"><script type="module">
{without}
{code}
const pause = () => new Promise((done) => setTimeout(done));
window.moved = async () => {{
  const engine = await openCore(await bytesFrom("{engine}"));
  const image = {{ description: {description}, content: await bytesFrom("{content}") }};
  const run = new CoreRun(engine, image), shares = [];
  while (!run.advance(2)) {{ shares.push(run.progress); await pause(); }}
  return {{ ...run.result(), rows: [...run.result().rows], shares }};
}};
window.refused = () => window.moved().then(() => null, (error) => ({{ reason: error.reason, message: error.message }}));
</script>"""


@pytest.fixture
def page_of(open_page, tmp_path):
    """A function that opens a page which moves a run; without: a line of JavaScript before all others."""

    def opened(run, without=""):
        image = run_image(run)
        letters = (base64.b64encode(one).decode() for one in (engine_of_pages(), image.content))
        engine, content = letters
        text = PAGE.format(
            policy=POLICY, without=without, code=joined(viewer_files(), "core_run.js"), engine=engine, content=content,
            description=json.dumps(image.description),
        )  # fmt: skip
        (tmp_path / "core.html").write_text(text, encoding="utf-8")
        return open_page((tmp_path / "core.html").as_uri())

    return opened


@pytest.mark.parametrize("name", ["fourbar_onesided", "slider_crank_oil"])
def test_a_browser_computes_what_node_computes(name, page_of, tmp_path):
    said, there, here = page_of(new(name)).evaluate("moved()"), in_node(tmp_path, new(name)), by_machine_code(new(name))
    assert said["statistics"] == there["statistics"] == here["statistics"]
    assert (np.array(said["rows"]) == there["rows"].ravel()).all()
    assert said["shares"] == sorted(said["shares"])


def test_a_browser_without_webassembly_is_told(page_of):
    said = page_of(new("ellipse"), "delete globalThis.WebAssembly;").evaluate("refused()")
    assert said == {"reason": "unsupported", "message": "this browser has no WebAssembly, which computes the motion"}
