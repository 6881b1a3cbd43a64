"""The command `rattle draw`."""

from __future__ import annotations

from pathlib import Path

from rattle.cli.question_command import Asked, Shown, Written, model_command, picture_option

DRAWING = ".dxf"  # ending of a drawing of the parts


@model_command
@picture_option("Picture (.png, .svg, .pdf) or drawing (.dxf) to write; default: the name of FILE with .png, here.")
def draw(asked: Asked) -> Shown:
    """Draw a mechanism as put together, before any run: to scale, with everything in it by name.

    Bodies, joints with their play, points, mass centres, drivers, springs, the other loads as arrows of what they exert
    at the start, and the degrees of freedom.  A mechanism that cannot be put together is drawn with its bodies where
    they were first guessed to be, the open joints in red, and the exit status is 1.

    A .dxf has a layer for every body with its outline, in mm; a pin is two circles whose radii differ by its play.
    What such a drawing cannot hold is named; rattle import reads it.

    \b
    Example:  rattle draw fourbar -o fourbar.svg
              rattle draw fourbar -o fourbar.dxf
              rattle draw fourbar --set l2="0.7 m"
    """
    from rattle.errors import AssemblyError, InputError
    from rattle.plots.curves import SUFFIXES

    asked = asked._replace(picture=asked.picture or f"{Path(asked.file).stem}.png")
    suffix = Path(str(asked.picture)).suffix.lower()
    if suffix not in (*SUFFIXES, DRAWING):
        raise InputError(f"{asked.picture}: expected a picture, {', '.join(SUFFIXES)}, or a drawing, {DRAWING}")
    if suffix == DRAWING:
        return _parts(asked._replace(picture=None, output=asked.picture))
    m = asked.model()
    drawing = Shown(files=asked.drawn(m.plot))
    try:
        _ = m.start
    except AssemblyError as error:
        return drawing._replace(status=1, remarks=[f"error: {error}"])
    return drawing


def _parts(asked: Asked) -> Shown:
    """The drawing of the parts as DXF."""
    from rattle.atomic_file import atomic
    from rattle.cli.output import check_files
    from rattle.exchange.dxf.write import dxf_of

    assert asked.output is not None, "a drawing is asked for by its name"
    check_files(asked.file, asked.output)
    text, notes = dxf_of(asked._replace(output=None).model())

    def write(path: str) -> None:
        with atomic(path) as file:
            file.write_text(text, encoding="ascii")

    return Shown(files=(Written(asked.output, write),), remarks=[f"note: {note}" for note in notes])
