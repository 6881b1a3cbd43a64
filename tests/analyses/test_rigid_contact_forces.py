"""What rigid contacts show in place of peaks: impulses, forces that can be read, and those of elastic bushes."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from click.testing import CliRunner

import rattle as rt
from rattle.analyses.elastic_bushes import _stiff, _stiffness
from rattle.answers.blocks import of_result
from rattle.cli.main import main
from rattle.cli.requirements import judge
from rattle.results.contact_summary import contact_lines, joint_table
from rattle.results.trust import Trust
from rattle.results.within_steps import bursts, largest, summit
from rattle.studio.jobs.motion import _said
from wiper import ARM_CENTRE, ARM_INERTIA, ARM_MASS, PIN, ROD, WIPER, C, wiper


@pytest.fixture(scope="module")
def runs() -> dict[float, rt.Result]:
    return {mu: wiper(mu).simulate(0.06, t_eval=np.linspace(0.0, 0.06, 61), horizon=True) for mu in (0.0, 0.2)}


def test_without_friction_the_force_towers_because_a_pin_turns_in_its_play_with_unlike_masses():
    peak, when = wiper(0.0).simulate(0.03, t_eval=[0.0]).peak("B.normal")
    assert peak > 20e3  # of a joint that bears some 100 N without play
    times = np.array([when - 3e-5, when - 1e-5, when, when + 1e-5, when + 3e-5])
    r = wiper(0.0).simulate(0.03, t_eval=times)
    # effective masses at B, by hand: along the rod the arm alone moves (the crank is driven, the rod keeps its length),
    # across it the rod swings about A and the arm hardly takes part
    along = ARM_INERTIA + ARM_MASS * ARM_CENTRE**2
    angle = r["arm.angle"]
    lever = PIN * np.sin(angle + np.pi / 2 - r["rod.angle"])  # of the rod's line about W: B is at angle + 90 degrees
    reflected = along / lever**2
    u = np.hypot(r["arm.B.vx"] - r["rod.B.vx"], r["arm.B.vy"] - r["rod.B.vy"])
    turned = np.arctan2(r["B.ey"], r["B.ex"]) - r["rod.angle"]  # of the normal from the rod's line
    assert abs(turned[2]) < 0.01
    # on the circle N = m_n u^2/c; loads and centrifugal accelerations of the links are some 100 N beside it
    assert r["B.normal"][2] == pytest.approx(reflected[2] * u[2] ** 2 / C, rel=0.02)
    # and u follows from the energy of a particle with these two masses: u^2 (m_n sin^2 a + m_t cos^2 a) is constant,
    # in a time so short that loads do no work; m_t = rod/3 beside the arm's 1/(sin^2/m_n ...) part, which is small
    across = ROD / 3.0
    energy = u**2 * (reflected * np.sin(turned) ** 2 + across * np.cos(turned) ** 2)
    assert energy == pytest.approx(np.full(5, energy[2]), rel=0.1)


def test_a_force_that_towers_is_not_printed_anywhere(runs):
    r = runs[0.0]
    table = joint_table(r)
    assert "N*s" in table
    assert r.trust.unread == ("M", "A", "B", "W")
    assert "but not the largest forces of M, A, B, W" in r.trust.word
    shown = " ".join([table, *contact_lines(r)])
    numbers = [float(word) for word in shown.replace("(", " ").split() if word.replace(".", "", 1).isdigit()]
    assert max(numbers) < 1e4
    assert not r.contacts["B"].readable
    hardest = max((one for one in r.events if one.kind == "impact"), key=lambda one: one.impulse)
    assert (r.contacts["B"].impulse, r.contacts["B"].impulse_at) == (hardest.impulse, hardest.t)


def test_a_force_that_towers_keeps_no_requirement(runs):
    run = next(iter(runs.values()))
    (towering, calm) = judge(run, ["max(B.force) < 1e15", "range(arm.angle) < 360 deg"])
    assert not towering.kept
    assert "cannot be judged" in towering.words
    assert math.isnan(towering.record["value"])
    assert calm.kept


@pytest.mark.parametrize("of", ["max(abs(motor.torque))", "max(abs(motor.power))", "rms(B.normal)", "max(rod.alpha)"])
def test_what_rises_with_a_force_that_towers_keeps_no_requirement_either(runs, of):
    (verdict,) = judge(runs[0.0], [f"{of} < 1e15"])
    assert not verdict.kept
    assert "towers with a rigid contact" in verdict.words


def test_values_at_instants_and_shares_are_left_of_a_force_that_towers(runs):
    asked = ["share(B.normal > 0) <= 1", "at(B.normal, 0.01) < 1e4", "max(arm.omega) < 1e3"]
    assert all(verdict.kept for verdict in judge(runs[0.0], asked))


STARTED = (
    WIPER.replace("friction = 0.1", 'friction = "mu"').replace("-51.7616 deg", "0 deg") + "[parameters]\nmu = 0.0\n"
)
SLIPPERY = WIPER.replace("friction = 0.1", 'friction = "mu"') + "[parameters]\nmu = 0.0\n"


def test_samples_whose_force_towers_have_no_number_and_say_so_once():
    found = rt.loads(SLIPPERY).sweep({"mu": [0.0, 0.001]}, ["max(B.force)", "max(arm.omega)"], t_end=0.06)
    assert np.isnan(found["max(B.force)"]).all()
    assert np.isfinite(found["max(arm.omega)"]).all()
    (said,) = [line for line in found.remarks() if "towers" in line]
    assert said.strip().startswith("2 x max(B.force): B.force towers with a rigid contact; ask for its impulse")


@pytest.mark.parametrize("output", ["final(B.angle)", "max(arm.T.x)", "min(B.rate)"])
def test_samples_run_side_by_side_beside_forces_that_tower_where_none_is_asked_for(output):
    found = rt.loads(SLIPPERY).set(mu=0.001).many({"mu": [0.001, 0.002]}, [output], t_end=0.06)
    assert found.stats["how"] == "2 run side by side"


def test_whether_a_torque_towers_does_not_depend_on_what_else_is_asked():
    m = rt.loads(
        """
