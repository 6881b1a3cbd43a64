"""One table of units for people: those of the model file first, the same in pictures and in pages."""

import math

import numpy as np
import pytest

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
