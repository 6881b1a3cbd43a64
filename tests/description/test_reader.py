"""What a model file means: values in SI, dimensions, names, defaults, in whatever order things are written."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

import rattle as rt
from rattle.description.dependence import describe_cycle, in_order
from rattle.description.model import ValueTable
from rattle.description.reader import read
from rattle.language.expression import names, value

pytestmark = [pytest.mark.nojit, pytest.mark.plain]

BAR = {"bar": ["A", "B"], "length": 1, "mass": 12}


def model(**tables):
    return read({"format": 1, "bodies": {"a": BAR}, **tables})


def two(joint, **tables):
    bodies = {"a": BAR, "b": BAR}
    return model(bodies=bodies, joints={"J": {"connect": ["a.B", "b.A"], **joint}}, **tables)


def messages(**tables):
    with pytest.raises(rt.ModelError) as caught:
        model(**tables)
    return [str(one) for one in caught.value.problems]


# ---------------------------------------------------------------- parameters and expressions
def test_parameters_depend_on_each_other_in_any_order():
    m = model(parameters={"c": "2*b", "b": "a + 1", "a": 3})
    assert m.constants == {"a": 3, "b": 4, "c": 8}
    assert list(m.parameters) == ["c", "b", "a"]  # as written


def test_parameters_carry_unit_limits_and_distribution():
    m = model(
        parameters={
            "r": {"value": "5 mm", "min": "0.5 mm", "max": "1 cm", "tol": "r0/2", "dist": "normal"},
            "r0": "1 mm",
        }
    )
    r = m.parameters["r"]
    assert (r.value, r.unit, r.minimum, r.maximum, r.tol, r.dist) == (0.005, "m", 0.0005, 0.01, 0.0005, "normal")


def test_distribution_may_be_a_table_of_values():
    both = {"values": ["6 mm", 0.005, "r0/2"], "weights": [1, 3, "2"]}
    m = model(
        parameters={"r": {"value": "5 mm", "dist": both}, "r0": "8 mm", "s": {"value": 1, "dist": {"values": [2]}}}
    )
    assert m.parameters["r"].dist == ValueTable((0.006, 0.005, 0.004), (1.0, 3.0, 2.0))
    assert m.parameters["s"].dist == ValueTable((2.0,), (1.0,))


def test_groups_are_read_as_written():
    parameters = {"a": 1, "b": "a", "c": "2 mm", "d": "3 mm"}
    assert model(parameters=parameters).groups == ()
    assert model(parameters=parameters, tolerances={}).groups == ()
    groups = [["c", "a"], ["d", "b"]]
    assert model(parameters=parameters, tolerances={"groups": groups}).groups == (("c", "a"), ("d", "b"))


def test_group_is_not_blamed_for_a_parameter_that_cannot_be_read():
    said = messages(parameters={"a": "5 mn", "b": 1}, tolerances={"groups": [["a", "b"]]})
    assert len(said) == 1
    assert said[0].startswith("parameters.a: ")


@given(st.permutations(["a", "b", "c", "d"]))
def test_order_of_writing_is_no_matter(order):
    written = {"a": "0.5 m", "b": "a + a", "c": "a*b", "d": "sqrt(c) + b"}
    m = model(parameters={key: written[key] for key in order})
    assert m.constants["d"] == pytest.approx(math.sqrt(0.5) + 1)
    assert m.parameters["d"].unit == "m"


def test_dimensions_pass_through_parameters():
    said = messages(parameters={"l": "1 m", "area": "l**2"}, bodies={"a": {**BAR, "length": "area"}})
    assert said == ["bodies.a.length: 'area' is an area; expected a length in m"]


def test_plain_numbers_fit_everywhere():
    m = model(parameters={"l": 0.5}, bodies={"a": {**BAR, "length": "l", "mass": "3*l"}})
    assert m.bodies["a"].mass == 1.5


@pytest.mark.parametrize(
    "text", ["t", "0.3 + t", "sin(t)", "omega*t", "0.2*sin(3*t)", "log(2 - t)", "t**2", "5 deg", "omega*2*sin(t)/omega"]
)
def test_functions_of_time_that_an_angle_may_be(text):
    m = two({"type": "revolute"}, parameters={"omega": "10 rad/s"}, drivers={"d": {"joint": "J", "angle": text}})
    assert m.drivers["d"].kind == "angle"


@pytest.mark.parametrize("text", ["speed*t", "sin(l*t)", "l + t", "l"])
def test_functions_of_time_that_are_no_angle(text):
    with pytest.raises(rt.ModelError, match=r"drivers.d.angle"):
        two(
            {"type": "revolute"},
            parameters={"speed": "1 m/s", "l": "1 m"},
            drivers={"d": {"joint": "J", "angle": text}},
        )


def test_signals_come_in_order_of_evaluation_with_units():
    m = model(signals={"power": "force*a.vx", "force": "-10*a.x*k", "half": "0.5 mm"}, parameters={"k": "1 N/m"})
    assert list(m.signals).index("force") < list(m.signals).index("power")
    assert m.signal_units == {"force": "", "power": "", "half": "m"} | {
        k: m.signal_units[k] for k in ("force", "power")
    }
    assert names(m.signals["power"]) == {"force", "a.vx"}
    assert value(m.signals["half"], {}) == 0.0005


def test_driver_may_use_signals_of_time_but_not_of_motion():
    tables = {"drivers": {"d": {"joint": "J", "angle": "ramp"}}}
    assert names(two({"type": "revolute"}, signals={"ramp": "3*t"}, **tables).drivers["d"].value) == {"ramp"}
    with pytest.raises(rt.ModelError, match="'ramp' depends on the motion"):
        two({"type": "revolute"}, signals={"ramp": "inner", "inner": "a.angle"}, **tables)


@given(st.dictionaries(st.sampled_from("abcdef"), st.sets(st.sampled_from("abcdef"))))
def test_order_of_evaluation_on_any_graph(uses):
    from rattle.language.syntax import parse

    nodes = {name: parse(" + ".join(sorted(others)) or "1") for name, others in uses.items()}
    order, cycles = in_order(nodes)
    done = set()
    on_cycle = {name for cycle in cycles for name in cycle}
    assert set(order) | on_cycle == set(nodes)
    for name in order:
        assert (names(nodes[name]) & nodes.keys()) - on_cycle <= done
        done.add(name)
    for cycle in cycles:
        assert all(after in names(nodes[before]) for before, after in zip(cycle, [*cycle[1:], cycle[0]], strict=True))
        assert describe_cycle(cycle).startswith("defined by itself")


def test_long_chain_of_parameters_is_no_trouble():
    chain = {f"p{n}": f"p{n + 1} + 1" for n in range(3000)} | {"p3000": 0}
    assert model(parameters=chain).constants["p0"] == 3000


# ---------------------------------------------------------------- bodies
def test_bar_has_its_mass_centre_in_the_middle():
    bar = model(bodies={"a": {**BAR, "points": {"P": [0.1, 0.2]}}}).bodies["a"]
    assert bar.points == {"A": (-0.5, 0), "B": (0.5, 0), "P": (0.1, 0.2)}
    assert bar.inertia == 1.0  # m l^2 / 12


def test_points_of_a_body_are_taken_from_its_mass_centre():
    body = {"points": {"P": [1, 2], "Q": ["3 cm", 0]}, "center": [1, 0], "mass": 1, "inertia": "2 kg*m^2"}
    assert model(bodies={"a": body}).bodies["a"].points == {"P": (0, 2), "Q": (0.03 - 1, 0)}


# ---------------------------------------------------------------- joints
def test_angle_of_a_slider_is_that_of_its_axis_unless_given():
    assert two({"type": "prismatic", "axis": "30 deg"}).joints["J"].fields["angle"] == pytest.approx(math.pi / 6)
    assert two({"type": "prismatic", "axis": 1, "angle": 0}).joints["J"].fields["angle"] == 0
    assert two({"type": "prismatic"}).joints["J"].fields == {"axis": 0.0, "angle": 0.0}


def test_contact_is_a_massless_link_unless_said():
    assert two({"type": "revolute", "clearance": "1 mm"}).joints["J"].contact.model == "massless-link"
    assert two({"type": "revolute", "clearance": 0, "contact": "ideal"}).joints["J"].contact.model == "ideal"
    assert two({"type": "revolute"}).joints["J"].contact is None


def test_contact_that_does_not_suit_the_joint_says_which_do():
    with pytest.raises(rt.ModelError, match=r"joints.J.*'massless-link'.*prismatic joint.*expected.*ideal"):
        two({"type": "prismatic", "clearance": 0.001, "contact": "massless-link"})


def test_contact_that_was_not_written_is_not_found_fault_with():
    """A slot or guide has no usual contact: what is missing is said, not that a massless link does not suit it."""
    with pytest.raises(rt.ModelError, match="a slot joint with clearance needs a contact: ideal, impact, exact"):
        rt.example("scotch_yoke").set({"joints.slot.contact": None})
    with pytest.raises(rt.ModelError, match="a prismatic joint with clearance needs a contact: ideal, impact"):
        two({"type": "prismatic", "clearance": 0.001})
    with pytest.raises(rt.ModelError, match=r"joints.J.clearance: a fixed joint cannot have clearance; leave it out"):
        two({"type": "fixed", "clearance": 0.001})


def test_joints_may_be_written_before_bodies():
    m = rt.loads(
        'format = 1\n[joints.J]\ntype = "revolute"\nconnect = ["ground.O", "a.A"]\n'
        '[bodies.a]\nbar = ["A", "B"]\nlength = 1\nmass = 1\n[ground.points]\nO = [0, 0]\n'
    )
    assert m.model.joints["J"].b.at == (-0.5, 0)


@pytest.mark.parametrize(
    ("driver", "words"),
    [
        ({"joint": "J"}, "needs angle"),
        ({"angle": 1}, "needs joint"),
        ({"joint": "J", "body": "a", "angle": 1}, "not both"),
        ({"joint": "J", "coordinate": "x", "angle": 1}, "only a driven body"),
        ({"body": "a", "position": 1}, "expected coordinate = one of x, y, angle"),
        ({"body": "a", "coordinate": "z", "position": 1}, "one of x, y, angle, got 'z'"),
        ({"body": "a", "coordinate": "angle", "position": 1}, "driven by 'angle', not by 'position'"),
        ({"body": "ground", "coordinate": "x", "position": 1}, "the ground does not move"),
        ({"body": "c", "coordinate": "x", "position": 1}, "no body 'c'"),
    ],
)
def test_driver_that_cannot_be(driver, words):
    with pytest.raises(rt.ModelError) as caught:
        two({"type": "revolute"}, drivers={"d": driver})
    assert words in str(caught.value)
    assert len(caught.value.problems) == 1


def test_driver_of_a_body_takes_a_point_or_the_mass_centre():
    drivers = {
        "d": {"body": "a.B", "coordinate": "x", "position": "0.1*t"},
        "e": {"body": "a", "coordinate": "x", "position": 0},
    }
    m = two({"type": "revolute"}, drivers=drivers)
    assert m.drivers["d"].point.at == (0.5, 0)
    assert m.drivers["e"].point.at == (0, 0)
    with pytest.raises(rt.ModelError, match="two drivers on one degree of freedom"):
        two({"type": "revolute"}, drivers={"d": drivers["d"], "e": drivers["d"]})


@pytest.mark.parametrize("kind", ["rod", "fixed"])
def test_joint_without_a_freedom_to_drive(kind):
    fields = {"length": 1} if kind == "rod" else {}
    with pytest.raises(rt.ModelError, match=f"a {kind} joint has nothing to drive; expected prismatic or revolute"):
        two({"type": kind, **fields}, drivers={"d": {"joint": "J", "angle": 1}})


# ---------------------------------------------------------------- loads, start, settings
def test_load_values_may_change_and_keep_their_dimension():
    m = model(loads={"f": {"type": "force", "at": "a.B", "force": ["sin(t)", "-2*a.vy"], "frame": "body"}})
    load = m.loads["f"]
    assert load.values[:2] == (0.5, 0)
    assert names(load.values[3]) == {"a.vy"}
    assert load.values[4] == 1.0
    said = messages(parameters={"k": "3 N/m"}, loads={"f": {"type": "torque", "body": "a", "torque": "k*a.x"}})
    assert said == ["loads.f.torque: 'k*a.x' is a force; expected a moment or energy in N*m"]


def test_load_may_act_at_the_mass_centre_of_a_body():
    m = model(
        ground={"points": {"O": [1, 0]}}, loads={"s": {"type": "spring", "connect": ["ground.O", "a"], "stiffness": 5}}
    )
    assert m.loads["s"].b.at == (0, 0)


def test_settings_and_start_in_any_unit():
    m = model(simulate={"t_end": "1 min", "output": "1 ms"}, initial={"a": {"angle": "90 deg", "omega": "60 rpm"}})
    assert m.settings.t_end == 60
    assert m.initial.bodies["a"]["omega"] == pytest.approx(2 * math.pi)


def test_empty_model_needs_a_body():
    with pytest.raises(rt.ModelError, match="a mechanism needs at least one body"):
        read({"format": 1})


def test_a_parameter_has_a_label_and_a_description():
    """They are read, written again, said by `check`, and refused where they are no words."""
    m = rt.Mechanism("labels")
    m.parameter("l", "300 mm", label="length of the arm", description="from  pin\nto tip")
    m.ground(O=[0, 0])
    m.bar("arm", "O", "P", length="l", mass=1)
    m.revolute("O", "ground.O", "arm.O")
    one = rt.loads(m.to_toml()).model.parameters["l"]
    assert (one.label, one.description, one.title) == ("length of the arm", "from pin to tip", "length of the arm (l)")
    assert "parameter: length of the arm (l) 300 mm: from pin to tip" in str(m.check())
    for wrong, said in ((3, "3 is no text"), (61 * "x", "61 characters are too long for a label, 60 at most")):
        other = rt.Mechanism("wrong").parameter("l", 1, label=wrong)
        with pytest.raises(rt.ModelError, match=said):
            _ = other.model


WORN = """format = 1
ground.points = { O = [0, 0] }
bodies.b = { mass = 1, inertia = 1, points = { A = [0.1, 0] } }
[joints.O]
type = "revolute"
connect = ["ground.O", "b.A"]
clearance = "0.1 mm"
contact = { model = "flores", bush_radius = "5 mm", bush_material = "steel", pin_material = "steel", length = 0.01, geometry = "liu", restitution = 0.9 }
wear = { bush = "1e-9 mm^3/(N*m)", jump = JUMP }
"""  # noqa: E501  # one line a table


@pytest.mark.parametrize(("jump", "cycles"), [("100", 100.0), ('"2*50"', 100.0), ('"auto"', math.nan)])
def test_the_jump_of_wear_is_a_number_or_auto(jump, cycles):
    assert rt.loads(WORN.replace("JUMP", jump)).model.joints["O"].wear.jump == pytest.approx(cycles, nan_ok=True)


@pytest.mark.parametrize("jump", ["true", "-5", '"autox"', "[1]"])
def test_other_jumps_of_wear_are_refused(jump):
    with pytest.raises(rt.ModelError, match=r"wear\.jump"):
        rt.loads(WORN.replace("JUMP", jump))
