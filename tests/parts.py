"""Which tests `make test` runs, by measured times: `--part quick`; `--part rest` runs all others but the long ones.

`measured.txt` beside this file has the processor seconds of every test and of every fixture that several tests share
which took more than LISTED, measured with machine code; `make times` writes it anew. A test that is not listed is
quick; one that asks for a slow fixture is not, and none that opens a browser is.
"""

import os
from pathlib import Path

import pytest

MEASURED = Path(__file__).with_name("measured.txt")
LISTED = 0.3  # [s] of processor time; what takes less is not worth a line
QUICK = 0.29  # [s] the slowest test of `make test`: one that is listed is not quick
SLOW_FIXTURES = ("browser",)
STARTED = pytest.StashKey[float]()  # when a test began
SHARED = pytest.StashKey[float]()  # what fixtures of several tests have taken so far


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--part", choices=("all", "quick", "rest"), default="all", help="see tests/parts.py")
    parser.addoption("--measure", action="store_true", help="write the times of all tests into tests/measured.txt")


def pytest_configure(config: pytest.Config) -> None:
    config.stash[SHARED] = 0.0
    config.pluginmanager.register(_Times(), "times")


def processor_time() -> float:
    """Processor seconds of this process and of its children that have ended."""
    now = os.times()
    return now.user + now.system + now.children_user + now.children_system


def shared_fixtures(item: pytest.Item) -> list[str]:
    """The names, as in `measured.txt`, of the fixtures of a test that it shares with others."""
    by_name = getattr(item, "_fixtureinfo", None)
    definitions = [] if by_name is None else [each[-1] for each in by_name.name2fixturedefs.values()]
    return [_fixture_name(each) for each in definitions if each.scope != "function"]


def _fixture_name(definition: pytest.FixtureDef) -> str:
    return f"{definition.baseid}@{definition.argname}"


def _measured() -> dict[str, float]:
    """Seconds of what `measured.txt` lists."""
    lines = MEASURED.read_text().splitlines() if MEASURED.exists() else []
    rows = (line.split(" ", 1) for line in lines if line and not line.startswith("#"))
    return {name: float(seconds) for seconds, name in rows}


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    part = config.option.part
    if part == "all":
        return
    seconds = _measured()

    def is_quick(item: pytest.Item) -> bool:
        names = [item.nodeid, *shared_fixtures(item)]
        browses = any(name in getattr(item, "fixturenames", ()) for name in SLOW_FIXTURES)
        return not browses and sum(seconds.get(name, 0.0) for name in names) <= QUICK

    kept = [i for i in items if i.get_closest_marker("long") is None and is_quick(i) == (part == "quick")]
    chosen = set(kept)
    config.hook.pytest_deselected(items=[i for i in items if i not in chosen])
    items[:] = kept


class _Times:
    """Takes the time of tests and of the fixtures that they share, and writes the list at the end."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self.fixtures: dict[str, float] = {}  # those set up since the last test

    @pytest.hookimpl(hookwrapper=True)
    def pytest_fixture_setup(self, fixturedef, request):
        if fixturedef.scope == "function":
            yield
            return
        before = processor_time() - request.config.stash[SHARED]  # without the fixtures that this one asks for
        yield
        took = processor_time() - request.config.stash[SHARED] - before
        request.config.stash[SHARED] += took
        self.fixtures[_fixture_name(fixturedef)] = took

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_setup(self, item):
        item.stash[STARTED] = processor_time() - item.config.stash[SHARED]

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_teardown(self, item):
        took = processor_time() - item.config.stash[SHARED] - item.stash[STARTED]
        item.user_properties.append(("seconds", {item.nodeid: took, **self.fixtures}))
        self.fixtures.clear()

    def pytest_runtest_logreport(self, report):
        if report.when == "teardown":
            self.seconds.update(dict(report.user_properties).get("seconds", {}))

    def pytest_sessionfinish(self, session):
        config = session.config
        if not config.option.measure or hasattr(config, "workerinput"):
            return
        rows = sorted((name, took) for name, took in self.seconds.items() if took > LISTED)
        head = "# processor seconds with machine code of what takes longer than the others: `make times`\n"
        MEASURED.write_text(head + "".join(f"{took:.1f} {name}\n" for name, took in rows))
