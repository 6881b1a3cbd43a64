"""Samples in a folder: nothing is lost however a run ends, nothing counts twice, no run is taken for another."""

import errno
import json
import os
import re
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import rattle as rt
from rattle.errors import MissingPackage
from rattle.questions.ensemble import folder as folders
from rattle.questions.ensemble import work
from rattle.questions.ensemble.bands import band
from rattle.questions.ensemble.fields import fields_of
from rattle.questions.ensemble.folder import MANIFEST, Folder
from rattle.questions.ensemble.pieces import FAILED, NOT_FINITE, OK, Piece
from rattle.questions.ensemble.plans import Drawn
from rattle.questions.ensemble.sampling import points
from rattle.questions.ensemble.store import Memory
from rattle.studies.runs.task import task_of
from springs import SPRING

pytest.importorskip("pyarrow")
OF = ["final(block.x)", "max(block.vx)"]


def asked(n=100, *, seed=3, design="sobol", of=OF, text=SPRING, t_end=0.3, vary=None, **settings):
    """A task and the plan of n samples."""
    m = rt.loads(text)
    fields = fields_of(m, vary)
    task = task_of(m, fields.names, of, t_end=t_end, **settings)
    return task, Drawn(fields, points(design, seed, fields.draws, n))


def piece(plan, first, last):
    """Samples with made-up numbers that say which sample they are: every fifth failed, every seventh is not finite."""
    numbers = np.arange(first, last)
    status = np.where(numbers % 5 == 4, FAILED, np.where(numbers % 7 == 6, NOT_FINITE, OK)).astype(np.int8)
    values = np.where(status == OK, np.sin(numbers + np.array([[0.1], [0.2]])), np.nan)
    messages = {int(n): f'sample {n} of "α" failed\nat once' for n in numbers[status != OK]}
    generic = numbers % 3 == 0
    return Piece(first, plan.values(first, last), values, status, messages, generic, {"is steep": int(generic.sum())})


def filled(store, plan, *spans):
    for first, last in spans:
        store.add(piece(plan, first, last))
    return store


def assert_same(found, wanted, names=("k", "x0", *OF)):
    for name in names:
        np.testing.assert_array_equal(found.column(name).view(np.int64), wanted.column(name).view(np.int64))
    np.testing.assert_array_equal(found.status(), wanted.status())
    np.testing.assert_array_equal(found.generic(), wanted.generic())
    assert found.messages() == wanted.messages()
    assert found.missing() == wanted.missing()


# ---------------------------------------------------------------- what is kept
@pytest.mark.nojit
def test_a_folder_gives_back_what_memory_does(tmp_path):
    task, plan = asked()
    spans = [(0, 10), (10, 40), (70, 71)]
    memory = filled(Memory(plan.names, task.texts, plan.count), plan, *spans)
    assert_same(filled(Folder(tmp_path / "run", task, plan), plan, *spans), memory)
    again = Folder(tmp_path / "run", task, plan)
    assert_same(again, memory)
    assert again.missing() == [(40, 70), (71, 100)]
    assert again.reasons() == memory.reasons() == {"is steep": 14}


@pytest.mark.nojit
def test_the_files_can_be_read_without_rattle(tmp_path):
    from pyarrow import parquet

    task, plan = asked()
    filled(Folder(tmp_path, task, plan), plan, (0, 10))
    table = parquet.read_table(tmp_path / "samples-000000000000-000000000009.parquet")
    assert table.column_names == ["sample", "k", "x0", *OF, "status", "generic", "message"]
    assert table.schema.field("k").metadata[b"unit"] == b"N/m"
    assert table["status"].to_pylist()[4:7] == ["failed", "ok", "not finite"]
    manifest = json.loads((tmp_path / MANIFEST).read_text())
    assert manifest["n"] == 100
    assert manifest["seed"] == 3
    assert manifest["outputs"] == OF
    assert rt.loads(manifest["model"]).parameters == {"k": 15.0, "x0": 0.5}


@pytest.mark.nojit
def test_samples_of_overlapping_files_count_once(tmp_path):
    """Two processes that did not know of each other, with pieces of other sizes."""
    task, plan = asked()
    one, other = Folder(tmp_path, task, plan), Folder(tmp_path, task, plan)
    filled(one, plan, (0, 16), (16, 48))
    filled(other, plan, (0, 32), (32, 40))
    assert_same(
        Folder(tmp_path, task, plan), filled(Memory(plan.names, task.texts, plan.count), plan, (0, 32), (32, 48))
    )


