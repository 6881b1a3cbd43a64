"""Loads written in Python: `@rt.load_law` turns a function into a kind of load, on one body or between two.

    @rt.load_law("drag", c="N*s^2/m^2")
    def drag(t, state, p):
        x, y, angle, vx, vy, omega = state      # of the body's mass centre
        speed = math.hypot(vx, vy)
        return -p.c * speed * vx, -p.c * speed * vy, 0.0

    @rt.load_law("gas spring", between="points", F0="N", k="N/m", rest="m")
    def gas_spring(t, length, rate, p):         # pushes the points apart if positive
        return p.F0 + p.k * (p.rest - length)

    m.load("air", "drag", body="ball", c=0.02)
    m.load("lift", "gas spring", connect=["ground.F", "lid.P"], F0="200 N", k="300 N/m", rest="0.4 m")

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
from rattle.elements.custom.law_forms import FORMS, Form
from rattle.errors import InputError
from rattle.jit import layout as at
from rattle.jit.functions import KernelFunction, users_law
from rattle.language.units import dimension_of
from rattle.registry import Field
from rattle.wrong_arguments import answer_in_words

log = logging.getLogger("rattle")

Law = Callable[..., Any]  # see `load_law`
FIELDS = ("type", "body", "connect")  # keys of loads, not available as fields of a law
_raised = threading.local()  # the exception that a law raised while machine code called it


@answer_in_words
def load_law(name: str, *, between: str = "", compiled: bool = True, **fields: str) -> Callable[[Law], Law]:
    """Decorator: register a function as a kind of load on one body, or between two.

    law(t, state, p) -> (fx, fy, torque): force at the mass centre in the ground frame [N], moment [N*m], from the
    time [s], state = (x, y, angle, vx, vy, omega) of the body [SI] and p, a named tuple of the fields [SI].
    between="points": law(t, length, rate, p) -> force [N] along the line between two points, which pushes them apart,
    from their distance [m] and its rate [m/s].
    between="bodies": law(t, a, b, p) -> (fx, fy, torque) on B at its point [N, N*m], from the state of both points,
    with angle and rate of their bodies; the reaction acts on A at the same place.
    name: the name used in model files.  fields: name and unit of every number that the user gives; their values may
    be expressions in t, state and signals.  compiled: False runs the function as plain Python, which is slower.

    Raises InputError for a name in use, a field that is not an identifier, an unknown unit and another `between`.
    """
    if between not in FORMS:
        raise InputError(f"load law '{name}': between must be 'points' or 'bodies', got {between!r}")
    for key, unit in fields.items():
        if key in FIELDS or key.startswith("_"):
            raise InputError(f"load law '{name}': a field cannot be called '{key}'")
        dimension_of(unit)

    def enter(law: Law) -> Law:
        text = (law.__doc__ or f"The load '{name}', written in Python.").strip()
        if "Source:" not in text:
            text += f"\n\nSource: {law.__module__}.{law.__qualname__}"
        form = FORMS[between]
        own = {key: Field(unit, key.replace("_", " "), live=True) for key, unit in fields.items()}
        leaf = type(law.__name__, (), {"__doc__": text, "__module__": law.__module__, **form.place, **own})
        registry.kind("load", name, LawKernel(name, law, tuple(fields), compiled, form))(leaf)
        return law

    if name in registry.kinds("load") and not isinstance(registry.kinds("load")[name].kernel, LawKernel):
        raise InputError(f"load law '{name}': a built-in load has this name; choose another")
    return enter


class LawKernel(KernelFunction):
    """The kernel of a law: calls the user's function with the kernel signature of loads."""

    def __init__(self, name: str, law: Law, keys: Sequence[str], compiled: bool = True, form: Form = FORMS[""]) -> None:
        self.name, self.law, self.keys, self.compiled, self.form = name, law, tuple(keys), compiled, form
        self.pack: Any = namedtuple("p", keys)  # type: ignore[misc]  # its keys are data
        super().__init__(self._plain(self.evaluate), "load", ours=False)
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
                made = KernelFunction(self._compiled(), "load", ours=False)
                _ = made.dispatcher
                return made
            except Exception as error:  # whatever Numba's error is, plain Python works
                reason = next((line for line in str(error).splitlines() if line.strip()), type(error).__name__)
                log.warning(f"load law '{self.name}' runs as plain Python, slower: Numba cannot compile it ({reason})")
        else:
            log.info(f"load law '{self.name}' runs as plain Python, slower (compiled=False)")
        return KernelFunction(self._through(), "load", ours=False)

    # ------------------------------------------------------------ the kernel in its three forms
    def _plain(self, law: Law) -> Callable[..., None]:
        """The kernel for plain Python.  law: (t, arguments, values) -> result."""
        count = len(self.keys)
        return self.form.kernel(
            lambda t, *given: law(float(t), _floats(given[:-1]), given[-1]), lambda p, k: _floats(p[k : k + count])
        )

    def _compiled(self) -> Callable[..., None]:
        """The kernel for machine code, with the law compiled into it."""
        law, part = users_law(self.law, len(self.keys))
        pack = self.pack
        given, _ = users_law(lambda p, k: pack(*part(p, k)), 0)
        return self.form.kernel(law, given)

    def _through(self) -> Callable[..., None]:
        """The kernel for machine code that calls back into Python."""
        self._callback = _callback(self)
        law, _ = users_law(self.form.called(self._callback), 0)
        given, _ = users_law(lambda p, k: p[k:], 0)
        return self.form.kernel(law, given)

    def evaluate(self, t: float, arguments: Sequence[Any], values: Sequence[float]) -> Any:
        """What the law returns [N, N*m]; nan if it raises, and the exception is kept for `complaint`.

        t: time [s]; arguments: of the law between t and the fields [SI]; values: of the fields [SI].
        """
        several = self.form.results > 1
        nothing = (math.nan,) * self.form.results if several else math.nan
        if isinstance(getattr(_raised, "error", None), KeyboardInterrupt):  # do not call the law again: the run ends
            return nothing
        try:
            found = self.law(t, *arguments, self.pack(*values))
            if not several:
                return float(found)
            fx, fy, torque = found
            return float(fx), float(fy), float(torque)
        except BaseException as error:  # machine code cannot pass on an exception, not even Ctrl-C
            _raised.law, _raised.t, _raised.error = self.name, t, error
            return nothing


