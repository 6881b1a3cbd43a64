"""Loads written in Python are loads like the built-in ones, compiled or not."""

import logging
import math

import numpy as np
import pytest

import rattle as rt
from rattle import registry
from rattle.jit import functions

pytestmark = pytest.mark.nojit


def turn_back(t, state, p):
    """A torsion spring and damper to the ground.

    Source: test.
    """
    _x, _y, angle, _vx, _vy, omega = state
    return 0.0, 0.0, -p.stiffness * angle - p.damping * omega


def turn_back_slowly(t, state, p):
    import json  # is not translated

    json.dumps([])
    return turn_back(t, state, p)


def wind(t, state, p):
    return p.strength * math.cos(3.0 * t), -p.drag * state[4], 0.0


def unsteady(t, state, p):
    if t > 0.05:
        raise ValueError("no wind any more")
    return 1.0, 0.0, 0.0


def lost(t, state, p):
    return math.nan if t > 0.05 else 1.0, 0.0, 0.0


def constant(t, state, p):
    return 2.0, 0.0, 0.0


def pull(t, length, rate, p):
    return -p.stiffness * (length - p.rest) - p.damping * rate


def pull_slowly(t, length, rate, p):
    import json  # is not translated

    json.dumps([])
    return pull(t, length, rate, p)


def rubber(t, a, b, p):
    """Elastic in both directions and in turning, with a force that is not along the line."""
    swing = p.twist * (b[2] - a[2]) + 0.1 * (b[5] - a[5])
    return -p.k * (b[0] - a[0]) - 0.3 * (b[3] - a[3]), -2 * p.k * (b[1] - a[1]) + math.sin(t), -swing


UNITS = {"stiffness": "N*m/rad", "damping": "N*m*s/rad"}


@pytest.fixture(autouse=True, scope="module")
def laws():
    """The laws of this file stay in this file."""
    before = dict(registry.kinds("load"))
    rt.load_law("turn back", **UNITS)(turn_back)
    rt.load_law("turn back plainly", compiled=False, **UNITS)(turn_back)
    rt.load_law("turn back slowly", **UNITS)(turn_back_slowly)
    rt.load_law("wind", strength="N", drag="N*s/m")(wind)
    rt.load_law("wind in Python", compiled=False, strength="N", drag="N*s/m")(wind)
    rt.load_law("unsteady")(unsteady)
    rt.load_law("unsteady in Python", compiled=False)(unsteady)
    rt.load_law("lost")(lost)
    rt.load_law("constant")(constant)
    rt.load_law("constant in Python", compiled=False)(constant)
    spring = {"stiffness": "N/m", "rest": "m", "damping": "N*s/m"}
    rt.load_law("pull", between="points", **spring)(pull)
    rt.load_law("pull plainly", between="points", compiled=False, **spring)(pull)
    rt.load_law("pull slowly", between="points", **spring)(pull_slowly)
    rt.load_law("rubber", between="bodies", k="N/m", twist="N*m/rad")(rubber)
    rt.load_law("rubber plainly", between="bodies", compiled=False, k="N/m", twist="N*m/rad")(rubber)
    yield
    entries = registry.kinds("load")
    for name in entries.keys() - before.keys():
        del entries[name]


def disc():
    m = rt.Mechanism("disc").ground(O=[0, 0])
    return m.body("disc", mass=1, inertia=0.5, points={"O": [0, 0]}).revolute("O", "ground.O", "disc.O")


def block():
    return rt.Mechanism("block").body("block", mass=2, inertia=1, points={}).initial("block", vx=1, vy=2)


@pytest.mark.parametrize("kind", ["turn back", "turn back plainly", "turn back slowly"])
def test_spring_written_in_python_moves_like_the_built_in_one(kind):
    fields = {"stiffness": 10, "damping": 0.2}
    own = disc().initial("disc", angle=1).load("L", kind, body="disc", **fields)
    built_in = disc().initial("disc", angle=1).load("L", "torsion-spring", connect=["ground", "disc"], **fields)
    one, other = (m.simulate(0.5, rtol=1e-10) for m in (own, built_in))
    np.testing.assert_allclose(one["disc.angle"], other["disc.angle"], atol=1e-12)
    # the built-in spring stores and dissipates, the law's power comes from outside: both balance
    assert np.abs(one["energy.balance"]).max() < 1e-8
    stored = other["energy.potential"] - other["energy.potential"][0] + other["energy.dissipated"]
    np.testing.assert_allclose(one["energy.work"], -stored, atol=1e-8)


