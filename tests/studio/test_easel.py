"""Drawing in a session without its page: acts, what is turned by hand, measures, a picture below."""

import base64
import itertools
import json
import math

import pytest

from rattle.errors import InputError
from rattle.sketch.drawn import drawn
from rattle.studio.desk import Desk, check
from rattle.studio.easel import Easel
from rattle.studio.folder import Folder, Refused

EMPTY = "# mine\nformat = 1\n"
PINS = [(-0.12, -0.04), (-0.12, 0.02), (0.04, 0.1), (0.08, -0.04)]


class Session:
    """A desk that does everything at once, and what it has told its page."""

    def __init__(self, folder, text=EMPTY, name="m.toml"):
        (folder / name).write_text(text)
        self.said = []
        self.desk = Desk(Folder(folder), self.said.append, later=lambda f, then: then(f()), post=lambda f: f())
        self.desk.bench.ask = lambda *one, **more: 0
        self.desk.draft.begin(text, name)
        self.hear("hello")
        self.hear("edit", on=True)

    def hear(self, do, **message):
        self.desk.hear({"do": do, **message})

    def act(self, act, **message):
        self.hear("act", number=len(self.said), act=act, snap=0.01, within=0.004, **message)
        return self.last("sketch")

    def last(self, kind):
        return [one for one in self.said if one["kind"] == kind][-1]

    @property
    def text(self):
        return self.desk.draft.text

    def fourbar(self):
        points = {}
        for spot in (PINS[0], PINS[3]):
            points[spot] = f"ground.O{len(points) + 1}"
            self.act("ground", at={"at": spot})
        for k, (p, q) in enumerate(itertools.pairwise(PINS), 1):
            ends = [{"at": spot, **({"point": points[spot]} if spot in points else {})} for spot in (p, q)]
            self.act("bar", **{"from": ends[0], "to": ends[1]})
            points[q] = points.get(q, f"bar{k}.B")
        self.act("motor", at={"at": PINS[0], "point": "ground.O1"})
        return self


@pytest.fixture
def session(tmp_path):
    return Session(tmp_path)


def test_an_empty_text_is_a_sheet_and_no_problem(session):
    model = session.last("model")
    assert (model["problems"], model["empty"], model["facts"]["title"]) == ([], True, "")
    assert model["facts"]["settings"]["gravity"] == ["0", "0"]
    told = session.last("sketch")["drawing"]
    assert (told["scene"], told["points"], told["status"][:14]) == (None, {}, "Put two ground")


def test_every_act_tells_the_text_with_its_number_and_then_the_drawing(session):
    before = len(session.said)
    session.act("ground", at={"at": [0.02, 0.01]})
    kinds = [one["kind"] for one in session.said[before:]]
    assert kinds.index("text") < kinds.index("sketch")
    assert session.last("text")["act"] == session.last("sketch")["number"] == before
    assert session.text == EMPTY + "\n[ground.points]\nO1 = [0.02, 0.01]\n"


def test_what_is_refused_is_told_and_leaves_the_text(session):
    session.fourbar()
    text, drawing = session.text, session.last("sketch")
    for message in (
        {"act": "type", "chosen": "body bar2", "field": "Length", "text": "9 m"},
        {"act": "type", "chosen": "body bar2", "field": "Length", "text": "nonsense"},
        {"act": "motor", "at": {"at": [1, 1]}},
        {"act": "nothing"},
        {"act": "bar", "from": None, "to": None},
        {"act": "start", "places": {"bar1": "x"}},
        {"act": "start"},
    ):
        session.act(**message)
        assert session.last("trouble")["about"] == "act", message
        assert "please report" not in session.last("trouble")["words"]
        assert (session.text, session.last("sketch")) == (text, drawing)


def test_a_text_with_a_fault_waits_and_says_the_line(session):
    session.hear("text", text=EMPTY + "[bodies.a]\nbar = 3\n")
    assert session.last("sketch")["trouble"].startswith("Drawing waits for the text: line 3, bodies.a")
    session.hear("text", text=EMPTY)
    assert "drawing" in session.last("sketch")


def test_a_model_in_json_is_drawn_on_and_stays_json(tmp_path):
    session = Session(tmp_path, '{"format": 1}', "m.json").fourbar()
    document, twin = json.loads(session.text), Session(tmp_path).fourbar()
    assert document["bodies"]["bar2"] == drawn(twin.text).document["bodies"]["bar2"]
    assert document["drivers"] == {"motor": {"joint": "J1", "angle": "90 deg + 60 rpm*t"}}


def test_a_body_in_the_hand_turns_the_mechanism_and_may_start_there(session):
    session.fourbar()
    text = session.text
    session.hear("grab", body="bar1", at=[-0.12, -0.01])
    session.hear("pull", at=[-0.1, -0.02])
    places = session.last("pulled")["places"]
    turned = drawn(text)
    points = {name: turned.model.bodies[name.split(".")[0]].points[name.split(".")[1]] for name in ("bar1.B", "bar2.A")}

    def at(name):
        (x, y, angle), (px, py) = places[name.split(".")[0]], points[name]
        return x + px * math.cos(angle) - py * math.sin(angle), y + px * math.sin(angle) + py * math.cos(angle)

    assert math.dist(at("bar1.B"), at("bar2.A")) < 1e-9
    assert session.text == text
    assert places["bar1"][2] == pytest.approx(math.atan2(0.02, 0.02), abs=0.01)  # towards the hand
    session.act("start", places=places)
    assert drawn(session.text).places["bar1"] == pytest.approx(places["bar1"], abs=1e-9)
    assert "bar2 = {" in session.text


