"""The page of a result in a browser: it plays, seeks, draws, listens to keys, and asks for nothing from outside."""

import numpy as np
import pytest
from click.testing import CliRunner

from any_motion import any_motion
from browsing import becomes, frames, keep_picture, shows
from circling import C, circling
from rattle.cli.main import main
from rattle.pages.replay import replay, write_page
from rattle.pages.scene import scene_of
from rattle.results.result import Result

pytestmark = [pytest.mark.nojit, pytest.mark.plain]


@pytest.fixture
def page_of(tmp_path, open_page):
    """A function that opens the page of a result, with the motion at rest unless it is said otherwise."""

    def opened(result, *, calm=True, scene=None, **options):
        path = tmp_path / "page.html"
        write_page(scene, path) if scene else replay(result, path)
        page = open_page(path.as_uri(), reduced_motion="reduce" if calm else "no-preference", **options)
        page.wait_for_function("window.rattle && window.rattle.names.length > 0")
        return page

    return opened


def test_page_plays_and_stops(page_of):
    page = page_of(circling(), calm=False)
    assert page.evaluate("rattle.playing")
    before = page.evaluate("rattle.time")
    page.wait_for_function(f"rattle.time > {before}")
    page.evaluate("rattle.pause()")
    stopped = page.evaluate("rattle.time")
    frames(page, 8)
    assert page.evaluate("rattle.time") == stopped


def test_reduced_motion_does_not_play_by_itself(page_of):
    page = page_of(circling())
    assert not page.evaluate("rattle.playing")
    page.evaluate("rattle.play()")
    page.wait_for_function("rattle.time > 0")


def test_curves_are_those_of_the_result(page_of):
    r = circling()
    page = page_of(r)
    assert set(page.evaluate("rattle.names")) == set(r.names)
    for name in ("O.normal", "arm.P.x", "O.force"):
        curve = page.evaluate(f"rattle.curve('{name}')")
        np.testing.assert_array_equal(curve["t"], r.t)
        np.testing.assert_allclose(curve["y"], r[name], rtol=1e-6, atol=1e-6 * np.abs(r[name]).max())
    assert page.evaluate("rattle.trust.text") == str(r.trust).splitlines()
    assert page.evaluate("rattle.trust.horizon") == r.trust.horizon
    with pytest.raises(Exception, match=r"no curve arm\.q; there are arm\.x"):
        page.evaluate("rattle.curve('arm.q')")


def test_keys_move_through_time(page_of):
    r = circling()
    page = page_of(r)
    page.keyboard.press("End")
    becomes(page, "(t) => rattle.time === t", r.t[-1])
    page.keyboard.press("Home")
    becomes(page, "rattle.time === 0")
    for key in ("ArrowRight", "ArrowRight", "ArrowLeft"):
        page.keyboard.press(key)
    becomes(page, "(t) => rattle.time === t", r.t[1])
    speed = page.evaluate("rattle.speed")
    page.keyboard.press("+")
    becomes(page, "(speed) => rattle.speed > speed", speed)
    page.keyboard.press(" ")
    becomes(page, "rattle.playing")
    page.keyboard.press(" ")
    becomes(page, "!rattle.playing")
    page.keyboard.press("?")
    shows(page.get_by_role("dialog", name="Help"))
    page.keyboard.press("Escape")
    shows(page.get_by_role("dialog", name="Help"), "hidden")


def test_what_is_said_is_on_the_page(page_of):
    page = page_of(circling())
    shows(page.get_by_text("constraint error 3e-15 m"))
    shows(page.get_by_text("play 5 mm"))
    page.evaluate("rattle.seek(0.18)")
    shows(page.get_by_text("after the horizon: statistics only"))
    page.get_by_role("tab", name="Orbit").click()
    shows(page.get_by_text("O: orbit of the pin, clearance 5 mm"))
    page.get_by_role("tab", name="Events (1)").click()
    page.get_by_title("Go to this time").click()
    becomes(page, "rattle.time === 0.01")


