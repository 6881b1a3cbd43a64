"""Play is typed as a length, as a fit or as the number of a rolling bearing, and shown as it is written."""

import pytest
from sheet import PINS, Sheet

import rattle as rt
from rattle.errors import InputError
from rattle.sketch.fields import fields_of

pytestmark = pytest.mark.nojit


@pytest.fixture
def crank():
    sheet = Sheet()
    sheet.ground(PINS[0])
    sheet.bars(PINS[0], PINS[1])
    return sheet


def play(sheet):
    (chosen,) = (f"joint {name}" for name in sheet.table["joints"])
    (field,) = (field for field in fields_of(sheet.sketch, chosen) if field.name == "Play")
    return chosen, field


def clearance(sheet):
    (joint,) = rt.loads(sheet.sketch.text).model.joints.values()
    return joint.clearance


@pytest.mark.parametrize(
    ("typed", "shown", "radial"),
    [
        ("0.2 mm", "0.2 mm", 2e-4),
        ("H7/g6 8 mm", "H7/g6 8 mm", 8.5e-6),
        ("H7/g6 of 8 mm", "H7/g6 8 mm", 8.5e-6),
        (" H7 / g6  8 mm ", "H7/g6 8 mm", 8.5e-6),
        ("6208 C3", "6208 C3", 12e-6),
        ("6000 um", "6000 um", 6e-3),
        ("600 µm", "600 µm", 6e-4),
        ("6004-2RS C3", "6004-2RS C3", 10.25e-6),
    ],
)
def test_play_is_typed_in_three_ways(crank, typed, shown, radial):
    chosen, field = play(crank)
    assert field.text == ""
    crank.type(chosen, "Play", typed)
    assert play(crank)[1].text == shown
    assert clearance(crank) == pytest.approx(radial)


def test_a_way_takes_the_place_of_the_one_before(crank):
    chosen, _ = play(crank)
    for typed in ("6208 C3", "H7/g6 8 mm", "0.2 mm", "6208", "0.1 mm"):
        crank.type(chosen, "Play", typed)
        assert play(crank)[1].text == typed
    before = crank.texts[1]
    crank.type(chosen, "Play", "")
    assert "# down" in crank.sketch.text
    assert clearance(crank) == 0.0
    assert before.count("clearance") == crank.sketch.text.count("clearance") == 0


@pytest.mark.parametrize(
    ("typed", "words"),
    [("H7/p6 8 mm", "interference"), ("H7/g6 8 kg", "8 kg"), ("6299 C3", "100 mm"), ("600", "a length has a unit")],
)
def test_what_leaves_no_play_is_refused(crank, typed, words):
    chosen, _ = play(crank)
    before = crank.sketch.text
    with pytest.raises(InputError, match=words):
        crank.type(chosen, "Play", typed)
    assert crank.sketch.text == before


def test_what_is_offered_can_be_typed(crank):
    chosen, field = play(crank)
    for offer in field.offers:
        crank.type(chosen, "Play", offer)
        assert clearance(crank) > 0.0
