"""Everything that can be wrong with a model says what, where and what is expected, and nothing else comes out."""
# ruff: noqa: E501  a case is a line

import copy
import json
import logging
import tomllib
from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

import rattle as rt
from rattle.description import file as model_file
from rattle.description.reader import read
from rattle.errors import MOST, ModelError

pytestmark = [pytest.mark.nojit, pytest.mark.plain]

TEXT = (Path(__file__).parents[1] / "data" / "full.toml").read_text()
DOCUMENT = tomllib.loads(TEXT)


def refusal(text):
    with pytest.raises(ModelError) as caught:
        rt.loads(text)
    return caught.value


def changed(old, new):
    assert TEXT.count(old) >= 1, old
    return TEXT.replace(old, new, 1)


# what is written instead of what; the key path, what the message must hold, and what the caret stands under
CASES = {
    "unknown table": ("[signals]", "[signal]", "signal", ["unknown key", "'signals'"], "signal]"),
    "unknown key": ('clearance = "r3"', 'clearence = "r3"', "joints.O3.clearence", ["did you mean 'clearance'"], "clear"),
    "unknown inline key": ("{ angle = ", "{ angel = ", "initial.coupler.angel", ["did you mean 'angle'"], "angel"),
    "unknown joint kind": ('"revolute"', '"revolut"', "joints.O1.type", ["joint", "did you mean 'revolute'"], '"revolut"'),
    "unknown load kind": ('"torque"', '"moment"', "loads.M.type", ["unknown load 'moment'", "torque"], '"moment"'),
    "unknown contact": ('contact = "massless-link"', 'contact = "massles-link"', "joints.O3.contact", ["'massless-link'"], '"massles'),
    "unknown method": ('"dop853"', '"dopri"', "simulate.method", ["dop853"], '"dopri"'),
    "wrong format": ("format = 1", "format = 2", "format", ["expected format = 1", "2"], "2"),
    "wrong dimension": ("mass = 0.5", 'mass = "2 mm"', "bodies.crank.mass", ["is a length", "expected a mass in kg"], '"2 mm"'),
    "wrong dimension of an expression": ('length = "l1"', 'length = "l1*l2"', "bodies.crank.length", ["'l1*l2' is an area", "expected a length in m"], '"l1*l2"'),
    "adding lengths and angles": ('length = "l1"', 'length = "l1 + omega"', "bodies.crank.length", ["cannot add m and 1/s"], "+ omega"),
    "sine of a length": ('angle = "alpha"', 'angle = "sin(l1)"', "initial.coupler.angle", ["cannot take sin of m"], "sin(l1)"),
    "unknown unit": ('l1 = "0.2 m"', 'l1 = "0.2 metre"', "parameters.l1", ["unknown unit 'metre'"], '"0.2 metre"'),
    "unit in other case": ('M = "40 N*m"', 'M = "40 n*m"', "parameters.M", ["unknown unit 'n'", "'N'"], '"40 n*m"'),
    "wrong dimension of a limit": ('tol = "0.5 mm"', 'tol = "0.5 kg"', "parameters.r3.tol", ["is a mass", "expected a length in m"], '"0.5 kg"'),
    "unknown distribution": ('tol = "0.5 mm"', 'dist = "gauss"', "parameters.r3.dist", ["unknown distribution 'gauss'", "uniform, normal, triangular or { values ="], '"gauss"'),
    "number for a distribution": ('tol = "0.5 mm"', "dist = 3", "parameters.r3.dist", ["unknown distribution 3"], "3"),
    "table without values": ('tol = "0.5 mm"', "dist = { weights = [1] }", "parameters.r3.dist", ["expected { values = [...] }"], "{ weights"),
    "misspelt key of a table": ('tol = "0.5 mm"', "dist = { values = [1], weigths = [1] }", "parameters.r3.dist.weigths", ["did you mean 'weights'"], "weigths"),
    "table that is empty": ('tol = "0.5 mm"', "dist = { values = [] }", "parameters.r3.dist.values", ["got an empty one"], "[]"),
    "text for values": ('tol = "0.5 mm"', 'dist = { values = "5 mm" }', "parameters.r3.dist.values", ["expected a list of values, got '5 mm'"], '"5 mm" }'),
    "value of another dimension": ('tol = "0.5 mm"', 'dist = { values = ["5 mm", "6 kg"] }', "parameters.r3.dist.values[1]", ["is a mass", "expected a length in m"], '"6 kg"'),
    "truth for a value": ('tol = "0.5 mm"', "dist = { values = [true] }", "parameters.r3.dist.values[0]", ["true"], "true"),
    "weights of another number": ('tol = "0.5 mm"', 'dist = { values = ["5 mm", "6 mm"], weights = [1] }', "parameters.r3.dist.weights", ["1 weights for 2 values"], "[1]"),
    "weights without a list": ('tol = "0.5 mm"', 'dist = { values = ["5 mm"], weights = 1 }', "parameters.r3.dist.weights", ["expected a list of weights, got 1"], "1 }"),
    "weight negative": ('tol = "0.5 mm"', 'dist = { values = ["5 mm", "6 mm"], weights = [1, -2] }', "parameters.r3.dist.weights[1]", ["-2 must not be negative"], "-2"),
    "weight infinite": ('tol = "0.5 mm"', 'dist = { values = ["5 mm"], weights = [inf] }', "parameters.r3.dist.weights[0]", ["not a finite number"], "inf"),
    "weights zero": ('tol = "0.5 mm"', 'dist = { values = ["5 mm", "6 mm"], weights = [0, 0.0] }', "parameters.r3.dist.weights", ["all weights are zero"], "[0, 0.0]"),
    "value outside its limits": ('max = "10 mm"', 'max = "1 mm"', "parameters.r3.value", ["not between min = '0.5 mm' and max = '1 mm'"], '"5 mm"'),
    "missing body": ('"crank.O2", "coupler', '"crnak.O2", "coupler', "joints.O2.connect[0]", ["no body 'crnak'", "'crank'"], '"crnak'),
    "missing point": ('"coupler.O3", "rocker', '"coupler.O33", "rocker', "joints.O3.connect[0]", ["no point 'O33' on body 'coupler'", "'O3'"], '"coupler.O33'),
    "missing ground point": ('"ground.O1", "crank', '"ground.O7", "crank', "joints.O1.connect[0]", ["the ground"], '"ground.O7'),
    "missing joint": ('joint = "O1"', 'joint = "O11"', "drivers.motor.joint", ["no joint 'O11'", "'O1'"], '"O11"'),
    "missing body of a load": ('body = "rocker"', 'body = "rokcer"', "loads.M.body", ["no body", "'rocker'"], '"rokcer"'),
    "missing body in the start": ("rocker = { angle", "rockr = { angle", "initial.rockr", ["no body", "'rocker'"], "rockr"),
    "missing name in an expression": ('twice = "2*l1"', 'twice = "2*l_1"', "parameters.twice", ["unknown name 'l_1'", "'l1'"], 'l_1"'),
    "quantity without number": ('free_length = "l2"', 'free_length = "long"', "loads.back.free_length", ["unknown name 'long'", "expected a length in m"], 'long"'),
    "body called like a joint": ("[bodies.crank]", "[bodies.O1]", "joints.O1", ["'O1' is already used in [bodies]"], "O1]"),
    "signal called like a parameter": ("reach = ", "l1 = ", "signals.l1", ["already a parameter"], "l1"),
    "signal called like a driver": ("reach = ", "motor = ", "signals.motor", ["is already used in [drivers]"], "motor"),
    "end points of a bar with one name": ('bar = ["O1", "O2"]', 'bar = ["O1", "O1"]', "bodies.crank.bar", ["used twice"], '["O1"'),
    "name of a function": ("l3 = ", "sin = ", "parameters.sin", ["reserved word"], "sin"),
    "name that is none": ("l3 = ", '"l 3" = ', "parameters.l 3", ["is not a name"], '"l 3"'),
    "joint from a body to itself": ('"crank.O2", "coupler.O2"', '"crank.O2", "crank.O1"', "joints.O2.connect", ["both ends are on 'crank'"], '["crank.O2'),
    "mass negative": ("mass = 0.5", 'mass = "-2 kg"', "bodies.crank.mass", ["must not be negative"], '"-2 kg"'),
    "no mass": ("mass = 0.5", "", "bodies.crank", ["needs a mass in kg"], "crank]"),
    "inertia negative": ("inertia = 0.06", "inertia = -0.06", "bodies.rocker.inertia", ["must not be negative"], "-0.06"),
    "no inertia": ("inertia = 0.06", "", "bodies.rocker", ["inertia", "kg*m^2"], "rocker]"),
    "inertia out of range": ('length = "l1"', "length = 1e40", "bodies.crank", ["out of range"], "crank]"),
    "length negative": ('length = "l1"', 'length = "-l1"', "bodies.crank.length", ["must be positive"], '"-l1"'),
    "clearance negative": ('clearance = "r3"', 'clearance = "-1 mm"', "joints.O3.clearance", ["must not be negative"], '"-1 mm"'),
    "contact without clearance": ('clearance = "r3"', "", "joints.O3.contact", ["needs a clearance"], "contact"),
    "nan": ("mass = 0.5", "mass = nan", "bodies.crank.mass", ["not a finite number"], "nan"),
    "infinity as text": ("mass = 0.5", 'mass = "inf kg"', "bodies.crank.mass", ["not a finite number"], '"inf kg"'),
    "huge whole number": ("mass = 0.5", "mass = 1" + 400 * "0", "bodies.crank.mass", ["not a finite number"], "1000"),
    "division by zero": ('length = "l1"', 'length = "l1*l1/(l2 - l3)"', "bodies.crank.length", ["not a finite number"], "/(l2 - l3)"),
    "parameter by itself": ('twice = "2*l1"', 'twice = "2*twice"', "parameters.twice", ["defined by itself: twice -> twice"], '"2*twice"'),
    "signals in a ring": ('rate = "coupler.vx"', 'rate = "speed"', "signals.speed", ["rate -> speed"], '"hypot'),
    "attribute access": ('length = "l1"', 'length = "().__class__"', "bodies.crank.length", ["unexpected character"], ".__class__"),
    "call": ('length = "l1"', "length = \"__import__('os')\"", "bodies.crank.length", ["expression cannot contain text"], "'os'"),
    "unknown function": ('length = "l1"', 'length = "l1 + eval(l2)"', "bodies.crank.length", ["there is no function 'eval'"], "eval(l2)"),
    "huge power": ('length = "l1"', 'length = "9**9**9**9"', "bodies.crank.length", ["not a finite number"], "**"),
    "deep nesting": ('length = "l1"', f'length = "{300 * "("}l1{300 * ")"}"', "bodies.crank.length", ["nested more than"], "(("),
    "very long expression": ('length = "l1"', f'length = "l1{3000 * " + l1"}"', "bodies.crank.length", ["at most 2000"], "l1 + l1"),
    "deep table": ('name = "Four', f"x = {40 * '['}{40 * ']'}\nname = \"Four", "x", ["nested more than"], "[[["),
    "time where it may not be": ('length = "l1"', 'length = "l1*t"', "bodies.crank.length", ["'t' changes during the run"], 't"'),
    "state in a driver": ('angle = "omega*t"', 'angle = "reach/l1"', "drivers.motor.angle", ["'reach' depends on the motion"], '"reach'),
    "position of a revolute joint": ('angle = "omega*t"', 'position = "0.1*t"', "drivers.motor.position", ["by 'angle', not by 'position'"], "position"),
    "three coordinates": ("O1 = [0, 0]", "O1 = [0, 0, 0]", "ground.points.O1", ["expected [x, y] in m"], "[0, 0, 0]"),
    "truth for a number": ("mass = 0.5", "mass = true", "bodies.crank.mass", ["expected a mass in kg", "true"], "true"),
    "date for a number": ("mass = 0.5", "mass = 1979-05-27", "bodies.crank.mass", ["expected a mass in kg"], "1979"),
    "list for a joint": ('joint = "O1"', 'joint = ["O1"]', "drivers.motor.joint", ["no joint"], '["O1"]'),
    "number for a table": ("[bodies.crank]", "[bodies]\nlink = 3\n[bodies.crank]", "bodies.link", ["expected a table, got 3"], "3"),
    "wrong frame": ('frame = "body"', 'frame = "bdoy"', "loads.push.frame", ["ground, body", "'body'"], '"bdoy"'),
    "offset without clearance": ("O3 = { offset", "O2 = { offset", "initial.O2", ["no clearance"], "O2"),
    "unknown key of tolerances": ("[signals]", '[tolerances]\ngroup = [["r3", "r4"]]\n[signals]', "tolerances.group", ["did you mean 'groups'"], 'group'),
    "unknown name in a group": ("[signals]", '[tolerances]\ngroups = [["r3", "r44"]]\n[signals]', "tolerances.groups[0][1]", ["no parameter 'r44'", "'r4'"], '"r44"'),
    "name in two groups": ("[signals]", '[tolerances]\ngroups = [["r3", "r4"], ["l1", "r3"]]\n[signals]', "tolerances.groups[1][1]", ["'r3' is in another group already", 'join'], '"r3"]]'),
    "name twice in a group": ("[signals]", '[tolerances]\ngroups = [["r3", "r3"]]\n[signals]', "tolerances.groups[0][1]", ['twice in this group'], '"r3"]]'),
    "group of one": ("[signals]", '[tolerances]\ngroups = [["r3", "r4"], ["l1"]]\n[signals]', "tolerances.groups[1]", ['a group of 1', 'two or more'], '["l1"]'),
    "group without brackets": ("[signals]", '[tolerances]\ngroups = ["r3", "r4"]\n[signals]', "tolerances.groups[0]", ['expected a group of parameters', "got 'r3'"], '"r3"'),
    "number in a group": ("[signals]", '[tolerances]\ngroups = [["r3", 4]]\n[signals]', "tolerances.groups[0]", ['expected a group of parameters'], '["r3"'),
    "text for groups": ("[signals]", '[tolerances]\ngroups = "r3, r4"\n[signals]', "tolerances.groups", ['expected groups of parameters'], '"r3, r4"'),
    "step of nothing": ("rtol = 1e-9", "rtol = 0", "simulate.rtol", ["must be positive"], "0"),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_problem_is_named_with_its_line_a_caret_and_what_is_wanted(case):
    old, new, path, words, under = CASES[case]
    text = changed(old, new)
    error = refusal(text)
    found = [one for one in error.problems if one.key == path]
    assert found, str(error)
    problem = found[0]
    for word in words:
        assert word in problem.message
    line, caret = problem.caret.split("\n")
    assert line.lstrip(".")[:40] in text
    assert line[caret.index("^") :].startswith(under)
    assert f"model:{problem.line}: {path}: " in str(error)
    source = text.split("\n")[problem.line - 1]
    assert under[:5] in source


def test_one_mistake_makes_one_problem():
    several = {
        "unknown key",
        "name of a function",
        "name that is none",
        "body called like a joint",
        "no mass",
        "missing body in the start",
        "unknown table",
    }
    for case, (old, new, *_rest) in CASES.items():
        if case not in several:
            error = refusal(changed(old, new))
            assert len(error.problems) == 1, f"{case}: {error}"


def test_all_problems_are_reported_at_once_in_the_order_of_the_file():
    text = TEXT.replace('clearance = "r3"', 'clearence = "r3"').replace("mass = 0.5", 'mass = "2 mm"')
    lines = [one.line for one in refusal(text).problems]
    assert len(lines) >= 2
    assert lines == sorted(lines)


def test_a_file_with_endless_problems_is_answered_at_once():
    text = "format = 1\n" + "".join(f"[bodies.b{n}]\nmas = 1\n" for n in range(30_000))
    error = refusal(text)
    assert len(error.problems) == MOST
    assert "there may be more" in str(error)


# ---------------------------------------------------------------- text that is no model
@pytest.mark.parametrize(
    ("text", "words", "line"),
    [
        ("format = 1\nmass = 5 kg\n", ["not valid TOML", "quotes"], 2),
        ("format = 1\n[bodies\n", ["not valid TOML"], 2),
        ('format = 1\nname = "open\n', ["not valid TOML"], 2),
        ("format = 1\nformat = 1\n", ["used twice", "format"], 2),
        ("[bodies.a]\nmass = 1\n[bodies.a]\n", ["used twice", "bodies.a"], 3),
        ("[ground]\npoints = { O = [0, 0], O = [1, 0] }\n", ["used twice"], 2),
        ('{"format": 1,\n "name": }', ["not valid JSON"], 2),
        ('{"format": 1, "format": 1}', ["'format' is used twice"], None),
        ("x = " + 5000 * "9", ["cannot read"], None),
        ("x = " + 5000 * "[", ["deep"], None),
        ('{"x": ' + 100_000 * "[", ["deep"], None),
        ("", ["format = 1"], None),
    ],
)
def test_text_that_cannot_be_read_says_why_and_where(text, words, line):
    error = refusal(text)
    for word in words:
        assert word in str(error)
    if line:
        assert error.problems[0].line == line
        assert error.problems[0].caret


def test_file_that_is_no_text(tmp_path):
    file = tmp_path / "latin.toml"
    file.write_bytes('format = 1\nname = "Kurbelschwinge für"\n'.encode("latin-1"))
    with pytest.raises(ModelError, match=r"latin.toml:2: not UTF-8 text \(byte 35\); save the file as UTF-8"):
        rt.load(file)


def test_file_that_is_missing_or_a_folder(tmp_path):
    with pytest.raises(ModelError, match=r"none.toml: cannot read the file: No such file"):
        rt.load(tmp_path / "none.toml")
    with pytest.raises(ModelError, match="cannot read the file: Is a directory"):
        rt.load(tmp_path)
    with pytest.raises(ModelError, match="not a file name"):
        rt.load("a\0b")


def test_file_of_50_megabytes_is_refused_without_reading_it(tmp_path):
    file = tmp_path / "large.toml"
    with file.open("wb") as out:
        out.truncate(50_000_000)
    with pytest.raises(ModelError, match="the file has 50 MB; a model has at most 8 MB"):
        rt.load(file)
    with pytest.raises(ModelError, match="the text has 50 MB"):
        rt.loads(" " * 50_000_000)


def test_file_without_end_is_refused():
    with pytest.raises(ModelError, match="a model has at most 8 MB"):
        rt.load("/dev/zero")


def test_file_name_stands_before_every_problem(tmp_path):
    file = tmp_path / "bad.toml"
    file.write_text(changed('clearance = "r3"', 'clearence = "r3"'))
    with pytest.raises(ModelError) as caught:
        rt.load(file)
    line = TEXT.split('clearance = "r3"')[0].count("\n") + 1
    assert str(caught.value).startswith(f"{file}:{line}: joints.O3.clearence: unknown key; did you mean 'clearance'?\n")


@pytest.mark.parametrize("place", ["missing/out.toml", "file.txt/out.toml", "."])
def test_folder_that_cannot_be_written_is_named(tmp_path, place):
    (tmp_path / "file.txt").write_text("")
    with pytest.raises(OSError, match="cannot write") as caught:
        rt.loads(TEXT).save(tmp_path / place)
    assert str(tmp_path) in str(caught.value)


@pytest.mark.parametrize("clearance", ["nan", '"-1 mm"', '"none"'])
def test_bush_radius_is_not_blamed_for_a_clearance_without_a_value(clearance):
    contact = 'contact = { model = "impact", bush_radius = "1 cm" }'
    text = changed('clearance = "r3"', f"clearance = {clearance}").replace('contact = "massless-link"', contact, 1)
    assert [problem.path for problem in refusal(text).problems] == [("joints", "O3", "clearance")]


# ---------------------------------------------------------------- drivers
def test_two_drivers_on_one_joint():
    error = refusal(changed("[loads.M]", '[drivers.second]\njoint = "O1"\nangle = "t"\n\n[loads.M]'))
    assert "drivers.second: joint 'O1' is already driven by 'motor': two drivers on one degree of freedom" in str(error)


def crank_and_rocker(**second):
    m = rt.Mechanism("four-bar")
    m.ground(A=[0, 0], D=[0.5, 0])
    m.bar("crank", "A", "B", length=0.1, mass=1).bar("coupler", "B", "C", length=0.5, mass=1)
    m.bar("rocker", "C", "D", length=0.3, mass=1)
    m.revolute("A", "ground.A", "crank.A").revolute("B", "crank.B", "coupler.B")
    m.revolute("C", "coupler.C", "rocker.C").revolute("D", "rocker.D", "ground.D")
    return m.driver("motor", "A", angle="1 + 10*t").driver("brake", **second)


@pytest.mark.parametrize(
    "second",
    [
        {"joint": "D", "angle": "2 + t"},  # two functions that disagree
        {"joint": "B", "angle": 0.1},
        {"body": "rocker", "coordinate": "angle", "angle": "-1"},
    ],
)
def test_two_drivers_on_the_one_freedom_of_a_linkage_are_named(second):
    with pytest.raises(rt.AssemblyError, match="drivers 'motor' and 'brake' drive the same degree of freedom"):
        _ = crank_and_rocker(**second).start


def test_two_drivers_that_agree_still_drive_the_same_freedom():
    single = crank_and_rocker(joint="B", angle=0.0)
    single._document["drivers"].pop("brake")
    single._forget()
    q = single.start.q
    agreeing = crank_and_rocker(joint="B", angle=float(q[5] - q[2]))
    with pytest.raises(rt.AssemblyError, match="drivers 'motor' and 'brake' drive the same degree of freedom"):
        _ = agreeing.start


def test_position_that_a_driver_cannot_reach_names_the_loop_and_the_position():
    m = rt.Mechanism("slider-crank")
    m.ground(O=[0, 0])
    m.bar("crank", "O", "A", length=0.1, mass=1).bar("rod", "A", "B", length=0.3, mass=1)
    m.body("slider", mass=1, inertia=1, points={"B": [0, 0]})
    m.revolute("O", "ground.O", "crank.O").revolute("A", "crank.A", "rod.A").revolute("B", "rod.B", "slider.B")
    m.prismatic("guide", "ground.O", "slider.B").driver("push", "guide", position=0.5)
    with pytest.raises(rt.AssemblyError) as caught:
        _ = m.start
    message = str(caught.value)
    for word in ("loop", "guide", "stays open by 0.1 m", "push = 0.5 m", "at t = 0 s"):
        assert word in message


# ---------------------------------------------------------------- anything at all
LINES = TEXT.split("\n")
VALUES = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(),
    st.text(max_size=8),
    st.sampled_from(["t", "l1", "5 mm", "crank.x", "ground.O1", "crank", "ground", "-1", "1/0", "massless-link", "rod"]),
    st.lists(st.one_of(st.integers(-3, 3), st.text(max_size=3), st.floats()), max_size=3),
    st.dictionaries(st.sampled_from(["value", "x", "model", "offset", "O1", ""]), st.one_of(st.integers(), st.text()), max_size=2),
)  # fmt: skip
SWAPS = ["0", "-1", "nan", '"l1"', '"t"', "[]", "{}", "true", '"crank.O1"', '"1e308*10"', "1e-320", "1e300", '"rod"']
FUZZ = settings(suppress_health_check=[HealthCheck.too_slow], max_examples=120)


