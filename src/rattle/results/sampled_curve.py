"""A curve between the instants of a result: cubic polynomials that do not reach across jumps and kinks.

In each interval [t_i, t_i+1], with u = t - t_i,

    p(u) = a0 + a1 u + a2 u^2 + a3 u^3

passes through four neighbouring samples, those at both ends of the interval among them.  Of the possible groups of four
the one is taken whose divided differences are small (essentially non-oscillatory interpolation), so that beside a jump
no group contains it.  Where the curve is smooth the error is of order h^4.  Between two samples that are exactly zero
the curve is zero, as a force without contact is; a flight of two samples is too short for any group.

A cubic may turn inside its interval only where the second differences on both sides agree (same sign, factor `ALIKE`),
as at a maximum that the samples resolve; elsewhere the curve is straight there.

An instant that stands twice is a *break*: the values just before and just after an impact, a kink of a driver or
another event.  No group reaches across it, the curve jumps or bends there, and the value at it is that just after.

Source: Harten, Engquist, Osher, Chakravarthy, J. Comput. Phys. 71 (1987) 231, section 3; the preference for the group
in the middle: Shu, J. Sci. Comput. 5 (1990) 127.
"""

from __future__ import annotations

import functools
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rattle.errors import InputError

Array = NDArray[np.float64]

CENTRAL = 2.0  # the middle group is left for another whose third difference is smaller by more than this factor
ALIKE = 3.0
HALVINGS = 100  # steps in which a root is found to rounding, at most
SAME = 1e-14  # relative change that is rounding
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(4)  # exact for the square of a cubic


class _Pieces(NamedTuple):
    """Parts of the intervals in which the curve is monotone."""

    interval: NDArray[np.int64]  # (m,) in which it lies
    start: Array  # (m,) u at both ends [s]
    end: Array
    left: Array  # (m,) values there
    right: Array


