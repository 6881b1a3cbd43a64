"""The studio in a real browser."""

import os
import threading
import time
from contextlib import suppress
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from urllib.parse import urlsplit
from urllib.request import url2pathname

import pytest
from studio_models import PENDULUM, start_studio

import rattle as rt
from browsing import becomes, frames, keep_picture, shows


def parameter(page, value, name="l"):
    becomes(page, f"Math.abs(window.rattle.parameters.{name} - {value}) < 1e-9")


def text_of(page):
    return page.locator("textarea.area").input_value()


def becomes_text(page, text):
    """Wait until the model text holds this."""
    becomes(page, "(text) => document.querySelector('textarea.area').value.includes(text)", text)


def is_text(page, text):
    """Wait until the model text is this."""
    becomes(page, "(text) => document.querySelector('textarea.area').value === text", text)


def test_the_page_shows_the_motion_that_simulate_computes(visit):
    page = visit()
    curve = page.evaluate("window.rattle.curve('rod.angle')")
    expected = rt.loads(PENDULUM).simulate(t_eval=curve["t"])["rod.angle"]
    assert max(abs(a - b) for a, b in zip(curve["y"], expected, strict=True)) < 1e-6  # single precision
    becomes(page, "location.href.endsWith('/')")  # the token has left the address
    becomes(page, "document.title.includes('a pendulum')")
    shows(page.locator(".status").get_by_text("constraint error"))
    words = page.locator(".status .trust-text").text_content()  # the answer comes first, how well it was solved last
    assert words.index("the curves can be trusted") < words.index("constraint error")


def test_a_knob_that_is_dragged_turns_the_motion_and_the_text(visit):
    page = visit()
    slider = page.locator("#knob-l")
    slider.focus()
    for _ in range(5):
        page.keyboard.press("ArrowRight")
    becomes(page, "window.rattle.parameters.l !== 1")
    page.get_by_role("tab", name="Text").click()
    becomes(page, """() => !document.querySelector("textarea").value.includes('"1 m", min')""")
    written = text_of(page)
    value = rt.loads(written).parameters["l"]
    assert value > 1.0
    parameter(page, value)
    assert "# a pendulum; this comment stays" in written
    assert "# length" in written


def test_a_value_is_typed_with_its_unit_and_undone(visit):
    page = visit()
    entry = page.get_by_label("l, value with unit")
    entry.fill("1250 mm")
    entry.press("Enter")
    parameter(page, 1.25)
    becomes_text(page, 'value = "1250 mm"')
    page.keyboard.press("Control+z")
    parameter(page, 1.0)
    is_text(page, PENDULUM)
    page.keyboard.press("Control+y")
    parameter(page, 1.25)
    entry.fill("5 kg")
    entry.press("Enter")
    shows(page.locator(".knobs .trouble", has_text="length"))  # that is what it has to be
    assert 'value = "1250 mm"' in text_of(page)


def test_a_bad_text_shows_its_line_and_the_old_motion_stays(visit):
    page = visit()
    page.keyboard.press("t")
    page.locator("textarea.area").fill(PENDULUM.replace("mass = 1", 'mas = 1\ncolour = "red"'))
    row = PENDULUM.split("\n").index("mass = 1") + 1
    shows(page.locator(".problem", has_text=f"line {row}").first)
    shows(page.locator(".problem", has_text=f"line {row + 1}").first)  # all problems, not the first alone
    page.locator(".problem", has_text=f"line {row + 1}").click()
    becomes(
        page,
        """() => {
          const area = document.querySelector("textarea.area");
          return area.value.slice(area.selectionStart, area.selectionEnd) === "colour";
        }""",
    )
    shows(page.locator(".status").get_by_text("before the change"))
    assert page.evaluate("window.rattle.curve('rod.angle').t.length") > 10
    page.locator("textarea.area").fill(PENDULUM)
    becomes(page, "() => document.querySelectorAll('.problem').length === 0")


def test_a_run_shows_how_far_it_is_and_is_stopped(visit):
    page = visit()
    end = page.get_by_label("end", exact=True)
    end.fill("1e6 s")
    end.press("Enter")
    page.locator(".motion-of > .badge", has_text="old: computing").wait_for(timeout=60000)
    page.locator(".motion-of > .badge", has_text="%").wait_for(timeout=60000)  # how far it is
    page.locator(".work").get_by_role("button", name="Stop").click()
    page.locator(".badge", has_text="stopped").wait_for(timeout=60000)
    assert page.evaluate("window.rattle.curve('rod.angle').t.length") > 10  # the old motion
    end.fill("1 s")
    end.press("Enter")
    becomes(page, "() => document.querySelector('.badge').hidden")


