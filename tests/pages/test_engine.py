"""A live page computes the motion that `simulate` computes: the same steps, events, checks and words."""

import shutil

import numpy as np
import pytest

import rattle as rt
from linkages import SCISSOR
from live import computed, program_of
from rattle.pages.live_model import live_model
from rattle.results.columns import geometry

pytestmark = pytest.mark.skipif(shutil.which("node") is None, reason="no node")


def simulated(m, run, t_end=None, horizon=False):
    """The same motion by Python, at the instants of a run of the page."""
    changes = {name: x for name, x in run["parameters"].items() if m.parameters[name] != x}
    return (m.set(changes) if changes else m).simulate(t_end, t_eval=run["t"], horizon=horizon)


def apart(run, r, names=None):
    """The largest difference of any curve, as a share of its largest value (or of the largest of its unit)."""
    widest = {}
    for name in r.names:
        widest[r.unit(name)] = max(widest.get(r.unit(name), 0.0), float(np.abs(r[name]).max()))
    return max(
        float(np.abs(run["columns"][name] - r[name]).max()) / max(widest.get(r.unit(name), 0.0), 1e-6)
        for name in names or run["names"]
    )


TURNED = {  # end [s], changed parameters
    "fourbar": (0.03, {"r3": 0.003}),
    "double_pendulum": (0.2, {"upper_length": 0.38, "start": 1.1}),
    "slider_crank": (0.012, {"rod_length": 0.13}),
    "quick_return": (0.2, {"r": 0.09}),
    "scissor_lift": (0.1, {"aside": 0.1}),
    "fourbar_onesided": (0.2, {"l2": 0.61}),  # that moves the start, and loops close anew
    "bouncing_pin": (0.01, {"c": 0.0008}),
    "gear_rattle": (0.3, {"R_1": 0.041}),
    "slider_crank_oil": (0.006, {"c": 4e-5}),
}


@pytest.mark.parametrize("name", TURNED)
def test_the_motion_is_that_of_simulate_also_when_a_parameter_is_turned(name, tmp_path):
    """The same steps; rounding alone is between the curves, which impacts magnify."""
    live, m = program_of(name)
    end, change = TURNED[name]
    assert set(change) <= set(live.parameters)
    for run in computed(tmp_path, live, {}, change, t_end=end):
        r = simulated(m, run, end)
        assert run["success"]
        assert run["stats"]["steps"] == pytest.approx(r.stats["steps"], rel=0.03, abs=2)
        assert apart(run, r, [name for name in run["names"] if name.endswith((".x", ".y", ".angle"))]) < 1e-9
        assert apart(run, r) < 1e-6
        assert [(event[1], event[2]) for event in run["events"]] == [(event.joint, event.kind) for event in r.events]


@pytest.mark.parametrize(("name", "end"), [("dc_motor_pid", 0.5), ("double_wishbone", 0.3), ("toggle", 0.1)])
def test_steps_end_where_expressions_switch(name, end, tmp_path):
    """Currents that saturate, tyres that lift off, a stop: what a step across such a kink would miss shows at once."""
    live, m = program_of(name)
    run = computed(tmp_path, live, t_end=end)
    r = simulated(m, run, end)
    assert run["success"]
    assert apart(run, r, [name for name in run["names"] if name.endswith((".x", ".y", ".angle"))]) < 1e-10
    assert apart(run, r) < 1e-6
    as_written = m.simulate(1e-3 * end)  # with plain numbers for parameters, signals of them have no unit
    assert run["units"] == {name: as_written.unit(name) for name in run["names"]}


PULSE = """
format = 1
[parameters]
width = { value = "5 ms", min = "1 ms", max = "20 ms" }
[bodies.block]
points = { P = [0, 0] }
mass = 2
inertia = 1
[ground.points]
O = [0, 0]
[joints.guide]
type = "prismatic"
connect = ["ground.O", "block.P"]
[loads.kick]
type = "force"
at = "block.P"
force = ["100 if t > 0.1 and t < 0.1 + width else 0", 0]
[initial]
block = { x = 0, vx = 0 }
[simulate]
t_end = 1
"""


def test_a_pulse_of_any_width_is_not_missed_in_a_page(tmp_path):
    """v = F width / m for pulses of a hundredth of the run: closed form, beyond the end of the model too."""
    live = live_model(rt.loads(PULSE))
    for t_end in (1.0, 2.0):
        for run in computed(tmp_path, live, {}, {"width": 0.012}, t_end=t_end):
            wanted = 100.0 * run["parameters"]["width"] / 2.0
            assert run["columns"]["block.vx"][-1] == pytest.approx(wanted, rel=1e-9)


