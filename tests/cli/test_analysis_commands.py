"""The commands without time steps: what they print, where, and with which exit status."""

import json

import pytest
from click.testing import CliRunner

from linkages import fourbar_text, slider_crank
from rattle.cli.main import main

pytestmark = pytest.mark.nojit


def run(*words: str):
    return CliRunner().invoke(main, ["-q", *words])


def test_equilibrium_lists_positions_with_units():
    seen = run("equilibrium", "fourbar")
    assert seen.exit_code == 0
    assert seen.stdout.startswith("1. stable, stiffness")
    assert "O3 presses with" in seen.stdout
    assert "motor.torque: " in seen.stdout
    assert " N*m" in seen.stdout
    entries = json.loads(run("equilibrium", "fourbar", "--json").stdout)
    assert [one["admissible"] for one in entries] == [True, False, False, False]
    assert entries[0]["values"]["O3.normal"]["unit"] == "N"


def test_equilibrium_says_which_load_friction_holds_and_when_it_jams(tmp_path):
    file = tmp_path / "drawer.toml"
    file.write_text(
        "format = 1\ngravity = [0, 0]\n[ground.points]\nO = [0, 0]\n[bodies.drawer]\nmass = 1\ninertia = 1\n"
        "points = { C = [0, 0], H = [0, 0.5] }\n"
        '[joints.guide]\ntype = "prismatic"\nconnect = ["ground.O", "drawer.C"]\n'
        'block = { length = 0.2, height = 0.05 }\nfriction = 0.25\n[loads.push]\ntype = "force"\nat = "drawer.H"\n'
        "force = [3, 0]\n"
    )
    seen = run("equilibrium", str(file), "--holds", "push")
    assert (seen.exit_code, seen.stdout.splitlines()[1]) == (0, "now 3 N: it rests")
    assert "jams: however large push is, either way, it does not move (from 0.8 times" in seen.stdout
    record = json.loads(run("equilibrium", str(file), "--holds", "push", "--json").stdout)
    assert (record["low"], record["high"], record["free"], record["jams"]) == (None, None, 0.0, True)
    assert run("equilibrium", str(file), "--holds", "pull").exit_code == 2
    assert "--holds is about" in run("equilibrium", str(file), "--holds", "push", "--path").stderr
    without = run("equilibrium", str(file))
    assert "friction in 'guide' is left out" in without.stderr
    with_spring = (
        '[loads.spring]\ntype = "spring"\nconnect = ["ground.O", "drawer.C"]\nstiffness = 100\nfree_length = 0\n'
    )
    file.write_text(file.read_text().replace("gravity = [0, 0]", "gravity = [0, -8]") + with_spring)
    said = "friction holds it from guide.position -7.5 mm to 67.5 mm"  # (3 -+ 0.25 * 3 * 0.5/0.1) N / (100 N/m)
    assert said in run("equilibrium", str(file)).stdout


def test_slow_motion_of_the_clamp_shows_its_advantage():
    seen = run("equilibrium", "toggle_clamp", "--path", "--points", "5")
    assert seen.exit_code == 0
    assert "work.advantage" in seen.stdout
    assert "286.49 1/m" in seen.stdout


def test_kinematics_with_play_is_bad_input_and_says_what_to_do(tmp_path):
    seen = run("kinematics", "fourbar")
    assert seen.exit_code == 2
    assert "2 degrees of freedom are left" in seen.stderr
    assert "--ideal" in seen.stderr
    out = tmp_path / "out.csv"
    seen = run("kinematics", "fourbar", "--ideal", "--points", "5", "--t-end", "0.1", "--csv", str(out))
    assert seen.exit_code == 0
    assert "rocker.omega" in seen.stdout
    assert out.read_text().startswith("t [s],crank.x [m]")


def test_a_dead_centre_fails_the_run_and_keeps_what_was_found(tmp_path):
    start = "crank = { angle = 1.5 }\ncoupler = { angle = 0.1 }"
    file = tmp_path / "rocker.toml"
    file.write_text(fourbar_text('joint = "D"\nangle = "2 - 1.0*t"', 0.3, 1.0, 0.5, 1.0, start))
    seen = run("inverse-dynamics", str(file), "--t-end", "3", "--points", "31")
    assert seen.exit_code == 1
    assert "dead centre" in seen.stderr
    assert "motor.torque" in seen.stdout


def test_output_to_input_in_one_call(tmp_path):
    file = tmp_path / "pushed.toml"
    push = 'body = "slider"\ncoordinate = "x"\nposition = "0.3 + 0.01*sin(5*t)"'
    file.write_text(slider_crank(push, crank="{ angle = 1.5 }"))
    seen = run("inverse-dynamics", str(file), "--effort-at", "O", "--points", "11")
    assert seen.exit_code == 0
    assert "O.torque" in seen.stdout
    assert "N*m" in seen.stdout


