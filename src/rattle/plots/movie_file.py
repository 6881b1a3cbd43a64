"""Writing an animated figure to a file, frame by frame."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rattle.errors import InputError, MissingProgram
from rattle.plots.curves import BORE, CURVES, GREY, LINES, MORE

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FILMS = (".gif", ".mp4")
Update = Callable[[int], None]  # changes the drawing to the instant of one frame


def require_film(path: str | os.PathLike[str]) -> None:
    """Refuse a file name for an animation. Raises InputError for another suffix, MissingProgram without ffmpeg."""
    from matplotlib.animation import FFMpegWriter

    suffix = Path(path).suffix.lower()
    if suffix == ".html":
        raise InputError(f"{os.fspath(path)}: only the result of a run becomes a page; use .gif or .mp4 here")
    if suffix not in FILMS:
        raise InputError(f"{os.fspath(path)}: an animation needs a name ending in .gif or .mp4")
    if suffix == ".mp4" and not FFMpegWriter.isAvailable():
        raise MissingProgram("an .mp4 needs the program ffmpeg, which was not found; install it or use .gif")


def write_mp4(figure: Figure, update: Update, count: int, file: Path, fps: int) -> None:
    """Write an .mp4 of `count` frames at `fps` [1/s]."""
    from matplotlib.animation import FFMpegWriter

    writer = FFMpegWriter(fps=fps)
    with writer.saving(figure, str(file), figure.dpi):
        for k in range(count):
            update(k)
            writer.grab_frame()


def write_gif(figure: Figure, update: Update, count: int, file: Path, fps: int) -> None:
    """Write a .gif of `count` frames at `fps` [1/s], with one palette for all: a third of PillowWriter's time."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from PIL import Image

    palette = Image.new("P", (1, 1))
    palette.putpalette(_palette())
    canvas: Any = FigureCanvasAgg(figure)
    pictures = []
    for k in range(count):
        update(k)
        canvas.draw()
        picture = Image.fromarray(np.asarray(canvas.buffer_rgba())[..., :3].copy())
        pictures.append(picture.quantize(palette=palette, dither=Image.Dither.NONE))
    pictures[0].save(file, save_all=True, append_images=pictures[1:], duration=round(1000 / fps), loop=0)


def _palette() -> list[int]:
    """Every colour of the pictures in steps towards white, and the light greys of the background.

    The steps near white are coarse: Pillow finds the nearest colour to 4 levels only, and white must stay white.
    """
    from matplotlib.colors import to_rgb

    colours = np.array([to_rgb(colour) for colour in (*CURVES, *MORE, GREY, "black")])
    steps = np.linspace(0, 1, 16)[:, None, None]
    blend = np.vstack([(colours + steps * (1 - colours)).reshape(-1, 3), [to_rgb(grey) for grey in (BORE, LINES)]])
    return [int(level) for level in np.rint(255 * blend).reshape(-1)]
