"""Interval arithmetic for expressions of time: bounds of a program and of its rate over a span of time.

Source: Moore, Kearfott, Cloud, Introduction to Interval Analysis (2009), chapters 2, 5 and 6.
"""

from __future__ import annotations

from rattle.jit.functions import compiled, native
from rattle.language import bytecode as p
from rattle.language.arithmetic import NAN
from rattle.language.bytecode import SIDE
from rattle.language.operation import dispatch
from rattle.language.span import Span, joined, minus, steady, switched, wave_span
from rattle.language.table_intervals import knot_span, table_span


def _span(record, operands):
    """What gives the span of an operation."""
    return f"return span({'side, ' if record.branches else ''}{operands})", {"span": record.span}


# span of the function `op` of one operand, and of two
of_one = dispatch(__name__, "of_one", "side, x", {code: _span(record, "x") for code, record in p.ONE.items()})
of_two = dispatch(__name__, "of_two", "side, x, y", {code: _span(record, "x, y") for code, record in p.TWO.items()})
# span of the switching function of a switch of spans; y is 0 for one operand
of_switching = dispatch(
    __name__, "of_switching", "x, y", {
        code: (f"return switching({'x' if code in p.ONE else 'x, y'})", {"switching": sides.switching_span})
        for code, sides in p.BRANCHES.items() if sides.switching_span is not None
    }, "return minus(x, y)", {"minus": minus},
)  # fmt: skip


@native("void", "n", "v", "i", "i", "f", "f", "m", "m")
def enclose(code, const, first, last, low, high, signals, stack):
    """Bounds of what the program in rows first..last-1 leaves on its stack, over the times low..high [s].

    signals (ns, 4 or more), stack (depth, 4): spans.  Switches are on the sides in `code`; 0: not known.
    """
    top = -1
    for row in range(first, last):
        op, k, side = code[row, 0], code[row, 1], code[row, SIDE]
        if op <= p.SIGNAL:
            top += 1
            put_span(stack, top, operand(op, k, const, low, high, signals))
        elif op == p.CURVE or op == p.BENT:
            put_span(stack, top, table_span(const, k, span_at(stack, top), side))
        elif op < p.FIRST_OF_TWO:
            put_span(stack, top, of_one(op, side, span_at(stack, top)))
        elif op < p.LESS:
            top -= 1
            put_span(stack, top, of_two(op, side, span_at(stack, top), span_at(stack, top + 1)))
        elif op == p.CHOOSE:
            top -= 2
            put_span(stack, top, choice(span_at(stack, top), span_at(stack, top + 1), span_at(stack, top + 2)))
        else:
            top -= 3
            then, otherwise = span_at(stack, top + 2), span_at(stack, top + 3)
            above, below = (otherwise, then) if op <= p.AT_MOST else (then, otherwise)
            still = then if op == p.AT_MOST or op == p.AT_LEAST else otherwise
            compared = minus(span_at(stack, top), span_at(stack, top + 1))
            put_span(stack, top, switched(side, compared, above, below, still, True))


@compiled
def span_at(stack, n):
    """The span in row n of a stack."""
    return Span(float(stack[n, 0]), float(stack[n, 1]), float(stack[n, 2]), float(stack[n, 3]))


@compiled
def put_span(stack, n, x):
    """Write a span into row n of a stack."""
    stack[n, 0], stack[n, 1], stack[n, 2], stack[n, 3] = x.low, x.high, x.slow, x.fast


@compiled
def operand(op, k, const, low, high, signals):
    """Span of a constant, of time, of a signal; of a state nothing is known."""
    if op == p.CONST:
        return steady(float(const[k]))
    if op == p.TIME:
        return Span(low, high, 1.0, 1.0)
    if op == p.SIGNAL:
        return span_at(signals, k)
    return Span(NAN, NAN, NAN, NAN)


@compiled
def switching_span(const, op, k, stack):
    """Span of the switching function of the switch (op, k) with its operands on the stack; see `bytecode.switching`."""
    x = span_at(stack, 0)
    if op == p.BENT:
        return wave_span(knot_span(const, k, x))
    return of_switching(op, x, steady(0.0) if op < p.FIRST_OF_TWO else span_at(stack, 1))


@compiled
def choice(condition, yes, no):
    """One of two branches, or both where the condition is not known."""
    if condition.low > 0.0:
        return yes
    return no if condition.high <= 0.0 else joined(yes, no, True)
