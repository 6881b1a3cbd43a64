"""Sections, buckling, refusals, remarks, tables and pictures of the strength of bars."""

import json
import math

import numpy as np
import pytest

import rattle as rt
from bars import IRON, SQUARE, beam, slider_crank

E = 210e9
SECTIONS = {  # A [m^2], I [m^4], W [m^3]
    '{ shape = "rectangle", width = "10 mm", height = "20 mm" }': (2e-4, 0.01 * 0.02**3 / 12, 0.01 * 0.02**2 / 6),
    '{ shape = "round", diameter = "12 mm" }': (math.pi * 36e-6, math.pi * 0.012**4 / 64, math.pi * 0.012**3 / 32),
    '{ shape = "tube", diameter = "12 mm", wall = "2 mm" }': (
        math.pi * 20e-6, math.pi * (0.012**4 - 0.008**4) / 64, math.pi * (0.012**4 - 0.008**4) / 32 / 0.012,
    ),
    "{ area = 3e-4, inertia = 2e-9, modulus = 4e-7 }": (3e-4, 2e-9, 4e-7),
}  # fmt: skip
LIGHT = "mass = 1e-9"


def borne(text, body="bar", t=(0.0, 1.0)):
    return rt.loads(text).strength(body, t_eval=list(t), analysis="inverse-dynamics")


def pressed(newton, section, held="pins", **more):
    force = f'loads.f = {{ type = "force", at = "bar.B", force = [{newton}, 0] }}'
    return borne(beam(force, held, section=section, body=LIGHT, **more))


@pytest.mark.parametrize("section", SECTIONS)
def test_pull_and_bending_share_the_section(section):
    area, _, modulus = SECTIONS[section]
    force = 'loads.f = { type = "force", at = "bar.B", force = [700, 20] }'
    s = borne(beam(force, "clamped", section=section, body=LIGHT))
    assert s.peak == pytest.approx(700 / area + 20 * 0.3 / modulus)
    assert s.deflection[0, 0] == s.deflection[0, -1] == 0.0
    upper, lower = s.fibres
    assert upper[0, 0] == pytest.approx(700 / area - 6 / modulus)  # M > 0 pulls the side of -y
    assert lower[0, 0] == pytest.approx(700 / area + 6 / modulus)


@pytest.mark.parametrize("section", SECTIONS)
def test_a_bar_buckles_at_the_force_of_euler(section):
    inertia = SECTIONS[section][1]
    critical = math.pi**2 * E * inertia / 0.3**2
    s = pressed(-critical / 7.0, section)
    assert s.buckling == pytest.approx(7.0)
    assert np.isinf(pressed(critical / 7.0, section).buckling).all()
    assert any("out of the plane" in remark for remark in s.remarks)


def test_a_stout_bar_yields_before_it_buckles_and_a_slender_one_does_not():
    stout, slender = (
        pressed(-100, '{ shape = "round", diameter = "20 mm" }'),
        pressed(-100, '{ shape = "round", diameter = "6 mm" }', length=0.8),
    )
    assert any("before it buckles" in remark for remark in stout.remarks)
    assert not any("before it buckles" in remark for remark in slender.remarks)


def test_what_leaves_the_theory_of_straight_bars_is_said():
    rectangle = '{{ shape = "rectangle", width = "5 mm", height = "{} mm" }}'
    stocky, slender = (borne(beam(section=rectangle.format(height))) for height in (100, 50))
    assert any("too stocky" in remark and "3 times its height" in remark for remark in stocky.remarks)
    assert not any("too stocky" in remark for remark in slender.remarks)
    limit = math.pi**2 * 210e9 * 0.005**4 / 12 / 0.3**2
    for share, buckles in ((0.9, False), (1.1, True)):
        s = pressed(-share * limit, rectangle.format(5))
        assert any(remark.startswith("BUCKLES") for remark in s.remarks) == buckles
    for share, yields in ((0.9, False), (1.1, True)):
        s = pressed(share * 300e6 * 25e-6, rectangle.format(5))
        assert any(remark.startswith("YIELDS") for remark in s.remarks) == yields


