"""One word changes the contact of every joint; all models of play on one page."""

import numpy as np
import pytest
from click.testing import CliRunner

import rattle as rt
from rattle.cli.main import main
from rattle.description.switch_contact import recontact
from rattle.errors import ModelError
from rattle.questions.compare import compute as compare

STEEL = {"bush_radius": "20 mm", "bush_material": "steel", "pin_material": "steel"}
FULL = {"model": "hunt-crossley", "restitution": 0.7, "friction": {"model": "lugre", "mu": 0.2}, **STEEL}


@pytest.mark.nojit
def test_another_model_keeps_what_it_knows():
    assert recontact(FULL, "exact") == {**FULL, "model": "exact"}
    assert recontact(FULL, "impact") == {
        "model": "impact", "restitution": 0.7, "friction": 0.2, "bush_radius": "20 mm",
    }  # fmt: skip
    assert recontact(FULL, "massless-link") == "massless-link"
    assert recontact("massless-link", "impact") == "impact"
    assert "restitution" not in recontact(FULL, "hertz")  # loses nothing
    assert "tangential_restitution" not in recontact({"model": "impact", "tangential_restitution": 0.1}, "exact")


@pytest.mark.nojit
def test_a_foundation_goes_with_its_geometry_and_needs_no_materials():
    bed = {"geometry": "foundation", "foundation": 1e12, "length": 0.02}
    soft = {"model": "flores", "restitution": 0.5, "bush_radius": 0.01, **bed}
    assert recontact(soft, "exact") == {**soft, "model": "exact"}
    assert recontact({**soft, "viscosity": 0.05}, "lubricated")["dry"].items() >= bed.items()
    made, assumed = compare._compliant(rt.example("slider_crank_worn"), ["B"], "hertz")
    assert not assumed
    assert not made.model.joints["B"].contact.unused


@pytest.mark.nojit
def test_with_contact_changes_all_joints_with_clearance_or_one():
    m = rt.example("fourbar")
    both = m.with_contact("impact").model.joints
    assert [both[name].contact.model for name in ("O3", "O4")] == ["impact", "impact"]
    assert both["O2"].contact is None
    one = m.with_contact("ideal", "O4").model.joints
    assert [one[name].contact.model for name in ("O3", "O4")] == ["massless-link", "ideal"]
    assert m.model.joints["O3"].contact.model == "massless-link"
    text = m.with_contact("impact").to_toml()
    assert "# The paper's four-bar" in text
    assert rt.loads(text).model.joints["O3"].contact.model == "impact"


@pytest.mark.nojit
@pytest.mark.parametrize(
    ("model", "joint", "said"),
    [
        ("exact", None, "needs a stiffness"),
        ("impakt", None, "did you mean 'impact'"),
        ("impact", "O2", "has no clearance"),
        ("impact", "O33", "did you mean 'O3'"),
    ],
)
def test_with_contact_says_what_is_missing(model, joint, said):
    with pytest.raises(ModelError, match=said):
        rt.example("fourbar").with_contact(model, joint)


@pytest.fixture(scope="module")
def comparison():
    return rt.example("slider_crank").compare(t_end=6e-3)


def test_compare_has_every_model_with_the_same_instants(comparison):
    assert list(comparison.results) == ["ideal", "massless link", "one-sided impact", "compliant", "lubricated"]
    times = [r.t for r in comparison.results.values()]
    assert all(np.array_equal(times[0], t) for t in times)
    assert comparison.joint == "B"
    assert comparison.results["compliant"].contacts["B"].contacts >= 2


def test_compare_says_what_it_took_for_granted(comparison):
    said, oil = comparison.assumed
    assert "bush radius 5 mm" in said
    assert "restitution 0.5" in said
    assert oil == "assumed for the lubricated B: oil of 50 mPa*s, bush radius 50 mm, a bush as long as wide"
    lines = str(comparison).splitlines()
    assert lines[1].split()[:6] == ["model", "peak", "force", "RMS", "force", "pressing"]
    assert {said, oil} < {*lines}


def test_oil_takes_the_peaks_off_the_force(comparison):
    ideal, oiled = comparison.results["ideal"], comparison.results["lubricated"]
    assert oiled.peak("B.force")[0] == pytest.approx(ideal.peak("B.force")[0], rel=0.01)
    assert comparison.results["compliant"].peak("B.force")[0] > 5 * ideal.peak("B.force")[0]
    row = comparison.rows()[-1]
    assert row[0] == "lubricated"
    assert row[6] == f"{oiled['energy.dissipated'][-1]:.3g} J"  # nothing else loses energy here


