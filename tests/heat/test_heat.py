"""Temperatures of joints: what is lost there flows off, with oil and play as they are when it does."""

import json
import math

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.optimize import brentq, root

import rattle as rt
from rattle.cli.main import main
from rattle.errors import InputError, ModelError, SolverError

MU, RADIUS = 0.1, 0.008
AIR = 293.15  # 20 degC [K]
W, R, L, C = 300.0, 0.01, 0.01, 3e-5  # a pin that turns in the middle of its bush, with oil
OIL = 'oil = "ISO VG 46", temperature ='
EXACT = 1e-9  # relative: losses of steady rotors are those of constants
NEAR = 0.05  # [K] a few last steps of the search
GROWS = 11.5e-6  # [1/K] by which light bushes grow more than iron pins
METALS = """
[materials.iron]
E = "210 GPa"
expansion = 11.5e-6
[materials.light]
E = "70 GPa"
expansion = 23e-6
"""


def rotors(*loads_and_speeds, more=""):
    """Rotors J0, J1, ... in plain bearings with dry friction, each under a force [N] at a speed [rad/s]."""
    text = "format = 1\nsimulate.t_end = 0.02\nground.points = {"
    text += ", ".join(f" O{k} = [{k}, 0]" for k in range(len(loads_and_speeds))) + " }\n"
    for k, (force, speed) in enumerate(loads_and_speeds):
        text += f"""
bodies.b{k} = {{ points = {{ P = [0, 0] }}, mass = 1, inertia = 1 }}
drivers.d{k} = {{ joint = "J{k}", angle = "{speed}*t" }}
loads.f{k} = {{ type = "force", at = "b{k}.P", force = [0, {-force}] }}
joints.J{k}.type = "revolute"
joints.J{k}.connect = ["ground.O{k}", "b{k}.P"]
joints.J{k}.friction = {{ model = "coulomb", mu = {MU}, pin_radius = {RADIUS} }}
"""
    return rt.loads(text + more)


def lost(force, speed):
    return MU * RADIUS * abs(force * speed)


def oiled(*speeds, warm=40, clearance=C, more=""):
    """Pins O0, O1, ... with VG 46 that turn in the middle of their bushes, unloaded."""
    text = "format = 1\nsimulate.t_end = 0.02\nground.points = {"
    text += ", ".join(f" O{k} = [{k}, 0]" for k in range(len(speeds))) + " }\n"
    for k, speed in enumerate(speeds):
        text += f"""
bodies.b{k} = {{ points = {{ P = [0, 0] }}, mass = 1, inertia = 1e-3 }}
drivers.d{k} = {{ body = "b{k}", coordinate = "angle", angle = "{speed}*t" }}
initial.b{k} = {{ angle = 0, vx = 0, vy = 0 }}
initial.O{k} = {{ offset = [0, 0] }}
joints.O{k}.type = "revolute"
joints.O{k}.connect = ["ground.O{k}", "b{k}.P"]
joints.O{k}.clearance = {clearance}
joints.O{k}.contact = {{ model = "lubricated", film = "short", length = {L}, bush_radius = {R}, {OIL} "{warm} degC" }}
"""
    return rt.loads(text + more)


def drag(kelvin, speed=W, grow=0.0):
    """2 pi mu w^2 R^3 L/c of such a pin [W] (Petroff)."""
    play = C + R * grow * (kelvin - AIR)
    return 2.0 * math.pi * rt.oil("ISO VG 46").viscosity(float(kelvin)) * speed**2 * R**3 * L / play


# ---------------------------------------------------------------- constant losses
def test_a_joint_alone_is_warmer_than_the_air_by_its_loss_over_its_conductance():
    h = rotors((300.0, 50.0), (500.0, -20.0)).heat(ambient="20 degC", cooling={"J0": "0.5 W/K", "J1": 0.4})
    assert h.temperature["J0"] == pytest.approx(AIR + lost(300, 50) / 0.5, rel=EXACT)
    assert h.temperature["J1"] == pytest.approx(AIR + lost(500, 20) / 0.4, rel=EXACT)
    assert h.loss == pytest.approx({"J0": 12.0, "J1": 8.0}, rel=EXACT)
    assert h.iterations == 1


