"""The pictures of the page on pictures: a drawing of a model, one that does not close, a path, a spectrum."""

from __future__ import annotations

from pathlib import Path

import rattle as rt
from making.runs import run
from making.text import fence

DOTS = 80  # per inch


def pages(folder: Path) -> dict[str, str]:
    """One page for each picture, with the command that draws it; pictures go into `folder`/pictures."""
    place = folder / "pictures"
    place.mkdir(exist_ok=True)
    high = rt.example("quick_return").set(height="700 mm")
    engine = rt.example("slider_crank").simulate("0.4 s")
    made = {
        "drawing": (rt.example("balanced_arm").plot(), "A drawing of the balanced arm", "rattle draw balanced_arm"),
        "open": (
            high.plot(),
            "A drawing of a mechanism that does not close",
            'rattle draw quick_return --set height="700 mm"',
        ),
        "path": (
            run("five_bar").result.plot_path("left_forearm.pen"),
            "A heart",
            "rattle plot heart.nc --xy left_forearm.pen",
        ),
        "spectrum": (
            engine.plot_spectrum("O.fx", "motor.torque"),
            "Spectra with the orders of the crank",
            "rattle plot engine.nc O.fx motor.torque --spectrum",
        ),
    }
    texts = {}
    for name, (figure, words, command) in made.items():
        figure.savefig(place / f"picture-{name}.png", dpi=DOTS)
        texts[f"picture-{name}"] = f"{fence(command, 'sh')}\n\n![{words}](generated/pictures/picture-{name}.png)\n"
    return texts
