"""Models as Functional Mock-up Units: what `rattle code -o model.fmu` writes is valid and moves as `simulate` does.

FMPy, which the project did not make, is the judge where it is installed.
"""

import shutil
import subprocess
import zipfile
from xml.etree import ElementTree

import numpy as np
import pytest
from click.testing import CliRunner

import rattle as rt
from mock_up_unit import Unit
from rattle.cli.main import main
from rattle.equations.state import state_layout

needs_cc = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
DEPENDENT = """
format = 1
gravity = [0, -9.81]
[parameters]
l = "0.5 m"
m = "2*l*kg_per_m"
kg_per_m = { value = "1.5 kg/m", min = "1 kg/m", max = "2 kg/m" }
drag = "0.02 N*s/m^1.5"
[ground.points]
O = [0, 0]
[bodies.arm]
bar = ["A", "B"]
length = "l"
mass = "m"
[joints.O]
type = "revolute"
connect = ["ground.O", "arm.A"]
[loads.push]
type = "torque"
body = "arm"
torque = "-drag*l**1.5*arm.omega*l"
[initial]
arm = { angle = "0.3 rad" }
"""
SPRING = """
format = 1
[parameters]
k = { value = 15, min = 5, max = 20 }
[ground.points]
O = [0, 0]
[bodies.block]
points = { P = [0, 0] }
mass = 1
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
block = { x = 0.5, vx = 0 }
"""


def written(path, *words):
    done = CliRunner().invoke(main, ["code", *words, "-o", str(path)])
    assert done.exit_code == 0, done.output
    return done


@pytest.fixture(scope="module")
def units(tmp_path_factory):
    """FMUs by name of the example, each written once."""
    folder, made = tmp_path_factory.mktemp("fmu"), {}

    def unit(name):
        if name not in made:
            made[name] = folder / f"{name}.fmu"
            written(made[name], name)
        return str(made[name])

    return unit


def described(path):
    """Description of an FMU, and its variables by name."""
    with zipfile.ZipFile(path) as opened:
        root = ElementTree.fromstring(opened.read("modelDescription.xml"))
    return root, {one.get("name"): one for one in root.find("ModelVariables")}


def differ(run, found, names):
    """Largest difference of curves, each as a share of the largest curve in its unit."""
    largest: dict[str, float] = {}
    for name in names:
        largest[run.unit(name)] = max(largest.get(run.unit(name), 0.0), float(np.abs(run[name]).max()))
    return max(np.abs(found[name] - run[name]).max() / (largest[run.unit(name)] or 1.0) for name in names)


