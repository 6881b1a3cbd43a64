"""The command line keeps what it computes, refuses early what it must refuse, and ends when it is told to."""

import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.io import loadmat

import rattle as rt
from circling import circling
from rattle import loading, mechanism
from rattle.analyses.dynamics import run as running
from rattle.cli.main import main
from rattle.pages import engine
from rattle.results import archive
from rattle.results.result import load_result
from workbooks import read_workbook

pytestmark = pytest.mark.nojit
PLAIN = {**os.environ, "RATTLE_JIT": "python"}


def call(*words):
    return CliRunner().invoke(main, [str(word) for word in words])


def shell(line, **options):
    line = line.replace("rattle", f"{sys.executable} -m rattle")
    return subprocess.run(["bash", "-c", line], capture_output=True, text=True, env=PLAIN, timeout=120, **options)


# ---------------------------------------------------------------- JSON
def strict(text):
    def refuse(word):
        raise AssertionError(f"{word} is not JSON")

    return json.loads(text, parse_constant=refuse)


@pytest.mark.parametrize(
    "words",
    [
        ("kinematics", "path_generator", "--ideal", "--points", 3),
        ("inverse-dynamics", "slider_crank", "--effort-at", "guide", "--points", 3),  # no effort there at t = 0
        ("equilibrium", "toggle_clamp", "--path", "--points", 2),
        ("equilibrium", "balanced_arm"),
        ("check", "fourbar"),
        ("run", "double_pendulum", "--t-end", "1 ms", "--no-horizon"),
    ],
)
def test_json_is_json(words):
    found = call(*words, "--json")
    assert found.exit_code == 0, found.output
    assert strict(found.stdout)


def test_what_is_not_finite_is_null():
    found = strict(call("inverse-dynamics", "slider_crank", "--effort-at", "guide", "--points", 3, "--json").stdout)
    assert found["curves"]["guide.thrust"]["max"] is None


# ---------------------------------------------------------------- refused before the work
@pytest.fixture
def never(monkeypatch):
    def work(*args, **options):
        raise AssertionError("it ran")

    for name in ("simulate", "kinematics", "compare", "poincare", "modes", "accuracy", "equilibrium"):
        monkeypatch.setattr(mechanism.Mechanism, name, work)
    monkeypatch.setattr("rattle.results.result.load_result", work)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("run model.toml -o out.csv", "a result is saved as .nc or .npz; --csv out.csv writes its curves"),
        ("run model.toml --csv nowhere/x.csv", "the folder nowhere does not exist"),
        ("run model.toml --csv x.xls", "give a name ending in .csv"),
        ("run model.toml --csv model.toml.csv", "it is the input file"),
        ("run model.toml -o out.nc --fallback nowhere", "needs a folder"),
        ("run model.toml -o out.npz --csv ./folder", "it is a folder"),
        ("kinematics model.toml -o out.bmp", "saved as .nc (netCDF) or .npz"),
        ("compare model.toml -o x.bmp", "a picture needs a name ending in"),
        ("poincare model.toml -o nowhere/x.png", "the folder nowhere does not exist"),
        ("modes model.toml -o x.html", "only the result of a run becomes a page; use .gif or .mp4 here"),
        ("accuracy model.toml --of a -o x.gif", "a picture needs a name ending in"),
        ("equilibrium model.toml -o x.nc", "they need --path"),
        ("export same.npz -o same.npz", "it is the input file"),
        ("export same.npz -o out.xls", "give a name ending in .csv"),
        ("ensemble model.toml --of lift --csv x.mat", "give a name ending in .csv"),
        ("run model.toml -o x.xlsx", "--csv x.xlsx writes its curves"),
        ("plot same.npz lift -o x.bmp", "a picture needs a name ending in"),
        ("animate same.npz -o x.mov", "an animation needs a name ending in .gif or .mp4"),
    ],
)
def test_what_cannot_be_written_is_refused_before_the_work(tmp_path, monkeypatch, never, words, said):
    monkeypatch.chdir(tmp_path)
    text = loading.examples()["fourbar"].read_text(encoding="utf-8")
    Path("model.toml").write_text(text, encoding="utf-8")
    os.link("model.toml", "model.toml.csv")
    Path("folder").mkdir()
    circling(5).save("same.npz")
    content = Path("same.npz").read_bytes()
    found = call(*words.split())
    assert found.exit_code == 2, found.output
    assert said in found.stderr.replace("\n", " ")
    assert Path("same.npz").read_bytes() == content
    assert Path("model.toml.csv").read_text(encoding="utf-8") == text