def test_saving_asks_before_a_file_is_overwritten(visit, studio):
    page = visit()
    entry = page.get_by_label("l, value with unit")
    entry.fill("1.5 m")
    entry.press("Enter")
    parameter(page, 1.5)
    page.keyboard.press("Control+s")
    page.get_by_role("heading", name="Overwrite?").wait_for()
    page.get_by_role("button", name="Cancel").click()
    assert (studio.folder / "m.toml").read_text() == PENDULUM
    page.keyboard.press("Control+s")
    page.get_by_role("button", name="Overwrite", exact=True).click()
    page.get_by_text("saved as m.toml").wait_for()
    assert (studio.folder / "m.toml").read_text() == PENDULUM.replace('value = "1 m"', 'value = "1.5 m"')
    page.get_by_role("button", name="Save as").click()
    page.get_by_label("File name").fill("../outside.toml")
    page.get_by_role("button", name="Save", exact=True).last.click()
    page.get_by_text("leads out of the folder").wait_for()
    assert not (studio.folder.parent / "outside.toml").exists()


def test_two_users_do_not_mix(visit):
    one, other = visit(), visit()
    entry = one.get_by_label("l, value with unit")
    entry.fill("1.75 m")
    entry.press("Enter")
    parameter(one, 1.75)
    frames(other)
    assert other.evaluate("window.rattle.parameters.l") == 1.0
    assert text_of(other) == PENDULUM
    entry = other.get_by_label("l, value with unit")
    entry.fill("0.5 m")
    entry.press("Enter")
    parameter(other, 0.5)
    parameter(one, 1.75)
    becomes_text(one, "1.75 m")


def wrong(address):
    """The address with another last letter."""
    return address[:-1] + ("A" if address[-1] != "A" else "B")


def test_without_the_right_token_the_browser_shows_nothing(browser, studio):
    context = browser.new_context()
    page = context.new_page()
    assert page.goto(studio.address.partition("?")[0]).status == 403
    assert page.goto(wrong(studio.new_address())).status == 403
    assert page.evaluate("window.rattle === undefined && document.scripts.length === 0")
    context.close()


def below(pid):
    """The processes that one has started, by number; none if it has ended."""
    with suppress(FileNotFoundError, ProcessLookupError):
        return [int(n) for task in Path(f"/proc/{pid}/task").iterdir() for n in (task / "children").read_text().split()]
    return []


def pages_computed(studio):
    """How many processes compute for pages: all are made by one that the studio keeps for that."""
    return sum(len(below(maker)) for maker in below(studio.process.pid))


def ends_at(count, studio):
    """Wait until so many pages have a process."""
    end = time.monotonic() + 60
    while pages_computed(studio) != count and time.monotonic() < end:
        time.sleep(0.3)
    assert pages_computed(studio) == count


def memory(pid):
    """Resident memory [MB]."""
    line = next(one for one in Path(f"/proc/{pid}/status").read_text().splitlines() if one.startswith("VmRSS"))
    return float(line.split()[1]) / 1e3


FEW = 8  # threads that a server may add when it pleases; 200 moves that leave one each are far more


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="threads are counted in /proc")
def test_two_hundred_quick_moves_and_a_closed_page_leave_nothing_behind(visit, studio):
    pid = studio.process.pid
    ends_at(0, studio)  # those of other tests end with their pages
    page = visit()
    becomes(page, "Boolean(window.rattle.viewer.scene.live)")
    move = """async (last) => {
      const slider = document.querySelector("#knob-l");
      for (let k = 0; k < 200; k++) {
        slider.value = 20 + (k % 2 ? k : 200 - k);
        slider.dispatchEvent(new Event("input", { bubbles: true }));
        if (k % 10 === 0) await new Promise((done) => setTimeout(done, 25));
      }
      slider.value = last;
      slider.dispatchEvent(new Event("input", { bubbles: true }));
    }"""
    page.evaluate(move, 320)
    parameter(page, 1.64)
    becomes(page, "() => document.querySelector('.work').hidden")
    threads, used = len(list(Path(f"/proc/{pid}/task").iterdir())), memory(pid)
    page.evaluate(move, 300)
    parameter(page, 1.55)
    becomes_text(page, 'value = "1.55 m"')  # the last one counts
    becomes(page, "() => document.querySelector('.work').hidden")
    assert len(list(Path(f"/proc/{pid}/task").iterdir())) <= threads + FEW
    assert memory(pid) < used + 15
    assert pages_computed(studio) == 1
    page.close()
    ends_at(0, studio)


