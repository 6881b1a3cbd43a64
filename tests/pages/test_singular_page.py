"""A page that computes a motion through a singular position shows no force of that instant."""

import numpy as np
import pytest

import rattle as rt
from browsing import becomes
from linkages import SCISSOR

pytestmark = [pytest.mark.nojit, pytest.mark.plain]


def test_forces_beside_a_singular_position_are_left_out_and_it_is_said(tmp_path, open_page):
    rt.loads(SCISSOR).page(tmp_path / "page.html", t_end=0.6)
    page = open_page((tmp_path / "page.html").as_uri(), reduced_motion="reduce")
    becomes(page, "window.rattle && rattle.names.length > 0 && rattle.trust.text.join().includes('singular position')")
    assert page.locator(".trust .badge").text_content() == "With limits"
    note = next(line for line in page.evaluate("rattle.trust.text") if "singular position" in line)
    assert "the run passes a singular position at t = 0.31" in note
    for joint in ("F", "M", "G", "T1", "T2"):
        curve = page.evaluate(f"rattle.curve('{joint}.force')")
        t, y = np.array(curve["t"]), np.array([np.nan if one is None else one for one in curve["y"]], float)
        assert np.nanmax(y) < 2e5  # within the passage it goes beyond all bounds
        assert np.isnan(y).any()
        assert (np.abs(t[np.isnan(y)] - 0.318) < 0.02).all()
    motion = page.evaluate("rattle.curve('table.y').y")
    assert None not in motion
    assert np.isfinite(motion).all()
