"""`set` and `remove` reach everything in a model file, keep its comments, and say what stands in the way."""

import tomllib

import pytest
from click.testing import CliRunner

import rattle as rt
from rattle.cli.main import main

pytestmark = [pytest.mark.nojit, pytest.mark.plain]

TEXT = """\
format = 1
name = "door"   # a title

[parameters]
l = "0.8 m"     # width
w = { value = 2, tol = 0.1 }

[signals]
half = "door.angle/2"   # seen by the filter

[states]
q = { rate = "half - q", start = 0 }    # a filter

[tables]
lift = { x = [0, 1, 2], y = [0, 1, 0] } # as measured

[ground.points]
O = [0, 0]

[bodies.door]   # a leaf
bar = ["O", "E"]
length = "l"
mass = 3        # heavy

[bodies.arm]
bar = ["E", "F"]
length = "0.3 m"
mass = 1

[joints.hinge]
type = "revolute"
connect = ["ground.O", "door.O"]
stop = { min = "0 deg", max = "110 deg" }   # a wall

[joints.pin]
type = "revolute"
connect = ["door.E", "arm.E"]
contact = "impact"      # hard
clearance = "1 mm"

[drivers.motor]
joint = "hinge"
angle = "w*t"   # steadily

[loads.M]
type = "torque"
body = "arm"
torque = "0.1*t"

[initial]
arm = { angle = 0.1 }
"""
BARE = """\
format = 1

[ground.points]
O = [0, 0]

[bodies.disc]
mass = 1
inertia = 1
points = { O = [0, 0] }

[joints.O]
type = "revolute"
connect = ["ground.O", "disc.O"]    # a pin
"""


def written(m):
    """The document of a mechanism, after it was written as text and read again."""
    found, made = ({key: one for key, one in x.items() if one != {}} for x in (tomllib.loads(m.to_toml()), m._document))
    assert found == made
    return found


@pytest.mark.parametrize(
    ("path", "value", "line"),
    [
        ("drivers.motor.angle", "3*t", 'angle = "3*t"   # steadily'),
        ("states.q.rate", "-q", 'q = { rate = "-q", start = 0 }    # a filter'),
        ("states.q.start", 1, 'q = { rate = "half - q", start = 1 }    # a filter'),
        ("signals.half", "door.omega", 'half = "door.omega"   # seen by the filter'),
        ("tables.lift.y.1", 3, "lift = { x = [0, 1, 2], y = [0, 3, 0] } # as measured"),
        ("loads.M.torque", 2, "torque = 2"),
        ("joints.hinge.stop.max", "90 deg", 'stop = { min = "0 deg", max = "90 deg" }   # a wall'),
        ("joints.pin.contact.restitution", 0.4, 'contact = { model = "impact", restitution = 0.4 }      # hard'),
        ("parameters.l.tol", "1 mm", 'l = { value = "0.8 m", tol = "1 mm" }     # width'),
        ("name", "hatch", 'name = "hatch"   # a title'),
        ("ground.points.O.1", 0.5, "O = [0, 0.5]"),
    ],
)
def test_a_change_alters_one_line_and_keeps_its_comment(path, value, line):
    m = rt.loads(TEXT).set({path: value})
    written(m)
    old, new = TEXT.splitlines(), m.to_toml().splitlines()
    assert [b for a, b in zip(old, new, strict=True) if a != b] == [line]


@pytest.mark.parametrize(
    ("changes", "seen"),
    [
        ({"gravity": [0, -9.81]}, lambda m: m.model.gravity == (0.0, -9.81)),
        ({"gravity.1": -9.81}, lambda m: m.model.gravity == (0.0, -9.81)),
        ({"simulate.t_end": "3 s"}, lambda m: m.model.settings.t_end == 3.0),
        ({"loads.M": {"type": "torque", "body": "disc", "torque": 2}}, lambda m: m.model.loads["M"].values == (2.0,)),
        ({"drivers.motor": {"joint": "O", "angle": "t"}}, lambda m: m.model.drivers["motor"].joint == "O"),
        ({"joints.O.stop.max": 2}, lambda m: m.model.joints["O"].stop.maximum == 2.0),
        (
            {"joints.O.clearance": "1 mm", "joints.O.contact": "impact", "joints.O.contact.restitution": 0.5},
            lambda m: m.model.joints["O"].contact.fields["restitution"] == 0.5,
        ),
        ({"bodies.disc.points.P": [1, 2]}, lambda m: m.model.bodies["disc"].points["P"] == (1.0, 2.0)),
        ({"bodies.disc.center.0": 0.5}, lambda m: m.model.bodies["disc"].points["O"] == (-0.5, 0.0)),
        ({"bodies.arm": {"bar": ["A", "B"], "length": 1, "mass": 2}}, lambda m: m.model.bodies["arm"].mass == 2.0),
        ({"parameters.k": 2, "bodies.disc.mass": "k"}, lambda m: m.model.bodies["disc"].mass == 2.0),
        ({"signals.s": "disc.angle"}, lambda m: list(m.model.signals) == ["s"]),
        ({"states.z": {"rate": "disc.angle"}}, lambda m: m.model.states["z"].start == 0.0),
        ({"tables.lift": {"x": [0, 1], "y": [0, 1]}}, lambda m: "lift" in m.to_toml()),
        ({"initial.disc.omega": 2}, lambda m: m.model.initial.bodies["disc"] == {"omega": 2.0}),
    ],
)
def test_what_a_model_does_not_have_yet_is_added(changes, seen):
    m = rt.loads(BARE).set(changes)
    assert seen(m)
    written(m)
    assert seen(rt.loads(m.to_toml()))
    assert "# a pin" in m.to_toml()