def test_play_prints_the_band_and_draws_it(tmp_path):
    figure = tmp_path / "play.svg"
    seen = run("accuracy", "path_generator", "--of", "coupler.P.y", "--points", "5", "-o", str(figure))
    assert seen.exit_code == 0
    for words in ("worst case", "root sum square", "tighten", " mm", " %"):
        assert words in seen.stdout
    assert "deviation" in figure.read_text()
    entry = json.loads(run("accuracy", "path_generator", "--of", "coupler.P.y", "--points", "3", "--json").stdout)
    assert entry["unit"] == "m"
    assert set(entry["share"]) == {"A", "B", "Q"}
    assert run("accuracy", "path_generator", "--of", "coupler.Z").exit_code == 2


def test_modes_name_frequencies_and_draw_a_shape(tmp_path):
    figure = tmp_path / "mode.svg"
    seen = run("modes", "balanced_arm", "-o", str(figure))
    assert seen.exit_code == 0
    assert "mode 1: 0.251" in seen.stdout
    assert "Hz" in seen.stdout
    assert figure.stat().st_size > 1000


def test_options_that_would_do_nothing_are_refused(tmp_path):
    seen = run("modes", "balanced_arm", "--mode", "7", "-o", str(tmp_path / "x.svg"))
    assert seen.exit_code == 2
    assert "the modes are numbered from 1 to 2" in seen.stderr
    for words, said in (
        ("equilibrium balanced_arm --t-end 1", "they need --path"),
        ("equilibrium balanced_arm --points 5", "they need --path"),
        ("equilibrium toggle_clamp --path --at 0.5", "a --path begins at t = 0"),
        ("equilibrium toggle_clamp --path --branches near", "a --path begins at t = 0"),
    ):
        seen = run(*words.split())
        assert seen.exit_code == 2
        assert said in seen.stderr


def test_a_name_for_a_mode_is_that_of_a_picture_or_of_an_animation():
    for name in ("mode.txt", "mode"):
        seen = run("modes", "balanced_arm", "-o", name)
        assert seen.exit_code == 2
        assert (
            f"{name}: a picture needs a name ending in .svg, .png, .pdf, an animation one in .gif or .mp4"
            in seen.stderr
        )


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("lyapunov", "no command 'lyapunov'; it is `rattle poincare FILE --lyapunov`"),
        ("bifurcation", "`rattle poincare FILE --parameter NAME`"),
        ("simulate", "`rattle run FILE`"),
        ("mode", "did you mean 'modes'"),
    ],
)
def test_commands_that_have_another_name_are_pointed_to(name, said):
    seen = run(name, "fourbar")
    assert seen.exit_code == 2
    assert said in seen.stderr


def test_a_search_that_was_given_up_is_said_beside_the_results():
    seen = run("equilibrium", "double_pendulum", "--effort", "0.001", "--json")
    assert seen.exit_code == 0
    assert json.loads(seen.stdout)
    assert "search stopped after 1 starts; there may be more" in seen.stderr


def test_efforts_at_a_dead_centre_are_left_out_and_said():
    seen = run("inverse-dynamics", "slider_crank", "--effort-at", "guide", "--points", "41")
    assert seen.exit_code == 0
    assert "nan N" not in seen.stdout
    assert "guide.thrust: none at" in seen.stdout
    assert "'guide' is at a dead centre there, where no effort of it does the work of driver 'motor'" in seen.stdout
    record = json.loads(
        run("inverse-dynamics", "slider_crank", "--effort-at", "guide", "--points", "41", "--json").stdout
    )
    assert record["success"] is True
    assert record["curves"]["guide.thrust"]["max"] > 0.0
    assert any("dead centre" in note for note in record["trust"]["notes"])


def test_flutter_is_not_called_stable(tmp_path):
    file = tmp_path / "flutter.toml"
    file.write_text(FLUTTER)
    seen = run("modes", str(file))
    assert seen.stdout.splitlines()[0].startswith("about: stable statically, unstable by flutter")
    assert "mode 1: flutter at 0.31831 Hz, grows at 0.05 1/s, damping -2.5 % (mass)" in seen.stdout
    record = json.loads(run("modes", str(file), "--json").stdout)
    assert record["grows"] is True
    assert record["modes"][0]["roots"][0] == pytest.approx([0.05, 1.999375])
    assert record["modes"][0]["damped_frequency"] == pytest.approx(1.999375 / 6.2831853)


FLUTTER = """
format = 1
gravity = [0, 0]
[ground.points]
O = [0, 0]
[bodies.mass]
points = { P = [0, 0] }
mass = 2
inertia = 1
[joints.rail]
type = "prismatic"
connect = ["ground.O", "mass.P"]
[loads.all]
type = "force"
at = "mass.P"
force = ["-8*mass.x + 0.2*mass.vx", 0]
"""


def test_modes_as_json_hold_frequencies_and_shapes():
    record = json.loads(run("modes", "double_pendulum", "--json").stdout)
    assert len(record["modes"]) == 2
    assert record["how"] == "exact derivatives"
    assert record["modes"][0]["frequency"] < record["modes"][1]["frequency"]
    assert all(len(shape) == 3 for one in record["modes"] for shape in one["shape"].values())
    assert record["equilibrium"]["stable"] is True
