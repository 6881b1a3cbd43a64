"""A question that stands in a folder of one's own is found wherever questions are: one declaration, many views."""

import ast
import inspect
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import rattle as rt
from rattle import signatures
from rattle.answers import blocks
from rattle.answers.answer import Answer, Number
from rattle.answers.arguments import read
from rattle.answers.blocks import curves, line, table
from rattle.errors import InputError
from rattle.pages.report_study import Study, answer_section
from rattle.question import PARTS, Argument, question, questions

FOLDER = Path(__file__).parent / "data" / "questions"
DOCS = Path(__file__).parents[1] / "docs"
TRAVEL = 0.1  # of the slider of slider_crank: twice its crank of 50 mm [m]
PROGRAM = """
import inspect, json, sys
from pathlib import Path
from click.testing import CliRunner
import rattle as rt
from rattle.cli.main import main
from rattle.signatures import stub
from rattle.studio.jobs import job
from rattle.studio.shelf import Shelf
from rattle.studio.tabs import forms

folder = Path(sys.argv[1])
m = rt.example("slider_crank")
answer = m.travel(points=361)
run = lambda *words: CliRunner().invoke(main, list(words)).output
source = {"text": m.to_toml(), "file": ""}
m.report(folder / "report.html", t_end=0.01)
e = m.ensemble(8, ["final(farthest)"], {"crank_length": 1e-3}, analysis="travel")
record = {
    "farthest": answer["farthest"],
    "printed": str(answer),
    "card": answer._repr_html_(),
    "signature": str(inspect.signature(rt.Mechanism.travel)),
    "stub": "def travel(" in stub(),
    "listed": run("--help"),
    "help": run("travel", "--help"),
    "command": run("travel", "slider_crank", "--points", "91", "--least", "50 mm"),
    "json": json.loads(run("travel", "slider_crank", "--json")),
    "picture": run("travel", "slider_crank", "-o", str(folder / "travel.svg")),
    "refused": run("travel", "slider_crank", "--points", "1"),
    "unit": run("travel", "slider_crank", "--least", "3 kg"),
    "form": next(tab for tab in forms() if tab["name"] == "travel"),
    "tab": job("travel")(Shelf(), source, points="61")["told"],
    "report": (folder / "report.html").read_text(),
    "samples": list(e["final(farthest)"]),
    "sweep": list(m.sweep({"crank_length": [0.04, 0.05]}, ["final(farthest)"], analysis="travel")["final(farthest)"]),
    "cranks": [e.sample(k).parameters["crank_length"] for k in range(8)],
}
print(json.dumps(record))
"""


@pytest.fixture(scope="module")
def everywhere(tmp_path_factory):
    """What all places say of the question `travel`, in a process that knows its folder."""
    folder = tmp_path_factory.mktemp("travel")
    env = os.environ | {"RATTLE_QUESTIONS": str(FOLDER)}
    done = subprocess.run([sys.executable, "-c", PROGRAM, str(folder)], env=env, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1]) | {"folder": folder}


def test_it_is_a_method_with_its_signature(everywhere):
    assert everywhere["farthest"] == pytest.approx(TRAVEL, rel=1e-4)
    assert everywhere["signature"] == "(m: 'Mechanism', points: 'int' = 181, least: 'float' = 0.0) -> 'Answer'"
    assert everywhere["stub"]


def test_it_is_a_command_with_options_json_and_picture(everywhere):
    assert "travel" in everywhere["listed"]
    assert "How far the mass centre" in everywhere["listed"]
    for words in ("--points", "--least", "evenly spaced in time", "--json", "--set", "-o, --output", "rattle travel"):
        assert words in everywhere["help"]
    assert "slider.x" in everywhere["command"]
    assert "slider.y" not in everywhere["command"]
    assert everywhere["json"]["numbers"]["farthest"] == {"value": pytest.approx(TRAVEL, rel=1e-4), "unit": "m"}
    assert (everywhere["folder"] / "travel.svg").read_text().count("<path") > 10


def test_wrong_values_are_refused_in_words(everywhere):
    assert "--points" in everywhere["refused"]
    assert "1 is below 2" in everywhere["refused"]
    assert "--least" in everywhere["unit"]
    assert "a mass" in everywhere["unit"]


def test_it_has_a_tab_with_a_form_in_the_studio(everywhere):
    assert everywhere["form"]["title"] == "Travel"
    fields = [(field["key"], field["label"], field["value"]) for field in everywhere["form"]["fields"]]
    assert fields == [("points", "points", "181"), ("least", "least [m]", "0.0")]
    assert everywhere["tab"] == "the farthest travels 100 mm"


def test_it_has_a_section_in_the_report_and_a_card_in_a_notebook(everywhere):
    assert "<h2>Travel</h2>" in everywhere["report"]
    assert "the farthest travels 100" in everywhere["report"]
    assert "<table>" in everywhere["card"]
    assert "<svg" in everywhere["card"]


