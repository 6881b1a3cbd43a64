"""The primitives of a mechanism give the same picture on the canvas of a page, in matplotlib and as SVG."""

import base64
import io

import matplotlib.image
import numpy as np
import pytest

from browsing import open_page  # noqa: F401
from drawn_mechanisms import EXAMPLES, PIXELS, cells_of, motion, pictures
from rattle.drawings import numbers
from rattle.pages.scene import scene_json, scene_of
from rattle.pages.viewer_text import viewer_text
from rattle.plots.scene import Scene
from rattle.plots.sketch import extent

# Edges are smoothed otherwise, and thin lines moved to whole pixels: up to 0.034.  Marks or walls that only one of them
# draws, or draws elsewhere, are 0.06 to 0.4 of a mechanism that has several.
UNLIKE = 0.04  # ink that differs, as a share of all
FINER = 2  # pixels of a picture in one of a page: thin lines are then moved less to whole pixels
PLAY = """
async ({ text, scene, low, high, wide, tall, instants, size, across }) => {
  const viewer = await import(URL.createObjectURL(new Blob([text], { type: "text/javascript" })));
  const data = JSON.parse(scene), motion = new viewer.Motion(data.runs[0], data.geometry);
  const stage = new viewer.Stage(motion, data);
  const theme = viewer.themeOf(false, stage.colours), scale = wide / (high[0] - low[0]);
  Object.assign(stage, { size, poses: instants.map((t) => motion.pose(t)) }); // the motion is these instants alone
  stage.values.renew();
  const play = stage.drawing.drawn.map((primitive) => viewer.player(stage, primitive));
  return instants.map((t) => {
    const canvas = document.createElement("canvas"), context = viewer.sized(canvas, wide, tall);
    context.fillStyle = "white";
    context.fillRect(0, 0, wide, tall);
    const p = new viewer.Painter(context, { scale, x: -low[0] * scale, y: high[1] * scale }, theme);
    stage.values.set(motion.pose(t), t, size / across);
    for (const draw of play) draw(p);
    return canvas.toDataURL().split(",")[1];
  });
}
"""
WHOLE = "() => document.querySelector('svg').setAttribute('style', 'display: block; width: 100vw; height: 100vh')"


def unlike(one, other):
    """How much of the ink of two pictures differs."""
    return np.abs(one - other).sum() / min(one.sum(), other.sum())


@pytest.mark.parametrize("name", [*EXAMPLES, "own"])
def test_canvas_matplotlib_and_svg_show_the_same(open_page, name):  # noqa: F811
    r = motion(name)
    pick = np.array([0, len(r.t) // 2, len(r.t) - 1])
    box = extent(Scene(r, pick, 1.0))
    figures = list(pictures(r))
    ax = figures[0].axes[0]
    low, high = zip(ax.get_xlim(), ax.get_ylim(), strict=True)
    page = open_page("about:blank", viewport={"width": PIXELS[0], "height": PIXELS[1]}, device_scale_factor=FINER)
    told = {
        "text": viewer_text(), "scene": scene_json(scene_of([("", r)])), "low": list(low), "high": list(high),
        "wide": PIXELS[0], "tall": PIXELS[1], "across": numbers.PIXELS, "instants": r.t[pick].tolist(),
        "size": float(max(box[1] - box[0])),
    }  # fmt: skip
    played = page.evaluate(PLAY, told)
    for figure, picture in zip(figures, played, strict=True):
        file = io.BytesIO()
        figure.savefig(file, dpi=100 * FINER)
        here = cells_of(pixels_of(file.getvalue()))
        assert here.sum() > 0
        assert unlike(here, cells_of(pixels_of(base64.b64decode(picture)))) < UNLIKE, "canvas"
        text = io.StringIO()
        figure.savefig(text, format="svg")
        page.set_content(f'<body style="margin: 0">{text.getvalue()[text.getvalue().index("<svg") :]}')
        page.evaluate(WHOLE)
        assert unlike(here, cells_of(pixels_of(page.screenshot()))) < UNLIKE, "SVG"


def pixels_of(png):
    """(high, wide, 3 or 4) of a picture."""
    return 255.0 * matplotlib.image.imread(io.BytesIO(png))
