"""Fits against the limits of the standard, row by row, and what is refused."""

import csv
import math
from pathlib import Path

import numpy as np
import pytest

import rattle as rt
from rattle.catalogue.fits import Fit

pytestmark = [pytest.mark.nojit, pytest.mark.plain]
LINES = (Path(__file__).parents[1] / "data" / "iso286_fits.csv").read_text(encoding="utf-8").splitlines()
ROWS = list(csv.DictReader(line for line in LINES if not line.startswith("#")))
ROUNDING = 1e-9  # um


def um(fit: Fit) -> list[float]:
    return [size * 1e6 for size in (*fit.hole, *fit.shaft)]


def test_all_ranges_of_24_fits_have_the_limits_of_the_standard():
    assert len(ROWS) == 600
    for row in ROWS:
        low, high = float(row["over"]), float(row["to"])
        limits = np.array([float(row[key]) for key in ("EI", "ES", "ei", "es")])
        for size in (0.5 * (low + high), high, low + 1.001):
            fit = rt.fit(row["fit"], f"{size} mm")
            assert np.allclose(um(fit), limits, rtol=0, atol=ROUNDING), (row, size)
            least, largest = limits[0] - limits[3], limits[1] - limits[2]
            plays = np.array([fit.least, fit.largest, fit.radial, fit.tol]) * 1e6
            assert np.allclose(plays, [least, largest, (least + largest) / 4, (largest - least) / 4], atol=ROUNDING)


@pytest.mark.parametrize(
    ("size", "least", "largest"),
    [("3 mm", 2, 18), ("3.001 mm", 4, 24), (0.006, 4, 24), ("6.001 mm", 5, 29), ("0.01 m", 5, 29), ("500 mm", 20, 123)],
)
def test_a_range_ends_with_its_upper_border(size, least, largest):
    fit = rt.fit("H7/g6", size)
    assert (fit.least * 1e6, fit.largest * 1e6) == pytest.approx((least, largest), abs=ROUNDING)


@pytest.mark.parametrize(
    ("text", "size", "least", "largest"),
    [
        ("G7/g6", 8, 10, 34), ("D10/f7", 25, 85, 190), ("H10/d9", 45, 80, 242), ("E8/js6", 25, 33.5, 79.5),
        ("H6/f6", 12, 16, 38), ("C9/h8", 33, 120, 221), ("H12/b11", 130, 260, 910), ("H5/g4", 8, 5, 15),
        ("H7/fg6", 8, 8, 32), ("H8/cd8", 5, 46, 82), ("A11/h11", 60, 340, 720), ("H7/h6", 30, 0, 34),
        ("H01/h01", 8, 0, 0.8), ("JS7/a11", 8, 272.5, 377.5), ("JS9/d9", 5, 15, 75),
    ],
)  # fmt: skip
def test_fits_are_put_together_from_single_deviations(text, size, least, largest):
    fit = rt.fit(text, f"{size} mm")
    assert (fit.least * 1e6, fit.largest * 1e6) == pytest.approx((least, largest), abs=ROUNDING)


def test_blanks_do_not_matter_and_the_fit_says_what_it_is():
    fit = rt.fit(" H7 / g6 ", "8 mm")
    assert fit == rt.fit("H7/g6", 0.008)
    assert (fit.text, fit.source, fit.diameter) == ("H7/g6", "ISO 286", 0.008)
    assert fit.words == "H7/g6 of 8 mm: radial play 2.5 to 14.5 um"
    assert (fit.radial, fit.tol) == pytest.approx((8.5e-6, 6e-6))


def test_two_diameters_make_the_play():
    fit = rt.fit("H7/g6", "8 mm")
    assert fit.bore == pytest.approx((7.5e-6, 7.5e-6))
    assert fit.pin == pytest.approx((-9.5e-6, 4.5e-6))
    assert (fit.bore[0] - fit.pin[0]) / 2 == pytest.approx(fit.radial)
    assert (fit.bore[1] + fit.pin[1]) / 2 == pytest.approx(fit.tol)


@pytest.mark.parametrize(
    ("text", "size", "words"),
    [
        ("H7/p6", "8 mm", "H7/p6.*beyond h: interference"),
        ("H7/k6", "8 mm", "interference"),
        ("P7/h6", "8 mm", "hole P lies beyond H"),
        ("H7/js6", "8 mm", r"no play at every part of the field: from 4\.5 um interference to 19\.5 um play"),
        ("JS7/h6", "8 mm", "from 7.5 um interference"),
        ("H7/fg6", "20 mm", "fg exists up to 10 mm"),
        ("H7/cd8", "11 mm", "cd exists up to 10 mm"),
        ("EF7/h6", "11 mm", "EF exists up to 10 mm"),
        ("H11/a11", "0.8 mm", "does not use a up to 1 mm"),
        ("B11/h11", "0.8 mm", "does not use B up to 1 mm"),
        ("H7", "8 mm", "has no shaft"),
        ("H7/g6/f5", "8 mm", "has 3 parts"),
        ("h6/H7", "8 mm", "did you mean 'H7/h6'"),
        ("h7/g6", "8 mm", "did you mean 'H7/g6'"),
        ("H7/G6", "8 mm", "did you mean 'H7/g6'"),
        ("H19/g6", "8 mm", "no grade 19"),
        ("H07/g6", "8 mm", "no grade 07"),
        ("H7/g", "8 mm", "its shaft 'g'"),
        ("7/g6", "8 mm", "its hole '7'"),
        ("", "8 mm", "is empty"),
        ("H7/q6", "8 mm", "no shaft with the letter 'q'"),
        ("I7/g6", "8 mm", "no hole with the letter 'I'"),
        ("H7/g\u0666", "8 mm", "is not a fit"),
        ("H7/g6", "0 mm", "outside 0 ... 500 mm"),
        ("H7/g6", "-8 mm", "outside 0 ... 500 mm"),
        ("H7/g6", "500.1 mm", "outside 0 ... 500 mm"),
        ("H7/g6", 8, "a number is in metres: write '8 mm'"),
        ("H7/g6", "8 kg", "is a mass"),
        ("H7/g6", "wide", "is not a length"),
        ("H7/g6", math.nan, "not a finite"),
        ("H7/g6", math.inf, "not a finite"),
        ("H7/g6", True, "diameter is a length"),
        ("H7/g6", None, "diameter is a length"),
        (76, "8 mm", "a fit is a text"),
    ],
)
def test_what_is_no_fit_with_play_is_refused_with_the_reason(text, size, words):
    with pytest.raises(rt.InputError, match=words):
        rt.fit(text, size)
