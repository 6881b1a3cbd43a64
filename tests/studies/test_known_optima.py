"""Searches with several constraints end at optima known from the literature, and say so only there.

Source: Hock, Schittkowski, Test Examples for Nonlinear Programming Codes (1981); numbers of problems as there.
"""

import math

import numpy as np
import pytest
import scipy.optimize

import rattle as rt
from rattle.errors import ModelError

CLOSE = 1e-7  # share of an optimum; constraints are met within 1e-7 of their sizes


def formula(text, start):
    """A mechanism whose signal y is a formula of parameters x1, x2 ..."""
    m = rt.Mechanism("formula").ground(O=[0, 0])
    for k, x in enumerate(start):
        m = m.parameter(f"x{k + 1}", float(x))
    m = m.body("b", mass=1, inertia=1, points={"C": [0, 0]}).revolute("p", "ground.O", "b.C")
    return m.driver("d", joint="p", angle="t").signal("y", text)


def optimum(text, bounds, constraints, start):
    vary = {f"x{k + 1}": one for k, one in enumerate(bounds)}
    return formula(text, start).optimise("final(y)", vary, constraints, t_end=1.0, analysis="kinematics", starts=1)


ROSEN_SUZUKI = (
    "x1**2 + x2**2 + 2*x3**2 + x4**2 - 5*x1 - 5*x2 - 21*x3 + 7*x4",
    [(-10, 10)] * 4,
    [
        "8 - x1**2 - x2**2 - x3**2 - x4**2 - x1 + x2 - x3 + x4 >= 0",
        "10 - x1**2 - 2*x2**2 - x3**2 - 2*x4**2 + x1 + x4 >= 0",
        "5 - 2*x1**2 - x2**2 - x3**2 - 2*x1 + x2 + x4 >= 0",
    ],
)
PROBLEMS = {  # objective, bounds, constraints, optimum, starts
    "two straight lines": (
        "-(x1 + x2)", [(0, 5)] * 2, ["x1 + 2*x2 <= 4", "3*x1 + x2 <= 6"], -2.8, [(0.5, 0.5), (0, 0), (5, 5)],
    ),
    "HS6": ("(1 - x1)**2", [(-10, 10)] * 2, ["10*(x2 - x1**2) == 0"], 0.0, [(-1.2, 1), (3, -2)]),
    "HS7": (
        "log(1 + x1**2) - x2", [(-10, 10)] * 2, ["(1 + x1**2)**2 + x2**2 == 4"], -math.sqrt(3), [(2, 2), (0.5, 1)],
    ),
    "HS21": (
        "0.01*x1**2 + x2**2 - 100", [(2, 50), (-50, 50)], ["10*x1 - x2 >= 10"], -99.96, [(2, -1), (30, 20)],
    ),
    "HS26": (
        "(x1 - x2)**2 + (x2 - x3)**4", [(-10, 10)] * 3, ["(1 + x2**2)*x1 + x3**4 == 3"], 0.0, [(-2.6, 2, 2)],
    ),
    "HS35": (
        "9 - 8*x1 - 6*x2 - 4*x3 + 2*x1**2 + 2*x2**2 + x3**2 + 2*x1*x2 + 2*x1*x3", [(0, 10)] * 3,
        ["x1 + x2 + 2*x3 <= 3"], 1 / 9, [(0.5, 0.5, 0.5), (0, 0, 0)],
    ),
    "HS39": (
        "-x1", [(-10, 10)] * 4, ["x2 - x1**3 - x3**2 == 0", "x1**2 - x2 - x4**2 == 0"], -1.0, [(2, 2, 2, 2)],
    ),
    "HS40": (
        "-x1*x2*x3*x4", [(-10, 10)] * 4, ["x1**3 + x2**2 == 1", "x1**2*x4 == x3", "x4**2 == x2"], -0.25,
        [(0.8, 0.8, 0.8, 0.8)],
    ),
    "HS43": (*ROSEN_SUZUKI, -44.0, [(0, 0, 0, 0), (0.1, 0.1, 0.1, 0.1), (1, 1, 1, -1), (3, -4, 5, 2)]),
    "HS71": (
        "x1*x4*(x1 + x2 + x3) + x3", [(1, 5)] * 4,
        ["x1*x2*x3*x4 >= 25", "x1**2 + x2**2 + x3**2 + x4**2 == 40"], 17.0140173, [(1, 5, 5, 1), (2, 2, 2, 2)],
    ),
    "HS76": (
        "x1**2 + 0.5*x2**2 + x3**2 + 0.5*x4**2 - x1*x3 + x3*x4 - x1 - 3*x2 + x3 - x4", [(0, 10)] * 4,
        ["x1 + 2*x2 + x3 + x4 <= 5", "3*x1 + x2 + 2*x3 - x4 <= 4", "x2 + 4*x3 >= 1.5"], -4.681818182,
        [(0.5, 0.5, 0.5, 0.5), (0, 0, 0, 0)],
    ),
    "HS100": (
        "(x1 - 10)**2 + 5*(x2 - 12)**2 + x3**4 + 3*(x4 - 11)**2 + 10*x5**6 + 7*x6**2 + x7**4 - 4*x6*x7 - 10*x6 - 8*x7",
        [(-10, 12)] * 7,
        [
            "2*x1**2 + 3*x2**4 + x3 + 4*x4**2 + 5*x5 <= 127",
            "7*x1 + 3*x2 + 10*x3**2 + x4 - x5 <= 282",
            "23*x1 + x2**2 + 6*x6**2 - 8*x7 <= 196",
            "4*x1**2 + x2**2 - 3*x1*x2 + 2*x3**2 + 5*x6 - 11*x7 <= 0",
        ],
        680.6300573, [(1, 2, 0, 4, 0, 1, 1)],
    ),
}  # fmt: skip