# ---------------------------------------------------------------- what is in the file
@pytest.mark.nojit
def test_the_description_has_every_parameter_state_and_result_column_with_its_unit(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", "")
    monkeypatch.delenv("CC", raising=False)
    done = written(tmp_path / "a.fmu", "slider_crank")
    assert "no C compiler was found" in done.stderr
    assert "sources only" in done.stderr
    root, variables = described(tmp_path / "a.fmu")
    m = rt.example("slider_crank")
    recorded = m.recorded()
    for name, one in m.model.parameters.items():
        assert variables[name].get("causality") == "parameter"
        assert float(variables[name].get("start")) == one.value
        assert variables[name].get("unit", "") == one.unit
        assert float(variables[name].get("min")) == one.minimum
    outputs = {name for name, one in variables.items() if one.get("causality") == "output"}
    assert outputs == set(recorded.curves) | set(recorded.points)
    r = m.simulate(1e-5)
    assert all(variables[name].get("unit", "") == r.unit(name) for name in outputs)
    assert all(variables[name].get("description") for name in variables)
    references = {name: one.get("valueReference") for name, one in variables.items()}
    assert len(set(references.values())) == len(references)
    states = [name for name, _ in state_layout(m.system).units()]
    assert [one.get("valueReference") for one in root.iter("ContinuousStateDerivative")] == [
        references[f"der({name})"] for name in states
    ]
    assert [variables[f"der({name})"].get("derivative") for name in states] == [references[name] for name in states]
    powers = {one.get("name"): dict(one.find("BaseUnit").attrib) for one in root.iter("Unit")}
    assert powers["N*m"] == {"kg": "1", "m": "2", "s": "-2"}
    assert powers["rad/s"] == {"rad": "1", "s": "-1"}
    with zipfile.ZipFile(tmp_path / "a.fmu") as opened:
        assert not [name for name in opened.namelist() if name.startswith("binaries")]
        assert {"sources/buildDescription.xml", "sources/fmi3.c", "sources/equations.c"} <= set(opened.namelist())


@pytest.mark.nojit
def test_parameters_given_by_others_follow_them_and_broken_powers_have_no_base_units(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", "")
    monkeypatch.delenv("CC", raising=False)
    (tmp_path / "a.toml").write_text(DEPENDENT)
    written(tmp_path / "a.fmu", str(tmp_path / "a.toml"))
    root, variables = described(tmp_path / "a.fmu")
    causality = {name: variables[name].get("causality") for name in ("l", "m", "kg_per_m", "drag")}
    assert causality == {
        "l": "parameter", "m": "calculatedParameter", "kg_per_m": "parameter", "drag": "input"
    }  # fmt: skip
    (broken,) = (one for one in root.iter("Unit") if one.get("name") == variables["drag"].get("unit"))
    assert broken.find("BaseUnit") is None


@pytest.mark.nojit
def test_the_same_model_gives_the_same_bytes_and_no_place_of_this_machine(tmp_path, monkeypatch):
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        written(tmp_path / name / "model.fmu", "double_pendulum")
    content = (tmp_path / "a" / "model.fmu").read_bytes()
    assert content == (tmp_path / "b" / "model.fmu").read_bytes()
    with zipfile.ZipFile(tmp_path / "a" / "model.fmu") as opened:
        for name in opened.namelist():
            assert str(tmp_path).encode() not in opened.read(name)
            assert b"/tmp/" not in opened.read(name)


@pytest.mark.nojit
def test_what_cannot_be_written_is_refused_and_leaves_no_file(tmp_path):
    done = CliRunner().invoke(main, ["code", "fourbar", "--step", "1ms", "-o", str(tmp_path / "a.fmu")])
    assert done.exit_code == 2
    assert "--step" in done.stderr
    assert list(tmp_path.iterdir()) == []


@needs_cc
def test_a_compiler_that_fails_is_quoted_and_the_sources_stay(tmp_path, monkeypatch):
    program = tmp_path / "broken"
    program.write_text("#!/bin/sh\necho no licence; exit 3\n")
    program.chmod(0o755)
    monkeypatch.setenv("CC", str(program))
    done = written(tmp_path / "a.fmu", "double_pendulum")
    assert "no licence" in done.stderr
    assert (tmp_path / "a.fmu").exists()


@needs_cc
def test_sources_are_strict_c_and_fit_the_declarations_of_the_standard(tmp_path, units):
    fmpy = pytest.importorskip("fmpy")
    headers = f"{fmpy.__path__[0]}/c-code/fmi3Functions.h"
    with zipfile.ZipFile(units("slider_crank")) as opened:
        opened.extractall(tmp_path)
    strict = ["cc", "-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-Wno-unused-parameter", "-O0", "-c"]
    for more in ([], ["-include", headers], ["-DFMI3_FUNCTION_PREFIX=crank_"]):
        command = [*strict, *more, str(tmp_path / "sources" / "fmi3.c"), "-o", str(tmp_path / "a.o")]
        subprocess.run(command, check=True, timeout=300)


# ---------------------------------------------------------------- judged by FMPy
@needs_cc
@pytest.mark.parametrize(
    "name",
    ["fourbar", "path_generator", *(pytest.param(x, marks=pytest.mark.long) for x in ("slider_crank", "quick_return"))],
)
def test_the_judge_finds_no_fault(name, units):
    validation = pytest.importorskip("fmpy.validation")
    assert validation.validate_fmu(units(name)) == []


CASES = [
    ("fourbar", 0.02, {}),
    ("fourbar", 0.02, {"omega": 12.0, "M": -20.0, "alpha": 1.1, "r3": 0.003}),
    ("slider_crank", 0.024, {"speed": 300.0, "rod_length": 0.15}),
    ("double_pendulum", 0.5, {"start": 1.2}),
]


@needs_cc
@pytest.mark.parametrize(
    ("fmi_type", "allowed"), [("CoSimulation", 1e-8), ("ModelExchange", 2e-6)]
)  # tolerances of 1e-10 per step; CVode's low orders take many more steps, and the four-bar amplifies errors
@pytest.mark.parametrize(("name", "span", "changes"), CASES)
def test_every_output_moves_as_in_the_package(fmi_type, allowed, name, span, changes, units):
    fmpy = pytest.importorskip("fmpy")
    recorded = rt.example(name).recorded()
    outputs = [*recorded.curves, *recorded.points]
    found = fmpy.simulate_fmu(
        units(name), stop_time=span, output_interval=span / 40, relative_tolerance=1e-10, fmi_type=fmi_type,
        output=outputs, start_values=changes,
    )  # fmt: skip
    run = rt.example(name).set(**changes).simulate(t_eval=np.linspace(0.0, span, 41), rtol=1e-11, atol=1e-13)
    assert len(found) == 41
    names = [one for one in outputs if one != "energy.balance"]
    assert differ(run, found, names) <= allowed
    assert np.abs(found["energy.balance"]).max() <= 1e-6 * max(1.0, np.abs(run["energy.kinetic"]).max())


@needs_cc
def test_co_simulation_follows_a_closed_form_at_any_communication_step(tmp_path):
    """x = 0.5 cos(sqrt(k/m) t)."""
    fmpy = pytest.importorskip("fmpy")
    (tmp_path / "spring.toml").write_text(SPRING)
    written(tmp_path / "a.fmu", str(tmp_path / "spring.toml"))
    for interval in (1.0, 0.25, 1e-3):
        found = fmpy.simulate_fmu(
            str(tmp_path / "a.fmu"), stop_time=3.0, output_interval=interval, relative_tolerance=1e-11,
            fmi_type="CoSimulation", output=["block.x", "block.vx"], start_values={"k": 9.0},
        )  # fmt: skip
        np.testing.assert_allclose(found["block.x"], 0.5 * np.cos(3.0 * found["time"]), atol=1e-9)
        np.testing.assert_allclose(found["block.vx"], -1.5 * np.sin(3.0 * found["time"]), atol=1e-9)


TURNED = """
format = 1
[parameters]
drive = "2 N*m"
inertia = 0.5
[ground.points]
O = [0, 0]
[bodies.wheel]
points = { P = [0, 0] }
mass = 1
inertia = "inertia"
[joints.O]
type = "revolute"
connect = ["ground.O", "wheel.P"]
[loads.motor]
type = "torque"
body = "wheel"
torque = "drive"
[initial]
wheel = { angle = 0, omega = 0 }
"""


@needs_cc
@pytest.mark.parametrize("fmi_type", ["CoSimulation", "ModelExchange"])
def test_a_torque_can_be_fed_in_during_a_run(fmi_type, tmp_path):
    """J d omega/dt = M: +2 N m, then -1 N m from 0.5 s on."""
    fmpy = pytest.importorskip("fmpy")
    (tmp_path / "wheel.toml").write_text(TURNED)
    written(tmp_path / "a.fmu", str(tmp_path / "wheel.toml"))
    _, variables = described(tmp_path / "a.fmu")
    assert [variables[name].get("causality") for name in ("drive", "inertia")] == ["input", "parameter"]
    fed = np.array([(0.0, 2.0), (0.5, 2.0), (0.5, -1.0), (1.0, -1.0)], dtype=[("time", float), ("drive", float)])
    found = fmpy.simulate_fmu(
        str(tmp_path / "a.fmu"), stop_time=1.0, output_interval=0.125, relative_tolerance=1e-10, fmi_type=fmi_type,
        output=["wheel.omega", "wheel.angle", "energy.balance"], input=fed,
    )  # fmt: skip
    t = found["time"]
    late = np.maximum(t - 0.5, 0.0)
    np.testing.assert_allclose(found["wheel.omega"], 4.0 * t - 6.0 * late, atol=1e-7)
    np.testing.assert_allclose(found["wheel.angle"], 2.0 * t**2 - 3.0 * late**2, atol=1e-7)
    assert np.abs(found["energy.balance"]).max() < 1e-6


@needs_cc
def test_an_input_outside_of_its_limits_is_refused_and_the_run_goes_on(opened):
    failed = pytest.importorskip("fmpy.fmi1").FMICallException
    unit, other = opened("fourbar"), opened("fourbar")
    for one in (unit, other):
        one.begin()
        one.set(M=-30.0)
    unit.fmu.doStep(0.0, 1e-3)
    with pytest.raises(failed):
        unit.set(M=81.0)
    assert "M = 81 is not between its limits" in unit.said[-1]
    unit.fmu.doStep(1e-3, 1e-3)
    other.fmu.doStep(0.0, 1e-3)
    other.fmu.doStep(1e-3, 1e-3)
    assert unit.get("M", "rocker.angle") == other.get("M", "rocker.angle")


@pytest.fixture
def opened(units):
    made = []

    def unit(name, kind="CS"):
        made.append(Unit(units(name), kind))
        return made[-1]

    yield unit
    for one in made:
        one.fmu.freeInstance()
        shutil.rmtree(one.folder)


@needs_cc
def test_parameters_that_cannot_be_put_together_are_an_error_with_its_reason(opened):
    unit = opened("fourbar")
    failed = pytest.importorskip("fmpy.fmi1").FMICallException
    lever = opened("quick_return")
    lever.set(height=0.01)  # the guide of the ram is out of reach of its rod
    lever.fmu.enterInitializationMode()
    with pytest.raises(failed):
        lever.fmu.exitInitializationMode()
    assert "cannot be put together" in lever.said[-1]
    for values, why in (
        ({"M": 81.0}, "M = 81 is not between its limits -80 and 80"),
        ({"l1": float("nan")}, "l1 is not a finite number"),
    ):
        unit.set(**values)
        unit.fmu.enterInitializationMode()
        with pytest.raises(failed):
            unit.fmu.exitInitializationMode()
        assert why in unit.said[-1]
        unit.fmu.reset()
    unit.begin()
    assert unit.get("l2", "M") == [0.6, 40.0]


@needs_cc
def test_calls_out_of_turn_are_refused_and_change_nothing(opened):
    failed = pytest.importorskip("fmpy.fmi1").FMICallException
    unit = opened("slider_crank")
    with pytest.raises(failed):
        unit.fmu.doStep(0.0, 1e-3)
    with pytest.raises(failed):
        unit.get("slider.x")
    with pytest.raises(failed):
        unit.fmu.enterInitializationMode(startTime=1.0)
    assert "starts at 0" in unit.said[-1]
    unit.begin()
    before = unit.get("slider.x", "slider.vx")
    with pytest.raises(failed):
        unit.set(speed=1.0)
    assert "speed cannot change during a run" in unit.said[-1]
    with pytest.raises(failed):
        unit.fmu.doStep(0.5, 1e-3)
    assert "the model is at 0 s" in unit.said[-1]
    assert unit.get("slider.x", "slider.vx") == before


@needs_cc
def test_a_saved_state_goes_on_as_before(opened):
    unit = opened("slider_crank")
    unit.begin()
    unit.fmu.doStep(0.0, 1e-3)
    state, ends = unit.fmu.getFMUState(), []
    for _ in range(2):
        unit.fmu.setFMUState(state)
        unit.fmu.doStep(1e-3, 2e-3)
        ends.append(unit.get("slider.x", "slider.vx", "B.fx", "energy.balance"))
    unit.fmu.freeFMUState(state)
    assert ends[0] == ends[1]
    assert unit.description.coSimulation.canGetAndSetFMUstate
    assert unit.description.modelExchange.canGetAndSetFMUstate


@needs_cc
def test_two_instances_do_not_know_of_each_other_and_a_reset_one_runs_the_same_again(opened):
    one, other = opened("slider_crank"), opened("slider_crank")
    other.set(speed=200.0)
    one.begin()
    other.begin()
    rows = []
    for _ in range(2):
        rows.append([])
        for k in range(5):
            one.fmu.doStep(k * 1e-3, 1e-3)
            if len(rows) == 1:
                other.fmu.doStep(k * 1e-3, 1e-3)
            rows[-1].append(one.get("slider.x", "B.fx", "energy.kinetic"))
        one.fmu.reset()
        one.begin()
    assert rows[0] == rows[1]
    run = rt.example("slider_crank").set(speed=200.0).simulate(t_eval=[0.0, 5e-3], rtol=1e-11)
    assert other.get("slider.x")[0] == pytest.approx(run["slider.x"][-1], rel=1e-9)


@needs_cc
def test_in_model_exchange_joints_that_drift_open_are_closed_in_event_mode(opened):
    unit = opened("double_pendulum", "ME")
    fmu = unit.fmu
    unit.begin()
    fmu.updateDiscreteStates()
    fmu.enterContinuousTimeMode()
    import ctypes

    count = fmu.getNumberOfContinuousStates()
    y = (ctypes.c_double * count)()
    fmu.getContinuousStates(y, count)
    assert fmu.completedIntegratorStep() == (False, False)
    closed = np.array(y)
    y[3] += 1e-4  # the lower body leaves its pin
    fmu.setContinuousStates(y, count)
    asked, ended = fmu.completedIntegratorStep()
    assert (asked, ended) == (True, False)
    fmu.enterEventMode()
    assert fmu.updateDiscreteStates()[3]  # values of states have changed
    fmu.enterContinuousTimeMode()
    fmu.getContinuousStates(y, count)
    assert fmu.completedIntegratorStep() == (False, False)
    assert 1e-6 < np.abs(np.array(y) - closed).max() < 1e-3
    m = rt.example("double_pendulum")
    length = m.parameters["upper_length"]
    upper, lower = np.array(y[:3]), np.array(y[3:6])
    half = m.model.bodies["lower"].points["P"]
    pin = lower[:2] + np.array([np.cos(lower[2]), np.sin(lower[2])]) * half[0]
    end = upper[:2] + np.array([np.cos(upper[2]), np.sin(upper[2])]) * (length / 2)
    np.testing.assert_allclose(pin, end, atol=1e-12)


@needs_cc
def test_other_tools_can_compile_the_sources(tmp_path, units):
    build = pytest.importorskip("fmpy.build")
    if shutil.which("cmake") is None:
        pytest.skip("no cmake")
    import fmpy

    with zipfile.ZipFile(units("slider_crank")) as opened:
        opened.extractall(tmp_path)
    shutil.rmtree(tmp_path / "binaries")
    build.build_platform_binary(tmp_path)
    found = fmpy.simulate_fmu(str(tmp_path), stop_time=1e-3, fmi_type="CoSimulation", output=["crank.angle"])
    assert found["crank.angle"][-1] == pytest.approx(rt.example("slider_crank").parameters["speed"] * 1e-3, rel=1e-9)


@pytest.mark.nojit
@pytest.mark.parametrize("name", ["fourbar", "quick_return", "toggle"])
def test_the_states_are_the_result_columns_of_their_names(name):
    model = rt.example(name).recorded()
    for k, (column, _) in enumerate(state_layout(model.system).units()):
        assert model.graph.place(model.curves[column]) == model.graph.inputs[1 + k], column
