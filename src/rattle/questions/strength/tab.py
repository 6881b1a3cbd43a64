"""What bars bear, in the studio."""

from __future__ import annotations

from rattle.answers.blocks import Content, content, drawing, table, words
from rattle.questions.strength.compute import in_mega, strengths
from rattle.questions.strength.pictures import draw_bars, plot_along
from rattle.questions.strength.words import HEAD, NEEDS, in_rows, remarks_of, worst_of
from rattle.studio.shelf import Shelf, Source


def tab(shelf: Shelf, source: Source) -> Content:
    """A row for every bar, the mechanism when the worst of them bears most, and forces along that one."""
    every = list(strengths(shelf.motion(source)).values())
    if not every:
        return content("no bar has a section and a material", words(NEEDS))
    worst = worst_of(every)
    return content(
        f"largest stress {in_mega(worst.peak)}, in {worst.body}",
        drawing(draw_bars(every, worst.peak_at[0])),
        table(HEAD, in_rows(every)),
        drawing(plot_along(worst)),
        *(words(remark) for remark in remarks_of(every)),
    )