def test_a_missing_package_is_named_before_the_run(tmp_path, monkeypatch, never):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(sys.modules, "h5netcdf", None)
    found = call("run", "fourbar", "-o", "out.nc")
    assert found.exit_code == 2
    assert "saving as .nc needs h5netcdf and h5py" in found.stderr
    assert ".npz needs nothing more" in found.stderr


def test_a_missing_ffmpeg_is_named_before_the_work(tmp_path, monkeypatch, never):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("matplotlib.animation.FFMpegWriter.isAvailable", lambda: False)
    circling(5).save("r.npz")
    for words in (("animate", "r.npz", "-o", "x.mp4"), ("modes", "balanced_arm", "-o", "x.mp4")):
        found = call(*words)
        assert found.exit_code == 2
        assert "needs the program ffmpeg" in found.stderr


# ---------------------------------------------------------------- without other packages
def test_the_commands_of_the_readme_work_in_a_plain_installation(tmp_path):
    """Without the packages for netCDF and tables; the ones that make pictures of a saved result too."""
    code = """
import sys
class Blocked:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in ("xarray", "h5netcdf", "h5py", "pandas", "netCDF4"):
            raise ImportError(name)
sys.meta_path.insert(0, Blocked())
from rattle.cli.main import main
for words in (
    "run double_pendulum --t-end 1ms --no-horizon -o out.npz --csv out.csv",
    "plot out.npz", "plot out.npz upper.angle -o p.png", "animate out.npz -o a.gif --frames 2",
    "export out.npz -o e.csv", "check fourbar", "kinds spring", "example",
):
    print(words, flush=True)
    try:
        main(words.split())
    except SystemExit as end:
        if end.code:
            raise
try:
    main("run double_pendulum --t-end 1ms -o out.nc".split())
except SystemExit as end:
    assert end.code == 2
"""
    run = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, env=PLAIN, capture_output=True, text=True, timeout=120
    )
    assert run.returncode == 0, run.stdout + run.stderr
    assert "saving as .nc needs h5netcdf and h5py" in run.stderr
    assert {one.name for one in tmp_path.iterdir()} == {"out.npz", "out.csv", "p.png", "a.gif", "e.csv"}
    assert (tmp_path / "e.csv").read_text() == (tmp_path / "out.csv").read_text()


# ---------------------------------------------------------------- Ctrl-C
@pytest.fixture
def stop_at(monkeypatch):
    """Ctrl-C in the given call of `advance` of the given run; returns the list of calls."""
    real, calls = running.Run.advance, []

    def at(number, run=1):
        def advance(self, t, chunk):
            calls.append(self)
            if len(set(calls)) == run and calls.count(self) == number:
                raise KeyboardInterrupt
            return real(self, t, chunk)

        assert engine.NUMBERS["CHUNK"] > 20  # an engine that is built meanwhile has the real one
        monkeypatch.setattr(running, "CHUNK", 20)
        monkeypatch.setattr(running.Run, "advance", advance)
        return calls

    return at


def test_an_interrupted_run_ends_at_once_and_keeps_what_there_is(tmp_path, stop_at):
    calls = stop_at(3)
    found = call("run", "double_pendulum", "--t-end", 1, "-o", tmp_path / "out.npz")
    assert found.exit_code == 130
    assert len(calls) == 3  # no second run for the horizon
    r = load_result(tmp_path / "out.npz")
    assert not r.success
    assert r.interrupted
    assert 0.0 < r.trust.t_end < 1.0
    assert len(r.t) > 2


def test_an_interrupted_run_does_not_replace_a_complete_one(tmp_path, stop_at):
    target = tmp_path / "out.npz"
    assert call("run", "double_pendulum", "--t-end", "1 ms", "--no-horizon", "-o", target).exit_code == 0
    content = target.read_bytes()
    stop_at(3)
    found = call("run", "double_pendulum", "--t-end", 1, "-o", target)
    assert found.exit_code == 130
    assert target.read_bytes() == content
    assert load_result(tmp_path / "out.partial.npz").interrupted
    assert "out.partial.npz" in found.stderr


