"""One session without its page: text, knobs, files, and what is computed when."""

import pytest
from studio_models import PENDULUM

from rattle.studio.bench import Outcome
from rattle.studio.desk import Desk
from rattle.studio.folder import Folder, Refused

pytestmark = [pytest.mark.nojit, pytest.mark.plain]


class Recorder:
    """A bench that only writes down what it is asked."""

    ended = False
    busy = ""
    waiting = ()

    def __init__(self):
        self.asked, self.dropped, self.stopped = [], [], []

    def ask(self, name, **arguments):
        self.asked.append((name, arguments))

    def drop(self, *names):
        self.dropped.append(names)

    def stop(self, name):
        self.stopped.append(name)


@pytest.fixture
def desk(tmp_path):
    """A desk with a pendulum whose file is in its folder; checks happen at once."""
    (tmp_path / "m.toml").write_text(PENDULUM)
    said = []
    made = Desk(Folder(tmp_path), said.append, later=lambda f, then: then(f()), post=lambda f: f())
    made.bench, made.said = Recorder(), said
    made.draft.begin(PENDULUM, "m.toml")
    made.hear({"do": "hello"})
    return made


def last(desk, kind):
    return [one for one in desk.said if one["kind"] == kind][-1]


def test_a_knob_changes_its_value_in_the_text_and_nothing_else(desk):
    desk.hear({"do": "knob", "name": "l", "value": "1.25 m"})
    assert desk.draft.text == PENDULUM.replace('value = "1 m"', 'value = "1.25 m"')  # comments and all
    assert last(desk, "model")["facts"]["knobs"][0]["value"] == 1.25
    assert [name for name, _ in desk.bench.asked] == ["motion", "motion"]
    assert last(desk, "name-is")["changed"]


def test_a_value_that_makes_no_sense_is_answered_and_changes_nothing(desk):
    for value in ("5 kg", "nonsense", "-1 m", "3 m"):
        desk.hear({"do": "knob", "name": "l", "value": value})
        assert last(desk, "trouble")["about"] == "knob", value
    assert desk.draft.text == PENDULUM


def test_a_broken_text_names_its_line_and_column_and_the_old_motion_stays(desk):
    desk.hear({"do": "text", "text": PENDULUM.replace("mass = 1", 'mas = 1\ncolour = "red"')})
    problems = last(desk, "model")["problems"]
    lines = {one["line"]: one for one in problems}
    row = PENDULUM.split("\n").index("mass = 1") + 1
    assert (lines[row]["column"], lines[row]["width"]) == (1, len("mas"))
    assert "mas" in lines[row]["where"]
    assert "colour" in lines[row + 1]["where"]  # all of them, not the first alone
    assert len(desk.bench.asked) == 1


def test_settings_and_methods_are_written_where_they_belong(desk):
    desk.hear({"do": "setting", "name": "simulate.t_end", "value": "20 ms"})
    desk.hear({"do": "setting", "name": "gravity.1", "value": "-1.62"})
    desk.hear({"do": "method", "method": "rk4"})
    assert 't_end = "20 ms"' in desk.draft.text
    assert "gravity = [0, -1.62]" in desk.draft.text
    assert 'method = "rk4"' in desk.draft.text
    desk.hear({"do": "method", "method": ""})
    assert "rk4" not in desk.draft.text
    desk.hear({"do": "setting", "name": "bodies.rod.mass", "value": "2"})
    assert "no setting" in last(desk, "trouble")["words"]


def test_saving_asks_before_it_overwrites_and_keeps_comments(desk, tmp_path):
    desk.hear({"do": "knob", "name": "l", "value": "1.5 m"})
    desk.hear({"do": "save"})
    assert "exists" in last(desk, "overwrite")["words"]
    assert (tmp_path / "m.toml").read_text() == PENDULUM
    desk.hear({"do": "save", "sure": True})
    assert (tmp_path / "m.toml").read_text() == PENDULUM.replace('value = "1 m"', 'value = "1.5 m"')
    assert not last(desk, "name-is")["changed"]
    questions = sum(one["kind"] == "overwrite" for one in desk.said)
    desk.hear({"do": "knob", "name": "l", "value": "1.6 m"})
    desk.hear({"do": "save"})  # what this session has written itself it may write again
    assert "1.6 m" in (tmp_path / "m.toml").read_text()
    (tmp_path / "m.toml").write_text("# by somebody else\n")
    desk.hear({"do": "save"})
    assert "changed by another program" in last(desk, "overwrite")["words"]
    assert (tmp_path / "m.toml").read_text() == "# by somebody else\n"
    assert sum(one["kind"] == "overwrite" for one in desk.said) == questions + 1


