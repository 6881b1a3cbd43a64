"""Contact laws written in Python: `@rt.normal_law` and `@rt.friction_law` turn functions into kinds.

    @rt.normal_law("stiffening", c="s/m")
    def stiffening(static, delta, ddelta, v0, p):        # F [N]; static: the force of the stiffness at this depth
        return static * (1.0 + p.c * ddelta)

    @rt.friction_law("plateau", mu="", v1="m/s")
    def plateau(u, N, p):                                # T [N] against the slip u [m/s]
        return p.mu * N * min(1.0, abs(u) / p.v1) * math.copysign(1.0, u)

    contact = { model = "stiffening", c = "2 s/m", stiffness = 1e9, bush_radius = "1 cm",
                friction = { model = "plateau", mu = 0.1, v1 = "1 mm/s" } }

The functions are translated and run as fast as the built-in laws; one that is refused runs as plain Python, slower, see
`law_kernel`.
A law that pulls or returns energy is detected and named by `rattle.analyses.law_check`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rattle import registry
from rattle.elements.custom import load_law
from rattle.elements.custom.law_kernel import Law, UsersKernel, place_of, taking
from rattle.errors import InputError
from rattle.interfaces.laws import FrictionLaw, NormalLaw
from rattle.jit import layout as at
from rattle.jit.families import Kind
from rattle.jit.functions import KernelFunction
from rattle.language.units import dimension_of
from rattle.registry import Field
from rattle.wrong_arguments import answer_in_words

Array = NDArray[np.float64]
LIGHT = 1e-30  # normal force [N] with which a law of friction is asked where damping has brought it to zero
TAKEN = {
    "normal": (
        "model", "friction", "stiffness", "exponent", "bush_radius", "bush_material", "pin_material", "geometry",
        "length",
    ),
    "friction": ("model",),
}  # fmt: skip


@answer_in_words
def normal_law(name: str, **fields: str) -> Callable[[Law], Law]:
    """Decorator: register a function as a normal force law of compliant contacts.

    law(static, delta, ddelta, v0, p) -> F: normal force [N], from the static force of the joint's stiffness [N],
    penetration [m], its rate [m/s], approach speed of this contact [m/s] and p, a named tuple of the fields [SI].
    A negative force is replaced by zero: a contact never pulls.
    name: the name used in model files.  fields: name and unit of every number that the user gives.

    Raises InputError for a name in use, for a field that is not an identifier or that every contact has, and for an
    unknown unit.
    """
    return _enter("normal", name, fields, 0)


@answer_in_words
def friction_law(name: str, *, memory: bool = False, states: int = 0, **fields: str) -> Callable[[Law], Law]:
    """Decorator: register a function as a friction law of compliant contacts.

    law(u, N, p) -> T: friction force [N] against the slip u [m/s] under the normal force N [N]; with states=1
    (or memory=True) law(u, N, z, p) -> (T, dz): z is a state of the law, in any unit, zero at the start of a contact,
    and dz its rate.  With several states z and dz are tuples.
    name, fields: as for `normal_law`.  Raises what `normal_law` raises.
    """
    if states < 0:
        raise InputError(f"friction law '{name}': {states} states; expected 0, 1, 2, ...")
    return _enter("friction", name, fields, max(states, int(memory)))


def _enter(family: str, name: str, fields: dict[str, str], states: int) -> Callable[[Law], Law]:
    for key, unit in fields.items():
        if key in TAKEN[family] or key.startswith("_"):
            raise InputError(f"{family} law '{name}': a field cannot be called '{key}'")
        dimension_of(unit)
    entered = registry.kinds(family)
    if name in entered and not isinstance(entered[name].kernel, ContactLaw):
        raise InputError(f"{family} law '{name}': a built-in law has this name; choose another")
    if family == "normal" and name in registry.kinds("contact"):
        raise InputError(f"normal law '{name}': a built-in contact model has this name; choose another")

    def enter(law: Law) -> Law:
        text = (law.__doc__ or f"The {family} law '{name}', written in Python.").strip()
        if "Source:" not in text:
            text += "\n\nSource: " + place_of(law, f"{family} law '{name}'")
        own = {key: Field(unit, key.replace("_", " ")) for key, unit in fields.items()}
        keys = tuple(fields)
        pack = staticmethod(lambda values: tuple(float(values[key]) for key in keys))
        common = {"__doc__": text, "__module__": law.__module__, "pack": pack, "states": states}
        base = NormalLaw if family == "normal" else FrictionLaw
        leaf = type(law.__name__, (base,), {**common, **own})
        registry.kind(family, name, ContactLaw(family, name, law, keys, states))(leaf)
        return law

    return enter


class ContactLaw(UsersKernel):
    """The kernel of a law: calls the user's function with the kernel signature of the family."""

    def __init__(self, family: str, name: str, law: Law, keys: tuple[str, ...], states: int) -> None:
        self.name, self.states = name, states
        sizes: tuple[int, ...] = (0, 0, 0, 0)
        result: Kind = "f"
        if family == "friction":
            sizes = (0, 0) if not states else (0, 0, 0 if states == 1 else states)
            result = "f" if not states else ("f", "f" if states == 1 else ("f",) * states)
        super().__init__(family, f"{family} law '{name}'", law, keys, sizes, result, True)

    def plain(self) -> Law:
        """The kernel for plain Python."""
        return self.around(self.law)

    def around(self, law: Law) -> Law:
        """The kernel with this law in it."""
        if self.family == "normal":
            return _normal(law, self.fields)
        if self.states < 2:
            return (_without, _with_one)[self.states](law, self.fields)
        return _with_many(law, self.fields, taking("", self.states), self.states)

    def flat(self, *flattened: float) -> Sequence[float]:
        """What the law returns as plain Python; arguments and result are numbers one after the other."""
        numbers = iter(flattened)
        arguments = [tuple(islice(numbers, size)) if size else next(numbers) for size in self.sizes]
        if load_law.interrupted():  # do not call the law again: the run ends
            raise InterruptedError
        try:
            result = self.law(*arguments, self.pack(*numbers))
        except KeyboardInterrupt as error:  # it is raised again when the run has ended
            load_law.note(self.name, math.inf, error)
            raise
        return tuple(_numbers(result))


