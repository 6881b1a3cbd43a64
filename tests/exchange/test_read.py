"""Which program a file is of says its content; whatever a file holds, it is read or refused in words, and soon."""

import random
import re
import tracemalloc
from contextlib import suppress

import pytest

import rattle as rt
from foreign_texts import DIGITS, fourbar, pmks_fourbar, pylinkage
from rattle.errors import InputError
from rattle.exchange.imported import Assumptions, Imported
from rattle.exchange.names import Names, counted, listed
from rattle.exchange.read import mechanism, read_import
from rattle.exchange.writing import text_of

ASMT, LINK, JSON = fourbar().text(), f"pmks:{pmks_fourbar()}", pylinkage()
MODEL = rt.examples()["slider_crank"].read_text(encoding="utf-8")
MEMORY = 300e6  # bytes


@pytest.fixture
def file(tmp_path):
    """Write a file and give its path."""

    def write(content, name="a.txt"):
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return write


@pytest.mark.parametrize(("text", "bodies"), [
    (ASMT, {"Part1", "Part2", "Part3"}), (LINK, {"AB", "BC", "CD"}), (JSON, {"crank", "rod", "rocker"}),
    (MODEL, {"crank", "rod", "slider"}), (rt.loads(MODEL).to_json(), {"crank", "rod", "slider"}),
])  # fmt: skip
@pytest.mark.parametrize("name", ["a.txt", "a", "a.asmt", "a.toml", "a.json"])
def test_the_content_says_what_a_file_is(file, text, bodies, name):
    assert set(rt.read(file(text, name)).model.bodies) == bodies


def test_a_file_that_is_read_can_be_saved_and_loaded(file, tmp_path):
    m = rt.read(file(LINK))
    m.save(tmp_path / "m.toml")
    again = rt.load(tmp_path / "m.toml")
    assert again.to_toml() == m.to_toml()
    assert "a.txt" in again.to_toml().splitlines()[0]


def test_what_is_stated_may_have_a_unit(file):
    path = file(JSON)
    a, b = rt.read(path, scale="1 cm", steps_per_second=50), rt.read(path, scale=0.01, steps_per_second="50")
    assert a.to_toml() == b.to_toml()


@pytest.mark.parametrize(("stated", "says"), [
    ({"scale": "1 kg"}, "scale"), ({"scale": 0}, "positive"), ({"scale": float("nan")}, "positive"),
    ({"steps_per_second": -1}, "positive"), ({"thickness": "5 mm"}, "thickness"), ({"scale": "x"}, "scale"),
])  # fmt: skip
def test_what_cannot_be_stated_is_refused(file, stated, says):
    with pytest.raises(InputError, match=says):
        rt.read(file(JSON), **stated)


def test_what_a_format_says_itself_cannot_be_stated(file):
    with pytest.raises(InputError, match="links of PMKS"):
        rt.read(file(LINK), scale=0.1)
    with pytest.raises(InputError, match="model file"):
        rt.read(file(MODEL), scale=0.1)


@pytest.mark.parametrize(("content", "says"), [
    (b"", "empty"), (b"  \n", "empty"), (b"hello\nworld", "hello"), (b"PK\x03\x04rest", "zip"),
    (b"\x7fELF\0\0", "byte 0"), (b"AutoCAD Binary DXF\r\n\x1a\0", "ASCII DXF"), (b"AC1027\0\0", "DWG"),
    ("freeCAD".encode("utf-16"), "UTF-16"),
    (b"<?xml version='1.0'?><!DOCTYPE a [<!ENTITY b SYSTEM 'file:///etc/passwd'>]><a>&b;</a>", "xml"),
])  # fmt: skip
def test_what_no_reader_knows_is_refused(file, content, says):
    with pytest.raises(rt.ModelError, match=rf"^[^\n]*{says}[^\n]*$"):
        rt.read(file(content))


@pytest.mark.parametrize("name", ["a.asmt", "a.pmks", "a.json"])
def test_a_file_of_another_kind_is_refused_by_its_ending(file, name):
    with pytest.raises(rt.ModelError, match=r"a\.(asmt|pmks|json)"):
        rt.read(file("<html lang='en'/>", name))


def test_a_file_that_is_not_there_and_a_name_that_is_none_are_refused(tmp_path):
    with pytest.raises(rt.ModelError, match="cannot read the file"):
        rt.read(tmp_path / "none.asmt")
    with pytest.raises(TypeError):
        rt.read(3)


def test_letters_of_older_programs_are_read(file):
    text = ASMT.replace("Part2", "Größe").encode("latin-1")
    assert len(rt.read(file(text)).model.bodies) == 3


def test_a_mechanism_that_no_model_can_be_is_refused_in_one_line():
    bad = Imported({"format": 1, "bodies": {"a": {"points": {}, "mass": -1.0, "inertia": -1.0}}}, "from a.asmt")
    with pytest.raises(rt.ModelError, match=r"^a\.asmt: [^\n]*bodies\.a\.mass[^\n]*1 more[^\n]*$"):
        mechanism(bad, "a.asmt")


