"""Values of parameters are distributed as their tolerances say, and questions that make no sense are refused."""

import math

import numpy as np
import pytest
from scipy import stats

import rattle as rt
from rattle.questions.ensemble.fields import Field, fields_of
from rattle.results.result import UnknownName

pytestmark = [pytest.mark.nojit, pytest.mark.plain]  # NumPy alone

EVEN = (np.arange(100_000) + 0.5) / 100_000  # midpoints of equal shares: sums over them have no noise


def mechanism(groups=(), **parameters):
    m = rt.Mechanism("disc")
    for name, given in parameters.items():
        m.parameter(name, **given) if isinstance(given, dict) else m.parameter(name, given)
    for one in groups:
        m.group(*one)
    m.ground(O=[0, 0]).body("disc", mass=1, inertia=1, points={"O": [0, 0]})
    return m.revolute("O", "ground.O", "disc.O")


def field(**given) -> Field:
    return fields_of(mechanism(l={"value": "100 mm", **given})).fields[0]


# ---------------------------------------------------------------- distributions
REFERENCE = {  # frozen distributions of SciPy for 100 mm +- 0.3 mm
    "uniform": stats.uniform(0.0997, 0.0006),
    "normal": stats.truncnorm(-3, 3, 0.1, 0.0001),
    "triangular": stats.triang(0.5, 0.0997, 0.0006),
}


@pytest.mark.parametrize("dist", REFERENCE)
def test_values_are_distributed_as_an_independent_library_says(dist):
    x = field(tol="0.3 mm", dist=dist).quantile(EVEN)
    found = stats.kstest(x, REFERENCE[dist].cdf)
    assert found.statistic < 0.5001 / len(EVEN)  # the least that any sample can have is 0.5/n


@pytest.mark.parametrize("dist", REFERENCE)
def test_drawn_values_pass_the_test_of_kolmogorov_and_smirnov(dist):
    x = field(tol="0.3 mm", dist=dist).quantile(np.random.default_rng(5).random(20_000))
    assert stats.kstest(x, REFERENCE[dist].cdf).pvalue > 0.01


@pytest.mark.parametrize("dist", REFERENCE)
def test_mean_and_sd_are_those_of_the_values(dist):
    one = field(tol="0.3 mm", dist=dist)
    x = one.quantile(EVEN)
    assert one.mean == 0.1
    assert x.mean() == pytest.approx(0.1, abs=1e-12)
    assert x.std() == pytest.approx(one.sd, rel=1e-5)  # of a midpoint rule with 1e5 points at a square root
    assert one.sd == pytest.approx(REFERENCE[dist].std(), rel=1e-9)


def test_sd_has_its_closed_form():
    assert field(tol="0.3 mm").sd == pytest.approx(0.0003 / math.sqrt(3.0), rel=1e-14)
    assert field(tol="0.3 mm", dist="triangular").sd == pytest.approx(0.0003 / math.sqrt(6.0), rel=1e-14)
    inside = math.erf(3.0 / math.sqrt(2.0))
    density = math.exp(-4.5) / math.sqrt(2.0 * math.pi)
    expected = 0.0001 * math.sqrt(1.0 - 6.0 * density / inside)
    assert field(tol="0.3 mm", dist="normal").sd == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("dist", REFERENCE)
@pytest.mark.parametrize(("value", "tol"), [(0.1, 0.0003), (0.3, 0.1), (-7.0, 2.3), (0.0, 1e-9), (1.0 / 3.0, 1e-7)])
def test_no_value_is_outside_of_the_tolerance_by_rounding(dist, value, tol):
    one = fields_of(mechanism(a={"value": value, "tol": tol, "dist": dist})).fields[0]
    u = np.array([0.0, 1e-300, 1e-17, 2.0**-53, 0.25, 0.5, 0.75, 1.0 - 2.0**-52, 1.0 - 2.0**-53])
    x = one.quantile(u)
    assert (one.low, one.high) == (value - tol, value + tol)
    assert np.all((one.low <= x) & (x <= one.high))
    assert np.all(np.diff(x) >= 0.0)
    assert x[0] == pytest.approx(one.low, rel=4e-16, abs=4e-16 * tol)  # ends are reached up to rounding
    assert x[5] == pytest.approx(value, abs=1e-15 * max(1.0, abs(value)))


def test_distribution_is_uniform_unless_said():
    assert field(tol="0.3 mm").dist == "uniform"


def test_value_of_a_sample_does_not_depend_on_those_beside_it():
    for dist in REFERENCE:
        one = field(tol="0.3 mm", dist=dist)
        u = np.random.default_rng(1).random(1001)
        alone = [one.quantile(u[n : n + 1])[0] for n in range(len(u))]
        assert np.array_equal(one.quantile(u), alone)


