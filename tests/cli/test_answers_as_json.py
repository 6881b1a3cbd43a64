"""What --json holds of power, films, sections, comparisons and designs: the numbers of the methods, in SI."""

import json
import math

import numpy as np
import pytest
from click.testing import CliRunner

import rattle as rt
from rattle.cli.main import main

SIZES = {"viscosity": 0.02, "length": 0.03, "radius": 0.05, "clearance": 1e-4}


def record(*words, status=0):
    done = CliRunner().invoke(main, ["-q", *map(str, words), "--json"])
    assert done.exit_code == status, done.output
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def crank():
    return rt.example("slider_crank").simulate()


def test_power_of_a_cycle(crank):
    p = crank.power()
    seen = record("power", "slider_crank", "--units", "kJ,kW")
    assert (seen["t0"], seen["t1"]) == pytest.approx((p.t0, p.t1))
    ports = {(port["element"], port["body"]): port for port in seen["ports"]}
    assert len(ports) == len(p.table)
    for row in p.table.itertuples():
        assert ports[row.element, row.body]["E_in"] == pytest.approx(row.E_in, rel=1e-6, abs=1e-9)
    motor = next(element for element in seen["elements"] if element["element"] == "motor")
    supplied = p.elements.set_index("element").supplied["motor"]
    assert motor["supplied"] == pytest.approx(supplied, rel=1e-6, abs=1e-9)


def test_power_at_an_instant_beside_its_table(crank, tmp_path):
    table = tmp_path / "power.csv"
    seen = record("power", "slider_crank", "--at", "1ms", "-o", table)
    assert seen["t"] == 1e-3
    powers = crank.power().at(1e-3).power
    assert [port["power"] for port in seen["ports"]] == pytest.approx(list(powers), rel=1e-6, abs=1e-6)
    assert len(table.read_text().splitlines()) == len(powers) + 1


def test_a_film_with_a_load_and_its_stribeck_curve():
    words = [word for name, size in SIZES.items() for word in (f"--{name}", size)]
    seen = record("film", *words, "--load", "1 kN", "--speed", "3000 rpm", "--boundary-film", "1 um", "--units", "mm")
    film = rt.Film(**SIZES)
    position = film.static(1e3, 100 * math.pi)
    for name in ("eccentricity", "attitude", "film_thickness", "pressure", "loss"):
        assert seen["position"][name] == pytest.approx(getattr(position, name), rel=1e-9)
    assert np.allclose(seen["position"]["stiffness"], position.stiffness)
    assert seen["position"]["critical_mass"] == pytest.approx(film.critical_mass(1e3, 100 * math.pi))
    assert seen["static"]["sommerfeld"] == pytest.approx(film.table(seen["static"]["eccentricity"]).sommerfeld.tolist())
    assert seen["stribeck"]["friction"] == pytest.approx(film.stribeck(1e3, boundary_film=1e-6).friction.tolist())


def test_a_section_and_its_exponent(tmp_path):
    m = rt.example("double_pendulum")
    picture = tmp_path / "section.png"
    words = ["poincare", "double_pendulum", "--of", "upper.angle", "--of", "lower.angle", "--period", "0.1"]
    seen = record(*words, "--skip", 2, "--points", 5, "--lyapunov", "-o", picture)
    section = m.poincare("upper.angle", "lower.angle", period=0.1, skip=2, points=5)
    assert seen["t"] == pytest.approx(section.t.tolist())
    assert seen["values"]["lower.angle"] == pytest.approx(section["lower.angle"].tolist(), rel=1e-6)
    assert seen["units"] == {"upper.angle": "rad", "lower.angle": "rad"}
    assert seen["lyapunov"]["exponent"] == pytest.approx(m.lyapunov().exponent, rel=1e-6)
    assert picture.stat().st_size > 1000


def test_a_bifurcation_diagram(tmp_path):
    words = ["poincare", "slider_crank", "--of", "slider.vx", "--parameter", "rod_length", "--from", "120 mm"]
    words += ["--to", "0.2", "--values", 2, "--skip", 1, "--points", 2, "--period", "1ms"]
    seen = record(*words, "-o", tmp_path / "diagram.png")
    diagram = rt.example("slider_crank").bifurcation(
        "rod_length", [0.12, 0.2], "slider.vx", period=1e-3, skip=1, points=2
    )
    assert (seen["parameter"], seen["values"]) == ("rod_length", [0.12, 0.2])
    assert np.allclose(seen["points"], diagram.points, rtol=1e-6)


def test_a_comparison_of_contact_models(tmp_path):
    seen = record("compare", "fourbar", "--t-end", "20ms", "-o", tmp_path / "models.png", "--units", "kN")
    comparison = rt.example("fourbar").compare(t_end=0.02)
    assert list(seen["models"]) == list(comparison.results)
    assert seen["joint"] == comparison.joint
    ideal, impact = comparison.results["ideal"], comparison.results["one-sided impact"].contacts[comparison.joint]
    force = f"{comparison.joint}.force"
    assert seen["models"]["ideal"]["peak"] == pytest.approx(ideal.peak(force)[0], rel=1e-6)
    assert seen["models"]["ideal"]["rms"] == pytest.approx(ideal.rms(force), rel=1e-6)
    assert seen["models"]["ideal"]["contacts"] is None
    assert seen["models"]["one-sided impact"]["impacts"] == impact.impacts
    assert seen["models"]["one-sided impact"]["energy_lost"] == pytest.approx(impact.energy_lost, rel=1e-6)


def test_a_best_design(tmp_path):
    design = tmp_path / "best.toml"
    words = ["--ideal", "--analysis", "kinematics", "--minimise", "sd(coupler.P.y)", "--vary", "a=30 mm:50 mm"]
    seen = record("optimise", "path_generator", *words, "--subject-to", "a <= 45 mm", "--starts", 2, "-o", design)
    optimum = (
        rt.example("path_generator")
        .ideal()
        .optimise("sd(coupler.P.y)", {"a": (0.03, 0.05)}, ["a <= 45 mm"], analysis="kinematics", starts=2)
    )
    assert seen["success"] is True
    assert seen["value"] == pytest.approx(optimum.value, rel=1e-9)
    assert seen["parameters"]["a"]["value"] == pytest.approx(optimum.values["a"], rel=1e-9)
    assert seen["parameters"]["a"]["before"] == rt.example("path_generator").parameters["a"]
    assert seen["constraints"][0]["margin"] == pytest.approx(0.045 - optimum.values["a"], abs=1e-12)
    assert seen["active"] == list(optimum.active)
    assert rt.load(design).parameters["a"] == pytest.approx(optimum.values["a"], rel=1e-9)