@pytest.mark.parametrize("seed", range(4))
def test_random_networks_are_those_of_a_dense_solve_and_lose_what_goes_out(seed):
    random = np.random.default_rng(seed)
    forces, speeds = random.uniform(50, 500, 4), random.uniform(5, 50, 4)
    cooling = {f"J{k}": random.uniform(0.1, 2.0) for k in random.choice(4, size=2, replace=False)}
    pairs = [(0, 1), (1, 2), (3, 2), (0, 3)]
    conduction = {(f"J{i}", f"J{j}"): random.uniform(0.1, 3.0) for i, j in pairs}
    matrix = np.diag([cooling.get(f"J{k}", 0.0) for k in range(4)])
    for (i, j), conductance in zip(pairs, conduction.values(), strict=True):
        matrix[[i, j], [i, j]] += conductance
        matrix[[i, j], [j, i]] -= conductance
    losses = np.array([lost(*pair) for pair in zip(forces, speeds, strict=True)])
    h = rotors(*zip(forces, speeds, strict=True)).heat(ambient=AIR, cooling=cooling, conduction=conduction)
    assert list(h.temperature.values()) == pytest.approx(AIR + np.linalg.solve(matrix, losses), rel=EXACT)
    assert sum(h.to_air.values()) == pytest.approx(sum(h.loss.values()), rel=EXACT)


def test_a_joint_may_be_cooled_through_another_and_one_without_loss_is_as_warm_as_what_it_touches():
    m = rotors((300.0, 50.0), (0.0, 20.0), (0.0, 10.0))
    h = m.heat(ambient="20 degC", cooling={"J1": "0.25 W/K"}, conduction={("J0", "J1"): "0.5 W/K"})
    assert h.temperature["J1"] == pytest.approx(AIR + 12 / 0.25, rel=EXACT)
    assert h.temperature["J0"] == pytest.approx(AIR + 12 / 0.25 + 12 / 0.5, rel=EXACT)
    assert h.temperature["J2"] == AIR


def test_the_loss_is_that_of_the_last_turn_and_not_of_the_start():
    """A force that dies away: its mean over the last of ten turns is 1/(2 pi) of the integral over it."""
    m = rotors((300.0, 50.0)).set({"loads.f0.force": [0, "-300*exp(-10*t)"], "simulate.t_end": "10*2*pi/50"})
    end, turn = 0.4 * math.pi, 2.0 * math.pi / 50.0
    mean = (math.exp(-10 * (end - turn)) - math.exp(-10 * end)) / (10 * turn)
    h = m.heat(ambient="20 degC", cooling={"J0": 0.01})
    assert h.loss["J0"] == pytest.approx(lost(300, 50) * mean, rel=1e-6)  # tolerance of a run


# ---------------------------------------------------------------- oil and play
@pytest.mark.parametrize(("air", "conductance"), [(293.15, 0.1), (253.15, 0.3), (333.15, 1000.0), (400.0, 0.02)])
def test_oil_is_as_thin_as_it_is_where_its_drag_flows_off(air, conductance):
    want = brentq(lambda kelvin: conductance * (kelvin - air) - drag(kelvin), max(air, 243.15), 473.15, xtol=1e-9)
    h = oiled(W).heat(ambient=air, cooling={"O0": conductance})
    assert h.temperature["O0"] == pytest.approx(want, abs=NEAR)
    assert h.loss["O0"] == pytest.approx(conductance * (h.temperature["O0"] - air), rel=EXACT)
    assert h.iterations <= 10
    r = h.mechanism.simulate(0.01, t_eval=[0.0, 0.01])
    assert r["O0.friction_power"][-1] == pytest.approx(h.loss["O0"], rel=1e-3)


def test_the_answer_does_not_depend_on_the_temperature_in_the_file():
    warm = [oiled(W, warm=t).heat(ambient="20 degC", cooling={"O0": 0.1}).temperature["O0"] for t in (-20, 40, 190)]
    assert warm == pytest.approx([warm[0]] * 3, abs=1e-9)


def test_two_films_that_warm_each_other_are_steady_together():
    speeds, cooling, between = (300.0, 150.0), (0.1, 0.05), 0.08

    def lacking(kelvin):
        flow = between * (kelvin[0] - kelvin[1])
        return [cooling[k] * (kelvin[k] - AIR) + (flow, -flow)[k] - drag(kelvin[k], speeds[k]) for k in range(2)]

    want = root(lacking, [320.0, 320.0], tol=1e-10).x
    paths = {"cooling": {"O0": cooling[0], "O1": cooling[1]}, "conduction": {("O0", "O1"): between}}
    h = oiled(*speeds).heat(ambient="20 degC", **paths)
    assert list(h.temperature.values()) == pytest.approx(want, abs=NEAR)
    assert sum(h.to_air.values()) == pytest.approx(sum(h.loss.values()), rel=EXACT)
    assert h.iterations <= 20


def play(bush, pin, size=C):
    return f'{{ radial = {size}, bush_material = "{bush}", pin_material = "{pin}" }}'


