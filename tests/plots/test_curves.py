"""Pictures: units on every axis, the horizon shaded, N < 0 marked where it is and nowhere else."""

import numpy as np
import pytest
from matplotlib.collections import LineCollection
from matplotlib.colors import to_hex
from PIL import Image

import rattle as rt
from circling import OMEGA, STEADY, SWING, T_END, C, circling
from rattle.drawings.magnified import BUSH, PIN
from rattle.plots.animation import scene
from rattle.plots.curves import AFTER, RED, new_axes, robust_limits, save_figure
from rattle.plots.paper_page import paper_page

nojit = pytest.mark.nojit


def texts(figure):
    return [text.get_text() for ax in figure.axes for text in ax.texts]


def shaded(ax):
    return [patch.get_extents().transformed(ax.transData.inverted()) for patch in ax.patches]


# ---------------------------------------------------------------- curves
@nojit
def test_one_panel_per_unit_each_with_its_unit():
    figure = circling().plot("O.normal", "arm.x", "O.fx", "arm.angle", "lift")
    assert [ax.get_ylabel() for ax in figure.axes] == ["force [N]", "length [m]", "angle [deg]", "no unit"]
    assert [len(ax.get_legend().get_texts()) for ax in figure.axes] == [2, 1, 1, 1]
    assert figure.axes[-1].get_xlabel() == "time [s]"


@nojit
def test_legend_does_not_cover_the_curves():
    figure = circling().plot("O.normal", "O.fx")
    figure.canvas.draw()
    ax = figure.axes[0]
    box = ax.get_legend().get_window_extent()
    assert not box.overlaps(ax.get_window_extent())
    assert box.x1 <= figure.bbox.x1


@nojit
def test_what_lies_after_the_horizon_is_shaded_and_labelled():
    figure = circling(horizon=0.15).plot("O.normal", "arm.x")
    for ax in figure.axes:
        (span,) = shaded(ax)
        assert (span.x0, span.x1) == pytest.approx((0.15, T_END))
    assert texts(figure) == [AFTER]


@nojit
@pytest.mark.parametrize("horizon", [None, T_END])
def test_nothing_is_shaded_without_a_horizon_or_after_the_whole_run(horizon):
    figure = circling(horizon=horizon).plot("O.normal")
    assert shaded(figure.axes[0]) == []
    assert texts(figure) == []


@nojit
def test_compared_results_are_dashed_and_named():
    figure = circling().plot("O.normal", compare=[("coarse", circling(11))])
    ours, theirs = figure.axes[0].lines[:2]
    assert (ours.get_linestyle(), theirs.get_linestyle()) == ("-", "--")
    assert theirs.get_label() == "O.normal, coarse"
    assert len(theirs.get_xdata()) == 11


@nojit
def test_plot_draws_into_a_given_axis_if_one_unit_is_asked():
    ax = new_axes(4, 3)[0]
    assert circling().plot("O.fx", "O.fy", ax=ax) is ax
    with pytest.raises(ValueError, match="one axis shows one unit"):
        circling().plot("O.fx", "arm.x", ax=ax)
    with pytest.raises(ValueError, match="name at least one curve"):
        circling().plot()
    with pytest.raises(KeyError, match="did you mean"):
        circling().plot("O.norm")


@nojit
def test_a_rare_spike_does_not_flatten_the_curve():
    curve = np.sin(np.linspace(0, 20, 2001))
    ax = new_axes(4, 3)[0]
    assert not robust_limits(ax, [curve])
    curve[1000] = 1e4
    ax.plot(curve)
    assert robust_limits(ax, [curve])
    assert 1 < ax.get_ylim()[1] < 2
    assert "10000" in ax.texts[0].get_text()


# ---------------------------------------------------------------- orbits
@nojit
def test_orbit_marks_pulling_where_it_happens_and_nowhere_else():
    figure = circling(4001).plot_orbit("O")
    lines = [c for c in figure.axes[0].collections if isinstance(c, LineCollection)]
    (ticks,) = [c for c in lines if to_hex(c.get_color()[0]) == RED.lower()]
    ends = np.array(ticks.get_segments())
    direction = np.arctan2(ends[..., 1], ends[..., 0])
    assert np.cos(direction).max() < -STEADY / SWING + 1e-3  # N = STEADY + SWING cos a < 0
    assert np.cos(direction).min() == pytest.approx(-1, abs=1e-6)
    assert np.hypot(*ends.T).min() > 1e3 * C  # outside the clearance circle, in mm


@nojit
def test_orbit_of_a_massless_link_stays_on_the_circle_between_instants():
    figure = circling(21).plot_orbit("O")
    path = next(c for c in figure.axes[0].collections if c.get_array() is not None)
    points = np.vstack(path.get_segments())
    assert np.hypot(*points.T) == pytest.approx(1e3 * C, rel=1e-12)
    assert len(points) > 4 * 21


@nojit
@pytest.mark.parametrize(("clearance", "unit"), [(5e-3, "mm"), (2e-5, "µm")])
def test_orbit_is_in_a_handy_unit_with_equal_axes(clearance, unit):
    ax = circling(clearance=clearance).plot_orbit("O").axes[0]
    assert f"[{unit}]" in ax.get_xlabel()
    assert f"[{unit}]" in ax.get_ylabel()
    assert ax.get_aspect() == 1
    assert ax.get_xlim() == ax.get_ylim()


