"""Drawings of what has no size or no value: they are shown, and say what is wrong."""

from sheet import Sheet

from rattle.loading import examples
from rattle.sketch.picture import picture_of


def test_a_motor_whose_function_has_no_value_is_drawn_and_says_so():
    """The laws of a five-bar for arms that do not reach."""
    text = examples()["five_bar"].read_text(encoding="utf-8")
    sheet = Sheet(text.replace('a = "200 mm"', 'a = "71 mm"').replace('b = "100 mm"', 'b = "160 mm"'))
    status = picture_of(sheet.sketch)["status"]
    assert status.startswith("5 joints, 2 motors: cannot move: the function of driver 'left_motor' has no finite value")


def test_points_that_rounding_parts_have_no_size():
    """What is drawn beside them is as large as on an empty sheet."""
    sheet = Sheet("format = 1\n[ground.points]\nO = [1e-20, 0.3]\nP = [0, 0.30000000000000004]\n")
    assert sheet.sketch.size == 1.0
    sheet = Sheet("format = 1\n[ground.points]\nO = [1e-9, 0.3]\nP = [0, 0.3]\n")
    assert sheet.sketch.size == 1e-9
