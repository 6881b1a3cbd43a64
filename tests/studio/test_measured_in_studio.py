"""Measured curves in the studio: a file that is dropped is shown beside the motion, and the model stays as it is."""

import numpy as np
import pytest
from studio_models import PENDULUM

import rattle as rt
from browsing import becomes, frames, keep_picture, shows
from rattle.errors import InputError
from rattle.studio.measured import measured_columns

DROP = """([name, text]) => {
  const data = new DataTransfer();
  data.items.add(new File([text], name, { type: "text/csv" }));
  const place = document.querySelector(".motion-of");
  const how = { dataTransfer: data, bubbles: true, cancelable: true };
  for (const kind of ["dragover", "drop"]) place.dispatchEvent(new DragEvent(kind, how));
}"""
CURVES = {"rod.angle": "rad", "rod.omega": "rad/s", "O.fx": "N"}


def bench(shift=0.0):
    """What was measured of the pendulum: 2 deg too much, with decimal commas."""
    r = rt.loads(PENDULUM).simulate()
    rows = [(1e3 * (t - shift), np.rad2deg(y) + 2.0) for t, y in zip(r.t[::50], r["rod.angle"][::50], strict=True)]
    return "t [ms];theta [deg];note\r\n" + "".join(f"{t:.6f};{y:.9f};x\r\n".replace(".", ",") for t, y in rows)


def test_a_dropped_file_is_shown_beside_the_motion_and_the_model_stays_as_it_is(visit):
    page = visit()
    page.evaluate("() => rattle.choose(['rod.angle'])")
    before = page.locator("textarea.area").input_value()
    page.evaluate(DROP, ["m.csv", bench()])
    becomes(page, "() => rattle.measured.length === 1")
    (seen,) = page.evaluate("() => rattle.measured")
    assert (seen["curve"], seen["label"]) == ("rod.angle", "theta (m.csv)")
    assert np.rad2deg(seen["rms"]) == pytest.approx(2.0, rel=1e-4)
    frames(page)
    keep_picture(page, "studio_measured")
    assert page.locator("textarea.area").input_value() == before
    slider = page.locator("#knob-l")
    slider.focus()
    for _ in range(5):
        page.keyboard.press("ArrowRight")
    becomes(page, "(rms) => rattle.measured.length === 1 && Math.abs(rattle.measured[0].rms - rms) > 1e-3", seen["rms"])
    page.get_by_role("button", name="Remove theta of m.csv").click()
    becomes(page, "() => rattle.measured.length === 0")


def test_its_curve_and_its_offset_can_be_chosen(visit):
    page = visit()
    page.evaluate("() => rattle.choose(['rod.x'])")
    page.get_by_label("File of measured curves").set_input_files(
        {"name": "m.csv", "mimeType": "text/csv", "buffer": bench(shift=0.1).encode()}
    )
    shows(page.get_by_text("choose the curve that its column belongs to"))
    page.get_by_label("belongs to").select_option("rod.angle")
    becomes(page, "() => rattle.measured.length === 1")
    (seen,) = page.evaluate("() => rattle.measured")
    assert np.rad2deg(seen["rms"]) > 3.0
    offset = page.get_by_label("Offset in time")
    offset.fill("100 parsecs")
    offset.press("Enter")
    shows(page.locator('input[aria-label="Offset in time"][aria-invalid="true"]'))
    offset.fill("100 ms")
    offset.press("Enter")
    becomes(page, "() => Math.abs(rattle.measured[0].rms * 180 / Math.PI - 2) < 1e-3")
    assert page.evaluate("() => rattle.viewer.curves.chosen") == ["rod.x", "rod.angle"]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("t [s];x [deg]\n0;1\n1;nan\n", "m.csv, line 3: 'nan' in the column 'x [deg]' is not a finite number"),
        ("0;1\n", "m.csv, line 1: numbers without a head"),
    ],
)
def test_what_cannot_be_read_is_said_with_its_line(visit, text, words):
    page = visit()
    page.evaluate(DROP, ["m.csv", text])
    shows(page.get_by_text(words))
    assert page.evaluate("() => rattle.measured") == []


@pytest.mark.nojit
def test_columns_come_with_the_curves_that_they_may_belong_to():
    answer = measured_columns("m.csv", "t;a [deg];F [kN];ratio\n0;1;2;3\n", CURVES, ["rod.angle", "O.fx"])
    assert [(column["name"], column["curve"], column["units"]) for column in answer["columns"]] == [
        ("a", "rod.angle", ["rad"]),
        ("F", "O.fx", ["N"]),
        ("ratio", "", ["N", "rad", "rad/s"]),
    ]
    assert [c["curve"] for c in measured_columns("m.csv", "t;rod.omega [rpm]\n0;1\n", CURVES, ["O.fx"])["columns"]] == [
        "rod.omega"
    ]


@pytest.mark.nojit
def test_a_file_without_any_column_of_numbers_is_refused_with_the_first_reason():
    with pytest.raises(InputError, match=r"m\.csv, line 1: 'a \[fluid\]': unknown unit 'fluid'"):
        measured_columns("m.csv", "t;a [fluid];b\n0;1;x\n", CURVES, [])
