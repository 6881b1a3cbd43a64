"""Outputs: what is read, what is refused, and their values against closed forms."""

import numpy as np
import pytest

from circling import OMEGA, STEADY, SWING, T_END, C, circling
from rattle.errors import ModelError
from rattle.language import arrays
from rattle.language.syntax import names
from rattle.results.evaluation import evaluate
from rattle.results.event import Event, Peak
from rattle.results.reductions import Known, argument, needed_instants, read, read_constraint
from rattle.results.result import Result
from rattle.results.trust import Trust

pytestmark = pytest.mark.nojit

PARAMETERS = {"T": 0.1, "F": 50.0, "p": 0.25}
UNITS = {"T": "s", "F": "N", "p": ""}
COARSE, FINE = 41, 4001  # 20 and 2000 samples a round
KNOWN = Known.of(circling(), UNITS)


def error(n):
    """Largest error of a cubic through four even samples of a unit circle: 2 rounds in n - 1 intervals, over 24."""
    return (4 * np.pi / (n - 1)) ** 4 / 24


def number(text, n=FINE, ideal=None):
    return evaluate(read(text, KNOWN), circling(n), PARAMETERS, ideal)


# ---------------------------------------------------------------- values
LEAVE = np.arccos(-STEADY / SWING) / OMEGA  # N = 0 on the way down
CLOSED = [  # text, value, largest change of it when the curve changes by 1
    ("max(O.normal)", STEADY + SWING, 1),
    ("min(O.normal)", STEADY - SWING, 1),
    ("max(abs(O.fx - O.fx))", 0.0, 1),
    ("range(O.normal)", 2 * SWING, 2),
    ("mean(O.normal)", STEADY, 1),
    ("sd(O.normal)", SWING / np.sqrt(2), 2),
    ("rms(O.normal)", np.sqrt(STEADY**2 + SWING**2 / 2), 1),
    ("rms(O.normal - 2*F)", SWING / np.sqrt(2), 1),
    ("integral(O.normal)", STEADY * T_END, T_END),
    ("at(O.normal, 0.033)", STEADY + SWING * np.cos(OMEGA * 0.033), 1),
    ("at(O.normal, 0.37*T)", STEADY + SWING * np.cos(OMEGA * 0.037), 1),
    ("final(O.normal)", STEADY + SWING, 0),
    ("quantile(O.normal, p)", STEADY - SWING * np.sqrt(0.5), 1),
    ("share(O.normal > 0)", 2 / 3, 4 / (SWING * OMEGA * np.sqrt(0.7)) / T_END),
    ("share(O.normal <= 0)", 1 / 3, 4 / (SWING * OMEGA * np.sqrt(0.7)) / T_END),
    ("share(F < O.normal)", np.arccos(-0.25) / np.pi, 4 / (SWING * OMEGA * np.sqrt(0.9)) / T_END),
    ("first(O.normal < 0)", LEAVE, 1 / (SWING * OMEGA * np.sqrt(0.7))),
    ("first(O.normal <= 0)", LEAVE, 1 / (SWING * OMEGA * np.sqrt(0.7))),
]


@pytest.mark.parametrize("n", [COARSE, FINE])
@pytest.mark.parametrize(("text", "expected", "moves"), CLOSED)
def test_reductions_of_a_cosine(text, expected, moves, n):
    assert number(text, n) == pytest.approx(expected, rel=1e-12, abs=moves * SWING * error(n) + 1e-13)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("(final(arm.x) - 0.3)**2", C**2),
        ("max(max(O.normal), 400) - min(0, 3)", 400.0),
        ("hypot(max(O.normal), 4*F + max(O.normal)*2/3) / F", np.hypot(300, 400) / 50),
        ("count(O.impacts)", 1),
        ("count(O.contacts)", 1),
        ("first(t >= 0.2)", 0.2),
        ("share(t > T)", 0.5),
        ("first(O.normal > 0)", 0.0),
        ("max(hypot(arm.x - 0.3, arm.y))", C),
        ("mean(1 if t < T else 3)", 2.0),
        ("2*F", 100.0),
    ],
)
def test_expressions_inside_and_arithmetic_outside(text, expected):
    assert number(text) == pytest.approx(expected, rel=2e-4 if " if " in text else 1e-9, abs=1e-15)


def test_the_same_mechanism_without_play_is_another_result():
    ideal = circling(401, clearance=0.0)
    assert number("max(arm.x - ideal.arm.x)", 401, ideal) == pytest.approx(C, rel=1e-12)
    assert number("rms(ideal.arm.P.x - arm.P.x)", 401, ideal) == pytest.approx(C / np.sqrt(2), rel=1e-7)
    with pytest.raises(ValueError, match="without play"):
        number("max(ideal.arm.x)", 401)
    with pytest.raises(ValueError, match="same instants"):
        number("max(ideal.arm.x)", 401, circling(301))


