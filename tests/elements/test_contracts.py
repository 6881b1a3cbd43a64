"""What every kind in the registry promises; a new kind is tested here without an edit.

A joint or driver: its Jacobian is the derivative of Phi, nu and gamma are its time derivatives along a path.
A load: its power is accounted for, its elastic force is the slope of its potential, between two bodies it is
action and reaction.  All in plain Python and in machine code.
"""

import math
from inspect import isabstract
from typing import get_args, get_overloads, get_type_hints

import numpy as np
import pytest

from moving_bodies import FIRST, SECOND, A, B, H, Path, body_at, field_values, rng_for, turned
from rattle import registry
from rattle.elements.custom.load_law import LawKernel
from rattle.jit import layout as at
from rattle.language.local_function import packed
from rattle.language.units import dimension_of

pytestmark = pytest.mark.nojit

BUILT_IN = ("joint", "driver", "load", "contact", "normal", "stiffness", "friction", "clearance", "stop")
JOINTS = [(family, name) for family in ("joint", "driver") for name in registry.kinds(family)]
LOADS = [name for name, one in registry.kinds("load").items() if not isinstance(one.kernel, LawKernel)]


def parameters(family, kind, rng, f):
    """Points of A and B, the fields of the joint, then the function and its derivatives for a driver."""
    points = list(rng.uniform(-1, 1, 4))
    if family == "joint":
        return np.array(packed(points + field_values(kind, rng) + constants(kind, rng)))
    line = [rng.uniform(0.5, 2.0)] if kind.leaf.along_line else []
    return np.array(points + line + list(rng.uniform(-0.5, 0.5, kind.leaf.from_start)) + f)


def constants(kind, rng):
    """That all rows act, where some may not; what the start has made the constants of rows that count from it."""
    whole = [1.0] if kind.leaf.placing else []
    return whole + (list(rng.uniform(-0.5, 0.5, kind.leaf.from_start)) if kind.leaf.from_start else [])


def evaluate(kind, q, v, p):
    rows = np.zeros((len(kind.leaf.rows) + 1, at.width("rows")))
    kind.kernel(body_at(q, v), A, B, p, 0, 1, rows)
    assert not rows[0].any(), "a kernel writes its own rows only"
    return rows[1:]


@pytest.mark.usefixtures("mode")
@pytest.mark.parametrize(("family", "name"), JOINTS)
def test_jacobian_is_the_derivative_of_the_residual(family, name):
    kind, path = registry.kinds(family)[name], Path(rng_for(name))
    p = parameters(family, kind, rng_for(name, "p"), path.f(0.3))
    q, v = path.q(0.3), path.v(0.3)
    rows = evaluate(kind, q, v, p)
    for body, first in ((A, 3), (B, 6)):
        for k in range(3):
            ahead, behind = q.copy(), q.copy()
            ahead[body, k] += H
            behind[body, k] -= H
            slope = (evaluate(kind, ahead, v, p)[:, at.RES] - evaluate(kind, behind, v, p)[:, at.RES]) / (2 * H)
            np.testing.assert_allclose(rows[:, first + k], slope, atol=FIRST)


def along(family, kind, name, t):
    path = Path(rng_for(name))
    return evaluate(kind, path.q(t), path.v(t), parameters(family, kind, rng_for(name, "p"), path.f(t)))


@pytest.mark.usefixtures("mode")
@pytest.mark.parametrize(("family", "name"), JOINTS)
def test_nu_and_gamma_are_time_derivatives_along_a_path(family, name):
    kind, path, t = registry.kinds(family)[name], Path(rng_for(name)), 0.3
    here, ahead, behind = (along(family, kind, name, t + dt) for dt in (0.0, H, -H))
    v, dv = path.v(t), path.dv(t)
    jacobian = np.hstack([here[:, 3:6], here[:, 6:9]])
    # d Phi / dt = Phi_q v - nu,   d (Phi_q v - nu) / dt = Phi_q dv - gamma
    rate = jacobian @ np.concatenate([v[A], v[B]]) - here[:, at.NU]
    np.testing.assert_allclose(rate, (ahead[:, at.RES] - behind[:, at.RES]) / (2 * H), atol=FIRST)
    second = jacobian @ np.concatenate([dv[A], dv[B]]) - here[:, at.GAMMA]
    curvature = (ahead[:, at.RES] - 2 * here[:, at.RES] + behind[:, at.RES]) / H**2
    np.testing.assert_allclose(second, curvature, atol=SECOND)


