"""Law of what pulls only while it is stretched: a spring and a damper in parallel.

T = K e + c e',  never less than 0;    e > 0: stretch [m], K [N/m], c [N*s/m]
"""

from __future__ import annotations

from rattle.interfaces.fields import LawValues
from rattle.interfaces.laws import NormalLaw
from rattle.jit.functions import kernel
from rattle.language.recorded import as_number
from rattle.registry import Field, kind


@kernel("normal")
def tension(static, delta, ddelta, v0, p, k):
    """Tension [N]: p[k] = c [N*s/m]."""
    return max(0.0, static + p[k] * ddelta) if delta > 0.0 else 0.0


@kind("tension", "tension", tension)
class Tension(NormalLaw):
    """Spring and damper of a strand.

    Source: definition.
    """

    damping = Field("N*s/m", "of the strand", default=0.0, least="not negative")

    @classmethod
    def pack(cls, values: LawValues) -> tuple[float, ...]:
        """Parameter of the kernel, p[k] = c [N*s/m]."""
        return (as_number(values["damping"]),)
