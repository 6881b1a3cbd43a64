"""Models with contacts and events as FMUs: co-simulation moves them as `rattle run` does, events included."""

import io
import itertools
import shutil
import subprocess
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from click.testing import CliRunner

import rattle as rt
from mock_up_unit import Unit
from rattle.cli.main import main
from rattle.errors import TraceError
from rattle.pages import compiled_unit as units
from rattle.pages.engine import kernels_of_platform

pytestmark = [
    pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler"),
]
PIN = """
format = 1
[parameters]
c = { value = 1e-3, min = 1e-4, max = 2e-3 }
v0 = { value = 0.5, min = 0.1, max = 2 }
e = { value = 0.8, min = 0, max = 1 }
[ground.points]
O = [0, 0]
[bodies.pin]
points = { P = [0, 0] }
mass = 3
inertia = 0.001
[joints.O]
type = "revolute"
connect = ["ground.O", "pin.P"]
clearance = "c"
contact = { model = "impact", restitution = "e", bush_radius = 0.01 }
[initial]
pin = { angle = 0, omega = 0, vx = "v0" }
O = { offset = [0, 0] }
[simulate]
t_end = "15 ms"
output = "0.1 ms"
"""
TURNED = f"""{PIN}
[loads.push]
type = "force"
at = "pin.P"
force = ["3 N * (1 - 2*step(t - 4 ms))", 0]
"""
STEPPED = TURNED.replace("2*step(t - 4 ms)", "floor(t/1 ms)")
EVENTS = {"eventModeUsed": True, "earlyReturnAllowed": True}


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """A function: the FMU of a model, each written once."""
    folder, made = tmp_path_factory.mktemp("units"), {}
    kernels_of_platform()  # compiled once for all of them

    def one(name):
        if name not in made:
            made[name] = folder / f"{name}.fmu"
            made[name].write_bytes(units.compiled_unit(model(name), name, model(name).model.settings.t_end).content)
        return str(made[name])

    return one


@pytest.fixture
def opened(written):
    made = []

    def unit(name, **how):
        made.append(Unit(written(name), **how))
        return made[-1]

    yield unit
    for one in made:
        one.fmu.freeInstance()
        shutil.rmtree(one.folder)


def model(name):
    if name == "wide":  # it can be told lengths that fit nowhere
        return rt.example("fourbar_onesided").set({"parameters.l2.max": 10.0, "parameters.l1.max": 1.0})
    texts = {"pin": PIN, "turned": TURNED, "stepped": STEPPED}
    return rt.loads(texts[name]) if name in texts else rt.example(name)


def events_of(unit, end, step):
    """Instants at which steps end early [s], where a run begins that is told so."""
    found, t = [], 0.0
    unit.fmu.enterStepMode()
    while t < end * (1.0 - 1e-12):
        asked = min(step, end - t)
        needed, _, early, t = unit.fmu.doStep(t, asked)
        assert needed == early
        if early:
            found.append(t)
            unit.fmu.enterEventMode()
            unit.fmu.updateDiscreteStates()
            unit.fmu.enterStepMode()
    return np.array(found)


# ---------------------------------------------------------------- judged by FMPy
@pytest.mark.parametrize("name", ["pin", "woodpecker", "fourbar_oil"])
def test_the_judge_finds_no_fault(name, written):
    validation = pytest.importorskip("fmpy.validation")
    assert validation.validate_fmu(written(name)) == []


def test_a_thrown_pin_follows_its_closed_form_for_other_parameters_too(written):
    fmpy = pytest.importorskip("fmpy")
    for c, v, e in ((1e-3, 0.5, 0.8), (7e-4, 0.5, 0.8), (1e-3, 0.9, 0.6)):
        found = fmpy.simulate_fmu(
            written("pin"), stop_time=0.015, output_interval=5e-4, fmi_type="CoSimulation", output=["pin.x"],
            start_values={"c": c, "v0": v, "e": e},
        )  # fmt: skip
        t, side, hit, speed = found["time"], 1.0, c / v, v
        x = v * t
        for _ in range(40):
            after = t >= hit - 1e-12
            speed *= e
            x[after] = side * c - side * speed * (t[after] - hit)
            hit, side = hit + 2.0 * c / speed, -side
        np.testing.assert_allclose(found["pin.x"], x, atol=1e-11)


