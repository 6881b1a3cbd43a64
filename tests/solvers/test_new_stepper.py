"""A stepper is one class: entered here, it runs through reader, schema, help, catalogue and simulation."""

import math

import numpy as np
import pytest
from click.testing import CliRunner
from test_rates import T_END, order_seen

import rattle as rt
from rattle import registry
from rattle.cli.main import main
from rattle.description.schema import schema
from rattle.equations.motion import derivative
from rattle.jit.functions import kernel
from rattle.registry import kind, kinds
from rattle.solvers.projection import project_on_constraints
from rattle.solvers.sign_watch import watched_change
from rattle.solvers.stepper import AdaptiveStepper, FixedStepper


@kernel("stepper")
def bogacki_shampine(m, t, h, rtol, atol, tame):
    y, k, stage, y_new = m.state, m.slopes, m.stage, m.state_new
    nq, changed, total = 2 * m.change.shape[0], False, 0.0
    for s in range(4):
        for n in range(y.shape[0]):
            if s == 0:
                k[0, n] = m.rate[n]
            elif s == 1:
                stage[n] = y[n] + 0.5 * h * k[0, n]
            elif s == 2:
                stage[n] = y[n] + 0.75 * h * k[1, n]
            else:
                y_new[n] = y[n] + h * (2.0 * k[0, n] + 3.0 * k[1, n] + 4.0 * k[2, n]) / 9.0
                stage[n] = y_new[n]
        if s > 0:
            share = 1.0 if s == 3 else (0.5 if s == 1 else 0.75)
            if tame == 1:
                project_on_constraints(m, t + share * h, stage, stage)
            derivative(m, t + share * h, stage, k[s])
            changed |= watched_change(m)
    for n in range(nq):
        apart = h * (-5.0 * k[0, n] / 72.0 + k[1, n] / 12.0 + k[2, n] / 9.0 - k[3, n] / 8.0)
        total += (apart / (atol + rtol * max(abs(y[n]), abs(y_new[n])))) ** 2
    return math.sqrt(total / nq), changed


@kernel("stepper")
def heun(m, t, h, rtol, atol, tame):
    y, f, k, stage, y_new = m.state, m.rate, m.slopes, m.stage, m.state_new
    for n in range(y.shape[0]):
        stage[n] = y[n] + h * f[n]
    derivative(m, t + h, stage, k[1])
    error = 0.0
    for n in range(y.shape[0]):
        y_new[n] = y[n] + 0.5 * h * (f[n] + k[1, n])
        if not abs(y_new[n]) < math.inf:
            error = math.inf
    return error, watched_change(m)


@kernel("dense output")
def hermite(m, t, h):
    for row in range(3, 7):
        for n in range(m.dense.shape[1]):
            m.dense[row, n] = 0.0


@pytest.fixture(scope="module", autouse=True)
def entered():
    """Both steppers in the registry, for this module alone."""
    kinds("stepper")

    @kind("stepper", "bogacki-shampine", bogacki_shampine)
    class BogackiShampine(AdaptiveStepper):
        """Order 3 that chooses its steps: quick looks.

        Source: Bogacki, Shampine, A 3(2) pair of Runge-Kutta formulas, Appl. Math. Lett. 2 (1989) 321-325.
        """

        order = 3
        stages = 3
        dense_output = hermite
        refinement = 10 ** (1 / 3)

    @kind("stepper", "heun", heun)
    class Heun(FixedStepper):
        """Order 2 with fixed steps.

        Source: Heun, Neue Methoden zur approximativen Integration, Z. Math. Phys. 45 (1900) 23-38.
        """

        order = 2
        stages = 1
        dense_output = hermite
        refinement = 10 ** (1 / 2)

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
