"""What a tab shows of its blocks: as it is seen, read off, hidden, zoomed and clicked on the page."""

import json

import numpy as np
import pytest

import rattle as rt
from browsing import becomes, frames, keep_picture, shows
from rattle.answers.blocks import bars, curves, line, of_result, table, words

pytest.importorskip("starlette")
from rattle.studio.page import as_json

BLACK_OR_BLUE = """([selector, x, y]) => {
  const canvas = document.querySelector(selector), ratio = canvas.width / canvas.clientWidth;
  const box = canvas.getContext("2d").getImageData(Math.round(ratio * x) - 2, Math.round(ratio * y) - 2, 5, 5).data;
  return Array.from({ length: 25 }, (_, k) => box[4 * k + 2] - box[4 * k] > 60 && box[4 * k + 3] > 60).some(Boolean);
}"""
SHOW = """async (blocks) => {
  const { Sheet } = await import(new URL("sheet.js", location));
  window.sheet = new Sheet((message) => { window.picked = message; });
  sheet.turn(false);
  document.querySelector("#tab-forces").click();
  document.querySelector("#panel-forces .sheet-of").replaceWith(sheet.el);
  sheet.show(blocks);
}"""


@pytest.fixture
def shown(visit):
    """A function that shows blocks in the sheet of a tab; returns the page."""

    def show(*blocks, **options):
        page = visit(**options)
        page.evaluate(SHOW, json.loads(as_json({"blocks": blocks}))["blocks"])
        page.add_style_tag(content=".tab-head + .sheet-of { visibility: visible !important; opacity: 1 !important }")
        frames(page)
        return page

    return show


def forces(joints="OABQ"):
    run = rt.example("crank_rocker_play").simulate(2e-3)
    return of_result("Forces", run, [f"{name}.force" for name in joints], {f"{name}.force": name for name in joints})


