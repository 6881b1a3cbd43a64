"""A stepper is one class: entered here, it runs through reader, schema, help, catalogue and simulation."""

import math
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
from rattle.pages.live_model import live_model
from rattle.registry import kind, kinds
from rattle.solvers.explicit import step
from rattle.solvers.peaks.samples import BLANK, sample_arrays
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
    live = live_model(m, 0.5)
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
        ({"times": (0,)}, "time and a row for every stage"),
        ({"times": (), "rows": (), "weights": ()}, "time and a row for every stage"),
        ({"rows": ((), (1, 0, 0, 0), (0.5, 0.5))}, "time and a row for every stage"),
        ({"rows": ((), (1,), (0.5,))}, "sum up to the time"),
        ({"rows": ((), (0, 1), (0.5, 0.5))}, "stages before them"),
        ({"weights": (0.5, math.nan, 0.5)}, "finite numbers"),
        ({"order": 3}, "not of order 3"),
        ({"order": 0}, "whole number from 1 on"),
        ({"order": 2.5}, "whole number from 1 on"),
        ({"errors": ((1, 0, 0),)}, "sum up to zero"),
        ({"errors": ((0, 0, 0),)}, "not zero"),
        ({"errors": ((1, -1),)}, "a weight for every stage"),
        ({"dense": ((0, 0, 0),) * 5}, "four rows of dense output"),
        ({"dense": ((1,),)}, "a weight for every slope"),
        ({"stable": -1}, "not negative"),
        ({"times": (0, 1, 1, 0.5, 0.5), "rows": ((), (1,), (0.5, 0.5), (0.5,), (0.5,))}, "time 1, and its row"),
    ],
)
def test_a_tableau_that_cannot_be_is_refused(change, words):
    right = {"order": 2, "times": (0, 1, 1), "rows": ((), (1,), (0.5, 0.5)), "weights": (1 / 2, 1 / 2, 0)}
    assert Tableau(**right).stages == 3
    with pytest.raises(InputError, match=words):
        Tableau(**right | change)


@pytest.mark.nojit
def test_the_order_of_a_tableau_is_that_of_its_rows_too():
    """These weights integrate quadratic functions of time; the motion would still be of order 2."""
    with pytest.raises(InputError, match="not of order 3"):
        Tableau(3, (0, 1 / 2, 1), ((), (1 / 2,), (0, 1)), (1 / 6, 2 / 3, 1 / 6))


WITH_ENDS = {  # methods with a weight at the end of the step that is not their last stage, or several equal nodes
    "ssprk3": (3, (0, 1, 1 / 2), ((), (1,), (1 / 4, 1 / 4)), (1 / 6, 1 / 6, 2 / 3)),
    "kutta": (3, (0, 1 / 2, 1), ((), (1 / 2,), (-1, 2)), (1 / 6, 2 / 3, 1 / 6)),
    "three eighths": (4, (0, 1 / 3, 2 / 3, 1), ((), (1 / 3,), (-1 / 3, 1), (1, -1, 1)), (1 / 8, 3 / 8, 3 / 8, 1 / 8)),
    "euler": (1, (0,), ((),), (1,)),
}


@pytest.mark.nojit
@pytest.mark.parametrize("name", WITH_ENDS)
def test_every_weight_of_a_method_belongs_to_a_sample(name):
    arrays = sample_arrays(Tableau(*WITH_ENDS[name]))
    shown = arrays["sample_weights"][0 if arrays["sampling"][0] != BLANK else 1 :]
    assert shown.sum(axis=1) == pytest.approx(1.0, abs=1e-14)


@pytest.mark.parametrize("name", WITH_ENDS)
def test_mean_squares_of_forces_are_those_of_another_method(name):
    @kind("stepper", "with ends", step)
    class WithEnds(FixedStepper):
        """Only for this test. Source: see `WITH_ENDS`."""

        tableau = Tableau(*WITH_ENDS[name])

    try:
        r = rt.loads(model("with ends")).simulate(2.0, step=1e-4 if name != "euler" else 1e-5, t_eval=[0.0, 2.0])
    finally:
        registry._families["stepper"].pop("with ends")
    exact = rt.loads(model("dop853")).simulate(2.0, t_eval=[0.0, 2.0])
    assert r.peaks["O.force"].rms == pytest.approx(exact.peaks["O.force"].rms, rel=1e-6 if name != "euler" else 1e-3)
    assert r.peaks["O.force"].value == pytest.approx(
        exact.peaks["O.force"].value, rel=1e-6 if name != "euler" else 1e-3
    )


def test_a_method_of_order_five_has_mean_squares_side_by_side_too():
    @kind("stepper", "cash-karp", step)
    class CashKarp(AdaptiveStepper):
        """Source: Cash, Karp, ACM Trans. Math. Software 16 (1990) 201-222."""

        tableau = Tableau(
            order=5,
            times=(0, 1 / 5, 3 / 10, 3 / 5, 1, 7 / 8),
            rows=(
                (), (1 / 5,), (3 / 40, 9 / 40), (3 / 10, -9 / 10, 6 / 5), (-11 / 54, 5 / 2, -70 / 27, 35 / 27),
                (1631 / 55296, 175 / 512, 575 / 13824, 44275 / 110592, 253 / 4096),
            ),
            weights=(37 / 378, 0, 250 / 621, 125 / 594, 0, 512 / 1771),
            errors=((37 / 378 - 2825 / 27648, 0, 250 / 621 - 18575 / 48384, 125 / 594 - 13525 / 55296,
                     -277 / 14336, 512 / 1771 - 1 / 4),),
        )  # fmt: skip

    try:
        m = rt.loads(model("cash-karp").replace("length = 0.5", 'length = "l"') + "[parameters]\nl = 0.5\n")
        many = m.many({"l": [0.45, 0.5, 0.55]}, ["rms(O.force)"], t_end=1.0)
        alone = [m.set(l=x).simulate(1.0).peaks["O.force"].rms for x in (0.45, 0.5, 0.55)]
    finally:
        registry._families["stepper"].pop("cash-karp")
    assert len(many.generic) == 0
    assert many["rms(O.force)"] == pytest.approx(alone, rel=1e-6)


@pytest.mark.nojit
def test_a_tableau_without_an_error_estimate_cannot_choose_steps():
    with pytest.raises(InputError, match="no error estimate"):

        class _Adaptive(AdaptiveStepper):
            tableau = kinds("stepper")["heun"].leaf.tableau
