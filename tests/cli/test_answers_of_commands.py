"""Help texts, answers, JSON and refusals of every command stay word for word what they were."""

import pytest
from answers import KEPT, LINES, answers, difference, help_of, help_of_all

from rattle.cli.main import COMMANDS


@pytest.mark.nojit
@pytest.mark.parametrize("command", COMMANDS)
def test_help_texts_stay_word_for_word(command):
    assert help_of(command) == (KEPT / f"{command}.help.txt").read_text(encoding="utf-8")


@pytest.mark.nojit
def test_the_list_of_commands_stays_word_for_word():
    assert help_of_all() == (KEPT / "rattle.help.txt").read_text(encoding="utf-8")


@pytest.mark.parametrize("command", LINES)
def test_commands_answer_in_the_same_words_and_numbers(command):
    assert difference(answers(command), (KEPT / f"{command}.answers.txt").read_text(encoding="utf-8")) == ""


def test_a_changed_word_or_number_is_seen():
    """What the comparison is for."""
    kept = "peak 12.5 N at t = 0.1 s"
    assert difference(kept, kept) == ""
    assert difference("peak 12.501 N at t = 0.1 s", kept) == ""
    assert difference("peak 12.6 N at t = 0.1 s", kept)
    assert difference("peaks 12.5 N at t = 0.1 s", kept)
    assert difference(f"{kept}\nmore", kept)