@nojit
def test_orbit_of_something_without_play_says_who_has_it():
    with pytest.raises(ValueError, match=r"no orbit of 'arm': orbits are drawn for pins .* in a bush; here: O$"):
        circling().plot_orbit("arm")


# ---------------------------------------------------------------- files
@nojit
@pytest.mark.parametrize(("suffix", "magic"), [(".png", b"\x89PNG"), (".pdf", b"%PDF"), (".svg", b"<?xml")])
def test_pictures_are_what_their_suffix_says(tmp_path, suffix, magic):
    file = tmp_path / f"p{suffix}"
    save_figure(circling().plot("O.normal"), file)
    assert file.read_bytes().startswith(magic)
    assert list(tmp_path.iterdir()) == [file]


@nojit
def test_other_suffixes_are_refused_before_anything_is_drawn(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))  # no ffmpeg here
    r = circling()
    with pytest.raises(ValueError, match=r"ending in \.svg, \.png, \.pdf"):
        save_figure(r.plot("O.normal"), tmp_path / "p.bmp")
    with pytest.raises(ValueError, match=r"fps, power: only \.gif and \.mp4 have this"):
        r.animate(tmp_path / "a.html", fps=30, power=True)
    with pytest.raises(ValueError, match=r"ending in \.gif or \.mp4"):
        r.animate(tmp_path / "a.avi")
    with pytest.raises(RuntimeError, match="needs the program ffmpeg"):
        r.animate(tmp_path / "a.mp4")
    assert list(tmp_path.iterdir()) == []


# ---------------------------------------------------------------- moving
@nojit
def test_gif_shows_as_many_frames_as_asked_at_their_pace(tmp_path):
    circling().animate(tmp_path / "a.gif", frames=5, fps=10)
    with Image.open(tmp_path / "a.gif") as film:
        assert film.n_frames == 5
        assert film.info["duration"] == 100
        assert film.convert("RGB").getpixel((2, 2)) == (255, 255, 255)


@nojit
def test_frames_are_even_in_time_and_show_the_pin_where_it_is():
    figure, update, count = scene(circling(horizon=0.16), frames=9)
    ax, inset = figure.axes[1], figure.axes[0]
    pins = [line for line in inset.lines if line.get_marker() == "o"]  # the pin as it is pushed, and as it is pulled
    assert count == 9
    for k in range(count):
        update(k)
        t = k * T_END / 8
        assert ax.get_title(loc="left").startswith(f"t = {t:.4f} s")
        assert (AFTER in ax.get_title(loc="left")) == (t > 0.16)
        (pin,) = [line for line in pins if np.isfinite(line.get_xdata()).all()]
        where = (1.0 - PIN) * BUSH * np.array([np.cos(OMEGA * t), np.sin(OMEGA * t)])  # the play is magnified so
        assert np.ravel(pin.get_data()) == pytest.approx(where, abs=1e-9)
        assert (to_hex(pin.get_color()) == RED.lower()) == (STEADY + SWING * np.cos(OMEGA * t) < 0)


@nojit
def test_nothing_leaves_the_picture():
    r = circling()
    figure, update, count = scene(r, frames=9)
    ax = figure.axes[1]
    limits = ax.get_xlim(), ax.get_ylim()
    for k in range(count):
        update(k)
    assert (ax.get_xlim(), ax.get_ylim()) == limits
    for x, y in ((r[f"arm.{p}.x"], r[f"arm.{p}.y"]) for p in "OP"):
        assert limits[0][0] < x.min() < x.max() < limits[0][1]
        assert limits[1][0] < y.min() < y.max() < limits[1][1]


# ---------------------------------------------------------------- the paper's page
def test_paper_page_shows_the_papers_ten_figures_with_its_signs():
    m = rt.example("fourbar")
    figure = paper_page(m.simulate(0.02), m.ideal().simulate(0.02))
    assert [ax.get_title(loc="left").split("  ")[0] for ax in figure.axes] == [f"Figure {k}" for k in range(3, 13)]
    start = {ax.get_ylabel(): ax.lines[0].get_ydata()[0] for ax in figure.axes}
    # independent reference for the paper's data, alpha = 60 deg, M = 40 N m, no gravity
    forces = [start[f"{symbol} [N]"] for symbol in ("H₂", "V₂", "N₃", "N₄")]
    assert forces == pytest.approx([-16.913254230, 191.806895396, 275.306033837, -212.474678096], rel=1e-8)
    assert [start[f"{symbol} [deg]"] for symbol in ("θ₂", "θ₃")] == pytest.approx([60, -60], abs=1e-9)


def test_the_largest_force_stands_beside_its_bar_and_over_nothing():
    figure = circling(4001).plot_orbit("O")
    ax, bar = figure.axes
    figure.canvas.draw()
    assert bar.get_title() == ""
    assert ", up to " in bar.get_ylabel()
    inside, label = ax.get_window_extent(), bar.yaxis.label.get_window_extent()
    assert label.x0 > bar.get_window_extent().x1 > inside.x1
    assert label.y1 < figure.bbox.y1
    ticks = [tick.get_window_extent() for tick in bar.get_yticklabels() if tick.get_text()]
    assert all(tick.x1 <= label.x0 for tick in ticks)
