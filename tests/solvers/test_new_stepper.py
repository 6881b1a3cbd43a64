"""A stepper is one class: entered here, it runs through reader, schema, help, catalogue and simulation."""

import shutil
import zipfile

import numpy as np
import pytest
from click.testing import CliRunner
from test_rates import T_END, order_seen

import rattle as rt
from live import computed
from rattle import registry
from rattle.cli.main import main
from rattle.description.schema import schema
from rattle.errors import InputError
from rattle.pages.live_program import live_program
from rattle.registry import kind, kinds
from rattle.solvers.explicit import step
from rattle.solvers.stepper import AdaptiveStepper, FixedStepper
from rattle.solvers.tableau import Tableau


@pytest.fixture(scope="module", autouse=True)
def entered():
    """Both steppers in the registry, for this module alone."""
    kinds("stepper")

    @kind("stepper", "bogacki-shampine", step)
    class BogackiShampine(AdaptiveStepper):
        """Order 3 that chooses its steps: quick looks.

        Source: Bogacki, Shampine, A 3(2) pair of Runge-Kutta formulas, Appl. Math. Lett. 2 (1989) 321-325.
        """

        tableau = Tableau(
            order=3,
            times=(0, 1 / 2, 3 / 4, 1),
            rows=((), (1 / 2,), (0, 3 / 4), (2 / 9, 1 / 3, 4 / 9)),
            weights=(2 / 9, 1 / 3, 4 / 9, 0),
            errors=((-5 / 72, 1 / 12, 1 / 9, -1 / 8),),
        )

    @kind("stepper", "heun", step)
    class Heun(FixedStepper):
        """Order 2 with fixed steps.

        Source: Heun, Neue Methoden zur approximativen Integration, Z. Math. Phys. 45 (1900) 23-38.
        """

        tableau = Tableau(order=2, times=(0, 1), rows=((), (1,)), weights=(1 / 2, 1 / 2))

    yield
    for name in ("bogacki-shampine", "heun"):
        registry._families["stepper"].pop(name)


def model(method: str) -> str:
    return f"""
format = 1
gravity = [0, -9.81]
ground.points.O = [0, 0]
bodies.bar = {{ bar = ["O", "P"], length = 0.5, mass = 1 }}
joints.O = {{ type = "revolute", connect = ["ground.O", "bar.O"] }}
initial.bar = {{ angle = 0.4 }}
simulate = {{ method = "{method}" }}
"""


@pytest.mark.nojit
def test_model_file_schema_help_and_catalogue_know_a_new_stepper():
    assert rt.loads(model("heun")).model.settings.method == "heun"
    with pytest.raises(rt.ModelError, match=r"did you mean .heun."):
        rt.loads(model("heum"))
    method = schema()["properties"]["simulate"]["properties"]["method"]
    assert {"bogacki-shampine", "heun"} <= set(method["enum"])
    assert "heun: Order 2 with fixed steps" in method["description"]
    said = " ".join(CliRunner().invoke(main, ["run", "--help"]).output.split())
    assert "bogacki-shampine (adaptive)" in said
    assert "heun (fixed --step)" in said
    assert "Order 3 that chooses its steps" in CliRunner().invoke(main, ["kinds", "bogacki-shampine"]).output


@pytest.mark.parametrize("name", ["heun", "bogacki-shampine"])
def test_new_stepper_has_its_order(name):
    stepper = kinds("stepper")[name]
    assert order_seen(stepper, (1.0, 0.7, 0.5, 0.36, 0.25), np.array([T_END])) == pytest.approx(
        stepper.leaf.order, abs=0.2
    )


def test_model_that_asks_for_a_new_stepper_is_run_by_it_and_its_peaks_come_from_within_the_steps():
    new, usual = rt.loads(model("bogacki-shampine")), rt.loads(model("dop853"))
    r, exact = new.simulate(2.0, t_eval=[0.0, 2.0]), usual.simulate(2.0, t_eval=[0.0, 2.0])
    assert r.provenance["method"] == "bogacki-shampine"
    assert r.stats["evaluations"] >= 4 * r.stats["steps"]
    assert r.stats["steps"] > 10 * exact.stats["steps"]
    assert r["bar.angle"][-1] == pytest.approx(exact["bar.angle"][-1], abs=1e-5)  # error per step of 1e-8
    for name in ("O.force", "O.x"):
        if name in exact.peaks:
            assert r.peaks[name].value == pytest.approx(exact.peaks[name].value, rel=1e-5)
            assert r.peaks[name].rms == pytest.approx(exact.peaks[name].rms, rel=1e-5)
    assert "O.force" in exact.peaks


