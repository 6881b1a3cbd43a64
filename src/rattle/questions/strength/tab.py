"""What bars and necks bear, in the studio."""

from __future__ import annotations

from rattle.answers.blocks import Content, content, drawing, table, words
from rattle.questions.strength.answer import in_mega
from rattle.questions.strength.compute import strengths
from rattle.questions.strength.pictures import draw_stressed
from rattle.questions.strength.words import HEAD, NEEDS, NOTHING, in_rows, remarks_of, worst_of
from rattle.studio.shelf import Shelf, Source


def tab(shelf: Shelf, source: Source) -> Content:
    """A row for every bar and neck, the mechanism when the worst of them bears most, and forces in that one."""
    every = list(strengths(shelf.motion(source)).values())
    if not every:
        return content(NOTHING, words(NEEDS))
    worst = worst_of(every)
    return content(
        f"largest stress {in_mega(worst.peak)}, in {worst.name}",
        drawing(draw_stressed(every, worst.peak_at[0])),
        table(HEAD, in_rows(every)),
        drawing(worst.plot()),
        *(words(remark) for remark in remarks_of(every)),
    )