def test_a_condition_that_never_holds_has_no_first_instant():
    assert np.isnan(number("first(O.normal > 301)"))
    assert number("share(O.normal > 301)") == 0.0
    assert number("share(O.normal >= -101)") == 1.0
    assert np.isnan(number("first(O.normal >= 301)"))


def test_zero_without_contact_counts_for_at_most_and_not_for_less():
    r = made({"N": np.maximum(STEADY + SWING * np.cos(OMEGA * TIMES), 0.0)})
    free = 1 / 3
    step = TIMES[1] / T_END
    assert of(r, "share(N <= 0)") == pytest.approx(
        free, abs=2 * step
    )  # two flights, each end known to half an interval
    assert of(r, "share(N > 0)") + of(r, "share(N <= 0)") == pytest.approx(1.0, abs=1e-12)
    assert of(r, "share(N < 0)") == 0.0
    assert of(r, "share(N >= 0)") == 1.0
    assert of(r, "first(N <= 0)") == pytest.approx(LEAVE, abs=TIMES[1])


# ---------------------------------------------------------------- what is not known
TIMES = np.linspace(0.0, T_END, 401)


def made(curves, peaks=None, t=TIMES, t_end=T_END, analysis="simulate", **rest):
    return Result(
        t=t, data=np.column_stack(list(curves.values())), names=curves, units=dict.fromkeys(curves, "N"),
        geometry={"bodies": {}, "joints": {"O": {"clearance": C}}, "loads": {}}, trust=Trust(0.0, "", 0.0, t_end),
        stats={}, provenance={"analysis": analysis, "parameters": PARAMETERS}, peaks=peaks, **rest,
    )  # fmt: skip


def of(result, text, **rest):
    return evaluate(read(text, Known.of(result)), result, **rest)


@pytest.mark.parametrize("text", [text for text, _, _ in CLOSED if "at(" not in text or "O.fx" in text])
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_curve_with_a_value_that_is_not_finite_has_no_number(text, bad):
    curves = {"O.normal": np.cos(TIMES), "O.fx": np.cos(TIMES)}
    for curve in curves.values():
        curve[200] = bad
    assert np.isnan(of(made(curves), text))


def test_outside_its_domain_an_output_has_no_number():
    r = made({"N": np.cos(TIMES)})
    for text in ("1/(final(N) - final(N))", "sqrt(-max(N))", "max(log(N/F - 1))", "exp(1e6*max(N))", "quantile(N, F)"):
        assert np.isnan(of(r, text))


def test_of_a_run_that_stopped_early_only_what_happened_is_known():
    stopped = {"success": False, "message": "stopped", "events": [Event(0.01, "O", "impact")]}
    r = made({"N": STEADY + SWING * np.cos(OMEGA * TIMES)}, t_end=2 * T_END, **stopped)
    assert of(r, "at(N, 0.05)") == pytest.approx(STEADY - SWING)
    assert of(r, "first(N < 0)") == pytest.approx(LEAVE, rel=1e-6)
    for text in (
        "at(N, 0.25)",
        "final(N)",
        "max(N)",
        "mean(N)",
        "share(N > 0)",
        "count(O.impacts)",
        "quantile(N, 0.5)",
    ):
        assert np.isnan(of(r, text)), text


def test_an_instant_outside_the_run_is_refused():
    r = made({"N": np.cos(TIMES)})
    for t in ("0.3", "-0.1", "0.2 + 1e-9"):
        with pytest.raises(ValueError, match="outside the run, which goes from 0 to"):
            of(r, f"at(N, {t})")


def test_events_are_counted_in_runs_in_time_only():
    with pytest.raises(ValueError, match="a result of kinematics"):
        of(made({"N": np.cos(TIMES)}, analysis="kinematics"), "count(O.impacts)")


# ---------------------------------------------------------------- from within the steps
def sparse(t=(0.0, 0.1, 0.2), **rest):
    """Three outputs of a run whose steps saw more."""
    curves = {name: np.ones(len(t)) for name in ("O.fx", "O.fy", "O.normal", "O.moment", "m.force")}
    peaks = {"O.force": 7.0, "O.normal": 5.0, "O.moment": 9.0, "m.force": 8.0}
    return made(curves, {name: Peak(value, 0.03, value / 4) for name, value in peaks.items()}, t, **rest)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("max(O.force)", 7.0),
        ("max(abs(O.force))", 7.0),
        ("max(O.normal)", 5.0),
        ("range(O.normal)", 4.0),
        ("max(abs(O.moment))", 9.0),
        ("max(abs(m.force))", 8.0),
        ("rms(O.normal)", 1.25),
        # the peak is that of the magnitude, and these have a sign
        ("max(O.moment)", 1.0),
        ("max(m.force)", 1.0),
        # the steps did not watch these
        ("max(2*O.normal)", 2.0),
        ("min(O.normal)", 1.0),
    ],
)
def test_peaks_between_outputs_are_those_within_the_steps(text, expected):
    assert of(sparse(), text) == expected