def test_the_first_bending_frequency_is_that_of_a_uniform_bar_on_pins():
    s = borne(beam(gravity=10.0))
    assert s.frequency == pytest.approx(math.pi / 2 * math.sqrt(E * 1e-8 / 12 / (0.785 * 0.3**4)))


def test_contacts_that_are_shorter_than_the_bending_vibration_are_said():
    s = rt.loads(PLAY).simulate(0.02).strength("rod")
    assert any("rings" in remark and "B" in remark for remark in s.remarks)


PLAY = slider_crank().replace(
    'joints.B = { type = "revolute", connect = ["rod.B", "slider.B"] }',
    'joints.B = { type = "revolute", connect = ["slider.B", "rod.B"], clearance = "0.2 mm", contact = '
    '{ model = "hertz", bush_radius = "8 mm", restitution = 0.8, bush_material = "steel", pin_material = "steel" } }',
)


def test_impulses_of_rigid_contacts_are_said_to_be_left_out():
    rigid = PLAY.replace('model = "hertz"', 'model = "impact"').replace(
        ', bush_material = "steel", pin_material = "steel"', ""
    )
    s = rt.loads(rigid).simulate(0.02).strength("rod")
    assert any("impulses" in remark and "B" in remark for remark in s.remarks)


# ---------------------------------------------------------------- refusals
@pytest.mark.parametrize(
    ("text", "body", "words"),
    [
        (beam(), "bra", "did you mean 'bar'"),
        (slider_crank(), "slider", "is no bar"),
        (beam(body="mass = 1").replace('material = "iron"', ""), "bar", "needs material"),
        (beam(body="mass = 1").replace(f"section = {SQUARE}", ""), "bar", "needs section"),
    ],
)  # fmt: skip
def test_what_is_no_bar_is_refused_by_name(text, body, words):
    with pytest.raises(rt.InputError, match=words):
        borne(text, body)


def test_other_analyses_have_no_forces():
    m = rt.loads(slider_crank())
    with pytest.raises(rt.InputError, match="simulate"):
        m.kinematics([0.01]).strength("rod")
    with pytest.raises(rt.InputError, match="inverse-dynamics"):
        m.strength("rod", analysis="kinematics")
    nothing = m.inverse_dynamics([0.01])
    del nothing.provenance["document"]
    with pytest.raises(rt.InputError, match="does not hold its model"):
        nothing.strength("rod")


def test_the_motion_of_the_model_is_followed_unless_instants_are_given():
    m = rt.loads(slider_crank())
    assert m.strength("rod").t[-1] == pytest.approx(0.1)
    assert m.strength("rod", t_eval=["1 ms", "2 ms"]).t == pytest.approx([0.001, 0.002])
    assert len(m.strength("rod", analysis="inverse-dynamics").t) == 1001


# ---------------------------------------------------------------- tables, pictures, the command
def test_the_table_has_the_extremes_at_every_place(tmp_path):
    s = borne(slider_crank(), "rod", np.linspace(0.001, 0.1, 9))
    assert s.table["moment_max"].to_numpy() == pytest.approx(s.moment.max(axis=0))
    assert s.to_csv(tmp_path / "rod.csv").read_text().startswith("x,normal_min,normal_max")


def test_pictures_name_the_largest_stress_and_its_place():
    s = borne(slider_crank(), "rod", np.linspace(0.001, 0.1, 9))
    *_, stress = s.plot().axes
    shown = [text.get_text() for text in stress.texts]
    assert shown == [f"{s.peak / 1e6:.4g} MPa"]
    (mark,) = [line for line in stress.lines if line.get_marker() in "v^"]
    assert mark.get_xdata()[0] == pytest.approx(1e3 * s.peak_at[1])
    drawn, bar = s.draw().axes
    assert "stress" in bar.get_ylabel()
    assert any("moment on the side that is pulled" in text.get_text() for text in drawn.texts)


