"""One table of units for people: those of the model file first, the same in pictures and in pages."""

import math

import numpy as np
import pytest

from rattle.language.units import UNITS, parse_quantity, unit_name
from rattle.results.handy_units import HANDY, handy_unit, written_units

pytestmark = [pytest.mark.nojit, pytest.mark.plain]
MODEL = {
    "name": "5 mm is no length here, this is a name",
    "parameters": {
        "l": "300 mm",
        "a": {"value": "60 deg", "label": "90 rad"},
        "n": "60 rpm",
        "c": "20 um",
        "M": "4 N*m",
    },
    "ground": {"points": {"O": ["0 mm", 0], "W": ["280 mm", "-40 mm"]}},
    "loads": {"f": {"force": ["-4 N*tanh(arm.T.vx/(10 mm/s))", "3 kN"]}, "g": {"force": ["4 N", 0]}},
}


def test_a_quantity_has_the_unit_of_the_one_in_the_model_file_that_is_nearest_in_size():
    written = written_units(MODEL)
    assert [handy_unit("m", size, written).unit for size in (0.5, 2e-3, 3e-5, 0.0)] == ["mm", "mm", "um", "mm"]
    assert [handy_unit("N", size, written).unit for size in (30.0, 3e3)] == ["N", "kN"]
    assert (handy_unit("rad", 1.0, written).unit, handy_unit("N*m", 90.0, written).unit) == ("deg", "N*m")
    rpm = handy_unit("rad/s", math.pi, written)
    assert (rpm.factor * math.pi, rpm.unit) == (pytest.approx(30.0), "rpm")
    assert written_units({"parameters": {"l": 0.3, "x": "l/2"}}) == {}


def test_the_unit_of_the_model_file_is_left_where_its_numbers_are_not_handy():
    written = written_units(MODEL)
    assert handy_unit("m", 2e-8, written).unit == "µm"
    assert handy_unit("m", 200.0, written) == (1.0, "m")
    assert handy_unit("Pa", 5e6, written) == (1e-6, "MPa")


def test_an_energy_lends_its_unit_to_no_moment_and_turns_lend_theirs_to_angles():
    written = written_units({"parameters": {"E": "5 kJ", "M": "4 N*m", "turns": "3 rev", "w": "2 rev/s"}})
    assert sorted(written) == ["N*m", "rad", "rad/s"]
    assert handy_unit("N*m", 5.0, written).unit == "N*m"
    assert handy_unit("rad", 6.0 * math.pi, written) == (pytest.approx(0.5 / math.pi), "rev")


def test_pages_read_every_unit_that_model_files_may_have(viewer_in_node):
    texts = [f"2.5 {unit}" for unit in (*UNITS, "N*m/rad", "kN/mm^2", "mm/s^2", "N*s/m")]
    want = [parse_quantity(text) for text in texts]
    found = viewer_in_node(
        'import { typedValue } from "./viewer.mjs";\n'
        'console.log(JSON.stringify(data.map(([text, unit]) => typedValue(text, unit, ""))));',
        [(text, unit_name(dimension)) for text, (_, dimension) in zip(texts, want, strict=True)],
    )
    assert found == pytest.approx([value for value, _ in want], rel=1e-12)


def test_a_slider_is_exact_at_its_ends_and_its_own_value_and_round_in_the_unit_shown_elsewhere(viewer_in_node):
    knob = {"min": 1e-3, "max": 4e-3, "value": 2.0001e-3, "factor": 1e-3}
    found = viewer_in_node(
        'import { plain, stepOf, valueAt } from "./viewer.mjs";\n'
        "const texts = [...Array(401).keys()].map((step) => plain(valueAt(data, step) / data.factor));\n"
        "console.log(JSON.stringify([texts, stepOf(data, data.value), plain(2e7), plain(5e-5), plain(0.1 + 0.2)]));",
        knob,
    )
    texts, own, *numbers = found
    assert (texts[0], texts[own], texts[400]) == ("1", "2.0001", "4")
    assert all(len(text) <= 4 for step, text in enumerate(texts) if step != own)  # such as 3.27
    assert numbers == ["2e7", "5e-5", "0.3"]


def test_pages_choose_the_same_unit_as_pictures(viewer_in_node):
    """Sizes are random over sixteen decades, seeded; with and without units of a model file."""
    random = np.random.default_rng(3)
    written = written_units(MODEL)
    asked = [
        (unit, float(10.0 ** random.uniform(-8, 8)), bool(k % 2)) for unit in (*HANDY, "kg", "") for k in range(20)
    ]
    asked += [(unit, 0.0, own) for unit in HANDY for own in (True, False)]
    found = viewer_in_node(
        'import { handyUnit } from "./viewer.mjs";\n'
        "const found = data[0].map(([unit, size, own]) => handyUnit(unit, size, own ? data[1] : undefined));\n"
        "console.log(JSON.stringify(found));",
        [asked, written],
    )
    for (unit, size, own), shown in zip(asked, found, strict=True):
        want = handy_unit(unit, size, written if own else None)
        assert shown["factor"] == pytest.approx(want.factor)
        assert shown["unit"] == want.unit.replace("*", "·").replace("^2", "²")
