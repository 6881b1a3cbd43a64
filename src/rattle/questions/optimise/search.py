"""The search for the least objective from one design: steps that know the derivatives, and keep the bounds.

Sums of squares without constraints take Gauss-Newton steps in a trust region (SciPy's `least_squares`, trf), all else
sequential quadratic programming (SLSQP).  Both work on the places x of the parameters between their bounds, 0 to 1, so
that parameters of any size count alike, and on numbers divided by their size at the start.

A design that cannot be evaluated has no numbers: the trust region shrinks, and SLSQP, which sees a large value there,
takes a shorter step.

A search has succeeded where the conditions of optimality of first order hold: the constraints are met, and with
multipliers y of the active constraints and bounds (y >= 0 but for equations) the rest |grad f - sum y grad g| is as
good as zero.  What a routine says about itself does not count, neither does the size or the sign of the objective.

Source: Nocedal, Wright, Numerical Optimization (2006), sections 10.3, 18.1, 12.3 (multipliers).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from rattle.jit.choices import TINY
from rattle.questions.optimise.designs import Design, Designs, LostError
from rattle.results.reductions import EQUAL

MOST = 200  # iterations of one search
FINE = 1e-13  # relative change that ends a search
FLAT = 1e-15  # gradient that ends a least-squares search: below all rounding, so that FINE alone does
ROUNDS = 4  # SLSQP begins again where it ended, at most so often
GAIN = 1e-9  # relative gain of a round below which no other follows
WALL = 1e3  # value of a design that has none, in objectives at the start of the search
MET = 1e-7  # share of its size by which a constraint may be missed and yet hold
ACTIVE = 1e-5  # share of its size within which a constraint or bound is active
NEAR = 1e-3  # distance from a bound within which a least-squares search is tried on the bound itself
OPTIMAL = 1e-5  # rest of the gradient per 1 % of the ranges, as a share of the objective or of what was gained, in an
# optimum (test_known_optima_with_several_constraints falls without it: searches that ended early would pass)
PENALTY = 2.0  # times what a miss of a constraint is worth: more than the multipliers themselves, an exact penalty
RESTORED = 1e-10  # gain of a round that only looks for designs that meet the constraints, at which it ends


@dataclass(eq=False)
class Found:
    """What a search from one design has come to."""

    begun: Design
    best: Design  # the one with the least objective that meets the constraints, or that misses them least
    scale: np.ndarray  # (m,) sizes of the margins
    equal: np.ndarray  # (m,) True where a margin is to be zero
    designs: int = 1  # that were looked at
    message: str = ""  # how the search ended where it did not converge
    path: list[float] = field(default_factory=list)  # the best objective after every design

    def missed(self, design: Design) -> float:
        """By how much of its size the worst constraint is missed; 0 if all hold."""
        return float(np.max(self.misses(design), initial=0.0))

    def misses(self, design: Design) -> np.ndarray:
        """(m,) by how much of its size each constraint is missed, not negative."""
        margins = design.numbers[1:] / self.scale
        return np.asarray(np.where(self.equal, np.abs(margins), np.maximum(-margins, 0.0)))

    @property
    def meets(self) -> bool:
        """True if the best design meets all constraints."""
        return self.missed(self.best) <= MET

    def enter(self, design: Design) -> None:
        """Look at a design."""
        self.designs += 1
        if design.sound:
            missed, least = (max(self.missed(candidate) - MET, 0.0) for candidate in (design, self.best))
            if missed < least or (missed == least == 0.0 and design.numbers[0] < self.best.numbers[0]):
                self.best = design
        self.path.append(float(self.best.numbers[0]))


def search(designs: Designs, begin: Design) -> Found:
    """The search from one sound design."""
    equal = np.array([constraint.comparison == EQUAL for constraint in designs.question.constraints], dtype=bool)
    result = Found(begin, begin, sizes(designs, begin), equal)
    try:
        if designs.by_squares(begin):
            _least_squares(designs, result)
        else:
            _quadratic_programming(designs, result)
    except LostError as error:
        result.message = f"the search ended early: {error}"
    result.scale = sizes(designs, result.best)  # at the start margins may be larger by decades
    rest = _rest(designs, result)
    if not result.meets:
        result.message = result.message or "no design was found that meets all constraints"
    elif rest <= OPTIMAL:
        result.message = ""
    elif not result.message:
        result.message = "no step gains anything, yet the gradient is not zero: the objective jumps or has a kink there"
    return result


def _rest(designs: Designs, result: Found) -> float:
    """What is left of the gradient at the best design per 1 % of the ranges, as a share of what it is measured with:
    the objective, what was gained, or the gradient itself before the constraints held it.

    Errors of the parts r of a sum of squares are errors 2 |J| |dr| of its gradient: so much is as good as nothing.
    """
    there = held(designs, result)
    if there is None:
        return np.inf
    value, before = float(result.best.numbers[0]), float(result.begun.numbers[0])
    left, least = there.left, designs.gradient_doubt(result.best)
    if least > 0.0 and designs.is_root:  # the square of a root is least where it is, and smooth
        left *= 2.0 * abs(value)
    if left <= 0.01 * least:
        return 0.0
    balanced = there.before if there.constraints or there.low or there.high else 0.0
    return there.left / max(abs(value), abs(before - value), balanced, TINY)


def sizes(designs: Designs, design: Design) -> np.ndarray:
    """(m,) sizes of the margins: values or changes over the range of all parameters, whichever is larger."""
    try:
        changes = np.linalg.norm(designs.slopes(design)[1:], axis=1)
    except LostError:
        changes = np.zeros(len(design.numbers) - 1)
    return np.asarray(np.maximum(np.maximum(np.abs(design.numbers[1:]), changes), TINY))


# ---------------------------------------------------------------- sums of squares
def _least_squares(designs: Designs, result: Found) -> None:
    """Gauss-Newton; variables that end beside a bound are then tried on it."""
    free = np.ones(len(result.begun.x), dtype=bool)
    _on_free(designs, result, free)
    for _ in range(ROUNDS):
        x = result.best.x.copy()
        _, slopes = designs.parts(designs.at(x))
        r = designs.residuals(designs.at(x))
        gradient = slopes.T @ r
        outward = ((x <= NEAR) & (gradient > 0.0)) | ((x >= 1.0 - NEAR) & (gradient < 0.0))
        beside = outward & (x > 0.0) & (x < 1.0)
        if not beside.any():
            return
        x[beside] = np.round(x[beside])
        begun = designs.at(x)
        before = result.best
        result.enter(begun)
        if begun.sound and not outward.all():
            _on_free(designs, result, ~outward, begun)
        if result.best is before:
            return


def _on_free(designs: Designs, result: Found, free: np.ndarray, begin: Design | None = None) -> None:
    """Gauss-Newton on some variables; free: (k,) True for these."""
    from scipy.optimize import least_squares

    begun = result.best if begin is None else begin
    here = designs.residuals(designs.at(begun.x))
    scale = float(np.linalg.norm(here)) or 1.0

    def place(x: np.ndarray) -> np.ndarray:
        whole = begun.x.copy()
        whole[free] = x
        return whole

    def parts(x: np.ndarray) -> np.ndarray:
        design = designs.at(place(x))
        result.enter(design)
        return designs.residuals(design) / scale if design.sound else np.full(len(here), np.nan)

    def slopes(x: np.ndarray) -> np.ndarray:
        return foreign(designs.parts(designs.at(place(x)))[1][:, free] / scale)

    done = least_squares(
        parts, foreign(begun.x[free]), slopes, (0.0, 1.0), method="trf", x_scale="jac", ftol=FINE, xtol=FINE,
        gtol=FLAT, max_nfev=MOST,
    )  # fmt: skip
    if done.status == 0:
        result.message = f"not converged after {MOST} steps"


# ---------------------------------------------------------------- with constraints
def _quadratic_programming(designs: Designs, result: Found) -> None:
    """SLSQP, begun again where it ended until that gains nothing; from a design that meets the constraints, if it
    comes to none itself."""
    for _ in range(ROUNDS):
        before = result.best
        _one_round(designs, result)
        if not result.meets:
            _restore(designs, result)
        gain = before.numbers[0] - result.best.numbers[0]
        better = result.missed(before) > MET >= result.missed(result.best)
        if not better and gain <= GAIN * max(abs(before.numbers[0]), TINY):
            return


def _one_round(designs: Designs, result: Found) -> None:
    from scipy.optimize import minimize

    begun = result.best
    result.scale = sizes(designs, begun)
    gradient = np.linalg.norm(designs.slopes(designs.at(begun.x))[0])
    scale = max(abs(float(begun.numbers[0])), float(gradient), TINY)
    scale = min(scale, abs(float(begun.numbers[0])) or scale)
    wall = [1.0]

    def numbers(x: np.ndarray) -> np.ndarray:
        """Objective and margins, divided by their sizes; where a design has none, those of a design that is bad."""
        design = designs.at(x)
        if not design.sound:
            return np.concatenate([[WALL * wall[0]], -np.ones_like(result.scale)])
        scaled = np.concatenate([[design.numbers[0] / scale], design.numbers[1:] / result.scale])
        wall[0] = max(wall[0], abs(float(scaled[0])))
        return scaled

    def objective(x: np.ndarray) -> float:
        result.enter(designs.at(x))
        return float(numbers(x)[0])

    def slopes(x: np.ndarray) -> np.ndarray:
        design = designs.at(x)
        if not design.sound:
            raise LostError("it came to a design that cannot be evaluated")
        jacobian = designs.slopes(design)
        return np.vstack([jacobian[:1] / scale, jacobian[1:] / result.scale[:, None]])

    def condition(kind: str, chosen: np.ndarray) -> dict[str, str | Callable[..., np.ndarray]]:
        return {
            "type": kind,
            "fun": lambda x: foreign(numbers(x)[1:][chosen]),
            "jac": lambda x: foreign(slopes(x)[1:][chosen]),
        }

    parts = (("eq", result.equal), ("ineq", ~result.equal))
    done = minimize(
        objective, foreign(begun.x), jac=lambda x: foreign(slopes(x)[0]), method="SLSQP",
        bounds=[(0.0, 1.0)] * len(begun.x), constraints=[condition(*part) for part in parts if part[1].any()],
        options={"maxiter": MOST, "ftol": FINE},
    )  # fmt: skip
    result.message = "" if done.status == 0 else f"SLSQP: {done.message}"
    _prefer(designs, result, designs.at(done.x))


def _prefer(designs: Designs, result: Found, last: Design) -> None:
    """Take where a round ended, rather than a design on the way that was less only by what it missed a constraint.

    With the multipliers y there, a miss of d is worth y d (an exact penalty).
    """
    if not last.sound or result.missed(last) > MET or result.missed(result.best) > MET or last is result.best:
        return
    there = held(designs, result, last)
    if there is None:
        return
    misses = result.misses(result.best) * result.scale
    worth = sum(abs(y) * float(misses[j]) for j, y in there.constraints.items())
    if last.numbers[0] <= result.best.numbers[0] + PENALTY * worth:
        result.best = last


def _restore(designs: Designs, result: Found) -> None:
    """Gauss-Newton on what the constraints are missed by: to a design that meets them, or misses them least."""
    from scipy.optimize import least_squares

    def misses(x: np.ndarray) -> np.ndarray:
        design = designs.at(x)
        result.enter(design)
        return foreign(result.misses(design)) if design.sound else np.full(len(result.scale), np.nan)

    def slopes(x: np.ndarray) -> np.ndarray:
        design = designs.at(x)
        sign = np.where(result.equal, np.sign(design.numbers[1:]), np.where(design.numbers[1:] < 0.0, -1.0, 0.0))
        return foreign((sign / result.scale)[:, None] * designs.slopes(design)[1:])

    least_squares(
        misses, foreign(result.best.x), slopes, (0.0, 1.0), method="trf", x_scale="jac", ftol=RESTORED, xtol=RESTORED,
        gtol=RESTORED, max_nfev=MOST,
    )  # fmt: skip


def foreign(values: np.ndarray) -> np.ndarray:
    """An array as every routine outside may take it: its own memory in C's order, float64.

    A routine that reads a row of a matrix in the other order as if its numbers stood side by side takes others.
    """
    return np.array(values, dtype=np.float64, order="C")


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
    before: float  # the same of the gradient itself, that constraints and bounds may hold
    idle: tuple[int, ...]  # places of parameters on which neither objective nor constraints depend near the design


def held(designs: Designs, result: Found, at: Design | None = None) -> Held | None:
    """Multipliers y of the active constraints and bounds with the least |grad f - sum y grad g|, y >= 0 but for
    equations.

    at: the design (default: the best).  None where there are no derivatives.
    """
    from scipy.optimize import nnls

    design = designs.at((result.best if at is None else at).x)
    low, high = np.flatnonzero(design.x <= ACTIVE), np.flatnonzero(design.x >= 1.0 - ACTIVE)
    margins = design.numbers[1:]
    met = result.misses(design) <= MET
    active = np.flatnonzero(met & (result.equal | (margins <= ACTIVE * result.scale)))
    try:
        slopes = designs.slopes(design)
        parts = (
            designs.parts(design)[1] if designs.squares else slopes
        )  # where a sum of squares is least its slope is 0
    except LostError:
        return None
    idle = np.flatnonzero(~(slopes.any(axis=0) | parts.any(axis=0)))
    unit = np.eye(len(design.x))
    rows = np.array([*(slopes[1 + j] / result.scale[j] for j in active), *unit[low], *-unit[high]])
    free = np.concatenate([result.equal[active], np.zeros(len(low) + len(high), dtype=bool)])
    left, multipliers = slopes[0].copy(), np.zeros(len(rows))
    size = float(np.linalg.norm(left))
    if len(rows) and size > 0.0:
        signed = np.concatenate([rows, -rows[free]])  # an equation pushes either way
        found_signed, _ = nnls(foreign(signed.T), foreign(left / size))
        multipliers = size * found_signed[: len(rows)]
        multipliers[free] -= size * found_signed[len(rows) :]
        left = left - multipliers @ rows
    worth = {int(j): float(y / result.scale[j]) for j, y in zip(active, multipliers, strict=False)}
    gain, before = 0.01 * float(np.abs(left).sum()), 0.01 * float(np.abs(slopes[0]).sum())
    return Held(worth, tuple(low.tolist()), tuple(high.tolist()), gain, before, tuple(idle.tolist()))
