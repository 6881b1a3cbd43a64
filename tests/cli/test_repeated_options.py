"""What is written on the command line is used: an option that takes one value is refused where it is given twice."""

import click
import pytest
from click.testing import CliRunner

from rattle.cli.main import COMMANDS, main

pytestmark = pytest.mark.nojit
SOME = "1"


def call(*words):
    return CliRunner().invoke(main, [str(word) for word in words])


def options_of(command):
    return [option for option in main.get_command(click.Context(main), command).params if hasattr(option, "multiple")]


@pytest.mark.parametrize("command", COMMANDS)
def test_no_command_drops_a_value_of_an_option_that_is_given_twice(command):
    for option in options_of(command):
        if not isinstance(option, click.Option) or option.multiple or option.is_flag:
            continue
        name = max(option.opts, key=len)
        answer = call(command, "no_such_model", name, SOME, name, SOME)
        assert answer.exit_code == 2, f"{command} {name}"
        assert f"{name} is given twice; it takes one {option.metavar or 'value'}" in answer.output


@pytest.mark.parametrize("command", COMMANDS)
def test_a_choice_and_its_opposite_are_refused_and_a_flag_may_be_repeated(command):
    for option in options_of(command):
        if not isinstance(option, click.Option) or not option.is_flag:
            continue
        name, other = option.opts[0], (option.secondary_opts or option.opts)[0]
        answer = call(command, name, other, "no_such_model")
        assert ("is given twice" in answer.output) == bool(option.secondary_opts), f"{command} {name} {other}"


def test_a_short_and_a_long_name_are_one_option():
    answer = call("run", "fourbar", "-o", "a.nc", "--output", "b.nc")
    assert answer.exit_code == 2
    assert "--output is given twice; it takes one FILE" in answer.output


def test_three_times_is_said_as_such():
    answer = call("run", "fourbar", "--t-end", 1, "--t-end", 1, "--t-end", 2)
    assert "--t-end is given 3 times" in answer.output


def test_page_shows_the_curves_of_every_curves_option(tmp_path):
    words = (
        "page",
        "fourbar",
        "--ideal",
        "--t-end",
        "2 ms",
        "--curves",
        "rocker.angle",
        "--curves",
        "O3.no_such,O4.fx",
    )
    answer = call(*words, "-o", tmp_path / "page.html")
    assert "O3.no_such" in answer.output  # the first of them, which is known, is none that hides the second
    kept = call(*words[:5], "--curves", "rocker.angle", "--curves", "O4.fx", "-o", tmp_path / "page.html")
    assert kept.exit_code == 0, kept.output
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert '"rocker.angle", "O4.fx"' in page or '"rocker.angle","O4.fx"' in page


def test_poincare_takes_as_many_curves_as_it_draws():
    three = ("--of", "B.ex", "--of", "B.ey", "--of", "B.normal")
    answer = call("poincare", "slider_crank_play", *three)
    assert answer.exit_code == 2
    assert "--of is given 3 times; a section takes two curves" in answer.output
    answer = call("poincare", "slider_crank_play", *three[:4], "--parameter", "c", "--from", 1e-4, "--to", 2e-4)
    assert answer.exit_code == 2
    assert "a diagram over --parameter takes one curve" in answer.output


def test_compare_draws_every_curve(tmp_path):
    words = ("compare", "fourbar", "--t-end", 1e-4, "--curve", "rocker.angle", "--curve", "coupler.x")
    answer = call("-q", *words, "-o", tmp_path / "page.svg")
    assert answer.exit_code == 0, answer.output
    drawn = (tmp_path / "page.svg").read_text(encoding="utf-8")
    assert "Motion: rocker.angle" in drawn
    assert "Deviation of coupler.x" in drawn
