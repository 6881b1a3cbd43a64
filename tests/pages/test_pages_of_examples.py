"""Every shipped example as a page: it plays, every view of it can be opened, and nothing complains."""

import pytest

import rattle as rt
from browsing import frames
from rattle.pages.replay import replay


@pytest.mark.long
@pytest.mark.parametrize("name", sorted(rt.examples()))
def test_every_example_has_a_page(open_page, name, tmp_path):
    r = rt.example(name).simulate()
    path = tmp_path / "page.html"
    replay(r, path)
    page = open_page(path.as_uri())
    page.wait_for_function(f"rattle.time > {r.t[0]}")
    for key in ("f", "n", "t", "d"):
        page.keyboard.press(key)
    for tab in page.get_by_role("tab").all():
        if tab.is_visible():
            tab.click()
    frames(page)
    assert path.stat().st_size < 2_000_000