def tried(text):
    """Read, put together, and move a little: only the errors of this package may come out."""
    with suppress(ModelError, rt.AssemblyError):
        m = rt.loads(text)
        m.simulate(1e-4, rtol=1e-3)
        assert rt.loads(m.to_toml()).parameters == m.parameters


def paths(table, path=()):
    for key, value in table.items() if isinstance(table, dict) else enumerate(table):
        yield (*path, key)
        if isinstance(value, dict | list):
            yield from paths(value, (*path, key))


PATHS = list(paths(DOCUMENT))


@FUZZ
@given(
    st.lists(
        st.tuples(st.sampled_from(["drop", "double", "swap", "cut"]), st.integers(0), st.integers(0)),
        max_size=3,
        min_size=1,
    )
)
def test_lines_lost_doubled_and_changed(changes):
    lines = list(LINES)
    for what, one, other in changes:
        n = one % len(lines)
        if what == "drop":
            del lines[n]
        elif what == "double":
            lines.insert(other % len(lines), lines[n])
        elif what == "swap" and " = " in lines[n]:
            lines[n] = lines[n].split(" = ")[0] + " = " + SWAPS[other % len(SWAPS)]
        elif what == "cut":
            lines[n] = lines[n][: other % (len(lines[n]) + 1)]
    tried("\n".join(lines))