def test_a_stop_in_the_second_run_keeps_the_whole_first_one(tmp_path, monkeypatch):
    def stopped(self, progress=False, what="simulate", real=running.Run.go):
        real(self, progress, what) if what == "simulate" else setattr(self, "interrupted", True)

    monkeypatch.setattr(running.Run, "go", stopped)
    found = call("run", "double_pendulum", "--t-end", "1 ms", "-o", tmp_path / "out.npz")
    assert found.exit_code == 130
    r = load_result(tmp_path / "out.npz")
    assert r.success
    assert r.trust.horizon is None


def test_interrupted_sections_say_so(tmp_path, monkeypatch, stop_at):
    monkeypatch.chdir(tmp_path)
    stop_at(3)
    found = call(
        "poincare", "double_pendulum", "--of", "upper.angle", "--of", "upper.omega", "--period", 0.05, "--skip", 0
    )
    assert found.exit_code == 130
    assert "stopped by the user at t = " in found.stdout
    assert Path("poincare.png").exists()


def test_a_section_stopped_before_its_first_point_is_no_picture(tmp_path, monkeypatch, stop_at):
    monkeypatch.chdir(tmp_path)
    stop_at(1)
    found = call("poincare", "double_pendulum", "--of", "upper.angle", "--of", "upper.omega", "--period", 0.05)
    assert found.exit_code == 130
    assert "0 points, every 0.05 s, stopped by the user at t = " in found.stdout
    assert not Path("poincare.png").exists()


# ---------------------------------------------------------------- runs that stop early
SECTION = ("poincare", "m.toml", "--of", "upper.angle", "--period", 0.01, "--points", 20)
OF_TWO = ("--of", "upper.omega")  # a section draws one curve over another


