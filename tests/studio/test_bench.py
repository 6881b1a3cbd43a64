"""The process that computes for one session: the latest request counts, a run can be stopped, nothing is left."""

import multiprocessing
import queue
import threading
import time

import pytest
from studio_models import PENDULUM

from rattle.studio.bench import Bench, Outcome

LONG = PENDULUM.replace('t_end = "1 s"', 't_end = "1e5 s"\nrtol = 1e-12\noutput = 1e4')


class Thread:
    """The thread of a page: calls are brought into it by `post`, and made by `until`."""

    def __init__(self):
        self.calls, self.heard = queue.Queue(), []
        self.bench = Bench(lambda name, outcome: self.heard.append((name, outcome)), self.calls.put)

    def until(self, true, seconds=40):
        end = time.monotonic() + seconds
        while not true():
            assert time.monotonic() < end, self.heard[-3:]
            try:
                self.calls.get(timeout=0.05)()
            except queue.Empty:
                continue

    def kinds(self):
        return [(name, outcome.kind) for name, outcome in self.heard if outcome.kind != "progress"]


@pytest.fixture
def page():
    """A bench with its thread; at the end neither a process nor a thread of it may be left."""
    before = set(multiprocessing.active_children()), set(threading.enumerate())
    made = Thread()
    yield made
    made.bench.end()
    assert set(multiprocessing.active_children()) <= before[0]
    left = set(threading.enumerate()) - before[1]
    assert not [one for one in left if not isinstance(one, threading.Timer)]


def source(length):
    return {"text": PENDULUM.replace('value = "1 m"', f'value = "{length} m"'), "file": ""}


def test_of_two_hundred_quick_requests_the_last_one_is_answered(page):
    began = len(threading.enumerate())
    page.bench.ask("motion", source=source(1.0))
    page.until(lambda: page.kinds())
    page.heard.clear()
    lengths = [round(0.5 + 0.005 * k, 3) for k in range(200)]
    for length in lengths:
        page.bench.ask("motion", source=source(length))
        assert len(page.bench.waiting) <= 1
    page.until(lambda: not page.bench.busy and not page.bench.waiting)
    done = [outcome.value for name, outcome in page.heard if outcome.kind == "done"]
    assert len(done) == 1  # all others were dropped, or stopped on the way
    assert done[0]["scene"]["runs"][0]["parameters"] == {"l": lengths[-1]}
    assert len(multiprocessing.active_children()) == 1
    assert len(threading.enumerate()) <= began + 1


def test_a_run_is_stopped_and_tells_how_far_it_was(page):
    page.bench.ask("motion", source={"text": LONG, "file": ""})
    page.until(lambda: any(outcome.kind == "progress" and outcome.value[1] > 0 for _, outcome in page.heard))
    what, share = page.heard[-1][1].value
    assert what == "simulate"
    assert 0 < share < 1
    began = time.monotonic()
    page.bench.stop("motion")
    page.until(lambda: page.kinds() == [("motion", "stopped")])
    assert time.monotonic() - began < 2
    page.heard.clear()
    page.bench.ask("motion", source=source(1.0))  # the same process goes on
    page.until(lambda: page.kinds() == [("motion", "done")])


def test_the_motion_goes_before_all_that_waits(page):
    page.bench.ask("equilibrium", source=source(1.0))
    page.bench.ask("thumbnail slider_crank", example="slider_crank")
    page.bench.ask("forces", source=source(1.0))
    page.bench.ask("motion", source=source(1.0))
    page.until(lambda: len(page.kinds()) == 4)
    assert [name for name, _ in page.kinds()] == ["equilibrium", "motion", "forces", "thumbnail slider_crank"]
    assert {kind for _, kind in page.kinds()} == {"done"}


def test_an_answer_to_what_was_dropped_is_not_told_though_it_was_on_its_way(page):
    number = page.bench.ask("forces", source=source(1.0))
    page.bench._process.wait()
    page.bench.drop("forces")
    page.bench._hear(page.bench._process, Outcome(number, "done", "of the model before"))
    assert page.kinds() == [("forces", "stopped")]


def test_an_answer_that_is_an_error_is_plain_words(page):
    page.bench.ask("accuracy", source=source(1.0), of="rod.angle")
    page.until(lambda: page.kinds())
    assert page.heard[-1][1].kind == "failed"
    assert "no joint has a clearance" in page.heard[-1][1].value
    assert "Traceback" not in page.heard[-1][1].value


def test_a_process_that_is_ended_from_outside_is_replaced(page):
    page.bench.ask("motion", source={"text": LONG, "file": ""})
    page.until(lambda: any(outcome.kind == "progress" for _, outcome in page.heard))
    page.bench._process._process.kill()
    page.until(lambda: page.kinds())
    assert page.heard[-1][1].kind == "failed"
    page.bench.ask("motion", source=source(1.0))
    page.until(lambda: ("motion", "done") in page.kinds())
