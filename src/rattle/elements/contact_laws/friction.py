"""Friction laws: tangential force from slip, normal force and the states of the law.

The kernel is  f(u, N, z, p, k, dz) -> T:  slip u [m/s], normal force N [N], states z[0], z[1], ... of the law, `states`
in number; their rates are written to dz.  T [N] opposes the slip: the power taken from the motion is T u [W].
p[k:] are the fields in their order (`pack`); z is 0 at the start of a contact.  The kernel is called in contact only,
where a damped normal force may be clipped at zero: T and dz are continuous there, and N <= 0 counts as zero.

Without states T u >= 0 at every instant.  With one (dahl, lugre: bristles) T u may be negative while
bristles spring back, but never by more than the energy they store, **for every N(t)**: T u - dS/dt >= 0 with

    S = sigma z^2/2  [J]      z = sqrt(N) times the bristle deflection  [m N^(1/2)]

With the deflection zeta itself as state, F = N sigma zeta, a law would return more energy than it took when N rises
while the bristle is loaded (S = N sigma zeta^2/2 grows without work).  With dz = u sqrt(N) - ... and
T = sqrt(N) sigma z the stored energy depends on z only, and at constant N both are the same law.

Regularised laws creep at rest: under a tangential load F < mu N the slip is that given in each docstring.
"""

from __future__ import annotations

import math

from rattle.errors import InputError
from rattle.interfaces.fields import LawValues
from rattle.interfaces.laws import FrictionLaw
from rattle.jit.choices import TINY, assume, select
from rattle.jit.functions import kernel
from rattle.language.recorded import as_number
from rattle.registry import Field, kind

MU = Field("", "coefficient of friction", least="not negative")
MU_STATIC = Field("", "coefficient at rest; default: mu", lambda read: read["mu"], least="not negative")
V_STRIBECK = Field("m/s", "slip at which the extra friction at rest has fallen to 1/e", default=0.01, least="positive")
V1 = Field("m/s", "slip at which tanh(1) = 76 % of mu N is reached", default=1e-3, least="positive")


@kernel("friction")
def coulomb_smooth(u, N, z, p, k, dz):
    """Friction force [N] of `CoulombSmooth`."""
    if N <= 0.0:
        return 0.0
    return p[k] * N * math.tanh(u / p[k + 1])


@kernel("friction")
def ambrosio(u, N, z, p, k, dz):
    """Friction force [N] of `Ambrosio`."""
    v0, v1 = p[k + 1], p[k + 2]
    if N <= 0.0:
        return 0.0
    share = select(v1 > v0, (abs(u) - v0) / max(v1 - v0, TINY), 1.0)
    return select(abs(u) <= v0, 0.0, p[k] * N * math.copysign(min(share, 1.0), u))


@kernel("friction")
def threlfall(u, N, z, p, k, dz):
    """Friction force [N] of `Threlfall`."""
    if N <= 0.0:
        return 0.0
    half = math.tanh(1.5 * min(abs(u) / p[k + 1], 1.0))  # 1 - exp(-x) = 2 tanh(x/2)/(1 + tanh(x/2))
    return p[k] * N * math.copysign(2.0 * half / (1.0 + half), u)


@kernel("friction")
def viscous(u, N, z, p, k, dz):
    """Friction force [N] of `Viscous`."""
    return p[k] * u


@kernel("friction")
def stribeck(u, N, z, p, k, dz):
    """Friction force [N] of `Stribeck`."""
    mu = p[k] + (p[k + 1] - p[k]) * math.exp(-((abs(u) / p[k + 2]) ** p[k + 3]))
    return mu * max(N, 0.0) * math.tanh(u / p[k + 4]) + p[k + 5] * u


@kernel("friction")
def dahl(u, N, z, p, k, dz):
    """Friction force [N] of `Dahl`, and the rate of its state [m N^(1/2)/s]."""
    dz[0] = 0.0
    mu, sigma, alpha, N = p[k], p[k + 1], p[k + 2], max(N, 0.0)
    if not assume(mu > 0.0):
        return 0.0
    root = math.sqrt(N)
    held = math.copysign(sigma * z[0] / mu, u * z[0])  # along the slip; equals root when sliding
    share = select(abs(held) < root, 1.0 - held / max(root, TINY), 1.0)
    bends = root * share**alpha
    relaxes = root - held  # where N has decreased: at a rate that does not depend on N
    turns = root * (2.0**alpha - 1.0) - held
    dz[0] = u * select(abs(held) < root, bends, select(held > 0.0, relaxes, turns))
    return min(max(root * sigma * z[0], -mu * N), mu * N)


@kernel("friction")
def lugre(u, N, z, p, k, dz):
    """Friction force [N] of `LuGre`, and the rate of its state [m N^(1/2)/s]."""
    dz[0] = 0.0
    mu, mu_static, sigma, damping, viscosity = p[k], p[k + 1], p[k + 3], p[k + 4], p[k + 5]
    if not assume(mu > 0.0):
        return 0.0
    N = max(N, 0.0)
    root = math.sqrt(N)
    g = mu + (mu_static - mu) * math.exp(-((u / p[k + 2]) ** 2))
    dz[0] = root * u - sigma * abs(u) * z[0] / g
    limit = N * max(mu, mu_static)
    bristle = min(max(root * sigma * z[0], -limit), limit)
    return bristle + root * damping / (1.0 + damping * abs(u) / g) * dz[0] + N * viscosity * u


