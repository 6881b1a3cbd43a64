"""Live pages in a headless browser: the first motion, and a new one after a slider is turned."""

from __future__ import annotations

import shutil
import tempfile
import time
from functools import partial
from pathlib import Path
from typing import Any

import rattle as rt
from measure import Row, Sampler, interleave

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
FIRST = "() => window.rattle?.live && window.rattle.statistics?.steps > 0"
TURN = """async ([name, value]) => {
    const began = performance.now();
    await window.rattle.set(name, value);
    return (performance.now() - began) / 1000;
}"""
# example: a parameter, two values of it, aims of the first motion and of a new one
PAGES = {
    "crank_rocker_play": ("c", (0.0004, 0.0005), "1 s", "0.1 s"),
    "slider_crank_play": ("c", (0.0004, 0.0005), "1 s", "0.15 s"),
    "fourbar_onesided": ("l2", (0.6, 0.601), "1 s", ""),
    "fourbar_oil": ("omega", (30.0, 31.0), "1 s", ""),
}


def rows(repeats: int) -> list[Row]:
    """Times in the browser, against `simulate` of the same motion; none where there is no browser."""
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        return []
    browser_path = next((path for name in BROWSERS if (path := shutil.which(name))), None)
    if browser_path is None:
        return []
    table = []
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as play:
        browser = play.chromium.launch(executable_path=browser_path, args=["--no-sandbox"])
        for name, (parameter, values, first_aim, turn_aim) in PAGES.items():
            m, place = rt.example(name), Path(folder) / f"{name}.html"
            m.page(place)
            parameter = parameter if parameter in m.parameters else next(iter(m.parameters))
            tab = browser.new_page()
            tab.goto(place.as_uri())
            tab.wait_for_function(FIRST)
            median = interleave(
                {
                    "first": partial(_opened, browser, place),
                    "turned": _turned(tab, parameter, values),
                    "simulate": partial(_simulated, m, parameter, values[0]),
                },
                repeats,
            )
            yardstick = f"simulate {name}"
            table += [
                Row(f"page of {name}, first motion", median["first"], yardstick, median["simulate"], first_aim),
                Row(f"page of {name}, {parameter} turned", median["turned"], yardstick, median["simulate"], turn_aim),
                Row(f"page of {name}, size [MB]", place.stat().st_size / 1e6, aim="0.6", seconds=False),
            ]
            tab.close()
        browser.close()
    return table


def _opened(browser: Any, place: Path) -> float:
    tab = browser.new_page()
    began = time.perf_counter()
    tab.goto(place.as_uri())
    tab.wait_for_function(FIRST)
    took = time.perf_counter() - began
    tab.close()
    return took


def _turned(tab: Any, parameter: str, values: tuple[float, float]) -> Sampler:
    turns = 0

    def sample() -> float:
        nonlocal turns
        turns += 1
        return float(tab.evaluate(TURN, [parameter, values[turns % 2]]))

    return sample


def _simulated(m: rt.Mechanism, parameter: str, value: float) -> float:
    began = time.perf_counter()
    m.set({parameter: value}).simulate()
    return time.perf_counter() - began
