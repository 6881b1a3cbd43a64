"""Samples on executors and on Dask: the same bits as in this process, whatever happens to the workers."""

import logging
import os
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest

import rattle as rt
from rattle.errors import MissingPackage, WorkerError
from rattle.questions.ensemble import engines, work
from rattle.questions.ensemble import local_workers as local
from rattle.questions.ensemble.local_workers import local_workers
from rattle.studies.runs.ctrl_c import noticed

OF = ["quantile(rocker.angle, 0.9)", "at(rocker.omega, 0.05)"]
PROCESSES = get_context("spawn")  # what every system has


def kinematics(n, m=None, **options):
    """A study whose samples run one by one, some hundredths of a second each; every other one cannot be closed."""
    m = rt.example("fourbar").ideal() if m is None else m
    l2 = np.column_stack([np.linspace(0.58, 0.62, n - n // 2), np.full(n - n // 2, 2.0)]).ravel()[:n]
    return m.sweep({"l2": l2}, OF, analysis="kinematics", t_end=0.1, **options)


def assert_same(found, wanted):
    for name in ("l2", *OF):
        np.testing.assert_array_equal(found[name], wanted[name])
    np.testing.assert_array_equal(found.store.generic(), wanted.store.generic())
    assert found.counts() == wanted.counts()
    assert found.counts()["ok"] > 0 < found.counts()["failed"]
    assert found.messages == wanted.messages


@pytest.fixture(scope="module")
def forty():
    return kinematics(40, threads=1)


@pytest.fixture(scope="module")
def processes():
    with ProcessPoolExecutor(2, PROCESSES) as pool:
        yield pool


@pytest.fixture(scope="module")
def scheduler():
    pytest.importorskip("distributed")
    with local_workers(2) as (address, _):
        yield address


def counted_once(folder, n):
    """Whether every sample is a row of one file."""
    from pyarrow import parquet

    numbers = np.concatenate([parquet.read_table(one)["sample"].to_numpy() for one in folder.glob("samples-*")])
    return sorted(numbers.tolist()) == list(range(n))


# ---------------------------------------------------------------- the same numbers everywhere
def test_threads_and_processes_give_the_same_bits(forty, processes, tmp_path):
    pytest.importorskip("pyarrow")
    assert forty.how.endswith("on 1 thread: quantile(...) needs a whole curve")
    assert_same(kinematics(40, threads=2), forty)
    with ThreadPoolExecutor(2) as pool:
        found = kinematics(40, executor=pool)
        assert_same(found, forty)
        assert found.how.startswith("40 one by one on 2 threads (ThreadPoolExecutor): quantile")
    found = kinematics(40, executor=processes, folder=tmp_path)
    assert_same(found, forty)
    assert "in 2 processes (ProcessPoolExecutor), kept in" in found.how
    assert counted_once(tmp_path, 40)
    assert processes.submit(abs, -1).result() == 1  # it is the user's, and still works


def test_ensembles_side_by_side_have_the_same_bits_elsewhere(processes):
    def made(**options):
        of = ["final(rod.angle)", "max(rod.omega)"]
        return pendulum().ensemble(200, of, {"l": "1 mm"}, seed=7, t_end=0.5, **options)

    here, there = made(threads=1), made(executor=processes)
    for name in ("l", *here.outputs):
        np.testing.assert_array_equal(there[name], here[name])
    assert "200 run side by side in" in there.how
    assert there.summary().equals(here.summary())


def test_histories_come_back_from_other_processes(processes, tmp_path):
    pytest.importorskip("pyarrow")
    pytest.importorskip("h5netcdf")

    def made(**options):
        curves = ["rod.angle"]
        return pendulum().ensemble(40, ["final(rod.angle)"], {"l": "1 mm"}, t_end=0.2, histories=curves, **options)

    here, there = made(), made(executor=processes, folder=tmp_path)
    t, angles = there.histories("rod.angle")
    np.testing.assert_array_equal(angles, here.histories("rod.angle")[1])
    np.testing.assert_array_equal(angles[:, -1], there["final(rod.angle)"])
    assert t[-1] == 0.2


def pendulum():
    return rt.loads("""
format = 1
gravity = [0, -9.81]
[parameters]
l = "0.5 m"
[ground.points]
O = [0, 0]
[bodies.rod]
bar = ["O", "P"]
length = "l"
mass = 1
[joints.O]
type = "revolute"
connect = ["ground.O", "rod.O"]
[initial]
rod = { angle = "-30 deg", omega = 0 }
""")


def test_dask_gives_the_same_bits_also_when_a_worker_is_killed(forty, scheduler, tmp_path):
    """A worker process ends in the middle of its work: its pieces run again, and no sample counts twice."""
    pytest.importorskip("pyarrow")
    found = kinematics(40, scheduler=scheduler)
    assert_same(found, forty)
    assert f"in 2 processes (Dask, {scheduler})" in found.how
    from distributed import Client

    with Client(scheduler, set_as_default=False) as client:
        victim = next(iter(client.run(os.getpid).values()))
    killed = []

    def kill():
        until = time.monotonic() + 20.0
        while len(list(tmp_path.glob("samples-*"))) < 2 and time.monotonic() < until:
            time.sleep(0.01)
        killed.append(len(list(tmp_path.glob("samples-*"))))
        os.kill(victim, signal.SIGKILL)

    killer = threading.Thread(target=kill)
    killer.start()
    found = kinematics(200, scheduler=scheduler, folder=tmp_path)
    killer.join()
    assert killed[0] < len(list(tmp_path.glob("samples-*")))
    assert counted_once(tmp_path, 200)
    assert_same(found, kinematics(200))


def test_a_result_whose_worker_is_killed_before_it_is_fetched_is_made_again(scheduler, tmp_path):
    from distributed import Client

    written, fetching, gate = tmp_path / "written", threading.Event(), threading.Event()

    def hold(_):  # nothing else is fetched meanwhile
        fetching.set()
        gate.wait(60.0)

    with Client(scheduler, set_as_default=False) as client:
        victims = client.run(os.getpid).values()
    with engines.engine(None, scheduler, None) as found:
        try:
            found.executor.submit(abs, -1).add_done_callback(hold)
            assert fetching.wait(60.0)
            outcome = found.executor.submit(Path.write_text, written, "three")
            appears(written)
            written.unlink()  # before another worker can make it again
            for victim in victims:
                os.kill(victim, signal.SIGKILL)
        finally:
            gate.set()
        assert outcome.result(60.0) == 5
    assert written.exists()


def appears(path):
    until = time.monotonic() + 60.0
    while not (path.exists() and path.read_text()):
        assert time.monotonic() < until
        time.sleep(0.01)


def test_a_run_without_any_worker_left_ends(monkeypatch, tmp_path):
    """Here the programs end that would start workers again."""
    pytest.importorskip("distributed")
    before, start = [], local._start
    monkeypatch.setattr(local, "_start", lambda *given: before.append(start(*given)) or before[-1])
    monkeypatch.setattr(work, "GLANCE", 0.1)

    def kill():
        until = time.monotonic() + 60.0
        while (len(before) < 2 or not list(tmp_path.glob("samples-*"))) and time.monotonic() < until:
            time.sleep(0.01)
        for worker in before:
            os.killpg(worker.pid, signal.SIGKILL)

    threading.Thread(target=kill, daemon=True).start()
    with pytest.raises(WorkerError, match=r"all worker processes have ended; the first of them said: .*; what is"):
        kinematics(20_000, workers=2, folder=tmp_path)


def test_workers_on_this_machine_are_started_and_ended(forty):
    pytest.importorskip("distributed")
    before = children()
    found = kinematics(40, workers=2)
    assert_same(found, forty)
    assert "in 2 processes (Dask):" in found.how
    assert children() == before


def children():
    """Worker processes that this one has started."""
    import psutil

    mine = psutil.Process().children(recursive=True)
    return {one.pid for one in mine if "dask_worker" in " ".join(one.cmdline())}


def test_what_is_under_way_does_not_grow_with_the_number_of_samples(monkeypatch):
    """Nothing is ever handed out far ahead of what is stored."""
    under_way, most = [0], [0]

    class Counted(ThreadPoolExecutor):
        def submit(self, function, job, first, parameters):
            under_way[0] += 1
            most[0] = max(most[0], under_way[0])
            return super().submit(function, job, first, parameters)

    add = work.Crew.add

    def counted(crew, worker):
        under_way[0] -= 1
        add(crew, worker)

    monkeypatch.setattr(work.Crew, "add", counted)
    monkeypatch.setattr(work, "PIECE_TIME", 0.0)
    with Counted(2) as pool:
        found = pendulum().ensemble(4000, ["final(rod.angle)"], {"l": "1 mm"}, t_end=0.1, executor=pool)
    assert found.counts()["ok"] == 4000
    assert most[0] <= work.LEAST_UNDER_WAY


# ---------------------------------------------------------------- what goes wrong
def kill_oneself():
    os.kill(os.getpid(), signal.SIGKILL)


def test_a_broken_pool_of_processes_is_reported_and_the_same_call_goes_on(forty, tmp_path):
    pytest.importorskip("pyarrow")
    with ProcessPoolExecutor(2, PROCESSES) as pool:
        pool.submit(kill_oneself)
        with pytest.raises(WorkerError, match=r"a worker process ended \(killed, or out of memory\); what is finished"):
            kinematics(40, executor=pool, folder=tmp_path)
        with pytest.raises(WorkerError, match="give a folder, and what is finished is kept"):
            kinematics(40, executor=pool)
    assert_same(kinematics(40, folder=tmp_path), forty)


@pytest.mark.nojit
def test_an_unreachable_scheduler_is_said_within_seconds(monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr(engines, "CONNECTION", 1.0)
    with pytest.raises(ConnectionError, match=r"no Dask scheduler answers at tcp://127.0.0.1:9 within 1 s; start one"):
        pendulum().sweep({"l": [0.5]}, ["final(rod.angle)"], t_end=0.1, scheduler="tcp://127.0.0.1:9")


@pytest.mark.nojit
@pytest.mark.parametrize(
    ("options", "error", "said"),
    [
        ({"workers": 2, "scheduler": "tcp://127.0.0.1:9"}, ValueError, "scheduler and workers exclude each other"),
        ({"workers": 2, "threads": 2}, ValueError, "threads is for runs in this process"),
        ({"workers": 0}, ValueError, "workers must be from 1"),
        ({"workers": "2"}, TypeError, "workers must be an integer"),
        ({"scheduler": "127.0.0.1:9"}, ValueError, "expected an address such as tcp://"),
        ({"executor": 4}, TypeError, "expected a concurrent.futures.Executor, got 4"),
    ],
)
def test_engines_that_make_no_sense_are_refused(options, error, said):
    with pytest.raises(error, match=said):
        pendulum().sweep({"l": [0.5]}, ["final(rod.angle)"], t_end=0.1, **options)


@pytest.mark.nojit
def test_without_distributed_the_message_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    for options in ({"workers": 1}, {"scheduler": "tcp://127.0.0.1:9"}):
        with pytest.raises(MissingPackage, match="needs distributed; install it with: pip install distributed"):
            pendulum().sweep({"l": [0.5]}, ["final(rod.angle)"], t_end=0.1, **options)


@pytest.mark.nojit
def test_a_worker_of_another_version_is_refused(monkeypatch):
    m = pendulum()
    job = engines.job_of(m.sweep({"l": [0.5]}, ["final(rod.angle)"], t_end=0.1).task)
    with pytest.raises(WorkerError, match=f"has rattle {rt.__version__}, not 0.0.9; install the same version there"):
        engines.work(replace(job, version="0.0.9"), 0, np.array([[0.5]]))


def test_laws_in_python_run_on_threads_and_are_refused_by_processes_without_them(processes, laws):
    space = {}
    exec("def law(t, state, p):\n    return -p.c*state[3], -p.c*state[4], 0.0\n", space)
    rt.load_law("air of a test", compiled=False, c="N*s/m")(space["law"])
    m = rt.loads(pendulum().to_toml() + '\n[loads.air]\ntype = "air of a test"\nbody = "rod"\nc = 0.5\n')
    values, of = {"l": np.linspace(0.4, 0.6, 4)}, ["final(rod.angle)"]
    here = m.sweep(values, of, t_end=0.05)
    with ThreadPoolExecutor(2) as pool:
        np.testing.assert_array_equal(m.sweep(values, of, t_end=0.05, executor=pool)[of[0]], here[of[0]])
    with pytest.raises(WorkerError, match="does not know the load 'air of a test' of the model, which is written in"):
        m.sweep(values, of, t_end=0.05, executor=processes)


INTERRUPTED = """
import sys
import numpy as np
import rattle as rt
if __name__ == "__main__":
    print("started", flush=True)
    l2, of = np.linspace(0.58, 0.62, 4000), ["quantile(rocker.angle, 0.9)"]
    found = rt.example("fourbar").ideal().sweep(
        {"l2": l2}, of, analysis="kinematics", t_end=0.1, folder=sys.argv[2], **eval(sys.argv[1])
    )
    print(found.interrupted, found.counts()["ok"] >= 8, flush=True)
"""


@pytest.mark.parametrize("options", ["dict(threads=2)", pytest.param("dict(workers=1)", marks=pytest.mark.long)])
def test_ctrl_c_ends_everything_and_leaves_a_folder_that_goes_on(tmp_path, options):
    pytest.importorskip("pyarrow")
    pytest.importorskip("distributed")
    script, folder = tmp_path / "script.py", tmp_path / "run"
    script.write_text(INTERRUPTED)
    child = subprocess.Popen(
        [sys.executable, str(script), options, str(folder)], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # tests that run behind a shell's & ignore it
    )  # fmt: skip
    try:
        assert child.stdout.readline() == b"started\n"
        until = time.monotonic() + 40.0
        while len(list(folder.glob("samples-*"))) < 2:  # the first one is counted then
            assert time.monotonic() < until
            assert child.poll() is None
            time.sleep(0.02)
        os.killpg(child.pid, signal.SIGINT)  # as a terminal does
        out, err = child.communicate(timeout=20.0)
    finally:
        child.kill()
        child.wait()
    assert out == b"True True\n", err
    assert b"Traceback" not in err
    assert child.returncode == 0


def test_ctrl_c_is_not_lost_in_a_finaliser_and_the_second_one_is_raised():
    class Dropped:
        def __del__(self):
            signal.raise_signal(signal.SIGINT)

    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with noticed() as pressed:
            assert not pressed()
            Dropped()
            assert pressed()
            with pytest.raises(KeyboardInterrupt):
                signal.raise_signal(signal.SIGINT)
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        with noticed() as pressed:  # who ignores it still does
            signal.raise_signal(signal.SIGINT)
            assert not pressed()
    finally:
        signal.signal(signal.SIGINT, before)


def test_a_scheduler_without_workers_is_said(caplog):
    distributed = pytest.importorskip("distributed")
    logging.getLogger("rattle").setLevel(logging.WARNING)
    with (
        distributed.LocalCluster(n_workers=0, host="127.0.0.1", dashboard_address="127.0.0.1:0") as cluster,
        engines.engine(None, cluster.scheduler_address, None) as found,
    ):
        assert found.name == f"Dask, {cluster.scheduler_address}"
    assert "has no workers: waiting for one" in caplog.text