@kind("friction", "coulomb-smooth", coulomb_smooth)
class CoulombSmooth(FrictionLaw):
    """T = mu N tanh(u/v1).

    Creep at rest: v1 artanh(F/(mu N)) under a load F.
    Source: Coulomb's law, smoothed at u = 0; Andersson, Soderberg, Bjorklund (2007), Tribol. Int. 40, 580-587.
    """

    mu = MU
    v1 = V1


@kind("friction", "ambrosio", ambrosio)
class Ambrosio(FrictionLaw):
    """T = mu N cd sign(u), cd = 0 below v0, (|u|-v0)/(v1-v0) up to v1, 1 above.

    Creep at rest: v0 + (v1-v0) F/(mu N) under a load F; below v0 there is no friction at all.
    Source: Ambrosio (2003), Impact of rigid and flexible multibody systems, NATO Science Series 103, 57-81.
    """

    mu = MU
    v0 = Field("m/s", "slip up to which there is no friction", default=1e-4, least="not negative")
    v1 = Field("m/s", "slip from which there is full friction; more than v0", default=1e-3, least="positive")

    @classmethod
    def pack(cls, values: LawValues) -> tuple[float, ...]:
        """Parameters of the kernel [-, m/s, m/s].  Raises InputError unless v0 < v1."""
        mu, v0, v1 = (as_number(values[key]) for key in ("mu", "v0", "v1"))
        if not v0 < v1:
            raise InputError(f"ambrosio needs v0 < v1, not {v0:g} and {v1:g} m/s")
        return mu, v0, v1


@kind("friction", "threlfall", threlfall)
class Threlfall(FrictionLaw):
    """T = mu N (1 - exp(-3 |u|/vr)) sign(u) up to |u| = vr, constant at 0.950 mu N above.

    Creep at rest: -(vr/3) ln(1 - F/(mu N)) under a load F < 0.950 mu N.
    Source: Threlfall (1978), Mech. Mach. Theory 13, 475-483.
    """

    mu = MU
    vr = Field("m/s", "slip from which friction is constant", default=1e-3, least="positive")


@kind("friction", "viscous", viscous)
class Viscous(FrictionLaw):
    """T = c u during contact, independent of N: also where damping has brought N to zero.

    Creep at rest: F/c under a load F.
    Source: definition.
    """

    viscosity = Field("N*s/m", "c, force per slip", least="not negative")


@kind("friction", "stribeck", stribeck)
class Stribeck(FrictionLaw):
    """T = N [mu + (mu_static - mu) exp(-(|u|/v_stribeck)^shape)] tanh(u/v1) + c u.

    Creep at rest: about v1 artanh(F/(mu_static N)) under a load F.
    Source: Armstrong-Helouvry, Dupont, Canudas de Wit (1994), Automatica 30, 1083-1138.
    """

    mu = MU
    mu_static = MU_STATIC
    v_stribeck = V_STRIBECK
    shape = Field("", "exponent of the fall from mu_static to mu", default=2.0, least="positive")
    v1 = V1
    viscosity = Field("N*s/m", "c, force per slip", default=0.0, least="not negative")


@kind("friction", "dahl", dahl)
class Dahl(FrictionLaw):
    """dT/dx = N sigma (1 - T/(mu N) sign(u))^alpha: bristles that bend before they slide.

    At constant N and alpha = 1: T = mu N (1 - exp(-sigma x/mu)) over a sliding distance x; the stiffness at rest is
    N sigma.  For varying N (alpha = 1): dz = sqrt(N) u - |u| sigma z/mu, T = sqrt(N) sigma z, limited to mu N.

    At rest: no creep under a steady load; drifts under a load that oscillates.
    Source: Dahl (1968), Aerospace Corp. TOR-158(3107-18)-1; the dependence on N: this package, see the top of the file.
    """

    states = 1
    mu = MU
    sigma = Field("1/m", "bristle stiffness per normal force", default=1e4, least="positive")
    alpha = Field("", "shape of the approach to sliding", default=1.0, least="positive")


@kind("friction", "lugre", lugre)
class LuGre(FrictionLaw):
    """Bristles with damping, and less friction in motion than at rest.

    zeta' = u - sigma0 |u| zeta/g(u),  T = N (sigma0 zeta + s1 zeta' + sigma2 u),
    g = mu + (mu_static - mu) exp(-(u/v_stribeck)^2),  s1 = sigma1/(1 + sigma1 |u|/g), passive for every sigma1;
    z = sqrt(N) zeta, the elastic part limited to N mu_static.  In steady sliding T = N (g(u) sign u + sigma2 u).

    At rest: no creep under a steady load; drifts under a load that oscillates.
    Source: Canudas de Wit et al. (1995), IEEE Trans. Autom. Control 40, 419-425; N and s1: this package.
    """

    states = 1
    mu = MU
    mu_static = MU_STATIC
    v_stribeck = V_STRIBECK
    sigma0 = Field("1/m", "bristle stiffness per normal force", default=1e4, least="positive")
    sigma1 = Field("s/m", "bristle damping per normal force", default=1.0, least="not negative")
    sigma2 = Field("s/m", "viscous friction per normal force", default=0.0, least="not negative")