def test_a_question_of_a_result_is_asked_of_the_motion_of_a_report(tmp_path):
    lasts = plain("lasts", shown="f'it lasts {m.t[-1]:g} s'", declared='of="result"')
    page = tmp_path / "report.html"
    asked_with([tmp_path], "report", "slider_crank", "--t-end", "2 ms", "-o", str(page), lasts=lasts)
    assert "<h2>Lasts</h2>" in page.read_text()
    assert "it lasts 0.002 s" in page.read_text()


def test_ensembles_and_sweeps_may_ask_it(everywhere):
    assert everywhere["samples"] == pytest.approx([2.0 * crank for crank in everywhere["cranks"]], rel=1e-4)
    assert everywhere["sweep"] == pytest.approx([0.08, 0.1], rel=1e-4)


def test_the_table_of_analyses_has_a_row_for_it():
    from making.questions import rows

    env = os.environ | {
        "RATTLE_QUESTIONS": str(FOLDER),
        "PYTHONPATH": os.pathsep.join([str(DOCS), *filter(None, [os.environ.get("PYTHONPATH")])]),
    }
    program = "from making.questions import rows; print([row for row in rows() if 'travel' in row[1]])"
    done = subprocess.run([sys.executable, "-c", program], env=env, capture_output=True, text=True, check=True)
    want = ("how much room a mechanism needs", "travel", "`rattle travel slider_crank --points 91`", "`m.travel()`")
    assert ast.literal_eval(done.stdout) == [want]
    assert not any("travel" in row[1] for row in rows())


@pytest.mark.nojit
def test_signatures_for_editors_are_those_of_the_declarations():
    def classes(text):
        tree = ast.parse(text)
        for node in ast.walk(tree):
            if isinstance(node, ast.FunctionDef):
                said = ast.get_docstring(node)
                node.body = [] if said is None else [ast.Expr(ast.Constant(said))]
        return [ast.dump(node) for node in tree.body if isinstance(node, ast.ClassDef)]

    kept = signatures.STUB.read_text(encoding="utf-8")
    assert classes(kept) == classes(signatures.stub()), "run `make signatures`"


@pytest.mark.nojit
@pytest.mark.parametrize("name", questions())
def test_every_question_says_what_it_asks_and_its_parts_are_known(name):
    asked = questions()[name]
    assert asked.asks.endswith(".")
    assert len(asked.asks) < 110
    assert asked.answer.__doc__
    parts = {path.stem for path in Path(asked.answer.__code__.co_filename).parent.glob("*.py")}
    assert not asked.command or "command" in parts or asked.answers_in_blocks
    assert asked.own_tab is None or "tab" in parts
    assert {part for part in PARTS if asked.has(part)} == parts & PARTS.keys()
    if "samples" in parts:
        assert callable(asked.part("samples").ANALYSIS.run)
    if "section" in parts:
        assert all(callable(make) for _, make in asked.part("section").SECTIONS)
    if "tab" in parts:
        assert list(inspect.signature(asked.part("tab").tab).parameters)[:2] == ["shelf", "source"]


@pytest.mark.nojit
def test_a_name_that_is_taken_and_an_argument_that_is_not_there_are_refused():
    def modes(m, points=3):
        """Another one."""

    with pytest.raises(InputError, match=r"'modes' is declared twice.*rename one"):
        question(asks="Another one.")(modes)
    modes.__name__ = "other"
    with pytest.raises(InputError, match=r"no argument pionts; it has points"):
        question(asks="Another one.", arguments={"pionts": Argument("How many.")})(modes)
    assert "other" not in questions()


def asked_with(folders, *words, **files):
    """What the command line says with folders of questions; files: declarations, by their name, in the first one."""
    for name, text in files.items():
        (folders[0] / name).mkdir(parents=True)
        (folders[0] / name / "__init__.py").write_text(text)
    env = os.environ | {"RATTLE_QUESTIONS": os.pathsep.join(map(str, folders))}
    program = [sys.executable, "-m", "rattle", *words] if words else [sys.executable, "-c", BOTH]
    done = subprocess.run(program, env=env, capture_output=True, text=True)
    assert "Traceback" not in done.stderr, done.stderr
    return done.stdout + done.stderr


BOTH = "import rattle as rt; m = rt.example('slider_crank'); print(m.first(), m.second())"
PLAIN = """
from rattle.answers.answer import Answer
from rattle.question import Argument, question
from rattle.mechanism import Mechanism
@question(asks="Nothing.", {declared})
def {name}(m{arguments}) -> Answer:
    return Answer.of(repr({shown}))
"""


def plain(name, arguments="", shown="'nothing'", declared=""):
    return PLAIN.format(name=name, arguments=arguments, shown=shown, declared=declared)


@pytest.mark.nojit
def test_declarations_may_import_what_they_need_at_their_top(tmp_path):
    files = {"first": plain("first", shown="1"), "second": plain("second", shown="2")}
    assert asked_with([tmp_path], "second", "slider_crank", **files) == "2\n"
    assert asked_with([tmp_path]) == "1 2\n"


