"""A live page computes the motion that `simulate` computes: the same steps, checks and words."""

import shutil

import numpy as np
import pytest

import rattle as rt
from live import computed, program_of
from rattle.errors import TraceError
from rattle.pages.live_program import live_program
from rattle.results.columns import geometry

pytestmark = pytest.mark.skipif(shutil.which("node") is None, reason="no node")


def simulated(m, run, live, **settings):
    """The same motion by Python: at the instants, with the settings of a run of the page."""
    s = {**live.settings, **settings}
    return m.set(**run["parameters"]).simulate(
        s["t_end"], t_eval=run["t"], method=s["method"], rtol=s["rtol"], atol=s["atol"], step=s["step"],
        horizon=settings.get("horizon", False),
    )  # fmt: skip


def apart(run, r, names=None):
    """The largest difference of any curve, as a share of its largest value (or of the largest of its unit)."""
    widest = {}
    for name in r.names:
        widest[r.unit(name)] = max(widest.get(r.unit(name), 0.0), float(np.abs(r[name]).max()))
    return max(
        float(np.abs(run["columns"][name] - r[name]).max()) / max(widest.get(r.unit(name), 0.0), 1e-6)
        for name in names or run["names"]
    )


EQUAL = {  # steps of equal length: s, steps, changed parameters
    "fourbar": (0.02, 200, {"r3": 0.003, "M": -20.0}),
    "double_pendulum": (0.2, 100, {"upper_length": 0.38, "start": 1.1}),
    "slider_crank": (0.012, 200, {"rod_length": 0.13}),
    "squeezer": (0.004, 60, {"mom": 0.04}),
    "quick_return": (0.2, 60, {"r": 0.09}),
}


@pytest.mark.parametrize("name", EQUAL)
def test_equal_steps_give_the_curves_of_simulate(name, tmp_path):
    """Rounding alone is between them, which forces over short lengths magnify."""
    live, m = program_of(name)
    end, steps, change = EQUAL[name]
    for p in ({}, change):
        settings = {"method": "rk4", "t_end": end, "step": end / steps, "outputs": 5}
        run = computed(tmp_path, live, p, **settings)
        assert run["stats"]["steps"] == steps
        assert run["parameters"] == {**run["parameters"], **p}
        assert apart(run, simulated(m, run, live, **settings)) < 1e-10


ADAPTIVE = {
    "fourbar": (0.03, {"r3": 0.003}),
    "chain": (0.02, {}),
    "scissor_lift": (0.1, {"aside": 0.1}),
    "five_bar": (0.3, {}),
}


@pytest.mark.parametrize("name", ADAPTIVE)
def test_the_usual_method_takes_the_steps_of_simulate(name, tmp_path):
    live, m = program_of(name)
    end, change = ADAPTIVE[name]
    run = computed(tmp_path, live, change, t_end=end, outputs=30)
    r = simulated(m, run, live, t_end=end)
    assert (run["stats"]["steps"], run["stats"]["rejected"]) == (r.stats["steps"], r.stats["rejected"])
    assert apart(run, r, [name for name in run["names"] if name.endswith((".x", ".y", ".angle"))]) < 1e-9
    assert apart(run, r) < 1e-7
    as_written = m.simulate(1e-3 * end)  # with plain numbers for parameters, signals of them have no unit
    assert run["units"] == {name: as_written.unit(name) for name in run["names"]}


@pytest.mark.parametrize(("name", "end"), [("dc_motor_pid", 0.5), ("double_wishbone", 0.3), ("toggle", 0.1)])
def test_steps_end_where_expressions_switch(name, end, tmp_path):
    """Currents that saturate, tyres that lift off, a stop: what a step across such a kink would miss shows at once."""
    live, m = program_of(name)
    run = computed(tmp_path, live, t_end=end, outputs=100)
    r = simulated(m, run, live, t_end=end)
    assert run["success"]
    assert apart(run, r, [name for name in run["names"] if name.endswith((".x", ".y", ".angle"))]) < 1e-10
    assert apart(run, r) < 1e-6


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


def test_a_short_pulse_is_not_stepped_over(tmp_path):
    """v = F width / m for a pulse of a hundredth of the run, whatever its width: closed form."""
    live = live_program(rt.loads(PULSE))
    for width in (0.005, 0.0123):
        run = computed(tmp_path, live, {"width": width})
        assert run["columns"]["block.vx"][-1] == pytest.approx(100.0 * width / 2.0, rel=1e-9)
        want = 50.0 * width * (0.9 - 0.5 * width)
        assert run["columns"]["block.x"][-1] == pytest.approx(want, rel=1e-9)


def test_rates_that_are_not_given_are_those_of_the_mechanism_without_play(tmp_path):
    """The page solves for them anew: the start and the motion are those of the assembly."""
    text = rt.example("fourbar").to_toml().replace(", omega = 0", "")
    m = rt.loads(text)
    live = live_program(m)
    for p in ({}, {"r3": 0.003, "l1": 0.19}, {"omega": 7.0, "alpha": 1.1}):
        run = computed(tmp_path, live, p, t_end=0.01, outputs=5)
        r = simulated(m, run, live, t_end=0.01)
        assert apart(run, r, [name for name in run["names"] if name.endswith((".x", ".y", ".angle", ".omega"))]) < 1e-10