@pytest.mark.parametrize("kind", ["wind", "wind in Python"])
def test_force_and_work_of_a_law_follow_from_momentum(kind):
    r = block().load("w", kind, body="block", strength=4, drag="0.5 N*s/m").simulate(1.0, rtol=1e-10)
    np.testing.assert_allclose(r["block.vx"], 1 + 2 / 3 * np.sin(3 * r.t), atol=1e-9)
    np.testing.assert_allclose(r["block.vy"], 2 * np.exp(-0.25 * r.t), atol=1e-9)
    gained = r["energy.kinetic"] - r["energy.kinetic"][0]
    np.testing.assert_allclose(r["energy.work"], gained, atol=1e-8)


def test_fields_of_a_law_may_change_in_time_and_are_checked():
    r = block().load("w", "wind", body="block", strength="6*t/cos(3*t)", drag=0).simulate(0.4, rtol=1e-10)
    np.testing.assert_allclose(r["block.vx"], 1 + 1.5 * r.t**2, atol=1e-9)
    with pytest.raises(rt.ModelError, match=r"loads.w.strength: '5 kg' is a mass; expected a force in N"):
        _ = block().load("w", "wind", body="block", strength="5 kg", drag=0).model
    with pytest.raises(rt.ModelError, match=r"loads.w: needs drag"):
        _ = block().load("w", "wind", body="block", strength=1).model


def test_law_stands_in_model_files_and_in_the_schema():
    from rattle.description.schema import schema

    m = block().load("w", "wind", body="block", strength="5 N", drag=0.1)
    assert rt.loads(m.to_toml()).model.loads == m.model.loads
    assert '"wind"' in str(schema()).replace("'", '"')


@pytest.mark.parametrize("kind", ["constant", "constant in Python"])
def test_law_without_fields(kind):
    r = block().load("push", kind, body="block").simulate(1.0)
    assert r["block.vx"][-1] == pytest.approx(2.0)


@pytest.mark.parametrize("kind", ["unsteady", "unsteady in Python"])
@pytest.mark.parametrize("method", ["dop853", "rk4"])
def test_exception_in_a_law_ends_the_run_and_is_told(kind, method):
    r = block().load("w", kind, body="block").simulate(0.1, method=method, step=1e-3)
    assert not r.success
    assert f"load law '{kind}' raised ValueError: no wind any more at t = 0.05" in r.message
    assert r.t[-1] == pytest.approx(0.05, abs=1.1e-3)


def test_law_that_gives_no_number_is_named():
    r = block().load("w", "lost", body="block").simulate(0.1)
    assert not r.success
    assert "loads.w: load law 'lost' gives (nan, 0.0, 0.0) at t = 0.05" in r.message


@pytest.mark.parametrize("method", ["rk4", "dop853"])
def test_evaluations_that_a_run_counts_are_those_that_call_its_loads(method):
    """A law that counts its calls: two runs differ in calls by as much as in counted evaluations and outputs."""
    calls = [0]

    def counted(t, state, p):
        calls[0] += 1
        return math.sin(40 * t), 0.0, 0.0

    rt.load_law("counted", compiled=False)(counted)
    beside = []
    for outputs, step in ((2, 0.02), (40, 0.005)):
        calls[0] = 0
        r = block().load("w", "counted", body="block").simulate(
            0.3, t_eval=np.linspace(0.0, 0.3, outputs), method=method, step=step
        )  # fmt: skip
        assert r.success, r.message
        beside.append(calls[0] - r.stats["evaluations"] - outputs)
    assert beside[0] == beside[1]  # at the start, the same in both runs


def test_interrupt_in_a_law_stops_the_run():
    def interrupted(t, state, p):
        if t > 0.05:
            raise KeyboardInterrupt
        return 1.0, 0.0, 0.0

    rt.load_law("interrupted", compiled=False)(interrupted)
    r = block().load("w", "interrupted", body="block").simulate(0.1)
    assert "stopped by the user" in r.message
    assert block().simulate(0.1).success  # and is over then


def test_log_says_what_runs_slower(caplog):
    if not functions.start():
        pytest.skip("machine code is switched off: everything is plain Python")
    for name in ("turn back slowly", "turn back plainly"):  # as if met for the first time
        registry.kinds("load")[name].kernel._address = 0
    with caplog.at_level(logging.INFO, logger="rattle"):
        registry.table("load")
    text = caplog.text
    assert "load law 'turn back plainly' runs as plain Python, slower (compiled=False)" in text
    assert "load law 'turn back slowly' runs as plain Python, slower: " in text
    assert "turn_back_slowly, line 26: 'import json' is not known here" in text
    assert "'turn back'" not in text


def test_name_and_units_of_a_law_are_checked_at_once():
    with pytest.raises(ValueError, match=r"'torque'.*has this name"):
        rt.load_law("torque")
    with pytest.raises(ValueError, match="cannot be called 'body'"):
        rt.load_law("x", body="kg")
    with pytest.raises(ValueError, match="unknown unit 'newton'"):
        rt.load_law("x", force="newton")


