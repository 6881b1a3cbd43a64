"""Drawings that are broken, huge or made to do harm: read or refused in words and soon, whatever they hold."""

import json
import resource

import numpy as np
import pytest

import rattle as rt
from bounded import bounded
from dxf_files import arc, box, circle, dxf, insert, line, old_outline, outline
from rattle.exchange.dxf.read import read_dxf
from rattle.exchange.dxf.write import dxf_of
from rattle.exchange.imported import Assumptions
from rattle.exchange.svg.read import read_svg

pytestmark = pytest.mark.nojit
VALUES: tuple[str, ...] = ("nan", "inf", "-1e308", "1e308", "1e-308", "0", "-1", "9" * 30, "abc", "1_0", "0x1")
VALUES += ("ground", "-0.0", "1e12", "\u0663", "CIRCLE")
VALUES += ("", "POLYLINE", "VERTEX", "INSERT", "SEQEND", "ENDSEC", "SECTION", "BLOCK", "EOF")


def sample():
    part = [box("arm", -8, -8, 68, 8), circle("arm", 0, 0, 4.2), circle("arm", 60, 0, 4), circle("ground", 0, 0, 4)]
    part += [old_outline("rod", [(50, -9), (150, -9, 0.5), (150, 9), (50, 9)]), circle("rod", 60, 0, 4)]
    part += [insert("rod", "b", 0, 0, ("41", 2), ("42", -2)), line("d", -5, 0, 5, 0), arc("d", 0, 0, 5, 0, 180)]
    part += [outline("e", [(0, 30), (10, 30, 1), (10, 40)], 0), [("0", "TEXT"), ("8", "e")]]
    inner = ("c", (1, 2), [circle("q", 3, 3, 1)])
    return dxf(part, blocks=[("b", (0, 0), [circle("0", 40, 1, 1), insert("0", "c", 1, 1)]), inner])


PICTURE = """\
<svg xmlns="http://www.w3.org/2000/svg" width="90mm" height="50mm" viewBox="0 0 90 50">
<g id="a" transform="rotate(3) scale(1 -1)">
<path d="M0 0h40a5 3 20 0 1 5 5v10c1 2 3 4-5 5q1 1-3 2T0 20zm9 9h3v3z"/><circle cx="5" cy="5" r="2"/></g>
<g id="b"><rect x="50" width="20" height="9" rx="2"/><ellipse cx="60" cy="4" rx="2" ry="1"/>
<polygon points="0,0 1,1 2,0"/></g></svg>
"""


def settled(read, text):
    """Read, or refused with words; what is read is a model or refused as one."""
    words = ""
    with bounded():
        try:
            rt.loads(json.dumps(read(text, "x.drawing", Assumptions()).document))
        except rt.InputError as error:
            words = str(error)
    assert words == "" or 8 < len(words) < 2000
    return "refused" if words else "read"


def broken_lines(rng, text):
    """A text with some lines taken out, doubled, exchanged, replaced."""
    lines = text.split("\n")
    for _ in range(int(rng.integers(1, 4))):
        k, n = int(rng.integers(len(lines))), int(rng.integers(len(lines)))
        act = int(rng.integers(5))
        if act == 0:
            lines[k] = VALUES[int(rng.integers(len(VALUES)))]
        elif act == 1:
            del lines[k - k % 2 : k - k % 2 + int(rng.integers(1, 7))]
        elif act == 2:
            lines[k:k] = lines[n : n + int(rng.integers(1, 30))]
        elif act == 3:
            lines[k], lines[n] = lines[n], lines[k]
        else:
            lines = lines[: max(1, k)]
    return "\n".join(lines)


def test_broken_dxf_is_read_or_refused():
    rng, text, ends = np.random.default_rng(11), sample(), []
    assert settled(read_dxf, text) == "read"
    for _ in range(400):
        ends.append(settled(read_dxf, broken_lines(rng, text)))
    assert ends.count("read") > 30
    assert ends.count("refused") > 30


def test_broken_svg_is_read_or_refused():
    rng, ends = np.random.default_rng(12), []
    assert settled(read_svg, PICTURE) == "read"
    letters = "<>\"'&;=/ 0123456789.-eMLHVCSQTAZmlhvcsqtaz()\0\u00e9"
    for _ in range(300):
        text = list(PICTURE)
        for _ in range(int(rng.integers(1, 5))):
            k = int(rng.integers(len(text)))
            text[k : k + int(rng.integers(0, 3))] = letters[int(rng.integers(len(letters)))] * int(rng.integers(1, 3))
        ends.append(settled(read_svg, "".join(text)))
    assert ends.count("read") > 30
    assert ends.count("refused") > 30