def test_the_pull_of_a_massless_link_is_no_normal_force():
    r = sparse()
    r.peaks["O.pressing"] = Peak(3.0, 0.1, 1.0)
    assert of(r, "max(O.normal)") == 3.0


def test_a_curve_drawn_through_outputs_beside_a_peak_is_no_higher_peak():
    t = np.linspace(0.0, 0.2, 6)
    curves = {"O.fx": np.array([0.0, 4.0, 6.9, 6.9, 4.0, 0.0]), "O.fy": np.zeros(6)}
    assert of(made(curves, None, t), "max(O.force)") > 7.0  # the cubic between the two highest outputs
    r = made(curves, {"O.force": Peak(7.0, 0.1, 1.0)}, t)
    assert (of(r, "max(O.force)"), of(r, "range(O.force)")) == (7.0, 7.0)


def test_peaks_outside_the_outputs_are_not_theirs():
    assert of(sparse((0.1, 0.15, 0.2)), "max(O.force)") == pytest.approx(np.sqrt(2))
    assert of(sparse(t_end=0.3), "rms(O.normal)") == pytest.approx(1.0)


# ---------------------------------------------------------------- what is read
@pytest.mark.parametrize(
    ("text", "unit"),
    [
        ("max(O.normal)", "N"),
        ("rms(O.normal - 5)", "N"),
        ("integral(O.normal)", "N*s"),
        ("first(O.normal > F)", "s"),
        ("share(O.normal > F)", ""),
        ("count(O.impacts)", ""),
        ("max(arm.angle - ideal.arm.angle)", "rad"),
        ("max(sin(arm.angle))", ""),
        ("max(O.normal)/F", ""),
        ("(final(arm.x) - 0.3)**2", "m^2"),
        ("max(arm.x*O.normal)", "N*m"),
        ("at(arm.x, T)", "m"),
        ("quantile(O.force, 0.95)", "N"),
        ("max(F if t < T else O.normal)", "N"),
    ],
)
def test_an_output_has_the_unit_of_what_it_is(text, unit):
    assert read(text, KNOWN).unit == unit


def test_energy_stays_in_joule():
    known = Known({"energy.kinetic": "J", "energy.work": "J", "motor.torque": "N*m"})
    assert read("max(energy.kinetic - energy.work)", known).unit == "J"
    assert read("max(energy.kinetic) + mean(energy.work)", known).unit == "J"
    assert read("max(motor.torque)", known).unit == "N*m"
    assert read("max(energy.kinetic + motor.torque)", known).unit == "N*m"


def test_the_parsed_form_is_a_list_of_reductions_and_a_tree_over_their_places():
    output = read("max(O.force)*max(arm.x) - 2*F*at(ideal.arm.P.x + arm.y, 0.5*T)", KNOWN)
    assert [one.kind for one in output.reductions] == ["max", "max", "at"]
    assert names(output.outer) == {"#0", "#1", "#2", "F"}
    assert output.names == {"O.force", "arm.x", "arm.y"}
    assert output.ideal_names == {"arm.P.x"}
    assert argument(output.reductions[2], PARAMETERS) == 0.05
    assert needed_instants(output, PARAMETERS) == (0.05,)
    with pytest.raises(ValueError, match="no argument"):
        argument(output.reductions[0], PARAMETERS)


@pytest.mark.parametrize(
    ("condition", "strict", "sign"),
    [("arm.x > O2", True, 1), ("arm.x >= O2", False, 1), ("arm.x < O2", True, -1), ("arm.x <= O2", False, -1)],
)
def test_a_condition_is_a_difference_that_is_positive_where_it_holds(condition, strict, sign):
    known = Known({"arm.x": "m"}, {"O2": "m"})
    (one,) = read(f"share({condition})", known).reductions
    assert one.strict is strict
    assert float(arrays.evaluate(one.inner, {"arm.x": 5.0, "O2": 2.0}.__getitem__)) == 3.0 * sign


@pytest.mark.parametrize("text", ["max(O.normal) <= 500", "500 >= max(O.normal)", "max(O.normal) < 10*F"])
def test_the_margin_of_a_constraint_is_what_is_left(text):
    constraint = read_constraint(text, KNOWN)
    assert evaluate(constraint.margin, circling(), PARAMETERS) == pytest.approx(200.0, rel=1e-9)
    assert constraint.margin.unit == "N"
    assert constraint.comparison in text


