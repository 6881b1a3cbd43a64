"""`Mechanism`: a model, its analyses, and the studies of many runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, overload

from rattle.analyses.analysed_model import AnalysedModel
from rattle.errors import ModelError, suggest
from rattle.language.times import Seconds, seconds_or_none
from rattle.results.result import UnknownName
from rattle.wrong_arguments import answers_in_words

if TYPE_CHECKING:
    import os
    from concurrent.futures import Executor
    from pathlib import Path

    import numpy as np
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rattle.studies.bifurcation import Bifurcation
    from rattle.studies.compare import Comparison
    from rattle.studies.ensemble.ensemble import Ensemble
    from rattle.studies.ensemble.fields import Vary
    from rattle.studies.ensemble.largest import Largest
    from rattle.studies.ensemble.sweep import Sweep
    from rattle.studies.ensemble.tolerance import Tolerance
    from rattle.studies.ensemble.within import Within
    from rattle.studies.film.bearing import Film
    from rattle.studies.lyapunov import Lyapunov
    from rattle.studies.many import Many
    from rattle.studies.optimise.optimum import Optimum
    from rattle.studies.poincare import Section
    from rattle.studies.wear.worn import Worn


@answers_in_words
class Mechanism(AnalysedModel):
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
        for table, singular in (("bodies", "body"), ("joints", "joint"), ("drivers", "driver"), ("loads", "load")):
            n = len(self._document.get(table, {}))
            if n or table in ("bodies", "joints"):
                counts.append(f"{n} {singular if n == 1 else table}")
        name = self._document.get("name") or self._file
        return f"<rattle.Mechanism{f' {name!r}' if name else ''}: {', '.join(counts)}>"

    def _repr_html_(self) -> str:
        from rattle.plots.diagram import drawing
        from rattle.results.display import card, model_tables, table

        try:
            tables = model_tables(self.model, {name: self.written_unit(name) for name in self.model.parameters})
        except ModelError as error:
            problems = [(problem.key, problem.message) for problem in error.problems]
            return table(("where", "what is still wrong or missing"), problems, repr(self)[1:-1])
        return card(repr(self)[1:-1].partition(": ")[2], drawing(self), tables, hint="m.check(), m.simulate()")

    @overload
    def plot(self, ax: None = None) -> Figure: ...
    @overload
    def plot(self, ax: Axes) -> Axes: ...
    def plot(self, ax: Axes | None = None) -> Figure | Axes:
        """The mechanism as put together, before any run: to scale, in m or mm, with everything by its name.

        Bodies, joints with their play, points, mass centres, drivers, loads as they act at the start, gravity, and the
        degrees of freedom that are left.  If it cannot be put together, its bodies where they were first guessed to
        be, with the open joints and the reason in red.
        ax: draw there.  Returns a new figure, or `ax` if it is given.  Raises ModelError.
        """
        from rattle.plots.diagram import plot_model

        return plot_model(self, ax)

    def view(self, t_end: Seconds | None = None) -> Any:
        """The mechanism in a notebook, moving, with sliders; a widget.  t_end: of the motion at first [s].

        Computed in the browser where the model can be recorded, else by the kernel.  Raises MissingPackage, ModelError,
        AssemblyError.
        """
        from rattle.pages.notebook import view

        return view(self, seconds_or_none(t_end, "t_end"))

    def report(
        self, path: str | os.PathLike[str], *, title: str = "", author: str = "", t_end: Seconds | None = None,
        paper: str = "A4", progress: bool = False,
    ) -> Path:  # fmt: skip
        """Write a report to hand on: one .html page that needs nothing else and prints well, or a .pdf.

        What is in it: docs/report.md.  A motion that fails gives a report that says so at its top.
        title: default the name of the model.  t_end: end of the motion [s].  paper: A4 or Letter, of a .pdf, which a
        browser prints.  progress: show a progress bar.  Returns the path.
        Raises ModelError, ValueError for another suffix, MissingProgram for a .pdf without a browser, OSError.
        """
        from rattle.pages.report import report

        end = seconds_or_none(t_end, "t_end")
        return report(self, path, title=title, author=author, t_end=end, paper=paper, progress=progress)

    def page(
        self, path: str | os.PathLike[str], *, t_end: Seconds | None = None,
        over: Mapping[str, Sequence[float | str]] | None = None, progress: bool = False, title: str = "",
        curves: Sequence[str] = (), trust: bool = True,
    ) -> str:  # fmt: skip
        """Write the mechanism as one web page that computes: `m.page("fourbar.html")`; no server, no internet.

        Parameters with min and max become sliders, and the motion follows them; the page says how far it can be
        trusted.  What only rattle itself can compute (contacts, friction, oil) becomes a page with the runs of a small
        sweep to choose from, and the reason is returned ("" for a page that computes).
        t_end: end of the motion [s] (default: as in the model).  over: values of parameters for such runs, numbers in
        SI or texts such as "1 mm", all combinations.  progress: show a progress bar.
        title: above the page, instead of the name of the model.  curves: those shown at first.  trust: False leaves one
        word of how far the motion can be trusted, and hides the reasons.
        Raises ModelError, AssemblyError, OSError; ValueError for more than 40 runs or an unknown curve.
        """
        from rattle.pages.page import page

        return page(
            self, path, t_end=seconds_or_none(t_end, "t_end"), over=over, progress=progress, title=title,
            curves=curves, trust=trust,
        )  # fmt: skip

    def film(self, joint: str) -> Film:
        """The oil film of a joint as a calculator: static positions, whirl, Stribeck curve, chart; see `rt.Film`.

        Raises UnknownName for a joint that is not there, ModelError for one without oil.
        """
        from rattle.studies.film.bearing import Film

        joints = self.model.joints
        if joint not in joints:
            raise UnknownName(f"the model has no joint {joint!r}{suggest(joint, joints)}")
        return Film.of_joint(joints[joint])

    def compare(
        self, *, joint: str | None = None, curve: str | Sequence[str] | None = None, t_end: Seconds | None = None,
        law: str | None = None, progress: bool = False,
    ) -> Comparison:  # fmt: skip
        """The mechanism with ideal joints, massless links, impact, compliant contacts and oil, side by side.

        joint: whose force and orbit are shown (default: the first with clearance).  curve: of the motion, or
        several (default: one of the last body).  t_end: [s] (default: one turn of the driver).  law: normal force law
        of the compliant run.  Raises ModelError if no joint has a clearance, UnknownName.
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

    def ensemble(
        self, n: int, outputs: Sequence[str], vary: Vary = None, *, seed: int = 0, analysis: str = "simulate",
        t_end: Seconds | None = None, design: str = "sobol", histories: Sequence[str] = (),
        rtol: float | None = None, method: str | None = None, threads: int | None = None,
        executor: Executor | None = None, scheduler: str | None = None,
        workers: int | None = None, folder: str | os.PathLike[str] | None = None, resume: bool = True,
        progress: bool = False,
    ) -> Ensemble:  # fmt: skip
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
        is kept in the folder, and the same call goes on.
        """
        from rattle.studies.ensemble.ensemble import ensemble

        return ensemble(
            self, n, outputs, vary, seed=seed, analysis=analysis, t_end=seconds_or_none(t_end, "t_end"), design=design,
            histories=histories, rtol=rtol, method=method, threads=threads, executor=executor, scheduler=scheduler,
            workers=workers, folder=folder, resume=resume, progress=progress,
        )  # fmt: skip

    def wear(
        self, cycles: float | None = None, jump: float | str | None = None, cycle: Seconds | None = None,
        stop: Mapping[str, float] | None = None, out: str | os.PathLike[str] | None = None, *,
        rtol: float | None = None, progress: bool | Callable[[float, float], None] = False,
    ) -> Worn:  # fmt: skip
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

        Source: docs/wear.md; Archard, J. Appl. Phys. 24 (1953) 981-988.
        """
        from rattle.studies.wear.wear import wear

        return wear(self, cycles, jump, seconds_or_none(cycle, "cycle"), stop, out, rtol=rtol, progress=progress)

    def tolerance(
        self, of: str, vary: Vary = None, *, analysis: str = "simulate", t_end: Seconds | None = None,
        n: int | None = None, seed: int = 0, threads: int | None = None, progress: bool = False,
    ) -> Tolerance:  # fmt: skip
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
        181 (2010) 259-270.
        """
        from rattle.studies.ensemble.tolerance_study import tolerance

        return tolerance(
            self, of, vary, analysis=analysis, t_end=seconds_or_none(t_end, "t_end"), n=n, seed=seed, threads=threads,
            progress=progress,
        )  # fmt: skip

    def tolerance_for(
        self, of: str, within: Within, parameter: str, share: float = 0.997, *, vary: Vary = None,
        analysis: str = "simulate", t_end: Seconds | None = None, n: int | None = None, seed: int = 0,
        threads: int | None = None, progress: bool = False,
    ) -> Largest:  # fmt: skip
        """The largest tolerance, or clearance, that keeps an accuracy: `m.tolerance_for("final(x)", "1 mm", "l2")`.

        of, vary, analysis, t_end: as in `tolerance`; vary=[] leaves the others as they are.
        within: deviation that is allowed, [SI] or such as "0.1 deg", or two limits (low, high).
        parameter: whose tolerance is sought, with the distribution of its field.  The clearance itself is sought of a
        parameter that is the clearance of joints and has no tolerance: deviations are then from the mechanism without
        play, and with kinematics and inverse-dynamics all positions of the pins count.
        share: of the mechanisms that have to keep the limits.  n: samples for each value that is tried (default
        16 384 side by side, 1024 one by one, 512 if all positions of the pins count).

        Returns a float [SI], to 0.1 %, that also has `report`, `share` and `unit`.
        Raises what `tolerance` raises; ValueError if no value keeps the limits.
        """
        from rattle.studies.ensemble.largest import tolerance_for

        return tolerance_for(
            self, of, within, parameter, share, vary=vary, analysis=analysis, t_end=seconds_or_none(t_end, "t_end"),
            n=n, seed=seed, threads=threads, progress=progress,
        )  # fmt: skip

    def sweep(
        self, values: Mapping[str, Sequence[float | str] | np.ndarray], outputs: Sequence[str], *,
        analysis: str = "simulate", t_end: Seconds | None = None, rtol: float | None = None, method: str | None = None,
        threads: int | None = None, executor: Executor | None = None, scheduler: str | None = None,
        workers: int | None = None, folder: str | os.PathLike[str] | None = None, resume: bool = True,
        progress: bool = False,
    ) -> Sweep:  # fmt: skip
        """Outputs over all combinations of values: `m.sweep({"r3": [1e-3, 2e-3]}, ["max(O3.force)"]).table`.

        values: by parameter, numbers in SI or texts such as "1 mm"; the last parameter changes fastest.
        All else as in `ensemble`.  `w.grid(output)` is an array with one axis per parameter.
        """
        from rattle.studies.ensemble.sweep import sweep

        return sweep(
            self, values, outputs, analysis=analysis, t_end=seconds_or_none(t_end, "t_end"), rtol=rtol, method=method,
            threads=threads, executor=executor, scheduler=scheduler, workers=workers, folder=folder, resume=resume,
            progress=progress,
        )  # fmt: skip

    def optimise(
        self, minimise: str, vary: Mapping[str, Sequence[float | str]], subject_to: Sequence[str] = (), *,
        t_end: Seconds | None = None, analysis: str = "simulate", starts: int = 5, seed: int = 0,
        progress: bool = False,
    ) -> Optimum:  # fmt: skip
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
        period: time between two points [s] or an expression over parameters such as "2*pi/w".
        crossing, level: the curve and the level [SI] that it rises through.
        skip: points left out at the start.  points: how many are kept.  method, rtol, atol, step: as in `simulate`.
        """
        from rattle.studies.poincare import section

        return section(
            self, names, period=period, crossing=crossing, level=level, skip=skip,
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
        points [s] or an expression such as "2*pi/w", for every value anew (default: a turn of the driver).
        skip, points: points left out, points kept, for each value.
        method, rtol, atol, step: as in `simulate`.
        """
        from rattle.studies.bifurcation import bifurcation

        return bifurcation(
            self, parameter, values, of, period=period, skip=skip, points=points,
            method=method, rtol=rtol, atol=atol, step=seconds_or_none(step, "step"), threads=threads, progress=progress,
        )  # fmt: skip