@pytest.mark.parametrize(
    ("name", "start"), [(name, start) for name, problem in PROBLEMS.items() for start in problem[-1]]
)
def test_known_optima_with_several_constraints(name, start):
    text, bounds, constraints, least, _ = PROBLEMS[name]
    o = optimum(text, bounds, constraints, start)
    assert o.success, o.report
    assert abs(o.value - least) < CLOSE * max(1.0, abs(least)), o.report
    assert o.runs < 200  # thousands are burned where a routine is given wrong gradients


@pytest.mark.parametrize("extra", [["x1 <= 4"], ["x1 >= -9", "x2 + x3 <= 15"]])
def test_a_constraint_that_is_never_active_changes_nothing(extra):
    text, bounds, constraints = ROSEN_SUZUKI
    for chosen in (constraints[:1], constraints[1:]):
        alone, beside = (optimum(text, bounds, [*chosen, *more], (0.1,) * 4) for more in ([], extra))
        assert alone.success
        assert beside.success
        assert abs(alone.value - beside.value) < CLOSE * abs(alone.value)


def test_random_quadratic_problems_with_lines_as_constraints():
    """Against all combinations of active constraints, each solved as linear equations."""
    rng = np.random.default_rng(7)
    for _ in range(4):
        n, m = 3, 4
        root = rng.normal(size=(n, n))
        H, g, a, b = root @ root.T + 0.5 * np.eye(n), rng.normal(size=n), rng.normal(size=(m, n)), rng.uniform(1, 2, m)
        text = " + ".join([f"({H[i, j] / 2:.17g})*x{i + 1}*x{j + 1}" for i in range(n) for j in range(n)])
        text += "".join(f" + ({g[i]:.17g})*x{i + 1}" for i in range(n)) + " - 50"
        sums = [" + ".join(f"({a[k, i]:.17g})*x{i + 1}" for i in range(n)) for k in range(m)]
        lines = [f"{left} <= {0.3 * right:.17g}" for left, right in zip(sums, b, strict=True)]
        o = optimum(text, [(-20, 20)] * n, lines, (0, 0, 0))
        assert o.success, o.report
        assert abs(o.value - least_by_active_sets(H, g, a, 0.3 * b) + 50) < 1e-6