format = 1
gravity = [0, -9.81]
parameters = { F = 20.0 }
ground.points.O = [0, 0]
bodies.crank = { points = { O = [0, 0], A = [0.05, 0] }, mass = 0.3, inertia = 1e-4 }
bodies.rod = { bar = ["A", "B"], length = 0.12, mass = 0.21, inertia = 2.5e-4 }
bodies.slider = { points = { B = [0, 0] }, mass = 0.4, inertia = 1e-4 }
drivers.motor = { joint = "O", angle = "0.7 + 0.5*sin(60*t)" }
loads.push = { type = "force", at = "slider.B", force = ["F*cos(11*t)", 0] }
[joints]
O = { type = "revolute", connect = ["ground.O", "crank.O"] }
A = { type = "revolute", connect = ["crank.A", "rod.A"] }
B = { type = "revolute", connect = ["slider.B", "rod.B"], clearance = 5e-4, contact = "PIN" }
guide = { type = "prismatic", connect = ["ground.O", "slider.B"], axis = 0 }
[initial]
B = { offset = [0, 0] }
""".replace('"PIN"', '{ model = "impact", restitution = 0.6, bush_radius = 0.01 }')
    )
    asked = ["max(abs(motor.torque))"]
    for more in ([], ["final(slider.x)"], ["max(slider.x)"]):
        assert np.isnan(m.many({"F": [20.0]}, asked + more, 0.03)[asked[0]][0])


def test_designs_whose_force_towers_are_none_and_the_reason_is_said():
    with pytest.raises((ValueError, RuntimeError), match=r"towers with a rigid contact"):
        rt.loads(SLIPPERY).optimise("max(B.force)", {"mu": (0.0, 1e-3)}, t_end=0.06, starts=1)


def test_a_calm_rigid_contact_keeps_its_force():
    r = wiper(0.1, 0.6).simulate(0.5, t_eval=[0.0, 0.5])
    assert r.trust.unread == ()
    assert "lasting force" in joint_table(r)
    assert f"{r.peak('B.force')[0]:.4g} N" in joint_table(r)


def test_elastic_bushes_bracket_runs_with_stiffnesses_between_them(runs):
    low, high = runs[0.0].trust.elastic["B"]
    for stiffness in (2e9, 1e10):
        bush = {"model": "exact", "restitution": 0.3, "friction": 0.0, "stiffness": stiffness, "exponent": 1.5}
        m = wiper(0.0).set({"joints.B.contact": {**bush, "bush_radius": 0.006}})
        assert 0.9 * low < m.simulate(0.06, t_eval=[0.0]).peak("B.normal")[0] < 1.1 * high
    assert "elastic bushes would show about" in contact_lines(runs[0.0])[0]


def test_the_stiffer_bushes_have_the_stiffness_of_hertz():
    stiff, words = _stiff(wiper(0.1))
    # sphere in socket, steel on steel: K = 4/(3 (s + s)) sqrt(R_A R_B/(R_A - R_B)), s = (1 - nu^2)/E
    steel = stiff.model.joints["B"].contact.static.values
    assert (steel["bush_material"], steel["pin_material"]) == ("steel", "steel")
    compliance = (1.0 - 0.3**2) / 207e9
    assert _stiffness(stiff, "B") == pytest.approx(
        4.0 / (3.0 * 2.0 * compliance) * math.sqrt(0.006 * (0.006 - C) / C), rel=1e-6
    )
    assert "steel" in words["B"]


def test_assumed_bushes_are_said():
    m = rt.loads(WIPER).set({"joints.B.contact": {"model": "impact", "restitution": 0.3}})
    assert "assumed bush radius 3 mm" in _stiff(m)[1]["B"]


def test_the_approach_to_a_lock_by_friction_is_said_with_its_time(runs):
    assert not any("Painleve" in note for note in runs[0.0].trust.notes)
    assert any("Painleve" in note and "t = " in note for note in runs[0.2].trust.notes)


@pytest.mark.parametrize("t_end", [1.03, 1.1])
def test_trust_ends_where_friction_nearly_locks_a_joint(t_end):
    """With a tenth of the tolerance the run stops there; the usual run and its second one pass, and agree by chance."""
    m = rt.loads(STARTED).set({"mu": 0.195})
    loose = m.simulate(t_end, t_eval=np.linspace(0.0, t_end, 1101), horizon=True)
    lock = float(next(note for note in loose.trust.notes if "Painleve" in note).split("t = ")[1].split(" s")[0])
    assert loose.trust.horizon <= lock + 1e-3
    assert loose.trust.trusted_until() < t_end
    assert loose.trust.word.startswith("trusted up to t = 1.0")


def test_a_lock_ends_the_trust_of_a_run_in_words():
    t = Trust(1e-16, t_end=1.1, horizon=1.0262, horizon_motion=1.0262, locked="B")
    assert t.word == "trusted up to t = 1.026 s, where friction nearly locks B"
    assert "where friction nearly locks B" in t.why[0]
    assert any("nearly locks B" in doubt for doubt in t.doubts())


def test_a_link_that_pulls_is_not_trusted_to_the_end():
    t = Trust(1e-16, t_end=1.0, horizon=1.0, pulled={"B": 0.14}, first_pull={"B": 0.3})
    assert t.word.startswith("trusted up to t = 0.3 s: B would have to pull for 14 % of the run")
    assert t.trusted_until() == 0.3
    at_once = Trust(1e-16, t_end=1.0, horizon=1.0, pulled={"B": 0.14}, first_pull={"B": 0.0})
    assert at_once.word.startswith("not to be trusted: B would have to pull")


@pytest.mark.parametrize(
    ("trust", "word"),
    [
        (Trust(1e-16, t_end=1.0, horizon=1.0), "trusted over the whole run"),
        (Trust(1e-16, t_end=1.0, horizon=0.31), "trusted up to t = 0.31 s, after it statistics only"),
        (Trust(1e-16, t_end=1.0), "how far it can be trusted was not computed (horizon=True does)"),
        (Trust(1e-16, t_end=0.5, horizon=0.5, stopped=True), "trusted up to where the run ended, t = 0.5 s"),
        (
            Trust(1e-16, t_end=1.0, horizon=1.0, energy_share=0.02),
            "not to be trusted: 2 % of the energy is unaccounted for",
        ),
        (
            Trust(1e-16, t_end=1.0, horizon=1.0, singular=(0.667,)),
            "trusted over the whole run, but not the forces at singular positions (t = 0.667 s)",
        ),
        (
            Trust(1e-16, t_end=1.0, singular=(0.667,)),
            "how far it can be trusted was not computed (horizon=True does); in no case the forces at singular"
            " positions (t = 0.667 s)",
        ),
        (Trust(1e-16, t_end=1.0, horizon=1.0, pulled={"B": 0.0}, first_pull={"B": None}), "trusted over the whole run"),
    ],
)
def test_trust_is_one_line_and_the_reasons_stand_apart(trust, word):
    assert trust.word == word
    assert any("constraint error" in line for line in trust.why)
    assert "constraint error" not in trust.word


LARGEST = 2e4  # [N, N*m, W]: nothing beyond is to be seen of a joint that bears some 100 N


def test_pictures_have_the_scale_of_what_can_be_read_and_say_that_they_are_cut(runs):
    r = runs[0.0]
    assert r.peak("B.force")[0] > LARGEST
    figure = r.plot("B.force", "B.normal")
    low, high = figure.axes[0].get_ylim()
    assert max(abs(low), abs(high)) < LARGEST
    words = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    assert all("cut where it towers" in word for word in words)
    orbit = r.plot_orbit("B")
    assert "cut where it towers" in orbit.axes[1].get_ylabel()
    assert orbit.axes[1].get_ylim()[1] < LARGEST


def test_a_comparison_does_not_print_a_peak_that_towers(runs):
    r = runs[0.0]
    assert [largest(r, f"B.{what}") < LARGEST for what in ("force", "normal", "fx")] == [True] * 3
    assert summit(r, "B.normal") is None
    assert all(burst.y < LARGEST for burst in bursts(r, "B.normal"))
    block = of_result("Forces", r, ["B.force"])
    assert block["lines"][0]["top"] is None
    assert "cut" in block["lines"][0]["name"]
    assert np.nanmax(block["lines"][0]["y"]) < LARGEST


def test_a_report_and_power_leave_out_what_towers(runs, tmp_path):
    m = wiper(0.0).set({"simulate.t_end": 0.06})
    m.report(tmp_path / "report.html")
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    card = text.split("Peak effort of motor</dt><dd>")[1]
    assert card.startswith("not to be read")
    driver = text.split("Efforts of the drivers")[1].split("</table>")[0]
    assert driver.count("not to be read") == 2
    power = runs[0.0].power()
    joint = power.table[power.table["element"] == "B"]
    assert joint["peak"].isna().all()
    assert "peaks are left out" in power.remark


def test_json_has_no_peak_of_a_contact_that_towers(tmp_path):
    (tmp_path / "wiper.toml").write_text(WIPER.replace("friction = 0.1", "friction = 0.0"), encoding="utf-8")
    done = CliRunner().invoke(main, ["run", str(tmp_path / "wiper.toml"), "--t-end", "0.06", "--no-horizon", "--json"])
    contact = json.loads(done.stdout)["contacts"]["B"]
    assert (contact["peak"], contact["rms"]) == (None, None)
    assert contact["impulse"] > 0.0


def test_a_penetration_is_positive_where_it_is_largest():
    r = rt.example("slider_crank_play").simulate(0.006, t_eval=np.linspace(0.0, 0.006, 13))
    assert summit(r, "B.penetration").y == r.peak("B.penetration")[0] > 0.0


def test_a_requirement_on_a_rigid_force_far_below_that_of_elastic_bushes_is_not_kept_by_it_alone():
    r = wiper(0.1, 0.6).simulate(0.06, t_eval=np.linspace(0.0, 0.06, 61), horizon=True)
    peak, high = r.peak("B.force")[0], r.trust.elastic["B"][1]
    assert r.trust.unread == ()
    assert high > 2.0 * peak
    between, above = judge(r, [f"max(B.force) < {0.5 * (peak + high)}", f"max(B.force) < {2.0 * high}"])
    assert (between.kept, above.kept) == (False, True)
    assert "elastic bushes in B would show about" in between.words


def test_the_largest_impulse_can_be_asked_for(runs):
    r = runs[0.0]
    hardest = max(event.impulse for event in r.events if event.kind == "impact")
    kept, broken = judge(r, [f"max(B.impulse) < {1.01 * hardest}", f"max(B.impulse) < {0.99 * hardest}"])
    assert (kept.kept, broken.kept) == (True, False)
    assert (kept.record["value"], kept.record["unit"]) == (hardest, "N*s")
    found = rt.loads(SLIPPERY).sweep({"mu": [0.0, 0.001]}, ["max(B.impulse)"], t_end=0.06)
    assert found["max(B.impulse)"][0] == pytest.approx(hardest, rel=1e-6)
    with pytest.raises(rt.ModelError, match=r"write max\(B\.impulse\) alone"):
        judge(r, ["rms(B.impulse) < 1"])


def test_the_studio_says_what_is_not_to_be_trusted(runs):
    told = _said(runs[0.0])
    assert told["limited"]
    assert told["trust"][0] == "not to be trusted: the largest forces of M, A, B, W"
