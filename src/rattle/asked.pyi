"""Methods that questions add; written by `python -m rattle.signatures` from their declarations."""

import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from typing import Any, overload

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rattle.language.quantities import Quantity
from rattle.language.times import Seconds
from rattle.questions.accuracy.compute import Accuracy
from rattle.questions.bearing_moments.compute import BearingMoments
from rattle.questions.bifurcation.compute import Bifurcation
from rattle.questions.check.compute import Check
from rattle.questions.compare.compute import Comparison
from rattle.questions.dead_band.compute import DeadBand
from rattle.questions.durability.compute import Durability
from rattle.questions.ensemble.compute import Ensemble
from rattle.questions.ensemble.fields import Vary
from rattle.questions.equilibrium.position import Equilibria, Equilibrium
from rattle.questions.film.bearing import Film
from rattle.questions.heat.compute import Heat
from rattle.questions.holds.holding_range import HoldingRange
from rattle.questions.lyapunov.compute import Lyapunov
from rattle.questions.many.compute import Many
from rattle.questions.modes.compute import Modes
from rattle.questions.optimise.optimum import Optimum
from rattle.questions.poincare.compute import Section
from rattle.questions.power.compute import Power
from rattle.questions.strength.answer import Strength
from rattle.questions.sweep.compute import Sweep
from rattle.questions.tolerance.largest import Largest
from rattle.questions.tolerance.report import Tolerance
from rattle.questions.tolerance.required_accuracy import Within
from rattle.questions.wear.worn import Worn
from rattle.results.result import Result