# ---------------------------------------------------------------- tables of values
def test_table_has_frequencies_exactly_by_weights():
    one = field(dist={"values": ["101 mm", 0.1, "99.5 mm"], "weights": [1, 5, 2]})
    values, counts = np.unique(one.quantile((np.arange(800) + 0.5) / 800), return_counts=True)
    assert values.tolist() == [0.0995, 0.1, 0.101]
    assert counts.tolist() == [200, 500, 100]
    assert (one.low, one.high, one.nominal) == (0.0995, 0.101, 0.1)


def test_mean_and_sd_of_a_table():
    one = field(dist={"values": [1, 2, 5], "weights": [0.5, 0.25, 0.25]})
    assert one.mean == 2.25
    assert one.sd == pytest.approx(math.sqrt(0.5 * 1.25**2 + 0.25 * 0.25**2 + 0.25 * 2.75**2), rel=1e-15)


def test_values_of_a_table_without_weights_are_as_likely():
    one = field(dist={"values": [3, 1, 2, 2]})
    assert one.quantile((np.arange(8) + 0.5) / 8).tolist() == [1, 1, 2, 2, 2, 2, 3, 3]


def test_value_of_weight_zero_is_never_drawn_and_bounds_nothing():
    one = field(dist={"values": [9, 1, 2, 0], "weights": [0, 1, 1, 0]})
    assert (one.low, one.high) == (1, 2)
    assert set(one.quantile(np.array([0.0, 0.49, 0.5, 1.0 - 2.0**-53]))) == {1, 2}


@pytest.mark.parametrize("weights", [[1e59, 1e59], [1e-59, 1e-59], [7, 7]])
def test_only_ratios_of_weights_matter(weights):
    one = field(dist={"values": [1, 2], "weights": weights})
    assert one.shares == (0.5, 0.5)


def test_table_needs_no_tolerance_and_ignores_that_of_the_file():
    assert field(tol=0.001, dist={"values": [0.1, 0.11]}).high == 0.11
    assert field(tol=0, dist={"values": [0.1, 0.11]}).high == 0.11


# ---------------------------------------------------------------- what varies
THREE = {
    "a": {"value": "600 mm", "tol": "0.1 mm"},
    "b": {"value": "a", "tol": "0.2 mm", "dist": "normal"},
    "c": {"value": "1 mm", "dist": {"values": ["1 mm", "2 mm"]}},
    "exact": {"value": 1, "tol": 0},
    "free": "30 deg",
}


def test_all_with_a_tolerance_or_a_table_vary():
    found = fields_of(mechanism(**THREE))
    assert found.names == ("a", "b", "c")
    assert [one.unit for one in found.fields] == ["m", "m", "m"]
    assert found.draw == (0, 1, 2)
    assert found.draws == 3


def test_named_parameters_vary_in_the_order_of_their_names():
    found = fields_of(mechanism(**THREE), ["c", "a"])
    assert found.names == ("c", "a")
    assert found.fields[1] == fields_of(mechanism(**THREE)).fields[0]


def test_part_of_the_same_nominal_size_has_a_deviation_of_its_own():
    b = fields_of(mechanism(**THREE)).fields[1]
    assert (b.nominal, b.low, b.high) == (0.6, 0.6 - 0.0002, 0.6 + 0.0002)


@pytest.mark.parametrize(
    "tol", [2e-4, "0.2 mm", "2e-4", {"tol": "0.2 mm"}, np.float64(2e-4), {"tol": np.float32(2e-4)}, "a/3000"]
)
def test_tolerance_given_here_stands_before_that_of_the_file(tol):
    (one,) = fields_of(mechanism(**THREE), {"a": tol}).fields
    assert one.tol == pytest.approx(2e-4, rel=1e-6)
    assert one.dist == "uniform"


def test_what_is_not_given_here_is_as_in_the_file():
    a, b, free = fields_of(
        mechanism(**THREE), {"a": {"dist": "triangular"}, "b": "0.5 mm", "free": {"tol": "1 deg", "dist": "normal"}}
    ).fields
    assert (a.tol, a.dist) == (0.0001, "triangular")
    assert (b.tol, b.dist) == (0.0005, "normal")
    assert (free.nominal, free.tol) == (pytest.approx(math.pi / 6), pytest.approx(math.pi / 180))


def test_table_given_here():
    (one,) = fields_of(mechanism(**THREE), {"a": {"dist": {"values": ["599 mm", "601 mm"]}}}).fields
    assert (one.dist, one.values, one.shares) == ("table", (0.599, 0.601), (0.5, 0.5))


def test_values_of_samples_are_those_of_the_quantiles():
    found = fields_of(mechanism(**THREE))
    points = np.random.default_rng(3).random((7, 3))
    values = found.values(points)
    assert values.shape == (3, 7)
    for row, one, u in zip(values, found.fields, points.T, strict=True):
        assert np.array_equal(row, one.quantile(u))