@pytest.mark.parametrize(
    ("name", "end", "values"), [("excavator", 7.0, (2.1, 5.3)), ("scissor_lift", 11.0, (6.0, 17.0))]
)
def test_parameters_move_instants_of_expressions_of_time(name, end, values, tmp_path):
    """The end of the stroke, of which T is the time: the same steps end there, beyond the end of the model too."""
    live, m = program_of(name)
    for run in computed(tmp_path, live, *({"T": value} for value in values), t_end=end):
        r = simulated(m, run, end)
        assert run["success"]
        assert run["stats"]["steps"] == pytest.approx(r.stats["steps"], rel=0.03, abs=2)
        assert apart(run, r, [name for name in run["names"] if name.endswith((".x", ".y", ".angle"))]) < 1e-9
        assert apart(run, r) < 1e-6
        assert [(event[1], event[2]) for event in run["events"]] == [(event.joint, event.kind) for event in r.events]


KNOTS = """
format = 1
parameters = { late = 0.1, tooth = 0.1 }
tables.push = { x = [0, "late", 1], y = [0, 2, 0] }
ground.points = { O = [0, 0] }
bodies.rod = { bar = ["A", "B"], length = 1.0, mass = 1.0 }
joints.O = { type = "revolute", connect = ["ground.O", "rod.A"] }
loads.hand = { type = "torque", body = "rod", torque = "push(t) + mod(t, tooth)" }
simulate.t_end = 1
"""


def test_knots_of_tables_and_thousands_of_instants_follow_from_parameters(tmp_path):
    m = rt.loads(KNOTS)
    for run in computed(tmp_path, live_model(m), {"late": 0.37}, {"tooth": 0.0005}):
        r = simulated(m, run)
        assert run["success"]
        assert run["stats"]["steps"] == r.stats["steps"]
        assert apart(run, r, ["rod.x", "rod.angle", "rod.omega"]) < 1e-9


def test_rates_that_are_not_given_are_those_of_the_mechanism_without_play(tmp_path):
    """The page solves for them anew: the start and the motion are those of the assembly."""
    m = rt.loads(rt.example("fourbar").to_toml().replace(", omega = 0", ""))
    live = live_model(m)
    for run in computed(tmp_path, live, {}, {"r3": 0.003, "l1": 0.19}, {"omega": 7.0, "alpha": 1.1}, t_end=0.01):
        r = simulated(m, run, 0.01)
        assert apart(run, r, [name for name in run["names"] if name.endswith((".x", ".y", ".angle", ".omega"))]) < 1e-10


def test_values_of_the_start_are_rounded_in_a_model_file_and_parameters_may_change_nevertheless(tmp_path):
    """A given angle that closes a loop to nine digits only: loads and masses have nothing to do with it."""
    live, m = program_of("excavator")
    run = computed(tmp_path, live, {"payload": 0.0, "r": 0.25}, t_end=0.1)
    assert apart(run, simulated(m, run, 0.1)) < 1e-7


def test_a_motion_through_singular_positions_goes_on_as_in_python(tmp_path):
    """The rods of the windows fall into one line at 0.708 s: steps leap across."""
    live, m = program_of("windows")
    run = computed(tmp_path, live, t_end=1.0)
    assert run["success"]
    assert apart(run, simulated(m, run, 1.0), ["p1.x", "p1.y"]) < 1e-6


def test_a_run_that_ends_beside_a_singular_position_leaves_its_forces_out_as_in_python(tmp_path):
    m = rt.loads(SCISSOR)
    run, r = computed(tmp_path, live_model(m), t_end=0.32), m.simulate(0.32)
    assert run["trust"]["singular"] == pytest.approx(r.trust.singular, rel=1e-6)
    assert "the table leaves out 0.3149 to 0.32 s" in "".join(run["trust"]["text"])
    left_out = [name for name in run["names"] if np.isnan(r[name]).any()]
    assert left_out
    for name in left_out:
        np.testing.assert_array_equal(np.isnan(run["columns"][name]), np.isnan(r[name]))


def test_trust_says_what_python_says(tmp_path):
    """In its words, to the digit: the pulls of links are located, the horizon is that of a tighter run."""
    live, m = program_of("fourbar")
    run = computed(tmp_path, live, t_end=0.1, horizon=True)
    r = simulated(m, run, 0.1, horizon=True)
    said, want = ("\n".join(run["trust"]["text"]), str(r.trust))
    assert said.split(", energy error")[1] == want.split(", energy error")[1]
    assert run["trust"]["pulled"] == pytest.approx(dict(r.trust.pulled), abs=1e-6)
    assert run["trust"]["first_pull"] == pytest.approx(dict(r.trust.first_pull), abs=1e-9)
    assert run["trust"]["energy_share"] == pytest.approx(r.trust.energy_share, rel=0.01)


