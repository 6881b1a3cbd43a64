"""Dormand-Prince 8(5, 3): adaptive, order 8, dense output of order 7.

Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I (1993), section II.10.
"""

from __future__ import annotations

from rattle.registry import kind
from rattle.solvers.dop853_tableau import TABLEAU
from rattle.solvers.explicit import step
from rattle.solvers.stepper import COMPLIANT, FREE, AdaptiveStepper


@kind("stepper", "dop853", step)
class Dop853(AdaptiveStepper):
    """Adaptive explicit Runge-Kutta method of order 8, the default without impact contacts.

    Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I (1993), section II.10.
    """

    usual_with = (FREE, COMPLIANT)
    tableau = TABLEAU