RUNS = [
    ("slider_crank_play", {}),
    pytest.param("fourbar_onesided", {}, marks=pytest.mark.long),
    ("fourbar_onesided", {"r3": 0.004, "l2": 0.61}),
    ("woodpecker", {}),
    ("ratchet", {}),
    ("belt_drive", {}),
    ("fourbar_oil", {}),
    ("scissor_lift", {"T": 6.0}),  # instants of expressions of time follow from it
]


@pytest.mark.parametrize(("name", "changes"), RUNS)
def test_contacts_and_curves_are_those_of_a_run(name, changes, opened):
    """At communication points that fall anywhere; FMI knows of no end of the run, so that the model's own is told."""
    m = model(name).set(**changes)
    end = m.model.settings.t_end
    run = m.simulate(t_eval=np.linspace(0.0, end, 38))
    names = [name for name in run.names if name != "energy.balance"]
    for how in ({}, EVENTS):
        unit = opened(name, **how)
        unit.set(**changes)
        unit.begin(stopTime=end)
        if how:
            found = events_of(unit, end, end / 7.0)
            listed = np.array([event.t for event in run.events if 0.0 < event.t < end][:10])
            assert len(found) > 0
            assert max((np.abs(found - t).min() for t in listed), default=0.0) <= 1e-9
            continue
        for k, t in enumerate(run.t):
            if k:
                unit.fmu.doStep(run.t[k - 1], t - run.t[k - 1])
            np.testing.assert_allclose(unit.get(*names), [run[one][k] for one in names], rtol=1e-9, atol=1e-9)


def test_a_state_is_saved_between_events_and_goes_on_as_before(opened):
    unit = opened("woodpecker")
    unit.begin()
    unit.fmu.doStep(0.0, 0.07)
    state, ends = unit.fmu.getFMUState(), []
    names = ("bird.angle", "bird.omega", "energy.dissipated")
    for _ in range(2):
        unit.fmu.setFMUState(state)
        unit.fmu.doStep(0.07, 1e-5)
        unit.fmu.doStep(0.07001, 0.05)
        ends.append(unit.get(*names))
    unit.fmu.freeFMUState(state)
    assert ends[0] == ends[1]
    assert unit.description.coSimulation.canGetAndSetFMUstate


def test_communication_points_change_nothing(opened):
    """However close they are: the steps are those of a run that knows of none."""
    ends = []
    for steps in (3, 400):
        unit = opened("fourbar_onesided")
        unit.begin(stopTime=0.1)
        times = np.linspace(0.0, 0.1, steps + 1)
        for a, b in itertools.pairwise(times):
            unit.fmu.doStep(a, b - a)
        ends.append(unit.get("rocker.angle", "rocker.omega", "O3.normal", "energy.dissipated"))
    np.testing.assert_allclose(ends[0], ends[1], rtol=1e-12, atol=1e-15)


def test_an_event_at_a_communication_point_is_told_there(opened):
    """Without a step of no length after it."""
    unit = opened("woodpecker", **EVENTS)
    unit.begin(stopTime=1.0)
    times = [t for t in events_of(unit, 0.2, 0.2) if t <= 0.2]
    unit = opened("woodpecker", **EVENTS)
    unit.begin(stopTime=1.0)
    unit.fmu.enterStepMode()
    t = 0.0
    for event in times:
        while t < event:  # a sum of a point and a step is rounded
            needed, _, _, after = unit.fmu.doStep(t, event - t)
            assert after > t
            t = after
        assert needed


@pytest.mark.parametrize(("name", "end"), [("turned", 0.015), ("drawer", 1.0)])
def test_sums_of_communication_steps_go_on_to_the_end(name, end, opened):
    """They are rounded, and no step of a run is that short; expressions of time switch up to the end as written."""
    last = model(name).simulate(t_eval=[0.0, end])
    unit = opened(name)
    unit.begin(stopTime=end)
    unit.fmu.doStep(0.0, end)
    for share in (2.0**-52, 1e-15, 1e-13):
        unit.fmu.doStep(unit.get("t")[0], share * end)
    assert unit.get("t")[0] > end
    name = next(name for name in last.names if name.endswith(".x"))
    assert unit.get(name) == pytest.approx([last[name][-1]], rel=1e-9, abs=1e-12)


