"""Kept machine code is only taken from a folder of the user's own, is never needed, and heals itself."""

import os
import shutil
import stat

import numpy as np
import pytest

from rattle.jit import cache, functions
from rattle.jit import folder as folder_module
from rattle.jit.cache import Folder, code_folder
from rattle.jit.translation import unit

posix = pytest.mark.skipif(not hasattr(os, "getuid"), reason="folders of Windows profiles are private")


def mode(path):
    return stat.S_IMODE(path.stat().st_mode)


# ---------------------------------------------------------------- which folder
@pytest.mark.nojit
@posix
def test_a_new_folder_is_private_whatever_the_umask(tmp_path, monkeypatch):
    monkeypatch.setenv("RATTLE_CACHE", str(tmp_path / "kept"))
    before = os.umask(0)
    try:
        found = code_folder("abc")
    finally:
        os.umask(before)
    assert found == Folder(tmp_path / "kept" / "abc", True)
    assert mode(tmp_path / "kept") == mode(tmp_path / "kept" / "abc") == 0o700


def others_may_write(root):
    (root / "abc").mkdir(parents=True)
    (root / "abc").chmod(0o777)


def group_may_write_above(root):
    (root / "abc").mkdir(parents=True)
    root.chmod(0o770)


def link(root):
    other = root.parent / "other"
    (other / "abc").mkdir(parents=True, mode=0o700)
    root.symlink_to(other)


def link_inside(root):
    other = root.parent / "other"
    other.mkdir(mode=0o700)
    root.mkdir(mode=0o700)
    (root / "abc").symlink_to(other)


def file_instead(root):
    root.write_text("")


def everybody_may_write_two_above(root):
    root.mkdir(mode=0o700)
    root.parent.chmod(0o777)


@pytest.mark.nojit
@posix
@pytest.mark.parametrize(
    "prepare",
    [others_may_write, group_may_write_above, link, link_inside, file_instead, everybody_may_write_two_above],
)
def test_code_is_not_taken_from_a_folder_that_others_could_have_filled(tmp_path, monkeypatch, caplog, prepare):
    root = tmp_path / "place" / "kept"
    root.parent.mkdir()
    prepare(root)
    monkeypatch.setenv("RATTLE_CACHE", str(root))
    found = code_folder("abc")
    assert not found.lasting
    assert root not in found.path.parents
    assert mode(found.path) == 0o700
    assert "RATTLE_CACHE" in caplog.text
    assert list(found.path.iterdir()) == []


@pytest.mark.nojit
@posix
def test_a_folder_of_another_user_is_not_used(tmp_path, monkeypatch):
    root = tmp_path / "kept"
    (root / "abc").mkdir(parents=True, mode=0o700)
    monkeypatch.setenv("RATTLE_CACHE", str(root))
    owner = root.stat().st_uid
    monkeypatch.setattr(cache.os, "getuid", lambda: owner + 1)
    found = code_folder("abc")
    assert not found.lasting
    assert "belongs to another user" in found.why_not


@pytest.mark.nojit
@posix
def test_a_place_like_tmp_is_shared_but_its_entries_are_not(tmp_path, monkeypatch):
    root = tmp_path / "kept"
    root.mkdir()
    root.chmod(0o1777)
    monkeypatch.setenv("RATTLE_CACHE", str(root))
    assert code_folder("abc") == Folder(root / "abc", True)


@pytest.mark.nojit
def test_an_empty_name_means_home_and_a_tilde_is_the_home(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.setenv("USERPROFILE", str(tmp_path / "home"))
    monkeypatch.setenv("RATTLE_CACHE", "")
    assert code_folder("abc").path == tmp_path / "home" / ".cache" / "rattle" / "abc"
    monkeypatch.setenv("RATTLE_CACHE", "~/mine")
    assert code_folder("abc").path == tmp_path / "home" / "mine" / "abc"
    assert [one.name for one in tmp_path.iterdir()] == ["home"]


@pytest.mark.nojit
def test_without_a_home_or_any_folder_there_is_just_no_cache(monkeypatch):
    def nowhere(*args, **options):
        raise RuntimeError("Could not determine home directory.")

    def full(*args, **options):
        raise OSError(28, "No space left on device")

    monkeypatch.delenv("RATTLE_CACHE", raising=False)
    monkeypatch.setattr(cache.Path, "home", nowhere)
    assert not code_folder("abc").lasting
    monkeypatch.setattr(cache.tempfile, "mkdtemp", full)
    assert code_folder("abc").path is None


# ---------------------------------------------------------------- one file
def kept_in(folder, monkeypatch):
    """A native function, new to this process, whose machine code is kept in a folder; how often it was compiled."""

    def scaled(t, y):
        return 2.0 * t + y

    found, compiled = functions.KernelFunction(scaled, letters="fff"), []
    found.__module__ = "rattle.somewhere"
    monkeypatch.setattr(folder_module, "_code_folder", Folder(folder, True))
    make = unit.native
    monkeypatch.setattr(unit, "native", lambda *given: compiled.append(given) or make(*given))
    assert found(1.0, 3.0) == 5.0
    return len(compiled)


@pytest.fixture
def _machine_code():
    if not functions.start():
        pytest.skip("runs without machine code")


def flip(content):
    middle = len(content) // 2
    return content[:middle] + bytes([content[middle] ^ 1]) + content[middle + 1 :]


DAMAGE = {
    "empty": lambda content: b"",
    "cut": lambda content: content[: len(content) // 2],
    "zeros": lambda content: bytes(len(content)),
    "garbage": lambda content: b"\x80\x05garbage" * 50,
    "one bit": flip,
    "short": lambda content: content[:7],
}


@pytest.mark.usefixtures("_machine_code")
def test_kept_code_is_used_and_damaged_code_is_made_anew(tmp_path, monkeypatch):
    def compiles():
        with monkeypatch.context() as patch:
            return kept_in(tmp_path, patch)

    assert compiles() == 1
    (file,) = tmp_path.iterdir()
    assert compiles() == 0
    whole = file.read_bytes()
    for what, damage in DAMAGE.items():
        file.write_bytes(damage(whole))
        assert compiles() == 1, what
        assert compiles() == 0, what
    file.unlink()
    file.mkdir()
    (file / "x").write_text("")
    assert compiles() == 1
    assert compiles() == 0


@pytest.mark.usefixtures("_machine_code")
@pytest.mark.parametrize("what", ["gone", "none", "full"])
def test_a_cache_that_cannot_be_written_loses_nothing(tmp_path, monkeypatch, what):
    def full(*args):
        raise OSError(28, "No space left on device")

    folder = None if what == "none" else tmp_path / "kept"
    if what == "full":
        folder.mkdir()
        monkeypatch.setattr(cache.Path, "write_bytes", full)
    assert kept_in(folder, monkeypatch) == 1
    assert not list(tmp_path.rglob("*.code")) + list(tmp_path.rglob(".*"))


def test_a_run_needs_no_cache_folder(tmp_path, monkeypatch):
    import rattle as rt

    rt.example("double_pendulum").simulate(1e-3)
    (tmp_path / "kept").mkdir()
    monkeypatch.setattr(folder_module, "_code_folder", Folder(tmp_path / "kept", True))
    shutil.rmtree(tmp_path / "kept")
    r = rt.example("double_pendulum").simulate(2e-3)
    assert r.success
    assert r.t[-1] == 2e-3
    monkeypatch.setattr(folder_module, "_code_folder", Folder(None, False))
    assert np.array_equal(rt.example("double_pendulum").simulate(2e-3)["energy.kinetic"], r["energy.kinetic"])