class OfMechanism:
    def check(self) -> Check:
        """Bodies, joints, mobility, redundant constraints, loops, branch, range of the driver; str() is a short report.

        Ranges of drivers in deg or m.  Raises ModelError, AssemblyError."""
        ...
    @overload
    def plot(self, ax: None = None) -> Figure: ...
    @overload
    def plot(self, ax: Axes) -> Axes: ...
    def simulate(
        self,
        t_end: Seconds | None = None,
        *,
        t_eval: Sequence[Seconds] | np.ndarray | None = None,
        method: str | None = None,
        rtol: float | None = None,
        atol: float | None = None,
        step: Seconds | None = None,
        progress: bool = False,
        strict: bool = False,
        horizon: bool = False,
        most_steps: int | None = None,
    ) -> Result:
        """Motion in time from the assembled start; all curves in SI units.

        t_end: end of the run [s].  t_eval: output instants [s] (default: the model's output interval, or 1000
        outputs).  Every time may also be a text: t_end="20 ms".
        method: a stepper (`rattle kinds stepper`); default: as in the model, otherwise "dop853", for impact contacts
        "event", with oil films "radau".
        rtol, atol: relative and absolute tolerance per step of an adaptive stepper on positions and rates
        [m, rad, m/s, rad/s].
        step: step of one with fixed steps, largest step of an adaptive one [s].
        progress: show a progress bar.  horizon: run once more with a ten times tighter tolerance (1e-8 where rtol is
        looser than 1e-7) and report how long both agree within 1 % of every curve's range.
        With rigid contacts two further runs tell what elastic bushes would show in their place (`trust.elastic`).
        most_steps: the run ends after this many steps (default: when 200 000 steps advance it by less than 1e-4 of
        its duration).

        Steps end where expressions of loads and drivers switch.  A jump in the speed of a driver is an impulse (event
        "jolt"); a jump in its position raises ModelError.

        A run ends before the drift exceeds 1e-3 (of the mechanism's extent, or of 1 rad) or the energy error exceeds
        1e-3 (of the largest of kinetic energy, work and range of the potential); for Moreau-Jean the energy may be
        off by 0.2.  A run that cannot go on returns what was computed, with success = False and a message
        (strict=True raises SolverError).  Source: docs/theory.md, section 3; Grigore et al., equation (1)."""
        ...
    def compare(
        self,
        *,
        joint: str | None = None,
        curve: str | Sequence[str] | None = None,
        t_end: Seconds | None = None,
        law: str | None = None,
        progress: bool = False,
    ) -> Comparison:
        """The mechanism with ideal joints, massless links, impact, compliant contacts and oil, side by side.

        joint: whose force and orbit are shown (default: the first with clearance).  curve: of the motion, or
        several (default: one of the last body).  t_end: [s] (default: one turn of the driver).  law: normal force law
        of the compliant run.  Raises ModelError if no joint has a clearance, UnknownName."""
        ...
    def poincare(
        self,
        *names: str,
        period: Seconds | None = None,
        crossing: str | None = None,
        level: float = 0.0,
        skip: int = 50,
        points: int = 500,
        method: str | None = None,
        rtol: float | None = None,
        atol: float | None = None,
        step: Seconds | None = None,
    ) -> Section:
        """Poincare section: values [SI] once per turn of the driver, or each time a curve rises through a level.

        For all details see `rattle.questions.poincare.compute.section`.
        period: time between two points [s] or an expression over parameters such as "2*pi/w".
        crossing, level: the curve and the level [SI] that it rises through.
        skip: points left out at the start.  points: how many are kept.  method, rtol, atol, step: as in `simulate`."""
        ...
    def bifurcation(
        self,
        parameter: str,
        values: Sequence[float] | np.ndarray,
        of: str,
        *,
        period: Seconds | None = None,
        skip: int = 100,
        points: int = 100,
        method: str | None = None,
        rtol: float | None = None,
        atol: float | None = None,
        step: Seconds | None = None,
        threads: int | None = None,
        progress: bool = False,
    ) -> Bifurcation:
        """Bifurcation diagram: an output [SI] once per turn of the driver, over the values of a parameter.

        For all details see `rattle.questions.bifurcation.compute`.
        parameter, values: the parameter and its values [SI].  of: a name of the result.  period: time between two
        points [s] or an expression such as "2*pi/w", for every value anew (default: a turn of the driver).
        skip, points: points left out, points kept, for each value.
        method, rtol, atol, step: as in `simulate`."""
        ...
    def lyapunov(
        self, t_end: Seconds | None = None, *, stretch: Seconds | None = None, rtol: float = 1e-10
    ) -> Lyapunov:
        """Largest Lyapunov exponent [1/s] with its uncertainty: it explains the horizon.

        By exact variational equations where the model can be recorded, else by two neighbouring runs: see `.how`.
        t_end: end of the run [s].  stretch: time between two readings of the growth [s].  rtol: relative tolerance."""
        ...
    def kinematics(self, t_eval: Seconds | Sequence[Seconds] | np.ndarray, *, strict: bool = False) -> Result:
        """Position, velocity and acceleration [SI] of a fully driven mechanism at increasing times [s].

        Starts from the assembled position at t = 0 and keeps its branch.  A position that cannot be reached ends
        the result there, with success = False and a message and an event that say when, where and why (strict=True
        raises SolverError); points where branches meet are events and notes of `trust`.
        Raises ModelError if a degree of freedom is not driven, and says which bodies can still move.

        Source: Haug, Computer Aided Kinematics and Dynamics of Mechanical Systems (1989), sections 3.6 and 4.5."""
        ...
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
        Raises what `kinematics` raises."""
        ...
    @overload
    def equilibrium(self, t: Seconds = 0.0, *, branches: str = "near", effort: float = 1.0) -> Equilibria: ...
    @overload
    def equilibrium(
        self, t: Sequence[float] | np.ndarray, *, branches: str = "near", effort: float = 1.0
    ) -> Result: ...
    def holds(self, load: str, t: Seconds = 0.0, *, at: Equilibrium | None = None) -> HoldingRange:
        """The values of one load for which friction in the joints holds the mechanism at rest: `m.holds("push")`.

        load: name of a load, of a driver (then of its effort) or "gravity"; all other loads stay as they are.  Values
        are [N] of a force along its present direction, [N*m] of a torque, multiples of what has no single value.
        t: time of the drivers [s].  The position is that of the start, or, at=E[0], of an equilibrium.
        One degree of freedom has to be left, without contacts and play.

        Both ends are where motion is impending, all joints at mu_static and pressed by the load that overcomes them:
        `h.low`, `h.high`; `h.free` without friction.  `h.jams`: an end is infinite, no load of any size moves it that
        way; `h.jams_from`: with how many times the friction it would.  `h.self_locking`: the other loads alone do not
        move it.  `h.rests`: as it is.  str(h) says it in words.
        Raises ModelError, AssemblyError, ValueError for a load that is not there or cannot move the mechanism.

        Source: docs/contact.md; Meriam, Kraige, Engineering Mechanics: Statics, chapter 6."""
        ...
    def dead_band(self, t: Seconds = 0.0, *, at: Equilibrium | None = None) -> DeadBand:
        """The positions at which friction in the joints holds the mechanism under its loads, `band["door.angle"]`.

        They are those around the start, or, at=E[0], around an equilibrium; one degree of freedom has to be left, as
        for `holds`.  t: time of the drivers [s].  The motion is followed in steps of a thirty-second of the size of the
        mechanism; where it would not rest for less than that, nothing is noticed.

        `band["door.angle"]`: both ends [SI], of any position of a result.  str(band) says it in words.
        Raises ModelError, AssemblyError, ValueError if friction does not hold it there.

        Source: docs/contact.md."""
        ...
    def modes(self, t: Seconds = 0.0, equilibrium: Equilibrium | None = None, *, effort: float = 1.0) -> Modes:
        """Natural frequencies [Hz], damping ratios, growth [1/s] and shapes about an equilibrium, all forces together.

        Pins with clearance are massless links that press, those in oil float.  The stiffness of a film under a pin that
        turns is not symmetric: a mode that grows by it is oil whirl, and named so with its frequency over the turning
        speed (`.whirl`: the film of each mode).  Matrices are exact derivatives or differences: see `.how`.
        t: time of the drivers [s].  equilibrium: default the first of `equilibrium(t)`.  effort: as of `equilibrium`.
        Raises ValueError if there is no equilibrium, or the one given is not one of this mechanism."""
        ...
    def accuracy(
        self, of: str, t_eval: Seconds | Sequence[Seconds] | np.ndarray, *, extremes: bool = True, loaded: bool = True
    ) -> Accuracy:
        """How far the play of the joints lets one output deviate [SI], at given times [s].

        of: a name of a result of `inverse_dynamics`, such as "rocker.angle" or "coupler.P.x", or a signal.
        extremes: also the exact extremes over all positions of the pins in their circles.
        loaded: also the deviation where the loads press the pins (equilibrium), for comparison.
        Raises ModelError if the mechanism without play is not fully driven or no joint has a clearance, UnknownName.

        Source: docs/theory.md, section 7; Ting, Zhu, Watkins, The effects of joint clearance on position and
        orientation deviation of linkages and manipulators, Mech. Mach. Theory 35 (2000) 391-401."""
        ...
    def sensitivity(
        self,
        outputs: Sequence[str],
        parameters: Sequence[str],
        t_eval: Seconds | Sequence[Seconds] | np.ndarray | None = None,
        analysis: str = "simulate",
        *,
        rtol: float | None = None,
        atol: float | None = None,
        strict: bool = False,
    ) -> Result:
        """Exact derivatives of curves by parameters, for all of them at once: `s["d(rocker.angle)/d(l2)"]` [SI].

        outputs: names of a result, and numbers of the whole run, "max(abs(B.force))", "mean(...)", of contacts
        "time(B.contacts, 2)", "speed(...)", "peak(...)", whose derivatives are the same at all instants.
        parameters: names of parameters; all else that is written with them follows.
        t_eval: output instants [s] (default: those of the model; t = 0 for an equilibrium).
        analysis: "simulate" integrates the derivatives along with the motion, start included, and controls the errors
        of both; "kinematics", "inverse-dynamics" and "equilibrium" (one instant, or a quasi-static path) solve for
        them at every position.
        rtol (default 1e-10), atol: of a motion, as in `simulate`.

        The result holds the outputs and, for each parameter, their derivatives.  Where they grow exponentially,
        `trust` says how fast, and how long they tell what a change does.  Where an expression switches, and where
        contacts begin and end, the jump of the derivatives is exact: contacts with force laws, rigid ones that
        bounce, stick, slip, rest and let go, one-way clutches, and joints with dry friction, which stick and slip,
        beside contacts too; a contact that grazes is told.  What cannot go on ends the result with success = False and
        a message (strict=True raises SolverError).
        Raises TraceError, with the reason, for oil, wear, ratchets, clutches with max_torque, two-phase impacts beside
        joints that rub, for loads written in Python, for drivers that switch, and where the start does not follow from
        [initial]; UnknownName, and what the analysis itself raises.

        Source: docs/theory.md, section 10."""
        ...
    def many(
        self,
        samples: Mapping[str, Sequence[float] | np.ndarray],
        outputs: Sequence[str],
        t_end: Seconds | None = None,
        *,
        rtol: float | None = None,
        atol: float | None = None,
        method: str | None = None,
        step: Seconds | None = None,
        threads: int | None = None,
        progress: bool = False,
    ) -> Many:
        """Outputs of runs with many sets of parameters: `m.many({"l2": values}, ["max(abs(O3.normal))"], 0.05)`.

        samples: parameter names with their values (n,) [SI].  outputs: numbers such as "max(abs(O3.normal))",
        "at(rocker.angle, 0.05)", "final(x)", "first(x > 0)": max min mean rms sd range integral at final share first
        quantile count, inside them expressions over result names, outside them arithmetic.
        t_end: [s].  rtol (default 1e-8), atol, method, step: as in `simulate`.  threads: default one per core.

        Returns `found[output]`, an array (n,) [SI], nan where it has no value: `found.failed`, `found.message(i)`.
        Samples run side by side, with contacts too, where sample i gives the same bits whatever stands beside it;
        what that cannot vouch for runs one by one: `found.generic`, and `found.stats["how"]` says why.
        Whether a massless link pulls is not checked: ask for "min(O3.normal)".
        Raises ModelError for an output that cannot be read, UnknownName for a parameter, ValueError."""
        ...
    def ensemble(
        self,
        n: int,
        outputs: Sequence[str],
        vary: Vary = None,
        *,
        seed: int = 0,
        analysis: str = "simulate",
        t_end: Seconds | None = None,
        design: str = "sobol",
        histories: Sequence[str] = (),
        rtol: float | None = None,
        method: str | None = None,
        threads: int | None = None,
        executor: Executor | None = None,
        scheduler: str | None = None,
        workers: int | None = None,
        folder: str | os.PathLike[str] | None = None,
        resume: bool = True,
        progress: bool = False,
    ) -> Ensemble:
        """Statistics of n mechanisms with tolerances: `m.ensemble(1000, ["max(O3.force)"]).summary()`.

        outputs: numbers of a run as in `many`.  vary: parameters and their tolerances: all that have one in the model
        file (default), a list of names, or {"l2": "0.1 mm", "r3": {"tol": 1e-4, "dist": "normal"}}.
        seed: sample i depends on it and on i alone (and on n for lhs).  design: sobol, halton, lhs (spread evenly) or
        random (independent).
        analysis: simulate, kinematics, inverse-dynamics, equilibrium, accuracy (outputs of "rocker.angle.high",
        .low, .nominal, .worst, .rss) or modes ("mode1.frequency", .damping, .growth).
        t_end: [s] (default: as in the model; t = 0 alone for equilibrium and modes).  rtol (default 1e-8), method: of
        motions.  histories: curves of all samples that are kept at 201 instants, `e.histories("rocker.angle")`; such
        samples run one by one, and beyond 1 GB need a folder.  progress: show a progress bar with rate and time left.
        threads: of this process, default one per core.  Instead of them, executor: any concurrent.futures.Executor;
        workers: so many processes on this machine; scheduler: address of a Dask scheduler, "tcp://10.0.0.1:8786".
        All give the same bits; laws written in Python must be known in the other processes.
        folder: where samples are kept, piece by piece, as Parquet files, histories as netCDF.  The same call goes on
        where it ended, in whatever way, also with a larger n (not for lhs); the folder of another run is refused.
        resume: False refuses every folder with a run.

        Returns the samples, `e["max(O3.force)"]`, `e.table`, `e.sample(17)`, and what follows from them: `e.summary()`,
        `e.yield_below("max(O3.force)", 5000)`, and pictures: `e.plot("max(O3.force)", limit="5 kN")`,
        `e.plot_scatter()`, `e.plot_band("rocker.angle")`, `e.plot_contributions("max(O3.force)")`.  A sample that
        cannot be run is a row with its message.  Ctrl-C returns the samples so far.
        Raises ModelError, UnknownName, ValueError for a question that makes no sense; MissingPackage without pandas
        where tables are asked for, pyarrow for a folder, distributed for workers; ConnectionError for a scheduler that
        does not answer, WorkerError for workers that end, OSError if the folder cannot be written: what is finished
        is kept in the folder, and the same call goes on."""
        ...
    def sweep(
        self,
        values: Mapping[str, Sequence[float | str] | np.ndarray],
        outputs: Sequence[str],
        *,
        analysis: str = "simulate",
        t_end: Seconds | None = None,
        rtol: float | None = None,
        method: str | None = None,
        threads: int | None = None,
        executor: Executor | None = None,
        scheduler: str | None = None,
        workers: int | None = None,
        folder: str | os.PathLike[str] | None = None,
        resume: bool = True,
        progress: bool = False,
    ) -> Sweep:
        """Outputs over all combinations of values: `m.sweep({"r3": [1e-3, 2e-3]}, ["max(O3.force)"]).table`.

        values: by parameter, numbers in SI or texts such as "1 mm"; the last parameter changes fastest.
        All else as in `ensemble`.  `w.grid(output)` is an array with one axis per parameter."""
        ...
    def tolerance(
        self,
        of: str,
        vary: Vary = None,
        *,
        analysis: str = "simulate",
        t_end: Seconds | None = None,
        n: int | None = None,
        seed: int = 0,
        threads: int | None = None,
        progress: bool = False,
    ) -> Tolerance:
        """What tolerances do to an output: `print(m.tolerance("at(rocker.angle, 0.3)", analysis="kinematics"))`.

        of: a number of a run as in `many`.  vary, analysis, t_end: as in `ensemble`.  n: rows of samples, a power of
        two (default 1024 side by side, 512 one by one); with d independent tolerances n (d + 2) mechanisms are run,
        and all 2^d corners for d up to ten.
        seed: of the samples.  threads: default one per core.  progress: show a progress bar.

        Bands (low, high) in SI, side by side: `t.worst_case` at the corners, `t.root_sum_square` from exact slopes
        (`t.slopes`, `t.how`), `t.monte_carlo` with 99.73 % of the samples.  `t.sobol`: shares of the variance by
        parameter, with 95 % bounds; a group is one, "l2, l3".  `t.tighten`: what to tighten first.
        `t.yield_within("0.1 deg")`, `t.allocate("0.1 deg")`.  str(t) is a report.
        Raises what `ensemble` raises; ValueError if the output has no value without deviations.

        Source: Chase, Parkinson, Research in Engineering Design 3 (1991) 23-37; Saltelli et al., Comput. Phys. Comm.
        181 (2010) 259-270."""
        ...
    def tolerance_for(
        self,
        of: str,
        within: Within,
        parameter: str,
        share: float = 0.997,
        *,
        vary: Vary = None,
        analysis: str = "simulate",
        t_end: Seconds | None = None,
        n: int | None = None,
        seed: int = 0,
        threads: int | None = None,
        progress: bool = False,
    ) -> Largest:
        """The largest tolerance, or clearance, that keeps an accuracy: `m.tolerance_for("final(x)", "1 mm", "l2")`.

        of, vary, analysis, t_end: as in `tolerance`; vary=[] leaves the others as they are.
        within: deviation that is allowed, [SI] or such as "0.1 deg", or two limits (low, high).
        parameter: whose tolerance is sought, with the distribution of its field.  The clearance itself is sought of a
        parameter that is the clearance of joints and has no tolerance: deviations are then from the mechanism without
        play, and with kinematics and inverse-dynamics all positions of the pins count.
        share: of the mechanisms that have to keep the limits.  n: samples for each value that is tried (default
        16 384 side by side, 1024 one by one, 512 if all positions of the pins count).

        Returns a float [SI], to 0.1 %, that also has `report`, `share` and `unit`.
        Raises what `tolerance` raises; ValueError if no value keeps the limits."""
        ...
    def optimise(
        self,
        minimise: str,
        vary: Mapping[str, Sequence[float | str]],
        subject_to: Sequence[str] = (),
        *,
        t_end: Seconds | None = None,
        analysis: str = "simulate",
        starts: int = 5,
        seed: int = 0,
        progress: bool = False,
    ) -> Optimum:
        """Values of parameters that make an output least: `m.optimise("rms(P.y)", {"l2": (0.5, 0.8)})`.

        minimise: a number such as "rms(rocker.angle - ideal.rocker.angle)" or "(final(block.x) - 0.3)**2"; reductions
        as in `many`.  vary: parameters with their lower and upper bound, numbers in SI or texts such as "5 mm"; they
        are never left.  subject_to: comparisons that must hold, such as "max(O3.force) <= 500" or "l2 + l3 == 0.9".
        t_end: end of the runs [s] (default: as in the model).  analysis: "simulate", "kinematics" or
        "inverse-dynamics".  starts: searches, the first from the present design, the others from designs drawn between
        the bounds with this seed.  progress: show a progress bar.

        A search follows exact derivatives of the curves where there are any, otherwise differences of runs, and the
        report says so.  A sum of squares is recognised and searched as one.  Returns the best design:
        `o.mechanism`, `o.value` and `o.values` [SI], `o.active`, `o.report`, `o.success`.
        Raises ValueError, UnknownName, ModelError with what is wrong in the question; ValueError if the present design
        cannot be evaluated.

        Source: Nocedal, Wright, Numerical Optimization (2006), sections 10.3 and 18.1."""
        ...
    def film(self, joint: str) -> Film:
        """The oil film of a joint as a calculator: static positions, whirl, Stribeck curve, chart; see `rt.Film`.

        Raises UnknownName for a joint that is not there, ModelError for one without oil."""
        ...
    def orbit(
        self,
        joint: str,
        t_eval: Sequence[Seconds] | np.ndarray | None = None,
        *,
        t_end: Seconds | None = None,
        rtol: float | None = None,
        strict: bool = False,
    ) -> Result:
        """Orbit of the pin of a joint with oil under the forces of the mechanism without play (mobility method).

        Quicker than `simulate`, and close to it while the film carries: what the pin's own motion in the clearance
        changes in the forces is left out, so while it is hardly loaded its path differs.
        joint: name of a lubricated joint.  The mechanism with all clearances closed has to be fully driven; its motion
        and forces are those of `ideal().inverse_dynamics`, without stops.
        The pin starts where the mechanism with play starts: in the middle of its bush, or at its `offset` in [initial];
        it takes a turn or two of the driver to get onto its closed orbit.
        t_eval: output instants [s], from 0 on; t_end [s]: end, with the outputs of a run (default: as in the model).
        rtol: error of a step as a share of the film's thickness (default 1e-8).

        The result has the names of a run; of this joint e, film, friction and leakage, of all else what holds without
        play.  Where the film is thinner than its boundary film, the dry contact carries by its elastic force and rubs
        by the turning of the pin.
        A mechanism that gets to a dead centre ends the result there, with success = False (strict=True raises
        SolverError).
        Raises UnknownName for a joint that is not there, ModelError for one without oil or if a degree of freedom is
        not driven, AssemblyError.

        Source: Booth (1965), J. Basic Eng. 87, 187-198; docs/theory.md, section 11."""
        ...
    def heat(
        self,
        *,
        ambient: Quantity | None = None,
        cooling: Mapping[str, Quantity] | str | None = None,
        conduction: Mapping[tuple[str, str], Quantity] | str | None = None,
        t_end: Seconds | None = None,
    ) -> Heat:
        """Steady temperatures of joints from what they lose by friction.

        What a joint loses is the mean over the last turn of the driver, or over the whole run.  It flows to the air and
        between joints by conductances that have to be known.  Oil and play are those at the temperature of their joint,
        found by repeated runs.  What is left out is as in the table [heat] of the model.

        ambient: temperature of the air, "20 degC"; a number is kelvin.  cooling: to the air, {"pin": "2 W/K"}.
        conduction: between joints, {("pin", "slider"): "0.5 W/K"}.  t_end: end of the runs [s] (default: the model's).
        `h.temperature["pin"]` [K], `h.loss["pin"]` [W], `h.iterations` runs, `h.mechanism` with these temperatures,
        `h.table` [degC], `h.plot()`, `h.remarks`.  Losses are those of `r.power()`.
        Raises InputError for heat that cannot leave, unknown joints and wrong units; SolverError where a joint seizes,
        oil leaves -30 ... 200 degC, or no steady temperatures are reached.

        Source: docs/heat-and-life.md."""
        ...
    def wear(
        self,
        cycles: float | None = None,
        jump: float | str | None = None,
        cycle: Seconds | None = None,
        stop: Mapping[str, float] | None = None,
        out: str | os.PathLike[str] | None = None,
        *,
        rtol: float | None = None,
        progress: bool | Callable[[float, float], None] = False,
    ) -> Worn:
        """Wear of pins and bushes over many cycles: `w = m.wear(cycles=1e6); print(w); w.plot()`.

        Joints wear that have `wear = { bush = "1e-6 mm^3/(N*m)", pin = 0 }`.  A cycle is simulated, its wear carried
        over a jump of many cycles, and so on.
        cycles: how many (default: as in the model).  cycle: its duration [s] (default: one turn of the driver).
        jump: "auto" chooses jumps by their error, 1 % of the depth each; a number of cycles, cut where it is unstable.
        stop: {"depth": 1e-4, "volume": 1e-9} ends the study there [m, m^3]; worn through at `wall` ends it too.
        out: folder in which it is kept after every jump; the same call goes on there, in whatever way it ended.
        rtol: of the motion (default: as in the model, or 1e-6).  progress: show a progress bar.

        `w.profile("pin").bush.depth` [m], .angle [rad], .volume [m^3], .deepest; .pin likewise; `w.history`,
        `w.mechanism` (worn, for every other analysis), `w.plot("pin")`, `w.limiting`, `w.trust`.
        Raises ModelError, ValueError for a question that makes no sense or a folder of another study, SolverError for
        a cycle that cannot be simulated, OSError.

        Source: docs/wear.md; Archard, J. Appl. Phys. 24 (1953) 981-988."""
        ...
    def durability(
        self, duty: Sequence[Mapping[str, Any]] | str | None = None, hours: float | None = None
    ) -> Durability:
        """How long joints and links last: load, pressure, PV, film, wear life, fatigue life, safety, what fails first.

        One run per duty case.  Joints wear by k p v with `wear`, `length` and the radius of their pin, those with play
        by the map of `rattle wear`; bars with `section` and `material` tire by the cycles of their stress.  Bands about
        a life are assumptions unless the model says them.

        duty: cases, [{"share": 0.7, "set": {"M": 30}}, ...] or "0.7: M=30; 0.3: M=60", shares of time in proportion
        (default: [duty] of the model, else the model as it is).  hours: that it needs to last, to compare with.
        `d.table`, one row per joint and link: load [N], pressure and shear of its pin [Pa], pv [Pa m/s], film (least
        thickness over roughness), wear life [h], fatigue life [h], safety; nan where something is missing, which
        `d.remarks` says.
        `d.first` (name, what, hours), `d.bands` (10, 50, 90 % of the first failure [h]), `d.advice`, `d.plot()`.
        Raises ModelError, InputError for cases that make no sense, SolverError for a run that fails.

        Source: docs/heat-and-life.md."""
        ...

class OfResult:
    def power(self, t0: float | None = None, t1: float | None = None) -> Power:
        """Powers [W] between elements and bodies, and their energies [J] from t0 to t1 [s].

        By default the last turn of the driver, or the whole run if no driver turns steadily or it is shorter than that.
        The run of a motion in time is repeated from the model that the result holds.
        Raises InputError for a result of another analysis or times outside of the run, ModelError for a model with laws
        in Python that are not known here."""
        ...
    def strength(self, body: str) -> Strength:
        """What a bar or the neck of a plate bears: normal and shear force, moment, stress, safety, life; of a bar also

        deflection and buckling.

        body: a bar with `section` and `material`, or "plate.neck" of a plate with `necks`.  The motion, of `simulate`
        or `inverse_dynamics`, is repeated from the model that the result holds; instants are those of the result.
        Raises InputError for another name or a result of another analysis, SolverError if forces do not balance the
        inertia.

        Source: Timoshenko, Strength of Materials I (1955); ASTM E1049-85; docs/theory.md, section 12."""
        ...
    def bearing_moments(self, joint: str, *, tilt_stiffness: Mapping[str, Quantity] | None = None) -> BearingMoments:
        """Force and tilting moment of a bearing on body B about its middle, in the axes of the ground.

        Planes of bodies and middles of joints are their `z`.  The motion is repeated from the model that the result
        holds.  In a tree of joints moments follow from balance alone; in a loop three are redundant, and bearings share
        them by their stiffness against tilting: equal, or tilt_stiffness [N m/rad] of all of them; along
        z they are rigid.
        Raises InputError for an unknown joint, one that is no bearing, or bodies that nothing holds against tipping.

        Source: Newton and Euler, Castigliano; docs/theory.md, section 12."""
        ...