@pytest.mark.parametrize(
    "name",
    [
        "../x.toml",
        "/tmp/x.toml",
        "C:\\x.toml",
        "sub/../../x.toml",
        "x.py",
        ".hidden.toml",
        "out/x.toml",
        "link.toml",
        "a\0b.toml",
        "no/such/x.toml",
    ],
)
def test_nothing_is_written_or_read_outside_of_the_folder(desk, tmp_path, name):
    outside = tmp_path.parent / f"{tmp_path.name}-outside"
    outside.mkdir()
    (outside / "x.toml").write_text(PENDULUM)
    (tmp_path / "out").symlink_to(outside)
    (tmp_path / "link.toml").symlink_to(outside / "x.toml")
    before = (outside / "x.toml").stat().st_mtime_ns
    for action in ("save", "open"):
        desk.hear({"do": action, "name": name, **({"sure": True} if action == "save" else {})})
        assert desk.said[-1]["kind"] == "trouble", action
    assert desk.draft.text == PENDULUM
    assert (outside / "x.toml").stat().st_mtime_ns == before
    assert [one.name for one in outside.iterdir()] == ["x.toml"]
    assert "link.toml" not in desk.folder.models()[0]


def test_tables_of_a_model_stay_inside_of_its_folder(desk, tmp_path):
    (tmp_path.parent / "secret.csv").write_text("1,2\n3,4\n")
    (tmp_path / "near.csv").symlink_to(tmp_path.parent / "secret.csv")
    for file in ("../secret.csv", "near.csv", "/etc/passwd"):
        desk.hear({"do": "text", "text": f'{PENDULUM}\n[tables.f]\nfile = "{file}"\n'})
        assert "out of the folder" in last(desk, "model")["problems"][0]["words"]


def test_a_model_text_runs_no_code(desk, tmp_path):
    for value in ("__import__('os').system('touch run')", "().__class__", "open('run','w')", "(lambda: 1)()"):
        desk.hear({"do": "knob", "name": "l", "value": value})
        assert desk.said[-1]["kind"] == "trouble"
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize(
    "message",
    [
        None,
        5,
        [],
        {},
        {"do": 5},
        {"do": "__init__"},
        {"do": "hear"},
        {"do": "end", "x": 1},
        {"do": "knob"},
        {"do": "knob", "name": "l", "value": [1]},
        {"do": "compute", "tab": "os", "options": {}},
        {"do": "text", "text": 7},
    ],
)
def test_messages_that_make_no_sense_are_answered_with_words(desk, message):
    desk.hear(message)
    assert desk.said[-1]["kind"] == "trouble"
    assert desk.draft.text == PENDULUM


def test_a_text_that_is_too_large_is_refused(desk):
    desk.hear({"do": "text", "text": "#" * 9_000_000})
    assert "too large" in last(desk, "trouble")["words"]
    assert desk.draft.text == PENDULUM


def test_tabs_are_computed_when_they_are_opened_and_say_when_they_are_out_of_date(desk):
    desk.hear({"do": "show", "tab": "equilibrium", "options": {"t": "0 s"}})
    name, arguments = desk.bench.asked[-1]
    assert (name, arguments["t"], arguments["source"]["text"]) == ("equilibrium", "0 s", PENDULUM)
    desk._outcome("equilibrium", Outcome(2, "done", {"told": "", "blocks": []}))
    desk.hear({"do": "show", "tab": "motion"})
    desk.hear({"do": "show", "tab": "equilibrium"})
    assert desk.bench.asked[-1][0] == "equilibrium"
    assert len(desk.bench.asked) == 2  # it is there already
    desk.hear({"do": "show", "tab": "motion"})
    desk.hear({"do": "knob", "name": "l", "value": "1.2 m"})
    assert {"kind": "tab", "tab": "equilibrium", "state": "old"} in desk.said
    assert desk.bench.asked[-1][0] == "motion"
    desk.hear({"do": "show", "tab": "equilibrium"})
    assert desk.bench.asked[-1][0] == "equilibrium"


