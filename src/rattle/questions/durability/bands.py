"""How lives scatter: lognormal about the life of the table, by factors that 10 and 90 % reach.

    P(t) = Phi(ln(t/life)/s),  s = -ln(low)/z below the life, ln(high)/z above,  z = 1.2816

These factors are assumptions unless the model says them: nobody has measured them for the parts at hand.
"""

from __future__ import annotations

import math
from typing import NamedTuple

WEAR = (1.0 / 3.0, 3.0)  # of the life, 10 and 90 %
FATIGUE = (0.5, 2.0)
SLOPE = 1.5  # of the Weibull distribution of lives of rolling bearings, as ISO 281 has it
MEDIAN = (math.log(2.0) / -math.log(0.9)) ** (1.0 / SLOPE)  # life of half of them over L10, which 90 % reach
ROLLING = (1.0 / MEDIAN, (math.log(10.0) / math.log(2.0)) ** (1.0 / SLOPE))
AT_10 = 1.2815515655446004  # quantile of the normal distribution at 90 %


class Bands(NamedTuple):
    """Hours by which 10, 50 and 90 % have failed."""

    early: float
    middle: float
    late: float


def bands(hours: float, factors: tuple[float, float]) -> Bands:
    """The bands about a life [h]; factors: those that 10 and 90 % reach."""
    return Bands(hours * factors[0], hours, hours * factors[1])


def failed(hours: float, life: float, factors: tuple[float, float]) -> float:
    """Share that has failed after so many hours, of what lasts `life` hours in the middle."""
    if not 0.0 < hours < math.inf or not 0.0 < life < math.inf:
        return float(hours >= life)
    apart = math.log(hours / life)
    width = abs(math.log(factors[0] if apart < 0.0 else factors[1])) / AT_10
    return 0.5 * (1.0 + math.erf(apart / width / math.sqrt(2.0)))
