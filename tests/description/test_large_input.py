"""Small texts that could cost much are answered in time and memory that grow with their size, not with its square."""

import tracemalloc

import numpy as np
import pytest

import rattle as rt
from rattle.description.dependence import describe_cycle, in_order
from rattle.description.toml_locations import locate, locate_all

pytestmark = [pytest.mark.nojit, pytest.mark.plain]
WORK = 75  # calls of Python functions per character at most: linear reading makes about 15, quadratic thousands
MEMORY = 300e6  # bytes


def parameters(lines):
    return "format = 1\n[parameters]\n" + "\n".join(lines)


MANY = 1500
TEXTS = {
    "a key of 1500 parts": "x" + ".a" * MANY + " = 1",
    "the same in an inline table": "x = {" + "a." * MANY + "a = 1}",
    "the same in quotes": "x" + '."a"' * MANY + " = 1",
    "a header of 1500 parts": "[x" + ".a" * MANY + "]",
    "cycles through all": parameters(f'p{n} = "p{n + 1}+p0"' for n in range(MANY)),
    "a chain": parameters([*(f'p{n} = "p{n + 1}+1"' for n in range(MANY)), f"p{MANY} = 1"]),
    "unknown names": parameters(f'p{n} = "q{n}+1"' for n in range(MANY)),
    "mistakes at the end": parameters([*(f"p{n} = {n}" for n in range(MANY)), *(f'w{n} = "5 zz"' for n in range(49))]),
    "long names": parameters([*("n" * 100_000 + f"{n} = 1" for n in range(10)), 'x = "nn"']),
}


@pytest.mark.parametrize("case", TEXTS)
def test_work_and_memory_grow_with_the_text_and_not_with_its_square(case):
    import sys

    text, calls = TEXTS[case], 0

    def count(frame, event, argument):
        nonlocal calls
        calls += 1

    tracemalloc.start()
    sys.setprofile(count)
    try:
        with pytest.raises(rt.ModelError) as caught:
            rt.loads(text)
    finally:
        sys.setprofile(None)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
    assert calls < WORK * len(text)
    assert peak < MEMORY
    assert len(str(caught.value)) < 20_000


def test_dots_that_are_no_keys_are_read():
    dots = "a." * 40
    text = f'format = 1\nname = "{dots}a"  # {dots}a ......................\n[bodies.a]\nmass = 1\ninertia = 1\n'
    assert rt.loads(text).name == f"{dots}a"
    many = f'name = """\n{dots}a\n"""\nformat = 1\n[bodies.a]\nmass = 1\ninertia = 1\n'
    assert rt.loads(many).name.strip() == f"{dots}a"


def test_expressions_without_end_are_refused():
    text = parameters(f'p{n} = "{"+".join(["1.5"] * 450)}"' for n in range(400))
    with pytest.raises(rt.ModelError, match="the expressions have more than 600000 characters in all"):
        rt.loads(text)


def test_texts_of_very_many_entries_are_refused():
    for text in ("a = 1\n" * 200_001, "[a.b]\n" * 100_001, '{"a": ' + ",".join(['{"a": 1}'] * 200_001) + "}"):
        with pytest.raises(rt.ModelError, match="a model has at most 200000"):
            rt.loads(text)


def test_names_are_quoted_short():
    with pytest.raises(rt.ModelError) as caught:
        rt.loads("format = 1\n" + "x" * 1_000_000 + " = 1\n")
    assert len(str(caught.value)) < 2000


# ---------------------------------------------------------------- the two algorithms behind it
def test_order_and_cycles_of_random_definitions():
    """Against a slow search: nothing stands before what it uses, and what is left out leads to itself."""
    from rattle.language.syntax import parse

    rng = np.random.default_rng(5)
    for _ in range(60):
        count = int(rng.integers(1, 9))
        uses = {f"p{n}": [f"p{k}" for k in np.flatnonzero(rng.random(count) < 0.25)] for n in range(count)}
        order, cycles = in_order({name: parse("+".join(["1", *found])) for name, found in uses.items()})
        assert len(set(order)) == len(order)
        for n, name in enumerate(order):
            assert all(one in order[:n] or one not in order for one in uses[name])
        for cycle in cycles:
            assert all(b in uses[a] for a, b in zip(cycle, [*cycle[1:], cycle[0]], strict=True))
            assert not set(cycle) & set(order)
        left = uses.keys() - set(order)
        assert left == {name for cycle in cycles for name in cycle}
        for start in left:
            reached, ahead = set(), list(uses[start])
            while ahead:
                one = ahead.pop()
                if one not in reached:
                    reached.add(one)
                    ahead += uses[one]
            assert start in reached


def test_a_long_cycle_is_shown_short():
    from rattle.language.syntax import parse

    _, (cycle,) = in_order({f"p{n}": parse(f"p{(n + 1) % 500}") for n in range(500)})
    assert len(describe_cycle(cycle)) < 200


def test_many_places_are_found_in_one_pass_as_one_by_one():
    text = (
        'a = 1\n[b]\nc.d = [1, {e = 2}, 3]\n"x y" = 4\n[[f]]\ng = 1\n[[f]]\ng = [[5, 6], 7]\n[h.i]\nj = 2\n[h]\nk = 3\n'
    )
    paths = [
        ("a",), ("b",), ("b", "c"), ("b", "c", "d", 1, "e"), ("b", "x y"), ("f", 1, "g", 0, 1), ("f", 0, "g"), ("f",),
        ("h",), ("h", "k"), ("h", "i", "none"), ("none",), ("b", "c", "d", 7), ("f", 1, "none"),
    ]  # fmt: skip
    wanted = [(path, key) for path in paths for key in (False, True)]
    assert locate_all(text, wanted) == [locate(text, path, key) for path, key in wanted]
    assert locate(text, ("f", 1, "g", 0, 1)) == (8, 10)
    assert locate(text, ("b", "c", "d", 1, "e")) == (3, 16)