def test_values_of_the_start_are_rounded_in_a_model_file_and_parameters_may_change_nevertheless(tmp_path):
    """A given angle that closes a loop to nine digits only: loads and masses have nothing to do with it."""
    live, _ = program_of("excavator")
    run = computed(tmp_path, live, {"payload": 0.0, "r": 0.25}, t_end=0.1, outputs=5)
    assert apart(run, simulated(rt.example("excavator"), run, live, t_end=0.1)) < 1e-7


def test_parameters_that_leave_the_start_as_it_is_need_no_given_start(tmp_path):
    live = live_program(rt.loads(PULSE.replace("x = 0, ", "")))
    run = computed(tmp_path, live, {"width": 0.01})
    assert run["columns"]["block.vx"][-1] == pytest.approx(0.5, rel=1e-9)
    assert "outside of its limits" in computed(tmp_path, live, {"width": 0.5})["error"]


def test_a_motion_through_singular_positions_goes_on_as_in_python(tmp_path):
    """The rods of the windows fall into one line at 0.708 s: steps leap across."""
    live, m = program_of("windows")
    run = computed(tmp_path, live, t_end=1.0, outputs=50)
    r = simulated(m, run, live, t_end=1.0)
    assert run["success"]
    assert apart(run, r, ["p1.x", "p1.y"]) < 1e-6


def test_trust_says_what_python_says(tmp_path):
    """In its words, to the digit: the pulls of links are located, the horizon is that of a tighter run."""
    live, m = program_of("fourbar")
    settings = {"t_end": 0.1, "outputs": 100, "horizon": True}
    run = computed(tmp_path, live, **settings)
    r = simulated(m, run, live, **settings)
    said, want = ("\n".join(run["trust"]["text"]), str(r.trust))
    # the constraint error is rounding, and the page corrects once more
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


def test_a_dead_centre_that_ends_a_run_is_named_and_so_are_values_of_the_start(tmp_path):
    """A rail so steep that the rod cannot get round: no load is to blame, and `simulate` ends there too."""
    m = rt.loads(STEEP_RAIL)
    live = live_program(m)
    assert any("asked for slide.x = 0.25 m, got " in note for note in live.notes)
    run = computed(tmp_path, live, {"tilt": 1.3962634015954636})
    r = m.set(tilt=1.3962634015954636).simulate()
    assert (run["success"], r.success) == (False, False)
    assert "dead centre" in run["message"]
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
    live, m = program_of("double_pendulum")
    settings = {"method": "rk4", "t_end": 20.0, "step": 1.0, "outputs": 20}
    run = computed(tmp_path, live, **settings)
    r = simulated(m, run, live, **settings)
    assert not run["success"]
    said, want = run["message"], r.message  # how far it would open is rounding, hugely magnified
    assert said.split("'")[0] == want.split("'")[0] == "ended at t = 0 s, before "
    assert said.split("energy: ")[1] == want.split("energy: ")[1]
    assert run["n"] == len(r.t) < 21


def test_parameters_that_do_not_close_are_refused_in_words(tmp_path):
    live, _ = program_of("slider_crank")
    run = computed(tmp_path, live, {"rod_length": 0.01})
    assert "outside of its limits" in run["error"]
    run = computed(tmp_path, program_of("quick_return")[0], {"d": 1e6})
    assert "outside of its limits" in run["error"]


# ---------------------------------------------------------------- the drawing
@pytest.mark.parametrize("name", ["fourbar", "double_wishbone", "five_bar", "scissor_lift"])
def test_the_drawing_follows_the_parameters(name, tmp_path):
    """Every number of it is that of the model at these parameters."""
    live, m = program_of(name)
    change = {one.name: one.value * 1.02 + (0.01 if one.value == 0.0 else 0.0) for one in live.program.parameters}
    script_run = computed(tmp_path, live, t_end=1e-9, outputs=1, rtol=1e-3, atol=1e-3)
    assert "error" not in script_run
    same_numbers(script_run["geometry"], geometry(m.model))
    made = drawn_at(tmp_path, change)
    same_numbers(made, geometry(m.set(**change).model))


def drawn_at(folder, change):
    """geometry(p) of the module in this folder."""
    import json
    import subprocess

    text = f'import {{ geometry }} from "./model.mjs"; console.log(JSON.stringify(geometry({json.dumps(change)})));'
    (folder / "drawn.mjs").write_text(text)
    done = subprocess.run(["node", "drawn.mjs"], cwd=folder, capture_output=True, text=True, check=True, timeout=60)
    return json.loads(done.stdout)


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


def test_a_start_far_from_the_model_s_is_said(tmp_path):
    """Far away the assembly of Python may take the other half of a loop; the page goes on with the one that it has."""
    live = live_program(rt.loads(LOOP))
    for rod, far in ((0.52, False), (0.95, True)):
        run = computed(tmp_path, live, {"rod": rod}, t_end=0.01, outputs=2)
        assert ("put together in several ways" in " ".join(run["trust"]["text"])) == far


def test_what_cannot_compute_in_a_page_says_why():
    with pytest.raises(TraceError, match="contacts begin and end"):
        live_program(rt.example("bouncing_pin"))
