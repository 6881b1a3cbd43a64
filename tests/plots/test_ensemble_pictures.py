"""Pictures of ensembles and sweeps show the samples: all of them, in units, and what is left out is said."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.collections import PolyCollection, QuadMesh
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from scipy.stats import spearmanr

import rattle as rt
from rattle.plots.bulk import bulk_of
from rattle.plots.curves import BLACK, BLUE, GREY, ORANGE, RED, SKY, new_axes
from rattle.questions.ensemble.pieces import FAILED, OK, Piece
from rattle.questions.ensemble.shares import draw_shares
from rattle.questions.ensemble.store import Memory
from rattle.results.result import UnknownName

pytestmark = pytest.mark.nojit
T = 0.3
OF, FORCE = "final(block.x)", "m*at(block.ax, 0.1)"
SPRING = """
format = 1
[parameters]
k = { value = 15, tol = 4 }
x0 = { value = "0.04 m", tol = "5 mm" }
m = { value = "1 kg", tol = "0.2 kg" }
[ground.points]
O = [0, 0]
[bodies.block]
points = { P = [0, 0] }
mass = "m"
inertia = 1
[joints.guide]
type = "prismatic"
connect = ["ground.O", "block.P"]
[loads.s]
type = "spring"
connect = ["ground.O", "block.P"]
stiffness = "k"
free_length = 0
[initial]
block = { x = "x0", vx = 0 }
"""


def spring():
    return rt.loads(SPRING)


@pytest.fixture(scope="module")
def ran():
    return spring().ensemble(96, [OF, FORCE], t_end=T, seed=2)


def filled(e, *columns, failed=()):
    """The ensemble with other outputs (n,); samples `failed` have none."""
    values, status = np.array(columns, dtype=float), np.full(len(e), OK, dtype=np.int8)
    status[list(failed)], values[:, list(failed)] = FAILED, np.nan
    store = Memory(e.parameters, e.outputs, len(e))
    messages = dict.fromkeys(map(int, failed), "the loop cannot be closed")
    store.add(Piece(0, e.plan.values(0, len(e)), values, status, messages, np.zeros(len(e), dtype=bool)))
    return replace(e, store=store)


@pytest.fixture(scope="module")
def many():
    return spring().ensemble(1, [OF, FORCE], t_end=T)


def sized(e, n):
    """An ensemble of n samples without outputs."""
    from rattle.questions.ensemble.plans import Drawn
    from rattle.questions.ensemble.sampling import points

    return replace(e, plan=Drawn(e.fields, points("sobol", 0, e.fields.draws, n)))


def bars(ax):
    return np.array([p.get_height() for p in ax.patches if to_hex(p.get_facecolor()) == SKY.lower()])


def said(ax):
    return "\n".join(text.get_text() for text in ax.texts)


def legend(ax):
    return [text.get_text() for text in ax.get_legend().get_texts()]


def lines(ax, colour):
    """Places of the upright lines of a colour."""
    return [
        float(one.get_xdata()[0]) for one in ax.lines if to_hex(one.get_color()) == colour.lower() and one.get_visible()
    ]


# ---------------------------------------------------------------- histograms
def test_a_histogram_holds_all_samples_and_marks_quantiles_nominal_and_limit(ran):
    limit = float(np.quantile(ran[OF], 0.8))
    ax = ran.plot(OF, limit=limit).axes[0]
    assert bars(ax).sum() == 96
    assert ax.get_title(loc="left") == OF
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("length [mm]", "number of samples")
    quantiles = [1e3 * one.value for one in ran.statistics(OF).quantiles.values()]
    assert lines(ax, BLACK) == pytest.approx(quantiles)
    assert lines(ax, ORANGE) == pytest.approx([1e3 * ran.nominal[0]])
    assert lines(ax, RED) == pytest.approx([1e3 * limit])
    share = ran.yield_below(OF, limit)
    texts = [f"{100 * one:.1f} %" for one in share]
    assert legend(ax)[-1] == f"limit {1e3 * limit:.5g} mm:\n{texts[0]} within ({texts[1]} to {texts[2]})"
    assert said(ax) == "96 samples of k, x0, m"


def test_what_is_beyond_two_limits_is_shaded(ran):
    low, high = (float(one) for one in np.quantile(ran[OF], [0.1, 0.9]))
    ax = ran.plot(OF, limit=(low, f"{1e3 * high!r} mm")).axes[0]
    assert lines(ax, RED) == pytest.approx([1e3 * low, 1e3 * high])
    spans = [one.get_extents().transformed(ax.transData.inverted()) for one in ax.patches]
    shaded = sorted((one.x0, one.x1) for one, p in zip(spans, ax.patches, strict=True) if p.get_alpha() == 0.08)
    left, right = ax.get_xlim()
    assert np.ravel(shaded) == pytest.approx([left, 1e3 * low, 1e3 * high, right])
    with pytest.raises(ValueError, match="the lower one, 2, is not below the upper one, 1"):
        ran.plot(OF, limit=(2, 1))
    with pytest.raises(ValueError, match="expected a length"):
        ran.plot(OF, limit="3 kg")


def test_a_few_values_far_away_do_not_flatten_the_rest_and_are_counted(ran):
    values = ran[OF].copy()
    values[[3, 50]], values[70] = 4.0, -7.0
    ax = filled(ran, values, ran[FORCE]).plot(OF).axes[0]
    assert bars(ax).sum() == 93
    rest = 1e3 * np.delete(ran[OF], [3, 50, 70])
    assert ax.get_xlim()[0] == pytest.approx(rest.min(), abs=0.1 * np.ptp(rest))
    assert ax.get_xlim()[1] == pytest.approx(rest.max(), abs=0.1 * np.ptp(rest))
    assert "not shown: 1 below" in said(ax)
    assert "down to −7000; 2 above" in said(ax)
    assert "up to 4000 mm" in said(ax)


def test_a_mark_outside_is_in_the_legend_with_its_side(ran):
    ax = ran.plot(OF, limit="5 m").axes[0]
    assert lines(ax, RED) == []
    assert legend(ax)[-1].startswith("limit 5 m:\n100.0 % within")
    assert legend(ax)[-1].endswith("(further right)")


def test_values_over_decades_have_a_logarithmic_axis_and_even_bins_there(ran):
    rng = np.random.default_rng(0)
    ax = filled(ran, ran[OF], 10.0 ** rng.uniform(2, 5, 96)).plot(FORCE).axes[0]
    assert ax.get_xscale() == "log"
    assert bars(ax).sum() == 96
    edges = np.array([p.get_x() for p in ax.patches if to_hex(p.get_facecolor()) == SKY.lower()])
    assert np.ptp(np.diff(np.log(edges))) < 1e-9
    assert filled(ran, ran[OF], rng.uniform(0, 5, 96)).plot(FORCE).axes[0].get_xscale() == "linear"


def test_whole_numbers_have_a_bin_each(ran):
    counts = np.repeat([0.0, 1.0, 2.0, 5.0], [40, 30, 20, 6])
    task = replace(ran.task, outputs=tuple(replace(one, unit="") for one in ran.task.outputs))
    ax = replace(filled(ran, counts, counts), task=task).plot(OF).axes[0]
    found = [p for p in ax.patches if to_hex(p.get_facecolor()) == SKY.lower()]
    assert [(p.get_x() + p.get_width() / 2, p.get_height()) for p in found] == [
        (0, 40), (1, 30), (2, 20), (3, 0), (4, 0), (5, 6)
    ]  # fmt: skip


@pytest.mark.parametrize("n", [1, 2, 50])
def test_equal_values_are_one_bar(many, n):
    e = filled(sized(many, n), np.full(n, 0.02), np.full(n, 5e3))
    ax = e.plot(FORCE, limit=6e3).axes[0]
    assert bars(ax).tolist() == [n]
    assert ax.get_xlim()[0] < 4900 < 5100 < ax.get_xlim()[1]
    assert lines(ax, RED) == [6000.0]


def test_samples_without_a_value_are_counted_and_nothing_but_them_is_refused(ran):
    e = filled(ran, ran[OF], ran[FORCE], failed=range(10))
    ax = e.plot(OF).axes[0]
    assert bars(ax).sum() == 86
    assert said(ax) == "96 samples of k, x0, m, 10 failed"
    none = filled(ran, ran[OF], ran[FORCE], failed=range(96))
    for draw in (none.plot, lambda output: none.plot_scatter([output])):
        with pytest.raises(ValueError, match=r"none of 96 samples has a finite value.*the loop cannot be closed"):
            draw(OF)
    with pytest.raises(UnknownName):
        ran.plot("final(block.y)")


def test_given_axes_are_drawn_on_and_returned(ran, tmp_path):
    figure = Figure(figsize=(10, 8))
    first, second, third, fourth = figure.subplots(2, 2).flat
    assert ran.plot(OF, ax=first) is first
    assert ran.plot_contributions(OF, ax=second) is second
    assert ran.plot_band("block.x", members=2, ax=third) is third
    w = spring().sweep({"k": [10, 15], "x0": [0.03, 0.04]}, [OF], t_end=T)
    assert w.plot(OF, ax=fourth) is fourth
    for name in ("a.svg", "a.png", "a.pdf"):
        figure.savefig(tmp_path / name)
    assert len(figure.axes) == 5  # with the colour bar


# ---------------------------------------------------------------- scatter
def test_a_scatter_matrix_has_outputs_over_parameters_with_their_rank_correlations(ran):
    figure = ran.plot_scatter()
    grid = np.reshape(figure.axes, (2, 3))
    assert [ax.get_xlabel() for ax in grid[-1]] == ["k", "x0 [mm]", "m [kg]"]
    assert [ax.get_ylabel() for ax in grid[:, 0]] == [f"{OF} [mm]", FORCE + " [N]"]
    for n, output in enumerate(ran.outputs):
        for k, parameter in enumerate(ran.parameters):
            value = spearmanr(ran[parameter], ran[output]).statistic
            shown = grid[n, k].get_title(loc="right").replace("−", "-")
            assert float(shown.removeprefix("ρ = ")) == pytest.approx(value, abs=0.0051)
            (dots,) = grid[n, k].lines
            assert len(dots.get_xdata()) == 96
    x, y = grid[0, 1].lines[0].get_data()
    np.testing.assert_allclose(x, 1e3 * ran["x0"])
    np.testing.assert_allclose(y, 1e3 * ran[OF])


def test_failed_samples_and_far_ones_are_marked_at_the_edge(ran):
    values = ran[OF].copy()
    values[5] = 1e9
    ax = filled(ran, values, ran[FORCE], failed=(1, 2, 3)).plot_scatter([OF], ["k"]).axes[0]
    dots, far, failed = ax.lines
    assert [len(one.get_xdata()) for one in (dots, far, failed)] == [92, 1, 3]
    np.testing.assert_allclose(failed.get_xdata(), ran["k"][1:4])
    assert far.get_xdata() == ran["k"][5]
    assert ax.get_ylim()[1] < 100
    assert "1 above" in ax.figure.get_suptitle()
    assert "3 failed" in ax.figure.get_suptitle()


def test_thousands_of_points_become_cells_that_hold_all_of_them(many):
    e = sized(many, 6000)
    e = filled(e, e.plan.values(0, 6000)[0] ** 2, 10.0 ** e.plan.values(0, 6000)[2] * 3)
    for ax in filled(e, e[OF], e[FORCE], failed=range(500)).plot_scatter(parameters=["k"]).axes:
        (cells,) = (one for one in ax.collections if isinstance(one, PolyCollection))
        assert cells.get_array().sum() == 5500
        assert cells.get_rasterized()


def test_a_scatter_matrix_stays_readable(many, ran):
    wide = rt.loads(
        SPRING.replace("m = {", "\n".join(f"p{n} = {{ value = 1, tol = 0.1 }}" for n in range(5)) + "\nm = {")
    )
    e = wide.ensemble(16, [OF], t_end=T)
    assert len(e.parameters) == 8
    figure = e.plot_scatter()
    assert len(figure.axes) == 6
    names = [ax.get_xlabel().partition(" ")[0] for ax in figure.axes]
    assert {"k", "x0"} <= set(names)  # with the closest relations
    assert "6 parameters with the closest relations" in figure.get_suptitle()
    with pytest.raises(ValueError, match="8 are asked for; a scatter matrix shows 1 to 6"):
        e.plot_scatter(parameters=list(e.parameters))
    with pytest.raises(ValueError, match="parameters: 'q' is none of k, x0, m"):
        ran.plot_scatter(parameters=["q"])


# ---------------------------------------------------------------- bands
def test_a_band_is_that_of_the_curves_of_its_members(ran):
    ax = ran.plot_band("block.x", members=8).axes[0]
    t = np.linspace(0.0, T, 201)
    k, x0, m = (ran[name][:8, None] for name in ("k", "x0", "m"))
    exact = 1e3 * x0 * np.cos(np.sqrt(k / m) * t)
    wide, half = ax.collections
    for area, low, high in ((wide, 0.05, 0.95), (half, 0.25, 0.75)):
        y = area.get_paths()[0].vertices[:, 1]
        ends = np.quantile(exact, [low, high], axis=0)
        assert (y.min(), y.max()) == pytest.approx((ends.min(), ends.max()), abs=1e-4)
    single = [one for one in ax.lines if to_hex(one.get_color()) == GREY]
    np.testing.assert_allclose([one.get_ydata() for one in single], exact[:5], atol=1e-4)
    (median,) = (one for one in ax.lines if to_hex(one.get_color()) == BLUE.lower())
    np.testing.assert_allclose(median.get_ydata(), np.median(exact, axis=0), atol=1e-4)
    (nominal,) = (one for one in ax.lines if to_hex(one.get_color()) == ORANGE.lower())
    np.testing.assert_allclose(nominal.get_ydata(), 40 * np.cos(np.sqrt(15) * t), atol=1e-4)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("time [s]", "length [mm]")
    assert ax.get_title(loc="left") == "block.x, 8 members"
    assert said(ax) == "the first 8 of 96 samples of k, x0, m"


def test_a_narrow_band_is_drawn_a_second_time_as_deviations(ran):
    narrow = spring().ensemble(16, [OF], {"x0": "0.1 mm"}, t_end=1.0)
    _, below = narrow.plot_band("block.x", members=4).axes
    assert below.get_ylabel() == "deviation from the nominal [mm]"
    (median,) = (one for one in below.lines if to_hex(one.get_color()) == BLUE.lower())
    shift = 1e3 * (np.median(narrow["x0"][:4]) - 0.04)
    t = np.linspace(0.0, 1.0, 201)
    np.testing.assert_allclose(median.get_ydata(), shift * np.cos(np.sqrt(15) * t), atol=1e-5)
    assert len(ran.plot_band("block.x", members=4).axes) == 1


def test_failed_members_are_left_out_and_told(ran):
    ax = filled(ran, ran[OF], ran[FORCE], failed=(0, 2)).plot_band("block.x", members=3).axes[0]
    assert ax.get_title(loc="left") == "block.x, 1 member"
    assert "the first 3 of 96 samples of k, x0, m, 2 of them failed" in said(ax)
    with pytest.raises(ValueError, match="none of 2 members could be run: the loop cannot be closed"):
        filled(ran, ran[OF], ran[FORCE], failed=range(96)).plot_band("block.x", members=2)
    with pytest.raises(UnknownName, match="no curve"):
        ran.plot_band("blok.x", members=2)
    rest = spring().ensemble(2, [OF], analysis="equilibrium")
    with pytest.raises(ValueError, match="give it a t_end"):
        rest.plot_band("block.x")


# ---------------------------------------------------------------- contributions
def test_bars_are_the_contributions_the_greatest_on_top(ran):
    found = ran.contributions(OF)
    ax = ran.plot_contributions(OF).axes[0]
    order = np.argsort([-one.value for one in found.indices])
    assert [p.get_width() for p in ax.patches] == pytest.approx([100 * found.indices[n].value for n in order])
    assert [one.get_text() for one in ax.get_yticklabels()] == [found.names[n] for n in order]
    assert ax.get_ylim()[0] > ax.get_ylim()[1]
    assert "share of the variance" in ax.get_xlabel()
    assert f"together {100 * found.explained.value:.1f} %" in said(ax)


def test_a_variance_of_few_outliers_is_shared_by_ranks_and_said(ran):
    values = ran[OF].copy()
    values[5] = 1e9
    ax = filled(ran, values, ran[FORCE]).plot_contributions(OF).axes[0]
    assert "variance of its ranks" in ax.get_xlabel()
    assert "outliers" in said(ax)


def test_totals_stand_behind_and_sort_the_bars():
    ax = new_axes(6, 3)[0]
    nan = (float("nan"),) * 3
    draw_shares(ax, ["a", "b", "c"], [(0.5, 0.4, 0.6), (0.1, 0.0, 0.2), nan], [(0.6, 0.5, 0.7), (0.8, 0.7, 0.9), nan])
    assert [one.get_text() for one in ax.get_yticklabels()] == ["b", "a", "c"]
    behind, front = ax.containers[0], ax.containers[2]
    assert [p.get_width() for p in behind][:2] == pytest.approx([80, 60])
    assert [p.get_width() for p in front][:2] == pytest.approx([10, 50])
    assert [one.get_text() for one in ax.texts] == [
        "10 % (0 to 20); 80 % (70 to 90)", "50 % (40 to 60); 60 % (50 to 70)", "-; -",
    ]  # fmt: skip


# ---------------------------------------------------------------- sweeps
def test_a_sweep_of_one_parameter_is_a_curve_in_its_order():
    w = spring().sweep({"x0": [0.04, 0.01, 0.03]}, [OF], t_end=T)
    ax = w.plot(OF).axes[0]
    (line,) = ax.lines
    np.testing.assert_allclose(line.get_xdata(), [10, 30, 40])
    np.testing.assert_allclose(line.get_ydata(), [1e3 * w[OF][n] for n in (1, 2, 0)])
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("x0 [mm]", "length [mm]")
    one = spring().sweep({"x0": [0.04], "k": [15]}, [OF], t_end=T).plot(OF).axes[0]
    assert said(one) == "x0 = 40 mm, 1 run"


def test_a_map_has_every_value_at_its_place_and_hatches_what_failed():
    w = spring().sweep({"k": [20.0, 10.0, 15.0], "x0": [0.03, 0.035, 0.04, 0.045]}, [OF], t_end=T)
    values = w[OF].copy()
    values[1] = np.nan
    store = Memory(w.parameters, w.outputs, len(w))
    status = np.where(np.isnan(values), FAILED, OK).astype(np.int8)
    store.add(Piece(0, w.plan.values(0, 12), values[None], status, {1: "no"}, np.zeros(12, dtype=bool)))
    figure = replace(w, store=store).plot(OF)
    ax, bar = figure.axes
    (cells,) = (one for one in ax.collections if isinstance(one, QuadMesh))
    shown = np.ma.filled(np.ma.reshape(cells.get_array(), (4, 3)), np.nan)
    np.testing.assert_allclose(shown, 1e3 * np.reshape(values, (3, 4))[[1, 2, 0]].T)
    assert (ax.get_xlabel(), ax.get_ylabel(), bar.get_ylabel()) == ("k", "x0 [mm]", "length [mm]")
    (hatched,) = (one for one in ax.collections if one.get_hatch())
    (box,) = hatched.get_paths()
    x, y = box.vertices[:-1].mean(axis=0)
    assert (x, y) == pytest.approx((20.0, 35.0))
    assert said(ax) == "12 runs, 1 without a value (grey)"


def test_without_a_name_all_outputs_are_drawn():
    w = spring().sweep({"k": [10.0, 15.0]}, [OF, FORCE], t_end=T)
    assert [ax.get_title(loc="left") for ax in w.plot().axes] == [OF, FORCE]
    with pytest.raises(ValueError, match="one axis shows one output; name one of"):
        w.plot(ax=new_axes(4, 3)[0])


def test_further_parameters_are_fixed_or_named():
    w = spring().sweep({"k": [10.0, 15.0], "x0": [0.03, 0.04], "m": [0.9, 1.0, 1.1]}, [OF], t_end=T)
    with pytest.raises(ValueError, match=r"varies with k, x0, m.*at=\{'m': 1.0\}"):
        w.plot(OF)
    ax = w.plot(OF, at={"m": "0.9 kg", "k": 15}).axes[0]
    np.testing.assert_allclose(ax.lines[0].get_ydata(), 1e3 * w.grid(OF)[1, :, 0])
    assert said(ax) == "k = 15, m = 0.9 kg, 2 runs"
    with pytest.raises(ValueError, match=r"m = 0.95 is not in the sweep; the nearest: 0.9, 1"):
        w.plot(OF, at={"m": 0.95})
    with pytest.raises(ValueError, match="'q' is none of k, x0, m"):
        w.plot(OF, at={"q": 1})


# ---------------------------------------------------------------- range
def test_the_bulk_holds_all_that_does_not_flatten_it():
    even = np.linspace(1.0, 2.0, 100)
    assert bulk_of(even, "N")[:2] == (1.0, 2.0)
    assert bulk_of(np.append(even, 2.9), "N").above == 0
    assert bulk_of(np.append(even, [50.0, -40.0]), "N")[5:9] == (1, 1, -40.0, 50.0)
    mostly = bulk_of(np.append(np.zeros(1000), 7.0), "N")
    assert (mostly.low, mostly.high, mostly.above) == (0.0, 0.0, 1)
