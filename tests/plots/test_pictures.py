"""Pictures show what an engineer looks for: handy units, paths of points, names as they are written."""

import math
import os
from itertools import pairwise

import numpy as np
import pytest
from click.testing import CliRunner
from matplotlib.patches import Circle, Polygon

import rattle as rt
from circling import circling
from rattle.cli.main import main
from rattle.plots.animation import animate, scene
from rattle.plots.curves import handy_unit, plot
from rattle.plots.orbit import plot_path
from rattle.questions.compare.compute import newton
from rattle.questions.poincare.compute import Section
from rattle.questions.poincare.pictures import plot_section
from rattle.results.display import quantity
from rattle.results.result import Result

nojit = pytest.mark.nojit


def with_name(name, rename=None):
    r = circling(101)
    stored = [(rename or {}).get(one, one) for one in r.stored]
    return Result(
        t=r.t, data=np.column_stack([r[one] for one in r.stored]), names=stored,
        units={new: r.unit(old) for new, old in zip(stored, r.stored, strict=True)}, geometry=r.geometry,
        trust=r.trust, stats={}, provenance={"model": name},
    )  # fmt: skip


@nojit
def test_units_are_those_in_which_a_number_is_handy():
    assert handy_unit("rad", 1.0) == (180 / math.pi, "deg")
    assert [handy_unit("m", size)[1] for size in (2.0, 0.02, 2e-5, 0.0)] == ["m", "mm", "µm", "m"]
    assert handy_unit("N", 1e-9) == (1.0, "N")
    for unit, value in (("rad/s", 3.0), ("rad", 2.0), ("m", 0.03), ("m", 0.07), ("N", 5.0)):
        factor, shown = handy_unit(unit, value)
        assert quantity(value, unit, 6) == f"{factor * value:.6g} {shown}"
    r = circling(101)
    (line,) = plot(r, "arm.angle").axes[0].lines[:1]
    np.testing.assert_allclose(line.get_ydata(), np.degrees(r["arm.angle"]), rtol=1e-14)


@nojit
def test_curves_over_another_curve():
    r = circling(101)
    ax = plot(r, "O.normal", over="arm.angle").axes[0]
    assert ax.get_xlabel() == "arm.angle [deg]"
    np.testing.assert_allclose(ax.lines[0].get_xdata(), np.degrees(r["arm.angle"]), rtol=1e-14)


@nojit
def test_names_are_text_whatever_stands_in_them(tmp_path):
    r = with_name("$\\frac{1}$ of a mechanism", {"lift": "_x"})
    figure = plot(r, "_x", "O.fx")
    figure.savefig(tmp_path / "a.png")
    assert figure.axes[0].get_title(loc="left") == "$\\frac{1}$ of a mechanism"
    said = [text.get_text() for ax in figure.axes for text in ax.get_legend().get_texts()]
    assert sorted(said) == ["O.fx", "_x"]


def test_the_page_of_compare_takes_any_name(tmp_path):
    m = rt.example("slider_crank")
    text = m.to_toml().replace(f'name = "{m.name}"', r'name = "$\\frac{1}$"')
    found = rt.loads(text).compare(t_end=1e-4)
    found.figure().savefig(tmp_path / "page.png")
    assert found.name == "$\\frac{1}$"


@nojit
def test_path_of_a_point_has_one_scale_in_both_directions():
    r = circling(101)
    point = next(name[:-2] for name in r.names if name.count(".") == 2 and name.endswith(".x"))
    ax = plot_path(r, point).axes[0]
    assert ax.get_aspect() == 1.0
    factor = {"m": 1.0, "mm": 1e3}[ax.get_xlabel()[3:-1]]
    np.testing.assert_allclose(ax.lines[0].get_ydata(), factor * r[f"{point}.y"], rtol=1e-14)
    with pytest.raises(KeyError):
        plot_path(r, "arm.nowhere")


@nojit
def test_section_of_a_pin_is_drawn_in_its_bush_with_equal_axes():
    x, y = np.array([1e-4, -4e-4]), np.array([2e-4, 0.0])
    section = Section(np.arange(2.0), {"B.ex": x, "B.ey": y}, {"B.ex": "m", "B.ey": "m"}, "rule", False, {"B": 5e-4})
    figure = plot_section(section, "B.ex", "B.ey")
    ax = figure.axes[0]
    assert ax.get_xlabel() == "B.ex [mm]"
    assert ax.get_aspect() == 1.0
    assert [patch.radius for patch in ax.patches] == [pytest.approx(0.5)]
    figure.canvas.draw()
    boxes = [
        t.get_window_extent()
        for t in ax.get_xticklabels()
        if t.get_text() and ax.get_xlim()[0] <= t.get_position()[0] <= ax.get_xlim()[1]
    ]
    assert not any(a.overlaps(b) for a, b in pairwise(boxes))


