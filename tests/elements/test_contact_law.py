"""Contact laws written in Python: as good and as fast as those of the package, and found out when they cheat."""

import math
import sys

import numpy as np
import pytest

import rattle as rt
from rattle import registry
from rattle.elements.custom.contact_law import friction_law, normal_law
from rattle.errors import ModelError
from rattle.jit import functions

BUSH = """
format = 1
[ground.points]
O = [0, 0]
[bodies.pin]
points = {{ P = [0, 0] }}
mass = 1
inertia = 1e-3
[joints.O]
type = "revolute"
connect = ["ground.O", "pin.P"]
clearance = "1 mm"
contact = {contact}
[initial]
pin = {{ x = 0, y = 0.0003, angle = 0, vx = 0.5, vy = {vy}, omega = 0 }}
"""


def free_pin(contact, vy=0.0):
    return rt.loads(BUSH.format(contact=contact, vy=vy))


@pytest.mark.usefixtures("laws")
def test_a_law_of_ones_own_is_the_law_of_the_package():
    @normal_law("mine", a="")
    def mine(static, delta, ddelta, v0, p):
        return static * (1.0 + p.a * ddelta / v0)

    @friction_law("smooth", mu="", v1="m/s")
    def smooth(u, N, p):
        return p.mu * N * math.tanh(u / p.v1)

    given = 'stiffness = 1e9, bush_radius = "10 mm", '
    friction = '{ model = "smooth", mu = 0.2, v1 = "1 mm/s" }'
    own = free_pin(f'{{ model = "mine", a = 0.75, {given} friction = {friction} }}', 0.4)
    theirs = free_pin(
        f'{{ model = "hunt-crossley", restitution = 0.5, {given} '
        'friction = { model = "coulomb-smooth", mu = 0.2 } }',
        0.4,
    )
    times = np.linspace(0, 0.01, 50)
    one, two = own.simulate(t_eval=times), theirs.simulate(t_eval=times)
    for name in ("pin.x", "pin.y", "pin.angle", "O.normal", "energy.dissipated"):
        # the same formula; one's own does not go on beyond the end of a contact, where steps differ
        assert one[name] == pytest.approx(two[name], rel=1e-7, abs=1e-11)
    assert one.trust.notes == tuple(note for note in two.trust.notes if "restitution" not in note)


@pytest.mark.usefixtures("laws")
def test_a_friction_law_may_have_a_memory():
    @friction_law("bristle", memory=True, mu="", sigma="1/m")
    def bristle(u, N, z, p):  # Dahl's law with the exponent 1, see laws/friction.py
        root = math.sqrt(N)
        held = math.copysign(p.sigma * z / p.mu, u * z)
        rate = root - held
        return min(max(root * p.sigma * z, -p.mu * N), p.mu * N), u * rate

    given = 'model = "exact", restitution = 0.5, stiffness = 1e9, bush_radius = "10 mm"'
    own = free_pin(f'{{ {given}, friction = {{ model = "bristle", mu = 0.2, sigma = 1e4 }} }}', 0.4).simulate(0.003)
    theirs = free_pin(f'{{ {given}, friction = {{ model = "dahl", mu = 0.2, sigma = 1e4 }} }}', 0.4).simulate(0.003)
    assert own["pin.omega"][-1] == pytest.approx(theirs["pin.omega"][-1], rel=1e-5)
    assert abs(own["pin.omega"][-1]) > 1.0


@pytest.mark.usefixtures("laws")
def test_a_law_runs_as_machine_code_like_the_built_in_ones():
    @normal_law("quick", a="")
    def quick(static, delta, ddelta, v0, p):
        return static * (1.0 + p.a * ddelta / v0)

    if not functions.start():
        pytest.skip("runs without machine code")
    own = free_pin('{ model = "quick", a = 0.1, stiffness = 1e9 }')
    theirs = free_pin('{ model = "hunt-crossley", restitution = 0.93333333, stiffness = 1e9 }')
    own.simulate(0.01)  # compiles, and tries the law for energy it would give back
    calls = []
    sys.setprofile(lambda frame, event, argument: calls.append(frame.f_code.co_name))
    try:
        r = own.simulate(0.2)
    finally:
        sys.setprofile(None)
    assert r.stats["evaluations"] > 1000
    assert "quick" not in calls  # machine code calls machine code: the interpreter never sees the law
    assert theirs.simulate(0.2).trust.contacts == r.trust.contacts


@pytest.mark.usefixtures("laws")
def test_a_law_that_gives_energy_back_is_named():
    @normal_law("lively")
    def lively(static, delta, ddelta, v0, p):
        return static * (1.0 if ddelta > 0.0 else 1.2)

    m = free_pin('{ model = "lively", stiffness = 1e9 }')
    assert "O: normal law 'lively' creates energy" in str(m.check())
    r = m.simulate(0.004)
    assert any("'lively' creates energy" in note for note in r.trust.notes)
    assert len(str(r.trust).splitlines()) == 2


