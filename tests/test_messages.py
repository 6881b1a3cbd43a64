"""What a user is told when something does not fit: where, what is known, what to do."""

import pytest
from click.testing import CliRunner

import rattle as rt
from rattle.cli.main import main
from rattle.language.expression import ExpressionError, parse

pytestmark = pytest.mark.nojit

MODEL = """format = 1
[parameters]
payload = "10 kg"
r = { value = "2 mm", min = "0.5 mm", max = "10 mm" }
alpha = { value = "60 deg", min = "50 deg", max = "75 deg" }
[bodies.b]
mass = "%s"
inertia = 1
points = { C = [0, 0] }
[loads.F]
type = "force"
at = "b.C"
force = ["%s", 0]
"""


def refused(mass="payload", force="0"):
    with pytest.raises(rt.ModelError) as caught:
        rt.loads(MODEL % (mass, force))
    return str(caught.value)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("payload + 40 kgs", "kgs is not a unit"),
        ("40*kg", "kg is a unit"),
        ("2 slug", "rattle kinds units"),
        ("0,21 kg", "decimal point"),
    ],
)
def test_units_where_they_cannot_stand(text, said):
    assert said in refused(mass=text)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("1 if t > 1 and t else 0", "'and' joins two conditions"),
        ("(1 if not t else 0)", "'not' takes a condition"),
        ("max(1, t > 1 and t < 2)", "'and' is allowed only between"),
        ("max(t, 2 n)", "did you mean 2 N?"),
        ("2 N*k + b.x*N", "N is a unit, which stands behind a number: 5 N"),
        ("log10(t)", "write log(x)/log(10)"),
        ("ceiling(t)", "known: sin, cos"),
        ("b.D.x", "did you mean 'b.C.x'"),
        ("C.force", "<body>.x .y .angle"),
    ],
)
def test_what_expressions_know(text, said):
    assert said in refused(force=text)


def test_a_choice_inside_a_choice_is_what_the_message_advises():
    parse("(1 if t < 2 else 0) if t > 1 else 0")
    with pytest.raises(ExpressionError, match="has no 'else'"):
        parse("1 if t < 2")


def test_a_value_of_the_wrong_kind_is_blamed_not_its_limits():
    m = rt.loads(MODEL % ("payload", "0"))
    with pytest.raises(rt.ModelError, match=r"parameters\.r\.value: '2 kg' is a mass; expected a length"):
        m.set(r="2 kg")
    with pytest.raises(rt.ModelError, match=r"min = '50 deg' and max = '75 deg' \(a number without a unit is SI: rad"):
        m.set(alpha=30)
    with pytest.raises(rt.ModelError, match=r"min = '0.5 m' and max = '0.8 m' \(a number without a unit is SI: m here"):
        rt.example("fourbar").set(l2=2.0)


def test_what_cannot_be_closed_without_its_play_says_who_disagrees_and_that_play_is_closed():
    with pytest.raises(rt.AssemblyError) as caught:
        _ = rt.example("woodpecker").ideal().start
    said = str(caught.value)
    # the guides of one wall each stand 30 mm off the pole, where the driver holds the sleeve at 0
    assert "driver 'axis' and joints 'lower', 'upper' contradict each other" in said
    assert "clearance of 'lower', 'upper', up to 0.03 m, is closed here" in said
    with pytest.raises(rt.AssemblyError) as caught:
        _ = rt.example("fourbar").ideal().set({"bodies.rocker.length": 0.01, "bodies.coupler.length": 0.3}).start
    assert "is closed here" not in str(caught.value)  # 5 mm are no reason


def test_a_value_that_the_driver_holds_through_a_loop_names_the_joints_of_the_loop():
    notes = rt.example("fourbar").ideal().start.changes
    assert notes[0].startswith("asked for coupler.angle = 60 deg, got 59.4471 deg")
    assert notes[0].endswith("the driver 'motor' holds it through joints 'O1', 'O2', 'O3', 'O4'")


def test_gravity_and_tables_can_be_set():
    m = rt.loads(MODEL % ("payload", "0")).set(gravity=[0, -9.81])
    assert m.model.gravity == (0, -9.81)
    done = CliRunner().invoke(
        main,
        [
            "check",
            "fourbar",
            "--set",
            "gravity=[0, -9.81]",
            "--set",
            'joints.O3.contact={ model = "impact", restitution = 0.5 }',
        ],
    )
    assert done.exit_code == 0, done.output
    assert "impact" in done.output
    with pytest.raises(rt.ModelError, match="gravity"):
        _ = rt.Mechanism("x", gravity=-9.81).model


def test_a_misspelt_example_is_guessed():
    done = CliRunner().invoke(main, ["check", "fourbr"])
    assert done.exit_code == 2
    assert "did you mean 'fourbar'" in done.output


@pytest.mark.parametrize(
    "name", ["driver", "gravity", "materials", "steel", "units", "functions", "names", "initial", "revolute"]
)
def test_kinds_know_everything_that_may_stand_in_a_file(name):
    done = CliRunner().invoke(main, ["kinds", name])
    assert done.exit_code == 0, done.output
    assert len(done.output) > 30


def test_a_driver_is_a_function_of_time_alone():
    text = CliRunner().invoke(main, ["kinds", "driver"]).output
    assert "joint (name)" in text
    assert "coordinate" in text
    assert "may use" not in text


def test_a_load_or_driver_can_be_left_out():
    m = rt.example("fourbar")
    free = m.set({"loads.M": None, "drivers.motor": None})
    assert not free.model.loads
    assert not free.model.drivers
    assert "[loads.M]" not in free.to_toml()
    assert "crank" in free.to_toml()
    with pytest.raises(rt.ModelError, match="did you mean 'motor'"):
        m.set({"drivers.moter": None})
    done = CliRunner().invoke(main, ["check", "fourbar", "--without", "drivers.motor"])
    assert done.exit_code == 0, done.output
    assert "mobility 3" in done.output
