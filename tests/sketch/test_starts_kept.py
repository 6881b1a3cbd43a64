"""What a drag leaves in the text: starts that joints do not keep are none, and what has to follow is told."""

import pytest
from sheet import Sheet

from rattle.loading import examples


@pytest.fixture
def slider_crank():
    """The shipped one: its guide is through the bearing of the crank."""
    return Sheet(examples()["slider_crank"].read_text(encoding="utf-8"))


def test_a_guide_that_moves_takes_its_block_along_and_no_start_is_written(slider_crank):
    before = slider_crank.sketch.text
    slider_crank.do("nudge", point="ground.O", by=[0.0, 0.01])
    after = slider_crank.sketch.text
    assert slider_crank.place("slider.B")[1] == pytest.approx(0.01, abs=1e-12)
    assert after[after.index("[initial]") :] == before[before.index("[initial]") :]
    assert slider_crank.words == "ground.O moved; joints take along rod, slider"


def test_a_parameter_is_used_where_it_is_computed_with_and_nowhere_else(slider_crank):
    """The name of a model has words, and quantities have units, of which parameters may have the names."""
    text = """name = "l and m of a bar"
format = 1
[parameters]
l = 0.1
m = { value = 2, label = "l of a bar" }
[bodies.bar]
bar = ["A", "B"]
length = "l"
mass = "m + 0*l"
[bodies.other]
bar = ["A", "B"]
length = "3 m"
mass = "m"
"""
    sheet = Sheet(text)
    sheet.type("body bar", "Length", "0.2 m")
    assert sheet.words.endswith("parameter l is 0.2 m now, in bodies.bar.length, bodies.bar.mass")
