"""Small free vibrations about an equilibrium.

Z^T M Z ddz + Z^T C Z dz + Z^T K Z z = 0,     shapes Z z, scaled so that the largest displacement is the
mechanism's size;  K as in `balance`, C = -dQ/dv: exact derivatives, or differences where there are none
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from rattle.analyses.statics.balance import StaticProblem
from rattle.analyses.statics.equilibrium import Equilibrium
from rattle.analyses.statics.exact_stiffness import exact_stiffness
from rattle.equations.motion import loads, place
from rattle.equations.rest_force import force_at
from rattle.errors import TraceError
from rattle.results.build import build_result
from rattle.results.display import table
from rattle.results.result import Result
from rattle.results.trust import Trust

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from rattle.results.display import Picture

FRAMES = 61
EVEN = (
    1e-6  # share of a stiffness by which it may be unsymmetric because of differences: frequencies change by its square
)
COUPLED = 0.01  # share of a root of all equations by which that of a mode alone may differ
NOTHING = 1e-6  # share of the largest root that counts as none: roots of neutral motions are square roots of rounding
SHOWN = 12  # roots in a note
NEUTRAL = 1e-10  # share of the largest eigenvalue that counts as none


@dataclass(repr=False)
class Modes:
    """Natural frequencies about an equilibrium, lowest first, and their shapes."""

    equilibrium: Equilibrium
    omega: np.ndarray  # (f,) natural circular frequencies [rad/s]; nan for an unstable mode (see growth)
    growth: np.ndarray  # (f,) rate at which an unstable mode grows, damping included [1/s], 0 for stable modes
    damping: np.ndarray  # (f,) damping ratio of the mode alone [-]
    shapes: np.ndarray  # (f, 3 nb) x, y, angle of every body [m, m, rad] at the largest displacement
    problem: StaticProblem = field(repr=False)
    note: str = ""  # how far the search for the equilibrium went, if it was cut short
    how: str = ""  # how stiffness and damping were found: "exact derivatives", or "differences" and why

    @property
    def frequency(self) -> np.ndarray:
        """(f,) natural frequencies [Hz]."""
        return np.asarray(self.omega / (2 * math.pi))

    @property
    def time_constants(self) -> np.ndarray:
        """(f, 2) slow and fast time constant [s] of overdamped modes; nan for modes that oscillate.

        Roots of s^2 + 2 zeta omega s + omega^2: -omega (zeta -+ sqrt(zeta^2 - 1)) = -1/T.
        """
        zeta = np.where(self.damping >= 1.0, self.damping, np.nan)
        slow = zeta + np.sqrt(zeta * zeta - 1.0)
        return np.stack([slow / self.omega, 1.0 / (slow * self.omega)], axis=1)

    def __len__(self) -> int:
        return len(self.omega)

    def __repr__(self) -> str:
        found = ", ".join(self.behaviour(k, 4).partition(",")[0] for k in range(min(6, len(self))))
        more = ", ..." if len(self) > 6 else ""
        return f"<rattle.Modes: {len(self)} mode{'s' if len(self) != 1 else ''}{': ' if found else ''}{found}{more}>"

    def behaviour(self, mode: int, digits: int = 6) -> str:
        """Behaviour of a mode (0 = lowest) in words: frequency [Hz], time constants [s] or growth [1/s]."""
        if math.isnan(self.omega[mode]):
            return f"unstable, grows at {self.growth[mode]:.{digits}g} 1/s"
        if self.damping[mode] >= 1.0:
            slow, fast = self.time_constants[mode]
            return f"overdamped, time constants {slow:.{digits}g} s and {fast:.{digits}g} s"
        return f"{self.frequency[mode]:.{digits}g} Hz"

    def _repr_html_(self) -> str:
        return table(("mode", "frequency", "damping", "moving bodies"), self.rows(), f"about: {self.equilibrium}")

    def rows(self) -> list[tuple[str, str, str, str]]:
        """One row per mode: number from 1, frequency [Hz], time constants or growth, damping, bodies that move most."""
        bodies = self.problem.system.bodies
        found = []
        for k in range(len(self)):
            share = np.abs(self.shapes[k] / self.problem.scale).reshape(-1, 3).max(axis=1)
            movers = ", ".join(bodies[int(n)] for n in np.argsort(-share)[:3] if share[n] > 0.1 * share.max())
            damping = "" if math.isnan(self.omega[k]) else f"{100 * self.damping[k]:.3g} %"
            found.append((str(k + 1), self.behaviour(k), damping, movers))
        return found

    def __str__(self) -> str:
        said = [
            f"mode {k}: {swing}{', damping ' if damping else ''}{damping} ({movers})"
            for k, swing, damping, movers in self.rows()
        ] or ["no degree of freedom is left that could vibrate"]
        how = f"stiffness and damping: {self.how}" if self.how else ""
        return "\n".join(one for one in (*said, how, self.note) if one)

    def motion(self, mode: int = 0, amplitude: float = 0.1) -> Result:
        """One cycle of a mode (0 = lowest) as a result that can be plotted and animated.

        amplitude: largest displacement as a share [-] of the mechanism's size; every position is assembled again, so
        that the joints stay closed.  An unstable mode is shown over 1 s.  Raises ValueError if there is no such mode.
        """
        if not 0 <= mode < len(self):
            raise ValueError(f"mode {mode}: there are {len(self)} modes, numbered from 0")
        problem, q0 = self.problem, self.equilibrium.q
        omega = 2 * math.pi if math.isnan(self.omega[mode]) or self.omega[mode] == 0.0 else self.omega[mode]
        t = np.linspace(0.0, 2 * math.pi / omega, FRAMES)
        names = [name for name in self.equilibrium.result.stored if name.endswith((".x", ".y", ".angle", ".ex", ".ey"))]
        table = []
        problem.at(self.equilibrium.t)
        steps = 8
        swing = {0: q0.copy()}
        for sign in (1, -1):  # outwards in small steps, so that pins with clearance keep their side
            q = q0.copy()
            for n in range(1, steps + 1):
                q = q + sign * amplitude / steps * self.shapes[mode]
                problem.close(q)
                swing[sign * n] = q.copy()
        keys = np.array(sorted(swing), dtype=float)
        known = np.array([swing[int(k)] for k in keys])
        for instant in t:
            level = steps * math.cos(omega * instant)
            q = np.array([np.interp(level, keys, known[:, k]) for k in range(len(q0))])
            problem.close(q)
            one = problem.finish(q, 0)
            table.append([one[name] for name in names])
        base = self.equilibrium.result
        return build_result(
            problem.system.model, f"mode {mode + 1}", t=t, data=np.array(table), names=names,
            units={name: base.unit(name) for name in names},
            trust=Trust(drift=0.0, t_end=float(t[-1]), horizon=float(t[-1])),
        )  # fmt: skip

    def plot(self, mode: int = 0, amplitude: float = 0.1) -> Figure:
        """The mechanism in equilibrium and at both ends of the vibration; see `rattle.plots.statics.plot_mode`.

        amplitude: as in `motion`.
        """
        from rattle.plots.statics import plot_mode

        return plot_mode(self, mode, amplitude)

    def animate(
        self, mode: int, path: str | os.PathLike[str], amplitude: float = 0.1, *, frames: int = 120, fps: int = 20,
        trace: Iterable[str] = (), dpi: float = 90.0, speed: float | None = None, names: bool = False,
    ) -> Picture:  # fmt: skip
        """One cycle of a mode (0 = lowest) as .gif or .mp4; a notebook shows it.

        amplitude: as in `motion`.  frames (at most), fps [1/s], trace (names of points), dpi, speed, names: as in
        `Result.animate`.  Raises ValueError for a mode that is not there or another suffix.
        """
        return self.motion(mode, amplitude).animate(
            path, frames=frames, fps=fps, trace=trace, dpi=dpi, speed=speed, names=names
        )


def modes(problem: StaticProblem, one: Equilibrium, note: str = "") -> Modes:
    """Natural modes [rad/s, 1/s] about an equilibrium found with `problem`; see `Mechanism.modes`."""
    problem.at(one.t)
    g, null = problem.reduce(one.q)
    if not len(g):
        empty = np.zeros(0)
        return Modes(one, empty, empty, empty, np.zeros((0, len(one.q))), problem, note)
    h, c, how = _matrices(problem, one.q, null)
    mass = null.T @ (problem.system.arrays["mass"][1:].ravel()[:, None] * null)
    squares, vectors, left = _eigenvectors(h, mass)
    modal = np.einsum("ik,ij,jk->k", left, c, vectors)
    omega, growth, damping = _oscillations(squares, modal)
    note = "\n".join(one for one in (note, _together(h, c, mass, squares, modal, growth)) if one)
    if np.iscomplexobj(vectors):  # at the instant of the largest displacement
        largest = vectors[np.abs(vectors).argmax(axis=0), range(len(g))]
        vectors = np.real(vectors / largest)
    shapes = (null @ vectors).T
    largest = np.abs(shapes / problem.scale).max(axis=1, keepdims=True)
    shapes *= problem.system.size / largest
    return Modes(one, omega, growth, damping, shapes, problem, note, how)


def _eigenvectors(h: np.ndarray, mass: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Eigenvalues mu (f,) [1/s^2] of h x = mu mass x by their real parts, right and left vectors in columns (f, f).

    left^T mass right = 1.  Loads without a potential make h unsymmetric, and mu may be complex (flutter).
    """
    lower = np.linalg.inv(np.linalg.cholesky(mass))
    if np.abs(h - h.T).max() <= EVEN * np.abs(h).max():
        squares, vectors = np.linalg.eigh(lower @ (0.5 * (h + h.T)) @ lower.T)
        inverse = vectors.T
    else:
        squares, vectors = np.linalg.eig(lower @ h @ lower.T)
        order = np.argsort(squares.real, kind="stable")
        squares, vectors = squares[order], vectors[:, order]
        inverse = np.linalg.pinv(vectors)
    squares[np.abs(squares) < NEUTRAL * np.abs(squares).max(initial=0.0)] = 0.0
    return squares, lower.T @ vectors, lower.T @ inverse.T


