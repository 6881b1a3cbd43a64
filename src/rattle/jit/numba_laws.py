"""Laws of users that `translation` refuses, compiled by Numba if it is installed; nothing else imports it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from rattle.jit import machine
from rattle.jit.families import Kind
from rattle.value_types import Plain

CALL = """
def run(result, {parameters}):
    try:
        {left} = law({arguments})
    except Exception:
        {left} = {nothing}
{kept}
    return 0
"""


def entry(law: Plain, pack: Any, sizes: Sequence[int], result: Kind) -> machine.Entry | None:
    """A law as a function of floats that kernels call; nan if it raises.  None if Numba is not installed.

    pack: class of the named tuple of its fields.  sizes: of its other arguments: 0 for a number, n for a tuple.
    result: kind of its result.  Raises what Numba raises if it cannot compile the law.
    """
    try:
        import numba
    except ImportError:
        return None
    if not hasattr(law, "py_func"):
        law = numba.njit(error_model="numpy")(law)
    names = (f"x{n}" for n in range(sum(max(1, size) for size in sizes) + len(pack._fields)))
    parameters: list[str] = []

    def some(size: int) -> str:
        parameters.extend(taken := [next(names) for _ in range(size)])
        return f"{', '.join(taken)}"

    arguments = [f"({some(size)},)" if size else some(1) for size in sizes]
    arguments.append(f"pack({some(len(pack._fields))})")
    stores: list[str] = []

    def place(kind: Kind, value: str = "") -> str:
        if isinstance(kind, tuple):
            return f"({''.join(f'{place(part, value)}, ' for part in kind)})"
        stores.append(f"y{len(stores)}")
        return value or stores[-1]

    left, results = place(result), len(stores)
    kept = "\n".join(f"    result[{n}] = y{n}" for n in range(results))
    text = CALL.format(
        parameters=", ".join(parameters),
        left=left,
        arguments=", ".join(arguments),
        nothing=place(result, "nan"),
        kept=kept,
    )
    space: dict[str, object] = {"law": law, "pack": pack, "nan": math.nan}
    exec(text, space)
    number = numba.types.float64
    called = numba.cfunc(numba.types.int32(numba.types.CPointer(number), *[number] * len(parameters)))(space["run"])
    compiled: Any = law
    if any(_may_be_none(numba, signature.return_type) for signature in compiled.nopython_signatures):
        raise TypeError("there is a way to its end without a value to return")
    machine.keep(called)
    return machine.Entry(int(called.address), (result, *"f" * len(parameters)))


def _may_be_none(numba: Any, kind: Any) -> bool:
    """True for a result that is None on some ways, or holds such a value."""
    parts = kind.types if isinstance(kind, numba.types.BaseTuple) else ()
    return isinstance(kind, numba.types.Optional | numba.types.NoneType) or any(
        _may_be_none(numba, part) for part in parts
    )
