"""Measured curves in pages and reports: dots beside the motion, and what they differ by, whatever is turned."""

import numpy as np
import pytest

import rattle as rt
from browsing import becomes, frames
from rattle.errors import InputError
from rattle.pages.page import page
from rattle.pages.report import write_report

MEASURED = "() => rattle.measured"
PANELS = """() => rattle.viewer.curves.panels.map((panel) => ({ key: panel.key, lines: panel.lines.length,
  dots: panel.lines.filter((line) => line.dots).length, legend: panel.legend.textContent }))"""
OFF = np.deg2rad(1.5)  # what is measured too much


@pytest.fixture(scope="module")
def crank():
    return rt.example("slider_crank").set({"simulate.t_end": "12 ms"})


@pytest.fixture
def bench(tmp_path, crank):
    """A file with an angle that was measured 1.5 deg too large, 40 values within the run and two outside."""
    r = crank.simulate()
    t = r.t[np.linspace(0, len(r.t) - 1, 40).astype(int)]
    rows = np.column_stack([1e3 * t, np.rad2deg(np.interp(t, r.t, r["rod.angle"]) + OFF)])
    rows = np.vstack([[-1.0, 0.0], rows, [1e4, 0.0]])
    np.savetxt(tmp_path / "m.csv", rows, delimiter=";", header="t [ms];phi [deg]", fmt="%.17g")
    return tmp_path / "m.csv"


def test_a_live_page_says_what_a_measured_curve_differs_by_also_after_a_knob(tmp_path, open_page, crank, bench):
    page(crank, tmp_path / "page.html", measured=f"{bench}:phi=rod.angle", curves=["A.force"])
    tab = open_page((tmp_path / "page.html").as_uri(), reduced_motion="reduce")
    becomes(tab, "() => window.rattle && rattle.live && rattle.run !== null")
    (seen,) = tab.evaluate(MEASURED)
    assert (seen["curve"], seen["label"]) == ("rod.angle", "phi (m.csv)")
    assert (len(seen["t"]), seen["all"]) == (40, 42)
    assert seen["rms"] == pytest.approx(OFF, rel=1e-4)  # numbers of a page have single precision
    speed = 0.5 * tab.evaluate("() => rattle.parameters.speed")
    tab.evaluate("(speed) => rattle.set('speed', speed)", speed)
    slower = crank.set({"speed": speed}).simulate()
    (part,) = slower.residuals(f"{bench}:phi=rod.angle")
    assert tab.evaluate(MEASURED)[0]["rms"] == pytest.approx(part.rms, rel=1e-3)
    frames(tab)
    panels = tab.evaluate(PANELS)
    assert [panel["key"] for panel in panels] == ["N", "rad", "rad difference"]
    assert [panel["dots"] for panel in panels] == [0, 1, 1]
    assert "phi (m.csv) − rod.angle" in panels[2]["legend"]
    assert "40 of 42 values within the run" in panels[2]["legend"]
    assert f"rms {np.rad2deg(part.rms):.3g} deg" in panels[2]["legend"]


def test_a_page_that_replays_runs_compares_with_the_one_that_is_shown(tmp_path, open_page, crank, bench):
    page(crank, tmp_path / "page.html", over={"speed": ["5000 rpm", "2000 rpm"]}, measured=f"{bench}:phi=rod.angle")
    tab = open_page((tmp_path / "page.html").as_uri(), reduced_motion="reduce")
    becomes(tab, "() => window.rattle && rattle.run !== null")
    for rpm in (2000, 5000):
        speed = rpm * np.pi / 30
        tab.evaluate("(speed) => rattle.set('speed', speed)", speed)
        (part,) = crank.set({"speed": speed}).simulate().residuals(f"{bench}:phi=rod.angle")
        assert tab.evaluate(MEASURED)[0]["rms"] == pytest.approx(part.rms, rel=1e-3)


def test_a_page_refuses_what_does_not_fit_and_is_not_written(tmp_path, crank, bench):
    for words in ("rod.agle", "A.force"):
        with pytest.raises(InputError, match=r"did you mean 'rod\.angle'|A\.force is in N"):
            page(crank, tmp_path / "page.html", measured=f"{bench}:phi={words}")
    assert not (tmp_path / "page.html").exists()


def test_a_page_takes_sources_one_by_one(tmp_path, crank, bench):
    page(crank, tmp_path / "page.html", measured=(f"{bench}:{column}=rod.angle" for column in ("phi",)))
    assert '"measured"' in (tmp_path / "page.html").read_text(encoding="utf-8")


def test_a_report_has_a_section_on_measured_curves(tmp_path, crank, bench):
    write_report(crank, tmp_path / "r.html", measured=[f"{bench}:phi=rod.angle"])
    text = (tmp_path / "r.html").read_text(encoding="utf-8")
    section = text[text.index('<section id="measured-curves">') :].partition("</section>")[0]
    assert "phi (m.csv)" in section
    assert "40 of 42" in section
    assert "1.5 deg" in section
    write_report(crank, tmp_path / "r.html")
    assert "measured-curves" not in (tmp_path / "r.html").read_text(encoding="utf-8")


def test_a_report_refuses_a_file_before_anything_runs(tmp_path, crank, monkeypatch):
    monkeypatch.setattr("rattle.pages.report.study", lambda *_: pytest.fail("it ran"))
    (tmp_path / "m.csv").write_text("0;1\n")
    with pytest.raises(InputError, match="line 1: numbers without a head"):
        crank.report(tmp_path / "r.html", measured=tmp_path / "m.csv")