def test_a_chaotic_motion_has_a_horizon(tmp_path):
    live, _ = program_of("double_pendulum")
    run = computed(tmp_path, live, horizon=True)
    assert 8.0 < run["trust"]["horizon"] < 14.0
    assert run["trust"]["text"][1].endswith("(horizon), after it statistics only")


STEEP_RAIL = """
format = 1
[parameters]
tilt = { value = "15 deg", min = "-80 deg", max = "80 deg" }
[ground.points]
O = [0, 0]
S = [0.3, 0.1]
[bodies.crank]
points = { O = [0, 0], A = [0.05, 0] }
mass = 1
inertia = 0.01
[bodies.slide]
points = { P = [0, 0] }
mass = 0.5
inertia = 0.002
[joints.O]
type = "revolute"
connect = ["ground.O", "crank.O"]
[joints.rail]
type = "prismatic"
connect = ["ground.S", "slide.P"]
axis = "tilt"
[joints.rod]
type = "rod"
connect = ["crank.A", "slide.P"]
length = 0.27
[drivers.motor]
joint = "O"
angle = "12*t"
[initial]
crank = { angle = 0 }
slide = { x = 0.25 }
[simulate]
t_end = 1
"""


def test_a_run_that_ends_at_a_dead_centre_is_said_to_have_ended_and_so_are_values_of_the_start(tmp_path):
    """A rail so steep that the rod cannot get round: `simulate` ends there too."""
    m = rt.loads(STEEP_RAIL)
    live = live_model(m)
    assert any("asked for slide.x = 0.25 m, got " in note for note in live.notes)
    run = computed(tmp_path, live, {"tilt": 1.3962634015954636})
    r = m.set(tilt=1.3962634015954636).simulate()
    assert (run["success"], r.success) == (False, False)
    assert f"t = {r.trust.t_end:.4g}" in run["message"]
    assert run["trust"]["t_end"] == pytest.approx(r.trust.t_end, rel=1e-4)


LOOP = """
format = 1
[parameters]
rod = { value = "0.5 m", min = "0.4 m", max = "1 m" }
[ground.points]
A = [0, 0]
D = [0.8, 0]
[bodies.crank]
bar = ["A", "B"]
length = 0.3
mass = 1
[bodies.link]
bar = ["B", "C"]
length = "rod"
mass = 1
[bodies.rocker]
bar = ["D", "C"]
length = 0.5
mass = 1
[joints.A]
type = "revolute"
connect = ["ground.A", "crank.A"]
[joints.B]
type = "revolute"
connect = ["crank.B", "link.B"]
[joints.C]
type = "revolute"
connect = ["link.C", "rocker.C"]
[joints.D]
type = "revolute"
connect = ["ground.D", "rocker.D"]
[drivers.motor]
joint = "A"
angle = "1 + 2*t"
[initial]
link = { angle = 0.3 }
rocker = { angle = 1.9 }
[simulate]
t_end = 1
"""


def test_a_step_that_tears_joints_apart_ends_the_run_in_words(tmp_path):
    text = rt.example("double_pendulum").to_toml() + '\nmethod = "rk4"\nstep = 1.0\n'
    m = rt.loads(text)
    run = computed(tmp_path, live_model(m, 20.0))
    r = m.simulate(20.0)
    assert not run["success"]
    assert run["message"].split("'")[0] == r.message.split("'")[0] == "ended at t = 0 s, before "
    assert run["n"] == len(r.t) < 21


def test_parameters_that_do_not_close_are_refused_in_words(tmp_path):
    run = computed(tmp_path, program_of("slider_crank")[0], {"rod_length": 0.01})
    assert "rod_length = 0.01 is outside of its limits" in run["error"]
    refused, good = computed(
        tmp_path, live_model(rt.loads(LOOP.replace("0.4 m", "0.01 m"))), {"rod": 0.02}, {"rod": 0.5}, t_end=0.05
    )
    assert "cannot be put together" in refused["error"]
    assert good["success"]


def test_a_page_stays_with_the_closing_that_it_has(tmp_path):
    """Python may take another half of the loop for a length far away; the page goes on with its own, or says so."""
    m = rt.loads(LOOP)
    run = computed(tmp_path, live_model(m), {"rod": 0.52}, t_end=0.01)
    assert apart(run, simulated(m, run, 0.01), ["link.angle", "rocker.angle"]) < 1e-9