def test_a_tab_shows_what_its_fields_say_when_it_is_opened_again(desk):
    desk.hear({"do": "show", "tab": "accuracy", "options": {"of": "rod.x"}})
    desk._outcome("accuracy", Outcome(2, "done", {"told": "", "blocks": []}))
    desk.hear({"do": "show", "tab": "accuracy", "options": {}})  # the field is as usual again
    assert len(desk.bench.asked) == 3
    assert "of" not in desk.bench.asked[-1][1]
    desk._outcome("accuracy", Outcome(3, "done", {"told": "", "blocks": []}))
    desk.hear({"do": "show", "tab": "accuracy", "options": {}})
    assert len(desk.bench.asked) == 3


def test_python_code_makes_the_same_mechanism(desk, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    desk.hear({"do": "knob", "name": "l", "value": "1.25 m"})
    code = last_code(desk)
    assert "rt.load('m.toml')" in code  # its file, with what was changed since
    assert made_by(code).parameters == {"l": 1.25}
    desk.hear(
        {
            "do": "text",
            "text": desk.draft.text.replace(
                "[simulate]", '[loads.push]\ntype = "torque"\nbody = "rod"\ntorque = 1\n\n[simulate]'
            ),
        }
    )
    code = last_code(desk)
    assert "rt.loads(" in code  # more than values differ
    assert "push" in made_by(code).model.loads


def last_code(desk):
    desk.hear({"do": "python"})
    return last(desk, "python")["code"]


def made_by(code):
    names = {}
    exec(code.replace("r = m.simulate(horizon=True)\nprint(r.trust)\n", ""), names)
    return names["m"]


def test_a_folder_lists_models_and_nothing_else(tmp_path):
    (tmp_path / "a.toml").write_text(PENDULUM)
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "b.toml").write_text(PENDULUM)
    (tmp_path / "pyproject.toml").write_text("[project]\nname = 'x'\n")
    (tmp_path / ".git").mkdir()
    (tmp_path / ".git" / "c.toml").write_text(PENDULUM)
    assert Folder(tmp_path).models() == (["a.toml", "sub/b.toml"], True)
    with pytest.raises(Refused):
        Folder(tmp_path).place("sub")


# ---------------------------------------------------------------- whatever is typed or asked
@pytest.mark.parametrize(
    "text",
    [
        PENDULUM.replace("[ground", 'b = { value = "2*l", min = "1 mi" }\n[ground'),
        PENDULUM.replace("[ground", 'b = { value = "2*l", min = "1e400" }\n[ground'),
        PENDULUM.replace("mass = 1", "mass = 5e-324"),
        "[" * 500,
        "\0",
        "a = 1" + "0" * 5000,
    ],
)
def test_after_any_text_the_next_one_is_checked(desk, text):
    desk.hear({"do": "text", "text": text})
    assert last(desk, "model")["problems"]
    desk.hear({"do": "text", "text": PENDULUM.replace("mass = 1", "mass = 2")})
    assert not last(desk, "model")["problems"]
    assert last(desk, "model")["facts"]


def test_a_fault_of_reading_is_a_problem_and_the_next_text_is_checked(desk, monkeypatch):
    def slip(*_):
        raise ZeroDivisionError("slip")

    with monkeypatch.context() as patched:
        patched.setattr("rattle.studio.desk.facts", slip)
        desk.hear({"do": "text", "text": PENDULUM.replace("mass = 1", "mass = 2")})
        (problem,) = last(desk, "model")["problems"]
        assert "please report this" in problem["words"]
        assert "slip" in problem["words"]
    desk.hear({"do": "text", "text": PENDULUM.replace("mass = 1", "mass = 3")})
    assert last(desk, "model")["facts"]


