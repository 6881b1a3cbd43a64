"""Contracts hold in either mode."""

import pytest

from rattle.jit import functions


@pytest.fixture(params=["python", "machine"])
def mode(request, monkeypatch):
    """Every contract holds as plain Python and as machine code."""
    if request.param == "python":
        monkeypatch.setattr(functions, "_jit", False)
    elif not functions.start():
        pytest.skip("machine code is switched off")