def test_a_section_without_points_says_why(tmp_path):
    with pytest.raises(
        ValueError, match=r"coupler\.angle goes from 0\.\d+ to 1\.\d+ rad; it never rises through 0 rad"
    ):
        rt.example("fourbar").poincare("O3.ex", "O3.ey", crossing="coupler.angle", skip=0, points=5)
    out = tmp_path / "none.png"
    words = ["poincare", "fourbar", "--crossing", "coupler.angle", "--skip", "0", "--points", "5", "-o", str(out)]
    assert CliRunner().invoke(main, words).exit_code == 2
    assert not out.exists()


@nojit
def test_film_says_its_speed_and_draws_traces_and_names():
    r = circling(201)
    point = next(name[:-2] for name in r.names if name.count(".") == 2 and name.endswith(".x"))
    figure, update, count = scene(r, 21, [point], fps=10, names=True)
    update(count - 1)
    (ax,) = [one for one in figure.axes if one.get_title(loc="left")]
    pace = (r.t[-1] - r.t[0]) * 10 / (count - 1)
    assert f"shown {pace:.2g} times as fast" in ax.get_title(loc="left")
    assert any(len(line.get_xdata()) == len(r.t) for line in ax.lines)
    assert "arm" in [text.get_text() for text in ax.texts]


@nojit
def test_a_film_slower_than_its_outputs_allow_is_refused(tmp_path):
    with pytest.raises(ValueError, match="choose a larger speed"):
        animate(circling(21), tmp_path / "a.gif", speed=1e-3)
    with pytest.raises(ValueError, match="positive"):
        animate(circling(21), tmp_path / "a.gif", speed=-1.0)


@nojit
def test_pictures_of_one_result_do_not_overwrite_each_other(tmp_path):
    r = circling(101)
    r.save(tmp_path / "out.npz")
    point = next(name[:-2] for name in r.names if name.count(".") == 2 and name.endswith(".x"))
    path = str(tmp_path / "out.npz")
    for words in (["O.fx"], ["--orbit", "O"], ["--xy", point]):
        done = CliRunner().invoke(main, ["plot", path, *words])
        assert done.exit_code == 0, done.output
    assert {one.name for one in tmp_path.glob("*.png")} == {"out.png", "out-O.png", "out-path.png"}
    assert CliRunner().invoke(main, ["plot", path, "--over", "arm.angle"]).exit_code == 2


def test_a_block_is_shown_between_its_walls_and_no_word_is_cut_off():
    found = rt.example("guide_play").compare(t_end="30 ms")
    figure = found.figure()
    figure.canvas.draw()
    force = next(ax for ax in figure.axes if "block and guide" in ax.get_title(loc="left"))
    notes = [text.get_text() for text in force.texts]
    assert any(f"peak {newton(found.results['compliant'].contacts['guide'].peak)}" in one for one in notes)
    panels = [ax for ax in figure.axes if "block in its guide" in ax.get_title()]
    assert panels
    edge = figure.bbox.width
    clearance = 1e3 * found.results["one-sided impact"].geometry["joints"]["guide"]["clearance"]
    for ax in panels:
        assert not [patch for patch in ax.patches if isinstance(patch, Circle)]
        (walls,) = [patch for patch in ax.patches if isinstance(patch, Polygon)]
        assert np.ptp(walls.get_xy()[:, 1]) == pytest.approx(2 * clearance)  # [mm], the guide lies flat
        box = ax.title.get_window_extent()
        assert box.x0 >= 0.0
        assert box.x1 <= edge


@pytest.mark.nojit
@pytest.mark.skipif(os.name != "posix", reason="stands in for ffmpeg with a shell script")
def test_an_mp4_hands_every_frame_to_ffmpeg(tmp_path, monkeypatch):
    ffmpeg = tmp_path / "ffmpeg"
    ffmpeg.write_text('#!/bin/sh\nfor last; do :; done\necho "$@" > "${0%/*}/words"\ncat > "$last"\n')
    ffmpeg.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    film = tmp_path / "film.mp4"
    circling(41).animate(film, frames=4, fps=10)
    words = (tmp_path / "words").read_text().split()
    width, height = map(int, words[words.index("-s") + 1].split("x"))
    assert words[words.index("-framerate" if "-framerate" in words else "-r") + 1] == "10"
    frames = np.fromfile(film, np.uint8).reshape(-1, height, width, 4)
    assert len(frames) == 4
    assert len({frame.tobytes() for frame in frames}) == 4  # the pin moves on from one to the next