def _oscillations(squares: np.ndarray, c: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """omega [rad/s], growth [1/s] and damping ratio (f,) of s^2 + c s + mu = 0, as in `Modes`; mu = squares (f,)."""
    half, flutter = 0.5 * c, np.imag(squares) != 0.0
    reach = np.sqrt(half * half - squares + 0j)
    roots = np.where(np.imag(squares) < 0.0, -reach, reach) - half  # of a pair of modes one grows, the other decays
    unstable = np.where(flutter, roots.real > 0.0, np.real(squares) < 0.0)
    omega = np.where(unstable, np.nan, np.where(flutter, np.abs(roots), np.sqrt(np.abs(squares))))
    loss = np.where(flutter, -roots, half).real
    damping = np.divide(loss, omega, out=np.zeros(len(omega)), where=omega > 0.0)
    return omega, np.where(unstable, roots.real, 0.0), damping


def _together(
    h: np.ndarray, c: np.ndarray, mass: np.ndarray, squares: np.ndarray, modal: np.ndarray, growth: np.ndarray
) -> str:
    """What is said where the modes, each with its own damping, are not the motions of all equations; "" otherwise."""
    half = 0.5 * modal
    reach = np.sqrt(half * half - squares + 0j)
    alone = list(np.concatenate([reach - half, -reach - half]))
    f = len(h)
    zero = np.zeros((f, f))
    roots = np.linalg.eigvals(np.block([[zero, np.eye(f)], [-np.linalg.solve(mass, h), -np.linalg.solve(mass, c)]]))
    largest = np.abs(roots).max()
    unlike = False
    for root in roots:
        nearest = int(np.argmin([abs(root - one) for one in alone]))
        unlike |= abs(root - alone.pop(nearest)) > COUPLED * abs(root) + NOTHING * largest
    grows = roots.real.max() > NOTHING * largest
    if not unlike and not (grows and not growth.any()):
        return ""
    shown = sorted((one for one in roots if one.imag >= 0.0), key=abs)[:SHOWN]
    listed = ", ".join(f"{one.real:.4g}" + (f" +- {one.imag:.4g}i" if one.imag > 0.0 else "") for one in shown)
    why = "forces by velocities couple the modes, which stand here each alone" if unlike else "damping is negative"
    verdict = f"; the equilibrium is unstable, motions grow at {roots.real.max():.4g} 1/s" if grows else ""
    return f"{why}: all equations together have the roots s = {listed} 1/s{verdict}"


def _matrices(problem: StaticProblem, q: np.ndarray, null: np.ndarray) -> tuple[np.ndarray, np.ndarray, str]:
    """Z^T K Z [N/m], Z^T C Z [N*s/m], (dof, dof), with Z = null (3 nb, dof), and how they were found."""
    try:
        return *exact_stiffness(problem, q, null), "exact derivatives"
    except TraceError as error:
        damping = null.T @ _damping(problem, q) @ null
        return problem.hessian(q, null), damping, f"differences, because {error}"


def _damping(problem: StaticProblem, q: np.ndarray) -> np.ndarray:
    """C = -dQ/dv (3 nb, 3 nb) [N*s/m, N*m*s] at zero velocity, by differences."""
    workspace, n = problem.workspace, len(q)
    result = np.zeros((n, n))
    for k in range(n):
        sides = []
        for sign in (1.0, -1.0):
            v = np.zeros(n)
            v[k] = sign * 1e-4 * problem.scale[k] * problem.system.size
            place(workspace, q, v)
            loads(workspace, problem.t)
            sides.append(workspace.force[1:].ravel().copy())
        result[:, k] = -(sides[0] - sides[1]) / (2e-4 * problem.scale[k] * problem.system.size)
    force_at(workspace, problem.t, q, problem.out)
    return result
