"""Small free vibrations about an equilibrium.

(Z^T M Z s^2 + Z^T C Z s + Z^T K Z) z = 0,     shapes Z z, scaled so that the largest displacement is the
mechanism's size;  K as in `balance`, C = -dQ/dv: exact derivatives, or differences where there are none
"""

from __future__ import annotations

import cmath
import math
import os
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from rattle.analyses.assembly.rank import unlike_masses
from rattle.analyses.history import require_known_torques
from rattle.equations.motion import loads, place
from rattle.equations.rest_force import FACTORS, SHIFTS, force_at
from rattle.equations.system import System
from rattle.errors import InputError, TraceError, WrongType
from rattle.questions.equilibrium.balance import StaticProblem
from rattle.questions.equilibrium.compute import static_problem
from rattle.questions.equilibrium.exact_stiffness import exact_stiffness
from rattle.questions.equilibrium.position import Equilibria, Equilibrium
from rattle.questions.modes.oil_whirl import Whirl, seen_speeds, whirls
from rattle.questions.modes.small_motions import DIFFERENCES, EXACT, small_motions
from rattle.results.build import build_result
from rattle.results.display import quantity, table
from rattle.results.result import Result
from rattle.results.trust import Trust
from rattle.wrong_arguments import answers_in_words

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from rattle.results.display import Picture

FRAMES = 61
OTHER = 1e-6  # share of size and forces by which an equilibrium may be open or unbalanced, to be one of a mechanism
ROUNDING = 1e-10  # damping ratio below which it is rounding [-]: what is left of roots without any
SLOW = 1e-4  # velocity by which damping is found [sizes of the mechanism per second]
SHARE = 1e-3  # the same as a share of what a film sees
STEPS = 8  # from the equilibrium outwards, so that pins with clearance keep their side


