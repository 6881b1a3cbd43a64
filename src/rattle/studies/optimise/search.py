"""The search for the least objective from one design: steps that know the derivatives, and keep the bounds.

Sums of squares without constraints take Gauss-Newton steps in a trust region (SciPy's `least_squares`, trf), all else
sequential quadratic programming (SLSQP).  Both work on the places x of the parameters between their bounds, 0 to 1, so
that parameters of any size count alike, and on numbers divided by their size at the start.

A design that cannot be evaluated has no numbers: the trust region shrinks, and SLSQP, which sees a large value there,
takes a shorter step.

Source: Nocedal, Wright, Numerical Optimization (2006), sections 10.3, 18.1, 12.3 (multipliers).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from rattle.studies.optimise.designs import Design, Designs, LostError

MOST = 200  # iterations of one search
FINE = 1e-13  # relative change that ends a search
ROUNDS = 4  # SLSQP begins again where it ended, at most so often
GAIN = 1e-9  # relative gain of a round below which no other follows
WALL = 1e3  # value of a design that has none, in objectives at the start of the search
MET = 1e-7  # share of its size by which a constraint may be missed and yet hold
ACTIVE = 1e-5  # share of its size within which a constraint or bound is active
NEAR = 1e-3  # distance from a bound within which a least-squares search is tried on the bound itself
LEVEL = 1e-6  # share of the objective or of what was gained, per 1 % of the ranges, below which a gradient is nothing
STEEP = 1e-2  # the same share, above which a search has not come to a valley
EASED = 1e-300


@dataclass(eq=False)
class Found:
    """What a search from one design has come to."""

    begun: Design
    best: Design  # the one with the least objective that meets the constraints, or that misses them least
    scale: np.ndarray  # (m,) sizes of the margins
    designs: int = 1  # that were looked at
    message: str = ""  # how the search ended where it did not converge
    path: list[float] = field(default_factory=list)  # the best objective after every design

    def missed(self, design: Design) -> float:
        """By how much of its size the worst constraint is missed; 0 if all hold."""
        return float(np.max(-design.numbers[1:] / self.scale, initial=0.0))

    def enter(self, design: Design) -> None:
        """Look at a design."""
        self.designs += 1
        if design.sound:
            missed, least = (max(self.missed(one) - MET, 0.0) for one in (design, self.best))
            if missed < least or (missed == least == 0.0 and design.numbers[0] < self.best.numbers[0]):
                self.best = design
        self.path.append(float(self.best.numbers[0]))


def search(designs: Designs, begin: Design) -> Found:
    """The search from one sound design."""
    found = Found(begin, begin, sizes(designs, begin))
    try:
        if designs.squares and not designs.question.constraints:
            _least_squares(designs, found)
        else:
            _quadratic_programming(designs, found)
    except LostError as error:
        found.message = f"the search ended early: {error}"
    slope = _slope(designs, found)
    if slope <= LEVEL or found.best.numbers[0] <= designs.doubt(found.best):
        found.message = ""
    elif slope > STEEP and not found.message and found.missed(found.best) <= MET:
        found.message = "no step gains anything, yet the gradient is not zero: the objective jumps or has a kink there"
    return found


def _slope(designs: Designs, found: Found) -> float:
    """What the best design would gain per 1 % of the ranges, as a share of the objective or of what was gained."""
    there = held(designs, found)
    value, before = float(found.best.numbers[0]), float(found.begun.numbers[0])
    return np.inf if there is None else there.left / max(abs(value), abs(before - value), EASED)


def sizes(designs: Designs, design: Design) -> np.ndarray:
    """(m,) sizes of the margins: values or changes over the range of all parameters, whichever is larger."""
    try:
        changes = np.linalg.norm(designs.slopes(design)[1:], axis=1)
    except LostError:
        changes = np.zeros(len(design.numbers) - 1)
    return np.asarray(np.maximum(np.maximum(np.abs(design.numbers[1:]), changes), EASED))


# ---------------------------------------------------------------- sums of squares
def _least_squares(designs: Designs, found: Found) -> None:
    """Gauss-Newton; variables that end beside a bound are then tried on it."""
    free = np.ones(len(found.begun.x), dtype=bool)
    _on_free(designs, found, free)
    for _ in range(ROUNDS):
        x = found.best.x.copy()
        _, slopes = designs.parts(designs.at(x))
        r = designs.residuals(designs.at(x))
        gradient = slopes.T @ r
        outward = ((x <= NEAR) & (gradient > 0.0)) | ((x >= 1.0 - NEAR) & (gradient < 0.0))
        beside = outward & (x > 0.0) & (x < 1.0)
        if not beside.any():
            return
        x[beside] = np.round(x[beside])
        begun = designs.at(x)
        before = found.best
        found.enter(begun)
        if begun.sound and not outward.all():
            _on_free(designs, found, ~outward, begun)
        if found.best is before:
            return


def _on_free(designs: Designs, found: Found, free: np.ndarray, begin: Design | None = None) -> None:
    """Gauss-Newton on some variables; free: (k,) True for these."""
    from scipy.optimize import least_squares

    begun = found.best if begin is None else begin
    here = designs.residuals(designs.at(begun.x))
    scale = float(np.linalg.norm(here)) or 1.0

    def place(x: np.ndarray) -> np.ndarray:
        whole = begun.x.copy()
        whole[free] = x
        return whole

    def parts(x: np.ndarray) -> np.ndarray:
        design = designs.at(place(x))
        found.enter(design)
        return designs.residuals(design) / scale if design.sound else np.full(len(here), np.nan)

    def slopes(x: np.ndarray) -> np.ndarray:
        return np.asarray(designs.parts(designs.at(place(x)))[1][:, free] / scale)

    done = least_squares(
        parts, begun.x[free], slopes, (0.0, 1.0), method="trf", x_scale="jac", ftol=FINE, xtol=FINE, gtol=1e-15,
        max_nfev=MOST,
    )  # fmt: skip
    if done.status == 0:
        found.message = f"not converged after {MOST} steps"


# ---------------------------------------------------------------- with constraints
def _quadratic_programming(designs: Designs, found: Found) -> None:
    """SLSQP, begun again where it ended until that gains nothing."""
    for _ in range(ROUNDS):
        before = found.best
        _one_round(designs, found)
        gain = before.numbers[0] - found.best.numbers[0]
        better = found.missed(before) > MET >= found.missed(found.best)
        if not better and gain <= GAIN * max(abs(before.numbers[0]), EASED):
            return


def _one_round(designs: Designs, found: Found) -> None:
    from scipy.optimize import minimize

    begun = found.best
    gradient = np.linalg.norm(designs.slopes(designs.at(begun.x))[0])
    scale = max(abs(float(begun.numbers[0])), float(gradient), EASED)
    scale = min(scale, abs(float(begun.numbers[0])) or scale)
    wall = [1.0]

    def numbers(x: np.ndarray) -> np.ndarray:
        """Objective and margins, divided by their sizes; where a design has none, those of a design that is bad."""
        design = designs.at(x)
        if not design.sound:
            return np.concatenate([[WALL * wall[0]], -np.ones_like(found.scale)])
        made = np.concatenate([[design.numbers[0] / scale], design.numbers[1:] / found.scale])
        wall[0] = max(wall[0], abs(float(made[0])))
        return made

    def objective(x: np.ndarray) -> float:
        found.enter(designs.at(x))
        return float(numbers(x)[0])

    def slopes(x: np.ndarray) -> np.ndarray:
        design = designs.at(x)
        if not design.sound:
            raise LostError("it came to a design that cannot be evaluated")
        made = designs.slopes(design)
        return np.vstack([made[:1] / scale, made[1:] / found.scale[:, None]])

    held: list[dict[str, str | Callable[..., np.ndarray]]] = []
    if designs.question.constraints:
        held = [{"type": "ineq", "fun": lambda x: numbers(x)[1:], "jac": lambda x: slopes(x)[1:]}]
    done = minimize(
        objective, begun.x, jac=lambda x: slopes(x)[0], method="SLSQP", bounds=[(0.0, 1.0)] * len(begun.x),
        constraints=held, options={"maxiter": MOST, "ftol": FINE},
    )  # fmt: skip
    found.message = "" if done.status == 0 else f"SLSQP: {done.message}"


# ---------------------------------------------------------------- what holds the optimum
@dataclass(frozen=True)
class Held:
    """Constraints and bounds that are active, and what they are worth."""

    constraints: dict[
        int, float
    ]  # place of a constraint that is active and met: change of the objective per unit of its margin [SI]
    low: tuple[int, ...]  # places of parameters at their lower, and at their upper bound
    high: tuple[int, ...]
    left: float  # what is left of the gradient: change of the objective per 1 % of the ranges, to first order
    idle: tuple[int, ...]  # places of parameters on which neither objective nor constraints depend near the design


def held(designs: Designs, found: Found) -> Held | None:
    """Multipliers y >= 0 of the active constraints and bounds with the least |grad f - sum y grad g|.

    None where there are no derivatives.
    """
    from scipy.optimize import nnls

    design = designs.at(found.best.x)
    low, high = np.flatnonzero(design.x <= ACTIVE), np.flatnonzero(design.x >= 1.0 - ACTIVE)
    margins = design.numbers[1:]
    active = np.flatnonzero((margins <= ACTIVE * found.scale) & (margins >= -MET * found.scale))
    try:
        slopes = designs.slopes(design)
        parts = (
            designs.parts(design)[1] if designs.squares else slopes
        )  # where a sum of squares is least its slope is 0
    except LostError:
        return None
    idle = np.flatnonzero(~(slopes.any(axis=0) | parts.any(axis=0)))
    unit = np.eye(len(design.x))
    rows = [*(slopes[1 + j] / found.scale[j] for j in active), *unit[low], *-unit[high]]
    left, multipliers = slopes[0], np.zeros(0)
    size = float(np.linalg.norm(left))
    if rows and size > 0.0:
        multipliers, _ = nnls(np.array(rows).T, left / size)
        multipliers = multipliers * size
        left = left - multipliers @ np.array(rows)
    worth = {int(j): float(y / found.scale[j]) for j, y in zip(active, multipliers, strict=False)}
    gain = 0.01 * float(np.abs(left).sum())
    return Held(worth, tuple(low.tolist()), tuple(high.tolist()), gain, tuple(idle.tolist()))
