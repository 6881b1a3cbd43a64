"""The mechanism as put together, before any run."""

from __future__ import annotations

from typing import TYPE_CHECKING, overload

from rattle.question import question

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rattle.mechanism import Mechanism


@overload
def plot(m: Mechanism, ax: None = None) -> Figure: ...
@overload
def plot(m: Mechanism, ax: Axes) -> Axes: ...
@question(
    asks="The mechanism as put together, before any run: everything in it by name, and what moves freely.",
    order=40,
    command="draw",
    title="Drawing",
    wants=(("what it looks like, with names, before anything runs", "[drawing](pictures.md)"),),
    examples=(("rattle draw F", "m.plot()"),),
    shows_quantities=False,
)
def plot(m: Mechanism, ax: Axes | None = None) -> Figure | Axes:
    """The mechanism as put together, before any run: to scale, in m or mm, with everything by its name.

    Bodies, joints with their play, points, mass centres, drivers, loads as they act at the start, gravity, and the
    degrees of freedom that are left.  If it cannot be put together, its bodies where they were first guessed to
    be, with the open joints and the reason in red.
    ax: draw there.  Returns a new figure, or `ax` if it is given.  Raises ModelError.
    """
    from rattle.plots.diagram import plot_model

    return plot_model(m, ax)