@pytest.mark.parametrize(("family", "name"), JOINTS)
def test_force_of_a_joint_does_no_work_on_rigid_motion_of_both_bodies(family, name):
    """Action and reaction: shifting everything changes no residual, nor does turning it where A carries the frame."""
    kind, path = registry.kinds(family)[name], Path(rng_for(name))
    if family == "driver" and kind.leaf.drives == "body":
        pytest.skip("held from the ground")
    q, v = path.q(0.3), path.v(0.3)
    rows = evaluate(kind, q, v, parameters(family, kind, rng_for(name, "p"), path.f(0.3)))
    np.testing.assert_allclose(rows[:, 3:5] + rows[:, at.BX : at.BX + 2], 0.0, atol=1e-14)
    turning = np.array([-q[A, 1], q[A, 0], 1.0, -q[B, 1], q[B, 0], 1.0])
    if family == "driver" or not kind.leaf.rows_in_ground:  # rows in the frame of A, or of no frame
        np.testing.assert_allclose(rows[:, 3:9] @ turning, 0.0, atol=1e-13)


def joint_of(name):
    """A kind of joint, its points of A and B, and values of its fields."""
    kind, rng = registry.kinds("joint")[name], rng_for(name, "declared")
    return kind, rng.uniform(-1, 1, (2, 2)), dict(zip(kind.fields, field_values(kind, rng), strict=True))


@pytest.mark.parametrize("name", [name for name, one in registry.kinds("joint").items() if one.leaf.from_start])
def test_rows_that_count_from_the_start_vanish_with_what_is_left_of_them_there(name):
    kind, q = registry.kinds("joint")[name], Path(rng_for(name)).q(0.3)
    p = parameters("joint", kind, rng_for(name, "p"), [])
    own, counting = slice(len(p) - kind.leaf.from_start, None), slice(kind.leaf.placing, None)
    p[own] = 0.0
    d = q[B, :2] + turned(q[B, 2], p[2:4]) - q[A, :2] - turned(q[A, 2], p[:2])
    p[own] = kind.leaf.start_constants(tuple(evaluate(kind, q, np.zeros((3, 3)), p)[counting, at.RES]), tuple(d))
    assert np.abs(p[own][: len(kind.leaf.rows)]).min() > 0.01, "the case is too special to show anything"
    np.testing.assert_allclose(evaluate(kind, q, np.zeros((3, 3)), p)[counting, at.RES], 0.0, atol=1e-14)


@pytest.mark.parametrize("name", [name for name, one in registry.kinds("joint").items() if one.leaf.places])
def test_bodies_placed_as_a_joint_declares_close_its_rows(name):
    """The first guess knows no more of a joint than this."""
    kind, (at_a, at_b), fields = joint_of(name)
    q = Path(rng_for(name)).q(0.3)
    kept, line = kind.leaf.kept_angle(fields), kind.leaf.line(fields)
    if kept is not None:
        q[B, 2] = q[A, 2] + kept
    way = 0.7 * min(kind.leaf.travel(fields), 1.0) if line is not None else kind.leaf.distance(fields)
    apart = way * turned(q[A, 2], (math.cos(line or 0.4), math.sin(line or 0.4)))
    q[B, :2] = q[A, :2] + turned(q[A, 2], at_a) + apart - turned(q[B, 2], at_b)
    rows = evaluate(kind, q, np.zeros((3, 3)), np.array([*at_a, *at_b, *fields.values()]))
    np.testing.assert_allclose(rows[:, at.RES], 0.0, atol=1e-14)


