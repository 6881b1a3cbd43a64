"""Loads written in Python: `@rt.load_law` turns a function into a kind of load.

    @rt.load_law("drag", c="N*s^2/m^2")
    def drag(t, state, p):
        x, y, angle, vx, vy, omega = state      # of the body's mass centre
        speed = math.hypot(vx, vy)
        return -p.c * speed * vx, -p.c * speed * vy, 0.0

    m.load("air", "drag", body="ball", c=0.02)

The function is compiled by Numba and runs as fast as the built-in loads.  If Numba cannot compile it, or with
compiled=False, it runs as plain Python: slower, because every evaluation goes through the interpreter.
Its power counts as work done from outside.
"""

from __future__ import annotations

import ctypes
import logging
import math
import threading
from collections import namedtuple
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from rattle import registry
from rattle.jit import layout as at
from rattle.jit.functions import KernelFunction, users_law
from rattle.language.units import dimension_of
from rattle.registry import Field

log = logging.getLogger("rattle")

Law = Callable[..., Any]  # (t, state, p) -> (fx, fy, torque)
FIELDS = ("type", "body")  # keys of every load, not available as fields of a law
_raised = threading.local()  # the exception that a law raised while machine code called it


def load_law(name: str, *, compiled: bool = True, **fields: str) -> Callable[[Law], Law]:
    """Decorator: register a function as a kind of load on one body.

    law(t, state, p) -> (fx, fy, torque): force at the mass centre in the ground frame [N], moment [N*m], from the
    time [s], state = (x, y, angle, vx, vy, omega) of the body [SI] and p, a named tuple of the fields [SI].
    name: the name used in model files.  fields: name and unit of every number that the user gives; their values may
    be expressions in t, state and signals.  compiled: False runs the function as plain Python, which is slower.

    Raises ValueError for a name in use, a field that is not an identifier, and an unknown unit.
    """
    for key, unit in fields.items():
        if key in FIELDS or key.startswith("_"):
            raise ValueError(f"load law '{name}': a field cannot be called '{key}'")
        dimension_of(unit)

    def enter(law: Law) -> Law:
        text = (law.__doc__ or f"The load '{name}', written in Python.").strip()
        if "Source:" not in text:
            text += f"\n\nSource: {law.__module__}.{law.__qualname__}"
        own = {key: Field(unit, key.replace("_", " "), live=True) for key, unit in fields.items()}
        place = Field("", "body on which the load acts", shape="body")
        leaf = type(law.__name__, (), {"__doc__": text, "__module__": law.__module__, "body": place, **own})
        registry.kind("load", name, LawKernel(name, law, tuple(fields), compiled))(leaf)
        return law

    if name in registry.kinds("load") and not isinstance(registry.kinds("load")[name].kernel, LawKernel):
        raise ValueError(f"load law '{name}': a built-in load has this name; choose another")
    return enter


class LawKernel(KernelFunction):
    """The kernel of a law: calls the user's function with the kernel signature of loads."""

    def __init__(self, name: str, law: Law, keys: Sequence[str], compiled: bool) -> None:
        self.name, self.law, self.keys, self.compiled = name, law, tuple(keys), compiled
        self.pack: Any = namedtuple("p", keys)  # type: ignore[misc]  # its keys are data
        super().__init__(_plain(self), "load", ours=False)
        self._native: KernelFunction | None = None
        self._callback: Any = None  # must live as long as machine code may call it

    @property
    def dispatcher(self) -> Any:
        """The Numba dispatcher, made on first use."""
        if self._native is None:
            self._native = self._make()
        return self._native.dispatcher

    def _make(self) -> KernelFunction:
        if self.compiled:
            try:
                made = KernelFunction(_native(self), "load", ours=False)
                _ = made.dispatcher
                return made
            except Exception as error:  # whatever Numba's error is, plain Python works
                reason = next((line for line in str(error).splitlines() if line.strip()), type(error).__name__)
                log.warning(f"load law '{self.name}' runs as plain Python, slower: Numba cannot compile it ({reason})")
        else:
            log.info(f"load law '{self.name}' runs as plain Python, slower (compiled=False)")
        self._callback = _callback(self)
        return KernelFunction(_through(self._callback), "load", ours=False)

    def evaluate(self, t: float, state: Sequence[float], values: Sequence[float]) -> tuple[float, float, float]:
        """Force [N] (fx, fy) and moment [N*m]; nan if the law raises, and the exception is kept for `complaint`.

        t: time [s]; state: (6,) of the body [m, rad, m/s, rad/s]; values: of the fields [SI].
        """
        if isinstance(getattr(_raised, "error", None), KeyboardInterrupt):  # do not call the law again: the run ends
            return math.nan, math.nan, math.nan
        try:
            fx, fy, torque = self.law(t, tuple(state), self.pack(*values))
            return float(fx), float(fy), float(torque)
        except BaseException as error:  # machine code cannot pass on an exception, not even Ctrl-C
            _raised.law, _raised.t, _raised.error = self.name, t, error
            return math.nan, math.nan, math.nan


