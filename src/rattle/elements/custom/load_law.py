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

The function is translated and runs as fast as the built-in loads, see `law_kernel`; with compiled=False it runs as
plain Python.  Its power counts as work done from outside.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Sequence
from itertools import islice
from typing import Any

import numpy as np

from rattle import registry
from rattle.elements.custom.law_forms import FORMS, Form
from rattle.elements.custom.law_kernel import Law, UsersKernel, place_of
from rattle.errors import InputError
from rattle.interfaces.loads import LoadKind
from rattle.jit import layout as at
from rattle.language.units import dimension_of
from rattle.registry import Field
from rattle.wrong_arguments import answer_in_words

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
            text += "\n\nSource: " + place_of(law, f"load law '{name}'")
        form = FORMS[between]
        own = {key: Field(unit, key.replace("_", " "), live=True) for key, unit in fields.items()}
        leaf = type(law.__name__, (LoadKind,), {"__doc__": text, "__module__": law.__module__, **form.place, **own})
        registry.kind("load", name, LawKernel(name, law, tuple(fields), compiled, form))(leaf)
        return law

    if name in registry.kinds("load") and not isinstance(registry.kinds("load")[name].kernel, LawKernel):
        raise InputError(f"load law '{name}': a built-in load has this name; choose another")
    return enter


class LawKernel(UsersKernel):
    """The kernel of a law: calls the user's function with the kernel signature of loads."""

    def __init__(self, name: str, law: Law, keys: Sequence[str], compiled: bool = True, form: Form = FORMS[""]) -> None:
        self.name, self.form = name, form
        super().__init__("load", f"load law '{name}'", law, keys, form.sizes, form.result, compiled)

    def plain(self) -> Law:
        """The kernel for plain Python."""
        return self.calling(self.evaluate)

    def calling(self, law: Law) -> Law:
        """The kernel for plain Python with another law: (t, arguments, values) -> result."""
        return self.form.kernel(
            lambda t, *arguments: law(float(t), _floats(arguments[:-1]), arguments[len(arguments) - 1]), self.fields
        )

    def around(self, law: Law) -> Law:
        """The kernel with this law in it, for machine code."""
        return self.form.kernel(law, self.fields)

    def flat(self, *flattened: float) -> Sequence[float]:
        """What the law returns as plain Python; arguments and result are numbers one after the other."""
        numbers = iter(flattened[1:])
        arguments = [tuple(islice(numbers, size)) if size else next(numbers) for size in self.sizes[1:]]
        result = self.evaluate(flattened[0], arguments, tuple(numbers))
        return result if isinstance(result, tuple) else (result,)

    @property
    def several(self) -> bool:
        """Whether the law returns several numbers."""
        return isinstance(self.form.result, tuple)

    def evaluate(self, t: float, arguments: Sequence[object], values: Sequence[float]) -> float | tuple[float, ...]:
        """What the law returns [N, N*m]; nan if it raises, and the exception is kept for `complaint`.

        t: time [s]; arguments: of the law between t and the fields [SI]; values: of the fields [SI].
        """
        nothing = (math.nan,) * len(self.form.result) if self.several else math.nan
        if interrupted():  # do not call the law again: the run ends
            return nothing
        try:
            result = self.law(t, *arguments, self.pack(*values))
            if not self.several:
                return float(result)
            fx, fy, torque = result
            return float(fx), float(fy), float(torque)
        except BaseException as error:  # a run does not stop at an exception, not even at Ctrl-C
            note(self.name, t, error)
            return nothing


def _floats(value: Any) -> Any:
    """Numbers of Python in place of those of NumPy, which divide by zero without an exception."""
    return float(value) if np.ndim(value) == 0 else tuple(_floats(item) for item in value)


def note(name: str, t: float, error: BaseException) -> None:
    """Keep the exception that a law raised at a time [s] while a kernel called it."""
    _raised.law, _raised.t, _raised.error = name, t, error


def interrupted() -> bool:
    """True once Ctrl-C has come while a law ran."""
    return isinstance(getattr(_raised, "error", None), KeyboardInterrupt)


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
    heard: list[float | tuple[float, ...]] = []

    def law(t: float, arguments: Sequence[object], values: Sequence[float]) -> float | tuple[float, ...]:
        heard.append(kernel.evaluate(t, arguments, values))
        return heard[-1]

    a, b, k = (int(load[column]) for column in (at.END_A, at.END_B, at.FIRST_P))
    kernel.calling(law)(t, body, a, b, values, k, np.zeros((len(body), 3)), np.zeros(4))
    if np.isfinite(heard[0]).all():
        return ""
    return complaint(t) or f"load law '{kernel.name}' gives {heard[0]} at t = {t:.6g} s"