def test_law_describes_itself_in_the_registry():
    kind = registry.kinds("load")["turn back"]
    assert kind.summary == "A torsion spring and damper to the ground."
    assert kind.source == "test."
    assert registry.kinds("load")["wind"].source.endswith("test_load_law.wind")


def test_inverse_dynamics_says_which_law_has_no_value_and_how_often():
    m = block().load("w", "unsteady in Python", body="block").load("still", "constant", body="block")
    m.ground(O=[0, 0])
    for name, axis in (("x", "x"), ("y", "y")):
        m.driver(name, body="block", coordinate=axis, position="0*t")
    m.driver("turn", body="block", coordinate="angle", angle="0*t")
    r = m.inverse_dynamics([0.0, 0.02, 0.06, 0.08])
    assert np.isfinite(r["x.force"][:2]).all()
    assert np.isnan(r["x.force"][2:]).all()
    (note,) = [one for one in r.trust.notes if "loads.w" in one]
    assert "raised ValueError: no wind any more at t = 0.06 s; no forces at 2 of 4 instants" in note


# ---------------------------------------------------------------- between two
def pair():
    """Two free bodies that turn and fly."""
    m = rt.Mechanism("pair")
    for n, name in enumerate(("one", "two"), 1):
        m.body(name, mass=n, inertia=0.3 * n, points={"P": [0.2, 0.1 * n]})
        m.initial(name, x=0.7 * n, y=0.1 - n, vx=0.5 - n, vy=0.2, angle=0.3 * n, omega=1.5 - n)
    return m


@pytest.mark.parametrize("kind", ["pull", "pull plainly", "pull slowly"])
def test_spring_between_two_points_written_in_python_moves_like_the_built_in_one(kind):
    fields = {"connect": ["one.P", "two.P"], "stiffness": 20, "damping": 0.4}
    own = pair().load("L", kind, rest="0.5 m", **fields).simulate(1.0, rtol=1e-10, t_eval=[0.5, 1.0])
    built_in = pair().load("L", "spring", free_length="0.5 m", **fields).simulate(1.0, rtol=1e-10, t_eval=[0.5, 1.0])
    for name in ("one.x", "one.angle", "two.y", "two.omega"):
        np.testing.assert_allclose(own[name], built_in[name], atol=1e-11)


@pytest.mark.parametrize("kind", ["rubber", "rubber plainly"])
def test_law_between_bodies_keeps_momentum_and_angular_momentum_and_its_work_is_what_the_pair_gains(kind):
    m = pair().load("L", kind, connect=["one.P", "two.P"], k=15, twist="2 N*m/rad")
    r = m.simulate(1.0, rtol=1e-11, t_eval=np.linspace(0, 1, 5))
    px, py, turn = 0.0, 0.0, 0.0
    for mass, name in ((1, "one"), (2, "two")):
        x, y, vx, vy = (r[f"{name}.{key}"] for key in ("x", "y", "vx", "vy"))
        px, py = px + mass * vx, py + mass * vy
        turn = turn + mass * (x * vy - y * vx) + 0.3 * mass * r[f"{name}.omega"]
    for kept in (px, py, turn):
        np.testing.assert_allclose(kept, kept[0], atol=1e-9)
    gained = r["energy.kinetic"] - r["energy.kinetic"][0]
    assert np.abs(gained).max() > 0.1
    np.testing.assert_allclose(r["energy.work"], gained, atol=1e-8)


def test_law_between_two_points_has_a_kind_and_names_its_faults():
    assert list(registry.kinds("load")["pull"].fields) == ["connect", "stiffness", "rest", "damping"]
    with pytest.raises(rt.ModelError, match=r"loads.L: needs connect"):
        _ = pair().load("L", "pull", stiffness=1, rest=0, damping=0).model
    with pytest.raises(ValueError, match="between must be 'points' or 'bodies', got 'line'"):
        rt.load_law("other", between="line")(pull)
    with pytest.raises(ValueError, match="a field cannot be called 'connect'"):
        rt.load_law("other", between="points", connect="m")(pull)
    rt.load_law("broken", between="points")(lambda t, length, rate, p: 1.0 / (t - 0.1) if t > 0.2 else math.nan)
    r = pair().load("L", "broken", connect=["one.P", "two.P"]).simulate(0.1)
    assert not r.success
    assert "loads.L: load law 'broken' gives nan at t = 0" in r.message


def test_function_in_place_of_a_value_is_refused_with_what_to_do():
    m = block().load("L", "torque", body="block", torque=math.sin)
    with pytest.raises(rt.ModelError, match=r"loads.L.torque: a Python function cannot stand for .*@rt.load_law"):
        _ = m.model
