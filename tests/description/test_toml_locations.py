"""Positions in TOML texts: hand-made cases, and random documents with values that occur only once."""

import tomllib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rattle.description.toml_locations import caret, locate

pytestmark = [pytest.mark.nojit, pytest.mark.plain]

TEXT = '''\
# bodies.crank = 1 [not.a.table]
format = 1
name = "a # b = [c]" # comment

[parameters]
r3 = { value = "5 mm", min = 'x }', "t o l" = 3 }

  [ bodies . "crank" ]   # header
bar = [
  "O1", # first ]
  "O2",
]
length = "l1"

[bodies.coupler.points]
O2 = [[1, 2], [3.5, 1979-05-27 07:32:00], [-4, +inf]]
text = """
[bodies.rocker]
mass = 3 ""\\""" and " more""""
raw = \'\'\'
mass = 'x'
[bodies.rocker]\'\'\'
[bodies.rocker]
mass = 2
a.b . 'c d' = { e = 1, f.g = [ { h = 7 }, { h = 8 } ] }

[[loads]]
x = 1
[[loads.parts]]
y = 1
[loads.parts.deep]
z = 1
[[loads.parts]]
y = 2
[[loads]]
x = 2
[[loads.parts]]
y = 3
[last]
"ke\\u0079" = 1
'''


def _at(path, key=False):
    found = locate(TEXT, path, key)
    return None if found is None else (found[0], TEXT.splitlines()[found[0] - 1][found[1] - 1 :])


@pytest.mark.parametrize(
    ("path", "line", "start"),
    [
        (("format",), 2, "1"),
        (("name",), 3, '"a #'),
        (("parameters",), 5, "parameters]"),
        (("parameters", "r3"), 6, "{ value"),
        (("parameters", "r3", "value"), 6, '"5 mm"'),
        (("parameters", "r3", "min"), 6, "'x }'"),
        (("parameters", "r3", "t o l"), 6, "3 }"),
        (("bodies", "crank"), 8, '"crank" ]'),
        (("bodies", "crank", "bar"), 9, "["),
        (("bodies", "crank", "bar", 0), 10, '"O1"'),
        (("bodies", "crank", "bar", 1), 11, '"O2"'),
        (("bodies", "crank", "length"), 13, '"l1"'),
        (("bodies", "coupler"), 15, "coupler.points]"),
        (("bodies", "coupler", "points", "O2", 1), 16, "[3.5"),
        (("bodies", "coupler", "points", "O2", 1, 0), 16, "3.5"),
        (("bodies", "coupler", "points", "O2", 1, 1), 16, "1979"),
        (("bodies", "coupler", "points", "O2", 2, 1), 16, "+inf"),
        (("bodies", "rocker"), 23, "rocker]"),
        (("bodies", "rocker", "mass"), 24, "2"),
        (("bodies", "rocker", "a", "b"), 25, "b . "),
        (("bodies", "rocker", "a", "b", "c d"), 25, "{ e"),
        (("bodies", "rocker", "a", "b", "c d", "f", "g", 1, "h"), 25, "8 }"),
        (("loads",), 27, "loads]]"),
        (("loads", 0, "x"), 28, "1"),
        (("loads", 0, "parts", 0, "y"), 30, "1"),
        (("loads", 0, "parts", 0, "deep", "z"), 32, "1"),
        (("loads", 0, "parts", 1, "y"), 34, "2"),
        (("loads", 1), 35, "loads]]"),
        (("loads", 1, "x"), 36, "2"),
        (("loads", 1, "parts", 0, "y"), 38, "3"),
        (("last", "key"), 40, "1"),
        # not there: the nearest parent
        (("bodies", "rocker", "inertia"), 23, "rocker]"),
        (("bodies", "piston", "mass"), 8, "bodies"),
        (("bodies", "crank", "bar", 2), 9, "["),
        (("bodies", "crank", "bar", "x"), 9, "["),
        (("parameters", "r3", "dist"), 6, "{ value"),
        (("loads", 7), 27, "loads]]"),
        (("loads", 1, "parts", 1), 37, "parts]]"),
        (("format", "x"), 2, "1"),
    ],
)
def test_value_is_where_it_was_written(path, line, start):
    found = _at(path)
    assert found is not None
    assert (found[0], found[1][: len(start)]) == (line, start)


@pytest.mark.parametrize(
    ("path", "line", "start"),
    [
        (("format",), 2, "format"),
        (("bodies", "crank"), 8, '"crank"'),
        (("bodies", "rocker", "a", "b", "c d"), 25, "'c d'"),
        (("parameters", "r3", "t o l"), 6, '"t o l"'),
        (("bodies", "crank", "bar", 1), 11, '"O2"'),
        (("last", "key"), 40, '"ke'),
    ],
)
def test_key_is_where_it_was_written(path, line, start):
    found = _at(path, key=True)
    assert found is not None
    assert (found[0], found[1][: len(start)]) == (line, start)


def test_nothing_is_found_where_nothing_is():
    tomllib.loads(TEXT)  # the cases above are valid TOML
    assert locate(TEXT, ("springs", "x")) is None
    assert locate(TEXT, ()) is None
    assert locate("", ("a",)) is None
    assert locate("\ufeffa = 1", ("a",)) == (1, 6)
    assert locate("a = 1\r\nb = 2\r\n", ("b",)) == (2, 5)
    assert locate("x = {\n  a = 1, # comment\n  b = 2,\n}", ("x", "b")) == (3, 7)


# ---------------------------------------------------------------- random documents
_KEYS = ["a", "b-1", "c", "O3", "9", "x y", "q.r", 'say "hi"', "it's", "é", "[t]", "#"]