@pytest.mark.nojit
def test_more_samples_of_a_sequence_keep_those_that_are_there(tmp_path):
    task, plan = asked(32)
    filled(Folder(tmp_path, task, plan), plan, (0, 20))
    more = asked(64)[1]
    store = filled(Folder(tmp_path, task, more), more, (20, 64))
    assert_same(store, filled(Memory(more.names, task.texts, 64), more, (0, 64)))
    assert_same(Folder(tmp_path, task, plan), filled(Memory(plan.names, task.texts, 32), plan, (0, 32)))
    assert json.loads((tmp_path / MANIFEST).read_text())["n"] == 64


@pytest.mark.nojit
def test_a_parameter_may_have_the_name_of_a_column(tmp_path):
    text = SPRING.replace("x0", "status")
    task, plan = asked(text=text)
    store = filled(Folder(tmp_path, task, plan), plan, (0, 100))
    np.testing.assert_array_equal(store.column("status"), plan.values(0, 100)[1])
    assert store.status()[4] == FAILED


# ---------------------------------------------------------------- damage and bad folders
@pytest.mark.nojit
@pytest.mark.parametrize("harm", ["cut", "flipped", "empty", "renamed"])
def test_a_damaged_file_is_named_and_its_samples_run_again(tmp_path, harm, caplog):
    task, plan = asked()
    filled(Folder(tmp_path, task, plan), plan, (0, 50), (50, 100))
    file = tmp_path / "samples-000000000050-000000000099.parquet"
    content = bytearray(file.read_bytes())
    if harm == "flipped":  # a value in the middle of the numbers of a column
        content[len(content) // 3] ^= 0xFF
    if harm == "renamed":
        file.rename(tmp_path / "samples-000000000051-000000000100.parquet")
    else:
        file.write_bytes(content[: {"cut": len(content) // 2, "empty": 0}.get(harm, len(content))])
    store = Folder(tmp_path, task, plan)
    assert store.missing() == [(50, 100)]
    assert "is damaged" in caplog.text
    assert "samples-00000000005" in caplog.text
    filled(store, plan, (50, 100))
    assert_same(Folder(tmp_path, task, plan), filled(Memory(plan.names, task.texts, 100), plan, (0, 100)))


@pytest.mark.nojit
def test_leftovers_of_killed_runs_are_ignored_and_removed(tmp_path):
    task, plan = asked()
    filled(Folder(tmp_path, task, plan), plan, (0, 50))
    old, new = (tmp_path / f".samples-000000000050-000000000099-{n:08x}.parquet" for n in range(2))
    for one in (old, new):
        one.write_bytes(b"PAR1 half a fi")
    os.utime(old, (0.0, 0.0))
    assert Folder(tmp_path, task, plan).missing() == [(50, 100)]
    assert not old.exists()
    assert new.exists()  # it may be of a process that is writing it at this moment


@pytest.mark.nojit
@pytest.mark.parametrize(
    ("other", "said"),
    [
        ({"text": SPRING.replace("mass = 1", "mass = 2")}, "its model has bodies.block.mass: 1, now 2"),
        ({"text": SPRING + '[loads.push]\ntype = "force"\nat = "block.P"\nforce = [1, 0]\n'},
         "its model has loads.push: none, now"),
        ({"of": OF[:1]}, "its outputs: final(block.x), max(block.vx), now final(block.x)"),
        ({"seed": 4}, "its seed: 3, now 4"),
        ({"design": "halton"}, "its design: sobol, now halton"),
        ({"t_end": 0.4}, "0.3, now 0.4"),
        ({"rtol": 1e-9}, "its setting rtol: 1e-08, now 1e-09"),
        ({"vary": {"k": 2.0, "x0": 0.01}}, "its field of k.tol: 1.0, now 2.0"),
        ({"vary": ["x0"]}, "its field of k: {"),
        ({"vary": ["x0", "k"]}, "its parameters vary together or in an order in another way"),
    ],
)  # fmt: skip
def test_a_folder_of_another_run_is_refused_with_the_difference(tmp_path, other, said):
    Folder(tmp_path, *asked())
    with pytest.raises(ValueError, match=r"holds another run, .*give another folder") as error:
        Folder(tmp_path, *asked(**other))
    assert said in str(error.value)
    Folder(tmp_path, *asked())


@pytest.mark.nojit
def test_comments_of_a_model_make_no_other_run(tmp_path):
    Folder(tmp_path, *asked())
    Folder(tmp_path, *asked(text="# my spring\n" + SPRING))


@pytest.mark.nojit
def test_other_folders_are_refused(tmp_path, monkeypatch):
    task, plan = asked(design="lhs")
    Folder(tmp_path / "a", task, plan)
    with pytest.raises(ValueError, match="n = 100, now 50, and the first samples of its design depend on n"):
        Folder(tmp_path / "a", *asked(50, design="lhs"))
    with pytest.raises(FileExistsError, match="holds a run already"):
        Folder(tmp_path / "a", task, plan, resume=False)
    Folder(tmp_path / "b", task, plan, resume=False)
    (tmp_path / "c").mkdir()
    (tmp_path / "c" / "thesis.tex").write_text("...")
    with pytest.raises(FileExistsError, match=r"holds other files \(thesis.tex\) and no manifest.json"):
        Folder(tmp_path / "c", task, plan)
    with pytest.raises(NotADirectoryError, match="is a file"):
        Folder(tmp_path / "c" / "thesis.tex", task, plan)
    for text in ("", "{", "[]", '{"format": 1}'):
        (tmp_path / "a" / MANIFEST).write_text(text)
        with pytest.raises(ValueError, match=r"manifest.json is damaged, or is not of rattle"):
            Folder(tmp_path / "a", task, plan)
    monkeypatch.setattr("rattle.questions.ensemble.identity.__version__", "0.0.9")
    with pytest.raises(ValueError, match=re.escape(f"its version of rattle: {rt.__version__}, now 0.0.9")):
        Folder(tmp_path / "b", task, plan)


@pytest.mark.nojit
def test_samples_with_other_parameter_values_are_refused(tmp_path):
    """As another version of a package might draw them from the same seed."""
    task, plan = asked()
    filled(Folder(tmp_path, task, plan), asked(seed=4)[1], (0, 50))
    with pytest.raises(ValueError, match="its values of k are not those of this design and seed; it was made with"):
        Folder(tmp_path, task, plan)


@pytest.mark.nojit
def test_a_law_in_python_is_known_by_its_code(tmp_path, laws):
    text = SPRING + '[loads.air]\ntype = "air of a test"\nbody = "block"\n'
    sources = ["return 0.0, 0.0, 0.0", "return -state[3], 0.0, 0.0"]
    for n, source in enumerate(sources):
        space = {}
        exec(f"def law(t, state, p):\n    {source}\n", space)
        rt.load_law("air of a test")(space["law"])
        if n == 0:
            Folder(tmp_path, *asked(text=text))
    with pytest.raises(ValueError, match="its Python code of load 'air of a test'"):
        Folder(tmp_path, *asked(text=text))


@pytest.mark.nojit
def test_without_pyarrow_the_message_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(MissingPackage, match="a folder of samples needs pyarrow; install it with: pip install pyarrow"):
        Folder(tmp_path, *asked())


# ---------------------------------------------------------------- runs that end early
def swept(n=40, **options):
    return rt.loads(SPRING).sweep({"x0": np.linspace(0.49, 0.51, n)}, OF, t_end=0.3, **options)


def assert_same_sweep(found, wanted):
    for name in ("x0", *OF):
        np.testing.assert_array_equal(found[name], wanted[name])
    assert list(found.status) == list(wanted.status)
    assert found.table.equals(wanted.table)


@pytest.fixture
def small_pieces(monkeypatch):
    monkeypatch.setattr(work, "FIRST_PIECE", {True: 8, False: 8})
    monkeypatch.setattr(work, "PIECE_TIME", 0.0)
    monkeypatch.setattr(work, "LEAST_SHARE", 4)


@pytest.mark.nojit
@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EIO])
def test_a_full_disk_is_reported_and_the_same_call_goes_on(tmp_path, monkeypatch, small_pieces, number):
    write, left = Path.write_bytes, [3]

    def until_full(path, content):
        if path.parent != tmp_path:
            return write(path, content)
        if left[0] == 0:
            write(path, content[: len(content) // 2])
            raise OSError(number, os.strerror(number))
        left[0] -= 1
        return write(path, content)

    monkeypatch.setattr(Path, "write_bytes", until_full)
    with pytest.raises(OSError, match=rf"{os.strerror(number)}; 24 samples are kept, and the same call goes") as error:
        swept(folder=tmp_path)
    assert error.value.errno == number
    assert not [one for one in tmp_path.iterdir() if one.name.startswith(".")]
    monkeypatch.undo()
    assert_same_sweep(swept(folder=tmp_path), swept())


@pytest.mark.nojit
def test_a_limit_of_the_file_size_is_reported(tmp_path):
    """The system itself refuses to write."""
    task, plan = asked()
    store = filled(Folder(tmp_path, task, plan), plan, (0, 10))
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, limits[1]))
    try:
        with pytest.raises(OSError, match=r"cannot write .*; 10 samples are kept") as error:
            filled(store, plan, (10, 100))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert error.value.errno == errno.EFBIG
    assert Folder(tmp_path, task, plan).missing() == [(10, 100)]


@pytest.mark.nojit
def test_ctrl_c_leaves_a_folder_that_goes_on(tmp_path, monkeypatch, small_pieces):
    whole, left = swept(), [2]
    add = Folder.add

    def until_stopped(store, piece):
        if left[0] == 0:
            raise KeyboardInterrupt
        left[0] -= 1
        add(store, piece)

    monkeypatch.setattr(Folder, "add", until_stopped)
    found = swept(folder=tmp_path)
    assert found.interrupted
    assert 0 < found.counts()["ok"] < 40
    assert "of 40 samples; the same call goes on" in str(found)
    monkeypatch.setattr(Folder, "add", add)
    again = swept(folder=tmp_path)
    assert not again.interrupted
    assert_same_sweep(again, whole)


@pytest.mark.nojit
def test_a_folder_that_is_complete_runs_nothing(tmp_path, monkeypatch):
    whole = swept(folder=tmp_path)
    monkeypatch.setattr(work, "Runner", None)
    again = swept(folder=tmp_path)
    assert_same_sweep(again, whole)
    assert again.how == f"40 run side by side, kept in {tmp_path}"


@pytest.mark.nojit
def test_samples_that_fail_are_rows_with_their_message(tmp_path):
    values = {"k": [0.5, 15.0], "x0": [0.5]}
    for _ in range(2):
        found = rt.loads(SPRING).sweep(values, OF, t_end=0.3, folder=tmp_path)
        assert list(found.table["status"]) == ["failed", "ok"]
        assert "not between min = 1" in found.table["message"][0]
        assert "1 run side by side, 1 one by one" in found.how
        assert "1 x has no start" in found.how


CHILD = """
import sys
import numpy as np
import rattle as rt
from rattle.questions.ensemble import work
work.FIRST_PIECE, work.PIECE_TIME, work.LEAST_SHARE = {True: 4, False: 4}, 0.0, 4
text, folder = sys.argv[1:]
print("started", flush=True)
rt.loads(text).sweep({"x0": np.linspace(0.49, 0.51, 4000)}, %r, t_end=0.3, threads=1, folder=folder)
""" % (OF,)  # noqa: UP031  # braces


def test_a_run_that_is_killed_anywhere_goes_on_to_the_same_numbers(tmp_path):
    """SIGKILL: nothing can be put in order before the end."""
    folder = tmp_path / "run"
    rng = np.random.default_rng(5)
    kept = 0
    for _ in range(2):
        child = subprocess.Popen(
            [sys.executable, "-c", CHILD, SPRING, str(folder)], stdout=subprocess.PIPE, env=dict(os.environ)
        )
        try:
            assert child.stdout.readline() == b"started\n"
            before = len(list(folder.glob("samples-*"))) if folder.is_dir() else 0
            until = time.monotonic() + 30.0
            while (len(list(folder.glob("samples-*"))) if folder.is_dir() else 0) <= before:
                assert time.monotonic() < until
                assert child.poll() is None
                time.sleep(0.001)
            time.sleep(rng.uniform(0.0, 0.1))
        finally:
            child.send_signal(signal.SIGKILL)
            child.wait()
            child.stdout.close()
        assert child.returncode == -signal.SIGKILL, "it came to its end before it was killed: take more samples"
        assert len(list(folder.glob("samples-*"))) > kept
        kept = len(list(folder.glob("samples-*")))
    folders.STALE, stale = 0.0, folders.STALE
    try:
        found = swept(4000, folder=folder, threads=2)
    finally:
        folders.STALE = stale
    assert_same_sweep(found, swept(4000))
    assert not [one for one in folder.iterdir() if one.name.startswith(".")]
    from pyarrow import parquet

    assert sum(parquet.read_metadata(one).num_rows for one in folder.glob("samples-*")) == 4000


# ---------------------------------------------------------------- histories
def kept(n=20, **options):
    m = rt.loads(SPRING)
    return m.ensemble(
        n, OF[:1], seed=2, t_end=0.3, histories=["block.x", "energy.potential", "guide.force"], threads=1, **options
    )


def test_histories_are_the_curves_of_the_samples(tmp_path, small_pieces):
    """x = x0 cos(sqrt(k/m) t), the spring's energy k x^2/2, and the guide bears nothing."""
    pytest.importorskip("h5netcdf")
    memory, folder = kept(), kept(folder=tmp_path)
    assert "20 one by one on 1 thread: whole curves are kept" in memory.how
    for found in (memory, folder, kept(folder=tmp_path)):
        t, x = found.histories("block.x")
        np.testing.assert_allclose(t, np.linspace(0.0, 0.3, 201), rtol=0.0, atol=1e-15)
        want = found["x0"][:, None] * np.cos(np.sqrt(found["k"])[:, None] * t)
        np.testing.assert_allclose(x, want, rtol=0.0, atol=1e-7)
        energy = 0.5 * found["k"][:, None] * want**2
        np.testing.assert_allclose(found.histories("energy.potential")[1], energy, rtol=0.0, atol=1e-6)
        np.testing.assert_allclose(found.histories("guide.force")[1], 0.0, atol=1e-12)
        np.testing.assert_array_equal(found.history(13, "block.x")[1], x[13])
        np.testing.assert_array_equal(x, memory.histories("block.x")[1])
        assert (found.unit("block.x"), found.unit("guide.force")) == ("m", "N")
    xarray = pytest.importorskip("xarray")
    first = sorted(tmp_path.glob("histories-*.nc"))[1]
    with xarray.open_dataset(first, engine="h5netcdf") as data:
        np.testing.assert_array_equal(data["block.x"].sel(sample=9), x[9])
        assert data["energy.potential"].attrs["units"] == "J"
    with pytest.raises(KeyError, match=r"no history 'block.y'"):
        memory.histories("block.y")
    with pytest.raises(
        ValueError, match=r"holds another run, its histories: block.x, energy.potential, guide.force, now"
    ):
        rt.loads(SPRING).ensemble(20, OF[:1], seed=2, t_end=0.3, folder=tmp_path)


def test_a_band_is_drawn_from_the_histories_that_are_kept(tmp_path, monkeypatch):
    pytest.importorskip("h5netcdf")
    found = kept(folder=tmp_path)
    again = band(rt.loads(SPRING).ensemble(20, OF[:1], seed=2, t_end=0.3), "block.x", 20)
    monkeypatch.setattr(type(found), "sample", None)
    drawn = band(found, "block.x", 20)
    np.testing.assert_array_equal(drawn.members, found.histories("block.x")[1])
    np.testing.assert_allclose(drawn.members, again.members, rtol=0.0, atol=1e-12)
    assert drawn.unit == again.unit == "m"


@pytest.mark.parametrize("harm", ["cut", "gone"])
def test_samples_whose_histories_are_lost_run_again(tmp_path, small_pieces, harm, caplog):
    pytest.importorskip("h5netcdf")
    whole = kept(folder=tmp_path)
    file = sorted(tmp_path.glob("histories-*.nc"))[-1]
    if harm == "cut":
        file.write_bytes(file.read_bytes()[:-100])
    else:
        file.unlink()
    again = kept(folder=tmp_path)
    assert file.name in caplog.text
    np.testing.assert_array_equal(again.histories("block.x")[1], whole.histories("block.x")[1])


@pytest.mark.nojit
@pytest.mark.parametrize(
    ("histories", "error", "said"),
    [
        ("block.x", ValueError, r'write histories=\["block.x"\]'),
        (["block.X"], KeyError, "no curve 'block.X'; did you mean"),
    ],
)
def test_histories_that_make_no_sense_are_refused(histories, error, said):
    with pytest.raises(error, match=said):
        rt.loads(SPRING).ensemble(4, OF[:1], t_end=0.3, histories=histories)


@pytest.mark.nojit
def test_histories_beyond_the_memory_need_a_folder():
    with pytest.raises(ValueError, match=r"1000000 samples of 1 curves take 1.6 GB; in memory .*: give a folder"):
        rt.loads(SPRING).ensemble(10**6, OF[:1], t_end=0.3, histories=["block.x"])
