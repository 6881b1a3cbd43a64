"""What is drawn is what was computed: every kind of page and of picture reaches the largest value of the table."""

import base64
import json

import numpy as np
import pytest

import rattle as rt
from browsing import becomes, frames
from circling import circling
from linkages import SCISSOR
from rattle.pages.notebook import kernel_scene
from rattle.pages.page import page
from rattle.pages.replay import replay, write_page
from rattle.pages.scene import run_of, scene_json, scene_of
from rattle.results.contact_summary import contact_lines, joint_table
from rattle.results.result import Result
from wiper import wiper

PIN = "B.normal"
# what a page shows of a curve: its largest value, the range of its panel, and whether the mark is there in its colour
SHOWN = """(name) => {
  const curve = rattle.curve(name), panel = rattle.viewer.curves.panels.find((one) => one.names.includes(name));
  const { low, high, handy } = panel, ys = [...curve.line.y, curve.peak.y], x = panel.X(curve.peak.t);
  const y = panel.Y(handy.factor * curve.peak.y) + (curve.peak.y < 0 ? 5 : -5), canvas = panel.below;
  const ratio = canvas.width / canvas.clientWidth;
  const pixel = canvas.getContext("2d").getImageData(Math.round(ratio * x), Math.round(ratio * y), 1, 1).data;
  return { largest: Math.max(...ys.map(Math.abs)), low: low / handy.factor, high: high / handy.factor,
    opaque: pixel[3] > 200, labels: panel.labels };
}"""


def rattling(interval):
    """A slider-crank with a compliant pin; the output interval [s] is fine, so that pages thin it, or misses all."""
    return rt.example("slider_crank_play").set({"simulate.t_end": 0.006, "simulate.output": interval})


@pytest.fixture
def shown(tmp_path, open_page):
    """A function that opens a page and tells what it shows of a curve."""

    def of(path, name, **options):
        tab = open_page(path.as_uri(), reduced_motion="reduce", **options)
        becomes(tab, "(name) => window.rattle && rattle.names.includes(name)", name)
        tab.evaluate("(name) => rattle.choose([name])", name)
        frames(tab)
        return tab.evaluate(SHOWN, name)

    return of


def fits(seen, want, limit=1e-6):
    """The largest value is the table's; the panel reaches it, and no triangle is lost."""
    assert seen["largest"] == pytest.approx(want, rel=limit)
    assert max(seen["high"], -seen["low"]) > want
    assert seen["opaque"]


@pytest.mark.parametrize("interval", [1e-6, 5e-4])
def test_a_replay_reaches_the_peak_of_the_table(interval, shown, tmp_path):
    r = rattling(interval).simulate()
    replay(r, tmp_path / "page.html")
    fits(shown(tmp_path / "page.html", PIN), r.peak(PIN)[0])


def test_a_page_with_runs_reaches_the_peaks_of_all_of_them(shown, tmp_path):
    m = rattling(1e-6)
    page(m, tmp_path / "page.html", over={"c": ["0.2 mm", "0.4 mm"]})
    fits(shown(tmp_path / "page.html", PIN), m.simulate().peak(PIN)[0])


@pytest.mark.parametrize(("width", "height"), [(1366, 768), (390, 844), pytest.param(844, 390, marks=pytest.mark.long)])
def test_a_live_page_reaches_the_peak_of_the_table_and_every_axis_has_a_scale(width, height, shown, tmp_path):
    """Between the outputs, too: these are 3 ms apart, an eighth of a turn."""
    m = rt.example("slider_crank").set({"simulate.output": "3 ms"})
    name = next(one for one in m.simulate().peaks if one.endswith(".force"))
    page(m, tmp_path / "page.html")
    seen = shown(tmp_path / "page.html", name, viewport={"width": width, "height": height})
    fits(seen, m.simulate().peak(name)[0], 1e-3)  # the page takes the crest of a parabola through its steps
    for labels in seen["labels"].values():
        assert len(set(labels)) >= 2


def test_a_notebook_reaches_the_peak_of_the_table(shown, tmp_path):
    """The first motion, and those that the kernel sends for other parameters, which come as the same runs."""
    m = rattling(1e-6)
    scene = kernel_scene(m, None, "of contacts")
    write_page({**scene, "knobs": []}, tmp_path / "page.html")
    want = m.simulate()
    fits(shown(tmp_path / "page.html", PIN), want.peak(PIN)[0])
    sent = json.loads(scene_json(run_of(want, "", scene["geometry"])))
    assert sent["peaks"][PIN][0] == pytest.approx(want.peak(PIN)[0])
    assert sent["between"].keys() == scene["runs"][0]["between"].keys()


@pytest.mark.parametrize("interval", [1e-6, 5e-4])
def test_plots_reach_the_peak_of_the_table(interval):
    r = rattling(interval).simulate()
    ax = r.plot(PIN).axes[0]
    want = r.peak(PIN)[0] * (1e-3 if "kN" in ax.get_ylabel() else 1.0)
    drawn = [np.abs(line.get_ydata()).max() for line in ax.lines]
    assert max(drawn) == pytest.approx(want)
    assert ax.get_ylim()[1] >= want