class SampledCurve:
    """A curve of time through samples; t (n,) increasing [s], twice at a break, values (n,) finite or not, in any unit.

    Raises InputError if there is no instant, or if they do not increase.
    """

    def __init__(self, t: ArrayLike, values: ArrayLike) -> None:
        self.t: Array = np.asarray(t, dtype=np.float64)
        self.values: Array = np.asarray(values, dtype=np.float64)
        if not len(self.t):
            raise InputError("the result has no instant")
        if not (np.diff(self.t) >= 0.0).all():
            raise InputError("the instants of the result must increase")
        self.span = float(self.t[-1] - self.t[0])  # [s]
        self.finite = bool(np.isfinite(self.values).all())

    @functools.cached_property
    def coefficients(self) -> Array:
        """(4, n - 1) coefficients a0 ... a3 of the cubics."""
        with np.errstate(all="ignore"):
            cubics = _coefficients(self.t, self.values)
        cubics[:, (self.values[:-1] == 0.0) & (self.values[1:] == 0.0)] = 0.0
        return cubics

    def at(self, instant: float) -> float:
        """Value at an instant [s] of the run: of the sample if there is one, otherwise of the cubic.

        nan where a sample that it needs is not finite.
        """
        k = int(np.searchsorted(self.t, instant, side="right")) - 1
        k = min(max(k, 0), len(self.t) - 1)
        if self.t[k] == instant or len(self.t) == 1:
            return float(self.values[k])
        k = min(k, len(self.t) - 2)
        with np.errstate(invalid="ignore"):
            return float(_polynomial(self.coefficients[:, k], np.float64(instant - self.t[k])))

    def through(self, instants: ArrayLike) -> Array:
        """(m,) values at instants (m,) [s] of the run, each as by `at`."""
        wanted = np.asarray(instants, dtype=np.float64)
        k = np.clip(np.searchsorted(self.t, wanted, side="right") - 1, 0, len(self.t) - 1)
        on = self.t[k] == wanted
        if len(self.t) == 1 or on.all():
            return self.values[k]
        before = np.minimum(k, len(self.t) - 2)
        with np.errstate(invalid="ignore"):
            between = _polynomial(self.coefficients[:, before], wanted - self.t[before])
        return np.where(on, self.values[k], between)

    def integral(self) -> float:
        """Integral over time [unit s]."""
        h = np.diff(self.t)
        a0, a1, a2, a3 = self.coefficients
        return math.fsum(h * (a0 + h * (a1 / 2 + h * (a2 / 3 + h * a3 / 4))))

    def mean(self) -> float:
        """Mean over time; the value itself if there is one instant only."""
        return self.integral() / self.span if self.span else float(self.values[0])

    def mean_square(self, about: float = 0.0) -> float:
        """Mean over time of the square of the difference from a value [unit^2]."""
        if not self.span:
            return float(self.values[0] - about) ** 2
        half = np.diff(self.t)[:, None] / 2
        squares = (_polynomial(self.coefficients[:, :, None], half * (_NODES + 1.0)) - about) ** 2
        return math.fsum((squares @ _WEIGHTS) * half[:, 0]) / self.span

    def square_parts(self) -> Array:
        """(m,) numbers whose squares add up to the mean square, each in proportion to the curve at one place."""
        if not self.span:
            return self.values[:1].copy()
        half = np.diff(self.t)[:, None] / 2
        values = _polynomial(self.coefficients[:, :, None], half * (_NODES + 1.0))
        return np.asarray(values * np.sqrt(_WEIGHTS * half / self.span)).ravel()

    def greatest(self) -> float:
        """Greatest value of the cubics and samples."""
        return float(np.max(self._pieces.right, initial=self.values.max()))

    def least(self) -> float:
        """Least value of the cubics and samples."""
        return float(np.min(self._pieces.right, initial=self.values.min()))

    # ------------------------------------------------------------ levels
    def spans_above(self, level: float) -> tuple[Array, Array]:
        """Spans (start, end) of time [s], in order, in which the curve is greater than a level.

        It crosses the level only between samples on different sides of it: a cubic that reaches across between two
        samples on one side is no evidence, and a force that cannot pull would be said to do so.
        Between a plateau at the level and a sample above it the curve leaves the level at an unknown instant, taken in
        the middle of the interval: so a force that is exactly zero without contact.
        """
        every = np.arange(len(self.t) - 1)
        h = np.diff(self.t)
        p = _Pieces(every, np.zeros_like(h), h, self.values[:-1], self.values[1:])
        return self._spans(p, level)

    def rises(self, level: float) -> tuple[NDArray[np.int64], Array]:
        """Intervals (m,) in which the curve rises through a level, and the instants [s] at which it does.

        At a break where it jumps from below to above it rises too.  A curve that only touches the level does not.
        """
        side = np.sign(self.values - level)
        following = np.minimum.accumulate(np.where(side != 0.0, np.arange(len(side)), len(side) - 1)[::-1])[::-1]
        side = side[following]  # at the level a sample counts as the next one beside it
        every, h = np.arange(len(self.t) - 1), np.diff(self.t)
        rising = (side[:-1] < 0.0) & (side[1:] > 0.0)
        p = _Pieces(every, np.zeros_like(h), h, self.values[:-1], self.values[1:])
        return every[rising], self.t[:-1][rising] + self._roots(p, rising, level)

    def _spans(self, p: _Pieces, level: float) -> tuple[Array, Array]:
        """The spans above a level in pieces of the curve."""
        left, right = p.left - level, p.right - level
        start, end = p.start.copy(), p.end.copy()
        crossing = np.sign(left) * np.sign(right) < 0.0
        root = self._roots(p, crossing, level)
        start[crossing] = np.where(left[crossing] < 0.0, root, start[crossing])
        end[crossing] = np.where(left[crossing] < 0.0, end[crossing], root)
        leaves, reaches = self._plateau_edges(level)
        middle = np.diff(self.t)[p.interval] / 2
        start = np.where(leaves[p.interval], np.maximum(start, middle), start)
        end = np.where(reaches[p.interval], np.minimum(end, middle), end)
        inside = ((left > 0.0) | (right > 0.0)) & (end > start)
        origin = self.t[p.interval[inside]]
        return origin + start[inside], origin + end[inside]

    def time_above(self, level: float) -> float:
        """Time [s] in which the curve is greater than a level, by the spans of `spans_above`."""
        start, end = self.spans_above(level)
        return math.fsum(end - start)

    def quantile(self, share: float) -> float:
        """The value that the curve does not exceed for this share (0 to 1) of the time."""
        low, high = self.least(), self.greatest()
        if share <= 0.0 or not self.span:
            return low
        if share >= 1.0:
            return high
        rest, scale = (1.0 - share) * self.span, max(abs(low), abs(high))

        def excess(level: float) -> float:
            start, end = self._spans(self._pieces, level)
            return math.fsum(end - start) - rest

        at_low, at_high = excess(low), -rest
        for _ in range(HALVINGS):  # false position, and halving in turn: the time may jump at a plateau
            if at_low <= 0.0 or high - low <= SAME * scale:
                break
            for level in (low + (high - low) * at_low / (at_low - at_high), low + 0.5 * (high - low)):
                if low < level < high:
                    over = excess(level)
                    low, at_low, high, at_high = (
                        (level, over, high, at_high) if over > 0.0 else (low, at_low, level, over)
                    )
        return high if at_low > 0.0 else low

    def _roots(self, p: _Pieces, chosen: NDArray[np.bool_], level: float) -> Array:
        """Where the chosen pieces, whose ends are on different sides, cross a level: u [s]."""
        a = self.coefficients[:, p.interval[chosen]]
        low, high = p.start[chosen], p.end[chosen]
        rising = p.right[chosen] > p.left[chosen]
        u = 0.5 * (low + high)
        for _ in range(HALVINGS if len(low) else 0):  # Newton's method, and halving where it leaves the bracket
            off = _polynomial(a, u) - level
            before = (off < 0.0) == rising
            low, high = np.where(before, u, low), np.where(before, high, u)
            with np.errstate(all="ignore"):
                step = u - off / (a[1] + u * (2.0 * a[2] + u * 3.0 * a[3]))
            last, u = u, np.where((step >= low) & (step <= high), step, 0.5 * (low + high))
            if (np.abs(u - last) <= SAME * high).all():
                break
        return np.asarray(u)

    def _plateau_edges(self, level: float) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Intervals that begin, and that end, where a plateau at a level ends or begins; (n - 1,) each."""
        on = self.values == level
        flat = on[:-1] & on[1:]
        leaves, reaches = np.zeros(len(flat), dtype=bool), np.zeros(len(flat), dtype=bool)
        leaves[1:] = flat[:-1] & ~flat[1:]
        reaches[:-1] = flat[1:] & ~flat[:-1]
        return leaves, reaches

    @functools.cached_property
    def _pieces(self) -> _Pieces:
        """The intervals, cut where the curve turns."""
        h = np.diff(self.t)
        with np.errstate(all="ignore"):
            cuts = _turns(self.coefficients, h)
            edges = np.array([np.zeros_like(h), cuts[0], cuts[1], h])
            values = _polynomial(self.coefficients, edges)
            values = np.where(edges == h, self.values[1:], values)
        start, end = edges[:-1].T, edges[1:].T  # (n - 1, 3)
        kept = end > start
        interval = np.broadcast_to(np.arange(len(h))[:, None], kept.shape)[kept]
        return _Pieces(interval, start[kept], end[kept], values[:-1].T[kept], values[1:].T[kept])


def _polynomial(a: Array, u: Array | np.float64) -> Array:
    """Value of a cubic; a (4, ...) coefficients, u [s]."""
    return np.asarray(a[0] + u * (a[1] + u * (a[2] + u * a[3])))


def _coefficients(t: Array, values: Array) -> Array:
    """(4, n - 1) coefficients of the cubics; with fewer than four samples polynomials of lower degree.

    Differences across a break are infinite, so that no group has them.
    """
    n = len(t)
    h = np.diff(t)
    whole = h > 0.0
    first = np.where(whole, np.diff(values) / h, 0.0)
    second = np.diff(first) / (t[2:] - t[:-2]) if n > 2 else np.zeros(0)
    third = np.diff(second) / (t[3:] - t[:-3]) if n > 3 else np.zeros(0)
    if not whole.all():
        second = np.where(whole[1:] & whole[:-1], second, np.inf)
        third = np.where(whole[2:] & whole[1:-1] & whole[:-2], third, np.inf)
    i = np.arange(n - 1)
    if n < 3:
        return np.array([values[:-1], first, 0.0 * h, 0.0 * h])
    # third sample: the one before or the one after the interval
    before = _smaller(second, i - 1, i, 1.0)
    group = np.where(before, i - 1, i)
    beside = np.where(before, t[np.maximum(i - 1, 0)], t[np.minimum(i + 2, n - 1)]) - t[:-1]
    d2 = _known(second[group])
    if n < 4:
        d3 = np.zeros(n - 1)
    else:  # the group that has the interval in its middle, or the one beyond the third sample
        outer = np.where(before, i - 2, i)
        d3 = _known(third[np.where(_smaller(third, outer, i - 1, CENTRAL), outer, i - 1)])
    cubics = np.array([values[:-1], first - d2 * h + d3 * h * beside, d2 - d3 * (h + beside), d3])
    earlier, later = second[np.clip(i - 1, 0, n - 3)], second[np.clip(i, 0, n - 3)]
    earlier, later = np.where(np.isinf(earlier), later, earlier), np.where(np.isinf(later), earlier, later)
    small, large = np.minimum(np.abs(earlier), np.abs(later)), np.maximum(np.abs(earlier), np.abs(later))
    alike = (earlier * later > 0.0) & (large <= ALIKE * small)
    cuts = _turns(cubics, h)
    straight = ~alike & (cuts < h).any(axis=0)
    return np.where(straight, [values[:-1], first, 0.0 * h, 0.0 * h], cubics)


def _known(differences: Array) -> Array:
    """Divided differences, 0 where there is none on one side of all breaks: the polynomial is of lower degree there."""
    return np.where(np.isinf(differences), 0.0, differences)


def _turns(a: Array, h: Array) -> Array:
    """(2, n - 1) increasing places u [s] in the intervals where the slope a1 + 2 a2 u + 3 a3 u^2 is zero, else h."""
    _, a1, a2, a3 = a
    q = -(a2 + np.copysign(np.sqrt(a2 * a2 - 3 * a1 * a3), a2))  # no cancellation
    cuts = np.array([q / (3 * a3), a1 / q])
    return np.sort(np.where((cuts > 0.0) & (cuts < h), cuts, h), axis=0)


def _smaller(
    differences: Array, place: NDArray[np.int64], other: NDArray[np.int64], factor: float
) -> NDArray[np.bool_]:
    """Where the divided difference at `place` is smaller, by a factor, or that at `other` does not exist."""
    last = len(differences) - 1
    there, beside = (place >= 0) & (place <= last), (other >= 0) & (other <= last)
    sizes = np.abs(differences)
    less = factor * sizes[np.clip(place, 0, last)] <= sizes[np.clip(other, 0, last)]
    return ~beside | (there & less)