def _floats(given: Any) -> Any:
    """Numbers of Python in place of those of NumPy, which divide by zero without an exception."""
    return float(given) if np.ndim(given) == 0 else tuple(_floats(one) for one in given)


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


def failure(kind: str, t: float, body: np.ndarray, load: np.ndarray, values: np.ndarray) -> str:
    """Why the user's law of a load has no finite value, found by running it as plain Python; "" if it has one.

    t: time [s]; body, load: arrays of the workspace [SI], `load` the row of the load; values: of all elements [SI].
    """
    kernel = registry.kinds("load")[kind].kernel
    if not isinstance(kernel, LawKernel):
        return ""
    forget()
    heard: list[Any] = []

    def law(*given: Any) -> Any:
        heard.append(kernel.evaluate(*given))
        return heard[-1]

    a, b, k = (int(load[one]) for one in (at.END_A, at.END_B, at.FIRST_P))
    kernel._plain(law)(t, body, a, b, values, k, np.zeros((len(body), 3)), np.zeros(4))
    if np.isfinite(heard[0]).all():
        return ""
    return complaint(t) or f"load law '{kernel.name}' gives {heard[0]} at t = {t:.6g} s"


def _callback(kernel: LawKernel) -> Any:
    """The law as a C function of t and pointers to its arguments, the field values and its result."""
    number = ctypes.POINTER(ctypes.c_double)
    form, count = kernel.form, len(kernel.keys)

    def call(t: float, arguments: int, values: int, result: int) -> None:
        passed = ctypes.cast(arguments, number)[: form.size]
        # an empty array of values has no address
        given = ctypes.cast(values, number)[:count] if count else []
        found = kernel.evaluate(t, form.inputs(passed), given)
        out = ctypes.cast(result, number)
        for n, one in enumerate(found if form.results > 1 else (found,)):
            out[n] = one

    address = ctypes.c_void_p
    return ctypes.CFUNCTYPE(None, ctypes.c_double, address, address, address)(call)
