"""How machine code comes to call laws in Python: translated, compiled by Numba, or by a call of the interpreter."""

import importlib.util
import logging
import math
import sys

import numpy as np
import pytest
from test_contact_law import BUSH

import rattle as rt
from rattle import registry
from rattle.elements.custom import load_law
from rattle.elements.custom.contact_law import friction_law, normal_law
from rattle.jit import functions

pytestmark = [
    pytest.mark.usefixtures("laws"),
    pytest.mark.skipif(not functions.start(), reason="runs without machine code"),
]
with_numba = pytest.mark.skipif(importlib.util.find_spec("numba") is None, reason="needs the extra `laws`")


def bounce(law, friction, t_end=0.004):
    contact = f'{{ {law}, stiffness = 1e9, bush_radius = "1 cm", friction = {{ {friction} }} }}'
    return rt.loads(BUSH.format(contact=contact, vy=0.4)).simulate(t_end, horizon=False)


@pytest.fixture
def _no_numba(monkeypatch):
    monkeypatch.setitem(sys.modules, "numba", None)


def damped(static, delta, ddelta, v0, p):
    return static * (1.0 + p.a * ddelta / v0)


def damped_by_words(static, delta, ddelta, v0, p):
    return {"F": static}["F"] * (1.0 + p.a * ddelta / v0)


def bristles(u, N, z, p):
    first, second = z
    force = p.s * first + 0.5 * p.s * second
    return min(max(force, -p.mu * N), p.mu * N), (u * (1.0 - abs(first) * 1e3), np.minimum(u, 1.0))


def bristles_by_words(u, N, z, p):
    return {"found": bristles(u, N, z, p)}["found"]


def smooth(u, N, p):
    return p.mu * N * np.tanh(u / 1e-3)


def smooth_by_list(u, N, p):
    return sum([p.mu * N * math.tanh(u / 1e-3) * n for n in range(2)])


FRICTION = 'model = "{}", mu = 0.2, s = 1e7'


@pytest.mark.usefixtures("_no_numba")
def test_laws_as_plain_python_give_the_bits_of_laws_as_machine_code(caplog):
    normal_law("damped", a="")(damped)
    normal_law("damped by words", a="")(damped_by_words)
    friction_law("bristles", states=2, mu="", s="")(bristles)
    friction_law("bristles by words", states=2, mu="", s="")(bristles_by_words)
    one = bounce('model = "damped", a = 0.5', FRICTION.format("bristles"))
    assert "plain Python" not in caplog.text
    two = bounce('model = "damped by words", a = 0.5', FRICTION.format("bristles by words"))
    for word in ("normal law 'damped", "friction law 'bristles"):
        told = f"{word} by words' runs as plain Python, slower: test_law_kernel."
        (found,) = (message for message in caplog.messages if told in message)  # once
        assert "' is not known here" in found
        assert "_by_words, line " in found
    assert one.success
    assert two.success
    assert abs(one["pin.omega"][-1]) > 1.0
    for name in one.names:
        np.testing.assert_array_equal(one[name], two[name])


@with_numba
def test_what_the_translation_refuses_numba_compiles(caplog):
    friction_law("smooth", mu="")(smooth)
    friction_law("smooth by list", mu="")(smooth_by_list)
    friction_law("bristles", states=2, mu="", s="")(bristles)
    with caplog.at_level(logging.INFO, logger="rattle"):
        one, two = (bounce('model = "hertz"', f'model = "{name}", mu = 0.2') for name in ("smooth", "smooth by list"))
    assert "friction law 'smooth by list' is compiled by Numba, which takes longer: test_law_kernel." in caplog.text
    assert "'smooth'" not in caplog.text
    np.testing.assert_allclose(one["pin.omega"], two["pin.omega"], rtol=1e-9)


@with_numba
def test_a_law_that_numba_has_compiled_is_a_law(caplog):
    import numba

    friction_law("theirs", mu="")(numba.njit(smooth))
    friction_law("smooth", mu="")(smooth)
    one, two = (bounce('model = "hertz"', f'model = "{name}", mu = 0.2') for name in ("smooth", "theirs"))
    assert not caplog.messages
    np.testing.assert_array_equal(one["pin.omega"], two["pin.omega"])


@with_numba
def test_laws_of_every_form_are_compiled_by_numba():
    from rattle.jit import numba_laws

    kernels = [
        load_law.LawKernel("a", lambda t, state, p: (state[1], 2.0, p.c), ["c"]),
        load_law.LawKernel("b", lambda t, length, rate, p: length + rate, [], True, load_law.FORMS["points"]),
        load_law.LawKernel("c", lambda t, a, b, p: (a[5], b[0], 1.0), [], True, load_law.FORMS["bodies"]),
    ]
    friction_law("bristles", states=2, mu="", s="")(bristles)
    kernels.append(registry.kinds("friction")["bristles"].kernel)
    for one in kernels:
        found = numba_laws.entry(one.law, one.pack, one.sizes, one.result)
        assert found.address
        assert len(found.letters) == 1 + sum(max(1, size) for size in one.sizes) + len(one.pack._fields)


@pytest.mark.usefixtures("_no_numba")
def test_an_exception_of_a_law_as_plain_python_is_told_as_it_is():
    @normal_law("short of words")
    def short_of_words(static, delta, ddelta, v0, p):
        return {"F": static}["G"] if delta > 1e-6 else static

    r = bounce('model = "short of words"', 'model = "coulomb-smooth", mu = 0.1')
    assert not r.success
    assert "joint 'O': normal law 'short of words' raised KeyError: 'G' (at a penetration of 1" in r.message


@pytest.mark.usefixtures("_no_numba")
def test_ctrl_c_in_a_contact_law_stops_the_run():
    @normal_law("stopped")
    def stopped(static, delta, ddelta, v0, p):
        if {"deep": delta > 1e-6}["deep"]:
            raise KeyboardInterrupt
        return static

    r = bounce('model = "stopped"', 'model = "coulomb-smooth", mu = 0.1')
    assert "stopped by the user" in r.message
    assert rt.example("bouncing_pin").simulate(1e-3).success  # and is over then


def test_a_python_function_fails_with_its_own_exception():
    from rattle.jit import machine

    class Own(Exception):
        """Of a user."""

    def law(x):
        if x > 1.0:
            raise Own("too large")
        return (2.0 * x,)

    entry = machine.python_entry(law, "f", 1)

    def run(x):
        return entry(x) + 1.0

    kernel = functions.KernelFunction(run, letters="ff")
    assert kernel(1.0) == 3.0
    with pytest.raises(Own, match="too large"):
        kernel(2.0)