def waves(n=5001, **more):
    """Two curves, of which the second is small; the first has one value alone that stands out."""
    x = np.linspace(0.0, 1.0, n)
    y = np.sin(6.0 * x)
    y[n // 3] = 9.0
    return curves("Waves", "time [s]", "force [N]", [line("large", x, y), line("small", x, 0.01 * np.cos(x))], **more)


@pytest.mark.parametrize("size", [(390, 844), (1366, 768)])
def test_the_names_of_colours_stand_above_the_curves(shown, size):
    page = shown(forces(), viewport={"width": size[0], "height": size[1]})
    names = page.locator(".curves > .legend li button[aria-pressed]")
    assert names.all_text_contents() == list("OABQ")
    top = page.locator(".curves > .layers").bounding_box()["y"]
    heights = {round(one.bounding_box()["y"]) for one in names.all()}
    assert len(heights) == 1  # in one line
    assert max(heights) < top
    colours = page.evaluate("[...document.querySelectorAll('.curves > .legend .swatch')].map((one) => one.style.color)")
    assert len(set(colours)) == 4
    keep_picture(page, f"sheet-{size[0]}")


def test_curves_reach_the_largest_value_between_two_outputs(shown):
    r = rt.example("slider_crank_play").set({"simulate.t_end": 0.006, "simulate.output": 5e-4}).simulate()
    page = shown(of_result("forces", r, ["B.normal"]))
    chart = "window.sheet.charts[0]"
    (factor,) = {1.0, 1e-3} & {1e-3 if "kN" in page.evaluate(f"{chart}.up") else 1.0}
    peak = page.evaluate(f"({{ x: {chart}.X({chart}.lines[0].peak.x), y: {chart}.Y({chart}.lines[0].peak.y) }})")
    assert page.evaluate(f"{chart}.lines[0].peak.y") == pytest.approx(factor * r.peak("B.normal")[0])
    assert page.evaluate(f"{chart}.high") > factor * r.peak("B.normal")[0]
    assert page.evaluate(BLACK_OR_BLUE, [".curves > .layers canvas", peak["x"], peak["y"] - 5])  # the triangle is there
    place = page.locator(".curves > .layers").bounding_box()
    page.mouse.move(place["x"] + peak["x"], place["y"] + 100)
    shows(page.locator(".curves > .layers .tip", has_text="largest B.normal"))


def test_one_value_of_thousands_that_stands_out_is_seen(shown):
    page = shown(waves())
    chart = "window.sheet.charts[0]"
    x, y = page.evaluate(f"[{chart}.X(1666 / 5000), {chart}.Y(8.5)]")
    assert page.evaluate(BLACK_OR_BLUE, [".curves > .layers canvas", x, y])


@pytest.mark.parametrize("n", [201, 20001])
def test_a_gap_stays_a_gap_and_a_value_alone_in_it_is_a_dot(shown, n):
    """Where forces are not defined; at few rows, and at more than there are pixels."""
    x = np.linspace(0.0, 1.0, n)
    y = np.where(np.abs(x - 0.5) < 0.2, np.nan, 1.0)
    y[n // 2] = 2.0
    page = shown(curves("Gap", "time [s]", "force [N]", [line("force", x, y)]))
    chart = "window.sheet.charts[0]"
    places = page.evaluate(
        f"[[0.1, 1], [0.9, 1], [0.5, 2], [0.4, 1], [0.45, 1.5]].map(([x, y]) => [{chart}.X(x), {chart}.Y(y)])"
    )
    assert [page.evaluate(BLACK_OR_BLUE, [".curves > .layers canvas", *at]) for at in places] == [True] * 3 + [
        False
    ] * 2


def test_a_name_that_is_clicked_hides_its_curve_and_the_axis_fits_the_rest(shown):
    page = shown(waves())
    page.get_by_title("Hide or show large").click()
    becomes(page, "window.sheet.charts[0].high < 0.02")
    place = page.locator(".curves > .layers").bounding_box()
    page.mouse.move(place["x"] + 300, place["y"] + 100)
    shows(page.locator(".curves > .layers .tip", has_text="small"))
    assert "large" not in page.locator(".curves > .layers .tip").text_content()
    page.get_by_title("Hide or show large").click()
    becomes(page, "window.sheet.charts[0].high > 9")


def test_a_drag_zooms_and_a_button_goes_back(shown):
    page = shown(waves())
    back = page.get_by_role("button", name="Show all of it")
    assert back.count() == 0
    place = page.locator(".curves > .layers").bounding_box()
    page.mouse.move(place["x"] + 200, place["y"] + 60)
    page.mouse.down()
    page.mouse.move(place["x"] + 300, place["y"] + 90)
    page.mouse.up()
    shows(back)
    from_, to = page.evaluate("window.sheet.charts[0].scope.shown")
    assert 0.05 < from_ < to < 0.5
    back.click()
    becomes(page, "window.sheet.charts[0].scope.span === 1")
    assert back.count() == 0


def test_what_the_mouse_is_over_is_read_off_with_units(shown):
    page = shown(waves())
    x = page.evaluate("window.sheet.charts[0].X(0.5)")
    place = page.locator(".curves > .layers").bounding_box()
    page.mouse.move(place["x"] + x, place["y"] + 100)
    frames(page)
    rows = page.locator(".curves > .layers .tip").text_content().split("\n")
    assert rows[0].startswith("time = 0.5")
    assert rows[0].endswith(" s")
    name, value = rows[1].split(" = ")
    assert name == "large"
    assert float(value.removesuffix(" N")) == pytest.approx(np.sin(3.0), abs=0.02)  # a pixel is 1 ms


def test_what_a_finger_has_touched_is_read_off_and_stays(shown):
    page = shown(waves(), viewport={"width": 390, "height": 844}, is_mobile=True, has_touch=True)
    page.locator(".curves > .layers").tap(position={"x": 200, "y": 100})
    frames(page)
    tip = page.locator(".curves > .layers .tip")
    shows(tip)
    assert "small = " in tip.text_content()


def test_after_the_horizon_the_ground_is_grey_and_it_is_said(shown):
    page = shown(waves(after=0.5))
    assert "(grey: after the horizon, statistics only)" in page.locator(".curves h3").text_content()
    grey = """(x) => {
      const { charts: [chart] } = window.sheet, canvas = chart.below, ratio = canvas.width / canvas.clientWidth;
      return canvas.getContext("2d").getImageData(Math.round(ratio * chart.X(x)), Math.round(ratio * 20), 1, 1).data[3];
    }"""
    assert page.evaluate(grey, 0.71) > 0
    assert page.evaluate(grey, 0.21) == 0


def test_a_curve_without_a_name_has_the_colour_of_the_one_it_is_like_and_goes_with_it(shown):
    t = np.linspace(0.0, 1.0, 50)
    lines = [line("worst", t, 1.0 + t), line("", t, -1.0 - t, like=0), line("exact", t, t, dash=True)]
    page = shown(curves("Band", "time [s]", "deviation [mm]", lines))
    assert page.evaluate("window.sheet.charts[0].lines.map((line) => line.colour)") == [0, 0, 1]
    assert page.locator(".curves > .legend button[aria-pressed]").all_text_contents() == ["worst", "exact"]
    page.get_by_title("Hide or show worst").click()
    becomes(page, "window.sheet.charts[0].low > -0.2")


def test_a_bar_that_is_clicked_picks_its_mechanism(shown):
    block = {
        "kind": "histogram", "title": "max(A.force)", "x": "force [N]", "edges": np.array([1.0, 2.0, 3.0, 4.0]),
        "counts": np.array([3, 0, 5]), "samples": [7, -1, 11], "marks": [{"x": 2.2, "label": "nominal"}],
    }  # fmt: skip
    page = shown(block)
    low, empty, high = (bar.bounding_box() for bar in page.locator(".bin").all())
    assert low["height"] / high["height"] == pytest.approx(3 / 5, abs=0.02)
    assert empty["height"] < 1
    mark = page.locator(".mark").bounding_box()
    assert mark["x"] == pytest.approx(empty["x"] + 0.2 * empty["width"], abs=2.0)
    page.locator(".bin").last.hover()
    tip = page.evaluate("getComputedStyle(document.querySelectorAll('.bin')[2], '::after').content")
    assert "5 mechanisms" in tip
    assert "replays number 11" in tip
    page.locator(".bin").last.click()
    becomes(page, "window.picked?.number === 11 && window.picked.do === 'pick'")


def test_words_tables_and_bars_are_texts_and_never_code(shown):
    evil = "<img src=x onerror=alert(1)>"
    page = shown(
        words(evil, "care"), table((evil, "b"), [(evil, "1 N")], evil), bars(evil, "µm", [evil, "B"], [2.0, 1.0])
    )
    assert page.locator(".sheet-of img").count() == 0
    assert page.get_by_text(evil).count() == 6
    first, second = (bar.bounding_box()["width"] for bar in page.locator(".track i").all())
    assert first == pytest.approx(2.0 * second, rel=0.02)
