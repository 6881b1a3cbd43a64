"""Law of a contact whose damping is stated: a spring and a damper in parallel, which push and never pull.

    F = max(0, K delta^n + c ddelta)        delta > 0 penetration [m], ddelta its rate [m/s], c [N*s/m]

It starts with c times the approach speed, and ends where F does, at a depth at which the spring still pushes but the
damper would pull as much: what the spring holds then is lost.  The kernel does not clip F, so that it is smooth across
that end; the contact ends there, see `solvers.contacts.contact_events`.  With n = 1, a free mass m and
z = c/(2 sqrt(K m)) < 1 the impact returns

    e = exp(-z/sqrt(1 - z^2) (pi - atan2(2 z sqrt(1 - z^2), 1 - 2 z^2)))
"""

from __future__ import annotations

from rattle.interfaces.fields import LawValues
from rattle.interfaces.laws import NormalLaw
from rattle.jit.functions import kernel
from rattle.language.recorded import as_number
from rattle.registry import Field, kind


@kernel("normal")
def spring_damper(static, delta, ddelta, v0, p, k):
    """Normal force [N], negative where the damper would pull: p[k] = c [N*s/m]."""
    return static + p[k] * ddelta


@kind("tension", "spring-damper", spring_damper)
class SpringDamper(NormalLaw):
    """Static force and damper in parallel.

    Source: Schwager, Poeschel (2007), Granular Matter 9, 465-469 (the contact ends where its force does).
    """

    ends_by_force = True
    damping = Field("N*s/m", "of the contact, in place of a restitution", least="not negative")

    @classmethod
    def pack(cls, values: LawValues) -> tuple[float, ...]:
        """Parameter of the kernel, p[k] = c [N*s/m]."""
        return (as_number(values["damping"]),)
