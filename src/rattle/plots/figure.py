"""The figure class of all pictures: it shows itself in a notebook, whatever backend is chosen there."""

from __future__ import annotations

import hashlib
import html
import io
import re
from typing import Any

from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

TEXT: Any = {"svg.fonttype": "none", "svg.hashsalt": "rattle"}  # settings: text is text, the same picture the same file
DPI = 110  # of the picture in a notebook
FINE = 200  # dots per inch of the parts of a picture in a page that are drawn as dots
MANY = 400  # lines of one collection above which they are drawn as dots in a page: each would be an element of its own


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

    def to_page(self, label: str = "") -> str:
        """The picture as an SVG element that may stand in a page among others: text is text, names are its own.

        label: what it shows, for those who do not see it.  Collections of many lines are drawn as dots.
        """
        dense = [lines for ax in self.axes for lines in ax.collections if len(lines.get_paths()) > MANY]
        for lines in dense:
            lines.set_rasterized(True)
        out = io.StringIO()
        self.savefig(out, format="svg", dpi=FINE, metadata={"Date": None})
        for lines in dense:
            lines.set_rasterized(False)
        text = out.getvalue()
        text = re.sub(r"<metadata>.*?</metadata>", "", text[text.index("<svg") :], flags=re.DOTALL)
        opening = f'<svg class="picture" role="img" aria-label="{html.escape(label)}"'
        return with_own_names(text).replace("<svg", opening, 1).strip()


def with_own_names(text: str) -> str:
    """An SVG element whose names no other picture of a page has; the same picture has the same names."""
    own = "p" + hashlib.sha256(text.encode()).hexdigest()[:8]
    return re.sub(r'(\sid="|url\(#|href="#)', rf"\1{own}-", text)