@pytest.mark.parametrize(
    "message",
    [
        {"do": "save", "name": 5},
        {"do": "save", "name": ["m.toml"]},
        {"do": "open", "name": None},
        {"do": "example", "name": {}},
        {"do": "thumbnails", "names": 3},
        {"do": "compute", "tab": "forces", "options": 7},
        {"do": "setting", "name": {}, "value": 1},
        {"do": "pick", "number": "x"},
        {"do": "text", "text": 5},
        {"do": "knob"},
    ],
)
def test_a_message_that_makes_no_sense_is_answered(desk, message):
    before = len(desk.said)
    desk.hear(message)
    assert [one["kind"] for one in desk.said[before:]] == ["trouble"]
    desk.hear({"do": "alive"})
    assert desk.said[-1]["kind"] == "alive"
    assert desk.draft.text == PENDULUM


class Waiting:
    """What runs aside, when it is told to."""

    def __init__(self):
        self.waiting = []

    def later(self, function, then):
        self.waiting.append((function, then))

    def go_on(self):
        function, then = self.waiting.pop(0)
        then(function())


@pytest.fixture
def slow(tmp_path):
    """A desk whose errands and checks wait until they are told to go on."""
    (tmp_path / "m.toml").write_text(PENDULUM)
    said, aside = [], Waiting()
    made = Desk(Folder(tmp_path), said.append, later=aside.later, post=lambda f: f())
    made.bench, made.said, made.aside = Recorder(), said, aside
    made.draft.begin(PENDULUM, "m.toml")
    return made


@pytest.mark.parametrize(
    "message",
    [
        {"do": "files"},
        {"do": "files", "gallery": True},
        {"do": "open", "name": "m.toml"},
        {"do": "example", "name": "fourbar"},
        {"do": "knob", "name": "l", "value": 1.5},
        {"do": "setting", "name": "simulate.t_end", "value": "2 s"},
        {"do": "save", "name": "other.toml"},
        {"do": "save_as"},
        {"do": "python"},
    ],
)
def test_nothing_that_reads_texts_or_files_is_done_where_other_pages_wait(slow, message, monkeypatch):
    def forbidden(*_, **__):
        raise AssertionError("in the thread of the page")

    with monkeypatch.context() as patched:
        for name in ("parse", "read_file", "save", "dump"):
            patched.setattr(f"rattle.description.file.{name}", forbidden)
        patched.setattr(Folder, "_walk", forbidden)
        slow.hear(message)
    assert not [one for one in slow.said if one["kind"] == "trouble"]
    slow.aside.go_on()
    assert not [one for one in slow.said if one["kind"] == "trouble"]
    assert slow.said


def test_of_many_turns_of_a_knob_the_last_counts_and_none_undoes_what_is_typed_meanwhile(slow):
    for value in (1.1, 1.2, 1.3):
        slow.hear({"do": "knob", "name": "l", "value": value})
    slow.hear({"do": "text", "text": PENDULUM.replace("mass = 1", "mass = 2")})
    while slow.aside.waiting:
        slow.aside.go_on()
    assert "value = 1.3" in slow.draft.text
    assert "mass = 2" in slow.draft.text


def test_a_save_holds_the_knob_that_was_turned_before_it(slow):
    slow.hear({"do": "knob", "name": "l", "value": 1.25})
    slow.hear({"do": "save", "name": "new.toml"})
    while slow.aside.waiting:
        slow.aside.go_on()
    assert "1.25" in slow.folder.read("new.toml")


def test_of_very_many_files_a_part_is_looked_at(tmp_path, monkeypatch):
    monkeypatch.setattr("rattle.studio.folder.MOST_LOOKED", 20)
    (tmp_path / "z.toml").write_text(PENDULUM)
    for k in range(40):
        (tmp_path / f"{k}.json").write_text("{}")
    assert Folder(tmp_path).models() == (["z.toml"], False)
