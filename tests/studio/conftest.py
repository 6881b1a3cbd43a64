"""A studio that is served in a folder of its own, for tests that ask it over the network."""

import pytest
from studio_models import PENDULUM, start_studio

from browsing import becomes


@pytest.fixture(scope="session")
def studio(tmp_path_factory):
    """A studio with the model of a pendulum, and a file outside of its folder with a link to it."""
    pytest.importorskip("uvicorn")
    outside = tmp_path_factory.mktemp("outside")
    (outside / "secret.toml").write_text(PENDULUM.replace("a pendulum", "a secret"))
    folder = tmp_path_factory.mktemp("studio")
    (folder / "m.toml").write_text(PENDULUM)
    (folder / "link.toml").symlink_to(outside / "secret.toml")
    served = start_studio(folder, "m.toml", "--no-browser")
    yield served
    served.process.terminate()
    assert served.process.wait(10) == 0


@pytest.fixture
def visit(open_page, studio):
    """A function that opens a page of the studio and waits until it shows a motion; the model is the file's again."""
    (studio.folder / "m.toml").write_text(PENDULUM)
    asked, ports = [], set()

    def opened(served=studio, first_time=False, **options):
        page = open_page("about:blank", **options)
        page.on("request", lambda one: asked.append(one.url))
        if not first_time:
            page.add_init_script("localStorage.setItem('rattle-studio-hints', 'seen')")
        ports.add(served.port)
        page.goto(served.new_address())
        becomes(page, "window.rattle && window.rattle.names.length > 5")
        return page

    yield opened
    ours = (*(f"http://127.0.0.1:{port}/" for port in ports), "data:", "blob:", "about:")
    assert [one for one in asked if not one.startswith(ours)] == []
