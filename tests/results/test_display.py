"""Objects say what they are: short and true in a line, as a table in a notebook, pictures without a display backend."""

import html
import re
from dataclasses import replace

import numpy as np
import pytest

import rattle as rt
from rattle.results.display import Picture, grid, printed, quantity


@pytest.fixture(scope="module")
def fourbar():
    return rt.example("fourbar")


@pytest.fixture(scope="module")
def run(fourbar):
    return fourbar.simulate("10 ms")


def cells(text):
    return [html.unescape(cell) for cell in re.findall(r"<td[^>]*>(.*?)</td>", text)]


@pytest.mark.nojit
def test_a_mechanism_says_what_it_holds(fourbar):
    assert repr(fourbar) == str(fourbar)
    assert "3 bodies, 4 joints, 1 driver, 1 load" in repr(fourbar)
    shown = cells(fourbar._repr_html_())
    assert {"O3", "revolute", "coupler - rocker", "5 mm", "massless-link"} <= set(shown)


@pytest.mark.nojit
def test_an_unfinished_mechanism_shows_what_is_missing():
    m = rt.Mechanism("half")
    m.bar("a", "A", "B", length=1, mass=1)
    m.revolute("J", "ground.X", "a.A")
    assert "1 body, 1 joint" in repr(m)
    assert any("X" in cell for cell in cells(m._repr_html_()))


@pytest.mark.nojit
def test_names_are_text_in_a_table():
    m = rt.loads(
        'format = 1\nname = "<script>x</script>"\n[bodies.b]\nmass = 1\ninertia = 1\npoints = { P = [0, 0] }\n'
    )
    assert "<script>" not in m._repr_html_()


def test_results_and_reports_show_themselves(fourbar, run):
    assert len(repr(run)) < 120
    assert "11 instants" in repr(run)
    assert "O3" in run._repr_html_()
    assert run._ipython_key_completions_() == list(run.names)
    for one in (
        fourbar.check(),
        run.trust,
        fourbar.compare(t_end="5 ms"),
        fourbar.accuracy("rocker.angle", [0.0, 0.1]),
    ):
        assert repr(one).startswith("<rattle.")
        assert "array(" not in repr(one)
        assert "\n" not in repr(one)
        assert len(one._repr_html_()) > 50


def test_positions_of_rest_show_their_angles():
    found = rt.example("balanced_arm").equilibrium()
    angle = np.rad2deg(found[0]["arm.angle"])
    assert f"arm.angle {angle:.4g} deg" in repr(found[0])
    assert repr(found).count("rattle.Equilibrium") == len(found)
    assert f"{angle:.6g} deg" in cells(found[0]._repr_html_())
    modes = rt.example("balanced_arm").modes()
    assert f"{modes.frequency[0]:.4g} Hz" in repr(modes)
    assert f"{modes.frequency[0]:.6g} Hz" in cells(modes._repr_html_())


def test_a_figure_is_a_picture_without_any_backend(run):
    assert run.plot("rocker.angle")._repr_png_()[:4] == b"\x89PNG"


@pytest.mark.nojit
def test_a_film_shows_itself_and_a_missing_one_says_where_it_should_be(tmp_path):
    there = tmp_path / "a.gif"
    there.write_bytes(b"GIF89a")
    assert 'src="data:image/gif;base64,' in Picture(there)._repr_html_()
    assert "b.gif" in Picture(tmp_path / "b.gif")._repr_html_()


def test_times_are_texts_or_numbers(fourbar, run):
    assert run.t[-1] == fourbar.simulate(0.01).t[-1] == 0.01
    assert fourbar.simulate("10 ms", t_eval=["1 ms", 0.01]).t.tolist() == [0.001, 0.01]
    path = rt.example("path_generator").ideal()
    assert path.kinematics("20 ms")["crank.angle"] == path.kinematics(0.02)["crank.angle"]
    with pytest.raises(ValueError, match="'1 kg' is a mass; expected a time"):
        fourbar.simulate("1 kg")
    with pytest.raises(TypeError, match="t_end is a time"):
        fourbar.simulate([1, 2])


def test_a_curve_is_asked_for_by_one_name(run):
    with pytest.raises(TypeError, match="one name"):
        run["a", "b"]


def test_what_studies_find_are_cards_of_one_look(fourbar):
    shown = {
        "samples": fourbar.many({"l2": [0.6, 0.61]}, ["max(O3.force)"], "2 ms"),
        "film": rt.Film("50 mPa*s", length="10 mm", radius="10 mm", clearance="50 um"),
        "balance": fourbar.simulate("2 ms").power(),
        "equilibria": rt.example("balanced_arm").equilibrium(),
    }
    for words, one in shown.items():
        text = one._repr_html_()
        assert text.startswith('<div class="rattle-card">')
        assert words in text
        assert "next: <code>" in text
    assert "50 mPa·s" in shown["film"]._repr_html_()
    assert "50 µm" in shown["film"]._repr_html_()


