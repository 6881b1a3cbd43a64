"""Branches on values, written so that a calculation can also be recorded as straight-line code (see `rattle.trace`)."""

from __future__ import annotations

from rattle.jit.functions import compiled

TINY = 1e-300  # what keeps quotients of zeros finite: no quantity that is divided by is as small


@compiled
def select(condition, yes, no):
    """`yes` where the condition holds, `no` elsewhere; both are computed."""
    return yes if condition else no


@compiled
def assume(condition):
    """The condition itself; a recording takes it for true and notes that it has to be."""
    return condition


@compiled
def usually(condition):
    """The condition itself, where both ways are sound; a recording takes the usual one as `assume`, or the other."""
    return condition