def test_oil_is_left_out_where_its_bush_would_not_fit_and_is_not_for_guides():
    found = rt.example("fourbar").compare(t_end=1e-4)
    assert "O3 has no bush_radius, and a usual one for 5 mm of play around oil, 0.5 m," in found.skipped["lubricated"]
    assert "lubricated" not in {*(guide := rt.example("guide_play").compare(t_end=1e-4)).results, *guide.skipped}


def test_every_model_starts_from_the_same_motion(comparison):
    ideal = comparison.results["ideal"]
    for r in comparison.results.values():
        # within the play of 0.5 mm and the first 0.1 ms, whatever the model
        assert np.abs(r["slider.x"] - ideal["slider.x"])[r.t < 1e-4].max() < 6e-4


def test_a_start_that_nobody_expects_is_said_once_and_one_that_all_expect_never():
    asked = {"initial.crank.angle": "40 deg"}  # the motor begins at 0
    found = rt.example("slider_crank_play").set(asked).compare(t_end=1e-4)
    assert str(found).count("asked for ") == 1
    assert "ideal: asked for crank.angle = 40 deg, got 0 deg: the driver 'motor' holds it" in str(found)
    assert "asked for" not in str(rt.example("fourbar").compare(t_end=1e-4))


def test_bushes_in_place_of_contacts_without_restitution_are_those_of_the_bracket():
    found = rt.example("fourbar_onesided").compare(t_end="12 ms")  # e = 0
    assert found.assumed[0].endswith("restitution 0.05 in place of 0")
    low, high = found.results["one-sided impact"].trust.elastic["O3"]
    compliant = found.results["compliant"]
    assert low < compliant.peak("O3.normal")[0] < 1.05 * high  # the same bushes, with another tolerance
    assert "restitution 0.05 in place of 0" in found.results["one-sided impact"].trust.bushes["O3"]
    row = next(row for row in found.rows() if row[0] == "compliant")
    assert row[-1].endswith("(not the peak)") == bool(compliant.trust.coarse())


def test_page_has_no_text_over_another_in_its_table_and_titles(comparison):
    figure = comparison.figure()
    figure.canvas.draw()
    for ax in figure.axes:
        texts = [t for t in (*ax.texts, ax._left_title, ax.title) if t.get_text() and t.get_visible()]
        boxes = [t.get_window_extent() for t in texts]
        for n, one in enumerate(boxes):
            assert one.x1 <= figure.bbox.x1 + 1, texts[n].get_text()
            for k in range(n):
                assert not one.overlaps(boxes[k]), (texts[n].get_text(), texts[k].get_text())


def test_compare_and_run_contact_on_the_command_line(tmp_path):
    out = tmp_path / "page.png"
    done = CliRunner().invoke(main, ["compare", "slider_crank", "--t-end", "0.001", "-o", str(out)])
    assert done.exit_code == 0, done.output
    assert out.stat().st_size > 20_000
    assert "one-sided impact" in done.output
    words = ["run", "slider_crank", "--contact", "exact", "--t-end", "0.001"]
    missing = CliRunner().invoke(main, words)
    assert missing.exit_code == 2
    assert "needs a stiffness" in missing.output
    ideal = CliRunner().invoke(main, ["run", "slider_crank", "--contact", "massless-link", "--t-end", "0.001", "--why"])
    assert ideal.exit_code == 0, ideal.output
    assert "pull" in ideal.output


def test_compare_refuses_what_has_no_play():
    with pytest.raises(ModelError, match="nothing to compare"):
        rt.example("double_pendulum").compare()
    with pytest.raises(ModelError, match="has no clearance"):
        rt.example("fourbar").compare(joint="O2")


def test_page_goes_without_the_ideal_mechanism_where_that_cannot_be_put_together():
    found = rt.example("woodpecker").compare(t_end=2e-3)
    assert "cannot be assembled" in found.skipped["ideal"]
    assert found.reference == "one-sided impact"
    titles = [ax.get_title(loc="left") for ax in found.figure().axes]
    assert "Deviation of bird.angle from the run with one-sided impact" in titles