def test_play_is_that_at_the_temperature():
    want = brentq(lambda kelvin: 0.1 * (kelvin - AIR) - drag(kelvin, grow=GROWS), AIR, 473.0, xtol=1e-9)
    h = oiled(W, clearance=play("light", "iron"), more=METALS).heat(ambient="20 degC", cooling={"O0": 0.1})
    assert h.temperature["O0"] == pytest.approx(want, abs=NEAR)
    assert h.mechanism.model.joints["O0"].clearance == pytest.approx(C + R * GROWS * (want - AIR), rel=1e-4)


def test_where_play_closes_the_colder_of_two_steady_states_is_the_answer():
    """A light pin in an iron bush: the balance holds once before its drag rises, and once more just before it jams."""
    closed = AIR + C / (R * GROWS)

    def lacking(kelvin):
        return 0.05 * (kelvin - AIR) - drag(kelvin, grow=-GROWS)

    places = np.linspace(AIR, min(closed, 473.0) - 0.1, 2000)
    first = next(k for k, kelvin in enumerate(places) if lacking(kelvin) > 0.0)
    want = brentq(lacking, places[first - 1], places[first], xtol=1e-9)
    h = oiled(W, clearance=play("iron", "light"), more=METALS).heat(ambient="20 degC", cooling={"O0": 0.05})
    assert h.temperature["O0"] == pytest.approx(want, abs=NEAR)


def test_a_pin_that_grows_into_its_bush_seizes_and_the_temperature_is_told():
    tight = 4e-6
    closed = AIR - 273.15 + tight / (R * GROWS)
    m = oiled(W, clearance=play("iron", "light", tight), more=METALS)
    with pytest.raises(SolverError, match=rf"O0 seizes: no play left at {closed:.1f} degC"):
        m.heat(ambient="20 degC", cooling={"O0": "0.02 W/K"})
    with pytest.raises(SolverError, match=r"O0 seizes: no play left at 60.0 degC"):
        m.heat(ambient="60 degC", cooling={"O0": "0.02 W/K"})


@pytest.mark.parametrize(
    ("air", "conductance", "words"),
    [
        ("20 degC", "0.1 mW/K", "the oil of O0 would boil away: it becomes hotter than 200 degC"),
        ("-60 degC", "1 kW/K", "the oil of O0 would set: it becomes colder than -30 degC"),
    ],
)
def test_oil_that_leaves_the_temperatures_for_which_it_is_known_is_told(air, conductance, words):
    with pytest.raises(SolverError, match=words):
        oiled(W).heat(ambient=air, cooling={"O0": conductance})


# ---------------------------------------------------------------- what is refused
@pytest.mark.parametrize(
    ("paths", "words"),
    [
        ({"cooling": {"J0": 0.5}}, r"J1: no way leads to the air for what is lost there, 8 W"),
        ({"cooling": {"J0": "0 W/K", "J1": 1}}, r"cooling of J0: '0 W/K' must be positive"),
        ({"cooling": {"J0": "0.5 W", "J1": 1}}, r"'0.5 W' is a power; expected a thermal conductance"),
        ({"cooling": {"J9": 1, "J0": 1, "J1": 1}}, r"no joint 'J9'"),
        ({"cooling": {"J0": True, "J1": 1}}, r"expected a conductance"),
        ({"cooling": "J0 0.5 W/K"}, r'expected "pin=2 W/K'),
        ({"cooling": {}}, r"no way leads to the air"),
        ({"cooling": 3}, r"expected conductances by joint"),
        ({"ambient": "20 mm"}, r"'20 mm' is a length"),
        ({"ambient": 20}, r"a number is kelvin, write '20 degC'"),
        ({"ambient": True}, r"expected a temperature"),
        ({"ambient": None}, r"how warm is the air"),
        ({"conduction": {("J0", "J9"): 1}}, r"no joint 'J9'"),
        ({"conduction": {("J0", "J0"): 1}}, r"expected two joints"),
        ({"conduction": {"J0": 1}}, r"expected two joints"),
        ({"conduction": {("J0", "J1"): -1}}, r"must be positive"),
        ({"conduction": "J0=1 W/K"}, r'expected "pin,slider=0.5 W/K"'),
        ({"conduction": 1}, r"conduction: expected"),
    ],
)
def test_ways_that_make_no_sense_are_refused(paths, words):
    usual = {"ambient": "20 degC", "cooling": {"J0": 0.5, "J1": 0.4}}
    with pytest.raises(InputError, match=words):
        rotors((300.0, 50.0), (500.0, 20.0)).heat(**{**usual, **paths})