@pytest.mark.nojit
def test_units_are_printed_after_numbers_only():
    assert printed("4 N*m, 9.81 m/s^2, 3 um, +-2 N") == "4 N·m, 9.81 m/s², 3 µm, ±2 N"
    assert printed("max(2*x) um m*g l1*sin(a)") == "max(2*x) um m*g l1*sin(a)"
    assert '<td class="number">4 N·m</td>' in grid(("a", "b"), [("x", "4 N*m")])


def test_trust_says_what_holds_and_what_does_not(run):
    assert [one.partition(":")[0] for one in run.trust.holds()] == ["the equations were solved well"]
    doubts = run.trust.doubts()
    assert doubts[0].startswith("how long the curves can be trusted was not computed")
    assert "would have to pull" in doubts[1]
    loose = replace(run.trust, drift=1e-5, pulled={}, horizon=0.01)
    assert loose.holds(size=1.0) == ("the curves can be trusted over the whole run, to t = 0.01 s",)
    assert "solved loosely" in loose.doubts(size=1.0)[0]
    assert loose.doubts(size=100.0) == ()


@pytest.mark.nojit
def test_numbers_are_written_as_people_read_them():
    assert quantity(np.pi / 6, "rad") == "30 deg"
    assert quantity(-5e-16, "rad") == "0 deg"
    assert quantity(5e-4, "m") == "0.5 mm"
    assert quantity(2.0, "m") == "2 m"
    assert quantity(3.0, "") == "3"


def test_modes_draw_the_first_without_being_told():
    assert rt.example("balanced_arm").modes().plot().axes


def test_a_dataset_says_what_was_run_and_how_far_to_trust_it(run):
    attributes = run.to_xarray().attrs
    assert attributes["trust"] == str(run.trust)
    assert attributes["method"] == "dop853"


def test_a_result_is_a_table_in_a_notebook(run):
    shown = run._repr_html_()
    assert "<pre" not in shown
    assert "<th" in shown
    force, when = run.peak("O3.force")
    here = cells(shown)
    assert {"O2", "O3", "O4", f"{force:.4g} N", f"{when:.4g} s", f"{run.rms('O3.force'):.4g} N"} <= set(here)
    assert len(here) % 9 == 0  # a joint without play has dashes, not fewer cells
    assert run.trust.word in html.unescape(shown)


@pytest.mark.parametrize("draw", ["curves", "orbit", "path"])
def test_a_picture_drawn_into_given_axes_returns_them_and_no_second_figure(run, draw):
    from matplotlib.figure import Figure

    from rattle.plots.orbit import plot_path

    ways = {
        "curves": lambda ax: run.plot("rocker.angle", ax=ax),
        "orbit": lambda ax: run.plot_orbit("O3", ax=ax),
        "path": lambda ax: plot_path(run, "coupler.O3", ax=ax),
    }
    ax = Figure().subplots()
    assert ways[draw](ax) is ax
    assert ax.lines
    assert isinstance(ways[draw](None), Figure)


def test_sections_and_bifurcations_draw_into_given_axes(run):
    from matplotlib.figure import Figure

    from rattle.questions.bifurcation.compute import Bifurcation
    from rattle.questions.poincare.compute import Section

    section = Section(run.t, {n: run[n] for n in ("O3.ex", "O3.ey")}, {"O3.ex": "m", "O3.ey": "m"}, "a rule")
    points = np.arange(6.0).reshape(2, 3)
    found = Bifurcation("c", np.array([1.0, 2.0]), "m", "O3.ex", "m", points, "a rule")
    left, right = Figure().subplots(1, 2)
    assert section.plot(ax=left) is left
    assert found.plot(ax=right) is right
    assert isinstance(section.plot(), Figure)
    assert isinstance(found.plot(), Figure)


@pytest.mark.nojit
def test_options_of_pictures_and_films_have_names():
    from inspect import Parameter, signature

    from rattle.plots import animation, curves
    from rattle.questions.modes.compute import Modes

    for method, function in ((rt.Result.plot, curves.plot), (rt.Result.animate, animation.animate)):
        of_pages = ("title", "curves", "language") if method is rt.Result.animate else ()  # no picture has them
        ours = {name: one for name, one in signature(method).parameters.items() if name not in of_pages}
        theirs = signature(function).parameters
        assert not any(one.kind == Parameter.VAR_KEYWORD for one in ours.values())
        assert {n: p.default for n, p in ours.items() if n != "self"} == {
            n: p.default for n, p in theirs.items() if n != "result"
        }
    film = signature(Modes.animate).parameters
    wanted = signature(animation.animate).parameters
    run_only = ("result", "path", "power", "stress")  # a mode has neither
    assert {n: film[n].default for n in wanted if n not in run_only} == {
        n: p.default for n, p in wanted.items() if n not in run_only
    }
