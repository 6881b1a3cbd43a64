"""What a notebook shows of a result: forces, contacts and oil, joint by joint, and how far to trust them."""

from __future__ import annotations

from html import escape

from rattle.results.contact_summary import Curves, contact_lines, joint_rows
from rattle.results.display import card, grid, marks, printed
from rattle.results.film_summary import film_rows


def result_card(r: Curves, title: str, stopped: str, example: str) -> str:
    """A result as HTML; all texts escaped.

    title: what it is.  stopped: why it ended early, "" if it did not.  example: a curve to draw.
    """
    tables = [grid(head, rows) for head, rows in (joint_rows(r), film_rows(r)) if rows]
    sentences = [marks([("bad", f"stopped: {stopped}")])] if stopped else []
    sentences += [f"<p>{escape(line)}</p>" for line in contact_lines(r)]
    sentences += [f"<p>{escape(printed(line))}</p>" for line in (r.trust.word, *r.trust.why)]
    first = next((f"{joint}.force" for joint in r.geometry["joints"] if f"{joint}.fx" in r), example)
    return card(title, *tables, *sentences, hint=f'r.plot("{first}"), r.trust')
