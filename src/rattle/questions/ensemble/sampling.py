"""Points of the unit cube at which fields are sampled.

random   independent points
sobol    scrambled Sobol sequence: fills the cube evenly; means of n samples have errors of about 1/n
halton   scrambled Halton sequence: as Sobol's; in more than about ten dimensions it fills the cube less evenly
lhs      Latin hypercube: every draw has one value in each of n equal intervals

Point i of the first three depends on the seed, the number of draws and i alone: in whatever pieces and order points
are made, and however many there are, they have the same bits, so that an ensemble can be cut, resumed and made larger.
A Latin hypercube is one design of n points; another n is another design.

Source: Salmon et al., Parallel random numbers: as easy as 1, 2, 3, Proc. SC11 (2011) (Philox); Matousek, On the
L2-discrepancy for anchored boxes, J. Complexity 14 (1998) 527-556 (scrambling of Sobol's sequence); Owen, A randomized
Halton algorithm in R, arXiv:1706.02808; McKay, Beckman, Conover, Technometrics 21 (1979) 239-245 (Latin hypercube).
"""

from __future__ import annotations

import threading
from abc import ABC, abstractmethod
from functools import cached_property
from typing import Any, final

import numpy as np

from rattle.analyses import arguments
from rattle.errors import InputError, WrongType, suggest

BITS = 30  # of a coordinate of Sobol's sequence, which ends after 2**BITS points
MOST = 2**BITS  # points
MOST_DRAWS = {  # dimensions of a design
    "sobol": 21201,  # for which SciPy has direction numbers
    "halton": 1000,  # the tables of its permutations then take 0.2 GB
}
BELOW_ONE = 1.0 - 2.0**-53  # greatest float below 1
BLOCK = 4  # numbers that Philox makes at a time
PIECE = 2**16  # points that are made at a time to be passed over


class Points(ABC):
    """Points 0 ... count - 1 of a design in [0, 1)."""

    design = ""
    grows = True  # the first points stay as they are when there are more of them

    def __init__(self, seed: int, draws: int, count: int) -> None:
        self.seed = seed
        self.draws = draws  # dimensions
        self.count = count

    @final
    def points(self, first: int, last: int) -> np.ndarray:
        """(last - first, draws) points first ... last - 1.  Raises InputError for points that are not there."""
        if not 0 <= first <= last <= self.count:
            raise InputError(f"points {first} to {last} are not among 0 to {self.count}")
        return np.asarray(np.minimum(self._made(first, last), BELOW_ONE))

    @abstractmethod
    def _made(self, first: int, last: int) -> np.ndarray:
        """The points, of which a coordinate may round to 1."""

    def __reduce__(self) -> Any:
        return points, (self.design, self.seed, self.draws, self.count)


@final
class _Random(Points):
    """Independent points: the generator counts, so that every point can be reached at once."""

    design = "random"

    def __init__(self, seed: int, draws: int, count: int) -> None:
        super().__init__(seed, draws, count)
        self._key = np.random.SeedSequence(seed).generate_state(2, np.uint64)
        self._blocks = -(-draws // BLOCK)  # of a point

    def _made(self, first: int, last: int) -> np.ndarray:
        generator = np.random.Philox(key=self._key, counter=first * self._blocks)
        whole = generator.random_raw((last - first) * self._blocks * BLOCK)
        numbers = np.asarray((whole >> np.uint64(11)) * 2.0**-53)
        return numbers.reshape(last - first, self._blocks * BLOCK)[:, : self.draws]


class _Sequence(Points):
    """Points of a sequence that is made from its start on; it goes on where it was left, if it can."""

    def __init__(self, seed: int, draws: int, count: int) -> None:
        super().__init__(seed, draws, count)
        self._engine = self._start()
        self._in_use = threading.Lock()

    def _made(self, first: int, last: int) -> np.ndarray:
        if first == last:
            return np.empty((0, self.draws))
        with self._in_use:
            try:
                if first < self._engine.num_generated:
                    self._engine.reset()
                if first > self._engine.num_generated:
                    self._pass_over(first - self._engine.num_generated)
                return self._next(last - first)
            except BaseException:  # stopped anywhere: it may not know where it is
                self._engine.reset()
                raise

    @abstractmethod
    def _start(self) -> Any:
        """The engine at point 0."""

    @abstractmethod
    def _pass_over(self, count: int) -> None:
        """Go on by at least one point."""

    @abstractmethod
    def _next(self, count: int) -> np.ndarray:
        """(count, draws) the next points, at least one."""


@final
class _Sobol(_Sequence):
    design = "sobol"

    def _start(self) -> Any:
        return _engine("Sobol", self, scramble=True, bits=BITS)

    def _pass_over(self, count: int) -> None:
        self._engine.fast_forward(count)

    def _next(self, count: int) -> np.ndarray:
        if self._engine.num_generated or count == 1:
            return np.asarray(self._engine.random(count))
        # one by itself: SciPy warns if a sequence does not begin with a power of two
        return np.concatenate([self._engine.random(1), self._engine.random(count - 1)])


@final
class _Halton(_Sequence):
    design = "halton"

    def _start(self) -> Any:
        return _engine("Halton", self, scramble=True)

    def _pass_over(self, count: int) -> None:
        for done in range(0, count, PIECE):  # they are made and thrown away
            self._engine.fast_forward(min(PIECE, count - done))

    def _next(self, count: int) -> np.ndarray:
        return np.asarray(self._engine.random(count))


@final
class _LatinHypercube(Points):
    design = "lhs"
    grows = False

    def _made(self, first: int, last: int) -> np.ndarray:
        return self._all[first:last]

    @cached_property
    def _all(self) -> np.ndarray:
        return np.asarray(_engine("LatinHypercube", self).random(self.count))


_DESIGNS: dict[str, type[Points]] = {design.design: design for design in (_Sobol, _LatinHypercube, _Halton, _Random)}
DESIGNS = tuple(_DESIGNS)


def points(design: str, seed: int, draws: int, n: int) -> Points:
    """Points of n samples.

    design: one of DESIGNS.  seed: any integer from 0 on.  draws: number of independent draws, the dimensions.
    Raises InputError and TypeError for a design, seed or number that cannot be.
    """
    if design not in DESIGNS:
        raise InputError(f"unknown design {design!r:.60}{suggest(str(design), DESIGNS)}")
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer):
        raise WrongType(f"seed must be an integer, got {seed!r:.60}")
    if seed < 0:
        raise InputError("seed must be an integer from 0 on, got a negative one")
    draws, n = arguments.whole("draws", draws, 1), arguments.whole("n", n, 1, MOST)
    most = MOST_DRAWS.get(design, draws)
    if draws > most:
        raise InputError(f"design '{design}' has at most {most} independent parameters, got {draws}; take 'random'")
    size = 4.0 * 8.0 * n * draws  # with what is needed to make them
    if design == "lhs" and size > arguments.MOST_BYTES:
        raise InputError(
            f"design 'lhs' makes all its points at once: {n} of {draws} numbers take {size / 1e9:.1f} GB, at most"
            f" {arguments.MOST_BYTES / 1e9:g} GB are used; take 'sobol', which is made in pieces"
        )
    return _DESIGNS[design](int(seed), draws, n)


def _engine(name: str, asked: Points, **options: Any) -> Any:
    """An engine of SciPy with a generator of its own."""
    from scipy.stats import qmc

    generator = np.random.Generator(np.random.PCG64(asked.seed))
    return getattr(qmc, name)(asked.draws, **options, rng=generator)