def test_a_run_that_ends_early_has_no_losses():
    m = rotors((300.0, 50.0)).set({"loads.f0.force": [0, "-300*(0.01 - t)**0.5"]})
    with pytest.raises(SolverError, match="its losses are not known"):
        m.heat(ambient="20 degC", cooling={"J0": 1})


# ---------------------------------------------------------------- in the model file, and on the command line
TABLE = """
[heat]
ambient = "20 degC"
cooling = { J0 = "0.4 W/K", J1 = 0.25 }
conduction = [{ between = ["J1", "J0"], conductance = "0.5 W/K" }]
"""
PAIR = (300.0, 50.0), (500.0, 20.0)
RISES = np.linalg.solve([[0.9, -0.5], [-0.5, 0.75]], [12, 8])


def test_the_model_file_may_hold_the_ways_and_arguments_stand_for_them():
    h = rotors(*PAIR, more=TABLE).heat()
    assert list(h.temperature.values()) == pytest.approx(AIR + RISES, rel=EXACT)
    texts = rotors(*PAIR).heat(ambient=300.0, cooling="J0=0.4 W/K, J1=0.25 W/K", conduction="J0,J1=0.5 W/K")
    assert list(texts.temperature.values()) == pytest.approx(300.0 + RISES, rel=EXACT)
    other = rotors(*PAIR, more=TABLE).heat(ambient="30 degC", cooling={"J0": 0.4, "J1": 1e9})
    assert other.temperature["J1"] == pytest.approx(AIR + 10, abs=1e-6)
    with pytest.raises(ModelError, match=r"heat: where does its heat go"):
        rotors(*PAIR).heat()


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('"20 degC"', '"20 mm"', "heat.ambient: '20 mm' is a length"),
        ("J1 = 0.25", "J9 = 0.25", "heat.cooling.J9: no joint 'J9'"),
        ("J1 = 0.25", "J1 = 0", "heat.cooling.J1: 0 must be positive"),
        ('"J1", "J0"', '"J1", "J1"', "'J1' stands at both ends"),
        ('"J1", "J0"', '"J1"', "expected two joints"),
        ("conductance", "conductanze", "did you mean 'conductance'"),
        ("ambient", "ambience", "did you mean 'ambient'"),
        ('[{ between = ["J1", "J0"], conductance = "0.5 W/K" }]', "3", "heat.conduction: expected"),
        ('[{ between = ["J1", "J0"], conductance = "0.5 W/K" }]', "[3]", "expected a way such as"),
    ],
)
def test_a_wrong_table_is_refused_where_it_stands(old, new, words):
    with pytest.raises(ModelError, match=words.replace("[", r"\[")):
        rotors(*PAIR, more=TABLE.replace(old, new))


def test_the_command_prints_degrees_and_writes_json_and_a_picture(tmp_path):
    path, picture = tmp_path / "m.toml", tmp_path / "heat.svg"
    rotors(*PAIR, more=TABLE).save(path)
    run = CliRunner().invoke(main, ["heat", str(path), "-o", str(picture)])
    assert run.exit_code == 0
    assert f"{20 + RISES[0]:.1f} degC" in run.output
    assert "temperature [degC]" in picture.read_text()
    asked = ["heat", str(path), "--ambient", "30 degC", "--cooling", "J0=1 W/K, J1=1 W/K", "--json"]
    numbers = json.loads(CliRunner().invoke(main, asked).output)["numbers"]
    assert numbers["J0.loss"] == {"value": pytest.approx(12.0, rel=EXACT), "unit": "W"}
    assert numbers["hottest"]["value"] > 303.15


def test_samples_of_an_ensemble_have_temperatures():
    m = rotors(*PAIR, more=TABLE + "[parameters]\npush = 300\n").set({"loads.f0.force": [0, "-push"]})
    e = m.ensemble(3, ["final(J0.temperature)"], {"push": 20.0}, analysis="heat", seed=2)
    pushes = [e.sample(k).parameters["push"] for k in range(3)]
    want = [AIR + np.linalg.solve([[0.9, -0.5], [-0.5, 0.75]], [lost(push, 50), 8])[0] for push in pushes]
    assert list(e["final(J0.temperature)"]) == pytest.approx(want, rel=1e-6)


def test_table_card_and_remarks_say_the_same():
    h = rotors(*PAIR, more=TABLE).heat()
    assert list(h.table["temperature"]) == pytest.approx(20 + RISES, rel=EXACT)
    assert f"{20 + RISES[1]:.1f} degC" in h._repr_html_()
    assert "<svg" in h._repr_html_()
    assert "20 W flow to the air" in repr(h)
    assert (
        "no joint loses anything"
        in rotors((0.0, 50.0), more="heat = { ambient = 293, cooling = { J0 = 1 } }").heat().told
    )