@pytest.mark.nojit
@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("wrong", "def (:", "wrong cannot be read: SyntaxError: invalid syntax"),
        ("wrong", "import nowhere_at_all", "wrong cannot be read: ModuleNotFoundError"),
        ("modes", plain("modes"), "holds modes, and so does rattle; rename one of them"),
        ("studio", plain("studio"), "there is a command studio already"),
        ("other", plain("other", declared="command='modes'"), "there is a command modes already"),
        ("other", plain("other", ", json: bool = False"), "json means something already; rename the argument"),
        ("ideal", plain("ideal"), "a mechanism has a method ideal already; rename the question"),
        ("set", plain("set"), "a mechanism has a method set already; rename the question"),
    ],
)
def test_a_declaration_that_cannot_be_used_is_refused_in_words(tmp_path, name, text, words):
    assert words in asked_with([tmp_path], "check", "slider_crank", **{name: text})


@pytest.mark.nojit
def test_two_folders_that_hold_the_same_question_are_refused(tmp_path):
    asked_with([tmp_path / "a"], "--help", same=plain("same"))
    assert "holds same, and so does" in asked_with([tmp_path / "b", tmp_path / "a"], "--help", same=plain("same"))


@pytest.mark.nojit
def test_types_are_those_of_live_annotations_or_of_what_is_usual(tmp_path):
    arguments = ", n: int = 3, on: bool = True, few=2, *, need: float"
    text = plain("other", arguments, "(n, on, few, need)", "arguments={'n': Argument('N.', at_least=2)}")
    ask = "other", "slider_crank"
    assert "Missing option '--need'" in asked_with([tmp_path], *ask, other=text)
    assert asked_with([tmp_path], *ask, "--need", "1", "--no-on", "--few", "5", "--n", "4") == "(4, False, 5, 1.0)\n"
    assert "1 is below 2" in asked_with([tmp_path], *ask, "--need", "1", "--n", "1")
    assert "expected a whole number, got 'inf'" in asked_with([tmp_path], *ask, "--need", "1", "--few", "inf")


@pytest.mark.nojit
def test_two_bars_of_the_same_name_are_two_bars():
    bars = Answer.of("two", blocks.bars("Bars", "y", ["a", "a"], [1.0, 2.0])).plot().axes[0].patches
    assert [bar.get_height() for bar in bars] == [1.0, 2.0]
    assert bars[0].get_x() != bars[1].get_x()


@pytest.mark.nojit
def test_a_folder_that_is_not_there_is_named():
    env = os.environ | {"RATTLE_QUESTIONS": "/nowhere/at/all"}
    done = subprocess.run([sys.executable, "-m", "rattle", "--help"], env=env, capture_output=True, text=True)
    assert done.returncode == 2
    assert "RATTLE_QUESTIONS: there is no folder /nowhere/at/all" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.nojit
def test_arguments_are_read_as_what_they_are_declared_to_be():
    def asked(m, k: int = 1, t: "Sequence[Seconds]" = (), x: "list[float]" = (), o: "Optional[int]" = None):  # noqa: F821
        """What is asked."""

    modes = questions()["modes"]._replace(answer=asked, arguments={"k": Argument("Which.", choices=("1", "2"))})
    assert [read(modes, *words) for words in (("k", "2"), ("t", "20 ms, 1"), ("x", "1,2.5"), ("o", "3"))] == [
        2, [0.02, 1.0], [1.0, 2.5], 3,
    ]  # fmt: skip
    for words, wrong in ((("k", "3"), "1 or 2"), (("x", "1,b"), "a number"), (("k", "1.5"), "a whole number")):
        with pytest.raises(InputError, match=wrong):
            read(modes, *words)


@pytest.mark.nojit
def test_blocks_that_do_not_fit_are_refused_where_they_are_made():
    with pytest.raises(InputError, match=r"the head has 2 cells, a row has 1"):
        table(("a", "b"), [("1",)])
    with pytest.raises(InputError, match=r"curve c: x has the shape \(2,\), y \(3,\)"):
        line("c", [0, 1], [1, 2, 3])
    assert Answer.of("told", numbers={"a": 1.5, "b": Number(2.0, "m")}).numbers == {"a": (1.5, ""), "b": (2.0, "m")}


@pytest.mark.nojit
def test_a_report_says_of_an_answer_that_cannot_be_drawn_why(tmp_path, monkeypatch):
    def huge(m) -> Answer:
        """Numbers that no axis can hold."""
        return Answer.of("huge", curves("Huge", "x", "y", [line("c", [0, 1], [-1e308, 1e308])]))

    asked = questions()["modes"]._replace(name="huge", title="Huge numbers", answer=huge)
    results = Study(rt.example("slider_crank"))
    results.keep("huge", huge(results.m))
    section = answer_section(results, asked)
    assert section.body == ""
    assert section.reason
