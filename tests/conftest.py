"""How the tests run: the same inputs every time, no window system, and a smaller set without machine code."""

import os

import pytest
from hypothesis import settings

from browsing import browser, open_page  # noqa: F401  # fixtures
from rattle import registry

pytest_plugins = ["parts"]

os.environ["MPLBACKEND"] = "Agg"
JIT = os.environ.get("RATTLE_JIT") != "python"

settings.register_profile("rattle", derandomize=True, deadline=None, max_examples=100 if JIT else 20)
settings.load_profile("rattle")


def pytest_configure(config: pytest.Config) -> None:
    """Without machine code only the tests marked `nojit` are affordable."""
    if not JIT and not config.option.markexpr:
        config.option.markexpr = "nojit and not machine and not long"


@pytest.fixture
def laws():
    """Laws of a test leave the registry after it."""
    before = {family: dict(registry.kinds(family)) for family in ("load", "normal", "friction")}
    yield
    for family, kinds in before.items():
        entries = registry._families[family]
        entries.clear()
        entries.update(kinds)