@pytest.mark.usefixtures("laws")
def test_a_law_that_pulls_is_named():
    @normal_law("sticky")
    def sticky(static, delta, ddelta, v0, p):
        return static - 50.0

    assert "pulls" in str(free_pin('{ model = "sticky", stiffness = 1e9 }').check())


@pytest.mark.usefixtures("laws")
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_friction_that_pushes_is_named(sign):
    @friction_law("pusher", mu="", s="")
    def pusher(u, N, p):
        return p.s * p.mu * N * math.tanh(u / 1e-3)

    friction = f'{{ model = "pusher", mu = 0.1, s = {sign} }}'
    contact = f'{{ model = "exact", restitution = 0.5, stiffness = 1e9, bush_radius = 0.01, friction = {friction} }}'
    found = free_pin(contact).check().laws
    assert bool(found) == (sign < 0)
    assert all("friction law 'pusher' creates energy" in one for one in found)


@pytest.mark.parametrize("name", sorted(registry.kinds("friction")))
def test_every_friction_law_of_the_package_passes_the_same_check(name):
    from rattle.analyses.law_check import friction_fault

    kind = registry.kinds("friction")[name]
    values = {}
    for key, entry in kind.fields.items():
        default = entry.default(values) if callable(entry.default) else entry.default
        values[key] = {"mu": 0.2, "mu_static": 0.3, "viscosity": 5.0}.get(key, default)
    assert friction_fault(kind.kernel.python, np.array([*kind.leaf.pack(values), 0.0]), kind.leaf.states) == ""


@pytest.mark.parametrize("e", [0.1, 0.5, 1.0])
@pytest.mark.parametrize("name", sorted(registry.kinds("normal")))
def test_every_normal_law_of_the_package_passes_the_same_check(name, e):
    from rattle.analyses.law_check import normal_fault

    kind = registry.kinds("normal")[name]
    p = np.array([*kind.leaf.pack({"restitution": e, "least_speed": 1e-3, "effective_mass": 1.0}), 0.0])
    m = free_pin('{ model = "exact", restitution = 0.5, stiffness = 1e9 }')
    assert normal_fault(kind.kernel.python, p, m.model.joints["O"].contact) == ""


@pytest.mark.usefixtures("laws")
def test_bad_laws_are_refused(caplog):
    with pytest.raises(ValueError, match="a built-in law has this name"):
        normal_law("hertz")
    with pytest.raises(ValueError, match="a built-in contact model"):
        normal_law("impact")
    with pytest.raises(ValueError, match="cannot be called 'stiffness'"):
        normal_law("x", stiffness="N/m")
    with pytest.raises(ValueError, match="unknown unit"):
        friction_law("x", mu="furlong")

    @normal_law("python only")
    def only(static, delta, ddelta, v0, p):
        return {"F": static}["F"] + len(str(delta)) * 0.0 + float(__import__("os").getpid()) * 0.0

    m = free_pin('{ model = "python only", stiffness = 1e9 }')
    m.simulate(0.001)
    if functions.start():
        assert "normal law 'python only' runs as plain Python, slower: " in caplog.text
        assert "test_contact_law.only, line" in caplog.text
    normal_law("wants", a="")(lambda static, delta, ddelta, v0, p: static)
    with pytest.raises(ModelError, match="needs a: a"):
        free_pin('{ model = "wants", stiffness = 1e9 }')


@pytest.mark.usefixtures("laws")
def test_a_law_that_raises_ends_the_run_with_a_message():
    @normal_law("raises")
    def raises(static, delta, ddelta, v0, p):
        if delta > 1e-6:
            raise ValueError("too deep")
        return static

    r = free_pin('{ model = "raises", stiffness = 1e9 }').simulate(0.01)
    assert not r.success
    assert "joint 'O': normal law 'raises' raised ValueError: too deep (at a penetration of 1" in r.message
    assert "stiff" not in r.message


@pytest.mark.usefixtures("laws")
def test_a_law_without_a_value_is_named_before_stiffness_is_blamed():
    @friction_law("undefined", mu="")
    def undefined(u, N, p):
        return p.mu * N * (math.copysign(1.0, u) if abs(u) < 1e-9 else math.nan)

    given = 'model = "hertz", stiffness = 1e9, bush_radius = "1 cm"'
    m = free_pin(f'{{ {given}, friction = {{ model = "undefined", mu = 0.1 }} }}', 0.4)
    r = m.simulate(0.01)
    assert not r.success
    assert "friction law 'undefined' gives nan at a slip of" in r.message


@pytest.mark.usefixtures("laws")
def test_the_law_in_the_docs_runs():
    import re
    from pathlib import Path

    text = (Path(__file__).parents[2] / "docs" / "contact.md").read_text(encoding="utf-8")
    (code,) = (one for one in re.findall(r"```python\n(.*?)```", text, re.S) if "rt.normal_law" in one)
    scope = {}
    exec(code, scope)
    r = scope["m"].simulate(2e-3)
    assert r.success
    assert r.contacts["B"].contacts >= 1
    assert scope["m"].check().laws == ()
