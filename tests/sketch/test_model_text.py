"""Small changes of a model text leave all else as it is written."""

import difflib
import json
import random
import tomllib

import pytest

import rattle as rt
from rattle.errors import ModelError
from rattle.loading import examples
from rattle.sketch.model_text import renamed, revised, sections

TEXT = """# on top
format = 1
gravity = [0, -9.81]   # down

[ground.points]
O = [0, 0]   # left
# above the bodies
[bodies.rod]   # the long one
bar = ["A", "B"]
length = "0.5 m"   # as drawn
mass = 1
[bodies.arm]
bar = ["A", "B"]
length = 0.2
mass = 1

# the pins
[joints.P]
type = "revolute"
connect = ["ground.O", "rod.A"]

[joints.Q]
type = "revolute"
connect = ["rod.B", "arm.A"]
clearance = "1 mm"
[joints.Q.contact]
model = "impact"
restitution = 0.5

[initial]
rod = { angle = "10 deg" }   # nearly level
"""


ANGLE = '{{ angle = "{} deg" }}   # nearly level'


def changed_lines(before, after):
    """Lines that came and lines that went."""
    lines = [line for line in difflib.ndiff(before.splitlines(), after.splitlines()) if line[:1] in "+-"]
    return [line[2:] for line in lines if line[0] == "-"], [line[2:] for line in lines if line[0] == "+"]


@pytest.mark.parametrize(
    ("path", "value", "went", "came"),
    [
        ("bodies.rod.length", 0.25, 'length = "0.5 m"   # as drawn', "length = 0.25   # as drawn"),
        ("ground.points.O.1", 2.0, "O = [0, 0]   # left", "O = [0, 2]   # left"),
        ("initial.rod.angle", "3 deg", f"rod = {ANGLE.format(10)}", f"rod = {ANGLE.format(3)}"),
    ],
)  # fmt: skip
def test_a_value_changes_where_it_stands(path, value, went, came):
    assert changed_lines(TEXT, revised(TEXT, [(tuple(path.split(".")), value)])) == ([went], [came])


def test_new_entries_go_behind_the_last_of_their_table_as_the_file_has_them():
    text = revised(TEXT, [(("bodies", "new"), {"bar": ["A", "B"], "length": 1, "mass": 2})])
    assert '[bodies.arm]\nbar = ["A", "B"]\nlength = 0.2\nmass = 1\n[bodies.new]\nbar = ["A", "B"]\n' in text
    text = revised(TEXT, [(("joints", "R"), {"type": "revolute", "connect": ["ground.O", "arm.B"]})])
    assert 'restitution = 0.5\n\n[joints.R]\ntype = "revolute"\n' in text
    text = revised(TEXT, [(("drivers", "motor"), {"joint": "P", "angle": "60 rpm*t"})])
    assert text.index("[joints.Q.contact]") < text.index("[drivers.motor]") < text.index("[initial]")
    text = revised(TEXT, [(("initial", "arm"), {"angle": "5 deg"})])
    assert text.endswith('nearly level\narm = { angle = "5 deg" }\n')


@pytest.mark.parametrize("name", ["bodies.rod", "bodies.arm", "joints.P", "joints.Q", "initial.rod", "ground.points.O"])
def test_what_is_removed_takes_its_own_lines_and_no_comment_of_others(name):
    path = tuple(name.split("."))
    text = revised(TEXT, [(path, None)])
    went, came = changed_lines(TEXT, text)
    assert came == []
    assert all(comment in text for comment in ("# on top", "# down", "# above the bodies", "# the pins"))
    table = tomllib.loads(text)
    for key in path[:-1]:
        table = table.get(key, {})
    assert path[-1] not in table
    assert went
    assert revised(text, [(path, None)]) == text


@pytest.mark.parametrize("name", sorted(examples()))
def test_an_entry_that_comes_and_goes_leaves_every_example_as_it_was(name):
    text = examples()[name].read_text()
    entries = [
        (("joints", "new"), {"type": "revolute", "connect": ["ground.O", "x.A"]}),
        (("bodies", "new"), {"bar": ["A", "B"], "length": 0.1, "mass": 1}),
        (("loads", "new"), {"type": "force", "at": "x.A", "force": [1, 0]}),
    ]
    for path, value in entries:
        after = revised(text, [(path, value)])
        assert tomllib.loads(after)[path[0]]["new"] == value
        document = tomllib.loads(after)
        del document[path[0]]["new"]
        assert {key: part for key, part in document.items() if part} == tomllib.loads(text)
        assert revised(after, [(path, None)]).split() == text.split()


def test_sections_of_the_examples_are_their_headings():
    for path in examples().values():
        lines = path.read_text().split("\n")
        heads = [k for k, line in enumerate(lines) if line.startswith("[")]
        assert [part.start for part in sections("\n".join(lines))] == heads


def test_many_random_changes_of_numbers_move_nothing_else():
    chance = random.Random(5)
    for path in list(examples().values())[::5]:
        text = path.read_text()
        document = tomllib.loads(text)
        bodies = [name for name, body in document["bodies"].items() if "mass" in body]
        for body in chance.sample(bodies, min(2, len(bodies))):
            went, came = changed_lines(text, revised(text, [(("bodies", body, "mass"), 0.125)]))
            assert len(went) == len(came) <= 1
            assert all("0.125" in line for line in came)


def test_json_stays_json():
    text = json.dumps(tomllib.loads(TEXT))
    after = revised(text, [(("bodies", "new"), {"bar": ["A", "B"], "length": 1, "mass": 2}), (("joints", "P"), None)])
    assert json.loads(after)["bodies"]["new"]["mass"] == 2
    assert "P" not in json.loads(after)["joints"]


def test_a_name_changes_in_headings_and_at_the_start():
    text = renamed(TEXT, "joints", "Q", "elbow")
    assert "[joints.elbow]\n" in text
    assert "[joints.elbow.contact]" in text
    assert "joints.Q" not in text
    text = renamed(TEXT, "bodies", "rod", "beam")
    assert "[bodies.beam]   # the long one" in text
    assert 'beam = { angle = "10 deg" }   # nearly level' in text


def test_what_cannot_be_read_is_refused():
    with pytest.raises(ModelError, match="not valid TOML"):
        revised("a = [", [(("name",), "x")])


def test_a_picture_below_a_drawing_is_read_and_has_no_effect():
    text = revised(TEXT, [(("picture",), {"file": "a.png", "scale": 0.001, "origin": [0, 0], "angle": 0})])
    assert rt.loads(text).system.arrays["row_body"].tolist() == rt.loads(TEXT).system.arrays["row_body"].tolist()
    with pytest.raises(ModelError, match=r"picture\.scale.*positive"):
        rt.loads(text.replace("scale = 0.001", "scale = 0"))