@pytest.mark.parametrize("name", [name for name, one in registry.kinds("joint").items() if one.leaf.motor])
def test_motor_of_a_joint_moves_what_the_joint_leaves_free(name):
    kind, points, fields = joint_of(name)
    q, none = Path(rng_for(name)).q(0.3), np.zeros((3, 3))
    driver = registry.kinds("driver")[kind.leaf.motor.driver]
    line = [kind.leaf.line(fields)] if driver.leaf.along_line else []
    rows = evaluate(kind, q, none, np.array([*points.ravel(), *fields.values()]))
    driven = evaluate(driver, q, none, np.array([*points.ravel(), *line, 0.0, 0.0, 0.0]))
    both = np.vstack([rows, driven])[:, at.AX :]
    assert driver.leaf.drives == "joint"
    assert np.linalg.matrix_rank(both) == len(both)


# ---------------------------------------------------------------- loads
def load_at(kind, q, v, p, t=0.3):
    force, energy = np.zeros((3, 3)), np.zeros(4)
    kind.kernel(t, body_at(q, v), A, B, p, 0, force, energy)
    return force, energy


def load_of(name):
    kind, path = registry.kinds("load")[name], Path(rng_for(name))
    return kind, path.q(0.3), path.v(0.3), np.array([*field_values(kind, rng_for(name, "p")), 0.0])


@pytest.mark.usefixtures("mode")
@pytest.mark.parametrize("name", LOADS)
def test_power_of_a_load_is_accounted_for(name):
    kind, q, v, p = load_of(name)
    force, energy = load_at(kind, q, v, p)
    power = float((force * v).sum())
    assert power == pytest.approx(energy[at.ELASTIC] + energy[at.OUTSIDE] - energy[at.DISSIPATED], abs=1e-12)
    assert abs(power) > 1e-3, "the case is too special to show anything"


@pytest.mark.usefixtures("mode")
@pytest.mark.parametrize("name", LOADS)
def test_elastic_power_is_the_rate_at_which_the_potential_falls(name):
    kind, q, v, p = load_of(name)
    _, here = load_at(kind, q, v, p)
    ahead, behind = (load_at(kind, q + dt * v, v, p)[1][at.POTENTIAL] for dt in (H, -H))
    assert here[at.ELASTIC] == pytest.approx(-(ahead - behind) / (2 * H), abs=1e-7)


@pytest.mark.usefixtures("mode")
@pytest.mark.parametrize("name", LOADS)
def test_load_at_rest_that_stores_is_the_slope_of_its_potential(name):
    kind, q, v, p = load_of(name)
    rest = np.zeros_like(v)
    force, energy = load_at(kind, q, rest, p)
    assert energy[[at.ELASTIC, at.OUTSIDE, at.DISSIPATED]] == pytest.approx(0.0)
    if energy[at.POTENTIAL] == 0.0:
        return
    for body in (A, B):
        for k in range(3):
            ahead, behind = q.copy(), q.copy()
            ahead[body, k] += H
            behind[body, k] -= H
            slope = load_at(kind, ahead, rest, p)[1][at.POTENTIAL] - load_at(kind, behind, rest, p)[1][at.POTENTIAL]
            assert force[body, k] == pytest.approx(-slope / (2 * H), abs=1e-7)


@pytest.mark.usefixtures("mode")
@pytest.mark.parametrize("name", LOADS)
def test_load_between_two_bodies_is_action_and_reaction(name):
    kind, q, v, p = load_of(name)
    force, _ = load_at(kind, q, v, p)
    two = any(one.shape == "connect" for one in kind.fields.values())
    if not two:
        assert not force[A].any(), "a load on one body leaves the other alone"
        return
    np.testing.assert_allclose(force[A, :2] + force[B, :2], 0.0, atol=1e-14)
    moment = force[:, 2] + q[:, 0] * force[:, 1] - q[:, 1] * force[:, 0]  # about the origin
    assert moment[A] + moment[B] == pytest.approx(0.0, abs=1e-13)


@pytest.mark.parametrize("name", LOADS)
def test_damping_never_gives_energy(name):
    kind, q, _, p = load_of(name)
    rng = rng_for(name, "v")
    assert all(load_at(kind, q, rng.uniform(-2, 2, (3, 3)), p)[1][at.DISSIPATED] >= 0.0 for _ in range(50))