def test_a_number_for_friction_becomes_a_table_where_a_field_of_it_is_set():
    given = {"joints.pin.contact": {"model": "impact", "friction": 0.1, "bush_radius": "1 cm"}}
    m = rt.loads(TEXT).set(given).set({"joints.pin.contact.friction.mu": 0.3})
    assert m.model.joints["pin"].contact.fields["friction"] == 0.3
    written(m)


def test_a_load_takes_instants_and_values_and_takes_others_later():
    first = rt.loads(TEXT).set({"loads.M.torque": ([0, 1], [0, 5])})
    again = first.set({"loads.M.torque": ([0, 2], [1, 7])})
    push = {"type": "force", "at": "arm.F", "force": [([0, 1], [0, 2]), 3]}
    both = again.set({"loads.push": push})
    assert written(first)["tables"]["M_torque"] == {"x": [0, 1], "y": [0, 5], "kind": "linear"}
    assert written(again)["tables"]["M_torque"]["y"] == [1, 7]
    assert written(both)["loads"]["push"]["force"] == ["push_force_x(t)", 3]
    assert "# as measured" in both.to_toml()


# ---------------------------------------------------------------- removing
@pytest.mark.parametrize("name", ["loads.M", "M"])
def test_an_entry_is_removed_by_its_path_or_its_name(name):
    m = rt.loads(TEXT).remove(name)
    assert "loads" not in written(m)
    assert [line for line in TEXT.splitlines() if "#" in line] == [x for x in m.to_toml().splitlines() if "#" in x]
    assert rt.loads(TEXT).set({name: None}).to_toml() == m.to_toml()


def test_a_body_goes_with_its_start_and_the_motion_is_that_of_what_is_left():
    whole = rt.loads(TEXT).remove("arm", "pin", "M")
    assert "arm" not in whole.to_toml()
    assert set(whole.model.bodies) == {"door"}
    assert "initial" not in written(whole)
    assert rt.loads(whole.to_toml()).start.q == pytest.approx(whole.start.q)


@pytest.mark.parametrize(
    ("names", "words"),
    [
        (["arm"], "bodies.arm: still needed by joints.pin and loads.M: remove them too, or change what needs it"),
        (["hinge"], "joints.hinge: still needed by drivers.motor: remove that too"),
        (["half"], "signals.half: still needed by states.q: remove that too"),
        (["w"], "parameters.w: still needed by drivers.motor: remove that too"),
        (["motr"], "no parameter 'motr', and not a path"),
        (["loads.N"], "there is no 'loads.N' in the model; known: M"),
        (["joints.pin.stop"], "there is no 'joints.pin.stop' in the model; known: type, connect, contact, clearance"),
        (["joints.pin.stop.max"], "there is no 'joints.pin.stop' in the model"),
        (["hinge.stop"], "hinge.stop: expected the whole path, 'joints.hinge.stop'"),
    ],
)
def test_what_is_still_needed_or_was_never_there_is_named(names, words):
    with pytest.raises(rt.ModelError) as caught:
        rt.loads(TEXT).remove(*names)
    assert str(caught.value).startswith(words) or words in str(caught.value)
    if "still needed" in words:
        assert len(caught.value.problems) > 1  # with the lines that need it
        assert caught.value.problems[1].line


def test_what_is_named_as_needing_a_part_is_all_that_needs_it():
    with pytest.raises(rt.ModelError) as caught:
        rt.loads(TEXT).remove("door")
    said = str(caught.value).split("needed by ")[1].split(":")[0].replace(" and ", ", ").split(", ")
    assert set(said) == {"signals.half", "states.q", "joints.hinge", "joints.pin", "drivers.motor"}
    assert set(rt.loads(TEXT).remove("door", *said).model.bodies) == {"arm"}


