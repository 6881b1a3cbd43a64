"""`rattle orbit`: the table of the film, picture and file, what it refuses."""

import json

import pytest
from click.testing import CliRunner

import rattle as rt
from rattle.cli.main import main

OILED = ("slider_crank_play", "--set", "c=2e-4", "--set",
         'joints.B.contact={model="lubricated",viscosity=0.4,length=0.02,bush_radius=0.01}')  # fmt: skip


def orbit(*arguments):
    return CliRunner().invoke(main, ["-q", "orbit", *map(str, arguments)])


def test_an_orbit_prints_its_film_and_is_saved_and_drawn(tmp_path):
    picture, saved = tmp_path / "orbit.svg", tmp_path / "orbit.npz"
    done = orbit(*OILED, "--joint", "B", "--t-end", "24 ms", "-o", saved)
    assert done.exit_code == 0, done.output
    r = rt.load_result(saved)
    one = r.films["B"]
    assert f"{1e6 * one.least_film:.4g} um" in done.output
    assert "inertia is left out" in done.output
    done = orbit(*OILED, "--t-end", "24 ms", "-o", picture, "--json")
    assert json.loads(done.stdout)["films"]["B"]["least_film"] == pytest.approx(one.least_film, rel=1e-12)
    assert "µm" in picture.read_text(encoding="utf-8") or "mm" in picture.read_text(encoding="utf-8")


@pytest.mark.nojit
@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("slider_crank_play",), "this needs a joint with oil"),
        ((*OILED, "--joint", "C"), "no joint 'C'"),
        ((*OILED, "--joint", "A"), "joints.A.contact: an orbit needs oil"),
        ((*OILED, "--ideal"), "an orbit is about play"),
        ((*OILED, "--without", "motor"), "degree of freedom is left"),
        ((*OILED, "-o", "orbit.xlsx"), ".nc"),
    ],
)
def test_what_has_no_orbit_is_refused_on_the_command_line(arguments, said):
    done = orbit(*arguments)
    assert done.exit_code == 2
    assert said in done.output