def test_new_stepper_says_with_which_contacts_it_works():
    compliant, rigid = rt.example("slider_crank_play"), rt.example("fourbar").with_contact("impact")
    with pytest.raises(ValueError, match="heun takes fixed steps, which contacts do not allow; use method dop853"):
        compliant.simulate(1e-3, method="heun")
    ran = rigid.simulate(1e-3, method="bogacki-shampine")
    assert ran.provenance["method"] == "event"
    assert "method bogacki-shampine knows no impacts: event" in str(ran.trust)


def test_new_adaptive_stepper_finds_the_contacts_that_the_usual_one_finds():
    m = rt.example("slider_crank_play")
    runs = [m.simulate(1.8e-3, rtol=1e-7, method=name) for name in ("bogacki-shampine", "dop853")]
    one, other = ([event.t for event in r.events if event.kind == "contact"] for r in runs)
    assert len(other) > 5
    assert one == pytest.approx(other, abs=1e-6)  # s: ten times what the tolerance makes of a free flight


@pytest.mark.parametrize("name", ["heun", "bogacki-shampine"])
def test_samples_side_by_side_are_run_by_a_new_stepper_as_one_by_one(name):
    m = rt.loads(model(name).replace("length = 0.5", 'length = "l"') + "[parameters]\nl = 0.5\n")
    of = ["final(bar.angle)", "max(O.force)"]
    lengths = np.linspace(0.4, 0.6, 9)
    settings = {"rtol": 1e-7} if name != "heun" else {"step": 2e-4}
    many = m.many({"l": lengths}, of, t_end=1.0, **settings)
    assert len(many.generic) == 0
    for k in (0, 4, 8):
        r = m.set(l=lengths[k]).simulate(1.0, **settings)
        assert many[of[0]][k] == pytest.approx(r["bar.angle"][-1], abs=2e-6)
        assert many[of[1]][k] == pytest.approx(r.peaks["O.force"].value, rel=1e-4)


@pytest.mark.skipif(shutil.which("node") is None, reason="no node")
@pytest.mark.parametrize("name", ["heun", "bogacki-shampine"])
def test_a_page_takes_the_steps_of_a_new_stepper(name, tmp_path):
    m = rt.loads(model(name))
    live = live_program(m, t_end=0.5)
    run = computed(tmp_path, live)
    r = m.simulate(0.5, t_eval=run["t"])
    assert not live.notes
    assert run["stats"]["steps"] == r.stats["steps"]
    assert run["columns"]["bar.angle"] == pytest.approx(r["bar.angle"], abs=1e-10)


def test_an_fmu_holds_the_coefficients_of_a_new_stepper(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "m.toml").write_text(model("bogacki-shampine"))
    ran = CliRunner().invoke(main, ["code", "m.toml", "-o", "m.fmu"])
    assert ran.exit_code == 0, ran.output
    with zipfile.ZipFile("m.fmu") as archive:
        text = archive.read("sources/equations.c").decode()
    assert "enum { STAGES = 4, ORDER = 3 };" in text


@pytest.mark.nojit
@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"weights": (1 / 2, 1 / 2)}, "time and a row for every stage"),
        ({"rows": ((), (1,), (0.5,))}, "sum up to the time"),
        ({"rows": ((), (0, 1), (1,))}, "stages before them"),
        ({"order": 3}, "below degree 3"),
        ({"errors": ((1, 0, 0),)}, "sum up to zero"),
        ({"dense": ((0, 0, 0),) * 5}, "four dense rows"),
    ],
)
def test_a_tableau_that_cannot_be_is_refused(change, words):
    right = {"order": 2, "times": (0, 1, 1), "rows": ((), (1,), (0.5, 0.5)), "weights": (1 / 2, 1 / 2, 0)}
    assert Tableau(**right).stages == 3
    if "weights" in change:
        right["times"] = (0,)
    with pytest.raises(InputError, match=words):
        Tableau(**right | change)


@pytest.mark.nojit
def test_a_tableau_without_an_error_estimate_cannot_choose_steps():
    with pytest.raises(InputError, match="no error estimate"):

        class _Adaptive(AdaptiveStepper):
            tableau = kinds("stepper")["heun"].leaf.tableau