# ---------------------------------------------------------------- the drawing
@pytest.mark.parametrize("name", ["fourbar", "double_wishbone", "five_bar", "scissor_lift"])
def test_the_drawing_follows_the_parameters(name, tmp_path):
    """Every number of it is that of the model at these parameters."""
    live, m = program_of(name)
    change = {
        key: one.value * 1.02 + (0.01 if one.value == 0.0 else 0.0) for key, one in live.parameters.items()
    }  # fmt: skip
    own, turned = computed(tmp_path, live, {}, change, t_end=1e-9)
    same_numbers(own["geometry"], geometry(m.model))
    same_numbers(turned["geometry"], geometry(m.set(change).model))


def same_numbers(got, want):
    if isinstance(want, dict):
        assert got.keys() == want.keys()
        for key, inner in want.items():
            same_numbers(got[key], inner)
    elif isinstance(want, list | tuple):
        assert len(got) == len(want)
        for one, other in zip(got, want, strict=True):
            same_numbers(one, other)
    elif isinstance(want, float):
        assert got == pytest.approx(want, rel=1e-12, abs=1e-14)
    else:
        assert got == want


FREE = LOOP.replace("link = { angle = 0.3 }\nrocker = { angle = 1.9 }\n", "").replace(
    '[drivers.motor]\njoint = "A"\nangle = "1 + 2*t"\n', ""
)


def test_a_start_that_is_one_of_several_is_that_of_python(tmp_path):
    """Nothing says where the crank begins: the closing that is chosen is that of `set`, however long the rod."""
    m = rt.loads(FREE)
    for run in computed(tmp_path, live_model(m), {}, {"rod": 0.6}, {"rod": 0.45}, t_end=0.05):
        assert apart(run, simulated(m, run, 0.05)) < 1e-6


KICKED = LOOP.replace('"1 + 2*t"', '"1 + 2*t + w*max(0, t - late) + leap*step(t - late)"').replace(
    "[parameters]", "[parameters]\nw = 0\nlate = 0.03\nleap = 0"
)


def test_jumps_of_drivers_follow_from_parameters(tmp_path):
    """A jolt where the model has none, at any instant, and the words on it; who jumps in position is refused."""
    m = rt.loads(KICKED)
    live = live_model(m)
    runs = computed(tmp_path, live, {"w": 1.5, "late": 0.02}, {"w": -0.7}, {"w": 1.0, "late": 0.09}, {}, t_end=0.05)
    for run, jolts in zip(runs, (1, 1, 0, 0), strict=True):
        r = simulated(m, run, 0.05)
        assert run["stats"]["steps"] == r.stats["steps"]
        assert apart(run, r) < 1e-6
        assert [event[2] for event in run["events"]] == ["jolt"] * jolts
        for event, wanted in zip(run["events"], r.events, strict=True):
            numbers = wanted.t, wanted.normal_speed, wanted.impulse, wanted.energy_lost
            assert [event[0], event[3], *event[6:8]] == pytest.approx(numbers, rel=1e-9)
        notes = [[note for note in said if "jumps in speed" in note] for said in (run["trust"]["notes"], r.trust.notes)]
        assert notes[0] == notes[1]
    error = computed(tmp_path, live, {"leap": 0.2}, t_end=0.05)["error"]
    with pytest.raises(rt.ModelError) as refused:
        m.set(leap=0.2).simulate(0.05)
    assert error in str(refused.value)
    assert "jumps by 0.2 rad at t = 0.03 s" in error


def test_parameters_may_have_the_names_of_what_every_object_has(tmp_path):
    text = LOOP.replace("rod =", "constructor =").replace('"rod"', '"constructor"')
    own, turned = computed(tmp_path, live_model(rt.loads(text)), {}, {"constructor": 0.52}, t_end=0.05)
    assert own["parameters"] == {"constructor": 0.5}
    assert turned["parameters"] == {"constructor": 0.52}


def test_what_no_page_can_follow_hides_nothing_of_other_parameters():
    """The cam's radius cannot be recorded."""
    text = rt.example("cam_lift_off").to_toml().replace("[parameters]", "[parameters]\nlate = 0.01")
    kick = '\n[loads.kick]\ntype = "force"\nat = "follower.F"\nforce = [0, "1 if t > late else 0"]\n'
    live = live_model(rt.loads(text + kick))
    assert live.fixed["R"].startswith("only rattle itself")
    assert {"late", "speed"} <= set(live.parameters)


def test_a_run_of_more_steps_than_a_page_takes_says_so(tmp_path):
    live = live_model(rt.example("slider_crank"))
    live.data["settings"]["most_steps"] = 20
    assert "after 20 steps, the most of a page" in computed(tmp_path, live)["message"]