def forget() -> None:
    """Forget the exception that a law raised in this thread."""
    _raised.error = None


def complaint(since: float) -> str:
    """The last exception of a law in this thread at or after the time `since` [s], in words; "" if there was none.

    Ctrl-C (KeyboardInterrupt) is raised again.
    """
    error = getattr(_raised, "error", None)
    if error is None or _raised.t < since:
        return ""
    if not isinstance(error, Exception):
        forget()
        raise error
    return f"load law '{_raised.law}' raised {type(error).__name__}: {error} at t = {_raised.t:.6g} s"


def failure(kind: str, t: float, body: np.ndarray, values: np.ndarray) -> str:
    """Why the user's law of a kind of load has no finite value, found by running it as plain Python; "" if it has one.

    t: time [s]; body: (8,) row of the body [SI]; values: (n,) of the fields [SI], in their order.
    """
    kernel = registry.kinds("load")[kind].kernel
    if not isinstance(kernel, LawKernel):
        return ""
    forget()
    found = kernel.evaluate(t, [float(one) for one in body[:6]], [float(one) for one in values[: len(kernel.keys)]])
    if all(math.isfinite(one) for one in found):
        return ""
    return complaint(t) or f"load law '{kernel.name}' gives {found} at t = {t:.6g} s"


# ---------------------------------------------------------------- the kernel in its three forms
def _plain(kernel: LawKernel) -> Callable[..., None]:
    """The kernel for plain Python."""
    count = len(kernel.keys)

    def run(t: Any, body: Any, a: Any, b: Any, p: Any, k: Any, force: Any, energy: Any) -> None:
        values = [float(one) for one in p[k : k + count]]
        fx, fy, torque = kernel.evaluate(float(t), [float(one) for one in body[b, :6]], values)
        force[b, at.X] += fx
        force[b, at.Y] += fy
        force[b, at.PHI] += torque
        energy[at.OUTSIDE] += fx * body[b, at.VX] + fy * body[b, at.VY] + torque * body[b, at.W]

    return run


def _native(kernel: LawKernel) -> Callable[..., None]:
    """The kernel for machine code, with the law compiled into it."""
    law, part = users_law(kernel.law, len(kernel.keys))
    pack = kernel.pack

    def run(t: Any, body: Any, a: Any, b: Any, p: Any, k: Any, force: Any, energy: Any) -> None:
        kept = force[b, at.X]
        force[b, at.X] = math.nan  # stays nan if the law raises: machine code does not stop at an exception
        state = (body[b, at.X], body[b, at.Y], body[b, at.PHI], body[b, at.VX], body[b, at.VY], body[b, at.W])
        fx, fy, torque = law(t, state, pack(*part(p, k)))
        force[b, at.X] = kept + fx
        force[b, at.Y] += fy
        force[b, at.PHI] += torque
        energy[at.OUTSIDE] += fx * body[b, at.VX] + fy * body[b, at.VY] + torque * body[b, at.W]

    return run


def _callback(kernel: LawKernel) -> Any:
    """The law as a C function of pointers to state, field values and result."""
    number = ctypes.POINTER(ctypes.c_double)
    count = len(kernel.keys)

    def call(t: float, row: int, values: int, force: int, energy: int) -> None:
        state = ctypes.cast(row, number)[:6]
        # an empty array of values has no address
        given = ctypes.cast(values, number)[:count] if count else []
        on_body, rate = ctypes.cast(force, number), ctypes.cast(energy, number)
        for n, part in enumerate(kernel.evaluate(t, state, given)):
            on_body[n] += part
            rate[at.OUTSIDE] += part * state[at.VX + n]

    address = ctypes.c_void_p
    return ctypes.CFUNCTYPE(None, ctypes.c_double, address, address, address, address)(call)


def _through(callback: Any) -> Callable[..., None]:
    """The kernel for machine code that calls back into Python."""

    def run(t: Any, body: Any, a: Any, b: Any, p: Any, k: Any, force: Any, energy: Any) -> None:
        callback(t, body[b].ctypes, p[k:].ctypes, force[b].ctypes, energy.ctypes)

    return run
