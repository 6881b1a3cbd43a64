"""Largest Lyapunov exponent: the rate at which neighbouring motions separate.

Sources: Wolf, Swift, Swinney, Vastano, Determining Lyapunov exponents from a time series, Physica D 16 (1985)
285-317; Benettin, Galgani, Strelcyn, Kolmogorov entropy and numerical experiments, Phys. Rev. A 14 (1976) 2338.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from rattle.analyses import arguments
from rattle.analyses.assembly.rank import rank
from rattle.equations.closure import open_by
from rattle.equations.dense import LARGE
from rattle.errors import InputError, TraceError
from rattle.jit import functions
from rattle.questions.lyapunov import neighbouring_runs, variational_equations
from rattle.questions.lyapunov.neighbouring_runs import APART, parts_of
from rattle.results.display import lines

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism

ROUNDING = 1e-9  # [-] by which stretches may be longer than the run: that of its division
SHORTER = 6  # how often a stretch is cut to a quarter if the growth in it is not linear
TO_VANISH = 3  # the same where a difference vanishes in one, before it counts as gone at once
UNSURE = 0.8  # uncertainty, as a share of the exponent, above which the exponent is not determined
ROUGH = 0.3  # the same above which it is called rough
ENOUGH = 100.0  # growth of differences below which the motion may be regular: there they grow in proportion to time
SEEN = 3.0  # growth of differences above which it is worth saying that it was not more
WEIGHED = 2.0  # growth that is a matter of how positions and rates are weighed in the size of a difference
SETTLED = 0.1  # scatter of the later parts of a run beside that of the earlier ones: a start that dies away is faster
BLOCKS = 10  # parts of the run from whose scatter the uncertainty follows
SPREAD = 1.2  # variance of the slope of the best line through a random walk, as a share of that of its mean step
STUDENT = 2.262  # 95 % of Student's t with BLOCKS - 1 degrees of freedom


class Lyapunov(NamedTuple):
    """Largest Lyapunov exponent: small differences grow as exp(exponent t)."""

    exponent: float  # [1/s]
    uncertainty: float  # 95 %, from the scatter of 10 parts of the run; at least what a factor of 100 makes [1/s]
    span: float  # time over which it was measured [s]
    growth: np.ndarray  # (n,) natural logarithm of the growth in every stretch [-]
    stretch: float  # length of a stretch [s]
    how: str = ""  # "exact variational equations", or "two neighbouring runs" and why
    vanished: float = math.nan  # instant at which neighbouring motions have become the same one [s]; nan: they have not

    @property
    def chaotic(self) -> bool:
        """True if the exponent exceeds its uncertainty and differences grew at least a hundredfold."""
        return self.exponent > self.uncertainty and self.exponent * self.span > math.log(ENOUGH)

    def horizon(self, error: float = 1e-9, seen: float = 1e-2) -> float:
        """Time [s] in which a relative error [-] grows to the size `seen` [-]; inf without growth."""
        return math.log(seen / error) / self.exponent if self.exponent > 0.0 else math.inf

    def __repr__(self) -> str:
        gone = math.isfinite(self.vanished)
        words = f"differences vanish by t = {self.vanished:.3g} s" if gone else self._number()
        return f"<rattle.Lyapunov: {words}>"

    def _repr_html_(self) -> str:
        return lines(str(self))

    def __str__(self) -> str:
        return f"{self._finding()}\nby {self.how}" if self.how else self._finding()

    def _number(self) -> str:
        return f"{self.exponent:.3g} +- {self.uncertainty:.2g} 1/s over {self.span:.4g} s"

    def _finding(self) -> str:
        if math.isfinite(self.vanished):
            return (
                f"no exponential growth of errors: neighbouring motions have become the same one by t = "
                f"{self.vanished:.3g} s (of a small difference less than 1e-7 is left within {self.stretch:.2g} s), so "
                "the largest Lyapunov exponent is taken as -inf; a shorter stretch tells a very fast decay from that"
            )
        words = f"largest Lyapunov exponent {self._number()}"
        seen, bounded = math.exp(min(self.exponent * self.span, 700.0)), 1.001 * math.log(ENOUGH) / self.span
        if self.uncertainty > max(UNSURE * abs(self.exponent), bounded):
            return f"{words}: not determined, the uncertainty is as large as the exponent; run much longer"
        if not self.chaotic:
            more = (
                f" (they grew {seen:.2g}-fold; a longer run shows whether the growth continues)" if seen > SEEN else ""
            )
            return f"{words}: no exponential growth of errors beyond the uncertainty{more}"
        tenfold = math.log(10.0) / self.exponent
        if self.uncertainty > ROUGH * self.exponent:
            words += f" (rough: uncertain by {100 * self.uncertainty / self.exponent:.0f} %)"
        return f"{words}: an error grows tenfold every {tenfold:.2g} s, from 1e-9 to 1 % in {self.horizon():.2g} s"


def lyapunov(
    m: Mechanism, t_end: float | None = None, *, stretch: float | None = None, skip: float = 0.2, rtol: float = 1e-10
) -> Lyapunov:
    """Largest Lyapunov exponent, from the growth of a small difference between two motions.

    Where the model can be recorded the difference is infinitely small: the variational equations carry it along the
    constraints, with exact derivatives.  With contacts, loads written in Python or expressions that switch there is a
    second run, which starts at a distance of 1e-7; after every stretch of time the difference is scaled back to 1e-7
    and projected onto the constraints, contact memory included.  States of the model count like positions, each in
    shares of its range along the run.  The first direction is the same in every call.

    t_end: duration [s] (default: that of the model).  stretch: [s] (default: t_end/400, shorter if a second run moves
    away too fast).  skip: share [-] of the run left out at the start, until the difference has turned to the direction
    of largest growth.  rtol: relative tolerance [-] of the motion and of the difference, or of both runs.
    The exponent is the slope of the best line through the logarithm of the growth over time.  Where differences changed
    less than a hundredfold it may be zero or any other that small, as in a run shorter than the mechanism's own times.
    With set-valued contacts two runs are event-driven; a stretch lasts a little longer if at its end one run has had
    an impact that the other is about to have.  Where contacts hold every position, or all rests, neighbouring motions
    become one and the same: then the exponent is -inf, and `vanished` says when.  A decay that leaves less than 1e-7
    within a stretch, cut to a 64th, counts as that; give a shorter stretch to tell it.
    Raises InputError if the drivers determine every position (then nothing can grow), or if a run cannot go on.
    """
    functions.start()
    span = arguments.positive("t_end", m.model.settings.t_end if t_end is None else t_end)
    length = span / 400 if stretch is None else arguments.positive("stretch", stretch)
    rtol = arguments.relative_tolerance(rtol)
    if 2 * BLOCKS * length > span * (1.0 + ROUNDING):
        raise InputError(f"a stretch of {length:g} s is too long for {span:g} s; take at most a {2 * BLOCKS}th of it")
    if not 0.0 <= skip < 1.0:
        raise InputError(f"skip must be a share of the run, from 0 to below 1; got {skip}")
    _require_mobility(m)
    growth, length, how, precision = _growths(m, span, length, rtol)
    lasts = np.isfinite(growth)
    if not lasts.all():
        return Lyapunov(-math.inf, 0.0, span, growth, length, how, m.start.t + length * int(1 + lasts.sum()))
    kept = growth[int(skip * len(growth)) :]
    exponent, seen = _slope(kept) / length, len(kept) * length
    return Lyapunov(exponent, _uncertainty(kept, exponent, length, precision), seen, growth, length, how)


def _uncertainty(growth: np.ndarray, exponent: float, length: float, precision: float) -> float:
    """95 % of the exponent [1/s], from its growth (n,) in stretches of a length [s], each of a relative precision."""
    blocks = np.array([part.mean() for part in np.array_split(growth, BLOCKS)]) / length
    seen = len(growth) * length
    rounding = precision * (abs(exponent) + 1.0 / length)
    error = max(STUDENT * float(blocks.std(ddof=1)) * math.sqrt(SPREAD / BLOCKS), rounding)
    early, late = np.split(blocks, 2)
    if np.ptp(late) > max(SETTLED * np.ptp(early), rounding):
        # differences turn slowly, which shows as a drift and hardly as scatter: the size of one is a matter of weights
        error = max(error, math.log(WEIGHED) / seen)
    if abs(exponent) * seen < math.log(ENOUGH):  # so much may be a start that dies away, or growth with a power of time
        error = max(error, math.log(ENOUGH) / seen)
    return error


def _slope(growth: np.ndarray) -> float:
    """Mean growth per stretch [-]: slope of the best line through the sums of `growth` (n,).

    The plain mean depends only on the two ends.  Differences that rotate while they grow oscillate by a bounded amount,
    which enters the plain mean divided by n, but the slope divided by n^2.
    """
    n = len(growth)
    k = np.arange(1, n + 1)
    return float(6.0 / (n * (n + 1) * (n + 2)) * np.sum(k * (n + 1 - k) * growth))


def _require_mobility(m: Mechanism) -> None:
    """Raise InputError for a mechanism without a degree of freedom in which motions could separate."""
    system, workspace = m.system, m.system.workspace()
    if len(system.arrays["contact"]) or system.row_count > LARGE or system.model.remembers:
        return
    open_by(workspace, m.start.t, m.start.q, m.start.v)
    if rank(system, workspace) == 3 * system.body_count:
        raise InputError(
            "the drivers fix every position: there is no degree of freedom in which errors could grow, so no exponent"
            " (a joint with clearance, or one driver less, gives one)"
        )


def _growths(m: Mechanism, span: float, length: float, rtol: float) -> tuple[np.ndarray, float, str, float]:
    """(n,) logarithm of the growth in every stretch, the length of a stretch [s], how it was found, how precisely."""
    why = ""
    for attempt in range(SHORTER):
        times = m.start.t + length * np.arange(1, max(2 * BLOCKS, round(span / length)) + 1)
        apart = parts_of(m, length, times)
        first = np.random.default_rng(1).normal(size=len(apart.places))
        if not why:
            try:
                growth = variational_equations.growths(m, first, apart, times, rtol)
                return growth, length, "exact variational equations", rtol
            except TraceError as error:
                why = str(error)
        grown = neighbouring_runs.growths(m, first, apart, times, rtol)
        if grown is not None and (attempt >= TO_VANISH or np.isfinite(grown).all()):
            return grown, length, f"two neighbouring runs, because {why}", APART
        length /= 4.0
    raise InputError(f"differences grow too fast even over {length:.3g} s; give a shorter stretch")
