"""The viewer as one text: joined in the right order, and nothing named twice."""

import re

import pytest

from rattle.pages.compact import compact
from rattle.pages.viewer_text import declarations, joined, viewer_files, viewer_text

pytestmark = [pytest.mark.nojit, pytest.mark.plain]


def test_files_are_joined_after_what_they_import():
    files = {
        "a.js": 'import { b } from "./b.js";\n// a note\nexport function a() {\n  return b + 1;\n}\n',
        "b.js": "export const b = 1;\n",
    }
    assert joined(files, "a.js") == "export const b=1;\nexport function a(){\nreturn b+1;\n}\n"


B = "export const b = 1;\n"


@pytest.mark.parametrize(
    ("files", "said"),
    [
        ({"a.js": 'import { b } from "./b.js";\nconst c = 1;\n', "b.js": B + "const d = 1, c = 2;\n"}, "c is declared"),
        ({"a.js": 'import { d } from "./b.js";\n', "b.js": B}, "does not export it"),
        ({"a.js": 'import { b } from "./c.js";\n'}, "which is not there"),
        ({"a.js": 'import b from "https://x.org/b.js";\n'}, "imports are written"),
        (
            {"a.js": 'import { b } from "./b.js";\nexport const a = 1;\n', "b.js": 'import { a } from "./a.js";\n' + B},
            "in a circle",
        ),
    ],
)
def test_what_cannot_be_joined_is_said(files, said):
    with pytest.raises(ValueError, match=said):
        joined(files, "a.js")


def test_declarations_are_found_several_on_one_line_too():
    text = (
        "export const a = f(1, 2), b = [3, 4];\nlet c = (d) => d;\nasync function e() {}\n"
        "class G {}\n  const inner = 1;\n"
    )
    assert declarations(text) == ["a", "b", "c", "e", "G"]


TRICKY = r"""
// a comment with "a text" in it
const a = [], b = 'it // is', c = "so \" /* not */ "; /* a comment
over lines */ let d = 7 /* between */ - -1, e = d++ + +1;
const f = (x) => x / 2 / 1, g = "a/b c".replace(/[/ "']+/g, "-");
const h = `t ${ [1, 2].map((y) => `<${ y }>`).join(" , ") } // end`;
a.push(b, c, d, e, f(6), g, h)
console.log(JSON.stringify(a))
"""


def test_a_compact_program_does_the_same(viewer_in_node):
    text = compact(TRICKY)
    assert len(text) < len(TRICKY) - 40
    assert viewer_in_node(text) == viewer_in_node(TRICKY)


def test_files_stay_readable():
    for name, text in viewer_files().items():
        lines = text.splitlines()
        assert len(lines) <= 400, f"{name} has {len(lines)} lines"
        if name != "style.js":
            assert lines[0].startswith("// "), f"{name} does not say what it is"


def test_viewer_asks_for_nothing_from_outside():
    text = viewer_text().replace("http://www.w3.org/2000/svg", "")
    assert not re.search(r"https?://|\beval\(|new Function|importScripts|@import|fetch\(", text)


def test_readouts_keep_their_digits_however_small_the_curve(viewer_in_node):
    said = viewer_in_node(
        """
import { steady } from "./viewer.mjs";
const small = [[0.00123456, 0.00123456], [0.00123456, -0.0004], [3e-7, 3e-7]];
const cases = [...small, [0.5, 0.25], [12.5, 12.5], [45870, 45870.4], [0, 0]];
console.log(JSON.stringify(cases.map(([most, value]) => steady(most)(value).trim())));
"""
    )
    minus = "\N{MINUS SIGN}"
    assert said == ["0.001235", f"{minus}0.000400", f"3.00e{minus}7", "0.2500", "12.50", "45870", "0.000"]
