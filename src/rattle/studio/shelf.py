"""What the process of a session keeps at hand: the last model with its motion, so that every tab looks at the same."""

from __future__ import annotations

from typing import Any

from rattle.mechanism import Mechanism
from rattle.results.result import Result

Source = dict[str, str]  # text of a model, and the name of its file, "" if it has none


class Shelf:
    """The last model, its motion and what was asked of it."""

    def __init__(self) -> None:
        self._source: Source = {}
        self._mechanism: Mechanism | None = None
        self._results: dict[bool, Result] = {}  # by whether the horizon is known
        self.turnable: dict[str, set[str]] = {}  # parameters that a page can turn by itself, by the shape of the model
        self.studies: dict[str, Any] = {}  # the last ensemble, from which samples are taken

    def mechanism(self, source: Source) -> Mechanism:
        """The model of a text; the file says in which folder its tables are.  Raises ModelError."""
        if self._mechanism is None or source != self._source:
            self._mechanism = Mechanism.from_text(source["text"], source["file"])
            self._source = source
            self._results.clear()
            self.studies.clear()
        return self._mechanism

    def motion(self, source: Source, horizon: bool = False) -> Result:
        """The motion of a model over the time that it says.  Raises ModelError, AssemblyError."""
        m = self.mechanism(source)
        result = self._results.get(True) or self._results.get(horizon)
        if result is None:
            result = m.simulate(progress=True, horizon=horizon).whole()
            self._results[horizon] = result
        return result