@pytest.mark.parametrize(("value", "tol"), [(1, 3), (11, 2), (7, 1), (3, 3), (29, 11), (57, 28)])  # in 0.1 mm
def test_field_that_ends_at_its_limits_never_rounds_beyond_them(value, tol):
    texts = {"min": value - tol, "value": value, "max": value + tol, "tol": tol}
    m = mechanism(c={key: f"{one / 10} mm" for key, one in texts.items()})
    c = m.model.parameters["c"]
    one = fields_of(m).fields[0]
    assert (one.low, one.high) == (c.minimum, c.maximum)
    for x in one.quantile(np.array([0.0, 2.0**-53, 1.0 - 2.0**-53])):
        assert m.set(c=float(x)).parameters["c"] == x  # the reader refuses values beyond the limits


# ---------------------------------------------------------------- groups
def test_one_draw_moves_all_of_a_group_through_their_own_fields():
    found = fields_of(mechanism(groups=[("c", "a")], **THREE))
    assert found.draw == (0, 1, 0)
    assert found.draws == 2
    u = np.linspace(0.0, 0.999, 50)
    a, b, c = found.values(np.column_stack([u, u[::-1]]))
    one, other, third = found.fields
    assert np.array_equal(a, one.quantile(u))
    assert np.array_equal(b, other.quantile(u[::-1]))
    assert np.array_equal(c, third.quantile(u))


def test_equal_fields_of_a_group_have_equal_deviations():
    same = {"value": 0.6, "tol": 1e-4, "dist": "normal"}
    found = fields_of(mechanism(groups=[("a", "b")], a=same, b=same, c=same))
    a, b, c = found.values(np.random.default_rng(2).random((1000, found.draws)))
    assert np.array_equal(a, b)
    assert abs(np.corrcoef(a, c)[0, 1]) < 0.1  # three standard errors of 1000 independent pairs


def test_part_of_a_group_moves_together():
    m = mechanism(groups=[("a", "b", "c"), ("exact", "free")], **THREE)
    assert fields_of(m, ["c", "b"]).draw == (0, 0)
    assert fields_of(m, {"free": 0.1, "a": 0.1, "exact": 0.1, "c": {}}).draw == (0, 1, 0, 1)


def test_part_of_a_group_without_tolerance_is_refused_unless_it_is_left_out():
    m = mechanism(groups=[("a", "free")], **THREE)
    assert m.check().mobility == 1  # a model that only runs
    with pytest.raises(rt.ModelError, match=r"tolerances.groups\[0\]: 'free' is made together with 'a' but has no tol"):
        fields_of(m)
    assert fields_of(m, ["a"]).draw == (0,)
    assert fields_of(m, {"a": {}, "free": 0.1}).draw == (0, 0)


def test_group_none_of_which_varies_is_no_matter():
    assert fields_of(mechanism(groups=[("exact", "free")], **THREE)).names == ("a", "b", "c")


# ---------------------------------------------------------------- questions that are refused
def refused(match, vary=None, error=ValueError, **parameters):
    with pytest.raises(error, match=match):
        fields_of(mechanism(**(parameters or THREE)), vary)


@pytest.mark.parametrize(
    ("vary", "match"),
    [
        ("a", r'expected a list of parameters; write vary=\["a"\]'),
        ("a, b", r'write vary=\["a", "b"\]'),
        ([], r'expected parameters such as \["l2"\]'),
        ({}, r'expected parameters such as \["l2"\]'),
        (3, "expected parameters such as"),
        (["a", "b", "a"], "'a' is named twice"),
        (["free"], r"'free' has no tolerance; give it one in the file: free = .* or here: vary="),
        ({"free": {"dist": "normal"}}, "'free' has no tolerance"),
        (["exact"], "'exact' has tol = 0 in the file and would not vary"),
        ({"a": 0}, "'a' has tol = 0 and would not vary"),
        ({"a": "0 mm"}, "'a' has tol = 0 and would not vary"),
        ({"a": None}, "'a': expected a tolerance such as"),
        ({"a": True}, "'a': expected a tolerance such as"),
        ({"a": (0.1, 0.2)}, "'a': expected a tolerance such as"),
        ({"a": "normal"}, r"'normal' is no tolerance; write \{\"dist\": \"normal\"\}"),
        ({"a": {"tolerance": 1}}, "'a': unknown key 'tolerance'"),
        ({"a": {"min": 1}}, "'a': unknown key 'min'"),
        ({"c": "0.1 mm"}, "'c' is distributed by a table of values, which needs no tol"),
    ],
)
def test_question_that_makes_no_sense_is_refused_with_a_hint(vary, match):
    refused(match, vary)