# ---------------------------------------------------------------- names and text
def test_names_are_valid_free_and_not_reserved():
    names = Names()
    words = ["in", "in", "1", "", "Größe 2", "a.b", "a-b", "t", "日本", "ground", "x" * 200]
    new = [names.new(word, "body") for word in words]
    assert new == ["in_", "in__2", "body_1", "body", "Groe_2", "a_b", "a_b_2", "t_", "body_2", "ground_", "x" * 60]
    assert len(names.changed) == len(words)


def test_lists_of_names_are_short():
    assert listed("abc") == "a, b, c"
    assert listed(map(str, range(20)), 2) == "0, 1 and 18 more"
    assert [counted(n, word) for n, word in ((1, "body"), (2, "body"), (3, "link"))] == [
        "1 body",
        "2 bodies",
        "3 links",
    ]


def test_a_comment_stays_a_comment():
    text = text_of(Imported({"format": 1}, "from a\nformat = 2\r.asmt", (), ("b\nc = 1",), ("\x1b[2J",)))
    assert all(line.startswith("#") for line in text.split("\n\n")[0].splitlines())
    assert "\x1b" not in text


# ---------------------------------------------------------------- hostile files
HOSTILE = {
    "blanks": " " * 7_900_000,
    "line breaks": "\n" * 7_900_000 + "x",
    "tabs": ASMT[:200] + "\t" * 7_900_000,
    "lines": "OndselSolver\nAssembly\n" + "\tx\n" * 2_000_000,
    "steps deeper": "OndselSolver\nAssembly\n" + "".join("\t" * k + "x\n" for k in range(3900)),
    "a row of numbers": ASMT.replace("0.4\n", "1 " * 3_900_000 + "\n", 1),
    "a sum": ASMT.replace("2.0d*pi*time", "1+" * 3_900_000),
    "parentheses": ASMT.replace("2.0d*pi*time", "(" * 3_900),
    "quotes": ASMT.replace("2.0d*pi*time", '"' * 3_999),
    "brackets": "[" * 7_900_000,
    "braces": '{"a":' * 1_500_000,
    "a list": '{"joints":[' + "1," * 3_900_000 + "1]}",
    "an id": '{"joints": [{"id": "' + "x" * 7_900_000 + '"}], "links": []}',
    "digits": '{"joints": ' + "9" * 7_900_000 + "}",
    "a link": "pmks:" + "A" * 7_900_000,
    "an address": "https://" + "?" * 7_900_000,
    "percent signs": "https://a?" + "%41" * 19_000,
    "comments": "999\n" * 1_900_000 + "x",
    "too much": "x" * 8_000_001,
}


@pytest.mark.parametrize("name", HOSTILE)
def test_a_hostile_file_is_refused_in_few_words(file, name):
    path = file(HOSTILE[name])  # work that grows with the square of its size would take hours
    with pytest.raises(InputError) as caught:
        read_import(path, Assumptions())
    assert len(str(caught.value)) < 1000


@pytest.mark.parametrize("name", ["lines", "steps deeper"])
def test_a_hostile_file_takes_little_memory(file, name):
    path = file(HOSTILE[name])
    tracemalloc.start()
    with pytest.raises(InputError):
        read_import(path, Assumptions())
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < MEMORY


def mutated(rng: random.Random, text: str) -> str:
    """The text with a piece cut, doubled, exchanged or put in."""
    for _ in range(rng.randrange(1, 4)):
        at = rng.randrange(len(text) + 1)
        end, way = min(len(text), at + rng.randrange(1, 40)), rng.randrange(6)
        if way == 0:
            text = text[:at]
        elif way == 1:
            text = text[:at] + text[end:]
        elif way == 2:
            word = rng.choice(
                ["nan", "inf", "1e308", "-", "\t", "\n", "{", "[", '"', "é", "😀", "1e-320", "0", "9" * 30]
            )
            text = text[:at] + word + text[rng.choice([at, end]) :]
        elif way == 3:
            text = text[:at] + text[at:end] * rng.randrange(2, 5) + text[end:]
        elif way == 4:
            lines = text.split("\n")
            a, b = (rng.randrange(len(lines)) for _ in range(2))
            lines[a], lines[b] = lines[b], lines[a]
            text = "\n".join(lines)
        elif numbers := list(re.finditer(r"-?\d+\.?\d*", text)):
            number = rng.choice(numbers)
            word = rng.choice(["0", "-1", "1e30", "1e-30", "3.3", "-0.0", "1e15", "NaN", "Infinity"])
            text = text[: number.start()] + word + text[number.end() :]
    return text


@pytest.mark.parametrize("text", [ASMT, LINK, JSON], ids=["asmt", "pmks", "pylinkage"])
@pytest.mark.parametrize("seed", range(4))
def test_files_that_were_damaged_are_read_or_refused_in_words(file, text, seed):
    rng = random.Random(seed)
    for _ in range(40):
        damaged = mutated(rng, text)
        if text is LINK and len(damaged) > 6 and rng.random() < 0.7:  # with a check, so that more than that is met
            damaged = damaged[:-1] + DIGITS[len(damaged[5:-1].encode("utf-16-le")) // 2 % 62]
        path = file(damaged, rng.choice(["a.txt", "a.asmt", "a.pmks", "a.json"]))
        with suppress(InputError):
            assert mechanism(read_import(path, Assumptions()), str(path)).model.bodies