@answers_in_words
@dataclass(repr=False)
class Modes:
    """Natural modes about an equilibrium, lowest first: frequencies, damping ratios, rates of growth, and shapes.

    They are the motions z exp(s t) of all equations together, so also those of damping that couples the undamped
    modes, of gyroscopic and of follower forces.  Every mode has two roots s: a conjugate pair, or two real ones.
    """

    equilibrium: Equilibrium
    roots: np.ndarray  # (f, 2) complex s [1/s]; of a conjugate pair that with Im s > 0 first, of two real the larger
    vectors: np.ndarray  # (f, 2, 3 nb) complex x, y, angle of every body that belong to them, largest as in shapes
    problem: StaticProblem = field(repr=False)
    note: str = ""  # how far the search for the equilibrium went, if it was cut short
    how: str = ""  # how stiffness and damping were found: "exact derivatives", or "differences" and why
    whirl: tuple[Whirl | None, ...] = ()  # of every mode: the film that makes it grow, None where no film does

    @property
    def omega(self) -> np.ndarray:
        """(f,) natural circular frequencies |s| [rad/s]; of two real roots sqrt(s1 s2); nan for a divergent mode.

        Divergent: with a real root that grows (see `growth`).
        """
        first, other = self.roots.T
        divergent = (first.imag == 0.0) & (first.real > 0.0)
        size = np.where(first.imag != 0.0, np.abs(first), np.sqrt(np.abs(first * other)))
        return np.asarray(np.where(divergent, np.nan, size))

    @property
    def growth(self) -> np.ndarray:
        """(f,) rate Re s at which an unstable mode grows [1/s], 0 for one that does not grow."""
        return np.asarray(np.maximum(self.roots[:, 0].real, 0.0))

    @property
    def damping(self) -> np.ndarray:
        """(f,) damping ratio -Re s/|s| [-]: negative for flutter, 1 or more if overdamped, 0 for a divergent mode."""
        loss, omega = -0.5 * self.roots.sum(axis=1).real, self.omega
        return np.asarray(np.divide(loss, omega, out=np.zeros(len(omega)), where=omega > 0.0) + 0.0)

    @property
    def frequency(self) -> np.ndarray:
        """(f,) natural frequencies |s|/(2 pi) [Hz]; nan for a divergent mode."""
        return np.asarray(self.omega / (2 * math.pi))

    @property
    def damped_frequency(self) -> np.ndarray:
        """(f,) frequencies at which the modes do vibrate, Im s/(2 pi) [Hz]; 0 for those that do not."""
        return np.asarray(self.roots[:, 0].imag / (2 * math.pi))

    @property
    def time_constants(self) -> np.ndarray:
        """(f, 2) slow and fast time constant -1/s [s] of overdamped modes; nan for modes of any other kind."""
        overdamped = (self.roots.imag == 0.0).all(axis=1) & (self.roots.real < 0.0).all(axis=1)
        return np.asarray(-1.0 / np.where(overdamped[:, None], self.roots.real, np.nan))

    @property
    def shapes(self) -> np.ndarray:
        """(f, 3 nb) x, y, angle of every body [m, m, rad] at the largest displacement; of the first root."""
        return np.asarray(self.vectors[:, 0].real)

    @property
    def about(self) -> str:
        """The equilibrium in words, and whether motions near it grow although it is stable at rest."""
        rest, grows = self.equilibrium, self.growth > 0.0
        divergent = np.isnan(self.omega).any()
        if not grows.any():
            if rest.eigenvalue < 0.0:
                return rest.described("held by forces without a potential")
            return rest.described("stable") if rest.stable else str(rest)
        if divergent and rest.eigenvalue < 0.0:
            return str(rest)
        if any(self.whirl):
            return rest.described(f"{'stable statically, ' if rest.stable else ''}unstable by oil whirl")
        still = "stable statically, " if rest.stable else "" if rest.eigenvalue < 0.0 else "neutral statically, "
        return rest.described(f"{still}unstable by {'negative damping' if divergent else 'flutter'}")

    def __len__(self) -> int:
        return len(self.roots)

    def __repr__(self) -> str:
        listed = ", ".join(self.behaviour(k, 4).partition(",")[0] for k in range(min(6, len(self))))
        more = ", ..." if len(self) > 6 else ""
        return f"<rattle.Modes: {len(self)} mode{'s' if len(self) != 1 else ''}{': ' if listed else ''}{listed}{more}>"

    def behaviour(self, mode: int, digits: int = 6) -> str:
        """Behaviour of a mode (0 = lowest) in words: frequency [Hz], time constants [s] or growth [1/s]."""
        first, other = (complex(root) for root in self.roots[mode])
        cycles = quantity(float(self.frequency[mode]), "Hz", digits)
        whirl = self.whirl[mode] if self.whirl else None
        if whirl is not None:
            ratio = f", {whirl.ratio:.{digits}g} of the turning speed" if math.isfinite(whirl.ratio) else ""
            return f"oil whirl of {whirl.joint} at {cycles}{ratio}, grows at {first.real:.{digits}g} 1/s"
        if first.imag != 0.0:
            return f"flutter at {cycles}, grows at {first.real:.{digits}g} 1/s" if first.real > 0.0 else cycles
        if first.real > 0.0:
            also = f" and {other.real:.{digits}g}" if other.real > 0.0 else ""
            return f"unstable, grows at {first.real:.{digits}g}{also} 1/s"
        if first.real < 0.0:
            slow, fast = self.time_constants[mode]
            return f"overdamped, time constants {slow:.{digits}g} s and {fast:.{digits}g} s"
        return f"{cycles}, comes to rest with time constant {-1.0 / other.real:.{digits}g} s" if other.real else cycles

    def _repr_html_(self) -> str:
        return table(
            ("mode", "frequency", "damping", "moving bodies"), self.rows(), f"about: {self.about}", hint="modes.plot(0)"
        )

    def rows(self) -> list[tuple[str, str, str, str]]:
        """One row per mode: number from 1, frequency [Hz], time constants or growth, damping, bodies that move most."""
        bodies = self.problem.system.bodies
        rows = []
        for k in range(len(self)):
            share = np.abs(self.vectors[k, 0] / self.problem.scale).reshape(-1, 3).max(axis=1)
            movers = ", ".join(bodies[int(n)] for n in np.argsort(-share)[:3] if share[n] > 0.1 * share.max())
            ratio = self.damping[k] if abs(self.damping[k]) > ROUNDING else 0.0
            damping = "" if math.isnan(self.omega[k]) else f"{100 * ratio:.3g} %"
            rows.append((str(k + 1), self.behaviour(k), damping, movers))
        return rows

    def __str__(self) -> str:
        lines = [
            f"mode {k}: {swing}{', damping ' if damping else ''}{damping} ({movers})"
            for k, swing, damping, movers in self.rows()
        ] or ["no degree of freedom is left that could vibrate"]
        how = f"stiffness and damping: {self.how}" if self.how else ""
        return "\n".join(line for line in (*lines, how, self.note) if line)

    def motion(self, mode: int = 0, amplitude: float = 0.1) -> Result:
        """One cycle of a mode (0 = lowest) as a result that can be plotted and animated.

        amplitude: largest displacement as a share [-] of the mechanism's size, which stays the same over the cycle;
        every position is assembled again, so that the joints stay closed.  A mode that is not a vibration is shown as a
        swing, over 1 s if it is unstable.  Raises InputError if there is no such mode.
        """
        if not 0 <= mode < len(self):
            raise InputError(f"mode {mode}: there are {len(self)} modes, numbered from 0")
        problem = self.problem
        omega = float(self.roots[mode, 0].imag or self.omega[mode])
        t = np.linspace(0.0, 2 * math.pi / omega if omega > 0.0 else 1.0, FRAMES)
        names = [name for name in self.equilibrium.result.stored if name.endswith((".x", ".y", ".angle", ".ex", ".ey"))]
        table = []
        problem.at(self.equilibrium.t)
        for turn in np.linspace(0.0, 2 * math.pi, FRAMES):
            q = self.equilibrium.q.copy()
            for _ in range(STEPS):
                q += amplitude / STEPS * (self.vectors[mode, 0] * cmath.exp(1j * turn)).real
                problem.close(q)
            rest = problem.finish(q, 0)
            table.append([rest[name] for name in names])
        base = self.equilibrium.result
        return build_result(
            problem.system.model, f"mode {mode + 1}", t=t, data=np.array(table), names=names,
            units={name: base.unit(name) for name in names},
            trust=Trust(drift=0.0, t_end=float(t[-1]), horizon=float(t[-1])),
        )  # fmt: skip

    def plot(self, mode: int = 0, amplitude: float = 0.1) -> Figure:
        """The mechanism in equilibrium and at both ends of the vibration; see `plot_mode`.

        amplitude: as in `motion`.
        """
        from rattle.questions.modes.pictures import plot_mode

        return plot_mode(self, mode, amplitude)

    def animate(
        self, mode: int, path: str | os.PathLike[str], amplitude: float = 0.1, *, frames: int = 120, fps: int = 20,
        trace: Iterable[str] = (), dpi: float = 90.0, speed: float | None = None, names: bool = False,
    ) -> Picture:  # fmt: skip
        """One cycle of a mode (0 = lowest) as .gif or .mp4; a notebook shows it.

        amplitude: as in `motion`.  frames (at most), fps [1/s], trace (names of points), dpi, speed, names: as in
        `Result.animate`.  Raises InputError for a mode that is not there or another suffix.
        """
        return self.motion(mode, amplitude).animate(
            path, frames=frames, fps=fps, trace=trace, dpi=dpi, speed=speed, names=names
        )