def bulges(n):
    """A wheel with n small bulges on its rim."""
    turns = [2 * np.pi * k / n for k in range(n)]
    return outline("a", [(1000 * np.cos(turn), 1000 * np.sin(turn), 0.2) for turn in turns])


LONG = "0\nLINE\n8\na\n10\n0\n20\n0\n11\n1\n21\n1\n"
NESTED = [(f"b{k}", (0, 0), [insert("0", f"b{k + 1}", n, 0) for n in range(60)]) for k in range(12)]
DOT = [circle("0", 0, 0, 1)]
ROWS = insert("a", "b", 0, 0, ("70", 30000), ("71", 30000), ("44", 1), ("45", 1))
HUGE = {
    "a million bulges": lambda: dxf([bulges(1_000_000)]),
    "as many bulges as there may be": lambda: dxf([bulges(9_900)]),
    "as many bulges and circles": lambda: dxf([bulges(9_900), *(circle("a", k, 3, 0.01) for k in range(900))]),
    "lines that close nothing": lambda: dxf([line("a", k, 0, k + 1, 0) for k in range(9_900)]),
    "a grid of lines": lambda: dxf([line("a", k % 99, k // 99, k % 99 + 1, k // 99) for k in range(9_900)]),
    "too many lines": lambda: dxf([line("a", k, 0, k + 1, 0) for k in range(49_000)]),
    "two million lines of text": lambda: LONG * 170_000,
    "blocks of blocks of blocks": lambda: dxf([insert("a", "b0", 0, 0)], blocks=[*NESTED, ("b12", (0, 0), DOT)]),
    "a row of a billion": lambda: dxf([ROWS], blocks=[("b", (0, 0), DOT)]),
    "an empty row of a billion": lambda: dxf([ROWS], blocks=[("b", (0, 0), [])]),
    "many layers": lambda: dxf([circle(f"l{k}", 0, 0, 1 + k) for k in range(3000)]),
    "many sleeves": lambda: dxf([circle(f"l{k % 95}", 0, 0, 1 + k) for k in range(990)]),
    "outlines in outlines": lambda: dxf([box("a", -k, -k, k, k) for k in range(1, 180)]),
    "too many outlines in outlines": lambda: dxf([box("a", -k, -k, k, k) for k in range(1, 420)]),
    "many outlines": lambda: dxf([box("a", 3 * k, 0, 3 * k + 1, 1) for k in range(9000)]),
    "many polylines": lambda: dxf([old_outline("a", [(k, 0), (k + 1, 0), (k, 1)]) for k in range(3_000)]),
    "a spiral": lambda: dxf([outline("a", [(k * np.cos(k / 9), k * np.sin(k / 9), 0.1) for k in range(9000)])]),
    "one long value": lambda: dxf([circle("a" * 4_000_000, 0, 0, 1)]),
}


NO_BODY, FEWER = "no layer is a body", "more than 1000"
REFUSED = {  # the others are read
    "a million bulges": "more than 8 million", "lines that close nothing": NO_BODY, "a grid of lines": NO_BODY,
    "too many lines": "more than 300000", "two million lines of text": "more than 300000",
    "blocks of blocks of blocks": FEWER, "a row of a billion": FEWER, "an empty row of a billion": NO_BODY,
    "many layers": FEWER, "too many outlines in outlines": "too many outlines", "many outlines": FEWER,
    "many polylines": FEWER, "a spiral": "without crossing",
}  # fmt: skip


LASTING = (  # seconds of reading; the others have each of their forms in smaller numbers
    "a million bulges", "as many bulges and circles", "lines that close nothing", "too many lines", "many outlines",
)  # fmt: skip


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.long) if name in LASTING else name for name in HUGE]
)
def test_huge_drawings_take_no_longer(name):
    text = HUGE[name]()
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    assert settled(read_dxf, text) == ("refused" if name in REFUSED else "read")
    if name in REFUSED:
        with pytest.raises(rt.InputError, match=REFUSED[name]):
            read_dxf(text, "x.drawing", Assumptions())
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 500_000  # kB


def test_every_cut_of_a_drawing_is_refused():
    text = dxf_of(rt.example("slider_crank"))[0]
    lines = text.split("\n")
    for k in range(0, len(lines) - 3, 37):
        assert settled(read_dxf, "\n".join(lines[:k])) == "refused"
