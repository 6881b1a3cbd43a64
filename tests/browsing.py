"""One browser for all tests of pages and of the studio; pictures of what they show are kept, to be looked at."""

import shutil
import time
from pathlib import Path

import pytest

PICTURES = Path(__file__).parent.parent / "build" / "screenshots"

PATIENCE = 60.0  # with what a page computes, on a machine that has other work too [s]
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
WITHIN = (
    "file:",
    "data:",
    "blob:",
    "about:",
    "http://127.0.0.1",
    "http://localhost",
    "ws://127.0.0.1",
    "ws://localhost",
)


def keep_picture(page, name):
    """Keep what a page shows now as build/screenshots/NAME.png."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    page.screenshot(path=PICTURES / f"{name}.png")


DRAWN = """([n, patience]) => new Promise((done, fail) => {
  setTimeout(() => fail(new Error("the browser draws no pictures")), patience);
  const next = () => (n-- > 0 ? requestAnimationFrame(next) : done());
  next();
})"""


# a page unpacks its viewer after it is loaded: a test that is faster would find nothing
MOUNTED = "() => { const root = document.getElementById('rattle'); return !root || root.hasChildNodes(); }"


def frames(page, count=3):
    """Wait for so many pictures of the page: what was asked for before has been drawn after the second."""
    page.evaluate(DRAWN, [count, 1000.0 * PATIENCE])


def becomes(page, condition, argument=None):
    """Wait until a condition in JavaScript holds; also on a page whose policy forbids scripts to make code of texts."""
    end = time.monotonic() + PATIENCE
    while not page.evaluate(condition, argument):
        assert time.monotonic() < end, f"never: {condition}"
        page.wait_for_timeout(20)


def shows(locator, state="visible"):
    """Wait until an element is there, or with another state until it is not."""
    locator.wait_for(state=state)


@pytest.fixture(scope="session")
def browser():
    """Chromium, once for all tests; without it they are skipped."""
    program = next(filter(None, map(shutil.which, BROWSERS)), None)
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    if program is None:
        pytest.skip(f"no browser: none of {', '.join(BROWSERS)} is installed")
    with playwright.sync_playwright() as play:
        options = ["--no-sandbox", "--disable-gpu", "--disable-background-networking"]
        one = play.chromium.launch(executable_path=program, args=options)
        yield one
        one.close()


@pytest.fixture
def open_page(browser):
    """A function that opens an address in a fresh tab; at the end no tab may have said an error or asked outside."""
    contexts, wrong = [], []

    def open_one(address, **options):
        context = browser.new_context(**{"viewport": {"width": 1366, "height": 768}, **options})
        contexts.append(context)
        page = context.new_page()
        page.on("console", lambda said: wrong.append(said.text) if said.type == "error" else None)
        page.on("pageerror", lambda error: wrong.append(str(error)))
        page.on("request", lambda one: None if one.url.startswith(WITHIN) else wrong.append(f"asked for {one.url}"))
        page.goto(address)
        page.wait_for_function(MOUNTED)
        return page

    yield open_one
    for context in contexts:
        context.close()
    assert wrong == []