def test_equal_steps_go_on_beyond_the_end_of_the_run(opened):
    """To the time that was asked for, wherever communication points are: the model's own end is 1 s."""
    run = model("three_plays").simulate(t_eval=[0.0, 1.0, 1.25], t_end=1.25)
    for times in ([0.0, 1.0, 1.25], [0.0, 0.75, 1.25], [0.0, 0.001, 1.25]):
        unit = opened("three_plays")
        unit.begin()
        for a, b in itertools.pairwise(times):
            unit.fmu.doStep(a, b - a)
        names = ("crank.angle", "coupler.angle", "rocker.angle")
        assert unit.get(*names) == pytest.approx([run[name][-1] for name in names], rel=1e-9)


def test_a_stop_time_that_never_comes_is_no_scale_for_events(opened):
    ends = []
    for stop in (0.024, 1e12, float("inf")):
        unit = opened("slider_crank_play")
        unit.begin(stopTime=stop)
        unit.fmu.doStep(0.0, 0.01)
        ends.append(unit.get("slider.x", "B.normal"))
    np.testing.assert_allclose(ends[1:], [ends[0]] * 2, rtol=1e-6)


def test_it_is_told_when_instants_are_too_many(opened):
    unit = opened("stepped")
    unit.begin(stopTime=0.015)
    assert not unit.said
    unit.fmu.reset()
    unit.begin(stopTime=float("inf"))
    assert "switches too often up to 15000 s to follow" in unit.said[-1]
    unit.fmu.reset()
    with pytest.raises(pytest.importorskip("fmpy.fmi1").FMICallException):
        unit.begin(stopTime=15.0)
    assert "than the model has room for" in unit.said[-1]


def test_energies_are_compared_with_those_between_communication_points_too(opened):
    """The door is at rest at both."""
    unit = opened("door_closer")
    unit.begin(stopTime=5.0)
    unit.fmu.doStep(0.0, 3.0)
    assert unit.said == []


def test_a_state_goes_on_in_another_instance(opened):
    unit, ends = opened("woodpecker"), []
    first = unit.fmu.component
    unit.begin()
    unit.fmu.doStep(0.0, 0.07)
    state = unit.fmu.getFMUState()
    unit.fmu.instantiate()
    second = unit.fmu.component
    unit.fmu.setFMUState(state)
    for one in (first, second):
        unit.fmu.component = one
        unit.fmu.doStep(0.07, 0.05)
        ends.append(unit.get("bird.angle", "bird.omega", "energy.dissipated"))
        unit.fmu.doStep(0.12, 0.2)
    unit.fmu.freeFMUState(state)
    unit.fmu.fmi3FreeInstance(first)
    assert ends[0] == ends[1]


# ---------------------------------------------------------------- refused
def test_what_has_no_start_or_another_form_is_an_error_with_its_reason(opened):
    failed = pytest.importorskip("fmpy.fmi1").FMICallException
    unit = opened("wide")
    for values, why in (
        ({"l2": 5.0}, "cannot be put together"),
        ({"l2": float("nan")}, "l2 is not a finite number"),
        ({"r3": -1.0}, "is not between its limits"),
    ):
        unit.set(**values)
        unit.fmu.enterInitializationMode()
        with pytest.raises(failed):
            unit.fmu.exitInitializationMode()
        assert why in unit.said[-1]
        unit.fmu.reset()
    unit.begin()
    with pytest.raises(failed):
        unit.set(l2=0.6)
    assert "cannot change during a run" in unit.said[-1]
    with pytest.raises(failed):
        unit.fmu.doStep(0.5, 1e-3)
    assert "the model is at 0 s" in unit.said[-1]
    unit.fmu.doStep(0.0, 1e-3)