def test_a_name_that_two_entries_have_needs_its_path():
    m = rt.loads(TEXT).set({"loads.door": {"type": "torque", "body": "door", "torque": 1}})
    with pytest.raises(rt.ModelError, match=r"door: expected the whole path, 'bodies.door' or 'loads.door'"):
        m.remove("door")
    assert "door" not in m.remove("loads.door").model.loads


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"door.mass": 2}, "door.mass: expected the whole path, 'bodies.door.mass'"),
        ({"hinge": 2}, "expected the whole path, 'joints.hinge'; or name what is to change in it: joints.hinge.KEY"),
        ({"gravty": [0, 0]}, "not a path like joints.O3.clearance; did you mean 'gravity'?"),
        ({"gravity": 9.81}, "gravity: expected [x, y] in m/s^2, got 9.81"),
        ({"joints.pin.stp.max": 1}, "joints.pin.stp: unknown key; did you mean 'stop'?"),
        ({"loads.N.torque": 1}, "there is no 'loads.N' in the model; known: M"),
        ({"states.p.rate": "1"}, "there is no 'states.p' in the model"),
        ({"tables.lift.x": [0, 0, 1]}, "tables.lift.x[1]: 0 does not follow on 0: x must increase"),
        ({"joints.hinge.stop.min": "120 deg"}, "must be less than max"),
        ({"initial.amr.angle": 1}, "no body or clearance joint 'amr'; did you mean 'arm'?"),
        ({"drivers.motor.angle": "half"}, "a driver must depend on time only, but 'half' depends on the motion"),
    ],
)
def test_a_change_that_cannot_be_says_where_and_what_to_do(change, words):
    with pytest.raises(rt.ModelError) as caught:
        rt.loads(TEXT).set(change)
    assert words in str(caught.value)


def test_a_limit_is_not_missed_by_rounding():
    m = rt.loads(
        "format = 1\nground.points.O = [0, 0]\n[parameters]\na = { value = 0.175, min = 0.14, max = 0.21 }\n"
        '[bodies.b]\nmass = 1\ninertia = 1\npoints = { P = ["a", 0] }\n'
    )
    assert 0.8 * 0.175 < 0.14  # by one digit of its last place
    assert m.set(a=0.8 * 0.175).parameters["a"] == pytest.approx(0.14)
    with pytest.raises(rt.ModelError, match="not between"):
        m.set(a=0.1399)


def test_a_study_over_an_entry_says_how_to_make_it_a_parameter():
    m = rt.loads(TEXT)
    with pytest.raises(KeyError, match=r'm.set\({"parameters.NAME": VALUE, "bodies.arm.mass": "NAME"}\)'):
        m.sweep({"bodies.arm.mass": [1, 2]}, ["max(door.angle)"])


# ---------------------------------------------------------------- the same on the command line
def kept(tmp_path, *words):
    """What `rattle check` says of the model in TEXT with these options."""
    file = tmp_path / "door.toml"
    file.write_text(TEXT)
    return CliRunner().invoke(main, ["check", str(file), *words])


def test_the_command_line_takes_tables_truth_values_and_quotes(tmp_path):
    words = ["--set", 'loads.M={type="torque", body="arm", torque="2 N*m"}', "--set", 'name="a hatch"']
    done = kept(tmp_path, *words, "--set", "gravity=[0, -9.81]", "--set", "joints.pin.stop.max=1")
    assert done.exit_code == 0, done.stderr
    assert done.stdout.startswith("a hatch: 2 bodies")
    refused = kept(tmp_path, "--set", "joints.pin.internal=true")
    assert "joints.pin.internal: unknown key" in refused.stderr
    assert kept(tmp_path, "--set", 'name="a').exit_code == 2


def test_the_command_line_leaves_out_by_name(tmp_path):
    done = kept(tmp_path, "--without", "arm", "--without", "pin", "--without", "M")
    assert done.exit_code == 0, done.stderr
    assert "door: 1 body, 1 joint," in done.stdout
    refused = kept(tmp_path, "--without", "arm")
    assert refused.exit_code == 2
    assert "still needed by joints.pin and loads.M" in refused.stderr


def test_line_ends_and_tables_of_one_line_stay():
    """A new body goes into the table of one line, where a heading of its own would be no TOML."""
    body = "{ points = { P = [0, 0] }, mass = 1, inertia = 1 }"
    m = rt.loads(f"format = 1\r\nbodies = {{ a = {body} }} # all\r\n")
    more = m.set({"bodies.b": {"points": {"P": [0, 0]}, "mass": 1, "inertia": 1}})
    assert more.to_toml() == f"format = 1\r\nbodies = {{ a = {body}, b = {body} }} # all\r\n"
    assert m.set({"name": "door"}).to_toml().count("\n") == m.set({"name": "door"}).to_toml().count("\r\n") == 3
