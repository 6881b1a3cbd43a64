"""`Mechanism`: a model and all analyses that can be run on it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, overload

from rattle.analyses import arguments
from rattle.description.written_model import WrittenModel
from rattle.errors import ModelError
from rattle.language.units import Seconds, seconds, seconds_or_none, times

if TYPE_CHECKING:
    import numpy as np

    from rattle.analyses.accuracy.clearance_error import Accuracy
    from rattle.analyses.assembly.assembly import Assembled
    from rattle.analyses.check import Check
    from rattle.analyses.statics.equilibrium import Equilibria, Equilibrium
    from rattle.analyses.statics.modes import Modes
    from rattle.analyses.straight_line.recorded_model import RecordedModel
    from rattle.equations.system import System
    from rattle.results.result import Result
    from rattle.studies.bifurcation import Bifurcation
    from rattle.studies.compare import Comparison
    from rattle.studies.lyapunov import Lyapunov
    from rattle.studies.many import Many
    from rattle.studies.optimise.optimum import Optimum
    from rattle.studies.poincare import Section


class Mechanism(WrittenModel):
    """A planar mechanism: read from a model file, or built in code.

        m = rt.load("fourbar.toml")
        m = rt.Mechanism("pendulum", gravity=[0, -9.81])
        m.ground(O=[0, 0])
        m.bar("rod", "A", "B", length="1 m", mass=1)
        m.revolute("O", "ground.O", "rod.A")

    Numbers are in SI units; texts are quantities ("5 mm") or expressions over parameters, as in a model file.
    Every analysis checks the model first and raises ModelError with all problems at once.
    """

    def __repr__(self) -> str:
        counts = []
        for table, one in (("bodies", "body"), ("joints", "joint"), ("drivers", "driver"), ("loads", "load")):
            n = len(self._document.get(table, {}))
            if n or table in ("bodies", "joints"):
                counts.append(f"{n} {one if n == 1 else table}")
        name = self._document.get("name") or self._file
        return f"<rattle.Mechanism{f' {name!r}' if name else ''}: {', '.join(counts)}>"

    def _repr_html_(self) -> str:
        from rattle.results.display import model_tables, table

        try:
            return model_tables(self.model, repr(self)[1:-1])
        except ModelError as error:
            problems = [(one.key, one.message) for one in error.problems]
            return table(("where", "what is still wrong or missing"), problems, repr(self)[1:-1])

    @cached_property
    def system(self) -> System:
        """The model as flat arrays, in SI units. Raises ModelError."""
        from rattle.equations.system import compile_system

        return compile_system(self.model)

    @cached_property
    def start(self) -> Assembled:
        """Assembled positions [m, rad] and rates [m/s, rad/s] at t = 0. Raises ModelError, AssemblyError."""
        from rattle.analyses.assembly.assembly import assemble

        return assemble(self.system)

    def recorded(self, parameters: Sequence[str] = ()) -> RecordedModel:
        """The model as a graph whose inputs are time, state and these parameters.

        Raises TraceError, with the reason, if it has contacts or cannot be recorded; UnknownName.
        """
        from rattle.analyses.straight_line.recorded_model import record_model

        return record_model(self._document, self.system, self.start, parameters)

    # ------------------------------------------------------------ analyses
    def check(self) -> Check:
        """Bodies, joints, mobility, redundant constraints, loops, branch, range of the driver; str() is a short report.

        Ranges of drivers in deg or m.  Raises ModelError, AssemblyError.
        """
        from rattle.analyses.check import check

        return check(self.system, self.start)

    def simulate(
        self, t_end: Seconds | None = None, *, t_eval: Sequence[Seconds] | np.ndarray | None = None,
        method: str | None = None, rtol: float | None = None, atol: float | None = None, step: Seconds | None = None,
        progress: bool = False, strict: bool = False, horizon: bool = False, most_steps: int | None = None,
    ) -> Result:  # fmt: skip
        """Motion in time from the assembled start; all curves in SI units.

        t_end: end of the run [s].  t_eval: output instants [s] (default: the model's output interval, or 1000
        outputs).  Every time may also be a text: t_end="20 ms".
        method: a stepper (`rattle kinds stepper`); default: as in the model, otherwise "dop853", for impact contacts
        "event".
        rtol, atol: relative and absolute tolerance per step of an adaptive stepper on positions and rates
        [m, rad, m/s, rad/s].
        step: step of one with fixed steps, largest step of an adaptive one [s].
        progress: show a progress bar.  horizon: run once more with a ten times tighter tolerance (1e-8 where rtol is
        looser than 1e-7) and report how long both agree within 1 % of every curve's range.
        most_steps: the run ends after this many steps (default: when 200 000 steps advance it by less than 1e-4 of
        its duration).

        Steps end where expressions of loads and drivers switch.  A jump in the speed of a driver is an impulse (event
        "jolt"); a jump in its position raises ModelError.

        A run ends before the drift exceeds 1e-3 (of the mechanism's extent, or of 1 rad) or the energy error exceeds
        1e-3 (of the largest of kinetic energy, work and range of the potential); for Moreau-Jean the energy may be
        off by 0.2.  A run that cannot go on returns what was computed, with success = False and a message
        (strict=True raises SolverError).  Source: docs/theory.md, section 3; Grigore et al., equation (1).
        """
        from rattle.analyses.dynamics import simulate as simulation

        return simulation.simulate(
            self.system, self.start, t_end=seconds_or_none(t_end, "t_end"), t_eval=times(t_eval, "t_eval"),
            method=method, rtol=rtol, atol=atol, step=seconds_or_none(step, "step"), progress=progress, strict=strict,
            horizon=horizon, most_steps=most_steps,
        )  # fmt: skip

    def compare(
        self, *, joint: str | None = None, curve: str | None = None, t_end: Seconds | None = None,
        law: str | None = None, progress: bool = False,
    ) -> Comparison:  # fmt: skip
        """The mechanism with ideal joints, massless links, one-sided impact and compliant contacts, side by side.

        joint: whose force and orbit are shown (default: the first with clearance).  curve: of the motion (default:
        one of the last body).  t_end: [s] (default: one turn of the driver).  law: normal force law of the compliant
        run.  Raises ModelError if no joint has a clearance, UnknownName.
        """
        from rattle.studies.compare import compare

        return compare(
            self, joint=joint, curve=curve, t_end=seconds_or_none(t_end, "t_end"), law=law, progress=progress
        )

    def many(
        self, samples: Mapping[str, Sequence[float] | np.ndarray], outputs: Sequence[str],
        t_end: Seconds | None = None, *, rtol: float | None = None, atol: float | None = None,
        method: str | None = None, step: Seconds | None = None, threads: int | None = None, progress: bool = False,
    ) -> Many:  # fmt: skip
        """Outputs of runs with many sets of parameters: `m.many({"l2": values}, ["max(abs(O3.normal))"], 0.05)`.

        samples: parameter names with their values (n,) [SI].  outputs: numbers such as "max(abs(O3.normal))",
        "at(rocker.angle, 0.05)", "final(x)", "first(x > 0)": max min mean rms sd range integral at final share first
        quantile count, inside them expressions over result names, outside them arithmetic.
        t_end: [s].  rtol (default 1e-8), atol, method, step: as in `simulate`.  threads: default one per core.

        Returns `found[output]`, an array (n,) [SI], nan where it has no value: `found.failed`, `found.message(i)`.
        Mechanisms without contacts run side by side, where sample i gives the same bits whatever stands beside it;
        what that cannot vouch for runs one by one: `found.generic`, and `found.stats["how"]` says why.
        Whether a massless link pulls is not checked: ask for "min(O3.normal)".
        Raises ModelError for an output that cannot be read, UnknownName for a parameter, ValueError.
        """
        from rattle.studies.many import many

        return many(
            self, samples, outputs, t_end=seconds_or_none(t_end, "t_end"), rtol=rtol, atol=atol, method=method,
            step=seconds_or_none(step, "step"), threads=threads, progress=progress,
        )  # fmt: skip

    def optimise(
        self, minimise: str, vary: Mapping[str, Sequence[float | str]], subject_to: Sequence[str] = (), *,
        t_end: Seconds | None = None, analysis: str = "simulate", starts: int = 5, seed: int = 0,
        progress: bool = False,
    ) -> Optimum:  # fmt: skip
        """Values of parameters that make an output least: `m.optimise("rms(P.y)", {"l2": (0.5, 0.8)})`.

        minimise: a number such as "rms(rocker.angle - ideal.rocker.angle)" or "(final(block.x) - 0.3)**2"; reductions
        as in `many`.  vary: parameters with their lower and upper bound, numbers in SI or texts such as "5 mm"; they
        are never left.  subject_to: comparisons that must hold, such as "max(O3.force) <= 500".
        t_end: end of the runs [s] (default: as in the model).  analysis: "simulate", "kinematics" or
        "inverse-dynamics".  starts: searches, the first from the present design, the others from designs drawn between
        the bounds with this seed.  progress: show a progress bar.

        A search follows exact derivatives of the curves where there are any, otherwise differences of runs, and the
        report says so.  A sum of squares is recognised and searched as one.  Returns the best design:
        `o.mechanism`, `o.value` and `o.values` [SI], `o.active`, `o.report`, `o.success`.
        Raises ValueError, UnknownName, ModelError with what is wrong in the question; ValueError if the present design
        cannot be evaluated.

        Source: Nocedal, Wright, Numerical Optimization (2006), sections 10.3 and 18.1.
        """
        from rattle.studies.optimise.optimise import optimise

        return optimise(
            self, minimise, vary, subject_to, t_end=seconds_or_none(t_end, "t_end"), analysis=analysis, starts=starts,
            seed=seed, progress=progress,
        )  # fmt: skip

    def lyapunov(
        self, t_end: Seconds | None = None, *, stretch: Seconds | None = None, rtol: float = 1e-10
    ) -> Lyapunov:
        """Largest Lyapunov exponent [1/s] with its uncertainty: it explains the horizon.

        By exact variational equations where the model can be recorded, else by two neighbouring runs: see `.how`.
        t_end: end of the run [s].  stretch: time between two readings of the growth [s].  rtol: relative tolerance.
        """
        from rattle.studies.lyapunov import lyapunov

        return lyapunov(self, seconds_or_none(t_end, "t_end"), stretch=seconds_or_none(stretch, "stretch"), rtol=rtol)

    def poincare(
        self, *names: str, period: Seconds | None = None, crossing: str | None = None, level: float = 0.0,
        skip: int = 50, points: int = 500, method: str | None = None, rtol: float | None = None,
        atol: float | None = None, step: Seconds | None = None,
    ) -> Section:  # fmt: skip
        """Poincare section: values [SI] once per turn of the driver, or each time a curve rises through a level.

        For all details see `rattle.studies.poincare.section`.
        period: time between two points [s].  crossing, level: the curve and the level [SI] that it rises through.
        skip: points left out at the start.  points: how many are kept.  method, rtol, atol, step: as in `simulate`.
        """
        from rattle.studies.poincare import section

        return section(
            self, names, period=seconds_or_none(period, "period"), crossing=crossing, level=level, skip=skip,
            points=points, method=method, rtol=rtol, atol=atol, step=seconds_or_none(step, "step"),
        )  # fmt: skip

    def bifurcation(
        self, parameter: str, values: Sequence[float] | np.ndarray, of: str, *, period: Seconds | None = None,
        skip: int = 100, points: int = 100, method: str | None = None, rtol: float | None = None,
        atol: float | None = None, step: Seconds | None = None, threads: int | None = None, progress: bool = False,
    ) -> Bifurcation:  # fmt: skip
        """Bifurcation diagram: an output [SI] once per turn of the driver, over the values of a parameter.

        For all details see `rattle.studies.bifurcation`.
        parameter, values: the parameter and its values [SI].  of: a name of the result.  period: time between two
        points [s] (default: a turn of the driver).  skip, points: points left out, points kept, for each value.
        method, rtol, atol, step: as in `simulate`.
        """
        from rattle.studies.bifurcation import bifurcation

        return bifurcation(
            self, parameter, values, of, period=seconds_or_none(period, "period"), skip=skip, points=points,
            method=method, rtol=rtol, atol=atol, step=seconds_or_none(step, "step"), threads=threads, progress=progress,
        )  # fmt: skip

    def kinematics(self, t_eval: Seconds | Sequence[Seconds] | np.ndarray, *, strict: bool = False) -> Result:
        """Position, velocity and acceleration [SI] of a fully driven mechanism at increasing times [s].

        Starts from the assembled position at t = 0 and keeps its branch.  A position that cannot be reached ends
        the result there, with success = False and a message and an event that say when, where and why (strict=True
        raises SolverError); points where branches meet are events and notes of `trust`.
        Raises ModelError if a degree of freedom is not driven, and says which bodies can still move.

        Source: Haug, Computer Aided Kinematics and Dynamics of Mechanical Systems (1989), sections 3.6 and 4.5.
        """
        from rattle.analyses.kinematics import kinematics

        return kinematics.analyse(
            self.system, self._start_or_none(), times(t_eval, "t_eval"), forces=False, strict=strict
        )

    def inverse_dynamics(
        self,
        t_eval: Seconds | Sequence[Seconds] | np.ndarray,
        *,
        effort_at: str | Mapping[str, str] | None = None,
        strict: bool = False,
    ) -> Result:
        """Kinematics with all reactions [N, N*m] and the effort [N or N*m] and power [W] of the drivers.

        effort_at: a joint with a motor that does the work of the driver, which then only prescribes the motion: its
        torque is `<joint>.torque` [N*m] (`<joint>.thrust` [N] on a prismatic joint), its power `<joint>.power` [W];
        all reactions are those with this motor.  With several drivers: {driver: joint}.
        Joints whose reactions are not unique (redundant constraints) are named in `trust.nonunique`.
        Raises what `kinematics` raises.
        """
        from rattle.analyses.kinematics import kinematics

        return kinematics.analyse(
            self.system, self._start_or_none(), times(t_eval, "t_eval"), forces=True, effort_at=effort_at, strict=strict
        )

    @overload
    def equilibrium(self, t: Seconds = 0.0, *, branches: str = "near", effort: float = 1.0) -> Equilibria: ...
    @overload
    def equilibrium(
        self, t: Sequence[float] | np.ndarray, *, branches: str = "near", effort: float = 1.0
    ) -> Result: ...
    def equilibrium(
        self, t: Seconds | Sequence[float] | np.ndarray = 0.0, *, branches: str = "near", effort: float = 1.0
    ) -> Equilibria | Result:
        """Equilibria with the drivers held where they are at time t [s]; loads are evaluated with all rates zero.

        Returns a list: admissible (no bush has to pull) and stable ones first, then by their distance from the
        initial guess.  A pin with clearance is a massless link; equilibria with the pin on the other side of its bush
        (n and -n at every pin) are in the list too.  A compliant pin sinks in by its law, an impact pin is rigid;
        friction is left out.
        The search is limited: it minimises the potential first, so that stable ones are found before all others, and
        ends within about a tenth of a second for ten bodies; `.extent` of the list says how far it went, `.note` that
        it was cut short.  branches: "near" keeps the branch in which the mechanism is assembled, "all" searches the
        others too.  effort: 10 allows ten times the work; at most 10 000.

        With an array of times [s]: the quasi-static motion over them as a Result, with the drivers' efforts, the
        mechanical advantage `<load>.advantage` (force or moment held at the load per unit of effort),
        `equilibrium.stiffness` (smallest eigenvalue of the reduced Hessian [N/m]), `.stable` and `.admissible`
        (1 or 0); where N of a pin goes through zero the pin changes sides, which is an event "side".
        Raises AssemblyError, ModelError.

        Source: docs/theory.md, section 7; Nocedal, Wright, Numerical Optimization (2006), section 16.2.
        """
        import numpy as np

        t = times(t, "t")
        if np.ndim(t) == 0:
            from rattle.analyses.statics.equilibria import equilibria

            return equilibria(self.system, arguments.number("t", t), branches, arguments.effort(effort))
        from rattle.analyses.statics.quasistatic import quasistatic

        return quasistatic(self.system, np.asarray(t, dtype=float), arguments.effort(effort))

    def sensitivity(
        self, outputs: Sequence[str], parameters: Sequence[str],
        t_eval: Seconds | Sequence[Seconds] | np.ndarray | None = None, analysis: str = "simulate", *,
        rtol: float | None = None, atol: float | None = None, strict: bool = False,
    ) -> Result:  # fmt: skip
        """Exact derivatives of curves by parameters, for all of them at once: `s["d(rocker.angle)/d(l2)"]` [SI].

        outputs: names of a result.  parameters: names of parameters; all else that is written with them follows.
        t_eval: output instants [s] (default: those of the model; t = 0 for an equilibrium).
        analysis: "simulate" integrates the derivatives along with the motion, start included, and controls the errors
        of both; "kinematics", "inverse-dynamics" and "equilibrium" (one instant, or a quasi-static path) solve for
        them at every position.
        rtol (default 1e-10), atol: of a motion, as in `simulate`.

        The result holds the outputs and, for each parameter, their derivatives.  Where they grow exponentially,
        `trust` says how fast, and how long they tell what a change does.  Where an expression switches, the jump of
        the derivatives is exact.  What cannot go on ends the result with success = False and a message
        (strict=True raises SolverError).
        Raises TraceError, with the reason, for contacts and loads written in Python, for drivers that switch, and
        where the start does not follow from [initial]; UnknownName, and what the analysis itself raises.

        Source: docs/theory.md, section 10.
        """
        from rattle.analyses.sensitivity.sensitivity import sensitivity

        return sensitivity(
            self._document, self.system, self.start, outputs, parameters, times(t_eval, "t_eval"), analysis,
            rtol=rtol, atol=atol, strict=strict,
        )  # fmt: skip

    def modes(self, t: Seconds = 0.0, equilibrium: Equilibrium | None = None, *, effort: float = 1.0) -> Modes:
        """Natural frequencies [Hz], damping ratios and shapes about an equilibrium.

        Pins with clearance are massless links that press.  Matrices are exact derivatives or differences: see `.how`.
        t: time of the drivers [s].  equilibrium: default the first of `equilibrium(t)`.  effort: as of `equilibrium`.
        Raises ValueError if there is no equilibrium.
        """
        from rattle.analyses.statics.equilibria import static_problem
        from rattle.analyses.statics.modes import modes

        effort = arguments.effort(effort)
        if equilibrium is not None:
            return modes(static_problem(self.system, equilibrium), equilibrium)
        found = self.equilibrium(seconds(t, "t"), effort=effort)
        first = found.first_at(seconds(t, "t"))
        return modes(static_problem(self.system, first), first, found.note)

    def accuracy(
        self, of: str, t_eval: Seconds | Sequence[Seconds] | np.ndarray, *, extremes: bool = True, loaded: bool = True
    ) -> Accuracy:
        """How far the play of the joints lets one output deviate [SI], at given times [s].

        of: a name of a result of `inverse_dynamics`, such as "rocker.angle" or "coupler.P.x", or a signal.
        extremes: also the exact extremes over all positions of the pins in their circles.
        loaded: also the deviation where the loads press the pins (equilibrium), for comparison.
        Raises ModelError if the mechanism without play is not fully driven or no joint has a clearance, UnknownName.

        Source: docs/theory.md, section 7; Ting, Zhu, Watkins, The effects of joint clearance on position and
        orientation deviation of linkages and manipulators, Mech. Mach. Theory 35 (2000) 391-401.
        """
        from rattle.analyses.accuracy.clearance_error import accuracy

        return accuracy(self.system, of, times(t_eval, "t_eval"), extremes=extremes, loaded=loaded)

    def _start_or_none(self) -> Assembled | None:
        """The start at t = 0, or None if the mechanism cannot be assembled there."""
        from rattle.errors import AssemblyError
        from rattle.jit import functions

        functions.start()
        try:
            return self.start
        except AssemblyError:
            return None