def test_a_run_that_cannot_go_on_ends_until_an_earlier_state_is_set(opened):
    failed = pytest.importorskip("fmpy.fmi1").FMICallException
    unit = opened("wide")
    unit.set(l1=0.7)  # the crank cannot turn about
    unit.begin(stopTime=0.5)
    unit.fmu.doStep(0.0, 0.1)
    state, before = unit.fmu.getFMUState(), unit.get("t", "crank.angle")
    with pytest.raises(failed):
        unit.fmu.doStep(0.1, 0.05)
    assert "t = 0.115" in unit.said[-1]
    assert unit.get("t", "crank.angle") == before
    with pytest.raises(failed):
        unit.fmu.doStep(0.1, 0.005)
    unit.fmu.setFMUState(state)
    unit.fmu.freeFMUState(state)
    unit.fmu.doStep(0.1, 0.005)
    assert unit.get("crank.angle") == pytest.approx([before[1] + 10.0 * 0.005])


def test_it_is_for_co_simulation_only(written):
    fmi3 = pytest.importorskip("fmpy.fmi3")
    import fmpy

    description = fmpy.read_model_description(written("pin"))
    assert description.modelExchange is None
    assert description.coSimulation.hasEventMode
    assert description.coSimulation.mightReturnEarlyFromDoStep
    folder = fmpy.extract(written("pin"))
    unit = fmi3.FMU3Model(
        guid=description.guid, unzipDirectory=folder, modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="a",
    )  # fmt: skip
    with pytest.raises(Exception, match="instantiate"):
        unit.instantiate()
    shutil.rmtree(folder)


def test_laws_in_python_are_refused_as_in_pages(laws):
    @rt.load_law("wind", c="N")
    def wind(t, state, p):
        return p.c, 0.0, 0.0

    m = model("pin")
    m.load("air", "wind", body="pin", c="1 N")
    with pytest.raises(TraceError, match="law in Python"):
        units.compiled_unit(m, "law", 1.0)


@pytest.mark.usefixtures("written")
def test_without_a_compiler_nothing_is_written(tmp_path, monkeypatch):
    program = tmp_path / "broken"
    program.write_text("#!/bin/sh\necho no licence; exit 3\n")
    program.chmod(0o755)
    monkeypatch.setenv("CC", str(program))
    done = CliRunner().invoke(main, ["code", "woodpecker", "-o", str(tmp_path / "a.fmu")])
    assert done.exit_code == 2
    assert "no licence" in done.stderr
    assert not (tmp_path / "a.fmu").exists()


# ---------------------------------------------------------------- what is in the file
@pytest.mark.usefixtures("written")
def test_descriptions_of_parameters_may_hold_what_xml_cannot():
    text = PIN.replace("c = { value", 'c = { description = "a <b> & \\u0001 */", value')
    with zipfile.ZipFile(io.BytesIO(units.compiled_unit(rt.loads(text), "pin", 0.015).content)) as opened:
        variables = ElementTree.fromstring(opened.read("modelDescription.xml")).iter("Float64")
    assert {one.get("name"): one.get("description") for one in variables}["c"] == "a <b> & \\x01 */"


def test_the_same_model_gives_the_same_bytes_and_no_place_of_this_machine(written):
    again = units.compiled_unit(model("pin"), "pin", 0.015).content
    assert Path(written("pin")).read_bytes() == again
    with zipfile.ZipFile(written("pin")) as opened:
        for name in opened.namelist():
            assert str(Path.cwd()).encode() not in opened.read(name)


def test_its_c_is_strict_and_fits_the_declarations_of_the_standard(tmp_path, monkeypatch):
    fmpy = pytest.importorskip("fmpy")
    kept = {}

    def keep(files, main, kernels):
        kept.update(files)
        return b""

    monkeypatch.setattr(units.fmu, "shared_library", keep)
    units.compiled_unit(model("fourbar_oil"), "oil", 0.1)
    for name, text in kept.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    strict = ["cc", "-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-Wno-unused-parameter", "-O0", "-c"]
    for more in ([], ["-include", f"{fmpy.__path__[0]}/c-code/fmi3Functions.h"]):
        command = [*strict, *more, str(tmp_path / units.MAIN), "-o", str(tmp_path / "a.o")]
        subprocess.run(command, check=True, timeout=300)