@pytest.mark.parametrize(
    ("given", "match"),
    [
        ("0.1 kg", r"vary\.a\.tol: '0.1 kg' is a mass; expected a length in m"),
        ("1 deg", r"vary\.a\.tol: '1 deg' is a plain number or angle; expected a length in m"),
        ("0.1 mn", r"vary\.a\.tol: unknown unit 'mn'"),
        ("-0.1 mm", r"vary\.a\.tol: '-0.1 mm' must not be negative"),
        (-1e-4, r"vary\.a\.tol: -0.0001 must not be negative"),
        (math.nan, r"vary\.a\.tol: nan is not a finite number"),
        (math.inf, r"vary\.a\.tol: inf is not a finite number"),
        ("inf mm", r"vary\.a\.tol: 'inf mm' is not a finite number"),
        ({"dist": "gauss"}, r"vary\.a\.dist: unknown distribution 'gauss'; expected uniform, normal, triangular or"),
        ({"dist": 3}, r"vary\.a\.dist: unknown distribution 3"),
        ({"dist": {"values": []}}, r"vary\.a\.dist\.values: expected a list of values, got an empty one"),
        ({"dist": {"values": "1 mm"}}, r"vary\.a\.dist\.values: expected a list of values, got '1 mm'"),
        ({"dist": {"values": [1, "2 s"]}}, r"vary\.a\.dist\.values\[1\]: '2 s' is a time; expected a length"),
        ({"dist": {"values": [1, 2], "weights": [1]}}, r"vary\.a\.dist\.weights: 1 weights for 2 values"),
        ({"dist": {"values": [1, 2], "weights": [0, 0]}}, r"vary\.a\.dist\.weights: all weights are zero"),
        ({"dist": {"values": [1, 2], "weights": [1, -1]}}, r"vary\.a\.dist\.weights\[1\]: -1 must not be negative"),
        ({"dist": {"weights": [1]}}, r"vary\.a\.dist: expected \{ values = "),
    ],
)
def test_tolerance_that_cannot_be_read_is_refused_as_in_the_file(given, match):
    refused(match, {"a": given}, rt.ModelError)


def test_all_problems_of_tolerances_are_reported_at_once():
    with pytest.raises(rt.ModelError) as caught:
        fields_of(mechanism(**THREE), {"a": "0.1 kg", "b": {"dist": "gauss"}})
    assert [one.key for one in caught.value.problems] == ["vary.a.tol", "vary.b.dist"]


def test_unknown_parameter_is_refused_with_a_suggestion():
    with pytest.raises(UnknownName, match="no parameter 'exat'; did you mean 'exact'"):
        fields_of(mechanism(**THREE), ["exat"])
    with pytest.raises(TypeError, match="expected names of parameters, got 3"):
        fields_of(mechanism(**THREE), [3])


def test_model_without_tolerances_says_where_to_write_them():
    refused(r"no parameter of the model has a tolerance; give it one in the file: x = \{ value", x=1)
    refused("no parameter of the model has a tolerance", x={"value": 1, "tol": 0})


@pytest.mark.parametrize(
    ("given", "match"),
    [
        # uniform on 0 to 2 mm: a quarter is below 0.5 mm, a tenth above 1.8 mm
        ({"tol": "1 mm", "min": "0.5 mm"}, r"25 % of its values \(uniform, 0 to 0.002 m\) are beyond min = 0.0005 m"),
        ({"tol": "1 mm", "min": "0.5 mm", "max": "1.8 mm"}, "35 % of its values .* min = 0.0005 m and max = 0.0018 m"),
        ({"tol": "1 mm", "min": "0.5 mm"}, "take tol = 0.0005 m at most, or widen the limits"),
        # a triangle of half that width on either side: (1/2)^2/2
        ({"tol": "1 mm", "max": "1.5 mm", "dist": "triangular"}, r"12 % of its values \(triangular"),
        ({"dist": {"values": ["1 mm", "2 mm"], "weights": [3, 1]}, "max": "1.9 mm"}, "25 % .* take other values"),
        ({"tol": "1 mm", "max": "1 mm"}, "50 % of its values .* choose another value, or widen"),
    ],
)
def test_field_beyond_the_limits_is_refused_with_its_share(given, match):
    refused(match, error=rt.ModelError, c={"value": "1 mm", **given})


def test_share_of_a_normal_field_beyond_a_limit_is_that_of_an_independent_library():
    one = field(tol="0.3 mm", dist="normal")
    found = one.share_outside(0.0998, 0.1001)
    assert found == pytest.approx(REFERENCE["normal"].cdf(0.0998) + REFERENCE["normal"].sf(0.1001), rel=1e-9)


def test_field_up_to_its_limits_is_allowed():
    assert field(tol="1 mm", min="99 mm", max="101 mm").high == 0.101
    refused("beyond max = 0.100999", error=rt.ModelError, l={"value": "100 mm", "tol": "1 mm", "max": "100.999 mm"})