def write_pendulum_torn_at(t):
    """m.toml: a double pendulum and a torque beyond all numbers from t [s] on, where its runs stop."""
    m = rt.example("double_pendulum").load("M", "torque", body="upper", torque=f"1e300*step(t - {t})")
    Path("m.toml").write_text(m.settings(rtol=1e-6).to_toml())


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize(
    ("more", "said"),
    [
        (
            (*OF_TWO, "--skip", 9),
            "the run stopped at t = 0.045 s, .*; the first point is that at t = 0.09 s, after 9 periods",
        ),
        (
            (*OF_TWO, "--crossing", "upper.x", "--skip", 2),
            "the run stopped at t = 0.045 s, .*; upper.x goes from 0.1.* never rises",
        ),
        (
            ("--parameter", "start", "--from", 1, "--to", 1.1, "--values", 2, "--skip", 9),
            "every run stopped before 9 periods were over, the first one at t = 0.045 s",
        ),
    ],
)
def test_a_section_whose_run_stops_before_its_first_point_says_why_and_draws_nothing(more, said, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_pendulum_torn_at(0.045)
    found = call(*SECTION, *more)
    assert found.exit_code == 1
    assert re.search(f"error: no point: {said}", found.stderr)
    assert not Path("poincare.png").exists()


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_a_section_whose_run_stops_shows_the_points_it_has_and_fails(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_pendulum_torn_at(0.045)
    found = call(*SECTION, *OF_TWO, "--skip", 1)
    assert found.exit_code == 1
    assert "4 points, every 0.01 s, stopped at t = 0.045 s" in found.stdout  # at 10, 20, 30 and 40 ms
    assert Path("poincare.png").exists()


def test_an_interrupted_bifurcation_ends_its_other_runs(stop_at):
    calls = stop_at(1, run=2)
    m = rt.example("double_pendulum")
    found = m.bifurcation(
        "upper_length", [0.4, 0.41, 0.42, 0.43], "upper.angle", period=0.01, skip=0, points=5, threads=1
    )
    assert found.interrupted
    assert "stopped by the user" in found.rule
    assert found.points.shape == (4, 5)
    assert not running.stop.is_set()
    assert np.isfinite(found.points[0]).all()
    assert np.isnan(found.points[1:]).all()
    assert len(set(calls)) == 2


def test_a_bifurcation_interrupted_in_its_first_run_leaves_later_runs_alone(stop_at):
    stop_at(1)
    m = rt.example("double_pendulum")
    with pytest.raises(KeyboardInterrupt):
        m.bifurcation("upper_length", [0.4, 0.41], "upper.angle", period=0.01, skip=0, points=5, threads=1)
    assert not running.stop.is_set()
    assert m.simulate(0.01).success


def test_comparison_ends_at_ctrl_c(stop_at):
    stop_at(2)
    found = call("compare", "slider_crank_play", "--t-end", "0.1", "-o", "never.png")
    assert found.exit_code == 130
    assert not Path("never.png").exists()


@pytest.mark.parametrize(
    "words",
    [
        ("compare", "fourbar", "-o", "never.png"),
        ("poincare", "double_pendulum", "--of", "upper.angle", "--of", "upper.omega", "--period", "1"),
        ("ensemble", "fourbar", "--of", "max(O3.force)", "-n", "8"),
        ("tolerance", "fourbar", "--of", "max(O3.force)"),
        ("page", "stribeck", "-o", "never.html"),
        ("report", "fourbar", "-o", "never.html"),
        ("demo", "-o", "never"),
    ],
    ids=lambda words: words[0],
)
def test_ctrl_c_ends_the_whole_command_not_one_run_of_it(tmp_path, monkeypatch, stop_at, words):
    monkeypatch.chdir(tmp_path)
    calls = stop_at(1)
    found = call(*words)
    assert found.exit_code == 130, found.output
    assert len(set(calls)) == 1  # nothing was run after it
    assert not [one for one in tmp_path.rglob("never*") if one.is_file()]


def test_a_report_is_not_written_of_a_motion_that_was_cut_and_the_old_one_stays(tmp_path, monkeypatch, stop_at):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "r.html").write_text("the old one")
    for number, run in ((3, 1), (1, 2)):  # in the motion, and in the run that tells how long it can be trusted
        stop_at(number, run)
        assert call("report", "fourbar", "-o", "r.html").exit_code == 130
        monkeypatch.undo()
        monkeypatch.chdir(tmp_path)
        assert (tmp_path / "r.html").read_text() == "the old one"
        assert [one.name for one in tmp_path.iterdir()] == ["r.html"]


def interrupted(*_, **__):
    raise KeyboardInterrupt


def test_ctrl_c_at_a_question_ends_with_the_status_of_shells(monkeypatch):
    pytest.importorskip("uvicorn")
    monkeypatch.setattr("click.termui.visible_prompt_func", interrupted)
    monkeypatch.setattr("rattle.studio.serve.serve", lambda *_: pytest.fail("it listens"))
    with pytest.raises(SystemExit) as end:
        main(["studio", "--address", "0.0.0.0"])
    assert end.value.code == 130


def test_a_question_left_by_the_end_of_the_input_is_no_ctrl_c():
    found = CliRunner().invoke(main, ["studio", "--address", "0.0.0.0"], input="")
    assert found.exit_code == 1
    assert "Aborted" in found.output


def test_ctrl_c_while_options_are_parsed_ends_with_the_status_of_shells(monkeypatch):
    monkeypatch.setattr(type(main), "parse_args", interrupted)
    assert call("check", "fourbar").exit_code == 130


RUNNING = """
import sys
from rattle.analyses.dynamics import run
from rattle.cli.main import main
real = run.Run.advance
def advance(self, t, chunk):
    print("running", flush=True)
    return real(self, t, chunk)
run.Run.advance = advance
main()
"""


def test_a_program_that_is_interrupted_ends_at_once_with_the_status_of_shells(tmp_path):
    words = ["run", "double_pendulum", "--t-end", "1000", "-o", "out.npz"]
    run = subprocess.Popen(
        [sys.executable, "-c", RUNNING, *words],
        cwd=tmp_path,
        env=PLAIN,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # tests that run behind a shell's & ignore it
    )
    assert run.stdout.readline() == b"running\n"
    run.send_signal(signal.SIGINT)
    _, said = run.communicate(timeout=30)
    assert run.returncode == 130, said


LOSING = """
from rattle.analyses.dynamics import run
from rattle.cli.main import main
class Interrupted:
    def __del__(self):
        raise KeyboardInterrupt
real = run.Run.advance
def advance(self, t, chunk):
    if run.Run.advance is advance:
        run.Run.advance = real
        Interrupted()
    return real(self, t, chunk)
run.Run.advance = advance
main()
"""


def test_an_interrupt_that_python_loses_in_a_finaliser_ends_the_program_too(tmp_path):
    words = ["run", "double_pendulum", "--t-end", "1000", "-o", "out.npz"]
    ended = subprocess.run(
        [sys.executable, "-c", LOSING, *words],
        cwd=tmp_path,
        env=PLAIN,
        capture_output=True,
        text=True,
        timeout=60,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    assert ended.returncode == 130, ended.stderr
    assert "Exception ignored" not in ended.stderr


# ---------------------------------------------------------------- streams
@pytest.mark.machine
def test_a_reader_that_leaves_is_no_error():
    found = shell("rattle kinds | head -1")
    assert found.stderr == ""
    assert found.stdout


@pytest.mark.machine
def test_a_closed_stderr_changes_nothing():
    found = shell("rattle check fourbar 2>&-")
    assert found.returncode == 0
    assert "bodies" in found.stdout
    assert shell("rattle run fourbar --t-end 1ms --rtol nan 2>&-").returncode == 2


def test_quiet_keeps_the_reason_of_a_failure(tmp_path):
    (tmp_path / "m.toml").write_text(
        "format = 1\n[ground.points]\nO = [0, 0]\n[bodies.d]\nmass = 1\ninertia = 1\npoints = { O = [0, 0] }\n"
        '[joints.O]\ntype = "revolute"\nconnect = ["ground.O", "d.O"]\n'
        '[loads.M]\ntype = "torque"\nbody = "d"\ntorque = "sqrt(0.001 - t)"\n[simulate]\nt_end = 0.1\n'
    )
    found = call("-q", "run", tmp_path / "m.toml", "--no-horizon")
    assert found.exit_code == 1
    assert "loads.M" in found.stderr
    assert "no finite value" in found.stderr


# ---------------------------------------------------------------- a full disk
@pytest.fixture
def full(tmp_path, monkeypatch):
    real = archive.atomic

    def atomic(path):
        if Path(path).parent == tmp_path:
            raise OSError(28, f"cannot write {path}: No space left on device")
        return real(path)

    monkeypatch.setattr(archive, "atomic", atomic)
    (tmp_path / "other").mkdir()


def test_a_full_disk_loses_no_table_and_says_what_to_do(tmp_path, full):
    found = call("run", "double_pendulum", "--t-end", "1 ms", "--no-horizon", "-o", tmp_path / "out.npz")
    assert found.exit_code == 2
    assert "No space left on device" in found.stderr
    assert "--fallback FOLDER names another place" in found.stderr
    assert "peak force" in found.stdout


def test_another_place_is_tried_on_request(tmp_path, full):
    words = ("--fallback", tmp_path / "other", "-o", tmp_path / "out.npz")
    found = call("run", "double_pendulum", "--t-end", "1 ms", "--no-horizon", *words)
    assert found.exit_code == 0
    assert "saved as" in found.stderr
    assert load_result(tmp_path / "other" / "out.npz").success


# ---------------------------------------------------------------- whose fault it is
def test_a_slip_of_our_own_keeps_its_traceback(monkeypatch):
    def slip(self):
        return float("no number")

    monkeypatch.setattr(mechanism.Mechanism, "check", slip)
    found = call("check", "fourbar")
    assert isinstance(found.exception, ValueError)
    assert not isinstance(found.exception, SystemExit)


def test_an_answer_to_the_user_has_none():
    found = call("run", "fourbar", "--method", "euler")
    assert found.exit_code == 2
    assert "unknown method 'euler'" in found.stderr


def test_names_cannot_steer_the_terminal(tmp_path):
    file = tmp_path / "m.toml"
    file.write_text('format = 1\nname = "a\\u001b]0;x\\u0007"\ngravity = "\\u001b[2J\\u202e"\n', encoding="utf-8")
    found = call("check", file)
    assert found.exit_code == 2
    assert "\\x1b[2J\\u202e" in found.stderr
    assert all(one.isprintable() or one == "\n" for one in found.output)


def test_a_model_in_place_of_a_result_takes_set_and_a_saved_result_refuses_it(tmp_path):
    words = ("slider_crank", "--set", "speed=500 rpm", "--set", "simulate.t_end=1 ms")
    for command in (
        ("plot", words[0], "rod.x", *words[1:]),
        ("power", *words),
        ("animate", *words),
        ("export", *words),
    ):
        target = tmp_path / f"{command[0]}.{'html' if command[0] == 'animate' else 'csv'}"
        target = target.with_suffix(".svg") if command[0] == "plot" else target
        done = call(*command, "-o", str(target))
        assert done.exit_code == 0, done.output
        assert target.exists()
    slow = rt.example("slider_crank").set({"speed": "500 rpm", "simulate.t_end": "1 ms"}).simulate()
    last = (tmp_path / "export.csv").read_text().splitlines()[-1].split(",")
    header = (tmp_path / "export.csv").read_text().splitlines()[0].split(",")
    assert float(last[header.index("crank.angle [rad]")]) == pytest.approx(slow["crank.angle"][-1], rel=1e-12)
    slow.save(tmp_path / "slow.npz")
    done = call("export", tmp_path / "slow.npz", "--set", "speed=1", "-o", tmp_path / "no.csv")
    assert done.exit_code == 2
    assert "--set changes a model" in done.output


def test_export_writes_the_curves_that_are_named(tmp_path):
    rt.example("double_pendulum").simulate("5 ms").save(tmp_path / "r.npz")
    done = call("export", tmp_path / "r.npz", "upper.omega", "upper.angle", "-o", tmp_path / "two.csv")
    assert done.exit_code == 0, done.output
    assert (tmp_path / "two.csv").read_text().splitlines()[0] == "t [s],upper.omega [rad/s],upper.angle [rad]"
    assert (
        "did you mean 'upper.omega'"
        in call("export", tmp_path / "r.npz", "upper.omeg", "-o", tmp_path / "two.csv").output
    )
    assert call("export", tmp_path / "r.npz", "upper.omega", "-o", tmp_path / "two.nc").exit_code == 2
    for suffix in ("xlsx", "mat"):
        assert call("export", tmp_path / "r.npz", "upper.omega", "-o", tmp_path / f"two.{suffix}").exit_code == 0
    assert read_workbook((tmp_path / "two.xlsx").read_bytes())["curves"][0] == ["t [s]", "upper.omega [rad/s]"]
    assert loadmat(tmp_path / "two.mat")["r"]["values"][0, 0].shape == (len(rt.load_result(tmp_path / "r.npz").t), 1)


def test_curves_of_a_run_are_written_in_the_format_of_their_name(tmp_path):
    for suffix in ("csv", "xlsx", "mat"):
        assert call("run", "double_pendulum", "--t-end", "5 ms", "--csv", tmp_path / f"r.{suffix}").exit_code == 0
    rows = read_workbook((tmp_path / "r.xlsx").read_bytes())["curves"]
    header, *lines = (tmp_path / "r.csv").read_text().splitlines()
    column = rows[0].index("upper.omega [rad/s]")
    written = [float(line.split(",")[header.split(",").index("upper.omega [rad/s]")]) for line in lines]
    assert [row[column] for row in rows[1:]] == written
    assert loadmat(tmp_path / "r.mat")["r"]["t"][0, 0].ravel().tolist() == [row[0] for row in rows[1:]]


def test_a_table_for_o_names_the_option_that_writes_it(tmp_path):
    done = call("run", "double_pendulum", "-o", tmp_path / "x.csv")
    assert done.exit_code == 2
    assert f"--csv {tmp_path / 'x.csv'} writes its curves" in done.output


DRIVEN = """
format = 1
[ground.points]
O = [0, 0]
[bodies.weight]
points = { P = [0, 0] }
mass = "1 kg"
inertia = "1 kg*m^2"
[joints.guide]
type = "TYPE"
connect = ["ground.O", "weight.P"]
[drivers.motor]
joint = "guide"
KEY = "LAW"
[simulate]
t_end = "10 ms"
"""


def test_a_driver_without_an_end_in_reach_is_said_so_in_one_clause(tmp_path):
    (tmp_path / "m.toml").write_text(
        DRIVEN.replace("TYPE", "prismatic").replace("KEY", "position").replace("LAW", "0.1*t")
    )
    said = call("check", tmp_path / "m.toml").stdout
    assert "1 body, 1 joint, mobility 0" in said
    assert "motor can move as far as was tried, to both sides (now 0 m)" in said
    assert "beyond" not in said


@pytest.mark.parametrize(
    ("speed", "shown"), [("5000 rpm", "5000 rpm"), ("30 rad/s", "30 rad/s"), ("30", "1718.9 deg/s")]
)
def test_speeds_of_bodies_are_in_the_unit_of_the_model_file(tmp_path, speed, shown):
    text = DRIVEN.replace("TYPE", "revolute").replace("KEY", "angle").replace("LAW", "w*t")
    (tmp_path / "m.toml").write_text(text + f'[parameters]\nw = "{speed}"\n')
    said = call("kinematics", tmp_path / "m.toml").stdout
    line = next(line for line in said.splitlines() if line.startswith("weight.omega"))
    assert " ".join(line.split()).startswith(f"weight.omega {shown}")
    in_degrees = call("kinematics", tmp_path / "m.toml", "--units", "deg/s").stdout
    assert "rpm" not in in_degrees