def test_a_force_on_what_a_motor_holds_shows_what_play_gives(session):
    session.fourbar()
    session.act("type", chosen="joint J2", field="Play", text="0.2 mm")
    session.hear("grab", body="bar2", at=list(PINS[1]), force=True)
    session.hear("pull", at=[-1.12, 0.02])
    assert session.last("pulled")["words"] == "bar2 gives 0.2 mm this way, motors held"


def test_measures_are_told_and_kept_as_signals(session):
    session.fourbar()
    session.hear("measure", spots=[{"at": PINS[0], "point": "ground.O1"}, {"at": PINS[2], "point": "bar2.B"}])
    (row,) = session.last("readings")["rows"]
    assert row["words"] == f"distance of ground.O1 and bar2.B: {math.dist(PINS[0], PINS[2]):.4g} m"
    session.act("keep", signals=row["signals"])
    assert 'distance = "hypot(' in session.text
    session.hear("measure", spots=[{"at": PINS[2], "point": "bar2.B"}])
    words = [row["words"].split(":")[0] for row in session.last("readings")["rows"]]
    assert words == ["path of bar2.B", "transmission angle at J3", "mechanical advantage of motor at bar2.B"]
    session.hear("measure", spots=[{"at": [0, 0]}, {"at": PINS[2]}, {"at": [0.1, 0]}])
    assert session.last("readings")["rows"][0]["words"].startswith("angle at ")


def test_a_picture_lies_beside_the_model_and_is_scaled(session, tmp_path):
    data = b"\x89PNG not really"
    message = {"name": "../../my photo.png", "data": base64.b64encode(data).decode()}
    session.act("picture", **message, scale=0.001, origin=[-0.1, 0], angle=0)
    assert (tmp_path / "my-photo.png").read_bytes() == data
    assert session.last("sketch")["drawing"]["picture"]["scale"] == 0.001
    session.act("scale-picture", **{"from": [0, 0], "to": [0.1, 0]}, text="0.25 m")
    assert session.last("sketch")["drawing"]["picture"] == {
        "file": "my-photo.png", "scale": 0.0025, "origin": [-0.25, 0], "angle": 0,
    }  # fmt: skip
    session.hear("picture-file", name="my-photo.png")
    assert session.last("picture-file")["data"] == f"data:image/png;base64,{message['data']}"
    for text in ("three", "-1 m", "2 kg"):
        session.act("scale-picture", **{"from": [0, 0], "to": [0.1, 0]}, text=text)
        assert "is not a distance" in session.last("trouble")["words"]
    session.act("scale-picture", **{"from": [0.1, 0], "to": [0.1, 0]}, text="0.25 m")
    assert "the two points are one" in session.last("trouble")["words"]
    session.act("no-picture")
    assert session.text.strip() == EMPTY.strip()


def test_pictures_stay_inside_of_the_folder(tmp_path):
    folder = Folder(tmp_path)
    (tmp_path.parent / "secret.png").write_bytes(b"x")
    for name in ("../secret.png", "..\\secret.png", "m.toml", "none.png"):
        with pytest.raises(Refused):
            folder.picture(name)
    for name, content in (("a.exe", b"x"), ("big.png", b"x" * 12_000_001)):
        with pytest.raises(Refused):
            folder.keep_picture(name, content)
    first, again, other = (folder.keep_picture("a.png", content) for content in (b"1", b"1", b"2"))
    assert (first, again, other) == ("a.png", "a.png", "a-2.png")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a-2.png", "a.png"]
    (tmp_path / "sub").mkdir()
    assert folder.keep_picture("a.png", b"3", "sub/m.toml") == "a.png"  # beside its model
    assert folder.picture("a.png", "sub/m.toml").endswith(base64.b64encode(b"3").decode())
    assert folder.picture("a.png").endswith(base64.b64encode(b"1").decode())


def test_nothing_is_held_without_a_grab(tmp_path):
    easel = Easel(Folder(tmp_path))
    with pytest.raises(InputError, match="nothing is held"):
        easel.pulled((0.0, 0.0))
    with pytest.raises(InputError, match="nothing to measure"):
        easel.measured(EMPTY, "", [], 0.01)


def test_a_text_without_bodies_keeps_its_other_faults():
    assert check({"text": "format = 1\nnosuch = 2\n", "file": ""})["problems"][0]["where"] == "nosuch"


def test_an_act_under_way_when_another_model_is_opened_does_nothing_to_that(session):
    waiting = []
    session.desk._later = lambda run, then: waiting.append((run, then))
    session.act("ground", at={"at": [0.02, 0.01]})
    session.hear("act", number=901, act="ground", at={"at": [0.04, 0.01]})
    session.hear("new")
    fresh = session.text
    session.hear("act", number=902, act="ground", at={"at": [0.06, 0.01]}, opened=0)
    session.hear("text", text="# of the model before", number=7, opened=0)
    while waiting:
        run, then = waiting.pop(0)
        then(run())
    assert session.text == fresh
    assert session.last("sketch")["heard"] == 7
    session.hear("act", number=903, act="ground", at={"at": [0.06, 0.01]}, opened=1)
    while waiting:
        run, then = waiting.pop(0)
        then(run())
    assert "O1 = [0.06, 0.01]" in session.text