def test_a_curve_named_like_a_reduction_is_a_curve():
    known = Known({"range": "m", "ideal.x": "m", "x": "m"})
    assert read("max(range)", known).names == {"range"}
    output = read("max(ideal.x)", known)  # a body may be called ideal
    assert output.names == {"ideal.x"}
    assert not output.ideal_names


# ---------------------------------------------------------------- what is refused
@pytest.mark.parametrize(
    ("text", "column", "said"),
    [
        ("O.normal", 0, "give one number of it: max(O.normal), final(O.normal)"),
        ("2*max(O.normal) + t", 18, "'t' changes during the run"),
        ("max(O.normal, arm.x)", 4, "changes during the run"),
        ("max(O.nrmal)", 4, "did you mean 'O.normal'?"),
        ("O.nrmal", 0, "did you mean 'O.normal'?"),
        ("max(ideal.arm.z)", 4, "'ideal.arm.x'"),
        ("max(abs(min(O.normal)))", 8, "min(...) is one number already and cannot stand inside max"),
        ("at(O.normal, first(O.normal > 0))", 13, "cannot stand inside at"),
        ("share(O.normal)", 6, "share takes a condition, as in share(x > 0)"),
        ("share(max(O.normal))", 6, "share takes a condition"),
        ("max(O.normal > 0)", 13, "allowed only between 'if' and 'else' and in first(...) and in share(...)"),
        ("share(O.normal > 0 and arm.x > 0)", 19, "min(x, y)"),
        ("at(O.normal)", 0, "at takes 2 arguments, not 1"),
        ("mean(O.normal, 2)", 0, "mean takes 1 argument, not 2"),
        ("max()", 0, "max takes 1 or more arguments, not 0"),
        ("at(O.normal, t)", 13, "numbers and parameters only"),
        ("at(O.normal, arm.x)", 13, "numbers and parameters only"),
        ("at(O.normal, F)", 13, "is a force; expected a time"),
        ("at(O.normal, TT)", 13, "did you mean 'T'?"),
        ("at(O.normal, 20 mm)", 13, "is a length; expected a time"),
        ("at(O.normal, 20 mss)", 16, "mss is not a unit"),
        ("quantile(O.normal, 95)", 19, "from 0 to 1"),
        ("quantile(O.normal, T)", 19, "expected a plain number"),
        ("max(O.normal + arm.x)", 13, "cannot add N and m"),
        ("share(O.normal > arm.x)", 15, "cannot compare N and m"),
        ("max(O.normal) + max(arm.x)", 14, "cannot add N and m"),
        ("max(O.normal) <= 5", 14, "a comparison of two outputs is a constraint"),
        ("3 + 4", 0, "the same in every run"),
        ("", 0, "found the end"),
        ("max(O.impacts)", 4, "write count(O.impacts)"),
        ("count(O.impcts)", 6, "did you mean 'O.impacts'?"),
        ("count(O.normal)", 6, "count takes events of a joint with play"),
        ("count(2*O.impacts)", 7, "as in count(O.contacts)"),
        ("count(ideal.O.impacts)", 6, "without play"),
        ("mean", 0, "write mean(...)"),
        ("average(O.normal)", 0, "write mean"),
        ("max(a.b.c.d.e)", 11, "too many parts"),
        ("men(O.normal)", 0, "did you mean 'mean'"),
    ],
)
def test_what_is_no_output_is_refused_at_its_place(text, column, said):
    with pytest.raises(ModelError) as caught:
        read(text, KNOWN)
    (problem,) = caught.value.problems
    assert said in problem.message
    assert problem.column == column
    assert str(caught.value).endswith(f"{text}\n{' ' * column}^")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("max(O.normal)", "compares two outputs, as in max(O3.force) <= 500"),
        ("0 < max(O.normal) < 5", "allowed only between"),
        ("max(O.normal) <= max(arm.x)", "cannot compare m and N"),
        ("O.normal <= 500", "give one number of it"),
        ("1 <= 2", "the same in every run"),
    ],
)
def test_what_is_no_constraint_is_refused(text, said):
    with pytest.raises(ModelError) as caught:
        read_constraint(text, KNOWN)
    assert said in str(caught.value)


def test_without_play_there_is_nothing_to_count():
    with pytest.raises(ModelError, match="no joint has play"):
        read("count(O.impacts)", Known({"arm.x": "m"}))


def test_a_text_of_several_lines_shows_the_line_at_fault():
    with pytest.raises(ModelError) as caught:
        read("max(O.normal)\n + max(O.nrmal)", KNOWN)
    assert str(caught.value).endswith("\n + max(O.nrmal)\n       ^")


def test_very_long_outputs_are_read_without_recursion():
    assert len(read(" + ".join(["max(lift)"] * 150), KNOWN).reductions) == 150
