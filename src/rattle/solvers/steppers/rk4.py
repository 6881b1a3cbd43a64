"""The classical Runge-Kutta method of order 4 with a fixed step; cubic Hermite interpolation within a step.

Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I (1993), section II.1. The paper's method.
"""

from __future__ import annotations

from rattle.registry import kind
from rattle.solvers.explicit import step
from rattle.solvers.stepper import FixedStepper
from rattle.solvers.tableau import Tableau


@kind("stepper", "rk4", step)
class Rk4(FixedStepper):
    """The classical Runge-Kutta method of order 4 with fixed steps: to compare with other programs.

    Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I (1993), section II.1.
    """

    tableau = Tableau(
        order=4,
        times=(0.0, 0.5, 0.5, 1.0),
        rows=((), (0.5,), (0.0, 0.5), (0.0, 0.0, 1.0)),
        weights=(1 / 6, 1 / 3, 1 / 3, 1 / 6),
    )