@pytest.mark.usefixtures("mode")
@pytest.mark.parametrize("name", LOADS)
def test_loads_add_up(name):
    kind, q, v, p = load_of(name)
    force, _ = load_at(kind, q, v, p)
    twice, energy = np.zeros((3, 3)), np.zeros(4)
    for _ in range(2):
        kind.kernel(0.3, body_at(q, v), A, B, p, 0, twice, energy)
    np.testing.assert_allclose(twice, 2 * force)


# ---------------------------------------------------------------- what a kind says about itself
EVERY = [(family, name) for family in BUILT_IN for name in registry.kinds(family)]


@pytest.mark.parametrize(("family", "name"), EVERY)
def test_kind_says_what_it_is_and_where_it_comes_from(family, name):
    kind = registry.kinds(family)[name]
    assert len(kind.summary) > 10
    assert kind.summary.endswith((".", ")"))
    assert kind.source
    assert name == name.lower()
    for key, one in kind.fields.items():
        assert key.isidentifier()
        assert one.meaning or one.shape in ("body", "joint")
        dimension_of(one.unit)  # a unit the program can read
        assert one.least in ("", "positive", "not negative")
        if one.shape == "choice":
            assert one.choices
            assert one.default in one.choices


@pytest.mark.parametrize(("family", "name"), JOINTS)
def test_rows_have_units(family, name):
    assert set(registry.kinds(family)[name].leaf.rows) <= {"m", "rad"}


def test_parameters_of_a_set_valued_contact_are_named_in_the_order_of_its_fields():
    for key, place in (
        ("restitution", at.RESTITUTION), ("tangential_restitution", at.TANGENTIAL_RESTITUTION), ("friction", at.MU),
        ("restitution_law", at.RESTITUTION_LAW), ("jam", at.JAM),
    ):  # fmt: skip
        assert list(registry.kinds("contact")["impact"].fields).index(key) == place


def test_tags_are_places_in_the_table():
    for family in BUILT_IN:
        assert [one.tag for one in registry.kinds(family).values()] == list(range(len(registry.kinds(family))))


def test_a_field_is_inherited_in_its_place_and_the_own_declaration_counts():
    class Family:
        mass = registry.Field("kg", "of all")
        speed = registry.Field("m/s", "of all")

    class Leaf(Family):
        length = registry.Field("m", "of the leaf")
        mass = registry.Field("kg", "of the leaf")

    found = registry.fields_of(Leaf)
    assert [(name, one.meaning) for name, one in found.items()] == [
        ("mass", "of the leaf"), ("speed", "of all"), ("length", "of the leaf"),
    ]  # fmt: skip


@pytest.mark.parametrize("family", ["normal", "stiffness", "friction"])
def test_a_field_of_one_name_has_one_unit_in_its_family(family):
    for name in {key for one in registry.kinds(family).values() for key in one.fields}:
        units = {one.fields[name].unit for one in registry.kinds(family).values() if name in one.fields}
        assert len(units) == 1, (name, units)


def test_a_second_kind_of_the_same_name_is_refused_and_the_first_stays():
    first = registry.kinds("load")["spring"]

    class Spring:
        """Another spring.

        Source: none.
        """

    with pytest.raises(ValueError, match=r"load 'spring' is already .*\(rattle\.elements\.loads\.spring\)"):
        registry.kind("load", "spring", first.kernel)(Spring)
    assert registry.kinds("load")["spring"] is first


def interfaces():
    """The interface of every family, as the overloads of `kinds` tell them to who checks types."""
    for overload in get_overloads(registry.kinds):
        hints = get_type_hints(overload)
        (interface,) = get_args(get_args(hints["return"])[1])
        yield from ((family, interface) for family in get_args(hints["family"]))


@pytest.mark.parametrize(("family", "interface"), [*interfaces()])
def test_kinds_derive_from_the_interface_of_their_family(family, interface):
    leaves = {name: kind.leaf for name, kind in registry.kinds(family).items()}
    assert [name for name, leaf in leaves.items() if not issubclass(leaf, interface) or isabstract(leaf)] == []


def test_every_family_has_an_interface():
    assert {*registry.families()} == {family for family, _ in interfaces()}
