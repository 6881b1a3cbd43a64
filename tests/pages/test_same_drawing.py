"""The primitives of a mechanism give the same picture on the canvas of a page, in matplotlib and as SVG."""

import base64
import io

import matplotlib.image
import numpy as np
import pytest

import rattle as rt
from browsing import open_page  # noqa: F401
from drawn_mechanisms import EXAMPLES, PIXELS, cells_of, instants, magnified, motion, pictures
from rattle.drawings import numbers
from rattle.pages.scene import scene_json, scene_of
from rattle.pages.viewer_text import viewer_text
from rattle.plots.scene import Scene
from rattle.plots.sketch import extent

# Edges are smoothed otherwise, and thin lines moved to whole pixels: up to 0.034.  Marks or walls that only one of them
# draws, or draws elsewhere, are 0.06 to 0.4 of a mechanism that has several.
UNLIKE = 0.04  # ink that differs, as a share of all
FEW = 0.1  # the same of arrows alone, a hundredth of a picture: one that is missing or elsewhere is a fifth and more
MORE = (  # examples whose joints and loads are those of others
    "crank_rocker_play", "double_wishbone", "jansen_leg", "rimless_wheel", "scissor_lift", "slider_crank_play",
    "stick_slip",
)  # fmt: skip
FINER = 2  # pixels of a picture in one of a page: thin lines are then moved less to whole pixels
PLAY = """
async ({ text, scene, low, high, wide, tall, instants, size, across, layer, lines }) => {
  const viewer = await import(URL.createObjectURL(new Blob([text], { type: "text/javascript" })));
  const data = JSON.parse(scene), motion = new viewer.Motion(data.runs[0], data);
  const stage = new viewer.Stage(motion, data);
  const theme = viewer.themeOf(false, data.colours), scale = wide / (high[0] - low[0]);
  // the motion is these instants alone
  Object.assign(stage, { size, times: instants, poses: instants.map((t) => motion.pose(t)) });
  stage.values.renew();
  const every = layer ? stage.drawing[layer] : stage.drawing.magnified[0].drawn;
  const drawn = every.filter(({ line }) => !lines || line?.[0] === lines);
  const play = drawn.map((primitive) => viewer.player(stage, primitive));
  return instants.map((t) => {
    const canvas = document.createElement("canvas"), context = viewer.sized(canvas, wide, tall);
    context.fillStyle = "white";
    context.fillRect(0, 0, wide, tall);
    const p = new viewer.Painter(context, { scale, x: -low[0] * scale, y: high[1] * scale }, theme);
    stage.values.set(motion.pose(t), t, size / across, size);
    for (const draw of play) draw(p);
    return canvas.toDataURL().split(",")[1];
  });
}
"""
WHOLE = "() => document.querySelector('svg').setAttribute('style', 'display: block; width: 100vw; height: 100vh')"


def unlike(one, other):
    """How much of the ink of two pictures differs."""
    return np.abs(one - other).sum() / min(one.sum(), other.sum())


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.long if name in MORE else ()) for name in (*EXAMPLES, "own")]
)
def test_canvas_matplotlib_and_svg_show_the_same(open_page, name):  # noqa: F811
    compare(open_page, motion(name), "drawn")


@pytest.mark.parametrize(
    "name",
    [
        "balanced_arm",
        "excavator",
        "fourbar",
        *(pytest.param(x, marks=pytest.mark.long) for x in ("crank_rocker_play", "scotch_yoke")),
    ],
)
def test_forces_and_moments_are_the_same_arrows(open_page, name):  # noqa: F811
    compare(open_page, rt.example(name).simulate(0.2), "arrows", FEW)


@pytest.mark.parametrize("name", ["crank_rocker_play", "fourbar", "geneva", "guide_play"])
def test_joints_with_play_are_magnified_in_the_same_way(open_page, name):  # noqa: F811
    compare_magnified(open_page, rt.example(name).simulate(0.05))


def test_the_way_of_a_pin_is_the_same(open_page):  # noqa: F811
    """On a massless link it goes along arcs between the outputs."""
    compare_magnified(open_page, rt.example("fourbar").simulate(t_eval=np.linspace(0.0, 1.0, 401)), "sky", FEW)


def compare_magnified(open_page, r, lines=None, most=UNLIKE):  # noqa: F811
    wide, tall = PIXELS
    across = {"low": [-0.5 * wide / tall, -0.5], "high": [0.5 * wide / tall, 0.5], "size": 1.0, "across": tall}
    begun = int(lines is not None)  # there is no way behind the pin at first
    told = {**across, "lines": lines, "instants": r.t[instants(r)[begun:]].tolist()}
    same_pictures(open_page, r, list(magnified(r, lines))[begun:], told, most)


def compare(open_page, r, layer, most=UNLIKE):  # noqa: F811
    figures, box = list(pictures(r, layer)), extent(Scene(r, instants(r), 1.0))
    low, high = zip(figures[0].axes[0].get_xlim(), figures[0].axes[0].get_ylim(), strict=True)
    size = float(max(box[1] - box[0]))
    same_pictures(
        open_page, r, figures,
        {"low": list(low), "high": list(high), "size": size, "across": numbers.PIXELS, "layer": layer},
        most,
    )  # fmt: skip


def same_pictures(open_page, r, figures, told, most=UNLIKE):  # noqa: F811
    """Figures of a motion, and as SVG, are as the canvas of a page shows it.  told: which primitives, and where."""
    page = open_page("about:blank", viewport={"width": PIXELS[0], "height": PIXELS[1]}, device_scale_factor=FINER)
    told = {
        "text": viewer_text(), "scene": scene_json(scene_of([("", r)])), "wide": PIXELS[0], "tall": PIXELS[1],
        "instants": r.t[instants(r)].tolist(), **told,
    }  # fmt: skip
    played = page.evaluate(PLAY, told)
    for figure, picture in zip(figures, played, strict=True):
        file = io.BytesIO()
        figure.savefig(file, dpi=100 * FINER)
        here = cells_of(pixels_of(file.getvalue()))
        assert here.sum() > 0
        assert unlike(here, cells_of(pixels_of(base64.b64decode(picture)))) < most, "canvas"
        text = io.StringIO()
        figure.savefig(text, format="svg")
        page.set_content(f'<body style="margin: 0">{text.getvalue()[text.getvalue().index("<svg") :]}')
        page.evaluate(WHOLE)
        assert unlike(here, cells_of(pixels_of(page.screenshot()))) < most, "SVG"


def pixels_of(png):
    """(high, wide, 3 or 4) of a picture."""
    return 255.0 * matplotlib.image.imread(io.BytesIO(png))
