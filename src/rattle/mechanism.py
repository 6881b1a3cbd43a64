"""`Mechanism`: a model, its analyses, and the studies of many runs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from rattle.analyses.analysed_model import AnalysedModel
from rattle.asked import OfMechanism
from rattle.errors import InputError, ModelError
from rattle.language.times import Seconds, seconds_or_none, times
from rattle.wrong_arguments import answers_in_words

if TYPE_CHECKING:
    import os
    from pathlib import Path

    from rattle.results.result import Result

POSITIONS = 1001  # of a driven motion whose instants are not given


@answers_in_words
class Mechanism(OfMechanism, AnalysedModel):
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

    def view(
        self, t_end: Seconds | None = None, *, title: str = "", curves: Sequence[str] = (), language: str = "en"
    ) -> Any:
        """The mechanism in a notebook, moving, with sliders; a widget.  t_end: of the motion at first [s].

        Computed in the browser where the model can be recorded, else by the kernel.  title, curves, language: as of
        `page`.  Raises MissingPackage, ModelError, AssemblyError, ValueError for an unknown curve or language.
        """
        from rattle.pages.notebook import view
        from rattle.pages.wishes import Wishes

        return view(self, seconds_or_none(t_end, "t_end"), Wishes(title, curves, language=language))

    def strength(
        self, body: str, t_eval: Sequence[Seconds] | np.ndarray | None = None, *, analysis: str = "simulate",
        **options: Any,
    ) -> Any:  # fmt: skip
        """What a bar or plate bears in a motion, see `Result.strength`.

        t_eval: instants [s]; default: those of the model's run.  analysis: "simulate" or "inverse-dynamics".
        options: of that analysis.  Raises InputError for another analysis or no such bar, and what it raises.
        """
        return self._followed(t_eval, analysis, options).strength(body)

    def _followed(
        self, t_eval: Sequence[Seconds] | np.ndarray | None, analysis: str, options: dict[str, Any]
    ) -> Result:
        """The motion by this analysis, with all forces."""
        instants = None if t_eval is None else np.atleast_1d(np.asarray(times(t_eval, "t_eval"), float))
        if analysis == "simulate":
            if instants is not None and len(instants):
                options = {"t_end": float(instants[-1]), **options}
            return self.simulate(t_eval=instants, **options)
        if analysis.replace("_", "-").replace(" ", "-") != "inverse-dynamics":
            raise InputError(f"analysis: expected 'simulate' or 'inverse-dynamics', got {analysis!r}")
        if instants is None:
            instants = np.linspace(0.0, self.model.settings.t_end, POSITIONS)
        return self.inverse_dynamics(instants, **options)

    def report(
        self, path: str | os.PathLike[str], *, title: str = "", author: str = "", t_end: Seconds | None = None,
        paper: str = "A4", progress: bool = False, measured: str | Path | Iterable[str | Path] = (),
    ) -> Path:  # fmt: skip
        """Write a report to hand on: one .html page that needs nothing else and prints well, or a .pdf.

        What is in it: docs/report.md.  A motion that fails gives a report that says so at its top.
        title: default the name of the model.  t_end: end of the motion [s].  paper: A4 or Letter, of a .pdf, which a
        browser prints.  progress: show a progress bar.  measured: measured curves beside the motion, see
        `Result.residuals`; without a curve a column may belong to the output of the mechanism.  Returns the path.
        Raises ModelError, ValueError for another suffix, MissingProgram for a .pdf without a browser, OSError.
        """
        from rattle.pages.report import report

        end = seconds_or_none(t_end, "t_end")
        return report(
            self, path, title=title, author=author, t_end=end, paper=paper, progress=progress, measured=measured
        )

    def page(
        self, path: str | os.PathLike[str], *, t_end: Seconds | None = None,
        over: Mapping[str, Sequence[float | str]] | None = None, progress: bool = False, title: str = "",
        curves: Sequence[str] = (), trust: bool = True, language: str = "en",
        measured: str | Path | Iterable[str | Path] = (),
    ) -> str:  # fmt: skip
        """Write the mechanism as one web page that computes: `m.page("fourbar.html")`; no server, no internet.

        Parameters with min and max become sliders, and the motion follows them; the page says how far it can be
        trusted.  What only rattle itself can compute (contacts, friction, oil) becomes a page with the runs of a small
        sweep to choose from, and the reason is returned ("" for a page that computes).
        t_end: end of the motion [s] (default: as in the model).  over: values of parameters for such runs, numbers in
        SI or texts such as "1 mm", all combinations.  progress: show a progress bar.
        title: above the page, instead of the name of the model.  curves: those shown at first.  trust: False leaves one
        word of how far the motion can be trusted, and hides the reasons.
        language: of the labels: "en", "de", "fr", "es" or "zh"; sentences about trust and errors stay English.
        measured: measured curves that are drawn beside the motion whatever is turned, such as
        "measured.csv:theta=rocker.angle@0.2s", see `Result.residuals`.
        Raises ModelError, AssemblyError, OSError; ValueError for more than 40 runs, an unknown curve or language.
        """
        from rattle.pages.page import page

        return page(
            self, path, t_end=seconds_or_none(t_end, "t_end"), over=over, progress=progress, title=title,
            curves=curves, trust=trust, language=language, measured=measured,
        )  # fmt: skip