def modes(problem: StaticProblem, rest: Equilibrium, note: str = "") -> Modes:
    """Natural modes [rad/s, 1/s] about an equilibrium found with `problem`; see `Mechanism.modes`."""
    require_known_torques(problem.system, "a small motion about an equilibrium", also_smooth=True)
    problem.at(rest.t)
    problem.turn(rest.q)
    g, null = problem.reduce(rest.q)
    if not len(g):
        return Modes(rest, np.zeros((0, 2), complex), np.zeros((0, 2, len(rest.q)), complex), problem, note)
    stiffness, damping, how, error = _matrices(problem, rest.q, null)
    mass = null.T @ (problem.system.arrays["mass"][1:].ravel()[:, None] * null)
    try:
        roots, shapes = small_motions(stiffness, damping, mass, error)
    except np.linalg.LinAlgError as failure:
        raise InputError(f"modes cannot be computed: {_why_singular(problem.system)}") from failure
    vectors = shapes @ null.T
    displacement = vectors / problem.scale
    place = np.abs(displacement).argmax(axis=2)[:, :, None]
    largest = np.take_along_axis(displacement, place, axis=2)
    turned = np.where(np.isreal(largest), np.abs(largest), largest)  # a real shape keeps its sign
    whirling = whirls(problem, rest.q, roots, vectors)
    return Modes(rest, roots, problem.system.size * vectors / turned, problem, note, how, whirling)


