"""`rattle tolerance`: its tables, answers and refusals."""

import json

import pytest
from click.testing import CliRunner

import rattle as rt
from rattle.cli.main import main

pytestmark = pytest.mark.nojit
OF = "at(coupler.P.y, 0.35)"
WORDS = (
    "path_generator", "--ideal", "--analysis", "kinematics", "--vary", "a,b,d,r", "--of", OF, "-n", "64", "--t-end",
    "0.4",
)  # fmt: skip


def run(*words):
    return CliRunner().invoke(main, ["-q", "tolerance", *words])


@pytest.mark.machine
def test_the_report_and_its_numbers_are_those_of_the_python_interface(tmp_path):
    picture = tmp_path / "t.svg"
    seen = run(*WORDS, "--limit", "0.1 mm", "--require", "80 %", "--plot", str(picture))
    assert seen.exit_code == 0, seen.output
    t = rt.example("path_generator").ideal().tolerance(OF, ["a", "b", "d", "r"], analysis="kinematics", n=64, t_end=0.4)
    assert str(t).splitlines()[2] in seen.stdout
    assert "mm/mm" in seen.stdout  # the unit of r, which is 2.5*a, is that of its tolerance
    assert "of the mechanisms are within 0.1 mm" in seen.stdout
    assert "loosest tolerances that keep" in seen.stdout
    assert all(word in picture.read_text() for word in ("worst case", "root sum square", "nominal"))
    record = json.loads(run(*WORDS, "--limit", "0.1 mm", "--json").stdout)
    assert record["worst_case"] == list(t.worst_case)
    assert record["sobol"]["r"]["first"] == t.sobol.loc["r", "first"]
    assert record["tighten"][0] == "r"
    assert set(record["allocation"]) == {"a", "b", "d", "r"}


def test_the_largest_tolerance_of_one_parameter():
    words = [one if one != "a,b,d,r" else "a,b,d" for one in WORDS]
    seen = run(*words, "--limit", "0.1 mm", "--largest", "r", "--share", "0.99")
    assert seen.exit_code == 0, seen.output
    assert seen.stdout.startswith("largest tolerance of r: +-0.0")
    assert "99 % of the mechanisms keep" in seen.stdout


@pytest.mark.parametrize("words", [("--limit", "0.1 N"), ("--limit", "-1 mm"), ("--limit", "1 mm", "--cost", "r=1")])
def test_what_cannot_be_answered_is_refused_before_anything_runs(monkeypatch, words):
    def never(*given, **more):
        raise AssertionError("samples were run")

    monkeypatch.setattr(rt.Mechanism, "tolerance", never)
    seen = run(*WORDS, *words)
    assert seen.exit_code == 2, seen.output
    assert "error" in seen.output


def test_the_report_is_not_lost_where_no_tolerances_keep_the_limit(tmp_path):
    file = tmp_path / "m.toml"
    table = 'r = { value = "100 mm", dist = { values = ["99 mm", "101 mm"] } }'
    text = rt.example("path_generator").ideal().to_toml()
    file.write_text("\n".join(table if line.startswith("r = ") else line for line in text.splitlines()))
    words = (str(file), *WORDS[2:], "--limit", "0.01 mm")
    seen = run(*words)
    assert seen.exit_code == 1, seen.output
    assert "root sum square" in seen.stdout
    assert "of the mechanisms are within 0.01 mm" in seen.stdout
    assert "no tolerances: within: tables of values (r) alone take more than is allowed" in seen.stdout
    record = json.loads(run(*words, "--json").stdout)
    assert record["allocation"] is None
    assert record["share_within"]["value"] == 0.0


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--largest", "r"), "--largest needs --limit"),
        (("--cost", "r=1"), "--cost needs --limit"),
        (("--limit", "0.1 mm", "--cost", "r"), "NAME=COST"),
        (("--limit", "0.1 mm", "--cost", "r=1", "--cost", "r=2"), "'r' is given twice"),
        (("--share", "0.9"), "--share needs --largest"),
        (("--allocate", "rss"), "--allocate needs --limit"),
        (("--limit", "0.1 mm", "--largest", "r", "--plot", "t.svg"), "--plot says nothing to --largest"),
        (("--limit", "0.1 mm", "--largest", "r", "--cost", "r=2"), "--cost says nothing to --largest"),
        (("--limit", "0.1 N"), "force"),
        (("--vary", "q"), "no parameter 'q'"),
        (("--plot", "t.doc"), "picture"),
    ],
)
def test_bad_words_are_refused_with_a_hint(words, message):
    seen = run(*WORDS, *words)
    assert seen.exit_code == 2, seen.output
    assert message in seen.output
    assert "Traceback" not in seen.output
