"""The figure class of all pictures: it shows itself in a notebook, whatever backend is chosen there."""

from __future__ import annotations

import io
from typing import Any

from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

TEXT: Any = {"svg.fonttype": "none", "svg.hashsalt": "rattle"}  # settings: text is text, the same picture the same file
DPI = 110  # of the picture in a notebook


class Page(Figure):
    """A figure of its own, without the global state of pyplot."""

    def __init__(self, width: float, height: float) -> None:
        """width, height: [inches]."""
        super().__init__(figsize=(width, height), layout="constrained")
        FigureCanvasAgg(self)

    def savefig(self, fname: Any, **options: Any) -> None:
        """As in matplotlib; text stays text in an .svg."""
        with rc_context(TEXT):
            super().savefig(fname, **options)

    def _repr_png_(self) -> bytes:
        out = io.BytesIO()
        self.savefig(out, format="png", dpi=DPI)
        return out.getvalue()