def test_the_colours_of_an_orbit_end_at_the_largest_force_or_say_it():
    r = rattling(1e-6).simulate()
    figure = r.plot_orbit("B")
    bar = figure.axes[-1]
    want = r.peak(PIN)[0]
    assert bar.get_ylim()[1] >= want or f"{1e-3 * want:.4g} kN" in bar.get_ylabel()


INK = """([t, y]) => {
  const panel = rattle.viewer.curves.panels[0], canvas = panel.below, ratio = canvas.width / canvas.clientWidth;
  const x = Math.round(ratio * panel.X(t)), at = Math.round(ratio * panel.Y(panel.handy.factor * y));
  const box = canvas.getContext("2d").getImageData(x - 3, at, 7, 4).data; // just below the tip
  const blue = (_, k) => box[4 * k + 2] - box[4 * k] > 60 && box[4 * k + 3] > 60;
  return Array.from({ length: box.length / 4 }, blue).some(Boolean);
}"""


def test_a_single_value_that_stands_out_is_seen_at_every_zoom(tmp_path, open_page):
    """One instant of 30001 is much larger: its tip has the colour of the curve, in the whole run and ever closer."""
    r, at = circling(n=30_001, horizon=None, pulls=False), 17_003
    data = np.array(r._data)
    data[at, r.stored.index("O.normal")] = 4000.0
    spiky = Result(
        t=r.t, data=data, names=r.stored, units=r._units, geometry=r.geometry, trust=r.trust, stats={}, provenance={}
    )
    replay(spiky, tmp_path / "page.html")
    tab = open_page((tmp_path / "page.html").as_uri(), reduced_motion="reduce")
    becomes(tab, "window.rattle && rattle.names.length > 0")
    tab.evaluate("rattle.choose(['O.normal'])")
    for span in (0.2, 0.05, 0.01, 1e-3, 1e-4):
        low = min(max(0.0, r.t[at] - 0.4 * span), r.t[-1] - span)
        tab.evaluate("([low, high]) => rattle.viewer.curves.scope.choose([low, high])", [low, low + span])
        frames(tab)
        assert tab.evaluate(INK, [r.t[at], 4000.0]), f"not seen in a window of {span} s"


@pytest.fixture(scope="module")
def towering():
    """A run with a rigid pin whose force towers between impacts."""
    return wiper(0.0).simulate(0.06, t_eval=np.linspace(0.0, 0.06, 601), horizon=True)


def test_a_scene_holds_no_force_that_towers_and_has_the_words_of_the_command_line(towering):
    limit = 2e4  # [N] of a joint that bears some 100 N
    assert towering.peak(PIN)[0] > limit
    scene = scene_of([("run", towering)])
    (run,) = scene["runs"]
    forces = [n for n, unit in enumerate(run["units"]) if unit == "N"]
    data = np.frombuffer(base64.b64decode(run["data"]), "<f4").reshape(len(run["names"]), run["n"])
    assert np.nanmax(np.abs(data[forces])) < limit
    assert PIN not in run["peaks"]
    contacts = [event for event in run["events"] if event[2] == "contact"]
    assert contacts
    assert all(event[5] is None for event in contacts)
    assert run["trust"]["limits"] == [towering.trust.word]
    assert run["trust"]["contacts"] == list(contact_lines(towering))
    assert any("tower" in note for note in scene["notes"])


def test_a_page_with_a_force_that_towers_is_not_called_trusted(towering, tmp_path, open_page):
    replay(towering, tmp_path / "page.html")
    tab = open_page((tmp_path / "page.html").as_uri(), reduced_motion="reduce")
    becomes(tab, "window.rattle && rattle.names.length > 0")
    assert tab.locator(".trust .badge").text_content() == "With limits"
    lines = tab.locator(".trust .lines").text_content()
    assert "largest impulse" in lines
    assert "elastic bushes would show about" in lines
    tab.get_by_role("tab", name="Events").click()
    assert "not to be read" in tab.locator("table.events").text_content()


def test_a_force_that_grows_towards_a_gap_has_no_largest_value(tmp_path):
    """It is that of the instant at which forces begin to be left out, which the size of the gap decides."""
    r = rt.loads(SCISSOR).simulate(0.6, t_eval=np.linspace(0.0, 0.6, 61))
    ((since, until),) = r.trust.gaps
    assert r.peaks["M.force"].t in (since, until)
    row = next(line.split() for line in joint_table(r).splitlines() if line.startswith("M "))
    assert row[1:] == ["-", "gap", f"{r.trust.singular[0]:.4g}", "s", "-"]
    assert "M.force" not in run_of(r, "run", r.geometry)["peaks"]
    r.save(tmp_path / "r.npz")
    assert rt.load_result(tmp_path / "r.npz").trust.gaps == r.trust.gaps
    m = rt.loads(SCISSOR).set({"simulate.t_end": 0.6})
    m.report(tmp_path / "report.html")
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "Largest joint force" not in text
    assert "it grows towards t = 0.318" in text