def least_by_active_sets(H, g, a, b):
    n, m = len(g), len(b)
    best = math.inf
    for mask in range(2**m):
        on = [k for k in range(m) if mask >> k & 1]
        if len(on) > n:
            continue
        A = a[on]
        kkt = np.block([[H, A.T], [A, np.zeros((len(on),) * 2)]])
        x = np.linalg.lstsq(kkt, np.concatenate([-g, b[on]]), rcond=None)[0][:n]
        if (a @ x <= b + 1e-9).all():
            best = min(best, x @ H @ x / 2 + g @ x)
    return best


@pytest.mark.parametrize(
    "constraints", [["x1 + x2 >= 12", "x1 - x2 <= 1"], ["x1 + x2 == 12"], ["x1 == x2", "x1 + 2 <= x2"]]
)
@pytest.mark.parametrize("objective", ["x1 + x2", "-(x1 + x2)"])
def test_constraints_that_exclude_each_other_are_never_a_success(objective, constraints):
    o = optimum(objective, [(0, 5)] * 2, constraints, (1, 2))
    assert not o.success
    assert not o.feasible
    assert "NO DESIGN" in o.report


def test_an_equation_holds_and_says_what_its_right_side_is_worth():
    o = optimum("x1**2 + 2*x2**2", [(-5, 5)] * 2, ["x1 + x2 == 3"], (0, 0))
    assert o.success
    assert abs(o.values["x1"] - 2.0) < 1e-6  # 2 x1 = 4 x2 = y, x1 + x2 = 3: y = 4
    assert "the objective by 4," in o.report
    assert "equation" not in o.report


@pytest.mark.parametrize("shift", [-1e3, 0.0, 10.0])
def test_a_search_that_ends_early_is_no_success_whatever_the_sign_of_the_objective(shift, monkeypatch):
    real = scipy.optimize.minimize

    def lazy(fun, x0, **given):
        done = real(fun, x0, **given)
        done.x, done.status = np.asarray(x0), 0
        return done

    def stop(fun, x0, **given):
        """A routine that looks nowhere else and calls it a success."""
        fun(np.asarray(x0))
        return scipy.optimize.OptimizeResult(x=np.asarray(x0), status=0, message="")

    monkeypatch.setattr(scipy.optimize, "minimize", stop)
    o = optimum(f"-(x1 + x2) + {shift}", [(0, 5)] * 2, ["x1 + 2*x2 <= 4", "3*x1 + x2 <= 6"], (0.5, 0.5))
    assert not o.success
    monkeypatch.setattr(scipy.optimize, "minimize", lazy)
    o = optimum(f"-(x1 + x2) + {shift}", [(0, 5)] * 2, ["x1 + 2*x2 <= 4", "3*x1 + x2 <= 6"], (0.5, 0.5))
    assert o.success  # it looked at the optimum, whatever it says


def test_routines_outside_get_numbers_side_by_side(monkeypatch):
    """Every array that they are handed or that a function hands them is float64 in C's order."""
    seen = []

    def check(values):
        if isinstance(values, np.ndarray):
            seen.append(values)
            assert values.flags.c_contiguous
            assert values.dtype == np.float64
        return values

    def watched(function):
        return (lambda *given: check(function(*given))) if callable(function) else check(function)

    def spy(routine):
        def call(*given, **named):
            if "constraints" in named:
                named["constraints"] = [{key: watched(x) for key, x in one.items()} for one in named["constraints"]]
            given = [watched(one) for one in given]
            return routine(*given, **{key: watched(x) if key == "jac" else x for key, x in named.items()})

        return call

    for name in ("minimize", "least_squares", "nnls"):
        monkeypatch.setattr(scipy.optimize, name, spy(getattr(scipy.optimize, name)))
    assert optimum(*PROBLEMS["HS71"][:3], (1, 5, 5, 1)).success
    assert optimum(*PROBLEMS["HS40"][:3], (0.8, 0.8, 0.8, 0.8)).success
    vary, missed = {"x1": (-3, 3), "x2": (-2, 2)}, "(final(y) - 0.1)**2 + (at(y, 0.5) - x2)**2"
    assert formula("x1*t + x2", (0, 0)).optimise(missed, vary, t_end=1.0, analysis="kinematics", starts=1).success
    assert len(seen) > 50


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("share(b.angle == 0) <= 0.5", "between two outputs"),
        ("x1 == 1 == x2", "="),
        ("x1 + (x2 == 3)", "between two outputs"),
        ("final(y) = 3", "="),
    ],
)
def test_equations_stand_between_outputs(text, words):
    with pytest.raises(ModelError, match=words):
        optimum("x1 + x2", [(0, 5)] * 2, [text], (1, 2))