SIZES = {"laptop": (1366, 768), "large": (1920, 1080), "phone": (390, 844)}


@pytest.mark.parametrize(
    ("size", "scheme"),
    [
        ("laptop", "dark"),
        ("phone", "light"),
        *(pytest.param(size, "light", marks=pytest.mark.long) for size in ("laptop", "large")),
    ],
)
def test_nothing_is_cut_off_and_the_trust_is_always_there(visit, size, scheme):
    width, height = SIZES[size]
    page = visit(viewport={"width": width, "height": height}, color_scheme=scheme)
    for tab in ("Motion", "Forces", "Text"):
        page.get_by_role("tab", name=tab).click()
        becomes(page, "() => document.querySelector('.work').hidden")
        frames(page)
        keep_picture(page, f"studio-{size}-{scheme}-{tab}")
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        box = page.locator(".status").bounding_box()
        assert box["y"] + box["height"] <= height + 1
        shows(page.locator("button.trust"))
    ground = page.evaluate("() => getComputedStyle(document.querySelector('.desk')).backgroundColor")
    assert (sum(map(int, ground[4:-1].split(","))) < 200) == (scheme == "dark")


def box_of(page, selector):
    """Left, top, right and bottom of an element."""
    box = page.locator(selector).bounding_box()
    return box["x"], box["y"], box["x"] + box["width"], box["y"] + box["height"]


# texts of the page that are smaller than 12 px on the glass
SMALL_TEXTS = """() => {
  const small = [];
  const look = (root) => {
    for (const el of root.querySelectorAll("*")) {
      if (el.shadowRoot) look(el.shadowRoot);
      const words = [...el.childNodes].some((node) => node.nodeType === 3 && node.textContent.trim());
      if (!words || el.matches("style, script, title") || !el.getClientRects().length) continue;
      const size = parseFloat(getComputedStyle(el).fontSize) * (el.getScreenCTM?.().a ?? 1) * visualViewport.scale;
      if (size < 11.95) small.push(`${el.tagName} ${size} ${el.textContent}`);
    }
  };
  look(document);
  return small;
}"""
HANDS = {"upright": (390, 844), "sideways": (844, 390)}


@pytest.mark.parametrize("held", HANDS)
def test_on_a_phone_all_is_as_wide_as_the_screen_and_readable(visit, held):
    width, height = HANDS[held]
    page = visit(
        viewport={"width": width, "height": height}, is_mobile=True, has_touch=True, first_time=True
    )  # nothing is in the way of a finger even then
    for tab in ("Forces", "Text", "Motion"):
        page.get_by_role("tab", name=tab).tap()
        becomes(page, "() => document.querySelector('.work').hidden")
        frames(page)
        keep_picture(page, f"studio-{held}-{tab}")
        assert page.evaluate("[innerWidth, document.documentElement.scrollWidth, visualViewport.scale]") == [
            width,
            width,
            1,
        ]
        for part in (".top", ".desk > main", ".status", f"#panel-{tab.lower()}"):
            left, top, right, bottom = box_of(page, part)
            assert left >= 0, (tab, part)
            assert top >= 0, (tab, part)
            assert right <= width, (tab, part)
            assert bottom <= height, (tab, part)
        assert page.evaluate(SMALL_TEXTS) == []
    knobs, main = box_of(page, "aside.knobs"), box_of(page, ".desk > main")
    assert knobs[1] >= main[3] if held == "upright" else knobs[0] >= main[2]
    assert (knobs[2], main[0]) == (width, 0)
    page.locator("#knob-l").tap(position={"x": 60, "y": 10})
    becomes(page, "window.rattle.parameters.l < 0.9")
    page.get_by_role("button", name="Save as").tap()
    page.get_by_label("File name").fill("")
    page.get_by_role("button", name="Close", exact=True).tap()
    page.locator("button.trust").tap()
    shows(page.locator("button.trust[aria-expanded=true]"))


def test_first_hints_cover_nothing_and_are_shown_until_they_were_read(visit):
    page = visit(first_time=True)
    hints = page.get_by_role("region", name="First hints")
    shows(hints)
    for tab in ("Text", "Motion"):
        page.get_by_role("tab", name=tab).click()
        foot, strip = box_of(page, ".hints")[3], box_of(page, ".strip")
        assert foot <= strip[1]
        assert strip[3] <= box_of(page, f"#panel-{tab.lower()}")[1]
    page.get_by_role("button", name="Got it").click()
    shows(hints, "detached")
    page.reload()
    becomes(page, "window.rattle && window.rattle.names.length > 5")
    assert hints.count() == 0
    page.keyboard.press("?")
    page.get_by_role("button", name="Show the first hints again").click()
    shows(hints)


