"""What a run and a comparison say: no false alarm, nothing that does not apply without a word."""

import numpy as np
import pytest
from click.testing import CliRunner

import rattle as rt
from rattle.analyses.dynamics.events import contact_notes
from rattle.analyses.dynamics.methods import note_choice
from rattle.cli.main import main
from rattle.errors import ModelError
from rattle.plots.orbit import plot_orbit
from rattle.registry import kinds
from rattle.results.event import Event


@pytest.mark.nojit
def test_rounding_is_no_gain_of_energy_and_a_true_gain_is():
    system = rt.example("fourbar").with_contact("impact").system
    tiny = [Event(0.1, "O3", "impact", 1e-9, impulse=1e-9, energy_lost=-1e-16)]
    assert contact_notes(system, tiny, 10.0) == ()
    gain = [Event(0.1, "O3", "impact", 0.1, impulse=1.0, energy_lost=-1e-3)]
    assert "1 impact created energy, 0.001 J" in contact_notes(system, gain, 10.0)[0]


@pytest.mark.parametrize(("name", "contact"), [("fourbar_onesided", None), ("fourbar", "impact")])
def test_impacts_that_lose_all_or_nothing_raise_no_alarm(name, contact):
    m = rt.example(name)
    r = (m.with_contact(contact) if contact else m).simulate(0.03)
    assert any(event.kind == "impact" for event in r.events)
    assert "created energy" not in str(r.trust)


@pytest.mark.nojit
def test_a_method_that_does_not_apply_is_named():
    steppers, free = kinds("stepper"), rt.example("double_pendulum").system
    impacts = rt.example("fourbar").with_contact("impact").system
    assert note_choice(impacts, "event", steppers["event"]) == ()
    assert "this model has none: dop853 was used" in note_choice(free, "moreau", steppers["dop853"])[0]
    assert "impacts: event was used" in note_choice(impacts, "rk4", steppers["event"])[0]


def test_runs_and_command_line_say_which_method_ran():
    said = str(rt.example("fourbar").simulate(1e-3, method="moreau").trust)
    assert "method moreau is for impact contacts" in said
    assert "method" not in str(rt.example("fourbar").simulate(1e-3).trust)
    done = CliRunner().invoke(main, ["run", "double_pendulum", "--contact", "impact"])
    assert done.exit_code == 2
    assert "no joint has a clearance, so contact 'impact' applies to none" in done.output


@pytest.mark.nojit
def test_a_contact_for_joints_without_play_is_refused_and_ideal_is_not():
    with pytest.raises(ModelError, match="no joint has a clearance"):
        rt.example("double_pendulum").with_contact("impact")
    assert rt.example("double_pendulum").ideal().model == rt.example("double_pendulum").model


def test_offset_of_a_guide_is_its_play_in_every_model():
    m = rt.example("guide_play")
    (guide,) = [name for name, one in m.model.joints.items() if one.kind == "prismatic"]
    play = m.model.joints[guide].clearance
    ideal, impact = m.ideal().simulate(0.02), m.with_contact("impact").simulate(0.02)
    assert np.hypot(ideal[f"{guide}.ex"], ideal[f"{guide}.ey"]).max() < 1e-12  # closed, wherever it has gone
    assert np.hypot(impact[f"{guide}.ex"], impact[f"{guide}.ey"]).max() < 3 * play  # tilted blocks: a little more


def test_impacts_and_contacts_are_counted_apart_in_table_and_orbit():
    r = rt.example("fourbar_onesided").simulate(0.05)
    kinds = [event.kind for event in r.events if event.joint == "O3"]
    impacts, contacts = kinds.count("impact"), kinds.count("contact")
    assert impacts > 0 < contacts
    (row,) = [line.split() for line in CliRunner().invoke(
        main, ["-q", "run", "fourbar_onesided", "--t-end", "0.05", "--no-horizon"]
    ).output.splitlines() if line.startswith("O3 ")]  # fmt: skip
    assert [int(word) for word in row[9:11]] == [contacts, impacts]
    said = [text.get_text() for text in plot_orbit(r, "O3").axes[0].get_legend().get_texts()]
    hardest = max(event.impulse for event in r.events if event.joint == "O3" and event.kind == "impact")
    assert any(text.startswith(f"{impacts} impact") and f"{hardest:.2g}" in text for text in said)
    assert any(text.startswith(f"{contacts} contact") for text in said)


def small_play():
    return rt.example("slider_crank").set({"joints.B.clearance": "0.02 mm"})


def test_a_bush_taken_for_granted_that_does_not_bear_the_forces_is_left_out_and_said():
    found = small_play().compare(t_end=5e-4)
    assert "compliant" not in found.results
    assert "sinks" in found.skipped["compliant"]
    assert "more than its play of 0.02 mm" in str(found)
    texts = [text.get_text() for ax in found.figure().axes for text in ax.texts]
    assert any("sinks" in text for text in texts)
    assert not any("N*s" in text for text in texts if "impact" not in text and "impulse" not in text)


def test_notes_of_every_run_stand_on_the_page_and_in_print():
    found = rt.example("slider_crank").compare(t_end=5e-4)
    assert found.notes  # slider.x as asked does not fit the play
    texts = " ".join(text.get_text() for ax in found.figure().axes for text in ax.texts)
    for model, notes in found.notes.items():
        for note in notes:
            assert f"{model}: {note}" in str(found)
            assert note[:60] in texts


def test_stems_stand_only_where_two_outputs_would_miss_a_contact():
    from matplotlib.collections import LineCollection

    found = rt.example("slider_crank").compare(t_end=6e-3)
    r = found.results["compliant"]
    interval = r.t[1] - r.t[0]
    assert all(event.duration > 2 * interval for event in r.events if event.kind == "contact")
    (panel,) = [ax for ax in found.figure().axes if ax.get_title(loc="left").startswith("Compliant")]
    assert not [one for one in panel.collections if isinstance(one, LineCollection)]
    assert "logarithmic" in panel.get_ylabel()