def _why_singular(system: System) -> str:
    """Why the mass of the free motions is not positive definite to double precision, in words."""
    unlike = unlike_masses(system)
    return unlike or "masses, inertias and lengths differ too much for double precision; are their units as meant?"


def own_problem(system: System, rest: Equilibrium) -> StaticProblem:
    """The problem of which an equilibrium given by a user is a solution.

    Raises TypeError if it is none, ValueError if it is one of another mechanism.
    """
    if not isinstance(rest, Equilibrium):
        hint = "; take one of them, such as m.equilibrium()[0]" if isinstance(rest, Equilibria) else ""
        raise WrongType(f"equilibrium must be one of m.equilibrium(), got {type(rest).__name__}{hint}")
    bodies, mine = tuple(rest.table.geometry["bodies"]), tuple(system.bodies)
    if bodies != mine:
        raise InputError(
            f"the equilibrium is one of another mechanism: it has the bodies {', '.join(bodies)}, this one"
            f" {', '.join(mine)}; take one of m.equilibrium()"
        )
    problem = static_problem(system, rest, sticks=True)
    assessed = problem.assess(rest.q, 0)
    open_by, unbalanced = assessed.gap, assessed.residual
    if open_by > max(OTHER * system.size, rest.gap) or not unbalanced <= max(
        OTHER * assessed.force, 2.0 * rest.residual
    ):
        raise InputError(
            f"the equilibrium is one of another mechanism: this one is open by {open_by:.2g} m (or rad) there and"
            f" unbalanced by {unbalanced:.2g} N; take one of m.equilibrium()"
        )
    return problem


def _matrices(problem: StaticProblem, q: np.ndarray, null: np.ndarray) -> tuple[np.ndarray, np.ndarray, str, float]:
    """Z^T K Z [N/m], Z^T C Z [N*s/m], (dof, dof), with Z = null (3 nb, dof), how they were found, and their error."""
    try:
        return *exact_stiffness(problem, q, null), "exact derivatives", EXACT
    except TraceError as error:
        return problem.hessian(q, null), _damping(problem, q, null), f"differences, because {error}", DIFFERENCES


def _damping(problem: StaticProblem, q: np.ndarray, null: np.ndarray) -> np.ndarray:
    """Z^T C Z (dof, dof) [N*s/m], C = -dQ/dv at zero velocity, by differences along Z = null (3 nb, dof).

    The force of a film changes over the velocity that it sees already.
    """
    workspace, dof = problem.workspace, null.shape[1]
    step = SLOW * problem.system.size
    films = seen_speeds(problem, q)
    if films:
        step = min(step, SHARE * min(films))
    result = np.zeros((dof, dof))
    for k in range(dof):
        for shift, factor in zip(SHIFTS, FACTORS, strict=True):
            place(workspace, q, shift * step * null[:, k])
            loads(workspace, problem.t)
            result[:, k] += factor / (12.0 * step) * (null.T @ workspace.force[1:].ravel())
    force_at(workspace, problem.t, q, problem.out)
    return result