def test_trust_is_one_word_that_opens(page_of):
    """Where there is no limit nobody has to read of rounding; where there is one it stands there at once."""
    page = page_of(circling(horizon=None, pulls=False))
    said = page.get_by_text("constraint error 3e-15 m")
    shows(page.get_by_text("Trusted", exact=True))
    shows(said, "hidden")
    page.get_by_text("why?").click()
    shows(said)


def test_curves_are_chosen_from_a_list_that_can_be_searched(page_of):
    page = page_of(circling())
    page.evaluate("rattle.choose([])")
    page.get_by_role("button", name="Choose curves").click()
    page.keyboard.type("arm p x")
    box = page.get_by_role("checkbox", name="arm.P.x m")
    box.check()
    becomes(page, "rattle.viewer.chooser.rows.filter((row) => !row.element.hidden).length === 1")
    page.keyboard.press("Escape")
    shows(page.get_by_role("button", name="Remove arm.P.x"))


def test_a_click_on_a_curve_leads_to_its_time(page_of):
    r = circling()
    page = page_of(r)
    page.evaluate("rattle.choose(['lift'])")
    plot = page.locator(".plot .above")
    frames(page)
    box = plot.bounding_box()
    plot.click(position={"x": 58 + 0.5 * (box["width"] - 70), "y": box["height"] / 2})
    becomes(page, "(t) => Math.abs(rattle.time - t) < 0.01 * t", r.t[-1] / 2)
    page.mouse.wheel(0, -400)
    becomes(page, "rattle.viewer.curves.scope.own !== null")
    page.mouse.dblclick(box["x"] + 200, box["y"] + 40)
    becomes(page, "rattle.viewer.curves.scope.own === null")


def test_the_pin_is_drawn_where_it_is(page_of):
    """The dot of the orbit is at the pin's place: its pixels are found on the canvas."""
    r = circling()
    page = page_of(r)
    page.get_by_role("tab", name="Orbit").click()
    for k in (0, 130, 270):
        page.evaluate(f"rattle.seek({r.t[k]})")
        frames(page)
        x, y, scale = page.evaluate(
            """() => {
              const tile = rattle.viewer.orbits.tiles[0], canvas = tile.above, side = canvas.clientHeight;
              const room = Math.min(canvas.clientWidth - 78, side), scale = 0.5 * room / (1.24 * tile.least);
              const c = canvas.getContext("2d"), all = c.getImageData(0, 0, canvas.width, canvas.height);
              let sx = 0, sy = 0, n = 0;
              for (let i = 0; i < all.data.length; i += 4) {
                if (all.data[i + 3] > 250 && all.data[i + 2] < 80) { sx += (i / 4) % all.width; sy += Math.floor(i / 4 / all.width); n++; }
              }
              return [(sx / n + 0.5 - 0.5 * room) / scale, -(sy / n + 0.5 - 0.5 * side) / scale, scale];
            }"""  # noqa: E501
        )
        assert x * C == pytest.approx(r["O.ex"][k], abs=1.5 / scale * C)
        assert y * C == pytest.approx(r["O.ey"][k], abs=1.5 / scale * C)


def test_nothing_is_drawn_while_the_page_is_hidden(page_of):
    page = page_of(circling(), calm=False)
    page.evaluate("document.body.insertAdjacentHTML('afterbegin', '<div style=\"height: 4000px\"></div>')")
    page.wait_for_function("!rattle.viewer.awake")
    frames(page, 3)  # one that was asked for before still comes
    before = page.evaluate("rattle.time")
    frames(page, 8)
    assert page.evaluate("rattle.time") == before
    page.evaluate("window.scrollTo(0, 5000)")
    page.wait_for_function(f"rattle.time > {before}")


def test_two_viewers_on_one_page_do_not_disturb_each_other(page_of):
    page = page_of(circling())
    page.evaluate(
        """() => {
          const root = document.createElement("div"), scene = JSON.parse(document.getElementById("scene").textContent);
          document.body.append(root);
          window.other = rattle.mount(root, scene, {});
        }"""
    )
    page.locator(".rattle-viewer").nth(1).hover()
    page.evaluate("rattle.viewer.host.page = false")
    page.keyboard.press("End")
    becomes(page, "rattle.time === 0 && Math.abs(other.time - 0.2) < 1e-12")
    page.evaluate("other.destroy()")
    becomes(page, "document.querySelectorAll('.rattle-viewer').length === 1")
    page.keyboard.press("Home")


