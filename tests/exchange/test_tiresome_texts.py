"""Texts that would take a search of signs minutes are refused at once."""

import json

import pytest

import rattle as rt
from bounded import bounded
from rattle.errors import InputError, ModelError
from rattle.exchange.svg.lengths import LONGEST, length_of, numbers_of, transform_of

MOST = 6.0  # processor seconds: without limits they take nine and more


@pytest.mark.parametrize(
    ("read", "text"),
    [
        (transform_of, " " * (LONGEST - 10) + "x"),
        (transform_of, "\u00a0" * (LONGEST - 10) + "x"),
        (transform_of, "a" * 20_000),
        (length_of, "1" * (LONGEST - 10) + "x"),
        (length_of, "1" * 20_000 + "x"),
        (numbers_of, "1" * 200_000),
        (numbers_of, " " * 200_000 + "x"),
    ],
)
def test_numbers_of_svg_are_read_in_one_pass(read, text):
    with bounded(MOST):
        assert read(text) is None


def test_links_with_very_many_joints_are_refused(tmp_path):
    joints = [{"id": f"j{k}", "type": "revolute", "position": [k, 0]} for k in range(1999)]
    links = [{"id": f"l{k}", "type": "link", "joints": [joint["id"] for joint in joints]} for k in range(30)]
    (tmp_path / "p.json").write_text(json.dumps({"name": "many", "joints": joints, "links": links}))
    with bounded(MOST), pytest.raises((InputError, ModelError), match="more than 5000 joints"):
        rt.read(tmp_path / "p.json")
