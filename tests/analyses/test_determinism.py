"""The same input gives the same bits: twice, after another run, and in several threads at once."""

import hashlib
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import rattle as rt
from rattle.results.result import Result

NAMES = ("chain", "fourbar", "quick_return", "squeezer", "windows")
CONTACTS = (
    ("slider_crank_play", None),
    ("bouncing_pin", "event"),
    ("fourbar_onesided", "event"),
    ("three_plays", "moreau"),
)


def bits(r: Result) -> bytes:
    return b"".join(np.ascontiguousarray(r[name]).tobytes() for name in r.stored)


def run(name: str) -> bytes:
    return bits(rt.example(name).simulate())


@pytest.fixture(scope="module")
def alone() -> dict[str, bytes]:
    return {name: run(name) for name in NAMES}


@pytest.mark.parametrize("name", NAMES)
def test_the_same_input_gives_the_same_bits(alone, name):
    assert run(name) == alone[name]
    m = rt.example(name)
    assert bits(m.simulate()) == bits(m.simulate()) == alone[name]


@pytest.mark.parametrize(("name", "method"), CONTACTS)
def test_contacts_give_the_same_bits_alone_and_in_threads(name, method):
    """Compliant contacts, impacts from event to event, and time stepping over them."""
    m = rt.example(name)
    first = m.simulate(0.02, method=method)
    assert first.events
    with ThreadPoolExecutor(2) as pool:
        together = list(pool.map(lambda one: one.simulate(0.02, method=method), [m, rt.example(name), m]))
    assert [bits(one) for one in together] == [bits(first)] * 3
    assert [one.events for one in together] == [first.events] * 3


@pytest.mark.nojit
def test_the_same_bits_without_machine_code_too():
    m = rt.example("slider_crank")
    assert bits(m.simulate(2e-3)) == bits(rt.example("slider_crank").simulate(2e-3))


def test_two_threads_give_the_bits_of_one(alone):
    with ThreadPoolExecutor(2) as pool:
        together = list(pool.map(run, NAMES * 3))
    assert together == [alone[name] for name in NAMES * 3]


def test_two_threads_may_share_one_mechanism(alone):
    m = rt.example("fourbar")
    system = threading.Barrier(2)

    def go(_: int) -> bytes:
        system.wait()
        return bits(m.simulate())

    with ThreadPoolExecutor(2) as pool:
        assert list(pool.map(go, range(2))) == [alone["fourbar"]] * 2


def test_a_new_process_gives_the_same_bits(alone, tmp_path):
    code = (
        "import hashlib, numpy as np, rattle as rt\n"
        "for name, method in (('fourbar', None), *%r):\n"
        "    r = rt.example(name).simulate(None if name == 'fourbar' else 0.02, method=method)\n"
        "    print(hashlib.sha256(b''.join(np.ascontiguousarray(r[n]).tobytes() for n in r.stored)).hexdigest())"
    )
    out = subprocess.run(
        [sys.executable, "-c", code % (CONTACTS,)], capture_output=True, text=True, check=True, cwd=tmp_path
    ).stdout
    here = [bits(rt.example(name).simulate(0.02, method=method)) for name, method in CONTACTS]
    assert out.split() == [hashlib.sha256(one).hexdigest() for one in (alone["fourbar"], *here)]