@FUZZ
@given(st.lists(st.tuples(st.sampled_from(PATHS), VALUES), min_size=1, max_size=2))
@example([(("bodies", "crank", "length"), 1e200)])
@example([(("bodies", "crank", "mass"), 5e-324)])
@example([(("drivers", "motor", "joint"), [1])])
def test_values_of_any_type_anywhere(changes):
    document = copy.deepcopy(DOCUMENT)
    for path, value in changes:
        table = document
        for key in path[:-1]:
            if not isinstance(table, dict) or key not in table:
                break
            table = table[key]
        else:
            if isinstance(table, dict if isinstance(path[-1], str) else list) and table:
                table[path[-1] if isinstance(path[-1], str) else path[-1] % len(table)] = value
    with suppress(ModelError):
        read(document)


@FUZZ
@given(st.text(max_size=200))
def test_any_text(text):
    with pytest.raises(ModelError):
        rt.loads(text)


@FUZZ
@given(st.recursive(VALUES, lambda inner: st.dictionaries(st.text(max_size=5), inner, max_size=3), max_leaves=5))
def test_any_json(value):
    with pytest.raises(ModelError):
        rt.loads(json.dumps({"bodies": value}))


def test_keys_that_are_no_text_are_refused():
    with pytest.raises(ModelError, match="is not a text"):
        read({"format": 1, "bodies": {3: {}}})


def test_nothing_in_a_file_reads_another_file(tmp_path, caplog):
    secret = tmp_path / "secret"
    secret.write_text("42")
    with caplog.at_level(logging.DEBUG), pytest.raises(ModelError):
        rt.loads(changed('length = "l1"', f"length = \"open('{secret}')\""))
    assert model_file.LARGEST < 50_000_000


def test_a_signal_without_its_owner_is_taken_for_that_of_the_table_in_which_it_stands():
    text = TEXT
    text += (
        '\n[loads.ram]\ntype = "actuator"\nconnect = ["ground.O1", "coupler.O2"]\nforce = "20 kN - 2000 N/m*length"\n'
    )
    assert "did you mean 'ram.length'?" in str(refusal(text))


@pytest.mark.parametrize(
    ("name", "joint", "why"),
    [("gear_rattle", "mesh", "has its play along the circumference"), ("cam_lift_off", "face", "only pushes")],
)
def test_an_offset_of_what_has_no_pin_is_refused(name, joint, why):
    with pytest.raises(ModelError, match=rf"initial\.{joint}: joint '{joint}' {why}"):
        rt.example(name).set({f"initial.{joint}.offset": [1e-5, 0.0]})
