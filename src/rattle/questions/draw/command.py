"""The command `rattle draw`."""

from __future__ import annotations

from pathlib import Path

from rattle.cli.question_command import Asked, Shown, model_command, picture_option


@model_command
@picture_option("Picture to write (.png, .svg, .pdf); default: the name of FILE with .png, in the current folder.")
def draw(asked: Asked) -> Shown:
    """Draw a mechanism as put together, before any run: to scale, with everything in it by name.

    Bodies, joints with their play, points, mass centres, drivers, springs, the other loads as arrows of what they exert
    at the start, and the degrees of freedom.  A mechanism that cannot be put together is drawn with its bodies where
    they were first guessed to be, the open joints in red, and the exit status is 1.

    \b
    Example:  rattle draw fourbar -o fourbar.svg
              rattle draw fourbar --set l2="0.7 m"
    """
    from rattle.errors import AssemblyError

    asked = asked._replace(picture=asked.picture or f"{Path(asked.file).stem}.png")
    m = asked.model()
    drawing = Shown(files=asked.drawn(m.plot))
    try:
        _ = m.start
    except AssemblyError as error:
        return drawing._replace(status=1, remarks=[f"error: {error}"])
    return drawing
