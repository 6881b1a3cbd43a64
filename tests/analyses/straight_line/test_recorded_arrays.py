"""Arrays that follow from parameters are those of the model that is read with other values."""

import numpy as np
import pytest

import rattle as rt
from rattle.analyses.assembly.start_constants import constants_of, with_constants
from rattle.analyses.straight_line.recorded_arrays import RecordedArrays, recorded_arrays
from rattle.description.read_parameters import chosen_parameters
from rattle.equations.system import System, compile_system
from rattle.errors import ModelError, TraceError

SHARES = (0.0, 1e-7, -0.003, -0.05, 0.3)  # changes of a parameter, in shares of it
ULPS = 8.0  # of an entry: functions of a graph are not those of Python
LOST = {  # the outline of a cam is looked at as a whole, a size that a fit is looked up by stands in no formula
    "cam_lift_off": ("R", "h"), "gripper": ("d",),
}  # fmt: skip
CANCELS = {"rimless_wheel": ("a",)}  # its mass centre is zero but for rounding
WHOLE = ("ratchet",)  # its number of teeth has to be one
RARE = (("ratchet", "teeth"), ("bouncing_pin", "mu"))  # whole numbers alone; 0 alone, where there is no friction
OF_TABLE = 1e-13  # of the largest entry: coefficients of splines, of logarithms that processors round otherwise


def _recorded(m: rt.Mechanism, names: list[str] | None = None) -> RecordedArrays:
    return recorded_arrays(m._document, m.system, names)


def _read(m: rt.Mechanism, values: dict[str, float]) -> System | None:
    """The system that is read with other values, with the constants of this mechanism; None where it is refused."""
    try:
        return compile_system(with_constants(m.set(values).model, dict(constants_of(m.system.model))))
    except ModelError:
        return None


def _same(m: rt.Mechanism, made: RecordedArrays, values: dict[str, float]) -> bool:
    """Compare with what is read; False where the model has another form."""
    known = made.inputs(m.system)
    known[: len(made.names)] = [values.get(name, x) for name, x in zip(made.names, known, strict=False)]
    found, wanted = made.at(known), _read(m, values)
    if found is None:
        return False
    assert wanted is not None, f"{values} are refused"
    numbers, facts = found
    own, image = m.system.plain_workspace(), wanted.plain_workspace()
    for name, array in {**wanted.arrays, "signals": image.signals, "element_state": image.element_state}.items():
        patched = (m.system.arrays[name] if name in m.system.arrays else getattr(own, name)).copy()
        assert patched.shape == array.shape, f"{name}: {values}"
        if name in numbers:
            patched.ravel()[made.entries[name]] = numbers[name]
        if array.dtype.kind != "f":
            assert np.array_equal(patched, array), f"{name}: {values}"
            continue
        alike = (patched == array) | (np.isnan(patched) & np.isnan(array))
        size = np.abs(array).max(initial=0.0) * OF_TABLE if name == "film_coefficients" else 0.0
        near = ULPS * np.spacing(np.where(alike, 0.0, np.abs(array))) + size
        assert (alike | (np.abs(np.where(alike, 0.0, patched) - np.where(alike, 0.0, array)) <= near)).all(), (
            f"{name}: {values}"
        )
    for name in ("size", "extent"):
        here = facts.get(name, getattr(m.system, name))
        assert abs(here - getattr(wanted, name)) <= ULPS * np.spacing(here), f"{name}: {values}"
    for name in ("t_end", "rtol", "atol", "step", "output"):
        there = getattr(wanted.model.settings, name)
        here = facts.get(name, getattr(m.model.settings, name))
        assert here == there or abs(here - there) <= ULPS * np.spacing(here), f"{name}: {values}"
    return True


@pytest.mark.parametrize("name", rt.examples())
def test_arrays_of_every_parameter_are_those_that_are_read(name: str) -> None:
    m = rt.example(name)
    names = [key for key in chosen_parameters(m._document) if key not in (*LOST.get(name, ()), *CANCELS.get(name, ()))]
    made, random = _recorded(m, names), np.random.default_rng(0)
    assert _same(m, made, {}), "the form at hand"
    for key in made.names:
        value = m.parameters[key]
        held = sum(_same(m, made, {key: value + share * (value or 1.0)}) for share in SHARES)
        assert held > 2 or (name, key) in RARE, f"no other value of {key} has the form"
    several = 0
    for size in (1e-3, 1e-3, 0.01, 0.03):
        values = {key: m.parameters[key] * (1.0 + size * random.uniform(-1.0, 1.0)) for key in made.names}
        several += _same(m, made, values)
    assert several or name in WHOLE, "several parameters at once leave the form"


@pytest.mark.parametrize(("name", "lost"), LOST.items())
def test_a_parameter_that_loses_its_record_is_noticed(name: str, lost: tuple[str, ...]) -> None:
    m = rt.example(name)
    for one in lost:
        with pytest.raises(TraceError, match="without its record"):
            _recorded(m, [one])


def test_the_flag_is_false_where_a_part_appears() -> None:
    m = rt.example("bouncing_pin").set(mu=0.0)
    made = _recorded(m)
    given = made.inputs(m.system)
    assert made.at(given) is not None
    given[made.names.index("mu")] = 0.1  # friction, which needs a law
    assert made.at(given) is None


def test_the_period_and_the_values_of_a_table_follow() -> None:
    m = rt.Mechanism("rotor").ground(O=[0, 0]).body("rotor", points={"O": [0, 0]}, mass=1.0, inertia=1.0)
    m.revolute("axis", "ground.O", "rotor.O").load("M", type="torque", body="rotor", torque="f(t/1 s)")
    m.parameter("P", 0.5).parameter("k", 2.0).table("f", ["0.2*P", "0.5*P", "1.2*P"], [0, "k", 0], period="P")
    made = _recorded(m)
    assert made.names == ("P", "k")
    assert _same(m, made, {"P": 0.7, "k": 2.0})
    assert _same(m, made, {"P": 0.01, "k": -1.0})


def test_the_start_of_own_states_follows() -> None:
    m = rt.Mechanism("tank", gravity=[0, -9.81])
    m.parameter("level", 2.0).parameter("rate", 0.5).ground(O=[0, 0])
    m.bar("rod", "A", "B", length=1.0, mass=1.0).revolute("O", "ground.O", "rod.A")
    m.state("h", "-rate*h", start="3*level")
    made = _recorded(m)
    found = made.at(np.array([2.5, 0.5]))
    assert found is not None
    assert found[0]["signals"].tolist() == found[0]["element_state"].tolist() == [7.5]
