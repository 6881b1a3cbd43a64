"""The kernel of functions of one variable of a kind, see `language.local_function`."""

from __future__ import annotations

from rattle.jit.functions import native
from rattle.language.bytecode import BENT, CONST, CURVE, TIME
from rattle.language.jets import operate_jet, put_jet

HEAD = 2  # numbers of a block before its operations


@native("fff", "v", "i", "f")
def function_jet(p, k, x):
    """Value, first and second derivative at x of the function that field p[k] of a kind is [SI]."""
    block = k + int(p[k])
    top = block + int(p[block + 1]) - 3
    for n in range(int(p[block])):
        op, argument = int(p[block + HEAD + 2 * n]), p[block + HEAD + 2 * n + 1]
        if op == CONST:
            top += 3
            put_jet(p, top, argument, 0.0, 0.0)
        elif op == TIME:
            top += 3
            put_jet(p, top, x, 1.0, 0.0)
        else:
            place = block + int(argument) if op in (CURVE, BENT) else 0
            top = operate_jet(op, 0, p, place, p, top)
    return p[top], p[top + 1], p[top + 2]


@native("void", "v", "i", "v", "m")
def function_jets(p, k, x, jets):
    """The same at every number of x (n,), into the rows of jets (n, 3)."""
    for n in range(x.shape[0]):
        jets[n, 0], jets[n, 1], jets[n, 2] = function_jet(p, k, x[n])
