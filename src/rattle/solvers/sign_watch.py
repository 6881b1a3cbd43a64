"""Forces that must not become negative: noticing their changes of sign."""

from __future__ import annotations

from rattle.jit.functions import compiled


@compiled
def watched_change(m):
    """True when a watched force has another sign than at the start of the step."""
    watch, sign, multiplier = m.watch, m.sign, m.multiplier
    for n in range(watch.shape[0]):
        if multiplier[watch[n]] * sign[n] < 0.0:
            return True
    return False
