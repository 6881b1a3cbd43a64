"""What the commands of all questions share."""

import json

import pytest
from click.testing import CliRunner

from rattle.answers.answer import Answer, Number
from rattle.cli.asked import command_of
from rattle.cli.main import main
from rattle.question import Question

KINEMATICS = ("--analysis", "kinematics", "--of", "max(slider.ax)", "--threads", "1")


def run(*words):
    return CliRunner().invoke(main, ["-q", *map(str, words)])


@pytest.mark.nojit
def test_an_argument_may_have_the_name_of_an_option_of_other_commands():
    def spans(m, csv: int = 1, required: int = 2) -> Answer:
        """Both, and the number of bodies."""
        return Answer.of(
            "both", numbers={"csv": Number(csv), "required": Number(required), "bodies": len(m.model.bodies)}
        )

    asked = Question("spans", spans, "nowhere", "Both.", "mechanism", "spans", "Spans", (), (), 1, {}, True, None)
    words = ["slider_crank", "--csv", "3", "--required", "4", "--json"]
    done = CliRunner().invoke(command_of(asked), words, obj={"quiet": True}, catch_exceptions=False)
    numbers = {name: number["value"] for name, number in json.loads(done.stdout)["numbers"].items()}
    assert numbers == {"csv": 3, "required": 4, "bodies": 3}


@pytest.mark.parametrize(
    "words",
    [
        ("sweep", "slider_crank", "--over", "rod_length=.1:.2:2", *KINEMATICS),
        ("wear", "slider_crank_worn", "--cycles", "1", "--jump", "1"),
        ("accuracy", "fourbar", "--of", "rocker.angle", "--points", "2"),
    ],
)
def test_with_json_and_a_picture_the_json_stands_alone(tmp_path, words):
    picture = tmp_path / "picture.svg"
    flag = "-o" if words[0] == "accuracy" else "--plot"
    done = run(*words, flag, picture, "--json")
    assert done.exit_code == 0
    assert json.loads(done.stdout)
    assert picture.stat().st_size > 1000
    assert run(*words, flag, picture).stdout.endswith(f"{picture}\n")
