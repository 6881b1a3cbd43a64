"""`rattle power`: tables and pictures of a saved result."""

import csv

import pytest
from click.testing import CliRunner

import rattle as rt
from rattle.cli.main import main


def run(*arguments):
    return CliRunner().invoke(main, ["power", *map(str, arguments)])


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    """A result file of half a second of the four-bar without play."""
    path = tmp_path_factory.mktemp("power") / "out.npz"
    rt.example("fourbar").ideal().simulate(0.7).save(path)
    return path


def test_a_table_says_who_gives_what_to_whom(saved, tmp_path):
    p = rt.load_result(saved).power(0.5, 0.7)
    done = run(saved, "--cycle", "200 ms", "-o", tmp_path / "p.csv")
    assert done.exit_code == 0, done.output
    rows = {(row["element"], row["body"]): row for row in csv.DictReader((tmp_path / "p.csv").open(encoding="utf-8"))}
    for (element, body), row in rows.items():
        mine = p.table[(p.table["element"] == element) & (p.table["body"] == body)]
        assert float(row["net"]) == pytest.approx(float(mine["net"].iloc[0]), rel=1e-12, abs=1e-12)
    said = run(saved, "--cycle", "200 ms").output
    assert "t = 0.5 to 0.7 s" in said
    assert "motor" in said
    assert "largest imbalance of a body" in said


def test_a_picture_and_an_instant(saved, tmp_path):
    assert run(saved, "-o", tmp_path / "p.svg").exit_code == 0
    assert "rocker" in (tmp_path / "p.svg").read_text(encoding="utf-8")
    lines = run(saved, "--at", "0.1").output.splitlines()
    p = rt.load_result(saved).power().at(0.1)
    motor = float(next(line for line in lines if line.startswith("motor")).split()[-1])
    assert motor == pytest.approx(float(p[p["element"] == "motor"]["power"].iloc[0]), rel=1e-4)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("-o", "p.xyz"), "written as .csv, or as a picture"),
        (("--curves",), "give its name"),
        (("--cycle", "9"), "give times in order between 0 and the end, 0.7 s"),
        (("--at", "0.1", "-o", "p.svg"), "prints or writes a table"),
        (("--at", "3"), "expected a time within the run"),
    ],
)
def test_requests_that_make_no_sense_are_refused(saved, tmp_path, monkeypatch, arguments, said):
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(main, ["power", str(saved), *arguments])
    assert done.exit_code != 0
    assert said in done.output + str(done.exception)