@pytest.mark.long
def test_a_damper_at_the_bound_of_a_constraint_is_a_success():
    """The integral of x^2 of x'' + c x' + k x = 0 from x = 1 is 1/(2 c) + c/(2 k), least at c = sqrt(k)."""
    text = """
    format = 1
    [parameters]
    c = 0.3
    [ground.points]
    O = [0, 0]
    [bodies.b]
    points = { P = [0, 0] }
    mass = 1
    inertia = 1
    [joints.g]
    type = "prismatic"
    connect = ["ground.O", "b.P"]
    [loads.s]
    type = "spring"
    connect = ["ground.O", "b.P"]
    stiffness = 5
    damping = "c"
    free_length = 0
    [initial]
    b = { x = 1, vx = 0 }
    """
    for conditions in (["c <= 0.8"], ["c <= 0.8", "c <= 2.9"], ["c == 0.8"]):
        o = rt.loads(text).optimise("integral(b.x**2)", {"c": (0.1, 3)}, conditions, t_end=20.0, starts=1)
        assert o.success, o.report
        assert abs(o.value - 0.705) < 1e-6  # exp(-0.8*20) is left, and outputs are 20/400 s apart


@pytest.mark.parametrize(
    ("low", "high", "start"),
    [
        pytest.param(0.1, 1e5, 1.0, marks=pytest.mark.long),
        pytest.param(0.1, 1e5, 2.0, marks=pytest.mark.long),
        pytest.param(1e-3, 10.0, 2e-3, marks=pytest.mark.long),
        (1e-3, 1e3, 0.01),
    ],
)
def test_ranges_of_decades_end_at_the_optimum_or_are_no_success(low, high, start):
    limit = 4.0 / math.sqrt(low * high)
    found = optimum("x1", [(low, high)], [f"4/x1 <= {limit!r}"], [start])
    assert not found.success or found.value == pytest.approx(4.0 / limit, rel=1e-6)
    several = formula("x1", [start]).optimise(
        "final(y)", {"x1": (low, high)}, [f"4/x1 <= {limit!r}"], t_end=1.0, analysis="kinematics", starts=5
    )
    assert several.success
    assert several.value == pytest.approx(4.0 / limit, rel=1e-6)


@pytest.mark.long
def test_problem_72_over_six_decades():
    limits = ["4/x1 + 2.25/x2 + 1/x3 + 0.25/x4 <= 0.0401", "0.16/x1 + 0.36/x2 + 0.64/x3 + 0.64/x4 <= 0.010085"]
    bounds = {f"x{k + 1}": (0.001, (5 - (k + 1)) * 1e5) for k in range(4)}
    found = formula("1 + x1 + x2 + x3 + x4", [1.0] * 4).optimise(
        "final(y)", bounds, limits, t_end=1.0, analysis="kinematics", starts=5
    )
    assert found.success
    assert found.value == pytest.approx(727.67937, rel=1e-5)


@pytest.mark.long
def test_a_check_that_misses_a_constraint_confirms_nothing():
    """The spike of y is narrower than the outputs: finer ones, as the check has, see it."""
    m = formula("x1*exp(-((t - 0.50125)/4e-4)**2)", [0.5]).signal("z", "-x1")
    found = m.optimise("final(z)", {"x1": (0, 5)}, ["max(y) <= 1"], t_end=1.0, analysis="kinematics", starts=1)
    assert found.check.numbers[1] >= -1e-4 or not found.confirmed