def _quoted(draw, key):
    bare = key.isascii() and key.replace("-", "").isalnum()
    styles = ["'" + key + "'"] if "'" not in key else []
    styles.append('"' + key.replace('"', '\\"') + '"')
    return draw(st.sampled_from([key] * 3 + styles if bare else styles))


_NOISE = ["", " ", "\t", "  "]
_COMMENTS = ["", "", " # x = [ {", " # ''' \"\"\""]
_DECOYS = [
    '"a = 1 # ]"',
    "'[a]'",
    '"""\n[a]\nb = "x" """',
    "'''\na = '\n'''",
    '"\\\\"',
    "''",
    '""""""',
    "1979-05-27 07:32:00",
]


class _Writer:
    """Writes random TOML; every number in it is a new one, so that its place is known."""

    def __init__(self, draw):
        self.draw = draw
        self.next = 10_000_000

    def pick(self, options):
        return self.draw(st.sampled_from(options))

    def keys(self):
        return self.draw(st.lists(st.sampled_from(_KEYS), unique=True, max_size=4))

    def entry(self, key, depth, inline=False):
        path = _quoted(self.draw, key)
        for _ in range(self.pick([0, 0, 0, 1])):
            path += self.pick(_NOISE) + "." + self.pick(_NOISE) + _quoted(self.draw, self.pick(_KEYS))
        return path + self.pick(_NOISE) + "=" + self.pick(_NOISE) + self.value(depth, inline)

    def value(self, depth, inline):
        kind = self.pick(["number"] * 3 + ["decoy"] + (["array", "inline"] if depth else []))
        if kind == "number":
            self.next += 1
            return str(self.next)
        if kind == "decoy":
            return self.pick(_DECOYS)
        if kind == "array":
            gap = [*_NOISE, "\n", " # ],\n\t"]
            items = [self.value(depth - 1, inline) for _ in range(self.pick([0, 1, 2, 3]))]
            body = ",".join(self.pick(gap) + item + self.pick(gap) for item in items)
            return "[" + body + (self.pick(["", ","]) if items else "") + self.pick(gap) + "]"
        return "{" + ",".join(" " + self.entry(key, depth - 1, True) + " " for key in self.keys()) + "}"

    def table(self, header, depth):
        lines = [self.entry(key, 2) + self.pick(_COMMENTS) for key in self.keys()]
        if header:
            spaced = (self.pick(_NOISE) + _quoted(self.draw, key) + self.pick(_NOISE) for key in header)
            inner = ".".join(spaced)
            lines.insert(0, self.pick(_NOISE) + self.pick([f"[{inner}]", f"[[{inner}]]"]) + self.pick(_COMMENTS))
        if depth:
            for key in self.keys():
                lines += self.table([*header, key], depth - 1)
        return lines


@st.composite
def _documents(draw):
    writer = _Writer(draw)
    return draw(st.sampled_from(["\n", "\r\n"])).join(writer.table([], 2)) + "\n"


def _leaves(value, path=()):
    if isinstance(value, dict | list):
        for key, inner in value.items() if isinstance(value, dict) else enumerate(value):
            yield from _leaves(inner, (*path, key))
    elif isinstance(value, int):
        yield path, value


@given(_documents())
def test_every_number_of_a_random_document_is_found(text):
    try:
        document = tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        return  # a key used twice
    for path, number in _leaves(document):
        at = text.index(str(number))
        expected = (text.count("\n", 0, at) + 1, at - text.rfind("\n", 0, at))
        assert locate(text, path) == expected
        assert locate(text, (*path, "missing")) == expected


@given(st.text(alphabet="ab.=[]{}\"'\\#,\n 1", max_size=200))
def test_any_text_is_scanned_to_an_end(text):
    found = locate(text, ("a", "b", 0))
    assert found is None or found <= (text.count("\n") + 1, len(text) + 1)


@pytest.mark.parametrize(
    "text",
    [
        "[" * 300_000,
        "a = " + "[" * 300_000,
        "a = " + "{a=" * 100_000,
        "a." * 150_000 + "a = 1",
        '"""' * 100_000,
        'b = """' + '\\"' * 150_000 + '"""\na = 1',
        "b = '''" + "''x" * 100_000 + "'''\na = 1",
        "b = [" + "1, " * 100_000 + "]\na = 1",
        "\n" * 300_000,
        " " * 300_000,
        "#" * 300_000,
        'b = "' * 60_000,
        "[bodies.x]\nmass = 1 # kg\npoints = { A = [0, 1], B = 'x' }\n" * 27_000,  # 1.5 MB
    ],
    ids=range(13),
)
def test_large_texts_take_a_second_or_two(text):
    locate(text, ("a", "a", 0, 0, "a"))  # ends while somebody waits: were it quadratic, it would take hours


def test_caret_stands_below_the_place():
    assert caret("a = 1\nbb = 22\n", 2, 6, 2) == "bb = 22\n     ^^"
    assert caret("\tbb = 22\r\n", 1, 7, 50) == "\tbb = 22\n\t     ^^"
    assert caret("x = 1", 1, 6) == "x = 1\n     ^"
    assert caret("x = 1", 7, 1) == ""
    assert caret("x\x1b = 1", 1, 1) == "x? = 1\n^"


def test_caret_shows_a_piece_of_a_long_line():
    text = "x" * 10_000 + "WRONG" + "y" * 10_000
    line, mark = caret(text, 1, 10_001, 5).splitlines()
    assert len(line) < 140
    assert line[mark.index("^") : mark.index("^") + 5] == "WRONG"
    assert mark.count("^") == 5