def _numbers(result: Any) -> Iterator[float]:
    for item in result if isinstance(result, tuple | list) else [result]:
        yield from _numbers(item) if isinstance(item, tuple | list | np.ndarray) else [float(item)]


# an exception is nan, which ends the run with a message
def _normal(law: Law, fields: Law) -> Law:
    def run(static: float, delta: float, ddelta: float, v0: float, p: Array, k: int) -> float:
        if delta <= 0.0:
            return 0.0
        try:
            return max(0.0, float(law(static, delta, ddelta, v0, fields(p, k))))
        except Exception:
            return math.nan

    return run


def _without(law: Law, fields: Law) -> Law:
    def run(u: float, N: float, z: Array, p: Array, k: int, dz: Array) -> float:
        try:
            return float(law(u, max(N, LIGHT), fields(p, k)))
        except Exception:
            return math.nan

    return run


def _with_one(law: Law, fields: Law) -> Law:
    def run(u: float, N: float, z: Array, p: Array, k: int, dz: Array) -> float:
        dz[0] = 0.0
        try:
            force, rate = law(u, max(N, LIGHT), z[0], fields(p, k))
            dz[0] = rate
            return float(force)
        except Exception:
            return math.nan

    return run


def _with_many(law: Law, fields: Law, own: Law, states: int) -> Law:
    def run(u: float, N: float, z: Array, p: Array, k: int, dz: Array) -> float:
        for n in range(states):
            dz[n] = 0.0
        try:
            force, rates = law(u, max(N, LIGHT), own(z, 0), fields(p, k))
            for place, rate in enumerate(rates):
                dz[place] = rate
            return float(force)
        except Exception:
            return math.nan

    return run


# ---------------------------------------------------------------- why a law has no value
def failure(
    contact: np.ndarray, kinematics: np.ndarray, memory: np.ndarray, states: np.ndarray, values: np.ndarray
) -> str:
    """Why a user's law has no finite value in one contact, found by running it as plain Python; "" if it has one.

    contact, kinematics, memory: rows of the contact in the workspace.  states: (n,) of all elements.
    values: (n,) parameters of all elements [SI].
    """
    delta, ddelta = -float(kinematics[at.GAP]), -float(kinematics[at.DGAP])
    if delta <= 0.0 or contact[at.IMPACT] == 1:
        return ""
    where = f"at a penetration of {delta:.4g} m"
    static = _kernel("stiffness", contact[at.STATIC]).python(delta, values, int(contact[at.STATIC_P]))
    law = _kernel("normal", contact[at.NORMAL_LAW])
    force = float(kinematics[at.NORMAL])
    if isinstance(law, ContactLaw):
        force, why = _tried(
            law, where, (static, delta, ddelta, float(memory[at.SPEED])), values[contact[at.NORMAL_P] :]
        )
        if why:
            return why
    rubs = _kernel("friction", contact[at.FRICTION]) if contact[at.FRICTION] >= 0 else None
    if isinstance(rubs, ContactLaw) and force > 0.0:
        first = contact[at.FIRST_STATE]
        own = tuple(float(z) for z in states[first : first + rubs.states])
        state = own if rubs.states == 1 else (own,) if own else ()
        where = f"at a slip of {float(kinematics[at.SLIP]):.4g} m/s under {force:.4g} N"
        _, why = _tried(rubs, where, (float(kinematics[at.SLIP]), force, *state), values[contact[at.FRICTION_P] :])
        return why
    return ""


def _kernel(family: str, tag: float) -> KernelFunction:
    """A kernel by its index in the table of its family; the law of strands follows on the normal laws."""
    family_kinds = list(registry.kinds(family).values())
    if family == "normal":
        family_kinds += registry.kinds("tension").values()
    kernels: list[KernelFunction] = [kind.kernel for kind in family_kinds if kind.kernel is not None]
    return kernels[int(tag)]


def _tried(kernel: ContactLaw, where: str, arguments: tuple[object, ...], values: np.ndarray) -> tuple[float, str]:
    """Force [N] of a law, and in words why it has no finite value ("" if it has one)."""
    name = f"{kernel.family} law '{kernel.name}'"
    fields = kernel.pack(*(float(number) for number in values[: len(kernel.pack._fields)]))
    try:
        result = kernel.law(*arguments, fields)
        force, *rate = result if isinstance(result, tuple) else (result,)
        if all(np.isfinite(number).all() for number in (force, *rate)):
            return float(force), ""
    except Exception as error:  # any exception of the user's function is reported
        return math.nan, f"{name} raised {type(error).__name__}: {error} ({where})"
    return math.nan, f"{name} gives {result} {where}"
