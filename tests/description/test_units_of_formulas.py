"""Units of formulas: checked where somebody gave units; a formula never passes by being more wrong."""

import itertools

import pytest

import rattle as rt

pytestmark = pytest.mark.nojit
PARAMETERS = {"k": "4 N/m", "c": "0.6 N*s/m", "w": "2 rad/s", "a": "3 mm", "bare": 2.0}


def read(force: str, **more: str) -> rt.Mechanism:
    """A mechanism with a force of this formula."""
    m = rt.Mechanism("formulas").ground(O=[0, 0])
    for name, given in PARAMETERS.items():
        m = m.parameter(name, given)
    for name, text in more.items():
        m = m.signal(name, text)
    m = m.body("b", mass=1, inertia=1, points={"P": [0, 0]}).prismatic("rail", "ground.O", "b.P")
    m = m.load("f", "force", at="b.P", force=[force, 0])
    assert m.model is not None
    return m


def passes(force: str, **more: str) -> bool:
    try:
        read(force, **more)
    except rt.ModelError:
        return False
    return True


@pytest.mark.parametrize(
    "force",
    [
        "-4*b.x - 0.6*b.vx",
        "b.x - b.x**3",
        "-b.x - 0.04*b.vx + cos(w*t)",
        "-b.x - 0.04*b.vx + cos(bare*t)",
        "b.x",
        "sin(b.x) - b.vx",
        "-sign(b.vx)*abs(b.vx)**1.5 + exp(-t)",
        "-k*b.x - c*b.vx",
        "-k*b.x - 0.6*b.vx + 2*cos(w*t)",
        "-k*a*sin(w*t) + 3 N",
        "b.vx if b.x > 0 else -b.x",
        "bare*b.x + b.vx",
        "t*b.x - t",
    ],
)
def test_ordinary_formulas_are_read(force):
    read(force)


@pytest.mark.parametrize(
    ("force", "words"),
    [
        ("-k*b.x - b.vx", "cannot subtract N and m/s"),
        ("-k*b.x + cos(w*t)", "cannot add N and a plain number"),
        ("k*(b.x + b.vx)", "cannot add m and m/s"),
        ("k*b.x*b.x", "expected a force"),
        ("3 N + b.x", "cannot add N and m"),
        ("2*sin(k*b.x)", "cannot take sin of N"),
        ("a", "is a length"),
        ("1 N if b.x > w else 0", "cannot compare m and 1/s"),
        ("k*rail.position + rail.rate", "cannot add N and m/s"),
    ],
)
def test_given_units_are_checked_and_both_are_named(force, words):
    with pytest.raises(rt.ModelError, match=words):
        read(force)


def test_one_more_wrong_term_never_makes_a_formula_pass():
    terms = ["k*b.x", "c*b.vx", "b.x", "b.vx", "b.x**2", "cos(w*t)", "0.5*b.x", "rail.rate", "3 N", "a", "k*b.vx"]
    for size in (1, 2):
        for chosen in itertools.combinations(terms, size):
            if passes(" + ".join(chosen)):
                continue
            for term in terms:
                more = " + ".join([*chosen, term])
                assert not passes(more), more


def test_signals_carry_what_was_given_and_nothing_else():
    assert not passes("stretch - b.vx", stretch="k*b.x")
    assert passes("odd - b.vx", odd="b.x - b.x**3")
    assert passes("plain - b.vx", plain="b.x")
    assert read("0*t", plain="b.x - a").model.recorded["plain"] == "m"
    assert read("0*t", plain="b.x + b.vx").model.recorded["plain"] == ""


def test_a_sum_of_many_terms_is_read():
    read(" + ".join(["b.x"] * 200))
