"""A studio that is served in a folder of its own, for tests that ask it over the network."""

import pytest
from studio_models import PENDULUM, start_studio


@pytest.fixture(scope="session")
def studio(tmp_path_factory):
    """A studio with the model of a pendulum, and a file outside of its folder with a link to it."""
    pytest.importorskip("panel")
    outside = tmp_path_factory.mktemp("outside")
    (outside / "secret.toml").write_text(PENDULUM.replace("a pendulum", "a secret"))
    folder = tmp_path_factory.mktemp("studio")
    (folder / "m.toml").write_text(PENDULUM)
    (folder / "link.toml").symlink_to(outside / "secret.toml")
    served = start_studio(folder, "m.toml", "--no-browser")
    yield served
    served.process.terminate()
    assert served.process.wait(10) == 0