def test_a_bar_of_an_ensemble_is_replayed(visit):
    page = visit()
    page.get_by_role("tab", name="Ensemble").click()
    page.get_by_label("mechanisms").fill("16")
    page.get_by_label("mechanisms").press("Enter")
    becomes(page, "() => /^16 mechanisms/.test(document.querySelector('.panel.ensemble .words').textContent)")
    counts = [int(bar.get_attribute("aria-label").split()[0]) for bar in page.locator(".histogram .bin").all()]
    assert sum(counts) == 16
    page.locator(".histogram .bin").nth(counts.index(max(counts))).click()
    shows(page.locator(".sample", has_text="of the ensemble"))
    becomes(page, "window.rattle.parameters.l !== 1")
    page.get_by_role("button", name="Back to the model").click()
    parameter(page, 1.0)


def test_a_studio_ends_at_once_when_it_is_told_to(tmp_path):
    (tmp_path / "m.toml").write_text(PENDULUM)
    served = start_studio(tmp_path, "m.toml", "--no-browser")
    served.process.terminate()
    assert served.process.wait(30) == 0  # and not when a connection or a computation ends


# ---------------------------------------------------------------- secrets
SLEEPER = """#!/bin/sh
echo "$@" > "$SEEN.part"
mv "$SEEN.part" "$SEEN"
"""


@pytest.mark.skipif(os.name != "posix", reason="a program that stands for the browser is a shell script")
def test_a_browser_is_led_to_the_page_by_a_file_that_only_its_user_reads(tmp_path, browser):
    """What stands on the command line of the browser, where every user reads it, is no secret."""
    (tmp_path / "m.toml").write_text(PENDULUM)
    program, seen = tmp_path / "browser.sh", tmp_path / "seen"
    program.write_text(SLEEPER)
    program.chmod(0o700)
    served = start_studio(tmp_path, "m.toml", BROWSER=str(program), SEEN=str(seen))
    try:
        while not seen.exists():
            assert served.process.poll() is None
            time.sleep(0.02)
        words = seen.read_text()
        assert "token" not in words
        assert words.startswith("file://")
        file = Path(url2pathname(urlsplit(words.strip()).path))
        assert file.stat().st_mode & 0o077 == 0
        assert file.parent.stat().st_mode & 0o077 == 0
        context = browser.new_context()
        page = context.new_page()
        page.goto(file.as_uri())
        page.wait_for_url(lambda place: place.startswith("http") and place.endswith("/"))
        becomes(page, "window.rattle && window.rattle.names.length > 5")
        context.close()
        assert served.ask(urlsplit(served.address).path + "?" + urlsplit(served.address).query).status == 303
    finally:
        served.process.terminate()
        assert served.process.wait(10) == 0
    assert not file.exists()


def test_another_port_of_this_computer_never_gets_the_cookie(visit):
    """A page of the studio is open; another server of the same host is visited, and sends the browser on to itself."""
    page = visit()
    heard = []

    class Listener(BaseHTTPRequestHandler):
        def do_GET(self):
            heard.append(self.headers.get("Cookie"))
            self.send_response(302 if self.path == "/first" else 200)
            if self.path == "/first":
                self.send_header("Location", "/second")
            self.send_header("Content-Length", "0")
            self.end_headers()

        def log_message(self, *_):
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), Listener) as listener:
        threading.Thread(target=listener.serve_forever, daemon=True).start()
        other = page.context.new_page()
        other.goto(f"http://127.0.0.1:{listener.server_address[1]}/first")
        other.close()
        listener.shutdown()
    assert len(heard) >= 2
    assert set(heard) == {None}


def test_a_studio_that_was_ended_is_missed_and_the_text_stays(visit, tmp_path):
    (tmp_path / "m.toml").write_text(PENDULUM)
    served = start_studio(tmp_path, "m.toml", "--no-browser")
    page = visit(served)
    served.process.terminate()
    assert served.process.wait(10) == 0
    shows(page.get_by_role("heading", name="The studio does not answer"))
    page.get_by_role("button", name="Stay here").click()
    page.get_by_role("tab", name="Text").click()
    assert text_of(page) == PENDULUM
