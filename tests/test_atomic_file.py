"""Writing a file harms nothing else: devices, pipes, links, permissions, and what was there before."""

import os
import signal
import stat
import subprocess
import sys
import threading

import pytest

from rattle.atomic_file import atomic, is_special, refuse_input, writable

pytestmark = [pytest.mark.nojit, pytest.mark.skipif(os.name != "posix", reason="devices and links of POSIX systems")]


def write(path, text="new"):
    with atomic(path) as file:
        file.write_text(text)


def test_a_device_is_written_to_and_stays_a_device(tmp_path):
    null = tmp_path / "null"
    try:
        os.mknod(null, stat.S_IFCHR | 0o666, os.makedev(1, 3))
        null.write_text("")
    except OSError as error:
        pytest.skip(f"no device can be made here: {error}")
    write(null)
    assert stat.S_ISCHR(null.stat().st_mode)
    assert list(tmp_path.iterdir()) == [null]


def test_a_pipe_carries_what_is_written_and_stays_a_pipe(tmp_path):
    pipe = tmp_path / "pipe.csv"
    os.mkfifo(pipe)
    heard = []
    reader = threading.Thread(target=lambda: heard.append(pipe.read_text()))
    reader.start()
    write(pipe, "a,b\n1,2\n")
    reader.join(10)
    assert heard == ["a,b\n1,2\n"]
    assert stat.S_ISFIFO(pipe.stat().st_mode)
    assert list(tmp_path.iterdir()) == [pipe]


def test_a_socket_is_refused(tmp_path):
    import socket

    with socket.socket(socket.AF_UNIX) as one:
        one.bind(str(tmp_path / "s"))
        with pytest.raises(OSError, match="it is a socket"):
            writable(tmp_path / "s")


@pytest.mark.parametrize("redirect", ["pipe", "file"])
def test_own_output_is_written_to(tmp_path, redirect):
    code = "from rattle.atomic_file import atomic\nprint('before')\n"
    code += "with atomic('/dev/stdout') as f:\n    f.write_text('x\\n')\nprint('after')"
    if redirect == "pipe":
        said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    else:
        with (tmp_path / "out").open("w") as out:
            subprocess.run([sys.executable, "-c", code], stdout=out, check=True)
        said = (tmp_path / "out").read_text()
    assert said == "before\nx\nafter\n"


def test_permissions_and_links_are_kept(tmp_path):
    file, twin, link = tmp_path / "a.txt", tmp_path / "twin.txt", tmp_path / "link.txt"
    file.write_text("a long old text")
    file.chmod(0o600)
    link.symlink_to(file)
    write(link)
    assert link.is_symlink()
    assert file.read_text() == "new"
    assert stat.S_IMODE(file.stat().st_mode) == 0o600
    os.link(file, twin)
    write(file, "newer")
    assert twin.read_text() == "newer"
    assert file.stat().st_ino == twin.stat().st_ino
    write(file, "x")
    assert twin.read_text() == "x"
    assert sorted(tmp_path.iterdir()) == [file, link, twin]


def test_links_in_a_circle_are_named(tmp_path):
    (tmp_path / "a").symlink_to(tmp_path / "b")
    (tmp_path / "b").symlink_to(tmp_path / "a")
    with pytest.raises(OSError, match="its symbolic links form a circle"):
        writable(tmp_path / "a")


def test_a_link_to_nothing_yet_makes_the_file(tmp_path):
    (tmp_path / "link").symlink_to(tmp_path / "file")
    write(tmp_path / "link")
    assert (tmp_path / "file").read_text() == "new"
    assert (tmp_path / "link").is_symlink()


def test_the_file_that_is_read_is_not_written(tmp_path):
    file, link = tmp_path / "a", tmp_path / "b"
    file.write_text("")
    link.symlink_to(file)
    with pytest.raises(FileExistsError, match="it is the input file; give another name"):
        refuse_input(link, file)
    refuse_input(tmp_path / "c", file, tmp_path / "d")


def test_errors_keep_what_the_system_said(tmp_path):
    def full():
        with atomic(tmp_path / "a"):
            raise OSError(28, "No space left on device")

    with pytest.raises(OSError, match="No space") as caught:
        full()
    assert caught.value.errno == 28


def test_a_program_that_is_ended_leaves_no_temporary_file(tmp_path):
    code = (
        "import time; from rattle.atomic_file import atomic\n"
        f"with atomic({str(tmp_path / 'a.csv')!r}) as f:\n"
        "    f.write_text('x'); print('go', flush=True); time.sleep(30)"
    )
    run = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert run.stdout.readline() == "go\n"
    assert len(list(tmp_path.iterdir())) == 1
    run.send_signal(signal.SIGTERM)
    assert run.wait(20) == 143
    assert list(tmp_path.iterdir()) == []


def test_a_plain_file_is_nothing_special(tmp_path):
    write(tmp_path / "a")
    assert not is_special(tmp_path / "a")
    assert not is_special(tmp_path)
    assert not is_special(tmp_path / "none")