@pytest.mark.parametrize(("size", "scheme"), [((1366, 768), "light"), ((1920, 1080), "dark"), ((390, 844), "light")])
def test_page_fits_the_screen(page_of, size, scheme):
    width, height = size
    page = page_of(circling(), viewport={"width": width, "height": height}, color_scheme=scheme)
    frames(page)
    wide, tall = page.evaluate("[document.documentElement.scrollWidth, document.documentElement.scrollHeight]")
    assert wide <= width
    if width > 800:
        assert tall <= height
    player = page.get_by_role("group", name="Player").bounding_box()
    assert player["y"] + player["height"] <= height
    keep_picture(page, f"replay-{width}x{height}-{scheme}")


def test_dark_is_a_matter_of_taste(page_of):
    page = page_of(circling(), color_scheme="dark")
    shows(page.locator(".frame[data-theme='dark']"))
    page.get_by_role("button", name="Dark or light").click()
    shows(page.locator(".frame[data-theme='light']"))


@pytest.mark.parametrize(
    "name", ["cam_lift_off", "planetary", "ratchet", "scotch_yoke", "torque_converter", "excavator"]
)
def test_parts_are_drawn_without_complaint(page_of, name):
    r = any_motion(name)
    page = page_of(r)
    for key in ("f", "n", "t"):
        page.keyboard.press(key)
    page.evaluate("rattle.seek(0.5)")
    frames(page)


def test_a_press_elsewhere_closes_a_list(page_of):
    page = page_of(circling())
    page.get_by_title("Paths of points (T)").click()
    box = page.get_by_role("checkbox", name="arm.P")
    box.check()
    shows(page.get_by_title("Paths of points (T)").and_(page.get_by_text("Paths (1)")))
    page.mouse.click(400, 650)
    shows(box, "hidden")


def test_two_runs_and_a_ghost_are_shown_together(page_of):
    wide, narrow = circling(), circling(clearance=0.5 * C)
    page = page_of(None, scene=scene_of([("wide", wide), ("narrow", narrow)], ideal=circling(clearance=0.1 * C)))
    shows(page.get_by_text("dashed beside it"))
    page.locator(".runs select").first.select_option("1")
    page.locator(".runs select").nth(1).select_option("0")
    becomes(page, "rattle.run.label === 'narrow'")
    curve = page.evaluate("rattle.curve('O.ex')")["y"]
    np.testing.assert_allclose(curve, narrow["O.ex"], atol=1e-9)
    page.keyboard.press("g")
    frames(page)


def test_command_writes_the_page_of_a_saved_result(tmp_path, open_page):
    circling().save(tmp_path / "out.npz")
    given = [
        "animate",
        str(tmp_path / "out.npz"),
        "-o",
        str(tmp_path / "out.html"),
        "--trace",
        "arm.P",
        "--speed",
        "0.05",
    ]
    done = CliRunner().invoke(main, given)
    assert done.exit_code == 0, done.output
    page = open_page((tmp_path / "out.html").as_uri())
    page.wait_for_function("window.rattle && rattle.speed === 0.05")
    shows(page.get_by_title("Paths of points (T)").and_(page.get_by_text("Paths (1)")))
    refused = CliRunner().invoke(main, [*given, "--frames", "20"])
    assert refused.exit_code != 0


def test_a_run_that_stopped_says_so_first(page_of):
    r = circling()
    stopped = Result(
        t=r.t, data=np.where(r.t[:, None] > 0.1, np.nan, r._data), names=r.stored, units=r._units, geometry=r.geometry,
        trust=r.trust, stats={}, provenance={}, success=False,
        message="at t = 0.1 s joint O came apart: shorten the step",
    )  # fmt: skip
    page = page_of(stopped)
    shows(page.get_by_text("Stopped", exact=True))
    shows(page.get_by_text("The run stopped: at t = 0.1 s joint O came apart: shorten the step"))
    page.keyboard.press("End")
    frames(page)
