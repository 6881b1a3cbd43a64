"""A model with the analyses of one run: motion, kinematics, equilibrium, vibrations, accuracy, sensitivities."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, Self, overload

from rattle.analyses import arguments
from rattle.description.written_model import WrittenModel
from rattle.errors import ModelError, TraceError
from rattle.language.times import Seconds, seconds, seconds_or_none, times

if TYPE_CHECKING:
    import numpy as np

    from rattle.analyses.accuracy.clearance_error import Accuracy
    from rattle.analyses.assembly.assembly import Assembled
    from rattle.analyses.check import Check
    from rattle.analyses.model_form import ModelForm
    from rattle.analyses.statics.dead_band import DeadBand
    from rattle.analyses.statics.equilibrium import Equilibria, Equilibrium
    from rattle.analyses.statics.holding_range import HoldingRange
    from rattle.analyses.statics.modes import Modes
    from rattle.analyses.straight_line.recorded_model import RecordedModel
    from rattle.equations.system import System
    from rattle.results.result import Result


class AnalysedModel(WrittenModel):
    """A model that can be analysed; every analysis checks it first and raises ModelError with all problems at once."""

    @cached_property
    def system(self) -> System:
        """The model as flat arrays, in SI units, with the constants of gears that its start sets.

        Raises ModelError; AssemblyError if such a mechanism cannot be put together.
        """
        from rattle.analyses.assembly.assembly import put_together
        from rattle.analyses.assembly.computable import computable

        model = self.model
        with computable(self._file):
            return put_together(model)

    @cached_property
    def start(self) -> Assembled:
        """Assembled positions [m, rad] and rates [m/s, rad/s] at t = 0. Raises ModelError, AssemblyError."""
        from rattle.analyses.assembly.assembly import assemble
        from rattle.analyses.assembly.computable import computable

        system = self.system
        with computable(self._file):
            return assemble(system, told=self._told)

    def neighbour(self, values: Mapping[str, Any], told: bool = True) -> Self:
        """As `set`, but what is not given of the start is looked for near the start of this mechanism.

        So samples of one study start on one branch, and none of them a turn away.  told: False for a mechanism that is
        run once: its start has no notes, and its results do not hold the model.  Raises ModelError.
        """
        beside = self._beside_its_start
        made = beside._of_its_form(values, told) or beside.set(values)
        made._told = told
        return made

    def _of_its_form(self, values: Mapping[str, Any], told: bool) -> Self | None:
        """As `neighbour` for numbers of parameters, without reading; None where the model has to be read.

        The form of the model is found when the same parameters are given for the third time.
        """
        from rattle.analyses.model_form import FORM_PAYS

        if not values or not all(isinstance(one, float) and math.isfinite(one) for one in values.values()):
            return None
        names = tuple(values)
        form, asked = self._forms.get(names, (None, 0))
        if asked < FORM_PAYS:
            if asked + 1 == FORM_PAYS:
                form = self._form(names)
            self._forms[names] = form, asked + 1
        if form is None or (found := form.at(list(values.values()))) is None:
            return None
        made = self._changed(values, shared=not told)
        made.__dict__["model"] = found.model
        if found.system is not None:
            made.__dict__["system"] = found.system
        return made

    @cached_property
    def _forms(self) -> dict[tuple[str, ...], tuple[ModelForm | None, int]]:
        """Forms by the names of their parameters, None where there is none, and how often they were asked for."""
        return {}

    def _form(self, names: Sequence[str]) -> ModelForm | None:
        """What is left of this model without the numbers that follow from these parameters; None if that is unknown."""
        from rattle.analyses.model_form import ModelForm

        known = self.parameters
        if not set(names) <= known.keys():
            return None
        try:
            made = self.set({name: known[name] for name in names})
            return ModelForm(made._document, made.model, names)
        except (TraceError, ModelError):
            return None

    @cached_property
    def _beside_its_start(self) -> Self:
        """This mechanism, so that those that `set` makes of it start near its start; itself if it has none."""
        start = self._start_or_none()
        if start is None:
            return self
        from rattle.analyses.assembly.assembly import near_places

        made = self.set()
        made._near, made._near_shut = near_places(self.system, start)
        return made

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
        from rattle.analyses.assembly.computable import computable
        from rattle.analyses.check import check

        system, start = self.system, self.start
        with computable(self._file):
            return check(system, start, {name: self.written_unit(name) for name in self.model.parameters})

    def simulate(
        self, t_end: Seconds | None = None, *, t_eval: Sequence[Seconds] | np.ndarray | None = None,
        method: str | None = None, rtol: float | None = None, atol: float | None = None, step: Seconds | None = None,
        progress: bool = False, strict: bool = False, horizon: bool = False, most_steps: int | None = None,
    ) -> Result:  # fmt: skip
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
        (strict=True raises SolverError).  Source: docs/theory.md, section 3; Grigore et al., equation (1).
        """
        from rattle.analyses.dynamics import simulate as simulation

        found = simulation.simulate(
            self.system, self.start, t_end=seconds_or_none(t_end, "t_end"), t_eval=times(t_eval, "t_eval"),
            method=method, rtol=rtol, atol=atol, step=seconds_or_none(step, "step"), progress=progress, strict=strict,
            horizon=horizon, most_steps=most_steps,
        )  # fmt: skip
        if horizon and found.success and not found.stats.get("horizon_interrupted"):
            from dataclasses import replace

            from rattle.analyses.elastic_bushes import elastic_bushes
            from rattle.results.contact_summary import unread

            elastic, bushes = elastic_bushes(self, found.trust.t_end)
            found.trust = replace(found.trust, elastic=elastic, bushes=bushes)
            found.trust = replace(found.trust, unread=unread(found))
        if self._told:
            found.provenance["document"] = self.to_json()
        return found

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

    def orbit(
        self, joint: str, t_eval: Sequence[Seconds] | np.ndarray | None = None, *, t_end: Seconds | None = None,
        rtol: float | None = None, strict: bool = False,
    ) -> Result:  # fmt: skip
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

        Source: Booth (1965), J. Basic Eng. 87, 187-198; docs/theory.md, section 11.
        """
        from rattle.analyses.orbit import orbit

        return orbit.orbit(
            self.system, self.start, joint, times(t_eval, "t_eval"), t_end=seconds_or_none(t_end, "t_end"), rtol=rtol,
            strict=strict,
        )  # fmt: skip

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
        A pin in oil floats where its film carries, with the dry contact beside it where it is thin: films, and they
        alone, see the speeds that the drivers have at t, as of a machine that turns steadily; the inertia of bodies
        that move then is left out, and `.note` says so.
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

        Source: docs/contact.md; Meriam, Kraige, Engineering Mechanics: Statics, chapter 6.
        """
        from rattle.analyses.statics.holding import holding_range

        return holding_range(self.system, load, arguments.number("t", seconds(t, "t")), at)

    def dead_band(self, t: Seconds = 0.0, *, at: Equilibrium | None = None) -> DeadBand:
        """The positions at which friction in the joints holds the mechanism under its loads, `band["door.angle"]`.

        They are those around the start, or, at=E[0], around an equilibrium; one degree of freedom has to be left, as
        for `holds`.  t: time of the drivers [s].  The motion is followed in steps of a thirty-second of the size of the
        mechanism; where it would not rest for less than that, nothing is noticed.

        `band["door.angle"]`: both ends [SI], of any position of a result.  str(band) says it in words.
        Raises ModelError, AssemblyError, ValueError if friction does not hold it there.

        Source: docs/contact.md.
        """
        from rattle.analyses.statics.dead_band import dead_band

        return dead_band(self.system, arguments.number("t", seconds(t, "t")), at)

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
        """Natural frequencies [Hz], damping ratios, growth [1/s] and shapes about an equilibrium, all forces together.

        Pins with clearance are massless links that press, those in oil float.  The stiffness of a film under a pin that
        turns is not symmetric: a mode that grows by it is oil whirl, and named so with its frequency over the turning
        speed (`.whirl`: the film of each mode).  Matrices are exact derivatives or differences: see `.how`.
        t: time of the drivers [s].  equilibrium: default the first of `equilibrium(t)`.  effort: as of `equilibrium`.
        Raises ValueError if there is no equilibrium, or the one given is not one of this mechanism.
        """
        from rattle.analyses.statics.equilibria import static_problem
        from rattle.analyses.statics.modes import modes, own_problem

        effort = arguments.effort(effort)
        if equilibrium is not None:
            return modes(own_problem(self.system, equilibrium), equilibrium)
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
