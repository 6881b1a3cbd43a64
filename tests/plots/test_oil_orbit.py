"""The orbit of a pin in oil as a picture: ring, dots, colours and marks are where the numbers have them."""

import math

import numpy as np
import pytest
from click.testing import CliRunner
from matplotlib.collections import LineCollection
from matplotlib.patches import Annulus

import rattle as rt
from rattle.cli.main import main


@pytest.fixture(scope="module")
def orbit():
    return rt.example("slider_crank_oil").set({"joints.B.contact.boundary_film": "12 um"}).orbit("B", t_end="30 ms")


def test_ring_dots_and_colours_are_those_of_the_result(orbit):
    ax, bar = orbit.plot_orbit("B").axes
    (ring,) = [one for one in ax.patches if isinstance(one, Annulus)]
    assert (ring.get_radii()[0], ring.get_width()) == pytest.approx((0.1, 0.012))  # [mm]
    lines = {line.get_label(): line for line in ax.lines}
    x, y = lines["every 10° of O"].get_data()
    assert len(x) == 36
    angle, last = orbit["O.angle"], orbit["O.angle"][-1]
    for k, (u, v) in enumerate(zip(x, y, strict=True)):
        t = np.interp(last - math.radians(10 * (35 - k)), angle, orbit.t)  # the run ends at half a turn
        assert (u, v) == pytest.approx([1e3 * np.interp(t, orbit.t, orbit[f"B.{e}"]) for e in ("ex", "ey")], abs=1e-6)
    before, final = [one for one in ax.collections if isinstance(one, LineCollection)]
    assert final.get_array().max() == pytest.approx(1e-6 * orbit["B.film_pressure"].max())
    assert len(final.get_segments()) == pytest.approx(0.4 * len(orbit.t), abs=2)  # one turn of two and a half
    assert len(before.get_segments()) + len(final.get_segments()) == len(orbit.t) - 1
    assert "MPa" in bar.get_ylabel()
    thin = int(np.argmin(orbit["B.film_thickness"]))
    (mark,) = [line for name, line in lines.items() if name.startswith("least film")]
    assert mark.get_xydata()[0] == pytest.approx([1e3 * orbit["B.ex"][thin], 1e3 * orbit["B.ey"][thin]])
    shown = np.isfinite(lines["dry contact carries too"].get_xdata())
    assert (shown == (orbit["B.regime"] > 0.0)).all()


def test_the_command_draws_the_orbit_of_a_saved_result(orbit, tmp_path):
    orbit.save(tmp_path / "o.npz")
    done = CliRunner().invoke(main, ["plot", str(tmp_path / "o.npz"), "--orbit", "B", "-o", str(tmp_path / "o.svg")])
    assert done.exit_code == 0, done.output
    assert "boundary film, 12 µm" in (tmp_path / "o.svg").read_text(encoding="utf-8")


def test_a_pin_in_oil_without_a_driven_joint_has_no_dots():
    r = rt.example("journal_falls").simulate("1 ms")
    labels = [line.get_label() for line in r.plot_orbit(next(iter(r.films))).axes[0].lines]
    assert not any("every" in label for label in labels)
    assert any(label.startswith("least film") for label in labels)