def test_bars_that_move_have_the_colours_of_their_stress(tmp_path):
    from rattle.plots.animation import scene

    r = rt.loads(slider_crank()).inverse_dynamics(np.linspace(0.001, 0.1, 5))
    figure, update, count = scene(r, 5, stress=True)
    (crank, rod) = [part for part in figure.axes[0].collections if part.get_array() is not None]
    s = r.strength("rod")
    for k in range(count):
        update(k)
        stress = np.abs(s.stress[k])
        assert 1e6 * np.asarray(rod.get_array()) == pytest.approx((stress[1:] + stress[:-1]) / 2)
        ends = np.array([rod.get_segments()[0][0], rod.get_segments()[-1][1]])
        assert ends[0] == pytest.approx([r["rod.A.x"][k], r["rod.A.y"][k]])
        assert np.hypot(*(ends[1] - ends[0])) == pytest.approx(0.12)
        assert len(crank.get_segments()) == 100
    r.animate(tmp_path / "a.gif", stress=True, frames=2)
    with pytest.raises(rt.InputError, match="no bar"):
        rt.example("fourbar").ideal().inverse_dynamics([0.0, 0.1]).animate(tmp_path / "b.gif", stress=True)


def test_moments_are_drawn_on_the_side_that_is_pulled():
    s = borne(beam(gravity=100.0))  # it sags: the lower side is pulled
    drawn, _ = s.draw().axes
    (area,) = [patch for patch in drawn.patches if patch.get_zorder() == 6]
    assert area.get_xy()[:, 1].min() < -0.01
    assert area.get_xy()[:, 1].max() == pytest.approx(0.0, abs=1e-12)
    low, high = drawn.get_ylim()
    assert low <= area.get_xy()[:, 1].min() < high


def test_the_command_tells_of_one_bar_or_all(tmp_path, monkeypatch):
    from click.testing import CliRunner

    from rattle.cli.main import main

    monkeypatch.chdir(tmp_path)
    (tmp_path / "m.toml").write_text(slider_crank())
    run = CliRunner().invoke
    alone = run(main, ["strength", "m.toml", "--of", "rod", "-o", "rod.svg"])
    assert alone.exit_code == 0, alone.output
    assert all(word in alone.output for word in ("largest stress", "buckling", "MPa", "rod"))
    assert (tmp_path / "rod.svg").stat().st_size > 10_000
    every = run(main, ["strength", "m.toml", "--analysis", "inverse-dynamics", "--points", "51", "-o", "bars.csv"])
    assert [line.split()[0] for line in every.output.splitlines()[1:3]] == ["crank", "rod"]
    assert (tmp_path / "bars.csv").read_text().splitlines()[1].startswith("crank,")
    record = json.loads(run(main, ["strength", "m.toml", "--of", "rod", "--json"]).output)
    assert record["rod"]["safety"] == pytest.approx(300e6 / record["rod"]["peak"])
    assert run(main, ["strength", "m.toml", "-o", "bars.txt"]).exit_code == 2
    assert "no bar" in run(main, ["strength", "fourbar"]).output


def test_a_notebook_shows_numbers_and_remarks():
    s = borne(beam(gravity=10.0, material=IRON.replace("yield", "expansion").replace('"300 MPa"', "1e-5")))
    assert "largest stress" in s._repr_html_()
    assert "does not say its yield" in s._repr_html_()


def test_reports_and_the_studio_show_every_bar():
    from rattle.pages.report_study import Study
    from rattle.questions.strength import section, tab
    from rattle.studio.shelf import Shelf

    m = rt.loads(slider_crank())
    study = Study(m)
    study.run = m.simulate(0.02)
    section.gather(study)
    page = section.section(study).body
    assert "<td>crank</td>" in page
    assert "<td>rod</td>" in page
    assert "out of the plane" in page
    shown = tab.tab(Shelf(), {"text": slider_crank(), "file": ""})
    (rows,) = [block["rows"] for block in shown["blocks"] if block["kind"] == "table"]
    assert [row[0] for row in rows] == ["crank", "rod"]


def test_reports_and_the_studio_say_that_there_is_no_bar():
    from rattle.pages.report_study import Study
    from rattle.questions.strength import section, tab
    from rattle.studio.shelf import Shelf

    m = rt.example("double_pendulum")
    study = Study(m)
    study.run = m.simulate(0.02)
    section.gather(study)
    assert "no bar" in section.section(study).reason
    assert "no bar" in tab.tab(Shelf(), {"text": m.to_toml(), "file": ""})["told"]
